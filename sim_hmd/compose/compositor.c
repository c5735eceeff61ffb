#include "sim_hmd/compose/compositor.h"

#include <inttypes.h>
#include <pthread.h>
#include <stdlib.h>

#include "sim_hmd/capture/capture.h"
#include "sim_hmd/compose/pass.h"
#include "sim_hmd/compose/plan.h"
#include "sim_hmd/compose/slot.h"
#include "sim_hmd/core/hot.h"
#include "sim_hmd/window/window.h"
#include "src/base/log.h"

enum {
    MAX_SLOTS = 4,
    WRITERS = 2,
    PREVIEW = 2, // a job's `what`: 0 and 1 are the eyes
    PREVIEW_MAX_WIDTH_PX = 960,
    PREVIEW_MAX_HEIGHT_PX = 720,
    PREVIEW_ALONE_WIDTH_PX = 1920, // of one eye that has the window for itself
    PREVIEW_ALONE_HEIGHT_PX = 1080,
};

// Read-back memory of all slots together; two slots are made in any case.
static const uint64_t SLOT_BYTES = 256u << 20;

struct sim_compositor {
    const struct ap_gpu *gpu;
    const struct sim_settings *settings;
    VkCommandPool pool;
    struct sim_pass pass; // made when a frame is first composed, as are the targets
    struct sim_pass_target eye[2], preview;
    VkRect2D preview_part[2];
    struct sim_plan plan; // the present frame's; large
    struct sim_slot slots[MAX_SLOTS];
    int slot_count;
    pthread_mutex_t lock;
    pthread_cond_t freed;
    struct sim_capture *capture; // NULL: nothing is ever looked at
    struct sim_window *window;
    struct sim_compositor_stats stats;
};

// ---- Jobs: on the writers' threads

static enum ap_status run_job(struct ap_error *err, void *user, int what) {
    struct sim_slot *slot = user;
    struct sim_compositor *c = slot->owner;
    enum ap_status st =
        ap_vk_check(err, vkWaitForFences(c->gpu->device, 1, &slot->fence, VK_TRUE, UINT64_MAX),
                    "the frame's picture was not finished: vkWaitForFences");
    if (!st && what == PREVIEW) {
        sim_window_show(c->window, slot->frame, slot->preview.mapped);
    } else if (!st) {
        const struct ap_eye_profile *eye = &c->settings->profile.eye[what];
        struct ap_pixels pixels = {slot->eye[what].mapped, eye->width_px, eye->height_px,
                                   (size_t)eye->width_px * 4, slot->bgra[what]};
        st = sim_capture_write(err, c->capture, slot->frame, what, &pixels);
    }
    pthread_mutex_lock(&c->lock);
    if (--slot->pending == 0)
        pthread_cond_signal(&c->freed);
    pthread_mutex_unlock(&c->lock);
    return st;
}

// A slot that nothing works on any more; waits for one if asked to, else NULL.
static struct sim_slot *take_slot(struct sim_compositor *c, bool wait) {
    struct sim_slot *slot = NULL;
    pthread_mutex_lock(&c->lock);
    for (;;) {
        for (int k = 0; k < c->slot_count && !slot; k++)
            if (c->slots[k].pending == 0)
                slot = &c->slots[k];
        if (slot || !wait)
            break;
        pthread_cond_wait(&c->freed, &c->lock);
    }
    pthread_mutex_unlock(&c->lock);
    if (slot)
        sim_slot_recycle(c->gpu, slot);
    return slot;
}

// ---- What the GPU is asked to do for one frame

static enum ap_status make_pass(struct ap_error *err, struct sim_compositor *c) {
    return c->pass.render_pass ? AP_OK : sim_pass_create(err, c->gpu, &c->pass);
}

static enum ap_status make_target(struct ap_error *err, struct sim_compositor *c, uint32_t width_px,
                                  uint32_t height_px, struct sim_pass_target *target) {
    if (target->framebuffer)
        return AP_OK;
    return sim_pass_target_create(err, c->gpu, &c->pass, width_px, height_px, target);
}

