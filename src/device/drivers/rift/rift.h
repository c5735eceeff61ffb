#ifndef ANTIPODE_DEVICE_DRIVERS_RIFT_H
#define ANTIPODE_DEVICE_DRIVERS_RIFT_H

#include "src/device/fusion/imu.h"
#include "src/device/hid/driver.h"

// Oculus Rift DK1, DK2 and CV1, the sensor in the headset: what differs is a row of a table. They
// fall silent unless they are told, again and again, that somebody listens.

enum { AP_RIFT_MEASUREMENTS = 3 };

struct ap_rift_layout {
    uint8_t report; // its id
    size_t len;
    size_t count, ticks, measurements; // offsets
    int most;                          // measurements in a report
    uint32_t step;                     // ticks from one to the next
    bool has_components;               // switched on by a report of their own
    struct ap_imu_params imu;
};

// Whose models are struct ap_rift_layout.
extern const struct ap_driver_ids ap_rift_ids[];

struct ap_rift_packet {
    int count; // the oldest first
    struct ap_imu_reading at[AP_RIFT_MEASUREMENTS];
};

// Three numbers of 21 bits, the highest first, in 1e-4 of a unit.
struct ap_vec3 ap_rift_triple(const uint8_t bytes[8]);

// AP_REPORT_IGNORED: another report. AP_REPORT_BAD: too short, or without a measurement.
enum ap_report_verdict ap_rift_parse(const struct ap_rift_layout *layout, const uint8_t *bytes,
                                     size_t len, struct ap_rift_packet *packet);

extern const struct ap_driver ap_driver_rift;

#endif
