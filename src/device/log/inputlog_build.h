#ifndef ANTIPODE_DEVICE_LOG_INPUTLOG_BUILD_H
#define ANTIPODE_DEVICE_LOG_INPUTLOG_BUILD_H

#include "src/device/inputlog.h"
#include "src/device/log/line_reader.h"

// What the readers of the formats share.

// One more value of a channel, made where it is new; one that changes nothing is left out. Times
// must not decrease. AP_INPUT, without a place, beyond the limits.
enum ap_status ap_inputlog_add(struct ap_error *err, struct ap_inputlog *log,
                               const struct ap_input_row *row);

enum ap_status ap_inputlog_read_iwer(struct ap_error *err, struct ap_line_reader *reader,
                                     struct ap_inputlog *log);

#endif
