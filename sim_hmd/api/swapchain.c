#include <stdlib.h>

#include "sim_hmd/core/swapchains.h"
#include "sim_hmd/strict/strict.h"
#include "src/base/log.h"

// Swapchains: images on the program's device. The compositor is done with an image before
// xrEndFrame returns, so waiting never blocks.

static const XrSwapchainUsageFlags known_usage =
    XR_SWAPCHAIN_USAGE_COLOR_ATTACHMENT_BIT | XR_SWAPCHAIN_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT |
    XR_SWAPCHAIN_USAGE_UNORDERED_ACCESS_BIT | XR_SWAPCHAIN_USAGE_TRANSFER_SRC_BIT |
    XR_SWAPCHAIN_USAGE_TRANSFER_DST_BIT | XR_SWAPCHAIN_USAGE_SAMPLED_BIT |
    XR_SWAPCHAIN_USAGE_MUTABLE_FORMAT_BIT;
static const XrSwapchainCreateFlags known_flags =
    XR_SWAPCHAIN_CREATE_PROTECTED_CONTENT_BIT | XR_SWAPCHAIN_CREATE_STATIC_IMAGE_BIT;

static VkImageUsageFlags usage_of(XrSwapchainUsageFlags usage, bool depth, bool captured) {
    static const struct {
        XrSwapchainUsageFlags xr;
        VkImageUsageFlags vk;
    } map[] = {
        {XR_SWAPCHAIN_USAGE_COLOR_ATTACHMENT_BIT, VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT},
        {XR_SWAPCHAIN_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT,
         VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT},
        {XR_SWAPCHAIN_USAGE_UNORDERED_ACCESS_BIT, VK_IMAGE_USAGE_STORAGE_BIT},
        {XR_SWAPCHAIN_USAGE_TRANSFER_SRC_BIT, VK_IMAGE_USAGE_TRANSFER_SRC_BIT},
        {XR_SWAPCHAIN_USAGE_TRANSFER_DST_BIT, VK_IMAGE_USAGE_TRANSFER_DST_BIT},
        {XR_SWAPCHAIN_USAGE_SAMPLED_BIT, VK_IMAGE_USAGE_SAMPLED_BIT},
    };
    // The layout that programs are handed is an attachment's; the compositor samples and copies.
    VkImageUsageFlags flags = depth ? VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT
                                    : VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT |
                                          VK_IMAGE_USAGE_TRANSFER_SRC_BIT |
                                          VK_IMAGE_USAGE_SAMPLED_BIT;
    if (captured)
        flags |= VK_IMAGE_USAGE_TRANSFER_SRC_BIT;
    for (size_t i = 0; i < sizeof map / sizeof *map; i++)
        if (usage & map[i].xr)
            flags |= map[i].vk;
    return flags;
}

static bool power_of_two(uint32_t n) {
    return n && !(n & (n - 1));
}

static uint32_t most_mips(uint32_t width, uint32_t height) {
    uint32_t mips = 1;
    for (uint32_t size = width > height ? width : height; size > 1; size /= 2)
        mips++;
    return mips;
}

// XR_KHR_vulkan_swapchain_format_list. The list only lets a device lay images out better; they are
// made without it, for the program's device need not have VK_KHR_image_format_list.
static XrResult check_format_list(const struct sim_session *session,
                                  const XrSwapchainCreateInfo *info) {
    const XrVulkanSwapchainFormatListCreateInfoKHR *list =
        sim_chained(info, XR_TYPE_VULKAN_SWAPCHAIN_FORMAT_LIST_CREATE_INFO_KHR);
    if (!list || !session->instance->enabled[SIM_KHR_vulkan_swapchain_format_list])
        return XR_SUCCESS;
    if (list->viewFormatCount && !list->viewFormats)
        return XR_ERROR_VALIDATION_FAILURE;
    // As Vulkan says of VkImageFormatListCreateInfo.
    if (list->viewFormatCount > 1 && !(info->usageFlags & XR_SWAPCHAIN_USAGE_MUTABLE_FORMAT_BIT))
        return XR_ERROR_VALIDATION_FAILURE;
    for (uint32_t i = 0; i < list->viewFormatCount; i++)
        if (list->viewFormats[i] == VK_FORMAT_UNDEFINED)
            return XR_ERROR_VALIDATION_FAILURE;
    return XR_SUCCESS;
}

