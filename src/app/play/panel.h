#ifndef ANTIPODE_APP_PLAY_PANEL_H
#define ANTIPODE_APP_PLAY_PANEL_H

#include "src/gpu/gpu.h"
#include "src/image/text.h"
#include "xr/client.h"

// A picture made here, shown by the runtime: a canvas, its way to the GPU, and the quad layer.
struct ap_play_panel {
    const struct ap_gpu *gpu;
    struct ap_xr_panel *quad;
    struct ap_canvas canvas; // draw here, then ap_play_panel_show
    struct ap_gpu_buffer staging;
    bool bgra;
};

// Borrows both. Destroy accepts a zeroed one.
enum ap_status ap_play_panel_create(struct ap_error *err, struct ap_xr *xr,
                                    const struct ap_gpu *gpu, uint32_t width_px, uint32_t height_px,
                                    struct ap_play_panel *panel);
void ap_play_panel_destroy(struct ap_play_panel *panel);

// Takes the canvas as it is to the quad; waits for the GPU.
enum ap_status ap_play_panel_show(struct ap_error *err, struct ap_play_panel *panel);

#endif
