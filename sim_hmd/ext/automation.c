#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "sim_hmd/core/spaces.h"
#include "src/base/clock.h"

// XR_EXT_conformance_automation: the program is the person with the controllers.

const struct sim_automated *sim_automation_find(const struct sim_automation *automation, int top,
                                                const char *path) {
    for (uint32_t i = 0; i < automation->count; i++)
        if (automation->inputs[i].top == top && strcmp(automation->inputs[i].path, path) == 0)
            return &automation->inputs[i];
    return NULL;
}

void sim_automation_finish(struct sim_automation *automation) {
    free(automation->inputs);
    *automation = (struct sim_automation){0};
}

// NULL without memory.
static struct sim_automated *input(struct sim_automation *automation, int top, const char *path) {
    const struct sim_automated *known = sim_automation_find(automation, top, path);
    if (known)
        return &automation->inputs[known - automation->inputs];
    if (automation->count == automation->capacity) {
        uint32_t capacity = automation->capacity ? 2 * automation->capacity : 16;
        struct sim_automated *bigger =
            realloc(automation->inputs, capacity * sizeof *automation->inputs);
        if (!bigger)
            return NULL;
        automation->inputs = bigger;
        automation->capacity = capacity;
    }
    struct sim_automated *fresh = &automation->inputs[automation->count++];
    *fresh = (struct sim_automated){.top = top};
    snprintf(fresh->path, sizeof fresh->path, "%s", path);
    return fresh;
}

static XrResult find_top(const struct sim_session *session, XrPath path, int *top) {
    if (!sim_path_text(&session->instance->paths, path))
        return XR_ERROR_PATH_INVALID;
    *top = sim_path_top(&session->instance->paths, path);
    return *top < 0 ? XR_ERROR_PATH_UNSUPPORTED : XR_SUCCESS;
}

// The component of the device that the program has switched on, else of any that has it.
static XrResult find_component(const struct sim_session *session, XrPath top_path,
                               XrPath source_path, enum sim_kind kind,
                               const struct sim_component **component, int *top) {
    XrResult result = find_top(session, top_path, top);
    if (result != XR_SUCCESS)
        return result;
    const char *text = sim_path_text(&session->instance->paths, source_path);
    if (!text)
        return XR_ERROR_PATH_INVALID;
    const struct sim_automation *automation = &session->automation;
    bool own = automation->device[*top] == SIM_OWN;
    for (int p = 0; sim_profiles[p].path; p++) {
        int t;
        if ((!own && p != automation->profile[*top]) ||
            !sim_instance_has(session->instance, sim_profiles[p].needs))
            continue;
        *component = sim_profile_component(p, text, kind, &t);
        size_t n = strlen(sim_top_paths[*top]);
        if (*component && t == *top && (*component)->kind == kind &&
            strcmp((*component)->path, text + n) == 0)
            return XR_SUCCESS;
    }
    return XR_ERROR_PATH_UNSUPPORTED;
}

XrResult XRAPI_CALL xrSetInputDeviceActiveEXT(XrSession handle, XrPath profile_path,
                                              XrPath top_path, XrBool32 active) {
    SIM_LOCKED;
    struct sim_session *session;
    XrResult result = sim_session_get(handle, &session);
    if (result != XR_SUCCESS)
        return result;
    const char *text = sim_path_text(&session->instance->paths, profile_path);
    if (!text)
        return XR_ERROR_PATH_INVALID;
    int profile = sim_profile_find(text), top;
    result = find_top(session, top_path, &top);
    if (result != XR_SUCCESS)
        return result;
    if (profile < 0 || !sim_profile_has_top(profile, top) ||
        !sim_instance_has(session->instance, sim_profiles[profile].needs))
        return XR_ERROR_PATH_UNSUPPORTED;
    session->automation.device[top] = active ? SIM_SWITCHED_ON : SIM_SWITCHED_OFF;
    session->automation.profile[top] = profile;
    return XR_SUCCESS;
}

// A stick's axes are inputs of their own: what moves the one moves the other.
static XrResult set_with_axes(struct sim_session *session, int top, const char *path, float x,
                              float y) {
    struct sim_automated *whole = input(&session->automation, top, path);
    if (!whole)
        return XR_ERROR_OUT_OF_MEMORY;
    whole->value[0] = x;
    whole->value[1] = y;
    for (int axis = 0; axis < 2; axis++) {
        char part[64];
        snprintf(part, sizeof part, "%.60s/%c", path, "xy"[axis]);
        struct sim_automated *one = input(&session->automation, top, part);
        if (!one)
            return XR_ERROR_OUT_OF_MEMORY;
        one->value[0] = axis ? y : x;
    }
    return XR_SUCCESS;
}

