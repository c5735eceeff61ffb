#ifndef ANTIPODE_DEVICE_LOG_HANDLOG_FORMAT_H
#define ANTIPODE_DEVICE_LOG_HANDLOG_FORMAT_H

#include "src/device/handlog.h"
#include "src/device/log/line_reader.h"

// What the readers of the formats share.

// Appends. AP_INPUT, without a place, where the time is not after the hand's last one.
enum ap_status ap_handlog_add(struct ap_error *err, struct ap_handlog *log, int hand, int64_t t_ns,
                              const struct ap_hand *frame);

enum ap_status ap_handlog_read_csv(struct ap_error *err, struct ap_line_reader *reader,
                                   struct ap_handlog *log);
enum ap_status ap_handlog_read_iwer(struct ap_error *err, struct ap_line_reader *reader,
                                    struct ap_handlog *log);

#endif
