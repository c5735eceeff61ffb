#include "tests/geom/check.h"

#include <float.h>
#include <string.h>

// exp, log and distance: inverse to each other, and right or refused at the edges. The accuracy
// itself is measured in test_accuracy.c.

static const struct ap_space spaces[] = {{-1, 0.85}, {0, 1.7}, {1, 0.57}};

#define for_each_space(s) for (const struct ap_space *s = spaces; s < spaces + 3; s++)

static void test_there_and_back(void **state) {
    (void)state;
    struct ref_random r = {1};
    for_each_space(s) {
        for (int i = 0; i < 1000; i++) {
            double t = ref_uniform(&r, 0, s->kappa > 0 ? 3.1 : 6);
            struct ap_vec3 v = ap_vec3_scale(t * s->rho_m, ref_direction(&r)), back, unchecked;
            struct ap_vec4 p = ap_exp(*s, v);
            struct ap_error err = {""};
            if (ap_log_map(&err, *s, p, 0, &back))
                fail_msg("%s", err.text);
            check_near(ap_vec3_length(ap_vec3_sub(back, v)), 0, 4e-15 * (1 + t) * s->rho_m);
            unchecked = ap_log_unchecked(*s, p, 0);
            assert_memory_equal(&back, &unchecked, sizeof back);
            double d;
            assert_int_equal(ap_distance(&err, *s, p, base_point(*s), &d), AP_OK);
            check_near(d, t * s->rho_m, 4e-15 * (1 + t) * s->rho_m);
            struct ap_iso m = ap_iso_translate(*s, v);
            struct ap_vec4 q = ap_iso_apply(&m, base_point(*s));
            check_near(q.x, p.x, 1e-15 * p.w + 1e-15);
            check_near(q.w, p.w, 1e-15 * fabs(p.w) + 1e-15);
        }
    }
}

static void test_long_way_round(void **state) {
    (void)state;
    struct ap_space s = {1, 0.57};
    struct ref_random r = {2};
    for (int i = 0; i < 1000; i++) {
        double t = ref_uniform(&r, 0.01, 3.1);
        struct ap_vec3 u = ref_direction(&r), v;
        struct ap_vec4 p = ap_exp(s, ap_vec3_scale(t * s.rho_m, u));
        assert_int_equal(ap_log_map(NULL, s, p, 1, &v), AP_OK);
        check_near(ap_vec3_length(v), (2 * M_PI - t) * s.rho_m, 4e-15);
        check_near(ap_vec3_dot(v, u) / ap_vec3_length(v), -1, 1e-13);
        struct ap_vec4 q = ap_exp(s, v);
        check_near(q.x, p.x, 4e-15);
        check_near(q.y, p.y, 4e-15);
        check_near(q.z, p.z, 4e-15);
        check_near(q.w, p.w, 4e-15);
    }
}

// Tiny vectors are kept to the last bit, and survive where their squares do not.
static void test_tiny_vectors(void **state) {
    (void)state;
    const double sizes[] = {1e-9, 1e-20, 1e-170, 1e-300, DBL_MIN, 4.9406564584124654e-324};
    for_each_space(s) {
        for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; i++) {
            struct ap_vec3 v = {sizes[i] * s->rho_m, -sizes[i] * s->rho_m, 0}, back;
            struct ap_vec4 p = ap_exp(*s, v);
            assert_true(p.x == v.x && p.y == v.y && p.z == 0 && p.w == s->rho_m);
            assert_int_equal(ap_log_map(NULL, *s, p, 0, &back), AP_OK);
            assert_true(back.x == v.x && back.y == v.y && back.z == 0);
            struct ap_iso m = ap_iso_translate(*s, v);
            check_near(m.m[0][3], v.x / s->rho_m, 3e-16 * sizes[i] + 1e-323);
            check_near(ap_iso_defect(*s, &m), 0, sizes[i]);
        }
    }
}

