#include "tests/sim_hmd/client.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>

// What capturing costs a program whose two eyes are 1440×1600: every frame of a short run, drawn by
// one copy, on the virtual clock, in each way that the settings offer. CPU time is of all threads.

enum { W = 1440, H = 1600, FRAMES = 24 };

static double seconds(clockid_t clock) {
    struct timespec t;
    clock_gettime(clock, &t);
    return (double)t.tv_sec + (double)t.tv_nsec * 1e-9;
}

struct bench {
    struct client c;
    VkBuffer buffer;
    VkDeviceMemory memory;
    VkCommandPool pool;
    VkQueue queue;
    XrSwapchain swapchain;
    VkImage image[3];
};

// Black above, below it a chequered floor that pales with the distance, and some balls.
static void paint(uint8_t *p) {
    for (int y = 0; y < H; y++)
        for (int x = 0; x < W; x++, p += 4) {
            double z = y > H / 2 ? 400.0 / (y - H / 2 + 8) : 0, u = (x - W / 2) * z / 300;
            int bright = (((int)(u + 100) + (int)(4 * z)) & 1) ? 200 : 90;
            int v = y > H / 2 ? (int)(bright / (1 + 0.1 * z)) : 0;
            for (int b = 0; b < 3; b++) {
                double dx = x - 300 - 400 * b, dy = y - 700 - 100 * b;
                double d = 1 - (dx * dx + dy * dy) / 22500;
                v = d > 0 ? (int)(60 + 190 * d) : v;
            }
            p[0] = (uint8_t)v;
            p[1] = (uint8_t)(v * 7 / 8);
            p[2] = (uint8_t)(v * 3 / 4);
            p[3] = 255;
        }
}

static void make_picture(struct bench *b) {
    VkBufferCreateInfo info = {.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO,
                               .size = (VkDeviceSize)W * H * 4,
                               .usage = VK_BUFFER_USAGE_TRANSFER_SRC_BIT};
    assert_int_equal(vkCreateBuffer(b->c.device, &info, NULL, &b->buffer), VK_SUCCESS);
    VkMemoryRequirements needs;
    vkGetBufferMemoryRequirements(b->c.device, b->buffer, &needs);
    VkMemoryAllocateInfo a = {.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO,
                              .allocationSize = needs.size};
    assert_int_equal(vkAllocateMemory(b->c.device, &a, NULL, &b->memory), VK_SUCCESS);
    assert_int_equal(vkBindBufferMemory(b->c.device, b->buffer, b->memory, 0), VK_SUCCESS);
    void *p;
    assert_int_equal(vkMapMemory(b->c.device, b->memory, 0, VK_WHOLE_SIZE, 0, &p), VK_SUCCESS);
    paint(p);
    VkCommandPoolCreateInfo pool = {.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO};
    assert_int_equal(vkCreateCommandPool(b->c.device, &pool, NULL, &b->pool), VK_SUCCESS);
    vkGetDeviceQueue(b->c.device, 0, 0, &b->queue);
}

static void make_swapchain(struct bench *b) {
    XrSwapchainCreateInfo i = {.type = XR_TYPE_SWAPCHAIN_CREATE_INFO,
                               .usageFlags = XR_SWAPCHAIN_USAGE_COLOR_ATTACHMENT_BIT |
                                             XR_SWAPCHAIN_USAGE_TRANSFER_DST_BIT,
                               .format = VK_FORMAT_R8G8B8A8_SRGB,
                               .sampleCount = 1,
                               .width = W,
                               .height = H,
                               .faceCount = 1,
                               .arraySize = 1,
                               .mipCount = 1};
    XR_OK(xrCreateSwapchain(b->c.session, &i, &b->swapchain));
    XrSwapchainImageVulkanKHR images[3] = {{.type = XR_TYPE_SWAPCHAIN_IMAGE_VULKAN_KHR},
                                           {.type = XR_TYPE_SWAPCHAIN_IMAGE_VULKAN_KHR},
                                           {.type = XR_TYPE_SWAPCHAIN_IMAGE_VULKAN_KHR}};
    uint32_t count;
    XR_OK(
        xrEnumerateSwapchainImages(b->swapchain, 3, &count, (XrSwapchainImageBaseHeader *)images));
    for (int k = 0; k < 3; k++)
        b->image[k] = images[k].image;
}

static void turn(VkCommandBuffer cmd, VkImage image, VkImageLayout from, VkImageLayout to) {
    VkImageMemoryBarrier barrier = {.sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER,
                                    .srcAccessMask = VK_ACCESS_MEMORY_WRITE_BIT,
                                    .dstAccessMask = VK_ACCESS_MEMORY_WRITE_BIT,
                                    .oldLayout = from,
                                    .newLayout = to,
                                    .image = image,
                                    .subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1}};
    vkCmdPipelineBarrier(cmd, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT,
                         VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, 0, 0, NULL, 0, NULL, 1, &barrier);
}

static void draw(struct bench *b, VkImage image) {
    const VkImageLayout target = VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL;
    VkCommandBufferAllocateInfo a = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
                                     .commandPool = b->pool,
                                     .commandBufferCount = 1};
    VkCommandBuffer cmd;
    assert_int_equal(vkAllocateCommandBuffers(b->c.device, &a, &cmd), VK_SUCCESS);
    VkCommandBufferBeginInfo begin = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
    vkBeginCommandBuffer(cmd, &begin);
    turn(cmd, image, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL, target);
    VkBufferImageCopy copy = {.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1},
                              .imageExtent = {W, H, 1}};
    vkCmdCopyBufferToImage(cmd, b->buffer, image, target, 1, &copy);
    turn(cmd, image, target, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL);
    vkEndCommandBuffer(cmd);
    VkSubmitInfo submit = {
        .sType = VK_STRUCTURE_TYPE_SUBMIT_INFO, .commandBufferCount = 1, .pCommandBuffers = &cmd};
    assert_int_equal(vkQueueSubmit(b->queue, 1, &submit, VK_NULL_HANDLE), VK_SUCCESS);
}

