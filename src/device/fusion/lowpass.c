#include "src/device/fusion/lowpass.h"

#include <math.h>

static const double PI = 3.14159265358979323846;

void ap_lowpass_init(struct ap_lowpass *f, int channels, double tau_s, double period_s) {
    // The bilinear transform of 1/(s² + √2·s + 1) with the cut-off pre-warped. The tangent's
    // argument is kept below π/2, where a period near tau would put it beyond.
    double cutoff_hz = sqrt(2) / (2 * PI * tau_s);
    double c = tan(PI * fmin(cutoff_hz * period_s, 0.475));
    double d = c * c + sqrt(2) * c + 1;
    *f = (struct ap_lowpass){.b0 = c * c / d,
                             .b1 = 2 * c * c / d,
                             .b2 = c * c / d,
                             .a1 = 2 * (c * c - 1) / d,
                             .a2 = (1 - sqrt(2) * c + c * c) / d,
                             .mean_samples = fmax(1, floor(tau_s / period_s)),
                             .channels = channels};
}

// The state in which the filter rests at a constant input.
static void settle(const struct ap_lowpass *f, double state[2], double value) {
    state[0] = value * (1 - f->b0);
    state[1] = value * (f->b2 - f->a2);
}

void ap_lowpass_step(struct ap_lowpass *f, const double *in, double *out) {
    if (f->seen < f->mean_samples) {
        f->seen++;
        for (int i = 0; i < f->channels; i++) {
            f->state[i][0] += (in[i] - f->state[i][0]) / f->seen;
            out[i] = f->state[i][0];
        }
        if (f->seen >= f->mean_samples)
            for (int i = 0; i < f->channels; i++)
                settle(f, f->state[i], f->state[i][0]);
        return;
    }
    for (int i = 0; i < f->channels; i++) { // direct form II, transposed
        double *s = f->state[i], x = in[i];
        double y = f->b0 * x + s[0];
        s[0] = f->b1 * x - f->a1 * y + s[1];
        s[1] = f->b2 * x - f->a2 * y;
        out[i] = y;
    }
}
