#include "src/render/list.h"

#include <math.h>
#include <string.h>

#include "src/render/mesh/budget.h"
#include "src/render/pass/kind.h"
#include "src/render/refine/disc.h"

static const double PI = 3.14159265358979323846;

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
        .closed = ap_pipeline_is_closed(item->pipeline),
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
        item->pipeline = ap_pipeline_exact(item->pipeline);
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
        .closed = ap_pipeline_is_closed(item->pipeline),
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
            item->pipeline = ap_pipeline_exact(item->pipeline);
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
    ap_draw_list_add(list, viewer, &drawn, drawn.eyes, range_m);
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
                item.pipeline = ap_pipeline_exact(item.pipeline);
        }
        if (st == AP_OK && of != 0)
            ap_draw_list_add(list, viewer, &item, of, range_m);
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
