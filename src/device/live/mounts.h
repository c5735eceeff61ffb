#ifndef ANTIPODE_DEVICE_LIVE_MOUNTS_H
#define ANTIPODE_DEVICE_LIVE_MOUNTS_H

#include "src/device/live/live.h"

// What calibration has kept in a folder (src/device/calibration/store.h), for ap_live_params.
struct ap_live_mounts {
    struct ap_device_calibration *kept; // what the mounts point into
    struct ap_live_mount *mounts;
    int count;
};

// A folder that is not there holds none. AP_INPUT where a file is wrong; finish in any case.
enum ap_status ap_live_mounts_read(struct ap_error *err, const char *dir,
                                   struct ap_live_mounts *out);
void ap_live_mounts_finish(struct ap_live_mounts *mounts);

#endif
