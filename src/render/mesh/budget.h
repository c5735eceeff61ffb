#ifndef ANTIPODE_RENDER_MESH_BUDGET_H
#define ANTIPODE_RENDER_MESH_BUDGET_H

#include "src/scene/scene.h"

// What a scene's budget (ap_scene_budget) is spent on, and what each thing takes of it: the only
// place that knows how many copies of what there are and how far buffers grow ahead of need.

// Frames that the CPU may be ahead of the GPU; each has its own copy of what changes with a frame.
enum { AP_FRAMES_AHEAD = 2 };

// What a part takes in the list of what is drawn, which the process holds, and in the buffers of
// these frames (src/render/list.c knows that it is no more).
enum { AP_PART_BYTES = 712 };

// The room to make for so much, that it need not be made again soon.
size_t ap_grown(size_t needed);

// Bytes at the most: levels of detail that are made ahead, in the process, on their way and on the
// GPU; cells that are known.
size_t ap_budget_meshes(const struct ap_scene *scene);
size_t ap_budget_known_cells(const struct ap_scene *scene);
// What so many vertices and indices of levels made ahead take of it.
size_t ap_budget_mesh_bytes(size_t vertices, size_t indices);

// Triangles that are made for a frame: how many there is room for, and how many there may be
// however much room. ahead_bytes: what the meshes made ahead take.
size_t ap_budget_triangles(const struct ap_scene *scene, size_t ahead_bytes);
size_t ap_budget_triangles_cap(const struct ap_scene *scene);

// Cells that are drawn in a frame, of part_count parts each: never fewer than the one she is in and
// those around it.
size_t ap_budget_cells(const struct ap_scene *scene, size_t part_count);

// AP_USAGE, with one line, where not even what a scene cannot do without fits: bytes of the
// coarsest meshes and of cells that are known from the start, and a list of its parts, of which
// cell_parts are each cell's.
enum ap_status ap_budget_check(struct ap_error *err, const struct ap_scene *scene, size_t bytes,
                               size_t cell_parts);

#endif
