#ifndef ANTIPODE_TESTS_DEVICE_CALIBRATION_NOISE_H
#define ANTIPODE_TESTS_DEVICE_CALIBRATION_NOISE_H

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include <cmocka.h>

#include "src/geom/vec.h"

static uint64_t noise_state = 1;

// [0, 1), the same in every run (splitmix64).
static inline double uniform(void) {
    uint64_t z = noise_state += 0x9e3779b97f4a7c15;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9;
    z = (z ^ z >> 27) * 0x94d049bb133111eb;
    return (double)((z ^ z >> 31) >> 11) * 0x1p-53;
}

static inline double gauss(double sigma) {
    return sigma * sqrt(-2 * log(1 - uniform())) * cos(2 * M_PI * uniform());
}

static inline struct ap_vec3 gauss3(double sigma) {
    double x = gauss(sigma), y = gauss(sigma);
    return (struct ap_vec3){x, y, gauss(sigma)};
}

static inline void check_near(const char *what, double got, double want, double tolerance) {
    if (!(fabs(got - want) <= tolerance))
        fail_msg("%s: %.17g, not %.17g within %g", what, got, want, tolerance);
}

#endif
