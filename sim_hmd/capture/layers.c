#include "sim_hmd/capture/layers.h"

#include <pthread.h>
#include <stdlib.h>

#include "sim_hmd/capture/depth.h"

enum { SLOTS = 4, WRITERS = 2, MAX_PICTURES = SIM_LAYER_PARTS_MAX * SIM_MAX_LAYERS };

// Read-back memory of all slots together; one frame alone may take more.
static const VkDeviceSize SLOT_BYTES = 256u << 20;

// A picture, and where the program has it.
struct picture {
    struct sim_capture_layer which;
    VkImage image;
    VkFormat format;
    uint32_t samples, array_layer;
    VkOffset3D from;
    uint32_t width_px, height_px;
    float min, max;      // a depth's range
    VkDeviceSize offset; // in the slot's buffer
};

struct slot {
    struct sim_layer_capture *owner;
    VkCommandBuffer cmd;
    VkFence fence;
    struct ap_gpu_buffer buffer;
    struct picture picture[MAX_PICTURES];
    uint32_t picture_count;
    struct ap_gpu_image made[2 * MAX_PICTURES]; // resolved or converted, for this frame
    uint32_t made_count;
    int pending; // jobs; the owner's lock
};

struct sim_layer_capture {
    const struct ap_gpu *gpu;
    VkCommandPool pool;
    struct slot slot[SLOTS];
    int slot_count;
    pthread_mutex_t lock;
    pthread_cond_t freed;
    struct sim_capture *writers;
};

int sim_layer_capture_parts(const struct sim_layer *layer,
                            enum sim_part parts[SIM_LAYER_PARTS_MAX]) {
    int count = 0;
    if (layer->kind == SIM_LAYER_CUBE) {
        for (; count < 6; count++)
            parts[count] = (enum sim_part)(SIM_PART_FACE + count);
        return count;
    }
    if (layer->kind != SIM_LAYER_PROJECTION) {
        parts[count++] = SIM_PART_ONLY;
        return count;
    }
    parts[count++] = SIM_PART_LEFT;
    parts[count++] = SIM_PART_RIGHT;
    for (int eye = 0; eye < 2; eye++)
        if (layer->has_depth[eye] && layer->depth[eye].samples == 1)
            parts[count++] = eye ? SIM_PART_DEPTH_RIGHT : SIM_PART_DEPTH_LEFT;
    return count;
}

static bool is_depth(const struct picture *p) {
    return p->which.part == SIM_PART_DEPTH_LEFT || p->which.part == SIM_PART_DEPTH_RIGHT;
}

static bool is_bgra(VkFormat format) {
    return format == VK_FORMAT_B8G8R8A8_SRGB || format == VK_FORMAT_B8G8R8A8_UNORM;
}

static bool is_linear(VkFormat format) {
    return format == VK_FORMAT_R8G8B8A8_UNORM || format == VK_FORMAT_B8G8R8A8_UNORM;
}

// ---- Jobs: on the writers' threads

static enum ap_status write_depth(struct ap_error *err, const struct sim_layer_capture *c,
                                  const struct picture *p, const void *texels) {
    size_t count = (size_t)p->width_px * p->height_px;
    uint16_t *values = malloc(count * sizeof *values);
    if (!values)
        return ap_fail(err, AP_ENVIRONMENT, "no memory for a depth of %ux%u pixels", p->width_px,
                       p->height_px);
    sim_depth_values(texels, p->format, count, p->min, p->max, values);
    enum ap_status st = sim_capture_write_depth(
        err, c->writers, &p->which, &(struct ap_grey){values, p->width_px, p->height_px});
    free(values);
    return st;
}

static enum ap_status write_picture(struct ap_error *err, const struct sim_layer_capture *c,
                                    const struct picture *p, const uint8_t *texels) {
    if (is_depth(p))
        return write_depth(err, c, p, texels);
    struct ap_pixels pixels = {texels, p->width_px, p->height_px, (size_t)p->width_px * 4,
                               is_bgra(p->format)};
    return sim_capture_write_layer(err, c->writers, &p->which, &pixels);
}

