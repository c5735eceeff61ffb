#include <inttypes.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "src/device/fusion/vqf.h"
#include "src/device/poselog.h"
#include "tests/device/fusion/broad.h"
#include "tests/device/memory_file.h"

static const double DEGREE = 3.14159265358979323846 / 180;
static const double PERIOD_S = 0.005;

static uint64_t seed = 1;

static double uniform(void) { // −1 … 1
    seed = seed * 6364136223846793005u + 1442695040888963407u;
    return (double)(int64_t)seed / 9223372036854775808.0;
}

static double noise(double sigma) {
    return sigma * (uniform() + uniform() + uniform());
}

static struct ap_vec3 noise3(double sigma) {
    return (struct ap_vec3){noise(sigma), noise(sigma), noise(sigma)};
}

static void check(const char *what, double got, double limit) {
    if (!(got <= limit))
        fail_msg("%s: %.6g, at most %.6g allowed", what, got, limit);
}

// A head that turns and sways after a rest of rest_s; the truth is integrated in steps sixteen
// times as fine.
struct simulation {
    struct ap_quat q; // sensor to earth
    struct ap_vec3 bias;
    double t_s, rest_s, rate_noise, force_noise;
    struct ap_vec3 gyr, acc; // the newest readings
};

static struct ap_vec3 rate_at(const struct simulation *s, double t_s) {
    double on = t_s > s->rest_s ? fmin(1, t_s - s->rest_s) : 0;
    return (struct ap_vec3){on * 1.1 * sin(1.7 * t_s), on * 1.5 * sin(0.9 * t_s + 1),
                            on * 0.8 * sin(2.3 * t_s + 2)};
}

static void simulate(struct simulation *s, double dt_s) {
    struct ap_quat before = s->q;
    for (int i = 0; i < 16; i++) {
        struct ap_vec3 w = rate_at(s, s->t_s + (i + 0.5) * dt_s / 16);
        double size = ap_vec3_length(w);
        if (size > 0)
            s->q = ap_quat_mul(
                s->q, ap_quat_from_axis_angle(ap_vec3_scale(1 / size, w), size * dt_s / 16));
    }
    s->q = ap_quat_normalize(s->q);
    s->t_s += dt_s;
    struct ap_quat step = ap_quat_mul(ap_quat_conj(before), s->q);
    double half = asin(fmin(1, hypot(hypot(step.x, step.y), step.z)));
    double k = half > 0 ? 2 * half / (sin(half) * dt_s) : 2 / dt_s;
    struct ap_vec3 rate = {k * step.x, k * step.y, k * step.z};
    s->gyr = ap_vec3_add(ap_vec3_add(rate, s->bias), noise3(s->rate_noise));
    double on = s->t_s > s->rest_s ? 1 : 0;
    struct ap_vec3 force = {on * sin(5 * s->t_s), 9.81 + on * sin(7 * s->t_s),
                            on * sin(3.1 * s->t_s)};
    s->acc = ap_vec3_add(ap_quat_rotate(ap_quat_conj(s->q), force), noise3(s->force_noise));
}

static struct simulation head(double rest_s) {
    struct simulation s = {.q = ap_quat_from_axis_angle((struct ap_vec3){0.6, 0, 0.8}, 0.7),
                           .bias = {0.3 * DEGREE, -0.4 * DEGREE, 0.5 * DEGREE},
                           .rest_s = rest_s,
                           .rate_noise = 0.05 * DEGREE,
                           .force_noise = 0.03};
    return s;
}

static struct ap_vqf start(const struct ap_vqf_params *params) {
    struct ap_vqf v;
    assert_true(ap_vqf_init(&v, params));
    return v;
}

// Angles of the error in earth axes, degrees: from the vertical, and about it.
static double inclination(struct ap_quat estimate, struct ap_quat truth) {
    struct ap_quat d = ap_quat_mul(estimate, ap_quat_conj(truth));
    return 2 * acos(fmin(1, hypot(d.y, d.w))) / DEGREE;
}

static double heading(struct ap_quat estimate, struct ap_quat truth) {
    struct ap_quat d = ap_quat_mul(estimate, ap_quat_conj(truth));
    return remainder(2 * atan2(d.y, d.w) / DEGREE, 360);
}

static double bias_error(const struct ap_vqf *v, const struct simulation *s) {
    return ap_vec3_length(ap_vec3_sub(v->bias, s->bias)) / DEGREE;
}

