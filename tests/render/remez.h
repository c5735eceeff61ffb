#ifndef ANTIPODE_TESTS_RENDER_REMEZ_H
#define ANTIPODE_TESTS_RENDER_REMEZ_H

// Minimax polynomials by Remez exchange in long double.

enum { REMEZ_TERMS_MAX = 10 };

struct remez_fit {
    const char *name;
    // What is to be met at t, and how much a difference counts there (> 0 inside of the interval).
    void (*at)(long double t, long double *value, long double *weight);
    long double from, to;
    int terms; // of the polynomial, from t^0 on; at most REMEZ_TERMS_MAX
};

// coefficients: fit->terms of them, t^0's first.
void remez(const struct remez_fit *fit, long double *coefficients);

// The largest weighted difference of this polynomial.
long double remez_worst(const struct remez_fit *fit, const long double *coefficients);

// Derives the polynomial anew and holds the shipped one against it: 0, or 1 where it is worse by
// more than slack. Prints both errors, and the coefficients where asked for.
int remez_hold(const struct remez_fit *fit, const float *shipped, long double slack, int print);

#endif