static void test_origin(void **state) {
    (void)state;
    for_each_space(s) {
        struct ap_vec3 zero = {0, 0, 0}, v = {1, 1, 1};
        struct ap_vec4 p = ap_exp(*s, zero);
        assert_true(p.x == 0 && p.y == 0 && p.z == 0 && p.w == s->rho_m);
        assert_int_equal(ap_log_map(NULL, *s, p, 0, &v), AP_OK);
        assert_true(v.x == 0 && v.y == 0 && v.z == 0);
        struct ap_iso m = ap_iso_translate(*s, zero);
        check_iso(&m, &AP_ISO_IDENTITY, 0);
        m = ap_iso_walk(*s, NULL, 0);
        check_iso(&m, &AP_ISO_IDENTITY, 0);
        double d = -1;
        assert_int_equal(ap_distance(NULL, *s, p, p, &d), AP_OK);
        assert_true(d == 0);
    }
}

// Refused, with a sentence, and the output left alone.
static void refuse_log(struct ap_space s, struct ap_vec4 p, int image, const char *word) {
    struct ap_error err = {""};
    struct ap_vec3 v = {7, 8, 9};
    assert_int_equal(ap_log_map(&err, s, p, image, &v), AP_INPUT);
    assert_true(v.x == 7 && v.y == 8 && v.z == 9);
    if (!strstr(err.text, word))
        fail_msg("'%s' does not say '%s'", err.text, word);
}

static void test_undefined_directions(void **state) {
    (void)state;
    const struct ap_space h3 = {-1, 2}, e3 = {0, 2}, s3 = {1, 2};
    refuse_log(s3, (struct ap_vec4){0, 0, 0, -2}, 0, "antipode");
    refuse_log(s3, (struct ap_vec4){0, 0, 0, -2}, 1, "antipode");
    refuse_log(s3, (struct ap_vec4){0, 0, 0, 2}, 1, "direction");
    refuse_log(s3, (struct ap_vec4){0, 0, 0, 2}, 2, "image");
    refuse_log(s3, (struct ap_vec4){0, 0, 0, 2}, -1, "image");
    refuse_log(e3, (struct ap_vec4){0, 0, 1, 2}, 1, "image");
    refuse_log(h3, (struct ap_vec4){0, 0, 0, 2}, 1, "image");
    // A hair beside the antipode there is a direction.
    struct ap_vec3 v;
    assert_int_equal(ap_log_map(NULL, s3, (struct ap_vec4){0, 1e-300, 0, -2}, 0, &v), AP_OK);
    check_near(v.y, 2 * M_PI, 1e-15);
    assert_int_equal(ap_log_map(NULL, s3, (struct ap_vec4){0, 1e-300, 0, -2}, 1, &v), AP_OK);
    check_near(v.y, -2 * M_PI, 1e-15);
}

static void test_points_off_the_space(void **state) {
    (void)state;
    const struct ap_space h3 = {-1, 2}, e3 = {0, 2}, s3 = {1, 2};
    struct ap_vec3 v;
    const double in = 0.99e-9, out = 1.01e-9, far = hypot(2, 30);
    assert_int_equal(ap_log_map(NULL, h3, (struct ap_vec4){0, 0, 30, far * (1 + in)}, 0, &v), 0);
    refuse_log(h3, (struct ap_vec4){0, 0, 30, far * (1 + out)}, 0, "h3");
    refuse_log(h3, (struct ap_vec4){0, 0, 30, far * (1 - out)}, 0, "h3");
    refuse_log(h3, (struct ap_vec4){0, 0, 0, -2}, 0, "above 0");
    refuse_log(h3, (struct ap_vec4){0, 0, 0, 0}, 0, "above 0");
    assert_int_equal(ap_log_map(NULL, e3, (struct ap_vec4){5, 0, 3, 2 + 2 * in}, 0, &v), 0);
    refuse_log(e3, (struct ap_vec4){5, 0, 3, 2 + 2 * out}, 0, "e3");
    refuse_log(e3, (struct ap_vec4){5, 0, 3, -2}, 0, "e3");
    assert_int_equal(ap_log_map(NULL, s3, (struct ap_vec4){0, 2 + 2 * in, 0, 0}, 0, &v), 0);
    refuse_log(s3, (struct ap_vec4){0, 2 + 2 * out, 0, 0}, 0, "s3");
    refuse_log(s3, (struct ap_vec4){0, 0, 0, 0}, 0, "s3");
    refuse_log(s3, (struct ap_vec4){1e308, 1e308, 1e308, 1e308}, 0, "s3");
    refuse_log(s3, (struct ap_vec4){NAN, 0, 0, 2}, 0, "finite");
    refuse_log(h3, (struct ap_vec4){0, INFINITY, 0, INFINITY}, 0, "finite");
    double d = -1;
    struct ap_error err = {""};
    struct ap_vec4 on = {0, 0, 0, 2}, off = {1, 0, 0, 2};
    assert_int_equal(ap_distance(&err, s3, on, off, &d), AP_INPUT);
    assert_int_equal(ap_distance(NULL, h3, off, on, &d), AP_INPUT);
    assert_true(d == -1 && err.text[0] != '\0');
}

