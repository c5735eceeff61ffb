#include "src/device/live/feed.h"

#include <stdlib.h>
#include <string.h>

static const int64_t MICROSECOND = 1000;

void ap_feed_begin(struct ap_feed *feed) {
    static const struct ap_clockmap_params clock = {.bits = 64, .tick_ns_num = 1, .tick_ns_den = 1};
    ap_clockmap_init(&feed->clock, &clock);
    feed->device_ns = feed->step_ns = 0;
    feed->lost = -1;
    feed->arrival_ns = feed->looked_ns = INT64_MIN;
    feed->interval_ns = 0;
    memset(feed->state, 0, sizeof feed->state);
    if (feed->driver && feed->driver->init)
        feed->driver->init(feed->state, &feed->info);
}

// A mean over about fifty reports, in which pauses do not count.
static void learn_interval(struct ap_feed *feed, int64_t over_ns, int count) {
    double each = (double)over_ns / count;
    if (each <= 0 || each > 2e8)
        return;
    double weight = feed->interval_ns == 0 ? 1 : fmin(1, 0.02 * count);
    feed->interval_ns += weight * (each - feed->interval_ns);
}

// Whole microseconds, as a recording has them, and always later than the report before: what stands
// at one time with another report of its device is no pose log any more.
int64_t ap_feed_stamp(struct ap_feed *feed, int64_t t_ns) {
    t_ns -= t_ns % MICROSECOND;
    if (feed->arrival_ns != INT64_MIN && t_ns <= feed->arrival_ns)
        t_ns = feed->arrival_ns + MICROSECOND;
    feed->arrival_ns = t_ns;
    return t_ns;
}

int ap_feed_date(struct ap_feed *feed, int64_t now_ns, int count, int queue_len, int64_t *t_ns) {
    bool is_first = feed->arrival_ns == INT64_MIN;
    int64_t before_ns = is_first                             ? now_ns - count * MICROSECOND
                        : feed->looked_ns > feed->arrival_ns ? feed->looked_ns
                                                             : feed->arrival_ns;
    double step = fmax(feed->interval_ns, (double)MICROSECOND);
    // A queue that was full: its reports are the oldest since the last look, and what came behind
    // them was dropped until somebody read.
    bool was_full = queue_len && count >= queue_len && feed->interval_ns > 0 &&
                    (double)(now_ns - before_ns) > step * (count + 1);
    if (!is_first && !was_full)
        learn_interval(feed, now_ns - before_ns, count);
    for (int i = 0; i < count; i++) {
        bool old = was_full && i < queue_len;
        int64_t t = old ? before_ns + (int64_t)(step * (i + 1))
                        : now_ns - (int64_t)(step * (count - 1 - i));
        t_ns[i] = ap_feed_stamp(feed, t < before_ns ? before_ns : t > now_ns ? now_ns : t);
    }
    feed->looked_ns = now_ns;
    return was_full && count <= queue_len ? count : count - 1;
}

// Steps of two and more usual ones are reports that were lost.
static void count_lost(struct ap_feed *feed, const struct ap_driver_sample *s) {
    int64_t step = s->device_ns - feed->device_ns;
    bool continues = feed->lost >= 0 && !s->reset && step > 0 && step < 500000000;
    if (feed->lost < 0)
        feed->lost = 0;
    feed->device_ns = s->device_ns;
    if (!continues)
        return;
    int64_t usual = feed->step_ns, off = step - usual;
    int64_t steps = usual ? (step + usual / 2) / usual : 1;
    if (usual == 0 || step < usual * 3 / 5)
        feed->step_ns = step;
    else if (llabs(off) < usual / 8)
        feed->step_ns += off / 16;
    else // towards the median: some clocks tick coarsely
        feed->step_ns += off > 0 ? usual / 64 : -usual / 64;
    feed->lost += steps > 1 ? steps - 1 : 0;
}

static int64_t date_sample(struct ap_feed *feed, const struct ap_driver_sample *s,
                           int64_t arrival_ns, bool is_guess, struct ap_fed *fed) {
    fed->restarted |= s->reset;
    if (!s->has_device_time)
        return arrival_ns;
    int64_t t_ns;
    if (s->reset)
        ap_clockmap_reset(&feed->clock);
    enum ap_clock_event event =
        is_guess ? ap_clockmap_add_guessed(&feed->clock, (uint64_t)s->device_ns, arrival_ns,
                                           feed->looked_ns, &t_ns)
                 : ap_clockmap_add(&feed->clock, (uint64_t)s->device_ns, arrival_ns, &t_ns);
    if (event == AP_CLOCK_RESTARTED)
        fed->restarted = true;
    count_lost(feed, s);
    return t_ns;
}

enum ap_report_verdict ap_feed_report(struct ap_feed *feed, int64_t arrival_ns, bool is_guess,
                                      const uint8_t *bytes, size_t len, struct ap_fed *fed) {
    fed->samples.count = 0;
    fed->restarted = false;
    if (!feed->driver)
        return AP_REPORT_IGNORED;
    enum ap_report_verdict verdict =
        feed->driver->parse(feed->state, &feed->info, arrival_ns, bytes, len, &fed->samples);
    if (verdict != AP_REPORT_OK)
        fed->samples.count = 0;
    for (int i = 0; i < fed->samples.count; i++)
        fed->t_ns[i] = date_sample(feed, &fed->samples.at[i], arrival_ns, is_guess, fed);
    return verdict;
}

bool ap_feed_idle(const struct ap_feed *feed, int64_t now_ns, struct ap_fed *fed) {
    fed->samples.count = 0;
    fed->restarted = false;
    if (!feed->driver || !feed->driver->idle || now_ns <= feed->arrival_ns)
        return false;
    feed->driver->idle(feed->state, &feed->info, now_ns, &fed->samples);
    for (int i = 0; i < fed->samples.count; i++)
        fed->t_ns[i] = now_ns;
    return fed->samples.count > 0;
}
