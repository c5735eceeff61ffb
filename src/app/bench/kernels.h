#ifndef ANTIPODE_APP_BENCH_KERNELS_H
#define ANTIPODE_APP_BENCH_KERNELS_H

#include <stddef.h>

// Log-map formulas over arrays, for `antipode bench` to time. A file of their own, for it is built
// with -O3 -fno-math-errno -fno-trapping-math, so that loops become SIMD; never fast-math. Image 0.

// x, y, z, w over rho, then the tangent point's three coordinates over rho.
struct ap_points_f {
    float *c[7];
    size_t count;
};
struct ap_points_d {
    double *c[7];
    size_t count;
};

// clamp, acos or acosh of w, factor 1 where the sine is below 1e-4 (the paper's section 5).
void ap_kernel_cosine_f(int kappa, const struct ap_points_f *p);
void ap_kernel_cosine_d(int kappa, const struct ap_points_d *p);
// atan2(r, w)/r, asinh(r)/r.
void ap_kernel_sine_f(int kappa, const struct ap_points_f *p);
void ap_kernel_sine_d(int kappa, const struct ap_points_d *p);
// ap_logmap_float's arithmetic without branches; by AVX2 where the processor has it and wide is not
// 0, else by what every processor of the kind has (SSE2).
void ap_kernel_polynomial_simd(int kappa, int wide, const struct ap_points_f *p);
// How many float32 are worked on at once; 0 where `wide` is not to be had.
int ap_kernel_lanes(int wide);

#endif
