#include "tests/geom/check.h"

// A walk around a loop without turning comes home turned by curvature times the area enclosed.

enum { ROUNDS = 300, MOST_CORNERS = 9 };

struct corner {
    double r, phi; // polar about the base point, in the plane y = 0; r in units of rho
};

static struct ap_vec4 place(struct ap_space s, struct corner c) {
    double r = s.rho_m * c.r;
    return ap_exp(s, (struct ap_vec3){r * cos(c.phi), 0, -r * sin(c.phi)});
}

// Signed excess of the triangle (base point, a, b): the sum of its angles less pi, the other two
// angles by the cotangent rule, so that no matrix and no log goes into it.
static double excess(struct ap_space s, struct corner a, struct corner b) {
    double at_base = remainder(b.phi - a.phi, 2 * M_PI);
    double sa = ap_space_sin(s, a.r), ca = ap_space_cos(s, a.r);
    double sb = ap_space_sin(s, b.r), cb = ap_space_cos(s, b.r);
    double at_a = atan2(sin(at_base) * sb, sa * cb - ca * sb * cos(at_base));
    double at_b = atan2(sin(at_base) * sa, sb * ca - cb * sa * cos(at_base));
    return at_a + at_b + at_base - copysign(M_PI, at_base);
}

static struct ap_iso around(struct ap_space s, const struct corner *corners, int count) {
    struct ap_iso pose = AP_ISO_IDENTITY;
    for (int i = 1; i <= count; i++) {
        struct ap_iso back = ap_iso_inverse(s, pose);
        struct ap_vec3 step;
        struct ap_error err = {""};
        if (ap_log_map(&err, s, ap_iso_apply(&back, place(s, corners[i % count])), 0, &step))
            fail_msg("%s", err.text);
        pose = ap_iso_mul(pose, ap_iso_translate(s, step));
    }
    return pose;
}

static void check_loops(int kappa, double rho_m, double size) {
    struct ap_space s = {kappa, rho_m};
    struct ref_random r = {7};
    for (int i = 0; i < ROUNDS; i++) {
        struct corner corners[MOST_CORNERS] = {{0, 0}};
        int count = 3 + i % (MOST_CORNERS - 2);
        double turn = 0;
        for (int k = 1; k < count; k++)
            corners[k] = (struct corner){ref_uniform(&r, 0.05, size), ref_uniform(&r, -M_PI, M_PI)};
        for (int k = 1; k + 1 < count; k++)
            turn += excess(s, corners[k], corners[k + 1]);
        struct ap_iso home = around(s, corners, count), expected = ap_iso_rotate_y(turn);
        check_iso(&home, &expected, 2e-12);
    }
}

static void test_loops(void **state) {
    (void)state;
    check_loops(-1, 0.85, 1.5);
    check_loops(0, 3, 1.5);
    check_loops(1, 0.57, 1.4);
    check_loops(1, 6e3, 0.3);
}

// A corner of an eighth of the sphere: a quarter turn exactly.
static void test_octant(void **state) {
    (void)state;
    struct ap_space s = {1, 2};
    const double quarter = M_PI / 2;
    struct corner corners[3] = {{0, 0}, {quarter, 0}, {quarter, quarter}};
    struct ap_iso home = around(s, corners, 3), expected = ap_iso_rotate_y(quarter);
    check_iso(&home, &expected, 2e-15);
}

// Forward, left, back and right by theta: a rotation of about kappa·theta² and an offset of about
// theta³/2 on each axis walked; the product itself against 640 bits.
static void test_small_square(void **state) {
    (void)state;
    for (int kappa = -1; kappa <= 1; kappa++) {
        struct ap_space s = {kappa, 0.85};
        for (double theta = 1e-4; theta < 0.2; theta *= 3) {
            double l = theta * s.rho_m;
            struct ap_vec3 steps[4] = {{0, 0, -l}, {-l, 0, 0}, {0, 0, l}, {l, 0, 0}};
            struct ap_iso home = ap_iso_walk(s, steps, 4), plain = AP_ISO_IDENTITY;
            for (int i = 0; i < 4; i++)
                plain = ap_iso_mul(plain, ap_iso_translate(s, steps[i]));
            check_near(ref_walk_error(s, steps, 4, &home), 0, 2e-15);
            check_iso(&plain, &home, 3e-15);
            double fourth = theta * theta * theta * theta;
            check_near(atan2(home.m[0][2], home.m[0][0]), kappa * theta * theta, 2 * fourth);
            check_near(fabs(home.m[0][3]), abs(kappa) * theta * theta * theta / 2, fourth);
            check_near(fabs(home.m[2][3]), abs(kappa) * theta * theta * theta / 2, fourth);
        }
    }
}

static int finish_all(void **state) {
    (void)state;
    ref_finish();
    return 0;
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_loops),
        cmocka_unit_test(test_octant),
        cmocka_unit_test(test_small_square),
    };
    return cmocka_run_group_tests(tests, NULL, finish_all);
}
