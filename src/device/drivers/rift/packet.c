#include "src/device/drivers/bytes.h"
#include "src/device/drivers/rift/rift.h"

struct ap_vec3 ap_rift_triple(const uint8_t b[8]) {
    uint64_t bits = 0;
    for (int i = 0; i < 8; i++)
        bits = bits << 8 | b[i];
    double v[3];
    for (int i = 0; i < 3; i++) {
        int64_t raw = (int64_t)(bits >> (43 - 21 * i) & 0x1fffff);
        v[i] = 1e-4 * (double)(raw < 0x100000 ? raw : raw - 0x200000);
    }
    return (struct ap_vec3){v[0], v[1], v[2]};
}

enum ap_report_verdict ap_rift_parse(const struct ap_rift_layout *layout, const uint8_t *bytes,
                                     size_t len, struct ap_rift_packet *packet) {
    if (len < 1 || bytes[0] != layout->report)
        return len < 1 ? AP_REPORT_BAD : AP_REPORT_IGNORED;
    if (len < layout->len || bytes[layout->count] == 0)
        return AP_REPORT_BAD;
    // Of more than fit, the device has left the older ones out.
    int count = bytes[layout->count] < layout->most ? bytes[layout->count] : layout->most;
    uint32_t newest =
        layout->imu.bits == 16 ? ap_u16le(bytes + layout->ticks) : ap_u32le(bytes + layout->ticks);
    packet->count = count;
    for (int i = 0; i < count; i++) {
        const uint8_t *b = bytes + layout->measurements + 16 * i;
        packet->at[i] =
            (struct ap_imu_reading){.ticks = newest - layout->step * (uint32_t)(count - 1 - i),
                                    .acc_m_s2 = ap_rift_triple(b),
                                    .gyr_rad_s = ap_rift_triple(b + 8)};
    }
    return AP_REPORT_OK;
}
