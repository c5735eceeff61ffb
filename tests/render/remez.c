#include "tests/render/remez.h"

#include <math.h>
#include <stdio.h>

enum { GRID = 20000 };

static long double grid(const struct remez_fit *fit, int i) {
    return fit->from + (fit->to - fit->from) * i / GRID;
}

static long double error_at(const struct remez_fit *fit, const long double *c, long double t) {
    long double p = 0, value, weight;
    fit->at(t, &value, &weight);
    for (int k = fit->terms - 1; k >= 0; k--)
        p = p * t + c[k];
    return (p - value) * weight;
}

// Solves the n×n system in place by elimination with row pivots.
static void solve(int n, long double a[REMEZ_TERMS_MAX + 1][REMEZ_TERMS_MAX + 2]) {
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
static void exchange(const struct remez_fit *fit, const long double *c, long double *points) {
    int found = 0;
    long double best = 0;
    for (int i = 0; i <= GRID; i++) {
        long double t = grid(fit, i), e = error_at(fit, c, t);
        if (found > 0 && e * best > 0) {
            if (fabsl(e) > fabsl(best)) {
                best = e;
                points[found - 1] = t;
            }
        } else if (found <= fit->terms && e != 0) {
            best = e;
            points[found++] = t;
        }
    }
}

void remez(const struct remez_fit *fit, long double *c) {
    long double points[REMEZ_TERMS_MAX + 1];
    int n = fit->terms + 1;
    for (int i = 0; i < n; i++)
        points[i] = fit->from + (fit->to - fit->from) *
                                    (1 - cosl(3.14159265358979323846L * (i + 0.5L) / n)) / 2;
    for (int round = 0; round < 12; round++) {
        long double a[REMEZ_TERMS_MAX + 1][REMEZ_TERMS_MAX + 2];
        for (int i = 0; i < n; i++) {
            long double value, power;
            fit->at(points[i], &value, &power);
            a[i][n] = value * power;
            for (int k = 0; k < fit->terms; k++, power *= points[i])
                a[i][k] = power;
            a[i][fit->terms] = i % 2 ? 1 : -1;
        }
        solve(n, a);
        for (int k = 0; k < fit->terms; k++)
            c[k] = a[k][n];
        exchange(fit, c, points);
    }
}

long double remez_worst(const struct remez_fit *fit, const long double *c) {
    long double w = 0;
    for (int i = 0; i <= GRID; i++)
        w = fmaxl(w, fabsl(error_at(fit, c, grid(fit, i))));
    return w;
}

int remez_hold(const struct remez_fit *fit, const float *shipped, long double slack, int print) {
    long double best[REMEZ_TERMS_MAX], ours[REMEZ_TERMS_MAX];
    remez(fit, best);
    for (int k = 0; k < fit->terms; k++)
        ours[k] = shipped[k];
    for (int k = 0; k < fit->terms && print; k++)
        printf("%s[%d] = %.9g\n", fit->name, k, (double)(float)best[k]);
    double minimax = (double)remez_worst(fit, best), here = (double)remez_worst(fit, ours);
    double allowed = minimax + (double)slack;
    printf("%s: minimax %.4g, shipped %.4g, allowed %.4g\n", fit->name, minimax, here, allowed);
    return !(here <= allowed);
}
