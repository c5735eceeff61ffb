#include <stdlib.h>

#include "sim_hmd/core/spaces.h"
#include "sim_hmd/input/actions.h"

// Spaces. Reference spaces VIEW, LOCAL, STAGE and LOCAL_FLOOR; the spaces of pose actions.

// LOCAL_FLOOR, the last, only with its extension.
static const XrReferenceSpaceType reference_spaces[] = {
    XR_REFERENCE_SPACE_TYPE_VIEW, XR_REFERENCE_SPACE_TYPE_LOCAL, XR_REFERENCE_SPACE_TYPE_STAGE,
    XR_REFERENCE_SPACE_TYPE_LOCAL_FLOOR_EXT};

static uint32_t reference_space_count(const struct sim_session *session) {
    return session->instance->enabled[SIM_EXT_local_floor] ? 4 : 3;
}

// What the walk and the window's person have: a room of 4 m by 4 m. A recording says nothing of it.
static const XrExtent2Df stage_bounds = {4.0f, 4.0f};

XrResult XRAPI_CALL xrEnumerateReferenceSpaces(XrSession handle, uint32_t capacity, uint32_t *count,
                                               XrReferenceSpaceType *spaces) {
    SIM_LOCKED;
    struct sim_session *session;
    XrResult result = sim_session_get(handle, &session);
    if (result != XR_SUCCESS)
        return result;
    return sim_two_calls(capacity, count, reference_space_count(session), reference_spaces,
                         sizeof *spaces, spaces);
}

static XrResult check_reference(const struct sim_session *session, XrReferenceSpaceType type) {
    for (uint32_t i = 0; i < reference_space_count(session); i++)
        if (type == reference_spaces[i])
            return XR_SUCCESS;
    return XR_ERROR_REFERENCE_SPACE_UNSUPPORTED;
}

XrResult XRAPI_CALL xrGetReferenceSpaceBoundsRect(XrSession handle, XrReferenceSpaceType type,
                                                  XrExtent2Df *bounds) {
    SIM_LOCKED;
    struct sim_session *session;
    XrResult result = sim_session_get(handle, &session);
    if (result != XR_SUCCESS)
        return result;
    if (!bounds)
        return XR_ERROR_VALIDATION_FAILURE;
    result = check_reference(session, type);
    if (result != XR_SUCCESS)
        return result;
    bool known = type == XR_REFERENCE_SPACE_TYPE_STAGE &&
                 session->instance->settings.poses != SIM_POSES_LOGS;
    *bounds = known ? stage_bounds : (XrExtent2Df){0, 0};
    return known ? XR_SUCCESS : XR_SPACE_BOUNDS_UNAVAILABLE;
}

static void free_space(struct sim_object *object) {
    free(object);
}

static XrResult add_space(struct sim_session *session, struct sim_space space, XrSpace *out) {
    struct sim_space *s = malloc(sizeof *s);
    if (!s)
        return XR_ERROR_OUT_OF_MEMORY;
    *s = space;
    s->session = session;
    if (!sim_object_add(&s->object, SIM_SPACE, &session->object, free_space)) {
        free(s);
        return XR_ERROR_LIMIT_REACHED;
    }
    *out = SIM_HANDLE(XrSpace, s);
    return XR_SUCCESS;
}

XrResult XRAPI_CALL xrCreateReferenceSpace(XrSession handle, const XrReferenceSpaceCreateInfo *info,
                                           XrSpace *out) {
    SIM_LOCKED;
    struct sim_session *session;
    XrResult result = sim_session_get(handle, &session);
    if (result != XR_SUCCESS)
        return result;
    if (!sim_is(info, XR_TYPE_REFERENCE_SPACE_CREATE_INFO) || !out)
        return XR_ERROR_VALIDATION_FAILURE;
    result = check_reference(session, info->referenceSpaceType);
    if (result != XR_SUCCESS)
        return result;
    struct sim_space space = {.reference = info->referenceSpaceType, .top = -1};
    if (!sim_pose_from_xr(info->poseInReferenceSpace, &space.parent_from_space))
        return XR_ERROR_POSE_INVALID;
    return add_space(session, space, out);
}

