#ifndef ANTIPODE_APP_BENCH_FACETS_H
#define ANTIPODE_APP_BENCH_FACETS_H

#include "src/render/cells.h"
#include "src/render/meshes.h"

// How far off a frame's own triangles are: points all over them, as straight as a device draws them
// in tangent space, against the geodesic planes, tubes and spheres that they stand for, in double
// and in pixels of each eye. Native view. Solids that are made of facets are exact by definition,
// discs have a computed rim.

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
    long points;           // that an eye sees
    uint32_t beyond_bound; // parts for which the frame itself gives the bound up
};

// The frame that the renderer makes of this input, some points of each of its parts: adds to
// *errors. The same points each time.
enum ap_status ap_facets_look(struct ap_error *err, struct ap_facets *facets,
                              const struct ap_frame_input *input, const uint32_t size_px[2],
                              double max_error_px, struct ap_facet_errors *errors);

#endif
