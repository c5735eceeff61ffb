#ifndef ANTIPODE_RENDER_LOGMAP_LOGMAP_FLOAT_H
#define ANTIPODE_RENDER_LOGMAP_LOGMAP_FLOAT_H

#include "src/geom/space.h"

// The float32 twin of shaders/logmap.glsl: the log map of nose space to the Euclidean tangent space
// (Weeks 2021, section 5) as the vertex shader computes it, without any inverse or hyperbolic
// built-in, which no driver gets right (docs/rendering.md). It is here so that it can be measured;
// the reference is ap_log_map.

// 1 + t·(c0 + c1·t + …) for asin(√t)/√t on [0, ½], asinh(√t)/√t on [0, 1], atanh(√t)/√t on
// [0, (3 − 2√2)²]; minimax in the relative error, derived anew by tests/render/fit_logmap.c.
enum { AP_LOGMAP_TERMS = 7, AP_LOGMAP_LOG_TERMS = 3 };
extern const float ap_logmap_asin[AP_LOGMAP_TERMS];
extern const float ap_logmap_asinh[AP_LOGMAP_TERMS];
extern const float ap_logmap_atanh[AP_LOGMAP_LOG_TERMS];

// p: (x, y, z, w)/rho; q: the tangent point over rho. kappa as in ap_space; image 1 in s3 only.
// Measured error over |q| against the double reference: at most 4e-7 (tests/render/test_logmap.c),
// in h3 for distances up to 80 rho.
void ap_logmap_float(int kappa, int image, const float p[4], float q[3]);

#endif
