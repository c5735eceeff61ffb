#include "sim_hmd/capture/frames_line.h"

#include <inttypes.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "sim_hmd/capture/capture.h"
#include "sim_hmd/capture/layers.h"
#include "sim_hmd/compose/frame.h"
#include "sim_hmd/core/spaces.h"
#include "src/base/number.h"

// Every word here is ours: nothing that a program may name is written.

static void put(struct sim_line *line, const char *format, ...) AP_PRINTF(2, 3);

static void put(struct sim_line *line, const char *format, ...) {
    char piece[256];
    va_list args;
    va_start(args, format);
    int n = vsnprintf(piece, sizeof piece, format, args);
    va_end(args);
    if (n < 0 || (size_t)n >= sizeof piece || line->failed) {
        line->failed = true;
        return;
    }
    if (line->len + (size_t)n + 1 > line->room) {
        size_t room = line->room ? 2 * line->room : 4096;
        char *more = realloc(line->text, room);
        if (!more) {
            line->failed = true;
            return;
        }
        line->text = more;
        line->room = room;
    }
    memcpy(line->text + line->len, piece, (size_t)n + 1);
    line->len += (size_t)n;
}

// JSON has no infinities.
static void put_numbers(struct sim_line *line, const char *key, const double *v, int count) {
    put(line, "\"%s\":[", key);
    for (int k = 0; k < count; k++) {
        char text[AP_DOUBLE_TEXT_MAX];
        ap_format_double(text, v[k]);
        put(line, "%s%s", k ? "," : "", v[k] - v[k] == 0 ? text : "null");
    }
    put(line, "]");
}

static void put_pose(struct sim_line *line, const char *key, struct ap_pose p) {
    const double v[7] = {p.p.x, p.p.y, p.p.z, p.q.x, p.q.y, p.q.z, p.q.w};
    put_numbers(line, key, v, 7);
}

static void put_xr_pose(struct sim_line *line, const char *key, XrPosef p) {
    const double v[7] = {(double)p.position.x,    (double)p.position.y,    (double)p.position.z,
                         (double)p.orientation.x, (double)p.orientation.y, (double)p.orientation.z,
                         (double)p.orientation.w};
    put_numbers(line, key, v, 7);
}

static void put_fov(struct sim_line *line, XrFovf f) {
    const double v[4] = {(double)f.angleLeft, (double)f.angleRight, (double)f.angleUp,
                         (double)f.angleDown};
    put_numbers(line, "fov", v, 4);
}

static const char *tracking(enum ap_pose_state state) {
    return state == AP_POSE_NONE ? "none" : state == AP_POSE_LOST ? "held" : "tracked";
}

static const char *space_name(XrSpace handle) {
    const struct sim_space *space = sim_space_get(handle);
    if (!space)
        return "unknown";
    if (space->is_action)
        return "action";
    switch (space->reference) {
    case XR_REFERENCE_SPACE_TYPE_VIEW:
        return "view";
    case XR_REFERENCE_SPACE_TYPE_LOCAL:
        return "local";
    case XR_REFERENCE_SPACE_TYPE_STAGE:
        return "stage";
    default:
        return "other";
    }
}

static void put_format(struct sim_line *line, VkFormat format) {
    static const struct {
        VkFormat format;
        const char *name;
    } names[] = {
        {VK_FORMAT_R8G8B8A8_SRGB, "R8G8B8A8_SRGB"},
        {VK_FORMAT_B8G8R8A8_SRGB, "B8G8R8A8_SRGB"},
        {VK_FORMAT_R8G8B8A8_UNORM, "R8G8B8A8_UNORM"},
        {VK_FORMAT_B8G8R8A8_UNORM, "B8G8R8A8_UNORM"},
        {VK_FORMAT_R16G16B16A16_SFLOAT, "R16G16B16A16_SFLOAT"},
        {VK_FORMAT_D16_UNORM, "D16_UNORM"},
        {VK_FORMAT_D24_UNORM_S8_UINT, "D24_UNORM_S8_UINT"},
        {VK_FORMAT_D32_SFLOAT, "D32_SFLOAT"},
        {VK_FORMAT_D32_SFLOAT_S8_UINT, "D32_SFLOAT_S8_UINT"},
    };
    for (size_t k = 0; k < sizeof names / sizeof *names; k++)
        if (names[k].format == format) {
            put(line, "\"format\":\"%s\"", names[k].name);
            return;
        }
    put(line, "\"format\":\"%d\"", (int)format);
}

