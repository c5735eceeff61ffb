#ifndef ANTIPODE_DEVICE_HID_REPORT_LOG_H
#define ANTIPODE_DEVICE_HID_REPORT_LOG_H

#include "src/device/axes.h"
#include "src/device/log/poselog_format.h"

// A raw HID recording as a pose log: its lines go in, rows come out. Each device of the recording
// gets the driver that knows it; what has none is passed over.
struct ap_report_log;

enum { AP_REPORT_LOG_DEVICES_MAX = 64 };

// NULL where there is no memory.
struct ap_report_log *ap_report_log_create(void);
void ap_report_log_destroy(struct ap_report_log *log);

// The role that the log's only tracker is given, before the first line: it decides which part of
// the body carries it. Empty: trackers get the names head, left, right, tracker4, … in the order in
// which their devices introduce them. Orientations are in these axes, and with `invert` those of
// the room in the tracker.
void ap_report_log_set_role(struct ap_report_log *log, struct ap_field role,
                            const struct ap_axes *axes, bool invert);

// One line, comments too. False: a bad line, which is as if it were not there.
bool ap_report_log_feed(struct ap_report_log *log, const char *line, size_t len,
                        struct ap_bad_line *bad);

// The next row of the lines so far; its device's name stays as long as the log.
bool ap_report_log_take(struct ap_report_log *log, struct ap_row *row);

// AP_INPUT where there were reports, but no driver for any of their devices, or no report at all.
enum ap_status ap_report_log_check_end(struct ap_error *err, const struct ap_report_log *log,
                                       const char *file);

#endif