// Rest of 6 s, then a minute of motion.
static void test_rest_then_motion(void **unused) {
    (void)unused;
    struct simulation s = head(6);
    struct ap_vqf v = start(&(struct ap_vqf_params){.period_s = PERIOD_S});
    double square = 0, offset = 0;
    int n = 0, rest = 0;
    while (s.t_s < 66) {
        simulate(&s, PERIOD_S);
        assert_true(ap_vqf_update(&v, s.gyr, s.acc, PERIOD_S));
        struct ap_quat q = ap_vqf_orientation(&v);
        if (s.t_s < 6) {
            rest += v.at_rest;
            offset = heading(q, s.q);
            continue;
        }
        double e = inclination(q, s.q);
        square += e * e;
        n++;
        if (s.t_s > 8 && v.at_rest)
            fail_msg("at rest in motion, t = %g s", s.t_s);
    }
    assert_in_range(rest, (int)(4.2 / PERIOD_S), (int)(4.6 / PERIOD_S)); // all but the first 1.5 s
    check("inclination RMS, degrees", sqrt(square / n), 0.4);
    check("bias, degrees a second", bias_error(&v, &s), 0.02);
    check("heading, degrees in a minute",
          fabs(remainder(heading(ap_vqf_orientation(&v), s.q) - offset, 360)), 1);
    check("sigma of the bias, degrees a second", ap_vqf_bias_sigma(&v) / DEGREE, 0.1);
}

// Never at rest: the bias is found from the tilt alone, and is what the heading owes.
static void test_motion_only(void **unused) {
    (void)unused;
    double wrong[2];
    for (int off = 0; off < 2; off++) {
        seed = 2;
        struct simulation s = head(0);
        struct ap_vqf v =
            start(&(struct ap_vqf_params){.period_s = PERIOD_S, .no_motion_bias = off});
        while (s.t_s < 150) {
            simulate(&s, PERIOD_S);
            ap_vqf_update(&v, s.gyr, s.acc, PERIOD_S);
            assert_false(v.at_rest);
        }
        wrong[off] = bias_error(&v, &s);
    }
    check("bias from motion, degrees a second", wrong[0], 0.2);
    check("(without it the test says nothing)", 0.7, wrong[1]);
}

static void test_rest_alone(void **unused) {
    (void)unused;
    struct simulation s = head(1e9);
    struct ap_vqf v = start(&(struct ap_vqf_params){.period_s = PERIOD_S, .no_motion_bias = true});
    for (int i = 0; i < 2000; i++) {
        simulate(&s, PERIOD_S);
        ap_vqf_update(&v, s.gyr, s.acc, PERIOD_S);
    }
    check("bias at rest, degrees a second", bias_error(&v, &s), 0.01);
    check("inclination at rest, degrees", inclination(ap_vqf_orientation(&v), s.q), 0.1);
    struct ap_vec3 bias = v.bias;
    ap_vqf_restart(&v);
    assert_memory_equal(&v.bias, &bias, sizeof bias);
    simulate(&s, PERIOD_S);
    ap_vqf_update(&v, s.gyr, s.acc, PERIOD_S); // level after one sample
    check("inclination after a restart, degrees", inclination(ap_vqf_orientation(&v), s.q), 1);
}

// A sensor that lies upside down, the one place where the shortest way up is not unique.
static void test_upside_down(void **unused) {
    (void)unused;
    struct ap_vqf v = start(&(struct ap_vqf_params){.period_s = PERIOD_S});
    for (int i = 0; i < 1000; i++)
        ap_vqf_update(&v, (struct ap_vec3){0, 0, 0}, (struct ap_vec3){0, -9.81, 0}, PERIOD_S);
    struct ap_vec3 up = ap_quat_rotate(ap_vqf_orientation(&v), (struct ap_vec3){0, -1, 0});
    check("up is down, m", ap_vec3_length(ap_vec3_sub(up, (struct ap_vec3){0, 1, 0})), 1e-9);
}

// The rate is integrated over the time that passed, not over the nominal period.
static void test_uneven_steps(void **unused) {
    (void)unused;
    struct simulation s = head(3);
    struct ap_vqf v = start(&(struct ap_vqf_params){.period_s = PERIOD_S});
    double worst = 0;
    while (s.t_s < 30) {
        double dt_s = PERIOD_S * (1 + 0.8 * uniform());
        simulate(&s, dt_s);
        ap_vqf_update(&v, s.gyr, s.acc, dt_s);
        if (s.t_s > 3)
            worst = fmax(worst, inclination(ap_vqf_orientation(&v), s.q));
    }
    check("inclination, degrees", worst, 1.5);
}

static bool state_is_sane(const struct ap_vqf *v) {
    struct ap_quat q = ap_vqf_orientation(v);
    double size = sqrt(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w);
    double limit = v->params.bias_clip * DEGREE * 1.0000001;
    bool ok = fabs(size - 1) < 1e-9 && fabs(v->bias.x) <= limit && fabs(v->bias.y) <= limit &&
              fabs(v->bias.z) <= limit && isfinite(v->rest_s);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            ok = ok && isfinite(v->covariance[i][j]) && v->covariance[i][i] >= 0;
    return ok;
}

