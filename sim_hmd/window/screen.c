#include "sim_hmd/window/screen.h"

#include <string.h>

static enum ap_status create_instance(struct ap_error *err, struct sim_screen *s) {
    uint32_t count = 0;
    const char **extensions = glfwGetRequiredInstanceExtensions(&count);
    if (!extensions)
        return ap_fail(err, AP_ENVIRONMENT, "Vulkan cannot draw into windows here");
    VkApplicationInfo app = {.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO,
                             .pApplicationName = "antipode-sim-window",
                             .apiVersion = VK_API_VERSION_1_0};
    VkInstanceCreateInfo info = {.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO,
                                 .pApplicationInfo = &app,
                                 .enabledExtensionCount = count,
                                 .ppEnabledExtensionNames = extensions};
    enum ap_status st =
        ap_vk_check(err, vkCreateInstance(&info, NULL, &s->gpu.instance), "vkCreateInstance");
    if (st)
        return st;
    return ap_vk_check(err, glfwCreateWindowSurface(s->gpu.instance, s->window, NULL, &s->surface),
                       "glfwCreateWindowSurface");
}

static bool find_family(VkPhysicalDevice device, VkSurfaceKHR surface, uint32_t *family) {
    VkQueueFamilyProperties families[16];
    uint32_t count = 16;
    vkGetPhysicalDeviceQueueFamilyProperties(device, &count, families);
    for (uint32_t k = 0; k < count; k++) {
        VkBool32 shows = VK_FALSE;
        vkGetPhysicalDeviceSurfaceSupportKHR(device, k, surface, &shows);
        if (shows && (families[k].queueFlags & VK_QUEUE_GRAPHICS_BIT)) {
            *family = k;
            return true;
        }
    }
    return false;
}

static enum ap_status create_device(struct ap_error *err, struct sim_screen *s) {
    VkPhysicalDevice devices[16];
    uint32_t count = 16, family = 0, k = 0;
    VkResult result = vkEnumeratePhysicalDevices(s->gpu.instance, &count, devices);
    if (result != VK_SUCCESS && result != VK_INCOMPLETE)
        return ap_vk_check(err, result, "vkEnumeratePhysicalDevices");
    while (k < count && !find_family(devices[k], s->surface, &family))
        k++;
    if (k == count)
        return ap_fail(err, AP_ENVIRONMENT, "no Vulkan device can draw into this window");
    float priority = 1;
    const char *extension = VK_KHR_SWAPCHAIN_EXTENSION_NAME;
    VkDeviceQueueCreateInfo queue = {.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO,
                                     .queueFamilyIndex = family,
                                     .queueCount = 1,
                                     .pQueuePriorities = &priority};
    VkDeviceCreateInfo info = {.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
                               .queueCreateInfoCount = 1,
                               .pQueueCreateInfos = &queue,
                               .enabledExtensionCount = 1,
                               .ppEnabledExtensionNames = &extension};
    VkDevice device;
    enum ap_status st =
        ap_vk_check(err, vkCreateDevice(devices[k], &info, NULL, &device), "vkCreateDevice");
    if (st)
        return st;
    VkInstance instance = s->gpu.instance;
    st = ap_gpu_init(err, instance, devices[k], device, family, 0, &s->gpu);
    if (st)
        vkDestroyDevice(device, NULL);
    return st;
}

// The bytes are shown as they are, so a format that does not encode is the first choice.
static enum ap_status choose_format(struct ap_error *err, struct sim_screen *s) {
    static const VkFormat wanted[] = {VK_FORMAT_B8G8R8A8_UNORM, VK_FORMAT_R8G8B8A8_UNORM,
                                      VK_FORMAT_B8G8R8A8_SRGB, VK_FORMAT_R8G8B8A8_SRGB};
    VkSurfaceFormatKHR formats[64];
    uint32_t count = 64;
    VkResult result =
        vkGetPhysicalDeviceSurfaceFormatsKHR(s->gpu.physical_device, s->surface, &count, formats);
    if (result != VK_SUCCESS && result != VK_INCOMPLETE)
        return ap_vk_check(err, result, "vkGetPhysicalDeviceSurfaceFormatsKHR");
    for (size_t w = 0; w < sizeof wanted / sizeof wanted[0]; w++)
        for (uint32_t k = 0; k < count; k++)
            if (formats[k].format == wanted[w]) {
                s->format = formats[k];
                return AP_OK;
            }
    return ap_fail(err, AP_ENVIRONMENT, "the window has no 8-bit colour format");
}

