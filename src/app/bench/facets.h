#ifndef ANTIPODE_APP_BENCH_FACETS_H
#define ANTIPODE_APP_BENCH_FACETS_H

#include "src/render/cells.h"
#include "src/render/mesh/meshes.h"

// How far off a frame's own triangles are: points all over them, as straight as a device draws them
// (native: in tangent space; tourist: in the eye's own), against the geodesic planes, tubes and
// spheres that they stand for, in double and in pixels of each eye. Solids that are made of facets
// are exact by definition, discs have a computed rim; not for native-of views. One thread each.

struct ap_facets {
    const struct ap_scene *scene; // borrowed
    struct ap_meshes meshes;
    struct ap_mesh_data ahead;
    struct ap_cell_view cells;
    struct ap_draw_list list;
    // Of the item at hand: where its corners are seen by each eye.
    struct ap_facet_corner *corner[2];
    size_t corner_room;
};
enum ap_status ap_facets_open(struct ap_error *err, const struct ap_scene *scene,
                              struct ap_facets *facets);
void ap_facets_close(struct ap_facets *facets);

struct ap_facet_errors {
    double worst_px;
    double at_m;           // how far from the nose the worst is,
    uint32_t part;         // of which part of the scene,
    bool refined;          // and whether its triangles were made for that frame
    long points;           // that an eye sees
    uint32_t beyond_bound; // parts for which the frame itself gives the bound up
    uint32_t refined_parts;
    double triangles; // of both eyes
};

struct ap_facets_params {
    const struct ap_frame_input *input;
    uint32_t size_px[2];
    double max_error_px;
    uint32_t points; // of a frame, about, shared out among its parts, 200 each at most
    uint64_t seed;   // of where
};

// The frame that the renderer makes of this input, some points of each of its parts: adds to
// *errors. How far off a point is: on a plane, where its facet shows it from where it is; on a tube
// or a sphere, how far beside what is drawn of it, and a drawn point, how far beside the surface's
// outline (or less than 0.4 of max_error_px from the surface's nearest point). AP_ENVIRONMENT: no
// memory.
enum ap_status ap_facets_look(struct ap_error *err, struct ap_facets *facets,
                              const struct ap_facets_params *params,
                              struct ap_facet_errors *errors);

#endif
