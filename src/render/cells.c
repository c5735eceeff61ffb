#include "src/render/cells.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "src/base/log.h"
#include "src/render/mesh/budget.h"
#include "src/render/pass/kind.h"
#include "src/view/cull.h"

enum { UNKNOWN = -1, NONE_HOLDS = -2 };
static const double PI = 3.14159265358979323846;

// What one frame has in common.
struct frame {
    const struct ap_scene *scene;
    const struct ap_meshes *meshes;
    const struct ap_frame_input *input;
    const struct ap_viewer *viewer;
    const struct ap_eyes *eyes;
    int rank;                  // of the cell at hand
    struct ap_sides sides;     // of what the eyes may see of the cell at hand
    bool windows;              // walls stand before the cells
    double horizon_m, faint_m; // where parts are gone, and where they begin to fade
    double least_rad;          // the half angle that is no longer drawn
    const struct ap_list_params *what;
    struct ap_cell_view *view;
    struct ap_draw_list *list;
    struct ap_iso cell_from_hand[2];
};

static bool in_cells(const struct ap_scene *scene, const struct ap_part *part) {
    return part->carrier == AP_CARRIER_CELL ||
           (scene->honeycomb->quotient && part->carrier != AP_CARRIER_WORLD);
}

enum ap_status ap_cell_view_create(struct ap_error *err, const struct ap_scene *scene,
                                   const struct ap_meshes *meshes, struct ap_cell_view *view) {
    const struct ap_honeycomb *h = scene->honeycomb;
    memset(view, 0, sizeof *view);
    view->parts = calloc(scene->part_count + 1, sizeof *view->parts);
    view->level = calloc(meshes->shape_count + 1, sizeof *view->level);
    view->shape_count = meshes->shape_count;
    if (!view->parts || !view->level)
        return ap_fail(err, AP_ENVIRONMENT, "no memory for the parts of a cell");
    for (size_t i = 0; i < scene->part_count; i++)
        if (in_cells(scene, &scene->parts[i]))
            view->parts[view->part_count++] = i;
    return ap_cells_create(err, &h->tiling, &h->pairing, ap_budget_known_cells(scene),
                           &view->cells);
}

void ap_cell_view_destroy(struct ap_cell_view *view) {
    free(view->parts);
    free(view->level);
    ap_cells_destroy(view->cells);
    ap_portal_finish(&view->portal);
    memset(view, 0, sizeof *view);
}

// 1 near by, 0 at the horizon; in s3 a part of it is kept all the way round.
static float brightness(const struct frame *f, const struct ap_seen_cell *cell) {
    double rho = f->viewer->space.rho_m, d = cell->distance_m;
    if (f->viewer->space.kappa > 0) {
        d = cell->image ? 2 * PI * rho - d : d;
        return (float)(1 - 0.8 * d / (2 * PI * rho));
    }
    double edge = (f->horizon_m - d) / (f->horizon_m - f->faint_m);
    return (float)(fmin(1, fmax(0, edge)) * (1 - 0.5 * d / f->horizon_m));
}

// A mirrored cell's pieces are their own mirror images, so that a rotation does for them.
static struct ap_iso unmirrored(struct ap_iso m) {
    for (int i = 0; i < 4; i++)
        m.m[i][0] = -m.m[i][0];
    return m;
}

// Near by each part has a mesh of its own, farther off the whole cell has one level of each shape,
// as long as that is good enough.
static enum ap_status choose_mesh(struct ap_error *err, const struct frame *f,
                                  const struct ap_seen_cell *cell, bool near_cell,
                                  const struct ap_place *place, struct ap_draw_item *item) {
    const struct ap_part *part = &f->scene->parts[item->part];
    size_t s = f->meshes->shape_of_part[item->part];
    const struct ap_shape *shape = &f->meshes->shapes[s];
    struct ap_level *level = &f->view->level[s];
    struct ap_place whole = *place;
    whole.nose_from_part = cell->nose_from_cell;
    whole.reach_m = cell->far_m - cell->distance_m;
    whole.anywhere = true;
    if (!near_cell && level->level == UNKNOWN &&
        !ap_choose_level(f->viewer, f->eyes, part, shape, &whole, item->image,
                         f->what->max_error_px, level))
        level->level = NONE_HOLDS;
    bool known = !near_cell && level->level != NONE_HOLDS;
    return ap_draw_list_mesh(err, f->what, place, known ? level : NULL, f->list, item);
}

