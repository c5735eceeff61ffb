#include "sim_hmd/compose/pass.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

#include "shaders/composite.frag.spv.h"
#include "shaders/composite.vert.spv.h"
#include "shaders/composite_cube.frag.spv.h"

static const VkFormat TARGET_FORMAT = VK_FORMAT_R8G8B8A8_SRGB;

static enum ap_status create_render_pass(struct ap_error *err, const struct ap_gpu *gpu,
                                         struct sim_pass *pass) {
    VkAttachmentDescription color = {.format = TARGET_FORMAT,
                                     .samples = VK_SAMPLE_COUNT_1_BIT,
                                     .loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR,
                                     .storeOp = VK_ATTACHMENT_STORE_OP_STORE,
                                     .stencilLoadOp = VK_ATTACHMENT_LOAD_OP_DONT_CARE,
                                     .stencilStoreOp = VK_ATTACHMENT_STORE_OP_DONT_CARE,
                                     .initialLayout = VK_IMAGE_LAYOUT_UNDEFINED,
                                     .finalLayout = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL};
    VkAttachmentReference ref = {0, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL};
    VkSubpassDescription subpass = {.pipelineBindPoint = VK_PIPELINE_BIND_POINT_GRAPHICS,
                                    .colorAttachmentCount = 1,
                                    .pColorAttachments = &ref};
    // The copies out of the target come after this frame's pass and before the next one's.
    VkSubpassDependency dependencies[2] = {
        {.srcSubpass = VK_SUBPASS_EXTERNAL,
         .dstSubpass = 0,
         .srcStageMask = VK_PIPELINE_STAGE_TRANSFER_BIT,
         .dstStageMask = VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT,
         .srcAccessMask = VK_ACCESS_TRANSFER_READ_BIT,
         .dstAccessMask =
             VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT | VK_ACCESS_COLOR_ATTACHMENT_READ_BIT},
        {.srcSubpass = 0,
         .dstSubpass = VK_SUBPASS_EXTERNAL,
         .srcStageMask = VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT,
         .dstStageMask = VK_PIPELINE_STAGE_TRANSFER_BIT,
         .srcAccessMask = VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT,
         .dstAccessMask = VK_ACCESS_TRANSFER_READ_BIT}};
    VkRenderPassCreateInfo info = {.sType = VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO,
                                   .attachmentCount = 1,
                                   .pAttachments = &color,
                                   .subpassCount = 1,
                                   .pSubpasses = &subpass,
                                   .dependencyCount = 2,
                                   .pDependencies = dependencies};
    return ap_vk_check(err, vkCreateRenderPass(gpu->device, &info, NULL, &pass->render_pass),
                       "vkCreateRenderPass");
}

static enum ap_status create_sampler(struct ap_error *err, const struct ap_gpu *gpu,
                                     VkFilter filter, VkSamplerAddressMode across,
                                     VkSampler *sampler) {
    VkSamplerCreateInfo info = {.sType = VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO,
                                .magFilter = filter,
                                .minFilter = filter,
                                .mipmapMode = filter == VK_FILTER_LINEAR
                                                  ? VK_SAMPLER_MIPMAP_MODE_LINEAR
                                                  : VK_SAMPLER_MIPMAP_MODE_NEAREST,
                                .maxLod = VK_LOD_CLAMP_NONE,
                                .addressModeU = across,
                                .addressModeV = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE,
                                .addressModeW = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE};
    return ap_vk_check(err, vkCreateSampler(gpu->device, &info, NULL, sampler), "vkCreateSampler");
}

static enum ap_status create_layouts(struct ap_error *err, const struct ap_gpu *gpu,
                                     struct sim_pass *pass) {
    VkDescriptorSetLayoutBinding bindings[SIM_PASS_FUSED + 1];
    for (uint32_t k = 0; k < SIM_PASS_FUSED; k++)
        bindings[k] = (VkDescriptorSetLayoutBinding){.binding = k,
                                                     .descriptorType =
                                                         VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER,
                                                     .descriptorCount = 1,
                                                     .stageFlags = VK_SHADER_STAGE_FRAGMENT_BIT};
    bindings[SIM_PASS_FUSED] = (VkDescriptorSetLayoutBinding){
        .binding = SIM_PASS_FUSED,
        .descriptorType = VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER,
        .descriptorCount = 1,
        .stageFlags = VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT};
    VkDescriptorSetLayoutCreateInfo sets = {.sType =
                                                VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO,
                                            .bindingCount = SIM_PASS_FUSED + 1,
                                            .pBindings = bindings};
    enum ap_status st =
        ap_vk_check(err, vkCreateDescriptorSetLayout(gpu->device, &sets, NULL, &pass->set_layout),
                    "vkCreateDescriptorSetLayout");
    if (st)
        return st;
    VkPipelineLayoutCreateInfo info = {.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
                                       .setLayoutCount = 1,
                                       .pSetLayouts = &pass->set_layout};
    return ap_vk_check(err, vkCreatePipelineLayout(gpu->device, &info, NULL, &pass->layout),
                       "vkCreatePipelineLayout");
}

