#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "sim_hmd/input/poses.h"
#include "sim_hmd/input/profiles.h"
#include "sim_hmd/window/input.h"
#include "src/base/clock.h"
#include "src/base/log.h"
#include "src/device/live/live.h"
#include "src/device/live/mounts.h"

// What is plugged in: head and hands are where their trackers are, predicted to the time that is
// asked for. With a window its keyboard and mouse stand in for whoever has no tracker. No call here
// waits for a device, but for create, which gives them a moment to start.

static const int64_t MS = 1000000;
static const int64_t START_MS = 2000, FIRST_POSE_MS = 400;

// How old the head's newest report was when a frame was shown; in steps of 0.1 ms.
enum { AGE_STEPS = 2000, AGE_STEP_NS = 100000 };

struct ages {
    int64_t ns; // of the frame that was asked for last; INT64_MIN: none
    int64_t newest_age_ns;
    bool is_lost;
    int64_t frames, lost, histogram[AGE_STEPS];
};

struct devices {
    struct ap_live *live;
    int64_t start_ns; // of the first frame, on the devices' clock
    uint32_t keys;
    void *window; // NULL: nobody stands in
    bool has_stats;
    struct ages *ages; // what `at` finds on its way; the runtime's lock is held
};

static const int roles[SIM_DEVICE_COUNT] = {
    [SIM_HEAD] = AP_LIVE_HEAD, [SIM_LEFT] = AP_LIVE_LEFT, [SIM_RIGHT] = AP_LIVE_RIGHT};

static void destroy(void *state);

static enum ap_status open_live(struct ap_error *err, const struct sim_device_settings *s,
                                struct ap_live **live) {
    struct ap_live_params params = {.assign = (const char *const *)s->assign.text,
                                    .assign_count = s->assign.count,
                                    .position = (const char *const *)s->position.text,
                                    .position_count = s->position.count,
                                    .ways = (const char *const *)s->bus.text,
                                    .way_count = s->bus.count};
    struct ap_live_bus way;
    struct ap_live_mounts mounts = {.count = 0};
    enum ap_status st = s->calibration ? ap_live_mounts_read(err, s->calibration, &mounts) : AP_OK;
    params.mounts = mounts.mounts;
    params.mount_count = (size_t)mounts.count;
    if (!st && s->replay.count) {
        st = ap_live_replay(err, (const char *const *)s->replay.text, s->replay.count, &way);
        params.buses = &way;
        params.bus_count = 1;
    }
    if (!st)
        st = ap_live_open(err, &params, live);
    ap_live_mounts_finish(&mounts);
    return st;
}

static void say_devices(const struct ap_live *live) {
    struct ap_live_device d;
    for (int i = 0; i < ap_live_device_count(live); i++) {
        ap_live_device_at(live, i, &d);
        if (d.why[0])
            ap_log(AP_LOG_WARNING, "%s", d.why);
        if (d.state == AP_LIVE_RUNNING || d.state == AP_LIVE_STARTING)
            ap_log(AP_LOG_INFO, "device: %s %s (%s)%s%s", d.place.name, d.place.serial,
                   d.driver->title, d.role[0][0] ? ", used as " : "", d.role[0]);
    }
}

// So that a program finds the head where it is, and not where nobody has been seen yet.
static void give_time(struct devices *d) {
    int64_t now_ns = ap_live_now_ns(d->live);
    if (!ap_live_settle(d->live, now_ns + START_MS * MS))
        ap_log(AP_LOG_WARNING, "a device takes long to start");
    int64_t until_ns = ap_live_now_ns(d->live) + FIRST_POSE_MS * MS;
    while ((now_ns = ap_live_now_ns(d->live)) < until_ns && ap_live_device_count(d->live) > 0 &&
           ap_live_at(d->live, AP_LIVE_HEAD, now_ns).state == AP_POSE_NONE)
        ap_clock_sleep_until_ns(ap_clock_now_ns() + 5 * MS);
    d->start_ns = now_ns;
    say_devices(d->live);
}

static enum ap_status create(struct ap_error *err, const struct sim_settings *settings,
                             void **state) {
    struct devices *d = calloc(1, sizeof *d);
    if (!d)
        return ap_fail(err, AP_ENVIRONMENT, "out of memory");
    d->ages = calloc(1, sizeof *d->ages);
    d->has_stats = settings->devices.stats;
    enum ap_status st = d->ages ? AP_OK : ap_fail(err, AP_ENVIRONMENT, "out of memory");
    if (!st)
        d->ages->ns = INT64_MIN;
    if (!st && settings->window)
        st = sim_poses_window.create(err, settings, &d->window);
    if (!st)
        st = open_live(err, &settings->devices, &d->live);
    if (st) {
        destroy(d);
        return st;
    }
    give_time(d);
    *state = d;
    return AP_OK;
}

