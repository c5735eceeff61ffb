#include "sim_hmd/compositor_pass.h"

#include <math.h>
#include <stddef.h>

#include "shaders/composite.frag.spv.h"
#include "shaders/composite.vert.spv.h"
#include "shaders/composite_cube.frag.spv.h"

static const VkFormat TARGET_FORMAT = VK_FORMAT_R8G8B8A8_SRGB;
static const VkShaderStageFlags PUSH_STAGES =
    VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT;

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
                                     VkFilter filter, VkSampler *sampler) {
    VkSamplerCreateInfo info = {.sType = VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO,
                                .magFilter = filter,
                                .minFilter = filter,
                                .addressModeU = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE,
                                .addressModeV = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE,
                                .addressModeW = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE};
    return ap_vk_check(err, vkCreateSampler(gpu->device, &info, NULL, sampler), "vkCreateSampler");
}

static enum ap_status create_layouts(struct ap_error *err, const struct ap_gpu *gpu,
                                     struct sim_pass *pass) {
    VkDescriptorSetLayoutBinding binding = {.binding = 0,
                                            .descriptorType =
                                                VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER,
                                            .descriptorCount = 1,
                                            .stageFlags = VK_SHADER_STAGE_FRAGMENT_BIT};
    VkDescriptorSetLayoutCreateInfo sets = {.sType =
                                                VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO,
                                            .bindingCount = 1,
                                            .pBindings = &binding};
    enum ap_status st =
        ap_vk_check(err, vkCreateDescriptorSetLayout(gpu->device, &sets, NULL, &pass->set_layout),
                    "vkCreateDescriptorSetLayout");
    if (st)
        return st;
    VkPushConstantRange push = {PUSH_STAGES, 0, sizeof(struct sim_pass_push)};
    VkPipelineLayoutCreateInfo info = {.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
                                       .setLayoutCount = 1,
                                       .pSetLayouts = &pass->set_layout,
                                       .pushConstantRangeCount = 1,
                                       .pPushConstantRanges = &push};
    return ap_vk_check(err, vkCreatePipelineLayout(gpu->device, &info, NULL, &pass->layout),
                       "vkCreatePipelineLayout");
}

// What the stages of a way of drawing are told: shaders/composite.frag's constants.
struct constants {
    uint32_t kind, alpha, edges;
};
static const VkSpecializationMapEntry constant_entries[3] = {
    {0, offsetof(struct constants, kind), 4},
    {1, offsetof(struct constants, alpha), 4},
    {2, offsetof(struct constants, edges), 4}};

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

static VkPipelineColorBlendAttachmentState blending(struct sim_pass_way way) {
    return (VkPipelineColorBlendAttachmentState){
        .blendEnable = way.alpha == SIM_PASS_PREMULTIPLIED || way.alpha == SIM_PASS_UNPREMULTIPLIED,
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
                                      const struct sim_pass *pass, struct sim_pass_way way,
                                      VkPipeline *pipeline) {
    struct constants constants = {way.surface, way.alpha, way.edges};
    VkSpecializationInfo special = {3, constant_entries, sizeof constants, &constants};
    VkShaderModule frag = way.surface == SIM_PASS_CUBE ? pass->frag_cube : pass->frag;
    VkPipelineShaderStageCreateInfo stages[2] = {
        stage(VK_SHADER_STAGE_VERTEX_BIT, pass->vert, NULL),
        stage(VK_SHADER_STAGE_FRAGMENT_BIT, frag, &special)};
    VkPipelineColorBlendAttachmentState over = blending(way);
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
        st = create_sampler(err, gpu, VK_FILTER_LINEAR, &made.linear);
    if (!st)
        st = create_sampler(err, gpu, VK_FILTER_NEAREST, &made.nearest);
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

void sim_pass_destroy(const struct ap_gpu *gpu, struct sim_pass *pass) {
    for (int k = 0; k < SIM_PASS_SURFACES * SIM_PASS_ALPHAS * 2; k++)
        vkDestroyPipeline(gpu->device, pass->pipelines[k / 8][k / 2 % 4][k % 2], NULL);
    vkDestroyShaderModule(gpu->device, pass->vert, NULL);
    vkDestroyShaderModule(gpu->device, pass->frag, NULL);
    vkDestroyShaderModule(gpu->device, pass->frag_cube, NULL);
    vkDestroyPipelineLayout(gpu->device, pass->layout, NULL);
    vkDestroyDescriptorSetLayout(gpu->device, pass->set_layout, NULL);
    vkDestroySampler(gpu->device, pass->linear, NULL);
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

// The pixels of the part that the layer's bounds touch.
static VkRect2D scissor_of(VkRect2D part, const struct sim_seen *seen) {
    const double width = part.extent.width, height = part.extent.height;
    int32_t left = (int32_t)floor(seen->from_uv[0] * width) - 1;
    int32_t top = (int32_t)floor(seen->from_uv[1] * height) - 1;
    int32_t right = (int32_t)ceil(seen->to_uv[0] * width) + 1;
    int32_t bottom = (int32_t)ceil(seen->to_uv[1] * height) + 1;
    left = left < 0 ? 0 : left;
    top = top < 0 ? 0 : top;
    right = right > (int32_t)part.extent.width ? (int32_t)part.extent.width : right;
    bottom = bottom > (int32_t)part.extent.height ? (int32_t)part.extent.height : bottom;
    return (VkRect2D){{part.offset.x + left, part.offset.y + top},
                      {(uint32_t)(right - left), (uint32_t)(bottom - top)}};
}

enum ap_status sim_pass_prepare(struct ap_error *err, const struct ap_gpu *gpu,
                                struct sim_pass *pass, struct sim_pass_way way) {
    VkPipeline *pipeline = &pass->pipelines[way.surface][way.alpha][way.edges];
    return *pipeline ? AP_OK : create_pipeline(err, gpu, pass, way, pipeline);
}

void sim_pass_draw(VkCommandBuffer cmd, const struct sim_pass *pass, VkRect2D part,
                   struct sim_pass_way way, const struct sim_seen *seen, VkDescriptorSet set) {
    VkViewport viewport = {(float)part.offset.x,
                           (float)part.offset.y,
                           (float)part.extent.width,
                           (float)part.extent.height,
                           0,
                           1};
    VkRect2D scissor = scissor_of(part, seen);
    vkCmdBindPipeline(cmd, VK_PIPELINE_BIND_POINT_GRAPHICS,
                      pass->pipelines[way.surface][way.alpha][way.edges]);
    vkCmdSetViewport(cmd, 0, 1, &viewport);
    vkCmdSetScissor(cmd, 0, 1, &scissor);
    vkCmdBindDescriptorSets(cmd, VK_PIPELINE_BIND_POINT_GRAPHICS, pass->layout, 0, 1, &set, 0,
                            NULL);
    vkCmdPushConstants(cmd, pass->layout, PUSH_STAGES, 0, sizeof seen->push, &seen->push);
    vkCmdDraw(cmd, 3, 1, 0, 0);
}
