#include "tests/render/probe.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "src/render/mesh/decals.h"
#include "tests/render/stage.h"

static const VkFormat COLOR = VK_FORMAT_R8G8B8A8_UNORM, DEPTH = VK_FORMAT_D32_SFLOAT;

void probe_world_open(struct probe_world *w, const struct ap_gpu *gpu, struct ap_scene *scene) {
    memset(w, 0, sizeof *w);
    w->gpu = gpu;
    w->scene = scene;
    STAGE_CHECK(ap_meshes_create(&stage_error, gpu, scene, &w->meshes));
    if (scene->honeycomb)
        STAGE_CHECK(ap_cell_view_create(&stage_error, scene, &w->meshes, &w->cells));
    STAGE_CHECK(ap_draw_list_create(&stage_error, scene->part_count, &w->list));
}

void probe_world_close(struct probe_world *w) {
    ap_draw_list_destroy(&w->list);
    if (w->scene->honeycomb)
        ap_cell_view_destroy(&w->cells);
    ap_meshes_destroy(w->gpu, &w->meshes);
}

static void make_layouts(struct probe *p) {
    const VkShaderStageFlags both = VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT;
    VkDescriptorSetLayoutBinding bindings[4] = {
        {0, VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, 1, both, NULL},
        {1, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1, both, NULL},
        {2, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 1, VK_SHADER_STAGE_FRAGMENT_BIT, NULL},
        {3, VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, 1, VK_SHADER_STAGE_FRAGMENT_BIT, NULL}};
    VkDescriptorSetLayoutCreateInfo set = {.sType =
                                               VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO,
                                           .bindingCount = 4,
                                           .pBindings = bindings};
    VkPushConstantRange push = {VK_SHADER_STAGE_VERTEX_BIT, 0, sizeof(int32_t)};
    VkPipelineLayoutCreateInfo layout = {.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
                                         .setLayoutCount = 1,
                                         .pSetLayouts = &p->set_layout,
                                         .pushConstantRangeCount = 1,
                                         .pPushConstantRanges = &push};
    VkDescriptorPoolSize sizes[3] = {{VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, 2},
                                     {VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1},
                                     {VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 1}};
    VkDescriptorPoolCreateInfo pool = {.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO,
                                       .maxSets = 1,
                                       .poolSizeCount = 3,
                                       .pPoolSizes = sizes};
    VkDescriptorSetAllocateInfo one = {.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO,
                                       .descriptorSetCount = 1,
                                       .pSetLayouts = &p->set_layout};
    VkDevice device = p->gpu->device;
    STAGE_CHECK(ap_vk_check(&stage_error,
                            vkCreateDescriptorSetLayout(device, &set, NULL, &p->set_layout),
                            "vkCreateDescriptorSetLayout"));
    STAGE_CHECK(ap_vk_check(&stage_error, vkCreatePipelineLayout(device, &layout, NULL, &p->layout),
                            "vkCreatePipelineLayout"));
    STAGE_CHECK(ap_vk_check(&stage_error,
                            vkCreateDescriptorPool(device, &pool, NULL, &p->descriptors),
                            "vkCreateDescriptorPool"));
    one.descriptorPool = p->descriptors;
    STAGE_CHECK(ap_vk_check(&stage_error, vkAllocateDescriptorSets(device, &one, &p->set),
                            "vkAllocateDescriptorSets"));
}

static VkAttachmentDescription kept(VkFormat format, VkImageLayout after) {
    return (VkAttachmentDescription){.format = format,
                                     .samples = VK_SAMPLE_COUNT_1_BIT,
                                     .loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR,
                                     .storeOp = VK_ATTACHMENT_STORE_OP_STORE,
                                     .stencilLoadOp = VK_ATTACHMENT_LOAD_OP_DONT_CARE,
                                     .stencilStoreOp = VK_ATTACHMENT_STORE_OP_DONT_CARE,
                                     .initialLayout = VK_IMAGE_LAYOUT_UNDEFINED,
                                     .finalLayout = after};
}