static enum ap_pipeline_kind pipeline_of(const struct frame *f, const struct ap_part *part,
                                         bool guard) {
    enum ap_pipeline_kind kind = ap_pipeline_for(part, f->input->plain);
    return guard ? ap_pipeline_looked_at(kind, true) : kind;
}

static bool is_hand(const struct ap_part *part) {
    return part->carrier == AP_CARRIER_LEFT || part->carrier == AP_CARRIER_RIGHT;
}

// Where a part is, and the cell's lamp as seen from it.
static void place_item(const struct frame *f, const struct ap_seen_cell *cell,
                       const struct ap_part *part, struct ap_draw_item *item) {
    struct ap_iso cell_from_part = part->carrier_from_part;
    if (is_hand(part))
        cell_from_part =
            ap_iso_mul(f->cell_from_hand[part->carrier == AP_CARRIER_RIGHT], cell_from_part);
    struct ap_iso part_from_cell = ap_iso_inverse(f->viewer->space, cell_from_part);
    item->nose_from_part = ap_iso_mul(cell->nose_from_cell, cell_from_part);
    item->lamp_in_cell = true;
    item->lamp = ap_iso_apply(&part_from_cell, f->scene->honeycomb->lamp);
    bool symmetric = part->one_sided || part->kind != AP_PART_SOLID;
    if (!cell->reverses || !symmetric)
        return;
    item->nose_from_part = unmirrored(item->nose_from_part);
    item->lamp.x = -item->lamp.x;
}

// Hands are small, and many triangles: what of them is seen from this cell, 1 near by and 0 where
// they are smaller than the smallest cell that is drawn.
static float hand_brightness(const struct frame *f, const struct ap_seen_cell *cell,
                             double reach_m) {
    struct ap_space space = f->viewer->space;
    double rho = space.rho_m, d = cell->distance_m;
    double size = ap_space_sin(space, reach_m / rho) / fmax(ap_space_sin(space, d / rho), 1e-9);
    return (float)fmin(1, fmax(0, size / sin(f->least_rad) - 1));
}

static struct ap_vec4 nose_in_part(const struct frame *f, const struct ap_draw_item *item) {
    const struct ap_space space = f->viewer->space;
    struct ap_iso part_from_nose = ap_iso_inverse(space, item->nose_from_part);
    return ap_iso_apply(&part_from_nose, (struct ap_vec4){0, 0, 0, space.rho_m});
}

// Whether no eye sees more than the back of it; counts it.
static bool turned_away(const struct frame *f, const struct ap_place *place,
                        const struct ap_shape *shape, struct ap_vec4 nose, double bulge_m,
                        const struct ap_draw_item *item) {
    const struct ap_facing facing = {.nose = nose,
                                     .out = shape->out,
                                     .count = shape->out_count,
                                     .near_m = place->near_m,
                                     .far_m = place->far_m,
                                     .bulge_m = bulge_m};
    if (f->what->no_cull || !ap_turned_away(f->viewer, f->eyes->reach_m, &facing, item->image))
        return false;
    for (int e = 0; e < 2; e++)
        f->list->stats.eye[e].turned_away += item->eyes >> e & 1;
    return true;
}

