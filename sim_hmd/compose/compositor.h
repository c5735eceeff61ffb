#ifndef ANTIPODE_SIM_HMD_COMPOSE_COMPOSITOR_H
#define ANTIPODE_SIM_HMD_COMPOSE_COMPOSITOR_H

#include "sim_hmd/compose/frame.h"

// What frame.h does not say: counts, for tests and the log.
struct sim_compositor_stats {
    int64_t frames;   // handed over
    int64_t skipped;  // nobody looks: nothing at all was done
    int64_t copied;   // pictures (an eye of a captured frame) that were copied bit for bit
    int64_t composed; // pictures that went through the graphics pass
    int64_t shown;    // frames drawn for the window
};
struct sim_compositor_stats sim_compositor_stats(const struct sim_compositor *compositor);

#endif