static void test_rejects(void **unused) {
    (void)unused;
    struct ap_vqf v = start(&(struct ap_vqf_params){.period_s = PERIOD_S});
    const struct ap_vec3 still = {0, 0, 0}, g = {0, 9.81, 0};
    ap_vqf_update(&v, still, g, PERIOD_S);
    const double bad[] = {(double)NAN, (double)INFINITY, -(double)INFINITY, 1e300, -1e10};
    struct ap_vqf before = v;
    for (int i = 0; i < 5; i++)
        for (int axis = 0; axis < 3; axis++) {
            struct ap_vec3 x = {axis == 0 ? bad[i] : 0, axis == 1 ? bad[i] : 0,
                                axis == 2 ? bad[i] : 0};
            assert_false(ap_vqf_update(&v, x, g, PERIOD_S));
            assert_false(ap_vqf_update(&v, still, x, PERIOD_S));
        }
    const double times[] = {0, -PERIOD_S, 0.6, (double)NAN, (double)INFINITY, -(double)INFINITY};
    for (int i = 0; i < 6; i++)
        assert_false(ap_vqf_update(&v, still, g, times[i]));
    assert_int_equal(v.rejected, 36);
    assert_int_equal(v.accepted, 1);
    v.rejected = before.rejected;
    assert_memory_equal(&v, &before, sizeof v);
    assert_true(ap_vqf_update(&v, still, still, PERIOD_S)); // no force: integrated
    struct ap_vqf other = v;
    const struct ap_vqf_params wrong[] = {{0},
                                          {.period_s = -1},
                                          {.period_s = (double)NAN},
                                          {.period_s = 1},
                                          {.period_s = 0.01, .tau_acc_s = 0.001},
                                          {.period_s = 0.01, .bias_clip = (double)INFINITY},
                                          {.period_s = 0.01, .rest_acc = -1}};
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++)
        assert_false(ap_vqf_init(&other, &wrong[i]));
    assert_memory_equal(&other, &v, sizeof v);
}

// Anything within the limits, however wild, leaves a state that can go on; and it recovers.
static void test_wild_input(void **unused) {
    (void)unused;
    struct ap_vqf v = start(&(struct ap_vqf_params){.period_s = PERIOD_S});
    for (int i = 0; i < 200000; i++) {
        double rate = pow(10, 2 * uniform()), force = pow(10, 3.2 * uniform());
        struct ap_vec3 w = {rate * uniform(), rate * uniform(), rate * uniform()};
        struct ap_vec3 a = {force * uniform(), force * uniform(), force * uniform()};
        if (i / 5000 % 2)
            w = (struct ap_vec3){0, 0, 0}; // long enough to be taken for rest
        ap_vqf_update(&v, w, a, i % 7 ? PERIOD_S : 0.25 * (1 + uniform()));
        if (!state_is_sane(&v))
            fail_msg("the state went bad at sample %d", i);
    }
    for (int i = 0; i < 20000; i++)
        ap_vqf_update(&v, (struct ap_vec3){0, 0, 0}, (struct ap_vec3){0, 0, 9.81}, PERIOD_S);
    struct ap_vec3 up = ap_quat_rotate(ap_vqf_orientation(&v), (struct ap_vec3){0, 0, 1});
    check("up after it, m", ap_vec3_length(ap_vec3_sub(up, (struct ap_vec3){0, 1, 0})), 1e-6);
    check("bias after it, degrees a second", ap_vec3_length(v.bias) / DEGREE, 0.01);
}

// The low-pass: a mean first, then a Butterworth filter of gain 1/√2 at its cut-off.
static void test_lowpass(void **unused) {
    (void)unused;
    struct ap_lowpass f;
    ap_lowpass_init(&f, 2, 0.5, PERIOD_S);
    double x[2] = {3, -4};
    for (int i = 0; i < 1000; i++) {
        double y[2];
        ap_lowpass_step(&f, x, y);
        check("constant", fabs(y[0] - 3) + fabs(y[1] + 4), 1e-11);
    }
    double most = 0, w = sqrt(2) / 0.5;
    ap_lowpass_init(&f, 1, 0.5, PERIOD_S);
    for (int i = 0; i < 20000; i++) {
        double y = sin(w * i * PERIOD_S);
        ap_lowpass_step(&f, &y, &y);
        if (i > 10000)
            most = fmax(most, fabs(y));
    }
    check("gain at the cut-off, from 1/√2", fabs(most - sqrt(0.5)), 1e-3);
}

