#include <stdlib.h>
#include <string.h>

#include "src/geom/map.h"
#include "src/track/anchored.h"
#include "src/track/chaperone.h"
#include "src/track/travel.h"
#include "tests/track/support.h"

// Anchors other than the head, and going where the room does not reach.

static const char *const spaces[] = {"s3", "e3", "h3"};

static struct ap_tracker *anchored_by(const char *space, const char *anchor, double radius_m,
                                      struct ap_tracker_params *params) {
    struct ap_error err;
    const struct ap_track_setup setup = {.space = space,
                                         .radius_m = radius_m,
                                         .tracker = AP_TRACKER_ANCHOR,
                                         .table_edge_m = NAN,
                                         .anchor = anchor};
    if (ap_track_setup(&err, &setup, params))
        fail_msg("%s", err.text);
    return tracker_of(params);
}

static struct ap_pose wander(struct ap_pose pose, uint64_t *seed) {
    pose.p.x += 0.02 * noise(seed);
    pose.p.y += 0.01 * noise(seed);
    pose.p.z += 0.02 * noise(seed);
    struct ap_quat turn = {0.02 * noise(seed), 0.03 * noise(seed), 0.01 * noise(seed), 1};
    pose.q = ap_quat_normalize(ap_quat_mul(pose.q, turn));
    return pose;
}

static void near_iso(const char *what, struct ap_iso got, struct ap_iso want, double tolerance) {
    double miss = largest_difference(&got, &want);
    double size = fmax(1, fabs(want.m[3][3]));
    if (!(miss <= tolerance * size))
        fail_msg("%s: %g, tolerance %g", what, miss, tolerance * size);
}

// By any anchor: what every device is to the anchor in the room, it is to the virtual anchor.
static void any_anchor_is_coherent(void **state) {
    (void)state;
    static const char *const anchors[] = {"head", "left", "puck"};
    static const char *const names[] = {"head", "left", "right", "puck"};
    for (int s = 0; s < 3; s++)
        for (int a = 0; a < 3; a++) {
            struct ap_tracker_params params;
            struct ap_tracker *t = anchored_by(spaces[s], anchors[a], 0.8, &params);
            uint64_t seed = 11;
            struct ap_pose pose[4] = {pose_at(0, 1.6, 0), pose_at(-0.3, 1.2, -0.3),
                                      pose_at(0.3, 1.1, -0.4), pose_at(0.2, 1, -1)};
            struct ap_iso world[4], ignored;
            int lead = a == 2 ? 3 : a;
            assert_false(feed(t, names[(lead + 1) % 4], pose[(lead + 1) % 4], &ignored));
            assert_int_equal(ap_tracker_dropped(t), 1);
            for (int frame = 0; frame < 400; frame++) {
                for (int i = 0; i < 4; i++)
                    pose[i] = wander(pose[i], &seed);
                assert_true(feed(t, names[lead], pose[lead], &world[lead]));
                for (int i = 0; i < 4; i++) {
                    assert_int_equal(ap_tracker_leads(t, names[i]), i == lead);
                    if (i != lead)
                        assert_true(feed(t, names[i], pose[i], &world[i]));
                    struct ap_pose d = ap_pose_mul(ap_pose_inverse(pose[lead]), pose[i]);
                    struct ap_iso want = ap_iso_mul(world[lead], ap_iso_from_pose(params.space, d));
                    near_iso(names[i], world[i], want, 4e-15);
                }
            }
            ap_tracker_destroy(t);
        }
}