// --- how old poses are when they are shown

static void count_age(struct ages *a) {
    if (a->ns == INT64_MIN)
        return;
    a->frames++;
    a->lost += a->is_lost;
    int64_t step = a->newest_age_ns / AGE_STEP_NS;
    if (!a->is_lost)
        a->histogram[step < 0 ? 0 : step < AGE_STEPS ? step : AGE_STEPS - 1]++;
}

// A frame may be asked for several times; the last answer is what it is drawn with.
static void note_age(struct ages *a, int64_t ns, const struct ap_live_answer *answer) {
    if (ns < a->ns)
        return;
    if (ns != a->ns)
        count_age(a);
    a->ns = ns;
    a->newest_age_ns = answer->age_ns;
    a->is_lost = answer->state == AP_POSE_LOST || answer->state == AP_POSE_NONE;
}

static double quantile_ms(const struct ages *a, double share) {
    int64_t wanted = (int64_t)ceil(share * (double)(a->frames - a->lost)), sum = 0;
    for (int i = 0; i < AGE_STEPS; i++) {
        sum += a->histogram[i];
        if (sum >= wanted)
            return (i + 0.5) * AGE_STEP_NS * 1e-6;
    }
    return NAN;
}

static void say_ages(struct ages *a) {
    count_age(a);
    if (a->frames > a->lost)
        ap_log(AP_LOG_INFO,
               "the head's newest report was %.1f ms old (median; 99 of 100: %.1f ms) when a frame "
               "was shown, in %lld frames; not tracked in %lld",
               quantile_ms(a, 0.5), quantile_ms(a, 0.99), (long long)(a->frames - a->lost),
               (long long)a->lost);
    else
        ap_log(AP_LOG_INFO, "the head was not tracked in any of %lld frames", (long long)a->frames);
}

// --- answers

static void destroy(void *state) {
    struct devices *d = state;
    if (!d)
        return;
    if (d->has_stats && d->live)
        say_ages(d->ages);
    ap_live_close(d->live);
    if (d->window)
        sim_poses_window.destroy(d->window);
    free(d->ages);
    free(d);
}

static void start(void *state, int64_t machine_ns) {
    struct devices *d = state;
    d->start_ns = machine_ns;
}

static enum ap_pose_state at(const void *state, enum sim_device device, int64_t ns,
                             struct ap_sample *sample) {
    const struct devices *d = state;
    int64_t t_ns;
    if (__builtin_add_overflow(d->start_ns, ns, &t_ns))
        return AP_POSE_NONE;
    struct ap_live_answer a = ap_live_at(d->live, roles[device], t_ns);
    if (device == SIM_HEAD)
        note_age(d->ages, ns, &a);
    if (a.state == AP_POSE_NONE && d->window)
        return sim_poses_window.at(d->window, device, ns, sample);
    *sample = (struct ap_sample){.t_ns = ns,
                                 .device = (int)device,
                                 .pose = a.pose,
                                 .trigger = a.select && a.trigger == 0 ? 1 : a.trigger,
                                 .select = a.select};
    return a.state;
}

static void input(void *state, const struct sim_window_input *in, double step_s) {
    struct devices *d = state;
    if (in->keys & ~d->keys & SIM_KEY_RECENTRE)
        ap_live_recentre(d->live);
    d->keys = in->keys;
    if (d->window)
        sim_poses_window.input(d->window, in, step_s);
}

// The keys are the buttons of hands that no tracker holds.
static bool component(const void *state, const struct sim_component *c, int top, float value[2]) {
    const struct devices *d = state;
    int role = top == SIM_TOP_LEFT ? AP_LIVE_LEFT : AP_LIVE_RIGHT;
    return d->window && sim_poses_window.component &&
           ap_live_at(d->live, role, ap_live_now_ns(d->live)).state == AP_POSE_NONE &&
           sim_poses_window.component(d->window, c, top, value);
}

const struct sim_poses_kind sim_poses_devices = {.create = create,
                                                 .destroy = destroy,
                                                 .at = at,
                                                 .start = start,
                                                 .input = input,
                                                 .component = component,
                                                 .learns = true};
