#ifndef ANTIPODE_DEVICE_CALIBRATION_REST_H
#define ANTIPODE_DEVICE_CALIBRATION_REST_H

#include <stdbool.h>
#include <stdint.h>

#include "src/base/status.h"
#include "src/device/fusion/imu.h"

// The biases of a gyroscope and an accelerometer from measurements while they lie still. Quarters
// of a second are still or not; still ones in a row are a rest, of which the first and the last
// quarter do not count. No clock, no allocation.

enum { AP_RESTS_MAX = 32 };

struct ap_rest_sums {
    int64_t count;
    struct ap_vec3 gyr, acc;   // sums, from gyr0 and acc0
    struct ap_vec3 gyr2, acc2; // of squares
    struct ap_vec3 gyr0, acc0; // the first
};

// A lie of at least two seconds.
struct ap_rest_found {
    int quarters;
    struct ap_vec3 gyr, gyr2, acc; // sums of the quarters' means
};

struct ap_rest {
    bool started;
    int64_t block_ns, last_ns, samples;
    struct ap_rest_sums block;
    struct ap_rest_found run, held;        // held: without the newest quarter
    struct ap_vec3 before_gyr, before_acc; // means of the newest quarter
    int run_quarters;                      // still ones up to now
    int found_count;
    struct ap_rest_found found[AP_RESTS_MAX];
    const char *last_why; // what made the newest quarter none of rest
};

struct ap_rest_result {
    struct ap_imu_bias bias;
    double gyr_sigma_rad_s; // standard error of the worst axis, by the scatter of the quarters
    double seconds;         // at rest
    int poses;              // how many ways up it lay
};

// All zero is a fresh one. False where a measurement is not finite, not after the one before or
// beyond 73 years; it does not count. A gap of half a second ends a rest.
bool ap_rest_add(struct ap_rest *rest, int64_t t_ns, struct ap_vec3 gyr_rad_s,
                 struct ap_vec3 acc_m_s2);

// From all the rests so far. The accelerometer's bias is the smallest one that makes every rest's
// force 9.80665 m/s²: from one pose only its part along up is known, from four or more that differ
// all of it. A bias over 5 °/s or 1 m/s² is refused. AP_INPUT: no rest of two seconds; the sentence
// says what moved.
enum ap_status ap_rest_result(struct ap_error *err, const struct ap_rest *rest,
                              struct ap_rest_result *result);

#endif
