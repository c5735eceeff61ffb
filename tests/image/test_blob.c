#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "src/image/image.h"

// What stands behind a disc: linear light at (x, y), per channel.
typedef double ground(double x, double y, int channel);

static double black(double x, double y, int c) {
    (void)x, (void)y, (void)c;
    return 0;
}
static double blue(double x, double y, int c) {
    (void)x, (void)y;
    return c == 2 ? 0.6 : 0.05;
}
static double slope(double x, double y, int c) {
    return 0.05 + (c == 0 ? 0.001 * x : c == 1 ? 0.003 * y : 0.2 + 0.002 * (x + y));
}
static double curved(double x, double y, int c) {
    return 0.3 + 0.2 * sin(0.03 * x + c) * cos(0.04 * y);
}

// Area of the disc inside a pixel, by 64 exact chords.
static double disc_coverage(double cx, double cy, double r, int i, int j) {
    enum { N = 64 };
    double sum = 0;
    for (int k = 0; k < N; k++) {
        double y = j + (k + 0.5) / N - cy;
        if (fabs(y) >= r)
            continue;
        double half = sqrt(r * r - y * y);
        double from = fmax(i, cx - half), to = fmin(i + 1, cx + half);
        sum += fmax(0, to - from) / N;
    }
    return sum;
}

static struct ap_image paint(uint32_t width, uint32_t height, ground *behind) {
    struct ap_image image;
    assert_int_equal(ap_image_create(NULL, width, height, &image), AP_OK);
    for (uint32_t j = 0; j < height; j++)
        for (uint32_t i = 0; i < width; i++)
            for (int c = 0; c < 3; c++)
                image.rgb[((size_t)j * width + i) * 3 + (size_t)c] =
                    ap_srgb_from_linear(behind(i + 0.5, j + 0.5, c));
    return image;
}

static void draw_disc(struct ap_image *image, const uint8_t color[3], double cx, double cy,
                      double r) {
    for (int j = (int)fmax(0, cy - r - 1); j <= cy + r + 1 && j < (int)image->height; j++)
        for (int i = (int)fmax(0, cx - r - 1); i <= cx + r + 1 && i < (int)image->width; i++) {
            double a = disc_coverage(cx, cy, r, i, j);
            uint8_t *p = image->rgb + ((size_t)j * image->width + (size_t)i) * 3;
            for (int c = 0; c < 3 && a > 0; c++)
                p[c] = ap_srgb_from_linear(a * ap_linear_from_srgb(color[c]) +
                                           (1 - a) * ap_linear_from_srgb(p[c]));
        }
}

static struct ap_blob_query around(const uint8_t color[3], double cx, double cy, double reach) {
    return (struct ap_blob_query){
        {color[0], color[1], color[2]}, cx - reach, cx + reach, cy - reach, cy + reach};
}

static const uint8_t red[3] = {255, 32, 32}, green[3] = {32, 220, 64}, white[3] = {255, 255, 255};

// Worst error over 24 positions and radii from r_min on.
static double worst_error(ground *behind, const uint8_t color[3], double r_min) {
    double worst = 0;
    for (int k = 0; k < 24; k++) {
        double r = r_min + 0.83 * k, cx = 60 + fmod(0.137 * k, 1), cy = 58 + fmod(0.331 * k, 1);
        struct ap_image image = paint(120, 120, behind);
        struct ap_blob blob;
        draw_disc(&image, color, cx, cy, r);
        struct ap_blob_query q = around(color, cx + 0.4, cy - 0.3, r + 8);
        assert_true(ap_find_blob(&image, &q, &blob));
        assert_false(blob.touches_edge);
        worst = fmax(worst, hypot(blob.i - cx, blob.j - cy));
        double area = acos(-1) * r * r;
        if (fabs(blob.area_px - area) > 0.01 * area + 0.05)
            fail_msg("radius %g: area %g, expected %g", r, blob.area_px, area);
        ap_image_finish(&image);
    }
    return worst;
}

static void accuracy(void **state) {
    (void)state;
    static const struct {
        const char *name;
        ground *behind;
        const uint8_t *color;
    } cases[] = {{"red on black", black, red},   {"green on black", black, green},
                 {"red on blue", blue, red},     {"white on blue", blue, white},
                 {"red on slope", slope, red},   {"white on slope", slope, white},
                 {"red on curved", curved, red}, {"green on curved", curved, green}};
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        // Below a radius of 4 px the bytes' rounding alone, with exact coverage, costs up to 0.008.
        double small = worst_error(cases[k].behind, cases[k].color, 2);
        double e = worst_error(cases[k].behind, cases[k].color, 4);
        printf("%s: worst error %.5f px, from radius 2 on %.5f\n", cases[k].name, e, small);
        if (!(e < 0.005 && small < 0.01))
            fail_msg("%s: %g px, tolerance 0.005; from radius 2 on %g, tolerance 0.01",
                     cases[k].name, e, small);
    }
}

