#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "src/device/inputlog.h"
#include "tests/device/memory_file.h"

static struct ap_inputlog *load(const char *first, const char *second) {
    struct memory_file a = memory_text(first), b = memory_text(second ? second : "");
    const char *paths[] = {a.path, b.path};
    struct ap_error err = {""};
    struct ap_inputlog *log = NULL;
    if (ap_inputlog_load(&err, paths, second ? 2 : 1, &log))
        fail_msg("%s", err.text);
    close(a.fd);
    close(b.fd);
    return log;
}

static void is(const struct ap_inputlog *log, const char *device, const char *path, int64_t t_ns,
               double x, double y) {
    float v[2] = {9, 9};
    int c = ap_inputlog_find(log, device, path);
    if (c < 0)
        fail_msg("no channel %s %s", device, path);
    bool any = ap_inputlog_at(log, c, t_ns, v);
    if (!any || v[0] != (float)x || v[1] != (float)y)
        fail_msg("%s %s at %lld: %d %.9g %.9g, expected %.9g %.9g", device, path, (long long)t_ns,
                 any, (double)v[0], (double)v[1], x, y);
}

static void values_hold_until_they_change(void **state) {
    (void)state;
    struct ap_inputlog *log = load("t_ns,device,path,value,value2\n# a comment\n\n"
                                   "-5,left,/input/trigger/value,0.7\r\n"
                                   "10 , right , /input/thumbstick , 0.5 , -0.25\n"
                                   "20,left,/input/trigger/value,0,\n"
                                   "20,right,/input/a/click,1",
                                   NULL);
    assert_int_equal(ap_inputlog_channel_count(log), 3);
    assert_int_equal(ap_inputlog_channel(log, 1).values, 2);
    assert_string_equal(ap_inputlog_channel(log, 2).path, "/input/a/click");
    float v[2] = {9, 9};
    assert_false(ap_inputlog_at(log, 0, -6, v));
    assert_true(v[0] == 9);
    is(log, "left", "/input/trigger/value", -5, 0.7, 0);
    is(log, "left", "/input/trigger/value", 19, 0.7, 0);
    is(log, "left", "/input/trigger/value", 20, 0, 0);
    is(log, "left", "/input/trigger/value", INT64_MAX, 0, 0);
    is(log, "right", "/input/thumbstick", 10, 0.5, -0.25);
    is(log, "right", "/input/a/click", 20, 1, 0);
    assert_int_equal(ap_inputlog_find(log, "left", "/input/a/click"), -1);
    assert_int_equal(ap_inputlog_end_ns(log), 20);
    ap_inputlog_destroy(log);
}

static void files_are_merged_by_time_and_the_later_wins(void **state) {
    (void)state;
    struct ap_inputlog *log =
        load("0,left,/input/x/click,1\n20,left,/input/x/click,0\n40,left,/input/x/click,1\n",
             "10,left,/input/x/click,0\n20,left,/input/x/click,1\n30,left,/input/x/click,0\n");
    const char *path = "/input/x/click";
    is(log, "left", path, 5, 1, 0);
    is(log, "left", path, 10, 0, 0);
    is(log, "left", path, 20, 1, 0);
    is(log, "left", path, 30, 0, 0);
    is(log, "left", path, 40, 1, 0);
    ap_inputlog_destroy(log);
}

static void many_rows_are_found_again(void **state) {
    (void)state;
    enum { N = 5000 };
    char *text = malloc(64 * N);
    assert_non_null(text);
    size_t n = 0;
    for (int i = 0; i < N; i++)
        n += (size_t)sprintf(text + n, "%d,gamepad,/input/trigger_left/value,%.4f\n", 7 * i,
                             i / (double)N);
    struct ap_inputlog *log = load(text, NULL);
    for (int i = 0; i < N; i++)
        is(log, "gamepad", "/input/trigger_left/value", 7 * i + i % 7, i / (double)N, 0);
    ap_inputlog_destroy(log);
    free(text);
}

