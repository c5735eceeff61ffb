#include "src/render/list.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "src/render/mesh/budget.h"
#include "src/render/refine/disc.h"

static const double PI = 3.14159265358979323846;

// What comes first in the order of drawing, as one number, so that items themselves are looked at
// only where it is equal.
struct ap_draw_key {
    uint64_t first;
    const struct ap_draw_item *item;
};

_Static_assert(sizeof(struct ap_draw_item) + sizeof(struct ap_draw_key) + sizeof(void *) +
                       AP_FRAMES_AHEAD * sizeof(struct ap_gpu_draw) <=
                   AP_PART_BYTES,
               "the budget's size of a part (src/render/mesh/budget.h)");

static enum ap_status make_room(struct ap_error *err, size_t room, struct ap_draw_list *list) {
    struct ap_draw_item *items = realloc(list->items, room * sizeof *items);
    if (items)
        list->items = items;
    const struct ap_draw_item **order = realloc(list->order, room * sizeof *order);
    if (order)
        list->order = order;
    struct ap_draw_key *keys = realloc(list->keys, room * sizeof *keys);
    if (keys)
        list->keys = keys;
    if (!items || !order || !keys)
        return ap_fail(err, AP_ENVIRONMENT, "no memory to draw %zu parts", room);
    list->room = room;
    return AP_OK;
}

enum ap_status ap_draw_list_create(struct ap_error *err, size_t part_count,
                                   struct ap_draw_list *list) {
    memset(list, 0, sizeof *list);
    return make_room(err, 2 * part_count + 1, list);
}

enum ap_status ap_draw_list_reserve(struct ap_error *err, size_t more, struct ap_draw_list *list) {
    size_t room = list->count + more + 1;
    return room <= list->room ? AP_OK : make_room(err, ap_grown(room), list);
}

size_t ap_draw_list_item_bytes(void) {
    return sizeof(struct ap_draw_item) + sizeof(struct ap_draw_key) + sizeof(void *);
}

void ap_draw_list_destroy(struct ap_draw_list *list) {
    free(list->items);
    free(list->order);
    free(list->keys);
    ap_mesh_data_finish(&list->refined);
    ap_refiner_finish(&list->refiner);
    ap_snapped_finish(&list->snapped);
    memset(list, 0, sizeof *list);
}

static int compare_items(const void *left, const void *right) {
    const struct ap_draw_item *a = *(const struct ap_draw_item *const *)left,
                              *b = *(const struct ap_draw_item *const *)right;
    bool disc = a->pipeline == AP_PIPELINE_DISC;
    if (disc != (b->pipeline == AP_PIPELINE_DISC))
        return disc ? 1 : -1;
    if (a->rank != b->rank)
        return a->rank < b->rank ? -1 : 1;
    if (a->pipeline != b->pipeline)
        return a->pipeline < b->pipeline ? -1 : 1;
    if (a->far_m != b->far_m)
        return a->far_m > b->far_m ? -1 : 1;
    if (a->refined != b->refined)
        return a->refined ? 1 : -1;
    // Where in the frame's data such a mesh lies depends on what else is drawn.
    if (a->snapped != b->snapped)
        return a->snapped < b->snapped ? -1 : 1;
    if (a->snapped == 0 && a->mesh.first_index != b->mesh.first_index)
        return a->mesh.first_index < b->mesh.first_index ? -1 : 1;
    if (a->part != b->part)
        return a->part < b->part ? -1 : 1;
    if (a->image != b->image || a->way != b->way)
        return a->image != b->image ? a->image - b->image : a->way - b->way;
    // The same part of several cells: near before far.
    double dw = a->nose_from_part.m[3][3] - b->nose_from_part.m[3][3];
    return dw == 0 ? memcmp(&a->nose_from_part, &b->nose_from_part, sizeof a->nose_from_part)
           : (dw < 0) == (a->image == 0) ? -1
                                         : 1;
}

// What compare_items looks at first; far_m is 0 but for discs.
static uint64_t first_of(const struct ap_draw_item *item) {
    enum { MOST_RANK = (1 << 20) - 1 };
    uint64_t rank = (uint64_t)(item->rank < 0           ? 0
                               : item->rank > MOST_RANK ? MOST_RANK
                                                        : item->rank);
    uint64_t first = rank << 43 | (uint64_t)item->pipeline << 35;
    if (item->pipeline == AP_PIPELINE_DISC)
        return first | UINT64_C(1) << 63;
    return first | (uint64_t)item->refined << 34 | (uint64_t)item->mesh.first_index << 2;
}

