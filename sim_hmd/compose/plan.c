#include "sim_hmd/compose/plan.h"

#include <math.h>

// A layer over less of the eye's picture is drawn on its own, within its bounds.
static const double MUCH = 0.5;

static bool may_be_bright(VkFormat format) {
    switch (format) {
    case VK_FORMAT_R8G8B8A8_SRGB:
    case VK_FORMAT_B8G8R8A8_SRGB:
    case VK_FORMAT_R8G8B8A8_UNORM:
    case VK_FORMAT_B8G8R8A8_UNORM:
    case VK_FORMAT_A2B10G10R10_UNORM_PACK32:
        return false;
    default:
        return true;
    }
}

static uint32_t way_of(const struct sim_layer *layer, int eye, const struct sim_seen *seen) {
    static const uint32_t surfaces[] = {
        [SIM_LAYER_PROJECTION] = 0,
        [SIM_LAYER_QUAD] = 0,
        [SIM_LAYER_CYLINDER] = SIM_WAY_CYLINDER,
        [SIM_LAYER_EQUIRECT] = SIM_WAY_SPHERE,
        [SIM_LAYER_CUBE] = SIM_WAY_CUBE,
    };
    uint32_t way = surfaces[layer->kind];
    if (way == 0 && layer->view[eye].mips > 1)
        way |= SIM_WAY_MIPS;
    if (layer->blend_alpha)
        way |= layer->unpremultiplied ? SIM_WAY_BLENDED | SIM_WAY_UNPREMULTIPLIED : SIM_WAY_BLENDED;
    if (!seen->all)
        way |= SIM_WAY_EDGES;
    if (seen->centred && way & (SIM_WAY_CYLINDER | SIM_WAY_SPHERE))
        way |= SIM_WAY_CENTRED;
    if (seen->part)
        way |= SIM_WAY_PART;
    if (may_be_bright(layer->view[eye].format))
        way |= SIM_WAY_BRIGHT;
    return way;
}

// The layers that this eye sees, without what an opaque one hides altogether.
static void add_drawings(const struct sim_frame *frame, int eye, struct sim_plan *plan) {
    for (uint32_t k = 0; k < frame->layer_count; k++) {
        const struct sim_layer *layer = &frame->layer[k];
        struct sim_drawing d = {.layer = k, .seen = sim_layer_seen(frame, eye, layer)};
        if (!d.seen.any)
            continue;
        if (d.seen.all && !layer->blend_alpha)
            plan->count[eye] = 0;
        d.way = way_of(layer, eye, &d.seen);
        plan->drawings[eye][plan->count[eye]++] = d;
    }
}

static bool fuses(const struct sim_drawing *d) {
    const struct sim_seen *s = &d->seen;
    return !(d->way & SIM_WAY_CUBE) &&
           (s->to_uv[0] - s->from_uv[0]) * (s->to_uv[1] - s->from_uv[1]) >= MUCH;
}

static void add_batches(struct sim_plan *plan, int eye) {
    plan->batch_count[eye] = 0;
    for (uint32_t k = 0; k < plan->count[eye]; k++) {
        const struct sim_drawing *d = &plan->drawings[eye][k];
        struct sim_batch *b =
            plan->batch_count[eye] ? &plan->batches[eye][plan->batch_count[eye] - 1] : NULL;
        if (!b || b->count == SIM_PASS_FUSED || !fuses(d - 1) || !fuses(d)) {
            b = &plan->batches[eye][plan->batch_count[eye]++];
            *b = (struct sim_batch){.first = k, .from_uv = {1, 1}, .key.first = k == 0};
        }
        for (int i = 0; i < 2; i++) {
            b->from_uv[i] = fmin(b->from_uv[i], d->seen.from_uv[i]);
            b->to_uv[i] = fmax(b->to_uv[i], d->seen.to_uv[i]);
        }
        b->key.ways[b->count++] = d->way;
        b->key.count = b->count;
    }
}

static bool copies(const struct sim_settings *settings, const struct sim_plan *plan, int eye) {
    if (plan->count[eye] != 1)
        return false;
    const struct ap_eye_profile *profile = &settings->profile.eye[eye];
    const struct sim_drawing *d = &plan->drawings[eye][0];
    const struct sim_layer *layer = &plan->frame->layer[d->layer];
    const struct sim_layer_view *view = &layer->view[eye];
    // Over black, premultiplied colour is the picture whatever its alpha.
    return layer->kind == SIM_LAYER_PROJECTION && !(d->way & SIM_WAY_UNPREMULTIPLIED) &&
           view->at_display && view->samples <= 1 &&
           (view->format == VK_FORMAT_R8G8B8A8_SRGB || view->format == VK_FORMAT_B8G8R8A8_SRGB) &&
           view->rect.extent.width == (int32_t)profile->width_px &&
           view->rect.extent.height == (int32_t)profile->height_px;
}

// Both eyes may be parts of one image, read in two ways.
static void add_use(struct sim_plan *plan, VkImage image, VkImageLayout layout) {
    for (uint32_t k = 0; k < plan->use_count; k++)
        if (plan->uses[k].image == image) {
            if (plan->uses[k].layout != layout)
                plan->uses[k].layout = VK_IMAGE_LAYOUT_GENERAL;
            return;
        }
    plan->uses[plan->use_count++] = (struct sim_use){image, layout};
}

VkImageLayout sim_plan_layout(const struct sim_plan *plan, VkImage image) {
    for (uint32_t k = 0; k < plan->use_count; k++)
        if (plan->uses[k].image == image)
            return plan->uses[k].layout;
    return VK_IMAGE_LAYOUT_UNDEFINED;
}

bool sim_plan_samples(const struct sim_plan *plan, int eye) {
    return (plan->show & 1u << eye) || (plan->pictures && !plan->copy[eye]);
}

void sim_plan_make(const struct sim_settings *settings, const struct sim_frame *frame,
                   unsigned show, struct sim_plan *plan) {
    plan->frame = frame;
    plan->show = show;
    plan->pictures = frame->capture;
    plan->use_count = 0;
    for (int eye = 0; eye < 2; eye++) {
        plan->count[eye] = 0;
        add_drawings(frame, eye, plan);
        add_batches(plan, eye);
        plan->copy[eye] = plan->pictures && copies(settings, plan, eye);
        for (uint32_t k = 0; k < plan->count[eye]; k++) {
            const struct sim_layer_view *view =
                &frame->layer[plan->drawings[eye][k].layer].view[eye];
            if (plan->copy[eye])
                add_use(plan, view->image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
            if (sim_plan_samples(plan, eye))
                add_use(plan, view->image,
                        view->samples > 1 ? VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL
                                          : VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);
        }
    }
}