// Compatible with the pass's own: only what happens to the attachments at its ends differs.
static void make_render_pass(struct probe *p) {
    VkAttachmentDescription attachments[2] = {
        kept(COLOR, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL),
        kept(DEPTH, VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL)};
    VkAttachmentReference color = {0, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL},
                          depth = {1, VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL};
    VkSubpassDescription subpass = {.pipelineBindPoint = VK_PIPELINE_BIND_POINT_GRAPHICS,
                                    .colorAttachmentCount = 1,
                                    .pColorAttachments = &color,
                                    .pDepthStencilAttachment = &depth};
    VkPipelineStageFlags stages = VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT |
                                  VK_PIPELINE_STAGE_EARLY_FRAGMENT_TESTS_BIT |
                                  VK_PIPELINE_STAGE_LATE_FRAGMENT_TESTS_BIT;
    VkAccessFlags access =
        VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT | VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT;
    const VkSubpassDependency dependencies[2] = {
        {.srcSubpass = VK_SUBPASS_EXTERNAL,
         .srcStageMask = stages | VK_PIPELINE_STAGE_FRAGMENT_SHADER_BIT,
         .dstStageMask = stages,
         .srcAccessMask = access,
         .dstAccessMask = access | VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_READ_BIT},
        {.dstSubpass = VK_SUBPASS_EXTERNAL,
         .srcStageMask = stages,
         .dstStageMask = VK_PIPELINE_STAGE_FRAGMENT_SHADER_BIT,
         .srcAccessMask = access,
         .dstAccessMask = VK_ACCESS_SHADER_READ_BIT}};
    VkRenderPassCreateInfo info = {.sType = VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO,
                                   .attachmentCount = 2,
                                   .pAttachments = attachments,
                                   .subpassCount = 1,
                                   .pSubpasses = &subpass,
                                   .dependencyCount = 2,
                                   .pDependencies = dependencies};
    STAGE_CHECK(ap_vk_check(&stage_error,
                            vkCreateRenderPass(p->gpu->device, &info, NULL, &p->render_pass),
                            "vkCreateRenderPass"));
}

static void make_images(struct probe *p) {
    VkImageCreateInfo info = {.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
                              .imageType = VK_IMAGE_TYPE_2D,
                              .format = COLOR,
                              .extent = {p->width, p->height, 1},
                              .mipLevels = 1,
                              .arrayLayers = 1,
                              .samples = VK_SAMPLE_COUNT_1_BIT,
                              .usage = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT |
                                       VK_IMAGE_USAGE_TRANSFER_SRC_BIT};
    STAGE_CHECK(ap_gpu_image_create(&stage_error, p->gpu, &info, VK_IMAGE_VIEW_TYPE_2D_ARRAY,
                                    VK_IMAGE_ASPECT_COLOR_BIT, &p->color));
    info.format = DEPTH;
    info.usage = VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT;
    STAGE_CHECK(ap_gpu_image_create(&stage_error, p->gpu, &info, VK_IMAGE_VIEW_TYPE_2D_ARRAY,
                                    VK_IMAGE_ASPECT_DEPTH_BIT, &p->depth));
    const VkImageView views[2] = {p->color.view, p->depth.view};
    VkFramebufferCreateInfo framebuffer = {.sType = VK_STRUCTURE_TYPE_FRAMEBUFFER_CREATE_INFO,
                                           .renderPass = p->render_pass,
                                           .attachmentCount = 2,
                                           .pAttachments = views,
                                           .width = p->width,
                                           .height = p->height,
                                           .layers = 1};
    STAGE_CHECK(ap_vk_check(
        &stage_error, vkCreateFramebuffer(p->gpu->device, &framebuffer, NULL, &p->framebuffer),
        "vkCreateFramebuffer"));
}

