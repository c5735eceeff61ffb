#include "src/render/renderer.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "src/base/log.h"
#include "src/render/mesh/budget.h"
#include "src/render/cells.h"
#include "src/render/mesh/decals.h"
#include "src/render/list.h"
#include "src/render/pass/resolve.h"
#include "src/render/samples.h"

enum { RING = AP_FRAMES_AHEAD };

struct slot {
    VkFence fence;
    bool busy; // submitted and not yet waited for
    VkCommandBuffer cmd;
    struct ap_gpu_buffer frame, draws, marks;
    struct ap_gpu_buffer vertices, indices; // of this frame's own meshes; grow
    VkDescriptorSet set;
    // Made anew each frame: targets belong to somebody else, who may replace them at any time.
    VkImageView target[2];
    VkFramebuffer framebuffer[2];
};

struct ap_renderer {
    const struct ap_gpu *gpu;
    const struct ap_scene *scene;
    struct ap_renderer_params params;
    bool multiview;
    double max_error_px;
    struct ap_samples samples;
    struct ap_meshes meshes;
    struct ap_draw_list list;
    struct ap_decals decals;
    struct ap_cell_view cells; // of a scene of cells
    VkDescriptorSetLayout set_layout;
    VkPipelineLayout layout;
    VkDescriptorPool descriptors;
    VkCommandPool pool;
    VkQueryPool times; // two for each slot; none where the queue keeps no time
    uint64_t time_mask;
    struct ap_pass pass[2];      // for one eye, for both; made when first needed
    const VkPipeline *pipelines; // of the frame's pass and world
    struct ap_resolve resolve;
    struct slot slot[RING];
    unsigned frame;
    bool told_budget; // that it ended
};

static enum ap_status create_layouts(struct ap_error *err, struct ap_renderer *r) {
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
    enum ap_status st =
        ap_vk_check(err, vkCreateDescriptorSetLayout(r->gpu->device, &set, NULL, &r->set_layout),
                    "vkCreateDescriptorSetLayout");
    if (st != AP_OK)
        return st;
    VkPushConstantRange push = {VK_SHADER_STAGE_VERTEX_BIT, 0, sizeof(int32_t)};
    VkPipelineLayoutCreateInfo layout = {.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
                                         .setLayoutCount = 1,
                                         .pSetLayouts = &r->set_layout,
                                         .pushConstantRangeCount = 1,
                                         .pPushConstantRanges = &push};
    st = ap_vk_check(err, vkCreatePipelineLayout(r->gpu->device, &layout, NULL, &r->layout),
                     "vkCreatePipelineLayout");
    if (st != AP_OK)
        return st;
    VkDescriptorPoolSize sizes[3] = {{VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, 2 * RING},
                                     {VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, RING},
                                     {VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, RING}};
    VkDescriptorPoolCreateInfo pool = {.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO,
                                       .maxSets = RING,
                                       .poolSizeCount = 3,
                                       .pPoolSizes = sizes};
    return ap_vk_check(err, vkCreateDescriptorPool(r->gpu->device, &pool, NULL, &r->descriptors),
                       "vkCreateDescriptorPool");
}

