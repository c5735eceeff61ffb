#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "src/device/timeline.h"
#include "tests/device/memory_file.h"

// Recordings made by hand, through the pose-log reader: which rows come out, and what is said
// where none can.

// A sensor with a quaternion of 16-bit values, and turns of it by nothing and a quarter to the
// left.
#define SENSOR "R: 16 05 20 09 8e a1 01 0a 83 04 75 10 95 04 81 02 c0\n"
#define AHEAD " 8 00 00 00 00 00 00 ff 7f\n"
#define LEFTWARD " 8 00 00 00 00 82 5a 82 5a\n"

static char rows[2048], error[AP_ERROR_TEXT_MAX];
static int64_t skipped;

// To two digits, without a sign for what is nothing.
static double two(double v) {
    return round(v * 100) / 100 + 0.0;
}

static void add_row(const struct ap_poselog *log, const struct ap_sample *s) {
    size_t n = strlen(rows);
    snprintf(rows + n, sizeof rows - n, "%lld %s %.2f %.2f %.2f %.2f %.2f;", (long long)s->t_ns,
             ap_poselog_device_name(log, s->device), two(s->pose.p.x), two(s->pose.p.y),
             two(s->pose.p.z), two(s->pose.q.y), two(s->pose.q.w));
}

static void hide_path(const char *path) {
    char *at = strstr(error, path);
    if (at) {
        memmove(at + 4, at + strlen(path), strlen(at + strlen(path)) + 1);
        memcpy(at, "FILE", 4);
    }
}

static void read_text(const char *role, const char *text, bool skip_bad) {
    struct memory_file file = memory_text(text);
    char source[64];
    snprintf(source, sizeof source, "%s%s", role, file.path);
    const char *sources[] = {source};
    struct ap_poselog_params params = {.sources = sources, .source_count = 1, .skip_bad = skip_bad};
    struct ap_error err = {""};
    struct ap_poselog *log = NULL;
    rows[0] = 0;
    enum ap_status st = ap_poselog_open(&err, &params, &log);
    for (bool got = true; !st && got;) {
        struct ap_sample s;
        st = ap_poselog_next(&err, log, &s, &got);
        if (!st && got)
            add_row(log, &s);
    }
    skipped = log ? ap_poselog_skipped(log) : 0;
    snprintf(error, sizeof error, "%s", st ? err.text : "");
    hide_path(file.path);
    ap_poselog_close(log);
    close(file.fd);
}

static void check_rows(const char *role, const char *text, const char *want) {
    read_text(role, text, false);
    assert_string_equal(error, "");
    assert_string_equal(rows, want);
}

static void check_error(const char *role, const char *text, const char *part) {
    read_text(role, text, false);
    if (!strstr(error, part))
        fail_msg("'%s' lacks '%s'", error, part);
}

// Head, hand and other things stand where a body has them.
static void test_roles(void **unused) {
    (void)unused;
    static const char text[] = "# c\n" SENSOR "E: 1.000001" AHEAD "E: 000001.500000" LEFTWARD;
    check_rows("", text,
               "1000001000 head 0.00 1.58 -0.08 0.00 1.00;"
               "1500000000 head -0.08 1.58 0.00 0.71 0.71;");
    check_rows("right=", text,
               "1000001000 right 0.20 1.05 -0.35 0.00 1.00;"
               "1500000000 right -0.15 1.05 0.00 0.71 0.71;");
    check_rows("left=", text,
               "1000001000 left -0.20 1.05 -0.35 0.00 1.00;"
               "1500000000 left -0.55 1.05 0.00 0.71 0.71;");
    check_rows("cue=", text,
               "1000001000 cue 0.00 1.00 0.00 0.00 1.00;"
               "1500000000 cue 0.00 1.00 0.00 0.71 0.71;");
}

// Lines belong to the device of the D: line before them; letters that nobody knows are nothing.
static void test_devices(void **unused) {
    (void)unused;
    static const char text[] =
        "D: 3\n" SENSOR "N: one\nP:\nI: 5 054c 0df0\nX: what ever\nD: 0\n" SENSOR
        "D: 7\nN: no driver\nE: 0 1 00\nD: 0\nE: 0.25" LEFTWARD "D: 3\nE: 0.25" AHEAD
        "D: 7\nE: 1 2 00 01\nD: 0\nE: 1" AHEAD;
    check_rows("", text,
               "250000000 head -0.08 1.58 0.00 0.71 0.71;"
               "250000000 left -0.20 1.05 -0.35 0.00 1.00;"
               "1000000000 head 0.00 1.58 -0.08 0.00 1.00;");
    check_error("left=", text, "expected only the device 'head', because left= renames it");
}

// A cap's two reports of one time are one row.
static void test_cap(void **unused) {
    (void)unused;
    static const char text[] =
        "R: 45 05 01 09 08 a1 01 15 81 25 7f 75 08 95 03 85 01 09 30 09 31 09 32 81 06 "
        "85 02 09 33 09 34 09 35 81 06 85 03 05 09 09 01 95 01 81 02 c0\n"
        "E: 1 4 01 7f 00 00\nE: 1 4 02 00 00 00\nE: 1.05 4 01 00 00 00\n";
    check_rows("", text,
               "1000000000 head 0.00 1.58 -0.08 0.00 1.00;"
               "1050000000 head 0.05 1.58 -0.08 0.00 1.00;");
}