static enum ap_status make_buffer(struct ap_error *err, struct sim_compositor *c, uint32_t width_px,
                                  uint32_t height_px, struct ap_gpu_buffer *buffer) {
    if (buffer->buffer)
        return AP_OK;
    return ap_gpu_buffer_create(err, c->gpu, (VkDeviceSize)width_px * height_px * 4,
                                VK_BUFFER_USAGE_TRANSFER_DST_BIT, true, buffer);
}

static enum ap_status make_pipelines(struct ap_error *err, struct sim_compositor *c,
                                     const struct sim_plan *plan) {
    enum ap_status st = AP_OK;
    sim_pass_make_room(c->gpu, &c->pass, plan->batch_count[0] + plan->batch_count[1]);
    for (int eye = 0; eye < 2; eye++)
        for (uint32_t k = 0; k < plan->batch_count[eye] && sim_plan_samples(plan, eye) && !st; k++)
            st = sim_pass_prepare(err, c->gpu, &c->pass, &plan->batches[eye][k].key);
    return st;
}

// Bit e: eye e is seen in the window.
static unsigned shown_eyes(const struct sim_settings *settings) {
    return settings->window_layout == SIM_LAYOUT_LEFT    ? 1
           : settings->window_layout == SIM_LAYOUT_RIGHT ? 2
                                                         : 3;
}

static VkExtent2D preview_size(const struct sim_compositor *c) {
    const VkRect2D *left = &c->preview_part[0], *right = &c->preview_part[1];
    return (VkExtent2D){left->extent.width + right->extent.width,
                        left->extent.height > right->extent.height ? left->extent.height
                                                                   : right->extent.height};
}

// Everything that this frame is the first to need.
static enum ap_status make_ready(struct ap_error *err, struct sim_compositor *c,
                                 const struct sim_plan *plan, struct sim_slot *slot) {
    enum ap_status st = AP_OK;
    bool passes = sim_plan_samples(plan, 0) || sim_plan_samples(plan, 1);
    if (passes)
        st = make_pass(err, c);
    if (!st && passes)
        st = sim_slot_descriptors(err, c->gpu, &c->pass, slot);
    if (!st && passes)
        st = make_pipelines(err, c, plan);
    for (int eye = 0; eye < 2 && plan->pictures && !st; eye++) {
        const struct ap_eye_profile *p = &c->settings->profile.eye[eye];
        st = make_buffer(err, c, p->width_px, p->height_px, &slot->eye[eye]);
        if (!st && !plan->copy[eye])
            st = make_target(err, c, p->width_px, p->height_px, &c->eye[eye]);
    }
    if (st || !plan->show)
        return st;
    VkExtent2D size = preview_size(c);
    st = make_buffer(err, c, size.width, size.height, &slot->preview);
    return st ? st : make_target(err, c, size.width, size.height, &c->preview);
}

static void copy_out(VkCommandBuffer cmd, VkImage image, VkImageLayout layout, uint32_t array_layer,
                     VkRect2D part, const struct ap_gpu_buffer *buffer) {
    VkBufferImageCopy region = {.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, array_layer, 1},
                                .imageOffset = {part.offset.x, part.offset.y, 0},
                                .imageExtent = {part.extent.width, part.extent.height, 1}};
    vkCmdCopyImageToBuffer(cmd, image, layout, buffer->buffer, 1, &region);
}

static void draw_layers(struct sim_compositor *c, const struct sim_plan *plan,
                        struct sim_slot *slot, int eye, VkRect2D part) {
    for (uint32_t k = 0; k < plan->batch_count[eye]; k++) {
        const struct sim_batch *b = &plan->batches[eye][k];
        sim_pass_draw(slot->cmd, &c->pass, part, &b->key, b->from_uv, b->to_uv, slot->sets[eye][k]);
    }
}

static void copy_target(VkCommandBuffer cmd, const struct sim_pass_target *target,
                        const struct ap_gpu_buffer *buffer) {
    VkRect2D all = {{0, 0}, {target->width_px, target->height_px}};
    copy_out(cmd, target->image.image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, 0, all, buffer);
}

