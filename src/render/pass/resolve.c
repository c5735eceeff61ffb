#include "src/render/pass/resolve.h"

#include <string.h>

#include "shaders/resolve.frag.spv.h"
#include "shaders/resolve.vert.spv.h"
#include "shaders/resolve_coded.frag.spv.h"
#include "shaders/resolve_one.frag.spv.h"
#include "src/render/pass/pipeline.h"

struct push {
    int32_t layer;
};

static enum ap_status create_render_pass(struct ap_error *err, const struct ap_gpu *gpu,
                                         VkFormat format, VkRenderPass *made) {
    VkAttachmentDescription target = {.format = format,
                                      .samples = VK_SAMPLE_COUNT_1_BIT,
                                      .loadOp = VK_ATTACHMENT_LOAD_OP_DONT_CARE,
                                      .storeOp = VK_ATTACHMENT_STORE_OP_STORE,
                                      .stencilLoadOp = VK_ATTACHMENT_LOAD_OP_DONT_CARE,
                                      .stencilStoreOp = VK_ATTACHMENT_STORE_OP_DONT_CARE,
                                      .initialLayout = VK_IMAGE_LAYOUT_UNDEFINED,
                                      .finalLayout = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL};
    VkAttachmentReference color = {0, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL};
    VkSubpassDescription subpass = {.pipelineBindPoint = VK_PIPELINE_BIND_POINT_GRAPHICS,
                                    .colorAttachmentCount = 1,
                                    .pColorAttachments = &color};
    // Whoever had the target last may have read it, and may read it next.
    VkSubpassDependency dependencies[2] = {
        {.srcSubpass = VK_SUBPASS_EXTERNAL,
         .dstSubpass = 0,
         .srcStageMask = VK_PIPELINE_STAGE_ALL_COMMANDS_BIT,
         .dstStageMask = VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT,
         .srcAccessMask = VK_ACCESS_MEMORY_WRITE_BIT,
         .dstAccessMask = VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT},
        {.srcSubpass = 0,
         .dstSubpass = VK_SUBPASS_EXTERNAL,
         .srcStageMask = VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT,
         .dstStageMask = VK_PIPELINE_STAGE_ALL_COMMANDS_BIT,
         .srcAccessMask = VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT,
         .dstAccessMask = VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_MEMORY_WRITE_BIT}};
    VkRenderPassCreateInfo info = {.sType = VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO,
                                   .attachmentCount = 1,
                                   .pAttachments = &target,
                                   .subpassCount = 1,
                                   .pSubpasses = &subpass,
                                   .dependencyCount = 2,
                                   .pDependencies = dependencies};
    return ap_vk_check(err, vkCreateRenderPass(gpu->device, &info, NULL, made),
                       "vkCreateRenderPass");
}

static enum ap_status create_layouts(struct ap_error *err, const struct ap_gpu *gpu,
                                     struct ap_resolve *r) {
    VkSamplerCreateInfo sampler = {.sType = VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO,
                                   .addressModeU = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE,
                                   .addressModeV = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE,
                                   .addressModeW = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE};
    enum ap_status st = ap_vk_check(err, vkCreateSampler(gpu->device, &sampler, NULL, &r->sampler),
                                    "vkCreateSampler");
    if (st != AP_OK)
        return st;
    VkDescriptorSetLayoutBinding binding = {0, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 1,
                                            VK_SHADER_STAGE_FRAGMENT_BIT, NULL};
    VkDescriptorSetLayoutCreateInfo set = {.sType =
                                               VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO,
                                           .bindingCount = 1,
                                           .pBindings = &binding};
    st = ap_vk_check(err, vkCreateDescriptorSetLayout(gpu->device, &set, NULL, &r->set_layout),
                     "vkCreateDescriptorSetLayout");
    if (st != AP_OK)
        return st;
    VkPushConstantRange push = {VK_SHADER_STAGE_FRAGMENT_BIT, 0, sizeof(struct push)};
    VkPipelineLayoutCreateInfo layout = {.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
                                         .setLayoutCount = 1,
                                         .pSetLayouts = &r->set_layout,
                                         .pushConstantRangeCount = 1,
                                         .pPushConstantRanges = &push};
    return ap_vk_check(err, vkCreatePipelineLayout(gpu->device, &layout, NULL, &r->layout),
                       "vkCreatePipelineLayout");
}

static enum ap_status create_sets(struct ap_error *err, const struct ap_gpu *gpu,
                                  struct ap_resolve *r) {
    VkDescriptorPoolSize size = {VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 2};
    VkDescriptorPoolCreateInfo pool = {.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO,
                                       .maxSets = 2,
                                       .poolSizeCount = 1,
                                       .pPoolSizes = &size};
    enum ap_status st =
        ap_vk_check(err, vkCreateDescriptorPool(gpu->device, &pool, NULL, &r->descriptors),
                    "vkCreateDescriptorPool");
    if (st != AP_OK)
        return st;
    VkDescriptorSetLayout layouts[2] = {r->set_layout, r->set_layout};
    VkDescriptorSetAllocateInfo info = {.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO,
                                        .descriptorPool = r->descriptors,
                                        .descriptorSetCount = 2,
                                        .pSetLayouts = layouts};
    return ap_vk_check(err, vkAllocateDescriptorSets(gpu->device, &info, r->set),
                       "vkAllocateDescriptorSets");
}

