#include <fcntl.h>
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>
#include <dirent.h>

#include "src/base/file.h"
#include "src/image/image.h"

static char folder[] = "/tmp/antipode-png-XXXXXX";

static const char *at(const char *name) {
    static char path[2][256];
    static int turn;
    turn ^= 1;
    snprintf(path[turn], sizeof path[turn], "%s/%s", folder, name);
    return path[turn];
}

static uint32_t next(uint32_t *state) {
    return *state = *state * 1664525u + 1013904223u;
}

static void noise(struct ap_image *image, uint32_t width, uint32_t height) {
    uint32_t state = width * 7 + height;
    assert_int_equal(ap_image_create(NULL, width, height, image), AP_OK);
    for (size_t k = 0; k < (size_t)width * height * 3; k++)
        image->rgb[k] = (uint8_t)(next(&state) >> 24);
}

static void assert_same(const struct ap_image *a, const struct ap_image *b) {
    assert_int_equal(a->width, b->width);
    assert_int_equal(a->height, b->height);
    assert_memory_equal(a->rgb, b->rgb, (size_t)a->width * a->height * 3);
}

static void round_trip(void **state) {
    (void)state;
    const uint32_t sizes[][2] = {{1, 1}, {3, 2}, {1, 301}, {257, 1}, {320, 200}};
    for (size_t k = 0; k < sizeof sizes / sizeof sizes[0]; k++) {
        struct ap_image out, in;
        struct ap_error err = {{0}};
        noise(&out, sizes[k][0], sizes[k][1]);
        assert_int_equal(ap_png_write(&err, at("a.png"), &out), AP_OK);
        if (ap_png_read(&err, at("a.png"), &in))
            fail_msg("%s", err.text);
        assert_same(&out, &in);
        ap_image_finish(&out);
        ap_image_finish(&in);
    }
}

static void from_pixels(void **state) {
    (void)state;
    enum { W = 5, H = 3, STRIDE = 24 };
    uint8_t bytes[STRIDE * H];
    for (int k = 0; k < STRIDE * H; k++)
        bytes[k] = (uint8_t)(k * 3 + 1);
    for (int bgra = 0; bgra < 2; bgra++) {
        struct ap_pixels pixels = {bytes, W, H, STRIDE, bgra != 0};
        struct ap_image in;
        assert_int_equal(ap_png_write_pixels(NULL, at("p.png"), &pixels, 0), AP_OK);
        assert_int_equal(ap_png_read(NULL, at("p.png"), &in), AP_OK);
        for (int y = 0; y < H; y++)
            for (int x = 0; x < W; x++)
                for (int c = 0; c < 3; c++)
                    assert_int_equal(in.rgb[(y * W + x) * 3 + c],
                                     bytes[y * STRIDE + 4 * x + (bgra ? 2 - c : c)]);
        ap_image_finish(&in);
    }
    struct ap_pixels bad = {bytes, W, H, 4 * W - 1, false};
    assert_int_equal(ap_png_write_pixels(NULL, at("q.png"), &bad, 0), AP_INPUT);
    bad.width = 0;
    assert_int_equal(ap_png_write_pixels(NULL, at("q.png"), &bad, 0), AP_INPUT);
    assert_false(ap_file_exists(at("q.png")));
}

// Two writes agree byte for byte, and nothing in the file tells the time.
static void same_bytes(void **state) {
    (void)state;
    struct ap_image image;
    char *a, *b;
    size_t n, m;
    noise(&image, 64, 48);
    assert_int_equal(ap_png_write(NULL, at("a.png"), &image), AP_OK);
    assert_int_equal(ap_png_write(NULL, at("b.png"), &image), AP_OK);
    assert_int_equal(ap_file_read(NULL, at("a.png"), 1 << 20, &a, &n), AP_OK);
    assert_int_equal(ap_file_read(NULL, at("b.png"), 1 << 20, &b, &m), AP_OK);
    assert_int_equal(n, m);
    assert_memory_equal(a, b, n);
    assert_null(memmem(a, n, "tIME", 4));
    assert_null(memmem(a, n, "tEXt", 4));
    assert_non_null(memmem(a, n, "sRGB", 4));
    free(a);
    free(b);
    ap_image_finish(&image);
}

static int files_in_folder(void) {
    DIR *dir = opendir(folder);
    int n = 0;
    assert_non_null(dir);
    while (readdir(dir))
        n++;
    closedir(dir);
    return n - 2;
}

