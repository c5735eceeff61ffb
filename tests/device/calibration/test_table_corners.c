#include "tests/device/calibration/noise.h"

#include <string.h>

#include "src/device/calibration/table_corners.h"

// Corner k of a table, counterclockwise from above, by the conventions' table frame.
static struct ap_vec3 corner(const struct ap_table_place *t, int k) {
    static const double x[4] = {0.5, 0.5, -0.5, -0.5}, z[4] = {0.5, -0.5, -0.5, 0.5};
    struct ap_quat turn = ap_quat_from_axis_angle((struct ap_vec3){0, 1, 0}, t->yaw_rad);
    struct ap_vec3 local = {t->edge_m * x[k], 0, t->edge_m * z[k]};
    return ap_vec3_add((struct ap_vec3){t->x_m, t->height_m, t->z_m}, ap_quat_rotate(turn, local));
}

static struct ap_table_place random_table(void) {
    return (struct ap_table_place){.x_m = 6 * uniform() - 3,
                                   .z_m = 6 * uniform() - 3,
                                   .yaw_rad = (uniform() - 0.5) * M_PI_2 * 0.999,
                                   .height_m = 0.4 + uniform(),
                                   .edge_m = 0.5 + uniform()};
}

static void check_place(const struct ap_table_place *got, const struct ap_table_place *want,
                        double tolerance) {
    check_near("x", got->x_m, want->x_m, tolerance);
    check_near("z", got->z_m, want->z_m, tolerance);
    check_near("yaw", got->yaw_rad, want->yaw_rad, tolerance);
    check_near("height", got->height_m, want->height_m, tolerance);
    check_near("edge", got->edge_m, want->edge_m, tolerance);
}

// Three corners in every order, and all four in every order.
static void test_exact(void **state) {
    (void)state;
    for (int n = 0; n < 200; n++) {
        struct ap_table_place table = random_table();
        for (int a = 0; a < 4; a++)
            for (int b = 0; b < 4; b++)
                for (int c = 0; c < 4; c++) {
                    if (a == b || b == c || a == c)
                        continue;
                    const struct ap_vec3 touches[4] = {corner(&table, a), corner(&table, b),
                                                       corner(&table, c),
                                                       corner(&table, 6 - a - b - c)};
                    for (int count = 3; count <= 4; count++) {
                        struct ap_error err = {""};
                        struct ap_table_fit fit;
                        if (ap_table_fit(&err, touches, count, 0, &fit))
                            fail_msg("%d%d%d: %s", a, b, c, err.text);
                        check_place(&fit.place, &table, 1e-12);
                        check_near("residual", fit.rms_m, 0, 1e-12);
                        check_near("corner", fit.corner_rad, M_PI_2, 1e-7);
                        assert_null(ap_table_fit_doubt(&fit));
                    }
                }
    }
}

// The scatter of the answer is what the normal equations say.
static void test_noise(void **state) {
    (void)state;
    static const double S = 0.002;
    enum { TRIALS = 20000 };
    double x2 = 0, height2 = 0, yaw2 = 0, known2 = 0;
    struct ap_table_place table = {0.3, -1.2, 0.2, 0.74, 0.9};
    for (int n = 0; n < TRIALS; n++) {
        struct ap_vec3 touches[3];
        struct ap_table_fit fit;
        for (int k = 0; k < 3; k++)
            touches[k] = ap_vec3_add(corner(&table, k), gauss3(S));
        assert_int_equal(ap_table_fit(NULL, touches, 3, 0, &fit), AP_OK);
        x2 += pow(fit.place.x_m - table.x_m, 2) / TRIALS;
        height2 += pow(fit.place.height_m - table.height_m, 2) / TRIALS;
        yaw2 += pow(fit.place.yaw_rad - table.yaw_rad, 2) / TRIALS;
        assert_int_equal(ap_table_fit(NULL, touches, 3, 0.9, &fit), AP_OK);
        check_near("edge as told", fit.place.edge_m, 0.9, 1e-15);
        known2 += pow(fit.place.x_m - table.x_m, 2) / TRIALS;
    }
    check_near("scatter of x", sqrt(x2) / S, sqrt(3.0 / 8), 0.02);
    check_near("scatter of the height", sqrt(height2) / S, sqrt(1.0 / 3), 0.02);
    check_near("scatter of the yaw", sqrt(yaw2) / (S / 0.9), sqrt(3.0) / 2, 0.02);
    assert_true(known2 < x2); // one thing less to find out
}