// Far points of h3, to where double itself ends.
static void test_far_points(void **state) {
    (void)state;
    const double sizes[] = {1e20, 1e99, 1e101, 1e200, 1e307};
    for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; i++) {
        struct ap_space s = {-1, 1};
        double x = sizes[i], d, expected = log(x) + log(2);
        struct ap_vec4 p = {x, 0, 0, x}, q = {0, -x, 0, x};
        struct ap_vec3 v;
        assert_int_equal(ap_log_map(NULL, s, p, 0, &v), AP_OK);
        check_near(v.x, expected, 1e-13);
        assert_int_equal(ap_distance(NULL, s, p, base_point(s), &d), AP_OK);
        check_near(d, expected, 1e-12);
        // At a right angle from each other: cosh d = cosh² of the way.
        assert_int_equal(ap_distance(NULL, s, p, q, &d), AP_OK);
        check_near(d, 2 * expected - log(2), 1e-12);
        assert_int_equal(ap_distance(NULL, s, p, p, &d), AP_OK);
        check_near(d, 0, 1e-12);
    }
    struct ap_space small = {-1, 1e-3};
    struct ap_vec3 v;
    assert_int_equal(ap_log_map(NULL, small, (struct ap_vec4){0, 1e307, 0, 1e307}, 0, &v), AP_OK);
    check_near(v.y, 1e-3 * (307 * log(10) + log(2) + 3 * log(10)), 1e-15);
}

static void test_names(void **state) {
    (void)state;
    const char *const names[] = {"h3", "e3", "s3"};
    for (int i = 0; i < 3; i++) {
        struct ap_space s = {5, 5};
        assert_int_equal(ap_space_from_name(NULL, names[i], 2.5, &s), AP_OK);
        assert_int_equal(s.kappa, i - 1);
        assert_true(s.rho_m == 2.5);
        assert_string_equal(ap_space_name(s), names[i]);
    }
    const double bad[] = {0, -1, NAN, INFINITY, -INFINITY};
    for (int i = 0; i < 5; i++) {
        struct ap_space s = {5, 5};
        struct ap_error err = {""};
        assert_int_equal(ap_space_from_name(&err, "h3", bad[i], &s), AP_USAGE);
        assert_true(s.kappa == 5 && err.text[0] != '\0');
    }
    struct ap_space s;
    assert_int_equal(ap_space_from_name(NULL, "H3", 1, &s), AP_USAGE);
    assert_int_equal(ap_space_from_name(NULL, "", 1, &s), AP_USAGE);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_there_and_back),       cmocka_unit_test(test_long_way_round),
        cmocka_unit_test(test_tiny_vectors),         cmocka_unit_test(test_origin),
        cmocka_unit_test(test_undefined_directions), cmocka_unit_test(test_points_off_the_space),
        cmocka_unit_test(test_far_points),           cmocka_unit_test(test_names),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
