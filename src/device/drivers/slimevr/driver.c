#include "src/device/drivers/slimevr/slimevr.h"

struct state {
    uint8_t tracker[256]; // by id: 0 not registered, else its number + 1
    uint8_t buttons[256];
    uint8_t battery[256]; // percent + 1, 0: not known
    uint8_t count;
};

static const struct ap_driver_ids ids[] = {
    {AP_PRODUCT(0x1209, 0x7690)},
    {AP_PRODUCT(0x1209, 0x7692)},
    {.vendor = 0x4e76, .first_product = 0xd2d0, .last_product = 0xd2df},
    {0},
};

// The receiver repeats packets to fill a report: the last one of each tracker counts.
static struct ap_driver_sample *sample_of(struct ap_driver_samples *samples, int tracker) {
    for (int i = 0; i < samples->count; i++)
        if (samples->at[i].tracker == tracker)
            return &samples->at[i];
    return ap_driver_add_sample(samples);
}

static void take(struct state *s, const struct ap_slimevr_packet *p,
                 struct ap_driver_samples *samples) {
    if (!s->tracker[p->id])
        return;
    if (p->has_buttons)
        s->buttons[p->id] = p->buttons;
    if (p->has_battery)
        s->battery[p->id] = (uint8_t)(p->battery_percent + 1);
    if (p->kind != AP_SLIMEVR_ROTATION)
        return;
    // The trackers' world has z up, their own axes stay: a quarter turn on the left.
    static const struct ap_quat turn = {-0.70710678118654752440, 0, 0, 0.70710678118654752440};
    struct ap_driver_sample *sample = sample_of(samples, s->tracker[p->id] - 1);
    if (!sample)
        return;
    sample->kind = AP_SAMPLE_ORIENTATION;
    sample->tracker = s->tracker[p->id] - 1;
    sample->pose.q = ap_quat_normalize(ap_quat_mul(turn, p->q));
    sample->acceleration_m_s2 = p->acceleration_m_s2;
    sample->buttons = s->buttons[p->id];
    sample->has_battery = s->battery[p->id] > 0;
    sample->battery = sample->has_battery ? (float)(s->battery[p->id] - 1) / 100 : 0;
}

// The receiver puts registrations behind the other packets, but they count for those, too.
static void take_registrations(struct state *s, const uint8_t *bytes, size_t len) {
    for (size_t at = 0; at < len; at += AP_SLIMEVR_PACKET) {
        struct ap_slimevr_packet p;
        if (ap_slimevr_parse(bytes + at, &p) && p.kind == AP_SLIMEVR_REGISTRATION &&
            !s->tracker[p.id] && s->count < UINT8_MAX)
            s->tracker[p.id] = ++s->count;
    }
}

static enum ap_report_verdict parse(void *state, const struct ap_device_info *info, int64_t t_ns,
                                    const uint8_t *bytes, size_t len,
                                    struct ap_driver_samples *samples) {
    (void)info, (void)t_ns;
    struct state *s = state;
    if (len == 0 || len % AP_SLIMEVR_PACKET)
        return ap_report_bad(samples, "a report of packets of 16 bytes, not of %zu bytes", len);
    take_registrations(s, bytes, len);
    for (size_t at = 0; at < len; at += AP_SLIMEVR_PACKET) {
        struct ap_slimevr_packet p;
        bool ok = ap_slimevr_parse(bytes + at, &p);
        if (ok)
            take(s, &p, samples);
        else if (s->tracker[p.id])
            return ap_report_bad(samples, "a unit quaternion of tracker %d", p.id);
    }
    return AP_REPORT_OK;
}

_Static_assert(sizeof(struct state) <= AP_DRIVER_STATE_MAX, "state");

const struct ap_driver ap_driver_slimevr = {
    .name = "slimevr",
    .title = "SlimeVR receiver",
    .ids = ids,
    .degrees = 3,
    .recentre = 2, // the first one selects
    .state_bytes = sizeof(struct state),
    .parse = parse,
};