static void record_eye(struct sim_compositor *c, const struct sim_plan *plan, struct sim_slot *slot,
                       int eye) {
    const struct ap_eye_profile *p = &c->settings->profile.eye[eye];
    if (plan->copy[eye]) {
        uint32_t only = plan->drawings[eye][0].layer;
        const struct sim_layer_view *view = &plan->frame->layer[only].view[eye];
        VkRect2D part = {{view->rect.offset.x, view->rect.offset.y}, {p->width_px, p->height_px}};
        copy_out(slot->cmd, view->image, sim_plan_layout(plan, view->image), view->array_layer,
                 part, &slot->eye[eye]);
        slot->bgra[eye] = view->format == VK_FORMAT_B8G8R8A8_SRGB;
        c->stats.copied++;
        return;
    }
    VkRect2D all = {{0, 0}, {p->width_px, p->height_px}};
    sim_pass_begin(slot->cmd, &c->pass, &c->eye[eye]);
    draw_layers(c, plan, slot, eye, all);
    sim_pass_end(slot->cmd);
    copy_target(slot->cmd, &c->eye[eye], &slot->eye[eye]);
    slot->bgra[eye] = false;
    c->stats.composed++;
}

static void record_preview(struct sim_compositor *c, const struct sim_plan *plan,
                           struct sim_slot *slot) {
    sim_pass_begin(slot->cmd, &c->pass, &c->preview);
    for (int eye = 0; eye < 2; eye++)
        if (plan->show & 1u << eye)
            draw_layers(c, plan, slot, eye, c->preview_part[eye]);
    sim_pass_end(slot->cmd);
    copy_target(slot->cmd, &c->preview, &slot->preview);
    c->stats.shown++;
}

static enum ap_status bind_layers(struct ap_error *err, struct sim_compositor *c,
                                  const struct sim_plan *plan, struct sim_slot *slot) {
    enum ap_status st = AP_OK;
    for (int eye = 0; eye < 2; eye++)
        for (uint32_t k = 0; k < plan->batch_count[eye] && sim_plan_samples(plan, eye) && !st; k++)
            st = sim_slot_bind(err, c->gpu, &c->pass, slot, plan, eye, k);
    return st;
}

static enum ap_status record(struct ap_error *err, struct sim_compositor *c,
                             const struct sim_plan *plan, struct sim_slot *slot) {
    VkCommandBufferBeginInfo begin = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
                                      .flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT};
    enum ap_status st =
        ap_vk_check(err, vkBeginCommandBuffer(slot->cmd, &begin), "vkBeginCommandBuffer");
    if (st)
        return st;
    const VkImageLayout released = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL;
    for (uint32_t k = 0; k < plan->use_count; k++)
        ap_gpu_barrier(slot->cmd, plan->uses[k].image, VK_IMAGE_ASPECT_COLOR_BIT, released,
                       plan->uses[k].layout);
    st = bind_layers(err, c, plan, slot);
    if (st)
        return st;
    for (int eye = 0; eye < 2 && plan->pictures; eye++)
        record_eye(c, plan, slot, eye);
    if (plan->show)
        record_preview(c, plan, slot);
    for (uint32_t k = 0; k < plan->use_count; k++)
        ap_gpu_barrier(slot->cmd, plan->uses[k].image, VK_IMAGE_ASPECT_COLOR_BIT,
                       plan->uses[k].layout, released);
    VkMemoryBarrier host = {.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER,
                            .srcAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT,
                            .dstAccessMask = VK_ACCESS_HOST_READ_BIT};
    vkCmdPipelineBarrier(slot->cmd, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_PIPELINE_STAGE_HOST_BIT, 0,
                         1, &host, 0, NULL, 0, NULL);
    return ap_vk_check(err, vkEndCommandBuffer(slot->cmd), "vkEndCommandBuffer");
}

