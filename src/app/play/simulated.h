#ifndef ANTIPODE_APP_PLAY_SIMULATED_H
#define ANTIPODE_APP_PLAY_SIMULATED_H

#include <stdbool.h>

#include "src/app/live_options.h"
#include "src/base/status.h"

// The simulated headset as `antipode play` wants it: at the desk, or replaying logs in real time.
struct ap_play_simulated {
    const char *headset; // NULL: "desktop" at a desk, "ci" where Vulkan is software, standard
    const char *layout;  // of the window: "left", "pair", "cross", "anaglyph"
    bool window;         // false: poses from the scripted walk, nothing is shown
    bool virtual_clock;  // every frame of the log or script is drawn, however long it takes
    double walk_s;       // how long the scripted walk is; NAN: its default
    char *const *logs, *const *inputs; // pose logs instead of the keys; input logs
    int log_count, input_count;
    const struct ap_live_options *live; // poses from devices; NULL: not
    bool stats;                         // they say at the end how old poses were
};

// Writes the runtime's settings to a temporary file, whose path it gives, and makes the simulated
// headset the loader's runtime. The file can go once the session is open; it is removed on failure.
// Call it before other threads start.
enum ap_status ap_play_simulate(struct ap_error *err, const struct ap_play_simulated *how,
                                char path[64]);

#endif
