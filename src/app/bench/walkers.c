#include <math.h>
#include <stdlib.h>
#include <time.h>

#include "src/app/bench/bench.h"
#include "src/geom/deep.h"
#include "src/geom/map.h"

// 3. Walkers: nanoseconds a step against the drift after a million steps, by when the pose is put
// back onto the group.

enum { STRETCHES = 8 };

struct policy {
    const char *name;
    long period;  // of Gram-Schmidt; 0 never
    bool carried; // by ap_iso_walk, double-double
};
static const struct policy POLICIES[] = {
    {"never", 0, false},         {"every 4096 steps", 4096, false}, {"every 64 steps", 64, false},
    {"every 8 steps", 8, false}, {"every step", 1, false},          {"double-double", 0, true},
};
enum { POLICY_COUNT = sizeof POLICIES / sizeof *POLICIES };

// Small steps in the walker's own frame, of no fixed length (its cosine would be wrong by the same
// last bit each time); beyond 1.7 rho she turns home. xorshift64*.
static struct ap_vec3 *make_steps(struct ap_space s, long count) {
    struct ap_vec3 *steps = calloc((size_t)count, sizeof *steps);
    struct ap_iso pose = AP_ISO_IDENTITY;
    uint64_t state = 88172645463325252u;
    const struct ap_vec4 base = {0, 0, 0, s.rho_m};
    for (long i = 0; steps && i < count; i++) {
        double r[4];
        for (int k = 0; k < 4; k++) {
            state ^= state >> 12;
            state ^= state << 25;
            state ^= state >> 27;
            r[k] = (double)((state * 2685821657736338717u) >> 11) * 0x1p-53;
        }
        struct ap_iso back = ap_iso_inverse(s, pose);
        struct ap_vec3 u = ap_log_unchecked(s, ap_iso_apply(&back, base), 0);
        if (ap_vec3_length(u) <= 1.69 * s.rho_m)
            u = (struct ap_vec3){r[0] - 0.5, r[1] - 0.5, r[2] - 0.5};
        steps[i] = ap_vec3_scale((0.005 + 0.01 * r[3]) * s.rho_m, ap_vec3_normalize(u));
        pose = ap_iso_mul(pose, ap_iso_translate(s, steps[i]));
    }
    return steps;
}

static double cpu_ns(void) {
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return (double)t.tv_sec * 1e9 + (double)t.tv_nsec;
}

// --- the same walk in 256 bits: what the others are held against

// c[0] = (1 − cos t)/t², c[1] = sin t/t, or with cosh and sinh, of x = κ·t² below 1e-3: series,
// ½(1 − x/(3·4)·(1 − x/(5·6)·…)) and 1 − x/(2·3)·(1 − x/(4·5)·…).
static void series(struct ap_fixed x, struct ap_fixed c[2]) {
    enum { TERMS = 18 };
    const struct ap_fixed one = ap_fixed_of(1);
    c[0] = c[1] = one;
    for (uint32_t i = 2 * TERMS; i > 0; i -= 2) {
        c[0] = ap_fixed_sub(one, ap_fixed_divide(ap_fixed_mul(x, c[0]), (i + 1) * (i + 2)));
        c[1] = ap_fixed_sub(one, ap_fixed_divide(ap_fixed_mul(x, c[1]), i * (i + 1)));
    }
    c[0] = ap_fixed_divide(c[0], 2);
}

// As ap_iso_translate, of a radius of 1.
static struct ap_deep_iso exact_step(int kappa, struct ap_vec3 v) {
    const struct ap_fixed u[3] = {ap_fixed_of(v.x), ap_fixed_of(v.y), ap_fixed_of(v.z)};
    struct ap_fixed square = ap_fixed_of(0), c[2];
    struct ap_deep_iso m = ap_deep_identity();
    for (int i = 0; i < 3; i++)
        square = ap_fixed_add(square, ap_fixed_mul(u[i], u[i]));
    struct ap_fixed x = kappa > 0 ? square : kappa < 0 ? ap_fixed_neg(square) : ap_fixed_of(0);
    series(x, c);
    for (int i = 0; i < 3; i++) {
        m.m[i][3] = ap_fixed_mul(c[1], u[i]);
        m.m[3][i] = kappa > 0 ? ap_fixed_neg(m.m[i][3]) : kappa < 0 ? m.m[i][3] : ap_fixed_of(0);
        for (int j = 0; j < 3 && kappa; j++) {
            struct ap_fixed bend = ap_fixed_mul(c[0], ap_fixed_mul(u[i], u[j]));
            m.m[i][j] = kappa > 0 ? ap_fixed_sub(m.m[i][j], bend) : ap_fixed_add(m.m[i][j], bend);
        }
    }
    m.m[3][3] = ap_fixed_sub(ap_fixed_of(1), ap_fixed_mul(c[0], x));
    return m;
}

static struct ap_deep_iso exact_walk(int kappa, const struct ap_vec3 *steps, long count) {
    struct ap_deep_iso pose = ap_deep_identity();
    for (long i = 0; i < count; i++) {
        struct ap_deep_iso step = exact_step(kappa, steps[i]);
        pose = ap_deep_mul(&pose, &step);
    }
    return pose;
}

// How far the walker is from where she ought to be, over rho, as far as coordinates tell.
static double off_by(const struct ap_deep_iso *truth, const struct ap_iso *pose) {
    double off = 0;
    for (int i = 0; i < 4; i++) {
        struct ap_fixed d = ap_fixed_sub(truth->m[i][3], ap_fixed_of(pose->m[i][3]));
        off = fmax(off, fabs(ap_fixed_round(d).hi));
    }
    return off;
}

