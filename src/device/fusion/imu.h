#ifndef ANTIPODE_DEVICE_FUSION_IMU_H
#define ANTIPODE_DEVICE_FUSION_IMU_H

#include <stdbool.h>
#include <stdint.h>

#include "src/device/fusion/vqf.h"

// What drivers of devices with a gyroscope, an accelerometer and a clock of their own share: the
// device's counter becomes the time between samples, and VQF the orientation. Plain data, no
// pointers, so that it can stand in a driver's state.

struct ap_imu_params {
    double period_s;                   // nominal
    int bits;                          // of the device's counter, 8 … 64
    uint32_t tick_ns_num, tick_ns_den; // a tick is num/den nanoseconds, both at least 1
    // What is at most so many ticks before the newest sample came out of order and is passed over;
    // anything before that is a counter that has begun anew.
    uint32_t late_ticks;
};

// What a sensor says when there is nothing to say (src/device/calibration/rest.h), in the tracker's
// axes.
struct ap_imu_bias {
    struct ap_vec3 gyr_rad_s, acc_m_s2;
};

struct ap_imu {
    struct ap_imu_params params;
    struct ap_imu_bias bias; // zero after ap_imu_init
    struct ap_vqf vqf;
    bool started;
    uint64_t raw;
    int64_t remainder; // below a nanosecond, in 1/den
    int64_t device_ns; // since the first sample, gaps left out
};

// One measurement, with the device's counter then.
struct ap_imu_reading {
    uint64_t ticks;
    struct ap_vec3 gyr_rad_s, acc_m_s2;
};

enum ap_imu_event {
    AP_IMU_OK,
    AP_IMU_RESET,    // the first sample, or the counter jumped by over half a second: heading anew
    AP_IMU_REPEATED, // the same stamp as before, or a little before it; nothing changed
    AP_IMU_REFUSED,  // not finite or beyond what a sensor can measure; nothing changed
};

// False where a parameter is out of range.
bool ap_imu_init(struct ap_imu *imu, const struct ap_imu_params *params);

// One sample at the device's counter `raw`, bias not yet taken away; axes and units as for
// ap_vqf_update.
enum ap_imu_event ap_imu_add(struct ap_imu *imu, uint64_t raw, struct ap_vec3 gyr_rad_s,
                             struct ap_vec3 acc_m_s2);

#endif