// A key's words are the shaders' constants, in this order.
#define CONSTANT(id, member)                                                                       \
    { id, offsetof(struct sim_pass_key, member), sizeof(uint32_t) }
static const VkSpecializationMapEntry constants[] = {CONSTANT(0, count),   CONSTANT(1, ways[0]),
                                                     CONSTANT(2, ways[1]), CONSTANT(3, ways[2]),
                                                     CONSTANT(4, ways[3]), CONSTANT(5, first)};
enum { CONSTANT_COUNT = sizeof constants / sizeof *constants };

// What all ways of drawing have in common.
static const VkPipelineVertexInputStateCreateInfo no_input = {
    .sType = VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO};
static const VkPipelineInputAssemblyStateCreateInfo triangles = {
    .sType = VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO,
    .topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST};
static const VkPipelineViewportStateCreateInfo one_viewport = {
    .sType = VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO,
    .viewportCount = 1,
    .scissorCount = 1};
static const VkPipelineRasterizationStateCreateInfo raster = {
    .sType = VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO, .lineWidth = 1};
static const VkPipelineMultisampleStateCreateInfo one_sample = {
    .sType = VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO,
    .rasterizationSamples = VK_SAMPLE_COUNT_1_BIT};
static const VkDynamicState dynamic_states[2] = {VK_DYNAMIC_STATE_VIEWPORT,
                                                 VK_DYNAMIC_STATE_SCISSOR};
static const VkPipelineDynamicStateCreateInfo dynamic = {
    .sType = VK_STRUCTURE_TYPE_PIPELINE_DYNAMIC_STATE_CREATE_INFO,
    .dynamicStateCount = 2,
    .pDynamicStates = dynamic_states};

static VkPipelineColorBlendAttachmentState blending(const struct sim_pass_key *key) {
    bool opaque = key->count == 1 && !(key->ways[0] & SIM_WAY_BLENDED);
    return (VkPipelineColorBlendAttachmentState){
        .blendEnable = !key->first && !opaque,
        .srcColorBlendFactor = VK_BLEND_FACTOR_ONE,
        .dstColorBlendFactor = VK_BLEND_FACTOR_ONE_MINUS_SRC_ALPHA,
        .srcAlphaBlendFactor = VK_BLEND_FACTOR_ONE,
        .dstAlphaBlendFactor = VK_BLEND_FACTOR_ONE_MINUS_SRC_ALPHA,
        .colorWriteMask = VK_COLOR_COMPONENT_R_BIT | VK_COLOR_COMPONENT_G_BIT |
                          VK_COLOR_COMPONENT_B_BIT | VK_COLOR_COMPONENT_A_BIT};
}

static VkPipelineShaderStageCreateInfo stage(VkShaderStageFlagBits bit, VkShaderModule module,
                                             const VkSpecializationInfo *special) {
    return (VkPipelineShaderStageCreateInfo){
        .sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
        .stage = bit,
        .module = module,
        .pName = "main",
        .pSpecializationInfo = special};
}

static enum ap_status create_pipeline(struct ap_error *err, const struct ap_gpu *gpu,
                                      const struct sim_pass *pass, const struct sim_pass_key *key,
                                      VkPipeline *pipeline) {
    VkSpecializationInfo special = {CONSTANT_COUNT, constants, sizeof *key, key};
    VkShaderModule frag = key->ways[0] & SIM_WAY_CUBE ? pass->frag_cube : pass->frag;
    VkPipelineShaderStageCreateInfo stages[2] = {
        stage(VK_SHADER_STAGE_VERTEX_BIT, pass->vert, &special),
        stage(VK_SHADER_STAGE_FRAGMENT_BIT, frag, &special)};
    VkPipelineColorBlendAttachmentState over = blending(key);
    VkPipelineColorBlendStateCreateInfo blend = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO,
        .attachmentCount = 1,
        .pAttachments = &over};
    VkGraphicsPipelineCreateInfo info = {.sType = VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO,
                                         .stageCount = 2,
                                         .pStages = stages,
                                         .pVertexInputState = &no_input,
                                         .pInputAssemblyState = &triangles,
                                         .pViewportState = &one_viewport,
                                         .pRasterizationState = &raster,
                                         .pMultisampleState = &one_sample,
                                         .pColorBlendState = &blend,
                                         .pDynamicState = &dynamic,
                                         .layout = pass->layout,
                                         .renderPass = pass->render_pass};
    return ap_vk_check(
        err, vkCreateGraphicsPipelines(gpu->device, VK_NULL_HANDLE, 1, &info, NULL, pipeline),
        "vkCreateGraphicsPipelines");
}

