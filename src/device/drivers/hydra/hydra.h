#ifndef ANTIPODE_DEVICE_DRIVERS_HYDRA_H
#define ANTIPODE_DEVICE_DRIVERS_HYDRA_H

#include "src/device/hid/driver.h"

// Razer Hydra: two controllers with places, from a base on the table.

struct ap_hydra_controller {
    struct ap_vec3 p_m; // from the base; y up
    struct ap_quat q;   // unit
    uint8_t buttons;    // bit 0 is the bumper
    double trigger;     // 0…1
};

enum { AP_HYDRA_REPORT = 52 };

enum ap_report_verdict ap_hydra_parse(const uint8_t *bytes, size_t len,
                                      struct ap_hydra_controller controllers[2]);

extern const struct ap_driver ap_driver_hydra;

#endif