static void bind_slot_set(const struct ap_renderer *r, const struct slot *slot) {
    const VkDescriptorBufferInfo buffers[4] = {{slot->frame.buffer, 0, VK_WHOLE_SIZE},
                                               {slot->draws.buffer, 0, VK_WHOLE_SIZE},
                                               {0},
                                               {slot->marks.buffer, 0, VK_WHOLE_SIZE}};
    const VkDescriptorImageInfo image = {r->decals.sampler, r->decals.image.view,
                                         VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
    static const VkDescriptorType types[4] = {
        VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER,
        VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER};
    VkWriteDescriptorSet writes[4];
    for (uint32_t i = 0; i < 4; i++)
        writes[i] = (VkWriteDescriptorSet){.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                           .dstSet = slot->set,
                                           .dstBinding = i,
                                           .descriptorCount = 1,
                                           .descriptorType = types[i],
                                           .pBufferInfo = i == 2 ? NULL : &buffers[i],
                                           .pImageInfo = i == 2 ? &image : NULL};
    vkUpdateDescriptorSets(r->gpu->device, 4, writes, 0, NULL);
}

static enum ap_status fill_slot_set(struct ap_error *err, struct ap_renderer *r,
                                    struct slot *slot) {
    VkDescriptorSetAllocateInfo info = {.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO,
                                        .descriptorPool = r->descriptors,
                                        .descriptorSetCount = 1,
                                        .pSetLayouts = &r->set_layout};
    enum ap_status st =
        ap_vk_check(err, vkAllocateDescriptorSets(r->gpu->device, &info, &slot->set),
                    "vkAllocateDescriptorSets");
    if (st != AP_OK)
        return st;
    bind_slot_set(r, slot);
    return AP_OK;
}

static enum ap_status create_slot(struct ap_error *err, struct ap_renderer *r, struct slot *slot) {
    VkFenceCreateInfo fence = {.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
    VkCommandBufferAllocateInfo cmd = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
                                       .commandPool = r->pool,
                                       .level = VK_COMMAND_BUFFER_LEVEL_PRIMARY,
                                       .commandBufferCount = 1};
    VkDeviceSize draws = (2 * r->scene->part_count + 1) * sizeof(struct ap_gpu_draw);
    enum ap_status st = ap_vk_check(err, vkCreateFence(r->gpu->device, &fence, NULL, &slot->fence),
                                    "vkCreateFence");
    if (st == AP_OK)
        st = ap_vk_check(err, vkAllocateCommandBuffers(r->gpu->device, &cmd, &slot->cmd),
                         "vkAllocateCommandBuffers");
    if (st == AP_OK)
        st = ap_gpu_buffer_create(err, r->gpu, sizeof(struct ap_gpu_frame),
                                  VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT, true, &slot->frame);
    if (st == AP_OK)
        st = ap_gpu_buffer_create(err, r->gpu, draws, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, true,
                                  &slot->draws);
    if (st == AP_OK)
        st = ap_gpu_buffer_create(err, r->gpu, sizeof(struct ap_gpu_marks),
                                  VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT, true, &slot->marks);
    return st == AP_OK ? fill_slot_set(err, r, slot) : st;
}

static enum ap_status create_times(struct ap_error *err, struct ap_renderer *r) {
    VkQueueFamilyProperties families[16];
    uint32_t count = 16;
    vkGetPhysicalDeviceQueueFamilyProperties(r->gpu->physical_device, &count, families);
    uint32_t bits =
        r->gpu->queue_family < count ? families[r->gpu->queue_family].timestampValidBits : 0;
    if (bits == 0)
        return AP_OK;
    r->time_mask = bits >= 64 ? UINT64_MAX : (UINT64_C(1) << bits) - 1;
    VkQueryPoolCreateInfo info = {.sType = VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO,
                                  .queryType = VK_QUERY_TYPE_TIMESTAMP,
                                  .queryCount = 2 * RING};
    return ap_vk_check(err, vkCreateQueryPool(r->gpu->device, &info, NULL, &r->times),
                       "vkCreateQueryPool");
}

bool ap_renderer_gpu_ms(const struct ap_renderer *r, double *ms) {
    uint64_t t[4];
    if (!r->times || r->frame == 0)
        return false;
    VkResult result = vkGetQueryPoolResults(
        r->gpu->device, r->times, 2 * ((r->frame - 1) % RING), 2, sizeof t, t, 2 * sizeof *t,
        VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WITH_AVAILABILITY_BIT);
    if (result != VK_SUCCESS || t[1] == 0 || t[3] == 0)
        return false;
    *ms = (double)((t[2] - t[0]) & r->time_mask) *
          (double)r->gpu->properties.limits.timestampPeriod * 1e-6;
    return true;
}

// Of what is there from the start.
static size_t scene_bytes(const struct ap_renderer *r) {
    return ap_meshes_bytes(&r->meshes) + (r->cells.cells ? ap_cells_bytes(r->cells.cells) : 0);
}

// And of the lists and buffers of frames.
static size_t held_bytes(const struct ap_renderer *r) {
    size_t sum = scene_bytes(r) + r->list.room * ap_draw_list_item_bytes() +
                 ap_mesh_data_bytes(&r->list.refined);
    for (int i = 0; i < RING; i++)
        sum += r->slot[i].draws.size + r->slot[i].vertices.size + r->slot[i].indices.size;
    return sum;
}

static enum ap_status create_parts(struct ap_error *err, struct ap_renderer *r) {
    VkCommandPoolCreateInfo pool = {.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
                                    .flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT,
                                    .queueFamilyIndex = r->gpu->queue_family};
    enum ap_status st = ap_vk_check(err, vkCreateCommandPool(r->gpu->device, &pool, NULL, &r->pool),
                                    "vkCreateCommandPool");
    if (st == AP_OK)
        st = create_times(err, r);
    if (st == AP_OK)
        st = create_layouts(err, r);
    struct ap_resolve_params resolve = {r->params.color_format,     r->params.width,
                                        r->params.height,           (int32_t)r->samples.samples,
                                        (int32_t)r->samples.across, r->samples.coded};
    if (st == AP_OK)
        st = ap_resolve_create(err, r->gpu, &resolve, &r->resolve);
    if (st == AP_OK)
        st = ap_meshes_create(err, r->gpu, r->scene, &r->meshes);
    struct ap_decals_params decals = {r->params.decals, r->params.decal_px, r->params.decal_count};
    if (st == AP_OK)
        st = ap_decals_create(err, r->gpu, &decals, &r->decals);
    r->params.decals = NULL; // the caller's
    if (st == AP_OK)
        st = ap_draw_list_create(err, r->scene->part_count, &r->list);
    if (st == AP_OK && r->scene->honeycomb)
        st = ap_cell_view_create(err, r->scene, &r->meshes, &r->cells);
    if (st == AP_OK)
        st = ap_budget_check(err, r->scene, scene_bytes(r), r->cells.part_count);
    for (int i = 0; st == AP_OK && i < RING; i++)
        st = create_slot(err, r, &r->slot[i]);
    return st;
}

enum ap_status ap_renderer_create(struct ap_error *err, const struct ap_gpu *gpu,
                                  const struct ap_scene *scene,
                                  const struct ap_renderer_params *params,
                                  struct ap_renderer **renderer) {
    if (params->width == 0 || params->height == 0)
        return ap_fail(err, AP_USAGE, "the renderer was asked for pictures of %u by %u pixels",
                       params->width, params->height);
    struct ap_renderer *r = calloc(1, sizeof *r);
    if (!r)
        return ap_fail(err, AP_ENVIRONMENT, "no memory for the renderer");
    r->gpu = gpu;
    r->scene = scene;
    r->params = *params;
    r->multiview = ap_use_multiview(gpu, params);
    r->max_error_px = params->max_error_px > 0 ? params->max_error_px : 0.25;
    enum ap_status st = ap_choose_samples(err, gpu, scene, params, &r->samples);
    if (st == AP_OK)
        st = create_parts(err, r);
    if (st == AP_OK)
        *renderer = r;
    else
        ap_renderer_destroy(r);
    return st;
}

static enum ap_status wait_for(struct ap_error *err, const struct ap_renderer *r,
                               struct slot *slot) {
    if (!slot->busy)
        return AP_OK;
    slot->busy = false;
    enum ap_status st =
        ap_vk_check(err, vkWaitForFences(r->gpu->device, 1, &slot->fence, VK_TRUE, UINT64_MAX),
                    "vkWaitForFences");
    return st == AP_OK
               ? ap_vk_check(err, vkResetFences(r->gpu->device, 1, &slot->fence), "vkResetFences")
               : st;
}

static void release_targets(const struct ap_gpu *gpu, struct slot *slot) {
    for (int i = 0; i < 2; i++) {
        vkDestroyFramebuffer(gpu->device, slot->framebuffer[i], NULL);
        vkDestroyImageView(gpu->device, slot->target[i], NULL);
        slot->framebuffer[i] = VK_NULL_HANDLE;
        slot->target[i] = VK_NULL_HANDLE;
    }
}

void ap_renderer_destroy(struct ap_renderer *r) {
    if (!r)
        return;
    VkDevice device = r->gpu->device;
    for (int i = 0; i < RING; i++) {
        struct slot *slot = &r->slot[i];
        wait_for(NULL, r, slot);
        release_targets(r->gpu, slot);
        vkDestroyFence(device, slot->fence, NULL);
        ap_gpu_buffer_destroy(r->gpu, &slot->frame);
        ap_gpu_buffer_destroy(r->gpu, &slot->draws);
        ap_gpu_buffer_destroy(r->gpu, &slot->marks);
        ap_gpu_buffer_destroy(r->gpu, &slot->vertices);
        ap_gpu_buffer_destroy(r->gpu, &slot->indices);
    }
    for (int i = 0; i < 2; i++)
        ap_pass_destroy(r->gpu, &r->pass[i]);
    ap_resolve_destroy(r->gpu, &r->resolve);
    ap_draw_list_destroy(&r->list);
    ap_decals_destroy(r->gpu, &r->decals);
    ap_cell_view_destroy(&r->cells);
    ap_meshes_destroy(r->gpu, &r->meshes);
    vkDestroyDescriptorPool(device, r->descriptors, NULL);
    vkDestroyPipelineLayout(device, r->layout, NULL);
    vkDestroyDescriptorSetLayout(device, r->set_layout, NULL);
    vkDestroyCommandPool(device, r->pool, NULL);
    vkDestroyQueryPool(device, r->times, NULL);
    free(r);
}

// A view of one eye's layer of the target and the framebuffer that draws into it: of `straight`, or
// where that is NULL of the pass that averages.
static enum ap_status bind_target(struct ap_error *err, const struct ap_renderer *r,
                                  const struct ap_target *target, const struct ap_pass *straight,
                                  struct slot *slot, int eye) {
    VkImageViewCreateInfo view = {
        .sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO,
        .image = target->image[eye],
        .viewType = VK_IMAGE_VIEW_TYPE_2D,
        .format = r->params.color_format,
        .subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, target->layer[eye], 1}};
    enum ap_status st =
        ap_vk_check(err, vkCreateImageView(r->gpu->device, &view, NULL, &slot->target[eye]),
                    "vkCreateImageView of a target");
    if (st != AP_OK)
        return st;
    if (straight)
        return ap_pass_framebuffer(err, r->gpu, straight, slot->target[eye],
                                   &slot->framebuffer[eye]);
    VkFramebufferCreateInfo info = {.sType = VK_STRUCTURE_TYPE_FRAMEBUFFER_CREATE_INFO,
                                    .renderPass = r->resolve.render_pass,
                                    .attachmentCount = 1,
                                    .pAttachments = &slot->target[eye],
                                    .width = r->params.width,
                                    .height = r->params.height,
                                    .layers = 1};
    return ap_vk_check(err,
                       vkCreateFramebuffer(r->gpu->device, &info, NULL, &slot->framebuffer[eye]),
                       "vkCreateFramebuffer");
}

