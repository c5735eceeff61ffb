#include "tests/game/stage.h"

#include "src/game/cue.h"
#include "src/geom/map.h"
#include "src/track/tracker.h"

static const double frame_s = 1.0 / 90;

// Hands on a cue whose tip goes along the ball's axis (dx, dy, dz) at v, meeting the sphere of
// contact at (right, above) at time t = 0; s before or after it.
struct stroke {
    struct ap_space space;
    struct ap_iso ball;
    double v, right, above, elevation, reach;
};

static struct ap_cue_hands hands_at(const struct stroke *s, double t, double noise,
                                    uint64_t *seed) {
    // The cue's line in the ball's own frame: level x to the right, along −z and down.
    struct ap_vec3 k = {0, -sin(s->elevation), -cos(s->elevation)};
    struct ap_vec3 up = {0, cos(s->elevation), -sin(s->elevation)};
    double r = 0.028575 + 0.0058, back = sqrt(1 - s->right * s->right - s->above * s->above);
    struct ap_vec3 tip = ap_vec3_add(
        ap_vec3_add(ap_vec3_scale(s->v * t - back * r, k), (struct ap_vec3){s->right * r, 0, 0}),
        ap_vec3_scale(s->above * r, up));
    struct ap_vec3 shake = {noise * (random01(seed) - 0.5), noise * (random01(seed) - 0.5),
                            noise * (random01(seed) - 0.5)};
    tip = ap_vec3_add(tip, shake);
    // The tip's frame: carried in parallel from the ball's centre, −z along k.
    struct ap_iso turn =
        ap_iso_rotate(ap_quat_from_axis_angle((struct ap_vec3){1, 0, 0}, -s->elevation));
    struct ap_iso world_from_tip =
        ap_iso_mul(ap_iso_mul(s->ball, ap_iso_translate(s->space, tip)), turn);
    struct ap_iso to_right = ap_iso_translate(s->space, (struct ap_vec3){0, 0, s->reach});
    struct ap_iso to_left = ap_iso_translate(s->space, (struct ap_vec3){0, 0, 0.2});
    // How the hands are turned does not matter to a cue in two hands.
    struct ap_iso any = ap_iso_rotate(ap_quat_from_axis_angle((struct ap_vec3){0, 1, 0}, 0.4));
    return (struct ap_cue_hands){.right_tracked = true,
                                 .left_tracked = true,
                                 .world_from_right =
                                     ap_iso_mul(ap_iso_mul(world_from_tip, to_right), any),
                                 .world_from_left = ap_iso_mul(world_from_tip, to_left)};
}

static struct stroke stroke_on(int kappa, double v, double right, double above) {
    struct ap_physics_params params = {0};
    static struct ap_physics ph;
    open_table(kappa, &params, &ph);
    place(&ph, 0, 0.1, 0.05);
    return (struct stroke){.space = ph.shape.space,
                           .ball = ap_cue_ball(&ph, 0),
                           .v = v,
                           .right = right,
                           .above = above,
                           .elevation = 0.15,
                           .reach = 0.75};
}

// Frames from −0.3 s to 0.1 s, not farther than 1.5 m from the contact (s3 is 1.8 m to its
// antipode); `phase` of a frame apart from it. Counts hits.
static int feed(const struct stroke *s, double phase, double noise, struct ap_cue_hit *hit) {
    const struct ap_cue_params params = {0};
    struct ap_cue cue;
    uint64_t seed = 9;
    int hits = 0;
    ap_cue_init(&params, &cue);
    for (int k = -27; k < 9; k++) {
        double t = (k + phase) * frame_s;
        if (fabs(s->v * t) > 1.5)
            continue;
        struct ap_cue_hands hands = hands_at(s, t, noise, &seed);
        hits += ap_cue_feed(&cue, s->space, llround((t + 10) * 1e9), &hands, &s->ball, 0.028575,
                            hit) == AP_CUE_HIT;
    }
    return hits;
}

// Speeds from 0.1 m/s to 15, which skips the ball from frame to frame, any phase, every space: the
// stroke is found once, with its time, place and speed.
static void test_strokes(void **state) {
    (void)state;
    for (int kappa = -1; kappa <= 1; kappa++)
        for (int k = 0; k <= 8; k++)
            for (double phase = 0.03; phase < 1; phase += 0.19) {
                double v = 0.1 * pow(150, k / 8.0);
                struct stroke s = stroke_on(kappa, v, 0.2, -0.3);
                struct ap_cue_hit hit;
                assert_int_equal(feed(&s, phase, 0, &hit), 1);
                check_near(hit.speed_m_s, v, 1e-6 * v);
                check_near((double)hit.t_ns * 1e-9, 10, 2e-9);
                check_near(hit.right, 0.2, 1e-6);
                check_near(hit.above, -0.3, 1e-6);
                check_near(asin(-hit.axis.y), 0.15, 1e-6);
            }
}

