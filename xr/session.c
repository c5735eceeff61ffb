#include "xr/internal.h"

#include <string.h>

static enum ap_status create_space(struct ap_error *err, struct ap_xr *xr,
                                   XrReferenceSpaceType type, XrSpace *space) {
    XrReferenceSpaceCreateInfo info = {.type = XR_TYPE_REFERENCE_SPACE_CREATE_INFO,
                                       .referenceSpaceType = type,
                                       .poseInReferenceSpace = {.orientation = {0, 0, 0, 1}}};
    return ap_xr_check(err, xr, ap_xrl.CreateReferenceSpace(xr->session, &info, space),
                       "xrCreateReferenceSpace");
}

static bool offers_stage(struct ap_xr *xr) {
    XrReferenceSpaceType types[32];
    uint32_t count = 0;
    if (XR_FAILED(ap_xrl.EnumerateReferenceSpaces(xr->session, 32, &count, types)))
        return false;
    for (uint32_t i = 0; i < count; i++)
        if (types[i] == XR_REFERENCE_SPACE_TYPE_STAGE)
            return true;
    return false;
}

static enum ap_status choose_blend_mode(struct ap_error *err, struct ap_xr *xr) {
    XrEnvironmentBlendMode modes[8];
    uint32_t count = 0;
    XrResult r = ap_xrl.EnumerateEnvironmentBlendModes(
        xr->instance, xr->system, XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO, 8, &count, modes);
    if (XR_FAILED(r) || count == 0)
        return ap_xr_check(err, xr, XR_FAILED(r) ? r : XR_ERROR_RUNTIME_FAILURE,
                           "xrEnumerateEnvironmentBlendModes");
    xr->blend = modes[0]; // the runtime's own preference stands first
    for (uint32_t i = 0; i < count; i++)
        if (modes[i] == XR_ENVIRONMENT_BLEND_MODE_OPAQUE)
            xr->blend = modes[i];
    return AP_OK;
}

enum ap_status ap_xr_session_create(struct ap_error *err, struct ap_xr *xr) {
    XrGraphicsBindingVulkanKHR binding = {.type = XR_TYPE_GRAPHICS_BINDING_VULKAN_KHR,
                                          .instance = xr->vk_instance,
                                          .physicalDevice = xr->vk_physical,
                                          .device = xr->vk_device,
                                          .queueFamilyIndex = xr->queue_family,
                                          .queueIndex = 0};
    XrSessionCreateInfo info = {
        .type = XR_TYPE_SESSION_CREATE_INFO, .next = &binding, .systemId = xr->system};
    enum ap_status st = ap_xr_check(
        err, xr, ap_xrl.CreateSession(xr->instance, &info, &xr->session), "xrCreateSession");
    if (st)
        return st;
    st = create_space(err, xr, XR_REFERENCE_SPACE_TYPE_VIEW, &xr->view);
    if (st)
        return st;
    xr->has_stage = offers_stage(xr);
    st = create_space(err, xr,
                      xr->has_stage ? XR_REFERENCE_SPACE_TYPE_STAGE : XR_REFERENCE_SPACE_TYPE_LOCAL,
                      &xr->stage);
    return st ? st : choose_blend_mode(err, xr);
}

static enum ap_status begin_session(struct ap_error *err, struct ap_xr *xr) {
    XrSessionBeginInfo info = {.type = XR_TYPE_SESSION_BEGIN_INFO,
                               .primaryViewConfigurationType =
                                   XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO};
    enum ap_status st =
        ap_xr_check(err, xr, ap_xrl.BeginSession(xr->session, &info), "xrBeginSession");
    xr->running = st == AP_OK;
    return st;
}

static enum ap_status handle_state(struct ap_error *err, struct ap_xr *xr, XrSessionState state) {
    xr->state = state;
    switch (state) {
    case XR_SESSION_STATE_READY:
        return begin_session(err, xr);
    case XR_SESSION_STATE_STOPPING:
        xr->running = false;
        return ap_xr_check(err, xr, ap_xrl.EndSession(xr->session), "xrEndSession");
    case XR_SESSION_STATE_EXITING:
        xr->ended = true;
        return AP_OK;
    case XR_SESSION_STATE_LOSS_PENDING:
        xr->lost = true;
        return AP_OK;
    default:
        return AP_OK;
    }
}

static enum ap_status handle_event(struct ap_error *err, struct ap_xr *xr,
                                   const XrEventDataBuffer *event) {
    if (event->type == XR_TYPE_EVENT_DATA_INSTANCE_LOSS_PENDING)
        xr->lost = true;
    if (event->type != XR_TYPE_EVENT_DATA_SESSION_STATE_CHANGED)
        return AP_OK;
    XrEventDataSessionStateChanged change;
    memcpy(&change, event, sizeof change);
    return change.session == xr->session ? handle_state(err, xr, change.state) : AP_OK;
}

enum ap_status ap_xr_poll(struct ap_error *err, struct ap_xr *xr, enum ap_xr_state *state) {
    while (!xr->lost) {
        XrEventDataBuffer event = {.type = XR_TYPE_EVENT_DATA_BUFFER};
        XrResult r = ap_xrl.PollEvent(xr->instance, &event);
        if (r == XR_EVENT_UNAVAILABLE)
            break;
        enum ap_status st = ap_xr_check(err, xr, r, "xrPollEvent");
        if (!st)
            st = handle_event(err, xr, &event);
        if (st && !xr->lost)
            return st;
    }
    *state = xr->lost      ? AP_XR_LOST
             : xr->ended   ? AP_XR_ENDED
             : xr->running ? AP_XR_RUNNING
                           : AP_XR_WAITING;
    return AP_OK;
}

enum ap_status ap_xr_request_exit(struct ap_error *err, struct ap_xr *xr) {
    if (xr->lost || xr->ended)
        return AP_OK;
    if (!xr->running) {
        xr->ended = true;
        return AP_OK;
    }
    return ap_xr_check(err, xr, ap_xrl.RequestExitSession(xr->session), "xrRequestExitSession");
}