// Of whose buffers the next draws are: the scene's, or the frame's own.
static void bind_meshes(const struct ap_renderer *r, const struct slot *slot, bool refined,
                        VkCommandBuffer cmd) {
    VkDeviceSize zero = 0;
    vkCmdBindVertexBuffers(cmd, 0, 1, refined ? &slot->vertices.buffer : &r->meshes.vertices.buffer,
                           &zero);
    vkCmdBindIndexBuffer(cmd, refined ? slot->indices.buffer : r->meshes.indices.buffer, 0,
                         VK_INDEX_TYPE_UINT32);
}

// A mesh of which no triangle is seen begins where the next one does.
static bool goes_with(const struct ap_draw_item *item, const struct ap_draw_item *next) {
    return next->mesh.first_index == item->mesh.first_index &&
           next->mesh.index_count == item->mesh.index_count && next->refined == item->refined &&
           next->pipeline == item->pipeline;
}

// Runs of equal meshes become one instanced draw.
static void record_draws(const struct ap_renderer *r, const struct slot *slot, unsigned eyes) {
    VkCommandBuffer cmd = slot->cmd;
    int bound = -1, buffers = -1;
    for (size_t i = 0, next; i < r->list.count; i = next) {
        const struct ap_draw_item *item = r->list.order[i];
        next = i + 1;
        if (!(item->eyes & eyes))
            continue;
        while (next < r->list.count && goes_with(item, r->list.order[next]) &&
               (r->list.order[next]->eyes & eyes))
            next++;
        if (bound != (int)item->pipeline)
            vkCmdBindPipeline(cmd, VK_PIPELINE_BIND_POINT_GRAPHICS, r->pipelines[item->pipeline]);
        if (buffers != item->refined)
            bind_meshes(r, slot, item->refined, cmd);
        bound = (int)item->pipeline;
        buffers = item->refined;
        vkCmdDrawIndexed(cmd, item->mesh.index_count, (uint32_t)(next - i), item->mesh.first_index,
                         (int32_t)item->mesh.first_vertex, (uint32_t)i);
    }
}

