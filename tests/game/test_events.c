#include "tests/game/stage.h"

#include "src/geom/map.h"

static void break_shot(struct ap_physics *ph, double speed) {
    struct ap_strike s = {.direction = ap_physics_toward(ph, 0, 1),
                          .speed_m_s = speed,
                          .right = 0.2,
                          .above = 0.25,
                          .elevation_rad = 0.2};
    strike(ph, 0, &s);
}

// How far anything is over its bound at now: chord² of two balls, cushions; metres.
static double deepest(const struct ap_physics *ph) {
    double worst = 0;
    struct ap_plane3 p[AP_BALLS_MAX];
    for (int i = 0; i < ph->ball_count; i++) {
        if (ph->ball[i].state == AP_BALL_POCKETED)
            continue;
        p[i] = ap_physics_motion(ph, i, ph->now_s).foot_m;
        for (int j = 0; j < i; j++)
            if (ph->ball[j].state != AP_BALL_POCKETED)
                worst = fmax(worst, 2 * ph->rolling_radius_m -
                                        sqrt(ap_plane_chord2(ph->shape.space.kappa, p[i], p[j])));
        for (int k = 0; k < ph->edge_count; k++) {
            const struct ap_plane3 *e = &ph->edge[k];
            worst =
                fmax(worst, ph->edge_height_m - (e->x * p[i].x + e->z * p[i].z + e->w * p[i].w));
        }
        for (int k = 0; k < ph->pocket_count; k++)
            worst = fmax(worst, sqrt(ph->capture_m2) - sqrt(ap_plane_chord2(ph->shape.space.kappa,
                                                                            p[i], ph->pocket[k])));
    }
    return worst;
}

// No event is missed: a dense scan of whole shots, in every space, finds no ball in another, in a
// cushion or in a pocket's mouth.
static void test_nothing_missed(void **state) {
    (void)state;
    for (int kappa = -1; kappa <= 1; kappa++)
        for (int pockets = 0; pockets < 2; pockets++) {
            struct ap_physics_params params = {.no_pockets = !pockets};
            struct ap_physics ph;
            open_table(kappa, &params, &ph);
            set_triangle(&ph, 1.06);
            break_shot(&ph, 7);
            double worst = 0;
            // Times that are nobody's multiples.
            while (!ap_physics_at_rest(&ph) && ph.now_s < 60) {
                ap_physics_advance(&ph, ph.now_s + 0.000917, NULL, NULL);
                worst = fmax(worst, deepest(&ph));
            }
            assert_true(ap_physics_at_rest(&ph));
            assert_true(ph.counters.events > 60);
            print_message("kappa %d, pockets %d: %llu events in %.1f s, deepest %.2g m\n", kappa,
                          pockets, ph.counters.events, ph.now_s, worst);
            check_near(worst, 0, 1e-12);
        }
    // The scan itself sees what it looks for.
    struct ap_physics_params params = {0};
    struct ap_physics ph;
    open_table(0, &params, &ph);
    place(&ph, 0, 0, 0);
    struct ap_plane_frame near = ap_plane_translate(ph.shape.space, (struct ap_plane2){0.057, 0});
    ap_physics_set(&ph, 1, &near, (struct ap_plane2){0, 0}, (struct ap_vec3){0, 0, 0},
                   AP_QUAT_IDENTITY);
    check_near(deepest(&ph), 0.00015, 1e-15);
}

// However the time is cut, the same bits.
static void test_cuts_do_not_matter(void **state) {
    (void)state;
    for (int kappa = -1; kappa <= 1; kappa++) {
        struct ap_physics_params params = {0};
        struct ap_physics a, b;
        open_table(kappa, &params, &a);
        set_triangle(&a, 1.06);
        break_shot(&a, 6);
        b = a;
        ap_physics_advance(&a, 30, NULL, NULL);
        for (int i = 1; i <= 3000; i++)
            ap_physics_advance(&b, i * 0.01, NULL, NULL);
        for (int i = 0; i < 16; i++) {
            assert_int_equal(a.ball[i].state, b.ball[i].state);
            assert_memory_equal(&a.ball[i].world_from_foot, &b.ball[i].world_from_foot,
                                sizeof a.ball[i].world_from_foot);
            assert_memory_equal(&a.ball[i].foot_from_ball, &b.ball[i].foot_from_ball,
                                sizeof a.ball[i].foot_from_ball);
        }
        assert_true(a.counters.events == b.counters.events);
    }
}

