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

// The shared recordings through the drivers, against where the bytes were made from.

static const double DEGREES = 57.295779513082321;

static char *shared(const char *role, const char *name) {
    static char texts[8][512];
    static int next;
    char *text = texts[next++ % 8];
    snprintf(text, sizeof texts[0], "%s%s/data/hid/%s", role, getenv("ANTIPODE_SHARED"), name);
    return text;
}

static struct ap_poselog *open_log(const char *source) {
    struct ap_poselog_params params = {.sources = &source, .source_count = 1};
    struct ap_error err;
    struct ap_poselog *log = NULL;
    if (ap_poselog_open(&err, &params, &log))
        fail_msg("%s", err.text);
    return log;
}

static bool next(struct ap_poselog *log, struct ap_sample *sample) {
    struct ap_error err;
    bool got = false;
    if (ap_poselog_next(&err, log, sample, &got))
        fail_msg("%s", err.text);
    return got;
}

static struct ap_timeline *truth_of(const char *name) {
    struct ap_poselog *log = open_log(shared("", name));
    struct ap_timeline *t = NULL;
    assert_int_equal(ap_timeline_load(NULL, log, &t), AP_OK);
    ap_poselog_close(log);
    return t;
}

static double angle_deg(struct ap_quat a, struct ap_quat b) {
    struct ap_quat d = ap_quat_mul(ap_quat_conj(a), b);
    return 2 * DEGREES * atan2(ap_vec3_length((struct ap_vec3){d.x, d.y, d.z}), fabs(d.w));
}

// The turn about +y that takes a nearest to b.
static struct ap_quat yaw_between(struct ap_quat a, struct ap_quat b) {
    struct ap_quat d = ap_quat_mul(b, ap_quat_conj(a));
    return ap_quat_normalize((struct ap_quat){0, d.y, 0, d.w});
}

struct errors {
    int count;
    double sum_deg, worst_deg;
};

static void add_error(struct errors *e, double deg) {
    e->count++;
    e->sum_deg += deg;
    if (deg > e->worst_deg)
        e->worst_deg = deg;
}

// The truth at the report's time. Between its own times (50 a second) it would be a guess.
static bool truth_at(const struct ap_timeline *t, int64_t t_ns, struct ap_quat *q) {
    static const int64_t ROUNDING_NS = 1000; // of the recordings' microseconds
    int64_t n = ap_timeline_sample_count(t), low = 0;
    for (int64_t high = n; low < high;) {
        int64_t mid = low + (high - low) / 2;
        if (ap_timeline_sample(t, mid).t_ns < t_ns - ROUNDING_NS)
            low = mid + 1;
        else
            high = mid;
    }
    if (low == n || ap_timeline_sample(t, low).t_ns > t_ns + ROUNDING_NS)
        return false;
    *q = ap_timeline_sample(t, low).pose.q;
    return true;
}

static void report(const char *what, const struct errors *e, double tolerance_deg) {
    print_message("%s: %d poses, mean %.4f, worst %.4f degrees\n", what, e->count,
                  e->sum_deg / e->count, e->worst_deg);
    if (!(e->worst_deg <= tolerance_deg))
        fail_msg("%s: worst %.4f degrees, allowed %.4f", what, e->worst_deg, tolerance_deg);
}

// The tracker's reference is its own: known up to a yaw, and at 14.92 s it begins a new one.
static void test_android(void **unused) {
    (void)unused;
    struct ap_timeline *truth = truth_of("android_head_tracker_vive_head.truth.tum");
    struct ap_poselog *log = open_log(shared("", "android_head_tracker_vive_head.hid"));
    struct errors errors[2] = {{0}};
    struct ap_quat yaw = AP_QUAT_IDENTITY, want;
    struct ap_sample s;
    while (next(log, &s)) {
        assert_true(truth_at(truth, s.t_ns, &want));
        struct errors *e = &errors[s.t_ns >= 14910000000];
        if (!e->count)
            yaw = yaw_between(s.pose.q, want);
        add_error(e, angle_deg(ap_quat_mul(yaw, s.pose.q), want));
        double reach = ap_vec3_length(ap_vec3_sub(s.pose.p, (struct ap_vec3){0, 1.5, 0}));
        assert_true(fabs(reach - 0.08 * sqrt(2)) < 1e-12);
    }
    assert_int_equal(errors[0].count + errors[1].count, 1453);
    assert_int_equal(ap_poselog_device_count(log), 1);
    assert_string_equal(ap_poselog_device_name(log, 0), "head");
    report("Android head tracker", &errors[0], 0.03);
    report("after its reset", &errors[1], 0.03);
    ap_poselog_close(log);
    ap_timeline_destroy(truth);
}