static void frame(struct bench *b) {
    XrFrameState f = client_wait(&b->c);
    client_begin(&b->c);
    uint32_t index, count;
    XrSwapchainImageWaitInfo wait = {.type = XR_TYPE_SWAPCHAIN_IMAGE_WAIT_INFO};
    XR_OK(xrAcquireSwapchainImage(b->swapchain, NULL, &index));
    XR_OK(xrWaitSwapchainImage(b->swapchain, &wait));
    draw(b, b->image[index]);
    XR_OK(xrReleaseSwapchainImage(b->swapchain, NULL));
    XrViewLocateInfo info = {.type = XR_TYPE_VIEW_LOCATE_INFO,
                             .viewConfigurationType = XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO,
                             .displayTime = f.predictedDisplayTime,
                             .space = b->c.stage};
    XrViewState state = {.type = XR_TYPE_VIEW_STATE};
    XrView views[2] = {{.type = XR_TYPE_VIEW}, {.type = XR_TYPE_VIEW}};
    XR_OK(xrLocateViews(b->c.session, &info, &state, 2, &count, views));
    XrCompositionLayerProjectionView out[2];
    for (int eye = 0; eye < 2; eye++)
        out[eye] = (XrCompositionLayerProjectionView){
            .type = XR_TYPE_COMPOSITION_LAYER_PROJECTION_VIEW,
            .pose = views[eye].pose,
            .fov = views[eye].fov,
            .subImage = {.swapchain = b->swapchain, .imageRect.extent = {W, H}}};
    XrCompositionLayerProjection layer = {.type = XR_TYPE_COMPOSITION_LAYER_PROJECTION,
                                          .space = b->c.stage,
                                          .viewCount = 2,
                                          .views = out};
    const XrCompositionLayerBaseHeader *list = (const XrCompositionLayerBaseHeader *)&layer;
    XrFrameEndInfo end = {.type = XR_TYPE_FRAME_END_INFO,
                          .displayTime = f.predictedDisplayTime,
                          .environmentBlendMode = XR_ENVIRONMENT_BLEND_MODE_OPAQUE,
                          .layerCount = 1,
                          .layers = &list};
    XR_OK(xrEndFrame(b->c.session, &end));
}

// "capture" is what stands for its value in the settings; NULL: none.
static void run(const char *name, const char *capture) {
    struct bench b = {0};
    char json[1024], command[256];
    snprintf(json, sizeof json,
             "{\"clock\": \"virtual\"%s%s%s, \"headset\": {\"name\": \"x\", \"refresh_hz\": 90, "
             "\"ipd_m\": 0.064, \"lens\": {\"k1\": 0.2, \"k2\": 0.05, \"red_scale\": 0.99, "
             "\"blue_scale\": 1.01}, \"eyes\": {\"left\": {\"resolution_px\": [%d, %d], "
             "\"fov_rad\": {\"left\": -0.8, \"right\": 0.8, \"up\": 0.8, \"down\": -0.8}}, "
             "\"right\": {\"resolution_px\": [%d, %d], \"fov_rad\": {\"left\": -0.8, \"right\": "
             "0.8, \"up\": 0.8, \"down\": -0.8}}}}}",
             capture ? ", \"capture\": {\"dir\": \"cap\"" : "", capture ? capture : "",
             capture ? "}" : "", W, H, W, H);
    client_settings(json);
    client_start(&b.c);
    make_picture(&b);
    make_swapchain(&b);
    frame(&b); // what is made when first needed
    double cpu = seconds(CLOCK_PROCESS_CPUTIME_ID), wall = seconds(CLOCK_MONOTONIC);
    for (int k = 1; k < FRAMES; k++)
        frame(&b);
    double called = seconds(CLOCK_MONOTONIC) - wall;
    vkDeviceWaitIdle(b.c.device);
    vkDestroyCommandPool(b.c.device, b.pool, NULL);
    vkDestroyBuffer(b.c.device, b.buffer, NULL);
    vkFreeMemory(b.c.device, b.memory, NULL);
    client_stop(&b.c); // the writers end
    printf("%-34s %7.1f CPU ms a frame, %7.1f ms wall, %7.1f ms in the program's thread\n", name,
           1e3 * (seconds(CLOCK_PROCESS_CPUTIME_ID) - cpu) / (FRAMES - 1),
           1e3 * (seconds(CLOCK_MONOTONIC) - wall) / (FRAMES - 1), 1e3 * called / (FRAMES - 1));
    snprintf(command, sizeof command,
             "cd '%s' && du -k cap 2>/dev/null | sed 's/cap/kB/'; rm -rf cap", client_folder());
    fflush(stdout);
    if (system(command) != 0)
        fprintf(stderr, "cannot remove the capture\n");
}

int main(void) {
    run("no capture", NULL);
    run("log only", ", \"composed\": false");
    run("composed, PNG", "");
    run("layers, PNG", ", \"composed\": false, \"layers\": true");
    run("composed and layers, PNG", ", \"layers\": true");
    run("composed and layers, raw", ", \"layers\": true, \"format\": \"raw\"");
    run("composed through the lens, PNG", ", \"lens\": true");
    return 0;
}
