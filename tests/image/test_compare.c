// PSNR, SSIM and FLIP against the formulas written out again by brute force in double, and the
// largest patch against a flood fill.

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "src/image/compare.h"

static uint32_t seed = 7;
static uint32_t noise(uint32_t below) {
    seed = seed * 1664525u + 1013904223u;
    return (uint32_t)(((uint64_t)seed * below) >> 32);
}

static struct ap_image picture(uint32_t width, uint32_t height) {
    struct ap_image image;
    assert_int_equal(ap_image_create(NULL, width, height, &image), AP_OK);
    for (uint32_t y = 0; y < height; y++)
        for (uint32_t x = 0; x < width; x++)
            for (uint32_t c = 0; c < 3; c++)
                image.rgb[3 * (y * width + x) + c] =
                    (uint8_t)(100 + 80 * sin(0.3 * x + c) * cos(0.2 * y) + noise(40));
    return image;
}

// Every n-th pixel or so is moved by up to `by`.
static struct ap_image changed(const struct ap_image *from, uint32_t n, int by) {
    struct ap_image image;
    assert_int_equal(ap_image_create(NULL, from->width, from->height, &image), AP_OK);
    for (size_t k = 0; k < (size_t)3 * from->width * from->height; k++) {
        int v = from->rgb[k] + (noise(n) == 0 ? (int)noise(2 * (uint32_t)by + 1) - by : 0);
        image.rgb[k] = (uint8_t)(v < 0 ? 0 : v > 255 ? 255 : v);
    }
    return image;
}

static void near(const char *what, double got, double want, double tolerance) {
    if (!(fabs(got - want) <= tolerance))
        fail_msg("%s: %.17g, expected %.17g within %g", what, got, want, tolerance);
}

static double slow_psnr(const struct ap_image *a, const struct ap_image *b) {
    double sum = 0, n = 3.0 * a->width * a->height;
    for (size_t k = 0; k < (size_t)n; k++)
        sum += pow((double)a->rgb[k] - b->rgb[k], 2);
    return 20 * log10(255) - 10 * log10(sum / n);
}

static double grey(const struct ap_image *a, long x, long y) {
    const uint8_t *p = a->rgb + 3 * (y * (long)a->width + x);
    return 0.299 * p[0] + 0.587 * p[1] + 0.114 * p[2];
}

static double slow_ssim(const struct ap_image *a, const struct ap_image *b, int nx, int ny) {
    double total = 0, windows = 0;
    for (long y = 0; y + ny <= (long)a->height; y++)
        for (long x = 0; x + nx <= (long)a->width; x++) {
            double w = 0, ma = 0, mb = 0, va = 0, vb = 0, cov = 0;
            for (int pass = 0; pass < 2; pass++)
                for (int j = 0; j < ny; j++)
                    for (int i = 0; i < nx; i++) {
                        double dx = i - nx / 2, dy = j - ny / 2;
                        double g = exp(-(dx * dx + dy * dy) / 4.5);
                        double p = grey(a, x + i, y + j), q = grey(b, x + i, y + j);
                        if (pass == 0) {
                            w += g;
                            ma += g * p;
                            mb += g * q;
                        } else {
                            va += g / w * (p - ma / w) * (p - ma / w);
                            vb += g / w * (q - mb / w) * (q - mb / w);
                            cov += g / w * (p - ma / w) * (q - mb / w);
                        }
                    }
            ma /= w;
            mb /= w;
            total += (2 * ma * mb + 6.5025) * (2 * cov + 58.5225) /
                     ((ma * ma + mb * mb + 6.5025) * (va + vb + 58.5225));
            windows++;
        }
    return total / windows;
}

