#include "src/device/drivers/playstation/playstation.h"

// The table: what differs between the controllers, and who is which.

enum { USB = 3, BLUETOOTH = 5, SONY = 0x054c };

static const struct ap_playstation_layout dualsense_usb = {
    .report = 0x01,
    .len = 64,
    .gyro = 16,
    .accel = 22,
    .ticks = 28,
    .buttons = 8,
    .triggers = 5,
    .battery = 53,
    .imu = {.period_s = 0.004, .bits = 32, .tick_ns_num = 1000, .tick_ns_den = 3},
    .calibration = 0x05,
    .calibration_len = 41,
    .plus = {7, 11, 15},
    .minus = {9, 13, 17},
};

static const struct ap_playstation_layout dualsense_bluetooth = {
    .report = 0x31,
    .len = 78,
    .has_crc = true,
    .gyro = 17,
    .accel = 23,
    .ticks = 29,
    .buttons = 9,
    .triggers = 6,
    .battery = 54,
    .imu = {.period_s = 0.004, .bits = 32, .tick_ns_num = 1000, .tick_ns_den = 3},
    .calibration = 0x05,
    .calibration_len = 41,
    .plus = {7, 11, 15},
    .minus = {9, 13, 17},
};

static const struct ap_playstation_layout dualshock4_usb = {
    .report = 0x01,
    .len = 64,
    .gyro = 13,
    .accel = 19,
    .ticks = 10,
    .buttons = 5,
    .triggers = 8,
    .battery = 30,
    .imu = {.period_s = 0.004, .bits = 16, .tick_ns_num = 16000, .tick_ns_den = 3},
    .calibration = 0x02,
    .calibration_len = 37,
    .plus = {7, 11, 15},
    .minus = {9, 13, 17},
};

static const struct ap_playstation_layout dualshock4_bluetooth = {
    .report = 0x11,
    .len = 78,
    .has_crc = true,
    .gyro = 15,
    .accel = 21,
    .ticks = 12,
    .buttons = 7,
    .triggers = 10,
    .battery = 32,
    .imu = {.period_s = 0.004, .bits = 16, .tick_ns_num = 16000, .tick_ns_den = 3},
    .calibration = 0x05,
    .calibration_len = 41,
    .plus = {7, 9, 11},
    .minus = {13, 15, 17},
};

const struct ap_driver_ids ap_playstation_ids[] = {
    {.bus = USB, AP_PRODUCT(SONY, 0x0ce6), .model = &dualsense_usb},
    {.bus = USB, AP_PRODUCT(SONY, 0x0df2), .model = &dualsense_usb},
    {.bus = BLUETOOTH, AP_PRODUCT(SONY, 0x0ce6), .model = &dualsense_bluetooth},
    {.bus = BLUETOOTH, AP_PRODUCT(SONY, 0x0df2), .model = &dualsense_bluetooth},
    {.bus = USB, AP_PRODUCT(SONY, 0x05c4), .model = &dualshock4_usb},
    {.bus = USB, AP_PRODUCT(SONY, 0x09cc), .model = &dualshock4_usb},
    {.bus = BLUETOOTH, AP_PRODUCT(SONY, 0x05c4), .model = &dualshock4_bluetooth},
    {.bus = BLUETOOTH, AP_PRODUCT(SONY, 0x09cc), .model = &dualshock4_bluetooth},
    {0},
};