// A tight rack, every contact at the same moment: the break of a mirrored rack is mirrored.
static void test_tight_rack(void **state) {
    (void)state;
    struct ap_physics_params params = {.no_pockets = true};
    struct ap_physics ph;
    open_table(0, &params, &ph);
    set_triangle(&ph, 1.0 + 1e-14);
    struct ap_strike s = {.direction = {0, -1, 0}, .speed_m_s = 5};
    strike(&ph, 0, &s);
    ap_physics_advance(&ph, 0.12, NULL, NULL);
    assert_true(ph.counters.rounds >= 5);
    static const int mirror[16] = {0, 1, 3, 2, 6, 5, 4, 10, 9, 8, 7, 15, 14, 13, 12, 11};
    double moved = 0;
    for (int i = 1; i < 16; i++) {
        struct ap_ball_motion a = ap_physics_motion(&ph, i, ph.now_s);
        struct ap_ball_motion b = ap_physics_motion(&ph, mirror[i], ph.now_s);
        check_near(a.foot_m.x, -b.foot_m.x, 1e-8);
        check_near(a.foot_m.z, b.foot_m.z, 1e-8);
        moved += hypot(a.velocity_m_s.x, a.velocity_m_s.z);
    }
    assert_true(moved > 3);
}

// Energy only falls, but for what parts slow contacts; and the frames stay on their group.
static void test_long_game(void **state) {
    (void)state;
    for (int kappa = -1; kappa <= 1; kappa++) {
        struct ap_physics_params params = {.no_pockets = true};
        struct ap_physics ph;
        open_table(kappa, &params, &ph);
        set_triangle(&ph, 1.06);
        uint64_t seed = 3;
        struct ap_physics_event e;
        long events = 0;
        for (int shot = 0; shot < 60; shot++) {
            struct ap_strike s = {.speed_m_s = 0.5 + 6 * random01(&seed),
                                  .right = 0.7 * random01(&seed) - 0.35,
                                  .above = 0.7 * random01(&seed) - 0.35,
                                  .elevation_rad = 0.6 * random01(&seed)};
            s.direction = ap_physics_heading(&ph, 0, 6.28 * random01(&seed));
            strike(&ph, 0, &s);
            double energy = ap_physics_energy(&ph);
            while (ap_physics_next(&ph, ph.now_s + 200, &e)) {
                double now = ap_physics_energy(&ph);
                assert_true(now <= energy + 0.17 * 1.1e-6);
                energy = now;
                assert_true(++events < 100000);
            }
            assert_true(ap_physics_at_rest(&ph));
        }
        double defect = 0;
        for (int i = 0; i < 16; i++) {
            struct ap_iso m = ap_physics_world_from_ball(&ph, i);
            defect = fmax(defect, ap_iso_defect(ph.shape.space, &m));
        }
        print_message("kappa %d: %ld events, defect %.2g\n", kappa, events, defect);
        check_near(defect, 0, 3e-15);
    }
}

struct path {
    int points, events;
    struct ap_plane3 last[AP_BALLS_MAX];
    double worst_step, t[AP_BALLS_MAX];
};

static void path_point(void *data, int ball, double t_s, struct ap_plane3 foot,
                       const struct ap_physics_event *event) {
    struct path *p = data;
    p->points++;
    p->events += event != NULL;
    if (p->t[ball] > 0 && t_s > p->t[ball])
        p->worst_step =
            fmax(p->worst_step, hypot(foot.x - p->last[ball].x, foot.z - p->last[ball].z));
    p->last[ball] = foot;
    p->t[ball] = t_s;
}

// The practice path is the way that the balls then take, and it leaves the balls alone.
static void test_path(void **state) {
    (void)state;
    for (int kappa = -1; kappa <= 1; kappa++) {
        struct ap_physics_params params = {0};
        struct ap_physics ph;
        open_table(kappa, &params, &ph);
        set_triangle(&ph, 1.06);
        break_shot(&ph, 3);
        struct path path = {0};
        const struct ap_path_sink sink = {&path, path_point};
        ap_physics_path(&ph, 60, 0.01, &sink);
        assert_true(path.events > 20 && path.points > 500);
        assert_true(path.worst_step < 0.03);
        assert_true(ph.now_s == 0);
        ap_physics_advance(&ph, 60, NULL, NULL);
        for (int i = 0; i < 16; i++) {
            if (path.t[i] == 0)
                continue;
            struct ap_plane3 end = ap_physics_motion(&ph, i, ph.now_s).foot_m;
            check_near(path.last[i].x, end.x, 1e-15);
            check_near(path.last[i].z, end.z, 1e-15);
        }
    }
}