static void psnr_and_ssim(void **state) {
    (void)state;
    static const struct {
        uint32_t width, height;
        int nx, ny;
    } size[] = {{40, 30, 11, 11}, {11, 11, 11, 11}, {64, 5, 11, 5}, {1, 40, 1, 11}, {10, 4, 9, 3}};
    for (size_t k = 0; k < sizeof size / sizeof *size; k++)
        for (uint32_t n = 1; n < 100; n *= 9) {
            struct ap_image a = picture(size[k].width, size[k].height);
            struct ap_image b = changed(&a, n, 90);
            b.rgb[0] ^= 1;
            struct ap_difference d;
            double ssim;
            assert_int_equal(ap_image_difference(NULL, &a, &b, &d), AP_OK);
            assert_int_equal(ap_image_ssim(NULL, &a, &b, &ssim), AP_OK);
            near("psnr", d.psnr_db, slow_psnr(&a, &b), 1e-9);
            near("ssim", ssim, slow_ssim(&a, &b, size[k].nx, size[k].ny), 1e-9);
            ap_image_finish(&a);
            ap_image_finish(&b);
        }
}

static void the_same(void **state) {
    (void)state;
    struct ap_image a = picture(33, 21), other = picture(33, 20);
    struct ap_difference d;
    double v;
    assert_int_equal(ap_image_difference(NULL, &a, &a, &d), AP_OK);
    assert_true(isinf(d.psnr_db) && d.psnr_db > 0);
    assert_int_equal(d.pixels + d.largest.pixels + (uint64_t)d.largest_step, 0);
    assert_int_equal(ap_image_ssim(NULL, &a, &a, &v), AP_OK);
    near("ssim", v, 1, 0);
    assert_int_equal(ap_image_flip(NULL, &a, &a, AP_FLIP_PPD, &v, NULL), AP_OK);
    near("flip", v, 0, 0);
    struct ap_error err;
    assert_int_equal(ap_image_difference(&err, &a, &other, &d), AP_INPUT);
    assert_non_null(strstr(err.text, "33x21"));
    assert_int_equal(ap_image_ssim(&err, &a, &other, &v), AP_INPUT);
    assert_int_equal(ap_image_flip(&err, &a, &other, 60, &v, NULL), AP_INPUT);
    assert_int_equal(ap_image_flip(&err, &a, &a, NAN, &v, NULL), AP_INPUT);
    ap_image_finish(&a);
    ap_image_finish(&other);
}

// ---- the largest patch

static uint64_t flood(const struct ap_image *a, const struct ap_image *b, uint8_t *seen, long x,
                      long y, long box[4]) {
    if (x < 0 || y < 0 || x >= (long)a->width || y >= (long)a->height)
        return 0;
    long k = y * (long)a->width + x;
    if (seen[k] || memcmp(a->rgb + 3 * k, b->rgb + 3 * k, 3) == 0)
        return 0;
    seen[k] = 1;
    box[0] = x < box[0] ? x : box[0];
    box[1] = y < box[1] ? y : box[1];
    box[2] = x > box[2] ? x : box[2];
    box[3] = y > box[3] ? y : box[3];
    uint64_t n = 1;
    for (int dy = -1; dy <= 1; dy++)
        for (int dx = -1; dx <= 1; dx++)
            n += flood(a, b, seen, x + dx, y + dy, box);
    return n;
}

static void largest_patch(void **state) {
    (void)state;
    for (int round = 0; round < 200; round++) {
        struct ap_image a = picture(1 + noise(30), 1 + noise(30));
        struct ap_image b = changed(&a, 2 + noise(30), 5);
        size_t n = (size_t)a.width * a.height;
        uint8_t *seen = calloc(n, 1);
        uint64_t best = 0, all = 0;
        long box[4] = {0};
        for (size_t k = 0; k < n; k++) {
            long x = (long)(k % a.width), y = (long)(k / a.width);
            long this_box[4] = {x, y, x, y};
            uint64_t size = flood(&a, &b, seen, x, y, this_box);
            all += size;
            if (size > best) {
                best = size;
                memcpy(box, this_box, sizeof box);
            }
        }
        struct ap_difference d;
        assert_int_equal(ap_image_difference(NULL, &a, &b, &d), AP_OK);
        assert_int_equal(d.pixels, all);
        assert_int_equal(d.largest.pixels, best);
        if (best) {
            assert_int_equal(d.largest.x, box[0]);
            assert_int_equal(d.largest.y, box[1]);
            assert_int_equal(d.largest.width, box[2] - box[0] + 1);
            assert_int_equal(d.largest.height, box[3] - box[1] + 1);
        }
        free(seen);
        ap_image_finish(&a);
        ap_image_finish(&b);
    }
}

