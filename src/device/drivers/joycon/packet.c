#include "src/device/drivers/joycon/joycon.h"

#include "src/device/drivers/bytes.h"

enum {
    FULL = 0x30,
    ANSWER = 0x21,
    READ_FLASH = 0x10,
    CALIBRATION_AT = 0x6020,
    USERS_AT = 0x8026,
    CALIBRATION = 24
};

static const double DEGREE = 3.14159265358979323846 / 180, GRAVITY = 9.80665;

struct ap_joycon_calibration ap_joycon_usual_calibration(void) {
    const double gyro = 0.070 * DEGREE, accel = GRAVITY / 4096;
    return (struct ap_joycon_calibration){.gyro_scale = {gyro, gyro, gyro},
                                          .accel_scale = {accel, accel, accel}};
}

// The sensor's x points to the triggers, y left and z out of the buttons; or it lies the other way
// round.
static struct ap_vec3 turned(const struct ap_joycon_model *model, double x, double y, double z) {
    double side = model->is_upside_down ? -1 : 1;
    return (struct ap_vec3){-side * y, side * z, -x};
}

enum ap_report_verdict ap_joycon_parse(const struct ap_joycon_model *model,
                                       const struct ap_joycon_calibration *c, const uint8_t *bytes,
                                       size_t len, struct ap_joycon_packet *packet) {
    if (len < 1)
        return AP_REPORT_BAD;
    if (bytes[0] != FULL)
        return AP_REPORT_IGNORED;
    if (len < AP_JOYCON_REPORT)
        return AP_REPORT_BAD;
    packet->battery = bytes[2] >> 5 < 4 ? (bytes[2] >> 5) / 4.0 : 1;
    for (int i = 0; i < AP_JOYCON_MEASUREMENTS; i++) {
        double a[3], w[3];
        for (int k = 0; k < 3; k++) {
            const uint8_t *b = bytes + 13 + 12 * i + 2 * k;
            a[k] = ap_i16le(b) * c->accel_scale[k];
            w[k] = (ap_i16le(b + 6) - c->gyro_bias[k]) * c->gyro_scale[k];
        }
        packet->at[i].ticks = (uint8_t)(bytes[1] + i);
        packet->at[i].acc_m_s2 = turned(model, a[0], a[1], a[2]);
        packet->at[i].gyr_rad_s = turned(model, w[0], w[1], w[2]);
    }
    uint32_t all = bytes[3] | (uint32_t)bytes[4] << 8 | (uint32_t)bytes[5] << 16;
    packet->buttons = (all >> model->selects & 1) | all << 1;
    packet->trigger = (bytes[3] | bytes[5]) & 0x80;
    return AP_REPORT_OK;
}

// Where the numbers stand in the answer to a reading of the flash; NULL: no calibration is in it.
// The user's own has two bytes in front that say that it is there.
static const uint8_t *find_calibration(const uint8_t *bytes, size_t len, bool *users) {
    enum { DATA = 20, MAGIC = 2 };
    if (len < DATA + CALIBRATION || bytes[0] != ANSWER || bytes[14] != READ_FLASH)
        return NULL;
    uint32_t at = ap_u32le(bytes + 15);
    *users = at == USERS_AT;
    if (at == CALIBRATION_AT && bytes[19] >= CALIBRATION)
        return bytes + DATA;
    if (at == USERS_AT && bytes[19] >= MAGIC + CALIBRATION && len >= DATA + MAGIC + CALIBRATION &&
        bytes[DATA] == 0xb2 && bytes[DATA + 1] == 0xa1)
        return bytes + DATA + MAGIC;
    return NULL;
}

bool ap_joycon_read_calibration(const uint8_t *bytes, size_t len,
                                struct ap_joycon_calibration *calibration) {
    struct ap_joycon_calibration c;
    // Offsets and scales of the forces, then of the rates.
    const uint8_t *b = find_calibration(bytes, len, &c.is_users);
    if (!b || (calibration->is_users && !c.is_users))
        return false;
    for (int k = 0; k < 3; k++) {
        double accel = ap_i16le(b + 6 + 2 * k) - ap_i16le(b + 2 * k);
        double bias = ap_i16le(b + 12 + 2 * k), gyro = ap_i16le(b + 18 + 2 * k) - bias;
        if (!(accel > 0 && gyro > 0))
            return false;
        c.accel_scale[k] = 4 * GRAVITY / accel;
        c.gyro_bias[k] = bias;
        c.gyro_scale[k] = 936 * DEGREE / gyro;
    }
    *calibration = c;
    return true;
}
