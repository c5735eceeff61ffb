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

#include "src/device/fusion/clockmap.h"

static uint64_t seed = 1;

static double uniform(void) { // 0 … 1
    seed = seed * 6364136223846793005u + 1442695040888963407u;
    return (double)(seed >> 11) / 9007199254740992.0;
}

// A device whose clock runs by `ppm` off the host's, and whose reports come late by at least
// 100 µs, mostly by little more and now and then by much.
struct device {
    struct ap_clockmap_params clock;
    double period_ns, ppm, first_ticks;
    double loss, stall; // chances
    int64_t queue_until_ns, last_arrival_ns;
};

static const double LEAST_NS = 100000;

static uint64_t ticks_at(const struct device *d, double host_ns) {
    double device_ns = host_ns * (1 - d->ppm * 1e-6);
    double ticks = device_ns * (double)d->clock.tick_ns_den / (double)d->clock.tick_ns_num;
    uint64_t whole = (uint64_t)floor(ticks) + (uint64_t)d->first_ticks;
    return d->clock.bits == 64 ? whole : whole & ((UINT64_C(1) << d->clock.bits) - 1);
}

static int64_t arrival_of(struct device *d, double host_ns) {
    double delay = LEAST_NS - 150000 * log(1 - 0.999 * uniform());
    if (uniform() < d->stall)
        d->queue_until_ns = (int64_t)(host_ns + 2.4e8 * uniform());
    int64_t arrival = (int64_t)(host_ns + delay);
    if (arrival < d->queue_until_ns)
        arrival = d->queue_until_ns; // the reader was away: all come at once
    if (arrival < d->last_arrival_ns)
        arrival = d->last_arrival_ns;
    return d->last_arrival_ns = arrival;
}

struct outcome {
    double worst_ns, rms_ns, ppm; // after 10 s, against the true time + the least delay
    int64_t restarts, samples;
};

static struct outcome run(struct device *d, double seconds) {
    struct ap_clockmap map;
    assert_true(ap_clockmap_init(&map, &d->clock));
    struct outcome o = {0};
    int64_t last = INT64_MIN, t;
    double squares = 0;
    const double boot = 5e12; // the host's clock does not begin at zero
    d->last_arrival_ns = d->queue_until_ns = 0;
    for (double at = 0; at < seconds * 1e9; at += d->period_ns) {
        if (uniform() < d->loss)
            continue;
        int64_t arrival = arrival_of(d, boot + at);
        ap_clockmap_add(&map, ticks_at(d, boot + at), arrival, &t);
        if (t <= last || t > arrival + 1000)
            fail_msg("at %g ns: %" PRId64 " after %" PRId64 ", arrived %" PRId64, at, t, last,
                     arrival);
        last = t;
        if (at < 1e10)
            continue;
        double error = (double)t - (boot + at + LEAST_NS);
        o.worst_ns = fmax(o.worst_ns, fabs(error));
        squares += error * error;
        o.samples++;
    }
    o.rms_ns = sqrt(squares / (double)o.samples);
    o.ppm = ap_clockmap_drift_ppm(&map);
    o.restarts = map.restarts;
    return o;
}

static void check(const char *what, double got, double limit) {
    if (!(got <= limit))
        fail_msg("%s: %.6g, at most %.6g allowed", what, got, limit);
}

static const struct {
    const char *name;
    struct device device;
} devices[] = {
    {"DualSense, wraps at once",
     {.clock = {.bits = 32, .tick_ns_num = 1000, .tick_ns_den = 3}, .period_ns = 4e6}},
    {"DS4, wraps every 0.35 s",
     {.clock = {.bits = 16, .tick_ns_num = 16000, .tick_ns_den = 3}, .period_ns = 4e6}},
    {"XREAL", {.clock = {.bits = 64, .tick_ns_num = 1, .tick_ns_den = 1}, .period_ns = 1e6}},
    {"PSVR, 24 bits of 1 µs",
     {.clock = {.bits = 24, .tick_ns_num = 1000, .tick_ns_den = 1}, .period_ns = 2e6}},
    {"Rift, ms in 16 bits",
     {.clock = {.bits = 16, .tick_ns_num = 1000000, .tick_ns_den = 1}, .period_ns = 2e6}},
};

