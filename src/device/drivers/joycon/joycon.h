#ifndef ANTIPODE_DEVICE_DRIVERS_JOYCON_H
#define ANTIPODE_DEVICE_DRIVERS_JOYCON_H

#include "src/device/fusion/imu.h"
#include "src/device/hid/driver.h"

// Nintendo's Joy-Cons and Pro Controller: three measurements, 5 ms apart, in a report.

enum { AP_JOYCON_REPORT = 49, AP_JOYCON_MEASUREMENTS = 3 };

enum { AP_JOYCON_HOME = 3 << 13 }; // of a packet's buttons: Home, the left one's Capture

struct ap_joycon_model {
    const char *side;    // NULL: of either hand
    bool is_upside_down; // the sensor
    int selects;         // the button that does, of the 24 in a report
};

// Whose models are struct ap_joycon_model: the left one, the right one, the Pro Controller.
extern const struct ap_driver_ids ap_joycon_ids[];

// Measured = (raw − bias)·scale, in rad/s and m/s², by the device's own axes.
struct ap_joycon_calibration {
    double gyro_bias[3], gyro_scale[3], accel_scale[3];
    bool is_users; // not the maker's
};

struct ap_joycon_calibration ap_joycon_usual_calibration(void);

struct ap_joycon_packet {
    // x right, y up, z back, as it is held pointing forward; ticks of 5 ms, the oldest first.
    struct ap_imu_reading at[AP_JOYCON_MEASUREMENTS];
    uint32_t buttons; // bit 0: A, or the left one's right arrow
    bool trigger;     // ZL or ZR
    double battery;   // 0…1, in steps of a quarter
};

// AP_REPORT_IGNORED: no full report.
enum ap_report_verdict ap_joycon_parse(const struct ap_joycon_model *model,
                                       const struct ap_joycon_calibration *calibration,
                                       const uint8_t *bytes, size_t len,
                                       struct ap_joycon_packet *packet);

// Takes the calibration from the answer to a reading of the flash, the maker's or, which goes
// before it, the one that the user has made; false where the report is something else or makes no
// sense.
bool ap_joycon_read_calibration(const uint8_t *bytes, size_t len,
                                struct ap_joycon_calibration *calibration);

extern const struct ap_driver ap_driver_joycon;

#endif
