#include "src/app/room.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "src/base/log.h"
#include "src/base/number.h"
#include "src/geom/cells.h"
#include "src/track/setup.h"

static enum ap_status check_positive(struct ap_error *err, const char *name, double value) {
    if (!isnan(value) && !(value > 0))
        return ap_fail(err, AP_USAGE, "--%s: expected a length above 0 in metres", name);
    return AP_OK;
}

static enum ap_status open_scene(struct ap_error *err, const struct ap_room_options *o,
                                 struct ap_scene **scene) {
    enum ap_status st = check_positive(err, "radius", o->radius_m);
    if (!st)
        st = check_positive(err, "table-edge", o->table_edge_m);
    if (!st)
        st = check_positive(err, "table-height", o->table_height_m);
    if (!st && !isnan(o->budget_mib) && !(o->budget_mib >= 0.1 && o->budget_mib <= 1e5))
        st = ap_fail(err, AP_USAGE, "--budget: expected 0.1 to 100000 MiB");
    if (st)
        return st;
    if (o->side_pockets && (o->scene || !o->space || strcmp(o->space, "e3") != 0))
        return ap_fail(err, AP_USAGE,
                       "--side-pockets: the billiards room of e3 alone has six pockets: give "
                       "--space e3 and no scene");
    const struct ap_scene_params params = {
        .space_name = o->space,
        .side_pockets = o->side_pockets,
        .radius_m = isnan(o->radius_m) ? 0 : o->radius_m,
        .table_edge_m = isnan(o->table_edge_m) ? 0 : o->table_edge_m,
        .table_height_m = isnan(o->table_height_m) ? 0 : o->table_height_m,
        .budget_bytes = isnan(o->budget_mib) ? 0 : (size_t)(o->budget_mib * 1048576),
    };
    if (o->scene && ap_scene_is_named(o->scene))
        return ap_scene_named(err, o->scene, &params, scene);
    if (o->scene && access(o->scene, F_OK) != 0 && !strchr(o->scene, '/'))
        return ap_fail(
            err, AP_INPUT,
            "--scene %s: neither a file that is there nor the name of a scene: these are " AP_SCENE_QUOTIENTS
            ", honeycomb:P,Q,R of " AP_SCENE_SYMBOLS,
            o->scene);
    return o->scene ? ap_scene_read(err, o->scene, &params, scene)
                    : ap_scene_billiards(err, &params, scene);
}

// Where a walker can go far, her pose is kept so that the way matters no more than its end.
static enum ap_status make_deep_steps(struct ap_error *err, struct ap_room *room) {
    const struct ap_honeycomb *h = room->scene->honeycomb;
    if (!h || h->tiling.space.kappa >= 0 || room->tracker_params.kind != AP_TRACKER_ANCHOR)
        return AP_OK;
    room->deep_steps = malloc(AP_CELL_FACES * sizeof *room->deep_steps);
    if (!room->deep_steps)
        return ap_fail(err, AP_ENVIRONMENT, "out of memory for the steps between cells");
    room->tracker_params.deep = ap_deep_steps(&h->tiling, &h->pairing, room->deep_steps);
    return AP_OK;
}

