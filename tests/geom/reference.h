#ifndef ANTIPODE_TESTS_GEOM_REFERENCE_H
#define ANTIPODE_TESTS_GEOM_REFERENCE_H

#include <stddef.h>
#include <stdint.h>

#include "src/geom/isometry.h"
#include "src/geom/map.h"

// The textbook formulas in 640 bits (MPFR), to measure the library against. Slow; one thread. Each
// function takes the library's answer and returns how far it is from the exact one.

// Largest |answer − exact| over the largest |exact| of the components.
double ref_exp_error(struct ap_space space, struct ap_vec3 v, struct ap_vec4 answer);
double ref_log_error(struct ap_space space, struct ap_vec4 p, int image, struct ap_vec3 answer);
double ref_walk_error(struct ap_space space, const struct ap_vec3 *steps, size_t count,
                      const struct ap_iso *answer);

// |answer − exact| in units of the contract's scale: rho·(w_p·w_q/rho²), max(d, rho), rho.
double ref_dist_error(struct ap_space space, struct ap_vec4 p, struct ap_vec4 q, double answer);

// |answer − exact|, radians.
double ref_vergence_error(struct ap_space space, int tourist, double ipd, double d, double answer);

void ref_finish(void);

// Random numbers for the tests: splitmix64, the same everywhere.
struct ref_random {
    uint64_t state;
};

double ref_uniform(struct ref_random *r, double low, double high);
struct ap_vec3 ref_direction(struct ref_random *r);

#endif