static enum ap_status add(struct ap_error *err, const struct frame *f,
                          const struct ap_seen_cell *cell, size_t index) {
    const struct ap_part *part = &f->scene->parts[index];
    struct ap_space space = f->viewer->space;
    double rho = space.rho_m, reach_m = f->meshes->reach_m[index];
    struct ap_draw_item item = {.part = (uint32_t)index,
                                .image = cell->image,
                                .eyes = 3,
                                .rank = f->rank,
                                .brightness = brightness(f, cell)};
    if (is_hand(part))
        item.brightness *= hand_brightness(f, cell, reach_m);
    if (item.brightness <= 0)
        return AP_OK;
    place_item(f, cell, part, &item);
    struct ap_vec4 centre = {rho * item.nose_from_part.m[0][3], rho * item.nose_from_part.m[1][3],
                             rho * item.nose_from_part.m[2][3], rho * item.nose_from_part.m[3][3]};
    if (!f->what->no_cull && f->viewer->mode != AP_VIEW_BORN && (f->windows || cell->within != 3))
        item.eyes = ap_sides_see_ball(&f->sides, space, centre, reach_m, cell->image);
    item.eyes &= cell->eyes;
    item.eyes &= ~f->input->closed_eyes;
    struct ap_place place = {.nose_from_part = item.nose_from_part,
                             .near_m = cell->near_m,
                             .far_m = cell->far_m,
                             .reach_m = reach_m};
    bool near_cell = cell->near_m < 2 * (cell->far_m - cell->near_m) || space.kappa > 0;
    if (near_cell && item.eyes) {
        double d = ap_base_distance(space, centre);
        place.near_m = fmax(0, d - reach_m);
        place.far_m = space.kappa > 0 ? fmin(d + reach_m, PI * rho) : d + reach_m;
    }
    const struct ap_shape *shape = &f->meshes->shapes[f->meshes->shape_of_part[index]];
    if (item.eyes && shape->out_count) {
        struct ap_vec4 nose = nose_in_part(f, &item);
        double clear = near_cell ? ap_clearance(space, part, nose) : 0;
        place.near_m = fmax(place.near_m, clear);
        if (space.kappa > 0)
            place.far_m = fmin(place.far_m, PI * rho - clear);
        if (turned_away(f, &place, shape, nose, part->radius_m, &item))
            item.eyes = 0;
    }
    item.mesh = shape->mesh[0];
    item.pipeline = pipeline_of(f, part, ap_needs_guard(f->viewer, f->eyes, &place));
    enum ap_status st = item.eyes ? choose_mesh(err, f, cell, near_cell, &place, &item) : AP_OK;
    if (st)
        return st;
    double turn = 2 * PI * rho;
    const double range_m[2] = {cell->image ? turn - place.far_m : place.near_m,
                               cell->image ? turn - place.near_m : place.far_m};
    ap_draw_list_add(f->list, f->viewer, &item, 3, range_m);
    return AP_OK;
}

// Shells of half a cell's width: within one, equal meshes are drawn together.
static int rank_of(const struct frame *f, const struct ap_seen_cell *cell) {
    double d = cell->distance_m;
    d = cell->image ? 2 * PI * f->viewer->space.rho_m - d : d;
    return (int)(d / f->scene->honeycomb->tiling.inradius_m);
}

static bool missing(const struct frame *f, const struct ap_part *part) {
    return part->hidden || (part->carrier == AP_CARRIER_LEFT && !f->input->hand_tracked[0]) ||
           (part->carrier == AP_CARRIER_RIGHT && !f->input->hand_tracked[1]);
}

// In a quotient a hand that reaches out of the cell comes in by another face.
static void bring_hands_in(struct frame *f) {
    const struct ap_honeycomb *h = f->scene->honeycomb;
    struct ap_vec4 base = {0, 0, 0, f->viewer->space.rho_m};
    for (int hand = 0; hand < 2; hand++) {
        struct ap_iso *m = &f->cell_from_hand[hand];
        *m = f->input->world_from_hand[hand];
        for (int step = 0; f->input->hand_tracked[hand] && step < 16; step++) {
            int face = ap_cells_left_by(&h->tiling, ap_iso_apply(m, base));
            if (face < 0)
                break;
            *m = ap_iso_mul(h->pairing.cell_from_neighbour[h->pairing.to[face]], *m);
        }
    }
}

static void set_horizon(struct frame *f) {
    const struct ap_honeycomb *h = f->scene->honeycomb;
    double pixels = fmax(f->eyes->pixels[0], f->eyes->pixels[1]);
    double angle = atan(h->horizon_px / pixels), reach = h->tiling.circumradius_m;
    f->least_rad = fmin(angle, 1);
    f->horizon_m = ap_horizon_m(f->viewer->space, reach, angle);
    f->faint_m = ap_horizon_m(f->viewer->space, reach, fmin(2.5 * angle, 1.2));
    f->faint_m = fmin(f->faint_m, 0.9 * f->horizon_m);
}

// Across a geodesic through the base point: how far a point is, whose coordinates across it these
// are.
static double across_m(struct ap_space space, double a, double b) {
    return space.rho_m * asin(fmin(hypot(a, b) / space.rho_m, 1));
}

