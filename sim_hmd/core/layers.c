#include <math.h>
#include <string.h>

#include "sim_hmd/compose/frame.h"
#include "sim_hmd/core/layers.h"
#include "sim_hmd/core/spaces.h"
#include "sim_hmd/core/swapchains.h"
#include "sim_hmd/strict/strict.h"

static const double TURN = 6.28318530717958647692; // 2π

static const XrCompositionLayerFlags known_flags =
    XR_COMPOSITION_LAYER_CORRECT_CHROMATIC_ABERRATION_BIT |
    XR_COMPOSITION_LAYER_BLEND_TEXTURE_SOURCE_ALPHA_BIT |
    XR_COMPOSITION_LAYER_UNPREMULTIPLIED_ALPHA_BIT;

// A pose that is the display's to float rounding, though it may have gone through another space.
SIM_HOT static bool same_pose(struct ap_pose a, struct ap_pose b) {
    double d = ap_vec3_length(ap_vec3_sub(a.p, b.p));
    double dot = a.q.x * b.q.x + a.q.y * b.q.y + a.q.z * b.q.z + a.q.w * b.q.w;
    return d <= 1e-5 && fabs(dot) >= 1 - 1e-11;
}

SIM_HOT static bool same_fov(XrFovf a, XrFovf b) {
    return a.angleLeft == b.angleLeft && a.angleRight == b.angleRight && a.angleUp == b.angleUp &&
           a.angleDown == b.angleDown;
}

SIM_HOT static bool fov_usable(XrFovf fov) {
    const float a[] = {fov.angleLeft, fov.angleRight, fov.angleUp, fov.angleDown};
    for (int i = 0; i < 4; i++)
        if (!(fabsf(a[i]) < 1.5707963f))
            return false;
    return fov.angleLeft != fov.angleRight && fov.angleUp != fov.angleDown;
}

// What every kind of layer is resolved from.
struct in {
    struct sim_session *session;
    const struct sim_frame *frame;
    const XrCompositionLayerBaseHeader *layer;
    struct ap_pose stage_from_space;
};

// The image that the swapchain shows now.
SIM_HOT static XrResult resolve_image(XrSwapchain handle, const struct sim_session *session,
                                      bool depth, uint32_t faces, uint32_t index,
                                      struct sim_layer_view *view) {
    struct sim_swapchain *swapchain;
    XrResult result = sim_swapchain_get(handle, &swapchain);
    if (result != XR_SUCCESS)
        return result;
    const XrSwapchainCreateInfo *info = &swapchain->info;
    if (swapchain->session != session || swapchain->depth != depth || swapchain->released < 0)
        return XR_ERROR_LAYER_INVALID;
    if (info->faceCount != faces || index >= info->arraySize)
        return sim_strict(
            XR_ERROR_VALIDATION_FAILURE, "xrEndFrame",
            "XrSwapchainSubImage: imageArrayIndex is below arraySize; cubes for cubes",
            "index %u of %u, %u faces", index, info->arraySize, info->faceCount);
    view->image = swapchain->image[swapchain->released].image;
    view->format = (VkFormat)info->format;
    view->width_px = info->width;
    view->height_px = info->height;
    view->samples = info->sampleCount;
    view->mips = info->mipCount;
    view->array_layer = index;
    view->rect = (XrRect2Di){{0, 0}, {(int32_t)info->width, (int32_t)info->height}};
    return XR_SUCCESS;
}

SIM_HOT static XrResult resolve_sub_image(const XrSwapchainSubImage *sub,
                                          const struct sim_session *session, bool depth,
                                          struct sim_layer_view *view) {
    XrResult result = resolve_image(sub->swapchain, session, depth, 1, sub->imageArrayIndex, view);
    if (result != XR_SUCCESS)
        return result;
    XrRect2Di r = sub->imageRect;
    if (r.offset.x < 0 || r.offset.y < 0 || r.extent.width <= 0 || r.extent.height <= 0 ||
        (int64_t)r.offset.x + r.extent.width > (int64_t)view->width_px ||
        (int64_t)r.offset.y + r.extent.height > (int64_t)view->height_px)
        return XR_ERROR_SWAPCHAIN_RECT_INVALID;
    view->rect = r;
    return XR_SUCCESS;
}

SIM_HOT static XrResult resolve_pose(XrPosef pose, struct ap_pose stage_from_space,
                                     struct sim_layer_view *view) {
    struct ap_pose space_from_layer;
    if (!sim_pose_from_xr(pose, &space_from_layer))
        return XR_ERROR_POSE_INVALID;
    view->stage_from_view = ap_pose_mul(stage_from_space, space_from_layer);
    view->submitted_pose = pose;
    return XR_SUCCESS;
}

// ---- Projections

