#include "src/device/drivers/bytes.h"
#include "src/device/drivers/fused.h"
#include "src/device/drivers/playstation/playstation.h"

static const double DEGREE = 3.14159265358979323846 / 180, GRAVITY = 9.80665;
static const double USUAL_GYRO_PER_DEG_S = 16.4, USUAL_ACCEL_PER_G = 8192;

struct ap_playstation_calibration
ap_playstation_calibrate(const struct ap_playstation_layout *layout,
                         const struct ap_feature_report *feature) {
    struct ap_playstation_calibration c;
    bool known = feature && feature->len >= layout->calibration_len;
    const uint8_t *b = known ? feature->bytes : NULL;
    double speeds = known ? ap_i16le(b + 19) + ap_i16le(b + 21) : 0;
    for (size_t i = 0; i < 3; i++) {
        c.gyro_bias[i] = c.accel_bias[i] = 0;
        c.gyro_scale[i] = DEGREE / USUAL_GYRO_PER_DEG_S;
        c.accel_scale[i] = GRAVITY / USUAL_ACCEL_PER_G;
        if (!known)
            continue;
        double turn = ap_i16le(b + layout->plus[i]) - ap_i16le(b + layout->minus[i]);
        double up = ap_i16le(b + 23 + 4 * i), down = ap_i16le(b + 25 + 4 * i);
        if (turn > 0 && speeds > 0) {
            c.gyro_bias[i] = ap_i16le(b + 1 + 2 * i);
            c.gyro_scale[i] = DEGREE * speeds / turn;
        }
        if (up > down) {
            c.accel_bias[i] = (up + down) / 2;
            c.accel_scale[i] = GRAVITY * 2 / (up - down);
        }
    }
    return c;
}

static struct ap_vec3 measured(const uint8_t *b, const double bias[3], const double scale[3]) {
    return (struct ap_vec3){(ap_i16le(b) - bias[0]) * scale[0],
                            (ap_i16le(b + 2) - bias[1]) * scale[1],
                            (ap_i16le(b + 4) - bias[2]) * scale[2]};
}

// The check sum is over the byte 0xa1 of Bluetooth's own header, too.
static bool crc_is_right(const uint8_t *bytes, size_t len) {
    static const uint8_t header = 0xa1;
    uint32_t crc = ap_crc32(ap_crc32(0, &header, 1), bytes, len - 4);
    return crc == ap_u32le(bytes + len - 4);
}

enum ap_report_verdict ap_playstation_parse(const struct ap_playstation_layout *layout,
                                            const struct ap_playstation_calibration *c,
                                            const uint8_t *bytes, size_t len,
                                            struct ap_playstation_packet *packet) {
    if (len < 1 || bytes[0] != layout->report)
        return len < 1 ? AP_REPORT_BAD : AP_REPORT_IGNORED;
    if (len < layout->len || (layout->has_crc && !crc_is_right(bytes, layout->len)))
        return AP_REPORT_BAD;
    const uint8_t *b = bytes + layout->buttons, *t = bytes + layout->triggers;
    // Square, cross, circle, triangle are the upper bits of the first byte; cross comes first.
    uint32_t face = (uint32_t)b[0] >> 4, others = (uint32_t)b[1] | (uint32_t)(b[2] & 3) << 8;
    unsigned level = bytes[layout->battery] & 15; // tenths, of which the last is not full
    uint8_t far = t[0] > t[1] ? t[0] : t[1];
    *packet = (struct ap_playstation_packet){
        .gyr_rad_s = measured(bytes + layout->gyro, c->gyro_bias, c->gyro_scale),
        .acc_m_s2 = measured(bytes + layout->accel, c->accel_bias, c->accel_scale),
        .ticks = layout->imu.bits == 16 ? ap_u16le(bytes + layout->ticks)
                                        : ap_u32le(bytes + layout->ticks),
        .buttons = (face >> 1 & 1) | (face & 1) << 1 | (face & 12) | others << 4,
        .trigger = far / 255.0,
        .battery = level < 10 ? level / 10.0 + 0.05 : 1,
    };
    return AP_REPORT_OK;
}