static enum ap_status create_picture(struct ap_error *err, struct sim_screen *s) {
    bool encodes =
        s->format.format == VK_FORMAT_B8G8R8A8_SRGB || s->format.format == VK_FORMAT_R8G8B8A8_SRGB;
    VkImageCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
        .imageType = VK_IMAGE_TYPE_2D,
        .format = encodes ? VK_FORMAT_R8G8B8A8_SRGB : VK_FORMAT_R8G8B8A8_UNORM,
        .extent = {s->width_px, s->height_px, 1},
        .mipLevels = 1,
        .arrayLayers = 1,
        .samples = VK_SAMPLE_COUNT_1_BIT,
        .tiling = VK_IMAGE_TILING_OPTIMAL,
        .usage = VK_IMAGE_USAGE_TRANSFER_DST_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT,
        .initialLayout = VK_IMAGE_LAYOUT_UNDEFINED};
    enum ap_status st = ap_gpu_image_create(err, &s->gpu, &info, VK_IMAGE_VIEW_TYPE_2D,
                                            VK_IMAGE_ASPECT_COLOR_BIT, &s->picture);
    if (st)
        return st;
    VkDeviceSize bytes = (VkDeviceSize)s->width_px * s->height_px * 4;
    st = ap_gpu_buffer_create(err, &s->gpu, bytes, VK_BUFFER_USAGE_TRANSFER_SRC_BIT, true,
                              &s->staging);
    if (!st)
        memset(s->staging.mapped, 0, (size_t)bytes);
    return st;
}