// WebXR's recorder: a source that has no pad, one that goes and comes, sticks down positive.
static const char iwer[] =
    "{\"schema\": [[0, {\"handedness\": \"left\", \"hasGamepad\": true, \"numButtons\": 6,"
    " \"numAxes\": 4}], [1, {\"handedness\": \"right\", \"hasGamepad\": true, \"numButtons\": 6,"
    " \"numAxes\": 4}], [2, {\"handedness\": \"left\"}]], \"frames\": ["
    "[100.5, 0,0,0, 0,0,0,1, [0, 0,0,0, 0,0,0,1, [[0,1,0.25],[0,0,0],null,[0,1,0],[1,1,1],[0,0,0],"
    " 0,0,0.5,0.25]]],"
    "[110.6, 0,0,0, 0,0,0,1, [1, 0,0,0, 0,0,0,1, [[1,1,1],[0,0,0.5],null,[0,0,0],[0,0,0],[1,1,1],"
    " 0,0,0,0]], [2, 0,0,0, 0,0,0,1]],"
    "[120.6, 0,0,0, 0,0,0,1, [0, 0,0,0, 0,0,0,1, [[0,0,0],[0,0,0],null,[0,1,0],[1,1,1],[0,0,0],"
    " 0,0,0,0]]]]}";

static void webxr_recordings_are_input_logs(void **state) {
    (void)state;
    struct ap_inputlog *log = load(iwer, NULL);
    is(log, "left", "/input/trigger/value", 0, 0.25, 0);
    is(log, "left", "/input/trigger/value", 20099999, 0.25, 0);
    is(log, "left", "/input/trigger/value", 20100000, 0, 0);
    is(log, "left", "/input/thumbstick", 0, 0.5, -0.25);
    is(log, "left", "/input/x/click", 20100000, 1, 0);
    is(log, "right", "/input/trigger/value", 10100000, 1, 0);
    is(log, "right", "/input/squeeze/value", 10100000, 0.5, 0);
    is(log, "right", "/input/b/click", 10100000, 1, 0);
    float v[2];
    assert_false(
        ap_inputlog_at(log, ap_inputlog_find(log, "right", "/input/b/click"), 10099999, v));
    // null, and at rest all the time
    assert_int_equal(ap_inputlog_find(log, "left", "/input/trackpad/click"), -1);
    assert_int_equal(ap_inputlog_find(log, "right", "/input/a/click"), -1);
    ap_inputlog_destroy(log);
}

// A Quest 3, 29 s with the controllers laid away in between.
static void a_real_recording_is_read(void **state) {
    (void)state;
    const char *shared = getenv("ANTIPODE_SHARED");
    char path[4096];
    snprintf(path, sizeof path, "%s/data/poses/quest3_iwer.json", shared ? shared : "");
    if (!shared || access(path, R_OK) != 0) {
        print_message("no recording: ANTIPODE_SHARED is not set\n");
        skip();
    }
    const char *paths[] = {path};
    struct ap_error err;
    struct ap_inputlog *log = NULL;
    if (ap_inputlog_load(&err, paths, 1, &log))
        fail_msg("%s", err.text);
    static const struct {
        const char *device, *path;
        int64_t first_ns;
    } presses[] = {{"right", "/input/b/click", 1187600000},
                   {"right", "/input/a/click", 2132500000}};
    for (size_t i = 0; i < sizeof presses / sizeof *presses; i++) {
        int c = ap_inputlog_find(log, presses[i].device, presses[i].path);
        float v[2];
        assert_true(c >= 0 && !ap_inputlog_at(log, c, presses[i].first_ns - 1, v));
        is(log, presses[i].device, presses[i].path, presses[i].first_ns, 1, 0);
    }
    ap_inputlog_destroy(log);
}