static enum ap_status open_tracker(struct ap_error *err, const struct ap_room_options *o,
                                   struct ap_room *room) {
    const char *name = o->tracker                             ? o->tracker
                       : room->scene->has_table && !o->anchor ? "billiards"
                                                              : "anchor";
    enum ap_tracker_kind kind;
    enum ap_status st = ap_tracker_kind_from_name(err, name, &kind);
    if (!st && room->scene->honeycomb && kind == AP_TRACKER_BILLIARDS)
        st = ap_fail(err, AP_USAGE,
                     "--tracker billiards: a world of cells has no table (take anchor or naive)");
    if (st)
        return st;
    // Without a table the virtual base point corresponds to the room's origin.
    room->has_table = room->scene->has_table || kind == AP_TRACKER_BILLIARDS;
    double height_m =
        isnan(o->table_height_m) ? AP_TABLE_HEIGHT_DEFAULT_MM * 1e-3 : o->table_height_m;
    const struct ap_track_setup setup = {.space = ap_space_name(room->scene->space),
                                         .radius_m = room->scene->space.rho_m,
                                         .tracker = kind,
                                         .table_edge_m = o->table_edge_m,
                                         .table_height_m = room->has_table ? height_m : 0,
                                         .anchor = o->anchor};
    struct ap_tracker_params *params = &room->tracker_params;
    st = ap_track_setup(err, &setup, params);
    if (!st && o->table_at)
        st = ap_table_at_parse(err, o->table_at, &params->table_x_m, &params->table_z_m,
                               &params->table_yaw_rad);
    if (!st)
        st = make_deep_steps(err, room);
    return st ? st : ap_tracker_create(err, params, &room->tracker);
}

// "h3" or "h3:0.85".
static enum ap_status parse_native_of(struct ap_error *err, const char *text, struct ap_space world,
                                      struct ap_space *born) {
    char name[3] = "";
    double radius_m = world.rho_m;
    bool good = strlen(text) >= 2;
    if (good) {
        memcpy(name, text, 2);
        good = text[2] == 0 ||
               (text[2] == ':' && ap_parse_double(text + 3, strlen(text + 3), &radius_m));
    }
    if (!good || ap_space_from_name(NULL, name, radius_m, born))
        return ap_fail(err, AP_USAGE,
                       "--native-of: '%s': expected e3, s3 or h3, or with its radius in metres, "
                       "as h3:0.85",
                       text);
    return AP_OK;
}

static enum ap_status choose_view(struct ap_error *err, const struct ap_room_options *o,
                                  struct ap_room *room) {
    if (o->native_of && o->view)
        return ap_fail(err, AP_USAGE, "--view and --native-of contradict: give one of them");
    if (o->eye)
        room->closed_eyes = strcmp(o->eye, "left") == 0 ? 2 : strcmp(o->eye, "right") == 0 ? 1 : 0;
    if (!o->native_of)
        return ap_view_mode_from_name(err, o->view ? o->view : "native", &room->view);
    enum ap_status st = parse_native_of(err, o->native_of, room->scene->space, &room->born);
    if (!st)
        room->view = ap_view_mode_of(room->scene->space, room->born);
    return st;
}

// Without a font balls bear no numbers, and all else goes on.
static enum ap_status make_decals(struct ap_error *err, struct ap_room *room) {
    enum { CELL_PX = 96 };
    const struct ap_scene *scene = room->scene;
    const char **texts = calloc(scene->decal_count + 1, sizeof *texts);
    if (!texts)
        return ap_fail(err, AP_ENVIRONMENT, "out of memory");
    for (size_t i = 0; i < scene->decal_count; i++)
        texts[i] = scene->decals[i].text;
    struct ap_error why = {""};
    if (scene->decal_count > 0 &&
        ap_text_atlas_create(&why, texts, (uint32_t)scene->decal_count, CELL_PX, &room->decals))
        ap_log(AP_LOG_WARNING, "the balls bear no numbers: %s", why.text);
    free(texts);
    return AP_OK;
}

void ap_room_renderer_params(const struct ap_room *room, struct ap_renderer_params *params) {
    params->max_error_px = room->max_error_px;
    params->samples = room->samples;
    params->no_cull = room->no_cull;
    params->decals = room->decals.coverage;
    params->decal_px = room->decals.cell_px;
    params->decal_count = room->decals.count;
}