// A projection's depth is verified and captured, and that is all: nothing is reprojected by place.
SIM_HOT static XrResult resolve_depth(struct sim_session *session,
                                      const XrCompositionLayerProjectionView *view, bool *has,
                                      struct sim_layer_depth *out) {
    const XrCompositionLayerDepthInfoKHR *depth =
        sim_chained(view, XR_TYPE_COMPOSITION_LAYER_DEPTH_INFO_KHR);
    if (!depth || !session->instance->enabled[SIM_KHR_composition_layer_depth])
        return XR_SUCCESS;
    struct sim_layer_view image;
    XrResult result = resolve_sub_image(&depth->subImage, session, true, &image);
    if (result != XR_SUCCESS)
        return result;
    // The comparisons are false for NaN.
    bool range = depth->minDepth >= 0 && depth->minDepth < depth->maxDepth && depth->maxDepth <= 1;
    if (!range || !(depth->nearZ > 0) || !(depth->farZ > 0) || depth->nearZ == depth->farZ)
        return sim_strict(
            XR_ERROR_VALIDATION_FAILURE, "xrEndFrame",
            "XrCompositionLayerDepthInfoKHR: 0 <= minDepth < maxDepth <= 1, nearZ and "
            "farZ positive and different",
            "minDepth %g, maxDepth %g, nearZ %g, farZ %g", (double)depth->minDepth,
            (double)depth->maxDepth, (double)depth->nearZ, (double)depth->farZ);
    *has = true;
    *out = (struct sim_layer_depth){.image = image.image,
                                    .format = image.format,
                                    .width_px = image.width_px,
                                    .height_px = image.height_px,
                                    .samples = image.samples,
                                    .array_layer = image.array_layer,
                                    .rect = image.rect,
                                    .min = depth->minDepth,
                                    .max = depth->maxDepth,
                                    .near_m = depth->nearZ,
                                    .far_m = depth->farZ};
    return XR_SUCCESS;
}

SIM_HOT static XrResult resolve_view(struct sim_session *session, const struct sim_frame *frame,
                                     int eye, struct ap_pose stage_from_space,
                                     const XrCompositionLayerProjectionView *in,
                                     struct sim_layer *layer) {
    struct sim_layer_view *out = &layer->view[eye];
    if (in->type != XR_TYPE_COMPOSITION_LAYER_PROJECTION_VIEW)
        return XR_ERROR_VALIDATION_FAILURE;
    XrResult result = resolve_sub_image(&in->subImage, session, false, out);
    if (result == XR_SUCCESS)
        result = resolve_pose(in->pose, stage_from_space, out);
    if (result != XR_SUCCESS)
        return result;
    if (!fov_usable(in->fov))
        return XR_ERROR_VALIDATION_FAILURE;
    out->fov = in->fov;
    out->at_display = same_fov(in->fov, frame->fov[eye]) &&
                      same_pose(out->stage_from_view, frame->stage_from_eye[eye]);
    return resolve_depth(session, in, &layer->has_depth[eye], &layer->depth[eye]);
}

SIM_HOT static XrResult resolve_projection(const struct in *in, struct sim_layer *out) {
    const XrCompositionLayerProjection *layer = (const XrCompositionLayerProjection *)in->layer;
    if (layer->viewCount != 2 || !layer->views)
        return sim_strict(XR_ERROR_VALIDATION_FAILURE, "xrEndFrame",
                          "XrCompositionLayerProjection: viewCount is the view configuration's, 2",
                          "viewCount is %u", layer->viewCount);
    out->kind = SIM_LAYER_PROJECTION;
    for (int eye = 0; eye < 2; eye++) {
        XrResult result = resolve_view(in->session, in->frame, eye, in->stage_from_space,
                                       &layer->views[eye], out);
        if (result != XR_SUCCESS)
            return result;
    }
    return XR_SUCCESS;
}

// ---- One picture in the room

static XrResult resolve_eyes(XrEyeVisibility eyes, struct sim_layer *out) {
    if (eyes != XR_EYE_VISIBILITY_BOTH && eyes != XR_EYE_VISIBILITY_LEFT &&
        eyes != XR_EYE_VISIBILITY_RIGHT)
        return XR_ERROR_VALIDATION_FAILURE;
    out->hidden[0] |= eyes == XR_EYE_VISIBILITY_RIGHT;
    out->hidden[1] |= eyes == XR_EYE_VISIBILITY_LEFT;
    return XR_SUCCESS;
}

static XrResult resolve_picture(const struct in *in, XrEyeVisibility eyes,
                                const XrSwapchainSubImage *sub, XrPosef pose,
                                struct sim_layer *out) {
    XrResult result = resolve_eyes(eyes, out);
    if (result == XR_SUCCESS)
        result = resolve_sub_image(sub, in->session, false, &out->view[0]);
    if (result == XR_SUCCESS)
        result = resolve_pose(pose, in->stage_from_space, &out->view[0]);
    out->view[1] = out->view[0];
    return result;
}