static int compare_keys(const void *left, const void *right) {
    const struct ap_draw_key *a = left, *b = right;
    if (a->first != b->first)
        return a->first < b->first ? -1 : 1;
    return compare_items(&a->item, &b->item);
}

// Counts it for the eyes of `of`: drawn, or culled where it is not for them.
static void count(struct ap_draw_list *list, const struct ap_draw_item *item, unsigned of) {
    for (int e = 0; e < 2; e++) {
        if (!(of >> e & 1))
            continue;
        struct ap_eye_stats *stats = &list->stats.eye[e];
        if (!(item->eyes >> e & 1)) {
            stats->culled++;
            continue;
        }
        stats->draws++;
        stats->back_draws += item->image == 1;
        stats->triangles += item->mesh.index_count / 3;
        stats->vertices += item->mesh.vertex_count;
    }
}

enum ap_pipeline_kind ap_pipeline_for(const struct ap_part *part, bool plain) {
    bool closed = part->one_sided || part->kind == AP_PART_BALL || part->kind == AP_PART_STICK;
    if (part->lit && part->finish == AP_FINISH_MATTE && closed && !plain)
        return part->kind == AP_PART_BALL ? AP_PIPELINE_MATTE_BALLS
               : part->form == AP_FORM_PLANE && part->kind == AP_PART_SOLID ? AP_PIPELINE_PLANES
                                                                            : AP_PIPELINE_MATTE;
    if (part->lit && part->finish != AP_FINISH_PLAIN && !plain)
        return part->kind == AP_PART_BALL    ? AP_PIPELINE_BALLS
               : part->kind == AP_PART_STICK ? AP_PIPELINE_STICKS
                                             : AP_PIPELINE_SHEETS;
    return closed ? AP_PIPELINE_CLOSED : AP_PIPELINE_TWOSIDED;
}

static bool is_guarded(enum ap_pipeline_kind pipeline) {
    return pipeline >= AP_PIPELINE_GUARD && pipeline < AP_PIPELINE_GUARD_END;
}

static bool is_matte(enum ap_pipeline_kind pipeline) {
    return pipeline == AP_PIPELINE_MATTE_BALLS || pipeline == AP_PIPELINE_MATTE ||
           pipeline == AP_PIPELINE_PLANES;
}

static bool is_closed(enum ap_pipeline_kind pipeline) {
    return is_guarded(pipeline)
               ? (pipeline - AP_PIPELINE_GUARD) & AP_GUARD_CLOSED
               : pipeline == AP_PIPELINE_CLOSED || is_matte(pipeline) ||
                     pipeline == AP_PIPELINE_BALLS || pipeline == AP_PIPELINE_STICKS;
}

enum ap_pipeline_kind ap_pipeline_looked_at(enum ap_pipeline_kind pipeline, bool one_sided) {
    unsigned draws = is_matte(pipeline)               ? AP_GUARD_MATTE
                     : pipeline == AP_PIPELINE_BALLS  ? AP_GUARD_BALLS
                     : pipeline == AP_PIPELINE_STICKS ? AP_GUARD_STICKS
                     : pipeline == AP_PIPELINE_SHEETS ? AP_GUARD_SHEETS
                                                      : 0;
    return AP_PIPELINE_GUARD + draws + (one_sided && is_closed(pipeline) ? AP_GUARD_CLOSED : 0);
}

// The same with its depth taken from the surface.
static enum ap_pipeline_kind exact(enum ap_pipeline_kind pipeline) {
    if (!is_guarded(pipeline))
        pipeline = ap_pipeline_looked_at(pipeline, true);
    return AP_PIPELINE_GUARD + ((pipeline - AP_PIPELINE_GUARD) | AP_GUARD_EXACT);
}

static void note_range(struct ap_draw_list *list, int way, double near_m, double far_m) {
    list->range.near_m[way] = fmin(list->range.near_m[way], near_m);
    list->range.far_m[way] = fmax(list->range.far_m[way], far_m);
}

// In an s3 that she was born in, things up to her antipode are seen one way, things up to a full
// turn the other; what lies across it is drawn both ways, and each fragment once. False: beyond.
static bool born_way(const struct ap_viewer *viewer, double near_m, double far_m, int way,
                     bool *across) {
    double half = PI * viewer->born.rho_m;
    if (viewer->mode != AP_VIEW_BORN || viewer->born.kappa <= 0)
        return way == 0;
    *across = far_m > half - 0.3 * viewer->born.rho_m;
    return way == 0 ? near_m < half : far_m > half && near_m < 2 * half;
}