static enum ap_status create_pipeline(struct ap_error *err, const struct ap_gpu *gpu,
                                      struct ap_resolve *r) {
    VkShaderModule vertex = VK_NULL_HANDLE, fragment = VK_NULL_HANDLE;
    enum ap_status st = ap_gpu_shader(err, gpu, resolve_vert, sizeof resolve_vert, &vertex);
    bool one = r->samples == 1;
    if (st == AP_OK)
        st = r->coded
                 ? ap_gpu_shader(err, gpu, resolve_coded_frag, sizeof resolve_coded_frag, &fragment)
                 : ap_gpu_shader(err, gpu, one ? resolve_one_frag : resolve_frag,
                                 one ? sizeof resolve_one_frag : sizeof resolve_frag, &fragment);
    if (st == AP_OK) {
        struct ap_pipeline_params params = {.vertex = vertex,
                                            .fragment = fragment,
                                            .constant = {r->samples + 256 * r->across},
                                            .width = r->width,
                                            .height = r->height,
                                            .samples = VK_SAMPLE_COUNT_1_BIT,
                                            .cull = VK_CULL_MODE_NONE,
                                            .layout = r->layout,
                                            .render_pass = r->render_pass};
        st = ap_pipeline_create(err, gpu, &params, &r->pipeline);
    }
    vkDestroyShaderModule(gpu->device, vertex, NULL);
    vkDestroyShaderModule(gpu->device, fragment, NULL);
    return st;
}

enum ap_status ap_resolve_create(struct ap_error *err, const struct ap_gpu *gpu,
                                 const struct ap_resolve_params *params,
                                 struct ap_resolve *resolve) {
    struct ap_resolve made = {.width = params->width,
                              .height = params->height,
                              .samples = params->samples,
                              .across = params->across,
                              .coded = params->coded};
    enum ap_status st = create_render_pass(err, gpu, params->color_format, &made.render_pass);
    if (st == AP_OK)
        st = create_layouts(err, gpu, &made);
    if (st == AP_OK)
        st = create_sets(err, gpu, &made);
    if (st == AP_OK)
        st = create_pipeline(err, gpu, &made);
    if (st == AP_OK)
        *resolve = made;
    else
        ap_resolve_destroy(gpu, &made);
    return st;
}

void ap_resolve_destroy(const struct ap_gpu *gpu, struct ap_resolve *r) {
    vkDestroyPipeline(gpu->device, r->pipeline, NULL);
    vkDestroyDescriptorPool(gpu->device, r->descriptors, NULL);
    vkDestroyPipelineLayout(gpu->device, r->layout, NULL);
    vkDestroyDescriptorSetLayout(gpu->device, r->set_layout, NULL);
    vkDestroySampler(gpu->device, r->sampler, NULL);
    vkDestroyRenderPass(gpu->device, r->render_pass, NULL);
    memset(r, 0, sizeof *r);
}

void ap_resolve_read(const struct ap_gpu *gpu, const struct ap_resolve *resolve, int which,
                     VkImageView multisampled) {
    VkDescriptorImageInfo image = {resolve->sampler, multisampled,
                                   VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
    VkWriteDescriptorSet write = {.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                  .dstSet = resolve->set[which],
                                  .descriptorCount = 1,
                                  .descriptorType = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER,
                                  .pImageInfo = &image};
    vkUpdateDescriptorSets(gpu->device, 1, &write, 0, NULL);
}

static void begin_pass(const struct ap_resolve *resolve, VkCommandBuffer cmd,
                       VkFramebuffer framebuffer) {
    VkRenderPassBeginInfo begin = {.sType = VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO,
                                   .renderPass = resolve->render_pass,
                                   .framebuffer = framebuffer,
                                   .renderArea = {{0, 0}, {resolve->width, resolve->height}}};
    vkCmdBeginRenderPass(cmd, &begin, VK_SUBPASS_CONTENTS_INLINE);
}

void ap_resolve_blacken(const struct ap_resolve *resolve, VkCommandBuffer cmd,
                        VkFramebuffer framebuffer) {
    static const VkClearAttachment black = {.aspectMask = VK_IMAGE_ASPECT_COLOR_BIT,
                                            .clearValue.color.float32 = {0, 0, 0, 1}};
    VkClearRect all = {.rect.extent = {resolve->width, resolve->height}, .layerCount = 1};
    begin_pass(resolve, cmd, framebuffer);
    vkCmdClearAttachments(cmd, 1, &black, 1, &all);
    vkCmdEndRenderPass(cmd);
}

void ap_resolve_record(const struct ap_resolve *resolve, VkCommandBuffer cmd, int which,
                       int32_t layer, VkFramebuffer framebuffer) {
    struct push push = {layer};
    begin_pass(resolve, cmd, framebuffer);
    vkCmdBindPipeline(cmd, VK_PIPELINE_BIND_POINT_GRAPHICS, resolve->pipeline);
    vkCmdBindDescriptorSets(cmd, VK_PIPELINE_BIND_POINT_GRAPHICS, resolve->layout, 0, 1,
                            &resolve->set[which], 0, NULL);
    vkCmdPushConstants(cmd, resolve->layout, VK_SHADER_STAGE_FRAGMENT_BIT, 0, sizeof push, &push);
    vkCmdDraw(cmd, 3, 1, 0, 0);
    vkCmdEndRenderPass(cmd);
}
