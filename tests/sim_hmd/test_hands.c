#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

#include "sim_hmd/input/hand_model.h"

// The made-up hand against what OpenXR says of grips and joints.

static const struct ap_vec3 X = {1, 0, 0}, Y = {0, 1, 0}, Z = {0, 0, 1};
static const int thumb_and_fingers[] = {AP_JOINT_THUMB, AP_JOINT_INDEX, AP_JOINT_MIDDLE,
                                        AP_JOINT_RING, AP_JOINT_LITTLE};

static void check_vec(const char *what, struct ap_vec3 got, struct ap_vec3 expected) {
    double off = ap_vec3_length(ap_vec3_sub(got, expected));
    if (!(off <= 1e-12))
        fail_msg("%s: %.15g %.15g %.15g, expected %.15g %.15g %.15g, tolerance 1e-12", what, got.x,
                 got.y, got.z, expected.x, expected.y, expected.z);
}

// Grip +x goes into the right palm and out of the left one; -z from the little finger to the thumb.
static void the_palm_holds_the_grip(void **state) {
    (void)state;
    const struct ap_pose grip = {{0.3, 1.1, -0.4},
                                 ap_quat_normalize((struct ap_quat){0.2, -0.3, 0.4, 0.8})};
    for (int hand = 0; hand < AP_HAND_COUNT; hand++) {
        struct ap_hand h;
        sim_make_hand(hand, grip, 0, 0, &h);
        double into = hand == AP_HAND_RIGHT ? 1 : -1;
        const struct ap_pose palm = h.joint[AP_JOINT_PALM].pose;
        check_vec("back of the hand", ap_quat_rotate(palm.q, Y),
                  ap_quat_rotate(grip.q, ap_vec3_scale(into, X)));
        check_vec("away from the fingers", ap_quat_rotate(palm.q, Z), ap_quat_rotate(grip.q, Y));
        check_vec("palm", palm.p,
                  ap_vec3_add(grip.p, ap_quat_rotate(grip.q, ap_vec3_scale(0.03 * into, X))));
        struct ap_vec3 across =
            ap_vec3_sub(h.joint[AP_JOINT_INDEX + 1].pose.p, h.joint[AP_JOINT_LITTLE + 1].pose.p);
        assert_true(ap_vec3_dot(across, ap_quat_rotate(grip.q, Z)) < -0.04);
    }
}

static void joints_look_along_their_bones(void **state) {
    (void)state;
    for (int k = 0; k < 8; k++) {
        struct ap_hand h;
        sim_make_hand(k & 1, AP_POSE_IDENTITY, k & 2 ? 1 : 0, k & 4 ? 1 : 0, &h);
        for (int f = 0; f < 5; f++) {
            int first = thumb_and_fingers[f], last = first + (f ? 4 : 3);
            for (int j = first; j < last; j++) {
                const struct ap_hand_joint *a = &h.joint[j], *b = a + 1;
                double bone = ap_vec3_length(ap_vec3_sub(b->pose.p, a->pose.p));
                assert_true(bone > 0.015 && bone < 0.07);
                assert_true(a->radius_m > 0.004 && a->radius_m < 0.03);
                struct ap_vec3 on = ap_quat_rotate(a->pose.q, ap_vec3_scale(-bone, Z));
                check_vec(ap_joint_name(j), ap_vec3_add(a->pose.p, on), b->pose.p);
            }
        }
    }
}

// How far a finger's tip is from the palm.
static double reach(const struct ap_hand *h, int tip) {
    return ap_vec3_length(ap_vec3_sub(h->joint[tip].pose.p, h->joint[AP_JOINT_PALM].pose.p));
}

static void squeeze_and_trigger_close_it(void **state) {
    (void)state;
    struct ap_hand open, trigger, fist;
    sim_make_hand(AP_HAND_RIGHT, AP_POSE_IDENTITY, 0, 0, &open);
    sim_make_hand(AP_HAND_RIGHT, AP_POSE_IDENTITY, 1, 0, &trigger);
    sim_make_hand(AP_HAND_RIGHT, AP_POSE_IDENTITY, 1, 1, &fist);
    for (int f = 1; f < 5; f++) {
        int tip = thumb_and_fingers[f] + 4;
        assert_true(reach(&fist, tip) < 0.8 * reach(&open, tip));
        bool same = reach(&trigger, tip) == reach(&open, tip);
        assert_true(same == (f != 1));
        // Into the palm's side, not through the back of the hand.
        struct ap_vec3 to = ap_vec3_sub(fist.joint[tip].pose.p, fist.joint[0].pose.p);
        assert_true(ap_vec3_dot(to, ap_quat_rotate(fist.joint[0].pose.q, Y)) < -0.01);
    }
}

static void the_left_is_the_rights_mirror_image(void **state) {
    (void)state;
    struct ap_hand l, r;
    sim_make_hand(AP_HAND_LEFT, AP_POSE_IDENTITY, 0.3, 0.6, &l);
    sim_make_hand(AP_HAND_RIGHT, AP_POSE_IDENTITY, 0.3, 0.6, &r);
    for (int j = 0; j < AP_JOINT_COUNT; j++) {
        struct ap_vec3 p = l.joint[j].pose.p; // through the plane between two hands: x
        check_vec(ap_joint_name(j), (struct ap_vec3){-p.x, p.y, p.z}, r.joint[j].pose.p);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_palm_holds_the_grip),
        cmocka_unit_test(joints_look_along_their_bones),
        cmocka_unit_test(squeeze_and_trigger_close_it),
        cmocka_unit_test(the_left_is_the_rights_mirror_image),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
