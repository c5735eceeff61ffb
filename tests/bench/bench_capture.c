#include "tests/sim_hmd/painter.h"

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
    struct painter p;
    XrSwapchain swapchain;
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
    XR_OK(xrCreateSwapchain(b->p.c.session, &i, &b->swapchain));
}

static void draw(struct painter *p, VkImage image) {
    const VkImageLayout target = VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL;
    const VkImageAspectFlags colour = VK_IMAGE_ASPECT_COLOR_BIT;
    VkCommandBuffer cmd = painter_begin(p);
    painter_turn(cmd, image, colour, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL, target);
    VkBufferImageCopy copy = {.imageSubresource = {colour, 0, 0, 1}, .imageExtent = {W, H, 1}};
    vkCmdCopyBufferToImage(cmd, p->buffer, image, target, 1, &copy);
    painter_turn(cmd, image, colour, target, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL);
    painter_submit(p, cmd);
}

static void frame(struct bench *b) {
    XrFrameState f = client_wait(&b->p.c);
    client_begin(&b->p.c);
    draw(&b->p, painter_acquire(b->swapchain));
    XR_OK(xrReleaseSwapchainImage(b->swapchain, NULL));
    XrViewLocateInfo info = {.type = XR_TYPE_VIEW_LOCATE_INFO,
                             .viewConfigurationType = XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO,
                             .displayTime = f.predictedDisplayTime,
                             .space = b->p.c.stage};
    uint32_t count;
    XrViewState state = {.type = XR_TYPE_VIEW_STATE};
    XrView views[2] = {{.type = XR_TYPE_VIEW}, {.type = XR_TYPE_VIEW}};
    XR_OK(xrLocateViews(b->p.c.session, &info, &state, 2, &count, views));
    XrCompositionLayerProjectionView out[2];
    for (int eye = 0; eye < 2; eye++)
        out[eye] = (XrCompositionLayerProjectionView){
            .type = XR_TYPE_COMPOSITION_LAYER_PROJECTION_VIEW,
            .pose = views[eye].pose,
            .fov = views[eye].fov,
            .subImage = {.swapchain = b->swapchain, .imageRect.extent = {W, H}}};
    XrCompositionLayerProjection layer = {.type = XR_TYPE_COMPOSITION_LAYER_PROJECTION,
                                          .space = b->p.c.stage,
                                          .viewCount = 2,
                                          .views = out};
    const XrCompositionLayerBaseHeader *list = (const XrCompositionLayerBaseHeader *)&layer;
    XrFrameEndInfo end = {.type = XR_TYPE_FRAME_END_INFO,
                          .displayTime = f.predictedDisplayTime,
                          .environmentBlendMode = XR_ENVIRONMENT_BLEND_MODE_OPAQUE,
                          .layerCount = 1,
                          .layers = &list};
    XR_OK(xrEndFrame(b->p.c.session, &end));
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
    painter_start(&b.p, (VkDeviceSize)W * H * 4);
    paint(b.p.mapped);
    make_swapchain(&b);
    frame(&b); // what is made when first needed
    double cpu = seconds(CLOCK_PROCESS_CPUTIME_ID), wall = seconds(CLOCK_MONOTONIC);
    for (int k = 1; k < FRAMES; k++)
        frame(&b);
    double called = seconds(CLOCK_MONOTONIC) - wall;
    painter_stop(&b.p); // the writers end
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
