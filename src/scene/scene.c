#include "src/scene/build.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const double default_edge_m = 0.9, default_height_m = 0.75;

// The edge of the table and the radius of the space fix each other in s3 and h3.
static enum ap_status resolve_space(struct ap_error *err, const struct ap_space_request *r,
                                    struct ap_table_shape *table) {
    const char *name = r->space_name        ? r->space_name
                       : r->file_space_name ? r->file_space_name
                                            : "h3";
    double radius = r->radius_m > 0 ? r->radius_m : r->file_radius_m;
    struct ap_space space;
    enum ap_status st = ap_space_from_name(err, name, radius > 0 ? radius : 1, &space);
    if (st)
        return st;
    double edge = r->table_edge_m > 0 ? r->table_edge_m : default_edge_m;
    if (!(radius > 0)) {
        *table = ap_table_from_edge(space.kappa, edge, 1);
        return AP_OK;
    }
    if (space.kappa != 0) {
        double fits = ap_table_edge_of_radius(space);
        if (r->has_table && r->table_edge_m > 0 && fabs(r->table_edge_m - fits) > 1e-9)
            return ap_fail(err, AP_USAGE,
                           "a right-angled table in %s of radius %.17g m has an edge of %.17g m, "
                           "not %.17g m: give the radius or --table-edge, not both",
                           name, radius, fits, r->table_edge_m);
        edge = r->has_table || !(r->table_edge_m > 0) ? fits : edge;
    }
    *table = ap_table_from_edge(space.kappa, edge, radius);
    table->space = space; // exactly as given
    return AP_OK;
}

static enum ap_status check_request(struct ap_error *err, const struct ap_space_request *r) {
    const double given[] = {r->radius_m, r->table_edge_m, r->table_height_m};
    const char *const what[] = {"radius", "table edge", "table height"};
    const double most_m[] = {1e9, 1e6, 1e6};
    for (int i = 0; i < 3; i++)
        if (!(given[i] >= 0) || !isfinite(given[i]) || given[i] > most_m[i])
            return ap_fail(err, AP_USAGE, "a %s of %g m: expected a length above 0, at most %g m",
                           what[i], given[i], most_m[i]);
    return AP_OK;
}

enum ap_status ap_build_init(struct ap_error *err, const struct ap_space_request *request,
                             struct ap_scene_build *build) {
    struct ap_scene_build b = {0};
    enum ap_status st = check_request(err, request);
    if (!st)
        st = resolve_space(err, request, &b.table);
    if (st)
        return st;
    b.scene = calloc(1, sizeof *b.scene);
    if (!b.scene)
        return ap_fail(err, AP_ENVIRONMENT, "out of memory for a scene");
    b.scene->space = b.table.space;
    b.scene->budget_bytes = request->budget_bytes;
    b.scene->has_table = request->has_table;
    b.scene->table_edge_m = b.table.edge_m;
    b.scene->table_height_m =
        request->table_height_m > 0 ? request->table_height_m : default_height_m;
    double unit_m = b.scene->space.kappa ? fmin(b.scene->space.rho_m, 1) : 1;
    b.scene->lamp =
        ap_exp(b.scene->space, ap_vec3_scale(unit_m, (struct ap_vec3){0.25, 1.05, 0.35}));
    *build = b;
    return AP_OK;
}

void ap_build_abort(struct ap_scene_build *build) {
    ap_scene_destroy(build->scene);
    *build = (struct ap_scene_build){0};
}

enum ap_status ap_build_finish(struct ap_error *err, struct ap_scene_build *build,
                               struct ap_scene **scene) {
    if (build->out_of_memory) {
        ap_build_abort(build);
        return ap_fail(err, AP_ENVIRONMENT, "out of memory for a scene");
    }
    *scene = build->scene;
    *build = (struct ap_scene_build){0};
    return AP_OK;
}

// Room for one more element, doubling; false without memory.
static bool make_room(void **items, size_t count, size_t *room, size_t size) {
    if (count < *room)
        return true;
    size_t more = *room ? 2 * *room : 64;
    void *grown = realloc(*items, more * size);
    if (!grown)
        return false;
    *items = grown;
    *room = more;
    return true;
}

void ap_build_part(struct ap_scene_build *build, struct ap_part part) {
    struct ap_scene *s = build->scene;
    void *items = s->parts;
    if (!make_room(&items, s->part_count, &build->part_room, sizeof part)) {
        build->out_of_memory = true;
        return;
    }
    s->parts = items;
    part.object = build->object;
    s->parts[s->part_count++] = part;
}

int ap_build_solid(struct ap_scene_build *build, struct ap_mesh *mesh) {
    struct ap_scene *s = build->scene;
    void *items = s->solids;
    if (mesh->out_of_memory ||
        !make_room(&items, s->solid_count, &build->solid_room, sizeof mesh->solid)) {
        build->out_of_memory = true;
        ap_mesh_finish(mesh);
        return 0;
    }
    s->solids = items;
    s->solids[s->solid_count] = mesh->solid;
    *mesh = (struct ap_mesh){0};
    return (int)s->solid_count++;
}