void probe_open(struct probe *p, const struct ap_gpu *gpu, uint32_t width, uint32_t height) {
    memset(p, 0, sizeof *p);
    p->gpu = gpu;
    p->width = width;
    p->height = height;
    make_layouts(p);
    const struct ap_pass_params pass = {.color_format = COLOR,
                                        .width = width,
                                        .height = height,
                                        .views = 1,
                                        .samples = VK_SAMPLE_COUNT_1_BIT,
                                        .layout = p->layout};
    STAGE_CHECK(ap_pass_create(&stage_error, gpu, &pass, &p->pass));
    make_render_pass(p);
    make_images(p);
    struct ap_decals decals = {0};
    STAGE_CHECK(ap_decals_create(&stage_error, gpu, &(struct ap_decals_params){0}, &decals));
    p->decal = decals.image;
    p->sampler = decals.sampler;
    STAGE_CHECK(ap_gpu_buffer_create(&stage_error, gpu, sizeof(struct ap_gpu_frame),
                                     VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT, true, &p->frame));
    STAGE_CHECK(ap_gpu_buffer_create(&stage_error, gpu, sizeof(struct ap_gpu_marks),
                                     VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT, true, &p->marks));
    STAGE_CHECK(ap_gpu_buffer_create(&stage_error, gpu, (VkDeviceSize)width * height * 8,
                                     VK_BUFFER_USAGE_TRANSFER_DST_BIT, true, &p->pixels));
}

void probe_close(struct probe *p) {
    VkDevice device = p->gpu->device;
    vkDeviceWaitIdle(device);
    struct ap_decals decals = {p->decal, p->sampler};
    ap_decals_destroy(p->gpu, &decals);
    ap_gpu_buffer_destroy(p->gpu, &p->frame);
    ap_gpu_buffer_destroy(p->gpu, &p->marks);
    ap_gpu_buffer_destroy(p->gpu, &p->pixels);
    vkDestroyFramebuffer(device, p->framebuffer, NULL);
    vkDestroyRenderPass(device, p->render_pass, NULL);
    ap_gpu_image_destroy(p->gpu, &p->color);
    ap_gpu_image_destroy(p->gpu, &p->depth);
    ap_pass_destroy(p->gpu, &p->pass);
    vkDestroyDescriptorPool(device, p->descriptors, NULL);
    vkDestroyPipelineLayout(device, p->layout, NULL);
    vkDestroyDescriptorSetLayout(device, p->set_layout, NULL);
}

void probe_list(const struct probe *p, struct probe_world *w, const struct ap_frame_input *input,
                double max_error_px) {
    struct ap_eyes eyes = ap_eyes_of(&input->viewer, p->width, p->height);
    const struct ap_list_params what = {.scene = w->scene,
                                        .meshes = &w->meshes,
                                        .input = input,
                                        .eyes = &eyes,
                                        .width_px = p->width,
                                        .height_px = p->height,
                                        .max_error_px = max_error_px};
    STAGE_CHECK(ap_draw_list_fill(&stage_error, &what, &w->list));
    if (w->scene->honeycomb)
        STAGE_CHECK(ap_cell_view_fill(&stage_error, &w->cells, &what, &w->list));
    ap_draw_list_sort(&w->list);
}

// Vertices, indices and draws of a frame.
struct buffers {
    struct ap_gpu_buffer vertices, indices, draws;
};

static void hold(const struct ap_gpu *gpu, const void *bytes, size_t size, VkBufferUsageFlags usage,
                 struct ap_gpu_buffer *buffer) {
    STAGE_CHECK(ap_gpu_buffer_create(&stage_error, gpu, size ? size : 16, usage, true, buffer));
    if (bytes && size)
        memcpy(buffer->mapped, bytes, size);
}

