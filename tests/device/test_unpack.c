#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>
#include <zlib.h>
#include <zstd.h>

#include "src/device/handlog.h"
#include "src/device/inputlog.h"
#include "src/device/log/line_reader.h"
#include "src/device/poselog.h"
#include "tests/device/memory_file.h"

// Packed logs: what comes out is what went in, of one file or several in a row; what is cut or
// damaged is an error, never half a log.

enum { LINES = 20000, TEXT_MAX = LINES * 48, PACKED_MAX = TEXT_MAX + 4096 };

static char text[TEXT_MAX];
static size_t text_len;
static unsigned char packed[2 * PACKED_MAX];

static int make_text(void **unused) {
    (void)unused;
    for (int i = 0; i < LINES; i++)
        text_len += (size_t)snprintf(text + text_len, sizeof text - text_len,
                                     "%d.5 %d.25 1.5 2 0 0 0 %s1\n", i, i % 977, i % 3 ? "" : "-");
    return 0;
}

static size_t gzip(const void *bytes, size_t len, unsigned char *out, int level) {
    z_stream z = {0};
    assert_int_equal(deflateInit2(&z, level, Z_DEFLATED, 15 + 16, 8, Z_DEFAULT_STRATEGY), Z_OK);
    z.next_in = (Bytef *)(uintptr_t)bytes;
    z.avail_in = (unsigned)len;
    z.next_out = out;
    z.avail_out = PACKED_MAX;
    assert_int_equal(deflate(&z, Z_FINISH), Z_STREAM_END);
    deflateEnd(&z);
    return PACKED_MAX - z.avail_out;
}

static size_t zstd(const void *bytes, size_t len, unsigned char *out, int level) {
    ZSTD_CCtx *c = ZSTD_createCCtx();
    assert_non_null(c);
    ZSTD_CCtx_setParameter(c, ZSTD_c_compressionLevel, level);
    ZSTD_CCtx_setParameter(c, ZSTD_c_checksumFlag, 1); // as the command line does
    size_t n = ZSTD_compress2(c, out, PACKED_MAX, bytes, len);
    ZSTD_freeCCtx(c);
    assert_false(ZSTD_isError(n));
    return n;
}

typedef size_t pack_fn(const void *, size_t, unsigned char *, int);
static pack_fn *const packers[] = {gzip, zstd};

// The whole file, read through the lines' reader.
static enum ap_status read_all(size_t len, struct ap_error *err, char **bytes, size_t *got) {
    struct memory_file file = memory_file(packed, len);
    struct ap_line_reader reader;
    enum ap_status st = ap_line_reader_open(err, &reader, file.path);
    if (!st)
        st = ap_line_reader_rest(err, &reader, TEXT_MAX * 2, bytes, got);
    ap_line_reader_close(&reader);
    close(file.fd);
    return st;
}

static void check_text(size_t len, int copies) {
    struct ap_error err;
    char *bytes = NULL;
    size_t got = 0;
    if (read_all(len, &err, &bytes, &got))
        fail_msg("%s", err.text);
    assert_int_equal(got, text_len * (size_t)copies);
    for (int i = 0; i < copies; i++)
        assert_memory_equal(bytes + text_len * (size_t)i, text, text_len);
    free(bytes);
}

static void test_whole(void **unused) {
    (void)unused;
    for (int p = 0; p < 2; p++)
        for (int level = 1; level <= 9; level += 4) {
            size_t n = packers[p](text, text_len, packed, level);
            check_text(n, 1);
            size_t more = packers[p](text, text_len, packed + n, 10 - level);
            check_text(n + more, 2);
        }
    size_t n = gzip(text, 0, packed, 6); // nothing, and then something
    check_text(n + gzip(text, text_len, packed + n, 6), 1);
    memcpy(packed, text, text_len);
    check_text(text_len, 1);
}

static void test_cut(void **unused) {
    (void)unused;
    for (int p = 0; p < 2; p++) {
        size_t n = packers[p](text, text_len, packed, 6);
        for (size_t len = 4; len < n; len += 1 + n / 97) {
            struct ap_error err = {""};
            char *bytes = NULL;
            size_t got;
            assert_int_equal(read_all(len, &err, &bytes, &got), AP_INPUT);
            assert_null(bytes);
            if (!strstr(err.text, "cannot unpack: it ends too early"))
                fail_msg("cut at %zu: '%s'", len, err.text);
        }
    }
}

