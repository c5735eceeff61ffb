#ifndef ANTIPODE_VIEW_EXACT_H
#define ANTIPODE_VIEW_EXACT_H

#include <stdint.h>

#include "src/view/view.h"

// Where points are seen, in pixels, and where lines of sight meet a plane, in double: what drawn
// triangles are held against. Native view. Pure; any thread.

// Pixels of an eye's picture of size_px (from its left and top edges). False where it does not show
// there: behind the eye, within AP_NEAR_M of it, beside the picture (*px is set all the same).
bool ap_exact_pixel(const struct ap_viewer *viewer, const uint32_t size_px[2], int eye,
                    struct ap_vec3 tangent_m, double px[2]);

// The same of a place in that eye's axes, as far as the picture goes along a line through the eye.
bool ap_exact_pixel_at(const struct ap_view_eye *eye, const uint32_t size_px[2], struct ap_vec3 at,
                       double px[2]);

// The point of the part's plane y = 0 in the direction u (unit) from the nose, in s3 the one whose
// distance is next to d_flat_m. False: there is none. Closed form: along a geodesic y goes as
// C·n.y + S·u.y of its place and direction.
bool ap_exact_on_plane(struct ap_space space, const struct ap_iso *part_from_nose, struct ap_vec3 u,
                       double d_flat_m, struct ap_vec3 *tangent_m);

// How many pixels q lies outside a triangle of the picture, 0 in it; INFINITY where the triangle is
// seen from its back (corners are counterclockwise on its front, to whom y goes upward).
double ap_exact_outside(const double q[2], const double a[2], const double b[2], const double c[2]);

#endif