// --- the race

static void walk_on(struct ap_space s, const struct policy *policy, const struct ap_vec3 *steps,
                    long from, long to, struct ap_iso *pose) {
    for (long i = from; i < to; i++) {
        *pose = ap_iso_mul(*pose, ap_iso_translate(s, steps[i]));
        if (policy->period && (i + 1) % policy->period == 0)
            *pose = ap_iso_orthonormalize(s, *pose);
    }
}

struct findings {
    double off, off_carried; // rho
    double ratio;            // of the times
};

// By stretches in turn. A walk that is carried is given in one go: its stretches are timed each for
// itself, and it is walked once more as a whole.
static void measure(struct ap_space s, const struct ap_vec3 *steps, long count, FILE *csv,
                    struct findings *findings) {
    struct ap_iso pose[POLICY_COUNT];
    double ns[POLICY_COUNT][STRETCHES];
    for (int i = 0; i < POLICY_COUNT; i++)
        pose[i] = AP_ISO_IDENTITY;
    for (int k = 0; k < STRETCHES; k++)
        for (int i = 0; i < POLICY_COUNT; i++) {
            long from = count * k / STRETCHES, to = count * (k + 1) / STRETCHES;
            double start = cpu_ns();
            if (POLICIES[i].carried)
                pose[i] = ap_iso_walk(s, steps + from, (size_t)(to - from));
            else
                walk_on(s, &POLICIES[i], steps, from, to, &pose[i]);
            ns[i][k] = (cpu_ns() - start) / (double)(to - from);
        }
    const struct ap_deep_iso truth = exact_walk(s.kappa, steps, count);
    for (int i = 0; i < POLICY_COUNT; i++) {
        if (POLICIES[i].carried)
            pose[i] = ap_iso_walk(s, steps, (size_t)count);
        double off = off_by(&truth, &pose[i]), defect = ap_iso_defect(s, &pose[i]);
        struct ap_spread spread = ap_bench_spread(ns[i], STRETCHES);
        fprintf(csv, "%s,\"%s\",%ld,%.4g,%.4g,%.4g,%.3g,%.3g\n", ap_space_name(s), POLICIES[i].name,
                count, spread.low, spread.median, spread.high, fmax(off, 1e-17),
                fmax(defect, 1e-17));
        if (i == 0)
            *findings = (struct findings){off, 0, spread.median};
        else if (POLICIES[i].carried)
            *findings = (struct findings){findings->off, off, spread.median / findings->ratio};
    }
}

static const char SCRIPT[] =
    "set multiplot layout 1,2 title heading\nset logscale xy\nset format x '%.0e'\n"
    "set ylabel 'ns of CPU a step (down is better)'\nset yrange [15:5000]\n"
    "set xrange [3e-18:1e-10]\nset xtics 1000\nset bmargin 9\n"
    "names = '\"pose put back: never\" \"every 4096 steps\" \"every 64 steps\" \"every 8 steps\" \"every "
    "step\" \"double-double\"'\n"
    "array form[6] = [4, 12, 8, 10, 14, 7]\n"
    "colour(s) = s==0 ? '#1f77b4' : s==1 ? '#1b9e77' : '#d95f02'\n"
    "do for [c=7:8] {\n"
    " set xlabel (c==7 ? 'position off at the end, rho' : 'defect of M^TGM - G').' (left is "
    "better; 0 is drawn at 1e-17)'\n"
    " set key at screen (c==7 ? 0.32 : 0.77), screen 0.02 center bottom vertical maxrows 3\n"
    " plot for [s=0:2] $data skip 1 every ::(6*s)::(6*s+5) using c:5 with lines lw 1 lc rgb colour(s) "
    "notitle, for [s=0:2] for [p=0:5] $data skip 1 every ::(6*s+p)::(6*s+p) using c:5:4:6 with "
    "yerrorbars pt form[p+1] ps 1.3 lw 1.5 lc rgb colour(s) notitle, for [p=0:(c==7 ? 5 : -1)] "
    "keyentry with points pt form[p+1] ps 1.3 lc rgb '#000000' title word(names,p+1), for [s=0:(c==8 "
    "? 2 : -1)] keyentry with lines lw 4 lc rgb colour(s) title word('h3 e3 s3',s+1)\n}\n"
    "unset multiplot\n";

enum ap_status ap_bench_walkers(struct ap_error *err, const struct ap_bench *bench) {
    long count = bench->quick ? 20000 : 1000000;
    struct ap_bench_table table = {0};
    struct findings findings = {0, 0, 0}, others;
    enum ap_status st = ap_bench_begin(
        err, "walkers", "space,back_onto_the_group,steps,ns_low,ns,ns_high,off_rho,defect", &table);
    for (int kappa = -1; !st && kappa <= 1; kappa++) {
        struct ap_space s = {kappa, 1};
        struct ap_vec3 *steps = make_steps(s, count);
        if (!steps)
            st = ap_fail(err, AP_ENVIRONMENT, "no memory for %ld steps", count);
        else
            measure(s, steps, count, table.csv, kappa < 0 ? &findings : &others);
        free(steps);
    }
    char title[256];
    snprintf(
        title, sizeof title,
        "A walk of %ld steps in h3 ends %.2g rho off in double, %.2g in double-double,\\nfor %.1f "
        "times the time",
        count, findings.off, findings.off_carried, findings.ratio);
    if (!st)
        st = ap_bench_end(err, bench, &table, title, bench->machine, SCRIPT);
    ap_bench_drop(&table);
    return st;
}
