#ifndef ANTIPODE_TESTS_DEVICE_HID_BYTES_OF_H
#define ANTIPODE_TESTS_DEVICE_HID_BYTES_OF_H

#include <stddef.h>
#include <stdint.h>

// Hexadecimal text to bytes; what is no digit does not count. At most `max`.
static inline size_t bytes_of(const char *text, size_t len, uint8_t *bytes, size_t max) {
    size_t digits = 0;
    for (size_t i = 0; i < len && digits < 2 * max; i++) {
        char c = text[i];
        int v = c >= '0' && c <= '9' ? c - '0' : c >= 'a' && c <= 'f' ? c - 'a' + 10 : -1;
        if (v < 0)
            continue;
        uint8_t *byte = &bytes[digits++ / 2];
        *byte = (uint8_t)(digits % 2 ? v << 4 : *byte | v);
    }
    return digits / 2;
}

// A head tracker by Android's protocol: the example of its specification, with other report ids
// and version 2's choice of a transport.
#define ANDROID_DESCRIPTOR                                                                         \
    "05 20 09 e1 a1 01 85 05 0a 08 03 15 00 26 ff 00 75 08 95 19 b1 03 0a 02 03 95 10 b1 03 "      \
    "85 09 0a 16 03 15 00 25 01 75 01 95 01 a1 02 0a 40 08 0a 41 08 b1 00 c0 "                     \
    "0a 19 03 a1 02 0a 55 08 0a 51 08 b1 00 c0 0a 10 f4 a1 02 0a 01 f8 0a 00 f8 b1 00 c0 "         \
    "0a 0e 03 15 00 25 1f 35 0a 45 64 75 05 95 01 66 01 10 55 0d b1 02 85 07 "                     \
    "0a 44 05 16 01 80 26 ff 7f 37 60 4f 46 ed 47 a1 b0 b9 12 55 08 75 10 95 03 81 02 "            \
    "0a 45 05 16 01 80 26 ff 7f 35 e0 45 20 55 00 75 10 95 03 81 02 "                              \
    "0a 46 05 15 00 26 ff 00 35 00 45 00 55 00 75 08 95 01 81 02 c0"

// A cap with split reports, 8 bits a value, the axes in another order, and 12 buttons.
#define CAP_DESCRIPTOR                                                                             \
    "05 01 09 08 a1 01 a1 00 85 01 15 81 25 7f 75 08 95 03 09 31 09 30 09 32 81 06 c0 "            \
    "a1 00 85 02 95 03 09 35 09 34 09 33 81 06 c0 "                                                \
    "a1 02 85 03 05 09 19 01 29 0c 15 00 25 01 75 01 95 0c 81 02 95 04 81 03 c0 c0"

// A relative orientation beside an accelerometer, unit exponent as hubs write it.
#define ORIENTATION_DESCRIPTOR                                                                     \
    "05 20 09 01 a1 01 85 01 09 73 a1 00 0a 53 04 16 01 80 26 ff 7f 55 0d 75 10 95 01 81 02 c0 "   \
    "85 02 09 8a a1 00 0a 83 04 95 04 81 02 c0 "                                                   \
    "85 03 09 8e a1 00 0a 16 03 15 00 25 05 75 08 95 01 a1 02 0a 40 08 0a 41 08 b1 00 c0 "         \
    "05 20 0a 83 04 16 01 80 26 ff 7f 75 10 95 04 81 02 c0 c0"

#endif