int ap_build_level(struct ap_scene_build *build, struct ap_mesh *mesh, int level,
                   double *radius_m) {
    double round_m = mesh->roundest_m, sagitta_m = mesh->sagitta_m;
    int at = ap_build_solid(build, mesh);
    if (build->out_of_memory)
        return 0;
    struct ap_solid *solid = &build->scene->solids[at];
    bool finest = level == AP_MESH_LEVELS - 1;
    solid->turn_rad = finest ? 0 : acos(1 - fmin(sagitta_m / round_m, 1));
    solid->longest_m = finest ? 0 : solid->longest_m;
    *radius_m = round_m;
    return at;
}

int ap_build_decal(struct ap_scene_build *build, const char *text) {
    struct ap_scene *s = build->scene;
    struct ap_decal decal = {""};
    snprintf(decal.text, sizeof decal.text, "%s", text);
    for (size_t i = 0; i < s->decal_count; i++)
        if (strcmp(s->decals[i].text, decal.text) == 0)
            return (int)i + 1;
    void *items = s->decals;
    if (!make_room(&items, s->decal_count, &build->decal_room, sizeof decal)) {
        build->out_of_memory = true;
        return 0;
    }
    s->decals = items;
    s->decals[s->decal_count++] = decal;
    return (int)s->decal_count;
}

void ap_color_set(struct ap_part *part, unsigned rgb) {
    for (int i = 0; i < 3; i++)
        part->color_srgb[i] = (double)(rgb >> (16 - 8 * i) & 255) / 255;
}

unsigned ap_color_rgb(const double srgb[3]) {
    unsigned rgb = 0;
    for (int i = 0; i < 3; i++)
        rgb = rgb << 8 | (unsigned)lround(srgb[i] * 255);
    return rgb;
}

static struct ap_part part_at(enum ap_part_kind kind, struct ap_iso place, unsigned rgb) {
    struct ap_part part = {.kind = kind, .carrier_from_part = place, .lit = true, .solid = -1};
    ap_color_set(&part, rgb);
    return part;
}

struct ap_part ap_ball_part(struct ap_iso place, double radius_m, unsigned rgb) {
    struct ap_part part = part_at(AP_PART_BALL, place, rgb);
    part.radius_m = part.radius2_m = radius_m;
    return part;
}

struct ap_part ap_stick_part(struct ap_iso place, double length_m, double radius_m, unsigned rgb) {
    struct ap_part part = part_at(AP_PART_STICK, place, rgb);
    part.radius_m = part.radius2_m = radius_m;
    part.length_m = length_m;
    return part;
}

struct ap_part ap_polygon_part(struct ap_iso place, int sides, double edge_m, unsigned rgb) {
    struct ap_part part = part_at(AP_PART_POLYGON, place, rgb);
    part.sides = sides;
    part.edge_m = edge_m;
    return part;
}

struct ap_part ap_solid_part(struct ap_iso place, int solid, unsigned rgb) {
    struct ap_part part = part_at(AP_PART_SOLID, place, rgb);
    part.solid = solid;
    return part;
}

double ap_part_reach(const struct ap_scene *scene, const struct ap_part *part) {
    double circum = 0, in;
    switch (part->kind) {
    case AP_PART_BALL:
        return part->radius_m;
    case AP_PART_STICK:
        return part->length_m / 2 + fmax(part->radius_m, part->radius2_m);
    case AP_PART_POLYGON:
        ap_regular_polygon(NULL, scene->space, part->sides, part->edge_m, &circum, &in);
        return circum;
    case AP_PART_SOLID:
        break;
    }
    return scene->solids[part->solid].reach_m;
}

struct ap_iso ap_shift(struct ap_space space, double x, double y, double z) {
    return ap_iso_translate(space, (struct ap_vec3){x, y, z});
}

enum ap_status ap_scene_add(struct ap_error *err, struct ap_scene *scene,
                            const struct ap_part *part, size_t count, size_t *first) {
    struct ap_part *grown = realloc(scene->parts, (scene->part_count + count) * sizeof *grown);
    if (!grown)
        return ap_fail(err, AP_ENVIRONMENT, "out of memory for a scene");
    scene->parts = grown;
    *first = scene->part_count;
    for (size_t i = 0; i < count; i++) {
        grown[scene->part_count] = *part;
        grown[scene->part_count++].hidden = true;
    }
    return AP_OK;
}

size_t ap_scene_budget(const struct ap_scene *scene) {
    size_t mib = scene->honeycomb ? 512 : 2048;
    return scene->budget_bytes ? scene->budget_bytes : mib << 20;
}

void ap_scene_destroy(struct ap_scene *scene) {
    if (!scene)
        return;
    for (size_t i = 0; i < scene->solid_count; i++) {
        free(scene->solids[i].positions);
        free(scene->solids[i].normals);
        free(scene->solids[i].indices);
        free(scene->solids[i].seams);
    }
    free(scene->solids);
    free(scene->honeycomb);
    free(scene->parts);
    free(scene->decals);
    free(scene);
}
