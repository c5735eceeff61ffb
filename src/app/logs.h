#ifndef ANTIPODE_APP_LOGS_H
#define ANTIPODE_APP_LOGS_H

#include "src/app/command.h"
#include "src/device/poselog.h"

// How a command's pose logs are to be read: options that `track`, `replay` and others share.
struct ap_log_options {
    const char *table_at; // NULL: not given
    const char *room;     // a file of `antipode calibrate table`; NULL: none
    const char *up, *head_frame;
    bool skip_bad;
};

#define AP_LOG_OPTIONS_NONE ((struct ap_log_options){.up = "y", .head_frame = "head"})

// The options' table entries.
#define AP_LOG_OPTION_TABLE(o)                                                                     \
    {"table-at", AP_OPTION_TEXT, &(o).table_at, "X,Z,YAW",                                         \
     "where the table stands in the log's room"},                                                  \
        {"room", AP_OPTION_TEXT, &(o).room, "FILE",                                                \
         "table's place, height and edge as calibrated"},                                          \
        {"up", AP_OPTION_CHOICE, &(o).up, "y|z", "which way is up in the log"},                    \
        {"head-frame", AP_OPTION_CHOICE, &(o).head_frame, "head|optical",                          \
         "axes of the log's head"},                                                                \
    {                                                                                              \
        "skip-bad", AP_OPTION_FLAG, &(o).skip_bad, "", "drop and count bad lines"                  \
    }

// What a command's help says of its operands; a piece of a string.
#define AP_LOG_HELP                                                                                       \
    "LOG is [head=|left=|right=|NAME=]FILE[,KEY=VALUE...], '-' for standard input. FILE is told by its\n" \
    "content: the program's own CSV, CSV with NAME_pos_x columns, TUM, EuRoC (poses or imu0), raw HID\n"  \
    "recordings, BSOR, the JSON of IWER and A-Frame; packed by gzip or zstd or not. KEY: offset (s),\n"   \
    "time-scale, scale (m), axes (as xz-y), hand, up, frame, invert (docs/pose-logs.md)."

// logs must outlive the log.
enum ap_status ap_logs_open(struct ap_error *err, const struct ap_log_options *options,
                            char *const *logs, int count, struct ap_poselog **log);

// Says, once at the end, how many bad lines were dropped.
void ap_logs_warn_skipped(const struct ap_poselog *log);

#endif
