#ifndef ANTIPODE_DEVICE_LIVE_FEED_H
#define ANTIPODE_DEVICE_LIVE_FEED_H

#include <stdalign.h>
#include <stddef.h>

#include "src/device/fusion/clockmap.h"
#include "src/device/hid/driver.h"

// One device's reports through its driver, each dated. Pure: no clock, no allocation, nothing
// opened; one thread at a time.

struct ap_feed {
    const struct ap_driver *driver;
    struct ap_device_info info;
    struct ap_clockmap clock;
    int64_t device_ns, step_ns; // of the newest sample with a device time; the usual step; 0: none
    int64_t lost;               // by steps of that clock; −1: it has none
    int64_t arrival_ns;         // of the newest report
    int64_t looked_ns;          // nothing that has not been dated came before
    double interval_ns;         // of arrivals, smoothed; 0: not known
    alignas(max_align_t) unsigned char state[AP_DRIVER_STATE_MAX];
};

struct ap_fed {
    struct ap_driver_samples samples;
    int64_t t_ns[AP_DRIVER_SAMPLES_MAX]; // when each was measured, on the host's clock
    bool restarted;                      // nothing leads here from the samples before
};

// feed->info and ->driver are set; the state begins anew.
void ap_feed_begin(struct ap_feed *feed);

// When the reports of a queue came in that was found at `now_ns` with `count` in it, after the one
// before was dated: writes `count` times, rising by a microsecond at least, none after now but for
// that. queue_len: what stands in a queue that was full and has dropped what came later (0: queues
// drop the oldest); then the first of them came right after the last look. How many of them, the
// first ones, have guessed times; only the newest can have come now.
int ap_feed_date(struct ap_feed *feed, int64_t now_ns, int count, int queue_len, int64_t *t_ns);

// The time of a report whose bus knows when it came, as ap_feed_date would give it.
int64_t ap_feed_stamp(struct ap_feed *feed, int64_t t_ns);

// One report that came at arrival_ns, or, where that is a guess, before the last look.
enum ap_report_verdict ap_feed_report(struct ap_feed *feed, int64_t arrival_ns, bool is_guess,
                                      const uint8_t *bytes, size_t len, struct ap_fed *fed);

// What a device that says nothing at rest would say now; false where its driver knows none such.
bool ap_feed_idle(const struct ap_feed *feed, int64_t now_ns, struct ap_fed *fed);

#endif
