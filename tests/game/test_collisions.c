#include "tests/game/stage.h"

#include "src/game/contact.h"
#include "src/game/segment.h"
#include "src/geom/map.h"

// Balls touch where their spheres do: the distance of their centres is 2·s.
static void test_contact_distance(void **state) {
    (void)state;
    for (int kappa = -1; kappa <= 1; kappa++) {
        struct ap_physics_params params = frictionless();
        struct ap_physics ph;
        open_table(kappa, &params, &ph);
        place(&ph, 0, 0, 0.2);
        place(&ph, 1, 0.01, 0);
        struct ap_strike s = {.direction = ap_physics_toward(&ph, 0, 1), .speed_m_s = 1};
        strike(&ph, 0, &s);
        struct ap_physics_event e;
        assert_true(ap_physics_next(&ph, 60, &e));
        assert_int_equal(e.kind, AP_EVENT_BALLS);
        struct ap_iso a = ap_physics_world_from_ball(&ph, 0),
                      b = ap_physics_world_from_ball(&ph, 1);
        struct ap_vec4 o = {0, 0, 0, ph.shape.space.rho_m};
        double d = NAN;
        assert_int_equal(
            ap_distance(NULL, ph.shape.space, ap_iso_apply(&a, o), ap_iso_apply(&b, o), &d), AP_OK);
        check_near(d, 2 * ph.params.ball_radius_m, 1e-13);
        // At the cushion the centre is s from the upright plane, here that over the edge itself.
        ph.now_s = 0;
        params.cushion_m = -1;
        open_table(kappa, &params, &ph);
        check_near(ph.edge_height_m, ph.rolling_radius_m, 1e-16);
    }
}

// The body's velocity at the contact, by the Killing field as a 4×4 matrix: (slip, turn) about the
// foot, taken at the point where the balls touch, in the direction t (sideways) or b (up).
static void field_at_contact(const struct ap_physics *ph, struct ap_plane2 v, struct ap_vec3 turn,
                             double *along, double *up) {
    struct ap_space s = ph->shape.space;
    double rho = s.rho_m, R = ph->rolling_radius_m;
    // Contact toward +x of the foot: half the contact distance along, then up.
    double half = ap_plane_distance(s, ph->touch_m2) / 2;
    double up_m = s.kappa > 0   ? rho * asin(tan(ph->params.ball_radius_m / rho))
                  : s.kappa < 0 ? rho * asinh(tanh(ph->params.ball_radius_m / rho))
                                : ph->params.ball_radius_m;
    struct ap_iso to = ap_iso_mul(ap_iso_translate(s, (struct ap_vec3){half, 0, 0}),
                                  ap_iso_translate(s, (struct ap_vec3){0, up_m, 0}));
    struct ap_plane2 slip = {v.x + R * turn.z, v.z - R * turn.x};
    double k[4][4] = {{0, -turn.z, turn.y, slip.x / rho},
                      {turn.z, 0, -turn.x, 0},
                      {-turn.y, turn.x, 0, slip.z / rho},
                      {-s.kappa * slip.x / rho, 0, -s.kappa * slip.z / rho, 0}};
    double w[4];
    for (int i = 0; i < 4; i++) {
        w[i] = 0;
        for (int j = 0; j < 4; j++)
            w[i] += rho * k[i][j] * to.m[j][3];
    }
    *along = *up = 0;
    for (int i = 0; i < 4; i++) {
        double metric = i == 3 ? s.kappa : 1;
        *along += metric * w[i] * to.m[i][2];
        *up += metric * w[i] * to.m[i][1];
    }
}

