#ifndef ANTIPODE_GEOM_ISOMETRY_H
#define ANTIPODE_GEOM_ISOMETRY_H

#include <stddef.h>

#include "src/geom/pose.h"
#include "src/geom/space.h"
#include "src/geom/vec.h"

// An isometry of the space: a dimensionless 4×4 matrix that acts on columns, m[row][column]. The
// upper left block turns, the last column is where the base point goes (over rho). In e3 the last
// column of a translation by v is v/rho ("Euclidean radians"), so one code path serves the three
// spaces. Names: world_from_nose takes nose coordinates to world coordinates.
// All functions are pure, and safe where an output is also an input.
struct ap_iso {
    double m[4][4];
};

extern const struct ap_iso AP_ISO_IDENTITY;

// The transvection along v, a tangent vector at the base point, metres. Domain as for ap_exp. Error
// (largest |answer − exact| over the largest exact entry): 8.9e-16 to 38 rho in h3, 8.3e-16 to 40
// rho in s3, 1.1e-16 in e3.
struct ap_iso ap_iso_translate(struct ap_space space, struct ap_vec3 v_m);

// Rotation about the base point; q unit.
struct ap_iso ap_iso_rotate(struct ap_quat q);

// About +y by angle_rad, counterclockwise from above.
struct ap_iso ap_iso_rotate_y(double angle_rad);

// translate(p)·rotate(q): a physical pose re-read as a rigid motion of the curved space.
struct ap_iso ap_iso_from_pose(struct ap_space space, struct ap_pose pose);

// a_from_c = mul(a_from_b, b_from_c). The same in every space. Each entry within 4 roundings of the
// sum of its products' sizes; over many steps see docs/accuracy.md.
struct ap_iso ap_iso_mul(struct ap_iso a_from_b, struct ap_iso b_from_c);

// G·Mᵀ·G in s3 and h3, rigid in e3; never a general inverse. As exact as M is.
struct ap_iso ap_iso_inverse(struct ap_space space, struct ap_iso m);

// p_a in metres from p_b in metres.
struct ap_vec4 ap_iso_apply(const struct ap_iso *a_from_b, struct ap_vec4 p_b);

// The product of the translations of a walk, left to right, each step a tangent vector in metres in
// the walker's own frame; no steps: the identity. Carried in double-double and rounded once:
// error 1.2e-16, also where a walk of h3 comes home and what was large cancels. Some µs a step.
struct ap_iso ap_iso_walk(struct ap_space space, const struct ap_vec3 *steps_m, size_t count);

// How far M is from the group: the largest entry of |Mᵀ·G·M − G| (e3: of the rotation block's
// |RᵀR − I| and the last row's difference from (0, 0, 0, 1)).
double ap_iso_defect(struct ap_space space, const struct ap_iso *m);

// Gram-Schmidt back onto the group: in h3 the timelike column first, in s3 the position column.
// For increments and cell-relative poses only: domain m33 < 10 in h3. Far from the base point it
// destroys a correct matrix, by up to 7e-16·m33² of its largest entry (docs/accuracy.md).
struct ap_iso ap_iso_orthonormalize(struct ap_space space, struct ap_iso m);

#endif