static void add_image(struct ap_draw_list *list, const struct ap_viewer *viewer,
                      struct ap_draw_item item, unsigned of, double near_m, double far_m) {
    bool any = false, guard = is_guarded(item.pipeline);
    for (int way = 0; way < 2; way++) {
        bool across = false;
        if (!born_way(viewer, near_m, far_m, way, &across))
            continue;
        // A disc is all on one side of her antipode.
        bool disc = item.pipeline == AP_PIPELINE_DISC,
             behind = viewer->mode == AP_VIEW_BORN && viewer->born.kappa > 0 &&
                      near_m + far_m > 2 * PI * viewer->born.rho_m;
        if (disc && behind != (way == 1))
            continue;
        // Of what is culled too, so that culling changes nothing in the picture.
        bool born = viewer->mode == AP_VIEW_BORN;
        note_range(list, born ? way : item.image, near_m, far_m);
        any = true;
        item.way = way;
        if (across && !guard && !disc)
            item.pipeline = ap_pipeline_looked_at(item.pipeline, false);
        if (item.eyes != 0)
            list->items[list->count++] = item;
        count(list, &item, of);
    }
    item.eyes = 0;
    if (!any)
        count(list, &item, of);
}

void ap_draw_list_add(struct ap_draw_list *list, const struct ap_viewer *viewer,
                      const struct ap_draw_item *item, double near_m, double far_m) {
    add_image(list, viewer, *item, 3, near_m, far_m);
}

void ap_draw_list_sort(struct ap_draw_list *list) {
    for (size_t i = 0; i < list->count; i++)
        list->keys[i] = (struct ap_draw_key){first_of(&list->items[i]), &list->items[i]};
    qsort(list->keys, list->count, sizeof *list->keys, compare_keys);
    for (size_t i = 0; i < list->count; i++)
        list->order[i] = list->keys[i].item;
}

// What the bound costs: a mesh of more triangles made ahead gives way to one made for this frame,
// which is fine only where it is looked at.
enum { AHEAD_MAX = 2000 };

static size_t refined_max(const struct ap_list_params *params) {
    const struct ap_meshes *meshes = params->meshes;
    return ap_budget_triangles(params->scene, ap_meshes_bytes(meshes));
}

// Of that: small pieces have more vertices than triangles.
static size_t refined_used(const struct ap_draw_list *list) {
    size_t triangles = list->refined.index_count / 3, vertices = list->refined.vertex_count;
    return triangles > vertices + vertices / 2 ? triangles : vertices + vertices / 2;
}

// A closed bound that is missed by no more than this may be too careful.
static const double NEARLY = 3;

// Whether the finest mesh made ahead holds the bound although no closed bound says so.
static bool holds_after_all(const struct ap_list_params *params, const struct ap_place *place,
                            struct ap_draw_list *list, const struct ap_draw_item *item) {
    const struct ap_viewer *viewer = &params->input->viewer;
    const struct ap_part *part = &params->scene->parts[item->part];
    const struct ap_shape *shape =
        &params->meshes->shapes[params->meshes->shape_of_part[item->part]];
    struct ap_level level;
    if (part->kind != AP_PART_SOLID || part->form == AP_FORM_FACETS ||
        viewer->mode == AP_VIEW_BORN ||
        !ap_choose_level(viewer, params->eyes, part, shape, place, item->image,
                         NEARLY * params->max_error_px, &level))
        return false;
    const struct ap_refine_params judge = {
        .viewer = viewer,
        .eyes = params->eyes,
        .nose_from_part = item->nose_from_part,
        .image = item->image,
        .max_error_px = params->max_error_px,
        .solid = &params->scene->solids[part->solid + shape->levels - 1],
        .closed = is_closed(item->pipeline),
        .any_depth = true}; // as closed bounds have it
    return ap_refine_holds(&list->refiner, &judge, part);
}

// Facets that may be off in depth are fewer, and surfaces meet where they ought to.
static bool is_stretched(const struct ap_list_params *params, const struct ap_place *place,
                         const struct ap_draw_item *item) {
    const struct ap_part *part = &params->scene->parts[item->part];
    return ap_is_stretched(&params->input->viewer, place, item->image) && !part->apart &&
           ap_part_form(part) != AP_FORM_FACETS;
}

