#include "sim_hmd/compose/slot.h"

#include <string.h>

// One batch's shapes, at a distance that every device takes as an offset.
enum { SHAPES_STRIDE = 512 };
_Static_assert(SIM_PASS_FUSED * sizeof(struct sim_shape) <= SHAPES_STRIDE, "shapes fit");

enum ap_status sim_slot_create(struct ap_error *err, const struct ap_gpu *gpu, VkCommandPool pool,
                               struct sim_slot *slot) {
    VkCommandBufferAllocateInfo info = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
                                        .commandPool = pool,
                                        .level = VK_COMMAND_BUFFER_LEVEL_PRIMARY,
                                        .commandBufferCount = 1};
    enum ap_status st = ap_vk_check(err, vkAllocateCommandBuffers(gpu->device, &info, &slot->cmd),
                                    "vkAllocateCommandBuffers");
    if (st)
        return st;
    VkFenceCreateInfo fence = {.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
    return ap_vk_check(err, vkCreateFence(gpu->device, &fence, NULL, &slot->fence),
                       "vkCreateFence");
}

void sim_slot_recycle(const struct ap_gpu *gpu, struct sim_slot *slot) {
    for (uint32_t k = 0; k < slot->view_count; k++)
        vkDestroyImageView(gpu->device, slot->views[k], NULL);
    for (uint32_t k = 0; k < slot->resolved_count; k++)
        ap_gpu_image_destroy(gpu, &slot->resolved[k]);
    slot->view_count = slot->resolved_count = 0;
}

void sim_slot_destroy(const struct ap_gpu *gpu, struct sim_slot *slot) {
    sim_slot_recycle(gpu, slot);
    for (int eye = 0; eye < 2; eye++)
        ap_gpu_buffer_destroy(gpu, &slot->eye[eye]);
    ap_gpu_buffer_destroy(gpu, &slot->preview);
    ap_gpu_buffer_destroy(gpu, &slot->shapes);
    vkDestroyDescriptorPool(gpu->device, slot->descriptors, NULL);
    vkDestroyFence(gpu->device, slot->fence, NULL);
    *slot = (struct sim_slot){0}; // the command buffer goes with its pool
}

enum ap_status sim_slot_descriptors(struct ap_error *err, const struct ap_gpu *gpu,
                                    const struct sim_pass *pass, struct sim_slot *slot) {
    if (slot->descriptors)
        return AP_OK;
    enum ap_status st = AP_OK;
    if (!slot->shapes.buffer)
        st = ap_gpu_buffer_create(err, gpu, (VkDeviceSize)SIM_MAX_VIEWS * SHAPES_STRIDE,
                                  VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT, true, &slot->shapes);
    if (st)
        return st;
    VkDescriptorPoolSize sizes[2] = {
        {VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, SIM_PASS_FUSED * SIM_MAX_VIEWS},
        {VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, SIM_MAX_VIEWS}};
    VkDescriptorPoolCreateInfo info = {.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO,
                                       .maxSets = SIM_MAX_VIEWS,
                                       .poolSizeCount = 2,
                                       .pPoolSizes = sizes};
    VkDescriptorPool pool;
    st = ap_vk_check(err, vkCreateDescriptorPool(gpu->device, &info, NULL, &pool),
                     "vkCreateDescriptorPool");
    if (st)
        return st;
    VkDescriptorSetLayout layouts[SIM_MAX_VIEWS];
    for (int k = 0; k < SIM_MAX_VIEWS; k++)
        layouts[k] = pass->set_layout;
    VkDescriptorSetAllocateInfo sets = {.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO,
                                        .descriptorPool = pool,
                                        .descriptorSetCount = SIM_MAX_VIEWS,
                                        .pSetLayouts = layouts};
    st = ap_vk_check(err, vkAllocateDescriptorSets(gpu->device, &sets, &slot->sets[0][0]),
                     "vkAllocateDescriptorSets");
    if (st)
        vkDestroyDescriptorPool(gpu->device, pool, NULL);
    else
        slot->descriptors = pool;
    return st;
}