static void refuse(const struct ap_vec3 *touches, int count, double edge_m, const char *what) {
    struct ap_error err = {""};
    struct ap_table_fit fit = {.rms_m = -1};
    assert_int_equal(ap_table_fit(&err, touches, count, edge_m, &fit), AP_INPUT);
    if (!strstr(err.text, what))
        fail_msg("'%s' says nothing of '%s'", err.text, what);
    assert_true(fit.rms_m == -1);
}

static void test_refused(void **state) {
    (void)state;
    refuse((struct ap_vec3[]){{0, 0, 0}, {1, 0, 0}}, 2, 0, "three or four");
    refuse((struct ap_vec3[]){{0, 0, 0}, {1, 0, 0}, {0, 0, NAN}}, 3, 0, "touch 3");
    refuse((struct ap_vec3[]){{0, 0, 0}, {0, 0, 0}, {0, 0, 0}}, 3, 0, "apart");
    refuse((struct ap_vec3[]){{0, 0, 0}, {9, 0, 0}, {9, 0, 9}}, 3, 0, "apart");
    refuse((struct ap_vec3[]){{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, 3, 0, "square");
    refuse((struct ap_vec3[]){{0, 0, 0}, {1, 0, 0}, {1, 0.5, 1}}, 3, 0, "square");
    refuse((struct ap_vec3[]){{0, 0, 0}, {1, 0, 0}, {1, 0, 1}}, 3, 0.05, "an edge of 0.05 m");
}

static const char *doubt_of(struct ap_vec3 third) {
    struct ap_table_fit fit;
    const struct ap_vec3 touches[3] = {{0, 0.7, 0}, {0.9, 0.7, 0}, third};
    assert_int_equal(ap_table_fit(NULL, touches, 3, 0, &fit), AP_OK);
    const char *doubt = ap_table_fit_doubt(&fit);
    return doubt ? doubt : "none";
}

static void test_doubts(void **state) {
    (void)state;
    assert_string_equal(doubt_of((struct ap_vec3){0.905, 0.705, 0.89}), "none");
    assert_non_null(strstr(doubt_of((struct ap_vec3){0.95, 0.7, 0.9}), "right one"));
    assert_non_null(strstr(doubt_of((struct ap_vec3){0.9, 0.7, 0.87}), "differ"));
    assert_non_null(strstr(doubt_of((struct ap_vec3){0.9, 0.72, 0.9}), "level"));
}

static void test_touches(void **state) {
    (void)state;
    struct ap_touch_finder finder = {.tip_m = {0, -0.02, -0.1}};
    // Held sideways: the tip is at its side. Pressed at 1 s for 0.2 s, with a jitter of 1 mm.
    struct ap_pose pose = {.q = ap_quat_from_axis_angle((struct ap_vec3){0, 1, 0}, M_PI_2)};
    struct ap_vec3 touch = {0, 0, 0};
    int made = 0;
    for (int i = 0; i < 300; i++) {
        bool pressed = i >= 100 && i < 120;
        pose.p = (struct ap_vec3){1 + (i % 2 ? 0.001 : -0.001), 2, pressed ? 3 : 3 + 0.01 * i};
        made +=
            ap_touch_find(&finder, (int64_t)i * 10000000, pose, pressed, &touch) == AP_TOUCH_MADE;
    }
    assert_int_equal(made, 1);
    check_near("x of the tip", touch.x, 0.9, 1e-12);
    check_near("y of the tip", touch.y, 1.98, 1e-12);
    check_near("z of the tip", touch.z, 3, 1e-12);
    // Held for ever: one touch, after half a second. Moved by 5 cm while pressed: none.
    made = 0;
    int moved = 0;
    for (int i = 0; i < 400; i++) {
        pose.p = (struct ap_vec3){i > 250 ? 0.002 * (i - 250) : 0, 0, 0};
        bool pressed = i != 200 && i != 399;
        enum ap_touch_event e = ap_touch_find(&finder, (int64_t)(i + 300) * 10000000, pose,
                                              pressed && (i < 100 || i > 255), &touch);
        made += e == AP_TOUCH_MADE;
        moved += e == AP_TOUCH_MOVED;
    }
    assert_int_equal(made, 1);
    assert_int_equal(moved, 1);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_exact),   cmocka_unit_test(test_noise),
        cmocka_unit_test(test_refused), cmocka_unit_test(test_doubts),
        cmocka_unit_test(test_touches),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
