#ifndef ANTIPODE_DEVICE_LOG_POSELOG_SOURCE_H
#define ANTIPODE_DEVICE_LOG_POSELOG_SOURCE_H

#include "src/device/log/line_reader.h"
#include "src/device/hid/report_log.h"
#include "src/device/log/poselog_argument.h"
#include "src/device/log/poselog_imu.h"
#include "src/device/log/poselog_named.h"
#include "src/device/log/row_table.h"

// AP_LOG_NAMED: the rows of a line, of which `given` have been given.
struct ap_log_named {
    struct ap_named_columns columns;
    struct ap_row rows[AP_NAMED_DEVICES_MAX];
    int count, given;
};

// One file of a pose log: its role and options, its format, and the row at its front.
struct ap_log_source {
    struct ap_line_reader reader;
    struct ap_log_argument argument;
    enum ap_log_format format;
    bool skip_bad;
    int64_t skipped;

    struct ap_csv_columns columns; // AP_LOG_CSV
    char *header;                  // what their names point into
    struct ap_field fields[AP_LOG_COLUMNS_MAX];
    char only_device[AP_LOG_DEVICE_NAME_MAX]; // with a role: the one name the file may hold

    // AP_LOG_HID, and as long as the format is not known: feature reports stand before what tells
    // it.
    struct ap_report_log *reports;
    int64_t early_bad_line; // of those; 0: none
    struct ap_bad_line early_bad;

    struct ap_log_imu *imu;        // AP_LOG_IMU
    struct ap_log_named *named;    // AP_LOG_NAMED
    struct ap_row_table *document; // AP_LOG_DOCUMENT: the rows that are left of it
    int64_t frame;                 // of the document, for messages

    bool has_row, at_end;
    struct ap_row row; // its pieces stay until ap_log_source_advance
    int64_t last_t_ns; // of the lines before it, as the file has them
};

// Opens `argument` = "[ROLE=]FILE[,KEY=VALUE…]" and finds out its format, for which it reads (and,
// on a pipe, waits for) the first line that says something. Finish it in any case. AP_INPUT,
// AP_ENVIRONMENT; AP_USAGE where the argument is none.
enum ap_status ap_log_source_open(struct ap_error *err, struct ap_log_source *source,
                                  const char *argument, bool skip_bad);
void ap_log_source_finish(struct ap_log_source *source);

// The next row into source->row, or at_end.
enum ap_status ap_log_source_advance(struct ap_error *err, struct ap_log_source *source);

// The row is bad: counts and drops it with skip_bad, else fails.
enum ap_status ap_log_source_reject(struct ap_error *err, struct ap_log_source *source,
                                    const struct ap_bad_line *bad);

// The device the row is of.
struct ap_field ap_log_source_device(const struct ap_log_source *source);

#endif
