#ifndef ANTIPODE_SIM_HMD_WINDOW_WINDOW_H
#define ANTIPODE_SIM_HMD_WINDOW_WINDOW_H

#include <stdbool.h>
#include <stdint.h>

#include "sim_hmd/window/input.h"
#include "src/base/status.h"

// The runtime's end of the window: a program of its own (antipode-sim-window), fed by memory that
// both share, so that nothing calls a window system inside somebody else's program. It leaves when
// this process does. Keys: docs/capture-composition.md.
struct sim_window;

enum sim_window_layout {
    SIM_WINDOW_PAIR,
    SIM_WINDOW_CROSS,
    SIM_WINDOW_ANAGLYPH,
    SIM_WINDOW_LEFT,
    SIM_WINDOW_LAYOUT_COUNT
};

struct sim_window_params {
    const char *program; // NULL: found beside the runtime library, or in ../libexec/antipode
    const char *title;   // NULL: "antipode"
    uint32_t width_px, height_px;  // of the pictures, both eyes side by side; 1…4096
    uint32_t split_px;             // where the right eye's part begins; 0: there is one eye only
    enum sim_window_layout layout; // at first; F2 takes the next, where there are two eyes
};

// Starts the program. AP_ENVIRONMENT where it is not there or does not start; whether it can open a
// window (no display…) shows later, as sim_window_alive turning false.
enum ap_status sim_window_open(struct ap_error *err, const struct sim_window_params *params,
                               struct sim_window **window);

// False once the window is gone; warns, once, if it never opened. One thread at a time.
bool sim_window_alive(struct sim_window *window);

// A picture of width_px·height_px R,G,B,A bytes (sRGB, alpha ignored); older frames than the last
// one shown are dropped. Any thread; never waits for the window.
void sim_window_show(struct sim_window *window, int64_t frame, const void *rgba);

// Keyboard and mouse as they are now. closed stays true when the window is gone, unless it never
// opened. One thread at a time.
void sim_window_input(struct sim_window *window, struct sim_window_input *input);

// Ends the program. Accepts NULL.
void sim_window_close(struct sim_window *window);

#endif
