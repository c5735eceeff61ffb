#include <math.h>

#include "sim_hmd/core/spaces.h"
#include "sim_hmd/input/actions.h"
#include "sim_hmd/input/source.h"

// OpenXR asks runtimes to take quaternions within 1 % of unit length.
static const double QUAT_TOLERANCE = 0.01;

SIM_HOT bool sim_pose_from_xr(XrPosef in, struct ap_pose *out) {
    struct ap_pose pose = {
        .p = {in.position.x, in.position.y, in.position.z},
        .q = {in.orientation.x, in.orientation.y, in.orientation.z, in.orientation.w}};
    double n =
        sqrt(pose.q.x * pose.q.x + pose.q.y * pose.q.y + pose.q.z * pose.q.z + pose.q.w * pose.q.w);
    // The comparisons are false for NaN.
    if (!(fabs(n - 1) <= QUAT_TOLERANCE) || !isfinite(pose.p.x) || !isfinite(pose.p.y) ||
        !isfinite(pose.p.z))
        return false;
    pose.q = ap_quat_normalize(pose.q);
    *out = pose;
    return true;
}

SIM_HOT XrPosef sim_pose_to_xr(struct ap_pose pose) {
    return (XrPosef){
        .orientation = {(float)pose.q.x, (float)pose.q.y, (float)pose.q.z, (float)pose.q.w},
        .position = {(float)pose.p.x, (float)pose.p.y, (float)pose.p.z}};
}

SIM_HOT XrSpaceLocationFlags sim_location_flags(enum ap_pose_state state) {
    switch (state) {
    case AP_POSE_EXACT:
    case AP_POSE_INTERPOLATED:
    case AP_POSE_PREDICTED:
        return XR_SPACE_LOCATION_ORIENTATION_VALID_BIT | XR_SPACE_LOCATION_POSITION_VALID_BIT |
               XR_SPACE_LOCATION_ORIENTATION_TRACKED_BIT | XR_SPACE_LOCATION_POSITION_TRACKED_BIT;
    case AP_POSE_LOST:
        return XR_SPACE_LOCATION_ORIENTATION_VALID_BIT | XR_SPACE_LOCATION_POSITION_VALID_BIT;
    case AP_POSE_NONE:
        break;
    }
    return 0;
}

SIM_HOT static struct sim_located device_in_stage(const struct sim_session *session,
                                                  enum sim_device device, XrTime time) {
    struct ap_sample sample;
    enum ap_pose_state state = sim_source_at(session->instance->source, device, time, &sample);
    return (struct sim_located){state, state ? sample.pose : AP_POSE_IDENTITY};
}

SIM_HOT struct sim_located sim_head_in_stage(const struct sim_session *session, XrTime time) {
    return device_in_stage(session, SIM_HEAD, time);
}

// The palm lies on the handle's outer side; stretched fingers point half-way between the handle and
// the ray across it.
static struct ap_pose grip_from_palm(int top) {
    const double out_m = 0.02, tilt_rad = -0.78539816339744831;
    return (struct ap_pose){.p = {top == SIM_TOP_LEFT ? -out_m : out_m, 0, 0},
                            .q = ap_quat_from_axis_angle((struct ap_vec3){1, 0, 0}, tilt_rad)};
}

static struct sim_located action_in_stage(const struct sim_space *space, XrTime time) {
    const struct sim_session *session = space->session;
    struct sim_located none = {AP_POSE_NONE, AP_POSE_IDENTITY};
    int top = space->picked_top;
    const struct sim_component *c =
        space->active ? sim_actions_binding(session, space->action, top) : NULL;
    if (!c || session->automation.device[top] == SIM_SWITCHED_OFF)
        return none;
    const struct sim_automated *driven = sim_automation_find(&session->automation, top, c->path);
    if (driven && driven->has_pose)
        return (struct sim_located){driven->state, driven->stage_from_device};
    if (top > SIM_TOP_RIGHT)
        return none;
    struct sim_located hand =
        device_in_stage(session, top == SIM_TOP_LEFT ? SIM_LEFT : SIM_RIGHT, time);
    if (hand.state && c->input == SIM_AIM)
        hand.pose = ap_headset_aim(&session->instance->settings.profile, hand.pose);
    if (hand.state && c->input == SIM_PALM)
        hand.pose = ap_pose_mul(hand.pose, grip_from_palm(top));
    return hand;
}

SIM_HOT static struct sim_located reference_in_stage(const struct sim_space *space, XrTime time) {
    if (space->reference == XR_REFERENCE_SPACE_TYPE_LOCAL_FLOOR_EXT)
        return (struct sim_located){AP_POSE_EXACT, sim_local_floor_in_stage(space->session, time)};
    switch (space->reference) {
    case XR_REFERENCE_SPACE_TYPE_VIEW:
        return sim_head_in_stage(space->session, time);
    case XR_REFERENCE_SPACE_TYPE_LOCAL:
        return (struct sim_located){AP_POSE_EXACT, sim_local_in_stage(space->session, time)};
    default:
        return (struct sim_located){AP_POSE_EXACT, AP_POSE_IDENTITY};
    }
}

SIM_HOT struct sim_located sim_space_in_stage(const struct sim_space *space, XrTime time) {
    struct sim_located at =
        space->is_action ? action_in_stage(space, time) : reference_in_stage(space, time);
    if (at.state)
        at.pose = ap_pose_mul(at.pose, space->parent_from_space);
    return at;
}

static XrVector3f vector(struct ap_vec3 v) {
    return (XrVector3f){(float)v.x, (float)v.y, (float)v.z};
}

void sim_velocity(struct ap_pose now, struct ap_pose then, XrVector3f *linear,
                  XrVector3f *angular) {
    const double per_s = 1e9 / SIM_VELOCITY_STEP_NS;
    *linear = vector(ap_vec3_scale(per_s, ap_vec3_sub(now.p, then.p)));
    *angular = (XrVector3f){0, 0, 0};
    struct ap_quat turn = ap_quat_mul(now.q, ap_quat_conj(then.q));
    struct ap_vec3 axis = {turn.x, turn.y, turn.z};
    double s = ap_vec3_length(axis), c = turn.w;
    if (c < 0) {
        axis = ap_vec3_scale(-1, axis);
        c = -c;
    }
    if (s > 0)
        *angular = vector(ap_vec3_scale(2 * atan2(s, c) / s * per_s, axis));
}
