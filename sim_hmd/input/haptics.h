#ifndef ANTIPODE_SIM_HMD_INPUT_HAPTICS_H
#define ANTIPODE_SIM_HMD_INPUT_HAPTICS_H

#include <stdbool.h>
#include <stdint.h>

// What the program let its controllers' motors do. Nobody holds them, so it is kept for the next
// line of frames.jsonl.

enum { SIM_MAX_PULSES = 64 };

struct sim_pulse {
    int64_t frame; // the one that was begun last
    int top;       // enum sim_top; −1: every hand that the action is bound to
    bool stop;     // xrStopHapticFeedback
    int64_t duration_ns;
    float frequency_hz, amplitude; // as given; 0 Hz: the runtime's choice
};

struct sim_pulses {
    uint32_t count;
    int64_t dropped; // beyond SIM_MAX_PULSES
    struct sim_pulse pulse[SIM_MAX_PULSES];
};

static inline void sim_pulses_add(struct sim_pulses *pulses, struct sim_pulse pulse) {
    if (pulses->count < SIM_MAX_PULSES)
        pulses->pulse[pulses->count++] = pulse;
    else
        pulses->dropped++;
}

#endif
