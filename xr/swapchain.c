#include "xr/internal.h"

enum { MAX_FORMATS = 256 };

static bool is_srgb(int64_t format, bool rgba_only) {
    return format == VK_FORMAT_R8G8B8A8_SRGB || (!rgba_only && format == VK_FORMAT_B8G8R8A8_SRGB);
}

// The runtime lists its formats in its order of preference.
static enum ap_status choose_format(struct ap_error *err, bool prefer_rgba, struct ap_xr *xr) {
    int64_t formats[MAX_FORMATS];
    uint32_t count = 0;
    enum ap_status st = ap_xr_check(
        err, xr, ap_xrl.EnumerateSwapchainFormats(xr->session, MAX_FORMATS, &count, formats),
        "xrEnumerateSwapchainFormats");
    if (st)
        return st;
    for (int pass = prefer_rgba ? 0 : 1; pass < 2; pass++)
        for (uint32_t i = 0; i < count; i++)
            if (is_srgb(formats[i], pass == 0)) {
                xr->format = (VkFormat)formats[i];
                return AP_OK;
            }
    return ap_fail(err, AP_ENVIRONMENT, "%s offers no 8-bit sRGB swapchain format",
                   xr->runtime_name);
}

static enum ap_status read_view_sizes(struct ap_error *err, struct ap_xr *xr) {
    uint32_t count = 0;
    for (int i = 0; i < 2; i++)
        xr->config[i] = (XrViewConfigurationView){.type = XR_TYPE_VIEW_CONFIGURATION_VIEW};
    enum ap_status st =
        ap_xr_check(err, xr,
                    ap_xrl.EnumerateViewConfigurationViews(
                        xr->instance, xr->system, XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO, 2,
                        &count, xr->config),
                    "xrEnumerateViewConfigurationViews");
    if (st)
        return st;
    for (int i = 0; i < 2; i++) {
        const XrViewConfigurationView *c = &xr->config[i];
        if (c->recommendedImageRectWidth > xr->width)
            xr->width = c->recommendedImageRectWidth;
        if (c->recommendedImageRectHeight > xr->height)
            xr->height = c->recommendedImageRectHeight;
    }
    return AP_OK;
}

enum ap_status ap_xr_swapchain_create(struct ap_error *err, struct ap_xr *xr,
                                      const XrSwapchainCreateInfo *info,
                                      struct ap_xr_swapchain *swapchain) {
    enum ap_status st =
        ap_xr_check(err, xr, ap_xrl.CreateSwapchain(xr->session, info, &swapchain->handle),
                    "xrCreateSwapchain");
    if (st)
        return st;
    XrSwapchainImageVulkanKHR images[AP_XR_MAX_IMAGES];
    for (int i = 0; i < AP_XR_MAX_IMAGES; i++)
        images[i] = (XrSwapchainImageVulkanKHR){.type = XR_TYPE_SWAPCHAIN_IMAGE_VULKAN_KHR};
    st = ap_xr_check(err, xr,
                     ap_xrl.EnumerateSwapchainImages(swapchain->handle, AP_XR_MAX_IMAGES,
                                                     &swapchain->image_count,
                                                     (XrSwapchainImageBaseHeader *)images),
                     "xrEnumerateSwapchainImages");
    for (uint32_t i = 0; !st && i < swapchain->image_count; i++)
        swapchain->images[i] = images[i].image;
    return st;
}

static enum ap_status create_swapchain(struct ap_error *err, struct ap_xr *xr, uint32_t layers,
                                       struct ap_xr_swapchain *swapchain) {
    const XrSwapchainCreateInfo info = {.type = XR_TYPE_SWAPCHAIN_CREATE_INFO,
                                        .usageFlags = XR_SWAPCHAIN_USAGE_COLOR_ATTACHMENT_BIT |
                                                      XR_SWAPCHAIN_USAGE_TRANSFER_SRC_BIT,
                                        .format = xr->format,
                                        .sampleCount = 1,
                                        .width = xr->width,
                                        .height = xr->height,
                                        .faceCount = 1,
                                        .arraySize = layers,
                                        .mipCount = 1};
    return ap_xr_swapchain_create(err, xr, &info, swapchain);
}

enum ap_status ap_xr_swapchains_create(struct ap_error *err, const struct ap_xr_params *params,
                                       struct ap_xr *xr) {
    enum ap_status st = choose_format(err, params->prefer_rgba, xr);
    if (!st)
        st = read_view_sizes(err, xr);
    if (st)
        return st;
    xr->swapchain_count = 1;
    st = create_swapchain(err, xr, 2, &xr->swapchain[0]);
    if (!st || xr->lost)
        return st;
    xr->swapchain_count = 2; // a runtime without arrays
    st = create_swapchain(err, xr, 1, &xr->swapchain[0]);
    return st ? st : create_swapchain(err, xr, 1, &xr->swapchain[1]);
}

enum ap_status ap_xr_swapchain_acquire(struct ap_error *err, struct ap_xr *xr,
                                       struct ap_xr_swapchain *swapchain) {
    XrSwapchainImageAcquireInfo acquire = {.type = XR_TYPE_SWAPCHAIN_IMAGE_ACQUIRE_INFO};
    XrSwapchainImageWaitInfo wait = {.type = XR_TYPE_SWAPCHAIN_IMAGE_WAIT_INFO,
                                     .timeout = XR_INFINITE_DURATION};
    enum ap_status st = ap_xr_check(
        err, xr, ap_xrl.AcquireSwapchainImage(swapchain->handle, &acquire, &swapchain->acquired),
        "xrAcquireSwapchainImage");
    if (!st)
        st = ap_xr_check(err, xr, ap_xrl.WaitSwapchainImage(swapchain->handle, &wait),
                         "xrWaitSwapchainImage");
    if (!st && swapchain->acquired >= swapchain->image_count)
        st = ap_fail(err, AP_ENVIRONMENT, "%s handed out a swapchain image that does not exist",
                     xr->runtime_name);
    return st;
}

enum ap_status ap_xr_swapchain_release(struct ap_error *err, struct ap_xr *xr,
                                       struct ap_xr_swapchain *swapchain) {
    XrSwapchainImageReleaseInfo info = {.type = XR_TYPE_SWAPCHAIN_IMAGE_RELEASE_INFO};
    return ap_xr_check(err, xr, ap_xrl.ReleaseSwapchainImage(swapchain->handle, &info),
                       "xrReleaseSwapchainImage");
}

enum ap_status ap_xr_acquire(struct ap_error *err, struct ap_xr *xr, struct ap_xr_images *images) {
    struct ap_xr_images got;
    for (int i = 0; i < xr->swapchain_count; i++) {
        enum ap_status st = ap_xr_swapchain_acquire(err, xr, &xr->swapchain[i]);
        if (st)
            return st;
    }
    for (int eye = 0; eye < 2; eye++) {
        const struct ap_xr_swapchain *s = &xr->swapchain[xr->swapchain_count == 1 ? 0 : eye];
        got.image[eye] = s->images[s->acquired];
        got.layer[eye] = xr->swapchain_count == 1 ? (uint32_t)eye : 0;
    }
    xr->drawing = true;
    *images = got;
    return AP_OK;
}