enum ap_status ap_room_follow(struct ap_error *err, struct ap_room *room,
                              struct ap_iso *world_from_head, struct ap_iso world_from_hand[2]) {
    enum { MOST = 1000 }; // in one frame
    const struct ap_honeycomb *h = room->scene->honeycomb;
    struct ap_vec4 base = {0, 0, 0, room->scene->space.rho_m};
    for (int i = 0; h && i < MOST; i++) {
        int face = ap_cells_left_by(&h->tiling, ap_iso_apply(world_from_head, base));
        if (face < 0)
            break;
        int back = h->pairing.to[face];
        const struct ap_iso *step = &h->pairing.cell_from_neighbour[back];
        enum ap_status st = ap_tracker_rebase(err, room->tracker, step, &h->pairing.low[back],
                                              room->deep_steps ? &room->deep_steps[back] : NULL);
        if (st)
            return st;
        *world_from_head = ap_iso_mul(*step, *world_from_head);
        for (int hand = 0; hand < 2; hand++)
            world_from_hand[hand] = ap_iso_mul(*step, world_from_hand[hand]);
        room->cells_crossed++;
    }
    return AP_OK;
}

void ap_room_switch_view(struct ap_room *room) {
    room->view = room->view == AP_VIEW_TOURIST ? AP_VIEW_NATIVE : AP_VIEW_TOURIST;
}

static enum ap_status choose_quality(struct ap_error *err, const struct ap_room_options *o,
                                     struct ap_room *room) {
    if (!isnan(o->max_error_px) && !(o->max_error_px >= 0.001 && o->max_error_px <= 100))
        return ap_fail(err, AP_USAGE, "--max-error: expected 0.001 to 100 pixels");
    if (!isnan(o->samples) && o->samples != 1 && o->samples != 4 && o->samples != 16 &&
        o->samples != 64)
        return ap_fail(err, AP_USAGE, "--samples: expected 1, 4, 16 or 64 a pixel");
    room->max_error_px = isnan(o->max_error_px) ? 0 : o->max_error_px;
    room->samples = isnan(o->samples) ? 0 : (uint32_t)o->samples;
    room->no_cull = o->no_cull;
    return AP_OK;
}

enum ap_status ap_room_open(struct ap_error *err, const struct ap_room_options *options,
                            struct ap_room *out) {
    struct ap_room room = {0};
    enum ap_status st = open_scene(err, options, &room.scene);
    if (!st)
        st = choose_view(err, options, &room);
    if (!st)
        st = make_decals(err, &room);
    if (!st)
        st = choose_quality(err, options, &room);
    if (!st)
        st = open_tracker(err, options, &room);
    if (st)
        ap_room_close(&room);
    else
        *out = room;
    return st;
}

void ap_room_close(struct ap_room *room) {
    ap_tracker_destroy(room->tracker);
    free(room->deep_steps);
    ap_scene_destroy(room->scene);
    ap_text_atlas_finish(&room->decals);
    *room = (struct ap_room){0};
}

static struct ap_frustum eye_frustum(const struct ap_xr_view *v, uint32_t width, uint32_t height) {
    struct ap_frustum f = {tan(v->left_rad), tan(v->right_rad), tan(v->up_rad), tan(v->down_rad)};
    if (v->width_px > 0 && v->width_px != width)
        f.right = f.left + (f.right - f.left) * width / v->width_px;
    if (v->height_px > 0 && v->height_px != height)
        f.down = f.up - (f.up - f.down) * height / v->height_px;
    return f;
}

struct ap_viewer ap_room_viewer(const struct ap_room *room, struct ap_iso world_from_head,
                                const struct ap_xr_view views[2], uint32_t width_px,
                                uint32_t height_px) {
    struct ap_viewer viewer = {.space = room->scene->space,
                               .mode = room->view,
                               .world_from_nose = world_from_head,
                               .born = room->born};
    for (int eye = 0; eye < 2; eye++)
        viewer.eye[eye] =
            (struct ap_view_eye){.view_from_eye = views[eye].view_from_eye,
                                 .frustum = eye_frustum(&views[eye], width_px, height_px)};
    return viewer;
}
