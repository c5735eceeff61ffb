#ifndef ANTIPODE_DEVICE_DRIVERS_SLIMEVR_H
#define ANTIPODE_DEVICE_DRIVERS_SLIMEVR_H

#include "src/device/hid/driver.h"

// The SlimeVR receiver: one dongle, many trackers, reports of packets of 16 bytes.

enum { AP_SLIMEVR_PACKET = 16 };

enum ap_slimevr_kind {
    AP_SLIMEVR_OTHER,        // one that does not turn a tracker
    AP_SLIMEVR_REGISTRATION, // the tracker of this id is there
    AP_SLIMEVR_ROTATION,
    AP_SLIMEVR_BUTTON,
};

struct ap_slimevr_packet {
    enum ap_slimevr_kind kind;
    uint8_t id;
    uint64_t address;                 // AP_SLIMEVR_REGISTRATION: 48 bits
    struct ap_quat q;                 // AP_SLIMEVR_ROTATION: unit, world z up
    struct ap_vec3 acceleration_m_s2; // of the tracker without gravity, in its own axes
    bool has_buttons;
    uint8_t buttons;
    bool has_battery;
    uint8_t battery_percent;
};

// False: a rotation that is none.
bool ap_slimevr_parse(const uint8_t bytes[AP_SLIMEVR_PACKET], struct ap_slimevr_packet *packet);

extern const struct ap_driver ap_driver_slimevr;

#endif