// Jitter, 1 % loss, and the clocks 100 ppm apart both ways.
static void test_drift(void **unused) {
    (void)unused;
    for (size_t i = 0; i < sizeof devices / sizeof devices[0]; i++)
        for (double ppm = -100; ppm <= 100; ppm += 50) {
            struct device d = devices[i].device;
            d.ppm = ppm;
            d.loss = 0.01;
            d.first_ticks = d.clock.bits == 32 ? 4294967296.0 - 6e6 : 0; // 2 s before the wrap
            struct outcome o = run(&d, 40);
            double tick_ns = (double)d.clock.tick_ns_num / (double)d.clock.tick_ns_den;
            print_message("%s, %+.0f ppm: worst %.1f µs, rms %.1f µs, drift %.2f ppm\n",
                          devices[i].name, ppm, o.worst_ns / 1e3, o.rms_ns / 1e3, o.ppm);
            check("worst, ns", o.worst_ns, 20000 + 1.05 * tick_ns);
            // A line through least delays of some µs each, 20 s long. Ticks of a millisecond hide
            // the drift: both clocks may step together for 10 s.
            if (tick_ns < 1e5)
                check("drift, ppm", fabs(o.ppm - ppm), 1);
            assert_int_equal(o.restarts, 1);
        }
}

// The reader is away for up to 240 ms now and then; what waited in the queue is dated right.
static void test_stale_queue(void **unused) {
    (void)unused;
    for (size_t i = 0; i < 4; i++) {
        struct device d = devices[i].device;
        d.ppm = 40;
        d.stall = 0.0005;
        struct outcome o = run(&d, 60);
        check("worst, ns", o.worst_ns, 100000);
        assert_int_equal(o.restarts, 1);
    }
}

struct feed {
    struct ap_clockmap map;
    int64_t t_ns;
};

static struct feed feed_of(const struct ap_clockmap_params *params) {
    struct feed f = {.t_ns = 0};
    assert_true(ap_clockmap_init(&f.map, params));
    return f;
}

static void expect(struct feed *f, uint64_t raw, int64_t host_ns, enum ap_clock_event event,
                   int64_t t_ns) {
    enum ap_clock_event got = ap_clockmap_add(&f->map, raw, host_ns, &f->t_ns);
    if (got != event || llabs(f->t_ns - t_ns) > 1)
        fail_msg("raw %" PRIu64 " at %" PRId64 ": event %d, time %" PRId64
                 "; expected event %d, time %" PRId64,
                 raw, host_ns, got, f->t_ns, event, t_ns);
}

static const int64_t MS = 1000000;

// Whole thirds of a microsecond add up exactly through the wrap.
static void test_exact_wrap(void **unused) {
    (void)unused;
    struct feed f =
        feed_of(&(struct ap_clockmap_params){.bits = 32, .tick_ns_num = 1000, .tick_ns_den = 3});
    uint32_t raw = UINT32_MAX - 5;
    expect(&f, raw, 1000 * MS, AP_CLOCK_RESTARTED, 1000 * MS);
    for (int64_t i = 1; i <= 30000; i++)
        expect(&f, (uint32_t)(raw + i * 10), 1000 * MS + i * 10000 / 3, AP_CLOCK_OK,
               1000 * MS + i * 10000 / 3);
}

static void test_repeat_and_restart(void **unused) {
    (void)unused;
    struct feed f =
        feed_of(&(struct ap_clockmap_params){.bits = 32, .tick_ns_num = 1000, .tick_ns_den = 1});
    expect(&f, 500000, 0, AP_CLOCK_RESTARTED, 0);
    for (int64_t i = 1; i < 100; i++)
        expect(&f, (uint64_t)(500000 + i * 1000), i * MS, AP_CLOCK_OK, i * MS);
    expect(&f, 599000, 99 * MS + 500, AP_CLOCK_REPEATED, 99 * MS);
    // The device restarts: its counter is back at 0.
    expect(&f, 0, 120 * MS, AP_CLOCK_RESTARTED, 120 * MS);
    expect(&f, 1000, 121 * MS, AP_CLOCK_OK, 121 * MS);
    // It jumps a day ahead, and back.
    expect(&f, 86400000000u % 4294967296u, 122 * MS, AP_CLOCK_RESTARTED, 122 * MS);
    expect(&f, 2000, 123 * MS, AP_CLOCK_RESTARTED, 123 * MS);
    // Unplugged for two seconds: the counter may be anything.
    expect(&f, 2500, 2200 * MS, AP_CLOCK_RESTARTED, 2200 * MS);
    assert_int_equal(f.map.restarts, 5);
    // Sent twice in a row with an arrival before the last one: nothing goes back.
    expect(&f, 2500, 2100 * MS, AP_CLOCK_REPEATED, 2200 * MS);
    expect(&f, 3500, 2100 * MS, AP_CLOCK_OK, 2200 * MS + 1);
}

