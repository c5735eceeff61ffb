#ifndef ANTIPODE_DEVICE_LOG_POSELOG_FORMAT_H
#define ANTIPODE_DEVICE_LOG_POSELOG_FORMAT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "src/base/status.h"
#include "src/geom/pose.h"

// The text formats of pose logs: pure functions from one line to one row. What a line needs from
// the lines before it (a header) stands in a struct of its own; order in time is poselog.c's.

enum {
    AP_LOG_COLUMNS_MAX = 256,
    AP_LOG_DEVICE_NAME_MAX = 64, // with the NUL
};

// A piece of a line, without the blanks around it.
struct ap_field {
    const char *text;
    size_t len;
};

// What a line says, in the log's own axes; the quaternion is unit.
struct ap_row {
    int64_t t_ns;
    struct ap_field device; // empty: the format has no device column
    struct ap_pose pose;
    float trigger, squeeze;
    bool select, reset;
    size_t t_column, device_column; // 1-based bytes, for messages about what only the log knows
};

// Why a line is bad: "FILE:LINE:column: expected …".
struct ap_bad_line {
    size_t column;
    char expected[192];
};

enum ap_log_format {
    AP_LOG_UNKNOWN,
    AP_LOG_CSV,
    AP_LOG_NAMED, // poselog_named.h
    AP_LOG_TUM,
    AP_LOG_EUROC,
    AP_LOG_IMU, // poselog_imu.h
    AP_LOG_HID,
    AP_LOG_DOCUMENT, // poselog_document.h; no lines
};

// Blank, or a '#' comment.
bool ap_log_line_is_empty(const char *line, size_t len);

// By the first line that is neither. AP_LOG_CSV, AP_LOG_NAMED: that line is the header.
enum ap_log_format ap_log_format_of(const char *line, size_t len);

// Where the columns of our own CSV stand.
struct ap_csv_columns {
    size_t count;
    uint8_t role[AP_LOG_COLUMNS_MAX];         // enum csv_role
    struct ap_field name[AP_LOG_COLUMNS_MAX]; // pieces of the header line, which must stay
};

bool ap_csv_parse_header(const char *line, size_t len, struct ap_csv_columns *columns,
                         struct ap_bad_line *bad);

// `fields` (columns->count of them) are the row's, for the columns that are only kept by name.
bool ap_csv_parse(const char *line, size_t len, const struct ap_csv_columns *columns,
                  struct ap_field *fields, struct ap_row *row, struct ap_bad_line *bad);

bool ap_tum_parse(const char *line, size_t len, struct ap_row *row, struct ap_bad_line *bad);
bool ap_euroc_parse(const char *line, size_t len, struct ap_row *row, struct ap_bad_line *bad);

// 1 to 63 bytes without blanks, commas, quotes and control characters.
bool ap_log_device_name_ok(struct ap_field name);

// False, with the place and the sentence in *bad.
bool ap_bad_line_at(struct ap_bad_line *bad, const char *line, const char *at, const char *format,
                    ...) AP_PRINTF(4, 5);

#endif