static void bad_lines_are_named(void **state) {
    (void)state;
    static const struct {
        const char *text, *where, *expected;
    } cases[] = {
        {"", ": no input", "t_ns,device,path"},
        {"# nothing\n", ": no input", "t_ns,device,path"},
        {"t_ns,device,px\n", ":1:1:", "the header"},
        {"0,left,/input/x/click\n", ":1:22:", "not 3 fields"},
        {"0,left,/input/x/click,1,0,0\n", ":1:1:", "not 6 fields"},
        {"1.5,left,/input/x/click,1\n", ":1:1:", "whole nanoseconds"},
        {"9000000000000000000,left,/input/x/click,1\n", ":1:1:", "4e18"},
        {"\n0,foot,/input/x/click,1\n", ":2:3:", "left, right, head"},
        {"0,left,input/x/click,1\n", ":1:8:", "a path"},
        {"0,left,/input/,1\n", ":1:8:", "a path"},
        {"0,left,/input//x,1\n", ":1:8:", "a path"},
        {"0,left,/input/x/,1\n", ":1:8:", "a path"},
        {"0,left,/input/X/click,1\n", ":1:8:", "a path"},
        {"0,left,/output/haptic,1\n", ":1:8:", "a path"},
        {"0,left,/input/grip/pose,1\n", ":1:8:", "pose logs"},
        {"0,left,/input/x/click,0.5\n", ":1:23:", "0 or 1"},
        {"0,left,/input/trigger/value,1.1\n", ":1:29:", "from 0 to 1"},
        {"0,left,/input/trigger/value,nan\n", ":1:29:", "from 0 to 1"},
        {"0,left,/input/thumbstick,0.5,-2\n", ":1:30:", "from -1 to 1"},
        {"5,left,/input/x/click,1\n4,left,/input/y/click,1\n", ":2:1:", "not before"},
        {"5,left,/input/x/click,1\n5,left,/input/x/click,0\n", ":2:1:", "not two"},
        {"5,left,/input/p,0.1,0.2\n6,left,/input/p,0.1\n", ":2:8:", "2 values"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct memory_file file = memory_text(cases[i].text);
        const char *path = file.path;
        struct ap_error err = {""};
        struct ap_inputlog *log = NULL;
        assert_int_equal(ap_inputlog_load(&err, &path, 1, &log), AP_INPUT);
        assert_null(log);
        char where[64];
        snprintf(where, sizeof where, "%s%s", file.path, cases[i].where);
        if (!strstr(err.text, where) || !strstr(err.text, cases[i].expected))
            fail_msg("'%s' gave '%s', expected '%s' and '%s'", cases[i].text, err.text, where,
                     cases[i].expected);
        close(file.fd);
    }
}

static void limits_hold(void **state) {
    (void)state;
    char *text = malloc(1 << 17);
    assert_non_null(text);
    size_t n = 0;
    for (int i = 0; i <= AP_INPUT_CHANNELS_MAX; i++)
        n += (size_t)sprintf(text + n, "0,left,/input/b%d/click,1\n", i);
    struct ap_error err = {""};
    struct ap_inputlog *log = NULL;
    struct memory_file file = memory_text(text);
    const char *path = file.path;
    assert_int_equal(ap_inputlog_load(&err, &path, 1, &log), AP_INPUT);
    assert_non_null(strstr(err.text, ":257:8: expected at most 256"));
    close(file.fd);
    memset(text, 'x', (1 << 17) - 1);
    text[(1 << 17) - 1] = '\0';
    file = memory_text(text);
    path = file.path;
    assert_int_equal(ap_inputlog_load(&err, &path, 1, &log), AP_INPUT);
    assert_non_null(strstr(err.text, ":1:65537: expected a line"));
    close(file.fd);
    free(text);
    path = "/no/such/log";
    assert_int_equal(ap_inputlog_load(&err, &path, 1, &log), AP_INPUT);
    assert_non_null(strstr(err.text, "/no/such/log: cannot open"));
    const char *many[AP_INPUT_FILES_MAX + 1] = {path};
    assert_int_equal(ap_inputlog_load(&err, many, AP_INPUT_FILES_MAX + 1, &log), AP_USAGE);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(values_hold_until_they_change),
        cmocka_unit_test(files_are_merged_by_time_and_the_later_wins),
        cmocka_unit_test(many_rows_are_found_again),
        cmocka_unit_test(webxr_recordings_are_input_logs),
        cmocka_unit_test(a_real_recording_is_read),
        cmocka_unit_test(bad_lines_are_named),
        cmocka_unit_test(limits_hold),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
