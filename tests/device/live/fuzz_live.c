#include <math.h>

#include "src/device/live/feed.h"
#include "src/device/fusion/predict.h"
#include "tests/device/hid/bytes_of.h"
#include "tests/device/live/devices.h"
#include "tests/device/mutate.h"

// What a live device may send, and when: a device's number, then reports of "TIME COUNT BYTES",
// TIME a power of two of nanoseconds since the look before and COUNT what stood in the queue. What
// was dated must lie in order and not after now, and what goes into a history come out as a pose.

static void require(bool ok, const char *what) {
    if (ok)
        return;
    fprintf(stderr, "broken: %s\n", what);
    abort();
}

static const struct {
    uint16_t bus, vendor, product;
    const char *descriptor;
} devices[] = {
    {3, 0x1209, 0x7690, SLIMEVR_DESCRIPTOR}, {3, 0x3318, 0x0424, XREAL_DESCRIPTOR},
    {3, 0x256f, 0xc635, CAP_DESCRIPTOR},     {5, 0x054c, 0x0e4c, ANDROID_DESCRIPTOR},
    {3, 0x054c, 0x0ce6, SLIMEVR_DESCRIPTOR}, {5, 0x057e, 0x2006, SLIMEVR_DESCRIPTOR},
};

static struct ap_feed feed;
static struct ap_history history;
static struct ap_fed fed;
static long samples_seen;

static void take_samples(int64_t now_ns) {
    for (int i = 0; i < fed.samples.count; i++) {
        const struct ap_driver_sample *s = &fed.samples.at[i];
        samples_seen++;
        if (fed.restarted)
            ap_history_reset(&history);
        ap_history_push(&history, fed.t_ns[i], s->pose,
                        s->has_rate ? &s->angular_velocity_rad_s : NULL);
    }
    struct ap_history_answer a = ap_history_at(&history, now_ns + 11000000);
    struct ap_quat q = a.pose.q;
    double square = q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w;
    require(fabs(square - 1) < 1e-9, "unit quaternion");
    require(isfinite(a.pose.p.x + a.pose.p.y + a.pose.p.z), "finite place");
}

static void take_queue(int64_t now_ns, int count, const uint8_t *bytes, size_t len) {
    int64_t t_ns[256], before = feed.arrival_ns;
    int64_t newest = before >= now_ns - 1000 * count ? before + 1000 * count : now_ns;
    int guessed = ap_feed_date(&feed, now_ns, count, 63, t_ns);
    require(guessed == count || guessed == count - 1, "all but the newest are guesses");
    for (int i = 0; i < count; i++) {
        require(t_ns[i] > before && t_ns[i] <= newest, "reports in order, none after now");
        before = t_ns[i];
        ap_feed_report(&feed, t_ns[i], i < guessed, bytes, len, &fed);
        require(feed.lost >= -1, "losses are counted up");
        take_samples(now_ns);
    }
    if (ap_feed_idle(&feed, now_ns + 1000000, &fed))
        take_samples(now_ns);
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t len) {
    if (len < 1)
        return 0;
    size_t d = bytes[0] % (sizeof devices / sizeof *devices), at = 1;
    uint8_t descriptor[512];
    memset(&feed.info, 0, sizeof feed.info);
    feed.info.bus = devices[d].bus;
    feed.info.vendor = devices[d].vendor;
    feed.info.product = devices[d].product;
    size_t n = bytes_of(devices[d].descriptor, strlen(devices[d].descriptor), descriptor,
                        sizeof descriptor);
    require(!ap_hid_parse_descriptor(NULL, descriptor, n, &feed.info.descriptor), "descriptor");
    feed.driver = ap_driver_find(&feed.info);
    require(feed.driver, "a driver");
    ap_feed_begin(&feed);
    ap_history_init(&history, &(struct ap_history_params){0});
    int64_t now_ns = 1000000000;
    for (; at + 3 <= len; at += n) {
        size_t size = bytes[at + 2] % 80, left = len - at - 3;
        now_ns += INT64_C(1) << bytes[at] % 44;
        n = 3 + (size < left ? size : left);
        take_queue(now_ns, bytes[at + 1] % 70 + 1, bytes + at + 3, n - 3);
    }
    return 0;
}

#ifndef ANTIPODE_LIBFUZZER
// Every device's reports at a kilohertz, with stalls.
static size_t make_seed(uint8_t *seed, size_t device) {
    size_t n = 0;
    seed[n++] = (uint8_t)device;
    for (int i = 0; i < 40; i++) {
        seed[n++] = i % 9 == 8 ? 28 : 20;
        seed[n++] = i % 9 == 8 ? 63 : 0;
        seed[n++] = 64;
        if (device == 1)
            xreal_report(seed + n, 1000000 * (i + 1), 0.3);
        else
            slimevr_report(seed + n, 0.1 * i, i & 3);
        static const uint8_t ids[] = {0, 0, 1, 7, 1, 0x30};
        if (ids[device])
            seed[n] = ids[device];
        n += 64;
    }
    return n;
}

int main(void) {
    static uint8_t seed[8192];
    static char text[MUTATE_MAX];
    static const char *const words[] = {"\x2b\x3f", "\xff\xff\x7f", "\x80", "\x01\x02\x03"};
    for (int round = 0; round < 600; round++) {
        size_t len = make_seed(seed, (size_t)round % 6);
        if (len > MUTATE_MAX)
            return 1;
        memcpy(text, seed, len);
        for (int change = 0; change < round / 6 % 20; change++)
            len = mutate_once(text, len, words, 4);
        mutate_feed(text, len);
    }
    printf("%ld samples\n", samples_seen);
    require(samples_seen > 10000, "samples");
    return 0;
}
#endif