// A lower bound of how far a point of s3 (cell's frame) is from a part of its own cell; *bulge_m at
// least the radius of what stands on the cell's edges and corners. False: not known.
static bool part_clearance(const struct frame *f, const struct ap_part *part, struct ap_vec4 p_m,
                           double *clear_m, double *bulge_m) {
    struct ap_space space = f->viewer->space;
    struct ap_iso part_from_cell = ap_iso_inverse(space, part->carrier_from_part);
    struct ap_vec4 q = ap_iso_apply(&part_from_cell, p_m);
    bool ball = part->kind == AP_PART_BALL;
    if (part->carrier != AP_CARRIER_CELL || (part->kind != AP_PART_SOLID && !ball) ||
        (part->form == AP_FORM_FACETS && !ball))
        return false;
    if (!ball && part->form == AP_FORM_PLANE) {
        *clear_m = across_m(space, q.y, 0);
        return true;
    }
    double sphere = across_m(space, hypot(q.x, q.y), q.z); // never more than the distance
    double from = ball                          ? sphere
                  : part->form == AP_FORM_TUBE  ? across_m(space, q.y, q.z)
                  : part->form == AP_FORM_STICK ? across_m(space, q.x, q.y)
                                                : sphere;
    *clear_m = from - part->radius_m;
    if (!ball)
        *bulge_m = fmax(*bulge_m, part->radius_m);
    return true;
}

// A lower bound of how far a point of the first cell (its frame) is from anything in s3; 0: not
// known. What other cells hold is beyond the faces, but for tubes that leave a corner of this cell
// for another: those reach across a face only within some radii of the corner.
static double clearance_m(const struct frame *f, struct ap_vec4 p_m) {
    const struct ap_scene *scene = f->scene;
    const struct ap_tiling *t = &scene->honeycomb->tiling;
    double faces = INFINITY, own = INFINITY, bulge = 0;
    if (f->input->hand_tracked[0] || f->input->hand_tracked[1])
        return 0;
    for (size_t i = 0; i < scene->part_count; i++) {
        double clear;
        if (scene->parts[i].hidden || scene->parts[i].carrier == AP_CARRIER_LEFT ||
            scene->parts[i].carrier == AP_CARRIER_RIGHT)
            continue;
        if (!part_clearance(f, &scene->parts[i], p_m, &clear, &bulge))
            return 0;
        own = fmin(own, clear);
    }
    for (int k = 0; k < t->face_count; k++) {
        double inside = -ap_tiling_beyond(t, p_m, k);
        faces = fmin(faces, t->space.rho_m * asin(fmin(fmax(inside, -1), 1)));
    }
    for (int k = 0; k < t->vertex_count; k++) {
        struct ap_vec4 v = t->vertex_m[k];
        struct ap_vec4 off = {v.x - p_m.x, v.y - p_m.y, v.z - p_m.z, v.w - p_m.w};
        double chord = sqrt(off.x * off.x + off.y * off.y + off.z * off.z + off.w * off.w);
        faces = fmin(faces, chord - 3 * bulge); // a chord is shorter than its arc
    }
    return fmax(0, 0.9 * fmin(own, faces));
}

// Likewise of both eyes of a tourist, who stand in the curved space.
static double eyes_clearance_m(const struct frame *f) {
    struct ap_space space = f->viewer->space;
    const struct ap_vec4 base = {0, 0, 0, space.rho_m};
    double clear = INFINITY;
    for (int e = 0; e < 2; e++) {
        struct ap_iso nose_from_eye = ap_iso_translate(space, f->viewer->eye[e].view_from_eye.p);
        struct ap_vec4 eye = ap_iso_apply(&nose_from_eye, base);
        eye = ap_iso_apply(&f->viewer->world_from_nose, eye);
        clear = fmin(clear, clearance_m(f, eye));
    }
    return clear;
}

