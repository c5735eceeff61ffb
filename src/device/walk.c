#include "src/device/walk.h"

#include <math.h>

#include "src/device/walk_path.h"
#include "src/device/walk_script.h"
#include "src/geom/vec.h"

// A body of 1.70 m, metres. The spine turns about the hip when it bends.
static const double HIP_Y = 0.95, SHOULDER_ABOVE_HIP = 0.40, SHOULDER_SIDE = 0.18,
                    EYES_ABOVE_HIP = 0.67, EYES_FORWARD = 0.08;
static const double BEND_RAD = 0.87, HIP_BACK = 0.10, KNEES_DOWN = 0.10;
static const double STEP_HZ = 1.8;

struct walker {
    double edge_m, table_y;
    uint64_t seed;
    double t_s;
    struct ap_walk_state state;
    double heading_rad;           // of the chest
    struct ap_vec3 foot, forward; // the point on the floor below the upright hip
    struct ap_vec3 right;
};

// Where a device is and how it points, before the quaternion is made.
struct aimed {
    struct ap_vec3 p;
    double yaw_rad, pitch_rad, roll_rad;
};

enum { SWAY_X, SWAY_Y, SWAY_Z, SWAY_YAW, SWAY_PITCH, SWAY_ROLL, SWAY_COUNT };