// ---- FLIP, straight from the paper: two-dimensional kernels, pixel by pixel

static const double xyz[3][3] = {{0.4123907993, 0.3575843394, 0.1804807884},
                                 {0.2126390059, 0.7151686788, 0.0721923154},
                                 {0.0193308187, 0.1191947798, 0.9505321522}};

static void times(const double m[3][3], const double v[3], double out[3]) {
    for (int r = 0; r < 3; r++)
        out[r] = m[r][0] * v[0] + m[r][1] * v[1] + m[r][2] * v[2];
}

static void solve(const double m[3][3], const double v[3], double out[3]) {
    double det = 0, minor[3][3];
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 3; c++)
            minor[r][c] = m[(r + 1) % 3][(c + 1) % 3] * m[(r + 2) % 3][(c + 2) % 3] -
                          m[(r + 1) % 3][(c + 2) % 3] * m[(r + 2) % 3][(c + 1) % 3];
    for (int c = 0; c < 3; c++)
        det += m[0][c] * minor[0][c];
    for (int r = 0; r < 3; r++)
        out[r] = (minor[0][r] * v[0] + minor[1][r] * v[1] + minor[2][r] * v[2]) / det;
}

static const double ones[3] = {1, 1, 1};

// Y, Cx, Cz of the pixel nearest to (x, y).
static void ycxcz(const struct ap_image *a, long x, long y, double out[3]) {
    x = x < 0 ? 0 : x >= (long)a->width ? (long)a->width - 1 : x;
    y = y < 0 ? 0 : y >= (long)a->height ? (long)a->height - 1 : y;
    double rgb[3], v[3], white[3];
    for (int c = 0; c < 3; c++)
        rgb[c] = ap_linear_from_srgb(a->rgb[3 * (y * (long)a->width + x) + c]);
    times(xyz, rgb, v);
    times(xyz, ones, white);
    out[0] = 116 * v[1] / white[1] - 16;
    out[1] = 500 * (v[0] / white[0] - v[1] / white[1]);
    out[2] = 200 * (v[1] / white[1] - v[2] / white[2]);
}

static void lab_hunt(const double rgb[3], double out[3]) {
    double v[3], white[3], f[3];
    times(xyz, rgb, v);
    times(xyz, ones, white);
    for (int c = 0; c < 3; c++) {
        double t = v[c] / white[c];
        f[c] = t > 216.0 / 24389 ? cbrt(t) : (24389.0 / 27 * t + 16) / 116;
    }
    out[0] = 116 * f[1] - 16;
    out[1] = 0.01 * out[0] * 500 * (f[0] - f[1]);
    out[2] = 0.01 * out[0] * 200 * (f[1] - f[2]);
}

