#include "src/geom/pose.h"
#include "src/track/anchored.h"
#include "tests/track/support.h"

// What the trackers promise to a player (docs/tracking.md), in the words of the paper.

static const char *const spaces[] = {"s3", "e3", "h3"};

// Head and left hand of one tracker over a loop of the head, 0.3 m a side, hands at rest: forward,
// left, back, right in the head's own frame. D = V_head⁻¹·V_hand before and after.
struct loop {
    struct ap_space space;
    struct ap_iso first, last, path; // D and D, and the product of the four translations
};

static struct ap_iso relation(struct ap_tracker *tracker, struct ap_space space,
                              struct ap_pose head, struct ap_pose hand) {
    struct ap_iso v_head, v_hand;
    assert_true(feed(tracker, "head", head, &v_head));
    assert_true(feed(tracker, "left", hand, &v_hand));
    return ap_iso_mul(ap_iso_inverse(space, v_head), v_hand);
}

static struct loop walk_loop(const char *space, enum ap_tracker_kind kind) {
    static const struct ap_vec3 sides[4] = {{0, 0, -0.3}, {-0.3, 0, 0}, {0, 0, 0.3}, {0.3, 0, 0}};
    struct ap_tracker_params params = params_of(space, NAN, kind);
    struct ap_tracker *tracker = tracker_of(&params);
    struct ap_quat q = ap_quat_from_axis_angle((struct ap_vec3){0.36, 0.48, 0.8}, 0.7);
    struct ap_pose head = {{0.5, 1.6, 0.9}, q}, hand = {{0.3, 1.1, 0.5}, {0.5, 0.5, -0.5, 0.5}};
    struct loop loop = {.space = params.space, .path = AP_ISO_IDENTITY};
    loop.first = relation(tracker, params.space, head, hand);
    for (int side = 0; side < 4; side++) {
        struct ap_vec3 from = head.p;
        struct ap_vec3 way = ap_quat_rotate(q, sides[side]);
        for (int i = 1; i <= 30; i++) {
            head.p = ap_vec3_add(from, ap_vec3_scale(i / 30.0, way));
            loop.last = relation(tracker, params.space, head, hand);
        }
        loop.path = ap_iso_mul(loop.path, ap_iso_translate(params.space, sides[side]));
    }
    ap_tracker_destroy(tracker);
    return loop;
}

static void check_loop(struct loop loop, enum ap_tracker_kind kind, const char *space) {
    // D_last·D_first⁻¹: H⁻¹ in naive, the identity in the coherent two.
    struct ap_iso change = ap_iso_mul(loop.last, ap_iso_inverse(loop.space, loop.first));
    struct ap_iso expected =
        kind == AP_TRACKER_NAIVE ? ap_iso_inverse(loop.space, loop.path) : AP_ISO_IDENTITY;
    double miss = largest_difference(&change, &expected);
    double holonomy = largest_difference(&loop.path, &AP_ISO_IDENTITY);
    printf("%s %-9s hand off by %.3g after the loop (|H - 1| %.3g), %.2g from theory\n", space,
           ap_tracker_kind_name(kind), largest_difference(&change, &AP_ISO_IDENTITY), holonomy,
           miss);
    if (!(miss <= 1e-12))
        fail_msg("%s %s: off by %g, tolerance 1e-12", space, ap_tracker_kind_name(kind), miss);
    // The loop means something: theta² and theta³/2 of it, by the sign of the curvature.
    double theta = 0.3 / loop.space.rho_m;
    double turn = loop.path.m[0][2], offset = loop.path.m[0][3];
    if (loop.space.kappa != 0 &&
        !(fabs(fabs(turn) - theta * theta) < 0.35 * theta * theta &&
          fabs(fabs(offset) - theta * theta * theta / 2) < 0.35 * theta * theta * theta))
        fail_msg("%s: the loop turns by %g and ends %g off; expected about %g, %g", space, turn,
                 offset, theta * theta, theta * theta * theta / 2);
}

static void small_square(void **state) {
    (void)state;
    for (int s = 0; s < 3; s++)
        for (int kind = 0; kind < 3; kind++)
            check_loop(walk_loop(spaces[s], (enum ap_tracker_kind)kind), (enum ap_tracker_kind)kind,
                       spaces[s]);
}

static void flat_space_needs_no_tracker(void **state) {
    (void)state;
    struct ap_tracker *trackers[3];
    struct ap_tracker_params params;
    for (int kind = 0; kind < 3; kind++) {
        params = params_of("e3", 0.7, (enum ap_tracker_kind)kind);
        trackers[kind] = tracker_of(&params);
    }
    uint64_t seed = 5;
    struct ap_pose pose = pose_at(0.4, 1.6, 0.3);
    for (int i = 0; i < 3000; i++) {
        pose.p = (struct ap_vec3){2 * noise(&seed), 1 + noise(&seed), 2 * noise(&seed)};
        struct ap_quat turn = {noise(&seed), noise(&seed), noise(&seed), 0.5};
        pose.q = ap_quat_normalize(turn);
        struct ap_pose from_base = pose;
        from_base.p.y -= 0.75;
        struct ap_iso expected = ap_iso_from_pose(params.space, from_base);
        for (int kind = 0; kind < 3; kind++) {
            struct ap_iso m;
            assert_true(feed(trackers[kind], i % 3 ? "left" : "head", pose, &m));
            double miss = largest_difference(&m, &expected);
            if (!(miss <= 3e-15))
                fail_msg("%s, sample %d: %g from the room's pose, tolerance 3e-15",
                         ap_tracker_kind_name((enum ap_tracker_kind)kind), i, miss);
        }
    }
    for (int kind = 0; kind < 3; kind++)
        ap_tracker_destroy(trackers[kind]);
}

