#include "src/track/billiards.h"
#include "tests/track/support.h"

// The perimeter coordinate where it is delicate, and the tracker there against its exact twin.

static double coordinate(struct ap_perimeter c) {
    return (double)c.edge + 0.5 - c.across / (2 * c.out);
}

static void check_c(struct ap_perimeter c, double expected) {
    if (!(fabs(coordinate(c) - expected) <= 1e-14))
        fail_msg("c = %.17g, expected %.17g, tolerance 1e-14", coordinate(c), expected);
}

static struct ap_perimeter at(double x, double z) {
    struct ap_perimeter c;
    if (!ap_perimeter_of(x, z, &c))
        fail_msg("(%g, %g) has no place on the perimeter", x, z);
    return c;
}

static void places(void **state) {
    (void)state;
    check_c(at(0, -1), 0.5);
    check_c(at(-1, 0), 1.5);
    check_c(at(0, 1), 2.5);
    check_c(at(1, 0), 3.5);
    check_c(at(-0.5, -1), 0.75);
    check_c(at(-2, 1), 1.75);
    // A corner begins the edge that follows it counterclockwise.
    check_c(at(0.7, -0.7), 0);
    check_c(at(-0.7, -0.7), 1);
    check_c(at(-0.7, 0.7), 2);
    check_c(at(0.7, 0.7), 3);
    assert_int_equal(at(0.7, nextafter(-0.7, 0)).edge, 3);
    assert_int_equal(at(nextafter(0.7, 0), -0.7).edge, 0);
    assert_int_equal(at(5e-324, 5e-324).edge, 3);
    struct ap_perimeter c;
    assert_false(ap_perimeter_of(0, -0.0, &c));
}

static void ties_go_up(void **state) {
    (void)state;
    uint64_t seed = 4;
    for (int i = 0; i < 20000; i++) {
        // Whole numbers up to 2^20, times whole numbers up to 2^30: opposite exactly, by different
        // quotients.
        double x = floor(0x1p20 * noise(&seed)), z = floor(0x1p20 * noise(&seed));
        double k = 1 + floor(0x1p29 * (1 + noise(&seed)));
        if (x == 0 && z == 0)
            continue;
        struct ap_perimeter head = at(x, z), hand = at(-k * x, -k * z);
        int64_t laps = 4 * (int64_t)floor(1e9 * noise(&seed));
        head.edge += laps;
        struct ap_perimeter c = ap_perimeter_unwrap(head, hand);
        if (c.edge != head.edge + 2)
            fail_msg("(%g, %g), times %g: %lld edges ahead, expected 2", x, z, -k,
                     (long long)(c.edge - head.edge));
    }
    // (0.1, −0.3) and (−0.2, 0.6): the same ratio, as doubles.
    assert_int_equal(ap_perimeter_unwrap(at(0.1, -0.3), at(-0.2, 0.6)).edge, 2);
    assert_int_equal(ap_perimeter_unwrap(at(0.3, -1), at(-0.3, 1)).edge, 2);
}

static void neighbours_of_ties(void **state) {
    (void)state;
    // On the far edge the coordinate grows with x: a larger x is more than two edges ahead.
    struct ap_perimeter head = at(0.3, -1);
    assert_int_equal(ap_perimeter_unwrap(head, at(-0.3, 1)).edge, 2);
    assert_int_equal(ap_perimeter_unwrap(head, at(nextafter(-0.3, -1), 1)).edge, 2);
    assert_int_equal(ap_perimeter_unwrap(head, at(nextafter(-0.3, 0), 1)).edge, -2);
    // At scales where products overflow or vanish.
    for (int e = -1040; e <= 1000; e += 340) {
        double f = ldexp(1, e);
        assert_int_equal(ap_perimeter_unwrap(head, at(-0.25 * f, f)).edge, -2);
        assert_int_equal(ap_perimeter_unwrap(head, at(-0.375 * f, f)).edge, 2);
        assert_int_equal(ap_perimeter_unwrap(at(0.25, -1), at(-0.25 * f, f)).edge, 2);
        assert_int_equal(ap_perimeter_unwrap(at(0, -1), at(-0.0, f)).edge, 2);
    }
}

