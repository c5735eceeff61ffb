#ifndef ANTIPODE_TESTS_DEVICE_LIVE_DEVICES_H
#define ANTIPODE_TESTS_DEVICE_LIVE_DEVICES_H

#include <math.h>
#include <string.h>

#include "src/device/drivers/fused.h"
#include "src/geom/vec.h"
#include "tests/device/live/fake_bus.h"

// Reports of a few devices, written by the protocols' descriptions and not by the parsers.

#define SLIMEVR_DESCRIPTOR "05 01 09 00 a1 01 09 00 75 08 95 40 81 02 c0"
#define XREAL_DESCRIPTOR "06 00 ff 09 01 a1 01 09 02 15 00 26 ff 00 75 08 95 40 81 02 c0"

static inline void put16(uint8_t *b, int value) {
    b[0] = (uint8_t)(value & 0xff);
    b[1] = (uint8_t)(value >> 8 & 0xff);
}

// A registration, the buttons, and twice a rotation about the vertical. The
// receiver's world has z up; the tracker's own axes lie as the room's: q = turn⁻¹·yaw.
static inline void slimevr_report(uint8_t bytes[64], double yaw_rad, int buttons) {
    double h = yaw_rad / 2, r = sqrt(0.5);
    // (x: +90°)·(y: yaw) = (r, 0, 0, r)·(0, sin h, 0, cos h)
    double q[4] = {r * cos(h), r * sin(h), r * sin(h), r * cos(h)};
    memset(bytes, 0, 64);
    bytes[0] = 255;
    bytes[1] = 5;
    bytes[2] = 0x11;
    for (int i = 2; i < 4; i++) {
        uint8_t *p = bytes + 16 * i;
        p[0] = 1;
        p[1] = 5;
        for (int k = 0; k < 4; k++)
            put16(p + 2 + 2 * k, (int)lround(q[k] * 32767));
    }
    bytes[16] = 6;
    bytes[17] = 5;
    bytes[18] = (uint8_t)buttons;
}

// At rest and upright, turning about y at `rate_rad_s`; the sensor's axes are (−x, z, y).
static inline void xreal_report(uint8_t bytes[64], int64_t device_ns, double rate_rad_s) {
    memset(bytes, 0, 64);
    bytes[0] = 1;
    bytes[1] = 2;
    for (int i = 0; i < 8; i++)
        bytes[4 + i] = (uint8_t)((uint64_t)device_ns >> 8 * i);
    put16(bytes + 12, 2000);
    bytes[14] = 0, bytes[15] = 0, bytes[16] = 0x80; // 2^23
    int gyro = (int)lround(rate_rad_s * 57.29577951308232 * 8388608 / 2000);
    put16(bytes + 24, gyro & 0xffff); // the sensor's z is up
    bytes[26] = (uint8_t)(gyro >> 16);
    put16(bytes + 27, 16);
    bytes[29] = 0, bytes[30] = 0, bytes[31] = 0x80;
    int g = 8388608 / 16;
    put16(bytes + 39, g & 0xffff);
    bytes[41] = (uint8_t)(g >> 16);
}

static inline int plug_slimevr(struct fake_bus *fake, const char *serial) {
    return fake_plug(fake, serial, 3, 0x1209, 0x7690, "SlimeVR receiver", SLIMEVR_DESCRIPTOR);
}

static inline int plug_xreal(struct fake_bus *fake, const char *serial) {
    return fake_plug(fake, serial, 3, 0x3318, 0x0424, "XREAL Air", XREAL_DESCRIPTOR);
}

static inline void send_slimevr(struct fake_bus *fake, int device, double yaw_rad, int buttons) {
    uint8_t bytes[64];
    slimevr_report(bytes, yaw_rad, buttons);
    fake_send(fake, device, bytes, sizeof bytes);
}

static inline void send_xreal(struct fake_bus *fake, int device, int64_t device_ns,
                              double rate_rad_s) {
    uint8_t bytes[64];
    xreal_report(bytes, device_ns, rate_rad_s);
    fake_send(fake, device, bytes, sizeof bytes);
}

static inline double yaw_of(struct ap_quat q) {
    struct ap_vec3 ahead = ap_quat_rotate(q, (struct ap_vec3){0, 0, -1});
    return atan2(-ahead.x, -ahead.z);
}

#endif