// Whether a cell's wall is so near to the nose that it fills half of the sky the long way round,
// and float32 does not tell points of it apart by its own coordinates.
static const double AT_NOSE = 0.01; // over rho
static bool is_at_nose(const struct ap_list_params *params, const struct ap_place *place,
                       const struct ap_draw_item *item) {
    const struct ap_viewer *viewer = &params->input->viewer;
    const struct ap_part *part = &params->scene->parts[item->part];
    return viewer->mode == AP_VIEW_NATIVE && item->image == 1 && item->lamp_in_cell &&
           part->kind == AP_PART_SOLID && part->form == AP_FORM_PLANE &&
           place->near_m < fmax(4 * AP_NEAR_M, AT_NOSE * viewer->space.rho_m);
}

// The item's wall by its coordinates at the nose's foot.
static struct ap_iso move_to_foot(struct ap_space space, struct ap_draw_item *item) {
    struct ap_iso part_from_foot = ap_plane_foot(space, &item->nose_from_part);
    struct ap_iso foot_from_part = ap_iso_inverse(space, part_from_foot);
    item->nose_from_part = ap_iso_mul(item->nose_from_part, part_from_foot);
    item->lamp = ap_iso_apply(&foot_from_part, item->lamp);
    item->at_foot = true;
    return foot_from_part;
}

static enum ap_status refine(struct ap_error *err, const struct ap_list_params *params,
                             const struct ap_place *place, const struct ap_seam_cut *seams,
                             struct ap_draw_list *list, struct ap_draw_item *item) {
    const struct ap_viewer *viewer = &params->input->viewer;
    const struct ap_part *part = &params->scene->parts[item->part];
    size_t used = refined_used(list), most = refined_max(params);
    bool stretched = is_stretched(params, place, item);
    if (stretched)
        item->pipeline = exact(item->pipeline);
    bool moves = is_at_nose(params, place, item);
    struct ap_iso foot_from_part;
    if (moves)
        foot_from_part = move_to_foot(viewer->space, item);
    const struct ap_refine_params how = {
        .viewer = viewer,
        .eyes = params->eyes,
        .nose_from_part = item->nose_from_part,
        .part_from_solid = moves ? &foot_from_part : NULL,
        .image = item->image,
        .max_error_px = params->max_error_px,
        .solid = part->kind == AP_PART_SOLID ? &params->scene->solids[part->solid] : NULL,
        .seams = seams,
        .closed = is_closed(item->pipeline),
        .any_depth = stretched || part->apart,
        .keep_unseen = params->no_cull,
        .triangles_max = most > used ? most - used : 0};
    uint32_t unseen = 0;
    bool held;
    item->refined = true;
    list->stats.refined++;
    enum ap_status st = ap_refine_part(err, &list->refiner, &how, part, &list->refined, &item->mesh,
                                       &held, &unseen);
    list->stats.unseen_facets += unseen;
    item->beyond = st == AP_OK && !held;
    list->stats.beyond_bound += item->beyond;
    bool full = refined_used(list) + 1 >= most && most < ap_budget_triangles_cap(params->scene);
    list->stats.over_budget += item->beyond && full;
    return st;
}

enum ap_status ap_draw_list_mesh(struct ap_error *err, const struct ap_list_params *params,
                                 const struct ap_place *place, const struct ap_level *known,
                                 struct ap_draw_list *list, struct ap_draw_item *item) {
    const struct ap_viewer *viewer = &params->input->viewer;
    const struct ap_part *part = &params->scene->parts[item->part];
    size_t index = params->meshes->shape_of_part[item->part];
    const struct ap_shape *shape = &params->meshes->shapes[index];
    struct ap_seam_cut cuts[AP_SEAMS_MAX] = {{0}};
    struct ap_level chosen;
    bool held = known || ap_choose_level(viewer, params->eyes, part, shape, place, item->image,
                                         params->max_error_px, &chosen);
    if (known)
        chosen = *known;
    int level = chosen.level, pieces = 1;
    bool seams = shape->seam_count > 0, small = shape->mesh[level].index_count / 3 <= AHEAD_MAX;
    // What holds the bound with whole seams has no others.
    bool cut = seams && !(known && level == 0), judged = cut && !(chosen.whole_seams && small);
    bool snaps = !judged || ap_seams_cut(viewer, params->eyes, part, shape, &item->nose_from_part,
                                         item->image, params->max_error_px, cuts, &pieces);
    if (!held && snaps && holds_after_all(params, place, list, item)) {
        held = true;
        if (is_stretched(params, place, item))
            item->pipeline = exact(item->pipeline);
    }
    while (held && cut && snaps && shape->seam_pieces[level] < pieces)
        level++;
    item->mesh = shape->mesh[level];
    size_t most = refined_max(params);
    bool fixed = part->kind == AP_PART_SOLID && part->form == AP_FORM_FACETS,
         full = refined_used(list) >= most;
    if (!fixed && !full && !(held && snaps && item->mesh.index_count / 3 <= AHEAD_MAX))
        return refine(err, params, place, seams ? cuts : NULL, list, item);
    item->beyond = !held;
    list->stats.beyond_bound += !held;
    list->stats.over_budget +=
        !held && !fixed && full && most < ap_budget_triangles_cap(params->scene);
    if (!held || !cut || !snaps)
        return AP_OK;
    // Where the budget has no room for coarser seams they stay as fine as the level: they may gape.
    list->stats.over_budget += full && most < ap_budget_triangles_cap(params->scene);
    if (full)
        return AP_OK;
    return ap_snapped_mesh(err, &list->snapped, params->meshes, index, level, cuts, &list->refined,
                           &item->mesh, &item->snapped, &item->refined);
}

