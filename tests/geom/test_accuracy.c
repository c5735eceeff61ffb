#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <stdio.h>
#include <stdlib.h>

#include "src/view/view.h"
#include "tests/geom/reference.h"

// Random inputs against 640-bit truth. The number of samples per case is the first argument; the
// figures in docs/accuracy.md come from `test_accuracy 1000000`.
static long samples = 3000;

struct worst {
    const char *name;
    double bound, error;
    long count;
    char at[400];
    struct ref_random random;
};

static struct worst start(const char *name, double bound) {
    return (struct worst){name, bound, 0, 0, "", {0x5eed}};
}

// True where the sample is the worst so far: the caller then describes it. NaN is, and stays so.
static bool is_worse(struct worst *w, double error) {
    w->count++;
    if (error > w->error || (isnan(error) && !isnan(w->error))) {
        w->error = error;
        return true;
    }
    return false;
}

static void finish(const struct worst *w) {
    printf("%-28s worst %.3g  bound %.3g  (%ld samples) at %s\n", w->name, w->error, w->bound,
           w->count, w->at);
    fflush(stdout);
    if (!(w->error <= w->bound))
        fail_msg("%s: error %.4g above the tolerance %.4g at %s", w->name, w->error, w->bound,
                 w->at);
}

static double log_uniform(struct ref_random *r, double low, double high) {
    return exp(ref_uniform(r, log(low), log(high)));
}

// A radius: mostly human scales, now and then any.
static double a_radius(struct ref_random *r) {
    return ref_uniform(r, 0, 1) < 0.9 ? log_uniform(r, 1e-3, 1e6) : log_uniform(r, 1e-140, 1e140);
}

// A length in units of rho: uniform, or logarithmic down to next to nothing.
static double a_length(struct ref_random *r, double most) {
    return ref_uniform(r, 0, 1) < 0.7 ? ref_uniform(r, 0, most) : most * log_uniform(r, 1e-160, 1);
}

// A direction: now and then with components of very different size, or along an axis.
static struct ap_vec3 a_vector(struct ref_random *r, double length) {
    struct ap_vec3 u = ref_direction(r);
    if (ref_uniform(r, 0, 1) < 0.3)
        u.y *= log_uniform(r, 1e-40, 1);
    if (ref_uniform(r, 0, 1) < 0.2)
        u.z = 0;
    return ap_vec3_scale(length / ap_vec3_length(u), u);
}

static void check_exp(int kappa, const char *name, double most) {
    struct worst w = start(name, 2e-15);
    for (long i = 0; i < samples; i++) {
        struct ap_space s = {kappa, a_radius(&w.random)};
        struct ap_vec3 v = a_vector(&w.random, s.rho_m * a_length(&w.random, most));
        if (is_worse(&w, ref_exp_error(s, v, ap_exp(s, v))))
            snprintf(w.at, sizeof w.at, "rho %.17g v %.17g %.17g %.17g", s.rho_m, v.x, v.y, v.z);
    }
    finish(&w);
}

static void test_exp(void **state) {
    (void)state;
    check_exp(-1, "exp h3 to 38 rho", 38);
    check_exp(0, "exp e3", 1e3);
    check_exp(1, "exp s3 to 40 rho", 40);
}

static void check_translate(int kappa, const char *name, double most) {
    struct worst w = start(name, 2e-15);
    for (long i = 0; i < samples; i++) {
        struct ap_space s = {kappa, a_radius(&w.random)};
        struct ap_vec3 v = a_vector(&w.random, s.rho_m * a_length(&w.random, most));
        struct ap_iso m = ap_iso_translate(s, v);
        if (is_worse(&w, ref_walk_error(s, &v, 1, &m)))
            snprintf(w.at, sizeof w.at, "rho %.17g v %.17g %.17g %.17g", s.rho_m, v.x, v.y, v.z);
    }
    finish(&w);
}

static void test_translate(void **state) {
    (void)state;
    check_translate(-1, "translate h3 to 38 rho", 38);
    check_translate(0, "translate e3", 1e3);
    check_translate(1, "translate s3 to 40 rho", 40);
}

// Off the space by as much as the conventions allow, exactly on it half of the time.
static struct ap_vec4 off_space(struct ref_random *r, struct ap_space s, struct ap_vec4 p) {
    if (ref_uniform(r, 0, 1) < 0.5)
        p.w += ref_uniform(r, -5e-10, 5e-10) * (s.kappa < 0 ? p.w : s.rho_m);
    return p;
}

