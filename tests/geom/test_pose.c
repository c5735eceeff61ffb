#include "tests/geom/check.h"

#include "src/geom/pose.h"

enum { ROUNDS = 500 };

static struct ap_pose random_pose(struct ref_random *r) {
    return (struct ap_pose){ap_vec3_scale(ref_uniform(r, 0, 3), ref_direction(r)), random_quat(r)};
}

static void check_vec3(struct ap_vec3 got, struct ap_vec3 expected, double tolerance) {
    check_near(got.x, expected.x, tolerance);
    check_near(got.y, expected.y, tolerance);
    check_near(got.z, expected.z, tolerance);
}

// Poses are the rigid isometries of e3: matrices must say the same.
static void test_poses_are_isometries_of_e3(void **state) {
    (void)state;
    struct ref_random r = {1};
    const struct ap_space e3 = {0, 1};
    for (int i = 0; i < ROUNDS; i++) {
        struct ap_pose a = random_pose(&r), b = random_pose(&r);
        struct ap_iso ma = ap_iso_from_pose(e3, a), mb = ap_iso_from_pose(e3, b);
        struct ap_iso got = ap_iso_from_pose(e3, ap_pose_mul(a, b));
        struct ap_iso expected = ap_iso_mul(ma, mb);
        check_iso(&got, &expected, 1e-14);
        got = ap_iso_from_pose(e3, ap_pose_inverse(a));
        expected = ap_iso_inverse(e3, ma);
        check_iso(&got, &expected, 1e-14);
        struct ap_vec4 p = ap_iso_apply(&ma, (struct ap_vec4){b.p.x, b.p.y, b.p.z, 1});
        check_vec3(ap_pose_apply(a, b.p), (struct ap_vec3){p.x, p.y, p.z}, 1e-14);
        struct ap_pose home = ap_pose_mul(a, ap_pose_inverse(a));
        check_vec3(home.p, (struct ap_vec3){0, 0, 0}, 1e-14);
        check_near(fabs(home.q.w), 1, 1e-15);
    }
}

static void test_rotation_sense(void **state) {
    (void)state;
    struct ap_quat q = ap_quat_from_axis_angle((struct ap_vec3){0, 1, 0}, M_PI / 2);
    check_vec3(ap_quat_rotate(q, (struct ap_vec3){0, 0, -1}), (struct ap_vec3){-1, 0, 0}, 3e-16);
    struct ap_iso a = ap_iso_rotate(q), b = ap_iso_rotate_y(M_PI / 2);
    check_iso(&a, &b, 3e-16);
}

static void test_slerp(void **state) {
    (void)state;
    struct ref_random r = {2};
    for (int i = 0; i < ROUNDS; i++) {
        struct ap_vec3 axis = ref_direction(&r);
        double a = ref_uniform(&r, -1.5, 1.5), b = ref_uniform(&r, -1.5, 1.5);
        double t = ref_uniform(&r, 0, 1);
        if (i % 2)
            b = a + 1e-9 * b; // nearly the same
        struct ap_quat qa = ap_quat_from_axis_angle(axis, a), qb = ap_quat_from_axis_angle(axis, b);
        struct ap_quat expected = ap_quat_from_axis_angle(axis, a + t * (b - a));
        if (i % 3 == 0) // the other sign is the same rotation
            qb = (struct ap_quat){-qb.x, -qb.y, -qb.z, -qb.w};
        struct ap_quat got = ap_quat_slerp(qa, qb, t);
        check_near(got.x, expected.x, 1e-15);
        check_near(got.y, expected.y, 1e-15);
        check_near(got.z, expected.z, 1e-15);
        check_near(got.w, expected.w, 1e-15);
        got = ap_quat_slerp(qa, qa, t);
        assert_memory_equal(&got, &qa, sizeof got);
    }
}

static void test_interpolate(void **state) {
    (void)state;
    struct ap_pose a = {{1, 2, 3}, AP_QUAT_IDENTITY};
    struct ap_pose b = {{3, 2, -1}, ap_quat_from_axis_angle((struct ap_vec3){0, 0, 1}, 1)};
    struct ap_pose middle = ap_pose_interpolate(a, b, 0.25);
    check_vec3(middle.p, (struct ap_vec3){1.5, 2, 2}, 0);
    check_near(middle.q.z, sin(0.125), 1e-16);
    struct ap_pose same = ap_pose_interpolate(a, a, 0.3);
    assert_memory_equal(&same, &a, sizeof a);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_poses_are_isometries_of_e3),
        cmocka_unit_test(test_rotation_sense),
        cmocka_unit_test(test_slerp),
        cmocka_unit_test(test_interpolate),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
