#ifndef ANTIPODE_SIM_HMD_WINDOW_SHARED_H
#define ANTIPODE_SIM_HMD_WINDOW_SHARED_H

#include <stdatomic.h>
#include <stddef.h>
#include <stdint.h>

// The memory that the runtime and its window's program share: this header, then three pictures.
// The runtime fills one (back), the window draws one (front), the third (middle) waits; each side
// swaps its own for the middle one, so neither ever waits for the other nor sees half a picture.
// Both are of one build; version tells where they are not. Neither trusts an index it reads.
enum {
    SIM_WINDOW_VERSION = 3,
    SIM_WINDOW_FRESH = 4, // set in middle when the runtime put it there
    SIM_WINDOW_MAX_SIDE = 4096,
    SIM_WINDOW_MEMORY_FD = 3, // in the window's program
    SIM_WINDOW_LIFE_FD = 4,   // a socket whose other end closes when the other process is gone
};

enum sim_window_state {
    SIM_WINDOW_STARTING,
    SIM_WINDOW_OPEN,
    SIM_WINDOW_FAILED,
    SIM_WINDOW_CLOSED
};

struct sim_window_shared {
    uint32_t version, width_px, height_px, split_px, layout;
    _Atomic uint32_t middle;                 // index 0…2, SIM_WINDOW_FRESH
    _Atomic uint32_t state;                  // enum sim_window_state, by the window
    _Atomic uint32_t keys;                   // enum sim_key bits
    _Atomic uint32_t looks;                  // how often the runtime has looked at them
    _Atomic int64_t mouse_x, mouse_y, wheel; // accumulated, in 1/256 pixel or notch
    char title[128];
    char why[256]; // why it failed; written before state
};

enum { SIM_WINDOW_FIXED_POINT = 256 };

static inline size_t sim_window_picture_bytes(const struct sim_window_shared *shared) {
    return (size_t)shared->width_px * shared->height_px * 4;
}

static inline uint8_t *sim_window_picture(struct sim_window_shared *shared, uint32_t index) {
    return (uint8_t *)(shared + 1) + index % 3 * sim_window_picture_bytes(shared);
}

static inline size_t sim_window_memory_bytes(const struct sim_window_shared *shared) {
    return sizeof *shared + 3 * sim_window_picture_bytes(shared);
}

#endif
