#include "src/app/bench/kernels.h"

#include <math.h>
#include <stdint.h>
#include <string.h>
#include <tgmath.h>

#include "src/render/logmap/logmap_float.h"

// The same text in float and in double; tgmath takes the function of the type.
#define KERNELS(T, SUFFIX)                                                                         \
    static T cosine_##SUFFIX(int kappa, T w) {                                                     \
        T theta, sine;                                                                             \
        if (kappa > 0) {                                                                           \
            theta = acos(w > 1 ? (T)1 : w < -1 ? (T)-1 : w);                                       \
            sine = sin(theta);                                                                     \
        } else {                                                                                   \
            theta = acosh(w < 1 ? (T)1 : w);                                                       \
            sine = sinh(theta);                                                                    \
        }                                                                                          \
        return sine < (T)1e-4 ? (T)1 : theta / sine;                                               \
    }                                                                                              \
    static T sine_##SUFFIX(int kappa, T r, T w) {                                                  \
        T theta = kappa > 0 ? atan2(r, w) : asinh(r);                                              \
        return r > 0 ? theta / r : (T)1;                                                           \
    }                                                                                              \
    void ap_kernel_cosine_##SUFFIX(int kappa, const struct ap_points_##SUFFIX *p) {                \
        for (size_t i = 0; i < p->count; i++) {                                                    \
            T f = cosine_##SUFFIX(kappa, p->c[3][i]);                                              \
            for (int k = 0; k < 3; k++)                                                            \
                p->c[4 + k][i] = f * p->c[k][i];                                                   \
        }                                                                                          \
    }                                                                                              \
    void ap_kernel_sine_##SUFFIX(int kappa, const struct ap_points_##SUFFIX *p) {                  \
        for (size_t i = 0; i < p->count; i++) {                                                    \
            T x = p->c[0][i], y = p->c[1][i], z = p->c[2][i];                                      \
            T f = sine_##SUFFIX(kappa, sqrt(x * x + y * y + z * z), p->c[3][i]);                   \
            for (int k = 0; k < 3; k++)                                                            \
                p->c[4 + k][i] = f * p->c[k][i];                                                   \
        }                                                                                          \
    }
KERNELS(float, f)
KERNELS(double, d)

#define INLINE static inline __attribute__((always_inline))

INLINE float series(const float *c, int terms, float t) {
    float p = c[terms - 1];
    for (int k = terms - 2; k >= 0; k--)
        p = p * t + c[k];
    return 1.0f + t * p;
}

INLINE float s3_factor(float t, float w) {
    float r = __builtin_sqrtf(t);
    float middle = __builtin_fabsf(w) < 0.70710678f ? 1.0f : 0.0f;
    float p = series(ap_logmap_asin, AP_LOGMAP_TERMS, middle > 0 ? w * w : t);
    float outer = w > 0 ? r * p : 3.14159265f - r * p;
    float theta = middle > 0 ? 1.57079633f - w * p : outer;
    return w > 0.70710678f ? p : theta / r;
}

INLINE float h3_factor(float t, float w) {
    float near = series(ap_logmap_asinh, AP_LOGMAP_TERMS, t < 1.0f ? t : 1.0f);
    float r = w > 4096.0f ? w : __builtin_sqrtf(t), x = w + r;
    x = t < 1.0f ? 1.0f : x;
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    int32_t e = (int32_t)((bits - 0x3f3504f3u) >> 23);
    bits -= (uint32_t)e << 23;
    float m;
    memcpy(&m, &bits, sizeof m);
    float s = (m - 1.0f) / (m + 1.0f);
    float log =
        (float)e * 0.693147181f + 2.0f * s * series(ap_logmap_atanh, AP_LOGMAP_LOG_TERMS, s * s);
    return t < 1.0f ? near : log / r;
}

INLINE void factors(int kappa, size_t n, const float *restrict t, const float *restrict w,
                    float *restrict f) {
    for (size_t i = 0; i < n; i++)
        f[i] = kappa > 0 ? s3_factor(t[i], w[i]) : h3_factor(t[i], w[i]);
}

INLINE void scale(size_t n, const float *restrict f, const float *restrict x, float *restrict q) {
    for (size_t i = 0; i < n; i++)
        q[i] = f[i] * x[i];
}

// By blocks that stay in the first cache, a loop for each step.
INLINE void polynomial(int kappa, const struct ap_points_f *p) {
    enum { BLOCK = 256 };
    float t[BLOCK], f[BLOCK];
    for (size_t at = 0; at < p->count; at += BLOCK) {
        size_t n = p->count - at < BLOCK ? p->count - at : BLOCK;
        const float *restrict x = p->c[0] + at, *restrict y = p->c[1] + at,
                              *restrict z = p->c[2] + at;
        for (size_t i = 0; i < n; i++)
            t[i] = x[i] * x[i] + y[i] * y[i] + z[i] * z[i];
        factors(kappa, n, t, p->c[3] + at, f);
        for (int k = 0; k < 3; k++)
            scale(n, f, p->c[k] + at, p->c[4 + k] + at);
    }
}

#if defined(__x86_64__)
__attribute__((target("avx2"))) static void wide_s3(const struct ap_points_f *p) {
    polynomial(1, p);
}
__attribute__((target("avx2"))) static void wide_h3(const struct ap_points_f *p) {
    polynomial(-1, p);
}
int ap_kernel_lanes(int wide) {
    return !wide ? 4 : __builtin_cpu_supports("avx2") ? 8 : 0;
}
#else
static void wide_s3(const struct ap_points_f *p) {
    polynomial(1, p);
}
static void wide_h3(const struct ap_points_f *p) {
    polynomial(-1, p);
}
int ap_kernel_lanes(int wide) {
    return wide ? 0 : 4;
}
#endif

static void narrow_s3(const struct ap_points_f *p) {
    polynomial(1, p);
}
static void narrow_h3(const struct ap_points_f *p) {
    polynomial(-1, p);
}

void ap_kernel_polynomial_simd(int kappa, int wide, const struct ap_points_f *p) {
    if (kappa > 0)
        (wide ? wide_s3 : narrow_s3)(p);
    else
        (wide ? wide_h3 : narrow_h3)(p);
}
