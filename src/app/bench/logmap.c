#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "src/app/bench/bench.h"
#include "src/app/bench/kernels.h"
#include "src/geom/map.h"
#include "src/render/logmap/logmap_device.h"
#include "src/render/logmap/logmap_float.h"

// 1. Log-map formulas: nanoseconds a point against the worst relative error.

// Points that fit the caches for the processor; enough of them to fill a device.
enum { POINTS = 6000, DEVICE_POINTS = 1 << 18, DEVICE_POINTS_QUICK = 1 << 13, REPEATS = 8 };

struct points {
    struct ap_points_f f;
    struct ap_points_d d;
    size_t device_points;
    float (*in)[4], (*out)[4];       // device_points; the first POINTS are those of f
    long double (*exact)[3];         // of f's points, then of d's
    struct ap_logmap_device *device; // may be NULL
};

enum way { SCALAR, SIMD, GLSL };

struct formula {
    const char *name, *precision, *way;
    int kind; // the case of run()
    enum way group;
};

enum {
    COSINE_F,
    SINE_F,
    POLY,
    POLY_4,
    POLY_8,
    COSINE_D,
    SINE_D,
    CARRIED,
    GPU_POLY,
    GPU_COS,
    GPU_SIN
};

static const struct formula FORMULAS[] = {
    {"acos/acosh of w (the paper)", "float", "scalar", COSINE_F, SCALAR},
    {"atan2/asinh of r", "float", "scalar", SINE_F, SCALAR},
    {"polynomial", "float", "scalar", POLY, SCALAR},
    {"polynomial", "float", "SIMD, 4 lanes", POLY_4, SIMD},
    {"polynomial", "float", "SIMD, 8 lanes", POLY_8, SIMD},
    {"acos/acosh of w (the paper)", "double", "scalar", COSINE_D, SCALAR},
    {"atan2/asinh of r", "double", "scalar", SINE_D, SCALAR},
    {"atan2/asinh, errors carried", "double", "scalar", CARRIED, SCALAR},
    {"polynomial (as drawn)", "float", "GLSL", GPU_POLY, GLSL},
    {"built-in acos/acosh of w", "float", "GLSL", GPU_COS, GLSL},
    {"built-in atan/asinh of r", "float", "GLSL", GPU_SIN, GLSL},
};
enum { FORMULA_COUNT = sizeof FORMULAS / sizeof *FORMULAS };

// The exact answer for the point as it is held: (x, y, z) alone in h3.
static void exact(int kappa, const long double p[4], long double q[3]) {
    long double r = sqrtl(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]);
    long double theta = kappa > 0 ? atan2l(r, p[3]) : asinhl(r);
    for (int k = 0; k < 3; k++)
        q[k] = theta / r * p[k];
}

// A third even, a third near the nose, a third near the antipode or not far; so for each multiple
// of three.
static void fill(struct points *p, int kappa) {
    const double pi = 3.14159265358979323846, far = kappa > 0 ? pi - 1e-5 : 80;
    for (size_t i = 0; i < p->device_points; i++) {
        double u = ((double)(i % POINTS) + 0.5) / POINTS, turn = 2.4 * (double)i;
        double t = i % 3 == 0   ? u * far
                   : i % 3 == 1 ? 1e-8 * pow(2e8, u)
                   : kappa > 0  ? pi - 1e-5 * pow(2e5, u)
                                : u * 5;
        double up = 2 * fmod(0.618 * (double)i, 1) - 1, flat = sqrt(1 - up * up);
        struct ap_vec4 x =
            ap_exp((struct ap_space){kappa, 1},
                   (struct ap_vec3){t * flat * cos(turn), t * up, t * flat * sin(turn)});
        const double all[4] = {x.x, x.y, x.z, x.w};
        for (int k = 0; k < 4; k++)
            p->in[i][k] = (float)all[k];
        for (int k = 0; i < POINTS && k < 4; k++) {
            p->f.c[k][i] = (float)all[k];
            p->d.c[k][i] = all[k];
        }
    }
    for (size_t i = 0; i < POINTS; i++) {
        long double f[4], d[4];
        for (int k = 0; k < 4; k++) {
            f[k] = p->f.c[k][i];
            d[k] = p->d.c[k][i];
        }
        exact(kappa, f, p->exact[i]);
        exact(kappa, d, p->exact[POINTS + i]);
    }
}

static void polynomial_scalar(int kappa, const struct ap_points_f *p) {
    for (size_t i = 0; i < p->count; i++) {
        const float x[4] = {p->c[0][i], p->c[1][i], p->c[2][i], p->c[3][i]};
        float q[3];
        ap_logmap_float(kappa, 0, x, q);
        for (int k = 0; k < 3; k++)
            p->c[4 + k][i] = q[k];
    }
}

static void carried(int kappa, const struct ap_points_d *p) {
    for (size_t i = 0; i < p->count; i++) {
        const struct ap_vec4 x = {p->c[0][i], p->c[1][i], p->c[2][i], p->c[3][i]};
        struct ap_vec3 q = ap_log_unchecked((struct ap_space){kappa, 1}, x, 0);
        p->c[4][i] = q.x;
        p->c[5][i] = q.y;
        p->c[6][i] = q.z;
    }
}