// Friction's impulse at a touch: along the slip that the exact field gives, at most mu times the
// normal one; the energy it takes is that of the slip it worked against.
static void test_throw(void **state) {
    (void)state;
    for (int kappa = -1; kappa <= 1; kappa++) {
        struct ap_physics_params params = {.no_pockets = true, .ball_friction = 0.06};
        struct ap_physics ph;
        open_table(kappa, &params, &ph);
        double D = ap_plane_distance(ph.shape.space, ph.touch_m2);
        struct ap_plane_frame other = ap_plane_translate(ph.shape.space, (struct ap_plane2){D, 0});
        struct ap_plane2 v = {1.2, 0.5};
        struct ap_vec3 turn = {9, 40, -13};
        ap_physics_set(&ph, 0, &AP_PLANE_FRAME_IDENTITY, v, turn, AP_QUAT_IDENTITY);
        ap_physics_set(&ph, 1, &other, (struct ap_plane2){0, 0}, (struct ap_vec3){0, 0, 0},
                       AP_QUAT_IDENTITY);
        double along, up, energy = ap_physics_energy(&ph);
        field_at_contact(&ph, v, turn, &along, &up);
        struct ap_physics_event e;
        assert_true(ap_physics_next(&ph, 60, &e));
        assert_int_equal(e.kind, AP_EVENT_BALLS);
        check_near(e.speed_m_s, 1.2, 1e-13);
        const struct ap_ball *a = &ph.ball[0], *b = &ph.ball[1];
        check_near(a->velocity_m_s.x, 1.2 * 0.025, 1e-13);
        check_near(b->velocity_m_s.x, 1.2 * 0.975, 1e-13);
        double gamma2 = 1 - kappa * pow(ph.rolling_radius_m / ph.shape.space.rho_m, 2);
        double normal = 0.17 * 0.975 * 1.2 / sqrt(gamma2), push = 0.06 * normal;
        double slip = hypot(along, up);
        // Sideways the second ball is thrown: generalized impulse = field's derivative by V_z.
        check_near(b->velocity_m_s.z, gamma2 * push * along / slip / 0.17, 1e-13);
        check_near(a->velocity_m_s.z, 0.5 - gamma2 * push * along / slip / 0.17, 1e-13);
        // Energy: restitution's share and friction's work, by the slip before and after.
        double along2, up2, along3, up3;
        field_at_contact(&ph, a->velocity_m_s, a->turn_rad_s, &along2, &up2);
        // The other ball sees the contact toward −x: turned half a circle.
        struct ap_plane2 vb = {-b->velocity_m_s.x, -b->velocity_m_s.z};
        struct ap_vec3 tb = {-b->turn_rad_s.x, b->turn_rad_s.y, -b->turn_rad_s.z};
        field_at_contact(&ph, vb, tb, &along3, &up3);
        double mean = ((along + along2 + along3) / 2 * along + (up + up2 - up3) / 2 * up) / slip;
        double lost = 0.25 * 0.17 * (1 - 0.95 * 0.95) * 1.2 * 1.2 + push * mean;
        check_near(energy - ap_physics_energy(&ph), lost, 1e-14);
    }
}

static void wall(struct ap_physics *ph, double e, double mu, struct ap_plane2 v,
                 struct ap_vec3 turn) {
    struct ap_physics_params params = {
        .no_pockets = true, .cushion_restitution = e, .cushion_friction = mu};
    open_table(-1, &params, ph);
    ap_physics_set(ph, 0, &AP_PLANE_FRAME_IDENTITY, v, turn, AP_QUAT_IDENTITY);
}

// A cushion gives the normal speed back by its restitution, and english turns the way off it.
static void test_cushion(void **state) {
    (void)state;
    struct ap_physics ph;
    wall(&ph, 0.8, -1, (struct ap_plane2){0.4, -1}, (struct ap_vec3){0, 0, 0});
    struct ap_plane2 n = {0, -1};
    check_near(ap_cushion_resolve(&ph, &ph.ball[0], n), 1, 1e-15);
    check_near(ph.ball[0].velocity_m_s.z, 0.8, 1e-15);
    check_near(ph.ball[0].velocity_m_s.x, 0.4, 1e-15);
    // Right english (counterclockwise) on a ball that goes to −z throws it to the right, +x.
    wall(&ph, 0.8, 0.2, (struct ap_plane2){0, -1}, (struct ap_vec3){0, 50, 0});
    ap_cushion_resolve(&ph, &ph.ball[0], n);
    assert_true(ph.ball[0].velocity_m_s.x > 0.1 && ph.ball[0].turn_rad_s.y < 50);
}