// Zero and infinity are infinitely far.
static bool resolve_radius(float radius, struct sim_layer *out) {
    out->radius_m = isfinite(radius) ? (double)radius : 0;
    return radius >= 0; // false for NaN
}

static bool within(float x, double low, double high) {
    const double float_rounding = 1e-6;
    return (double)x >= low - float_rounding && (double)x <= high + float_rounding;
}

static XrResult resolve_quad(const struct in *in, struct sim_layer *out) {
    const XrCompositionLayerQuad *quad = (const XrCompositionLayerQuad *)in->layer;
    XrExtent2Df size = quad->size;
    if (!(size.width >= 0) || !(size.height >= 0) || !isfinite(size.width) ||
        !isfinite(size.height))
        return sim_strict(XR_ERROR_VALIDATION_FAILURE, "xrEndFrame",
                          "XrCompositionLayerQuad: size is not negative", "%g by %g",
                          (double)size.width, (double)size.height);
    out->kind = SIM_LAYER_QUAD;
    out->width_m = (double)size.width;
    out->height_m = (double)size.height;
    return resolve_picture(in, quad->eyeVisibility, &quad->subImage, quad->pose, out);
}

static XrResult resolve_cylinder(const struct in *in, struct sim_layer *out) {
    const XrCompositionLayerCylinderKHR *c = (const XrCompositionLayerCylinderKHR *)in->layer;
    if (!resolve_radius(c->radius, out) || !within(c->centralAngle, 0, TURN) ||
        !(c->aspectRatio > 0) || !isfinite(c->aspectRatio))
        return sim_strict(XR_ERROR_VALIDATION_FAILURE, "xrEndFrame",
                          "XrCompositionLayerCylinderKHR: radius >= 0, centralAngle in [0, 2pi), "
                          "aspectRatio > 0",
                          "radius %g, centralAngle %g, aspectRatio %g", (double)c->radius,
                          (double)c->centralAngle, (double)c->aspectRatio);
    out->kind = SIM_LAYER_CYLINDER;
    out->central_rad = (double)c->centralAngle;
    out->height_radii = out->central_rad / (double)c->aspectRatio;
    return resolve_picture(in, c->eyeVisibility, &c->subImage, c->pose, out);
}

// The picture spans `scale` of the whole sphere, its middle moved by `bias` of it: right and down.
static XrResult resolve_equirect(const struct in *in, struct sim_layer *out) {
    const XrCompositionLayerEquirectKHR *e = (const XrCompositionLayerEquirectKHR *)in->layer;
    if (!resolve_radius(e->radius, out) || !isfinite(e->scale.x) || !isfinite(e->scale.y) ||
        !isfinite(e->bias.x) || !isfinite(e->bias.y))
        return XR_ERROR_VALIDATION_FAILURE;
    out->kind = SIM_LAYER_EQUIRECT;
    out->central_rad = TURN * (double)e->scale.x;
    double middle = -0.5 * TURN * (double)e->bias.y, half = 0.25 * TURN * (double)e->scale.y;
    out->upper_rad = middle + half;
    out->lower_rad = middle - half;
    XrResult result = resolve_picture(in, e->eyeVisibility, &e->subImage, e->pose, out);
    struct ap_quat aside =
        ap_quat_from_axis_angle((struct ap_vec3){0, 1, 0}, -TURN * fmod((double)e->bias.x, 1));
    for (int eye = 0; eye < 2; eye++)
        out->view[eye].stage_from_view.q = ap_quat_mul(out->view[eye].stage_from_view.q, aside);
    return result;
}

static XrResult resolve_equirect2(const struct in *in, struct sim_layer *out) {
    const XrCompositionLayerEquirect2KHR *e = (const XrCompositionLayerEquirect2KHR *)in->layer;
    if (!resolve_radius(e->radius, out) || !within(e->centralHorizontalAngle, 0, TURN) ||
        !within(e->upperVerticalAngle, -0.25 * TURN, 0.25 * TURN) ||
        !within(e->lowerVerticalAngle, -0.25 * TURN, 0.25 * TURN))
        return sim_strict(XR_ERROR_VALIDATION_FAILURE, "xrEndFrame",
                          "XrCompositionLayerEquirect2KHR: radius >= 0, centralHorizontalAngle in "
                          "[0, 2pi], vertical angles in [-pi/2, pi/2]",
                          "radius %g, angles %g, %g, %g", (double)e->radius,
                          (double)e->centralHorizontalAngle, (double)e->upperVerticalAngle,
                          (double)e->lowerVerticalAngle);
    out->kind = SIM_LAYER_EQUIRECT;
    out->central_rad = (double)e->centralHorizontalAngle;
    out->upper_rad = (double)e->upperVerticalAngle;
    out->lower_rad = (double)e->lowerVerticalAngle;
    return resolve_picture(in, e->eyeVisibility, &e->subImage, e->pose, out);
}

