#ifndef ANTIPODE_RENDER_REFINE_DISC_H
#define ANTIPODE_RENDER_REFINE_DISC_H

#include "src/render/mesh/mesh.h"
#include "src/view/view.h"

// Unlit balls as discs with an exact rim: what pictures are measured by. Each eye's outline is
// found in double (src/view/silhouette.h), and the share of each pixel that it covers is computed,
// not sampled: a centroid is then within a few thousandths of a pixel where four samples leave a
// tenth.

struct ap_disc_params {
    const struct ap_viewer *viewer;
    uint32_t width_px, height_px; // of the picture that is drawn
    struct ap_vec4 world_centre;
    double radius_m;
    int image;
    double max_error_px; // of the facets that bear its depth, should something cut through it
    size_t triangles_max; // more: AP_DISC_NO_ROOM
};

enum ap_disc_made { AP_DISC_UNFIT, AP_DISC_MADE, AP_DISC_NO_ROOM };

// Appends the disc that one eye sees, for shaders/disc.glsl: position = (a, b, how far ahead, w), a
// and b the tangents of the direction, w that of tourist depth; normal = (pixels inside the rim,
// the rim's normal in pixels, eye). Else nothing is appended, draw a mesh: *made AP_DISC_UNFIT, the
// eye is too near or what it sees is less than three pixels across. AP_ENVIRONMENT: no memory.
enum ap_status ap_disc_append(struct ap_error *err, const struct ap_disc_params *params, int eye,
                              struct ap_mesh_data *data, uint32_t first_vertex,
                              enum ap_disc_made *made);

#endif
