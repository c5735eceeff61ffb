#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "src/device/live/set.h"

static const int64_t IDLE_STEP_NS = 10000000, RATE_OVER_NS = 1000000000;
static const int64_t WAIT_NS = 1000000000;

// --- recentring

// The turn about +y that brings where it looks to −z; straight up or down it is the twist.
static struct ap_quat level_turn(struct ap_quat q) {
    struct ap_vec3 ahead = ap_quat_rotate(q, (struct ap_vec3){0, 0, -1});
    double yaw = hypot(ahead.x, ahead.z) > 1e-6 ? atan2(-ahead.x, -ahead.z) : 2 * atan2(q.y, q.w);
    return ap_quat_from_axis_angle((struct ap_vec3){0, 1, 0}, -yaw);
}

// True where the sample is the first one after somebody asked for it.
static bool recentre(struct live_slot *slot, struct live_tracker *t,
                     const struct ap_driver_sample *s, struct ap_pose pose) {
    struct ap_live *live = slot->live;
    uint32_t pressed = s->buttons & ~t->buttons & slot->about.driver->recentre;
    t->buttons = s->buttons;
    if (pressed)
        atomic_fetch_add_explicit(&live->recentre_count, 1, memory_order_acq_rel);
    unsigned count = atomic_load_explicit(&live->recentre_count, memory_order_acquire);
    if (count == t->recentre_count)
        return false;
    t->recentre_count = count;
    t->turn = level_turn(pose.q);
    t->anchor = pose;
    t->is_turned = true;
    return true;
}

// --- poses

// Where the tracker is, by what its driver knows and what the body it is worn on tells.
static struct ap_pose place(struct live_tracker *t, const struct ap_driver_sample *s,
                            struct ap_pose pose) {
    enum ap_body_part part = (enum ap_body_part)atomic_load(&t->part);
    if (s->kind == AP_SAMPLE_ORIENTATION) {
        if (t->is_turned)
            pose.q = ap_quat_normalize(ap_quat_mul(t->turn, pose.q));
        pose.p = ap_body_place(part, pose.q);
    } else if (s->kind == AP_SAMPLE_FLIGHT) {
        if (t->is_turned)
            pose = ap_pose_mul(ap_pose_inverse(t->anchor), pose);
        pose.p = ap_vec3_add(ap_body_place(part, AP_QUAT_IDENTITY), pose.p);
    }
    return pose;
}

static void hold(struct live_tracker *t, const struct ap_driver_sample *s, int64_t t_ns) {
    uint32_t trigger;
    memcpy(&trigger, &s->trigger, sizeof trigger);
    atomic_store_explicit(&t->held, (uint64_t)trigger << 32 | s->buttons, memory_order_release);
    atomic_store_explicit(&t->newest_ns, t_ns, memory_order_release);
}

static struct live_tracker *make_tracker(struct live_slot *slot, const struct ap_driver_sample *s) {
    struct live_tracker *t = calloc(1, sizeof *t);
    if (!t || !ap_history_init(&t->history, &slot->live->history)) {
        free(t);
        return NULL;
    }
    t->turn = AP_QUAT_IDENTITY;
    t->anchor = AP_POSE_IDENTITY;
    atomic_init(&t->role, -1);
    atomic_init(&t->part, AP_BODY_OTHER);
    t->flies = s->kind == AP_SAMPLE_FLIGHT;
    t->slot = slot;
    t->index = s->tracker;
    t->driver = slot->about.driver;
    t->vendor = slot->about.place.vendor;
    memcpy(t->serial, slot->about.place.serial, sizeof t->serial);
    t->recentre_count = atomic_load_explicit(&slot->live->recentre_count, memory_order_acquire);
    slot->tracker[s->tracker] = t;
    if (slot->about.tracker_count <= s->tracker)
        slot->about.tracker_count = s->tracker + 1;
    live_assign(slot, s->tracker);
    return t;
}

