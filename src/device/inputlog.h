#ifndef ANTIPODE_DEVICE_INPUTLOG_H
#define ANTIPODE_DEVICE_INPUTLOG_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "src/base/status.h"
#include "src/device/log/poselog_format.h"

// Input logs: what was pressed, pulled and pushed, by time. Grammar: docs/input-logs.md. A log is a
// set of channels, one for each device and path ("left", "/input/trigger/value"); a channel holds
// its value until its next row. Immutable after loading; any number of threads may read.

enum {
    AP_INPUT_CHANNELS_MAX = 256,
    AP_INPUT_FILES_MAX = 64,
    AP_INPUT_ROWS_MAX = 10000000,
    AP_INPUT_PATH_MAX = 128, // with the NUL
};

struct ap_inputlog;

struct ap_input_channel {
    const char *device; // "left", "right", "head", "gamepad", "treadmill"
    const char *path;   // "/input/trigger/value"
    int values;         // 1, or 2: x and y of a stick or a pad
};

// Reads the files to their ends and merges them by time; where two say something of one channel at
// one time, the later argument does. AP_INPUT: file:line:column and what was expected.
enum ap_status ap_inputlog_load(struct ap_error *err, const char *const *paths, size_t count,
                                struct ap_inputlog **log);
void ap_inputlog_destroy(struct ap_inputlog *log);

int ap_inputlog_channel_count(const struct ap_inputlog *log);
struct ap_input_channel ap_inputlog_channel(const struct ap_inputlog *log, int channel);
int ap_inputlog_find(const struct ap_inputlog *log, const char *device,
                     const char *path); // −1: none

// The newest value at or before t. False before the first one: *value untouched.
bool ap_inputlog_at(const struct ap_inputlog *log, int channel, int64_t t_ns, float value[2]);

// The last row's time.
int64_t ap_inputlog_end_ns(const struct ap_inputlog *log);

// One line that is neither blank, a comment nor the header.
struct ap_input_row {
    int64_t t_ns;
    const char *device;   // a literal
    struct ap_field path; // a piece of the line
    float value[2];
    int values;
};
bool ap_inputlog_parse(const char *line, size_t len, struct ap_input_row *row,
                       struct ap_bad_line *bad);

#endif