// A file-size limit stands for the full disk: no half file, no left-over part, the system's reason.
static void full_disk(void **state) {
    (void)state;
    struct ap_image image;
    struct ap_error err = {{0}};
    noise(&image, 200, 200);
    int before = files_in_folder();
    signal(SIGXFSZ, SIG_IGN);
    struct rlimit old, small;
    getrlimit(RLIMIT_FSIZE, &old);
    small = old;
    small.rlim_cur = 10000;
    setrlimit(RLIMIT_FSIZE, &small);
    enum ap_status st = ap_png_write(&err, at("full.png"), &image);
    setrlimit(RLIMIT_FSIZE, &old);
    assert_int_equal(st, AP_ENVIRONMENT);
    assert_non_null(strstr(err.text, "full.png"));
    assert_non_null(strstr(err.text, "File too large"));
    assert_int_equal(files_in_folder(), before);
    assert_int_equal(ap_png_write(&err, "/nowhere/at/all.png", &image), AP_ENVIRONMENT);
    ap_image_finish(&image);
}

static uint32_t crc(const uint8_t *p, size_t n) {
    uint32_t c = 0xffffffffu;
    for (size_t k = 0; k < n; k++) {
        c ^= p[k];
        for (int b = 0; b < 8; b++)
            c = c & 1 ? 0xedb88320u ^ (c >> 1) : c >> 1;
    }
    return ~c;
}

// Writes a small picture's file, changed, and expects a refusal that names it.
static void refuse(const char *bytes, size_t n) {
    struct ap_image in = {.width = 7, .height = 7};
    struct ap_error err = {{0}};
    assert_int_equal(ap_file_write(NULL, at("bad.png"), bytes, n), AP_OK);
    assert_int_equal(ap_png_read(&err, at("bad.png"), &in), AP_INPUT);
    assert_non_null(strstr(err.text, "bad.png"));
    assert_int_equal(in.width, 7);
    assert_null(in.rgb);
}

static void hostile(void **state) {
    (void)state;
    struct ap_image image;
    char *bytes;
    size_t n;
    noise(&image, 20, 10);
    assert_int_equal(ap_png_write(NULL, at("a.png"), &image), AP_OK);
    assert_int_equal(ap_file_read(NULL, at("a.png"), 1 << 20, &bytes, &n), AP_OK);
    for (size_t cut = 0; cut < n - 12; cut += 3)
        refuse(bytes, cut);
    char *changed = malloc(n);
    // Sizes that would take gigabytes, with a right checksum.
    const uint32_t sizes[][2] = {{32768, 32768}, {0x7fffffff, 0x7fffffff}, {32769, 1}, {0, 5}};
    for (size_t k = 0; k < 4; k++) {
        memcpy(changed, bytes, n);
        for (int b = 0; b < 4; b++) {
            changed[16 + b] = (char)(sizes[k][0] >> (24 - 8 * b));
            changed[20 + b] = (char)(sizes[k][1] >> (24 - 8 * b));
        }
        uint32_t c = crc((uint8_t *)changed + 12, 17);
        for (int b = 0; b < 4; b++)
            changed[29 + b] = (char)(c >> (24 - 8 * b));
        refuse(changed, n);
    }
    // Any byte may be anything; what comes back is a picture of a sane size or an error.
    uint32_t seed = 1;
    for (int k = 0; k < 2000; k++) {
        struct ap_image in = {0};
        memcpy(changed, bytes, n);
        for (int t = 0; t < 3; t++)
            changed[next(&seed) % n] = (char)(next(&seed) >> 24);
        assert_int_equal(ap_file_write(NULL, at("bad.png"), changed, n), AP_OK);
        if (ap_png_read(NULL, at("bad.png"), &in) == AP_OK)
            assert_true(in.width <= 32768 && in.height <= 32768);
        ap_image_finish(&in);
    }
    assert_int_equal(ap_png_read(NULL, at("absent.png"), &image), AP_INPUT);
    free(changed);
    free(bytes);
    ap_image_finish(&image);
}

static void bad_sizes(void **state) {
    (void)state;
    struct ap_image image = {0};
    assert_int_equal(ap_image_create(NULL, 0, 5, &image), AP_INPUT);
    assert_int_equal(ap_image_create(NULL, 5, 0, &image), AP_INPUT);
    assert_int_equal(ap_image_create(NULL, 32769, 5, &image), AP_INPUT);
    assert_int_equal(ap_image_create(NULL, 5, UINT32_MAX, &image), AP_INPUT);
    assert_null(image.rgb);
    ap_image_finish(&image);
}

static int clean(void **state) {
    (void)state;
    const char *names[] = {"a.png", "b.png", "p.png", "bad.png"};
    for (size_t k = 0; k < 4; k++)
        unlink(at(names[k]));
    return rmdir(folder);
}

int main(void) {
    if (!mkdtemp(folder))
        return 1;
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(round_trip), cmocka_unit_test(from_pixels), cmocka_unit_test(same_bytes),
        cmocka_unit_test(full_disk),  cmocka_unit_test(hostile),     cmocka_unit_test(bad_sizes),
    };
    return cmocka_run_group_tests(tests, NULL, clean);
}