static void bind_set(struct probe *p, const struct buffers *b) {
    const VkDescriptorBufferInfo buffers[4] = {{p->frame.buffer, 0, VK_WHOLE_SIZE},
                                               {b->draws.buffer, 0, VK_WHOLE_SIZE},
                                               {0},
                                               {p->marks.buffer, 0, VK_WHOLE_SIZE}};
    const VkDescriptorImageInfo image = {p->sampler, p->decal.view,
                                         VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
    static const VkDescriptorType types[4] = {
        VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER,
        VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER};
    VkWriteDescriptorSet writes[4];
    for (uint32_t i = 0; i < 4; i++)
        writes[i] = (VkWriteDescriptorSet){.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                           .dstSet = p->set,
                                           .dstBinding = i,
                                           .descriptorCount = 1,
                                           .descriptorType = types[i],
                                           .pBufferInfo = i == 2 ? NULL : &buffers[i],
                                           .pImageInfo = i == 2 ? &image : NULL};
    vkUpdateDescriptorSets(p->gpu->device, 4, writes, 0, NULL);
}

static void fill_buffers(struct probe *p, const struct probe_world *w,
                         const struct ap_frame_input *input, const uint32_t *number,
                         struct buffers *b) {
    const struct ap_viewer *viewer = &input->viewer;
    struct ap_eyes eyes = ap_eyes_of(viewer, p->width, p->height);
    const struct ap_mesh_data *own = &w->list.refined;
    hold(p->gpu, own->vertices, own->vertex_count * sizeof *own->vertices,
         VK_BUFFER_USAGE_VERTEX_BUFFER_BIT, &b->vertices);
    hold(p->gpu, own->indices, own->index_count * sizeof *own->indices,
         VK_BUFFER_USAGE_INDEX_BUFFER_BIT, &b->indices);
    hold(p->gpu, NULL, (w->list.count + 1) * sizeof(struct ap_gpu_draw),
         VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, &b->draws);
    p->said = ap_frame_of(viewer, w->scene->honeycomb != NULL);
    ap_frame_light(viewer, &eyes, w->scene->lamp_reach_m, w->scene->lamp_radius_m, &p->said);
    ap_frame_depth(viewer, &eyes, &w->list.range, &p->said);
    memcpy(p->frame.mapped, &p->said, sizeof p->said);
    struct ap_gpu_draw *draws = b->draws.mapped;
    ap_draw_list_write(w->scene, input, &eyes, &w->list, draws, p->marks.mapped);
    for (size_t i = 0; i < w->list.count; i++) {
        uint32_t id = number[i] + 1;
        for (int k = 0; k < 3; k++)
            draws[i].color[k] = (float)(id >> 8 * k & 255) / 255;
        draws[i].color[3] = 0; // shown as it is
        draws[i].finish[0] = 0;
    }
    bind_set(p, b);
}

static void record(const struct probe *p, const struct probe_world *w, const struct buffers *b,
                   int32_t eye, VkCommandBuffer cmd) {
    VkClearValue clear[2] = {0};
    VkRenderPassBeginInfo begin = {.sType = VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO,
                                   .renderPass = p->render_pass,
                                   .framebuffer = p->framebuffer,
                                   .renderArea = {{0, 0}, {p->width, p->height}},
                                   .clearValueCount = 2,
                                   .pClearValues = clear};
    VkDeviceSize zero = 0;
    vkCmdBeginRenderPass(cmd, &begin, VK_SUBPASS_CONTENTS_INLINE);
    vkCmdBindDescriptorSets(cmd, VK_PIPELINE_BIND_POINT_GRAPHICS, p->layout, 0, 1, &p->set, 0,
                            NULL);
    vkCmdPushConstants(cmd, p->layout, VK_SHADER_STAGE_VERTEX_BIT, 0, sizeof eye, &eye);
    for (uint32_t i = 0; i < w->list.count; i++) {
        const struct ap_draw_item *item = w->list.order[i];
        if (!(item->eyes >> eye & 1))
            continue;
        const struct ap_gpu_buffer *vertices = item->refined ? &b->vertices : &w->meshes.vertices,
                                   *indices = item->refined ? &b->indices : &w->meshes.indices;
        vkCmdBindPipeline(cmd, VK_PIPELINE_BIND_POINT_GRAPHICS, p->pipelines[item->pipeline]);
        vkCmdBindVertexBuffers(cmd, 0, 1, &vertices->buffer, &zero);
        vkCmdBindIndexBuffer(cmd, indices->buffer, 0, VK_INDEX_TYPE_UINT32);
        vkCmdDrawIndexed(cmd, item->mesh.index_count, 1, item->mesh.first_index,
                         (int32_t)item->mesh.first_vertex, i);
    }
    vkCmdEndRenderPass(cmd);
}

static void copy_out(const struct probe *p, VkCommandBuffer cmd) {
    const struct {
        const struct ap_gpu_image *image;
        VkImageAspectFlags aspect;
        VkImageLayout layout;
    } from[2] = {
        {&p->color, VK_IMAGE_ASPECT_COLOR_BIT, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL},
        {&p->depth, VK_IMAGE_ASPECT_DEPTH_BIT, VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL}};
    for (int i = 0; i < 2; i++) {
        ap_gpu_barrier(cmd, from[i].image->image, from[i].aspect, from[i].layout,
                       VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
        VkBufferImageCopy copy = {.bufferOffset = (VkDeviceSize)i * p->width * p->height * 4,
                                  .imageSubresource = {from[i].aspect, 0, 0, 1},
                                  .imageExtent = {p->width, p->height, 1}};
        vkCmdCopyImageToBuffer(cmd, from[i].image->image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
                               p->pixels.buffer, 1, &copy);
    }
}

void probe_draw(struct probe *p, const struct probe_world *w, const struct ap_frame_input *input,
                int eye, const uint32_t *number, uint32_t *ids, float *depth) {
    const struct ap_world made_for = {input->viewer.space.kappa, (int)input->viewer.mode, 0};
    bool needed[AP_PIPELINE_COUNT] = {false};
    for (size_t i = 0; i < w->list.count; i++)
        needed[w->list.items[i].pipeline] = true;
    STAGE_CHECK(ap_pass_pipelines(&stage_error, p->gpu, made_for, needed, &p->pass, &p->pipelines));
    struct buffers b = {0};
    VkCommandBuffer cmd = VK_NULL_HANDLE;
    size_t count = (size_t)p->width * p->height;
    fill_buffers(p, w, input, number, &b);
    STAGE_CHECK(ap_gpu_commands_begin(&stage_error, p->gpu, &cmd));
    record(p, w, &b, eye, cmd);
    copy_out(p, cmd);
    STAGE_CHECK(ap_gpu_commands_end(&stage_error, p->gpu, cmd));
    const uint8_t *rgba = p->pixels.mapped;
    for (size_t i = 0; i < count; i++)
        ids[i] = rgba[4 * i] | (uint32_t)rgba[4 * i + 1] << 8 | (uint32_t)rgba[4 * i + 2] << 16;
    memcpy(depth, rgba + 4 * count, count * sizeof *depth);
    ap_gpu_buffer_destroy(p->gpu, &b.vertices);
    ap_gpu_buffer_destroy(p->gpu, &b.indices);
    ap_gpu_buffer_destroy(p->gpu, &b.draws);
}

double probe_along(const struct probe *p, const struct ap_viewer *viewer, int eye, int image,
                   double x_px, double y_px, double depth) {
    const struct ap_frustum *f = &viewer->eye[eye].frustum;
    double a = f->left + (f->right - f->left) * x_px / p->width;
    double b = f->up - (f->up - f->down) * y_px / p->height, ahead = 1 / sqrt(1 + a * a + b * b);
    if (viewer->mode == AP_VIEW_NATIVE && image == 1 && p->said.long_way > 0) {
        // The angle from the nose says how far from it; the eye's line gets there so far from the
        // eye.
        const struct ap_pose *pose = &viewer->eye[eye].view_from_eye;
        struct ap_vec3 line =
            ap_quat_rotate(pose->q, (struct ap_vec3){a * ahead, b * ahead, -ahead});
        double from_nose =
            viewer->space.rho_m * (2 * 3.14159265358979323846 - depth / p->said.long_way);
        double along = ap_vec3_dot(pose->p, line);
        return sqrt(along * along + from_nose * from_nose - ap_vec3_dot(pose->p, pose->p)) - along;
    }
    if (viewer->mode == AP_VIEW_NATIVE)
        return p->said.near / depth / ahead;
    // (w·d.x − z·d.y)/−z, with w/−z = cot(t)/ahead (coth; 1/t), and from the antipode in image 1.
    const float *d = p->said.depth[image];
    double cot = (depth - d[1]) / d[0] * ahead, rho = viewer->space.rho_m;
    int kappa = viewer->space.kappa;
    double t = kappa > 0   ? atan2(1, cot)
               : kappa < 0 ? (cot > 1 ? atanh(1 / cot) : INFINITY)
                           : 1 / cot;
    return rho * (t + image * 3.14159265358979323846);
}
