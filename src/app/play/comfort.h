#ifndef ANTIPODE_APP_PLAY_COMFORT_H
#define ANTIPODE_APP_PLAY_COMFORT_H

#include "src/app/play/panel.h"

// Darkness for a teleport and a vignette while flying: a blended quad before the eyes, which is
// there only while it is needed, so that the renderer knows nothing of it.
struct ap_comfort {
    struct ap_play_panel panel;
    int shown_fade, shown_vignette; // in steps of 1/32
};

enum ap_status ap_comfort_create(struct ap_error *err, struct ap_xr *xr, const struct ap_gpu *gpu,
                                 struct ap_comfort *comfort);
void ap_comfort_destroy(struct ap_comfort *comfort);

// 0…1 each; redrawn only when they change.
enum ap_status ap_comfort_step(struct ap_error *err, struct ap_comfort *comfort, double fade,
                               double vignette);

#endif