static XrResult check_counts(const XrSwapchainCreateInfo *info) {
    bool some = info->width && info->height && info->arraySize && info->mipCount;
    if (some && info->arraySize <= UINT32_MAX / 6 && power_of_two(info->sampleCount) &&
        (info->faceCount == 1 || (info->faceCount == 6 && info->width == info->height)) &&
        info->mipCount <= most_mips(info->width, info->height))
        return XR_SUCCESS;
    return sim_strict(XR_ERROR_VALIDATION_FAILURE, "xrCreateSwapchain",
                      "XrSwapchainCreateInfo: sizes and counts are at least 1, faceCount is 1 or 6 "
                      "and then square, sampleCount is 1, 2, 4..., mipCount no more than there are",
                      "%u by %u, %u layers, %u faces, %u mips, %u samples", info->width,
                      info->height, info->arraySize, info->faceCount, info->mipCount,
                      info->sampleCount);
}

static XrResult check_info(const struct sim_session *session, const XrSwapchainCreateInfo *info) {
    if (!sim_is(info, XR_TYPE_SWAPCHAIN_CREATE_INFO) || info->createFlags & ~known_flags ||
        info->usageFlags & ~known_usage)
        return XR_ERROR_VALIDATION_FAILURE;
    bool listed = false;
    for (uint32_t i = 0; i < session->format_count; i++)
        listed |= session->formats[i] == info->format;
    if (!listed)
        return XR_ERROR_SWAPCHAIN_FORMAT_UNSUPPORTED;
    if (check_counts(info) != XR_SUCCESS)
        return XR_ERROR_VALIDATION_FAILURE;
    if (info->createFlags & XR_SWAPCHAIN_CREATE_PROTECTED_CONTENT_BIT)
        return XR_ERROR_FEATURE_UNSUPPORTED;
    bool depth = ap_gpu_aspect((VkFormat)info->format) != VK_IMAGE_ASPECT_COLOR_BIT;
    if (info->usageFlags & (depth ? XR_SWAPCHAIN_USAGE_COLOR_ATTACHMENT_BIT
                                  : XR_SWAPCHAIN_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT))
        return XR_ERROR_FEATURE_UNSUPPORTED;
    return XR_SUCCESS;
}

static VkImageCreateInfo image_info(const struct sim_session *session,
                                    const XrSwapchainCreateInfo *info, bool depth) {
    VkImageCreateFlags flags = 0;
    if (info->usageFlags & XR_SWAPCHAIN_USAGE_MUTABLE_FORMAT_BIT)
        flags |= VK_IMAGE_CREATE_MUTABLE_FORMAT_BIT;
    if (info->faceCount == 6)
        flags |= VK_IMAGE_CREATE_CUBE_COMPATIBLE_BIT;
    return (VkImageCreateInfo){
        .sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
        .flags = flags,
        .imageType = VK_IMAGE_TYPE_2D,
        .format = (VkFormat)info->format,
        .extent = {info->width, info->height, 1},
        .mipLevels = info->mipCount,
        .arrayLayers = info->arraySize * info->faceCount,
        .samples = (VkSampleCountFlagBits)info->sampleCount,
        .tiling = VK_IMAGE_TILING_OPTIMAL,
        .usage = usage_of(info->usageFlags, depth, session->instance->settings.capture_layers),
    };
}

static XrResult check_device(const struct sim_session *session, const VkImageCreateInfo *image) {
    VkImageFormatProperties can;
    if (vkGetPhysicalDeviceImageFormatProperties(session->gpu.physical_device, image->format,
                                                 image->imageType, image->tiling, image->usage,
                                                 image->flags, &can) != VK_SUCCESS)
        return XR_ERROR_FEATURE_UNSUPPORTED;
    if (image->extent.width > can.maxExtent.width || image->extent.height > can.maxExtent.height)
        return XR_ERROR_VALIDATION_FAILURE;
    if (image->arrayLayers > can.maxArrayLayers || image->mipLevels > can.maxMipLevels ||
        !(can.sampleCounts & (VkSampleCountFlags)image->samples))
        return XR_ERROR_FEATURE_UNSUPPORTED;
    return XR_SUCCESS;
}

