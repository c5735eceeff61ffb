#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "src/base/clock.h"
#include "src/geom/isometry.h"
#include "src/geom/map.h"
#include "tests/geom/reference.h"

// Times the geometry's inner functions beside the plain variant of each (no error carried, hypot
// and one libm call), and measures both errors on the same inputs. `bench_geom` prints a table.

enum { COUNT = 2000, RUNS = 31, MEASURED = 500 };

struct input {
    struct ap_space space;
    struct ap_vec3 v[COUNT];
    struct ap_vec4 p[COUNT];
    struct ap_iso m[COUNT];
};

union output {
    struct ap_vec4 p;
    struct ap_vec3 v;
    struct ap_iso m;
};

typedef void (*function)(const struct input *in, int i, union output *out);
typedef double (*error_of)(const struct input *in, int i, const union output *out);

static void exp_ours(const struct input *in, int i, union output *out) {
    out->p = ap_exp(in->space, in->v[i]);
}

static void exp_plain(const struct input *in, int i, union output *out) {
    struct ap_vec3 v = in->v[i];
    double n = sqrt(ap_vec3_dot(v, v)), t = n / in->space.rho_m;
    double f = n > 0 ? ap_space_sin(in->space, t) / t : 1;
    out->p =
        (struct ap_vec4){f * v.x, f * v.y, f * v.z, in->space.rho_m * ap_space_cos(in->space, t)};
}

static void log_ours(const struct input *in, int i, union output *out) {
    out->v = ap_log_unchecked(in->space, in->p[i], 0);
}

static void log_plain(const struct input *in, int i, union output *out) {
    struct ap_vec4 p = in->p[i];
    struct ap_vec3 v = {p.x, p.y, p.z};
    double w = p.w / in->space.rho_m;
    double t = in->space.kappa > 0 ? acos(w) : in->space.kappa < 0 ? acosh(w) : 1;
    double s = ap_space_sin(in->space, t);
    out->v = ap_vec3_scale(s > 0 ? t / s : 1, v);
}

static void translate_ours(const struct input *in, int i, union output *out) {
    out->m = ap_iso_translate(in->space, in->v[i]);
}

static void translate_plain(const struct input *in, int i, union output *out) {
    struct ap_vec3 v = in->v[i];
    double n = sqrt(ap_vec3_dot(v, v)), t = n / in->space.rho_m;
    double c = ap_space_cos(in->space, t), s = ap_space_sin(in->space, t);
    const double u[3] = {v.x / n, v.y / n, v.z / n};
    out->m = AP_ISO_IDENTITY;
    for (int r = 0; r < 3; r++) {
        for (int k = 0; k < 3; k++)
            out->m.m[r][k] += (c - 1) * u[r] * u[k];
        out->m.m[r][3] = s * u[r];
        out->m.m[3][r] = -in->space.kappa * s * u[r];
    }
    out->m.m[3][3] = c;
}

static void mul_ours(const struct input *in, int i, union output *out) {
    out->m = ap_iso_mul(in->m[i], in->m[COUNT - 1 - i]);
}

static void mul_plain(const struct input *in, int i, union output *out) {
    const struct ap_iso *a = &in->m[i], *b = &in->m[COUNT - 1 - i];
    memset(out, 0, sizeof *out);
    for (int r = 0; r < 4; r++)
        for (int c = 0; c < 4; c++)
            for (int k = 0; k < 4; k++)
                out->m.m[r][c] += a->m[r][k] * b->m[k][c];
}

static void walk_ours(const struct input *in, int i, union output *out) {
    const struct ap_vec3 steps[2] = {in->v[i], in->v[COUNT - 1 - i]};
    out->m = ap_iso_walk(in->space, steps, 2);
}

static void walk_plain(const struct input *in, int i, union output *out) {
    union output a, b;
    translate_plain(in, i, &a);
    translate_plain(in, COUNT - 1 - i, &b);
    out->m = ap_iso_mul(a.m, b.m);
}

static double exp_error(const struct input *in, int i, const union output *out) {
    return ref_exp_error(in->space, in->v[i], out->p);
}

static double log_error(const struct input *in, int i, const union output *out) {
    return ref_log_error(in->space, in->p[i], 0, out->v);
}

static double translate_error(const struct input *in, int i, const union output *out) {
    return ref_walk_error(in->space, &in->v[i], 1, &out->m);
}

static double walk_error(const struct input *in, int i, const union output *out) {
    const struct ap_vec3 steps[2] = {in->v[i], in->v[COUNT - 1 - i]};
    return ref_walk_error(in->space, steps, 2, &out->m);
}

static int by_size(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

// Median nanoseconds a call.
static double time_of(const struct input *in, function f) {
    static volatile double sink;
    double runs[RUNS];
    for (int k = 0; k < RUNS; k++) {
        union output out;
        int64_t start = ap_clock_now_ns();
        for (int i = 0; i < COUNT; i++) {
            f(in, i, &out);
            sink = out.p.x;
        }
        runs[k] = (double)(ap_clock_now_ns() - start) / COUNT;
    }
    (void)sink;
    qsort(runs, RUNS, sizeof runs[0], by_size);
    return runs[RUNS / 2];
}

static double worst_of(const struct input *in, function f, error_of error) {
    double worst = 0;
    for (int i = 0; error && i < MEASURED; i++) {
        union output out;
        f(in, i, &out);
        double e = error(in, i, &out);
        worst = e > worst || isnan(e) ? e : worst;
    }
    return worst;
}

static void fill(struct input *in, struct ap_space space, double least, double most) {
    struct ref_random r = {1};
    in->space = space;
    for (int i = 0; i < COUNT; i++) {
        double t = exp(ref_uniform(&r, log(least), log(most)));
        in->v[i] = ap_vec3_scale(t * space.rho_m, ref_direction(&r));
        in->p[i] = ap_exp(space, in->v[i]);
        in->m[i] = ap_iso_translate(space, in->v[i]);
    }
}

int main(void) {
    static const struct {
        const char *name;
        function ours, plain;
        error_of error;
    } rows[] = {
        {"exp", exp_ours, exp_plain, exp_error},
        {"log", log_ours, log_plain, log_error},
        {"translate", translate_ours, translate_plain, translate_error},
        {"mul", mul_ours, mul_plain, NULL},
        {"walk, 2 steps", walk_ours, walk_plain, walk_error},
    };
    static const struct {
        int kappa;
        double least, most;
    } ranges[] = {{-1, 1e-4, 1}, {-1, 1, 38}, {0, 1e-4, 1}, {1, 1e-4, 1}, {1, 1, 3.14}};
    struct input *in = calloc(1, sizeof *in);
    if (!in)
        return 1;
    printf("%-14s %-5s %-14s %9s %9s %12s %12s\n", "function", "space", "|v|/rho", "ns", "plain ns",
           "worst error", "plain's");
    for (size_t k = 0; k < sizeof ranges / sizeof ranges[0]; k++) {
        fill(in, (struct ap_space){ranges[k].kappa, 0.85}, ranges[k].least, ranges[k].most);
        for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
            char range[32];
            snprintf(range, sizeof range, "%g..%g", ranges[k].least, ranges[k].most);
            printf("%-14s %-5s %-14s %9.1f %9.1f", rows[i].name, ap_space_name(in->space), range,
                   time_of(in, rows[i].ours), time_of(in, rows[i].plain));
            if (rows[i].error)
                printf(" %12.2g %12.2g", worst_of(in, rows[i].ours, rows[i].error),
                       worst_of(in, rows[i].plain, rows[i].error));
            printf("\n");
        }
    }
    free(in);
    ref_finish();
    return 0;
}