static enum ap_status run_job(struct ap_error *err, void *user, int what) {
    struct slot *slot = user;
    struct sim_layer_capture *c = slot->owner;
    const struct picture *p = &slot->picture[what];
    enum ap_status st =
        ap_vk_check(err, vkWaitForFences(c->gpu->device, 1, &slot->fence, VK_TRUE, UINT64_MAX),
                    "a layer's picture was not finished: vkWaitForFences");
    if (!st)
        st = write_picture(err, c, p, (const uint8_t *)slot->buffer.mapped + p->offset);
    pthread_mutex_lock(&c->lock);
    if (--slot->pending == 0)
        pthread_cond_signal(&c->freed);
    pthread_mutex_unlock(&c->lock);
    return st;
}

// ---- Slots

static void recycle(const struct ap_gpu *gpu, struct slot *slot) {
    for (uint32_t k = 0; k < slot->made_count; k++)
        ap_gpu_image_destroy(gpu, &slot->made[k]);
    slot->made_count = slot->picture_count = 0;
}

// The lock is held. Buffers of idle slots give way to what is needed now.
static bool has_room(struct sim_layer_capture *c, const struct slot *taken, VkDeviceSize bytes) {
    VkDeviceSize busy = 0, idle = 0;
    for (int k = 0; k < c->slot_count; k++)
        if (&c->slot[k] != taken)
            *(c->slot[k].pending ? &busy : &idle) += c->slot[k].buffer.size;
    for (int k = 0; k < c->slot_count && busy + idle + bytes > SLOT_BYTES; k++)
        if (&c->slot[k] != taken && c->slot[k].pending == 0) {
            idle -= c->slot[k].buffer.size;
            ap_gpu_buffer_destroy(c->gpu, &c->slot[k].buffer);
        }
    return busy == 0 || busy + bytes <= SLOT_BYTES;
}

// Waits for the writers where all slots, or all the memory, are in use.
static struct slot *take_slot(struct sim_layer_capture *c, VkDeviceSize bytes) {
    struct slot *slot = NULL;
    pthread_mutex_lock(&c->lock);
    for (;;) {
        for (int k = 0; k < c->slot_count && !slot; k++)
            if (c->slot[k].pending == 0)
                slot = &c->slot[k];
        if (slot && has_room(c, slot, bytes))
            break;
        slot = NULL;
        pthread_cond_wait(&c->freed, &c->lock);
    }
    pthread_mutex_unlock(&c->lock);
    recycle(c->gpu, slot);
    return slot;
}

static enum ap_status make_buffer(struct ap_error *err, const struct ap_gpu *gpu,
                                  VkDeviceSize bytes, struct ap_gpu_buffer *buffer) {
    if (buffer->size >= bytes)
        return AP_OK;
    ap_gpu_buffer_destroy(gpu, buffer);
    return ap_gpu_buffer_create(err, gpu, bytes, VK_BUFFER_USAGE_TRANSFER_DST_BIT, true, buffer);
}

// ---- What is to be read back

struct plan {
    struct picture picture[MAX_PICTURES];
    uint32_t count;
    VkDeviceSize bytes;
};

static bool eight_bits(VkFormat format) {
    return format == VK_FORMAT_R8G8B8A8_SRGB || format == VK_FORMAT_B8G8R8A8_SRGB ||
           format == VK_FORMAT_R8G8B8A8_UNORM || format == VK_FORMAT_B8G8R8A8_UNORM;
}

static struct picture depth_picture(const struct sim_layer_depth *d) {
    return (struct picture){.image = d->image,
                            .format = d->format,
                            .samples = d->samples,
                            .array_layer = d->array_layer,
                            .from = {d->rect.offset.x, d->rect.offset.y, 0},
                            .width_px = (uint32_t)d->rect.extent.width,
                            .height_px = (uint32_t)d->rect.extent.height,
                            .min = d->min,
                            .max = d->max};
}

static struct picture colour_picture(const struct sim_layer_view *v, uint32_t face) {
    return (struct picture){.image = v->image,
                            .format = v->format,
                            .samples = v->samples,
                            .array_layer = v->array_layer + face,
                            .from = {v->rect.offset.x, v->rect.offset.y, 0},
                            .width_px = (uint32_t)v->rect.extent.width,
                            .height_px = (uint32_t)v->rect.extent.height};
}

