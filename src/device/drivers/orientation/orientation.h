#ifndef ANTIPODE_DEVICE_DRIVERS_ORIENTATION_H
#define ANTIPODE_DEVICE_DRIVERS_ORIENTATION_H

#include "src/device/hid/driver.h"

// Any HID sensor (page 0x20) that reports a quaternion (usage 0x0483, in the order x, y, z, w):
// device orientation 0x8A, relative orientation 0x8E, others. HID Usage Tables, section 23.

// Where the quaternion stands; the relative orientation first, which no magnet disturbs.
struct ap_orientation_layout {
    int field;
    uint32_t at;
};

bool ap_orientation_find(const struct ap_hid_descriptor *d, struct ap_orientation_layout *layout);

// A unit quaternion in the sensor's axes (x right, y forward, z up). Its scale is not looked at:
// many descriptors give one that cannot be right.
enum ap_report_verdict ap_orientation_parse(const struct ap_hid_descriptor *d,
                                            const struct ap_orientation_layout *layout,
                                            const uint8_t *bytes, size_t len, struct ap_quat *q);

extern const struct ap_driver ap_driver_orientation;

#endif