// Images that the queue may still work on wait for a call that may touch the queue.
static void free_swapchain(struct sim_object *object) {
    struct sim_swapchain *swapchain = (struct sim_swapchain *)object;
    struct sim_session *session = swapchain->session;
    struct sim_garbage *garbage = swapchain->used ? calloc(1, sizeof *garbage) : NULL;
    if (swapchain->used && !garbage)
        vkQueueWaitIdle(session->gpu.queue);
    for (uint32_t i = 0; i < swapchain->image_count; i++)
        if (garbage)
            garbage->image[i] = swapchain->image[i];
        else
            ap_gpu_image_destroy(&session->gpu, &swapchain->image[i]);
    if (garbage) {
        garbage->next = session->garbage;
        session->garbage = garbage;
        // Nobody runs a frame loop that would collect it.
        if (!session->running)
            sim_session_collect_garbage(session);
    }
    free(swapchain);
}

static XrResult make_images(struct sim_session *session, struct sim_swapchain *swapchain,
                            const VkImageCreateInfo *image) {
    struct ap_error err;
    VkImageViewType view =
        image->arrayLayers > 1 ? VK_IMAGE_VIEW_TYPE_2D_ARRAY : VK_IMAGE_VIEW_TYPE_2D;
    uint32_t count = swapchain->static_image ? 1 : SIM_MAX_IMAGES;
    for (; swapchain->image_count < count; swapchain->image_count++)
        if (ap_gpu_image_create(&err, &session->gpu, image, view, swapchain->aspect,
                                &swapchain->image[swapchain->image_count])) {
            ap_log(AP_LOG_WARNING, "a swapchain of %u by %u: %s", image->extent.width,
                   image->extent.height, err.text);
            return XR_ERROR_OUT_OF_MEMORY;
        }
    return XR_SUCCESS;
}

XrResult XRAPI_CALL xrCreateSwapchain(XrSession handle, const XrSwapchainCreateInfo *info,
                                      XrSwapchain *out) {
    SIM_LOCKED;
    struct sim_session *session;
    XrResult result = sim_session_get(handle, &session);
    if (result == XR_SUCCESS)
        result = check_info(session, info);
    if (result == XR_SUCCESS)
        result = check_format_list(session, info);
    if (result != XR_SUCCESS)
        return result;
    if (!out)
        return XR_ERROR_VALIDATION_FAILURE;
    VkImageAspectFlags aspect = ap_gpu_aspect((VkFormat)info->format);
    bool depth = aspect != VK_IMAGE_ASPECT_COLOR_BIT;
    VkImageCreateInfo image = image_info(session, info, depth);
    result = check_device(session, &image);
    if (result != XR_SUCCESS)
        return result;
    struct sim_swapchain *swapchain = calloc(1, sizeof *swapchain);
    if (!swapchain)
        return XR_ERROR_OUT_OF_MEMORY;
    swapchain->session = session;
    swapchain->info = *info;
    swapchain->info.next = NULL;
    swapchain->aspect = aspect;
    swapchain->depth = depth;
    swapchain->static_image = info->createFlags & XR_SWAPCHAIN_CREATE_STATIC_IMAGE_BIT;
    swapchain->released = -1;
    result = make_images(session, swapchain, &image);
    if (result == XR_SUCCESS &&
        !sim_object_add(&swapchain->object, SIM_SWAPCHAIN, &session->object, free_swapchain))
        result = XR_ERROR_LIMIT_REACHED;
    if (result != XR_SUCCESS) {
        free_swapchain(&swapchain->object);
        return result;
    }
    *out = SIM_HANDLE(XrSwapchain, swapchain);
    return XR_SUCCESS;
}

XrResult XRAPI_CALL xrDestroySwapchain(XrSwapchain handle) {
    SIM_LOCKED;
    struct sim_swapchain *swapchain = sim_object_get(sim_raw(handle), SIM_SWAPCHAIN);
    if (!swapchain)
        return XR_ERROR_HANDLE_INVALID;
    sim_object_destroy(&swapchain->object);
    return XR_SUCCESS;
}