static struct picture picture_of(const struct sim_layer *layer, enum sim_part part) {
    switch (part) {
    case SIM_PART_LEFT:
    case SIM_PART_RIGHT:
        return colour_picture(&layer->view[part], 0);
    case SIM_PART_DEPTH_LEFT:
    case SIM_PART_DEPTH_RIGHT:
        return depth_picture(&layer->depth[part - SIM_PART_DEPTH_LEFT]);
    case SIM_PART_ONLY:
        return colour_picture(&layer->view[0], 0);
    default:
        return colour_picture(&layer->view[0], (uint32_t)(part - SIM_PART_FACE));
    }
}

static void add_picture(struct plan *plan, const struct sim_frame *frame, int layer,
                        enum sim_part part) {
    const struct sim_layer *l = &frame->layer[layer];
    struct picture *p = &plan->picture[plan->count++];
    *p = picture_of(l, part);
    p->offset = plan->bytes;
    p->which = (struct sim_capture_layer){.frame = frame->index,
                                          .layer = layer,
                                          .part = part,
                                          .alpha = l->blend_alpha,
                                          .linear = is_linear(p->format)};
    VkDeviceSize texel = is_depth(p) ? sim_depth_texel_bytes(p->format) : 4;
    plan->bytes += (texel * p->width_px * p->height_px + 3) & ~(VkDeviceSize)3;
}

static void make_plan(const struct sim_frame *frame, struct plan *plan) {
    plan->count = 0;
    plan->bytes = 0;
    for (int layer = 0; layer < (int)frame->layer_count; layer++) {
        enum sim_part parts[SIM_LAYER_PARTS_MAX];
        int count = sim_layer_capture_parts(&frame->layer[layer], parts);
        for (int k = 0; k < count; k++)
            add_picture(plan, frame, layer, parts[k]);
    }
}

// ---- Commands

static void turn_images(VkCommandBuffer cmd, const struct plan *plan, bool back) {
    const VkImageLayout source = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL;
    for (uint32_t k = 0; k < plan->count; k++) {
        const struct picture *p = &plan->picture[k];
        const VkImageLayout released = is_depth(p)
                                           ? VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL
                                           : VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL;
        bool seen = false;
        for (uint32_t i = 0; i < k; i++)
            seen |= plan->picture[i].image == p->image;
        if (!seen)
            ap_gpu_barrier(cmd, p->image, ap_gpu_aspect(p->format), back ? source : released,
                           back ? released : source);
    }
}

// A part of a picture on its way to the buffer.
struct source {
    VkImage image;
    uint32_t array_layer;
    VkOffset3D offset;
};

static enum ap_status make_image(struct ap_error *err, const struct ap_gpu *gpu, struct slot *slot,
                                 VkFormat format, const struct picture *p, VkImage *out) {
    VkImageCreateInfo info = {.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
                              .imageType = VK_IMAGE_TYPE_2D,
                              .format = format,
                              .extent = {p->width_px, p->height_px, 1},
                              .mipLevels = 1,
                              .arrayLayers = 1,
                              .samples = VK_SAMPLE_COUNT_1_BIT,
                              .tiling = VK_IMAGE_TILING_OPTIMAL,
                              .usage =
                                  VK_IMAGE_USAGE_TRANSFER_DST_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT,
                              .initialLayout = VK_IMAGE_LAYOUT_UNDEFINED};
    struct ap_gpu_image *image = &slot->made[slot->made_count];
    enum ap_status st = ap_gpu_image_create(err, gpu, &info, VK_IMAGE_VIEW_TYPE_2D,
                                            VK_IMAGE_ASPECT_COLOR_BIT, image);
    if (st)
        return st;
    slot->made_count++;
    ap_gpu_barrier(slot->cmd, image->image, VK_IMAGE_ASPECT_COLOR_BIT, VK_IMAGE_LAYOUT_UNDEFINED,
                   VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
    *out = image->image;
    return AP_OK;
}

static void readable(VkCommandBuffer cmd, VkImage image, struct source *source) {
    ap_gpu_barrier(cmd, image, VK_IMAGE_ASPECT_COLOR_BIT, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                   VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
    *source = (struct source){.image = image};
}

// The mean of the samples.
static enum ap_status resolve(struct ap_error *err, const struct ap_gpu *gpu, struct slot *slot,
                              VkFormat format, const struct picture *p, struct source *source) {
    VkImage image;
    enum ap_status st = make_image(err, gpu, slot, format, p, &image);
    if (st)
        return st;
    VkImageResolve region = {
        .srcSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, source->array_layer, 1},
        .srcOffset = source->offset,
        .dstSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1},
        .extent = {p->width_px, p->height_px, 1}};
    vkCmdResolveImage(slot->cmd, source->image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, image,
                      VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &region);
    readable(slot->cmd, image, source);
    return AP_OK;
}

