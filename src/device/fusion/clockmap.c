#include "src/device/fusion/clockmap.h"

#include <math.h>
#include <string.h>

static const int64_t BUCKET_NS = AP_CLOCKMAP_BUCKET_MS * INT64_C(1000000);
static const int64_t SPAN_FOR_DRIFT_NS = 4000000000; // before, the clocks are taken as equally fast
static const int64_t EARLY_NS = 5000000;  // sooner than the line says by more: the clock jumped
static const int64_t LATE_NS = 100000000; // later by more, for as long as the next line says:
static const int64_t LATE_FOR_NS = 1000000000; // wraps were missed, or the clock stood still

static double wrap_ns(const struct ap_clockmap_params *p) {
    return ldexp((double)p->tick_ns_num / (double)p->tick_ns_den, p->bits);
}

bool ap_clockmap_init(struct ap_clockmap *map, const struct ap_clockmap_params *params) {
    struct ap_clockmap_params p = *params;
    if (p.gap_ns == 0)
        p.gap_ns = 1000000000;
    if (p.queue_ns == 0)
        p.queue_ns = 400000000;
    if (p.drift_max_ppm == 0)
        p.drift_max_ppm = 500;
    // The upper limits keep ticks·num of the longest step within 63 bits.
    bool ok = p.bits >= 8 && p.bits <= 64 && p.tick_ns_num >= 1 && p.tick_ns_num <= 1000000000 &&
              p.tick_ns_den >= 1 && p.tick_ns_den <= 1000000 && p.gap_ns >= 1 &&
              p.gap_ns <= 3600000000000 && p.queue_ns >= 1 && p.queue_ns <= 60000000000 &&
              p.drift_max_ppm > 0 && p.drift_max_ppm <= 10000 && wrap_ns(&p) >= 1e6;
    if (!ok)
        return false;
    *map = (struct ap_clockmap){.params = p, .out_ns = INT64_MIN, .late_since_ns = -1};
    return true;
}

void ap_clockmap_reset(struct ap_clockmap *map) {
    *map = (struct ap_clockmap){.params = map->params,
                                .out_ns = map->out_ns,
                                .restarts = map->restarts,
                                .late_since_ns = -1};
}

static double offset_at(const struct ap_clockmap *map, int64_t device_ns) {
    return map->height_ns + map->slope * ((double)device_ns - map->middle_ns);
}

// The value at the middle of the lower convex hull of the points, and its slope there: the line
// below all of them that has the least sum of distances.
static void fit(struct ap_clockmap *map) {
    const struct ap_clockmap_low *low = map->low;
    int n = map->low_count;
    double middle = 0, best = INFINITY, slope = 0, limit = map->params.drift_max_ppm * 1e-6;
    for (int i = 0; i < n; i++)
        middle += (double)low[i].device_ns / n;
    if (low[n - 1].device_ns - low[0].device_ns >= SPAN_FOR_DRIFT_NS) {
        for (int i = 0; i < n && (double)low[i].device_ns <= middle; i++)
            for (int j = n - 1; j > i && (double)low[j].device_ns > middle; j--) {
                double s = (double)(low[j].offset_ns - low[i].offset_ns) /
                           (double)(low[j].device_ns - low[i].device_ns);
                double at = (double)low[i].offset_ns + s * (middle - (double)low[i].device_ns);
                if (at < best) {
                    best = at;
                    slope = s;
                }
            }
        slope = fmin(fmax(slope, -limit), limit);
    }
    double height = INFINITY;
    for (int i = 0; i < n; i++)
        height =
            fmin(height, (double)low[i].offset_ns - slope * ((double)low[i].device_ns - middle));
    map->slope = slope;
    map->middle_ns = middle;
    map->height_ns = height;
}

static void add_low(struct ap_clockmap *map, int64_t device_ns, int64_t offset_ns) {
    struct ap_clockmap_low *last = map->low_count ? &map->low[map->low_count - 1] : NULL;
    if (last && last->device_ns / BUCKET_NS == device_ns / BUCKET_NS) {
        if (offset_ns >= last->offset_ns)
            return;
    } else {
        if (map->low_count == AP_CLOCKMAP_BUCKETS) {
            map->low_count--;
            memmove(map->low, map->low + 1, (size_t)map->low_count * sizeof *map->low);
        }
        last = &map->low[map->low_count++];
    }
    *last = (struct ap_clockmap_low){device_ns, offset_ns};
    fit(map);
}

// A known arrival: what was guessed before it goes.
static void lay(struct ap_clockmap *map, int64_t offset_ns) {
    if (map->is_guessed)
        map->low_count = 0;
    map->is_guessed = false;
    add_low(map, map->device_ns, offset_ns);
}