// first_eye: the only one, or 0 for both.
static void record_pass(const struct ap_renderer *r, const struct ap_pass *pass,
                        const struct slot *slot, VkFramebuffer framebuffer, int32_t first_eye) {
    VkClearValue clear[2] = {0}; // depth is reversed: 0 is far
    const double *back = r->scene->background_srgb;
    for (int i = 0; i < 3; i++)
        clear[0].color.float32[i] = r->samples.coded ? (float)back[i] : ap_linear_color(back[i]);
    clear[0].color.float32[3] = 1;
    VkRenderPassBeginInfo begin = {
        .sType = VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO,
        .renderPass = pass->render_pass,
        .framebuffer = framebuffer,
        .renderArea = {{0, 0},
                       {r->samples.across * r->params.width, r->samples.across * r->params.height}},
        .clearValueCount = 2,
        .pClearValues = clear};
    vkCmdBeginRenderPass(slot->cmd, &begin, VK_SUBPASS_CONTENTS_INLINE);
    vkCmdBindDescriptorSets(slot->cmd, VK_PIPELINE_BIND_POINT_GRAPHICS, r->layout, 0, 1, &slot->set,
                            0, NULL);
    vkCmdPushConstants(slot->cmd, r->layout, VK_SHADER_STAGE_VERTEX_BIT, 0, sizeof first_eye,
                       &first_eye);
    record_draws(r, slot, pass->views == 2 ? 3 : 1u << first_eye);
    vkCmdEndRenderPass(slot->cmd);
}

