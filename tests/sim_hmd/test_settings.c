#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "sim_hmd/core/settings.h"
#include "src/base/file.h"

static char dir[] = "/tmp/antipode-test-XXXXXX";
static char path[64];

static int make_dir(void **state) {
    (void)state;
    if (!mkdtemp(dir))
        return -1;
    snprintf(path, sizeof path, "%s/s.json", dir);
    return 0;
}

static int remove_dir(void **state) {
    (void)state;
    unlink(path);
    return rmdir(dir);
}

static enum ap_status read_text(struct ap_error *err, const char *text, struct sim_settings *s) {
    assert_int_equal(ap_file_write(NULL, path, text, strlen(text)), AP_OK);
    return sim_settings_read(err, path, s);
}

static struct sim_settings good(const char *text) {
    struct ap_error err;
    struct sim_settings s;
    if (read_text(&err, text, &s))
        fail_msg("%s", err.text);
    return s;
}

static void bad(const char *text, const char *expected) {
    struct ap_error err;
    struct sim_settings s;
    assert_int_equal(read_text(&err, text, &s), AP_INPUT);
    if (!strstr(err.text, expected) || !strstr(err.text, path) || strchr(err.text, '\n'))
        fail_msg("'%s' gave '%s', expected one line with the file and '%s'", text, err.text,
                 expected);
}

static void defaults_are_the_tables(void **state) {
    (void)state;
    struct sim_settings s;
    assert_int_equal(sim_settings_read(NULL, NULL, &s), AP_OK);
    assert_int_equal(s.poses, SIM_POSES_WALK);
    assert_int_equal(s.clock, SIM_CLOCK_REAL);
    assert_true(s.profile.refresh_hz == ap_headset_builtin().refresh_hz);
    const double rates[] = {60, 72, 80, 90, 120};
    assert_int_equal(s.rate_count, 5);
    assert_memory_equal(s.rates_hz, rates, sizeof rates);
    assert_null(s.capture_dir);
    assert_false(s.window);
    assert_false(sim_settings_captures(&s, 0));
    sim_settings_finish(&s);
    s = good("{}");
    assert_int_equal(s.clock, SIM_CLOCK_REAL);
    sim_settings_finish(&s);
}

static void everything_is_read(void **state) {
    (void)state;
    struct sim_settings s =
        good("{\"poses\": {\"logs\": [\"head=a.csv\", \"/b.csv\", \"x/c=d.csv\"], \"up\": \"z\", "
             "\"head_frame\": \"optical\", \"skip_bad\": true, \"table_at\": [1, 2, 0.5]}, "
             "\"clock\": \"virtual\", \"refresh_hz\": 59.94, \"frames\": 7, "
             "\"capture\": {\"dir\": \"out\", \"frames\": \"2:9:3\"}, \"window\": true}");
    char expected[128];
    assert_int_equal(s.log_count, 3);
    snprintf(expected, sizeof expected, "head=%s/a.csv", dir);
    assert_string_equal(s.logs[0], expected);
    assert_string_equal(s.logs[1], "/b.csv");
    snprintf(expected, sizeof expected, "%s/x/c=d.csv", dir);
    assert_string_equal(s.logs[2], expected);
    assert_true(s.z_up && s.skip_bad && s.has_table && s.window);
    assert_int_equal(s.head_frame, AP_HEAD_FRAME_OPTICAL);
    assert_true(s.table_x_m == 1 && s.table_z_m == 2 && s.table_yaw_rad == 0.5);
    assert_true(s.profile.refresh_hz == 59.94);
    assert_int_equal(s.frames, 7);
    for (int k = 0; k < 12; k++)
        assert_int_equal(sim_settings_captures(&s, k), k == 2 || k == 5 || k == 8);
    sim_settings_finish(&s);
    s = good("{\"poses\": {\"script\": \"walk\", \"table_edge_m\": 1.2, \"table_height_m\": 0.8, "
             "\"duration_s\": 5, \"seed\": 3}}");
    assert_true(s.walk.table_edge_m == 1.2 && s.walk.duration_s == 5 && s.walk.seed == 3);
    sim_settings_finish(&s);
    s = good("{\"strict\": true, \"strict_report\": \"r.jsonl\"}");
    snprintf(expected, sizeof expected, "%s/r.jsonl", dir);
    assert_true(s.strict);
    assert_string_equal(s.strict_report, expected);
    sim_settings_finish(&s);
    s = good("{\"poses\": {\"window\": true}}");
    assert_true(s.poses == SIM_POSES_WINDOW && s.window);
    sim_settings_finish(&s);
    s = good("{\"poses\": {\"window\": true}, \"window\": \"left\"}");
    assert_true(s.poses == SIM_POSES_WINDOW && s.window && s.window_layout == SIM_LAYOUT_LEFT);
    sim_settings_finish(&s);
}

