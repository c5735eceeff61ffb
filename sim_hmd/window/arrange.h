#ifndef ANTIPODE_SIM_HMD_WINDOW_ARRANGE_H
#define ANTIPODE_SIM_HMD_WINDOW_ARRANGE_H

#include <stdint.h>

#include "sim_hmd/window/window.h"

// A picture of both eyes side by side, as somebody at a screen wants to look at it. Pure.
struct sim_pair {
    const uint8_t *rgba; // 4·width·height
    uint32_t width_px, height_px;
    uint32_t split_px; // the right eye's part begins here; 0: one eye only, nothing is arranged
};

// Into `out`, which has room for the whole picture: what is left of it is the return values. Cross
// exchanges the eyes. The anaglyph has the left eye's luminance in red and the right one's green
// and blue; where the two parts differ in width it is as wide as the narrower.
void sim_arrange(const struct sim_pair *pair, enum sim_window_layout layout, uint8_t *out,
                 uint32_t *width_px, uint32_t *height_px);

#endif