static enum ap_status need_pass(struct ap_error *err, struct ap_renderer *r,
                                const struct ap_viewer *viewer, bool both) {
    struct ap_pass_params params = {r->samples.coded ? VK_FORMAT_R8G8B8A8_UNORM
                                                     : r->params.color_format,
                                    r->samples.across * r->params.width,
                                    r->samples.across * r->params.height,
                                    both ? 2 : 1,
                                    r->samples.samples,
                                    r->samples.coded,
                                    r->samples.straight,
                                    ap_draw_list_marks(r->scene),
                                    r->layout};
    enum ap_status st = AP_OK;
    if (!r->pass[both].render_pass) {
        st = ap_pass_create(err, r->gpu, &params, &r->pass[both]);
        if (st == AP_OK && !r->samples.straight)
            ap_resolve_read(r->gpu, &r->resolve, both, r->pass[both].read);
    }
    const struct ap_world world = {viewer->space.kappa, (int)viewer->mode,
                                   ap_viewer_born(viewer).kappa};
    bool needed[AP_PIPELINE_COUNT] = {false};
    for (size_t i = 0; i < r->list.count; i++)
        needed[r->list.items[i].pipeline] = true;
    return st == AP_OK
               ? ap_pass_pipelines(err, r->gpu, world, needed, &r->pass[both], &r->pipelines)
               : st;
}

