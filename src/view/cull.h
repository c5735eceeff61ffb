#ifndef ANTIPODE_VIEW_CULL_H
#define ANTIPODE_VIEW_CULL_H

#include "src/view/view.h"

// Whether any eye can see any of an object: conservative (never hides what is visible), exact
// enough that an object none of whose triangles can be seen is not drawn.

struct ap_bounds {
    // The object lies in the geodesic convex hull of these points (nose space), thickened by
    // radius_m. One point: a ball. Two: a stick. More: a polygon.
    const struct ap_vec4 *nose_points;
    int count;
    double radius_m;
};

// Bit e set: eye e may see it in this image (0; 1 in s3).
unsigned ap_visible_eyes(const struct ap_viewer *viewer, const struct ap_bounds *bounds, int image);

// Whether both eyes see nothing but the back of a surface. Its outward normals, where they meet the
// part's place (or its axis), are unit vectors in the convex hull of `out` (part's axes); nose: in
// the part's coordinates, metres. Points of it lie near_m…far_m from the nose, and at most bulge_m
// outside the planes through the part's place. Conservative: the planes that touch the surface's
// image in tangent space pass the nose at twice the eyes' distance, which leaves facets room to be
// tilted. False in native-of view, and near s3's antipode.
struct ap_facing {
    struct ap_vec4 nose;
    const struct ap_vec3 *out;
    int count; // 0: nothing is known
    double near_m, far_m, bulge_m;
};
bool ap_turned_away(const struct ap_viewer *viewer, double eye_m, const struct ap_facing *facing,
                    int image);

#endif
