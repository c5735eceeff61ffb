#include <inttypes.h>
#include <math.h>
#include <pthread.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "src/device/fusion/predict.h"

static const int64_t MS = 1000000;
static const double DEGREE = 3.14159265358979323846 / 180;

static struct ap_history history;

static void start(const struct ap_history_params *params) {
    assert_true(ap_history_init(&history, params));
}

// A device that turns at `rate` rad/s about +y and moves along +x at 1 m/s.
static struct ap_pose moving(int64_t t_ns, double rate) {
    double t_s = 1e-9 * (double)t_ns;
    return (struct ap_pose){{t_s, 0, 0},
                            ap_quat_from_axis_angle((struct ap_vec3){0, 1, 0}, rate * t_s)};
}

static void push_moving(int64_t t_ns) {
    assert_true(ap_history_push(&history, t_ns, moving(t_ns, 2), NULL));
}

static double turned(struct ap_quat a, struct ap_quat b) {
    struct ap_quat d = ap_quat_mul(a, ap_quat_conj(b));
    return 2 * atan2(hypot(hypot(d.x, d.y), d.z), fabs(d.w));
}

static void expect(int64_t t_ns, enum ap_pose_state state, struct ap_pose pose) {
    struct ap_history_answer a = ap_history_at(&history, t_ns);
    double off = ap_vec3_length(ap_vec3_sub(a.pose.p, pose.p)), angle = turned(a.pose.q, pose.q);
    if (a.state != state || !(off < 1e-12) || !(angle < 1e-7))
        fail_msg("at %" PRId64 ": %s, %g m and %g rad off (tolerance 1e-12, 1e-7); expected %s",
                 t_ns, ap_pose_state_name(a.state), off, angle, ap_pose_state_name(state));
}

// What the prediction of h after t comes to, by the formula and not by the code.
static struct ap_pose faded(int64_t t_ns, double h_s, double tau_s) {
    double part = tau_s * (1 - exp(-h_s / tau_s));
    return moving(t_ns + llround(1e9 * part), 2);
}

static void test_states(void **unused) {
    (void)unused;
    start(&(struct ap_history_params){.tau_s = 0.08});
    struct ap_history_answer none = ap_history_at(&history, 5);
    assert_int_equal(none.state, AP_POSE_NONE);
    for (int i = 0; i <= 10; i++)
        push_moving(i * 10 * MS);
    expect(-1, AP_POSE_NONE, AP_POSE_IDENTITY);
    expect(0, AP_POSE_EXACT, moving(0, 2));
    expect(50 * MS, AP_POSE_EXACT, moving(50 * MS, 2));
    expect(53 * MS, AP_POSE_INTERPOLATED, moving(53 * MS, 2));
    expect(99999999, AP_POSE_INTERPOLATED, moving(99999999, 2));
    expect(100 * MS, AP_POSE_EXACT, moving(100 * MS, 2));
    struct ap_history_answer a = ap_history_at(&history, 120 * MS);
    struct ap_pose want = faded(100 * MS, 0.02, 0.08);
    if (a.state != AP_POSE_PREDICTED || fabs(a.pose.p.x - want.p.x) > 1e-8 ||
        turned(a.pose.q, want.q) > 1e-7)
        fail_msg("20 ms ahead: %.10g m, expected %.10g m", a.pose.p.x, want.p.x);
    assert_int_equal(a.age_ns, 20 * MS);
    assert_true(fabs(a.linear_m_s.x - 1) < 1e-9 && fabs(a.angular_rad_s.y - 2) < 1e-6);
    // At most 40 ms ahead; then it stays; lost after 100.
    struct ap_pose end = ap_history_at(&history, 140 * MS).pose;
    expect(200 * MS, AP_POSE_PREDICTED, end);
    expect(200 * MS + 1, AP_POSE_LOST, end);
    expect(INT64_MAX, AP_POSE_LOST, end);
}

static void no_velocity(const char *what, int64_t t_ns) {
    struct ap_history_answer a = ap_history_at(&history, t_ns);
    struct ap_history_answer now = ap_history_at(&history, t_ns - a.age_ns);
    double off = ap_vec3_length(ap_vec3_sub(a.pose.p, now.pose.p));
    if (a.state != AP_POSE_PREDICTED || off > 0 || turned(a.pose.q, now.pose.q) > 1e-9 ||
        ap_vec3_length(a.linear_m_s) + ap_vec3_length(a.angular_rad_s) > 0)
        fail_msg("%s: %s, moved by %g m without a velocity", what, ap_pose_state_name(a.state),
                 off);
}

