#include "src/device/drivers/rift/rift.h"

// The table: what differs between the headsets, and who is which.

enum { OCULUS = 0x2833 };

static const struct ap_rift_layout dk1 = {
    .report = 0x01,
    .len = 62,
    .count = 1,
    .ticks = 2,
    .measurements = 8,
    .most = 3,
    .step = 1,
    .imu = {.period_s = 0.001,
            .bits = 16,
            .tick_ns_num = 1000000,
            .tick_ns_den = 1,
            .late_ticks = 100},
};

static const struct ap_rift_layout dk2 = {
    .report = 0x0b,
    .len = 64,
    .count = 3,
    .ticks = 8,
    .measurements = 12,
    .most = 2,
    .step = 1000,
    .imu = {.period_s = 0.001,
            .bits = 32,
            .tick_ns_num = 1000,
            .tick_ns_den = 1,
            .late_ticks = 100000},
};

static const struct ap_rift_layout cv1 = {
    .report = 0x0b,
    .len = 64,
    .count = 3,
    .ticks = 8,
    .measurements = 12,
    .most = 2,
    .step = 1000,
    .has_components = true,
    .imu = {.period_s = 0.001,
            .bits = 32,
            .tick_ns_num = 1000,
            .tick_ns_den = 1,
            .late_ticks = 100000},
};

// Nothing but the first interface: the CV1's second is its controllers' radio.
const struct ap_driver_ids ap_rift_ids[] = {
    {AP_PRODUCT(OCULUS, 0x0001), .not_interfaces = ~UINT32_C(1), .model = &dk1},
    {AP_PRODUCT(OCULUS, 0x0021), .not_interfaces = ~UINT32_C(1), .model = &dk2},
    {AP_PRODUCT(OCULUS, 0x2021), .not_interfaces = ~UINT32_C(1), .model = &dk2},
    {AP_PRODUCT(OCULUS, 0x0031), .not_interfaces = ~UINT32_C(1), .model = &cv1},
    {0},
};