static void tell(struct live_slot *slot, struct live_tracker *t, const struct ap_driver_sample *s,
                 int64_t t_ns, struct ap_pose pose, bool restarted) {
    const struct ap_live_listener *l = &slot->live->listener;
    if (!l->pose)
        return;
    struct ap_live_pose_row row = {.device = slot->index,
                                   .tracker = s->tracker,
                                   .t_ns = t_ns,
                                   .arrival_ns = slot->feed->arrival_ns,
                                   .pose = pose,
                                   .restarted = restarted,
                                   .sample = s};
    const char *role = ap_live_role_name(slot->live, atomic_load(&t->role));
    if (role)
        memcpy(row.role, role, strlen(role) + 1);
    l->pose(l->user, &row);
}

static void take_sample(struct live_slot *slot, const struct ap_driver_sample *s, int64_t t_ns,
                        bool restarted, bool told) {
    if (s->tracker < 0 || s->tracker >= AP_LIVE_TRACKERS_MAX || s->kind == AP_SAMPLE_IMU)
        return;
    struct live_tracker *t = slot->tracker[s->tracker];
    if (!t)
        t = make_tracker(slot, s);
    if (!t)
        return;
    live_inherit(slot->live, t);
    struct ap_pose pose = s->pose;
    struct ap_vec3 rate = s->angular_velocity_rad_s;
    if (slot->has_mount) {
        pose.q = ap_quat_normalize(ap_quat_mul(pose.q, slot->mount));
        rate = ap_quat_rotate(ap_quat_conj(slot->mount), rate);
    }
    if (recentre(slot, t, s, pose) || restarted)
        ap_history_reset(&t->history);
    pose = place(t, s, pose);
    bool is_first = t->history.last_t_ns == INT64_MIN, is_apart = t->history.apart;
    bool taken = ap_history_push(&t->history, t_ns, pose, s->has_rate ? &rate : NULL);
    if (taken) {
        hold(t, s, t_ns);
        slot->about.newest_ns = t_ns;
    }
    if (s->has_battery)
        slot->about.battery_percent = (int)lroundf(100 * s->battery);
    if (taken && told)
        tell(slot, t, s, t_ns, pose, is_apart && !is_first);
}

// --- reports

// A new second: how many reports came in the last one.
static void count_rate(struct live_slot *slot, int64_t now_ns) {
    struct ap_live_device *d = &slot->about;
    int64_t over = now_ns - slot->rate_since_ns;
    if (over < RATE_OVER_NS)
        return;
    d->rate_hz = (double)(d->reports - slot->rate_reports) * 1e9 / (double)over;
    slot->rate_since_ns = now_ns;
    slot->rate_reports = d->reports;
}

static void take_report(struct live_slot *slot, int64_t arrival_ns, bool is_guess,
                        const uint8_t *bytes, size_t len) {
    struct ap_live *live = slot->live;
    slot->about.reports++;
    if (live->listener.report)
        live->listener.report(live->listener.user,
                              &(struct ap_live_report){slot->index, arrival_ns, bytes, len});
    struct ap_fed fed;
    if (ap_feed_report(slot->feed, arrival_ns, is_guess, bytes, len, &fed) == AP_REPORT_BAD)
        slot->about.bad++;
    for (int i = 0; i < fed.samples.count; i++)
        take_sample(slot, &fed.samples.at[i], fed.t_ns[i], fed.restarted, true);
    slot->about.lost = slot->feed->lost;
    const struct ap_driver *driver = slot->feed->driver;
    if (driver && driver->ask && driver->ask(slot->feed->state, &slot->asked)) {
        slot->has_asked = true; // one question at a time: an answer comes before the next
        slot->bus->way.io->rouse(slot->bus->way.bus); // the keeper sends it
    }
}

// What is not open has nothing to lose. A node is listed for a moment after it was lost, and does
// not open any more: that is no second loss.
void live_slot_lose(struct live_slot *slot, int64_t now_ns) {
    atomic_store_explicit(&slot->state, AP_LIVE_GONE, memory_order_release);
    if (!slot->device)
        return;
    atomic_fetch_add_explicit(&slot->live->lose_count, 1, memory_order_acq_rel);
    slot->about.rate_hz = 0;
    slot->about.unplugged_count++;
    for (int i = 0; i < AP_LIVE_TRACKERS_MAX; i++)
        if (slot->tracker[i])
            ap_history_lose(&slot->tracker[i]->history, now_ns);
}

struct batch {
    int count, guessed; // the first ones' times are guesses
    size_t used;
    size_t at[AP_LIVE_BATCH], len[AP_LIVE_BATCH];
    int64_t t_ns[AP_LIVE_BATCH];
};

