#ifndef ANTIPODE_DEVICE_WALK_PATH_H
#define ANTIPODE_DEVICE_WALK_PATH_H

// Closed curves round a square table, for the scripted walk: the square widened by an offset, its
// corners round, smoothed as a cubic B-spline (twice continuously differentiable). Floor
// coordinates x and z, the table's centre at the origin.

// u counts edges as the trackers' perimeter coordinate does: counterclockwise from above, the
// middle of edge 0 (u = 0.5) toward −z, corners at whole numbers.
struct ap_walk_point {
    double x, z;   // metres
    double dx, dz; // per unit of u
};

// offset_m outside the table's edge; negative: above the table. |offset_m| < edge_m / 2 inside.
struct ap_walk_point ap_walk_path(double edge_m, double offset_m, double u);

// How far a person walks from one edge to the next, about.
double ap_walk_path_edge_length_m(double edge_m);

// Heading of a person who walks along the curve and is at its point of u, radians about +y,
// unwrapped: it grows by pi/2 per edge.
double ap_walk_path_heading(const struct ap_walk_point *at, double u);

// The same turn between −pi and pi: remainder(angle_rad, 2 pi), which most turns are already.
double ap_walk_turn_rad(double angle_rad);

// The distance from the table at which a person walks.
extern const double ap_walk_offset_m;

#endif
