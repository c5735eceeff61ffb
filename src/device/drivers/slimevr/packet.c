#include <math.h>

#include "src/device/drivers/bytes.h"
#include "src/device/drivers/slimevr/slimevr.h"
#include "src/device/unit_quat.h"

static struct ap_vec3 read_acceleration(const uint8_t *b) {
    return (struct ap_vec3){ap_i16le(b) / 128.0, ap_i16le(b + 2) / 128.0, ap_i16le(b + 4) / 128.0};
}

static bool read_q15(const uint8_t *b, struct ap_quat *q) {
    *q = (struct ap_quat){ap_i16le(b) / 32768.0, ap_i16le(b + 2) / 32768.0,
                          ap_i16le(b + 4) / 32768.0, ap_i16le(b + 6) / 32768.0};
    return ap_quat_make_unit(q);
}

// Three numbers of 10, 11 and 11 bits: v along the axis, |v| = angle/π (the exponential map of half
// the angle, scaled to a ball of radius 1).
static bool read_packed(const uint8_t *b, struct ap_quat *q) {
    uint32_t bits = ap_u32le(b);
    struct ap_vec3 v = {2.0 * (bits & 0x3ff) / 1024 - 1, 2.0 * (bits >> 10 & 0x7ff) / 2048 - 1,
                        2.0 * (bits >> 21) / 2048 - 1};
    double square = ap_vec3_dot(v, v);
    if (square > 1.1)
        return false;
    if (square == 0) {
        *q = AP_QUAT_IDENTITY;
        return true;
    }
    double length = sqrt(square), half = 1.57079632679489661923 * length, s = sin(half) / length;
    *q = (struct ap_quat){s * v.x, s * v.y, s * v.z, cos(half)};
    return ap_quat_make_unit(q);
}

// Percent (0: not now, as while it charges; 128: not known) and, behind it, the voltage, which is 0
// only in padding.
static void read_battery(const uint8_t *b, struct ap_slimevr_packet *packet) {
    packet->has_battery = (b[0] & 127) != 0 && b[1] != 0;
    packet->battery_percent = (b[0] & 127) > 100 ? 100 : b[0] & 127;
}

bool ap_slimevr_parse(const uint8_t b[AP_SLIMEVR_PACKET], struct ap_slimevr_packet *packet) {
    *packet = (struct ap_slimevr_packet){.id = b[1]};
    switch (b[0]) {
    case 0:
        read_battery(b + 2, packet);
        return true;
    case 255:
        packet->kind = AP_SLIMEVR_REGISTRATION;
        packet->address = ap_u32le(b + 2) | (uint64_t)ap_u16le(b + 6) << 32;
        return true;
    case 1:
    case 4: // with a magnetometer where 1 has acceleration
        packet->kind = AP_SLIMEVR_ROTATION;
        if (b[0] == 1)
            packet->acceleration_m_s2 = read_acceleration(b + 10);
        return read_q15(b + 2, &packet->q);
    case 2:
    case 7:
        packet->kind = AP_SLIMEVR_ROTATION;
        if (b[0] == 2)
            read_battery(b + 2, packet);
        packet->has_buttons = b[0] == 7;
        packet->buttons = b[0] == 7 ? b[2] & 3 : 0;
        packet->acceleration_m_s2 = read_acceleration(b + 9);
        return read_packed(b + 5, &packet->q);
    case 6:
        packet->kind = AP_SLIMEVR_BUTTON;
        packet->has_buttons = true;
        packet->buttons = b[2] & 3;
        return true;
    default:
        return true;
    }
}
