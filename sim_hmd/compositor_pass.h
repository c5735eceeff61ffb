#ifndef ANTIPODE_SIM_HMD_COMPOSITOR_PASS_H
#define ANTIPODE_SIM_HMD_COMPOSITOR_PASS_H

#include "sim_hmd/compositor_shape.h"
#include "sim_hmd/frame.h"

// How one layer is drawn. Each way is a pipeline of its own, so that none pays for another's
// questions.
enum sim_pass_surface { SIM_PASS_PLANE, SIM_PASS_CYLINDER, SIM_PASS_SPHERE, SIM_PASS_CUBE };
enum sim_pass_alpha {
    SIM_PASS_OPAQUE,
    SIM_PASS_PREMULTIPLIED,
    SIM_PASS_UNPREMULTIPLIED,
    SIM_PASS_UNPREMULTIPLIED_FIRST, // nothing but black below: no blending
};
enum { SIM_PASS_SURFACES = 4, SIM_PASS_ALPHAS = 4 };
struct sim_pass_way {
    enum sim_pass_surface surface;
    enum sim_pass_alpha alpha;
    bool edges; // some pixels of its bounds may miss it
};

// The graphics pass that lays layers over one another as a display's eye sees them: bilinear,
// blended in linear light, R8G8B8A8_SRGB.
struct sim_pass {
    VkRenderPass render_pass;
    VkDescriptorSetLayout set_layout;
    VkPipelineLayout layout;
    VkShaderModule vert, frag, frag_cube;
    VkPipeline pipelines[SIM_PASS_SURFACES][SIM_PASS_ALPHAS][2]; // made when first needed
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

// Makes the pipeline that this way of drawing needs, if it is the first to need it.
enum ap_status sim_pass_prepare(struct ap_error *err, const struct ap_gpu *gpu,
                                struct sim_pass *pass, struct sim_pass_way way);

// One layer, as it is seen, onto a part of the target. set holds the view's image, in
// SHADER_READ_ONLY_OPTIMAL or GENERAL. The way is prepared.
void sim_pass_draw(VkCommandBuffer cmd, const struct sim_pass *pass, VkRect2D part,
                   struct sim_pass_way way, const struct sim_seen *seen, VkDescriptorSet set);

#endif
