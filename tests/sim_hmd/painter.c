#include "tests/sim_hmd/painter.h"

#include <stdio.h>

void painter_start(struct painter *p, VkDeviceSize buffer_bytes) {
    *p = (struct painter){0};
    client_start(&p->c);
    VkBufferCreateInfo b = {.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO,
                            .size = buffer_bytes,
                            .usage = VK_BUFFER_USAGE_TRANSFER_SRC_BIT};
    assert_int_equal(vkCreateBuffer(p->c.device, &b, NULL, &p->buffer), VK_SUCCESS);
    VkMemoryRequirements needs;
    vkGetBufferMemoryRequirements(p->c.device, p->buffer, &needs);
    VkMemoryAllocateInfo a = {.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO,
                              .allocationSize = needs.size}; // type 0: host visible on lavapipe
    assert_int_equal(vkAllocateMemory(p->c.device, &a, NULL, &p->memory), VK_SUCCESS);
    assert_int_equal(vkBindBufferMemory(p->c.device, p->buffer, p->memory, 0), VK_SUCCESS);
    assert_int_equal(vkMapMemory(p->c.device, p->memory, 0, VK_WHOLE_SIZE, 0, (void **)&p->mapped),
                     VK_SUCCESS);
    VkCommandPoolCreateInfo pool = {.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO};
    assert_int_equal(vkCreateCommandPool(p->c.device, &pool, NULL, &p->pool), VK_SUCCESS);
    vkGetDeviceQueue(p->c.device, 0, 0, &p->queue);
}

void painter_stop(struct painter *p) {
    vkDeviceWaitIdle(p->c.device);
    vkDestroyCommandPool(p->c.device, p->pool, NULL);
    vkDestroyBuffer(p->c.device, p->buffer, NULL);
    vkFreeMemory(p->c.device, p->memory, NULL);
    client_stop(&p->c);
}

VkImage painter_acquire(XrSwapchain swapchain) {
    uint32_t index, count;
    XrSwapchainImageWaitInfo wait = {.type = XR_TYPE_SWAPCHAIN_IMAGE_WAIT_INFO,
                                     .timeout = XR_INFINITE_DURATION};
    XrSwapchainImageVulkanKHR images[3] = {{.type = XR_TYPE_SWAPCHAIN_IMAGE_VULKAN_KHR},
                                           {.type = XR_TYPE_SWAPCHAIN_IMAGE_VULKAN_KHR},
                                           {.type = XR_TYPE_SWAPCHAIN_IMAGE_VULKAN_KHR}};
    XR_OK(xrEnumerateSwapchainImages(swapchain, 3, &count, (XrSwapchainImageBaseHeader *)images));
    XR_OK(xrAcquireSwapchainImage(swapchain, NULL, &index));
    XR_OK(xrWaitSwapchainImage(swapchain, &wait));
    return images[index].image;
}

VkCommandBuffer painter_begin(struct painter *p) {
    VkCommandBufferAllocateInfo a = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
                                     .commandPool = p->pool,
                                     .commandBufferCount = 1};
    VkCommandBuffer cmd;
    assert_int_equal(vkAllocateCommandBuffers(p->c.device, &a, &cmd), VK_SUCCESS);
    VkCommandBufferBeginInfo begin = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
    vkBeginCommandBuffer(cmd, &begin);
    return cmd;
}

void painter_submit(struct painter *p, VkCommandBuffer cmd) {
    vkEndCommandBuffer(cmd);
    VkSubmitInfo submit = {
        .sType = VK_STRUCTURE_TYPE_SUBMIT_INFO, .commandBufferCount = 1, .pCommandBuffers = &cmd};
    assert_int_equal(vkQueueSubmit(p->queue, 1, &submit, VK_NULL_HANDLE), VK_SUCCESS);
}

void painter_turn(VkCommandBuffer cmd, VkImage image, VkImageAspectFlags aspect, VkImageLayout from,
                  VkImageLayout to) {
    VkImageMemoryBarrier b = {.sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER,
                              .srcAccessMask = VK_ACCESS_MEMORY_WRITE_BIT,
                              .dstAccessMask = VK_ACCESS_MEMORY_WRITE_BIT,
                              .oldLayout = from,
                              .newLayout = to,
                              .image = image,
                              .subresourceRange = {aspect, 0, 1, 0, VK_REMAINING_ARRAY_LAYERS}};
    vkCmdPipelineBarrier(cmd, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT,
                         VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, 0, 0, NULL, 0, NULL, 1, &b);
}

const char *painter_path(const char *dir, const char *name) {
    static char path[512];
    snprintf(path, sizeof path, "%s/%s/%s", client_folder(), dir, name);
    return path;
}
