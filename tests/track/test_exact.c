#include <string.h>

#include "tests/track/support.h"

// Every tracker in every space against 448-bit arithmetic, over synthetic walks.

static const char *const spaces[] = {"s3", "e3", "h3"};

static void step(uint64_t *seed, double size, struct ap_pose *pose) {
    pose->p.x += size * noise(seed);
    pose->p.y += size * noise(seed);
    pose->p.z += size * noise(seed);
    struct ap_quat turn = {size * noise(seed), size * noise(seed), size * noise(seed), 1};
    pose->q = ap_quat_normalize(ap_quat_mul(pose->q, turn));
}

static void stroll(const char *space, double radius_m, enum ap_tracker_kind kind, int samples,
                   double size) {
    struct ap_tracker_params params = params_of(space, radius_m, kind);
    struct pair pair = pair_of(&params);
    uint64_t seed = 1;
    const char *const names[3] = {"left", "head", "right"};
    struct ap_pose poses[3] = {pose_at(0.3, 1.1, 0.4), pose_at(0.1, 1.6, 0.9),
                               pose_at(-0.2, 1.2, 0.3)};
    for (int i = 0; i < samples; i++) {
        int device = i % 7 == 5 ? 1 : i % 3;
        step(&seed, size, &poses[device]);
        pair_feed(&pair, names[device], poses[device]);
    }
    char what[96];
    snprintf(what, sizeof what, "%s radius %g, %s, steps %g", space, params.space.rho_m,
             ap_tracker_kind_name(kind), size);
    pair_check(&pair, what);
    pair_finish(&pair);
}

static void strolls(void **state) {
    (void)state;
    for (int s = 0; s < 3; s++)
        for (int kind = 0; kind < 3; kind++) {
            stroll(spaces[s], NAN, (enum ap_tracker_kind)kind, 400, 0.01);
            stroll(spaces[s], 0.3, (enum ap_tracker_kind)kind, 400, 0.2);
            stroll(spaces[s], 20, (enum ap_tracker_kind)kind, 200, 1);
        }
}

// Fourteen radii out and back again: what a double loses on the way out it does not find again.
static void out_and_back(void **state) {
    (void)state;
    struct ap_tracker_params params = params_of("h3", 0.1, AP_TRACKER_NAIVE);
    struct pair pair = pair_of(&params);
    uint64_t seed = 2;
    for (int i = 0; i <= 560; i++) {
        double along = 1.4 * (i <= 280 ? i : 560 - i) / 280;
        struct ap_pose pose = pose_at(along, 0.75 + 1e-5 * noise(&seed), 1e-5 * noise(&seed));
        pose.q = ap_quat_from_axis_angle((struct ap_vec3){0, 1, 0}, 0.01 * i);
        pair_feed(&pair, "head", pose);
    }
    assert_true(pair.reach > 5e5);
    pair_check(&pair, "naive in h3, 14 rho out and back");
    pair_finish(&pair);
}

// What the poses' quaternions measure is a direction: their length does not count.
static void length_of_quaternions(void **state) {
    (void)state;
    for (int kind = 0; kind < 3; kind++) {
        struct ap_tracker_params params = params_of("h3", NAN, (enum ap_tracker_kind)kind);
        struct pair pair = pair_of(&params);
        uint64_t seed = 3;
        struct ap_pose pose = pose_at(0.5, 1.5, -0.6);
        for (int i = 0; i < 100; i++) {
            step(&seed, 0.05, &pose);
            struct ap_pose longer = pose;
            double f = 1 + 0.09 * noise(&seed);
            longer.q = (struct ap_quat){f * pose.q.x, f * pose.q.y, f * pose.q.z, f * pose.q.w};
            pair_feed(&pair, i % 3 ? "head" : "left", longer);
        }
        pair_check(&pair, "quaternions of any length");
        pair_finish(&pair);
    }
}

static void refusals(void **state) {
    (void)state;
    struct ap_error err = {""};
    struct ap_tracker_params params = params_of("h3", 1e-3, AP_TRACKER_ANCHOR);
    struct ap_tracker *tracker = tracker_of(&params);
    struct ap_iso before, after, m = AP_ISO_IDENTITY;
    bool row = false;
    assert_true(feed(tracker, "head", pose_at(0, 0.75, 0.01), &before));
    assert_int_equal(ap_tracker_feed(&err, tracker, "head", pose_at(5, 0, 0), &row, &m), AP_INPUT);
    assert_non_null(strstr(err.text, "too far"));
    assert_int_equal(ap_tracker_feed(NULL, tracker, "head", pose_at(NAN, 0, 0), &row, &m),
                     AP_INPUT);
    assert_memory_equal(&m, &AP_ISO_IDENTITY, sizeof m);
    // The refused samples left nothing behind.
    assert_true(feed(tracker, "head", pose_at(0, 0.75, 0.01), &after));
    assert_memory_equal(&before, &after, sizeof before);
    ap_tracker_destroy(tracker);

    struct ap_tracker *none = NULL;
    params = params_of("h3", NAN, AP_TRACKER_BILLIARDS);
    params.table_edge_m += 1e-6;
    assert_int_equal(ap_tracker_create(&err, &params, &none), AP_USAGE);
    assert_non_null(strstr(err.text, "does not fit"));
    params.table_edge_m = NAN;
    assert_int_equal(ap_tracker_create(&err, &params, &none), AP_USAGE);
    params.kind = AP_TRACKER_NAIVE;
    params.space.rho_m = -1;
    assert_int_equal(ap_tracker_create(&err, &params, &none), AP_USAGE);
    assert_null(none);
    ap_tracker_destroy(NULL);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(strolls),
        cmocka_unit_test(out_and_back),
        cmocka_unit_test(length_of_quaternions),
        cmocka_unit_test(refusals),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
