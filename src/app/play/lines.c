#include "src/app/play/lines.h"

#include "src/geom/map.h"

static const double dot_m = 0.004, mark_m = 0.008, step_m = 0.05, limit_s = 8;

enum ap_status ap_play_lines_init(struct ap_error *err, struct ap_scene *scene,
                                  struct ap_play_lines *out) {
    struct ap_play_lines lines = {.scene = scene};
    struct ap_part dot = {.kind = AP_PART_BALL,
                          .carrier_from_part = AP_ISO_IDENTITY,
                          .radius_m = dot_m,
                          .color_srgb = {1, 1, 1},
                          .object = -1};
    enum ap_status st = ap_scene_add(err, scene, &dot, AP_PLAY_LINE_DOTS, &lines.first);
    dot.radius_m = mark_m;
    dot.color_srgb[1] = dot.color_srgb[2] = 0.35;
    if (!st)
        st = ap_scene_add(err, scene, &dot, 1, &lines.mark);
    if (!st)
        *out = lines;
    return st;
}

// So high above a point of the table's plane.
static struct ap_iso above(struct ap_space space, struct ap_plane3 p, double height_m) {
    struct ap_vec3 to = ap_log_unchecked(space, (struct ap_vec4){p.x, 0, p.z, p.w}, 0);
    struct ap_vec3 up = {0, height_m, 0};
    return ap_iso_mul(ap_iso_translate(space, to), ap_iso_translate(space, up));
}

struct drawing {
    struct ap_play_lines *lines;
    const struct ap_physics *physics;
    int count;
};

static void put(void *data, int ball, double t_s, struct ap_plane3 foot_m,
                const struct ap_physics_event *event) {
    struct drawing *d = data;
    struct ap_scene *scene = d->lines->scene;
    (void)t_s;
    if (d->count == AP_PLAY_LINE_DOTS)
        return;
    struct ap_part *part = &scene->parts[d->lines->first + (size_t)d->count++];
    part->hidden = false;
    part->radius_m = event ? 1.6 * dot_m : dot_m;
    part->carrier_from_part = above(scene->space, foot_m, d->physics->params.ball_radius_m);
    for (size_t i = 0; i < scene->part_count; i++)
        if (scene->parts[i].pool_ball == 1 + ball)
            for (int c = 0; c < 3; c++)
                part->color_srgb[c] = 0.25 + 0.75 * scene->parts[i].color_srgb[c];
}

int ap_play_lines_show(struct ap_play_lines *lines, const struct ap_physics *physics,
                       const struct ap_strike *strike) {
    struct drawing d = {.lines = lines, .physics = physics};
    if (strike) {
        struct ap_physics trial = *physics;
        const struct ap_path_sink sink = {&d, put};
        if (ap_physics_strike(NULL, &trial, 0, strike) == AP_OK)
            ap_physics_path(&trial, limit_s, step_m, &sink);
    }
    for (int i = d.count; i < AP_PLAY_LINE_DOTS; i++)
        lines->scene->parts[lines->first + (size_t)i].hidden = true;
    return d.count;
}

void ap_play_lines_mark(struct ap_play_lines *lines, const struct ap_plane3 *point_m) {
    struct ap_part *part = &lines->scene->parts[lines->mark];
    part->hidden = !point_m;
    if (point_m)
        part->carrier_from_part = above(lines->scene->space, *point_m, mark_m);
}
