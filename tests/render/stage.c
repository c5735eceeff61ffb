#include "tests/render/stage.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct ap_error stage_error;

void stage_check(enum ap_status st, const struct ap_error *err, const char *file, int line) {
    if (st == AP_OK)
        return;
    fprintf(stderr, "%s:%d: status %d: %s\n", file, line, (int)st, err->text);
    exit(1);
}

bool stage_open(struct stage *stage, uint32_t width, uint32_t height, bool validate) {
    memset(stage, 0, sizeof *stage);
    struct ap_gpu_headless_params params = {validate, &stage->validation_errors};
    if (ap_gpu_create_headless(&stage_error, &params, &stage->gpu) != AP_OK) {
        printf("skipped: %s\n", stage_error.text);
        return false;
    }
    stage_resize(stage, width, height);
    return true;
}

void stage_resize(struct stage *stage, uint32_t width, uint32_t height) {
    vkDeviceWaitIdle(stage->gpu.device);
    ap_gpu_image_destroy(&stage->gpu, &stage->target);
    ap_gpu_buffer_destroy(&stage->gpu, &stage->pixels);
    stage->width = width;
    stage->height = height;
    VkImageCreateInfo info = {.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
                              .imageType = VK_IMAGE_TYPE_2D,
                              .format = VK_FORMAT_R8G8B8A8_SRGB,
                              .extent = {width, height, 1},
                              .mipLevels = 1,
                              .arrayLayers = 2,
                              .samples = VK_SAMPLE_COUNT_1_BIT,
                              .usage = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT |
                                       VK_IMAGE_USAGE_TRANSFER_SRC_BIT};
    STAGE_CHECK(ap_gpu_image_create(&stage_error, &stage->gpu, &info, VK_IMAGE_VIEW_TYPE_2D_ARRAY,
                                    VK_IMAGE_ASPECT_COLOR_BIT, &stage->target));
    STAGE_CHECK(ap_gpu_buffer_create(&stage_error, &stage->gpu, (VkDeviceSize)width * height * 8,
                                     VK_BUFFER_USAGE_TRANSFER_DST_BIT, true, &stage->pixels));
}

void stage_close(struct stage *stage) {
    vkDeviceWaitIdle(stage->gpu.device);
    ap_gpu_image_destroy(&stage->gpu, &stage->target);
    ap_gpu_buffer_destroy(&stage->gpu, &stage->pixels);
    ap_gpu_finish(&stage->gpu);
}

struct ap_renderer *stage_renderer(const struct stage *stage, const struct ap_scene *scene,
                                   const struct ap_renderer_params *params) {
    struct ap_renderer_params all = params ? *params : (struct ap_renderer_params){0};
    struct ap_renderer *renderer = NULL;
    all.color_format = VK_FORMAT_R8G8B8A8_SRGB;
    all.width = stage->width;
    all.height = stage->height;
    STAGE_CHECK(ap_renderer_create(&stage_error, &stage->gpu, scene, &all, &renderer));
    return renderer;
}

struct ap_frame_stats stage_draw(struct stage *stage, struct ap_renderer *renderer,
                                 const struct ap_frame_input *input) {
    struct ap_frame_stats stats = {0};
    VkImage image = stage->target.image;
    struct ap_target target = {{image, image}, {0, 1}};
    STAGE_CHECK(ap_renderer_draw(&stage_error, renderer, input, &target, &stats));
    VkCommandBuffer cmd = VK_NULL_HANDLE;
    STAGE_CHECK(ap_gpu_commands_begin(&stage_error, &stage->gpu, &cmd));
    ap_gpu_barrier(cmd, image, VK_IMAGE_ASPECT_COLOR_BIT, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL,
                   VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
    VkBufferImageCopy copy = {.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 2},
                              .imageExtent = {stage->width, stage->height, 1}};
    vkCmdCopyImageToBuffer(cmd, image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, stage->pixels.buffer,
                           1, &copy);
    STAGE_CHECK(ap_gpu_commands_end(&stage_error, &stage->gpu, cmd));
    return stats;
}

const uint8_t *stage_eye(const struct stage *stage, int eye) {
    return (const uint8_t *)stage->pixels.mapped + (size_t)eye * stage->width * stage->height * 4;
}

struct ap_image stage_picture(const struct stage *stage, int eye) {
    struct ap_image image;
    STAGE_CHECK(ap_image_create(&stage_error, stage->width, stage->height, &image));
    const uint8_t *from = stage_eye(stage, eye);
    for (size_t i = 0; i < (size_t)stage->width * stage->height; i++)
        memcpy(image.rgb + 3 * i, from + 4 * i, 3);
    return image;
}

struct ap_frame_input stage_input(struct ap_space space, enum ap_view_mode mode, double half_rad,
                                  double ipd_m) {
    double t = tan(half_rad);
    struct ap_frame_input input = {
        .viewer = {.space = space, .mode = mode, .world_from_nose = AP_ISO_IDENTITY},
        .world_from_hand = {AP_ISO_IDENTITY, AP_ISO_IDENTITY}};
    for (int e = 0; e < 2; e++) {
        input.viewer.eye[e].view_from_eye = AP_POSE_IDENTITY;
        input.viewer.eye[e].view_from_eye.p.x = (e == 0 ? -0.5 : 0.5) * ipd_m;
        input.viewer.eye[e].frustum = (struct ap_frustum){-t, t, t, -t};
    }
    return input;
}

struct ap_scene stage_scene(struct ap_space space, struct ap_part *parts, size_t count) {
    struct ap_scene scene = {.space = space, .parts = parts, .part_count = count};
    scene.lamp = ap_exp(space, (struct ap_vec3){0.2, 1.2, 0.4});
    return scene;
}

struct ap_part stage_ball(struct ap_space space, struct ap_vec3 at_m, double radius_m,
                          const uint8_t color[3]) {
    struct ap_part part = {.kind = AP_PART_BALL, .radius_m = radius_m};
    part.carrier_from_part = ap_iso_translate(space, at_m);
    for (int i = 0; i < 3; i++)
        part.color_srgb[i] = color[i] / 255.0;
    return part;
}
