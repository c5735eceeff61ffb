#include "src/app/live_options.h"

#include <signal.h>

enum ap_status ap_live_options_open(struct ap_error *err, const struct ap_live_options *o,
                                    const struct ap_live_params *base, struct ap_live **live) {
    struct ap_live_params params = *base;
    struct ap_live_bus way;
    params.assign = o->device.text;
    params.assign_count = o->device.count;
    params.position = o->position.text;
    params.position_count = o->position.count;
    if (o->replay.count) {
        enum ap_status st = ap_live_replay(err, o->replay.text, o->replay.count, &way);
        if (st)
            return st;
        params.buses = &way;
        params.bus_count = 1;
    }
    return ap_live_open(err, &params, live);
}

static volatile sig_atomic_t end_asked;

static void on_signal(int sig) {
    (void)sig;
    end_asked = 1;
}

void ap_catch_end(void) {
    signal(SIGINT, on_signal);
    signal(SIGTERM, on_signal);
}

bool ap_end_asked(void) {
    return end_asked;
}