static void blurred_lab(const struct ap_image *a, long x, long y, double ppd, double out[3]) {
    static const double a1[3] = {1, 1, 34.1}, b1[3] = {0.0047, 0.0053, 0.04};
    static const double a2[3] = {0, 0, 13.5}, b2[3] = {1e-5, 1e-5, 0.025};
    long r = (long)ceil(3 * sqrt(0.04 / (2 * M_PI * M_PI)) * ppd);
    double sum[3] = {0}, weights[3] = {0};
    for (long j = -r; j <= r; j++)
        for (long i = -r; i <= r; i++) {
            double v[3], d2 = (double)(i * i + j * j) / (ppd * ppd);
            ycxcz(a, x + i, y + j, v);
            for (int c = 0; c < 3; c++) {
                double w = a1[c] * sqrt(M_PI / b1[c]) * exp(-M_PI * M_PI * d2 / b1[c]) +
                           a2[c] * sqrt(M_PI / b2[c]) * exp(-M_PI * M_PI * d2 / b2[c]);
                sum[c] += w * v[c];
                weights[c] += w;
            }
        }
    double white[3], v[3], rgb[3];
    times(xyz, ones, white);
    double fy = (sum[0] / weights[0] + 16) / 116;
    v[0] = (fy + sum[1] / weights[1] / 500) * white[0];
    v[1] = fy * white[1];
    v[2] = (fy - sum[2] / weights[2] / 200) * white[2];
    solve(xyz, v, rgb);
    for (int c = 0; c < 3; c++)
        rgb[c] = fmin(fmax(rgb[c], 0), 1);
    lab_hunt(rgb, out);
}

// What the edge (or point) detector answers.
static double feature(const struct ap_image *a, long x, long y, double ppd, int point) {
    double sd = 0.5 * 0.082 * ppd, sum[2] = {0}, plus = 0, minus = 0;
    long r = (long)ceil(3 * sd);
    for (int pass = 0; pass < 2; pass++)
        for (long j = -r; j <= r; j++)
            for (long i = -r; i <= r; i++) {
                double g = exp(-(double)(i * i + j * j) / (2 * sd * sd)), v[3];
                double wx = point ? ((double)(i * i) / (sd * sd) - 1) * g : -(double)i * g;
                double wy = point ? ((double)(j * j) / (sd * sd) - 1) * g : -(double)j * g;
                if (pass == 0) {
                    plus += fmax(wx, 0);
                    minus += fmax(-wx, 0);
                    continue;
                }
                ycxcz(a, x + i, y + j, v);
                double t = (v[0] + 16) / 116;
                sum[0] += wx / (wx > 0 ? plus : minus) * t;
                sum[1] += wy / (wy > 0 ? plus : minus) * t;
            }
    return hypot(sum[0], sum[1]);
}

static double slow_flip(const struct ap_image *a, const struct ap_image *b, long x, long y,
                        double ppd) {
    static const double green[3] = {0, 1, 0}, blue[3] = {0, 0, 1};
    double p[3], q[3], g[3], bl[3];
    blurred_lab(a, x, y, ppd, p);
    blurred_lab(b, x, y, ppd, q);
    lab_hunt(green, g);
    lab_hunt(blue, bl);
    double d = pow(fabs(p[0] - q[0]) + hypot(p[1] - q[1], p[2] - q[2]), 0.7);
    double most = pow(fabs(g[0] - bl[0]) + hypot(g[1] - bl[1], g[2] - bl[2]), 0.7);
    double c =
        d < 0.4 * most ? 0.95 / (0.4 * most) * d : 0.95 + (d - 0.4 * most) / (0.6 * most) * 0.05;
    double edge = fabs(feature(a, x, y, ppd, 0) - feature(b, x, y, ppd, 0));
    double spot = fabs(feature(a, x, y, ppd, 1) - feature(b, x, y, ppd, 1));
    return pow(c, 1 - fmin(pow(fmax(edge, spot) / sqrt(2), 0.5), 1));
}

static void flip(void **state) {
    (void)state;
    const double ppd[] = {16, 40};
    for (int k = 0; k < 2; k++) {
        struct ap_image a = picture(23, 17), b = changed(&a, 4, 120);
        float map[23 * 17];
        double mean = 0, got;
        assert_int_equal(ap_image_flip(NULL, &a, &b, ppd[k], &got, map), AP_OK);
        for (long y = 0; y < 17; y++)
            for (long x = 0; x < 23; x++) {
                double want = slow_flip(&a, &b, x, y, ppd[k]);
                near("flip of a pixel", (double)map[y * 23 + x], want, 2e-4);
                mean += want / (23 * 17);
            }
        near("flip", got, mean, 2e-5);
        ap_image_finish(&a);
        ap_image_finish(&b);
    }
}

