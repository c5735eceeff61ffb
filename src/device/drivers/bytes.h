#ifndef ANTIPODE_DEVICE_DRIVERS_BYTES_H
#define ANTIPODE_DEVICE_DRIVERS_BYTES_H

#include <stdint.h>

// Little-endian numbers of packets; the caller has checked the length.

static inline uint16_t ap_u16le(const uint8_t *b) {
    return (uint16_t)(b[0] | b[1] << 8);
}

static inline int16_t ap_i16le(const uint8_t *b) {
    return (int16_t)ap_u16le(b);
}

static inline uint32_t ap_u32le(const uint8_t *b) {
    return (uint32_t)ap_u16le(b) | (uint32_t)ap_u16le(b + 2) << 16;
}

#endif
