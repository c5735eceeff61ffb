#include "src/app/play/panel.h"

#include <string.h>

enum ap_status ap_play_panel_create(struct ap_error *err, struct ap_xr *xr,
                                    const struct ap_gpu *gpu, uint32_t width_px, uint32_t height_px,
                                    struct ap_play_panel *out) {
    VkFormat format = ap_xr_vulkan(xr).color_format;
    struct ap_play_panel panel = {.gpu = gpu, .bgra = format == VK_FORMAT_B8G8R8A8_SRGB};
    const struct ap_xr_panel_params params = {width_px, height_px};
    enum ap_status st = ap_canvas_create(err, width_px, height_px, &panel.canvas);
    if (!st)
        st = ap_xr_panel_create(err, xr, &params, &panel.quad);
    if (!st)
        st = ap_gpu_buffer_create(err, gpu, (VkDeviceSize)width_px * height_px * 4,
                                  VK_BUFFER_USAGE_TRANSFER_SRC_BIT, true, &panel.staging);
    if (st)
        ap_play_panel_destroy(&panel);
    else
        *out = panel;
    return st;
}

void ap_play_panel_destroy(struct ap_play_panel *panel) {
    ap_xr_panel_destroy(panel->quad);
    if (panel->gpu)
        ap_gpu_buffer_destroy(panel->gpu, &panel->staging);
    ap_canvas_finish(&panel->canvas);
    *panel = (struct ap_play_panel){0};
}

static void fill_staging(struct ap_play_panel *panel) {
    size_t count = (size_t)panel->canvas.width * panel->canvas.height;
    uint8_t *to = panel->staging.mapped;
    memcpy(to, panel->canvas.rgba, count * 4);
    for (size_t i = 0; panel->bgra && i < count; i++) {
        uint8_t red = to[4 * i];
        to[4 * i] = to[4 * i + 2];
        to[4 * i + 2] = red;
    }
}

static enum ap_status copy_to(struct ap_error *err, struct ap_play_panel *panel, VkImage image) {
    VkCommandBuffer cmd;
    enum ap_status st = ap_gpu_commands_begin(err, panel->gpu, &cmd);
    if (st)
        return st;
    const VkImageAspectFlags color = VK_IMAGE_ASPECT_COLOR_BIT;
    VkBufferImageCopy all = {.imageSubresource = {color, 0, 0, 1},
                             .imageExtent = {panel->canvas.width, panel->canvas.height, 1}};
    ap_gpu_barrier(cmd, image, color, VK_IMAGE_LAYOUT_UNDEFINED,
                   VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
    vkCmdCopyBufferToImage(cmd, panel->staging.buffer, image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                           1, &all);
    ap_gpu_barrier(cmd, image, color, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                   VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL);
    return ap_gpu_commands_end(err, panel->gpu, cmd);
}

enum ap_status ap_play_panel_show(struct ap_error *err, struct ap_play_panel *panel) {
    VkImage image;
    enum ap_status st = ap_xr_panel_acquire(err, panel->quad, &image);
    if (st)
        return st;
    fill_staging(panel);
    st = copy_to(err, panel, image);
    return st ? st : ap_xr_panel_release(err, panel->quad);
}
