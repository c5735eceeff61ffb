#ifndef ANTIPODE_GEOM_VEC_H
#define ANTIPODE_GEOM_VEC_H

#include <math.h>

// Plain 3- and 4-vectors in double, and unit quaternions; pure functions, any thread. What space
// and unit a vector is in stands in the name of the variable or of the wrapping type.

struct ap_vec3 {
    double x, y, z;
};

struct ap_vec4 {
    double x, y, z, w;
};

// Hamilton, (x, y, z, w), unit; as in OpenXR.
struct ap_quat {
    double x, y, z, w;
};

static inline struct ap_vec3 ap_vec3_add(struct ap_vec3 a, struct ap_vec3 b) {
    return (struct ap_vec3){a.x + b.x, a.y + b.y, a.z + b.z};
}

static inline struct ap_vec3 ap_vec3_sub(struct ap_vec3 a, struct ap_vec3 b) {
    return (struct ap_vec3){a.x - b.x, a.y - b.y, a.z - b.z};
}

static inline struct ap_vec3 ap_vec3_scale(double s, struct ap_vec3 v) {
    return (struct ap_vec3){s * v.x, s * v.y, s * v.z};
}

static inline double ap_vec3_dot(struct ap_vec3 a, struct ap_vec3 b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static inline struct ap_vec3 ap_vec3_cross(struct ap_vec3 a, struct ap_vec3 b) {
    return (struct ap_vec3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

// Euclidean length without overflow or underflow on the way (within 1 ulp of hypot of hypot).
static inline double ap_vec3_length(struct ap_vec3 v) {
    return hypot(hypot(v.x, v.y), v.z);
}

// The unit vector along v; v itself where it is zero.
static inline struct ap_vec3 ap_vec3_normalize(struct ap_vec3 v) {
    double n = ap_vec3_length(v);
    return n > 0 ? (struct ap_vec3){v.x / n, v.y / n, v.z / n} : v;
}

#define AP_QUAT_IDENTITY ((struct ap_quat){0, 0, 0, 1})

// a∘b: first b, then a. Error 2.2e-16 for unit quaternions.
struct ap_quat ap_quat_mul(struct ap_quat a, struct ap_quat b);

static inline struct ap_quat ap_quat_conj(struct ap_quat q) {
    return (struct ap_quat){-q.x, -q.y, -q.z, q.w};
}

// Domain |q| > 0. Error 2.4e-16.
struct ap_quat ap_quat_normalize(struct ap_quat q);

// Rotates v by the unit quaternion q. Error 1.2e-15·|v|, of which most is that a rounded q is unit
// only to a rounding.
struct ap_vec3 ap_quat_rotate(struct ap_quat q, struct ap_vec3 v);

// Rotation by angle_rad about the unit vector axis, counterclockwise seen from its tip.
struct ap_quat ap_quat_from_axis_angle(struct ap_vec3 axis, double angle_rad);

// Slerp the short way, t in [0, 1]; a and b unit. Equal inputs give exactly that input.
// Error 2.6e-16.
struct ap_quat ap_quat_slerp(struct ap_quat a, struct ap_quat b, double t);

#endif
