#include "tests/sim_hmd/layered.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "src/base/file.h"
#include "src/image/image.h"

static void start(struct painter *p, const char *clock, const char *dir, const char *more,
                  const char *profile) {
    char json[2048];
    snprintf(json, sizeof json,
             "{\"clock\": \"%s\", \"capture\": {\"dir\": \"%s/%s\"%s}, \"headset\": "
             "{\"name\": \"tiny\", \"refresh_hz\": 90, \"ipd_m\": 0.06%s, \"eyes\": {\"left\": "
             "{\"resolution_px\": [%d, %d], \"fov_rad\": {\"left\": -0.8, \"right\": 0.7, "
             "\"up\": 0.7, \"down\": -0.6}}, \"right\": {\"resolution_px\": [%d, %d], "
             "\"fov_rad\": {\"left\": -0.7, \"right\": 0.8, \"up\": 0.7, \"down\": -0.6}}}}}",
             clock, client_folder(), dir, more, profile, W, H, W, H);
    client_settings(json);
    painter_start(p, 2 * W * H * 8);
}

void layered_start(struct painter *p, const char *dir, const char *more, const char *profile) {
    start(p, "virtual", dir, more, profile);
}

void layered_start_real(struct painter *p, const char *dir, const char *more) {
    start(p, "real", dir, more, "");
}

uint8_t layered_texel(int x, int y, int layer, int channel) {
    const int v[4] = {x * 3 + 17 * layer, y * 5, x ^ y, 255 - 2 * x};
    return (uint8_t)v[channel];
}

struct screen layered_screen(struct painter *p, VkFormat format) {
    struct screen s = {.format = format,
                       .texel_bytes = format == VK_FORMAT_R16G16B16A16_SFLOAT ? 8 : 4};
    const XrSwapchainCreateInfo i = client_colour_info(format, W, H);
    XR_OK(xrCreateSwapchain(p->c.session, &i, &s.swapchain));
    XrSwapchainImageVulkanKHR images[3] = {{.type = XR_TYPE_SWAPCHAIN_IMAGE_VULKAN_KHR},
                                           {.type = XR_TYPE_SWAPCHAIN_IMAGE_VULKAN_KHR},
                                           {.type = XR_TYPE_SWAPCHAIN_IMAGE_VULKAN_KHR}};
    uint32_t count;
    XR_OK(xrEnumerateSwapchainImages(s.swapchain, 3, &count, (XrSwapchainImageBaseHeader *)images));
    for (int k = 0; k < 3; k++)
        s.image[k] = images[k].image;
    return s;
}

// The half of v/255: 2048 steps from 0.5 to 1 and so on, so that a byte comes back from it.
static uint16_t half_of(double v) {
    int e = 0;
    if (v <= 0)
        return 0;
    double m = frexp(v, &e); // 0.5 ≤ m < 1
    return e < -13 ? 0 : (uint16_t)(((e + 14) << 10) + (int)lround((2 * m - 1) * 1024));
}

static void fill(struct painter *p, const struct screen *s, int frame) {
    uint8_t *to = p->mapped;
    for (int layer = 0; layer < 2; layer++)
        for (int y = 0; y < H; y++)
            for (int x = 0; x < W; x++)
                for (int c = 0; c < 4; c++) {
                    uint8_t v = layered_texel(x + frame, y, layer, c);
                    uint16_t half = half_of(c == 3 ? v / 255.0 : ap_linear_from_srgb(v));
                    if (s->texel_bytes == 8)
                        memcpy(to, &half, 2);
                    else
                        *to = v;
                    to += s->texel_bytes / 4;
                }
}

void layered_draw(struct painter *p, struct screen *s, int frame) {
    VkImage image = painter_acquire(s->swapchain);
    fill(p, s, frame);
    VkCommandBuffer cmd = painter_begin(p);
    painter_turn(cmd, image, VK_IMAGE_ASPECT_COLOR_BIT, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL,
                 VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
    VkBufferImageCopy copy = {.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 2},
                              .imageExtent = {W, H, 1}};
    vkCmdCopyBufferToImage(cmd, p->buffer, image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &copy);
    painter_turn(cmd, image, VK_IMAGE_ASPECT_COLOR_BIT, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                 VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL);
    painter_submit(p, cmd);
    vkQueueWaitIdle(p->queue); // the buffer is written again
    XR_OK(xrReleaseSwapchainImage(s->swapchain, NULL));
}

void layered_layer(struct painter *p, const struct screen *s, XrTime time, XrRect2Di rect,
                   XrCompositionLayerFlags flags, struct layer *l) {
    XrView views[2];
    client_views(&p->c, p->c.stage, time, views);
    *l = (struct layer){.projection = {.type = XR_TYPE_COMPOSITION_LAYER_PROJECTION,
                                       .layerFlags = flags,
                                       .space = p->c.stage,
                                       .viewCount = 2,
                                       .views = l->views}};
    for (uint32_t eye = 0; eye < 2; eye++)
        l->views[eye] = (XrCompositionLayerProjectionView){
            .type = XR_TYPE_COMPOSITION_LAYER_PROJECTION_VIEW,
            .pose = views[eye].pose,
            .fov = views[eye].fov,
            .subImage = {.swapchain = s->swapchain, .imageRect = rect, .imageArrayIndex = 1 - eye}};
}

const XrRect2Di layered_whole = {{0, 0}, {W, H}}, layered_part = {{5, 7}, {33, 19}};

void layered_run(struct painter *p, VkFormat first, VkFormat second, int frames) {
    struct screen s[2] = {layered_screen(p, first), layered_screen(p, second)};
    for (int k = 0; k < frames; k++) {
        struct layer l[2];
        XrFrameState f = client_wait(&p->c);
        client_begin(&p->c);
        for (int i = 0; i < 2; i++) {
            layered_draw(p, &s[i], k);
            layered_layer(p, &s[i], f.predictedDisplayTime, i ? layered_part : layered_whole,
                          i ? XR_COMPOSITION_LAYER_BLEND_TEXTURE_SOURCE_ALPHA_BIT : 0, &l[i]);
        }
        const XrCompositionLayerBaseHeader *list[2] = {
            (const XrCompositionLayerBaseHeader *)&l[0].projection,
            (const XrCompositionLayerBaseHeader *)&l[1].projection};
        XrFrameEndInfo end = {.type = XR_TYPE_FRAME_END_INFO,
                              .displayTime = f.predictedDisplayTime,
                              .environmentBlendMode = XR_ENVIRONMENT_BLEND_MODE_OPAQUE,
                              .layerCount = 2,
                              .layers = list};
        XR_OK(xrEndFrame(p->c.session, &end));
    }
}

bool layered_exists(const char *dir, const char *name) {
    return ap_file_exists(painter_path(dir, name));
}

char *layered_read(const char *dir, const char *name, size_t *len) {
    char *bytes;
    struct ap_error err;
    if (ap_file_read(&err, painter_path(dir, name), 1 << 24, &bytes, len))
        fail_msg("%s", err.text);
    return bytes;
}
