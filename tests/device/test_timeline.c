#include <inttypes.h>
#include <math.h>
#include <mpfr.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

#include "src/device/timeline.h"
#include "tests/device/memory_file.h"

// Halves away from zero of a quotient that MPFR knows to 300 bits (exact to the rounding here: the
// quotients have denominators below 2^53).
static int64_t exact_frame_time(int64_t t0_ns, int64_t frame, double hz) {
    mpfr_t q, d;
    mpfr_inits2(300, q, d, (mpfr_ptr)0);
    mpfr_set_sj(q, frame, MPFR_RNDN);
    mpfr_mul_ui(q, q, 1000000000, MPFR_RNDN);
    mpfr_set_d(d, hz, MPFR_RNDN);
    mpfr_div(q, q, d, MPFR_RNDN);
    mpfr_round(q, q);
    int64_t t = t0_ns + mpfr_get_sj(q, MPFR_RNDN);
    mpfr_clears(q, d, (mpfr_ptr)0);
    return t;
}

static void test_frame_times(void **unused) {
    (void)unused;
    const double rates[] = {90,    72,   120,  144,     60,     59.94, 90000.0 / 1001, 1,
                            0.125, 1e9,  2e9,  8e9,     0.1,    29.97, 5.1e9,          1.0 / 3,
                            1000,  89.9, 3e-3, 0x1p-30, 0x1p70, 1e300};
    const int64_t frames[] = {0,
                              1,
                              2,
                              3,
                              4,
                              5,
                              7,
                              45,
                              89,
                              90,
                              1000003,
                              INT64_C(1) << 33,
                              (INT64_C(1) << 40) - 1,
                              INT64_C(1) << 40};
    for (size_t r = 0; r < sizeof rates / sizeof *rates; r++)
        for (size_t k = 0; k < sizeof frames / sizeof *frames; k++) {
            if ((double)frames[k] * 1e9 / rates[r] > 9e18)
                continue;
            int64_t t0 = k & 1 ? 17 : -23;
            int64_t got = ap_frame_time_ns(t0, frames[k], rates[r]);
            int64_t want = exact_frame_time(t0, frames[k], rates[r]);
            int64_t back = ap_frame_time_ns(0, -frames[k], rates[r]);
            if (got != want || back != -(want - t0))
                fail_msg("frame %" PRId64 " at %.17g Hz: %" PRId64 " and back %" PRId64
                         ", expected %" PRId64 ", exactly",
                         frames[k], rates[r], got, back, want);
        }
}

static void test_frame_times_without_a_place(void **unused) {
    (void)unused;
    assert_int_equal(ap_frame_time_ns(0, INT64_MAX, 90), INT64_MAX);
    assert_int_equal(ap_frame_time_ns(0, INT64_C(1) << 40, 1e-300), INT64_MAX);
    assert_int_equal(ap_frame_time_ns(0, INT64_MIN, 1e-300), -INT64_MAX);
    assert_int_equal(ap_frame_time_ns(INT64_MAX - 5, 90, 90), INT64_MAX);
    assert_int_equal(ap_frame_time_ns(5, 90, 0), 5);
    assert_int_equal(ap_frame_time_ns(5, 90, NAN), 5);
}

static struct ap_timeline *load(const char *text) {
    struct memory_file file = memory_text(text);
    const char *path = file.path;
    struct ap_error err;
    struct ap_poselog *log = NULL;
    struct ap_timeline *timeline = NULL;
    struct ap_poselog_params params = {.sources = &path, .source_count = 1};
    if (ap_poselog_open(&err, &params, &log) || ap_timeline_load(&err, log, &timeline))
        fail_msg("%s", err.text);
    ap_poselog_close(log);
    close(file.fd);
    return timeline;
}

static const char header[] = "t_ns,device,px,py,pz,qx,qy,qz,qw,trigger,select\n";

static char *with_header(const char *rows) {
    static char text[4096];
    snprintf(text, sizeof text, "%s%s", header, rows);
    return text;
}

static void check_at(const struct ap_timeline *t, int device, int64_t t_ns,
                     enum ap_pose_state state, double x) {
    struct ap_sample sample = {.pose.p.x = -99};
    enum ap_pose_state got = ap_timeline_at(t, device, t_ns, &sample);
    if (got != state || !(fabs(sample.pose.p.x - x) <= 1e-15))
        fail_msg("device %d at %" PRId64 ": %s x = %.17g, expected %s x = %.17g (1e-15)", device,
                 t_ns, ap_pose_state_name(got), sample.pose.p.x, ap_pose_state_name(state), x);
    if (got != AP_POSE_NONE)
        assert_int_equal(sample.t_ns, t_ns);
}

