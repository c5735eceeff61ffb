// A picture through a lens: nothing happens without distortion; a straight ramp is where the
// formula puts it; colours part; outside is black.

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "src/image/lens.h"

enum { W = 80, H = 60 };

static uint8_t in[W * H * 4], out[W * H * 4];
static const struct ap_lens_view plain = {-1, 0.8, 0.9, -0.7, 0, 0, {1, 1, 1}};

// Linear in light across, so that bilinear sampling reproduces it but for the bytes' rounding.
static double light(double i) {
    return 0.1 + 0.8 * (i + 0.5) / W;
}

static void draw_ramp(void) {
    for (int k = 0; k < W * H; k++) {
        memset(in + 4 * k, ap_srgb_from_linear(light(k % W)), 3);
        in[4 * k + 3] = (uint8_t)k;
    }
}

static void no_lens_is_no_change(void **state) {
    (void)state;
    srand(3);
    for (size_t k = 0; k < sizeof in; k++)
        in[k] = (uint8_t)rand();
    struct ap_pixels pixels = {in, W, H, W * 4, false};
    ap_pixels_through_lens(&pixels, &plain, out);
    for (int k = 0; k < W * H; k++) {
        if (memcmp(in + 4 * k, out + 4 * k, 3) != 0)
            fail_msg("pixel %d: %d, expected %d", k, out[4 * k], in[4 * k]);
        assert_int_equal(out[4 * k + 3], 255);
    }
    pixels.bgra = true;
    ap_pixels_through_lens(&pixels, &plain, out);
    assert_int_equal(out[0], in[2]);
    assert_int_equal(out[2], in[0]);
}

static void a_ramp_is_where_the_formula_says(void **state) {
    (void)state;
    draw_ramp();
    struct ap_lens_view v = plain;
    v.k1 = 0.2;
    v.k2 = 0.05;
    v.scale[0] = 0.99;
    v.scale[2] = 1.02;
    struct ap_pixels pixels = {in, W, H, W * 4, false};
    ap_pixels_through_lens(&pixels, &v, out);
    int black = 0, seen = 0;
    for (int y = 0; y < H; y++)
        for (int x = 0; x < W; x++)
            for (int c = 0; c < 3; c++) {
                double px = -1 + 1.8 * (x + 0.5) / W, py = 0.9 - 1.6 * (y + 0.5) / H;
                double r = hypot(px, py);
                double factor = v.scale[c] * (1 + v.k1 * pow(r, 2) + v.k2 * pow(r, 4));
                double i = (px * factor + 1) / 1.8 * W - 0.5, j = (0.9 - py * factor) / 1.6 * H;
                int got = out[4 * (y * W + x) + c];
                if (i < -0.5 || i > W - 0.5 || j < 0 || j > H) {
                    assert_int_equal(got, 0);
                    black++;
                    continue;
                }
                double at = fmin(fmax(i, 0), W - 1);
                double want = ap_srgb_from_linear(light(at));
                if (fabs(got - want) > 1)
                    fail_msg("(%d, %d) channel %d: %d, expected %g within 1", x, y, c, got, want);
                seen++;
            }
    assert_true(black > 500 && seen > 5000);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(no_lens_is_no_change),
        cmocka_unit_test(a_ramp_is_where_the_formula_says),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
