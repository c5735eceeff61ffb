#ifndef ANTIPODE_GAME_PLANE_H
#define ANTIPODE_GAME_PLANE_H

#include <math.h>

#include "src/geom/isometry.h"
#include "src/geom/space.h"

// The plane of the table: the points (x, z, w) of the space with y = 0, a sphere, a plane or a
// hyperbolic plane of the space's radius. Everything about a ball's foot happens here. Pure, any
// thread, metres.

// A point of the plane, or a tangent vector at one: x, z, w in metres.
struct ap_plane3 {
    double x, z, w;
};

// An isometry of the plane, world_from_foot: the columns are the unit vectors along the foot's x
// and z and its point over rho. m[row][column], rows and columns in the order x, z, w.
struct ap_plane_frame {
    double m[3][3];
};

#define AP_PLANE_FRAME_IDENTITY ((struct ap_plane_frame){{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}})

// Two components in the frame of a foot, x and z, seen from above with y up.
struct ap_plane2 {
    double x, z;
};

static inline double ap_plane2_dot(struct ap_plane2 a, struct ap_plane2 b) {
    return a.x * b.x + a.z * b.z;
}

static inline double ap_plane2_length(struct ap_plane2 a) {
    return sqrt(a.x * a.x + a.z * a.z);
}

static inline struct ap_plane2 ap_plane2_add(struct ap_plane2 a, double s, struct ap_plane2 b) {
    return (struct ap_plane2){a.x + s * b.x, a.z + s * b.z};
}

// n × up: a quarter turn clockwise seen from above.
static inline struct ap_plane2 ap_plane2_side(struct ap_plane2 n) {
    return (struct ap_plane2){-n.z, n.x};
}

static inline struct ap_plane3 ap_plane_apply(const struct ap_plane_frame *f, struct ap_plane3 v) {
    return (struct ap_plane3){f->m[0][0] * v.x + f->m[0][1] * v.z + f->m[0][2] * v.w,
                              f->m[1][0] * v.x + f->m[1][1] * v.z + f->m[1][2] * v.w,
                              f->m[2][0] * v.x + f->m[2][1] * v.z + f->m[2][2] * v.w};
}

static inline struct ap_plane3 ap_plane_foot(const struct ap_plane_frame *f, double rho_m) {
    return (struct ap_plane3){rho_m * f->m[0][2], rho_m * f->m[1][2], rho_m * f->m[2][2]};
}

// The plane's own inner product, of signature (+, +, kappa).
static inline double ap_plane_dot(int kappa, struct ap_plane3 a, struct ap_plane3 b) {
    return a.x * b.x + a.z * b.z + kappa * a.w * b.w;
}

// The square of 2·rho·sin(d/(2·rho)), d², (2·rho·sinh(d/(2·rho)))²: without the cancellation that
// the angle's cosine has at small distances.
static inline double ap_plane_chord2(int kappa, struct ap_plane3 a, struct ap_plane3 b) {
    struct ap_plane3 d = {a.x - b.x, a.z - b.z, a.w - b.w};
    return ap_plane_dot(kappa, d, d);
}

// The first two components of foot_from_world·v: v's part along the foot's x and z.
static inline struct ap_plane2 ap_plane_local(int kappa, const struct ap_plane_frame *f,
                                              struct ap_plane3 v) {
    return (struct ap_plane2){f->m[0][0] * v.x + f->m[1][0] * v.z + kappa * f->m[2][0] * v.w,
                              f->m[0][1] * v.x + f->m[1][1] * v.z + kappa * f->m[2][1] * v.w};
}

// a·b.
struct ap_plane_frame ap_plane_mul(const struct ap_plane_frame *a, const struct ap_plane_frame *b);

// The transvection along v, a tangent vector at the base point in metres.
struct ap_plane_frame ap_plane_translate(struct ap_space space, struct ap_plane2 v_m);

// Gram-Schmidt back onto the group, the point first. Domain: within a few rho of the base point (a
// table is).
void ap_plane_orthonormalize(int kappa, struct ap_plane_frame *f);

// world_from_foot as an isometry of the space, up stays up.
struct ap_iso ap_plane_lift(const struct ap_plane_frame *f);

// The part of an isometry of the space that keeps the plane (a turn about y and a motion within).
struct ap_plane_frame ap_plane_of(const struct ap_iso *m);

// The distance whose chord² is given, and back. Chords beyond s3's diameter count as pi·rho.
double ap_plane_distance(struct ap_space space, double chord2_m2);
double ap_plane_chord2_of(struct ap_space space, double distance_m);

// rho·tan(s/rho), s, rho·tanh(s/rho): what takes the place of a ball's radius (shared by rolling,
// contact and english; docs/physics.md).
double ap_plane_rolling_radius(struct ap_space space, double s_m);

#endif
