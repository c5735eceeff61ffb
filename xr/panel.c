#include <stdlib.h>

#include "xr/internal.h"

static int free_slot(const struct ap_xr *xr) {
    for (int i = 0; i < AP_XR_MAX_PANELS; i++)
        if (!xr->panel[i])
            return i;
    return -1;
}

enum ap_status ap_xr_panel_create(struct ap_error *err, struct ap_xr *xr,
                                  const struct ap_xr_panel_params *params,
                                  struct ap_xr_panel **out) {
    int slot = free_slot(xr);
    if (slot < 0 || params->width_px == 0 || params->height_px == 0)
        return ap_fail(err, AP_USAGE, "a panel of %ux%u pixels: at least 1x1, %d at a time",
                       params->width_px, params->height_px, AP_XR_MAX_PANELS);
    struct ap_xr_panel *panel = calloc(1, sizeof *panel);
    if (!panel)
        return ap_fail(err, AP_ENVIRONMENT, "out of memory");
    panel->xr = xr;
    panel->params = *params;
    const XrSwapchainCreateInfo info = {.type = XR_TYPE_SWAPCHAIN_CREATE_INFO,
                                        .usageFlags = XR_SWAPCHAIN_USAGE_COLOR_ATTACHMENT_BIT |
                                                      XR_SWAPCHAIN_USAGE_TRANSFER_DST_BIT,
                                        .format = xr->format,
                                        .sampleCount = 1,
                                        .width = params->width_px,
                                        .height = params->height_px,
                                        .faceCount = 1,
                                        .arraySize = 1,
                                        .mipCount = 1};
    enum ap_status st = ap_xr_swapchain_create(err, xr, &info, &panel->swapchain);
    if (st) {
        ap_xr_panel_destroy(panel);
        return st;
    }
    xr->panel[slot] = panel;
    *out = panel;
    return AP_OK;
}

void ap_xr_panel_destroy(struct ap_xr_panel *panel) {
    if (!panel)
        return;
    for (int i = 0; i < AP_XR_MAX_PANELS; i++)
        if (panel->xr->panel[i] == panel)
            panel->xr->panel[i] = NULL;
    if (panel->swapchain.handle)
        ap_xrl.DestroySwapchain(panel->swapchain.handle);
    free(panel);
}

void ap_xr_panel_set(struct ap_xr_panel *panel, const struct ap_xr_panel_place *place) {
    panel->place = *place;
}

enum ap_status ap_xr_panel_acquire(struct ap_error *err, struct ap_xr_panel *panel,
                                   VkImage *image) {
    enum ap_status st = ap_xr_swapchain_acquire(err, panel->xr, &panel->swapchain);
    if (!st)
        *image = panel->swapchain.images[panel->swapchain.acquired];
    return st;
}

enum ap_status ap_xr_panel_release(struct ap_error *err, struct ap_xr_panel *panel) {
    enum ap_status st = ap_xr_swapchain_release(err, panel->xr, &panel->swapchain);
    panel->has_picture |= st == AP_OK;
    return st;
}

uint32_t ap_xr_panel_layers(const struct ap_xr *xr,
                            XrCompositionLayerQuad layers[AP_XR_MAX_PANELS]) {
    uint32_t count = 0;
    for (int i = 0; i < AP_XR_MAX_PANELS; i++) {
        const struct ap_xr_panel *panel = xr->panel[i];
        if (!panel || !panel->has_picture || !panel->place.shown || !(panel->place.width_m > 0))
            continue;
        float width = (float)panel->place.width_m;
        int32_t w = (int32_t)panel->params.width_px, h = (int32_t)panel->params.height_px;
        layers[count++] = (XrCompositionLayerQuad){
            .type = XR_TYPE_COMPOSITION_LAYER_QUAD,
            .layerFlags = panel->place.blended
                              ? XR_COMPOSITION_LAYER_BLEND_TEXTURE_SOURCE_ALPHA_BIT |
                                    XR_COMPOSITION_LAYER_UNPREMULTIPLIED_ALPHA_BIT
                              : 0,
            .space = panel->place.in_view ? xr->view : xr->stage,
            .eyeVisibility = XR_EYE_VISIBILITY_BOTH,
            .subImage = {.swapchain = panel->swapchain.handle, .imageRect = {.extent = {w, h}}},
            .pose = ap_pose_to_xr(panel->place.pose),
            .size = {width, width * (float)h / (float)w}};
    }
    return count;
}
