#ifndef ANTIPODE_GEOM_POSE_H
#define ANTIPODE_GEOM_POSE_H

#include "src/geom/vec.h"

// A rigid placement in the Euclidean room: position in metres, orientation a unit quaternion. As a
// transform `a_from_b` it takes b's coordinates to a's: p_a = rotate(q, p_b) + p.
struct ap_pose {
    struct ap_vec3 p;
    struct ap_quat q;
};

#define AP_POSE_IDENTITY ((struct ap_pose){{0, 0, 0}, {0, 0, 0, 1}})

// a_from_c = ap_pose_mul(a_from_b, b_from_c). The quaternion is renormalised.
struct ap_pose ap_pose_mul(struct ap_pose a_from_b, struct ap_pose b_from_c);

struct ap_pose ap_pose_inverse(struct ap_pose a_from_b);

struct ap_vec3 ap_pose_apply(struct ap_pose a_from_b, struct ap_vec3 p_b);

// Position linear, orientation slerp the short way; t in [0, 1].
struct ap_pose ap_pose_interpolate(struct ap_pose a, struct ap_pose b, double t);

#endif