static enum ap_status create_sync(struct ap_error *err, struct sim_screen *s) {
    VkSemaphoreCreateInfo semaphore = {.sType = VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO};
    VkFenceCreateInfo fence = {.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
    VkResult result = vkCreateFence(s->gpu.device, &fence, NULL, &s->fence);
    if (!result)
        result = vkCreateSemaphore(s->gpu.device, &semaphore, NULL, &s->acquired);
    for (int k = 0; k < SIM_SCREEN_MAX_IMAGES && !result; k++)
        result = vkCreateSemaphore(s->gpu.device, &semaphore, NULL, &s->drawn[k]);
    return ap_vk_check(err, result, "vkCreateSemaphore");
}

static void drop_swapchain(struct sim_screen *s) {
    vkDeviceWaitIdle(s->gpu.device);
    vkDestroySwapchainKHR(s->gpu.device, s->swapchain, NULL);
    s->swapchain = VK_NULL_HANDLE;
}

static enum ap_status make_swapchain(struct ap_error *err, struct sim_screen *s) {
    VkSurfaceCapabilitiesKHR can;
    enum ap_status st = ap_vk_check(
        err, vkGetPhysicalDeviceSurfaceCapabilitiesKHR(s->gpu.physical_device, s->surface, &can),
        "vkGetPhysicalDeviceSurfaceCapabilitiesKHR");
    if (st)
        return st;
    s->extent = can.currentExtent;
    if (s->extent.width == UINT32_MAX) {
        int width, height;
        glfwGetFramebufferSize(s->window, &width, &height);
        s->extent = (VkExtent2D){(uint32_t)width, (uint32_t)height};
    }
    if (s->extent.width == 0 || s->extent.height == 0)
        return AP_OK; // minimised
    if (!(can.supportedUsageFlags & VK_IMAGE_USAGE_TRANSFER_DST_BIT))
        return ap_fail(err, AP_ENVIRONMENT, "pictures cannot be copied into the window");
    uint32_t count = can.minImageCount + 1;
    if (can.maxImageCount > 0 && count > can.maxImageCount)
        count = can.maxImageCount;
    VkSwapchainCreateInfoKHR info = {
        .sType = VK_STRUCTURE_TYPE_SWAPCHAIN_CREATE_INFO_KHR,
        .surface = s->surface,
        .minImageCount = count,
        .imageFormat = s->format.format,
        .imageColorSpace = s->format.colorSpace,
        .imageExtent = s->extent,
        .imageArrayLayers = 1,
        .imageUsage = VK_IMAGE_USAGE_TRANSFER_DST_BIT,
        .imageSharingMode = VK_SHARING_MODE_EXCLUSIVE,
        .preTransform = can.currentTransform,
        .compositeAlpha = can.supportedCompositeAlpha & VK_COMPOSITE_ALPHA_OPAQUE_BIT_KHR
                              ? VK_COMPOSITE_ALPHA_OPAQUE_BIT_KHR
                              : VK_COMPOSITE_ALPHA_INHERIT_BIT_KHR,
        .presentMode = VK_PRESENT_MODE_FIFO_KHR, // the one that every device has
        .clipped = VK_TRUE};
    st = ap_vk_check(err, vkCreateSwapchainKHR(s->gpu.device, &info, NULL, &s->swapchain),
                     "vkCreateSwapchainKHR");
    if (st)
        return st;
    s->image_count = SIM_SCREEN_MAX_IMAGES;
    return ap_vk_check(
        err, vkGetSwapchainImagesKHR(s->gpu.device, s->swapchain, &s->image_count, s->images),
        "vkGetSwapchainImagesKHR");
}

enum ap_status sim_screen_open(struct ap_error *err, GLFWwindow *window, uint32_t width_px,
                               uint32_t height_px, struct sim_screen *s) {
    *s = (struct sim_screen){.window = window, .width_px = width_px, .height_px = height_px};
    enum ap_status st = create_instance(err, s);
    if (!st)
        st = create_device(err, s);
    if (!st)
        st = choose_format(err, s);
    if (!st)
        st = create_picture(err, s);
    if (!st)
        st = create_sync(err, s);
    return st ? st : make_swapchain(err, s);
}

void sim_screen_close(struct sim_screen *s) {
    VkInstance instance = s->gpu.instance;
    VkDevice device = s->gpu.device;
    if (device) {
        drop_swapchain(s);
        ap_gpu_image_destroy(&s->gpu, &s->picture);
        ap_gpu_buffer_destroy(&s->gpu, &s->staging);
        vkDestroyFence(device, s->fence, NULL);
        vkDestroySemaphore(device, s->acquired, NULL);
        for (int k = 0; k < SIM_SCREEN_MAX_IMAGES; k++)
            vkDestroySemaphore(device, s->drawn[k], NULL);
        ap_gpu_finish(&s->gpu);
        vkDestroyDevice(device, NULL);
    }
    if (instance) {
        vkDestroySurfaceKHR(instance, s->surface, NULL);
        vkDestroyInstance(instance, NULL);
    }
}

// Where the picture goes: as large as fits, in the middle.
static VkImageBlit place(const struct sim_screen *s) {
    double across = (double)s->extent.width / s->shown_width_px;
    double down = (double)s->extent.height / s->shown_height_px;
    double scale = across < down ? across : down;
    int32_t width = (int32_t)(scale * s->shown_width_px),
            height = (int32_t)(scale * s->shown_height_px);
    width = width > 0 ? width : 1;
    height = height > 0 ? height : 1;
    int32_t x = ((int32_t)s->extent.width - width) / 2,
            y = ((int32_t)s->extent.height - height) / 2;
    return (VkImageBlit){
        .srcSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1},
        .srcOffsets = {{0, 0, 0}, {(int32_t)s->shown_width_px, (int32_t)s->shown_height_px, 1}},
        .dstSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1},
        .dstOffsets = {{x, y, 0}, {x + width, y + height, 1}}};
}

