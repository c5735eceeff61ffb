#include "src/render/pass/pass.h"

#include <stddef.h>
#include <string.h>

#include "shaders/disc.frag.spv.h"
#include "shaders/disc.vert.spv.h"
#include "shaders/disc_single.vert.spv.h"
#include "shaders/part.frag.spv.h"
#include "shaders/part.vert.spv.h"
#include "shaders/part_exact.frag.spv.h"
#include "shaders/part_finish.frag.spv.h"
#include "shaders/part_finish.vert.spv.h"
#include "shaders/part_guard.frag.spv.h"
#include "shaders/part_guard.vert.spv.h"
#include "shaders/part_matte.frag.spv.h"
#include "shaders/part_single.vert.spv.h"
#include "shaders/part_single_finish.vert.spv.h"
#include "shaders/part_single_guard.vert.spv.h"
#include "src/render/mesh/mesh.h"
#include "src/render/pass/pipeline.h"
#include "src/view/view.h"

static const VkFormat DEPTH_FORMAT = VK_FORMAT_D32_SFLOAT;

static VkAttachmentDescription attachment(VkFormat format, VkSampleCountFlagBits samples,
                                          VkAttachmentStoreOp store, VkImageLayout after) {
    return (VkAttachmentDescription){.format = format,
                                     .samples = samples,
                                     .loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR,
                                     .storeOp = store,
                                     .stencilLoadOp = VK_ATTACHMENT_LOAD_OP_DONT_CARE,
                                     .stencilStoreOp = VK_ATTACHMENT_STORE_OP_DONT_CARE,
                                     .initialLayout = VK_IMAGE_LAYOUT_UNDEFINED,
                                     .finalLayout = after};
}

static enum ap_status create_render_pass(struct ap_error *err, const struct ap_gpu *gpu,
                                         const struct ap_pass_params *params, VkRenderPass *made) {
    VkAttachmentDescription attachments[2] = {
        attachment(params->color_format, params->samples, VK_ATTACHMENT_STORE_OP_STORE,
                   params->straight ? VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL
                                    : VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL),
        attachment(DEPTH_FORMAT, params->samples, VK_ATTACHMENT_STORE_OP_DONT_CARE,
                   VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL)};
    VkAttachmentReference color = {0, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL},
                          depth = {1, VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL};
    VkSubpassDescription subpass = {.pipelineBindPoint = VK_PIPELINE_BIND_POINT_GRAPHICS,
                                    .colorAttachmentCount = 1,
                                    .pColorAttachments = &color,
                                    .pDepthStencilAttachment = &depth};
    // The images are used again by the next pass or frame; a target by whoever it belongs to.
    VkPipelineStageFlags stages = VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT |
                                  VK_PIPELINE_STAGE_EARLY_FRAGMENT_TESTS_BIT |
                                  VK_PIPELINE_STAGE_LATE_FRAGMENT_TESTS_BIT;
    VkAccessFlags access =
        VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT | VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT;
    bool straight = params->straight;
    VkSubpassDependency dependencies[2] = {
        {.srcSubpass = VK_SUBPASS_EXTERNAL,
         .dstSubpass = 0,
         .srcStageMask = straight ? VK_PIPELINE_STAGE_ALL_COMMANDS_BIT
                                  : stages | VK_PIPELINE_STAGE_FRAGMENT_SHADER_BIT,
         .dstStageMask = stages,
         .srcAccessMask = straight ? VK_ACCESS_MEMORY_WRITE_BIT : access,
         .dstAccessMask = access | VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_READ_BIT},
        {.srcSubpass = 0,
         .dstSubpass = VK_SUBPASS_EXTERNAL,
         .srcStageMask = VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT,
         .dstStageMask =
             straight ? VK_PIPELINE_STAGE_ALL_COMMANDS_BIT : VK_PIPELINE_STAGE_FRAGMENT_SHADER_BIT,
         .srcAccessMask = VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT,
         .dstAccessMask = straight ? VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_MEMORY_WRITE_BIT
                                   : VK_ACCESS_SHADER_READ_BIT}};
    uint32_t mask = 3;
    VkRenderPassMultiviewCreateInfo multiview = {
        .sType = VK_STRUCTURE_TYPE_RENDER_PASS_MULTIVIEW_CREATE_INFO,
        .subpassCount = 1,
        .pViewMasks = &mask,
        .correlationMaskCount = 1,
        .pCorrelationMasks = &mask};
    VkRenderPassCreateInfo info = {.sType = VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO,
                                   .pNext = params->views == 2 ? &multiview : NULL,
                                   .attachmentCount = 2,
                                   .pAttachments = attachments,
                                   .subpassCount = 1,
                                   .pSubpasses = &subpass,
                                   .dependencyCount = 2,
                                   .pDependencies = dependencies};
    return ap_vk_check(err, vkCreateRenderPass(gpu->device, &info, NULL, made),
                       "vkCreateRenderPass");
}