// A day back in 64 bits, and a counter that stands still for half a second (its step is then too
// small for good): the map finds itself again within a second and a bit.
static void test_lost_step(void **unused) {
    (void)unused;
    struct feed f =
        feed_of(&(struct ap_clockmap_params){.bits = 64, .tick_ns_num = 1, .tick_ns_den = 1});
    uint64_t day = UINT64_C(86400000000000);
    expect(&f, day, 0, AP_CLOCK_RESTARTED, 0);
    expect(&f, day + 1000000, MS, AP_CLOCK_OK, MS);
    expect(&f, 7, 2 * MS, AP_CLOCK_RESTARTED, 2 * MS);
    int64_t host = 502 * MS, restarts = f.map.restarts;
    uint64_t raw = 7;
    for (int i = 0; i < 1100; i++) {
        raw += 1000000;
        host += MS;
        ap_clockmap_add(&f.map, raw, host, &f.t_ns);
    }
    assert_int_equal(f.map.restarts, restarts + 1);
    expect(&f, raw + 1000000, host + MS, AP_CLOCK_OK, host + MS);
}

// DS4: a hole longer than its wrap of 0.35 s.
static void test_hole_over_a_wrap(void **unused) {
    (void)unused;
    struct feed f =
        feed_of(&(struct ap_clockmap_params){.bits = 16, .tick_ns_num = 16000, .tick_ns_den = 3});
    expect(&f, 0, 0, AP_CLOCK_RESTARTED, 0);
    int64_t t = 800 * MS;
    expect(&f, (uint64_t)(t * 3 / 16000) & 0xffff, t, AP_CLOCK_OK, t / 16000 * 16000);
    t += 900 * MS;
    expect(&f, (uint64_t)(t * 3 / 16000) & 0xffff, t, AP_CLOCK_OK, t / 16000 * 16000);
}

// Whatever comes, the times increase.
static void test_garbage(void **unused) {
    (void)unused;
    static const int bits[] = {8, 16, 24, 32, 63, 64};
    for (int b = 0; b < 6; b++) {
        struct feed f = feed_of(&(struct ap_clockmap_params){
            .bits = bits[b], .tick_ns_num = 5000000, .tick_ns_den = 7});
        int64_t last = INT64_MIN, host = 0;
        uint64_t raw = 0;
        for (int i = 0; i < 50000; i++) {
            double dice = uniform();
            raw = dice < 0.01 ? (uint64_t)(uniform() * 1.8e19) : raw + (uint64_t)(20 * uniform());
            host = dice > 0.999   ? (int64_t)(uniform() * 1e15) - (int64_t)1e14
                   : dice > 0.998 ? INT64_MIN
                                  : host + (int64_t)(1e7 * uniform());
            enum ap_clock_event event = ap_clockmap_add(&f.map, raw, host, &f.t_ns);
            if (event == AP_CLOCK_REPEATED ? f.t_ns != last : f.t_ns <= last)
                fail_msg("%" PRId64 " after %" PRId64, f.t_ns, last);
            last = f.t_ns;
        }
        assert_true(fabs(ap_clockmap_drift_ppm(&f.map)) <= 500);
    }
}

static void test_params(void **unused) {
    (void)unused;
    struct ap_clockmap map;
    const struct ap_clockmap_params wrong[] = {
        {0},
        {.bits = 32},
        {.bits = 65, .tick_ns_num = 1, .tick_ns_den = 1},
        {.bits = 7, .tick_ns_num = 1000000, .tick_ns_den = 1},
        {.bits = 32, .tick_ns_num = 1, .tick_ns_den = 0},
        {.bits = 32, .tick_ns_num = -1, .tick_ns_den = 1},
        {.bits = 8, .tick_ns_num = 1, .tick_ns_den = 1}, // wraps in 256 ns
        {.bits = 32, .tick_ns_num = 1, .tick_ns_den = 1, .gap_ns = -1},
        {.bits = 32, .tick_ns_num = 1, .tick_ns_den = 1, .drift_max_ppm = (double)NAN},
    };
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++)
        if (ap_clockmap_init(&map, &wrong[i]))
            fail_msg("parameters %zu were taken", i);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_drift),      cmocka_unit_test(test_stale_queue),
        cmocka_unit_test(test_exact_wrap), cmocka_unit_test(test_repeat_and_restart),
        cmocka_unit_test(test_lost_step),  cmocka_unit_test(test_hole_over_a_wrap),
        cmocka_unit_test(test_garbage),    cmocka_unit_test(test_params),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