static enum ap_status submit(struct ap_error *err, struct sim_compositor *c,
                             const struct sim_plan *plan, struct sim_slot *slot) {
    enum ap_status st = make_ready(err, c, plan, slot);
    if (!st)
        st = record(err, c, plan, slot);
    if (!st)
        st = ap_vk_check(err, vkResetFences(c->gpu->device, 1, &slot->fence), "vkResetFences");
    VkSubmitInfo info = {.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO,
                         .commandBufferCount = 1,
                         .pCommandBuffers = &slot->cmd};
    if (!st)
        st = ap_vk_check(err, vkQueueSubmit(c->gpu->queue, 1, &info, slot->fence), "vkQueueSubmit");
    return st;
}

static void add_job(struct sim_compositor *c, struct sim_slot *slot, int what) {
    struct sim_capture_job job = {run_job, slot, what};
    sim_capture_add(c->capture, &job);
}

SIM_HOT enum ap_status sim_compositor_frame(struct ap_error *err, struct sim_compositor *c,
                                            const struct sim_frame *frame) {
    c->stats.frames++;
    bool show = c->window && sim_window_alive(c->window);
    if (!frame->capture && !show) {
        c->stats.skipped++;
        return c->capture ? sim_capture_error(err, c->capture) : AP_OK;
    }
    if (frame->capture && !c->settings->capture_dir)
        return ap_fail(err, AP_USAGE, "frame %" PRId64 " has no folder to be captured in",
                       frame->index);
    // Every captured frame is wanted; of the others the window shows what there is time for.
    struct sim_slot *slot = take_slot(c, frame->capture);
    if (!slot) {
        c->stats.skipped++;
        return sim_capture_error(err, c->capture);
    }
    struct sim_plan *plan = &c->plan;
    sim_plan_make(c->settings, frame, show ? shown_eyes(c->settings) : 0, plan);
    slot->frame = frame->index;
    enum ap_status st = submit(err, c, plan, slot);
    if (st)
        return st;
    pthread_mutex_lock(&c->lock);
    slot->pending = (plan->pictures ? 2 : 0) + (plan->show ? 1 : 0);
    pthread_mutex_unlock(&c->lock);
    if (plan->show)
        add_job(c, slot, PREVIEW);
    for (int eye = 0; eye < 2 && plan->pictures; eye++)
        add_job(c, slot, eye);
    return sim_capture_error(err, c->capture);
}

// ---- Life

// Each eye no larger than PREVIEW_…, both at one scale.
static void lay_out_preview(struct sim_compositor *c) {
    unsigned eyes = shown_eyes(c->settings);
    double width = eyes == 3 ? PREVIEW_MAX_WIDTH_PX : PREVIEW_ALONE_WIDTH_PX;
    double height = eyes == 3 ? PREVIEW_MAX_HEIGHT_PX : PREVIEW_ALONE_HEIGHT_PX;
    double scale = 1;
    for (int eye = 0; eye < 2; eye++) {
        const struct ap_eye_profile *p = &c->settings->profile.eye[eye];
        if ((eyes & 1u << eye) && width < scale * p->width_px)
            scale = width / p->width_px;
        if ((eyes & 1u << eye) && height < scale * p->height_px)
            scale = height / p->height_px;
    }
    int32_t x = 0;
    for (int eye = 0; eye < 2; eye++) {
        if (!(eyes & 1u << eye))
            continue;
        const struct ap_eye_profile *p = &c->settings->profile.eye[eye];
        uint32_t width_px = (uint32_t)(scale * p->width_px),
                 height_px = (uint32_t)(scale * p->height_px);
        c->preview_part[eye] =
            (VkRect2D){{x, 0}, {width_px > 0 ? width_px : 1, height_px > 0 ? height_px : 1}};
        x += (int32_t)c->preview_part[eye].extent.width;
    }
}

