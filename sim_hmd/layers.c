#include <math.h>

#include "sim_hmd/runtime.h"

// A pose that is the display's to float rounding, though it may have gone through another space.
static bool same_pose(struct ap_pose a, struct ap_pose b) {
    double d = ap_vec3_length(ap_vec3_sub(a.p, b.p));
    double dot = a.q.x * b.q.x + a.q.y * b.q.y + a.q.z * b.q.z + a.q.w * b.q.w;
    return d <= 1e-5 && fabs(dot) >= 1 - 1e-11;
}

static bool same_fov(XrFovf a, XrFovf b) {
    return a.angleLeft == b.angleLeft && a.angleRight == b.angleRight && a.angleUp == b.angleUp &&
           a.angleDown == b.angleDown;
}

static bool fov_usable(XrFovf fov) {
    const float a[] = {fov.angleLeft, fov.angleRight, fov.angleUp, fov.angleDown};
    for (int i = 0; i < 4; i++)
        if (!(fabsf(a[i]) < 1.5707963f))
            return false;
    return fov.angleLeft != fov.angleRight && fov.angleUp != fov.angleDown;
}

static XrResult resolve_image(const XrSwapchainSubImage *sub, struct sim_session *session,
                              struct sim_layer_view *view) {
    struct sim_swapchain *swapchain;
    XrResult result = sim_swapchain_get(sub->swapchain, &swapchain);
    if (result != XR_SUCCESS)
        return result;
    if (swapchain->session != session || swapchain->depth || swapchain->released < 0)
        return XR_ERROR_LAYER_INVALID;
    if (sub->imageArrayIndex >= swapchain->info.arraySize)
        return XR_ERROR_VALIDATION_FAILURE;
    XrRect2Di r = sub->imageRect;
    if (r.offset.x < 0 || r.offset.y < 0 || r.extent.width <= 0 || r.extent.height <= 0 ||
        (int64_t)r.offset.x + r.extent.width > (int64_t)swapchain->info.width ||
        (int64_t)r.offset.y + r.extent.height > (int64_t)swapchain->info.height)
        return XR_ERROR_SWAPCHAIN_RECT_INVALID;
    view->image = swapchain->image[swapchain->released].image;
    view->format = (VkFormat)swapchain->info.format;
    view->width_px = swapchain->info.width;
    view->height_px = swapchain->info.height;
    view->samples = swapchain->info.sampleCount;
    view->array_layer = sub->imageArrayIndex;
    view->rect = r;
    return XR_SUCCESS;
}

static XrResult resolve_view(struct sim_session *session, const struct sim_space *space,
                             const XrCompositionLayerProjectionView *in,
                             const struct sim_frame *frame, int eye, struct sim_layer_view *out) {
    if (in->type != XR_TYPE_COMPOSITION_LAYER_PROJECTION_VIEW)
        return XR_ERROR_VALIDATION_FAILURE;
    XrResult result = resolve_image(&in->subImage, session, out);
    if (result != XR_SUCCESS)
        return result;
    struct ap_pose space_from_view;
    if (!sim_pose_from_xr(in->pose, &space_from_view))
        return XR_ERROR_POSE_INVALID;
    if (!fov_usable(in->fov))
        return XR_ERROR_VALIDATION_FAILURE;
    struct sim_located at = sim_space_in_stage(space, frame->display_time);
    out->stage_from_view = ap_pose_mul(at.pose, space_from_view);
    out->submitted_pose = in->pose;
    out->fov = in->fov;
    out->at_display = same_fov(in->fov, frame->fov[eye]) &&
                      same_pose(out->stage_from_view, frame->stage_from_eye[eye]);
    return XR_SUCCESS;
}

static XrResult resolve_layer(struct sim_session *session, const XrCompositionLayerBaseHeader *in,
                              const struct sim_frame *frame, struct sim_layer *out) {
    if (!sim_is(in, XR_TYPE_COMPOSITION_LAYER_PROJECTION))
        return XR_ERROR_LAYER_INVALID;
    const XrCompositionLayerProjection *layer = (const XrCompositionLayerProjection *)in;
    const struct sim_space *space = sim_space_get(layer->space);
    if (!space)
        return XR_ERROR_HANDLE_INVALID;
    if (space->session != session)
        return XR_ERROR_VALIDATION_FAILURE;
    if (layer->viewCount != 2 || !layer->views)
        return XR_ERROR_VALIDATION_FAILURE;
    out->blend_alpha = layer->layerFlags & XR_COMPOSITION_LAYER_BLEND_TEXTURE_SOURCE_ALPHA_BIT;
    out->unpremultiplied = layer->layerFlags & XR_COMPOSITION_LAYER_UNPREMULTIPLIED_ALPHA_BIT;
    for (int eye = 0; eye < 2; eye++) {
        XrResult result =
            resolve_view(session, space, &layer->views[eye], frame, eye, &out->view[eye]);
        if (result != XR_SUCCESS)
            return result;
    }
    return XR_SUCCESS;
}

XrResult sim_layers_resolve(struct sim_session *session, const XrFrameEndInfo *info,
                            struct sim_frame *frame) {
    if (info->layerCount > SIM_MAX_LAYERS)
        return XR_ERROR_LAYER_LIMIT_EXCEEDED;
    if (info->layerCount && !info->layers)
        return XR_ERROR_VALIDATION_FAILURE;
    struct sim_located head = sim_head_in_stage(session, frame->display_time);
    for (int eye = 0; eye < 2; eye++) {
        frame->stage_from_eye[eye] = ap_pose_mul(
            head.pose, ap_headset_view_from_eye(&session->instance->settings.profile, eye));
        frame->fov[eye] = sim_fov(session, eye);
    }
    for (uint32_t i = 0; i < info->layerCount; i++) {
        XrResult result = resolve_layer(session, info->layers[i], frame, &frame->layer[i]);
        if (result != XR_SUCCESS)
            return result;
    }
    frame->layer_count = info->layerCount;
    return XR_SUCCESS;
}
