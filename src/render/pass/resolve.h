#ifndef ANTIPODE_RENDER_PASS_RESOLVE_H
#define ANTIPODE_RENDER_PASS_RESOLVE_H

#include "src/gpu/gpu.h"

// From a multisampled image to one layer of a target, in linear light, by a draw of its own: so
// that it is the same on every device. (Mesa 22.3.6's lavapipe resolves into layer 0 whichever
// layer the attachment names.)
struct ap_resolve {
    VkRenderPass render_pass;
    VkDescriptorSetLayout set_layout;
    VkPipelineLayout layout;
    VkPipeline pipeline;
    VkSampler sampler;
    VkDescriptorPool descriptors;
    VkDescriptorSet set[2]; // by what is read: the image of one eye, or of both
    uint32_t width, height;
    int32_t samples, across;
    bool coded;
};

struct ap_resolve_params {
    VkFormat color_format;
    uint32_t width, height; // of the target
    int32_t samples,
        across; // of a pixel that is read; such pixels to each side of one of the target's
    bool coded; // what is read are sRGB codes, as R32_UINT
};
enum ap_status ap_resolve_create(struct ap_error *err, const struct ap_gpu *gpu,
                                 const struct ap_resolve_params *params,
                                 struct ap_resolve *resolve);
void ap_resolve_destroy(const struct ap_gpu *gpu, struct ap_resolve *resolve);

// What set[which] reads; while no frame that uses it is on its way.
void ap_resolve_read(const struct ap_gpu *gpu, const struct ap_resolve *resolve, int which,
                     VkImageView multisampled);

// Resolves layer `layer` of what set[which] reads into the framebuffer, whose attachment is left in
// COLOR_ATTACHMENT_OPTIMAL.
void ap_resolve_record(const struct ap_resolve *resolve, VkCommandBuffer cmd, int which,
                       int32_t layer, VkFramebuffer framebuffer);

// Of an eye that is shut: black, and nothing is read.
void ap_resolve_blacken(const struct ap_resolve *resolve, VkCommandBuffer cmd,
                        VkFramebuffer framebuffer);

#endif
