#ifndef ANTIPODE_TESTS_RENDER_PROBE_H
#define ANTIPODE_TESTS_RENDER_PROBE_H

#include "src/render/cells.h"
#include "src/render/pass/pass.h"

// What the renderer draws, told apart by part and with its depths: the renderer's own list of a
// frame, its meshes, pipelines and shaders, one sample in the middle of each pixel, but each item
// in a colour that says which it is. One thread.

// A scene as the renderer holds it.
struct probe_world {
    const struct ap_gpu *gpu;
    struct ap_scene *scene; // borrowed
    struct ap_meshes meshes;
    struct ap_cell_view cells;
    struct ap_draw_list list;
};
void probe_world_open(struct probe_world *world, const struct ap_gpu *gpu, struct ap_scene *scene);
void probe_world_close(struct probe_world *world);

struct probe {
    const struct ap_gpu *gpu;
    uint32_t width, height;
    struct ap_pass pass;
    const VkPipeline *pipelines; // the pass's, of the newest frame's world
    VkDescriptorSetLayout set_layout;
    VkPipelineLayout layout;
    VkDescriptorPool descriptors;
    VkDescriptorSet set;
    struct ap_gpu_image decal;
    VkSampler sampler;
    VkFramebuffer framebuffer;
    VkRenderPass render_pass; // as the pass's, but that depths are kept
    struct ap_gpu_image color, depth;
    struct ap_gpu_buffer frame, marks, pixels;
    struct ap_gpu_frame said; // what the shaders were told of the newest frame
};
void probe_open(struct probe *probe, const struct ap_gpu *gpu, uint32_t width, uint32_t height);
void probe_close(struct probe *probe);

// Fills world->list with what is drawn, and orders it: what probe_draw draws.
void probe_list(const struct probe *probe, struct probe_world *world,
                const struct ap_frame_input *input, double max_error_px);

// Draws an eye. number: of each item of the list as it is ordered, below 0xffffff; what is drawn is
// 1 + number in ids[pixel], 0 where nothing is; depth: the buffer's.
void probe_draw(struct probe *probe, const struct probe_world *world,
                const struct ap_frame_input *input, int eye, const uint32_t *number, uint32_t *ids,
                float *depth);

// Metres along the line of sight from the eye to where something of this depth is: native in
// tangent space, tourist in the eye's space (image: 0 or 1). x, y: pixels.
double probe_along(const struct probe *probe, const struct ap_viewer *viewer, int eye, int image,
                   double x_px, double y_px, double depth);

#endif