enum ap_status sim_pass_create(struct ap_error *err, const struct ap_gpu *gpu,
                               struct sim_pass *pass) {
    struct sim_pass made = {0};
    enum ap_status st = create_render_pass(err, gpu, &made);
    if (!st)
        st = create_layouts(err, gpu, &made);
    if (!st)
        st = create_sampler(err, gpu, VK_FILTER_LINEAR, VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE,
                            &made.linear);
    if (!st)
        st = create_sampler(err, gpu, VK_FILTER_LINEAR, VK_SAMPLER_ADDRESS_MODE_REPEAT,
                            &made.linear_around);
    if (!st)
        st = create_sampler(err, gpu, VK_FILTER_NEAREST, VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE,
                            &made.nearest);
    if (!st)
        st = ap_gpu_shader(err, gpu, composite_vert, sizeof composite_vert, &made.vert);
    if (!st)
        st = ap_gpu_shader(err, gpu, composite_frag, sizeof composite_frag, &made.frag);
    if (!st)
        st = ap_gpu_shader(err, gpu, composite_cube_frag, sizeof composite_cube_frag,
                           &made.frag_cube);
    if (st)
        sim_pass_destroy(gpu, &made);
    else
        *pass = made;
    return st;
}

static void drop_pipelines(const struct ap_gpu *gpu, struct sim_pass *pass) {
    for (uint32_t k = 0; k < pass->made_count; k++)
        vkDestroyPipeline(gpu->device, pass->made[k].pipeline, NULL);
    pass->made_count = 0;
}

void sim_pass_destroy(const struct ap_gpu *gpu, struct sim_pass *pass) {
    drop_pipelines(gpu, pass);
    vkDestroyShaderModule(gpu->device, pass->vert, NULL);
    vkDestroyShaderModule(gpu->device, pass->frag, NULL);
    vkDestroyShaderModule(gpu->device, pass->frag_cube, NULL);
    vkDestroyPipelineLayout(gpu->device, pass->layout, NULL);
    vkDestroyDescriptorSetLayout(gpu->device, pass->set_layout, NULL);
    vkDestroySampler(gpu->device, pass->linear, NULL);
    vkDestroySampler(gpu->device, pass->linear_around, NULL);
    vkDestroySampler(gpu->device, pass->nearest, NULL);
    vkDestroyRenderPass(gpu->device, pass->render_pass, NULL);
    *pass = (struct sim_pass){0};
}

enum ap_status sim_pass_target_create(struct ap_error *err, const struct ap_gpu *gpu,
                                      const struct sim_pass *pass, uint32_t width_px,
                                      uint32_t height_px, struct sim_pass_target *target) {
    struct sim_pass_target made = {.width_px = width_px, .height_px = height_px};
    VkImageCreateInfo info = {.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
                              .imageType = VK_IMAGE_TYPE_2D,
                              .format = TARGET_FORMAT,
                              .extent = {width_px, height_px, 1},
                              .mipLevels = 1,
                              .arrayLayers = 1,
                              .samples = VK_SAMPLE_COUNT_1_BIT,
                              .tiling = VK_IMAGE_TILING_OPTIMAL,
                              .usage = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT |
                                       VK_IMAGE_USAGE_TRANSFER_SRC_BIT,
                              .initialLayout = VK_IMAGE_LAYOUT_UNDEFINED};
    enum ap_status st = ap_gpu_image_create(err, gpu, &info, VK_IMAGE_VIEW_TYPE_2D,
                                            VK_IMAGE_ASPECT_COLOR_BIT, &made.image);
    if (st)
        return st;
    VkFramebufferCreateInfo frame = {.sType = VK_STRUCTURE_TYPE_FRAMEBUFFER_CREATE_INFO,
                                     .renderPass = pass->render_pass,
                                     .attachmentCount = 1,
                                     .pAttachments = &made.image.view,
                                     .width = width_px,
                                     .height = height_px,
                                     .layers = 1};
    st = ap_vk_check(err, vkCreateFramebuffer(gpu->device, &frame, NULL, &made.framebuffer),
                     "vkCreateFramebuffer");
    if (st)
        sim_pass_target_destroy(gpu, &made);
    else
        *target = made;
    return st;
}