enum ap_status ap_pass_framebuffer(struct ap_error *err, const struct ap_gpu *gpu,
                                   const struct ap_pass *pass, VkImageView color,
                                   VkFramebuffer *framebuffer) {
    VkImageView views[2] = {color, pass->depth.view};
    VkFramebufferCreateInfo info = {.sType = VK_STRUCTURE_TYPE_FRAMEBUFFER_CREATE_INFO,
                                    .renderPass = pass->render_pass,
                                    .attachmentCount = 2,
                                    .pAttachments = views,
                                    .width = pass->params.width,
                                    .height = pass->params.height,
                                    .layers = 1};
    return ap_vk_check(err, vkCreateFramebuffer(gpu->device, &info, NULL, framebuffer),
                       "vkCreateFramebuffer");
}

static enum ap_status create_read_view(struct ap_error *err, const struct ap_gpu *gpu,
                                       struct ap_pass *pass) {
    VkImageViewCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO,
        .image = pass->color.image,
        .viewType = VK_IMAGE_VIEW_TYPE_2D_ARRAY,
        .format = pass->params.coded ? VK_FORMAT_R32_UINT : pass->params.color_format,
        .subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, pass->params.views}};
    return ap_vk_check(err, vkCreateImageView(gpu->device, &info, NULL, &pass->read),
                       "vkCreateImageView");
}

static enum ap_status create_images(struct ap_error *err, const struct ap_gpu *gpu,
                                    const struct ap_pass_params *params, struct ap_pass *pass) {
    VkImageCreateInfo info = {.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
                              .flags = params->coded ? VK_IMAGE_CREATE_MUTABLE_FORMAT_BIT : 0,
                              .imageType = VK_IMAGE_TYPE_2D,
                              .format = params->color_format,
                              .extent = {params->width, params->height, 1},
                              .mipLevels = 1,
                              .arrayLayers = params->views,
                              .samples = params->samples,
                              .usage =
                                  VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT};
    enum ap_status st = AP_OK;
    if (!params->straight)
        st = ap_gpu_image_create(err, gpu, &info, VK_IMAGE_VIEW_TYPE_2D_ARRAY,
                                 VK_IMAGE_ASPECT_COLOR_BIT, &pass->color);
    if (st == AP_OK && !params->straight)
        st = create_read_view(err, gpu, pass);
    if (st != AP_OK)
        return st;
    info.flags = 0;
    info.format = DEPTH_FORMAT;
    info.usage =
        VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSIENT_ATTACHMENT_BIT;
    st = ap_gpu_image_create(err, gpu, &info, VK_IMAGE_VIEW_TYPE_2D_ARRAY,
                             VK_IMAGE_ASPECT_DEPTH_BIT, &pass->depth);
    if (st != AP_OK || params->straight)
        return st;
    return ap_pass_framebuffer(err, gpu, pass, pass->color.view, &pass->framebuffer);
}

static enum ap_status create_pipeline(struct ap_error *err, const struct ap_gpu *gpu,
                                      const struct ap_pass *pass, struct ap_world world, int kind,
                                      VkPipeline *made) {
    static const VkVertexInputBindingDescription binding = {0, sizeof(struct ap_vertex),
                                                            VK_VERTEX_INPUT_RATE_VERTEX};
    static const VkVertexInputAttributeDescription attributes[2] = {
        {0, 0, VK_FORMAT_R32G32B32A32_SFLOAT, offsetof(struct ap_vertex, position)},
        {1, 0, VK_FORMAT_R32G32B32A32_SFLOAT, offsetof(struct ap_vertex, normal)}};
    static const VkPipelineVertexInputStateCreateInfo input = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO,
        .vertexBindingDescriptionCount = 1,
        .pVertexBindingDescriptions = &binding,
        .vertexAttributeDescriptionCount = 2,
        .pVertexAttributeDescriptions = attributes};
    static const struct {
        bool closed;
        int shaders, draws; // draws: DRAWS of shaders/finish.glsl
    } KIND[] = {[AP_PIPELINE_CLOSED] = {.closed = true}, [AP_PIPELINE_MATTE_BALLS] = {true, 2, 4},
                [AP_PIPELINE_MATTE] = {true, 5, 4},      [AP_PIPELINE_PLANES] = {true, 5, 5},
                [AP_PIPELINE_BALLS] = {true, 2, 1},      [AP_PIPELINE_STICKS] = {true, 2, 2},
                [AP_PIPELINE_SHEETS] = {false, 2, 3},    [AP_PIPELINE_DISC] = {.shaders = 3}};
    const struct ap_pass_params *params = &pass->params;
    bool guard = kind >= AP_PIPELINE_GUARD && kind < AP_PIPELINE_GUARD_END;
    int how = kind - AP_PIPELINE_GUARD, draws = guard ? how / AP_GUARD_BALLS : KIND[kind].draws;
    bool closed = guard ? how & AP_GUARD_CLOSED : KIND[kind].closed;
    int set = !guard ? KIND[kind].shaders : how & AP_GUARD_EXACT ? 4 : 1;
    struct ap_pipeline_params pipeline = {
        .vertex = pass->shader[2 * set],
        .fragment = pass->shader[2 * set + 1],
        .constant = {draws, world.kappa, world.mode, world.born_kappa, params->coded,
                     params->marks},
        .input = &input,
        .width = params->width,
        .height = params->height,
        .samples = params->samples,
        .cull = closed ? VK_CULL_MODE_BACK_BIT : VK_CULL_MODE_NONE,
        .depth = true,
        .blend = kind == AP_PIPELINE_DISC,
        .layout = params->layout,
        .render_pass = pass->render_pass};
    return ap_pipeline_create(err, gpu, &pipeline, made);
}

