#include "tests/game/stage.h"

#include "src/game/segment.h"
#include "src/geom/map.h"

// A shot through the middle slides, then rolls, on a geodesic: times and ways in closed form.
static void test_straight_shot(void **state) {
    (void)state;
    for (int kappa = -1; kappa <= 1; kappa++) {
        struct ap_physics_params params = {.no_pockets = true};
        struct ap_physics ph;
        open_table(kappa, &params, &ph);
        place(&ph, 0, 0.05, 0.2 * ph.shape.inradius_m);
        struct ap_plane3 from = ap_physics_motion(&ph, 0, 0).foot_m;
        struct ap_strike s = {.direction = ap_physics_heading(&ph, 0, 0.3), .speed_m_s = 0.25};
        strike(&ph, 0, &s);
        double v = ap_plane2_length(ph.ball[0].velocity_m_s);
        check_near(v, 1.75 * 0.25 / (0.17 / 0.54 + 1), 1e-14);
        double t = 2 * v / (7 * 0.2 * 9.81), way = v * t - 0.5 * 0.2 * 9.81 * t * t;
        struct ap_physics_event e;
        assert_true(ap_physics_next(&ph, 60, &e));
        assert_int_equal(e.kind, AP_EVENT_ROLL);
        check_near(e.t_s, t, 1e-15);
        check_near(ap_plane2_length(ph.ball[0].velocity_m_s), 5 * v / 7, 1e-14);
        // Rolling: the turn about the point of contact is V/(rho·tan_kappa(s/rho)).
        double q = hypot(ph.ball[0].turn_rad_s.x, ph.ball[0].turn_rad_s.z);
        check_near(q * ph.rolling_radius_m, 5 * v / 7, 1e-14);
        assert_true(ap_physics_next(&ph, 60, &e));
        assert_int_equal(e.kind, AP_EVENT_STOP);
        way += 25.0 / 49 * v * v / (2 * 0.01 * 9.81);
        struct ap_plane3 to = ap_physics_motion(&ph, 0, ph.now_s).foot_m;
        check_near(ap_plane_distance(ph.shape.space, ap_plane_chord2(kappa, from, to)), way, 1e-13);
        assert_true(ap_physics_at_rest(&ph));
        // On the geodesic that the heading names: the side distance from it is zero.
        struct ap_plane3 d = s.direction;
        double side = from.x * (d.z * to.w - d.w * to.z) - from.z * (d.x * to.w - d.w * to.x) +
                      from.w * (d.x * to.z - d.z * to.x);
        check_near(side / ph.shape.space.rho_m, 0, 1e-14);
    }
}

// The foot's frame by 4th-order Runge-Kutta: another way to the same curve.
static void rk_slope(struct ap_space s, const double f[3][3], double vx, double vz,
                     double d[3][3]) {
    for (int r = 0; r < 3; r++) {
        d[r][0] = -s.kappa * f[r][2] * vx / s.rho_m;
        d[r][1] = -s.kappa * f[r][2] * vz / s.rho_m;
        d[r][2] = (f[r][0] * vx + f[r][1] * vz) / s.rho_m;
    }
}

static void rk_step(struct ap_space s, double f[3][3], struct ap_plane2 v, struct ap_plane2 a,
                    double h) {
    double k[4][3][3], g[3][3];
    const double at[4] = {0, 0.5, 0.5, 1}, weight[4] = {1 / 6.0, 1 / 3.0, 1 / 3.0, 1 / 6.0};
    for (int i = 0; i < 4; i++) {
        for (int r = 0; r < 9; r++)
            g[r / 3][r % 3] = f[r / 3][r % 3] + (i ? at[i] * h * k[i - 1][r / 3][r % 3] : 0);
        rk_slope(s, (const double(*)[3])g, v.x + a.x * at[i] * h, v.z + a.z * at[i] * h, k[i]);
    }
    for (int i = 0; i < 4; i++)
        for (int r = 0; r < 9; r++)
            f[r / 3][r % 3] += h * weight[i] * k[i][r / 3][r % 3];
}