// A ball that is sent at a pocket falls in, at the mouth; six of them in e3 where asked.
static void test_pockets(void **state) {
    (void)state;
    for (int kappa = -1; kappa <= 1; kappa++) {
        struct ap_physics_params params = {.side_pockets = kappa == 0};
        struct ap_physics ph;
        open_table(kappa, &params, &ph);
        int pockets = ph.shape.sides + (kappa == 0 ? 2 : 0);
        assert_int_equal(ph.pocket_count, pockets);
        for (int k = 0; k < pockets; k++) {
            place(&ph, 0, 0.01, 0.02);
            struct ap_plane3 c = ph.pocket[k], p = ap_physics_motion(&ph, 0, ph.now_s).foot_m;
            struct ap_strike s = {.direction = {c.x - p.x, c.z - p.z, c.w - p.w}, .speed_m_s = 1};
            strike(&ph, 0, &s);
            struct ap_physics_event e;
            do
                assert_true(ap_physics_next(&ph, ph.now_s + 60, &e));
            while (e.kind == AP_EVENT_ROLL);
            assert_int_equal(e.kind, AP_EVENT_POCKET);
            assert_int_equal(e.b, k);
            assert_int_equal(ph.ball[0].pocket, k);
            p = ap_physics_motion(&ph, 0, ph.now_s).foot_m;
            check_near(sqrt(ap_plane_chord2(kappa, p, c)), sqrt(ph.capture_m2), 1e-13);
        }
    }
}

static void expect(enum ap_status got, enum ap_status want, const struct ap_error *err,
                   const char *word) {
    assert_int_equal(got, want);
    if (!strstr(err->text, word))
        fail_msg("'%s' does not say '%s'", err->text, word);
}

static void test_bad_input(void **state) {
    (void)state;
    struct ap_error err = {""};
    struct ap_physics ph;
    struct ap_table_shape shape = ap_table_from_edge(-1, 0.9, 1);
    struct ap_physics_params bad = {.ball_radius_m = 0.5};
    expect(ap_physics_init(&err, &shape, &bad, &ph), AP_USAGE, &err, "do not fit");
    bad = (struct ap_physics_params){.gravity_m_s2 = NAN};
    expect(ap_physics_init(&err, &shape, &bad, &ph), AP_USAGE, &err, "finite");
    bad = (struct ap_physics_params){.side_pockets = true};
    expect(ap_physics_init(&err, &shape, &bad, &ph), AP_USAGE, &err, "side pockets");
    bad = (struct ap_physics_params){.ball_restitution = 1.5};
    expect(ap_physics_init(&err, &shape, &bad, &ph), AP_USAGE, &err, "restitution");
    struct ap_physics_params params = {0};
    open_table(-1, &params, &ph);
    place(&ph, 0, 0, 0);
    expect(ap_physics_place(&err, &ph, 1, (struct ap_plane2){0.03, 0}), AP_INPUT, &err, "ball 0");
    expect(ap_physics_place(&err, &ph, 1, (struct ap_plane2){NAN, 0}), AP_INPUT, &err, "finite");
    expect(ap_physics_place(&err, &ph, 1, (struct ap_plane2){1e9, 0}), AP_INPUT, &err, "table");
    expect(ap_physics_place(&err, &ph, 1, (struct ap_plane2){0, -0.5}), AP_INPUT, &err, "edge 0");
    struct ap_strike s = {.direction = {1, 0, 0}, .speed_m_s = 1};
    expect(ap_physics_strike(&err, &ph, 3, &s), AP_INPUT, &err, "ball 3");
    s.speed_m_s = NAN;
    expect(ap_physics_strike(&err, &ph, 0, &s), AP_INPUT, &err, "finite");
    s.speed_m_s = 1, s.above = 0.7;
    expect(ap_physics_strike(&err, &ph, 0, &s), AP_INPUT, &err, "slips off");
    s.above = 0, s.direction = (struct ap_plane3){0, 0, 0};
    expect(ap_physics_strike(&err, &ph, 0, &s), AP_INPUT, &err, "direction");
    assert_true(ap_physics_at_rest(&ph));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_nothing_missed), cmocka_unit_test(test_cuts_do_not_matter),
        cmocka_unit_test(test_tight_rack),     cmocka_unit_test(test_long_game),
        cmocka_unit_test(test_path),           cmocka_unit_test(test_pockets),
        cmocka_unit_test(test_bad_input)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
