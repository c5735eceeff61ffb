#include "sim_hmd/compositor_pass.h"

#include <math.h>
#include <string.h>

#include "shaders/composite.frag.spv.h"
#include "shaders/composite.vert.spv.h"

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
    VkPushConstantRange push = {VK_SHADER_STAGE_FRAGMENT_BIT, 0, sizeof(struct sim_pass_push)};
    VkPipelineLayoutCreateInfo info = {.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
                                       .setLayoutCount = 1,
                                       .pSetLayouts = &pass->set_layout,
                                       .pushConstantRangeCount = 1,
                                       .pPushConstantRanges = &push};
    return ap_vk_check(err, vkCreatePipelineLayout(gpu->device, &info, NULL, &pass->layout),
                       "vkCreatePipelineLayout");
}

static enum ap_status create_pipeline(struct ap_error *err, const struct ap_gpu *gpu,
                                      VkShaderModule vert, VkShaderModule frag,
                                      struct sim_pass *pass) {
    VkPipelineShaderStageCreateInfo stages[2] = {
        {.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
         .stage = VK_SHADER_STAGE_VERTEX_BIT,
         .module = vert,
         .pName = "main"},
        {.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
         .stage = VK_SHADER_STAGE_FRAGMENT_BIT,
         .module = frag,
         .pName = "main"}};
    VkPipelineVertexInputStateCreateInfo input = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO};
    VkPipelineInputAssemblyStateCreateInfo assembly = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO,
        .topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST};
    VkPipelineViewportStateCreateInfo viewport = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO,
        .viewportCount = 1,
        .scissorCount = 1};
    VkPipelineRasterizationStateCreateInfo raster = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO, .lineWidth = 1};
    VkPipelineMultisampleStateCreateInfo samples = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO,
        .rasterizationSamples = VK_SAMPLE_COUNT_1_BIT};
    VkPipelineColorBlendAttachmentState over = {
        .blendEnable = VK_TRUE,
        .srcColorBlendFactor = VK_BLEND_FACTOR_ONE,
        .dstColorBlendFactor = VK_BLEND_FACTOR_ONE_MINUS_SRC_ALPHA,
        .srcAlphaBlendFactor = VK_BLEND_FACTOR_ONE,
        .dstAlphaBlendFactor = VK_BLEND_FACTOR_ONE_MINUS_SRC_ALPHA,
        .colorWriteMask = VK_COLOR_COMPONENT_R_BIT | VK_COLOR_COMPONENT_G_BIT |
                          VK_COLOR_COMPONENT_B_BIT | VK_COLOR_COMPONENT_A_BIT};
    VkPipelineColorBlendStateCreateInfo blend = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO,
        .attachmentCount = 1,
        .pAttachments = &over};
    VkDynamicState states[2] = {VK_DYNAMIC_STATE_VIEWPORT, VK_DYNAMIC_STATE_SCISSOR};
    VkPipelineDynamicStateCreateInfo dynamic = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_DYNAMIC_STATE_CREATE_INFO,
        .dynamicStateCount = 2,
        .pDynamicStates = states};
    VkGraphicsPipelineCreateInfo info = {.sType = VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO,
                                         .stageCount = 2,
                                         .pStages = stages,
                                         .pVertexInputState = &input,
                                         .pInputAssemblyState = &assembly,
                                         .pViewportState = &viewport,
                                         .pRasterizationState = &raster,
                                         .pMultisampleState = &samples,
                                         .pColorBlendState = &blend,
                                         .pDynamicState = &dynamic,
                                         .layout = pass->layout,
                                         .renderPass = pass->render_pass};
    return ap_vk_check(
        err,
        vkCreateGraphicsPipelines(gpu->device, VK_NULL_HANDLE, 1, &info, NULL, &pass->pipeline),
        "vkCreateGraphicsPipelines");
}

