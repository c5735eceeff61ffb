#include <stdlib.h>

#include "sim_hmd/core/spaces.h"
#include "sim_hmd/input/source.h"

// XR_EXT_hand_tracking: recorded hands, or made-up ones where the controllers are (source.h).

struct hand_tracker {
    struct sim_object object;
    struct sim_session *session;
    int hand; // AP_HAND_LEFT, AP_HAND_RIGHT
};

static void free_tracker(struct sim_object *object) {
    free(object);
}

static struct hand_tracker *get_tracker(XrHandTrackerEXT handle) {
    return sim_object_get(sim_raw(handle), SIM_HAND_TRACKER);
}

XrResult XRAPI_CALL xrCreateHandTrackerEXT(XrSession handle, const XrHandTrackerCreateInfoEXT *info,
                                           XrHandTrackerEXT *out) {
    SIM_LOCKED;
    struct sim_session *session;
    XrResult result = sim_session_get(handle, &session);
    if (result != XR_SUCCESS)
        return result;
    if (!sim_is(info, XR_TYPE_HAND_TRACKER_CREATE_INFO_EXT) || !out ||
        (info->hand != XR_HAND_LEFT_EXT && info->hand != XR_HAND_RIGHT_EXT) ||
        info->handJointSet != XR_HAND_JOINT_SET_DEFAULT_EXT)
        return XR_ERROR_VALIDATION_FAILURE;
    struct hand_tracker *tracker = calloc(1, sizeof *tracker);
    if (!tracker)
        return XR_ERROR_OUT_OF_MEMORY;
    tracker->session = session;
    tracker->hand = info->hand == XR_HAND_LEFT_EXT ? AP_HAND_LEFT : AP_HAND_RIGHT;
    if (!sim_object_add(&tracker->object, SIM_HAND_TRACKER, &session->object, free_tracker)) {
        free(tracker);
        return XR_ERROR_LIMIT_REACHED;
    }
    *out = SIM_HANDLE(XrHandTrackerEXT, tracker);
    return XR_SUCCESS;
}

XrResult XRAPI_CALL xrDestroyHandTrackerEXT(XrHandTrackerEXT handle) {
    SIM_LOCKED;
    struct hand_tracker *tracker = get_tracker(handle);
    if (!tracker)
        return XR_ERROR_HANDLE_INVALID;
    sim_object_destroy(&tracker->object);
    return XR_SUCCESS;
}

// A hand in a base space. state: AP_POSE_NONE where either is nowhere or the hand is lost.
struct located_hand {
    enum ap_pose_state state;
    struct ap_hand hand;
};

static void locate(const struct hand_tracker *tracker, const struct sim_space *base, XrTime time,
                   struct located_hand *out) {
    struct sim_source *source = tracker->session->instance->source;
    enum ap_pose_state hand = sim_source_hand(source, tracker->hand, time, &out->hand);
    struct sim_located at = sim_space_in_stage(base, time);
    out->state = hand == AP_POSE_LOST ? AP_POSE_NONE : sim_worse_state(hand, at.state);
    if (!out->state)
        return;
    struct ap_pose base_from_stage = ap_pose_inverse(at.pose);
    for (int j = 0; j < AP_JOINT_COUNT; j++)
        out->hand.joint[j].pose = ap_pose_mul(base_from_stage, out->hand.joint[j].pose);
}

static void fill_locations(const struct located_hand *at, XrHandJointLocationsEXT *out) {
    out->isActive = at->state != AP_POSE_NONE;
    for (int j = 0; j < AP_JOINT_COUNT; j++) {
        XrHandJointLocationEXT *joint = &out->jointLocations[j];
        *joint = (XrHandJointLocationEXT){.pose.orientation.w = 1};
        if (!at->state)
            continue;
        joint->locationFlags = sim_location_flags(at->state);
        joint->pose = sim_pose_to_xr(at->hand.joint[j].pose);
        joint->radius = (float)at->hand.joint[j].radius_m;
    }
}

static void fill_velocities(const struct hand_tracker *tracker, const struct sim_space *base,
                            XrTime time, const struct located_hand *now,
                            XrHandJointVelocitiesEXT *out) {
    struct located_hand then = {.state = AP_POSE_NONE};
    if (now->state)
        locate(tracker, base, time - SIM_VELOCITY_STEP_NS, &then);
    bool known = sim_location_flags(now->state) & sim_location_flags(then.state) &
                 XR_SPACE_LOCATION_POSITION_TRACKED_BIT;
    for (int j = 0; j < AP_JOINT_COUNT; j++) {
        XrHandJointVelocityEXT *v = &out->jointVelocities[j];
        *v = (XrHandJointVelocityEXT){0};
        if (!known)
            continue;
        v->velocityFlags = XR_SPACE_VELOCITY_LINEAR_VALID_BIT | XR_SPACE_VELOCITY_ANGULAR_VALID_BIT;
        sim_velocity(now->hand.joint[j].pose, then.hand.joint[j].pose, &v->linearVelocity,
                     &v->angularVelocity);
    }
}

XrResult XRAPI_CALL xrLocateHandJointsEXT(XrHandTrackerEXT handle,
                                          const XrHandJointsLocateInfoEXT *info,
                                          XrHandJointLocationsEXT *out) {
    SIM_LOCKED;
    const struct hand_tracker *tracker = get_tracker(handle);
    if (!tracker)
        return XR_ERROR_HANDLE_INVALID;
    if (tracker->session->lost)
        return XR_ERROR_SESSION_LOST;
    if (!sim_is(info, XR_TYPE_HAND_JOINTS_LOCATE_INFO_EXT) ||
        !sim_is(out, XR_TYPE_HAND_JOINT_LOCATIONS_EXT) || out->jointCount != AP_JOINT_COUNT ||
        !out->jointLocations)
        return XR_ERROR_VALIDATION_FAILURE;
    const struct sim_space *base = sim_space_get(info->baseSpace);
    if (!base)
        return XR_ERROR_HANDLE_INVALID;
    XrHandJointVelocitiesEXT *velocities = sim_chained(out, XR_TYPE_HAND_JOINT_VELOCITIES_EXT);
    if (base->session != tracker->session ||
        (velocities && (velocities->jointCount != AP_JOINT_COUNT || !velocities->jointVelocities)))
        return XR_ERROR_VALIDATION_FAILURE;
    if (info->time <= 0)
        return XR_ERROR_TIME_INVALID;
    struct located_hand at;
    locate(tracker, base, info->time, &at);
    fill_locations(&at, out);
    if (velocities)
        fill_velocities(tracker, base, info->time, &at, velocities);
    return XR_SUCCESS;
}

const struct sim_function sim_functions_EXT_hand_tracking[] = {
    SIM_FUNCTION(xrCreateHandTrackerEXT),
    SIM_FUNCTION(xrDestroyHandTrackerEXT),
    SIM_FUNCTION(xrLocateHandJointsEXT),
    {0},
};