// A tracker's noise, ±0.25 mm: the stroke is found once, its speed within 0.1 %.
static void test_noise(void **state) {
    (void)state;
    double worst = 0;
    for (int kappa = -1; kappa <= 1; kappa++)
        for (double phase = 0.01; phase < 1; phase += 0.07) {
            struct stroke s = stroke_on(kappa, 1.2, 0.1, 0.1);
            struct ap_cue_hit hit;
            assert_int_equal(feed(&s, phase, 0.0005, &hit), 1);
            worst = fmax(worst, fabs(hit.speed_m_s / 1.2 - 1));
        }
    print_message("speed off by %.2g at most\n", worst);
    check_near(worst, 0, 0.001);
}

static void test_beside(void **state) {
    (void)state;
    struct ap_cue_hit hit;
    struct stroke s = stroke_on(-1, 2, 0.6, 0);
    assert_int_equal(feed(&s, 0.5, 0, &hit), 0); // a miscue
    s = stroke_on(-1, -2, 0, 0);
    assert_int_equal(feed(&s, 0.5, 0, &hit), 0); // drawn back through the ball
    s = stroke_on(-1, 0.01, 0, 0);
    assert_int_equal(feed(&s, 0.5, 0, &hit), 0); // no more than laid to it
}

// What breaks while striking: NaN, a lost hand, a gap, a jump.
static void test_faults(void **state) {
    (void)state;
    enum { GOOD, LEFT_LOST, RIGHT_LOST, RIGHT_NAN, LEFT_NAN, GAP, JUMP, KINDS };
    for (int kappa = -1; kappa <= 1; kappa++)
        for (int kind = GOOD; kind < KINDS; kind++) {
            struct stroke s = stroke_on(kappa, 1, 0, 0);
            const struct ap_cue_params params = {0};
            struct ap_cue cue;
            struct ap_cue_hit hit = {.speed_m_s = -1};
            uint64_t seed = 1;
            int hits = 0;
            ap_cue_init(&params, &cue);
            for (int k = -27; k < 5; k++) {
                double t = (k + 0.5) * frame_s;
                struct ap_cue_hands h = hands_at(&s, t, 0, &seed);
                bool bad = k >= -2; // from just before the contact on
                if (bad && kind == GAP && k < 0)
                    continue;
                if (bad && kind == GAP)
                    t += 0.2;
                if (bad && kind == LEFT_LOST)
                    h.left_tracked = false;
                if (bad && kind == RIGHT_LOST && k < 1)
                    h.right_tracked = false;
                if (bad && kind == RIGHT_NAN && k < 1)
                    h.world_from_right.m[1][3] = NAN;
                if (bad && kind == LEFT_NAN)
                    h.world_from_left.m[0][0] = NAN;
                if (kind == JUMP) // from far behind to inside the ball and beyond
                    h = hands_at(&s, k < 0 ? t - 2 : t + 0.01, 0, &seed);
                hits += ap_cue_feed(&cue, s.space, llround((t + 10) * 1e9), &h, &s.ball, 0.028575,
                                    &hit) == AP_CUE_HIT;
            }
            int want = kind == GOOD || kind == LEFT_LOST || kind == LEFT_NAN;
            if (hits != want)
                fail_msg("kappa %d, fault %d: %d hits, not %d", kappa, kind, hits, want);
            if (want)
                check_near(hit.speed_m_s, 1, 1e-6);
        }
}

// The stroke on the table is the cue's: direction, elevation and what it then does.
static void test_to_the_table(void **state) {
    (void)state;
    for (int kappa = -1; kappa <= 1; kappa++) {
        struct ap_physics_params params = {0};
        static struct ap_physics ph;
        struct ap_error err = {""};
        struct stroke s = stroke_on(kappa, 1.5, 0.1, 0.2);
        struct ap_cue_hit hit;
        open_table(kappa, &params, &ph);
        place(&ph, 0, 0.1, 0.05);
        assert_int_equal(feed(&s, 0.3, 0, &hit), 1);
        struct ap_strike strike = ap_cue_strike(&ph, 0, &hit);
        check_near(strike.elevation_rad, 0.15, 1e-6);
        assert_int_equal(ap_physics_strike(&err, &ph, 0, &strike), AP_OK);
        // To −z of the ball's own frame, which was carried straight from the centre.
        struct ap_plane3 d = ap_physics_heading(&ph, 0, 0);
        struct ap_plane3 v = ap_physics_motion(&ph, 0, 0).velocity_m_s;
        double speed = sqrt(ap_plane_dot(kappa, v, v));
        check_near(ap_plane_dot(kappa, v, d) / speed, 1, 1e-9);
        assert_true(speed > 1.5 && ap_physics_motion(&ph, 0, 0).spin_rad_s > 1);
    }
}