static enum ap_status record(struct ap_error *err, struct ap_renderer *r,
                             const struct ap_frame_input *input, const struct ap_target *target,
                             struct slot *slot) {
    unsigned closed_eyes = input->closed_eyes;
    bool both = r->multiview && closed_eyes == 0;
    enum ap_status st = need_pass(err, r, &input->viewer, both);
    for (int e = 0; st == AP_OK && e < 2; e++)
        st = bind_target(err, r, target,
                         r->samples.straight && !(closed_eyes >> e & 1) ? &r->pass[both] : NULL,
                         slot, e);
    if (st != AP_OK)
        return st;
    const struct ap_pass *pass = &r->pass[both];
    VkCommandBufferBeginInfo begin = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
                                      .flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT};
    st = ap_vk_check(err, vkBeginCommandBuffer(slot->cmd, &begin), "vkBeginCommandBuffer");
    if (st != AP_OK)
        return st;
    uint32_t times = 2 * (uint32_t)(slot - r->slot);
    if (r->times) {
        vkCmdResetQueryPool(slot->cmd, r->times, times, 2);
        vkCmdWriteTimestamp(slot->cmd, VK_PIPELINE_STAGE_TOP_OF_PIPE_BIT, r->times, times);
    }
    for (int e = 0; e < 2; e++) {
        if (closed_eyes >> e & 1) {
            ap_resolve_blacken(&r->resolve, slot->cmd, slot->framebuffer[e]);
            continue;
        }
        if (e == 0 || !both)
            record_pass(r, pass, slot,
                        r->samples.straight ? slot->framebuffer[e] : pass->framebuffer, e);
        if (!r->samples.straight)
            ap_resolve_record(&r->resolve, slot->cmd, both, both ? e : 0, slot->framebuffer[e]);
    }
    if (r->times)
        vkCmdWriteTimestamp(slot->cmd, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, r->times, times + 1);
    return ap_vk_check(err, vkEndCommandBuffer(slot->cmd), "vkEndCommandBuffer");
}

static enum ap_status make_room(struct ap_error *err, const struct ap_renderer *r, size_t size,
                                VkBufferUsageFlags usage, struct ap_gpu_buffer *buffer) {
    if (size <= buffer->size)
        return AP_OK;
    ap_gpu_buffer_destroy(r->gpu, buffer);
    return ap_gpu_buffer_create(err, r->gpu, ap_grown(size), usage, true, buffer);
}

// The frame's own meshes, to where the GPU reads them; the slot is not in use.
static enum ap_status take_refined(struct ap_error *err, const struct ap_renderer *r,
                                   struct slot *slot) {
    const struct ap_mesh_data *data = &r->list.refined;
    size_t vertices = data->vertex_count * sizeof *data->vertices,
           indices = data->index_count * sizeof *data->indices;
    if (indices == 0)
        return AP_OK;
    enum ap_status st =
        make_room(err, r, vertices, VK_BUFFER_USAGE_VERTEX_BUFFER_BIT, &slot->vertices);
    if (st == AP_OK)
        st = make_room(err, r, indices, VK_BUFFER_USAGE_INDEX_BUFFER_BIT, &slot->indices);
    if (st == AP_OK) {
        memcpy(slot->vertices.mapped, data->vertices, vertices);
        memcpy(slot->indices.mapped, data->indices, indices);
    }
    return st;
}

// The list may be longer than any before; the slot is not in use.
static enum ap_status hold_draws(struct ap_error *err, const struct ap_renderer *r,
                                 struct slot *slot) {
    VkDeviceSize size = r->list.count * sizeof(struct ap_gpu_draw);
    if (size <= slot->draws.size)
        return AP_OK;
    struct ap_gpu_buffer larger = {0};
    enum ap_status st = ap_gpu_buffer_create(err, r->gpu, ap_grown(size),
                                             VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, true, &larger);
    if (st != AP_OK)
        return st;
    ap_gpu_buffer_destroy(r->gpu, &slot->draws);
    slot->draws = larger;
    bind_slot_set(r, slot);
    return AP_OK;
}

