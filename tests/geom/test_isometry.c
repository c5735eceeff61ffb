#include "tests/geom/check.h"

// The group, checked against routes that share no code with src/geom/isometry.c: reflections in
// points and in planes (Giovagnini 2021, sections 2.4 to 2.6, written for the three curvatures).

static const struct ap_space spaces[] = {{-1, 0.85}, {0, 1.7}, {1, 0.57}};
enum { ROUNDS = 400 };

#define for_each_space(s) for (const struct ap_space *s = spaces; s < spaces + 3; s++)

static double form4(struct ap_space s, const double *a, const double *b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + s.kappa * a[3] * b[3];
}

// x → 2·<x,a>/<a,a>·a − x: the reflection in the point a (sign +1), or with the sign turned and a
// spacelike normal, in the plane across a. Only s3 and h3, where the form is not degenerate.
static struct ap_iso reflection(struct ap_space s, const double *a, int sign) {
    struct ap_iso m;
    double aa = form4(s, a, a);
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++)
            m.m[i][j] = sign * (2 * a[i] * (j == 3 ? s.kappa : 1) * a[j] / aa - (i == j));
    return m;
}

static void normalized(struct ap_space s, double *a) {
    double n = sqrt(fabs(form4(s, a, a)));
    for (int i = 0; i < 4; i++)
        a[i] /= n;
}

// r(m)·r(a), m the midpoint of a and b, both normalised first.
static struct ap_iso by_reflections(struct ap_space s, struct ap_vec4 from, struct ap_vec4 to) {
    double a[4] = {from.x, from.y, from.z, from.w}, b[4] = {to.x, to.y, to.z, to.w}, m[4];
    normalized(s, a);
    normalized(s, b);
    for (int i = 0; i < 4; i++)
        m[i] = a[i] + b[i];
    return ap_iso_mul(reflection(s, m, 1), reflection(s, a, 1));
}

static void test_translation_by_reflections(void **state) {
    (void)state;
    struct ref_random r = {1};
    for (int k = -1; k <= 1; k += 2) {
        struct ap_space s = {k, 0.7};
        for (int i = 0; i < ROUNDS; i++) {
            struct ap_vec3 v = ap_vec3_scale(s.rho_m * ref_uniform(&r, 0, 1.5), ref_direction(&r));
            struct ap_iso got = ap_iso_translate(s, v);
            struct ap_iso other = by_reflections(s, base_point(s), ap_exp(s, v));
            check_iso(&got, &other, 1e-13);
            // From anywhere to anywhere: the same translation carried there.
            struct ap_vec3 q = ap_vec3_scale(s.rho_m * ref_uniform(&r, 0, 1), ref_direction(&r));
            struct ap_iso there = ap_iso_translate(s, q);
            struct ap_iso moved = mul3(there, got, ap_iso_inverse(s, there));
            struct ap_vec4 a = ap_exp(s, q), b = ap_iso_apply(&moved, a);
            other = by_reflections(s, a, b);
            check_iso(&moved, &other, 1e-12);
        }
    }
}

// The rotation about the line through exp(q) along `axis` (carried there by translate(q)): the
// product of the reflections in two planes through the line, half the angle apart.
static void test_rotation_about_a_line(void **state) {
    (void)state;
    struct ref_random r = {2};
    for (int k = -1; k <= 1; k += 2) {
        struct ap_space s = {k, 0.7};
        for (int i = 0; i < ROUNDS; i++) {
            struct ap_vec3 q = ap_vec3_scale(s.rho_m * ref_uniform(&r, 0, 2), ref_direction(&r));
            struct ap_vec3 axis = ref_direction(&r);
            double angle = ref_uniform(&r, -3, 3);
            struct ap_iso there = ap_iso_translate(s, q);
            struct ap_iso got = mul3(there, ap_iso_rotate(ap_quat_from_axis_angle(axis, angle)),
                                     ap_iso_inverse(s, there));
            struct ap_vec3 n1 = ap_vec3_normalize(ap_vec3_cross(axis, ref_direction(&r)));
            struct ap_vec3 n2 = ap_vec3_add(ap_vec3_scale(cos(angle / 2), n1),
                                            ap_vec3_scale(sin(angle / 2), ap_vec3_cross(axis, n1)));
            struct ap_vec4 p1 = ap_iso_apply(&there, (struct ap_vec4){n1.x, n1.y, n1.z, 0});
            struct ap_vec4 p2 = ap_iso_apply(&there, (struct ap_vec4){n2.x, n2.y, n2.z, 0});
            double a[4] = {p1.x, p1.y, p1.z, p1.w}, b[4] = {p2.x, p2.y, p2.z, p2.w};
            struct ap_iso other = ap_iso_mul(reflection(s, b, -1), reflection(s, a, -1));
            check_iso(&got, &other, 2e-12);
            // It leaves the line alone.
            struct ap_iso along = ap_iso_mul(there, ap_iso_translate(s, axis));
            struct ap_vec4 on_line = ap_iso_apply(&along, base_point(s));
            struct ap_vec4 still = ap_iso_apply(&got, on_line);
            check_near(still.x, on_line.x, 1e-12 * fabs(along.m[3][3]) + 1e-13);
            check_near(still.w, on_line.w, 1e-12 * fabs(along.m[3][3]) + 1e-13);
        }
    }
}