struct sums {
    double energy, momentum[3];
};

static struct sums sums_of(const struct ap_physics *ph) {
    struct sums s = {.energy = ap_physics_energy(ph)};
    ap_physics_momentum(ph, s.momentum);
    return s;
}

static void set_gas(struct ap_physics *ph, int count) {
    uint64_t seed = 7;
    for (int i = 0; i < count;) {
        struct ap_error err;
        double x = random01(&seed) - 0.5, z = random01(&seed) - 0.5;
        if (ap_physics_place(&err, ph, i, (struct ap_plane2){1.4 * x, 1.4 * z}))
            continue;
        struct ap_plane_frame f = ph->ball[i].world_from_foot;
        struct ap_plane2 v = {2 * random01(&seed) - 1, 2 * random01(&seed) - 1};
        ap_physics_set(ph, i++, &f, v, (struct ap_vec3){0, 0, 0}, AP_QUAT_IDENTITY);
    }
}

// Without friction and cushions, on the whole sphere: energy and the three momenta of SO(3), over
// 1e5 collisions.
static void test_conserved_on_sphere(void **state) {
    (void)state;
    struct ap_physics_params params = frictionless();
    params.no_cushions = true;
    struct ap_physics ph;
    open_table(1, &params, &ph);
    set_gas(&ph, 8);
    struct sums first = sums_of(&ph);
    struct ap_physics_event e;
    for (int i = 0; i < 100000; i++) {
        assert_true(ap_physics_next(&ph, INFINITY, &e));
        assert_int_equal(e.kind, AP_EVENT_BALLS);
    }
    struct sums last = sums_of(&ph);
    double size = 0.17 * 8;
    print_message("energy off by %.2g, momenta by %.2g %.2g %.2g of %.3g\n",
                  last.energy / first.energy - 1, last.momentum[0] - first.momentum[0],
                  last.momentum[1] - first.momentum[1], last.momentum[2] - first.momentum[2], size);
    check_near(last.energy / first.energy, 1, 1e-12);
    for (int k = 0; k < 3; k++)
        check_near(last.momentum[k], first.momentum[k], 1e-12 * size);
}

// With cushions, in every space: energy over 1e5 collisions; and each collision of two balls keeps
// the momenta, so that they change by what cushions do only.
static void test_conserved_with_cushions(void **state) {
    (void)state;
    for (int kappa = -1; kappa <= 1; kappa++) {
        struct ap_physics_params params = frictionless();
        struct ap_physics ph;
        open_table(kappa, &params, &ph);
        set_gas(&ph, 6);
        double energy = ap_physics_energy(&ph), drift[3] = {0};
        double before[3], now[3];
        ap_physics_momentum(&ph, before);
        struct ap_physics_event e;
        long balls = 0;
        for (int i = 0; i < 100000; i++) {
            assert_true(ap_physics_next(&ph, INFINITY, &e));
            ap_physics_momentum(&ph, now);
            if (e.kind == AP_EVENT_BALLS && ph.told_next == ph.told_count) {
                balls++;
                for (int k = 0; k < 3; k++)
                    drift[k] += now[k] - before[k];
            }
            memcpy(before, now, sizeof before);
        }
        print_message("kappa %d: %ld of 100000 between balls; energy off by %.2g, momenta by "
                      "%.2g %.2g %.2g\n",
                      kappa, balls, ap_physics_energy(&ph) / energy - 1, drift[0], drift[1],
                      drift[2]);
        assert_true(balls > 10000);
        check_near(ap_physics_energy(&ph) / energy, 1, 1e-12);
        for (int k = 0; k < 3; k++)
            check_near(drift[k], 0, 1e-12 * 0.17 * 6);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_contact_distance),
                                       cmocka_unit_test(test_throw), cmocka_unit_test(test_cushion),
                                       cmocka_unit_test(test_conserved_on_sphere),
                                       cmocka_unit_test(test_conserved_with_cushions)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