// A scripted sequence through tracker and twin in all spaces; the coordinates are asserted too.
struct event {
    const char *device;
    double x, z, c;
};

static void play(const struct event *events, size_t count, const char *what) {
    static const char *const spaces[] = {"s3", "e3", "h3"};
    for (int s = 0; s < 3; s++) {
        struct ap_tracker_params params = params_of(spaces[s], NAN, AP_TRACKER_BILLIARDS);
        struct pair pair = pair_of(&params);
        for (size_t i = 0; i < count; i++) {
            struct ap_pose pose = pose_at(events[i].x, 1.1, events[i].z);
            pose.q = ap_quat_from_axis_angle((struct ap_vec3){0.6, 0, 0.8}, 0.4);
            pair_feed(&pair, events[i].device, pose);
            double c = exact_coordinate(pair.exact);
            if (!(fabs(c - events[i].c) <= 1e-12))
                fail_msg("%s, sample %zu: c = %.17g, expected %g", what, i, c, events[i].c);
        }
        pair_check(&pair, what);
        pair_finish(&pair);
    }
}

#define PLAY(what, ...)                                                                            \
    do {                                                                                           \
        const struct event events[] = {__VA_ARGS__};                                               \
        play(events, sizeof events / sizeof *events, what);                                        \
    } while (0)

static void sequences(void **state) {
    (void)state;
    PLAY("head over two corners and back", {"head", 0, -1, 0.5}, {"head", -1, -1, 1},
         {"head", -1, 0.5, 1.75}, {"head", -1, 1, 2}, {"head", -1, -1, 1}, {"head", 0, -1, 0.5},
         {"head", 1, -1, 0}, {"head", 1, 0, -0.5}, {"head", 1, 1, -1}, {"head", 0, 1, -1.5},
         {"left", 1, -1, 0}, {"left", 0.5, -1, 0.25}, {"left", -0.25, -1, -3.375});
    PLAY("head jumps across: a tie goes up", {"head", 0.1, -0.3, 1. / 3},
         {"head", -0.2, 0.6, 7. / 3}, {"head", 0.4, -1.2, 13. / 3}, {"head", 1, -1, 4},
         {"head", -1, 1, 6});
    PLAY("a hand opposite the head", {"head", 0.3, -1, 0.35}, {"left", -0.3, 1, 2.35},
         {"left", -0.6, 2, 2.35}, {"left", 0.3, -0.5, 0.2}, {"head", 1, -1, 0}, {"left", -1, 1, 2},
         {"left", -0.9, 1, -1.95});
    PLAY("a hand all the way round", {"head", 0, -1, 0.5}, {"left", -1, 0, 1.5},
         {"left", -0.1, 1, 2.45}, {"left", 0.1, 1, -1.45}, {"left", 1, 0, -0.5},
         {"left", 0, -1, 0.5});
    PLAY("straight above the centre", {"head", 0, 0, 0.5}, {"left", 0, 0, 0.5}, {"left", 0, 1, 2.5},
         {"head", 1, 0, -0.5}, {"head", 0, 0, -0.5}, {"left", 0, 0, -0.5}, {"left", -1, 0, 1.5},
         {"head", 0, 1, -1.5}, {"left", 1, 0.5, -0.75});
    PLAY("the first coordinate", {"head", 1, 0, 3.5}, {"head", 0.5, -1, 4.25},
         {"left", 1, 0.5, 3.25}, {"head", -1, 0, 5.5}, {"left", 0.3, 0, 7.5},
         {"right", 0.3, -0.00001, 3.5 + 0.5 * (0.00001 / 0.3)},
         {"right", 0.3, 0.00001, 7.5 - 0.5 * (0.00001 / 0.3)});
}

