#ifndef ANTIPODE_SIM_HMD_COMPOSITOR_PASS_H
#define ANTIPODE_SIM_HMD_COMPOSITOR_PASS_H

#include "sim_hmd/frame.h"

// The graphics pass that lays projection layers over one another as a display's eye sees them:
// rotation-only reprojection, bilinear, blended in linear light, R8G8B8A8_SRGB.
struct sim_pass {
    VkRenderPass render_pass;
    VkDescriptorSetLayout set_layout;
    VkPipelineLayout layout;
    VkPipeline pipeline;
    VkSampler linear, nearest; // nearest: for formats that cannot be filtered
};

enum ap_status sim_pass_create(struct ap_error *err, const struct ap_gpu *gpu,
                               struct sim_pass *pass);
void sim_pass_destroy(const struct ap_gpu *gpu, struct sim_pass *pass); // accepts a zeroed one

struct sim_pass_target {
    struct ap_gpu_image image; // in TRANSFER_SRC_OPTIMAL after a pass
    VkFramebuffer framebuffer;
    uint32_t width_px, height_px;
};

enum ap_status sim_pass_target_create(struct ap_error *err, const struct ap_gpu *gpu,
                                      const struct sim_pass *pass, uint32_t width_px,
                                      uint32_t height_px, struct sim_pass_target *target);
void sim_pass_target_destroy(const struct ap_gpu *gpu, struct sim_pass_target *target);

// Starts the pass on a black target; sim_pass_end ends it.
void sim_pass_begin(VkCommandBuffer cmd, const struct sim_pass *pass,
                    const struct sim_pass_target *target);
void sim_pass_end(VkCommandBuffer cmd);

// One layer onto a part of the target: what the eye at this pose with this fov sees of it. set
// holds the view's image, in SHADER_READ_ONLY_OPTIMAL or GENERAL.
void sim_pass_draw(VkCommandBuffer cmd, const struct sim_pass *pass, VkRect2D part,
                   const struct sim_frame *frame, int eye, const struct sim_layer *layer,
                   VkDescriptorSet set);

// What the shader is told, for the tests' reference: see shaders/composite.frag.
struct sim_pass_push {
    float turn[3][4];
    float eye_tan[4], layer_tan[4];
    float rect[4];
    float size[2];
    uint32_t alpha;
};
struct sim_pass_push sim_pass_push_of(const struct sim_frame *frame, int eye,
                                      const struct sim_layer *layer);

#endif