// An unlit ball as a disc with a computed rim, for the eyes that see it well; those it leaves in
// item->eyes get a mesh. *of: the eyes that it is counted for.
static enum ap_status add_disc(struct ap_error *err, const struct ap_list_params *params,
                               struct ap_draw_list *list, struct ap_draw_item *item,
                               const double range_m[2], unsigned *of) {
    const struct ap_viewer *viewer = &params->input->viewer;
    const struct ap_part *part = &params->scene->parts[item->part];
    struct ap_vec4 base = {0, 0, 0, viewer->space.rho_m};
    struct ap_vec4 centre = ap_iso_apply(&item->nose_from_part, base);
    struct ap_disc_params disc = {.viewer = viewer,
                                  .width_px = params->width_px,
                                  .height_px = params->height_px,
                                  .world_centre = ap_iso_apply(&viewer->world_from_nose, centre),
                                  .radius_m = part->radius_m,
                                  .image = item->image,
                                  .max_error_px = params->max_error_px};
    size_t most = refined_max(params);
    bool bounded = most < ap_budget_triangles_cap(params->scene), full = false;
    struct ap_draw_item drawn = *item;
    drawn.eyes = 0;
    drawn.pipeline = AP_PIPELINE_DISC;
    drawn.refined = true;
    drawn.far_m = range_m[1];
    drawn.mesh = ap_mesh_data_begin(&list->refined);
    enum ap_status st = AP_OK;
    for (int e = 0; st == AP_OK && e < 2; e++) {
        enum ap_disc_made made = AP_DISC_UNFIT;
        size_t used = refined_used(list);
        disc.triangles_max = !bounded ? SIZE_MAX : used < most ? most - used : 0;
        if (item->eyes >> e & 1)
            st = ap_disc_append(err, &disc, e, &list->refined, drawn.mesh.first_vertex, &made);
        drawn.eyes |= made == AP_DISC_MADE ? 1u << e : 0;
        full |= made == AP_DISC_NO_ROOM;
    }
    list->stats.over_budget += full;
    *of = 3 & ~drawn.eyes;
    item->eyes &= ~drawn.eyes;
    if (st != AP_OK || drawn.eyes == 0)
        return st;
    ap_mesh_data_end(&list->refined, &drawn.mesh);
    add_image(list, viewer, drawn, drawn.eyes, range_m[0], range_m[1]);
    return AP_OK;
}