XrResult XRAPI_CALL xrEnumerateSwapchainImages(XrSwapchain handle, uint32_t capacity,
                                               uint32_t *count,
                                               XrSwapchainImageBaseHeader *images) {
    SIM_LOCKED;
    struct sim_swapchain *swapchain;
    XrResult result = sim_swapchain_get(handle, &swapchain);
    if (result != XR_SUCCESS)
        return result;
    if (!count || (capacity && !images))
        return XR_ERROR_VALIDATION_FAILURE;
    *count = swapchain->image_count;
    if (capacity == 0)
        return XR_SUCCESS;
    if (capacity < swapchain->image_count)
        return XR_ERROR_SIZE_INSUFFICIENT;
    XrSwapchainImageVulkanKHR *out = (XrSwapchainImageVulkanKHR *)images;
    for (uint32_t i = 0; i < swapchain->image_count; i++)
        if (out[i].type != XR_TYPE_SWAPCHAIN_IMAGE_VULKAN_KHR)
            return XR_ERROR_VALIDATION_FAILURE;
    for (uint32_t i = 0; i < swapchain->image_count; i++)
        out[i].image = swapchain->image[i].image;
    return XR_SUCCESS;
}

// Programs get images in an attachment's layout; done where the queue may be touched.
static XrResult set_layouts(struct sim_swapchain *swapchain) {
    struct ap_error err;
    const struct ap_gpu *gpu = &swapchain->session->gpu;
    VkCommandBuffer cmd;
    enum ap_status st = ap_gpu_commands_begin(&err, gpu, &cmd);
    if (!st) {
        for (uint32_t i = 0; i < swapchain->image_count; i++)
            ap_gpu_barrier(cmd, swapchain->image[i].image, swapchain->aspect,
                           VK_IMAGE_LAYOUT_UNDEFINED,
                           swapchain->depth ? VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL
                                            : VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL);
        st = ap_gpu_commands_end(&err, gpu, cmd);
    }
    if (!st)
        return XR_SUCCESS;
    sim_session_lose(swapchain->session, err.text);
    return XR_ERROR_SESSION_LOST;
}

SIM_HOT XrResult XRAPI_CALL xrAcquireSwapchainImage(XrSwapchain handle,
                                                    const XrSwapchainImageAcquireInfo *info,
                                                    uint32_t *index) {
    SIM_LOCKED;
    struct sim_swapchain *swapchain;
    XrResult result = sim_swapchain_get(handle, &swapchain);
    if (result != XR_SUCCESS)
        return result;
    if ((info && info->type != XR_TYPE_SWAPCHAIN_IMAGE_ACQUIRE_INFO) || !index)
        return XR_ERROR_VALIDATION_FAILURE;
    if (swapchain->acquired == swapchain->image_count ||
        (swapchain->static_image && swapchain->used))
        return XR_ERROR_CALL_ORDER_INVALID;
    if (!swapchain->used) {
        result = set_layouts(swapchain);
        if (result != XR_SUCCESS)
            return result;
        swapchain->used = true;
    }
    *index = swapchain->next;
    swapchain->next = (swapchain->next + 1) % swapchain->image_count;
    swapchain->acquired++;
    return XR_SUCCESS;
}

SIM_HOT XrResult XRAPI_CALL xrWaitSwapchainImage(XrSwapchain handle,
                                                 const XrSwapchainImageWaitInfo *info) {
    SIM_LOCKED;
    struct sim_swapchain *swapchain;
    XrResult result = sim_swapchain_get(handle, &swapchain);
    if (result != XR_SUCCESS)
        return result;
    if (!sim_is(info, XR_TYPE_SWAPCHAIN_IMAGE_WAIT_INFO))
        return XR_ERROR_VALIDATION_FAILURE;
    if (!swapchain->acquired || swapchain->waited)
        return XR_ERROR_CALL_ORDER_INVALID;
    swapchain->waited = true;
    return XR_SUCCESS;
}

SIM_HOT XrResult XRAPI_CALL xrReleaseSwapchainImage(XrSwapchain handle,
                                                    const XrSwapchainImageReleaseInfo *info) {
    SIM_LOCKED;
    struct sim_swapchain *swapchain;
    XrResult result = sim_swapchain_get(handle, &swapchain);
    if (result != XR_SUCCESS)
        return result;
    if (info && info->type != XR_TYPE_SWAPCHAIN_IMAGE_RELEASE_INFO)
        return XR_ERROR_VALIDATION_FAILURE;
    if (!swapchain->acquired || !swapchain->waited)
        return XR_ERROR_CALL_ORDER_INVALID;
    uint32_t n = swapchain->image_count;
    swapchain->released = (int)((swapchain->next + n - swapchain->acquired) % n);
    swapchain->acquired--;
    swapchain->waited = false;
    return XR_SUCCESS;
}