static void record(const struct sim_screen *s, VkCommandBuffer cmd, VkImage onto) {
    const VkImageAspectFlags color = VK_IMAGE_ASPECT_COLOR_BIT;
    VkBufferImageCopy all = {.imageSubresource = {color, 0, 0, 1},
                             .imageExtent = {s->shown_width_px, s->shown_height_px, 1}};
    VkClearColorValue grey = {.float32 = {0.05f, 0.05f, 0.05f, 1}};
    VkImageSubresourceRange range = {color, 0, 1, 0, 1};
    VkImageBlit blit = place(s);
    ap_gpu_barrier(cmd, s->picture.image, color, VK_IMAGE_LAYOUT_UNDEFINED,
                   VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
    vkCmdCopyBufferToImage(cmd, s->staging.buffer, s->picture.image,
                           VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &all);
    ap_gpu_barrier(cmd, s->picture.image, color, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                   VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
    ap_gpu_barrier(cmd, onto, color, VK_IMAGE_LAYOUT_UNDEFINED,
                   VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
    vkCmdClearColorImage(cmd, onto, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, &grey, 1, &range);
    ap_gpu_barrier(cmd, onto, color, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                   VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
    vkCmdBlitImage(cmd, s->picture.image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, onto,
                   VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &blit, VK_FILTER_LINEAR);
    ap_gpu_barrier(cmd, onto, color, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                   VK_IMAGE_LAYOUT_PRESENT_SRC_KHR);
}

// Draws into the acquired image and waits until that is done: the staging buffer is free again.
static enum ap_status submit(struct ap_error *err, struct sim_screen *s, uint32_t index) {
    VkCommandBuffer cmd;
    enum ap_status st = ap_gpu_commands_begin(err, &s->gpu, &cmd);
    if (st)
        return st;
    record(s, cmd, s->images[index]);
    VkPipelineStageFlags stage = VK_PIPELINE_STAGE_ALL_COMMANDS_BIT;
    VkSubmitInfo info = {.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO,
                         .waitSemaphoreCount = 1,
                         .pWaitSemaphores = &s->acquired,
                         .pWaitDstStageMask = &stage,
                         .commandBufferCount = 1,
                         .pCommandBuffers = &cmd,
                         .signalSemaphoreCount = 1,
                         .pSignalSemaphores = &s->drawn[index]};
    VkResult result = vkEndCommandBuffer(cmd);
    if (!result)
        result = vkQueueSubmit(s->gpu.queue, 1, &info, s->fence);
    if (!result)
        result = vkWaitForFences(s->gpu.device, 1, &s->fence, VK_TRUE, UINT64_MAX);
    if (!result)
        result = vkResetFences(s->gpu.device, 1, &s->fence);
    vkFreeCommandBuffers(s->gpu.device, s->gpu.pool, 1, &cmd);
    return ap_vk_check(err, result, "vkQueueSubmit");
}

static bool stale(VkResult result) {
    return result == VK_ERROR_OUT_OF_DATE_KHR || result == VK_SUBOPTIMAL_KHR;
}

enum ap_status sim_screen_draw(struct ap_error *err, struct sim_screen *s, const void *rgba,
                               uint32_t width_px, uint32_t height_px) {
    size_t bytes = (size_t)width_px * height_px * 4;
    s->shown_width_px = width_px;
    s->shown_height_px = height_px;
    if (rgba)
        memcpy(s->staging.mapped, rgba, bytes);
    else
        memset(s->staging.mapped, 0, bytes);
    enum ap_status st = s->swapchain ? AP_OK : make_swapchain(err, s);
    if (st || !s->swapchain)
        return st;
    uint32_t index;
    VkResult result = vkAcquireNextImageKHR(s->gpu.device, s->swapchain, UINT64_MAX, s->acquired,
                                            VK_NULL_HANDLE, &index);
    if (result == VK_ERROR_OUT_OF_DATE_KHR) {
        drop_swapchain(s);
        return AP_OK; // the next picture finds a new one
    }
    if (result != VK_SUBOPTIMAL_KHR && result)
        return ap_vk_check(err, result, "vkAcquireNextImageKHR");
    st = submit(err, s, index);
    if (st)
        return st;
    VkPresentInfoKHR info = {.sType = VK_STRUCTURE_TYPE_PRESENT_INFO_KHR,
                             .waitSemaphoreCount = 1,
                             .pWaitSemaphores = &s->drawn[index],
                             .swapchainCount = 1,
                             .pSwapchains = &s->swapchain,
                             .pImageIndices = &index};
    result = vkQueuePresentKHR(s->gpu.queue, &info);
    if (stale(result)) {
        drop_swapchain(s);
        return AP_OK;
    }
    return ap_vk_check(err, result, "vkQueuePresentKHR");
}