// Two discs of nearly one colour, side by side and in one box: each is measured alone.
static void similar_colours(void **state) {
    (void)state;
    const uint8_t a[3] = {255, 32, 32}, b[3] = {255, 32, 30}, c[3] = {253, 34, 32};
    struct ap_image image = paint(160, 80, slope);
    struct ap_blob blob;
    draw_disc(&image, a, 40.3, 40.2, 9);
    draw_disc(&image, b, 66.6, 41.7, 12);
    draw_disc(&image, c, 100.1, 38.5, 15);
    const struct {
        const uint8_t *color;
        double i, j;
    } discs[] = {{a, 40.3, 40.2}, {b, 66.6, 41.7}, {c, 100.1, 38.5}};
    for (int k = 0; k < 3; k++) {
        const uint8_t *color = discs[k].color;
        struct ap_blob_query q = {{color[0], color[1], color[2]}, 0, 160, 0, 80};
        assert_true(ap_find_blob(&image, &q, &blob));
        double e = hypot(blob.i - discs[k].i, blob.j - discs[k].j);
        if (!(e < 0.005))
            fail_msg("disc %d: (%.4f, %.4f), expected (%g, %g), error %g, tolerance 0.005", k,
                     blob.i, blob.j, discs[k].i, discs[k].j, e);
    }
    ap_image_finish(&image);
}

// A driver that rounds the colour one step off.
static void rounded_colour(void **state) {
    (void)state;
    const uint8_t drawn[3] = {254, 33, 32};
    struct ap_image image = paint(64, 64, blue);
    struct ap_blob blob;
    draw_disc(&image, drawn, 30.25, 33.75, 7);
    struct ap_blob_query q = around(red, 32, 32, 25);
    assert_true(ap_find_blob(&image, &q, &blob));
    assert_true(hypot(blob.i - 30.25, blob.j - 33.75) < 0.005);
    ap_image_finish(&image);
}

static void edges_and_misses(void **state) {
    (void)state;
    struct ap_image image = paint(64, 64, black);
    struct ap_blob blob = {.i = -7};
    draw_disc(&image, red, 3.0, 30, 5);
    struct ap_blob_query all = {{255, 32, 32}, -1e9, 1e9, -1e9, 1e9};
    assert_true(ap_find_blob(&image, &all, &blob));
    assert_true(blob.touches_edge);
    struct ap_blob_query cut = {{255, 32, 32}, 5, 20, 20, 40};
    assert_true(ap_find_blob(&image, &cut, &blob));
    assert_true(blob.touches_edge);
    blob.i = -7;
    const struct ap_blob_query misses[] = {
        {{255, 32, 32}, 20, 60, 0, 64},       {{0, 255, 0}, 0, 64, 0, 64},
        {{255, 32, 32}, 10, 5, 0, 64},        {{255, 32, 32}, NAN, NAN, 0, 64},
        {{255, 32, 32}, 100, 200, 0, 64},     {{255, 32, 32}, -20, -5, 0, 64},
        {{255, 32, 32}, 0, 64, -INFINITY, -1}};
    for (size_t k = 0; k < sizeof misses / sizeof misses[0]; k++)
        assert_false(ap_find_blob(&image, &misses[k], &blob));
    assert_true(blob.i == -7);
    ap_image_finish(&image);
    // A picture that is nothing but the colour has no background to measure against.
    image = paint(16, 16, black);
    draw_disc(&image, red, 8, 8, 40);
    assert_true(ap_find_blob(&image, &all, &blob));
    assert_true(blob.touches_edge);
    ap_image_finish(&image);
}

// A second thing that touches the disc is told apart from an uneven background.
static void strange_pixels(void **state) {
    (void)state;
    const uint8_t cyan[3] = {34, 224, 255}, lime[3] = {128, 255, 32};
    ground *const grounds[] = {black, blue, slope};
    struct ap_blob blob;
    for (size_t k = 0; k < 3; k++) {
        struct ap_image image = paint(64, 64, grounds[k]);
        draw_disc(&image, cyan, 30.3, 31.6, 6.2);
        struct ap_blob_query query = around(cyan, 30.3, 31.6, 12);
        assert_true(ap_find_blob(&image, &query, &blob));
        if (blob.strange_px > 0.3)
            fail_msg("alone: %g strange pixels, at most 0.3", blob.strange_px);
        draw_disc(&image, lime, 24.2, 31.6, 2.5);
        draw_disc(&image, cyan, 30.3, 31.6, 6.2);
        assert_true(ap_find_blob(&image, &query, &blob));
        if (blob.strange_px < 1)
            fail_msg("touched: %g strange pixels, at least 1", blob.strange_px);
        ap_image_finish(&image);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(accuracy),       cmocka_unit_test(similar_colours),
        cmocka_unit_test(rounded_colour), cmocka_unit_test(edges_and_misses),
        cmocka_unit_test(strange_pixels),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
