#include <inttypes.h>
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

// The real recordings of the shared folder; its MANIFEST.md says what is known of them.

static char *recording(const char *role, const char *name) {
    static char texts[4][512];
    static int next;
    char *text = texts[next++ % 4];
    snprintf(text, sizeof texts[0], "%s%s/data/poses/%s", role, getenv("ANTIPODE_SHARED"), name);
    return text;
}

static struct ap_poselog *open_log(const struct ap_poselog_params *params) {
    struct ap_error err;
    struct ap_poselog *log = NULL;
    if (ap_poselog_open(&err, params, &log))
        fail_msg("%s", err.text);
    return log;
}

static struct ap_timeline *load(const struct ap_poselog_params *params) {
    struct ap_poselog *log = open_log(params);
    struct ap_error err;
    struct ap_timeline *timeline = NULL;
    if (ap_timeline_load(&err, log, &timeline))
        fail_msg("%s", err.text);
    ap_poselog_close(log);
    return timeline;
}

static bool next(struct ap_poselog *log, struct ap_sample *sample) {
    struct ap_error err;
    bool got = false;
    if (ap_poselog_next(&err, log, sample, &got))
        fail_msg("%s", err.text);
    return got;
}

// A whole room-scale recording: three devices, 2568 samples each, in the order of their times.
static void test_vive_room(void **unused) {
    (void)unused;
    const char *sources[] = {recording("", "vive_room_head.tum"),
                             recording("left=", "vive_room_left.tum"),
                             recording("right=", "vive_room_right.tum")};
    struct ap_poselog_params params = {.sources = sources, .source_count = 3};
    struct ap_poselog *log = open_log(&params);
    struct ap_sample s;
    int count[3] = {0};
    int64_t before = INT64_MIN;
    for (int i = 0; next(log, &s); i++) {
        assert_true(s.t_ns >= before && s.device == i % 3);
        before = s.t_ns;
        count[s.device]++;
    }
    static const char *const names[] = {"head", "left", "right"};
    assert_int_equal(ap_poselog_device_count(log), 3);
    for (int d = 0; d < 3; d++) {
        assert_int_equal(count[d], 2568);
        assert_string_equal(ap_poselog_device_name(log, d), names[d]);
    }
    ap_poselog_close(log);
}

struct gaps {
    int over_100_ms;
    int64_t longest_ns;
};

static struct gaps count_gaps(const struct ap_timeline *t) {
    struct gaps gaps = {0};
    int64_t n = ap_timeline_sample_count(t);
    for (int64_t i = 1; i < n; i++) {
        int64_t a = ap_timeline_sample(t, i - 1).t_ns, b = ap_timeline_sample(t, i).t_ns;
        gaps.over_100_ms += b - a > 100000000;
        if (b - a > gaps.longest_ns)
            gaps.longest_ns = b - a;
        struct ap_sample s;
        enum ap_pose_state want = b - a > 100000000 ? AP_POSE_LOST : AP_POSE_INTERPOLATED;
        assert_int_equal(ap_timeline_at(t, 0, a, &s), AP_POSE_EXACT);
        if (b - a > 1)
            assert_int_equal(ap_timeline_at(t, 0, a + (b - a) / 2, &s), want);
    }
    return gaps;
}

static void test_desk_walk_is_lost_at_times(void **unused) {
    (void)unused;
    const char *source = recording("", "desk_walk_head.csv");
    struct ap_poselog_params params = {.sources = &source, .source_count = 1};
    struct ap_timeline *t = load(&params);
    assert_int_equal(ap_timeline_sample_count(t), 6986);
    struct gaps gaps = count_gaps(t);
    assert_int_equal(gaps.over_100_ms, 29);
    if (gaps.longest_ns < 13500000000 || gaps.longest_ns > 14500000000)
        fail_msg("longest gap %" PRId64 " ns, expected 14 s (0.5 s)", gaps.longest_ns);
    // Frames of a 90 Hz headset: what is lost is held.
    int64_t frames = ap_timeline_frame_count(t, 90), lost = 0;
    for (int64_t k = 0; k < frames; k++) {
        struct ap_sample s;
        int64_t t_k = ap_frame_time_ns(ap_timeline_start_ns(t), k, 90);
        lost += ap_timeline_at(t, 0, t_k, &s) == AP_POSE_LOST;
    }
    print_message("%" PRId64 " frames, %" PRId64 " lost\n", frames, lost);
    assert_in_range(lost, 20 * 90, 30 * 90);
    ap_timeline_destroy(t);
}

