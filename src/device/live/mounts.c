#include "src/device/live/mounts.h"

#include <stdlib.h>

#include "src/device/calibration/store.h"

enum ap_status ap_live_mounts_read(struct ap_error *err, const char *dir,
                                   struct ap_live_mounts *out) {
    *out = (struct ap_live_mounts){
        .kept = calloc(AP_CALIBRATED_MAX, sizeof(struct ap_device_calibration)),
        .mounts = calloc(AP_CALIBRATED_MAX, sizeof(struct ap_live_mount))};
    if (!out->kept || !out->mounts)
        return ap_fail(err, AP_ENVIRONMENT, "out of memory");
    enum ap_status st = ap_calibration_list(err, dir, AP_CALIBRATED_MAX, out->kept, &out->count);
    for (int i = 0; !st && i < out->count; i++) {
        const struct ap_device_calibration *c = &out->kept[i];
        out->mounts[i] = (struct ap_live_mount){.serial = c->key};
        if (c->has_mount)
            out->mounts[i].tracker_from_body = c->tracker_from_body;
        if (c->has_bias)
            out->mounts[i].bias = c->rest.bias;
    }
    return st;
}

void ap_live_mounts_finish(struct ap_live_mounts *mounts) {
    free(mounts->kept);
    free(mounts->mounts);
    *mounts = (struct ap_live_mounts){.count = 0};
}
