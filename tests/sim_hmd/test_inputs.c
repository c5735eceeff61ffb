#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include <string.h>

#include "sim_hmd/core/settings.h"
#include "sim_hmd/input/source.h"
#include "sim_hmd/input/log_inputs.h"
#include "src/device/walk.h"
#include "tests/device/memory_file.h"

// Input logs and the controllers that they drive.

static struct ap_inputlog *load(const char *text) {
    struct memory_file file = memory_text(text);
    const char *path = file.path;
    struct ap_error err;
    struct ap_inputlog *log = NULL;
    if (ap_inputlog_load(&err, &path, 1, &log))
        fail_msg("%s", err.text);
    close(file.fd);
    return log;
}

static const struct sim_component *component(const char *profile, const char *path, int *top) {
    char whole[128];
    snprintf(whole, sizeof whole, "/interaction_profiles/%s", profile);
    int p = sim_profile_find(whole);
    assert_true(p >= 0);
    const struct sim_component *c = sim_profile_component(p, path, SIM_VEC2, top);
    assert_non_null(c);
    return c;
}

static void reads(const struct ap_inputlog *log, const char *profile, const char *path, double x,
                  double y) {
    int top;
    const struct sim_component *c = component(profile, path, &top);
    float v[2] = {9, 9};
    bool any = sim_inputs_at(log, c, top, 0, v);
    if (!any || v[0] != (float)x || v[1] != (float)y)
        fail_msg("%s of %s: %d %.9g %.9g, expected %.9g %.9g", path, profile, any, (double)v[0],
                 (double)v[1], x, y);
}

static void silent(const struct ap_inputlog *log, const char *profile, const char *path) {
    int top;
    const struct sim_component *c = component(profile, path, &top);
    float v[2];
    if (sim_inputs_at(log, c, top, 0, v))
        fail_msg("%s of %s reads %.9g", path, profile, (double)v[0]);
}

static void one_log_drives_many_kinds(void **state) {
    (void)state;
    struct ap_inputlog *log = load("0,left,/input/trigger/value,0.75\n"
                                   "0,left,/input/squeeze/click,1\n"
                                   "0,left,/input/thumbstick,0.5,-0.25\n"
                                   "0,right,/input/trackpad/x,-1\n"
                                   "0,right,/input/trigger,0.25\n"
                                   "0,right,/input/a,1\n"
                                   "1,right,/input/b/click,1\n");
    reads(log, "oculus/touch_controller", "/user/hand/left/input/trigger/value", 0.75, 0);
    reads(log, "oculus/touch_controller", "/user/hand/left/input/squeeze/value", 1, 0);
    reads(log, "oculus/touch_controller", "/user/hand/left/input/thumbstick", 0.5, -0.25);
    reads(log, "oculus/touch_controller", "/user/hand/left/input/thumbstick/y", -0.25, 0);
    reads(log, "oculus/touch_controller", "/user/hand/right/input/a/click", 1, 0);
    silent(log, "oculus/touch_controller", "/user/hand/right/input/b/click"); // not yet
    silent(log, "oculus/touch_controller", "/user/hand/right/input/thumbstick");
    reads(log, "htc/vive_controller", "/user/hand/left/input/trigger/click", 1, 0);
    reads(log, "htc/vive_controller", "/user/hand/right/input/trigger/click", 0, 0);
    reads(log, "htc/vive_controller", "/user/hand/right/input/trackpad", -1, 0);
    reads(log, "khr/simple_controller", "/user/hand/left/input/select/click", 1, 0);
    reads(log, "khr/simple_controller", "/user/hand/right/input/select/click", 0, 0);
    silent(log, "khr/simple_controller", "/user/hand/left/input/menu/click");
    ap_inputlog_destroy(log);
    log = load("0,left,/input/select/click,1\n");
    reads(log, "oculus/touch_controller", "/user/hand/left/input/trigger/value", 1, 0);
    reads(log, "htc/vive_controller", "/user/hand/left/input/trigger/click", 1, 0);
    silent(log, "oculus/touch_controller", "/user/hand/left/input/trigger/touch");
    silent(log, "oculus/touch_controller", "/user/hand/left/input/squeeze/value");
    ap_inputlog_destroy(log);
}

