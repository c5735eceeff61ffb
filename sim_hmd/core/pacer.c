#include "sim_hmd/core/pacer.h"

#include <math.h>

#include "sim_hmd/core/hot.h"
#include "src/device/timeline.h"

void sim_pacer_init(struct sim_pacer *pacer, enum sim_clock clock, double refresh_hz,
                    int64_t epoch_ns) {
    *pacer = (struct sim_pacer){
        .clock = clock, .refresh_hz = refresh_hz, .epoch_ns = epoch_ns, .grid = -1};
}

void sim_pacer_set_rate(struct sim_pacer *pacer, double refresh_hz) {
    pacer->refresh_hz = refresh_hz;
    if (!pacer->count)
        return;
    pacer->first_ns = pacer->last_ns;
    pacer->base = pacer->count - 1;
    pacer->grid = 0;
}

SIM_HOT int64_t sim_pacer_now(const struct sim_pacer *pacer, int64_t machine_ns) {
    if (pacer->clock == SIM_CLOCK_VIRTUAL)
        return pacer->last_ns ? pacer->last_ns : SIM_FIRST_TIME_NS;
    return machine_ns - pacer->epoch_ns + SIM_FIRST_TIME_NS;
}

SIM_HOT int64_t sim_pacer_ahead(const struct sim_pacer *pacer, int ahead) {
    int64_t place =
        pacer->clock == SIM_CLOCK_VIRTUAL ? pacer->count - 1 - pacer->base : pacer->grid;
    return ap_frame_time_ns(pacer->first_ns, place + ahead, pacer->refresh_hz);
}

// The first frame on the grid that is shown after `now`, and after the last one.
SIM_HOT static int64_t next_on_grid(const struct sim_pacer *pacer, int64_t now_ns) {
    int64_t next = pacer->grid + 1;
    int64_t k = (int64_t)floor((double)(now_ns - pacer->first_ns) * pacer->refresh_hz * 1e-9);
    return k > next ? k : next;
}

SIM_HOT struct sim_prediction sim_pacer_next(struct sim_pacer *pacer, int64_t machine_ns) {
    int64_t period = (int64_t)llround(1e9 / pacer->refresh_hz);
    struct sim_prediction p = {
        .index = pacer->count++, .period_ns = period, .wake_machine_ns = INT64_MIN};
    if (pacer->clock == SIM_CLOCK_VIRTUAL) {
        if (!pacer->first_ns)
            pacer->first_ns = SIM_FIRST_TIME_NS;
        p.display_ns = ap_frame_time_ns(pacer->first_ns, p.index - pacer->base, pacer->refresh_hz);
    } else {
        int64_t now = sim_pacer_now(pacer, machine_ns);
        if (!pacer->first_ns)
            pacer->first_ns = now + period;
        int64_t before = pacer->grid;
        pacer->grid = next_on_grid(pacer, now);
        p.display_ns = ap_frame_time_ns(pacer->first_ns, pacer->grid, pacer->refresh_hz);
        while (p.display_ns <= now)
            p.display_ns = ap_frame_time_ns(pacer->first_ns, ++pacer->grid, pacer->refresh_hz);
        p.missed = pacer->grid - before - 1;
        p.wake_machine_ns = p.display_ns - period - SIM_FIRST_TIME_NS + pacer->epoch_ns;
    }
    pacer->last_ns = p.display_ns;
    return p;
}