static void test_slimevr(void **unused) {
    (void)unused;
    static const char *const names[] = {"head", "left", "right"};
    struct ap_timeline *truth[3] = {truth_of("slimevr_receiver_vive_head.truth.tum"),
                                    truth_of("slimevr_receiver_vive_left.truth.tum"),
                                    truth_of("slimevr_receiver_vive_right.truth.tum")};
    struct ap_poselog *log = open_log(shared("", "slimevr_receiver_vive_head_hands.hid"));
    struct errors errors[3] = {{0}};
    struct ap_sample s;
    struct ap_quat want;
    int rows[3] = {0};
    while (next(log, &s)) {
        assert_in_range(s.device, 0, 2);
        rows[s.device]++;
        if (truth_at(truth[s.device], s.t_ns, &want))
            add_error(&errors[s.device], angle_deg(s.pose.q, want));
    }
    for (int d = 0; d < 3; d++) {
        assert_string_equal(ap_poselog_device_name(log, d), names[d]);
        report(names[d], &errors[d], 0.02);
        // From the report on that says that the tracker is there: one more every 100 ms.
        assert_int_equal(rows[d], 2904 - 10 * d);
        ap_timeline_destroy(truth[d]);
    }
    ap_poselog_close(log);
}

static void test_spacemouse(void **unused) {
    (void)unused;
    struct ap_poselog *log = open_log(shared("right=", "spacemouse_enterprise_vive_right.hid"));
    struct ap_sample s, before = {.pose = AP_POSE_IDENTITY};
    int count = 0;
    double path_m = 0, turned_deg = 0;
    for (; next(log, &s); before = s, count++) {
        if (count) {
            path_m += ap_vec3_length(ap_vec3_sub(s.pose.p, before.pose.p));
            turned_deg += angle_deg(s.pose.q, before.pose.q);
        }
    }
    print_message("SpaceMouse: %d poses, %.2f m and %.0f degrees of path\n", count, path_m,
                  turned_deg);
    assert_int_equal(count, 2316);
    assert_string_equal(ap_poselog_device_name(log, 0), "right");
    assert_true(path_m > 1 && path_m < 60);
    ap_poselog_close(log);
}

static void check_refused(const char *text, const char *part) {
    struct memory_file file = memory_text(text);
    struct ap_poselog *log = open_log(file.path);
    struct ap_error err = {""};
    struct ap_sample s;
    bool got = false;
    assert_int_equal(ap_poselog_next(&err, log, &s, &got), AP_INPUT);
    if (!strstr(err.text, part))
        fail_msg("'%s' lacks '%s'", err.text, part);
    ap_poselog_close(log);
    close(file.fd);
}

static void test_no_driver(void **unused) {
    (void)unused;
    check_refused("D: 0\nN: Some Wheel\nI: 3 1234 5678\nE: 000000.000000 2 01 80\n",
                  "no driver for 'Some Wheel' (bus 3, 1234:5678)");
}

int main(void) {
    if (!getenv("ANTIPODE_SHARED")) {
        puts("skipped: ANTIPODE_SHARED is not set");
        return 77;
    }
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_android),
        cmocka_unit_test(test_slimevr),
        cmocka_unit_test(test_spacemouse),
        cmocka_unit_test(test_no_driver),
    };
    return cmocka_run_group_tests_name("hid-recordings", tests, NULL, NULL);
}
