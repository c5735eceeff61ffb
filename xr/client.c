#include "xr/internal.h"

#include <stdlib.h>

enum ap_status ap_xr_create(struct ap_error *err, const struct ap_xr_params *params,
                            struct ap_xr **out) {
    struct ap_xr *xr = calloc(1, sizeof *xr);
    if (!xr)
        return ap_fail(err, AP_ENVIRONMENT, "out of memory");
    enum ap_status st = ap_xr_loader_open(err);
    if (!st)
        st = ap_xr_instance_create(err, params, xr);
    if (!st)
        st = ap_xr_vulkan_create(err, xr);
    if (!st)
        st = ap_xr_session_create(err, xr);
    if (!st)
        st = ap_xr_swapchains_create(err, params, xr);
    if (!st)
        st = ap_xr_actions_create(err, xr);
    if (st)
        ap_xr_destroy(xr);
    else
        *out = xr;
    return st;
}

void ap_xr_destroy(struct ap_xr *xr) {
    if (!xr)
        return;
    if (xr->vk_device)
        vkDeviceWaitIdle(xr->vk_device);
    for (int i = 0; i < AP_XR_MAX_PANELS; i++)
        ap_xr_panel_destroy(xr->panel[i]);
    // Children go with their parents: spaces and swapchains with the session, actions with the set.
    if (xr->session)
        ap_xrl.DestroySession(xr->session);
    if (xr->actions.set)
        ap_xrl.DestroyActionSet(xr->actions.set);
    if (xr->vk_device)
        vkDestroyDevice(xr->vk_device, NULL);
    if (xr->vk_instance)
        vkDestroyInstance(xr->vk_instance, NULL);
    if (xr->instance)
        ap_xrl.DestroyInstance(xr->instance);
    free(xr);
}

struct ap_xr_vulkan ap_xr_vulkan(const struct ap_xr *xr) {
    return (struct ap_xr_vulkan){.instance = xr->vk_instance,
                                 .physical_device = xr->vk_physical,
                                 .device = xr->vk_device,
                                 .queue_family = xr->queue_family,
                                 .multiview = xr->multiview,
                                 .color_format = xr->format,
                                 .width_px = xr->width,
                                 .height_px = xr->height};
}

const char *ap_xr_runtime_name(const struct ap_xr *xr) {
    return xr->runtime_name;
}

const char *ap_xr_system_name(const struct ap_xr *xr) {
    return xr->system_name;
}

bool ap_xr_has_stage(const struct ap_xr *xr) {
    return xr->has_stage;
}

bool ap_xr_stage_bounds(struct ap_xr *xr, double *width_m, double *depth_m) {
    XrExtent2Df bounds;
    if (!xr->has_stage || ap_xrl.GetReferenceSpaceBoundsRect(
                              xr->session, XR_REFERENCE_SPACE_TYPE_STAGE, &bounds) != XR_SUCCESS)
        return false;
    if (!(bounds.width > 0) || !(bounds.height > 0))
        return false;
    *width_m = bounds.width;
    *depth_m = bounds.height;
    return true;
}

static enum ap_status locate_in(struct ap_error *err, struct ap_xr *xr, XrSpace space, XrTime time,
                                XrView located[2]) {
    XrViewLocateInfo info = {.type = XR_TYPE_VIEW_LOCATE_INFO,
                             .viewConfigurationType = XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO,
                             .displayTime = time,
                             .space = space};
    XrViewState state = {.type = XR_TYPE_VIEW_STATE};
    for (int i = 0; i < 2; i++)
        located[i] = (XrView){.type = XR_TYPE_VIEW};
    uint32_t count = 0;
    return ap_xr_check(err, xr, ap_xrl.LocateViews(xr->session, &info, &state, 2, &count, located),
                       "xrLocateViews");
}

// Twice: in VIEW for the picture (the eyes as offsets from the nose), in STAGE for the layer, so
// that the runtime may reproject it to where the head is when it is shown.
static enum ap_status locate_views(struct ap_error *err, struct ap_xr *xr, XrTime time,
                                   struct ap_xr_view views[2]) {
    XrView located[2];
    enum ap_status st = locate_in(err, xr, xr->view, time, located);
    if (!st)
        st = locate_in(err, xr, xr->stage, time, xr->located);
    if (st)
        return st;
    for (int i = 0; i < 2; i++) {
        const XrFovf *fov = &located[i].fov;
        views[i] = (struct ap_xr_view){.view_from_eye = ap_pose_from_xr(located[i].pose),
                                       .left_rad = fov->angleLeft,
                                       .right_rad = fov->angleRight,
                                       .up_rad = fov->angleUp,
                                       .down_rad = fov->angleDown,
                                       .width_px = xr->config[i].recommendedImageRectWidth,
                                       .height_px = xr->config[i].recommendedImageRectHeight};
    }
    return AP_OK;
}