// ---- pictures

static void difference_picture(void **state) {
    (void)state;
    struct ap_image a = picture(5, 4), b = changed(&a, 1000, 1), out;
    memcpy(b.rgb, a.rgb, 60);
    b.rgb[3 * 7] ^= 0x80;
    assert_int_equal(ap_image_difference_picture(NULL, &a, &b, NULL, &out), AP_OK);
    assert_int_equal(out.width, 15);
    assert_int_equal(out.height, 4);
    for (int y = 0; y < 4; y++) {
        assert_memory_equal(out.rgb + 45 * y, a.rgb + 15 * y, 15);
        assert_memory_equal(out.rgb + 45 * y + 15, b.rgb + 15 * y, 15);
        for (int x = 0; x < 5; x++) {
            const uint8_t *p = out.rgb + 45 * y + 30 + 3 * x;
            assert_int_equal(p[0] + p[1] + p[2] > 0, y == 1 && x == 2);
        }
    }
    ap_image_finish(&out);
    ap_image_finish(&a);
    ap_image_finish(&b);
}

static void pam(void **state) {
    (void)state;
    char path[] = "/tmp/antipode-pam-XXXXXX";
    int fd = mkstemp(path);
    assert_true(fd >= 0);
    close(fd);
    const uint8_t bytes[] = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16};
    struct ap_pixels pixels = {bytes, 2, 2, 8, true};
    struct ap_image image;
    assert_int_equal(ap_pam_write_pixels(NULL, path, &pixels, true), AP_OK);
    assert_int_equal(ap_picture_read(NULL, path, &image), AP_OK);
    const uint8_t want[] = {3, 2, 1, 7, 6, 5, 11, 10, 9, 15, 14, 13};
    assert_memory_equal(image.rgb, want, 12);
    ap_image_finish(&image);
    assert_int_equal(ap_png_write_pixels(NULL, path, &pixels, AP_PNG_ALPHA | AP_PNG_LINEAR), AP_OK);
    assert_int_equal(ap_picture_read(NULL, path, &image), AP_OK);
    assert_memory_equal(image.rgb, want, 12);
    ap_image_finish(&image);
    static const char *const bad[] = {
        "",
        "P7",
        "P7\n",
        "P7\nWIDTH 2\nHEIGHT 2\nDEPTH 4\nMAXVAL 255\nENDHDR\n123456789012345",
        "P7\nWIDTH 32768\nHEIGHT 32768\nDEPTH 4\nMAXVAL 255\nENDHDR\n1",
        "P7\nWIDTH -2\nHEIGHT 2\nDEPTH 4\nMAXVAL 255\nENDHDR\n1234567890123456",
        "P7\nWIDTH 99999999999999999999\nHEIGHT 2\nDEPTH 4\nMAXVAL 255\nENDHDR\n",
        "P7\nWIDTH 2\nHEIGHT 2\nDEPTH 2\nMAXVAL 255\nENDHDR\n1234567890123456",
        "P7\nWIDTH 2\nHEIGHT 2\nDEPTH 4\nMAXVAL 65535\nENDHDR\n1234567890123456",
    };
    for (size_t k = 0; k < sizeof bad / sizeof *bad; k++) {
        FILE *f = fopen(path, "wb");
        fputs(bad[k], f);
        fclose(f);
        struct ap_error err = {{0}};
        if (ap_picture_read(&err, path, &image) != AP_INPUT)
            fail_msg("was read: %s", bad[k]);
        assert_non_null(strstr(err.text, path));
    }
    unlink(path);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(psnr_and_ssim),      cmocka_unit_test(the_same),
        cmocka_unit_test(largest_patch),      cmocka_unit_test(flip),
        cmocka_unit_test(difference_picture), cmocka_unit_test(pam),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