static void test_bad_lines(void **unused) {
    (void)unused;
    check_error("", "R: 3 01 02\n", "FILE:1:11: expected 3 bytes as the line says, not 2");
    check_error("", "R: 1 01 02\n", "FILE:1:9: expected the line to end after 1 bytes");
    check_error("", "R: 1 1g\n", "FILE:1:6: expected a byte in hexadecimal");
    check_error("", "R: 99999999999 1g\n", "FILE:1:4: expected a number of bytes, 0 to 16384");
    check_error("", "R: 0\n", "FILE:1:1: expected a descriptor without fault");
    check_error("", "I: 5 54c\n", "FILE:1:9: expected bus, vendor and product");
    check_error("", "I: 5 54c 12345\n", "FILE:1:10: expected bus, vendor and product");
    check_error("", "D: x\n", "FILE:1:4: expected the number of a device");
    check_error("", SENSOR "E: 1,5" AHEAD, "FILE:2:4: expected the time in decimal seconds");
    check_error("", SENSOR "hello\n", "FILE:2:1: expected a letter and a colon");
    check_error("", SENSOR "E: 2" AHEAD "E: 1" AHEAD, "FILE:3:4: expected a time not before");
    check_error("", SENSOR "E: 2" AHEAD "E: 2" AHEAD, "FILE:3:4: expected a time after");
    check_error("", SENSOR "E: 86402" AHEAD "E: 2" AHEAD, "FILE:3:4: expected a time not before");
    // Shorter than the descriptor says, and a quaternion of nothing.
    check_error("", SENSOR "E: 2 7 1 2 3 4 5 6 7\n", "FILE:2:8: expected a report of 8 bytes");
    check_error("", SENSOR "E: 2 8 0 0 0 0 0 0 0 0\n", "a quaternion that is not zero");
    // What stands before the line that tells the format is looked at, too.
    check_error("", "# F: 2 00\n" SENSOR, "FILE:1:10: expected 2 bytes as the line says, not 1");
    check_rows("", "# F: 2 00\n0 0 0 0 0 0 0 1\n", "0 head 0.00 0.00 0.00 0.00 1.00;");
    check_error("", "N: A thing\nI: 3 1234 5678\nE: 0 1 00\n",
                "FILE: no driver for 'A thing' (bus 3, 1234:5678); there is one for: android");
    check_error("", SENSOR "N: A sensor\nE: 0 2 01 02\n", "a report of 8 bytes");
    check_error("", "N: A stick\nI: 5 057e 2006\nE: 0 2 3f 00\nE: 1 2 3f 00\n",
                "FILE: none of 2 reports says where a tracker is (A stick, driver joycon)");
    read_text("", "# F: 2 00\n" SENSOR "E: 1" AHEAD "E: 0" AHEAD "E: 2 1 00\nE: 3" AHEAD "zap\n",
              true);
    assert_string_equal(error, "");
    assert_int_equal(skipped, 4);
    assert_string_equal(rows, "1000000000 head 0.00 1.58 -0.08 0.00 1.00;"
                              "3000000000 head 0.00 1.58 -0.08 0.00 1.00;");
}

// A rotation vector of three bytes and a reset counter, which changes at the third report.
static void test_reset(void **unused) {
    (void)unused;
    struct memory_file file = memory_text(
        "R: 29 05 20 09 e1 a1 01 0a 44 05 15 81 25 7f 75 08 95 03 81 02 0a 46 05 15 00 95 01 81 02 "
        "c0\nE: 1.00 4 00 00 00 05\nE: 1.02 4 01 00 00 05\nE: 1.04 4 00 00 03 06\n"
        "E: 1.06 4 00 00 03 06\n");
    const char *source = file.path;
    struct ap_poselog_params params = {.sources = &source, .source_count = 1};
    struct ap_poselog *log = NULL;
    struct ap_timeline *t = NULL;
    struct ap_error err = {""};
    if (ap_poselog_open(&err, &params, &log) || ap_timeline_load(&err, log, &t))
        fail_msg("%s", err.text);
    static const enum ap_pose_state want[] = {
        AP_POSE_EXACT, AP_POSE_INTERPOLATED, AP_POSE_EXACT, AP_POSE_LOST,
        AP_POSE_EXACT, AP_POSE_INTERPOLATED, AP_POSE_EXACT};
    for (int i = 0; i < 7; i++) {
        struct ap_sample s;
        enum ap_pose_state got = ap_timeline_at(t, 0, 1000000000 + i * INT64_C(10000000), &s);
        if (got != want[i])
            fail_msg("%d ms: %s, expected %s", 10 * i, ap_pose_state_name(got),
                     ap_pose_state_name(want[i]));
    }
    ap_timeline_destroy(t);
    ap_poselog_close(log);
    close(file.fd);
}

static void test_many_devices(void **unused) {
    (void)unused;
    static char text[65 * 128];
    text[0] = 0;
    for (int i = 0; i < 64; i++)
        sprintf(text + strlen(text), "D: %d\n%sE: 0%s", i, SENSOR, AHEAD);
    read_text("", text, false);
    assert_string_equal(error, "");
    assert_non_null(strstr(rows, "0 right "));
    assert_non_null(strstr(rows, "0 tracker4 "));
    strcat(text, "D: 64\n");
    check_error("", text, "FILE:193:1: expected at most 64 devices in a recording");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_roles), cmocka_unit_test(test_devices),
        cmocka_unit_test(test_cap),   cmocka_unit_test(test_bad_lines),
        cmocka_unit_test(test_reset), cmocka_unit_test(test_many_devices),
    };
    return cmocka_run_group_tests_name("hid-report-log", tests, NULL, NULL);
}
