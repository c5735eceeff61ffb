#ifndef ANTIPODE_GEOM_MAP_H
#define ANTIPODE_GEOM_MAP_H

#include "src/base/status.h"
#include "src/geom/space.h"
#include "src/geom/vec.h"

// exp and log at the base point, and distance. Points and tangent vectors in metres. Pure, any
// thread. "Error" is the largest |answer − exact| over the largest exact component, measured
// against 640 bits on a million random inputs at radii from 1e-140 to 1e140 (docs/accuracy.md).

// translate(v)·(0, 0, 0, rho). Domain |v|/rho up to 700 in h3 (then cosh overflows), any finite v
// in s3 and e3. Error 4.9e-16 to 38 rho in h3, 4.1e-16 to 40 rho in s3, none in e3.
struct ap_vec4 ap_exp(struct ap_space space, struct ap_vec3 v_m);

// The tangent vector at the base point whose exp is p. image 0: the short way (the only one outside
// s3); image 1: the long way round, direction reversed, length 2·pi·rho − d. AP_INPUT: p off the
// space (by the tolerances of the conventions), a direction that is undefined ((x,y,z) = 0 exactly:
// s3's antipode; image 1 of the base point), image 1 outside s3, another image, non-finite input.
// Error 4.4e-16 to 300 rho in h3, 4.0e-16 in s3 (image 1: 5.0e-16) from next to the base point to
// next to the antipode, 2.2e-16 in e3.
enum ap_status ap_log_map(struct ap_error *err, struct ap_space space, struct ap_vec4 p, int image,
                          struct ap_vec3 *v_m);

// Distance in metres, symmetric to the last bit. AP_INPUT: a point off the space or not finite. h3
// takes w from (x,y,z), s3 is the angle between the 4-vectors, e3 compares (x,y,z)/w. |answer −
// exact| at most 4.5e-16·rho·(w_p·w_q/rho²) in h3, 5.7e-16·rho in s3, 4.8e-16·max(d, rho) in e3.
enum ap_status ap_distance(struct ap_error *err, struct ap_space space, struct ap_vec4 p,
                           struct ap_vec4 q, double *d_m);

// The unchecked twin of ap_log_map for points that come from exp and isometries (inner loops): a
// point slightly off the space is taken by (x,y,z) and w as it is; (x,y,z) = 0 gives zero.
struct ap_vec3 ap_log_unchecked(struct ap_space space, struct ap_vec4 p, int image);

// The length of image 0's log by plain square root, asinh and atan2, for what is bounded and not
// drawn: within 1e-15 of itself for |(x,y,z)| of 1e-150 to 1e150 m; smaller is 0, larger infinite.
double ap_base_distance(struct ap_space space, struct ap_vec4 p);

// AP_INPUT where p is not a point of the space; the sentence says by how much.
enum ap_status ap_point_check(struct ap_error *err, struct ap_space space, struct ap_vec4 p);

#endif