// A slide across its spin bends; the series is held against the integration.
static void test_curved_slide(void **state) {
    (void)state;
    for (int kappa = -1; kappa <= 1; kappa++) {
        struct ap_physics_params params = {.no_pockets = true, .no_cushions = kappa > 0};
        struct ap_physics ph;
        open_table(kappa, &params, &ph);
        ap_physics_set(&ph, 0, &AP_PLANE_FRAME_IDENTITY, (struct ap_plane2){0.4, -0.3},
                       (struct ap_vec3){30, 20, 25}, AP_QUAT_IDENTITY);
        struct ap_ball b = ph.ball[0];
        assert_false(b.straight);
        assert_true(b.state == AP_BALL_SLIDING);
        double f[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
        enum { STEPS = 4000 };
        double t = fmin(b.t_end_s, 0.3), h = t / STEPS;
        struct ap_plane2 v = b.velocity_m_s;
        for (int i = 0; i < STEPS; i++) {
            rk_step(ph.shape.space, f, v, b.acceleration_m_s2, h);
            v = ap_plane2_add(v, h, b.acceleration_m_s2);
        }
        struct ap_plane3 foot, velocity;
        ap_segment_at(&ph, &ph.ball[0], t, &foot, &velocity);
        double rho = ph.shape.space.rho_m;
        check_near(foot.x, rho * f[0][2], 2e-14);
        check_near(foot.z, rho * f[1][2], 2e-14);
        check_near(foot.w, rho * f[2][2], 2e-14);
        check_near(velocity.x, f[0][0] * v.x + f[0][1] * v.z, 1e-13);
        // Friction takes what it does on the way: power is -mu·m·g·|slip|.
        double before = ap_physics_energy(&ph), u = ap_plane2_length(ap_slip_of(&ph, &b));
        ph.now_s = t;
        double a = 0.2 * 9.81, lost = 0.17 * a * (u * t - 0.5 * 3.5 * a * t * t);
        double spin = 20 - t * 2.5 * 0.0127 * 9.81 / ph.rolling_radius_m;
        double inertia = 0.4 * 0.17 * ph.rolling_radius_m * ph.rolling_radius_m;
        lost += 0.5 * inertia * (400 - spin * spin);
        check_near(before - ap_physics_energy(&ph), lost, 1e-14);
    }
}

// A long curved slide is several series; it ends where a Runge-Kutta of the whole does.
static void test_long_slide(void **state) {
    (void)state;
    struct ap_physics_params params = {.no_cushions = true, .no_pockets = true};
    struct ap_physics ph;
    open_table(1, &params, &ph);
    ap_physics_set(&ph, 0, &AP_PLANE_FRAME_IDENTITY, (struct ap_plane2){5, 1},
                   (struct ap_vec3){-150, 0, 200}, AP_QUAT_IDENTITY);
    struct ap_ball b = ph.ball[0];
    double u = ap_plane2_length(ap_slip_of(&ph, &b)), t = u / (3.5 * 0.2 * 9.81);
    assert_true(b.t_end_s < t); // more than one series
    struct ap_physics_event e;
    assert_true(ap_physics_next(&ph, 60, &e));
    assert_int_equal(e.kind, AP_EVENT_ROLL);
    check_near(e.t_s, t, 1e-13);
    double f[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    struct ap_plane2 v = b.velocity_m_s;
    for (int i = 0; i < 40000; i++) {
        rk_step(ph.shape.space, f, v, b.acceleration_m_s2, t / 40000);
        v = ap_plane2_add(v, t / 40000, b.acceleration_m_s2);
    }
    struct ap_plane3 foot = ap_physics_motion(&ph, 0, e.t_s).foot_m;
    check_near(foot.x, ph.shape.space.rho_m * f[0][2], 1e-12);
    check_near(foot.z, ph.shape.space.rho_m * f[1][2], 1e-12);
}

// What is drawn follows from what is said: the material point at the contact moves with the slip.
static void test_orientation(void **state) {
    (void)state;
    for (int kappa = -1; kappa <= 1; kappa++) {
        struct ap_physics_params params = {.no_pockets = true};
        struct ap_physics ph;
        open_table(kappa, &params, &ph);
        struct ap_vec3 turn = {12, 9, -7};
        ap_physics_set(&ph, 0, &AP_PLANE_FRAME_IDENTITY, (struct ap_plane2){0.3, 0.2}, turn,
                       (struct ap_quat){0.5, 0.5, -0.5, 0.5});
        struct ap_plane2 slip = ap_slip_of(&ph, &ph.ball[0]);
        double h = 1e-5, rho = ph.shape.space.rho_m;
        ph.now_s = h;
        struct ap_iso later = ap_physics_world_from_ball(&ph, 0);
        ph.now_s = 0;
        struct ap_iso first = ap_physics_world_from_ball(&ph, 0);
        struct ap_iso back = ap_iso_inverse(ph.shape.space, first);
        struct ap_iso motion = ap_iso_mul(later, back);
        struct ap_vec4 p = ap_iso_apply(&motion, (struct ap_vec4){0, 0, 0, rho});
        // Acceleration makes half of mu·g·(1 + 5/2)·h and the turn of the slip as much again.
        check_near(p.x / h, slip.x, 2e-3);
        check_near(p.z / h, slip.z, 2e-3);
        check_near(p.y / h, 0, 2e-3);
        check_near((motion.m[2][1] - motion.m[1][2]) / (2 * h), turn.x, 2e-2);
        check_near((motion.m[0][2] - motion.m[2][0]) / (2 * h), turn.y, 2e-2);
        check_near((motion.m[1][0] - motion.m[0][1]) / (2 * h), turn.z, 2e-2);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_straight_shot), cmocka_unit_test(test_curved_slide),
        cmocka_unit_test(test_long_slide), cmocka_unit_test(test_orientation)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
