#ifndef ANTIPODE_DEVICE_FUSION_CLOCKMAP_H
#define ANTIPODE_DEVICE_FUSION_CLOCKMAP_H

#include <stdbool.h>
#include <stdint.h>

// A device's own time stamps on the host's monotonic clock: counters that wrap are unwrapped, and a
// line is laid under the arrival times (a report is never early, so the least delayed ones show the
// clocks; least in the sense of Moon, Skelly and Towsley, "Estimation and removal of clock skew
// from network delay measurements", 1999). Pure: no clock, no allocation; one thread at a time.
// What it cannot know is the least delay itself: times come out late by it (60–130 µs on USB).

enum {
    AP_CLOCKMAP_BUCKETS = 40,
    AP_CLOCKMAP_BUCKET_MS = 500, // so the line looks back 20 s
};

// 0 means the value behind.
struct ap_clockmap_params {
    int bits;             // of the counter, 8 … 64
    int64_t tick_ns_num;  // a tick is num/den nanoseconds: DualSense 1000/3, DS4 16000/3,
    int64_t tick_ns_den;  // 1 … 1e9 both
    int64_t gap_ns;       // 1 s: after so long without a report the map starts again
    int64_t queue_ns;     // 0.4 s: no report waits longer in a queue, nor 0.8 wraps
    double drift_max_ppm; // 500
};

enum ap_clock_event {
    AP_CLOCK_OK,
    AP_CLOCK_REPEATED,  // the same stamp again: a report that was sent twice
    AP_CLOCK_RESTARTED, // the first report, or the device's clock jumped, or a gap: no continuity
};

struct ap_clockmap {
    struct ap_clockmap_params params;
    bool started;
    bool is_guessed; // the line stands on a guess alone
    uint64_t raw;
    int64_t device_ns, since_ns;      // since the map started; the stamp's remainder below
    int64_t remainder;                // of ticks·num/den, in 1/den ns
    int64_t first_host_ns, host_ns;   // arrivals: the map's first, the newest
    int64_t out_ns;                   // the newest output
    int64_t late_since_ns;            // arrival from which on everything came late; −1: none did
    int64_t restarts;                 // counted, the first start too
    struct ap_clockmap_low {          // the least delayed report of half a second
        int64_t device_ns, offset_ns; // offset: arrival − device time, both since the start
    } low[AP_CLOCKMAP_BUCKETS];
    int low_count;                      // low[0] is the oldest
    double slope, middle_ns, height_ns; // offset ≈ height + slope·(device − middle)
};

// False where a parameter is out of range.
bool ap_clockmap_init(struct ap_clockmap *map, const struct ap_clockmap_params *params);

// Forgets everything but the parameters and the newest output.
void ap_clockmap_reset(struct ap_clockmap *map);

// The stamp of a report that arrived at host_ns (arrivals may not decrease; one that does is taken
// as the last one). *t_ns is when it was measured: never after its arrival unless the arrivals
// stand still, and larger than every *t_ns before it but for AP_CLOCK_REPEATED, where it is the
// same.
enum ap_clock_event ap_clockmap_add(struct ap_clockmap *map, uint64_t raw, int64_t host_ns,
                                    int64_t *t_ns);

// The same for a report that was read together with later ones, so that its arrival is a guess:
// probably at host_ns, at latest_ns at the latest. It gets its time from the line and has no part
// in laying it: one that is dated too early would draw the line too low for 20 s. A map that starts
// on a guess keeps it until a report comes whose arrival is known.
enum ap_clock_event ap_clockmap_add_guessed(struct ap_clockmap *map, uint64_t raw, int64_t host_ns,
                                            int64_t latest_ns, int64_t *t_ns);

// How much faster the host's clock runs than the device's, in parts per million.
double ap_clockmap_drift_ppm(const struct ap_clockmap *map);

#endif
