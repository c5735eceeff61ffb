#include "src/device/drivers/xreal/xreal.h"

#include <string.h>

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

// Head, check sum, length (of itself, the command and the payload), command, payload.
enum { HEAD = 0xaa, LENGTH = 5, COMMAND = 7, PAYLOAD = 8, LENGTH_OF_NONE = PAYLOAD - LENGTH };

void ap_xreal_command(uint8_t bytes[AP_XREAL_COMMAND], uint8_t command, const uint8_t *payload,
                      size_t len) {
    memset(bytes, 0, AP_XREAL_COMMAND);
    bytes[0] = HEAD;
    bytes[LENGTH] = (uint8_t)(LENGTH_OF_NONE + len);
    bytes[COMMAND] = command;
    for (size_t i = 0; i < len; i++)
        bytes[PAYLOAD + i] = payload[i];
    uint32_t crc = ap_crc32(0, bytes + LENGTH, LENGTH_OF_NONE + len);
    for (int i = 0; i < 4; i++)
        bytes[1 + i] = (uint8_t)(crc >> 8 * i);
}

bool ap_xreal_parse_answer(const uint8_t *bytes, size_t len, struct ap_xreal_answer *answer) {
    if (len < PAYLOAD || bytes[0] != HEAD)
        return false;
    size_t length = ap_u16le(bytes + LENGTH);
    if (length < LENGTH_OF_NONE || LENGTH + length > len)
        return false;
    *answer = (struct ap_xreal_answer){bytes[COMMAND], bytes + PAYLOAD, length - LENGTH_OF_NONE};
    return true;
}