static struct ap_vec4 a_point(struct ref_random *r, struct ap_space s, double most) {
    double t = a_length(r, most);
    struct ap_vec3 v = a_vector(r, s.rho_m * t);
    struct ap_vec4 p = ap_exp(s, v);
    if (s.kappa > 0 && ref_uniform(r, 0, 1) < 0.4) { // near the antipode
        p.w = -s.rho_m;
        double size = log_uniform(r, 1e-150, 1e-5);
        p.x = size * (v.x / t);
        p.y = size * (v.y / t);
        p.z = size * (v.z / t);
    }
    return off_space(r, s, p);
}

static void check_log(int kappa, int image, const char *name, double most) {
    struct worst w = start(name, 2e-15);
    for (long i = 0; i < samples; i++) {
        struct ap_space s = {kappa, a_radius(&w.random)};
        struct ap_vec4 p = a_point(&w.random, s, most);
        struct ap_vec3 v;
        struct ap_error err = {""};
        if (ap_log_map(&err, s, p, image, &v))
            fail_msg("%s: %s", name, err.text);
        if (is_worse(&w, ref_log_error(s, p, image, v)))
            snprintf(w.at, sizeof w.at, "rho %.17g p %.17g %.17g %.17g %.17g", s.rho_m, p.x, p.y,
                     p.z, p.w);
    }
    finish(&w);
}

static void test_log(void **state) {
    (void)state;
    check_log(-1, 0, "log h3 to 300 rho", 300);
    check_log(0, 0, "log e3", 1e3);
    check_log(1, 0, "log s3", 3.14);
    check_log(1, 1, "log s3, the long way", 3.14);
}

enum { STEPS = 5 };

static void check_walk(int kappa, const char *name, bool home) {
    struct worst w = start(name, 2e-15);
    for (long i = 0; i < samples / 4 + 1; i++) {
        struct ap_space s = {kappa, a_radius(&w.random)};
        struct ap_vec3 v[STEPS];
        for (int k = 0; k < STEPS; k++)
            v[k] = a_vector(&w.random, 0.6 * s.rho_m);
        if (home) { // out and back: what was large must cancel
            v[3] = ap_vec3_scale(-1, v[1]);
            v[2] = ap_vec3_scale(1e-9, v[2]);
            v[4] = ap_vec3_scale(-1, v[0]);
        }
        struct ap_iso m = ap_iso_walk(s, v, STEPS);
        if (is_worse(&w, ref_walk_error(s, v, STEPS, &m)))
            snprintf(w.at, sizeof w.at, "rho %.17g, step %ld of the seed", s.rho_m, i);
    }
    finish(&w);
}

static void test_walk(void **state) {
    (void)state;
    check_walk(-1, "walk h3", false);
    check_walk(0, "walk e3", false);
    check_walk(1, "walk s3", false);
    check_walk(-1, "walk h3, home again", true);
    check_walk(1, "walk s3, home again", true);
}

static void check_long_walk(int kappa, const char *name, double length) {
    struct worst w = start(name, 2e-15);
    enum { MOST = 40 };
    for (long i = 0; i < samples / 40 + 1; i++) {
        struct ap_space s = {kappa, a_radius(&w.random)};
        struct ap_vec3 v[MOST];
        for (int k = 0; k < MOST; k++)
            v[k] = a_vector(&w.random, s.rho_m * a_length(&w.random, length));
        struct ap_iso m = ap_iso_walk(s, v, MOST);
        if (is_worse(&w, ref_walk_error(s, v, MOST, &m)))
            snprintf(w.at, sizeof w.at, "rho %.17g, walk %ld of the seed", s.rho_m, i);
    }
    finish(&w);
}

static void test_long_walk(void **state) {
    (void)state;
    check_long_walk(-1, "walk h3, 40 steps to 2 rho", 2);
    check_long_walk(1, "walk s3, 40 steps to 40 rho", 40);
}