static void put_rect(struct sim_line *line, XrRect2Di r, uint32_t array_index) {
    put(line, ",\"rect\":[%d,%d,%d,%d],\"array_index\":%u", r.offset.x, r.offset.y, r.extent.width,
        r.extent.height, array_index);
}

// The swapchain and the part of it.
static void put_image(struct sim_line *line, const struct sim_layer_view *v) {
    put_format(line, v->format);
    put(line, ",\"size\":[%u,%u],\"samples\":%u", v->width_px, v->height_px, v->samples);
    put_rect(line, v->rect, v->array_layer);
}

static void put_depth(struct sim_line *line, const struct sim_layer_depth *d) {
    const double range[2] = {(double)d->min, (double)d->max};
    const double near_far[2] = {(double)d->near_m, (double)d->far_m};
    put(line, ",\"depth\":{");
    put_format(line, d->format);
    put(line, ",\"size\":[%u,%u],\"samples\":%u", d->width_px, d->height_px, d->samples);
    put_rect(line, d->rect, d->array_layer);
    put(line, ",");
    put_numbers(line, "range", range, 2);
    put(line, ",");
    put_numbers(line, "near_far_m", near_far, 2);
    put(line, "}");
}

static void put_flags(struct sim_line *line, XrCompositionLayerFlags flags) {
    static const struct {
        XrCompositionLayerFlags bit;
        const char *name;
    } names[] = {
        {XR_COMPOSITION_LAYER_CORRECT_CHROMATIC_ABERRATION_BIT, "correct_chromatic_aberration"},
        {XR_COMPOSITION_LAYER_BLEND_TEXTURE_SOURCE_ALPHA_BIT, "blend_texture_source_alpha"},
        {XR_COMPOSITION_LAYER_UNPREMULTIPLIED_ALPHA_BIT, "unpremultiplied_alpha"},
    };
    const char *comma = "";
    put(line, "\"flags\":[");
    for (size_t k = 0; k < sizeof names / sizeof *names; k++)
        if (flags & names[k].bit) {
            put(line, "%s\"%s\"", comma, names[k].name);
            comma = ",";
        }
    put(line, "]");
}

static const char *kind_name(enum sim_layer_kind kind) {
    switch (kind) {
    case SIM_LAYER_PROJECTION:
        return "projection";
    case SIM_LAYER_QUAD:
        return "quad";
    case SIM_LAYER_CYLINDER:
        return "cylinder";
    case SIM_LAYER_EQUIRECT:
        return "equirect";
    case SIM_LAYER_CUBE:
        return "cube";
    }
    return "unknown";
}

static void put_view(struct sim_line *line, const struct sim_layer *layer, int eye) {
    const struct sim_layer_view *v = &layer->view[eye];
    put(line, "{");
    put_xr_pose(line, "pose", v->submitted_pose);
    put(line, ",");
    put_pose(line, "stage_pose", v->stage_from_view);
    put(line, ",");
    if (layer->kind == SIM_LAYER_PROJECTION) {
        put_fov(line, v->fov);
        put(line, ",");
    }
    put_image(line, v);
    if (layer->has_depth[eye])
        put_depth(line, &layer->depth[eye]);
    put(line, "}");
}

// All layers begin alike; all but projections then say for which eyes they are.
static void put_layer(struct sim_line *line, const XrCompositionLayerBaseHeader *in,
                      const struct sim_layer *layer) {
    static const char *const eyes[] = {"both", "left", "right"};
    bool projection = layer->kind == SIM_LAYER_PROJECTION;
    XrEyeVisibility shown =
        projection ? XR_EYE_VISIBILITY_BOTH : ((const XrCompositionLayerQuad *)in)->eyeVisibility;
    put(line, "{\"type\":\"%s\",", kind_name(layer->kind));
    put_flags(line, in->layerFlags);
    put(line, ",\"space\":\"%s\",\"eyes\":\"%s\",\"views\":[", space_name(in->space),
        shown <= XR_EYE_VISIBILITY_RIGHT ? eyes[shown] : "unknown");
    put_view(line, layer, 0);
    if (projection) {
        put(line, ",");
        put_view(line, layer, 1);
    }
    put(line, "]}");
}

