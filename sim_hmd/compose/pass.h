#ifndef ANTIPODE_SIM_HMD_COMPOSE_PASS_H
#define ANTIPODE_SIM_HMD_COMPOSE_PASS_H

#include "sim_hmd/compose/shape.h"
#include "sim_hmd/compose/frame.h"

// How a layer is drawn: bits that shaders/composite.glsl knows too. They are constants of the
// pipeline, so that none pays for another's questions.
enum sim_way {
    SIM_WAY_CYLINDER = 1, // else a plane
    SIM_WAY_SPHERE = 2,
    SIM_WAY_BLENDED = 4,         // by the image's alpha
    SIM_WAY_UNPREMULTIPLIED = 8, // colour is multiplied by alpha first
    SIM_WAY_EDGES = 16,          // some pixels of its bounds may miss it
    SIM_WAY_CENTRED = 32,
    SIM_WAY_BRIGHT = 64, // the image's values may lie beyond 0…1
    SIM_WAY_CUBE = 128,
    SIM_WAY_MIPS = 512, // a plane whose image has smaller versions of itself
    SIM_WAY_PART = 256, // of an image: what is beside it must not be mixed in
};

// What one draw does. Layers that cover much of the eye are laid over one another within one, for
// reading a target back costs more than another texture.
enum { SIM_PASS_FUSED = 4, SIM_PASS_PIPELINES = 128 };
struct sim_pass_key {
    uint32_t count;
    uint32_t ways[SIM_PASS_FUSED];
    uint32_t first; // nothing but black below: no blending
};

// The graphics pass that lays layers over one another as a display's eye sees them: bilinear,
// blended in linear light, R8G8B8A8_SRGB.
struct sim_pass {
    VkRenderPass render_pass;
    VkDescriptorSetLayout set_layout; // SIM_PASS_FUSED images, then their struct sim_shape
    VkPipelineLayout layout;
    VkShaderModule vert, frag, frag_cube;
    struct {
        struct sim_pass_key key;
        VkPipeline pipeline;
    } made[SIM_PASS_PIPELINES]; // when first needed
    uint32_t made_count;
    VkSampler linear, nearest; // nearest: for formats that cannot be filtered
    VkSampler linear_around;   // the image's right side joins its left one
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

// Drops all pipelines if fewer than this many more would find a place. Waits for the queue then.
void sim_pass_make_room(const struct ap_gpu *gpu, struct sim_pass *pass, uint32_t more);

// Makes the pipeline that this draw needs, if it is the first to need it.
enum ap_status sim_pass_prepare(struct ap_error *err, const struct ap_gpu *gpu,
                                struct sim_pass *pass, const struct sim_pass_key *key);

// One draw onto a part of the target, within these bounds of it. set holds the images, in
// SHADER_READ_ONLY_OPTIMAL or GENERAL, and the shapes. The key is prepared.
void sim_pass_draw(VkCommandBuffer cmd, const struct sim_pass *pass, VkRect2D part,
                   const struct sim_pass_key *key, const double from_uv[2], const double to_uv[2],
                   VkDescriptorSet set);

#endif