static enum ap_status add_part(struct ap_error *err, const struct ap_list_params *params,
                               const struct ap_place_params *where, size_t index,
                               struct ap_draw_list *list) {
    const struct ap_viewer *viewer = where->viewer;
    const struct ap_part *part = &params->scene->parts[index];
    double reach_m = part->kind == AP_PART_BALL ? part->radius_m : params->meshes->reach_m[index];
    struct ap_place place = ap_place_part(where, part, reach_m);
    if (!ap_place_in_domain(&place)) {
        list->stats.out_of_domain++;
        return AP_OK;
    }
    unsigned open_eyes = ~params->input->closed_eyes;
    for (int e = 0; e < 2; e++)
        list->stats.eye[e].back_hidden += place.behind >> e & 1;
    double turn = 2 * PI * viewer->space.rho_m;
    enum ap_status st = AP_OK;
    for (int image = 0; st == AP_OK && image < (viewer->space.kappa > 0 ? 2 : 1); image++) {
        struct ap_draw_item item = {.part = (uint32_t)index,
                                    .image = image,
                                    .eyes = place.eyes[image] & open_eyes,
                                    .nose_from_part = place.nose_from_part,
                                    .brightness = 1};
        const double range_m[2] = {image ? turn - place.far_m : place.near_m,
                                   image ? turn - place.near_m : place.far_m};
        unsigned of = 3;
        if (item.eyes != 0 && part->kind == AP_PART_BALL && !part->lit &&
            ap_clear_of_eyes(viewer, params->eyes, &place))
            st = add_disc(err, params, list, &item, range_m, &of);
        if (st == AP_OK && item.eyes != 0) {
            bool guard = ap_needs_guard(viewer, params->eyes, &place);
            item.pipeline = ap_pipeline_for(part, params->input->plain);
            if (guard) // both sides: an eye may be inside
                item.pipeline = ap_pipeline_looked_at(item.pipeline, false);
            st = ap_draw_list_mesh(err, params, &place, NULL, list, &item);
            // A straight facet's depth would be off by more than what lies behind one another.
            if (image == 1 && viewer->mode == AP_VIEW_NATIVE)
                item.pipeline = exact(item.pipeline);
        }
        if (st == AP_OK && of != 0)
            add_image(list, viewer, item, of, range_m[0], range_m[1]);
    }
    return st;
}

// The polygons of s3 that hide what is seen the long way round.
enum { SCREENS_MAX = 16 };
static int find_screens(const struct ap_list_params *params, const struct ap_place_params *where,
                        struct ap_screen screens[SCREENS_MAX]) {
    const struct ap_scene *scene = params->scene;
    double slack_rad =
        4 * params->max_error_px / fmin(params->eyes->pixels[0], params->eyes->pixels[1]);
    int count = 0;
    for (size_t i = 0; where->viewer->space.kappa > 0 && i < scene->part_count; i++) {
        const struct ap_part *part = &scene->parts[i];
        if (count < SCREENS_MAX && !part->hidden && part->carrier == AP_CARRIER_WORLD &&
            ap_place_screen(where, part, params->meshes->reach_m[i], slack_rad, &screens[count]))
            count++;
    }
    return count;
}

enum ap_status ap_draw_list_fill(struct ap_error *err, const struct ap_list_params *params,
                                 struct ap_draw_list *list) {
    const struct ap_frame_input *input = params->input;
    const struct ap_viewer *viewer = &input->viewer;
    struct ap_iso nose_from_world = ap_iso_inverse(viewer->space, viewer->world_from_nose);
    struct ap_place_params where = {.viewer = viewer, .no_cull = params->no_cull};
    where.nose_from_carrier[AP_CARRIER_WORLD] = nose_from_world;
    where.nose_from_carrier[AP_CARRIER_LEFT] =
        ap_iso_mul(nose_from_world, input->world_from_hand[0]);
    where.nose_from_carrier[AP_CARRIER_RIGHT] =
        ap_iso_mul(nose_from_world, input->world_from_hand[1]);
    struct ap_screen screens[SCREENS_MAX];
    where.screen_count = find_screens(params, &where, screens);
    where.screens = screens;
    list->count = 0;
    list->refined.vertex_count = list->refined.index_count = 0;
    ap_snapped_clear(&list->snapped);
    memset(&list->stats, 0, sizeof list->stats);
    for (int image = 0; image < 2; image++) {
        list->range.near_m[image] = INFINITY;
        list->range.far_m[image] = 0;
    }
    // A disc and a mesh, for both images and both ways round the space she was born in.
    enum { EACH = 8 };
    enum ap_status st = AP_OK;
    const struct ap_honeycomb *cells = params->scene->honeycomb;
    for (size_t i = 0; st == AP_OK && i < params->scene->part_count; i++) {
        const struct ap_part *part = &params->scene->parts[i];
        bool in_cells = part->carrier == AP_CARRIER_CELL ||
                        (cells && cells->quotient && part->carrier != AP_CARRIER_WORLD);
        bool missing = in_cells || (part->carrier == AP_CARRIER_LEFT && !input->hand_tracked[0]) ||
                       (part->carrier == AP_CARRIER_RIGHT && !input->hand_tracked[1]);
        if (part->hidden || missing)
            continue;
        st = ap_draw_list_reserve(err, EACH, list);
        if (st == AP_OK)
            st = add_part(err, params, &where, i, list);
    }
    return st;
}

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