static XrResult set_scalar(struct sim_session *session, int top, const char *path, float value) {
    size_t n = strlen(path);
    if (n > 2 && path[n - 2] == '/' && (path[n - 1] == 'x' || path[n - 1] == 'y')) {
        char stick[64];
        snprintf(stick, sizeof stick, "%.*s", (int)(n - 2), path);
        const struct sim_automated *now = sim_automation_find(&session->automation, top, stick);
        float x = now ? now->value[0] : 0, y = now ? now->value[1] : 0;
        return path[n - 1] == 'x' ? set_with_axes(session, top, stick, value, y)
                                  : set_with_axes(session, top, stick, x, value);
    }
    struct sim_automated *one = input(&session->automation, top, path);
    if (!one)
        return XR_ERROR_OUT_OF_MEMORY;
    one->value[0] = value;
    return XR_SUCCESS;
}

static XrResult set_state(XrSession handle, XrPath top_path, XrPath source_path, enum sim_kind kind,
                          float x, float y) {
    struct sim_session *session;
    const struct sim_component *component;
    int top;
    XrResult result = sim_session_get(handle, &session);
    if (result == XR_SUCCESS)
        result = find_component(session, top_path, source_path, kind, &component, &top);
    if (result != XR_SUCCESS)
        return result;
    if (!isfinite(x) || !isfinite(y))
        return XR_ERROR_VALIDATION_FAILURE;
    return kind == SIM_VEC2 ? set_with_axes(session, top, component->path, x, y)
                            : set_scalar(session, top, component->path, x);
}

XrResult XRAPI_CALL xrSetInputDeviceStateBoolEXT(XrSession handle, XrPath top_path,
                                                 XrPath source_path, XrBool32 state) {
    SIM_LOCKED;
    return set_state(handle, top_path, source_path, SIM_BOOL, state ? 1 : 0, 0);
}

XrResult XRAPI_CALL xrSetInputDeviceStateFloatEXT(XrSession handle, XrPath top_path,
                                                  XrPath source_path, float state) {
    SIM_LOCKED;
    return set_state(handle, top_path, source_path, SIM_FLOAT, state, 0);
}

XrResult XRAPI_CALL xrSetInputDeviceStateVector2fEXT(XrSession handle, XrPath top_path,
                                                     XrPath source_path, XrVector2f state) {
    SIM_LOCKED;
    return set_state(handle, top_path, source_path, SIM_VEC2, state.x, state.y);
}

// The device stands where the space is now, and stays there.
XrResult XRAPI_CALL xrSetInputDeviceLocationEXT(XrSession handle, XrPath top_path,
                                                XrPath source_path, XrSpace space_handle,
                                                XrPosef pose) {
    SIM_LOCKED;
    struct sim_session *session;
    const struct sim_component *component;
    int top;
    XrResult result = sim_session_get(handle, &session);
    if (result != XR_SUCCESS)
        return result;
    const struct sim_space *space = sim_space_get(space_handle);
    if (!space)
        return XR_ERROR_HANDLE_INVALID;
    if (space->session != session)
        return XR_ERROR_VALIDATION_FAILURE;
    result = find_component(session, top_path, source_path, SIM_POSE, &component, &top);
    if (result != XR_SUCCESS)
        return result;
    struct ap_pose space_from_device;
    if (!sim_pose_from_xr(pose, &space_from_device))
        return XR_ERROR_POSE_INVALID;
    struct sim_automated *at = input(&session->automation, top, component->path);
    if (!at)
        return XR_ERROR_OUT_OF_MEMORY;
    struct sim_located stage =
        sim_space_in_stage(space, sim_pacer_now(&session->pacer, ap_clock_now_ns()));
    at->has_pose = true;
    at->state = stage.state;
    at->stage_from_device = ap_pose_mul(stage.pose, space_from_device);
    return XR_SUCCESS;
}

const struct sim_function sim_functions_EXT_conformance_automation[] = {
    SIM_FUNCTION(xrSetInputDeviceActiveEXT),     SIM_FUNCTION(xrSetInputDeviceStateBoolEXT),
    SIM_FUNCTION(xrSetInputDeviceStateFloatEXT), SIM_FUNCTION(xrSetInputDeviceStateVector2fEXT),
    SIM_FUNCTION(xrSetInputDeviceLocationEXT),   {0},
};
