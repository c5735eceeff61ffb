#ifndef ANTIPODE_DEVICE_FUSION_VQF_H
#define ANTIPODE_DEVICE_FUSION_VQF_H

#include <stdbool.h>
#include <stdint.h>

#include "src/device/fusion/lowpass.h"
#include "src/geom/vec.h"

// Orientation from gyroscope and accelerometer, with the gyroscope's bias estimated at rest and in
// motion: VQF without magnetometer, after D. Laidig, T. Seel, "VQF: Highly accurate IMU orientation
// estimation with bias estimation and magnetic disturbance rejection", Information Fusion 91
// (2023). No allocation, no clock; one thread at a time. The heading starts at 0 and drifts.

// 0 means the paper's value (which stands behind).
struct ap_vqf_params {
    double period_s;          // of the samples, nominal; required, 1e-5 … 0.5
    double tau_acc_s;         // 3: low-pass of the specific force
    double bias_sigma_init;   // 0.5 °/s
    double bias_forget_s;     // 100: in which 0.1 °/s of uncertainty come back
    double bias_clip;         // 2 °/s: no bias is larger
    double bias_sigma_motion; // 0.1 °/s
    double bias_sigma_rest;   // 0.03 °/s
    double rest_min_s;        // 1.5
    double rest_tau_s;        // 0.5
    double rest_gyr;          // 2 °/s
    double rest_acc;          // 0.5 m/s²
    bool no_motion_bias, no_rest_bias;
};

struct ap_vqf {
    struct ap_vqf_params params; // defaults filled in
    struct ap_quat gyr;          // sensor to the almost-inertial frame: integrated rates alone
    struct ap_quat tilt;         // almost-inertial frame to earth
    struct ap_lowpass acc_low, gyr_low, rest_acc_low, bias_low;
    struct ap_vec3 bias; // rad/s
    double covariance[3][3];
    double variance_init, variance_step, weight_motion, weight_vertical, weight_rest;
    double rest_s;
    struct ap_vec3 rest_gyr; // low-passed rate
    bool at_rest;
    int64_t accepted, rejected;
};

// False where a parameter is not finite or out of range; *vqf is then untouched.
bool ap_vqf_init(struct ap_vqf *vqf, const struct ap_vqf_params *params);

// Starts again with the bias kept: after a gap in the samples or a recentring.
void ap_vqf_restart(struct ap_vqf *vqf);

// One sample: rate in rad/s and specific force in m/s² (at rest +g along up), both in sensor axes,
// and the time since the sample before it. False, and only `rejected` changes, where anything is
// not finite, |rate| > 200 rad/s, |force| > 2000 m/s², dt_s ≤ 0 or > 0.5. A zero force (a sensor
// that is off) is integrated without tilt correction.
bool ap_vqf_update(struct ap_vqf *vqf, struct ap_vec3 gyr_rad_s, struct ap_vec3 acc_m_s2,
                   double dt_s);

// Sensor to earth, earth +y up; unit.
struct ap_quat ap_vqf_orientation(const struct ap_vqf *vqf);

// Rate less the estimated bias.
struct ap_vec3 ap_vqf_rate(const struct ap_vqf *vqf, struct ap_vec3 gyr_rad_s);

// Standard deviation of the bias estimate, rad/s (the largest of the three axes).
double ap_vqf_bias_sigma(const struct ap_vqf *vqf);

#endif