void sim_pass_target_destroy(const struct ap_gpu *gpu, struct sim_pass_target *target) {
    vkDestroyFramebuffer(gpu->device, target->framebuffer, NULL);
    ap_gpu_image_destroy(gpu, &target->image);
    *target = (struct sim_pass_target){0};
}

void sim_pass_begin(VkCommandBuffer cmd, const struct sim_pass *pass,
                    const struct sim_pass_target *target) {
    VkClearValue black = {.color = {.float32 = {0, 0, 0, 1}}};
    VkRenderPassBeginInfo info = {.sType = VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO,
                                  .renderPass = pass->render_pass,
                                  .framebuffer = target->framebuffer,
                                  .renderArea = {{0, 0}, {target->width_px, target->height_px}},
                                  .clearValueCount = 1,
                                  .pClearValues = &black};
    vkCmdBeginRenderPass(cmd, &info, VK_SUBPASS_CONTENTS_INLINE);
}

void sim_pass_end(VkCommandBuffer cmd) {
    vkCmdEndRenderPass(cmd);
}

// The pixels of the part that the bounds touch.
static VkRect2D scissor_of(VkRect2D part, const double from_uv[2], const double to_uv[2]) {
    const double width = part.extent.width, height = part.extent.height;
    int32_t left = (int32_t)floor(from_uv[0] * width) - 1;
    int32_t top = (int32_t)floor(from_uv[1] * height) - 1;
    int32_t right = (int32_t)ceil(to_uv[0] * width) + 1;
    int32_t bottom = (int32_t)ceil(to_uv[1] * height) + 1;
    left = left < 0 ? 0 : left;
    top = top < 0 ? 0 : top;
    right = right > (int32_t)part.extent.width ? (int32_t)part.extent.width : right;
    bottom = bottom > (int32_t)part.extent.height ? (int32_t)part.extent.height : bottom;
    return (VkRect2D){{part.offset.x + left, part.offset.y + top},
                      {(uint32_t)(right - left), (uint32_t)(bottom - top)}};
}

static VkPipeline find(const struct sim_pass *pass, const struct sim_pass_key *key) {
    for (uint32_t k = 0; k < pass->made_count; k++)
        if (memcmp(&pass->made[k].key, key, sizeof *key) == 0)
            return pass->made[k].pipeline;
    return VK_NULL_HANDLE;
}

void sim_pass_make_room(const struct ap_gpu *gpu, struct sim_pass *pass, uint32_t more) {
    if (pass->made_count + more <= SIM_PASS_PIPELINES)
        return;
    vkQueueWaitIdle(gpu->queue);
    drop_pipelines(gpu, pass);
}

enum ap_status sim_pass_prepare(struct ap_error *err, const struct ap_gpu *gpu,
                                struct sim_pass *pass, const struct sim_pass_key *key) {
    if (find(pass, key))
        return AP_OK;
    pass->made[pass->made_count].key = *key;
    enum ap_status st =
        create_pipeline(err, gpu, pass, key, &pass->made[pass->made_count].pipeline);
    if (!st)
        pass->made_count++;
    return st;
}

void sim_pass_draw(VkCommandBuffer cmd, const struct sim_pass *pass, VkRect2D part,
                   const struct sim_pass_key *key, const double from_uv[2], const double to_uv[2],
                   VkDescriptorSet set) {
    VkViewport viewport = {(float)part.offset.x,
                           (float)part.offset.y,
                           (float)part.extent.width,
                           (float)part.extent.height,
                           0,
                           1};
    VkRect2D scissor = scissor_of(part, from_uv, to_uv);
    vkCmdBindPipeline(cmd, VK_PIPELINE_BIND_POINT_GRAPHICS, find(pass, key));
    vkCmdSetViewport(cmd, 0, 1, &viewport);
    vkCmdSetScissor(cmd, 0, 1, &scissor);
    vkCmdBindDescriptorSets(cmd, VK_PIPELINE_BIND_POINT_GRAPHICS, pass->layout, 0, 1, &set, 0,
                            NULL);
    vkCmdDraw(cmd, 3, 1, 0, 0);
}
