#include "src/app/play/comfort.h"

#include <math.h>

enum { SIDE_PX = 256, STEPS = 32 };

// A square of 2 m, 0.2 m before the nose: 79° to each side. The vignette is clear within 25° and
// closed beyond 40°.
static const double width_m = 2, ahead_m = 0.2, clear_tangent = 0.466, closed_tangent = 0.839;

enum ap_status ap_comfort_create(struct ap_error *err, struct ap_xr *xr, const struct ap_gpu *gpu,
                                 struct ap_comfort *comfort) {
    *comfort = (struct ap_comfort){.shown_fade = -1};
    return ap_play_panel_create(err, xr, gpu, SIDE_PX, SIDE_PX, &comfort->panel);
}

void ap_comfort_destroy(struct ap_comfort *comfort) {
    ap_play_panel_destroy(&comfort->panel);
}

static void paint(struct ap_canvas *canvas, double fade, double vignette) {
    double per_px = width_m / SIDE_PX / ahead_m;
    for (uint32_t y = 0; y < SIDE_PX; y++)
        for (uint32_t x = 0; x < SIDE_PX; x++) {
            double tangent = per_px * hypot(x + 0.5 - SIDE_PX / 2.0, y + 0.5 - SIDE_PX / 2.0);
            double ring = (tangent - clear_tangent) / (closed_tangent - clear_tangent);
            ring = fmin(fmax(ring, 0), 1) * vignette;
            uint8_t *p = canvas->rgba + 4 * ((size_t)y * SIDE_PX + x);
            p[0] = p[1] = p[2] = 0;
            p[3] = (uint8_t)(255 * (1 - (1 - fade) * (1 - ring)) + 0.5);
        }
}

enum ap_status ap_comfort_step(struct ap_error *err, struct ap_comfort *comfort, double fade,
                               double vignette) {
    int f = (int)(fmin(fmax(fade, 0), 1) * STEPS + 0.5);
    int v = (int)(fmin(fmax(vignette, 0), 1) * STEPS + 0.5);
    bool shown = f > 0 || v > 0;
    enum ap_status st = AP_OK;
    if (shown && (f != comfort->shown_fade || v != comfort->shown_vignette)) {
        paint(&comfort->panel.canvas, (double)f / STEPS, (double)v / STEPS);
        st = ap_play_panel_show(err, &comfort->panel);
        comfort->shown_fade = f;
        comfort->shown_vignette = v;
    }
    const struct ap_xr_panel_place place = {.shown = shown,
                                            .in_view = true,
                                            .pose = {{0, 0, -ahead_m}, {0, 0, 0, 1}},
                                            .width_m = width_m,
                                            .blended = true};
    ap_xr_panel_set(comfort->panel.quad, &place);
    return st;
}
