#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "src/base/file.h"
#include "src/image/compare.h"

// Pictures of one channel of 16 bits: every value comes back, and a difference of one 65535th
// counts.

enum { W = 37, H = 21 };

static char path[] = "/tmp/antipode-grey-XXXXXX";

static void fill(uint16_t *values) {
    for (int k = 0; k < W * H; k++)
        values[k] = (uint16_t)(k * 84 + (k % 3)); // beyond what bytes can tell
    values[0] = 0;
    values[W * H - 1] = 65535;
}

static void round_trip(void **state) {
    (void)state;
    uint16_t values[W * H];
    fill(values);
    for (int raw = 0; raw < 2; raw++) {
        struct ap_grey grey = {values, W, H};
        struct ap_image image;
        struct ap_error err = {{0}};
        assert_int_equal(ap_grey_write(&err, path, &grey, raw), AP_OK);
        if (ap_picture_read(&err, path, &image))
            fail_msg("%s", err.text);
        assert_int_equal(image.width, W);
        assert_int_equal(image.height, H);
        assert_non_null(image.grey);
        assert_memory_equal(image.grey, values, sizeof values);
        for (int k = 0; k < W * H * 3; k++)
            if (fabs(image.rgb[k] - values[k / 3] / 257.0) > 0.5)
                fail_msg("byte %d is %d for %d, expected it within a half", k, image.rgb[k],
                         values[k / 3]);
        ap_image_finish(&image);
        assert_null(image.grey);
    }
}

// The header of either kind, by hand.
static void as_specified(void **state) {
    (void)state;
    static const uint16_t values[2] = {0x0102, 0xfffe};
    static const char pam[] = "P7\nWIDTH 2\nHEIGHT 1\nDEPTH 1\nMAXVAL 65535\n"
                              "TUPLTYPE GRAYSCALE\nENDHDR\n\1\2\377\376";
    static const unsigned char png[] = {0, 0, 0, 2, 0, 0, 0, 1, 16, 0}; // size, depth, grey
    struct ap_grey grey = {values, 2, 1};
    char *bytes;
    size_t len;
    assert_int_equal(ap_grey_write(NULL, path, &grey, true), AP_OK);
    assert_int_equal(ap_file_read(NULL, path, 1000, &bytes, &len), AP_OK);
    assert_int_equal(len, sizeof pam - 1);
    assert_memory_equal(bytes, pam, len);
    free(bytes);
    assert_int_equal(ap_grey_write(NULL, path, &grey, false), AP_OK);
    assert_int_equal(ap_file_read(NULL, path, 1000, &bytes, &len), AP_OK);
    assert_memory_equal(bytes + 16, png, sizeof png);
    free(bytes);
    grey.width = 0;
    assert_int_equal(ap_grey_write(NULL, path, &grey, false), AP_INPUT);
    assert_int_equal(ap_grey_write(NULL, "/nowhere/a.png", &(struct ap_grey){values, 2, 1}, true),
                     AP_ENVIRONMENT);
}

static void cut_short(void **state) {
    (void)state;
    uint16_t values[W * H];
    fill(values);
    for (int raw = 0; raw < 2; raw++) {
        char *bytes;
        size_t len;
        struct ap_image image;
        assert_int_equal(ap_grey_write(NULL, path, &(struct ap_grey){values, W, H}, raw), AP_OK);
        assert_int_equal(ap_file_read(NULL, path, 1 << 20, &bytes, &len), AP_OK);
        for (size_t n = 0; n < len; n += raw ? 41 : 13) {
            FILE *f = fopen(path, "wb");
            assert_int_equal(fwrite(bytes, 1, n, f), n);
            fclose(f);
            struct ap_error err = {{0}};
            if (ap_picture_read(&err, path, &image) != AP_INPUT)
                fail_msg("%zu of %zu bytes were read", n, len);
        }
        free(bytes);
    }
}

// One value of all is off by one 65535th.
static void differences(void **state) {
    (void)state;
    uint16_t values[W * H];
    fill(values);
    struct ap_image a, b, picture;
    assert_int_equal(ap_grey_write(NULL, path, &(struct ap_grey){values, W, H}, false), AP_OK);
    assert_int_equal(ap_picture_read(NULL, path, &a), AP_OK);
    values[5 * W + 7]++;
    assert_int_equal(ap_grey_write(NULL, path, &(struct ap_grey){values, W, H}, true), AP_OK);
    assert_int_equal(ap_picture_read(NULL, path, &b), AP_OK);
    struct ap_difference d;
    assert_int_equal(ap_image_difference(NULL, &a, &b, &d), AP_OK);
    assert_int_equal(d.pixels, 1);
    assert_int_equal(d.largest_step, 1);
    assert_int_equal(d.largest.x, 7);
    assert_int_equal(d.largest.y, 5);
    double want = 10 * log10(65535.0 * 65535.0 * W * H);
    if (fabs(d.psnr_db - want) > 1e-9)
        fail_msg("PSNR %.12g dB, expected %.12g within 1e-9", d.psnr_db, want);
    assert_int_equal(ap_image_difference_picture(NULL, &a, &b, NULL, &picture), AP_OK);
    assert_true(picture.rgb[3 * (5 * 3 * W + 2 * W + 7)] > 0); // seen in the map
    ap_image_finish(&picture);
    b.grey[0] = 514; // two bytes' steps
    b.grey[1] = 0;
    assert_int_equal(ap_image_difference(NULL, &a, &b, &d), AP_OK);
    assert_int_equal(d.largest_step, 2);
    // A picture of bytes has only these to be compared with.
    free(b.grey);
    b.grey = NULL;
    ap_image_difference(NULL, &a, &b, &d);
    assert_int_equal(d.pixels, 0);
    ap_image_finish(&a);
    ap_image_finish(&b);
}

static int begin(void **state) {
    (void)state;
    int fd = mkstemp(path);
    return fd < 0 || close(fd);
}

static int end(void **state) {
    (void)state;
    return unlink(path);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(round_trip),
        cmocka_unit_test(as_specified),
        cmocka_unit_test(cut_short),
        cmocka_unit_test(differences),
    };
    return cmocka_run_group_tests(tests, begin, end);
}
