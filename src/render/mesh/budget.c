#include "src/render/mesh/budget.h"

#include <math.h>

#include "src/render/mesh/mesh.h"

// The triangles of a frame's own, however large the budget.
enum { REFINED_MAX = 1000000, REFINED_MOST = 8000000 };

size_t ap_grown(size_t needed) {
    return needed + needed / 2;
}

static size_t part_bytes(void) {
    return ap_grown(AP_PART_BYTES);
}

// Of a triangle made for a frame, likewise: it has half a vertex of its own.
static size_t triangle_bytes(void) {
    size_t bytes = sizeof(struct ap_vertex) / 2 + 3 * sizeof(uint32_t);
    return ap_grown((1 + AP_FRAMES_AHEAD) * bytes);
}

static bool is_finite(const struct ap_scene *scene) {
    return scene->honeycomb && scene->honeycomb->tiling.cell_count > 0;
}

size_t ap_budget_meshes(const struct ap_scene *scene) {
    size_t budget = ap_scene_budget(scene);
    return scene->honeycomb ? budget / 8 : budget / 4 * 3;
}

size_t ap_budget_known_cells(const struct ap_scene *scene) {
    return ap_scene_budget(scene) / 4;
}

size_t ap_budget_mesh_bytes(size_t vertices, size_t indices) {
    enum { COPIES = 3 };
    return COPIES * (vertices * sizeof(struct ap_vertex) + indices * sizeof(uint32_t));
}

size_t ap_budget_triangles_cap(const struct ap_scene *scene) {
    return scene->honeycomb ? REFINED_MOST : REFINED_MAX;
}

static size_t least_cells(const struct ap_scene *scene) {
    return (size_t)scene->honeycomb->tiling.face_count + 1;
}

size_t ap_budget_cells(const struct ap_scene *scene, size_t part_count) {
    size_t most = ap_scene_budget(scene) / 8 * 3 / (part_bytes() * (part_count + 1)),
           least = least_cells(scene);
    return most > least ? most : least;
}

size_t ap_budget_triangles(const struct ap_scene *scene, size_t ahead_bytes) {
    size_t budget = ap_scene_budget(scene), room = budget / 4, cap = ap_budget_triangles_cap(scene);
    if (is_finite(scene)) {
        // Cells that there are few of leave room, each seen both ways round.
        size_t all = 2 * (size_t)scene->honeycomb->tiling.cell_count,
               most = ap_budget_cells(scene, scene->part_count), cells = all < most ? all : most,
               taken = ahead_bytes + cells * (scene->part_count * part_bytes());
        room = taken < budget ? budget - taken : 0;
        room = room < budget / 4 * 3 ? room : budget / 4 * 3;
    }
    size_t most = room / triangle_bytes();
    return most < cap ? most : cap;
}

enum ap_status ap_budget_check(struct ap_error *err, const struct ap_scene *scene, size_t bytes,
                               size_t cell_parts) {
    size_t parts = 2 * scene->part_count;
    if (scene->honeycomb)
        parts += least_cells(scene) * cell_parts;
    size_t need = bytes + parts * part_bytes(), budget = ap_scene_budget(scene);
    const double mib = 1048576;
    if (need <= budget)
        return AP_OK;
    return ap_fail(err, AP_USAGE,
                   "the budget of %.3g MiB is too small: the coarsest meshes of this scene and a "
                   "list of its parts take %.3g MiB (give a --budget of %.2g or more)",
                   (double)budget / mib, (double)need / mib, ceil((double)need / mib * 10) / 10);
}
