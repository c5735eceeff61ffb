#include "src/app/play/picture.h"

#include <stdio.h>
#include <stdlib.h>

#include "src/base/file.h"
#include "src/image/image.h"

static enum ap_status read_back(struct ap_error *err, const struct ap_gpu *gpu,
                                const struct ap_play_picture *p, int eye,
                                const struct ap_gpu_buffer *buffer) {
    VkCommandBuffer cmd;
    enum ap_status st = ap_gpu_commands_begin(err, gpu, &cmd);
    if (st)
        return st;
    const VkImageAspectFlags color = VK_IMAGE_ASPECT_COLOR_BIT;
    const VkImageLayout drawn = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL;
    VkBufferImageCopy all = {.imageSubresource = {color, 0, p->layer[eye], 1},
                             .imageExtent = {p->width_px, p->height_px, 1}};
    ap_gpu_barrier(cmd, p->image[eye], color, drawn, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
    vkCmdCopyImageToBuffer(cmd, p->image[eye], VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, buffer->buffer,
                           1, &all);
    ap_gpu_barrier(cmd, p->image[eye], color, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, drawn);
    return ap_gpu_commands_end(err, gpu, cmd);
}

static enum ap_status to_image(struct ap_error *err, const struct ap_play_picture *p,
                               const uint8_t *bytes, struct ap_image *image) {
    enum ap_status st = ap_image_create(err, p->width_px, p->height_px, image);
    if (st)
        return st;
    int red = p->format == VK_FORMAT_B8G8R8A8_SRGB ? 2 : 0;
    size_t count = (size_t)p->width_px * p->height_px;
    for (size_t i = 0; i < count; i++) {
        image->rgb[3 * i] = bytes[4 * i + (size_t)red];
        image->rgb[3 * i + 1] = bytes[4 * i + 1];
        image->rgb[3 * i + 2] = bytes[4 * i + 2 - (size_t)red];
    }
    return AP_OK;
}

static char *path_of(const char *folder, int number, const char *what) {
    char name[64];
    snprintf(name, sizeof name, "antipode-%03d-%s.png", number, what);
    return ap_path_join(folder, name);
}

static bool is_free(const char *folder, int number) {
    char *path = path_of(folder, number, "left");
    bool taken = !path || ap_file_exists(path);
    free(path);
    return !taken;
}

static enum ap_status write_one(struct ap_error *err, const char *folder, int number,
                                const char *what, const struct ap_image *image) {
    char *path = path_of(folder, number, what);
    enum ap_status st =
        path ? ap_png_write(err, path, image) : ap_fail(err, AP_ENVIRONMENT, "out of memory");
    free(path);
    return st;
}

enum ap_status ap_play_picture_write(struct ap_error *err, const struct ap_gpu *gpu,
                                     const struct ap_play_picture *picture, const char *folder,
                                     char name[64]) {
    struct ap_gpu_buffer buffer = {0};
    struct ap_image eye[2] = {{0}}, both = {0};
    int number = 1;
    while (number < 1000 && !is_free(folder, number))
        number++;
    if (number == 1000)
        return ap_fail(err, AP_ENVIRONMENT, "%s: no free name up to antipode-999-left.png", folder);
    enum ap_status st =
        ap_gpu_buffer_create(err, gpu, (VkDeviceSize)picture->width_px * picture->height_px * 4,
                             VK_BUFFER_USAGE_TRANSFER_DST_BIT, true, &buffer);
    for (int e = 0; e < 2 && !st; e++) {
        st = read_back(err, gpu, picture, e, &buffer);
        if (!st)
            st = to_image(err, picture, buffer.mapped, &eye[e]);
    }
    if (!st)
        st = ap_image_side_by_side(err, &eye[0], &eye[1], &both);
    if (!st)
        st = write_one(err, folder, number, "left", &eye[0]);
    if (!st)
        st = write_one(err, folder, number, "right", &eye[1]);
    if (!st)
        st = write_one(err, folder, number, "sbs", &both);
    if (!st)
        snprintf(name, 64, "antipode-%03d-{left,right,sbs}.png", number);
    for (int e = 0; e < 2; e++)
        ap_image_finish(&eye[e]);
    ap_image_finish(&both);
    ap_gpu_buffer_destroy(gpu, &buffer);
    return st;
}
