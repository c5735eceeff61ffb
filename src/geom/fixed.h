#ifndef ANTIPODE_GEOM_FIXED_H
#define ANTIPODE_GEOM_FIXED_H

#include <stdint.h>

#include "src/geom/dd.h"

// A number of 256 bits, 216 of them behind the point: between −2^39 and 2^39 in steps of 1e-65. For
// long walks in h3, whose roundings come back e^(distance/rho) times as large (docs/honeycombs.md).
// Two's complement, limb[0] the lowest. Nothing is checked for overflow: the caller keeps to the
// range. Each result is within one step of the exact one, sums are exact.
struct ap_fixed {
    uint64_t limb[4];
};

// A finite double below 2^39; what is smaller than a step is cut off.
struct ap_fixed ap_fixed_of(double a);

// The nearest double and the nearest to the rest.
struct ap_dd ap_fixed_round(struct ap_fixed a);

struct ap_fixed ap_fixed_add(struct ap_fixed a, struct ap_fixed b);
struct ap_fixed ap_fixed_neg(struct ap_fixed a);
struct ap_fixed ap_fixed_sub(struct ap_fixed a, struct ap_fixed b);
struct ap_fixed ap_fixed_mul(struct ap_fixed a, struct ap_fixed b);

// By a whole number, 0 < n < 2^32.
struct ap_fixed ap_fixed_divide(struct ap_fixed a, uint32_t n);

// 1/a and √a, a from 1/1000 to 1000: within 1e-60.
struct ap_fixed ap_fixed_inverse(struct ap_fixed a);
struct ap_fixed ap_fixed_sqrt(struct ap_fixed a);

#endif
