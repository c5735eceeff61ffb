#include "tests/geom/check.h"

#include "src/view/view.h"

// Straight ahead: the signs, limits and refusals; the accuracy is in test_accuracy.c.

static double vergence(int kappa, double rho, enum ap_view_mode mode, double ipd, double d) {
    double angle = NAN;
    struct ap_error err = {""};
    if (ap_vergence_ahead(&err, (struct ap_space){kappa, rho}, mode, ipd, d, &angle))
        fail_msg("%s", err.text);
    return angle;
}

static void test_native_is_euclidean(void **state) {
    (void)state;
    for (int kappa = -1; kappa <= 1; kappa++)
        for (double d = 0.01; d < 3; d *= 2)
            check_near(vergence(kappa, 0.57, AP_VIEW_NATIVE, 0.064, d), 2 * atan(0.032 / d), 0);
}

static void test_tourist_turns_of_s3(void **state) {
    (void)state;
    const double rho = 0.57, ipd = 0.064, quarter = M_PI / 2, far = 2 * atan(sin(0.032 / rho));
    const int sign[4] = {1, -1, 1, -1};
    for (int k = 0; k < 4; k++) {
        double last = INFINITY;
        for (int i = 1; i < 200; i++) {
            double d = rho * quarter * (k + i / 200.0);
            double angle = vergence(1, rho, AP_VIEW_TOURIST, ipd, d);
            if (!(angle * sign[k] > 0) || !(angle < last))
                fail_msg("quarter %d, d %g: vergence %g after %g", k, d, angle, last);
            last = angle;
        }
    }
    // Zero at the quarter turns, from both sides; all the way round at the antipode.
    for (int k = 1; k < 4; k += 2) {
        check_near(vergence(1, rho, AP_VIEW_TOURIST, ipd, rho * quarter * k), 0, 1e-15);
        double step = 1e-6,
               before = vergence(1, rho, AP_VIEW_TOURIST, ipd, rho * (quarter * k - step));
        double after = vergence(1, rho, AP_VIEW_TOURIST, ipd, rho * (quarter * k + step));
        check_near(before, step * far, 1e-9);
        check_near(after, -step * far, 1e-9);
    }
    check_near(vergence(1, rho, AP_VIEW_TOURIST, ipd, rho * (M_PI - 1e-12)), -M_PI, 1e-10);
    check_near(vergence(1, rho, AP_VIEW_TOURIST, ipd, rho * (M_PI + 1e-12)), M_PI, 1e-10);
}

static void test_tourist_floor_of_h3(void **state) {
    (void)state;
    double floor_rad = 2 * atan(sinh(0.032 / 0.85));
    check_near(vergence(-1, 0.85, AP_VIEW_TOURIST, 0.064, 1e4), floor_rad, 1e-16);
    assert_true(vergence(-1, 0.85, AP_VIEW_TOURIST, 0.064, 3) > floor_rad);
    // Eyes that are further apart than a double can say: opposite directions.
    check_near(vergence(-1, 1e-3, AP_VIEW_TOURIST, 1e3, 1), M_PI, 1e-15);
}

static void test_small_next_to_the_radius(void **state) {
    (void)state;
    for (int kappa = -1; kappa <= 1; kappa++) {
        double angle = vergence(kappa, 1e30, AP_VIEW_TOURIST, 0.064, 0.5);
        check_near(angle, 2 * atan(0.064), 0);
        angle = vergence(kappa, 1e300, AP_VIEW_TOURIST, 1e-20, 1e-20);
        check_near(angle, 2 * atan(0.5), 0);
    }
}

static void test_refusals(void **state) {
    (void)state;
    const double bad[] = {0, -0.0, -1, NAN, INFINITY, -INFINITY};
    for (int i = 0; i < 6; i++) {
        for (int kappa = -1; kappa <= 1; kappa++) {
            struct ap_space s = {kappa, 1};
            struct ap_error err = {""};
            double angle = 7;
            assert_int_equal(ap_vergence_ahead(&err, s, AP_VIEW_NATIVE, bad[i], 1, &angle),
                             AP_INPUT);
            assert_int_equal(ap_vergence_ahead(NULL, s, AP_VIEW_TOURIST, 1, bad[i], &angle),
                             AP_INPUT);
            assert_true(angle == 7 && err.text[0] != '\0');
        }
    }
    // The double just below 2·pi is less than 2·pi; the next one is not.
    struct ap_space s3 = {1, 1};
    double angle;
    for (int mode = AP_VIEW_NATIVE; mode <= AP_VIEW_TOURIST; mode++) {
        assert_int_equal(ap_vergence_ahead(NULL, s3, mode, 1, 2 * M_PI, &angle), AP_OK);
        assert_int_equal(ap_vergence_ahead(NULL, s3, mode, 1, nextafter(2 * M_PI, 7), &angle),
                         AP_INPUT);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_native_is_euclidean),
        cmocka_unit_test(test_tourist_turns_of_s3),
        cmocka_unit_test(test_tourist_floor_of_h3),
        cmocka_unit_test(test_small_next_to_the_radius),
        cmocka_unit_test(test_refusals),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
