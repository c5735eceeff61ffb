#include "src/gpu/gpu.h"

#include <string.h>

// A type among `allowed` with all of `want`, or UINT32_MAX.
static uint32_t memory_type(const struct ap_gpu *gpu, uint32_t allowed,
                            VkMemoryPropertyFlags want) {
    for (uint32_t i = 0; i < gpu->memory.memoryTypeCount; i++)
        if ((allowed >> i & 1) && (gpu->memory.memoryTypes[i].propertyFlags & want) == want)
            return i;
    return UINT32_MAX;
}

static enum ap_status allocate(struct ap_error *err, const struct ap_gpu *gpu,
                               const VkMemoryRequirements *needs, bool host,
                               VkDeviceMemory *memory) {
    VkMemoryPropertyFlags visible =
        VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
    uint32_t type = UINT32_MAX;
    // What the CPU reads back is slow without a cache, so a cached type is taken where there is
    // one.
    if (host)
        type =
            memory_type(gpu, needs->memoryTypeBits, visible | VK_MEMORY_PROPERTY_HOST_CACHED_BIT);
    if (type == UINT32_MAX)
        type = memory_type(gpu, needs->memoryTypeBits,
                           host ? visible : VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT);
    if (type == UINT32_MAX && !host)
        type = memory_type(gpu, needs->memoryTypeBits, 0);
    if (type == UINT32_MAX)
        return ap_fail(err, AP_ENVIRONMENT, "the Vulkan device has no %s memory for this resource",
                       host ? "host-visible" : "usable");
    VkMemoryAllocateInfo info = {.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO,
                                 .allocationSize = needs->size,
                                 .memoryTypeIndex = type};
    return ap_vk_check(err, vkAllocateMemory(gpu->device, &info, NULL, memory), "vkAllocateMemory");
}

enum ap_status ap_gpu_buffer_create(struct ap_error *err, const struct ap_gpu *gpu,
                                    VkDeviceSize size, VkBufferUsageFlags usage, bool host,
                                    struct ap_gpu_buffer *buffer) {
    struct ap_gpu_buffer b = {.size = size};
    VkBufferCreateInfo info = {.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO,
                               .size = size,
                               .usage = usage,
                               .sharingMode = VK_SHARING_MODE_EXCLUSIVE};
    enum ap_status st =
        ap_vk_check(err, vkCreateBuffer(gpu->device, &info, NULL, &b.buffer), "vkCreateBuffer");
    if (st != AP_OK)
        goto out;
    VkMemoryRequirements needs;
    vkGetBufferMemoryRequirements(gpu->device, b.buffer, &needs);
    st = allocate(err, gpu, &needs, host, &b.memory);
    if (st != AP_OK)
        goto out;
    st = ap_vk_check(err, vkBindBufferMemory(gpu->device, b.buffer, b.memory, 0),
                     "vkBindBufferMemory");
    if (st == AP_OK && host)
        st = ap_vk_check(err, vkMapMemory(gpu->device, b.memory, 0, VK_WHOLE_SIZE, 0, &b.mapped),
                         "vkMapMemory");
out:
    if (st == AP_OK)
        *buffer = b;
    else
        ap_gpu_buffer_destroy(gpu, &b);
    return st;
}

void ap_gpu_buffer_destroy(const struct ap_gpu *gpu, struct ap_gpu_buffer *buffer) {
    if (!gpu->device)
        return;
    vkDestroyBuffer(gpu->device, buffer->buffer, NULL);
    vkFreeMemory(gpu->device, buffer->memory, NULL); // unmaps
    memset(buffer, 0, sizeof *buffer);
}

enum ap_status ap_gpu_image_create(struct ap_error *err, const struct ap_gpu *gpu,
                                   const VkImageCreateInfo *info, VkImageViewType view_type,
                                   VkImageAspectFlags aspect, struct ap_gpu_image *image) {
    struct ap_gpu_image made = {0};
    enum ap_status st =
        ap_vk_check(err, vkCreateImage(gpu->device, info, NULL, &made.image), "vkCreateImage");
    if (st != AP_OK)
        goto out;
    VkMemoryRequirements needs;
    vkGetImageMemoryRequirements(gpu->device, made.image, &needs);
    st = allocate(err, gpu, &needs, false, &made.memory);
    if (st != AP_OK)
        goto out;
    st = ap_vk_check(err, vkBindImageMemory(gpu->device, made.image, made.memory, 0),
                     "vkBindImageMemory");
    // Images that are only copied have no view.
    VkImageUsageFlags viewable =
        VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_STORAGE_BIT |
        VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT |
        VK_IMAGE_USAGE_TRANSIENT_ATTACHMENT_BIT | VK_IMAGE_USAGE_INPUT_ATTACHMENT_BIT;
    if (st != AP_OK || !(info->usage & viewable))
        goto out;
    VkImageViewCreateInfo view = {
        .sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO,
        .image = made.image,
        .viewType = view_type,
        .format = info->format,
        .subresourceRange = {aspect, 0, VK_REMAINING_MIP_LEVELS, 0, VK_REMAINING_ARRAY_LAYERS}};
    st = ap_vk_check(err, vkCreateImageView(gpu->device, &view, NULL, &made.view),
                     "vkCreateImageView");
out:
    if (st == AP_OK)
        *image = made;
    else
        ap_gpu_image_destroy(gpu, &made);
    return st;
}

void ap_gpu_image_destroy(const struct ap_gpu *gpu, struct ap_gpu_image *image) {
    if (!gpu->device)
        return;
    vkDestroyImageView(gpu->device, image->view, NULL);
    vkDestroyImage(gpu->device, image->image, NULL);
    vkFreeMemory(gpu->device, image->memory, NULL);
    memset(image, 0, sizeof *image);
}