// Reads until the queue is empty or the batch is full; false where the device is gone.
static bool fill(struct live_slot *slot, struct batch *b, bool *empty) {
    struct live_bus *bus = slot->bus;
    b->count = 0;
    b->used = 0;
    *empty = false;
    while (b->count < AP_LIVE_BATCH && b->used + AP_HID_REPORT_MAX <= AP_LIVE_BATCH_BYTES) {
        size_t len = 0;
        int64_t t_ns = 0;
        enum ap_live_read got = bus->way.io->read(bus->way.bus, slot->device, bus->batch + b->used,
                                                  AP_HID_REPORT_MAX, &len, &t_ns);
        if (got != AP_LIVE_READ_REPORT) {
            *empty = true;
            return got == AP_LIVE_READ_NOTHING;
        }
        b->at[b->count] = b->used;
        b->len[b->count] = len;
        b->t_ns[b->count++] = t_ns;
        b->used += len;
    }
    return true;
}

// The times of what the bus could not date itself.
static void date(struct live_slot *slot, struct batch *b) {
    const struct live_bus *bus = slot->bus;
    b->guessed = 0;
    if (b->count > 0 && b->t_ns[0] == 0)
        b->guessed = ap_feed_date(slot->feed, bus->way.io->now_ns(bus->way.bus), b->count,
                                  bus->way.io->queue_len, b->t_ns);
    else
        for (int i = 0; i < b->count; i++)
            b->t_ns[i] = ap_feed_stamp(slot->feed, b->t_ns[i]);
}

void live_slot_drain(struct live_slot *slot) {
    struct live_bus *bus = slot->bus;
    static _Thread_local struct batch b;
    bool empty = false, there = true;
    while (!empty) {
        there = fill(slot, &b, &empty);
        // What a device says before its driver has begun says nothing.
        if (slot->is_reading)
            date(slot, &b);
        for (int i = 0; i < b.count && slot->is_reading; i++)
            take_report(slot, b.t_ns[i], i < b.guessed, bus->batch + b.at[i], b.len[i]);
        // A device that never stops must not keep the others waiting.
        if (b.count == AP_LIVE_BATCH)
            break;
    }
    int64_t now_ns = bus->way.io->now_ns(bus->way.bus);
    if (there) {
        count_rate(slot, now_ns);
        return;
    }
    live_slot_lose(slot, now_ns);
    bus->way.io->rouse(bus->way.bus); // the keeper closes it
}

// What is silent at rest is still there.
static bool idle(struct live_slot *slot, int64_t now_ns) {
    struct ap_fed fed;
    if (live_slot_state(slot) != AP_LIVE_RUNNING || !slot->about.driver ||
        !slot->about.driver->idle)
        return false;
    if (now_ns - slot->about.newest_ns >= IDLE_STEP_NS && ap_feed_idle(slot->feed, now_ns, &fed))
        for (int i = 0; i < fed.samples.count; i++)
            take_sample(slot, &fed.samples.at[i], fed.t_ns[i], false, false);
    return true;
}

void *live_read(void *arg) {
    struct live_bus *bus = arg;
    struct ap_live *live = bus->live;
    int tags[AP_LIVE_DEVICES_MAX];
    int64_t wait_ns = WAIT_NS;
    while (!atomic_load(&bus->stop)) {
        int n = bus->way.io->wait(bus->way.bus, tags, AP_LIVE_DEVICES_MAX, wait_ns);
        pthread_mutex_lock(&bus->lock);
        for (int i = 0; i < n; i++) {
            struct live_slot *slot = live->slots[tags[i]];
            if (slot->device && live_slot_state(slot) != AP_LIVE_GONE)
                live_slot_drain(slot);
        }
        bool idles = false;
        int64_t now_ns = bus->way.io->now_ns(bus->way.bus);
        for (int i = 0, count = live_slot_count(live); i < count; i++)
            if (live->slots[i]->bus == bus) {
                idles |= idle(live->slots[i], now_ns);
                count_rate(live->slots[i], now_ns);
            }
        pthread_mutex_unlock(&bus->lock);
        wait_ns = idles ? IDLE_STEP_NS : WAIT_NS;
    }
    return NULL;
}