// "hands": the middle of the two stands to both as in the room.
static void hands_share_an_anchor(void **state) {
    (void)state;
    for (int s = 0; s < 3; s++) {
        struct ap_tracker_params params;
        struct ap_tracker *t = anchored_by(spaces[s], "hands", 0.8, &params);
        uint64_t seed = 12;
        struct ap_pose left = pose_at(-0.2, 1, -0.3), right = pose_at(0.2, 1, -0.3), head;
        struct ap_iso l, r, h;
        assert_false(feed(t, "head", pose_at(0, 1.6, 0), &h));
        assert_false(feed(t, "left", left, &l));
        assert_true(feed(t, "right", right, &r));
        head = pose_at(0, 1.6, 0);
        for (int frame = 0; frame < 300; frame++) {
            left = wander(left, &seed);
            right = wander(right, &seed);
            head = wander(head, &seed);
            assert_true(feed(t, "left", left, &l));
            assert_true(feed(t, "right", right, &r));
            assert_true(feed(t, "head", head, &h));
            // By the same anchor, of its own making.
            struct ap_pose middle = ap_pose_interpolate(left, right, 0.5);
            struct ap_iso m;
            assert_true(ap_tracker_place(t, middle, &m));
            struct ap_pose d = ap_pose_mul(ap_pose_inverse(middle), head);
            near_iso("head", h, ap_iso_mul(m, ap_iso_from_pose(params.space, d)), 4e-14);
            d = ap_pose_mul(ap_pose_inverse(middle), right);
            near_iso("right", r, ap_iso_mul(m, ap_iso_from_pose(params.space, d)), 4e-14);
        }
        ap_tracker_destroy(t);
    }
}

// V·g·m·g⁻¹ with plain matrices, and what hangs on the anchor goes along.
static void carrying(void **state) {
    (void)state;
    for (int s = 0; s < 3; s++) {
        struct ap_tracker_params params;
        struct ap_tracker *t = anchored_by(spaces[s], NULL, 0.8, &params);
        struct ap_error err;
        uint64_t seed = 13;
        struct ap_pose head = pose_at(0.1, 1.6, 0.2), hand = pose_at(0.3, 1.2, -0.3);
        struct ap_pose grip = {{-0.4, 1, 0.3}, ap_quat_normalize((struct ap_quat){1, 2, -1, 3})};
        struct ap_pose motion = {{0.2, -0.1, -0.5},
                                 ap_quat_normalize((struct ap_quat){0, 1, 0, 5})};
        struct ap_iso v, w, hand_before, hand_after;
        assert_int_equal(ap_tracker_carry(&err, t, grip, motion), AP_USAGE);
        for (int i = 0; i < 50; i++) {
            head = wander(head, &seed);
            assert_true(feed(t, "head", head, &v));
        }
        assert_true(feed(t, "left", hand, &hand_before));
        assert_int_equal(ap_tracker_carry(&err, t, grip, motion), AP_OK);
        assert_true(feed(t, "head", head, &w));
        assert_true(feed(t, "left", hand, &hand_after));
        struct ap_iso g = ap_iso_from_pose(params.space, ap_pose_mul(ap_pose_inverse(head), grip));
        struct ap_iso m = ap_iso_mul(g, ap_iso_from_pose(params.space, motion));
        struct ap_iso way = ap_iso_mul(m, ap_iso_inverse(params.space, g));
        near_iso("carried head", w, ap_iso_mul(v, way), 4e-14);
        struct ap_iso d0 = ap_iso_mul(ap_iso_inverse(params.space, v), hand_before);
        struct ap_iso d1 = ap_iso_mul(ap_iso_inverse(params.space, w), hand_after);
        near_iso("hand to head", d1, d0, 4e-14);
        ap_tracker_destroy(t);
        struct ap_tracker_params held = params_of(spaces[s], NAN, AP_TRACKER_BILLIARDS);
        t = tracker_of(&held);
        assert_true(feed(t, "head", head, &v));
        assert_int_equal(ap_tracker_carry(&err, t, grip, motion), AP_USAGE);
        assert_non_null(strstr(err.text, "anchor"));
        ap_tracker_destroy(t);
    }
}

static struct ap_travel_input at(int64_t ms) {
    return (struct ap_travel_input){.t_ns = ms * 1000000,
                                    .room_from_head = {{0.1, 1.6, 0}, {0, 0, 0, 1}},
                                    .room_from_aim = {{0.3, 1.2, -0.2}, {0, 0, 0, 1}}};
}