// Depths are spread over all that there may be, so that leaving cells out changes no picture: in s3
// from where the nearest thing may be to where the farthest may be. Cotangents are without bound
// next to the nose and its antipode, and float32 spread over all of them tells surfaces a quarter
// turn off apart only to 2 mm in a metre: seams there were up to 0.7 px off. Point reflection takes
// each tiling but {3,3,3} to itself, so what an eye is clear of its antipode is, too.
static void note_ranges(const struct frame *f) {
    double half = PI * f->viewer->space.rho_m;
    double *near_m = f->list->range.near_m, *far_m = f->list->range.far_m;
    bool s3 = f->viewer->space.kappa > 0;
    struct ap_symbol symbol = f->scene->honeycomb->tiling.symbol;
    bool central = symbol.p != 3 || symbol.q != 3 || symbol.r != 3;
    // Somebody born elsewhere has another space's cotangents.
    bool known = s3 && f->viewer->mode == AP_VIEW_TOURIST;
    // From the nose the range is said, which the eyes' reach is taken off.
    double clear = known ? eyes_clearance_m(f) + f->eyes->reach_m : 0;
    double antipode = central ? clear : 0;
    near_m[0] = fmin(near_m[0], clear);
    far_m[0] = fmax(far_m[0], s3 ? half - antipode : 2 * f->horizon_m);
    near_m[1] = fmin(near_m[1], s3 ? half + antipode : 0);
    far_m[1] = fmax(far_m[1], s3 ? 2 * half - clear : 2 * f->horizon_m);
}

// Walls hide what is behind them unless a hand, drawn with the cell of its wrist, reaches through.
static bool windows_are_clear(const struct frame *f) {
    const struct ap_honeycomb *h = f->scene->honeycomb;
    bool hands = f->input->hand_tracked[0] || f->input->hand_tracked[1];
    return h->has_walls && !(h->quotient && hands);
}

// Of a cell: both eyes look no farther to the sides than the windows on the way allow.
static struct ap_sides sides_of_cell(const struct frame *f, const struct ap_seen_cell *cell) {
    struct ap_viewer viewer = *f->viewer;
    for (int e = 0; e < 2; e++) {
        const struct ap_gaze *g = &cell->gaze[e];
        if (cell->eyes >> e & 1)
            viewer.eye[e].frustum =
                (struct ap_frustum){g->low[0], g->high[0], g->high[1], g->low[1]};
    }
    return ap_sides_of(&viewer);
}

static void tell_budget(struct ap_cell_view *view, const struct ap_portal_stats *s) {
    if (s->budget == 0 || view->warned)
        return;
    view->warned = true;
    ap_log(AP_LOG_WARNING,
           "the budget for cells is used up after %zu of them: the world ends nearer than its "
           "horizon (give a larger --budget, or a nearer horizon)",
           view->cells->count);
}

enum ap_status ap_cell_view_fill(struct ap_error *err, struct ap_cell_view *view,
                                 const struct ap_list_params *what, struct ap_draw_list *list) {
    const struct ap_scene *scene = what->scene;
    const struct ap_viewer *viewer = &what->input->viewer;
    struct frame f = {.scene = scene,
                      .meshes = what->meshes,
                      .input = what->input,
                      .viewer = viewer,
                      .eyes = what->eyes,
                      .what = what,
                      .view = view,
                      .list = list,
                      .sides = ap_sides_of(viewer)};
    set_horizon(&f);
    bring_hands_in(&f);
    f.windows = windows_are_clear(&f);
    const struct ap_portal_params params = {
        .viewer = viewer,
        .horizon_m = f.horizon_m,
        .most_cells = ap_budget_cells(scene, view->part_count),
        .window = f.windows ? scene->honeycomb->window : NULL,
        // A window's rim is drawn within the bound, here of the smaller picture.
        .slack_rad = 4 * what->max_error_px / fmin(what->eyes->pixels[0], what->eyes->pixels[1]),
        .no_cull = what->no_cull};
    struct ap_portal_stats stats;
    enum ap_status st = ap_portal_walk(err, view->cells, &params, &view->portal, &stats);
    if (st)
        return st;
    tell_budget(view, &stats);
    struct ap_depth_range beside = list->range; // of what is not in the cells
    list->stats.cells = stats;
    for (size_t i = 0; !st && i < view->portal.count; i++) {
        const struct ap_seen_cell *cell = &view->portal.seen[i];
        for (size_t s = 0; s < view->shape_count; s++)
            view->level[s].level = UNKNOWN;
        f.rank = rank_of(&f, cell);
        if (f.windows)
            f.sides = sides_of_cell(&f, cell);
        st = ap_draw_list_reserve(err, 2 * view->part_count, list);
        for (size_t k = 0; !st && k < view->part_count; k++)
            if (!missing(&f, &scene->parts[view->parts[k]]))
                st = add(err, &f, cell, view->parts[k]);
    }
    if (viewer->space.kappa > 0 && viewer->mode == AP_VIEW_TOURIST)
        list->range = beside; // the cells' own is known better as a whole
    note_ranges(&f);
    return st;
}