// Into sRGB of 8 bits, cut to 0…1: what has more bits than a picture.
static enum ap_status convert(struct ap_error *err, const struct ap_gpu *gpu, struct slot *slot,
                              const struct picture *p, struct source *source) {
    VkImage image;
    enum ap_status st = make_image(err, gpu, slot, VK_FORMAT_R8G8B8A8_SRGB, p, &image);
    if (st)
        return st;
    int32_t w = (int32_t)p->width_px, h = (int32_t)p->height_px;
    VkImageBlit region = {
        .srcSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, source->array_layer, 1},
        .srcOffsets = {source->offset, {source->offset.x + w, source->offset.y + h, 1}},
        .dstSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1},
        .dstOffsets = {{0, 0, 0}, {w, h, 1}}};
    vkCmdBlitImage(slot->cmd, source->image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, image,
                   VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &region, VK_FILTER_NEAREST);
    readable(slot->cmd, image, source);
    return AP_OK;
}

static enum ap_status record_picture(struct ap_error *err, const struct ap_gpu *gpu,
                                     struct slot *slot, const struct picture *p) {
    struct source source = {p->image, p->array_layer, p->from};
    enum ap_status st = AP_OK;
    if (p->samples > 1)
        st = resolve(err, gpu, slot, p->format, p, &source);
    if (!st && !is_depth(p) && !eight_bits(p->format))
        st = convert(err, gpu, slot, p, &source);
    if (st)
        return st;
    VkBufferImageCopy region = {
        .bufferOffset = p->offset,
        .imageSubresource = {is_depth(p) ? VK_IMAGE_ASPECT_DEPTH_BIT : VK_IMAGE_ASPECT_COLOR_BIT, 0,
                             source.array_layer, 1},
        .imageOffset = source.offset,
        .imageExtent = {p->width_px, p->height_px, 1}};
    vkCmdCopyImageToBuffer(slot->cmd, source.image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
                           slot->buffer.buffer, 1, &region);
    return AP_OK;
}

static enum ap_status record(struct ap_error *err, const struct ap_gpu *gpu, struct slot *slot,
                             const struct plan *plan) {
    VkCommandBufferBeginInfo begin = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
                                      .flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT};
    enum ap_status st =
        ap_vk_check(err, vkBeginCommandBuffer(slot->cmd, &begin), "vkBeginCommandBuffer");
    if (st)
        return st;
    turn_images(slot->cmd, plan, false);
    for (uint32_t k = 0; k < plan->count && !st; k++)
        st = record_picture(err, gpu, slot, &plan->picture[k]);
    if (st)
        return st;
    turn_images(slot->cmd, plan, true);
    VkMemoryBarrier host = {.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER,
                            .srcAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT,
                            .dstAccessMask = VK_ACCESS_HOST_READ_BIT};
    vkCmdPipelineBarrier(slot->cmd, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_PIPELINE_STAGE_HOST_BIT, 0,
                         1, &host, 0, NULL, 0, NULL);
    return ap_vk_check(err, vkEndCommandBuffer(slot->cmd), "vkEndCommandBuffer");
}

