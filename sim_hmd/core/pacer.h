#ifndef ANTIPODE_SIM_HMD_CORE_PACER_H
#define ANTIPODE_SIM_HMD_CORE_PACER_H

#include <stdint.h>

#include "sim_hmd/core/settings.h"

// When frames are shown. XrTime and machine time are nanoseconds. On the virtual clock frame k is
// shown at 1e9 + round(k·1e9/Hz), whatever the machine's clock says. On the real clock XrTime is
// the machine's monotonic time less what it was when the instance was made, plus 1e9; frames stand
// on a grid of the headset's period from the session's first one, and a program that is late skips
// some. A change of the rate starts both anew at the last frame.

enum { SIM_FIRST_TIME_NS = 1000000000 };

struct sim_pacer {
    enum sim_clock clock;
    double refresh_hz;
    int64_t epoch_ns; // the machine's time at XrTime 1e9 (real clock)
    int64_t first_ns; // XrTime of place 0 of the grid, 0 before the first frame
    int64_t base;     // virtual clock: the frame that is shown at place 0
    int64_t count;    // frames predicted so far
    int64_t grid;     // the last frame's number on the grid
    int64_t last_ns;  // XrTime of the last predicted frame, 0 before the first
};

struct sim_prediction {
    int64_t index;      // frames since the session began
    int64_t display_ns; // XrTime
    int64_t period_ns;
    int64_t wake_machine_ns;     // when the program may start; INT64_MIN: at once
    int64_t waited_ns, begun_ns; // XrTime at which the calls returned; the frame loop's
    int64_t missed;              // places of the grid passed over since the frame before
};

void sim_pacer_init(struct sim_pacer *pacer, enum sim_clock clock, double refresh_hz,
                    int64_t epoch_ns);

// The frames after the last predicted one stand on a new grid from it.
void sim_pacer_set_rate(struct sim_pacer *pacer, double refresh_hz);

// XrTime at the machine's time; on the virtual clock the last predicted frame's.
int64_t sim_pacer_now(const struct sim_pacer *pacer, int64_t machine_ns);

// When the frame will be shown that comes `ahead` frames after the last predicted one, if none is
// missed on the way and the rate stays.
int64_t sim_pacer_ahead(const struct sim_pacer *pacer, int ahead);

// The next frame. Pure but for the pacer's own counters.
struct sim_prediction sim_pacer_next(struct sim_pacer *pacer, int64_t machine_ns);

#endif
