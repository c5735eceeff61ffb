#ifndef ANTIPODE_DEVICE_DRIVERS_SPACEMOUSE_H
#define ANTIPODE_DEVICE_DRIVERS_SPACEMOUSE_H

#include "src/device/hid/driver.h"

// 3Dconnexion's six-axis caps: how far the cap is pushed and turned says how fast to go. Reports
// and ranges are told by the report descriptor, so that split and joint reports, 8 and 16 bits and
// any order of axes are the same.

enum { AP_SPACEMOUSE_AXES = 6 }; // x y z rx ry rz

struct ap_spacemouse_layout {
    int axis[AP_SPACEMOUSE_AXES]; // field numbers, −1: none
    uint32_t axis_at[AP_SPACEMOUSE_AXES];
    int buttons; // −1: none
};

struct ap_spacemouse_report {
    bool has_axis[AP_SPACEMOUSE_AXES];
    double axis[AP_SPACEMOUSE_AXES]; // −1…1 of what the descriptor says; x right, y back, z down
    bool has_buttons;
    uint32_t buttons;
};

// False where a push axis is lacking.
bool ap_spacemouse_find(const struct ap_hid_descriptor *d, struct ap_spacemouse_layout *layout);

enum ap_report_verdict ap_spacemouse_parse(const struct ap_hid_descriptor *d,
                                           const struct ap_spacemouse_layout *layout,
                                           const uint8_t *bytes, size_t len,
                                           struct ap_spacemouse_report *report);

// For how long a rate goes on that was reported `dt_s` ago, seconds: the whole of the first 0.1 s,
// then less and less of the next. A release that was lost so ends at 0.15.
double ap_spacemouse_hold_s(double dt_s);

extern const struct ap_driver ap_driver_spacemouse;

#endif
