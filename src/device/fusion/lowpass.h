#ifndef ANTIPODE_DEVICE_FUSION_LOWPASS_H
#define ANTIPODE_DEVICE_FUSION_LOWPASS_H

#include <stddef.h>

// Second-order Butterworth low-pass over several channels at once. Until `tau` has passed it gives
// the mean of what it has seen, and goes on from there, so that it needs no settling.

enum { AP_LOWPASS_CHANNELS_MAX = 11 };

struct ap_lowpass {
    double b0, b1, b2, a1, a2;
    double mean_samples; // how long it is a mean
    double seen;
    int channels;
    double state[AP_LOWPASS_CHANNELS_MAX][2];
};

// Cut-off at √2/(2π·tau), the frequency at which the step response has the time constant tau.
// Domain: 0 < period_s < tau_s (the caller checks), 1 ≤ channels ≤ AP_LOWPASS_CHANNELS_MAX.
void ap_lowpass_init(struct ap_lowpass *filter, int channels, double tau_s, double period_s);

// One sample of every channel; in and out may be the same array.
void ap_lowpass_step(struct ap_lowpass *filter, const double *in, double *out);

#endif