static void hands_before_the_head(void **state) {
    (void)state;
    for (int kind = 0; kind < 3; kind++) {
        struct ap_tracker_params params = params_of("h3", NAN, (enum ap_tracker_kind)kind);
        struct pair pair = pair_of(&params);
        bool naive = kind == AP_TRACKER_NAIVE;
        assert_int_equal(pair_feed(&pair, "left", pose_at(0.1, 1, 0.2)), naive);
        assert_int_equal(pair_feed(&pair, "stylus", pose_at(0.1, 1, 0.3)), naive);
        assert_true(pair_feed(&pair, "head", pose_at(0.1, 1.7, 0.9)));
        assert_true(pair_feed(&pair, "left", pose_at(0.1, 1, 0.4)));
        assert_true(pair_feed(&pair, "stylus", pose_at(0.1, 1, 0.1)));
        assert_int_equal(ap_tracker_dropped(pair.tracker), naive ? 0 : 2);
        pair_check(&pair, "hands before the head");
        pair_finish(&pair);
    }
}

// Many laps forth and many back: every edge of both tables meets every other.
static void laps(void **state) {
    (void)state;
    static const char *const spaces[] = {"s3", "e3", "h3"};
    for (int s = 0; s < 3; s++) {
        struct ap_tracker_params params = params_of(spaces[s], NAN, AP_TRACKER_BILLIARDS);
        struct pair pair = pair_of(&params);
        for (int i = 0; i < 2000; i++) {
            double angle = 0.05 * (i < 1500 ? i : 3000 - 3 * (i - 1500));
            struct ap_pose pose = pose_at(-0.8 * sin(angle), 1.6, -0.8 * cos(angle));
            pose.q = ap_quat_from_axis_angle((struct ap_vec3){0, 1, 0}, angle);
            pair_feed(&pair, "head", pose);
            pose.p.y = 0.8;
            pose.p.x *= -cos(0.3 * i);
            pair_feed(&pair, "left", pose);
        }
        pair_check(&pair, "laps");
        pair_finish(&pair);
    }
}

// At the middle of each physical edge, hands on the wood: the virtual hand is at the middle of the
// virtual edge that counting along says, n of them to a lap.
static void hand_on_the_wood(void **state) {
    (void)state;
    static const char *const spaces[] = {"s3", "e3", "h3"};
    static const double dir[4][2] = {{0, -1}, {-1, 0}, {0, 1}, {1, 0}};
    for (int s = 0; s < 3; s++) {
        struct ap_tracker_params params = params_of(spaces[s], NAN, AP_TRACKER_BILLIARDS);
        struct ap_tracker *tracker = tracker_of(&params);
        struct ap_table_shape table =
            ap_table_from_edge(params.space.kappa, params.table_edge_m, params.space.rho_m);
        for (int e = 0; e < 20; e++) {
            double half = params.table_edge_m / 2;
            struct ap_pose pose = pose_at(half * dir[e % 4][0], 0.75, half * dir[e % 4][1]);
            struct ap_iso m, expected = ap_table_edge_frame(&table, e);
            feed(tracker, "head", pose, &m);
            for (int i = 0; i < 4; i++)
                if (!(fabs(m.m[i][3] - expected.m[i][3]) <= 1e-14))
                    fail_msg("%s edge %d, m%d3 = %.17g, expected %.17g, tolerance 1e-14", spaces[s],
                             e, i, m.m[i][3], expected.m[i][3]);
        }
        ap_tracker_destroy(tracker);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(places),
        cmocka_unit_test(ties_go_up),
        cmocka_unit_test(neighbours_of_ties),
        cmocka_unit_test(sequences),
        cmocka_unit_test(hands_before_the_head),
        cmocka_unit_test(laps),
        cmocka_unit_test(hand_on_the_wood),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
