#ifndef ANTIPODE_DEVICE_DRIVERS_PLAYSTATION_H
#define ANTIPODE_DEVICE_DRIVERS_PLAYSTATION_H

#include "src/device/fusion/imu.h"
#include "src/device/hid/driver.h"

// DualSense and DualShock 4, by cable and by Bluetooth: what differs is a row of a table.

struct ap_playstation_layout {
    uint8_t report; // its id
    size_t len;
    bool has_crc;                                          // in the last four bytes
    size_t gyro, accel, ticks, buttons, triggers, battery; // offsets
    struct ap_imu_params imu;
    uint8_t calibration; // the feature report's id; asking for it turns full reports on
    size_t calibration_len;
    size_t plus[3], minus[3]; // offsets of what the gyroscope said at the two speeds
};

// Whose models are struct ap_playstation_layout.
extern const struct ap_driver_ids ap_playstation_ids[];

// Measured = (raw − bias)·scale, in rad/s and m/s², by axis.
struct ap_playstation_calibration {
    double gyro_bias[3], gyro_scale[3], accel_bias[3], accel_scale[3];
};

enum { AP_PLAYSTATION_HOME = 1 << 12 }; // of a packet's buttons

// From the feature report, or the makers' usual values where it is NULL, short, or makes no sense
// (which copies of these controllers do).
struct ap_playstation_calibration
ap_playstation_calibrate(const struct ap_playstation_layout *layout,
                         const struct ap_feature_report *feature);

struct ap_playstation_packet {
    struct ap_vec3 gyr_rad_s, acc_m_s2; // x right, y up, z toward the player
    uint32_t ticks;
    uint32_t buttons; // bit 0: cross
    double trigger;   // the farther one, 0…1
    double battery;   // 0…1, in steps of a tenth
};

// AP_REPORT_IGNORED: another report. AP_REPORT_BAD: too short, or a wrong check sum.
enum ap_report_verdict ap_playstation_parse(const struct ap_playstation_layout *layout,
                                            const struct ap_playstation_calibration *calibration,
                                            const uint8_t *bytes, size_t len,
                                            struct ap_playstation_packet *packet);

extern const struct ap_driver ap_driver_playstation;

#endif
