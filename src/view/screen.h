#ifndef ANTIPODE_VIEW_SCREEN_H
#define ANTIPODE_VIEW_SCREEN_H

#include "src/view/view.h"

// What hides s3's back hemisphere: an opaque convex polygon in image 0 stands before everything
// that is seen the long way round. Native view. From the nose a polygon is a convex cone of
// directions; an eye e beside it sees each point at the distance d within asin(e/d) of that. While
// the eye goes there from the nose, the polygon's rim never crosses the direction of what lies
// inside the cone by more than both angles, so the polygon stays before it.

enum { AP_SCREEN_SIDES = 8 };

struct ap_screen {
    struct ap_vec3 inward[AP_SCREEN_SIDES]; // unit normals of the cone's sides
    int sides;
    double lean_rad; // of its rim, and of what is behind
};

// The polygon with these corners (nose space; in order, of a geodesic plane), whose points lie
// near_m…far_m from the nose; its edges are drawn within slack_rad. False: it hides nothing for
// sure, since it is close to an eye, reaches towards the antipode or is seen from its edge.
bool ap_screen_of(const struct ap_viewer *viewer, const struct ap_vec4 *corners, int count,
                  double near_m, double far_m, double slack_rad, struct ap_screen *screen);

// Whether all that lies within radius_m of the convex hull of points (nose space) and near_m…far_m
// from the nose is behind it when it is seen the long way round.
bool ap_screen_hides_back(const struct ap_viewer *viewer, const struct ap_screen *screen,
                          const struct ap_vec4 *points, int count, double radius_m, double near_m,
                          double far_m);

#endif