static void open_window(struct sim_compositor *c) {
    struct ap_error error;
    VkExtent2D size = preview_size(c);
    enum sim_layout layout = c->settings->window_layout;
    struct sim_window_params params = {
        .title = c->settings->profile.name,
        .width_px = size.width,
        .height_px = size.height,
        .split_px = shown_eyes(c->settings) == 3 ? c->preview_part[0].extent.width : 0,
        .layout = layout == SIM_LAYOUT_CROSS      ? SIM_WINDOW_CROSS
                  : layout == SIM_LAYOUT_ANAGLYPH ? SIM_WINDOW_ANAGLYPH
                                                  : SIM_WINDOW_PAIR};
    if (sim_window_open(&error, &params, &c->window))
        ap_log(AP_LOG_WARNING, "%s: going on without a window", error.text);
}

static enum ap_status create_slots(struct ap_error *err, struct sim_compositor *c) {
    VkCommandPoolCreateInfo info = {.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
                                    .flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT,
                                    .queueFamilyIndex = c->gpu->queue_family};
    enum ap_status st = ap_vk_check(err, vkCreateCommandPool(c->gpu->device, &info, NULL, &c->pool),
                                    "vkCreateCommandPool");
    const struct ap_eye_profile *eye = c->settings->profile.eye;
    uint64_t bytes = 4 * ((uint64_t)eye[0].width_px * eye[0].height_px +
                          (uint64_t)eye[1].width_px * eye[1].height_px);
    uint64_t count = bytes ? SLOT_BYTES / bytes : MAX_SLOTS;
    count = count < 2 ? 2 : count > MAX_SLOTS ? MAX_SLOTS : count;
    while (!st && c->slot_count < (int)count) {
        struct sim_slot *slot = &c->slots[c->slot_count++];
        slot->owner = c;
        st = sim_slot_create(err, c->gpu, c->pool, slot);
    }
    return st;
}

enum ap_status sim_compositor_create(struct ap_error *err, const struct ap_gpu *gpu,
                                     const struct sim_settings *settings,
                                     struct sim_compositor **compositor) {
    struct sim_compositor *c = calloc(1, sizeof *c);
    if (!c)
        return ap_fail(err, AP_ENVIRONMENT, "out of memory");
    c->gpu = gpu;
    c->settings = settings;
    pthread_mutex_init(&c->lock, NULL);
    pthread_cond_init(&c->freed, NULL);
    enum ap_status st = AP_OK;
    lay_out_preview(c);
    if (settings->window)
        open_window(c);
    if (settings->capture_dir || c->window) {
        st = sim_capture_create(err, settings, WRITERS, &c->capture);
        if (!st)
            st = create_slots(err, c);
    }
    if (st)
        sim_compositor_destroy(c);
    else
        *compositor = c;
    return st;
}

SIM_HOT bool sim_compositor_wants_frames(const struct sim_compositor *c) {
    return c->window && sim_window_alive(c->window);
}

SIM_HOT bool sim_compositor_input(const struct sim_compositor *c, struct sim_window_input *input) {
    if (!c->window)
        return false;
    bool alive = sim_window_alive(c->window); // says so if it could not be opened
    sim_window_input(c->window, input);
    return alive || input->closed;
}

enum ap_status sim_compositor_flush(struct ap_error *err, struct sim_compositor *c) {
    return sim_capture_flush(err, c->capture);
}

struct sim_compositor_stats sim_compositor_stats(const struct sim_compositor *c) {
    return c->stats;
}

void sim_compositor_destroy(struct sim_compositor *c) {
    if (!c)
        return;
    sim_capture_destroy(c->capture); // every fence has been waited for then
    sim_window_close(c->window);
    for (int k = 0; k < c->slot_count; k++)
        sim_slot_destroy(c->gpu, &c->slots[k]);
    for (int eye = 0; eye < 2; eye++)
        sim_pass_target_destroy(c->gpu, &c->eye[eye]);
    sim_pass_target_destroy(c->gpu, &c->preview);
    sim_pass_destroy(c->gpu, &c->pass);
    vkDestroyCommandPool(c->gpu->device, c->pool, NULL);
    pthread_cond_destroy(&c->freed);
    pthread_mutex_destroy(&c->lock);
    free(c);
}
