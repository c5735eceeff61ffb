#ifndef ANTIPODE_GEOM_SPACE_H
#define ANTIPODE_GEOM_SPACE_H

#include <stdbool.h>

#include "src/base/status.h"

// One of the three isotropic spaces with its radius. A point is a column (x, y, z, w) in metres
// with x²+y²+z² + kappa·w² = kappa·rho² (e3: w = rho); the base point is (0, 0, 0, rho).
// Weeks 2021, sections 1.2 and 4.1 ("Euclidean radians": e3 has a radius too, so that one code path
// serves all three).
struct ap_space {
    int kappa;    // sign of the curvature: +1 s3, 0 e3, −1 h3
    double rho_m; // > 0
};

// "s3", "e3", "h3"; AP_USAGE for another name, and for a radius that is not finite and > 0.
enum ap_status ap_space_from_name(struct ap_error *err, const char *name, double rho_m,
                                  struct ap_space *space);

const char *ap_space_name(struct ap_space space);

// (cos t, sin t), (1, t), (cosh t, sinh t). Error: that of libm (glibc 2.36: 0.52
// ulp in s3; cosh 1.0, sinh 1.8 ulp in h3).
double ap_space_cos(struct ap_space space, double t);
double ap_space_sin(struct ap_space space, double t);

#endif