static void test_states(void **unused) {
    (void)unused;
    struct ap_timeline *t = load(with_header("0,head,0,0,0,0,0,0,1,,\n"
                                             "1000000,left,5,0,0,0,0,0,1,0.5,1\n"
                                             "100000000,head,1,0,0,0,0,0,1,,\n"
                                             "200000001,head,2,0,0,0,0,0,1,,\n"
                                             "200000002,head,3,0,0,0,0,0,1,,\n"));
    int head = ap_timeline_find_device(t, "head"), left = ap_timeline_find_device(t, "left");
    assert_int_equal(ap_timeline_find_device(t, "right"), -1);
    assert_string_equal(ap_timeline_device_name(t, left), "left");
    assert_int_equal(ap_timeline_device_count(t), 2);
    assert_int_equal(ap_timeline_start_ns(t), 0);
    assert_int_equal(ap_timeline_end_ns(t), 200000002);
    assert_int_equal(ap_timeline_sample_count(t), 5);
    assert_int_equal(ap_timeline_sample(t, 1).device, left);
    check_at(t, head, -1, AP_POSE_NONE, -99);
    check_at(t, head, 0, AP_POSE_EXACT, 0);
    check_at(t, head, 25000000, AP_POSE_INTERPOLATED, 0.25);
    check_at(t, head, 100000000, AP_POSE_EXACT, 1);
    check_at(t, head, 100000001, AP_POSE_LOST, 1); // the gap is a nanosecond over 100 ms
    check_at(t, head, 200000000, AP_POSE_LOST, 1);
    check_at(t, head, 200000001, AP_POSE_EXACT, 2);
    check_at(t, head, 200000002, AP_POSE_EXACT, 3);
    check_at(t, head, 200000003, AP_POSE_LOST, 3);
    check_at(t, left, 999999, AP_POSE_NONE, -99);
    check_at(t, left, 50000000, AP_POSE_LOST, 5);
    check_at(t, 2, 0, AP_POSE_NONE, -99);
    struct ap_sample sample;
    ap_timeline_at(t, left, 2000000, &sample);
    assert_true(sample.trigger == 0.5f && sample.select);
    ap_timeline_destroy(t);
}

static void test_rotation_goes_the_short_way(void **unused) {
    (void)unused;
    // A quarter turn about y, once with the sign of the other cover.
    struct ap_timeline *t =
        load(with_header("0,head,0,0,0,0,0,0,1,,\n"
                         "90,head,0,0,0,0,-0.70710678118654752,0,-0.70710678118654752,,\n"));
    struct ap_sample sample;
    assert_int_equal(ap_timeline_at(t, 0, 30, &sample), AP_POSE_INTERPOLATED);
    double s = sin(M_PI / 12), c = cos(M_PI / 12);
    if (fabs(sample.pose.q.y - s) > 1e-15 || fabs(sample.pose.q.w - c) > 1e-15)
        fail_msg("q = %.17g %.17g, expected %.17g %.17g (1e-15)", sample.pose.q.y, sample.pose.q.w,
                 s, c);
    ap_timeline_destroy(t);
}

static void test_frame_count(void **unused) {
    (void)unused;
    struct ap_timeline *one = load(with_header("7,head,0,0,0,0,0,0,1,,\n"));
    assert_int_equal(ap_timeline_frame_count(one, 90), 1);
    ap_timeline_destroy(one);
    // The third frame at 90 Hz is due at 22222222 (22222222.2…).
    struct ap_timeline *t = load(with_header("5,head,0,0,0,0,0,0,1,,\n"
                                             "22222226,head,0,0,0,0,0,0,1,,\n"));
    assert_int_equal(ap_timeline_frame_count(t, 90), 2);
    ap_timeline_destroy(t);
    t = load(with_header("5,head,0,0,0,0,0,0,1,,\n22222227,head,0,0,0,0,0,0,1,,\n"
                         "90000000,left,0,0,0,0,0,0,1,,\n"));
    assert_int_equal(ap_timeline_frame_count(t, 90), 3);
    ap_timeline_destroy(t);
    t = load(with_header("0,head,0,0,0,0,0,0,1,,\n3000000000000000000,head,0,0,0,0,0,0,1,,\n"));
    assert_int_equal(ap_timeline_frame_count(t, 90), INT64_C(270000000001));
    ap_timeline_destroy(t);
}

static void test_no_head(void **unused) {
    (void)unused;
    struct memory_file file = memory_text(with_header("0,left,0,0,0,0,0,0,1,,\n"));
    const char *path = file.path;
    struct ap_error err = {""};
    struct ap_poselog *log = NULL;
    struct ap_timeline *timeline = NULL;
    struct ap_poselog_params params = {.sources = &path, .source_count = 1};
    assert_int_equal(ap_poselog_open(&err, &params, &log), AP_OK);
    assert_int_equal(ap_timeline_load(&err, log, &timeline), AP_INPUT);
    assert_non_null(strstr(err.text, "head"));
    assert_null(timeline);
    ap_poselog_close(log);
    close(file.fd);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_frame_times), cmocka_unit_test(test_frame_times_without_a_place),
        cmocka_unit_test(test_states),      cmocka_unit_test(test_rotation_goes_the_short_way),
        cmocka_unit_test(test_frame_count), cmocka_unit_test(test_no_head),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