// As recorded, and with the two clocks in step: the rates come 4.2 ms after the reference in both
// recordings, which is the sensor's own filter and no matter of the fusion.
static void check_broad(const char *name, double limit, double limit_in_step, double drift_limit) {
    const char *shared = getenv("ANTIPODE_SHARED");
    if (!shared) {
        print_message("skipped: ANTIPODE_SHARED is not set\n");
        skip();
    }
    char path[1024];
    snprintf(path, sizeof path, "%s/data/imu/%s.csv", shared, name);
    size_t count = 0;
    struct broad_row *rows = broad_read(path, &count);
    if (!rows || count < 17000)
        fail_msg("%s: %zu rows", path, count);
    struct ap_vqf v = start(&(struct ap_vqf_params){.period_s = BROAD_PERIOD_S});
    struct broad_errors raw = {0}, in_step = {0};
    double lag_s = broad_lag_s(rows, count);
    check("the rates' lag, ms, from 4.2", fabs(1e3 * lag_s - 4.2), 0.1);
    for (size_t i = 0; i < count; i++) {
        struct broad_row row = broad_in_step(rows, i, lag_s);
        assert_true(ap_vqf_update(&v, rows[i].gyr, rows[i].acc, BROAD_PERIOD_S));
        broad_add(&raw, &rows[i], ap_vqf_orientation(&v));
        broad_add(&in_step, &row, ap_vqf_orientation(&v));
    }
    print_message("%s: rates %.2f ms late; inclination %.3f (in step %.3f) degrees RMS, drift %.2f "
                  "degrees a minute\n",
                  name, 1e3 * lag_s, broad_inclination_deg(&raw), broad_inclination_deg(&in_step),
                  broad_drift_deg_min(&raw));
    check("inclination, degrees RMS", broad_inclination_deg(&raw), limit);
    check("inclination in step, degrees RMS", broad_inclination_deg(&in_step), limit_in_step);
    check("heading drift, degrees a minute", fabs(broad_drift_deg_min(&raw)), drift_limit);
    free(rows);
}

static void test_broad_slow(void **unused) {
    (void)unused;
    check_broad("broad_05_60s", 0.4, 0.4, 2);
}

static void test_broad_fast(void **unused) {
    (void)unused;
    check_broad("broad_21_60s", 1.6, 1.1, 13.5);
}

// The same rows as EuRoC's imu0 would have them, read as a pose log: the orientation is the one
// that the filter gives, and a head's place goes with it.
static void test_broad_as_log(void **unused) {
    (void)unused;
    const char *shared = getenv("ANTIPODE_SHARED");
    if (!shared) {
        print_message("skipped: ANTIPODE_SHARED is not set\n");
        skip();
    }
    char path[1024];
    snprintf(path, sizeof path, "%s/data/imu/broad_05_60s.csv", shared);
    size_t count = 0, len = 0;
    struct broad_row *rows = broad_read(path, &count);
    assert_non_null(rows);
    size_t room = 200 * count;
    char *text = malloc(room);
    assert_non_null(text);
    for (size_t i = 0; i < count; i++)
        len += (size_t)snprintf(text + len, room - len, "%lld,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g\n",
                                3500000LL * (long long)i, rows[i].gyr.x, rows[i].gyr.y,
                                rows[i].gyr.z, rows[i].acc.x, rows[i].acc.y, rows[i].acc.z);
    struct memory_file file = memory_file(text, len);
    const char *source = file.path;
    struct ap_poselog_params params = {.sources = &source, .source_count = 1};
    struct ap_poselog *log = NULL;
    struct broad_errors errors = {0};
    assert_int_equal(ap_poselog_open(NULL, &params, &log), AP_OK);
    size_t i = 8; // the first ones only tell the rate
    for (bool got = true; got; i += got) {
        struct ap_sample sample;
        assert_int_equal(ap_poselog_next(NULL, log, &sample, &got), AP_OK);
        if (!got)
            break;
        assert_int_equal(sample.t_ns, 3500000 * (int64_t)i);
        double neck = ap_vec3_length(ap_vec3_sub(sample.pose.p, (struct ap_vec3){0, 1.5, 0}));
        check("from the neck, m", fabs(neck - 0.08 * sqrt(2)), 1e-12);
        broad_add(&errors, &rows[i], sample.pose.q);
    }
    assert_int_equal(i, count);
    print_message("as a log: inclination %.3f degrees RMS\n", broad_inclination_deg(&errors));
    check("inclination, degrees RMS", broad_inclination_deg(&errors), 0.4);
    ap_poselog_close(log);
    close(file.fd);
    free(text);
    free(rows);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_lowpass),      cmocka_unit_test(test_rest_then_motion),
        cmocka_unit_test(test_motion_only),  cmocka_unit_test(test_rest_alone),
        cmocka_unit_test(test_upside_down),  cmocka_unit_test(test_uneven_steps),
        cmocka_unit_test(test_rejects),      cmocka_unit_test(test_wild_input),
        cmocka_unit_test(test_broad_slow),   cmocka_unit_test(test_broad_fast),
        cmocka_unit_test(test_broad_as_log),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
