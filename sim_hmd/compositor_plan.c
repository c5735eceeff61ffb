#include "sim_hmd/compositor_plan.h"

static struct sim_pass_way way_of(const struct sim_layer *layer, bool all, bool first) {
    static const enum sim_pass_surface surfaces[] = {
        [SIM_LAYER_PROJECTION] = SIM_PASS_PLANE,  [SIM_LAYER_QUAD] = SIM_PASS_PLANE,
        [SIM_LAYER_CYLINDER] = SIM_PASS_CYLINDER, [SIM_LAYER_EQUIRECT] = SIM_PASS_SPHERE,
        [SIM_LAYER_CUBE] = SIM_PASS_CUBE,
    };
    struct sim_pass_way way = {surfaces[layer->kind], SIM_PASS_OPAQUE, !all};
    // Over black, premultiplied colour is the picture whatever its alpha.
    if (layer->blend_alpha && layer->unpremultiplied)
        way.alpha = first ? SIM_PASS_UNPREMULTIPLIED_FIRST : SIM_PASS_UNPREMULTIPLIED;
    else if (layer->blend_alpha && !first)
        way.alpha = SIM_PASS_PREMULTIPLIED;
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
        d.way = way_of(layer, d.seen.all, plan->count[eye] == 0);
        plan->drawings[eye][plan->count[eye]++] = d;
    }
}

static bool copies(const struct sim_settings *settings, const struct sim_plan *plan, int eye) {
    if (plan->count[eye] != 1)
        return false;
    const struct ap_eye_profile *profile = &settings->profile.eye[eye];
    const struct sim_drawing *d = &plan->drawings[eye][0];
    const struct sim_layer *layer = &plan->frame->layer[d->layer];
    const struct sim_layer_view *view = &layer->view[eye];
    return layer->kind == SIM_LAYER_PROJECTION && d->way.alpha == SIM_PASS_OPAQUE &&
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
    return plan->show || (plan->pictures && !plan->copy[eye]);
}

void sim_plan_make(const struct sim_settings *settings, const struct sim_frame *frame, bool show,
                   struct sim_plan *plan) {
    plan->frame = frame;
    plan->show = show;
    plan->pictures = frame->capture;
    plan->use_count = 0;
    for (int eye = 0; eye < 2; eye++) {
        plan->count[eye] = 0;
        add_drawings(frame, eye, plan);
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