static enum ap_status create_shaders(struct ap_error *err, const struct ap_gpu *gpu,
                                     struct ap_pass *pass) {
    static const struct {
        const uint32_t *words;
        size_t bytes;
    } code[2][AP_PASS_SHADERS] = {{{part_single_vert, sizeof part_single_vert},
                                   {part_frag, sizeof part_frag},
                                   {part_single_guard_vert, sizeof part_single_guard_vert},
                                   {part_guard_frag, sizeof part_guard_frag},
                                   {part_single_finish_vert, sizeof part_single_finish_vert},
                                   {part_finish_frag, sizeof part_finish_frag},
                                   {disc_single_vert, sizeof disc_single_vert},
                                   {disc_frag, sizeof disc_frag},
                                   {part_single_guard_vert, sizeof part_single_guard_vert},
                                   {part_exact_frag, sizeof part_exact_frag},
                                   {part_single_finish_vert, sizeof part_single_finish_vert},
                                   {part_matte_frag, sizeof part_matte_frag}},
                                  {{part_vert, sizeof part_vert},
                                   {part_frag, sizeof part_frag},
                                   {part_guard_vert, sizeof part_guard_vert},
                                   {part_guard_frag, sizeof part_guard_frag},
                                   {part_finish_vert, sizeof part_finish_vert},
                                   {part_finish_frag, sizeof part_finish_frag},
                                   {disc_vert, sizeof disc_vert},
                                   {disc_frag, sizeof disc_frag},
                                   {part_guard_vert, sizeof part_guard_vert},
                                   {part_exact_frag, sizeof part_exact_frag},
                                   {part_finish_vert, sizeof part_finish_vert},
                                   {part_matte_frag, sizeof part_matte_frag}}};
    enum ap_status st = AP_OK;
    for (int i = 0; st == AP_OK && i < AP_PASS_SHADERS; i++)
        st = ap_gpu_shader(err, gpu, code[pass->views - 1][i].words, code[pass->views - 1][i].bytes,
                           &pass->shader[i]);
    return st;
}

enum ap_status ap_pass_create(struct ap_error *err, const struct ap_gpu *gpu,
                              const struct ap_pass_params *params, struct ap_pass *pass) {
    struct ap_pass made = {.params = *params, .views = params->views};
    enum ap_status st = create_render_pass(err, gpu, params, &made.render_pass);
    if (st == AP_OK)
        st = create_images(err, gpu, params, &made);
    if (st == AP_OK)
        st = create_shaders(err, gpu, &made);
    if (st == AP_OK)
        *pass = made;
    else
        ap_pass_destroy(gpu, &made);
    return st;
}

// Of one space there are native, tourist and native-of three spaces: four of these for each sign.
static int index_of(struct ap_world world) {
    int way = world.mode == AP_VIEW_BORN ? 2 + (world.born_kappa < 0) : world.mode;
    return 4 * (world.kappa + 1) + way;
}

enum ap_status ap_pass_pipelines(struct ap_error *err, const struct ap_gpu *gpu,
                                 struct ap_world world, const bool needed[AP_PIPELINE_COUNT],
                                 struct ap_pass *pass, const VkPipeline **pipelines) {
    VkPipeline *all = pass->pipeline[index_of(world)];
    enum ap_status st = AP_OK;
    for (int k = 0; st == AP_OK && k < AP_PIPELINE_COUNT; k++)
        if (needed[k] && !all[k])
            st = create_pipeline(err, gpu, pass, world, k, &all[k]);
    if (st == AP_OK)
        *pipelines = all;
    return st;
}

void ap_pass_destroy(const struct ap_gpu *gpu, struct ap_pass *pass) {
    for (int i = 0; i < AP_PASS_SHADERS; i++)
        vkDestroyShaderModule(gpu->device, pass->shader[i], NULL);
    for (int w = 0; w < AP_WORLD_COUNT; w++)
        for (int k = 0; k < AP_PIPELINE_COUNT; k++)
            vkDestroyPipeline(gpu->device, pass->pipeline[w][k], NULL);
    vkDestroyFramebuffer(gpu->device, pass->framebuffer, NULL);
    vkDestroyRenderPass(gpu->device, pass->render_pass, NULL);
    vkDestroyImageView(gpu->device, pass->read, NULL);
    ap_gpu_image_destroy(gpu, &pass->color);
    ap_gpu_image_destroy(gpu, &pass->depth);
    memset(pass, 0, sizeof *pass);
}
