#include "tests/geom/check.h"

#include "src/geom/table.h"

static struct ap_vec4 corner_of(const struct ap_table_shape *t, long long edge, double side) {
    struct ap_iso half = ap_iso_translate(t->space, (struct ap_vec3){side * t->edge_m / 2, 0, 0});
    struct ap_iso frame = ap_iso_mul(ap_table_edge_frame(t, edge), half);
    return ap_iso_apply(&frame, base_point(t->space));
}

static double distance(struct ap_space s, struct ap_vec4 p, struct ap_vec4 q) {
    double d = NAN;
    struct ap_error err = {""};
    if (ap_distance(&err, s, p, q, &d))
        fail_msg("%s", err.text);
    return d;
}

static void test_figures(void **state) {
    (void)state;
    struct ap_table_shape s3 = ap_table_from_edge(1, 0.9, 0), h3 = ap_table_from_edge(-1, 0.9, 0);
    check_near(s3.space.rho_m, 0.572957795130823, 1e-15);
    check_near(s3.inradius_m, 0.352643896827547, 1e-15);
    check_near(h3.space.rho_m, 0.848036510331695, 1e-15);
    check_near(h3.inradius_m, 0.531608361363761, 1e-15);
    struct ap_table_shape e3 = ap_table_from_edge(0, 0.9, 12);
    assert_true(e3.inradius_m == 0.45 && e3.space.rho_m == 12);
    check_near(e3.circumradius_m, 0.45 * sqrt(2), 1e-15);
    assert_int_equal(s3.sides, 3);
    assert_int_equal(e3.sides, 4);
    assert_int_equal(h3.sides, 5);
}

// Edge e ends where edge e + 1 begins, edges are as long as they should be, corners are right
// angles, corners stand at the circumradius; any integer names an edge.
static void test_closed_and_right_angled(void **state) {
    (void)state;
    for (int kappa = -1; kappa <= 1; kappa++) {
        struct ap_table_shape t = ap_table_from_edge(kappa, 0.9, 3);
        struct ap_space s = t.space;
        for (long long e = -7; e < 9; e++) {
            struct ap_vec4 end = corner_of(&t, e, -1), start = corner_of(&t, e, 1);
            check_near(distance(s, end, corner_of(&t, e + 1, 1)), 0, 2e-15);
            check_near(distance(s, start, end), t.edge_m, 2e-15);
            check_near(distance(s, end, base_point(s)), t.circumradius_m, 2e-15);
            // Seen from the corner, its two edges.
            struct ap_iso frame = ap_table_edge_frame(&t, e);
            struct ap_iso half = ap_iso_translate(s, (struct ap_vec3){-t.edge_m / 2, 0, 0});
            struct ap_iso back = ap_iso_inverse(s, ap_iso_mul(frame, half));
            struct ap_vec3 a = ap_log_unchecked(s, ap_iso_apply(&back, start), 0);
            struct ap_vec3 b =
                ap_log_unchecked(s, ap_iso_apply(&back, corner_of(&t, e + 1, -1)), 0);
            check_near(a.x, t.edge_m, 2e-15);
            check_near(b.x, 0, 2e-15);
            check_near(b.z, t.edge_m, 2e-15); // inward is +z
            struct ap_iso same = ap_table_edge_frame(&t, e + 100 * (long long)t.sides);
            check_iso(&frame, &same, 0);
        }
        struct ap_iso first = ap_table_edge_frame(&t, 0);
        assert_true(first.m[2][3] < 0 && first.m[0][3] == 0); // toward −z
        struct ap_iso second = ap_table_edge_frame(&t, 1);
        assert_true(second.m[0][3] < 0); // counterclockwise from above: toward −x
    }
    struct ap_table_shape t = ap_table_from_edge(0, 0.9, 3);
    struct ap_iso last = ap_table_edge_frame(&t, INT64_MIN), zero = ap_table_edge_frame(&t, 0);
    check_iso(&last, &zero, 0); // 2^63 is a multiple of four
}

static void test_edge_of_radius(void **state) {
    (void)state;
    for (int kappa = -1; kappa <= 1; kappa += 2) {
        struct ap_table_shape t = ap_table_from_edge(kappa, 0.37, 0);
        check_near(ap_table_edge_of_radius(t.space), 0.37, 1e-16);
    }
}

static void test_regular_polygons(void **state) {
    (void)state;
    double circum, in;
    struct ap_error err = {""};
    for (int kappa = -1; kappa <= 1; kappa++) {
        struct ap_space s = {kappa, 1.3};
        for (int n = 3; n < 12; n++) {
            double edge = 0.999 * 2 * M_PI * s.rho_m / n;
            if (ap_regular_polygon(&err, s, n, edge, &circum, &in))
                fail_msg("%s", err.text);
            // Two corners an edge apart at the circumradius; their middle at the inradius.
            double a = M_PI / n;
            struct ap_vec3 v = {-sin(a) * circum, 0, -cos(a) * circum}, w = {-v.x, 0, v.z};
            check_near(distance(s, ap_exp(s, v), ap_exp(s, w)), edge, 5e-15);
            struct ap_iso m = ap_iso_mul(ap_iso_translate(s, (struct ap_vec3){0, 0, -in}),
                                         ap_iso_translate(s, (struct ap_vec3){-edge / 2, 0, 0}));
            struct ap_vec4 p = ap_iso_apply(&m, base_point(s));
            check_near(distance(s, p, ap_exp(s, v)), 0, 1e-13);
        }
    }
    const struct ap_space s3 = {1, 1};
    circum = in = 7;
    assert_int_equal(ap_regular_polygon(&err, s3, 5, 2 * M_PI / 5 + 1e-9, &circum, &in), AP_INPUT);
    assert_int_equal(ap_regular_polygon(NULL, s3, 2, 1, &circum, &in), AP_INPUT);
    assert_int_equal(ap_regular_polygon(NULL, s3, 5, 0, &circum, &in), AP_INPUT);
    assert_int_equal(ap_regular_polygon(NULL, s3, 5, NAN, &circum, &in), AP_INPUT);
    assert_true(circum == 7 && in == 7 && err.text[0] != '\0');
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_figures),
        cmocka_unit_test(test_closed_and_right_angled),
        cmocka_unit_test(test_edge_of_radius),
        cmocka_unit_test(test_regular_polygons),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