// The TUM file is a camera's, with +z up; desk_walk_head.csv was made of every third of its poses.
static void test_desk_walk_is_the_tum_file(void **unused) {
    (void)unused;
    const char *tum = recording("", "tum_fr2_desk_groundtruth.txt");
    const char *csv = recording("", "desk_walk_head.csv");
    struct ap_poselog_params from_tum = {.sources = &tum,
                                         .source_count = 1,
                                         .z_up = true,
                                         .head_frame = AP_HEAD_FRAME_OPTICAL,
                                         .skip_bad = true,
                                         .has_table = true,
                                         .table_x_m = 0.8,
                                         .table_z_m = 1.5};
    struct ap_poselog_params from_csv = {.sources = &csv, .source_count = 1};
    struct ap_poselog *a = open_log(&from_tum), *b = open_log(&from_csv);
    struct ap_sample p, q;
    int64_t t0 = 0;
    int matched = 0;
    bool more = next(a, &p);
    for (t0 = p.t_ns; next(b, &q); matched++) {
        while (more && p.t_ns - t0 < q.t_ns)
            more = next(a, &p);
        assert_true(more);
        assert_int_equal(p.t_ns - t0, q.t_ns);
        double way = ap_vec3_length(ap_vec3_sub(p.pose.p, q.pose.p));
        struct ap_quat d = ap_quat_mul(ap_quat_conj(p.pose.q), q.pose.q);
        double turn = 2 * hypot(hypot(d.x, d.y), d.z);
        if (!(way <= 1e-12 && turn <= 3e-6))
            fail_msg("at %" PRId64 " ns: %g m (1e-12) and %g rad (3e-6) apart", q.t_ns, way, turn);
    }
    while (more)
        more = next(a, &p);
    assert_int_equal(matched, 6986);
    assert_int_equal(ap_poselog_skipped(a), 1); // the time that stands there twice
    ap_poselog_close(a);
    ap_poselog_close(b);
}

static void test_every_tum_recording(void **unused) {
    (void)unused;
    const struct {
        const char *name;
        int count;
    } files[] = {{"quest2_beatsaber_head.tum", 5398},
                 {"quest2_beatsaber_left.tum", 5398},
                 {"vivepro2_beatsaber_right.tum", 5401},
                 {"quest3_head.tum", 1796},
                 {"quest3_left.tum", 1694},
                 {"quest3_right.tum", 1783},
                 {"vive_crouch_head.tum", 1436},
                 {"tum_fr1_xyz_groundtruth.txt", 3000}};
    for (size_t i = 0; i < sizeof files / sizeof *files; i++) {
        const char *source = recording("", files[i].name);
        struct ap_poselog_params params = {.sources = &source, .source_count = 1};
        struct ap_timeline *t = load(&params);
        assert_int_equal(ap_timeline_sample_count(t), files[i].count);
        ap_timeline_destroy(t);
    }
}

int main(void) {
    if (!getenv("ANTIPODE_SHARED")) {
        puts("skipped: ANTIPODE_SHARED names no folder with recordings");
        return 77;
    }
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_vive_room),
        cmocka_unit_test(test_desk_walk_is_lost_at_times),
        cmocka_unit_test(test_desk_walk_is_the_tum_file),
        cmocka_unit_test(test_every_tum_recording),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