static void test_group_laws(void **state) {
    (void)state;
    struct ref_random r = {3};
    for_each_space(s) {
        for (int i = 0; i < ROUNDS; i++) {
            struct ap_vec3 u = ref_direction(&r), v;
            double a = ref_uniform(&r, -2, 2), b = ref_uniform(&r, -2, 2);
            struct ap_iso ta = ap_iso_translate(*s, ap_vec3_scale(a * s->rho_m, u));
            struct ap_iso tb = ap_iso_translate(*s, ap_vec3_scale(b * s->rho_m, u));
            struct ap_iso both = ap_iso_translate(*s, ap_vec3_scale((a + b) * s->rho_m, u));
            struct ap_iso got = ap_iso_mul(ta, tb);
            check_iso(&got, &both, 1e-13);
            struct ap_quat q = random_quat(&r);
            struct ap_iso turn = ap_iso_rotate(q);
            v = ap_vec3_scale(a * s->rho_m, u);
            struct ap_iso turned = ap_iso_translate(*s, ap_quat_rotate(q, v));
            got = mul3(turn, ta, ap_iso_inverse(*s, turn));
            check_iso(&got, &turned, 1e-14);
            struct ap_iso m = ap_iso_from_pose(*s, (struct ap_pose){v, q});
            got = ap_iso_mul(ta, turn);
            check_iso(&m, &got, 0);
            got = ap_iso_mul(m, ap_iso_inverse(*s, m));
            check_iso(&got, &AP_ISO_IDENTITY, 3e-14);
            got = ap_iso_mul(ap_iso_inverse(*s, m), m);
            check_iso(&got, &AP_ISO_IDENTITY, 3e-14);
            check_near(ap_iso_defect(*s, &m), 0, 3e-14);
        }
    }
}

static void test_distance_is_kept(void **state) {
    (void)state;
    struct ref_random r = {4};
    for_each_space(s) {
        for (int i = 0; i < ROUNDS; i++) {
            struct ap_vec3 v = ap_vec3_scale(ref_uniform(&r, 0, 1.5) * s->rho_m, ref_direction(&r));
            struct ap_iso m = ap_iso_from_pose(*s, (struct ap_pose){v, random_quat(&r)});
            struct ap_vec4 p = ap_exp(*s, ap_vec3_scale(s->rho_m, ref_direction(&r)));
            struct ap_vec4 q = ap_exp(*s, ap_vec3_scale(s->rho_m, ref_direction(&r)));
            double before, after;
            assert_int_equal(ap_distance(NULL, *s, p, q, &before), AP_OK);
            assert_int_equal(
                ap_distance(NULL, *s, ap_iso_apply(&m, p), ap_iso_apply(&m, q), &after), AP_OK);
            check_near(after, before, 2e-13);
        }
    }
}

static void test_orthonormalize(void **state) {
    (void)state;
    struct ref_random r = {5};
    for_each_space(s) {
        for (int i = 0; i < ROUNDS; i++) {
            struct ap_vec3 v = ap_vec3_scale(ref_uniform(&r, 0, 2) * s->rho_m, ref_direction(&r));
            struct ap_iso m = ap_iso_from_pose(*s, (struct ap_pose){v, random_quat(&r)}), near = m;
            for (int k = 0; k < 16; k++)
                near.m[k / 4][k % 4] += ref_uniform(&r, -1e-9, 1e-9);
            struct ap_iso back = ap_iso_orthonormalize(*s, near);
            check_near(ap_iso_defect(*s, &back), 0, 2e-14);
            check_iso(&back, &m, 2e-7);
            // The first column is only scaled: where the pose is stays where it is.
            if (s->kappa)
                check_near(back.m[0][3] * near.m[3][3], near.m[0][3] * back.m[3][3], 1e-14);
            // What is on the group stays, in aliased use too.
            m = ap_iso_orthonormalize(*s, m);
            struct ap_iso again = ap_iso_orthonormalize(*s, m);
            check_iso(&again, &m, 2e-14);
        }
    }
}

static void test_defect_sees_each_column(void **state) {
    (void)state;
    for_each_space(s) {
        struct ap_iso m = ap_iso_translate(*s, (struct ap_vec3){0.3, 0.2, -0.4});
        assert_true(ap_iso_defect(*s, &m) < 1e-15);
        for (int k = 0; k < 16; k++) {
            struct ap_iso bad = m;
            bad.m[k / 4][k % 4] += 1e-6;
            bool free_column = s->kappa == 0 && k % 4 == 3 && k != 15;
            check_near(ap_iso_defect(*s, &bad) > 1e-7, !free_column, 0);
        }
    }
}

static void test_inverse_is_as_exact_as_the_matrix(void **state) {
    (void)state;
    struct ap_space s = {-1, 1};
    struct ap_iso far = ap_iso_translate(s, (struct ap_vec3){20, -10, 5});
    struct ap_iso back = ap_iso_translate(s, (struct ap_vec3){-20, 10, -5});
    struct ap_iso got = ap_iso_inverse(s, far);
    check_iso(&got, &back, 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_translation_by_reflections),
        cmocka_unit_test(test_rotation_about_a_line),
        cmocka_unit_test(test_group_laws),
        cmocka_unit_test(test_distance_is_kept),
        cmocka_unit_test(test_orthonormalize),
        cmocka_unit_test(test_defect_sees_each_column),
        cmocka_unit_test(test_inverse_is_as_exact_as_the_matrix),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