static void test_no_velocity_without_reason(void **unused) {
    (void)unused;
    start(&(struct ap_history_params){0});
    struct ap_vec3 rate = {0, 2, 0};
    push_moving(0);
    no_velocity("the first sample", 10 * MS);
    push_moving(2 * MS);
    no_velocity("two samples 2 ms apart", 10 * MS);
    for (int i = 1; i < 10; i++)
        push_moving(i * 10 * MS);
    assert_true(ap_history_at(&history, 95 * MS).linear_m_s.x > 0.9);
    push_moving(151 * MS); // 61 ms later
    no_velocity("after a gap", 160 * MS);
    push_moving(161 * MS);
    push_moving(171 * MS);
    assert_true(ap_history_at(&history, 175 * MS).linear_m_s.x > 0.9);
    ap_history_reset(&history);
    assert_true(ap_history_push(&history, 181 * MS, moving(181 * MS, 2), &rate));
    no_velocity("after a reset, even with a gyroscope", 190 * MS);
    expect(175 * MS, AP_POSE_LOST, moving(171 * MS, 2)); // no interpolation over the reset
    struct ap_pose far = moving(191 * MS, 2);
    far.p.x += 1;
    assert_true(ap_history_push(&history, 191 * MS, far, NULL));
    no_velocity("after a jump of a metre", 200 * MS);
}

static void test_gyroscope(void **unused) {
    (void)unused;
    start(&(struct ap_history_params){.tau_s = (double)INFINITY});
    struct ap_quat lying = ap_quat_from_axis_angle((struct ap_vec3){1, 0, 0}, 90 * DEGREE);
    struct ap_vec3 rate = {0, 0, 3}; // in the room: −3 about y
    for (int i = 0; i < 5; i++)
        assert_true(
            ap_history_push(&history, i * 4 * MS, (struct ap_pose){{0, 0, 0}, lying}, &rate));
    struct ap_history_answer a = ap_history_at(&history, 26 * MS);
    struct ap_quat want =
        ap_quat_mul(ap_quat_from_axis_angle((struct ap_vec3){0, 1, 0}, -0.03), lying);
    if (turned(a.pose.q, want) > 1e-7)
        fail_msg("%g rad off", turned(a.pose.q, want));
}

static void test_lost(void **unused) {
    (void)unused;
    start(&(struct ap_history_params){0});
    ap_history_lose(&history, 5); // nothing to lose
    assert_int_equal(ap_history_at(&history, 10).state, AP_POSE_NONE);
    for (int i = 0; i < 5; i++)
        push_moving(i * 10 * MS);
    ap_history_lose(&history, 42 * MS);
    expect(39 * MS, AP_POSE_INTERPOLATED, moving(39 * MS, 2));
    expect(41 * MS, AP_POSE_LOST, moving(40 * MS, 2));
    expect(42 * MS, AP_POSE_LOST, moving(40 * MS, 2));
    expect(1000 * MS, AP_POSE_LOST, moving(40 * MS, 2));
    push_moving(60 * MS); // plugged in again
    expect(55 * MS, AP_POSE_LOST, moving(40 * MS, 2));
    expect(60 * MS, AP_POSE_EXACT, moving(60 * MS, 2));
    no_velocity("after it came back", 62 * MS);
    push_moving(200 * MS);
    expect(100 * MS, AP_POSE_LOST, moving(60 * MS, 2)); // 140 ms between two samples
}

static void test_ring(void **unused) {
    (void)unused;
    start(&(struct ap_history_params){0});
    for (int i = 0; i < 3000; i++)
        push_moving(i * MS);
    int64_t first = 3000 - AP_HISTORY_SLOTS;
    expect((first - 1) * MS, AP_POSE_LOST, moving(first * MS, 2));
    for (int64_t i = first; i < 3000; i++)
        expect(i * MS, AP_POSE_EXACT, moving(i * MS, 2));
    expect(first * MS + 1, AP_POSE_INTERPOLATED, moving(first * MS + 1, 2));
}

