#ifndef ANTIPODE_APP_CALIBRATE_H
#define ANTIPODE_APP_CALIBRATE_H

#include "src/app/live_options.h"
#include "src/app/room_file.h"

// What the parts of `antipode calibrate` share.
struct ap_calibrate_options {
    struct ap_live_options live;
    const char *only;  // the device's serial; NULL: whatever is there
    const char *out;   // of the room; NULL: in the user's folder
    const char *tip;   // "X,Y,Z"
    double seconds;    // at most; NAN: 60
    double table_edge; // NAN: not known
    double poses;      // of the accelerometer; NAN: 1
    double corners;    // NAN: 3
};

enum ap_status ap_calibrate_rest(struct ap_error *err, const struct ap_calibrate_options *o);
enum ap_status ap_calibrate_mount(struct ap_error *err, const struct ap_calibrate_options *o);
// From logs, or (log_count 0) from devices.
enum ap_status ap_calibrate_table(struct ap_error *err, const struct ap_calibrate_options *o,
                                  char *const *logs, int log_count);

#endif
