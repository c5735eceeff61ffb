#ifndef ANTIPODE_SIM_HMD_CORE_SPACES_H
#define ANTIPODE_SIM_HMD_CORE_SPACES_H

#include "sim_hmd/core/session.h"
#include "src/device/timeline.h"

struct sim_space {
    struct sim_object object;
    struct sim_session *session;
    bool is_action;
    XrReferenceSpaceType reference;
    uint64_t action;
    int top; // −1: any
    // As of the last xrSyncActions. A space of any hand takes the first that is active, and keeps
    // it.
    int picked_top; // −1: none yet
    bool active;
    struct ap_pose parent_from_space;
};

struct sim_space *sim_space_get(XrSpace handle); // NULL: none

struct sim_located {
    enum ap_pose_state state;
    struct ap_pose pose; // stage_from_space; the identity where there is none
};
struct sim_located sim_space_in_stage(const struct sim_space *space, XrTime time);
struct sim_located sim_head_in_stage(const struct sim_session *session, XrTime time);
bool sim_pose_from_xr(XrPosef in, struct ap_pose *out); // false: XR_ERROR_POSE_INVALID
XrPosef sim_pose_to_xr(struct ap_pose pose);
enum ap_pose_state sim_worse_state(enum ap_pose_state a, enum ap_pose_state b);
XrSpaceLocationFlags sim_location_flags(enum ap_pose_state state);

// recentre.c
struct ap_pose sim_local_in_stage(const struct sim_session *session, XrTime time);
struct ap_pose sim_local_floor_in_stage(const struct sim_session *session, XrTime time);
void sim_recentre_due(struct sim_session *session, const struct sim_prediction *frame,
                      uint32_t keys);

// A pose is measured against itself this long ago for its velocity: backward differences, which are
// exact for the straight lines and arcs that interpolation gives.
enum { SIM_VELOCITY_STEP_NS = 1000000 };
void sim_velocity(struct ap_pose now, struct ap_pose then, XrVector3f *linear, XrVector3f *angular);

#endif