static enum ap_status submit(struct ap_error *err, const struct ap_gpu *gpu, struct slot *slot,
                             const struct plan *plan) {
    enum ap_status st = make_buffer(err, gpu, plan->bytes, &slot->buffer);
    if (!st)
        st = record(err, gpu, slot, plan);
    if (!st)
        st = ap_vk_check(err, vkResetFences(gpu->device, 1, &slot->fence), "vkResetFences");
    VkSubmitInfo info = {.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO,
                         .commandBufferCount = 1,
                         .pCommandBuffers = &slot->cmd};
    if (!st)
        st = ap_vk_check(err, vkQueueSubmit(gpu->queue, 1, &info, slot->fence), "vkQueueSubmit");
    return st;
}

enum ap_status sim_layer_capture_frame(struct ap_error *err, struct sim_layer_capture *c,
                                       const struct sim_frame *frame) {
    struct plan plan;
    make_plan(frame, &plan);
    enum ap_status st = sim_capture_error(err, c->writers);
    if (st || plan.count == 0)
        return st;
    struct slot *slot = take_slot(c, plan.bytes);
    st = submit(err, c->gpu, slot, &plan);
    if (st)
        return st;
    for (uint32_t k = 0; k < plan.count; k++)
        slot->picture[k] = plan.picture[k];
    slot->picture_count = plan.count;
    pthread_mutex_lock(&c->lock);
    slot->pending = (int)plan.count;
    pthread_mutex_unlock(&c->lock);
    for (uint32_t k = 0; k < plan.count; k++)
        sim_capture_add(c->writers, &(struct sim_capture_job){run_job, slot, (int)k});
    return AP_OK;
}

// ---- Its life

static enum ap_status create_slot(struct ap_error *err, struct sim_layer_capture *c,
                                  struct slot *slot) {
    VkCommandBufferAllocateInfo info = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
                                        .commandPool = c->pool,
                                        .level = VK_COMMAND_BUFFER_LEVEL_PRIMARY,
                                        .commandBufferCount = 1};
    VkFenceCreateInfo fence = {.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
    slot->owner = c;
    enum ap_status st =
        ap_vk_check(err, vkAllocateCommandBuffers(c->gpu->device, &info, &slot->cmd),
                    "vkAllocateCommandBuffers");
    if (!st)
        st = ap_vk_check(err, vkCreateFence(c->gpu->device, &fence, NULL, &slot->fence),
                         "vkCreateFence");
    return st;
}

enum ap_status sim_layer_capture_create(struct ap_error *err, const struct ap_gpu *gpu,
                                        const struct sim_settings *settings,
                                        struct sim_layer_capture **capture) {
    struct sim_layer_capture *c = calloc(1, sizeof *c);
    if (!c)
        return ap_fail(err, AP_ENVIRONMENT, "out of memory");
    c->gpu = gpu;
    pthread_mutex_init(&c->lock, NULL);
    pthread_cond_init(&c->freed, NULL);
    VkCommandPoolCreateInfo pool = {.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
                                    .flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT,
                                    .queueFamilyIndex = gpu->queue_family};
    enum ap_status st = sim_capture_create(err, settings, WRITERS, &c->writers);
    if (!st)
        st = ap_vk_check(err, vkCreateCommandPool(gpu->device, &pool, NULL, &c->pool),
                         "vkCreateCommandPool");
    while (!st && c->slot_count < SLOTS)
        st = create_slot(err, c, &c->slot[c->slot_count++]);
    if (st)
        sim_layer_capture_destroy(c);
    else
        *capture = c;
    return st;
}

enum ap_status sim_layer_capture_flush(struct ap_error *err, struct sim_layer_capture *c) {
    return sim_capture_flush(err, c->writers);
}

void sim_layer_capture_destroy(struct sim_layer_capture *c) {
    if (!c)
        return;
    sim_capture_destroy(c->writers); // every fence has been waited for then
    for (int k = 0; k < c->slot_count; k++) {
        recycle(c->gpu, &c->slot[k]);
        ap_gpu_buffer_destroy(c->gpu, &c->slot[k].buffer);
        vkDestroyFence(c->gpu->device, c->slot[k].fence, NULL);
    }
    vkDestroyCommandPool(c->gpu->device, c->pool, NULL);
    pthread_cond_destroy(&c->freed);
    pthread_mutex_destroy(&c->lock);
    free(c);
}
