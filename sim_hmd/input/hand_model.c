#include "sim_hmd/input/hand_model.h"

#include <math.h>

// The hand's own axes: the wrist is the origin, -z toward the fingers, +y out of the back of the
// hand, +x right; a right hand. The left one is its mirror image.

enum { BONES = 4 };

struct finger {
    int first; // joint: its metacarpal
    int bones; // between its joints
    struct ap_vec3 root;
    double yaw_rad, roll_rad; // of the metacarpal
    double length_m[BONES];   // the metacarpal's first
    double relaxed_rad[BONES], closed_rad[BONES];
    double radius_m[BONES + 1];
};

static const struct finger fingers[] = {
    {AP_JOINT_THUMB,
     3,
     {-0.025, -0.018, -0.035},
     0.7,
     -0.9,
     {0.034, 0.033, 0.025},
     {0.1, 0.2, 0.2},
     {0.25, 0.6, 0.9},
     {0.019, 0.012, 0.010, 0.009}},
    {AP_JOINT_INDEX,
     4,
     {-0.018, -0.008, -0.037},
     0.1,
     0,
     {0.060, 0.038, 0.024, 0.022},
     {0, 0.35, 0.4, 0.2},
     {0, 1.3, 1.6, 1.0},
     {0.020, 0.010, 0.009, 0.008, 0.007}},
    {AP_JOINT_MIDDLE,
     4,
     {-0.002, -0.006, -0.036},
     0,
     0,
     {0.062, 0.043, 0.028, 0.025},
     {0, 0.4, 0.45, 0.25},
     {0, 1.35, 1.65, 1.0},
     {0.020, 0.011, 0.009, 0.008, 0.007}},
    {AP_JOINT_RING,
     4,
     {0.013, -0.006, -0.035},
     -0.1,
     0,
     {0.055, 0.039, 0.026, 0.024},
     {0, 0.45, 0.5, 0.25},
     {0, 1.35, 1.65, 1.0},
     {0.019, 0.010, 0.008, 0.008, 0.007}},
    {AP_JOINT_LITTLE,
     4,
     {0.023, -0.008, -0.034},
     -0.22,
     0,
     {0.048, 0.031, 0.020, 0.021},
     {0, 0.5, 0.5, 0.3},
     {0, 1.35, 1.6, 1.0},
     {0.018, 0.008, 0.007, 0.007, 0.006}},
};

static const double WRIST_RADIUS_M = 0.021;
// From the palm joint, in the middle of the bone, to what the palm holds.
static const double PALM_TO_GRIP_M = 0.03;

static struct ap_quat turn(double x, double y, double z, double angle) {
    return ap_quat_from_axis_angle((struct ap_vec3){x, y, z}, angle);
}

// Bends each joint by what curl (0 relaxed, 1 closed) makes of its two angles.
static void make_finger(const struct finger *f, double curl, struct ap_hand *out) {
    struct ap_quat q = ap_quat_mul(turn(0, 1, 0, f->yaw_rad), turn(0, 0, 1, f->roll_rad));
    struct ap_vec3 p = f->root;
    for (int b = 0; b <= f->bones; b++) {
        if (b < f->bones) {
            double bend = f->relaxed_rad[b] + curl * (f->closed_rad[b] - f->relaxed_rad[b]);
            q = ap_quat_mul(q, turn(1, 0, 0, -bend));
        }
        // The tip is turned like the bone that leads to it.
        out->joint[f->first + b] = (struct ap_hand_joint){{p, q}, f->radius_m[b]};
        if (b < f->bones)
            p = ap_vec3_add(p, ap_quat_rotate(q, (struct ap_vec3){0, 0, -f->length_m[b]}));
    }
}

static void mirror(struct ap_hand *hand) {
    for (int j = 0; j < AP_JOINT_COUNT; j++) {
        struct ap_pose *pose = &hand->joint[j].pose;
        pose->p.x = -pose->p.x;
        pose->q.y = -pose->q.y;
        pose->q.z = -pose->q.z;
    }
}

// OpenXR's grip: +x goes into the right palm and out of the left one, -z from the little finger to
// the thumb. So grip x, y, z are the right hand's y, z, x and the left hand's -y, z, -x.
static struct ap_quat grip_from_hand(int hand) {
    return hand == AP_HAND_RIGHT ? (struct ap_quat){-0.5, -0.5, -0.5, 0.5}
                                 : (struct ap_quat){-0.5, 0.5, 0.5, 0.5};
}

void sim_make_hand(int hand, struct ap_pose stage_from_grip, double trigger, double squeeze,
                   struct ap_hand *out) {
    out->joint[AP_JOINT_WRIST] = (struct ap_hand_joint){AP_POSE_IDENTITY, WRIST_RADIUS_M};
    for (size_t i = 0; i < sizeof fingers / sizeof *fingers; i++)
        make_finger(&fingers[i], fingers[i].first == AP_JOINT_INDEX ? trigger : squeeze, out);
    ap_hand_derive_palm(out);
    if (hand == AP_HAND_LEFT)
        mirror(out);
    struct ap_vec3 held = out->joint[AP_JOINT_PALM].pose.p;
    held.y -= PALM_TO_GRIP_M;
    struct ap_pose grip = {.q = grip_from_hand(hand)};
    grip.p = ap_vec3_scale(-1, ap_quat_rotate(grip.q, held));
    struct ap_pose stage_from_hand = ap_pose_mul(stage_from_grip, grip);
    for (int j = 0; j < AP_JOINT_COUNT; j++)
        out->joint[j].pose = ap_pose_mul(stage_from_hand, out->joint[j].pose);
}