// Real hands: through the coherent tracker, a ball hung where the cue's tip passes: each fast pass
// strikes once, at the speed the tip has there.
struct pose_row {
    int64_t t_ns;
    struct ap_pose pose;
};

static int read_tum(const char *path, struct pose_row *rows, int most) {
    FILE *f = fopen(path, "r");
    int n = 0;
    char line[512];
    assert_non_null(f);
    while (n < most && fgets(line, sizeof line, f)) {
        double t;
        struct ap_pose p;
        if (line[0] != '#' && sscanf(line, "%lf %lf %lf %lf %lf %lf %lf %lf", &t, &p.p.x, &p.p.y,
                                     &p.p.z, &p.q.x, &p.q.y, &p.q.z, &p.q.w) == 8)
            rows[n++] = (struct pose_row){llround(t * 1e9), p};
    }
    fclose(f);
    return n;
}

enum { ROWS = 3000 };

static void test_real_hands(void **state) {
    (void)state;
    const char *shared = getenv("ANTIPODE_SHARED");
    if (!shared) {
        print_message("skipped: ANTIPODE_SHARED is not set\n");
        skip();
    }
    static struct pose_row row[3][ROWS];
    static const char *const names[3] = {"head", "left", "right"};
    int n = ROWS;
    for (int i = 0; i < 3; i++) {
        char path[512];
        snprintf(path, sizeof path, "%s/data/poses/quest2_beatsaber_%s.tum", shared, names[i]);
        int count = read_tum(path, row[i], ROWS);
        n = count < n ? count : n;
    }
    assert_true(n > 1000);
    struct ap_table_shape t = ap_table_from_edge(-1, 0.9, 1);
    const struct ap_tracker_params tracker_params = {.kind = AP_TRACKER_BILLIARDS,
                                                     .space = t.space,
                                                     .table_height_m = 0.75,
                                                     .table_edge_m = 0.9};
    struct ap_error err = {""};
    struct ap_tracker *tracker = NULL;
    assert_int_equal(ap_tracker_create(&err, &tracker_params, &tracker), AP_OK);
    static struct ap_cue_hands hands[ROWS];
    static struct ap_iso tip[ROWS];
    const struct ap_cue_params params = {0};
    struct ap_cue cue;
    ap_cue_init(&params, &cue);
    for (int k = 0; k < n; k++)
        for (int i = 0; i < 3; i++) {
            struct ap_iso m;
            bool has_row;
            assert_int_equal(ap_tracker_feed(&err, tracker, names[i], row[i][k].pose, &has_row, &m),
                             AP_OK);
            hands[k].right_tracked = hands[k].left_tracked = true;
            if (i == 1)
                hands[k].world_from_left = m;
            if (i == 2)
                hands[k].world_from_right = m;
            if (i == 2)
                assert_true(ap_cue_pose(&cue, t.space, &hands[k], &tip[k]));
        }
    ap_tracker_destroy(tracker);
    int struck = 0, offered = 0;
    for (int k = 60; k + 60 < n; k += 37) {
        // The tip's own step, along the cue.
        struct ap_iso step = ap_iso_mul(ap_iso_inverse(t.space, tip[k - 1]), tip[k + 1]);
        double dt = (double)(row[2][k + 1].t_ns - row[2][k - 1].t_ns) * 1e-9;
        double along = -step.m[2][3] * t.space.rho_m / dt;
        struct ap_vec3 way = {step.m[0][3], step.m[1][3], step.m[2][3]};
        if (!(along > 0.2) || !(dt > 0) || dt > 0.05)
            continue;
        offered++;
        struct ap_cue_hit hit;
        int hits = 0;
        // Where the tip goes next, just touching at k.
        way = ap_vec3_scale((0.028575 + 0.0058) / ap_vec3_length(way), way);
        struct ap_iso ahead = ap_iso_mul(tip[k], ap_iso_translate(t.space, way));
        ap_cue_init(&params, &cue);
        for (int j = k - 40; j <= k + 3; j++)
            if (ap_cue_feed(&cue, t.space, row[2][j].t_ns, &hands[j], &ahead, 0.028575, &hit) !=
                AP_CUE_NOTHING) {
                hits++;
                assert_true(isfinite(hit.speed_m_s) && hit.speed_m_s > 0 && hit.speed_m_s < 20);
            }
        struck += hits > 0;
        assert_true(hits <= 2);
    }
    print_message("%d of %d forward passes of the tip touch\n", struck, offered);
    assert_true(offered >= 5 && struck * 10 >= offered * 8);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_strokes),      cmocka_unit_test(test_noise),
        cmocka_unit_test(test_beside),       cmocka_unit_test(test_faults),
        cmocka_unit_test(test_to_the_table), cmocka_unit_test(test_real_hands)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