// A one-sample copy of the view's layer of a multisampled image.
static enum ap_status resolve(struct ap_error *err, const struct ap_gpu *gpu, struct sim_slot *slot,
                              const struct sim_layer_view *view, VkImageLayout layout,
                              VkImageView *image_view) {
    VkImageCreateInfo info = {.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
                              .imageType = VK_IMAGE_TYPE_2D,
                              .format = view->format,
                              .extent = {view->width_px, view->height_px, 1},
                              .mipLevels = 1,
                              .arrayLayers = 1,
                              .samples = VK_SAMPLE_COUNT_1_BIT,
                              .tiling = VK_IMAGE_TILING_OPTIMAL,
                              .usage = VK_IMAGE_USAGE_TRANSFER_DST_BIT | VK_IMAGE_USAGE_SAMPLED_BIT,
                              .initialLayout = VK_IMAGE_LAYOUT_UNDEFINED};
    struct ap_gpu_image *image = &slot->resolved[slot->resolved_count];
    enum ap_status st = ap_gpu_image_create(err, gpu, &info, VK_IMAGE_VIEW_TYPE_2D,
                                            VK_IMAGE_ASPECT_COLOR_BIT, image);
    if (st)
        return st;
    slot->resolved_count++;
    VkImageResolve region = {.srcSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, view->array_layer, 1},
                             .dstSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1},
                             .extent = info.extent};
    ap_gpu_barrier(slot->cmd, image->image, VK_IMAGE_ASPECT_COLOR_BIT, VK_IMAGE_LAYOUT_UNDEFINED,
                   VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
    vkCmdResolveImage(slot->cmd, view->image, layout, image->image,
                      VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &region);
    ap_gpu_barrier(slot->cmd, image->image, VK_IMAGE_ASPECT_COLOR_BIT,
                   VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);
    *image_view = image->view;
    return AP_OK;
}

static enum ap_status view_layer(struct ap_error *err, const struct ap_gpu *gpu,
                                 struct sim_slot *slot, const struct sim_layer_view *view,
                                 bool cube, VkImageView *image_view) {
    VkImageViewCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO,
        .image = view->image,
        .viewType = cube ? VK_IMAGE_VIEW_TYPE_CUBE : VK_IMAGE_VIEW_TYPE_2D,
        .format = view->format,
        .subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, view->mips > 1 ? view->mips : 1,
                             view->array_layer, cube ? 6 : 1}};
    enum ap_status st = ap_vk_check(err, vkCreateImageView(gpu->device, &info, NULL, image_view),
                                    "vkCreateImageView");
    if (!st)
        slot->views[slot->view_count++] = *image_view;
    return st;
}

static enum ap_status image_of(struct ap_error *err, const struct ap_gpu *gpu,
                               const struct sim_pass *pass, struct sim_slot *slot,
                               const struct sim_plan *plan, int eye,
                               const struct sim_drawing *drawing, VkDescriptorImageInfo *image) {
    const struct sim_layer *layer = &plan->frame->layer[drawing->layer];
    const struct sim_layer_view *view = &layer->view[eye];
    VkImageLayout layout = sim_plan_layout(plan, view->image);
    enum ap_status st;
    if (view->samples > 1) {
        image->imageLayout = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL;
        st = resolve(err, gpu, slot, view, layout, &image->imageView);
    } else {
        image->imageLayout = layout;
        st = view_layer(err, gpu, slot, view, layer->kind == SIM_LAYER_CUBE, &image->imageView);
    }
    if (st)
        return st;
    VkFormatProperties format;
    vkGetPhysicalDeviceFormatProperties(gpu->physical_device, view->format, &format);
    bool filters = format.optimalTilingFeatures & VK_FORMAT_FEATURE_SAMPLED_IMAGE_FILTER_LINEAR_BIT;
    image->sampler = !filters               ? pass->nearest
                     : drawing->seen.around ? pass->linear_around
                                            : pass->linear;
    return AP_OK;
}

enum ap_status sim_slot_bind(struct ap_error *err, const struct ap_gpu *gpu,
                             const struct sim_pass *pass, struct sim_slot *slot,
                             const struct sim_plan *plan, int eye, uint32_t batch) {
    const struct sim_batch *b = &plan->batches[eye][batch];
    const struct sim_drawing *drawings = &plan->drawings[eye][b->first];
    VkDeviceSize offset = (VkDeviceSize)((uint32_t)eye * SIM_MAX_LAYERS + batch) * SHAPES_STRIDE;
    VkDescriptorImageInfo images[SIM_PASS_FUSED];
    for (uint32_t k = 0; k < SIM_PASS_FUSED; k++) {
        if (k >= b->count) { // a set wants all of its places filled
            images[k] = images[0];
            continue;
        }
        enum ap_status st = image_of(err, gpu, pass, slot, plan, eye, &drawings[k], &images[k]);
        if (st)
            return st;
        memcpy((char *)slot->shapes.mapped + offset + k * sizeof(struct sim_shape),
               &drawings[k].seen.shape, sizeof(struct sim_shape));
    }
    VkDescriptorBufferInfo shapes = {slot->shapes.buffer, offset, SHAPES_STRIDE};
    VkWriteDescriptorSet writes[2] = {{.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                       .dstSet = slot->sets[eye][batch],
                                       .descriptorCount = SIM_PASS_FUSED,
                                       .descriptorType = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER,
                                       .pImageInfo = images},
                                      {.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                       .dstSet = slot->sets[eye][batch],
                                       .dstBinding = SIM_PASS_FUSED,
                                       .descriptorCount = 1,
                                       .descriptorType = VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER,
                                       .pBufferInfo = &shapes}};
    vkUpdateDescriptorSets(gpu->device, 2, writes, 0, NULL);
    return AP_OK;
}