static void put_file(struct sim_line *line, const struct sim_settings *s, int64_t frame, int layer,
                     enum sim_part part, const char **comma) {
    char name[SIM_CAPTURE_NAME_MAX];
    sim_capture_name(s, frame, layer, part, name);
    put(line, "%s\"%s\"", *comma, name);
    *comma = ",";
}

static void put_files(struct sim_line *line, const struct sim_settings *s,
                      const struct sim_logged_frame *l) {
    const struct sim_frame *f = l->frame;
    const char *comma = "";
    put(line, "\"files\":[");
    for (int eye = 0; eye < 2 && l->captured && s->capture_composed; eye++)
        put_file(line, s, f->index, -1, eye ? SIM_PART_RIGHT : SIM_PART_LEFT, &comma);
    for (int k = 0; k < (int)f->layer_count && l->captured && s->capture_layers; k++) {
        enum sim_part parts[SIM_LAYER_PARTS_MAX];
        int count = sim_layer_capture_parts(&f->layer[k], parts);
        for (int i = 0; i < count; i++)
            put_file(line, s, f->index, k, parts[i], &comma);
    }
    put(line, "]");
}

static void put_pulse(struct sim_line *line, const struct sim_pulse *p) {
    put(line, "{\"frame\":%" PRId64 ",\"at\":\"%s\",", p->frame,
        p->top < 0 ? "any" : sim_top_paths[p->top]);
    if (p->stop) {
        put(line, "\"stop\":true}");
        return;
    }
    const double v[2] = {(double)p->frequency_hz, (double)p->amplitude};
    put(line, "\"duration_ns\":%" PRId64 ",", p->duration_ns);
    put_numbers(line, "frequency_amplitude", v, 2);
    put(line, "}");
}

static void put_haptics(struct sim_line *line, const struct sim_pulses *pulses) {
    put(line, "\"haptics\":[");
    for (uint32_t i = 0; i < pulses->count; i++) {
        put(line, i ? "," : "");
        put_pulse(line, &pulses->pulse[i]);
    }
    put(line, "],");
    if (pulses->dropped)
        put(line, "\"haptics_dropped\":%" PRId64 ",", pulses->dropped);
}

static void put_times(struct sim_line *line, const struct sim_settings *s,
                      const struct sim_logged_frame *l) {
    const struct sim_prediction *p = l->predicted;
    put(line, "\"frame\":%" PRId64 ",\"display_ns\":%" PRId64 ",\"period_ns\":%" PRId64, p->index,
        p->display_ns, p->period_ns);
    if (s->clock == SIM_CLOCK_VIRTUAL)
        return;
    put(line, ",\"waited_ns\":%" PRId64 ",\"begun_ns\":%" PRId64, p->waited_ns, p->begun_ns);
    put(line, ",\"ended_ns\":%" PRId64 ",\"deadline_ns\":%" PRId64 ",\"late\":%s", l->ended_ns,
        p->display_ns, l->ended_ns > p->display_ns ? "true" : "false");
}

void sim_line_write(struct sim_line *line, const struct sim_settings *settings,
                    const struct sim_logged_frame *l) {
    line->len = 0;
    put(line, "{");
    put_times(line, settings, l);
    put(line, ",\"missed\":%" PRId64 ",\"discarded\":%" PRId64 ",\"head\":{\"tracking\":\"%s\",",
        l->frame->missed, l->frame->discarded, tracking(l->head_state));
    put_pose(line, "pose", l->stage_from_head);
    put(line, "},\"eyes\":[");
    for (int eye = 0; eye < 2; eye++) {
        put(line, eye ? ",{" : "{");
        put_pose(line, "pose", l->frame->stage_from_eye[eye]);
        put(line, ",");
        put_fov(line, l->frame->fov[eye]);
        put(line, "}");
    }
    put(line, "],\"layers\":[");
    for (uint32_t k = 0; k < l->frame->layer_count; k++) {
        put(line, k ? "," : "");
        put_layer(line, l->info->layers[k], &l->frame->layer[k]);
    }
    put(line, "],");
    put_haptics(line, l->pulses);
    put_files(line, settings, l);
    put(line, "}\n");
}