static enum ap_clock_event start(struct ap_clockmap *map, uint64_t raw, int64_t host_ns,
                                 bool is_guess, int64_t *t_ns) {
    ap_clockmap_reset(map);
    map->started = true;
    map->is_guessed = is_guess;
    map->restarts++;
    map->raw = raw;
    map->first_host_ns = map->host_ns = host_ns;
    add_low(map, 0, 0);
    map->out_ns = host_ns > map->out_ns ? host_ns : map->out_ns + 1;
    *t_ns = map->out_ns;
    return AP_CLOCK_RESTARTED;
}

// How far the device's clock went, from the counter's step; fewest wraps that do not make the
// report older than a queue can hold. False where the step is no step of a running clock.
static bool unwrap(const struct ap_clockmap *map, uint64_t ticks, int64_t host_ns, int64_t *step_ns,
                   int64_t *remainder) {
    const struct ap_clockmap_params *p = &map->params;
    double ns = (double)ticks * (double)p->tick_ns_num / (double)p->tick_ns_den;
    double since = (double)(host_ns - map->first_host_ns);
    double late = since - (double)map->device_ns - offset_at(map, map->device_ns) - ns;
    if (late < -(double)EARLY_NS)
        return false;
    double wrap = wrap_ns(p);
    double wraps = 0, queue = fmin((double)p->queue_ns, 0.8 * wrap);
    while (late > queue && late - wrap > -(double)EARLY_NS && wraps < 4000) {
        late -= wrap;
        wraps++;
    }
    uint64_t whole = ticks;
    if (wraps > 0)
        whole += (uint64_t)wraps << p->bits; // only where a wrap is shorter than the longest gap
    int64_t parts = (int64_t)whole * p->tick_ns_num + map->remainder;
    *step_ns = parts / p->tick_ns_den;
    *remainder = parts % p->tick_ns_den;
    return true;
}

// Late without a break: the unwrapping went wrong, or the device's clock stood still.
static bool always_late(struct ap_clockmap *map, int64_t host_ns, double late_ns) {
    if (late_ns < fmin((double)LATE_NS, wrap_ns(&map->params) / 2)) {
        map->late_since_ns = -1;
        return false;
    }
    if (map->late_since_ns < 0)
        map->late_since_ns = host_ns - map->first_host_ns;
    return host_ns - map->first_host_ns - map->late_since_ns > LATE_FOR_NS;
}

// On the line; but no report is younger than its arrival, and a correction of the line backwards is
// worked off by letting time run at a quarter of its speed.
static int64_t place(const struct ap_clockmap *map, int64_t step_ns, int64_t latest_ns) {
    int64_t t = map->first_host_ns + map->device_ns + llround(offset_at(map, map->device_ns));
    if (t < map->out_ns + step_ns / 4)
        t = map->out_ns + step_ns / 4;
    if (t > latest_ns)
        t = latest_ns;
    return t > map->out_ns ? t : map->out_ns + 1;
}

static enum ap_clock_event add(struct ap_clockmap *map, uint64_t raw, int64_t host_ns,
                               int64_t latest_ns, bool is_guess, int64_t *t_ns) {
    const struct ap_clockmap_params *p = &map->params;
    uint64_t mask = p->bits == 64 ? UINT64_MAX : (UINT64_C(1) << p->bits) - 1;
    raw &= mask;
    if (host_ns < 0)
        host_ns = 0; // the monotonic clock never is; keeps the differences within 64 bits
    if (!map->started)
        return start(map, raw, host_ns, is_guess, t_ns);
    if (host_ns < map->host_ns)
        host_ns = map->host_ns;
    if (host_ns - map->host_ns > p->gap_ns)
        return start(map, raw, host_ns, is_guess, t_ns);
    uint64_t ticks = (raw - map->raw) & mask;
    if (ticks == 0) {
        *t_ns = map->out_ns;
        return AP_CLOCK_REPEATED;
    }
    int64_t step_ns, remainder;
    if (!unwrap(map, ticks, host_ns, &step_ns, &remainder))
        return start(map, raw, host_ns, is_guess, t_ns);
    map->raw = raw;
    map->host_ns = host_ns;
    map->device_ns += step_ns;
    map->remainder = remainder;
    int64_t offset = host_ns - map->first_host_ns - map->device_ns;
    if (!is_guess)
        lay(map, offset);
    if (!is_guess && always_late(map, host_ns, (double)offset - offset_at(map, map->device_ns)))
        return start(map, raw, host_ns, false, t_ns);
    map->out_ns = *t_ns = place(map, step_ns, latest_ns > host_ns ? latest_ns : host_ns);
    return AP_CLOCK_OK;
}

enum ap_clock_event ap_clockmap_add(struct ap_clockmap *map, uint64_t raw, int64_t host_ns,
                                    int64_t *t_ns) {
    return add(map, raw, host_ns, host_ns, false, t_ns);
}

enum ap_clock_event ap_clockmap_add_guessed(struct ap_clockmap *map, uint64_t raw, int64_t host_ns,
                                            int64_t latest_ns, int64_t *t_ns) {
    return add(map, raw, host_ns, latest_ns, true, t_ns);
}

double ap_clockmap_drift_ppm(const struct ap_clockmap *map) {
    return map->slope * 1e6;
}
