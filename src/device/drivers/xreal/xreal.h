#ifndef ANTIPODE_DEVICE_DRIVERS_XREAL_H
#define ANTIPODE_DEVICE_DRIVERS_XREAL_H

#include "src/device/hid/driver.h"

// XREAL Air, Air 2, Air 2 Pro, Air 2 Ultra: glasses whose sensor reports a thousand times a second.

enum { AP_XREAL_REPORT = 64, AP_XREAL_COMMAND = 64 };

struct ap_xreal_packet {
    uint64_t device_ns;
    struct ap_vec3 gyr_rad_s, acc_m_s2; // x right, y up, z back
};

// AP_REPORT_IGNORED: an answer to a command, or anything else that is no measurement.
// AP_REPORT_BAD: too short, or a divisor of 0.
enum ap_report_verdict ap_xreal_parse(const uint8_t *bytes, size_t len,
                                      struct ap_xreal_packet *packet);

// What the glasses are told and asked; they answer with the same number.
enum {
    AP_XREAL_CONFIG_LENGTH = 0x14, // the answer: 4 bytes
    AP_XREAL_CONFIG_NEXT = 0x15,   // the next piece of the text
    AP_XREAL_STREAM = 0x19,        // one byte: on, off
};

// A command with `len` bytes of payload, at most 8.
void ap_xreal_command(uint8_t bytes[AP_XREAL_COMMAND], uint8_t command, const uint8_t *payload,
                      size_t len);

struct ap_xreal_answer {
    uint8_t command;
    const uint8_t *payload; // into the report
    size_t len;
};

// False: the report is no answer, or says that it is longer than it is.
bool ap_xreal_parse_answer(const uint8_t *bytes, size_t len, struct ap_xreal_answer *answer);

extern const struct ap_driver ap_driver_xreal;

#endif