static struct ap_vec4 neighbour(struct ref_random *r, struct ap_space s, struct ap_vec4 p) {
    double step = log_uniform(r, 1e-18, 1);
    struct ap_vec3 d = a_vector(r, step * (s.kappa < 0 ? p.w : s.rho_m));
    double sign = s.kappa > 0 && ref_uniform(r, 0, 1) < 0.5 ? -1 : 1;
    struct ap_vec3 q = ap_vec3_scale(sign, ap_vec3_add((struct ap_vec3){p.x, p.y, p.z}, d));
    double n = ap_vec3_length(q), rho = s.rho_m;
    if (s.kappa > 0 && n < rho)
        return (struct ap_vec4){q.x, q.y, q.z, copysign(sqrt((rho - n) * (rho + n)), sign * p.w)};
    if (s.kappa > 0)
        return ap_exp(s, q);
    return (struct ap_vec4){q.x, q.y, q.z, s.kappa ? hypot(n, rho) : rho};
}

static void check_dist(int kappa, const char *name, double most) {
    struct worst w = start(name, 1.2e-15);
    for (long i = 0; i < samples; i++) {
        struct ap_space s = {kappa, a_radius(&w.random)};
        struct ap_vec4 p = a_point(&w.random, s, most), q = a_point(&w.random, s, most);
        if (ref_uniform(&w.random, 0, 1) < 0.5)
            q = off_space(&w.random, s, neighbour(&w.random, s, p));
        double d = NAN, back = NAN;
        struct ap_error err = {""};
        if (ap_distance(&err, s, p, q, &d) || ap_distance(&err, s, q, p, &back))
            fail_msg("%s: %s", name, err.text);
        if (d != back)
            fail_msg("%s: not symmetric: %.17g and %.17g", name, d, back);
        if (is_worse(&w, ref_dist_error(s, p, q, d)))
            snprintf(w.at, sizeof w.at, "%.17g: %.17g %.17g %.17g %.17g  %.17g %.17g %.17g %.17g",
                     s.rho_m, p.x, p.y, p.z, p.w, q.x, q.y, q.z, q.w);
    }
    finish(&w);
}

static void test_dist(void **state) {
    (void)state;
    check_dist(-1, "dist h3 to 40 rho", 40);
    check_dist(-1, "dist h3 to 2 rho", 2);
    check_dist(0, "dist e3", 1e3);
    check_dist(1, "dist s3", 3.14);
}

static void check_vergence(int kappa, bool tourist, const char *name) {
    struct worst w = start(name, 2e-15);
    const double quarter = 1.5707963267948966;
    for (long i = 0; i < samples; i++) {
        struct ap_space s = {kappa, a_radius(&w.random)};
        double ipd = s.rho_m * log_uniform(&w.random, 1e-6, 3);
        double t = a_length(&w.random, kappa > 0 ? 4 * quarter * 0.9999999 : 50);
        if (ref_uniform(&w.random, 0, 1) < 0.5) // next to the quarter turns
            t = quarter * floor(ref_uniform(&w.random, 1, 4)) +
                ref_uniform(&w.random, -1, 1) * log_uniform(&w.random, 1e-17, 1);
        double got, d = t * s.rho_m;
        struct ap_error err = {""};
        enum ap_view_mode mode = tourist ? AP_VIEW_TOURIST : AP_VIEW_NATIVE;
        if (ap_vergence_ahead(&err, s, mode, ipd, d, &got))
            fail_msg("%s: %s", name, err.text);
        if (is_worse(&w, ref_vergence_error(s, tourist, ipd, d, got)))
            snprintf(w.at, sizeof w.at, "rho %.17g ipd %.17g d %.17g", s.rho_m, ipd, d);
    }
    finish(&w);
}

static void test_vergence(void **state) {
    (void)state;
    check_vergence(1, false, "vergence native");
    check_vergence(-1, true, "vergence tourist h3");
    check_vergence(0, true, "vergence tourist e3");
    check_vergence(1, true, "vergence tourist s3");
}

static int finish_all(void **state) {
    (void)state;
    ref_finish();
    return 0;
}

int main(int argc, char **argv) {
    if (argc > 1)
        samples = atol(argv[1]);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_exp),       cmocka_unit_test(test_translate),
        cmocka_unit_test(test_log),       cmocka_unit_test(test_walk),
        cmocka_unit_test(test_long_walk), cmocka_unit_test(test_dist),
        cmocka_unit_test(test_vergence),
    };
    return cmocka_run_group_tests(tests, NULL, finish_all);
}
