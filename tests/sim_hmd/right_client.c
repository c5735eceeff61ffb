// The project's own OpenXR client for a session, to be looked at by the lint.
#include <stdio.h>

#include "xr/client.h"

static enum ap_status frame(struct ap_error *err, struct ap_xr *xr) {
    struct ap_xr_frame f;
    struct ap_xr_images images;
    enum ap_status st = ap_xr_begin_frame(err, xr, &f);
    if (!st && f.should_render)
        st = ap_xr_acquire(err, xr, &images);
    if (!st)
        st = ap_xr_haptic(err, xr, 1, 0.1, 0.5);
    return st ? st : ap_xr_end_frame(err, xr, &f);
}

int main(void) {
    struct ap_error err = {""};
    struct ap_xr *xr = NULL;
    const struct ap_xr_params params = {.application = "right"};
    enum ap_xr_state state = AP_XR_WAITING;
    enum ap_status st = ap_xr_create(&err, &params, &xr);
    while (!st && state != AP_XR_ENDED && state != AP_XR_LOST) {
        st = ap_xr_poll(&err, xr, &state);
        if (!st && state == AP_XR_RUNNING)
            st = frame(&err, xr);
    }
    ap_xr_destroy(xr);
    if (st)
        fprintf(stderr, "%s\n", err.text);
    return st || state != AP_XR_ENDED;
}