static void capture_outputs(void **state) {
    (void)state;
    struct sim_settings s = good("{\"capture\": {\"dir\": \"x\"}}");
    assert_true(s.capture_composed);
    assert_false(s.capture_layers || s.capture_lens || s.capture_raw || s.capture_log_all);
    sim_settings_finish(&s);
    s = good("{\"capture\": {\"dir\": \"x\", \"composed\": false, \"layers\": true, "
             "\"format\": \"raw\", \"log\": \"all\"}}");
    assert_false(s.capture_composed);
    assert_true(s.capture_layers && s.capture_raw && s.capture_log_all);
    sim_settings_finish(&s);
}

static void errors_name_their_place(void **state) {
    (void)state;
    bad("[]", "expected an object");
    bad("{\"colour\": 1}", "/colour");
    bad("{\"clock\": 3}", "/clock");
    bad("{\"clock\": \"fast\"}", "/clock");
    bad("{\"refresh_hz\": 0}", "/refresh_hz");
    bad("{\"refresh_hz\": -90}", "/refresh_hz");
    bad("{\"refresh_hz\": 1e999}", "s.json");
    bad("{\"refresh_hz\": 1e9}", "/refresh_hz");
    bad("{\"hands\": 3}", "/hands");
    bad("{\"hands\": \"-\"}", "/hands");
    bad("{\"refresh_rates_hz\": []}", "/refresh_rates_hz");
    bad("{\"refresh_rates_hz\": 90}", "/refresh_rates_hz");
    bad("{\"refresh_rates_hz\": [90, \"x\"]}", "/refresh_rates_hz/1");
    bad("{\"refresh_rates_hz\": [0]}", "/refresh_rates_hz/0");
    bad("{\"refresh_rates_hz\": [1,2,3,4,5,6,7,8,9,10,11,12,13,14,15,16]}", "/refresh_rates_hz");
    bad("{\"frames\": 1.5}", "/frames");
    bad("{\"frames\": -1}", "/frames");
    bad("{\"window\": 1}", "/window");
    bad("{\"window\": \"round\"}", "/window");
    bad("{\"strict\": 1}", "/strict");
    bad("{\"strict_report\": \"r\"}", "/strict_report: there is no report without");
    bad("{\"poses\": {}}", "/poses");
    bad("{\"poses\": []}", "/poses");
    bad("{\"poses\": {\"logs\": []}}", "/poses/logs");
    bad("{\"poses\": {\"logs\": [\"a\", 3]}}", "/poses/logs/1");
    bad("{\"poses\": {\"logs\": [\"-\"]}}", "/poses/logs/0");
    bad("{\"poses\": {\"logs\": [\"head=-\"]}}", "/poses/logs/0");
    bad("{\"poses\": {\"logs\": [\"a\"], \"up\": \"x\"}}", "/poses/up");
    bad("{\"poses\": {\"logs\": [\"a\"], \"script\": \"walk\"}}", "/poses/script");
    bad("{\"poses\": {\"logs\": [\"a\"], \"table_at\": [1, 2]}}", "/poses/table_at");
    bad("{\"poses\": {\"script\": \"walk\", \"seed\": -1}}", "/poses/seed");
    bad("{\"capture\": {}}", "/capture/dir");
    bad("{\"capture\": {\"dir\": \"x\", \"frames\": \"::0\"}}", "/capture/frames");
    bad("{\"capture\": {\"dir\": \"x\", \"frames\": \"7\"}}", "/capture/frames");
    bad("{\"capture\": {\"dir\": \"x\", \"frames\": \"-1:\"}}", "/capture/frames");
    bad("{\"capture\": {\"dir\": \"x\", \"layers\": 1}}", "/capture/layers");
    bad("{\"capture\": {\"dir\": \"x\", \"composed\": \"yes\"}}", "/capture/composed");
    bad("{\"capture\": {\"dir\": \"x\", \"format\": \"jpeg\"}}", "/capture/format");
    bad("{\"capture\": {\"dir\": \"x\", \"log\": true}}", "/capture/log");
    bad("{\"capture\": {\"dir\": \"x\", \"lens\": true}}", "/capture/lens: the headset's profile");
    bad("{\"capture\": {\"dir\": \"x\", \"lenses\": true}}", "/capture/lenses");
    bad("{\"headset\": {\"name\": \"x\", \"color\": 1}}", "/headset");
    bad("{\"clock\": \"real\", \"clock\": \"real\"}", "s.json");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(defaults_are_the_tables),
        cmocka_unit_test(everything_is_read),
        cmocka_unit_test(capture_outputs),
        cmocka_unit_test(errors_name_their_place),
    };
    return cmocka_run_group_tests(tests, make_dir, remove_dir);
}