static double distance_between(struct ap_space space, struct ap_iso a, struct ap_iso b) {
    struct ap_iso m = ap_iso_mul(ap_iso_inverse(space, a), b);
    double r = hypot(hypot(m.m[0][3], m.m[1][3]), m.m[2][3]);
    return space.rho_m * (space.kappa > 0 ? asin(r) : space.kappa < 0 ? asinh(r) : r);
}

// Steps of a millimetre anywhere outside 0.1 m of the axis: how much longer the virtual one is.
static double worst_stretch(const char *space, double near_m, double far_m, double height_m) {
    struct ap_tracker_params params = params_of(space, NAN, AP_TRACKER_BILLIARDS);
    struct ap_tracker *tracker = tracker_of(&params);
    uint64_t seed = 6;
    double worst = 0;
    for (int i = 0; i < 20000; i++) {
        double r = near_m + (far_m - near_m) * 0.5 * (1 + noise(&seed));
        double angle = 3.141592653589793 * noise(&seed), way = 3.141592653589793 * noise(&seed);
        struct ap_pose pose = pose_at(r * sin(angle), 0.75 + height_m, r * cos(angle));
        struct ap_iso a, b;
        assert_true(feed(tracker, "head", pose, &a));
        pose.p.x += 1e-3 * sin(way);
        pose.p.z += 1e-3 * cos(way);
        assert_true(feed(tracker, "head", pose, &b));
        worst = fmax(worst, distance_between(params.space, a, b) / 1e-3);
    }
    ap_tracker_destroy(tracker);
    return worst;
}

// No step of the head is torn: the conventions' figures for the stretch, with a margin for the
// diagonal of the two directions.
static void continuity(void **state) {
    (void)state;
    static const double rings[][2] = {{0.1, 0.15}, {0.2, 0.3}, {0.45, 1}};
    for (int s = 0; s < 3; s++)
        for (int ring = 0; ring < 3; ring++) {
            double stretch = worst_stretch(spaces[s], rings[ring][0], rings[ring][1], 0.8);
            struct ap_tracker_params params = params_of(spaces[s], NAN, AP_TRACKER_BILLIARDS);
            double d = hypot(0.8, fmax(0.55, 0.45 - rings[ring][0])) / params.space.rho_m;
            double radial = params.space.kappa < 0 ? sinh(d) / d : 1;
            double bound = params.space.kappa == 0
                               ? 1 + 1e-9
                               : 1.1 * hypot(radial, 0.45 / (rings[ring][0] - 0.001) + 1);
            printf("%s, %.2f to %.2f m from the axis: a step grows by up to %.2f (bound %.2f)\n",
                   spaces[s], rings[ring][0], rings[ring][1], stretch, bound);
            if (!(stretch <= bound))
                fail_msg("%s: stretch %g, bound %g", spaces[s], stretch, bound);
        }
}

// The general algorithm with an anchor of one's own: midpoint of head and hand, which moves and
// turns with both. What stands still with respect to the anchor stands still in the curved world.
static void own_anchor(void **state) {
    (void)state;
    for (int s = 0; s < 3; s++) {
        struct ap_space space;
        assert_int_equal(ap_space_from_name(NULL, spaces[s], 0.9, &space), AP_OK);
        struct ap_anchored body;
        struct ap_pose anchor = pose_at(0.1, 1.2, 0.3);
        ap_anchored_init(&body, space, (struct ap_vec3){0, 0, 0}, anchor);
        struct ap_iso at_anchor = ap_anchored_place(&body, anchor);
        struct ap_iso first = ap_iso_from_pose(space, anchor);
        assert_true(largest_difference(&at_anchor, &first) < 1e-15);
        struct ap_pose offset = {{0.2, -0.3, -0.4}, {0.5, 0.5, 0.5, 0.5}};
        struct ap_iso expected = ap_iso_from_pose(space, offset);
        uint64_t seed = 7;
        for (int i = 0; i < 500; i++) {
            anchor.p.x += 0.01 * noise(&seed);
            anchor.p.z += 0.01 * noise(&seed);
            struct ap_quat turn = {0.01 * noise(&seed), 0.02 * noise(&seed), 0, 1};
            anchor.q = ap_quat_normalize(ap_quat_mul(anchor.q, turn));
            ap_anchored_move(&body, anchor);
            struct ap_iso hand = ap_anchored_place(&body, ap_pose_mul(anchor, offset));
            struct ap_iso d = ap_iso_mul(ap_iso_inverse(space, body.world_from_anchor.hi), hand);
            double miss = largest_difference(&d, &expected);
            if (!(miss <= 1e-13))
                fail_msg("%s, frame %d: %g, tolerance 1e-13", spaces[s], i, miss);
        }
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(small_square),
        cmocka_unit_test(flat_space_needs_no_tracker),
        cmocka_unit_test(continuity),
        cmocka_unit_test(own_anchor),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