// A second of flying covers the speed's length whatever the frame rate, and no faster diagonally.
static void flying(void **state) {
    (void)state;
    for (int step_ms = 4; step_ms <= 40; step_ms *= 10) {
        struct ap_travel travel;
        ap_travel_init(&travel, &(struct ap_travel_params){.speed_mps = 1.5});
        double way_m = 0, vignette = 0;
        for (int ms = 0; ms <= 1000; ms += step_ms) {
            struct ap_travel_input in = at(ms);
            in.forward = in.right = 1;
            struct ap_travel_output out = ap_travel_step(&travel, &in);
            assert_int_equal(out.carry, ms > 0);
            assert_true(out.fade == 0 && !out.pointing);
            way_m += out.carry ? ap_vec3_length(out.motion.p) : 0;
            if (out.carry)
                assert_true(out.motion.p.z < 0 && out.motion.p.x > 0);
            vignette = out.vignette;
        }
        if (!(fabs(way_m - 1.5) < 1e-12) || vignette != 1)
            fail_msg("%d ms: %.17g m, vignette %g; expected 1.5 and 1", step_ms, way_m, vignette);
        struct ap_travel_input late = at(60000);
        late.forward = 1;
        double thrown_m = ap_vec3_length(ap_travel_step(&travel, &late).motion.p);
        assert_true(thrown_m < 0.16);
        late.t_ns = INT64_MIN;
        assert_false(ap_travel_step(&travel, &late).carry);
        late.t_ns = INT64_MAX;
        late.forward = NAN;
        assert_false(ap_travel_step(&travel, &late).carry);
    }
}

// Twelve turns of 30° are a whole one, in every space: the vertical is kept.
static void turning(void **state) {
    (void)state;
    for (int s = 0; s < 3; s++) {
        struct ap_tracker_params params;
        struct ap_tracker *t = anchored_by(spaces[s], NULL, 0.8, &params);
        struct ap_travel travel;
        ap_travel_init(&travel, NULL);
        struct ap_pose head = {{0.1, 1.6, 0}, ap_quat_normalize((struct ap_quat){0.3, 0.5, 0, 1})};
        struct ap_iso first, last;
        struct ap_error err;
        assert_true(feed(t, "head", head, &first));
        int turns = 0;
        for (int ms = 0; ms < 12 * 200; ms += 10) {
            struct ap_travel_input in = at(ms);
            in.room_from_head = head;
            in.turn = ms % 200 < 100 ? 1 : 0.05;
            struct ap_travel_output out = ap_travel_step(&travel, &in);
            turns += out.carry;
            if (out.carry)
                assert_int_equal(ap_tracker_carry(&err, t, out.room_from_grip, out.motion), AP_OK);
            if (turns == 3 && out.carry) {
                // A quarter to the right: what was before her is on her left.
                assert_true(feed(t, "head", head, &last));
                struct ap_iso d = ap_iso_mul(ap_iso_inverse(params.space, first), last);
                struct ap_vec3 want = ap_quat_rotate(
                    ap_quat_conj(head.q),
                    ap_quat_rotate(
                        ap_quat_from_axis_angle((struct ap_vec3){0, 1, 0}, -1.5707963267948966),
                        ap_quat_rotate(head.q, (struct ap_vec3){0, 0, -1})));
                double off =
                    hypot(hypot(-d.m[0][2] - want.x, -d.m[1][2] - want.y), -d.m[2][2] - want.z);
                if (!(off < 1e-14))
                    fail_msg("%s: a quarter turn looks %g off", spaces[s], off);
            }
        }
        assert_int_equal(turns, 12);
        assert_true(feed(t, "head", head, &last));
        near_iso("twelve turns", last, first, 1e-14);
        ap_tracker_destroy(t);
    }
}

