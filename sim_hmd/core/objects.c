#include <string.h>

#include "sim_hmd/core/instance.h"
#include "sim_hmd/core/session.h"
#include "sim_hmd/core/spaces.h"
#include "sim_hmd/core/swapchains.h"
#include "sim_hmd/input/actions.h"

// From handles to objects, and what else the calls share.

struct sim_instance *sim_instance_get(XrInstance handle) {
    return sim_object_get(sim_raw(handle), SIM_INSTANCE);
}

SIM_HOT XrResult sim_session_get(XrSession handle, struct sim_session **session) {
    *session = sim_object_get(sim_raw(handle), SIM_SESSION);
    if (!*session)
        return XR_ERROR_HANDLE_INVALID;
    return (*session)->lost ? XR_ERROR_SESSION_LOST : XR_SUCCESS;
}

SIM_HOT struct sim_space *sim_space_get(XrSpace handle) {
    return sim_object_get(sim_raw(handle), SIM_SPACE);
}

SIM_HOT XrResult sim_swapchain_get(XrSwapchain handle, struct sim_swapchain **swapchain) {
    *swapchain = sim_object_get(sim_raw(handle), SIM_SWAPCHAIN);
    if (!*swapchain)
        return XR_ERROR_HANDLE_INVALID;
    return (*swapchain)->session->lost ? XR_ERROR_SESSION_LOST : XR_SUCCESS;
}

struct sim_action_set *sim_action_set_get(XrActionSet handle) {
    return sim_object_get(sim_raw(handle), SIM_ACTION_SET);
}

struct sim_action *sim_action_get(XrAction handle) {
    return sim_object_get(sim_raw(handle), SIM_ACTION);
}

XrResult sim_subaction(const struct sim_instance *instance, const struct sim_action *action,
                       XrPath path, int *top) {
    *top = -1;
    if (path == XR_NULL_PATH)
        return XR_SUCCESS;
    if (!sim_path_text(&instance->paths, path))
        return XR_ERROR_PATH_INVALID;
    *top = sim_path_top(&instance->paths, path);
    return *top >= 0 && action->top[*top] ? XR_SUCCESS : XR_ERROR_PATH_UNSUPPORTED;
}

XrResult sim_two_calls(uint32_t capacity, uint32_t *count, uint32_t n, const void *items,
                       size_t size, void *out) {
    if (!count || (capacity && !out))
        return XR_ERROR_VALIDATION_FAILURE;
    *count = n;
    if (capacity == 0)
        return XR_SUCCESS;
    if (capacity < n)
        return XR_ERROR_SIZE_INSUFFICIENT;
    if (n)
        memcpy(out, items, n * size);
    return XR_SUCCESS;
}

XrResult sim_two_call_text(uint32_t capacity, uint32_t *count, const char *text, char *out) {
    return sim_two_calls(capacity, count, (uint32_t)strlen(text) + 1, text, 1, out);
}