static enum ap_status locate_all(struct ap_error *err, struct ap_xr *xr,
                                 struct ap_xr_frame *frame) {
    enum ap_status st = ap_xr_locate(err, xr, xr->view, frame->time_ns, &frame->head);
    if (!st)
        st = locate_views(err, xr, frame->time_ns, frame->view);
    return st ? st : ap_xr_actions_read(err, xr, frame->time_ns, frame->hand);
}

enum ap_status ap_xr_begin_frame(struct ap_error *err, struct ap_xr *xr, struct ap_xr_frame *out) {
    XrFrameWaitInfo wait = {.type = XR_TYPE_FRAME_WAIT_INFO};
    XrFrameState state = {.type = XR_TYPE_FRAME_STATE};
    enum ap_status st =
        ap_xr_check(err, xr, ap_xrl.WaitFrame(xr->session, &wait, &state), "xrWaitFrame");
    if (st)
        return st;
    XrFrameBeginInfo begin = {.type = XR_TYPE_FRAME_BEGIN_INFO};
    st = ap_xr_check(err, xr, ap_xrl.BeginFrame(xr->session, &begin), "xrBeginFrame");
    if (st)
        return st;
    struct ap_xr_frame frame = {.time_ns = state.predictedDisplayTime,
                                .period_ns = state.predictedDisplayPeriod,
                                .should_render = state.shouldRender == XR_TRUE};
    st = locate_all(err, xr, &frame);
    if (!st)
        *out = frame;
    return st;
}

static enum ap_status release_images(struct ap_error *err, struct ap_xr *xr) {
    enum ap_status st = AP_OK;
    for (int i = 0; !st && i < xr->swapchain_count; i++)
        st = ap_xr_swapchain_release(err, xr, &xr->swapchain[i]);
    return st;
}

enum ap_status ap_xr_end_frame(struct ap_error *err, struct ap_xr *xr,
                               const struct ap_xr_frame *frame) {
    bool drawn = xr->drawing;
    xr->drawing = false;
    if (drawn) {
        enum ap_status st = release_images(err, xr);
        if (st)
            return st;
    }
    XrCompositionLayerProjectionView views[2];
    for (int i = 0; i < 2; i++) {
        bool array = xr->swapchain_count == 1;
        views[i] = (XrCompositionLayerProjectionView){
            .type = XR_TYPE_COMPOSITION_LAYER_PROJECTION_VIEW,
            .pose = xr->located[i].pose,
            .fov = xr->located[i].fov,
            .subImage = {.swapchain = xr->swapchain[array ? 0 : i].handle,
                         .imageRect = {.extent = {(int32_t)frame->view[i].width_px,
                                                  (int32_t)frame->view[i].height_px}},
                         .imageArrayIndex = array ? (uint32_t)i : 0}};
    }
    XrCompositionLayerProjection projection = {.type = XR_TYPE_COMPOSITION_LAYER_PROJECTION,
                                               .space = xr->stage,
                                               .viewCount = 2,
                                               .views = views};
    XrCompositionLayerQuad quads[AP_XR_MAX_PANELS];
    const XrCompositionLayerBaseHeader *layers[1 + AP_XR_MAX_PANELS];
    uint32_t count = 0, panels = ap_xr_panel_layers(xr, quads);
    if (drawn)
        layers[count++] = (const XrCompositionLayerBaseHeader *)&projection;
    for (uint32_t i = 0; i < panels; i++)
        layers[count++] = (const XrCompositionLayerBaseHeader *)&quads[i];
    XrFrameEndInfo end = {.type = XR_TYPE_FRAME_END_INFO,
                          .displayTime = frame->time_ns,
                          .environmentBlendMode = xr->blend,
                          .layerCount = count,
                          .layers = layers};
    return ap_xr_check(err, xr, ap_xrl.EndFrame(xr->session, &end), "xrEndFrame");
}
