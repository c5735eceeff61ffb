#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "src/image/image.h"

static struct ap_image make(uint32_t width, uint32_t height, uint8_t r, uint8_t g, uint8_t b) {
    struct ap_image image;
    assert_int_equal(ap_image_create(NULL, width, height, &image), AP_OK);
    for (size_t k = 0; k < (size_t)width * height; k++) {
        image.rgb[3 * k] = r;
        image.rgb[3 * k + 1] = g;
        image.rgb[3 * k + 2] = b;
    }
    return image;
}

static void assert_pixel(const struct ap_image *image, uint32_t x, uint32_t y, int r, int g,
                         int b) {
    const uint8_t *p = image->rgb + ((size_t)y * image->width + x) * 3;
    if (p[0] != r || p[1] != g || p[2] != b)
        fail_msg("pixel (%u, %u): %d %d %d, expected %d %d %d", x, y, p[0], p[1], p[2], r, g, b);
}

static void srgb_curve(void **state) {
    (void)state;
    for (int v = 0; v < 256; v++)
        assert_int_equal(ap_srgb_from_linear(ap_linear_from_srgb((uint8_t)v)), v);
    double middle = ap_linear_from_srgb(128);
    if (fabs(middle - 0.21586050011389926) > 1e-15) // IEC 61966-2-1 in 50 digits
        fail_msg("linear of 128: %.17g, expected 0.21586050011389926 within 1e-15", middle);
    assert_int_equal(ap_srgb_from_linear(-1), 0);
    assert_int_equal(ap_srgb_from_linear(NAN), 0);
    assert_int_equal(ap_srgb_from_linear(2), 255);
    assert_int_equal(ap_srgb_from_linear(0.5), 188);
}

static void side_by_side(void **state) {
    (void)state;
    struct ap_image l = make(3, 2, 1, 2, 3), r = make(3, 2, 4, 5, 6), other = make(2, 3, 0, 0, 0);
    struct ap_image out = {0};
    assert_int_equal(ap_image_side_by_side(NULL, &l, &r, &out), AP_OK);
    assert_int_equal(out.width, 6);
    assert_int_equal(out.height, 2);
    assert_pixel(&out, 2, 1, 1, 2, 3);
    assert_pixel(&out, 3, 1, 4, 5, 6);
    ap_image_finish(&out);
    struct ap_error err = {{0}};
    assert_int_equal(ap_image_side_by_side(&err, &l, &other, &out), AP_INPUT);
    assert_non_null(strstr(err.text, "3x2"));
    assert_int_equal(ap_image_anaglyph(&err, &l, &other, &out), AP_INPUT);
    ap_image_finish(&l);
    ap_image_finish(&r);
    ap_image_finish(&other);
}

static void anaglyph(void **state) {
    (void)state;
    const uint8_t colours[][3] = {{255, 0, 0}, {0, 255, 0}, {0, 0, 255}, {10, 200, 77}, {7, 7, 7}};
    for (size_t k = 0; k < 5; k++) {
        const uint8_t *c = colours[k];
        struct ap_image l = make(2, 2, c[0], c[1], c[2]), r = make(2, 2, 9, 150, 33), out;
        assert_int_equal(ap_image_anaglyph(NULL, &l, &r, &out), AP_OK);
        double y = 0.2126 * ap_linear_from_srgb(c[0]) + 0.7152 * ap_linear_from_srgb(c[1]) +
                   0.0722 * ap_linear_from_srgb(c[2]);
        assert_pixel(&out, 1, 1, ap_srgb_from_linear(y), 150, 33);
        ap_image_finish(&l);
        ap_image_finish(&r);
        ap_image_finish(&out);
    }
}

static void contact_sheet(void **state) {
    (void)state;
    struct ap_image cells[3] = {make(4, 3, 10, 0, 0), make(4, 3, 0, 20, 0), make(4, 3, 0, 0, 30)};
    struct ap_image out;
    assert_int_equal(ap_image_contact_sheet(NULL, cells, 3, 2, 2, &out), AP_OK);
    assert_int_equal(out.width, 2 + 4 + 2 + 4 + 2);
    assert_int_equal(out.height, 2 + 3 + 2 + 3 + 2);
    assert_pixel(&out, 2, 2, 10, 0, 0);
    assert_pixel(&out, 11, 4, 0, 20, 0);
    assert_pixel(&out, 2, 9, 0, 0, 30);
    assert_pixel(&out, 1, 1, 48, 48, 48);
    assert_pixel(&out, 9, 9, 48, 48, 48);
    ap_image_finish(&out);
    assert_int_equal(ap_image_contact_sheet(NULL, cells, 0, 2, 2, &out), AP_INPUT);
    assert_int_equal(ap_image_contact_sheet(NULL, cells, 3, 0, 2, &out), AP_INPUT);
    assert_int_equal(ap_image_contact_sheet(NULL, cells, 3, 2, UINT32_MAX, &out), AP_INPUT);
    for (int k = 0; k < 3; k++)
        ap_image_finish(&cells[k]);
}

// Against the integral written out pixel by pixel.
static void shrink(void **state) {
    (void)state;
    struct ap_image in = make(7, 5, 0, 0, 0), out;
    for (size_t k = 0; k < 7 * 5 * 3; k++)
        in.rgb[k] = (uint8_t)(k * 37);
    assert_int_equal(ap_image_shrink(NULL, &in, 7, 5, &out), AP_OK);
    assert_memory_equal(in.rgb, out.rgb, 7 * 5 * 3);
    ap_image_finish(&out);
    assert_int_equal(ap_image_shrink(NULL, &in, 3, 2, &out), AP_OK);
    for (int j = 0; j < 2; j++)
        for (int i = 0; i < 3; i++)
            for (int c = 0; c < 3; c++) {
                double sum = 0;
                for (int y = 0; y < 5; y++)
                    for (int x = 0; x < 7; x++) {
                        double w = fmin(x + 1, (i + 1) * 7 / 3.0) - fmax(x, i * 7 / 3.0);
                        double h = fmin(y + 1, (j + 1) * 2.5) - fmax(y, j * 2.5);
                        if (w > 0 && h > 0)
                            sum += w * h * ap_linear_from_srgb(in.rgb[(y * 7 + x) * 3 + c]);
                    }
                int expected = ap_srgb_from_linear(sum / (7 / 3.0 * 2.5));
                assert_int_equal(out.rgb[(j * 3 + i) * 3 + c], expected);
            }
    ap_image_finish(&out);
    assert_int_equal(ap_image_shrink(NULL, &in, 8, 5, &out), AP_INPUT);
    assert_int_equal(ap_image_shrink(NULL, &in, 0, 5, &out), AP_INPUT);
    ap_image_finish(&in);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(srgb_curve),    cmocka_unit_test(side_by_side), cmocka_unit_test(anaglyph),
        cmocka_unit_test(contact_sheet), cmocka_unit_test(shrink),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
