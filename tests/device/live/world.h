#ifndef ANTIPODE_TESTS_DEVICE_LIVE_WORLD_H
#define ANTIPODE_TESTS_DEVICE_LIVE_WORLD_H

// cmocka wants these first.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <stdio.h>
#include <stdlib.h>

#include "src/device/live/live.h"
#include "tests/device/hid/bytes_of.h"
#include "tests/device/live/devices.h"

// Live devices over the fake bus: the test sets the clock, and waits until everybody has done what
// there was to do.

static const int64_t MS = 1000000, START_NS = 1000000000;

struct world {
    struct fake_bus *fake;
    struct ap_live *live;
    int64_t now_ns;
};

static inline struct world begin(const struct ap_live_params *params) {
    struct world w = {.fake = fake_bus_create(START_NS), .now_ns = START_NS};
    struct ap_live_params p = params ? *params : (struct ap_live_params){0};
    struct ap_live_bus way = fake_way(w.fake);
    p.buses = &way;
    p.bus_count = 1;
    struct ap_error err = {""};
    if (ap_live_open(&err, &p, &w.live))
        fail_msg("%s", err.text);
    return w;
}

static inline void end(struct world *w) {
    ap_live_close(w->live);
    assert_true(w->fake->destroyed);
    fake_bus_free(w->fake);
}

static inline void settle(struct world *w) {
    assert_true(fake_settle(w->fake));
}

static inline void step(struct world *w, int64_t ns) {
    w->now_ns += ns;
    fake_set_now(w->fake, w->now_ns);
}

static inline struct ap_live_device device_at(struct world *w, int device) {
    static struct ap_live_device d;
    ap_live_device_at(w->live, device, &d);
    return d;
}

static inline void expect_near(const char *what, double got, double want, double tolerance) {
    if (!(fabs(got - want) <= tolerance))
        fail_msg("%s: %.9g, expected %.9g within %g", what, got, want, tolerance);
}

static inline void expect_state(struct world *w, int role, enum ap_pose_state want) {
    struct ap_live_answer a = ap_live_at(w->live, role, w->now_ns);
    if (a.state != want)
        fail_msg("%s: state %d, expected %d", ap_live_role_name(w->live, role), (int)a.state,
                 (int)want);
}

// A turning head, 10 ms a report.
static inline void play_slimevr(struct world *w, int device, int count, double from_rad,
                                double step_rad) {
    for (int i = 0; i < count; i++) {
        step(w, 10 * MS);
        send_slimevr(w->fake, device, from_rad + i * step_rad, 0);
        settle(w);
    }
}

#endif