static void what_is_said_goes_before_what_follows(void **state) {
    (void)state;
    struct ap_inputlog *log = load("0,left,/input/trigger/value,0.75\n"
                                   "0,left,/input/trigger/click,0\n"
                                   "0,left,/input/select/click,0\n"
                                   "0,right,/input/trackpad,0.5,0.5\n"
                                   "0,right,/input/trackpad/x,-1\n");
    reads(log, "valve/index_controller", "/user/hand/left/input/trigger/click", 0, 0);
    reads(log, "valve/index_controller", "/user/hand/left/input/trigger/value", 0.75, 0);
    reads(log, "khr/simple_controller", "/user/hand/left/input/select/click", 0, 0);
    reads(log, "valve/index_controller", "/user/hand/right/input/trackpad", 0.5, 0.5);
    reads(log, "valve/index_controller", "/user/hand/right/input/trackpad/x", -1, 0);
    ap_inputlog_destroy(log);
}

static void a_profile_knows_what_it_hears(void **state) {
    (void)state;
    struct ap_inputlog *log = load("0,left,/input/trigger/value,0\n"
                                   "0,left,/input/a/click,0\n"
                                   "0,left,/input/thumbstick/x,0\n"
                                   "0,gamepad,/input/a/click,0\n");
    static const struct {
        const char *profile;
        bool heard[4];
    } cases[] = {
        {"/interaction_profiles/oculus/touch_controller", {true, false, true, false}},
        {"/interaction_profiles/valve/index_controller", {true, true, true, false}},
        {"/interaction_profiles/khr/simple_controller", {true, false, false, false}},
        {"/interaction_profiles/microsoft/xbox_controller", {false, false, false, true}},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        for (int c = 0; c < 4; c++)
            if (sim_inputs_heard(log, c, sim_profile_find(cases[i].profile)) != cases[i].heard[c])
                fail_msg("%s, %s: expected %d", cases[i].profile, ap_inputlog_channel(log, c).path,
                         cases[i].heard[c]);
    ap_inputlog_destroy(log);
}

// The settings' list, and the clock: log time 5 s is the session's first frame.
static void inputs_have_the_pose_logs_clock(void **state) {
    (void)state;
    struct memory_file poses = memory_text("t_ns,device,px,py,pz,qx,qy,qz,qw\n"
                                           "5000000000,head,0,1.6,0,0,0,0,1\n"
                                           "6000000000,head,0,1.6,0,0,0,0,1\n");
    struct memory_file inputs = memory_text("5000000000,left,/input/trigger/value,0.25\n"
                                            "5500000000,left,/input/trigger/value,0.5\n");
    char text[256];
    snprintf(text, sizeof text, "{\"poses\": {\"logs\": [\"%s\"]}, \"inputs\": [\"%s\"]}",
             poses.path, inputs.path);
    struct memory_file file = memory_text(text);
    struct ap_error err;
    struct sim_settings settings;
    struct sim_source *source = NULL;
    if (sim_settings_read(&err, file.path, &settings) ||
        sim_source_create(&err, &settings, &source))
        fail_msg("%s", err.text);
    int top;
    const struct sim_component *trigger =
        component("oculus/touch_controller", "/user/hand/left/input/trigger/value", &top);
    float v[2];
    sim_source_start(source, 700, 0);
    assert_false(sim_source_component(source, trigger, top, 699, v));
    assert_true(sim_source_component(source, trigger, top, 700, v));
    assert_true(v[0] == 0.25f);
    assert_true(sim_source_component(source, trigger, top, 500000699, v));
    assert_true(v[0] == 0.25f);
    assert_true(sim_source_component(source, trigger, top, 500000700, v));
    assert_true(v[0] == 0.5f);
    sim_source_destroy(source);
    sim_settings_finish(&settings);
    close(poses.fd);
    close(inputs.fd);
    close(file.fd);
}

// What is evaluated ahead and remembered is what is evaluated when it is asked for, also where
// frames are missed, the rate changes, and a moment before is asked for.
static void poses_ahead_are_the_same(void **state) {
    (void)state;
    struct ap_error err;
    struct sim_settings settings;
    struct sim_source *source = NULL;
    if (sim_settings_read(&err, NULL, &settings) || sim_source_create(&err, &settings, &source))
        fail_msg("%s", err.text);
    struct sim_pacer pacer;
    sim_pacer_init(&pacer, SIM_CLOCK_REAL, 90, 0);
    int64_t now_ns = 0, first_ns = 0;
    for (int k = 0; k < 200; k++) {
        if (k == 150)
            sim_pacer_set_rate(&pacer, 72);
        struct sim_prediction frame = sim_pacer_next(&pacer, now_ns);
        now_ns += k % 40 == 39 ? 37000000 : 11000000; // some frames are late
        if (k == 0) {
            first_ns = frame.display_ns;
            sim_source_start(source, first_ns, 0);
        }
        sim_source_prepare(source, &pacer);
        for (int d = SIM_HEAD; d < (k < 100 ? SIM_LEFT : SIM_DEVICE_COUNT); d++)
            for (int before = 0; before < 3; before++) {
                int64_t ns = frame.display_ns - (before == 1 ? 1000000 : 0);
                struct ap_sample got = {0};
                assert_int_equal(sim_source_at(source, (enum sim_device)d, ns, &got),
                                 AP_POSE_EXACT);
                struct ap_sample expected = ap_walk_at(&settings.walk, d, ns - first_ns);
                if (memcmp(&got.pose, &expected.pose, sizeof got.pose) != 0)
                    fail_msg("frame %d, device %d: x %.17g, expected %.17g", k, d, got.pose.p.x,
                             expected.pose.p.x);
            }
    }
    // Each frame's pose once, the moment before once; what was prepared in vain is a part of it.
    struct sim_source_stats stats = sim_source_stats(source);
    assert_int_equal(stats.asked, 100 * 3 + 100 * 9);
    if (stats.remembered < 300 + 490 || stats.evaluated > 2 * 400 + 12 * 32)
        fail_msg("asked %lld, remembered %lld, evaluated %lld", (long long)stats.asked,
                 (long long)stats.remembered, (long long)stats.evaluated);
    sim_source_destroy(source);
    sim_settings_finish(&settings);
}

static void bad_settings_are_named(void **state) {
    (void)state;
    static const char *const cases[][2] = {
        {"{\"inputs\": \"a.csv\"}", "/inputs: expected a list"},
        {"{\"inputs\": [\"a.csv\", 3]}", "/inputs/1: expected a file's path"},
        {"{\"inputs\": [\"-\"]}", "/inputs/0: expected a file's path"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct memory_file file = memory_text(cases[i][0]);
        struct ap_error err = {""};
        struct sim_settings settings;
        assert_int_equal(sim_settings_read(&err, file.path, &settings), AP_INPUT);
        if (!strstr(err.text, cases[i][1]))
            fail_msg("%s gave '%s', expected '%s'", cases[i][0], err.text, cases[i][1]);
        close(file.fd);
    }
    struct memory_file bad = memory_text("0,left,/input/trigger/value,7\n");
    char *path = bad.path;
    struct sim_settings settings = {.inputs = &path, .input_count = 1};
    struct sim_source *source = NULL;
    struct ap_error err = {""};
    assert_int_equal(sim_source_create(&err, &settings, &source), AP_INPUT);
    assert_null(source);
    if (!strstr(err.text, ":1:29: expected a number from 0 to 1"))
        fail_msg("'%s'", err.text);
    close(bad.fd);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(one_log_drives_many_kinds),
        cmocka_unit_test(what_is_said_goes_before_what_follows),
        cmocka_unit_test(a_profile_knows_what_it_hears),
        cmocka_unit_test(inputs_have_the_pose_logs_clock),
        cmocka_unit_test(poses_ahead_are_the_same),
        cmocka_unit_test(bad_settings_are_named),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
