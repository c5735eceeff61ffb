#include <math.h>
#include <string.h>

#include "src/render/list.h"

float ap_linear_color(double srgb) {
    return (float)(srgb <= 0.04045 ? srgb / 12.92 : pow((srgb + 0.055) / 1.055, 2.4));
}

static void set_mark(struct ap_space space, struct ap_vec4 at, double radius_m, int k,
                     struct ap_gpu_marks *marks) {
    ap_store_point(space, at, marks->at[k]);
    marks->sine[k] = (float)ap_space_sin(space, radius_m / space.rho_m);
}

int32_t ap_draw_list_marks(const struct ap_scene *scene) {
    int32_t shadows = 0;
    for (size_t i = 0; i < scene->part_count && shadows < AP_SHADOWS_MAX; i++)
        shadows += scene->parts[i].casts_shadow;
    return shadows + 256 * scene->mouth_count;
}

// In the coordinates of the part that takes them: what is near there has small ones.
static void write_marks(const struct ap_scene *scene, const struct ap_part *taker,
                        struct ap_gpu_marks *marks) {
    struct ap_space space = scene->space;
    struct ap_iso part_from_world = ap_iso_inverse(space, taker->carrier_from_part);
    const struct ap_vec4 base = {0, 0, 0, space.rho_m};
    int k = 0;
    for (size_t i = 0; i < scene->part_count && k < AP_SHADOWS_MAX; i++) {
        const struct ap_part *p = &scene->parts[i];
        if (!p->casts_shadow || p->hidden || p->carrier != AP_CARRIER_WORLD)
            continue;
        struct ap_iso at = ap_iso_mul(part_from_world, p->carrier_from_part);
        set_mark(space, ap_iso_apply(&at, base), p->radius_m, k++, marks);
    }
    for (int i = 0; i < scene->mouth_count; i++) {
        const float *sine = &marks->sine[AP_SHADOWS_MAX + i];
        set_mark(space, ap_iso_apply(&part_from_world, scene->mouths[i].at),
                 scene->mouths[i].radius_m, AP_SHADOWS_MAX + i, marks);
        marks->mouth_inverse[i] = 1 / fmaxf(*sine * *sine, 1e-12F);
    }
}

// Linear colours: the background's and those of the part at hand, of which many may follow.
struct palette {
    float back[3], own[3];
    const struct ap_part *of;
};

static void take_color(const struct ap_part *part, struct palette *palette) {
    if (palette->of == part)
        return;
    palette->of = part;
    for (int i = 0; i < 3; i++)
        palette->own[i] = ap_linear_color(part->color_srgb[i]);
}

static void write_item(const struct ap_scene *scene, const struct ap_frame_input *input,
                       const struct ap_eyes *eyes, const struct ap_draw_item *item,
                       const struct palette *palette, struct ap_vec4 lamp_nose,
                       struct ap_gpu_draw *draw) {
    const struct ap_viewer *viewer = &input->viewer;
    struct ap_space space = viewer->space;
    const struct ap_part *part = &scene->parts[item->part];
    for (int e = 0; e < 2; e++) {
        struct ap_iso to = item->nose_from_part;
        if (viewer->mode == AP_VIEW_TOURIST)
            to = ap_iso_mul(eyes->eye_from_nose[e], to);
        ap_store_iso(&to, draw->to[e]);
    }
    struct ap_iso part_from_nose = ap_iso_inverse(space, item->nose_from_part);
    struct ap_vec4 nose = {0, 0, 0, space.rho_m};
    struct ap_vec4 lamp =
        item->lamp_in_cell ? item->lamp : ap_iso_apply(&part_from_nose, lamp_nose);
    ap_store_point(space, lamp, draw->lamp);
    ap_store_point(space, ap_iso_apply(&part_from_nose, nose), draw->nose);
    for (int i = 0; i < 3; i++) {
        float own = palette->own[i], back = palette->back[i];
        draw->color[i] = item->brightness < 1 ? back + item->brightness * (own - back) : own;
        draw->root[i] = 1.055f * powf(fmaxf(draw->color[i], 0), 1 / 2.4f);
    }
    draw->color[3] = part->lit ? 1 : 0;
    draw->root[3] = part->kind == AP_PART_STICK ? (float)(part->length_m / 2 / space.rho_m) : 0;
    double t = part->radius_m / space.rho_m;
    draw->shape[0] = (float)ap_space_sin(space, t);
    draw->shape[1] = (float)ap_space_cos(space, t);
    draw->shape[2] = part->kind == AP_PART_BALL      ? AP_DRAW_BALL
                     : part->kind == AP_PART_POLYGON ? AP_DRAW_SHEET
                                                     : AP_DRAW_MESH;
    draw->shape[3] = (float)(item->image + 2 * item->way);
}

void ap_draw_list_write(const struct ap_scene *scene, const struct ap_frame_input *input,
                        const struct ap_eyes *eyes, const struct ap_draw_list *list,
                        struct ap_gpu_draw *draws, struct ap_gpu_marks *marks) {
    struct ap_vec4 lamp = ap_nose_from_world(&input->viewer, scene->lamp).x;
    const struct ap_part *taker = NULL;
    struct palette palette = {.of = NULL};
    memset(marks, 0, sizeof *marks);
    for (int i = 0; i < 3; i++)
        palette.back[i] = ap_linear_color(scene->background_srgb[i]);
    for (size_t i = 0; i < list->count; i++) {
        const struct ap_part *part = &scene->parts[list->order[i]->part];
        take_color(part, &palette);
        write_item(scene, input, eyes, list->order[i], &palette, lamp, &draws[i]);
        float *finish = draws[i].finish;
        finish[0] = part->lit && !input->plain ? (float)part->finish : 0;
        finish[1] = (float)(part->decal - 1);
        finish[2] = (float)ap_part_form(part);
        bool takes = part->takes_marks && part->lit && part->carrier == AP_CARRIER_WORLD;
        if (takes && !taker)
            write_marks(scene, taker = part, marks);
        finish[3] = takes && part == taker;
    }
}
