#ifndef ANTIPODE_RENDER_PASS_PIPELINE_H
#define ANTIPODE_RENDER_PASS_PIPELINE_H

#include "src/gpu/gpu.h"

// A graphics pipeline for triangles, one colour attachment.
struct ap_pipeline_params {
    VkShaderModule vertex, fragment;
    int32_t constant[6]; // of both shaders' constant_id 0 to 5, where they have them
    const VkPipelineVertexInputStateCreateInfo *input; // NULL: no vertex buffers
    uint32_t width, height;
    VkSampleCountFlagBits samples;
    VkCullModeFlags cull;
    bool blend; // over what is there, by alpha
    bool depth; // test and write, reversed: greater is nearer
    VkPipelineLayout layout;
    VkRenderPass render_pass;
};
enum ap_status ap_pipeline_create(struct ap_error *err, const struct ap_gpu *gpu,
                                  const struct ap_pipeline_params *params, VkPipeline *pipeline);

#endif