static XrResult resolve_cube(const struct in *in, struct sim_layer *out) {
    const XrCompositionLayerCubeKHR *cube = (const XrCompositionLayerCubeKHR *)in->layer;
    XrResult result = resolve_eyes(cube->eyeVisibility, out);
    if (result == XR_SUCCESS)
        result = resolve_image(cube->swapchain, in->session, false, 6, cube->imageArrayIndex,
                               &out->view[0]);
    if (result == XR_SUCCESS)
        result = resolve_pose((XrPosef){.orientation = cube->orientation}, in->stage_from_space,
                              &out->view[0]);
    out->kind = SIM_LAYER_CUBE;
    out->view[0].array_layer *= 6;
    out->view[1] = out->view[0];
    return result;
}

// ---- All of them

static const struct {
    XrStructureType type;
    int extension; // enum sim_extension_id; −1: core
    XrResult (*resolve)(const struct in *in, struct sim_layer *out);
} kinds[] = {
    {XR_TYPE_COMPOSITION_LAYER_PROJECTION, -1, resolve_projection},
    {XR_TYPE_COMPOSITION_LAYER_QUAD, -1, resolve_quad},
    {XR_TYPE_COMPOSITION_LAYER_CYLINDER_KHR, SIM_KHR_composition_layer_cylinder, resolve_cylinder},
    {XR_TYPE_COMPOSITION_LAYER_EQUIRECT_KHR, SIM_KHR_composition_layer_equirect, resolve_equirect},
    {XR_TYPE_COMPOSITION_LAYER_EQUIRECT2_KHR, SIM_KHR_composition_layer_equirect2,
     resolve_equirect2},
    {XR_TYPE_COMPOSITION_LAYER_CUBE_KHR, SIM_KHR_composition_layer_cube, resolve_cube},
};

SIM_HOT static int kind_of(const struct sim_session *session,
                           const XrCompositionLayerBaseHeader *layer) {
    int k = 0, count = sizeof kinds / sizeof *kinds;
    while (k < count && kinds[k].type != layer->type)
        k++;
    if (k == count || (kinds[k].extension >= 0 && !session->instance->enabled[kinds[k].extension]))
        return -1;
    return k;
}

SIM_HOT static XrResult resolve_layer(struct sim_session *session, const struct sim_frame *frame,
                                      const XrCompositionLayerBaseHeader *layer,
                                      struct sim_layer *out) {
    int kind = layer ? kind_of(session, layer) : -1;
    if (kind < 0)
        return XR_ERROR_LAYER_INVALID;
    const struct sim_space *space = sim_space_get(layer->space);
    if (!space)
        return XR_ERROR_HANDLE_INVALID;
    if (space->session != session || layer->layerFlags & ~known_flags)
        return XR_ERROR_VALIDATION_FAILURE;
    memset(out, 0, offsetof(struct sim_layer, depth));
    out->blend_alpha = layer->layerFlags & XR_COMPOSITION_LAYER_BLEND_TEXTURE_SOURCE_ALPHA_BIT;
    out->unpremultiplied = layer->layerFlags & XR_COMPOSITION_LAYER_UNPREMULTIPLIED_ALPHA_BIT;
    struct sim_located at = sim_space_in_stage(space, frame->display_time);
    // What hangs on a controller that was never seen is nowhere.
    out->hidden[0] = out->hidden[1] = space->is_action && at.state == AP_POSE_NONE;
    struct in in = {session, frame, layer, at.pose};
    return kinds[kind].resolve(&in, out);
}

SIM_HOT XrResult sim_layers_resolve(struct sim_session *session, const XrFrameEndInfo *info,
                                    struct sim_frame *frame) {
    if (info->layerCount > SIM_MAX_LAYERS)
        return XR_ERROR_LAYER_LIMIT_EXCEEDED;
    if (info->layerCount && !info->layers)
        return XR_ERROR_VALIDATION_FAILURE;
    struct sim_located head = sim_head_in_stage(session, frame->display_time);
    for (int eye = 0; eye < 2; eye++) {
        frame->stage_from_eye[eye] = ap_pose_mul(head.pose, session->view_from_eye[eye]);
        frame->fov[eye] = session->fov[eye];
    }
    for (uint32_t i = 0; i < info->layerCount; i++) {
        XrResult result = resolve_layer(session, frame, info->layers[i], &frame->layer[i]);
        if (result != XR_SUCCESS)
            return result;
    }
    frame->layer_count = info->layerCount;
    return XR_SUCCESS;
}
