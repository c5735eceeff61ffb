#ifndef ANTIPODE_GEOM_MAP_H
#define ANTIPODE_GEOM_MAP_H

#include "src/base/status.h"
#include "src/geom/space.h"
#include "src/geom/vec.h"

// exp and log at the base point, and distance. Points and tangent vectors in metres.

// translate(v)·(0, 0, 0, rho).
struct ap_vec4 ap_exp(struct ap_space space, struct ap_vec3 v_m);

// The tangent vector at the base point whose exp is p. image 0: the short way (the only one outside
// s3); image 1: the long way round, direction reversed, length 2·pi·rho − d. AP_INPUT: p off the
// space (by the tolerances of the conventions), a direction that is undefined ((x,y,z) = 0 exactly:
// s3's antipode; image 1 of the base point), image 1 outside s3, another image, non-finite input.
enum ap_status ap_log_map(struct ap_error *err, struct ap_space space, struct ap_vec4 p, int image,
                          struct ap_vec3 *v_m);

// Distance in metres, symmetric. AP_INPUT: a point off the space or not finite.
enum ap_status ap_distance(struct ap_error *err, struct ap_space space, struct ap_vec4 p,
                           struct ap_vec4 q, double *d_m);

// The unchecked twin of ap_log_map for points that come from exp and isometries (inner loops): a
// point slightly off the space is taken by (x,y,z) and w as it is; (x,y,z) = 0 gives zero.
struct ap_vec3 ap_log_unchecked(struct ap_space space, struct ap_vec4 p, int image);

// AP_INPUT where p is not a point of the space; the sentence says by how much.
enum ap_status ap_point_check(struct ap_error *err, struct ap_space space, struct ap_vec4 p);

#endif