// Where the geodesic from the aim ends is where the aiming hand is afterwards, in darkness.
static void teleporting(void **state) {
    (void)state;
    for (int s = 0; s < 3; s++) {
        struct ap_tracker_params params;
        struct ap_tracker *t = anchored_by(spaces[s], NULL, 0.8, &params);
        struct ap_travel travel;
        ap_travel_init(&travel, NULL);
        struct ap_iso head, aim, went;
        struct ap_error err;
        double reach_m = 0, darkest = 0;
        int carried = 0;
        for (int ms = 0; ms < 1500; ms += 10) {
            struct ap_travel_input in = at(ms);
            in.point = ms < 600;
            in.forward = ms < 400 ? 1 : 0;
            struct ap_travel_output out = ap_travel_step(&travel, &in);
            assert_true(feed(t, "head", in.room_from_head, &head));
            assert_int_equal(out.pointing, ms <= 600);
            reach_m = out.pointing ? out.reach_m : reach_m;
            darkest = fmax(darkest, out.fade);
            if (!out.carry)
                continue;
            carried++;
            assert_true(out.fade == 1);
            assert_true(feed(t, "right", in.room_from_aim, &aim));
            assert_int_equal(ap_tracker_carry(&err, t, out.room_from_grip, out.motion), AP_OK);
            assert_true(feed(t, "right", in.room_from_aim, &went));
            struct ap_iso way = ap_iso_translate(params.space, (struct ap_vec3){0, 0, -reach_m});
            near_iso("teleport", went, ap_iso_mul(aim, way), 4e-14);
        }
        assert_int_equal(carried, 1);
        assert_true(darkest == 1 && reach_m > 1.5 && travel.phase == AP_TRAVEL_STAY);
        ap_tracker_destroy(t);
    }
    // Cancelled, and the button still held: nothing happens until it is pressed anew.
    struct ap_travel travel;
    ap_travel_init(&travel, NULL);
    int pointing = 0;
    for (int ms = 0; ms < 1000; ms += 10) {
        struct ap_travel_input in = at(ms);
        in.point = ms < 500;
        in.cancel = ms == 300;
        struct ap_travel_output out = ap_travel_step(&travel, &in);
        assert_true(!out.carry && out.fade == 0);
        pointing += out.pointing;
    }
    assert_int_equal(pointing, 31);
}

// A fence where one is near a wall, none in the middle, the same line once, none without bounds.
static void chaperone(void **state) {
    (void)state;
    static struct ap_chaperone_line lines[AP_CHAPERONE_MAX_LINES];
    const struct ap_chaperone room = {.width_m = 3.1, .depth_m = 2.3};
    const struct ap_vec3 middle[] = {{0, 1.6, 0}, {0.2, 1, 0.1}};
    assert_true(ap_chaperone_alarm(&room, middle, 2) == 0);
    assert_int_equal(ap_chaperone_fence(&room, middle, 2, lines), 0);
    const struct ap_vec3 corner[] = {{1.4, 1.6, -1.05}, {1.5, 1.1, -1}, {NAN, 0, 0}};
    double alarm = ap_chaperone_alarm(&room, corner, 3);
    if (!(fabs(alarm - 0.9) < 1e-12))
        fail_msg("alarm %.17g, expected 0.9: 0.05 m from a wall", alarm);
    size_t count = ap_chaperone_fence(&room, corner, 3, lines);
    assert_true(count > 40 && count < AP_CHAPERONE_MAX_LINES);
    for (size_t i = 0; i < count; i++) {
        const struct ap_chaperone_line *l = &lines[i];
        bool on_z = fabs(l->a.z + 1.15) < 1e-12 && fabs(l->b.z + 1.15) < 1e-12;
        bool on_x = fabs(l->a.x - 1.55) < 1e-12 && fabs(l->b.x - 1.55) < 1e-12;
        assert_true(on_z || on_x);
        assert_true(ap_vec3_length(ap_vec3_sub(l->a, l->b)) <= 0.25 + 1e-12);
        assert_true(l->a.y >= 0 && l->b.y <= 2 && l->strength > 0 && l->strength <= 1);
        for (size_t j = 0; j < i; j++)
            if (memcmp(&lines[j], l, sizeof *l) == 0)
                fail_msg("line %zu is line %zu again", i, j);
    }
    const struct ap_vec3 outside[] = {{0, 1.6, 1.5}};
    assert_true(ap_chaperone_alarm(&room, outside, 1) == 1);
    assert_true(ap_chaperone_fence(&room, outside, 1, lines) > 20);
    const struct ap_chaperone none = {0}, wild = {.width_m = 1e300, .depth_m = 1e-3};
    assert_true(ap_chaperone_alarm(&none, outside, 1) == 0);
    assert_int_equal(ap_chaperone_fence(&none, outside, 1, lines), 0);
    assert_true(ap_chaperone_fence(&wild, corner, 3, lines) <= AP_CHAPERONE_MAX_LINES);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(any_anchor_is_coherent),
        cmocka_unit_test(hands_share_an_anchor),
        cmocka_unit_test(carrying),
        cmocka_unit_test(flying),
        cmocka_unit_test(turning),
        cmocka_unit_test(teleporting),
        cmocka_unit_test(chaperone),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