XrResult XRAPI_CALL xrCreateActionSpace(XrSession handle, const XrActionSpaceCreateInfo *info,
                                        XrSpace *out) {
    SIM_LOCKED;
    struct sim_session *session;
    XrResult result = sim_session_get(handle, &session);
    if (result != XR_SUCCESS)
        return result;
    if (!sim_is(info, XR_TYPE_ACTION_SPACE_CREATE_INFO) || !out)
        return XR_ERROR_VALIDATION_FAILURE;
    const struct sim_action *action = sim_action_get(info->action);
    if (!action)
        return XR_ERROR_HANDLE_INVALID;
    if (action->set->object.parent != &session->instance->object)
        return XR_ERROR_VALIDATION_FAILURE;
    if (action->type != XR_ACTION_TYPE_POSE_INPUT)
        return XR_ERROR_ACTION_TYPE_MISMATCH;
    struct sim_space space = {
        .is_action = true, .action = action->object.handle, .top = -1, .picked_top = -1};
    result = sim_subaction(session->instance, action, info->subactionPath, &space.top);
    if (result != XR_SUCCESS)
        return result;
    if (!sim_pose_from_xr(info->poseInActionSpace, &space.parent_from_space))
        return XR_ERROR_POSE_INVALID;
    return add_space(session, space, out);
}

enum ap_pose_state sim_worse_state(enum ap_pose_state a, enum ap_pose_state b) {
    if (a == AP_POSE_NONE || b == AP_POSE_NONE)
        return AP_POSE_NONE;
    if (a == AP_POSE_LOST || b == AP_POSE_LOST)
        return AP_POSE_LOST;
    return a == AP_POSE_INTERPOLATED ? a : b;
}

static struct sim_located relative(const struct sim_space *space, const struct sim_space *base,
                                   XrTime time) {
    struct sim_located s = sim_space_in_stage(space, time), b = sim_space_in_stage(base, time);
    enum ap_pose_state state = sim_worse_state(s.state, b.state);
    return (struct sim_located){state, state ? ap_pose_mul(ap_pose_inverse(b.pose), s.pose)
                                             : AP_POSE_IDENTITY};
}

// How the space moves against its base.
static void fill_velocity(const struct sim_space *space, const struct sim_space *base, XrTime time,
                          XrSpaceVelocity *velocity) {
    velocity->velocityFlags = 0;
    velocity->linearVelocity = velocity->angularVelocity = (XrVector3f){0, 0, 0};
    struct sim_located now = relative(space, base, time);
    struct sim_located then = relative(space, base, time - SIM_VELOCITY_STEP_NS);
    if (!(sim_location_flags(now.state) & sim_location_flags(then.state) &
          XR_SPACE_LOCATION_POSITION_TRACKED_BIT))
        return;
    velocity->velocityFlags =
        XR_SPACE_VELOCITY_LINEAR_VALID_BIT | XR_SPACE_VELOCITY_ANGULAR_VALID_BIT;
    sim_velocity(now.pose, then.pose, &velocity->linearVelocity, &velocity->angularVelocity);
}

XrResult XRAPI_CALL xrLocateSpace(XrSpace handle, XrSpace base_handle, XrTime time,
                                  XrSpaceLocation *location) {
    SIM_LOCKED;
    const struct sim_space *space = sim_space_get(handle), *base = sim_space_get(base_handle);
    if (!space || !base)
        return XR_ERROR_HANDLE_INVALID;
    if (!sim_is(location, XR_TYPE_SPACE_LOCATION) || space->session != base->session)
        return XR_ERROR_VALIDATION_FAILURE;
    if (space->session->lost)
        return XR_ERROR_SESSION_LOST;
    if (time <= 0)
        return XR_ERROR_TIME_INVALID;
    struct sim_located at = relative(space, base, time);
    location->locationFlags = sim_location_flags(at.state);
    location->pose = sim_pose_to_xr(at.pose);
    for (XrBaseOutStructure *s = location->next; s; s = s->next)
        if (s->type == XR_TYPE_SPACE_VELOCITY)
            fill_velocity(space, base, time, (XrSpaceVelocity *)s);
    return XR_SUCCESS;
}

XrResult XRAPI_CALL xrDestroySpace(XrSpace handle) {
    SIM_LOCKED;
    struct sim_space *space = sim_space_get(handle);
    if (!space)
        return XR_ERROR_HANDLE_INVALID;
    sim_object_destroy(&space->object);
    return XR_SUCCESS;
}
