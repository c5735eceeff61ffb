#ifndef ANTIPODE_DEVICE_DRIVERS_ANDROID_H
#define ANTIPODE_DEVICE_DRIVERS_ANDROID_H

#include "src/device/hid/driver.h"

// Head trackers by Android's HID protocol, versions 1 and 2 (headphones, mostly). Everything is
// told by the report descriptor. Protocol: source.android.com, "Head tracker HID protocol".

// Where things stand in the reports.
struct ap_android_layout {
    int vector, rate, counter; // field numbers; rate and counter may be −1
    uint32_t vector_at, rate_at, counter_at;
};

// What one report says, in the protocol's axes (x right, y back to nose, z up).
struct ap_android_report {
    struct ap_vec3 rotation_rad; // axis times angle
    struct ap_vec3 rate_rad_s;
    int64_t counter;
    bool has_rate, has_counter;
};

// False where the descriptor has no rotation vector of three values.
bool ap_android_find(const struct ap_hid_descriptor *d, struct ap_android_layout *layout);

enum ap_report_verdict ap_android_parse(const struct ap_hid_descriptor *d,
                                        const struct ap_android_layout *layout,
                                        const uint8_t *bytes, size_t len,
                                        struct ap_android_report *report);

extern const struct ap_driver ap_driver_android;

#endif
