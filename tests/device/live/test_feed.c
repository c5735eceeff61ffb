#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

#include "src/device/live/feed.h"
#include "tests/device/hid/bytes_of.h"
#include "tests/device/live/devices.h"

// When reports were measured that a busy reader finds in heaps: a device with a clock at 1 kHz, its
// reports in the queue at once, against the times at which they were made.

static const int64_t MS = 1000000, QUEUE = 63;

static uint64_t seed = 1;

static double uniform(void) {
    seed = seed * 6364136223846793005u + 1442695040888963407u;
    return (double)(seed >> 11) / 9007199254740992.0;
}

static struct ap_feed feed;
static struct ap_fed fed;

static void begin(void) {
    uint8_t descriptor[64];
    memset(&feed.info, 0, sizeof feed.info);
    feed.info.bus = 3;
    feed.info.vendor = 0x3318;
    feed.info.product = 0x0424;
    size_t n = bytes_of(XREAL_DESCRIPTOR, strlen(XREAL_DESCRIPTOR), descriptor, sizeof descriptor);
    assert_int_equal(ap_hid_parse_descriptor(NULL, descriptor, n, &feed.info.descriptor), AP_OK);
    feed.driver = ap_driver_find(&feed.info);
    assert_non_null(feed.driver);
    ap_feed_begin(&feed);
}

struct outcome {
    double early_ns, late_ns; // the worst after a second
    int restarts;
};

// Looks between `least` and `most` ns apart, the time of each look late by up to 30 µs; one in
// `one_in` is after a stall of `stall` ns instead (0: never). The newest report of all was made
// `phase` ns before the first look.
struct reader {
    int64_t least_ns, most_ns, stall_ns, phase_ns;
    int one_in;
};

static void take(struct outcome *o, int64_t made_ns, int64_t device_ns, int64_t arrival_ns,
                 bool is_guess, bool is_settled) {
    uint8_t bytes[64];
    xreal_report(bytes, device_ns, 0.5);
    assert_int_equal(ap_feed_report(&feed, arrival_ns, is_guess, bytes, sizeof bytes, &fed),
                     AP_REPORT_OK);
    for (int i = 0; i < fed.samples.count && is_settled; i++) {
        double error = (double)(fed.t_ns[i] - made_ns);
        o->early_ns = fmax(o->early_ns, -error);
        o->late_ns = fmax(o->late_ns, error);
        o->restarts += fed.restarted;
    }
}

// Report k is made at k ms, and 5 s later by the device's clock.
static struct outcome run(const struct reader *r, double seconds) {
    struct outcome o = {0};
    begin();
    int64_t now_ns = 1000 * MS + r->phase_ns, next = 1000;
    for (int look = 0; (double)now_ns < 1e9 * (1 + seconds); look++) {
        int64_t newest = now_ns / MS;
        int count = newest - next + 1 < QUEUE ? (int)(newest - next + 1) : (int)QUEUE;
        int64_t t_ns[63], seen_ns = now_ns + (int64_t)(30000 * uniform());
        int guessed = count > 0 ? ap_feed_date(&feed, seen_ns, count, QUEUE, t_ns) : 0;
        for (int i = 0; i < count; i++)
            take(&o, (next + i) * MS, (next + i + 5000) * MS, t_ns[i],
                 i<guessed, now_ns> 2000 * MS);
        next = newest + 1;
        now_ns += r->one_in && look % r->one_in == r->one_in - 1
                      ? r->stall_ns
                      : r->least_ns + (int64_t)((double)(r->most_ns - r->least_ns) * uniform());
    }
    return o;
}

static void check(const char *reader, const char *what, double got, double limit) {
    if (!(got <= limit))
        fail_msg("%s: %s by %.6g ms, at most %.6g allowed", reader, what, got / 1e6, limit / 1e6);
}

// A guess never draws the line too low: what is early is the slope of a line through few points.
// What is late is late by the least delay there was.
static void test_heaps(void **state) {
    (void)state;
    static const struct {
        const char *name;
        struct reader reader;
        double late_ns;
    } readers[] = {
        {"at once", {.least_ns = 100000, .most_ns = 300000}, 0.05e6},
        {"eight together", {.least_ns = 8000000, .most_ns = 8000000, .phase_ns = 20000}, 0.06e6},
        {"eight together, late",
         {.least_ns = 8000000, .most_ns = 8000000, .phase_ns = 900000},
         0.95e6},
        {"as it comes", {.least_ns = 1000, .most_ns = 20000000}, 0.1e6},
        {"with stalls", {1000, 5000000, 300000000, 0, 50}, 0.1e6},
        {"hardly ever", {1000, 5000000, 150000000, 0, 3}, 0.4e6},
    };
    for (size_t i = 0; i < sizeof readers / sizeof *readers; i++) {
        struct outcome o = run(&readers[i].reader, 20);
        print_message("%s: at most %.4f ms early, %.4f late\n", readers[i].name, o.early_ns / 1e6,
                      o.late_ns / 1e6);
        check(readers[i].name, "early", o.early_ns, 20000);
        check(readers[i].name, "late", o.late_ns, readers[i].late_ns);
        assert_int_equal(o.restarts, 0);
    }
}

// Without a clock the guess is all there is: after a full queue the interval is what it was, and
// the next full one begins where the reader looked last.
static void test_full_queues(void **state) {
    (void)state;
    int64_t t_ns[63], now_ns = 1000 * MS;
    begin();
    for (int i = 0; i < 500; i++)
        ap_feed_date(&feed, now_ns += MS, 1, QUEUE, t_ns);
    for (int round = 0; round < 20; round++) {
        int64_t looked_ns = now_ns;
        now_ns += 150 * MS;
        assert_int_equal(ap_feed_date(&feed, now_ns, QUEUE, QUEUE, t_ns), QUEUE);
        for (int i = 0; i < QUEUE; i++)
            check("full queue", "off", fabs((double)(t_ns[i] - looked_ns - (i + 1) * MS)), 0.05e6);
        assert_int_equal(ap_feed_date(&feed, now_ns += MS, 1, QUEUE, t_ns), 0);
        assert_int_equal(t_ns[0], now_ns);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_heaps),
        cmocka_unit_test(test_full_queues),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