static enum ap_status run(struct ap_error *err, struct points *p, int kind, int kappa) {
    const int kappa_image[2] = {kappa, 0};
    switch (kind) {
    case COSINE_F:
        ap_kernel_cosine_f(kappa, &p->f);
        return AP_OK;
    case SINE_F:
        ap_kernel_sine_f(kappa, &p->f);
        return AP_OK;
    case POLY:
        polynomial_scalar(kappa, &p->f);
        return AP_OK;
    case POLY_4:
    case POLY_8:
        ap_kernel_polynomial_simd(kappa, kind == POLY_8, &p->f);
        return AP_OK;
    case COSINE_D:
        ap_kernel_cosine_d(kappa, &p->d);
        return AP_OK;
    case SINE_D:
        ap_kernel_sine_d(kappa, &p->d);
        return AP_OK;
    case CARRIED:
        carried(kappa, &p->d);
        return AP_OK;
    default:
        return ap_logmap_device_map(err, p->device, (enum ap_logmap_way)(kind - GPU_POLY),
                                    kappa_image, (const float(*)[4])p->in, p->device_points, p->out,
                                    REPEATS);
    }
}

// Over the exact length; 1 where nothing of an answer is right, or it is no number.
static double error_of(const struct points *p, const struct formula *f) {
    bool is_double = f->precision[0] == 'd';
    double worst = 0;
    for (size_t i = 0; i < POINTS; i++) {
        const long double *q = p->exact[i + (is_double ? POINTS : 0)];
        long double off = 0, all = 0;
        for (int k = 0; k < 3; k++) {
            long double got = f->group == GLSL ? (long double)p->out[i][k]
                              : is_double      ? (long double)p->d.c[4 + k][i]
                                               : (long double)p->f.c[4 + k][i];
            off += (got - q[k]) * (got - q[k]);
            all += q[k] * q[k];
        }
        double e = (double)sqrtl(off / all);
        worst = e <= worst ? worst : e <= 1 ? e : 1;
    }
    return worst;
}

static bool there(const struct points *p, const struct formula *f) {
    return f->group == SCALAR || (f->group == GLSL && p->device) ||
           (f->group == SIMD && ap_kernel_lanes(f->kind == POLY_8) > 0);
}

// The renderer's polynomial and the better of the built-ins, in both spaces.
struct findings {
    double polynomial, polynomial_ns, built_in;
};

static enum ap_status race(struct ap_error *err, const struct ap_bench *bench, struct points *p,
                           int kappa, FILE *csv, struct findings *findings) {
    static double ns[FORMULA_COUNT][AP_BENCH_ROUNDS_MAX];
    double worst[FORMULA_COUNT] = {0};
    fill(p, kappa);
    const int rounds = 3 * bench->rounds;
    for (int round = -1; round < rounds; round++)
        for (int i = 0; i < FORMULA_COUNT; i++) {
            const struct formula *f = &FORMULAS[i];
            if (!there(p, f))
                continue;
            // On a device that is no processor its own time is the wall's.
            struct timespec a, b;
            bool wall = f->group == GLSL && !bench->software;
            clockid_t clock = wall ? CLOCK_MONOTONIC : CLOCK_PROCESS_CPUTIME_ID;
            int times = f->group == GLSL ? 1 : 20;
            clock_gettime(clock, &a);
            for (int k = 0; k < times; k++) {
                enum ap_status st = run(err, p, f->kind, kappa);
                if (st)
                    return st;
            }
            clock_gettime(clock, &b);
            double done = f->group == GLSL ? (double)p->device_points * REPEATS : POINTS * 20.0;
            if (round >= 0)
                ns[i][round] =
                    ((double)(b.tv_sec - a.tv_sec) * 1e9 + (double)(b.tv_nsec - a.tv_nsec)) / done;
            else
                worst[i] = error_of(p, f);
        }
    for (int i = 0; i < FORMULA_COUNT; i++) {
        const struct formula *f = &FORMULAS[i];
        if (!there(p, f))
            continue;
        struct ap_spread s = ap_bench_spread(ns[i], rounds);
        fprintf(csv, "%s,%s,\"%s\",\"%s\",%d,%.4g,%.4g,%.4g,%.3g\n", kappa > 0 ? "s3" : "h3",
                f->precision, f->way, f->name, (int)f->group, s.low, s.median, s.high, worst[i]);
        if (f->kind != GPU_POLY)
            continue;
        findings->polynomial = fmax(findings->polynomial, worst[i]);
        findings->polynomial_ns = fmax(findings->polynomial_ns, s.median);
        findings->built_in = fmax(
            findings->built_in, fmin(worst[i + GPU_COS - GPU_POLY], worst[i + GPU_SIN - GPU_POLY]));
    }
    return AP_OK;
}

