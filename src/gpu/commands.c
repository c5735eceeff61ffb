#include "src/gpu/gpu.h"

enum ap_status ap_gpu_shader(struct ap_error *err, const struct ap_gpu *gpu, const uint32_t *words,
                             size_t bytes, VkShaderModule *module) {
    VkShaderModuleCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO, .codeSize = bytes, .pCode = words};
    return ap_vk_check(err, vkCreateShaderModule(gpu->device, &info, NULL, module),
                       "vkCreateShaderModule");
}

enum ap_status ap_gpu_commands_begin(struct ap_error *err, const struct ap_gpu *gpu,
                                     VkCommandBuffer *cmd) {
    VkCommandBuffer made;
    VkCommandBufferAllocateInfo info = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
                                        .commandPool = gpu->pool,
                                        .level = VK_COMMAND_BUFFER_LEVEL_PRIMARY,
                                        .commandBufferCount = 1};
    enum ap_status st = ap_vk_check(err, vkAllocateCommandBuffers(gpu->device, &info, &made),
                                    "vkAllocateCommandBuffers");
    if (st != AP_OK)
        return st;
    VkCommandBufferBeginInfo begin = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
                                      .flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT};
    st = ap_vk_check(err, vkBeginCommandBuffer(made, &begin), "vkBeginCommandBuffer");
    if (st != AP_OK)
        vkFreeCommandBuffers(gpu->device, gpu->pool, 1, &made);
    else
        *cmd = made;
    return st;
}

enum ap_status ap_gpu_commands_end(struct ap_error *err, const struct ap_gpu *gpu,
                                   VkCommandBuffer cmd) {
    VkFence fence = VK_NULL_HANDLE;
    VkFenceCreateInfo info = {.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
    VkSubmitInfo submit = {
        .sType = VK_STRUCTURE_TYPE_SUBMIT_INFO, .commandBufferCount = 1, .pCommandBuffers = &cmd};
    enum ap_status st = ap_vk_check(err, vkEndCommandBuffer(cmd), "vkEndCommandBuffer");
    if (st == AP_OK)
        st = ap_vk_check(err, vkCreateFence(gpu->device, &info, NULL, &fence), "vkCreateFence");
    if (st == AP_OK)
        st = ap_vk_check(err, vkQueueSubmit(gpu->queue, 1, &submit, fence), "vkQueueSubmit");
    if (st == AP_OK)
        st = ap_vk_check(err, vkWaitForFences(gpu->device, 1, &fence, VK_TRUE, UINT64_MAX),
                         "vkWaitForFences");
    vkDestroyFence(gpu->device, fence, NULL);
    vkFreeCommandBuffers(gpu->device, gpu->pool, 1, &cmd);
    return st;
}

VkImageAspectFlags ap_gpu_aspect(VkFormat format) {
    switch (format) {
    case VK_FORMAT_D16_UNORM:
    case VK_FORMAT_D32_SFLOAT:
        return VK_IMAGE_ASPECT_DEPTH_BIT;
    case VK_FORMAT_D24_UNORM_S8_UINT:
    case VK_FORMAT_D32_SFLOAT_S8_UINT:
        return VK_IMAGE_ASPECT_DEPTH_BIT | VK_IMAGE_ASPECT_STENCIL_BIT;
    default:
        return VK_IMAGE_ASPECT_COLOR_BIT;
    }
}

void ap_gpu_barrier(VkCommandBuffer cmd, VkImage image, VkImageAspectFlags aspect,
                    VkImageLayout from, VkImageLayout to) {
    // Everything before, everything after: right for any pair of layouts, and these transitions
    // happen a few times a frame.
    VkImageMemoryBarrier barrier = {
        .sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER,
        .srcAccessMask = VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_MEMORY_WRITE_BIT,
        .dstAccessMask = VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_MEMORY_WRITE_BIT,
        .oldLayout = from,
        .newLayout = to,
        .srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
        .dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
        .image = image,
        .subresourceRange = {aspect, 0, VK_REMAINING_MIP_LEVELS, 0, VK_REMAINING_ARRAY_LAYERS}};
    vkCmdPipelineBarrier(cmd, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT,
                         VK_PIPELINE_STAGE_ALL_COMMANDS_BIT | VK_PIPELINE_STAGE_HOST_BIT, 0, 0,
                         NULL, 0, NULL, 1, &barrier);
}
