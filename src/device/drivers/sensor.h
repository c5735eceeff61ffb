#ifndef ANTIPODE_DEVICE_DRIVERS_SENSOR_H
#define ANTIPODE_DEVICE_DRIVERS_SENSOR_H

#include "src/device/hid/driver.h"

// What drivers share: rotations, axes, and how HID sensors are switched on.

enum { AP_SENSOR_PAGE = 0x20 };

// x right, y forward, z up (HID sensors) to x right, y up, z back.
struct ap_vec3 ap_y_up_vec3(struct ap_vec3 v);
struct ap_quat ap_y_up_quat(struct ap_quat q);

// Axis times angle, and back (the short way).
struct ap_quat ap_quat_from_rotation_vector(struct ap_vec3 v);
struct ap_vec3 ap_rotation_vector_from_quat(struct ap_quat q);

// One combined feature report for each report id that has one of: reporting state, power state,
// report interval, and the choice `transport` (0: none). What the device had in the other bits is
// kept where it is known.
int ap_sensor_start(const struct ap_device_info *info, double interval_s, uint32_t transport,
                    struct ap_driver_step steps[AP_DRIVER_STEPS_MAX]);

#endif
