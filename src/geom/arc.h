#ifndef ANTIPODE_GEOM_ARC_H
#define ANTIPODE_GEOM_ARC_H

#include "src/geom/dd.h"
#include "src/geom/space.h"
#include "src/geom/vec.h"

// A tangent vector as a direction and an arc length that carries its rounding error: the error of a
// turn is that of t times t, so with plain doubles forty radians in s3, or cosh far away in h3,
// would lose two digits.
struct ap_arc {
    struct ap_vec3 unit; // zero where v is; each component within 1.5 ulp
    struct ap_dd t;      // |v|/rho
};

struct ap_arc ap_arc_of(struct ap_space space, struct ap_vec3 v_m);

// The length of (x, y, z) without overflow or underflow on the way, within 2^-100.
struct ap_dd ap_length_dd(struct ap_vec3 v);

// Its double, and the unit vector along v (each component within 1.5 ulp); zero where v is.
double ap_polar(struct ap_vec3 v, struct ap_vec3 *unit);

// The unit vector along v != 0.
void ap_unit_dd(struct ap_vec3 v, struct ap_dd unit[3]);

// a/b within 2^-100, for any finite a.hi >= 0, b > 0 whose quotient is normal.
struct ap_dd ap_quotient_dd(struct ap_dd a, double b);

// (C, S, C − 1) of an arc, rounded to double: the arc's own error is not amplified, what is left is
// libm's. C − 1 is as exact relative to itself.
struct ap_turn {
    double c, s, c_minus_1;
};

struct ap_turn ap_turn_of(struct ap_space space, struct ap_dd t);

// The same in double-double: (S, C − 1). Error below 2^-94 of each for t <= 700 in h3, below 2^-102
// of 1 for t <= 2^40 in s3 (beyond that as ap_turn_of).
void ap_turn_dd(struct ap_space space, struct ap_dd t, struct ap_dd *s, struct ap_dd *c_minus_1);

#endif