static double phase_of(uint64_t seed, uint64_t i) {
    uint64_t z = seed + (i + 1) * UINT64_C(0x9e3779b97f4a7c15);
    z = (z ^ (z >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ (z >> 27)) * UINT64_C(0x94d049bb133111eb);
    return 2 * M_PI * (double)((z ^ (z >> 31)) >> 11) * 0x1p-53;
}

// A body never rests: sines of no common period, about −1…1.
static double sway(const struct walker *w, int device, int axis) {
    static const double hz[4] = {0.137, 0.271, 0.463, 0.911};
    static const double part[4] = {0.45, 0.3, 0.17, 0.08};
    double sum = 0;
    for (int i = 0; i < 4; i++) {
        uint64_t which = (uint64_t)((device * SWAY_COUNT + axis) * 4 + i);
        sum += part[i] * sin(2 * M_PI * hz[i] * w->t_s + phase_of(w->seed, which));
    }
    return sum;
}

static struct ap_vec3 forward_of(double heading_rad) {
    return (struct ap_vec3){-sin(heading_rad), 0, -cos(heading_rad)};
}

static struct walker make_walker(const struct ap_walk_params *params, double t_s) {
    struct walker w = {.edge_m = params->table_edge_m > 0 ? params->table_edge_m : 0.9,
                       .table_y = params->table_height_m > 0 ? params->table_height_m : 0.75,
                       .seed = params->seed ? params->seed : 1,
                       .t_s = t_s};
    w.state = ap_walk_script_at(w.edge_m, t_s);
    struct ap_walk_point at = ap_walk_path(w.edge_m, ap_walk_offset_m, w.state.u);
    w.heading_rad = ap_walk_path_heading(&at, w.state.u) + M_PI_2 * w.state.facing;
    w.forward = forward_of(w.heading_rad);
    w.right = forward_of(w.heading_rad - M_PI_2);
    // Weight goes from foot to foot, once in two steps.
    double side = 0.014 * w.state.pace * sin(M_PI * STEP_HZ * t_s);
    w.foot = (struct ap_vec3){at.x + side * w.right.x, 0, at.z + side * w.right.z};
    return w;
}

// A point of the body: to the right, up, and forward of the foot point.
static struct ap_vec3 body_point(const struct walker *w, double right, double up, double forward) {
    struct ap_vec3 p =
        ap_vec3_add(ap_vec3_scale(right, w->right), ap_vec3_scale(forward, w->forward));
    p.y = up;
    return ap_vec3_add(w->foot, p);
}

// The same for a point of the trunk, given from the hip: it bends with the spine.
static struct ap_vec3 trunk_point(const struct walker *w, double right, double up, double forward) {
    double b = BEND_RAD * w->state.bend, bob = 0.010 * w->state.pace;
    double hip_y = HIP_Y - KNEES_DOWN * w->state.bend + bob * cos(2 * M_PI * STEP_HZ * w->t_s);
    return body_point(w, right, hip_y + up * cos(b) - forward * sin(b),
                      up * sin(b) + forward * cos(b) - HIP_BACK * w->state.bend);
}

static void shake(const struct walker *w, int device, double metres, double radians,
                  struct aimed *a) {
    a->p.x += metres * sway(w, device, SWAY_X);
    a->p.y += 0.4 * metres * sway(w, device, SWAY_Y);
    a->p.z += metres * sway(w, device, SWAY_Z);
    a->yaw_rad += radians * sway(w, device, SWAY_YAW);
    a->pitch_rad += radians * sway(w, device, SWAY_PITCH);
    a->roll_rad += radians * sway(w, device, SWAY_ROLL);
}

// Yaw relative to the chest and pitch from one point to another, a weight's share of them.
static void look_at(const struct walker *w, double weight, struct ap_vec3 target,
                    struct aimed *head) {
    struct ap_vec3 d = ap_vec3_sub(target, head->p);
    double yaw = ap_walk_turn_rad(atan2(-d.x, -d.z) - w->heading_rad);
    // Necks turn so far and no farther; the eyes do the rest.
    head->yaw_rad += weight * 1.2 * tanh(yaw / 1.2);
    head->pitch_rad += weight * 0.75 * atan2(d.y, hypot(d.x, d.z));
}

// Beside the walker's path, and ahead_m farther along it.
static struct ap_vec3 path_point(const struct walker *w, double offset_m, double ahead_m,
                                 double y) {
    double u = w->state.u + ahead_m / ap_walk_path_edge_length_m(w->edge_m);
    struct ap_walk_point p = ap_walk_path(w->edge_m, offset_m, u);
    return (struct ap_vec3){p.x, y, p.z};
}

static struct aimed head_at(const struct walker *w) {
    const struct ap_walk_state *s = &w->state;
    struct aimed head = {.p = trunk_point(w, 0, EYES_ABOVE_HIP, EYES_FORWARD)};
    double ahead_m = 0.6 * (1 - s->facing), inside = fmin(0.3, w->edge_m / 3);
    if (s->on_table != 0) // no attention adds exactly nothing, and costs as much
        look_at(w, s->on_table, path_point(w, -inside, ahead_m, w->table_y), &head);
    if (s->on_way != 0)
        look_at(w, s->on_way, path_point(w, 0.3, 1.35, 0.85), &head);
    if (s->on_shot != 0)
        look_at(w, s->on_shot, path_point(w, -2.2 * inside, 0, w->table_y), &head);
    head.yaw_rad += w->heading_rad + s->glance_yaw_rad;
    head.pitch_rad += s->glance_pitch_rad;
    head.pitch_rad += 0.008 * s->pace * sin(2 * M_PI * STEP_HZ * w->t_s);
    head.roll_rad = 0.010 * s->pace * sin(M_PI * STEP_HZ * w->t_s);
    shake(w, 0, 0.005, 0.012, &head);
    return head;
}

// No farther from the shoulder than an arm reaches: unchanged to 0.6 m, never 0.72.
static void reach(const struct walker *w, double side, struct aimed *hand) {
    static const double FREE_M = 0.6, SPARE_M = 0.12;
    struct ap_vec3 shoulder = trunk_point(w, side, SHOULDER_ABOVE_HIP, 0);
    struct ap_vec3 arm = ap_vec3_sub(hand->p, shoulder);
    double length = ap_vec3_length(arm);
    if (length <= FREE_M)
        return;
    double reached = FREE_M + SPARE_M * tanh((length - FREE_M) / SPARE_M);
    hand->p = ap_vec3_add(shoulder, ap_vec3_scale(reached / length, arm));
}

static struct aimed blend(struct aimed a, struct aimed b, double part) {
    struct ap_vec3 way = ap_vec3_sub(b.p, a.p);
    return (struct aimed){ap_vec3_add(a.p, ap_vec3_scale(part, way)),
                          a.yaw_rad + part * (b.yaw_rad - a.yaw_rad),
                          a.pitch_rad + part * (b.pitch_rad - a.pitch_rad),
                          a.roll_rad + part * (b.roll_rad - a.roll_rad)};
}

// A grip's −z runs from the little finger to the thumb, its −y to the tips of straight fingers, +y
// up the forearm (OpenXR, 6.3.1 "grip"). Lying palm down the left hand has its thumb to the right:
// nearly a quarter turn each about y and z from one that hangs.
static const double FLAT_YAW = -1.15, FLAT_ROLL = -1.1;

// Swings against the right leg's step, touches the table's edge, or makes the bridge on it.
static struct aimed left_at(const struct walker *w) {
    const struct ap_walk_state *s = &w->state;
    double swing = s->pace * sin(M_PI * STEP_HZ * w->t_s), yaw = w->heading_rad;
    struct aimed hand = {body_point(w, -0.24, 0.90 + 0.02 * swing * swing, 0.10 + 0.07 * swing),
                         yaw - 0.1, 0.2 + 0.2 * swing, 0};
    double touch = s->touch * (1 - s->bend);
    if (touch != 0)
        hand = blend(hand,
                     (struct aimed){path_point(w, 0.01, 0.18, w->table_y + 0.03),
                                    yaw + 0.5 + FLAT_YAW, 0.1, FLAT_ROLL},
                     touch);
    if (s->bend != 0)
        hand = blend(hand,
                     (struct aimed){path_point(w, -0.10, 0, w->table_y + 0.05), yaw + FLAT_YAW, 0.1,
                                    FLAT_ROLL},
                     s->bend);
    reach(w, -SHOULDER_SIDE, &hand);
    shake(w, 1, 0.004 * (1 - 0.7 * s->bend), 0.02, &hand);
    return hand;
}

static struct aimed shot_at(const struct walker *w) {
    struct aimed shot = {body_point(w, 0.14, w->table_y + 0.16, 0.02 + 0.06 * w->state.stroke), 0,
                         0, 0};
    struct ap_vec3 cue = ap_vec3_sub(left_at(w).p, shot.p);
    double yaw = ap_walk_turn_rad(atan2(-cue.x, -cue.z) - w->heading_rad);
    shot.yaw_rad = w->heading_rad + yaw;
    shot.pitch_rad = atan2(cue.y, hypot(cue.x, cue.z));
    return shot;
}

// Carries the cue, slanting down before it; at the shot holds its end by the hip, so that the
// grip's −z runs along the cue to the other hand.
static struct aimed right_at(const struct walker *w) {
    const struct ap_walk_state *s = &w->state;
    double swing = s->pace * sin(M_PI * STEP_HZ * w->t_s);
    struct aimed hand = {body_point(w, 0.23, 0.98, 0.14 - 0.04 * swing), w->heading_rad + 0.1,
                         -0.12 - 0.06 * swing, 0};
    if (s->bend != 0)
        hand = blend(hand, shot_at(w), s->bend);
    reach(w, SHOULDER_SIDE, &hand);
    shake(w, 2, 0.004 * (1 - 0.7 * s->bend), 0.015 * (1 - 0.7 * s->bend), &hand);
    return hand;
}

static struct ap_pose pose_of(const struct aimed *a) {
    struct ap_quat yaw = ap_quat_from_axis_angle((struct ap_vec3){0, 1, 0}, a->yaw_rad);
    struct ap_quat pitch = ap_quat_from_axis_angle((struct ap_vec3){1, 0, 0}, a->pitch_rad);
    struct ap_quat roll = ap_quat_from_axis_angle((struct ap_vec3){0, 0, 1}, a->roll_rad);
    return (struct ap_pose){a->p, ap_quat_normalize(ap_quat_mul(yaw, ap_quat_mul(pitch, roll)))};
}

double ap_walk_duration_s(const struct ap_walk_params *params) {
    if (params->duration_s > 0)
        return params->duration_s;
    return ap_walk_script_duration_s(params->table_edge_m > 0 ? params->table_edge_m : 0.9);
}

struct ap_sample ap_walk_at(const struct ap_walk_params *params, int device, int64_t t_ns) {
    double t_s = fmin(fmax((double)t_ns * 1e-9, 0), ap_walk_duration_s(params));
    struct walker w = make_walker(params, t_s);
    struct aimed at = device == 0 ? head_at(&w) : device == 1 ? left_at(&w) : right_at(&w);
    struct ap_sample sample = {.t_ns = t_ns, .device = device, .pose = pose_of(&at)};
    if (device == 2) {
        sample.trigger = (float)fmin(fmax(w.state.trigger, 0), 1);
        sample.select = w.state.select != 0;
    }
    return sample;
}
