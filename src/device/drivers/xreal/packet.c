#include "src/device/drivers/xreal/xreal.h"

#include "src/device/drivers/bytes.h"
#include "src/device/drivers/fused.h"

static const double DEGREE = 3.14159265358979323846 / 180, GRAVITY = 9.80665;

static double i24le(const uint8_t *b) {
    int32_t v = b[0] | b[1] << 8 | b[2] << 16;
    return v < 0x800000 ? v : v - 0x1000000;
}

// Multiplier, divisor, and three numbers a little behind them; the sensor's x goes left, its y back
// and its z up.
static bool read_triple(const uint8_t *b, double unit, struct ap_vec3 *v) {
    uint32_t divisor = ap_u32le(b + 2);
    if (divisor == 0)
        return false;
    double scale = unit * ap_u16le(b) / divisor;
    *v = (struct ap_vec3){-scale * i24le(b + 6), scale * i24le(b + 12), scale * i24le(b + 9)};
    return true;
}

enum ap_report_verdict ap_xreal_parse(const uint8_t *bytes, size_t len,
                                      struct ap_xreal_packet *packet) {
    if (len < 2)
        return AP_REPORT_BAD;
    if (bytes[0] != 1 || bytes[1] != 2)
        return AP_REPORT_IGNORED;
    if (len < AP_XREAL_REPORT)
        return AP_REPORT_BAD;
    packet->device_ns = ap_u32le(bytes + 4) | (uint64_t)ap_u32le(bytes + 8) << 32;
    return read_triple(bytes + 12, DEGREE, &packet->gyr_rad_s) &&
                   read_triple(bytes + 27, GRAVITY, &packet->acc_m_s2)
               ? AP_REPORT_OK
               : AP_REPORT_BAD;
}

void ap_xreal_command(uint8_t bytes[AP_XREAL_COMMAND], uint8_t command, uint8_t payload) {
    for (int i = 0; i < AP_XREAL_COMMAND; i++)
        bytes[i] = 0;
    bytes[0] = 0xaa;
    bytes[5] = 4; // the length: of itself, the command and the payload
    bytes[7] = command;
    bytes[8] = payload;
    uint32_t crc = ap_crc32(0, bytes + 5, 4);
    for (int i = 0; i < 4; i++)
        bytes[1 + i] = (uint8_t)(crc >> 8 * i);
}