static void test_damaged(void **unused) {
    (void)unused;
    for (int p = 0; p < 2; p++) {
        size_t n = packers[p](text, text_len, packed, 6);
        int refused = 0, tried = 0;
        for (size_t at = 4; at < n; at += 1 + n / 211) {
            struct ap_error err = {""};
            char *bytes = NULL;
            size_t got = 0;
            packed[at] ^= 0x55;
            tried++;
            enum ap_status st = read_all(n, &err, &bytes, &got);
            refused += st == AP_INPUT;
            free(bytes);
            packed[at] ^= 0x55;
        }
        print_message("%s: %d of %d changed bytes refused\n", p ? "zstd" : "gzip", refused, tried);
        assert_true(refused > tried * 9 / 10); // names and times in headers may be anything
    }
    struct ap_error err;
    char *bytes = NULL;
    size_t got, n = gzip(text, text_len, packed, 6);
    memcpy(packed + n, "behind it", 9);
    assert_int_equal(read_all(n + 9, &err, &bytes, &got), AP_INPUT);
}

// Much out of little: a bound holds, and nothing is kept of it.
static void test_bound(void **unused) {
    (void)unused;
    static char zeros[TEXT_MAX];
    struct ap_error err = {""};
    char *bytes = NULL;
    size_t got, n = 0;
    for (int i = 0; i < 40; i++)
        n += zstd(zeros, sizeof zeros, packed + n, 3);
    assert_in_range(n, 1, 40 * 200);
    assert_int_equal(read_all(n, &err, &bytes, &got), AP_INPUT);
    assert_non_null(strstr(err.text, "larger than"));
    // A window of 1 GiB is asked for in a header of few bytes.
    static const unsigned char huge[] = {0x28, 0xb5, 0x2f, 0xfd, 0x00, 0xa0, 0x01, 0x00, 0x00};
    memcpy(packed, huge, sizeof huge);
    assert_int_equal(read_all(sizeof huge, &err, &bytes, &got), AP_INPUT);
    assert_non_null(strstr(err.text, "cannot unpack"));
}

static int poses_in(const char *path) {
    struct ap_poselog_params params = {.sources = &path, .source_count = 1};
    struct ap_poselog *log = NULL;
    struct ap_error err;
    int n = 0;
    if (ap_poselog_open(&err, &params, &log))
        fail_msg("%s", err.text);
    for (bool got = true; got;) {
        struct ap_sample sample;
        if (ap_poselog_next(&err, log, &sample, &got))
            fail_msg("%s", err.text);
        n += got;
    }
    ap_poselog_close(log);
    return n;
}

// Every reader of logs takes them: lines, documents, hands and inputs.
static void test_readers(void **unused) {
    (void)unused;
    static const char iwer[] =
        "{\"schema\": [[0, {\"handedness\": \"left\", \"hasGamepad\": true, \"numButtons\": 1, "
        "\"numAxes\": 0}]], \"frames\": [[5, 1, 2, 3, 0, 0, 0, 1, [0, 1, 2, 3, 0, 0, 0, 1, "
        "[[1, 1, 1]]]]]}";
    static const char hands[] = "nothing that a hand could be";
    for (int p = 0; p < 2; p++) {
        size_t n = packers[p](text, text_len, packed, 6);
        struct memory_file file = memory_file(packed, n);
        assert_int_equal(poses_in(file.path), LINES);
        close(file.fd);
        n = packers[p](iwer, sizeof iwer - 1, packed, 6);
        file = memory_file(packed, n);
        assert_int_equal(poses_in(file.path), 2);
        struct ap_error err = {""};
        struct ap_inputlog *inputs = NULL;
        const char *path = file.path;
        if (ap_inputlog_load(&err, &path, 1, &inputs))
            fail_msg("%s", err.text);
        assert_int_equal(ap_inputlog_channel_count(inputs), 2); // value and touch
        ap_inputlog_destroy(inputs);
        struct ap_handlog *hand = NULL;
        assert_int_equal(ap_handlog_read(&err, path, &hand), AP_INPUT);
        assert_non_null(strstr(err.text, "holds no hand"));
        close(file.fd);
        n = packers[p](hands, sizeof hands - 1, packed, 6);
        file = memory_file(packed, n);
        assert_int_equal(ap_handlog_read(&err, file.path, &hand), AP_INPUT);
        assert_null(strstr(err.text, "unpack"));
        close(file.fd);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_whole),   cmocka_unit_test(test_cut),
        cmocka_unit_test(test_damaged), cmocka_unit_test(test_bound),
        cmocka_unit_test(test_readers),
    };
    return cmocka_run_group_tests(tests, make_text, NULL);
}