// A colour for what is computed, a form for where; open: in double. Both plots share the key.
static const char SCRIPT[] =
    "set multiplot layout 1,2 title heading\nset bmargin 11\n"
    "set logscale xy\nset format x '%.0e'\nset xtics 10000\nset xrange [1e-17:10]\n"
    "set yrange [0.3:300]\nset xlabel 'worst relative error (left is better; 1: no digit is right)'\n"
    "set ylabel 'ns a point (down is better)'\nset key off\n"
    "set label 1 'both plots:' at screen 0.5, screen 0.17 center\n"
    "do for [s=0:1] {\n"
    " set title (s==0 ? 's3, from 1e-8 to pi - 1e-5 rho' : 'h3, from 1e-8 to 80 rho')\n"
    " set key at screen (s==0 ? 0.25 : 0.75), screen 0.01 center bottom vertical maxrows 6 samplen 1\n"
    " plot for [k=1:words(names)] $data skip 1 every ::(words(names)*s+k-1)::(words(names)*s+k-1) "
    "using 9:7:6:8 with yerrorbars pt int(word(forms,k)) ps 1.3 lw 1.5 lc rgb word(colours,k) title "
    "((k<=6)==(s==0) ? word(names,k) : '')\n unset label 1\n}\nunset multiplot\n";

static void write_script(const struct points *p, char *script, size_t size) {
    FILE *f = fmemopen(script, size, "w");
    if (!f)
        return;
    for (int what = 0; what < 3; what++) {
        fputs(what == 0 ? "names = '" : what == 1 ? "forms = '" : "colours = '", f);
        for (int i = 0; i < FORMULA_COUNT; i++) {
            const struct formula *x = &FORMULAS[i];
            bool is_double = x->precision[0] == 'd';
            int form = x->group == SCALAR ? 7 : x->kind == POLY_4 ? 11 : x->group == SIMD ? 9 : 5;
            const char *colour = strstr(x->name, "cos")       ? "#d62728"
                                 : strstr(x->name, "carried") ? "#1f77b4"
                                 : strstr(x->name, "asinh")   ? "#ff7f0e"
                                                              : "#2ca02c";
            if (!there(p, x))
                continue;
            if (what == 0)
                fprintf(f, "\"%s; %s, %s\" ", x->name, x->precision, x->way);
            else if (what == 1)
                fprintf(f, "%d ", form - is_double);
            else
                fprintf(f, "%s ", colour);
        }
        fputs("'\n", f);
    }
    fputs(SCRIPT, f);
    fclose(f);
}

static bool allocate(struct points *p) {
    p->f.count = p->d.count = POINTS;
    bool good = true;
    for (int k = 0; k < 7; k++) {
        p->f.c[k] = calloc(POINTS, sizeof *p->f.c[k]);
        p->d.c[k] = calloc(POINTS, sizeof *p->d.c[k]);
        good = good && p->f.c[k] && p->d.c[k];
    }
    p->in = calloc(p->device_points, sizeof *p->in);
    p->out = calloc(p->device_points, sizeof *p->out);
    p->exact = calloc(2 * (size_t)POINTS, sizeof *p->exact);
    return good && p->in && p->out && p->exact;
}

static void release(struct points *p) {
    for (int k = 0; k < 7; k++) {
        free(p->f.c[k]);
        free(p->d.c[k]);
    }
    free(p->in);
    free(p->out);
    free(p->exact);
    ap_logmap_device_destroy(p->device);
}

enum ap_status ap_bench_logmap(struct ap_error *err, const struct ap_bench *bench) {
    struct points p = {.device_points = bench->quick ? DEVICE_POINTS_QUICK : DEVICE_POINTS};
    struct findings found = {0, 0, 0};
    struct ap_bench_table table = {0};
    enum ap_status st = allocate(&p) ? AP_OK : ap_fail(err, AP_ENVIRONMENT, "out of memory");
    if (!st && bench->has_gpu)
        st = ap_logmap_device_create(err, &bench->gpu, p.device_points, &p.device);
    if (!st)
        st = ap_bench_begin(err, "logmap",
                            "space,precision,way,formula,group,ns_low,ns,ns_high,worst_error",
                            &table);
    for (int kappa = 1; !st && kappa >= -1; kappa -= 2)
        st = race(err, bench, &p, kappa, table.csv, &found);
    char device[512], script[4096] = "", title[256];
    write_script(&p, script, sizeof script);
    snprintf(device, sizeof device, "%s%s%.300s", bench->machine,
             bench->has_gpu ? "; GLSL on " : "",
             bench->has_gpu ? bench->gpu.properties.deviceName : "");
    snprintf(title, sizeof title, "Log maps: what they cost and how exact they are");
    if (p.device)
        snprintf(title, sizeof title,
                 "The renderer's log map: relative error at most %.1e, %.0f ns a point; by the "
                 "device's own functions up to %.1g",
                 found.polynomial, found.polynomial_ns, found.built_in);
    if (!st)
        st = ap_bench_end(err, bench, &table, title, device, script);
    ap_bench_drop(&table);
    release(&p);
    return st;
}