enum ap_status sim_pass_create(struct ap_error *err, const struct ap_gpu *gpu,
                               struct sim_pass *pass) {
    struct sim_pass made = {0};
    VkShaderModule vert = VK_NULL_HANDLE, frag = VK_NULL_HANDLE;
    enum ap_status st = create_render_pass(err, gpu, &made);
    if (!st)
        st = create_layouts(err, gpu, &made);
    if (!st)
        st = create_sampler(err, gpu, VK_FILTER_LINEAR, &made.linear);
    if (!st)
        st = create_sampler(err, gpu, VK_FILTER_NEAREST, &made.nearest);
    if (!st)
        st = ap_gpu_shader(err, gpu, composite_vert, sizeof composite_vert, &vert);
    if (!st)
        st = ap_gpu_shader(err, gpu, composite_frag, sizeof composite_frag, &frag);
    if (!st)
        st = create_pipeline(err, gpu, vert, frag, &made);
    vkDestroyShaderModule(gpu->device, vert, NULL);
    vkDestroyShaderModule(gpu->device, frag, NULL);
    if (st)
        sim_pass_destroy(gpu, &made);
    else
        *pass = made;
    return st;
}

void sim_pass_destroy(const struct ap_gpu *gpu, struct sim_pass *pass) {
    vkDestroyPipeline(gpu->device, pass->pipeline, NULL);
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
    vkCmdBindPipeline(cmd, VK_PIPELINE_BIND_POINT_GRAPHICS, pass->pipeline);
}

void sim_pass_end(VkCommandBuffer cmd) {
    vkCmdEndRenderPass(cmd);
}

static void tangents(const XrFovf *fov, float t[4]) {
    t[0] = (float)tan(fov->angleLeft);
    t[1] = (float)tan(fov->angleRight);
    t[2] = (float)tan(fov->angleUp);
    t[3] = (float)tan(fov->angleDown);
}

struct sim_pass_push sim_pass_push_of(const struct sim_frame *frame, int eye,
                                      const struct sim_layer *layer) {
    const struct sim_layer_view *view = &layer->view[eye];
    struct sim_pass_push push = {.rect = {(float)view->rect.offset.x, (float)view->rect.offset.y,
                                          (float)view->rect.extent.width,
                                          (float)view->rect.extent.height},
                                 .size = {(float)view->width_px, (float)view->height_px},
                                 .alpha = !layer->blend_alpha      ? 0
                                          : layer->unpremultiplied ? 2
                                                                   : 1};
    // In the identity no rounding of the product's shall move the picture.
    struct ap_quat q = view->at_display
                           ? AP_QUAT_IDENTITY
                           : ap_quat_mul(ap_quat_conj(ap_quat_normalize(view->stage_from_view.q)),
                                         ap_quat_normalize(frame->stage_from_eye[eye].q));
    const struct ap_vec3 axis[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    for (int c = 0; c < 3; c++) {
        struct ap_vec3 v = ap_quat_rotate(q, axis[c]);
        push.turn[0][c] = (float)v.x;
        push.turn[1][c] = (float)v.y;
        push.turn[2][c] = (float)v.z;
    }
    tangents(&frame->fov[eye], push.eye_tan);
    tangents(&view->fov, push.layer_tan);
    return push;
}

void sim_pass_draw(VkCommandBuffer cmd, const struct sim_pass *pass, VkRect2D part,
                   const struct sim_frame *frame, int eye, const struct sim_layer *layer,
                   VkDescriptorSet set) {
    VkViewport viewport = {(float)part.offset.x,
                           (float)part.offset.y,
                           (float)part.extent.width,
                           (float)part.extent.height,
                           0,
                           1};
    struct sim_pass_push push = sim_pass_push_of(frame, eye, layer);
    vkCmdSetViewport(cmd, 0, 1, &viewport);
    vkCmdSetScissor(cmd, 0, 1, &part);
    vkCmdBindDescriptorSets(cmd, VK_PIPELINE_BIND_POINT_GRAPHICS, pass->layout, 0, 1, &set, 0,
                            NULL);
    vkCmdPushConstants(cmd, pass->layout, VK_SHADER_STAGE_FRAGMENT_BIT, 0, sizeof push, &push);
    vkCmdDraw(cmd, 3, 1, 0, 0);
}
