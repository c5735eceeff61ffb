// Derives the minimax polynomials of the log map anew (Remez exchange in long double) and holds the
// coefficients that ship in src/render/logmap/logmap_float.h and shaders/logmap.glsl against them:
// the shipped ones may be at most a rounding worse. With --print it writes the coefficients.
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "src/render/logmap/logmap_float.h"

enum { TERMS_MAX = 10, GRID = 20000 };

typedef long double (*function)(long double t);

// What is fitted: (F(t) − 1)/t by a polynomial, so that the value at t = 0 is 1 exactly; the error
// is measured relative to F.
struct fit {
    const char *name;
    function f;
    long double end; // on [0, end]
    int terms;
    const float *shipped;
};

static long double asin_ratio(long double t) {
    return t == 0 ? 1 : asinl(sqrtl(t)) / sqrtl(t);
}
static long double asinh_ratio(long double t) {
    return t == 0 ? 1 : asinhl(sqrtl(t)) / sqrtl(t);
}
static long double atanh_ratio(long double t) {
    return t == 0 ? 1 : atanhl(sqrtl(t)) / sqrtl(t);
}

static const struct fit FITS[] = {
    {"asin", asin_ratio, 0.5L, AP_LOGMAP_TERMS, ap_logmap_asin},
    {"asinh", asinh_ratio, 1.0L, AP_LOGMAP_TERMS, ap_logmap_asinh},
    {"atanh", atanh_ratio, 0.029437251522859414L, AP_LOGMAP_LOG_TERMS, ap_logmap_atanh},
};

static long double error_at(const struct fit *fit, const long double *c, long double t) {
    long double p = 0;
    for (int k = fit->terms - 1; k >= 0; k--)
        p = p * t + c[k];
    long double f = fit->f(t);
    return (1 + t * p - f) / f;
}

// Solves the n×n system in place by elimination with row pivots.
static void solve(int n, long double a[TERMS_MAX + 1][TERMS_MAX + 2]) {
    for (int i = 0; i < n; i++) {
        int pivot = i;
        for (int r = i + 1; r < n; r++)
            if (fabsl(a[r][i]) > fabsl(a[pivot][i]))
                pivot = r;
        for (int k = 0; k <= n; k++) {
            long double swap = a[i][k];
            a[i][k] = a[pivot][k];
            a[pivot][k] = swap;
        }
        for (int r = 0; r < n; r++) {
            long double factor = r == i ? 0 : a[r][i] / a[i][i];
            for (int k = i; k <= n; k++)
                a[r][k] -= factor * a[i][k];
        }
    }
    for (int i = 0; i < n; i++)
        a[i][n] /= a[i][i];
}

// The next reference: the largest error of each run of one sign.
static void exchange(const struct fit *fit, const long double *c, long double *points) {
    int found = 0;
    long double best = 0;
    for (int i = 1; i <= GRID; i++) {
        long double t = fit->end * i / GRID, e = error_at(fit, c, t);
        if (found > 0 && e * best > 0) {
            if (fabsl(e) > fabsl(best)) {
                best = e;
                points[found - 1] = t;
            }
        } else if (found <= fit->terms) {
            best = e;
            points[found++] = t;
        }
    }
}

static void remez(const struct fit *fit, long double *c) {
    long double points[TERMS_MAX + 1];
    int n = fit->terms + 1;
    for (int i = 0; i < n; i++)
        points[i] = fit->end * (1 - cosl(3.14159265358979323846L * (i + 1) / n)) / 2;
    for (int round = 0; round < 12; round++) {
        long double a[TERMS_MAX + 1][TERMS_MAX + 2];
        for (int i = 0; i < n; i++) {
            long double t = points[i], f = fit->f(t), power = t / f;
            for (int k = 0; k < fit->terms; k++, power *= t)
                a[i][k] = power;
            a[i][fit->terms] = i % 2 ? 1 : -1;
            a[i][n] = (f - 1) / f;
        }
        solve(n, a);
        for (int k = 0; k < fit->terms; k++)
            c[k] = a[k][n];
        exchange(fit, c, points);
    }
}

static long double worst(const struct fit *fit, const long double *c) {
    long double w = 0;
    for (int i = 0; i <= GRID; i++)
        w = fmaxl(w, fabsl(error_at(fit, c, fit->end * i / GRID)));
    return w;
}

int main(int argc, char **argv) {
    int failures = 0;
    bool print = argc > 1 && strcmp(argv[1], "--print") == 0;
    for (size_t i = 0; i < sizeof FITS / sizeof FITS[0]; i++) {
        long double best[TERMS_MAX], shipped[TERMS_MAX];
        remez(&FITS[i], best);
        for (int k = 0; k < FITS[i].terms; k++)
            shipped[k] = FITS[i].shipped[k];
        if (print)
            for (int k = 0; k < FITS[i].terms; k++)
                printf("%s[%d] = %.9gf\n", FITS[i].name, k, (double)(float)best[k]);
        double minimax = (double)worst(&FITS[i], best), ours = (double)worst(&FITS[i], shipped);
        double allowed = minimax + 6e-8;
        printf("%s: minimax %.3g, shipped %.3g, allowed %.3g\n", FITS[i].name, minimax, ours,
               allowed);
        failures += !(ours <= allowed);
    }
    return failures;
}