// What is drawn in this frame, into the slot's buffers.
static enum ap_status place(struct ap_error *err, struct ap_renderer *r,
                            const struct ap_frame_input *input, struct slot *slot) {
    const struct ap_viewer *viewer = &input->viewer;
    struct ap_eyes eyes = ap_eyes_of(viewer, r->params.width, r->params.height);
    const struct ap_list_params what = {.scene = r->scene,
                                        .meshes = &r->meshes,
                                        .input = input,
                                        .eyes = &eyes,
                                        .width_px = r->samples.across * r->params.width,
                                        .height_px = r->samples.across * r->params.height,
                                        .max_error_px = r->max_error_px,
                                        .no_cull = r->params.no_cull};
    enum ap_status st = ap_draw_list_fill(err, &what, &r->list);
    if (st == AP_OK && r->scene->honeycomb)
        st = ap_cell_view_fill(err, &r->cells, &what, &r->list);
    if (st == AP_OK)
        st = take_refined(err, r, slot);
    if (st == AP_OK)
        st = hold_draws(err, r, slot);
    if (st != AP_OK)
        return st;
    ap_draw_list_sort(&r->list);
    struct ap_gpu_frame frame = ap_frame_of(viewer, r->scene->honeycomb != NULL);
    ap_frame_light(viewer, &eyes, r->scene->lamp_reach_m, r->scene->lamp_radius_m, &frame);
    ap_frame_depth(viewer, &eyes, &r->list.range, &frame);
    memcpy(slot->frame.mapped, &frame, sizeof frame);
    ap_draw_list_write(r->scene, input, &eyes, &r->list, slot->draws.mapped, slot->marks.mapped);
    return AP_OK;
}

static void tell_budget(struct ap_renderer *r) {
    if (r->list.stats.over_budget == 0 || r->told_budget || r->cells.warned)
        return;
    r->told_budget = true;
    ap_log(AP_LOG_WARNING,
           "the budget of %.3g MiB has no room for the triangles that --max-error asks for: some "
           "surfaces are drawn coarser (give a larger --budget)",
           (double)ap_scene_budget(r->scene) / 1048576);
}

static int64_t now(const struct ap_renderer *r) {
    return r->params.now_ns ? r->params.now_ns() : 0;
}

enum ap_status ap_renderer_draw(struct ap_error *err, struct ap_renderer *r,
                                const struct ap_frame_input *input, const struct ap_target *target,
                                struct ap_frame_stats *stats) {
    struct slot *slot = &r->slot[r->frame % RING];
    int64_t t0 = now(r);
    enum ap_status st = wait_for(err, r, slot);
    if (st != AP_OK)
        return st;
    release_targets(r->gpu, slot);
    int64_t t1 = now(r);
    st = place(err, r, input, slot);
    int64_t t2 = now(r);
    if (st == AP_OK)
        st = record(err, r, input, target, slot);
    if (st != AP_OK)
        return st;
    int64_t t3 = now(r);
    VkSubmitInfo submit = {.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO,
                           .commandBufferCount = 1,
                           .pCommandBuffers = &slot->cmd};
    st = ap_vk_check(err, vkQueueSubmit(r->gpu->queue, 1, &submit, slot->fence), "vkQueueSubmit");
    if (st != AP_OK)
        return st;
    slot->busy = true;
    r->frame++;
    tell_budget(r);
    if (!stats)
        return AP_OK;
    *stats = r->list.stats;
    stats->held_bytes = held_bytes(r);
    stats->wait_ms = (double)(t1 - t0) * 1e-6;
    stats->place_ms = (double)(t2 - t1) * 1e-6;
    stats->record_ms = (double)(t3 - t2) * 1e-6;
    stats->submit_ms = (double)(now(r) - t3) * 1e-6;
    return AP_OK;
}
