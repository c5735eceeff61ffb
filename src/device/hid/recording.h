#ifndef ANTIPODE_DEVICE_HID_RECORDING_H
#define ANTIPODE_DEVICE_HID_RECORDING_H

#include "src/device/hid/descriptor.h"
#include "src/device/log/poselog_format.h"

// Raw HID recordings: hid-recorder's text, line by line, and our comments with feature reports.
// Grammar: docs/pose-logs.md.

enum ap_hid_line_kind {
    AP_HID_LINE_NOTHING,    // a comment, a blank line, a letter that says nothing to us
    AP_HID_LINE_DEVICE,     // D: which device the lines from here on are of
    AP_HID_LINE_DESCRIPTOR, // R:
    AP_HID_LINE_NAME,       // N:
    AP_HID_LINE_IDS,        // I:
    AP_HID_LINE_REPORT,     // E:
    AP_HID_LINE_FEATURE,    // # F:
};

struct ap_hid_line {
    enum ap_hid_line_kind kind;
    int64_t device;                // AP_HID_LINE_DEVICE
    struct ap_field text;          // AP_HID_LINE_NAME
    uint16_t bus, vendor, product; // AP_HID_LINE_IDS
    int64_t t_ns;                  // AP_HID_LINE_REPORT
    size_t t_column, bytes_column; // 1-based
    size_t byte_count;             // of a descriptor or a report
    uint8_t bytes[AP_HID_REPORT_MAX];
};

// Whether a comment line is one of ours, "# F: …".
bool ap_hid_line_is_feature(const char *line, size_t len);

// False, with the place and the sentence in *bad, where the line is none that a recorder writes:
// numbers that are none, sizes that are not the number of bytes.
bool ap_hid_parse_line(const char *line, size_t len, struct ap_hid_line *out,
                       struct ap_bad_line *bad);

#endif
