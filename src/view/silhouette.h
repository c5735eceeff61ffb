#ifndef ANTIPODE_VIEW_SILHOUETTE_H
#define ANTIPODE_VIEW_SILHOUETTE_H

#include "src/view/view.h"

// The exact outline of a ball as an eye sees it, in double: the reference that pictures and
// vergence measurements are held against. In native view an eye's line of sight is straight in
// tangent space, and a point of it belongs to the ball where its exp is within radius_m of the
// centre; the outline is found by bracketing along rays. In tourist view it is a cone. In native-of
// view lines of sight are curved in tangent space, and the outline is where the picture of the
// surface folds over.
struct ap_silhouette {
    double centre_a, centre_b;     // tangents of the direction to the ball's centre
    double centroid_a, centroid_b; // area centroid of the outline in the image plane (tangents)
    double area;                   // in the image plane, tangents squared
    double min_a, max_a, min_b, max_b;
};

// image 0 or 1 (s3). False where the outline is not wholly in front of the eye (within 80° of its
// axis) or the eye is inside the ball. centroid within 1e-6 of the outline's size.
bool ap_ball_silhouette(const struct ap_viewer *viewer, int eye, struct ap_vec4 world_centre,
                        double radius_m, int image, struct ap_silhouette *out);

// A point of the outline: its line of sight, unit, in the eye's axes; of the surface there, the
// tangent point (not in tourist view, where the distance along the line says it).
struct ap_outline_point {
    struct ap_vec3 line;
    struct ap_vec3 tangent_m;
};

// count points of the same outline, in order around it, evenly in an angle about its middle: a
// smooth closed curve. *nearest: of the surface, what faces the eye; its line is meaningless in
// tourist view. False as ap_ball_silhouette.
bool ap_ball_outline(const struct ap_viewer *viewer, int eye, struct ap_vec4 world_centre,
                     double radius_m, int image, int count, struct ap_outline_point *points,
                     struct ap_outline_point *nearest);

// Vergence of a direction pair in VIEW axes: atan2(x_L, −z_L) − atan2(x_R, −z_R), radians.
double ap_vergence_of(struct ap_vec3 dir_left, struct ap_vec3 dir_right);

// Distance from the nose to the midpoint of the shortest segment between the two sight lines;
// INFINITY where vergence ≤ 0. Directions in VIEW axes, eye positions in metres.
double ap_vergence_distance(struct ap_vec3 eye_left, struct ap_vec3 dir_left,
                            struct ap_vec3 eye_right, struct ap_vec3 dir_right);

#endif