static void test_rejects(void **unused) {
    (void)unused;
    start(&(struct ap_history_params){0});
    push_moving(10);
    struct ap_pose good = AP_POSE_IDENTITY, bad = good;
    struct ap_vec3 rate = {0, (double)NAN, 0};
    assert_false(ap_history_push(&history, 10, good, NULL));
    assert_false(ap_history_push(&history, INT64_MIN, good, NULL));
    assert_false(ap_history_push(&history, 20, good, &rate));
    bad.p.z = (double)INFINITY;
    assert_false(ap_history_push(&history, 20, bad, NULL));
    bad = good;
    bad.q.w = 0;
    assert_false(ap_history_push(&history, 20, bad, NULL));
    bad.q.x = (double)NAN;
    assert_false(ap_history_push(&history, 20, bad, NULL));
    assert_int_equal(history.rejected, 6);
    expect(10, AP_POSE_EXACT, moving(10, 2));
    // The ends of time.
    start(&(struct ap_history_params){0});
    push_moving(INT64_MIN + 1);
    assert_true(ap_history_push(&history, INT64_MAX, good, NULL));
    assert_int_equal(ap_history_at(&history, 0).state, AP_POSE_LOST);
    ap_history_lose(&history, 0);
    assert_int_equal(ap_history_at(&history, INT64_MAX).state, AP_POSE_EXACT);
    const struct ap_history_params wrong[] = {{.tau_s = -1},
                                              {.tau_s = (double)NAN},
                                              {.ahead_max_ns = -1},
                                              {.lost_after_ns = INT64_MAX},
                                              {.jump_m_s = (double)NAN}};
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++)
        assert_false(ap_history_init(&history, &wrong[i]));
}

// One writes as fast as it can, three read at all times: a torn pose would not have p = (t, 2t, 3t)
// and the turn that goes with it.
enum { WRITES = 300000, READERS = 3 };

static atomic_bool writing;

struct reader {
    pthread_t thread;
    int64_t reads, exact, predicted, torn, backwards;
};

static struct ap_pose marked(int64_t i) {
    double x = (double)i;
    return (struct ap_pose){{x, 2 * x, 3 * x},
                            ap_quat_from_axis_angle((struct ap_vec3){0, 0, 1}, 1e-6 * x)};
}

static void *read_all(void *argument) {
    struct reader *r = argument;
    int64_t newest = 0;
    while (atomic_load_explicit(&writing, memory_order_relaxed) || r->reads < 100) {
        int64_t ask = newest + (r->reads % 3 - 1) * 50; // µs: in the ring, newest, ahead
        struct ap_history_answer a = ap_history_at(&history, 1000 * ask);
        r->reads++;
        if (a.state == AP_POSE_NONE)
            continue;
        int64_t now = ask - a.age_ns / 1000;
        r->backwards += now < newest;
        newest = now;
        r->exact += a.state == AP_POSE_EXACT;
        r->predicted += a.state == AP_POSE_PREDICTED;
        if (a.state != AP_POSE_EXACT && a.state != AP_POSE_INTERPOLATED)
            continue;
        double x = a.pose.p.x;
        struct ap_quat q = ap_quat_from_axis_angle((struct ap_vec3){0, 0, 1}, 1e-6 * x);
        r->torn += fabs(a.pose.p.y - 2 * x) > 1e-6 || fabs(a.pose.p.z - 3 * x) > 1e-6 ||
                   fabs(x - (double)ask) > 1e-6 || turned(a.pose.q, q) > 1e-7;
    }
    return NULL;
}

static void test_threads(void **unused) {
    (void)unused;
    start(&(struct ap_history_params){.jump_m_s = 1e9});
    struct reader readers[READERS] = {0};
    atomic_store(&writing, true);
    for (int i = 0; i < READERS; i++)
        assert_int_equal(pthread_create(&readers[i].thread, NULL, read_all, &readers[i]), 0);
    for (int64_t i = 1; i <= WRITES; i++)
        ap_history_push(&history, 1000 * i, marked(i), NULL);
    atomic_store(&writing, false);
    for (int i = 0; i < READERS; i++) {
        pthread_join(readers[i].thread, NULL);
        print_message("reader %d: %" PRId64 " reads, %" PRId64 " exact, %" PRId64 " predicted\n", i,
                      readers[i].reads, readers[i].exact, readers[i].predicted);
        if (readers[i].torn || readers[i].backwards)
            fail_msg("reader %d: %" PRId64 " torn poses, %" PRId64 " steps back", i,
                     readers[i].torn, readers[i].backwards);
    }
    assert_int_equal(history.rejected, 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_states),    cmocka_unit_test(test_no_velocity_without_reason),
        cmocka_unit_test(test_gyroscope), cmocka_unit_test(test_lost),
        cmocka_unit_test(test_ring),      cmocka_unit_test(test_rejects),
        cmocka_unit_test(test_threads),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
