// Derives the minimax polynomials of the log map anew and holds the coefficients that ship in
// src/render/logmap/logmap_float.h and shaders/logmap.glsl against them: the shipped ones may be at
// most a rounding worse. With --print it writes the coefficients.
#include <math.h>
#include <string.h>

#include "src/render/logmap/logmap_float.h"
#include "tests/render/remez.h"

// What is fitted: (F(t) − 1)/t by a polynomial, so that the value at t = 0 is 1 exactly; the error
// is measured relative to F.
static void by_ratio(long double t, long double f, long double *value, long double *weight) {
    *value = t == 0 ? 0 : (f - 1) / t;
    *weight = t / f;
}

static void asin_ratio(long double t, long double *value, long double *weight) {
    by_ratio(t, t == 0 ? 1 : asinl(sqrtl(t)) / sqrtl(t), value, weight);
}

static void asinh_ratio(long double t, long double *value, long double *weight) {
    by_ratio(t, t == 0 ? 1 : asinhl(sqrtl(t)) / sqrtl(t), value, weight);
}

static void atanh_ratio(long double t, long double *value, long double *weight) {
    by_ratio(t, t == 0 ? 1 : atanhl(sqrtl(t)) / sqrtl(t), value, weight);
}

static const struct remez_fit FITS[] = {
    {"asin", asin_ratio, 0, 0.5L, AP_LOGMAP_TERMS},
    {"asinh", asinh_ratio, 0, 1.0L, AP_LOGMAP_TERMS},
    {"atanh", atanh_ratio, 0, 0.029437251522859414L, AP_LOGMAP_LOG_TERMS},
};
static const float *const SHIPPED[] = {ap_logmap_asin, ap_logmap_asinh, ap_logmap_atanh};

int main(int argc, char **argv) {
    int failures = 0, print = argc > 1 && strcmp(argv[1], "--print") == 0;
    for (size_t i = 0; i < sizeof FITS / sizeof FITS[0]; i++)
        failures += remez_hold(&FITS[i], SHIPPED[i], 6e-8L, print);
    return failures;
}
