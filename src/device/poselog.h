#ifndef ANTIPODE_DEVICE_POSELOG_H
#define ANTIPODE_DEVICE_POSELOG_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include "src/base/status.h"
#include "src/geom/pose.h"

// Pose logs: one or more files merged by time, read as a stream (memory does not grow with the
// log). Grammar: docs/pose-logs.md. Formats (own CSV, TUM, EuRoC CSV,
// raw HID recordings) are told by content.

// A sample of one device. Poses are in the room, STAGE axes (+y up), metres; left/right are grips.
struct ap_sample {
    int64_t t_ns;
    int device; // index into the log's device names
    struct ap_pose pose;
    float trigger, squeeze; // 0…1; 0 where the log has none
    bool select;
    bool reset; // the device has begun a new reference: nothing leads here from the sample before
};

struct ap_poselog;

enum ap_head_frame { AP_HEAD_FRAME_HEAD, AP_HEAD_FRAME_OPTICAL };

struct ap_poselog_params {
    const char *const *sources; // "[head=|left=|right=|NAME=]FILE", FILE "-" = standard input
    size_t source_count;
    bool z_up;                     // --up z: turn a Z-up world to +y up
    enum ap_head_frame head_frame; // --head-frame optical
    bool skip_bad;                 // drop and count bad lines instead of failing
    bool has_table;                // --table-at: multiply poses by the table frame's inverse
    double table_x_m, table_z_m, table_yaw_rad;
};

// AP_INPUT where a file cannot be read or is of no known format; AP_USAGE for "left=" without a
// file, standard input twice, more than 64 logs. Reads (and, on a pipe, waits for) each log's first
// line. The sources must outlive the log.
enum ap_status ap_poselog_open(struct ap_error *err, const struct ap_poselog_params *params,
                               struct ap_poselog **log);

// The next sample in merged order (stable by time: equal times keep argument order, then file
// order). *got = false at the end. AP_INPUT at a bad line: file:line:column and what was expected.
enum ap_status ap_poselog_next(struct ap_error *err, struct ap_poselog *log,
                               struct ap_sample *sample, bool *got);

// Names seen so far; an index stays valid and keeps its name. "head", "left", "right" or a name.
int ap_poselog_device_count(const struct ap_poselog *log);
const char *ap_poselog_device_name(const struct ap_poselog *log, int device);

// Lines dropped by skip_bad so far.
int64_t ap_poselog_skipped(const struct ap_poselog *log);

// The text of any column, by its name, in the row the newest sample came from; not NUL-terminated,
// valid until the next call of ap_poselog_next. False where that row's file has no such column.
bool ap_poselog_column(const struct ap_poselog *log, const char *name, const char **text,
                       size_t *len);

void ap_poselog_close(struct ap_poselog *log);

// Our own CSV, 17 digits: reading it back gives the same samples bit for bit. Errors stay with the
// stream (ferror, or what closes it).
void ap_poselog_write_header(FILE *stream);
void ap_poselog_write_row(FILE *stream, const char *device, const struct ap_sample *sample);

#endif
