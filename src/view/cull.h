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

#endif
