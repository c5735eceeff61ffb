#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "src/base/log.h"
#include "src/base/utf8.h"
#include "src/device/calibration/store.h"
#include "src/device/live/rules.h"
#include "src/device/live/set.h"

static const int64_t MS = 1000000;
static const int64_t LOOK_NS = 1000000000; // at least so often at what there is
static const int64_t RETRY_NS = 200000000;
enum { SENSOR_PAGE = 0x20 };

static int64_t now_of(const struct live_bus *bus) {
    return bus->way.io->now_ns(bus->way.bus);
}

static void set_state(struct live_slot *slot, enum ap_live_state state) {
    atomic_store_explicit(&slot->state, (int)state, memory_order_release);
}

// --- which slot

static bool is_same_model(const struct ap_live_place *a, const struct ap_live_place *b) {
    return a->vendor == b->vendor && a->product == b->product && a->bus == b->bus &&
           a->interface_number == b->interface_number;
}

static bool is_same_device(const struct ap_live_place *a, const struct ap_live_place *b) {
    return is_same_model(a, b) && strcmp(a->serial, b->serial) == 0 &&
           strcmp(a->port, b->port) == 0 && strcmp(a->name, b->name) == 0;
}

static void close_device(struct live_slot *slot) {
    struct live_bus *bus = slot->bus;
    pthread_mutex_lock(&bus->lock);
    void *device = slot->device;
    slot->device = NULL;
    slot->is_reading = false;
    pthread_mutex_unlock(&bus->lock);
    if (device)
        bus->way.io->close(bus->way.bus, device);
}

// It is not there any more. What its queue still holds was measured all the same.
static void lose(struct live_slot *slot) {
    struct live_bus *bus = slot->bus;
    pthread_mutex_lock(&bus->lock);
    if (slot->device && live_slot_state(slot) != AP_LIVE_GONE)
        live_slot_drain(slot);
    if (live_slot_state(slot) != AP_LIVE_GONE)
        live_slot_lose(slot, now_of(bus));
    pthread_mutex_unlock(&bus->lock);
}

static const struct ap_driver *driver_of(const struct ap_live_place *place) {
    struct ap_device_info *info = malloc(sizeof *info);
    const struct ap_driver *driver =
        info && !live_describe(NULL, place, info) ? ap_driver_find(info) : NULL;
    free(info);
    return driver;
}

// A device that was here by another way, as a controller by Bluetooth that now hangs on its cable:
// its bus, product number and interface may be others.
static struct live_slot *find_moved(struct live_bus *bus, const struct ap_live_place *place) {
    const struct ap_driver *driver = place->serial[0] ? driver_of(place) : NULL;
    struct ap_live *live = bus->live;
    for (int i = 0, count = driver ? live_slot_count(live) : 0; i < count; i++) {
        struct live_slot *slot = live->slots[i];
        const struct ap_live_place *p = &slot->about.place;
        if (slot->bus != bus || live_slot_state(slot) != AP_LIVE_GONE ||
            slot->about.driver != driver || p->vendor != place->vendor ||
            !live_is_same_serial(p->serial, place->serial))
            continue;
        close_device(slot);
        return slot;
    }
    return NULL;
}

// A device that was here before: by its serial, where it has none by where it is plugged in, or
// else one of its kind.
static struct live_slot *find_gone(struct live_bus *bus, const struct ap_live_place *place) {
    struct ap_live *live = bus->live;
    struct live_slot *same_kind = NULL;
    for (int i = 0, count = live_slot_count(live); i < count; i++) {
        struct live_slot *slot = live->slots[i];
        const struct ap_live_place *p = &slot->about.place;
        if (slot->bus != bus || live_slot_state(slot) != AP_LIVE_GONE || !is_same_model(p, place) ||
            strcmp(p->serial, place->serial) != 0)
            continue;
        close_device(slot); // it may have gone a moment ago
        if (place->serial[0] || strcmp(p->port, place->port) == 0)
            return slot;
        if (!same_kind && strcmp(p->name, place->name) == 0)
            same_kind = slot;
    }
    return same_kind ? same_kind : find_moved(bus, place);
}

static struct live_slot *find_path(struct live_bus *bus, const char *path) {
    struct ap_live *live = bus->live;
    for (int i = 0, count = live_slot_count(live); i < count; i++)
        if (live->slots[i]->bus == bus && live_slot_state(live->slots[i]) != AP_LIVE_GONE &&
            strcmp(live->slots[i]->about.place.path, path) == 0)
            return live->slots[i];
    return NULL;
}

static struct ap_live_mount mount_of(const struct ap_live *live, const struct ap_live_place *p) {
    char key[AP_LIVE_SERIAL_MAX];
    struct ap_live_mount mount = {.tracker_from_body = AP_QUAT_IDENTITY};
    ap_device_key(key, sizeof key, p->serial, p->vendor, p->product);
    for (size_t i = 0; i < live->mount_count; i++)
        if (live_is_same_serial(live->mounts[i].serial, key))
            mount = live->mounts[i];
    struct ap_quat q = mount.tracker_from_body;
    if (q.x == 0 && q.y == 0 && q.z == 0 && q.w == 0)
        mount.tracker_from_body = AP_QUAT_IDENTITY;
    return mount;
}

static struct live_slot *make_slot(struct live_bus *bus) {
    struct ap_live *live = bus->live;
    struct live_slot *slot = calloc(1, sizeof *slot);
    struct ap_feed *feed = calloc(1, sizeof *feed);
    pthread_mutex_lock(&live->lock);
    bool room = live->slot_count < AP_LIVE_DEVICES_MAX;
    if (!slot || !feed || !room) {
        if (!live->is_full)
            ap_log(AP_LOG_WARNING, "devices: no room or memory for another one (%d are known)",
                   live->slot_count);
        live->is_full = true;
        pthread_mutex_unlock(&live->lock);
        free(feed);
        free(slot);
        return NULL;
    }
    *slot = (struct live_slot){.live = live, .bus = bus, .index = live->slot_count, .feed = feed};
    set_state(slot, AP_LIVE_GONE);
    slot->about.way = bus->way.io->name;
    slot->about.lost = slot->about.battery_percent = -1;
    live->slots[live->slot_count++] = slot;
    pthread_mutex_unlock(&live->lock);
    return slot;
}

// --- switching on

static void keep_feature(struct ap_device_info *info, const uint8_t *bytes, int len) {
    if (len <= 0 || len > AP_DEVICE_FEATURE_BYTES || info->feature_count == AP_DEVICE_FEATURES_MAX)
        return;
    struct ap_feature_report *f = &info->features[info->feature_count++];
    f->len = (size_t)len;
    memcpy(f->bytes, bytes, f->len);
}

static int get_feature(struct live_slot *slot, uint8_t id, size_t len, uint8_t *bytes) {
    memset(bytes, 0, len);
    bytes[0] = id;
    return slot->bus->way.io->get_feature(slot->bus->way.bus, slot->device, bytes, len);
}

// Sensors say in feature reports what they are and how they stand. Others are asked for nothing
// that their drivers do not ask for: there are devices that a question stops.
static void read_sensor_features(struct live_slot *slot) {
    struct ap_device_info *info = &slot->feed->info;
    bool done[256] = {false};
    for (int i = 0; i < info->descriptor.field_count; i++) {
        const struct ap_hid_field *f = &info->descriptor.fields[i];
        size_t len = ap_hid_report_bytes(&info->descriptor, AP_HID_FEATURE, f->report_id);
        uint32_t usage = ap_hid_usage_at(&info->descriptor, f, 0);
        uint8_t bytes[AP_DEVICE_FEATURE_BYTES];
        if (f->kind != AP_HID_FEATURE || usage >> 16 != SENSOR_PAGE || done[f->report_id] ||
            len == 0 || len > sizeof bytes)
            continue;
        done[f->report_id] = true;
        keep_feature(info, bytes, get_feature(slot, f->report_id, len, bytes));
    }
}

static void refused(struct live_slot *slot, const struct ap_driver_step *step) {
    pthread_mutex_lock(&slot->bus->lock);
    snprintf(slot->about.why, sizeof slot->about.why,
             "%.128s refused %s %02x, which switches it on; its reports are read all the same",
             slot->about.place.path, step->kind == AP_STEP_OUTPUT ? "output" : "feature report",
             (unsigned)step->bytes[0]);
    pthread_mutex_unlock(&slot->bus->lock);
}

static void take_step(struct live_slot *slot, const struct ap_driver_step *step) {
    const struct ap_live_io *io = slot->bus->way.io;
    void *bus = slot->bus->way.bus;
    int got = 0;
    if (step->kind == AP_STEP_GET_FEATURE) {
        uint8_t bytes[AP_DEVICE_FEATURE_BYTES];
        got = get_feature(slot, step->bytes[0], step->len, bytes);
        if (!slot->is_reading)
            keep_feature(&slot->feed->info, bytes, got);
    } else if (step->kind == AP_STEP_SET_FEATURE) {
        got = io->set_feature(bus, slot->device, step->bytes, step->len);
    } else {
        got = io->output(bus, slot->device, step->bytes, step->len);
    }
    if (got < 0)
        refused(slot, step);
}

static void begin_reading(struct live_slot *slot) {
    const struct ap_live_listener *l = &slot->live->listener;
    int64_t now_ns = now_of(slot->bus);
    if (l->started)
        l->started(l->user, slot->index, &slot->about.place, &slot->feed->info, now_ns);
    pthread_mutex_lock(&slot->bus->lock);
    ap_feed_begin(slot->feed);
    slot->has_asked = false;
    for (int i = 0; i < AP_LIVE_TRACKERS_MAX; i++)
        if (slot->tracker[i])
            ap_history_reset(&slot->tracker[i]->history);
    slot->rate_since_ns = now_ns;
    slot->rate_reports = slot->about.reports;
    slot->is_reading = true;
    pthread_mutex_unlock(&slot->bus->lock);
}

// What an answer that the reader has seen calls for.
static void take_asked(struct live_slot *slot) {
    pthread_mutex_lock(&slot->bus->lock);
    struct ap_driver_step step = slot->asked;
    bool has_asked = slot->has_asked;
    slot->has_asked = false;
    pthread_mutex_unlock(&slot->bus->lock);
    if (has_asked)
        take_step(slot, &step);
}

// Two interfaces of one device: plugged in at the same place, but for what stands behind the last
// '/' (of HID_PHYS) or ':' (of sysfs).
static bool is_same_plug(const char *a, const char *b) {
    size_t n = strlen(a);
    while (n > 0 && a[n - 1] != '/' && a[n - 1] != ':')
        n--;
    return n > 0 ? strncmp(a, b, n) == 0 : strcmp(a, b) == 0;
}

static bool is_silent(struct live_slot *slot, int64_t since_ns) {
    struct ap_live *live = slot->live;
    bool is_silent = true;
    pthread_mutex_lock(&slot->bus->lock);
    for (int i = 0, count = live_slot_count(live); i < count; i++) {
        const struct live_slot *s = live->slots[i];
        if (s->bus == slot->bus && s->about.driver == slot->about.driver &&
            is_same_plug(slot->about.place.port, s->about.place.port))
            is_silent &= s->about.newest_ns < since_ns;
    }
    pthread_mutex_unlock(&slot->bus->lock);
    return is_silent;
}

static void repeat_step(struct live_slot *slot, int i) {
    const struct ap_driver_step *step = &slot->steps[i];
    int64_t every_ns = step->repeat_ms * MS;
    if (!step->if_silent || is_silent(slot, now_of(slot->bus) - every_ns))
        take_step(slot, step);
    slot->due_ns[i] = now_of(slot->bus) + every_ns;
}

// Does what is due; when the next is. What only asks goes before the driver begins: it has the
// calibration that the driver begins with.
static int64_t take_steps(struct live_slot *slot) {
    int64_t next_ns = INT64_MAX;
    take_asked(slot);
    while (slot->step_at < slot->step_count) {
        const struct ap_driver_step *step = &slot->steps[slot->step_at];
        int64_t due_ns = slot->due_ns[slot->step_at];
        if (due_ns > now_of(slot->bus))
            return due_ns;
        if (!slot->is_reading && step->kind != AP_STEP_GET_FEATURE)
            begin_reading(slot);
        take_step(slot, step);
        int64_t now_ns = now_of(slot->bus);
        slot->due_ns[slot->step_at] = step->repeat_ms ? now_ns + step->repeat_ms * MS : INT64_MAX;
        if (++slot->step_at < slot->step_count)
            slot->due_ns[slot->step_at] = now_ns + step->wait_ms * MS;
    }
    if (!slot->is_reading)
        begin_reading(slot);
    int starting = AP_LIVE_STARTING; // unless the reader has found it gone
    atomic_compare_exchange_strong(&slot->state, &starting, AP_LIVE_RUNNING);
    for (int i = 0; i < slot->step_count; i++) {
        if (slot->due_ns[i] <= now_of(slot->bus))
            repeat_step(slot, i);
        if (slot->due_ns[i] < next_ns)
            next_ns = slot->due_ns[i];
    }
    return next_ns;
}

// --- opening and closing

static void fail(struct live_slot *slot, enum ap_live_state state, const char *why) {
    struct live_bus *bus = slot->bus;
    pthread_mutex_lock(&bus->lock);
    snprintf(slot->about.why, sizeof slot->about.why, "%s", why);
    pthread_mutex_unlock(&bus->lock);
    set_state(slot, state);
    slot->retry_ns = now_of(bus) + RETRY_NS;
}

enum ap_status live_describe(struct ap_error *err, const struct ap_live_place *p,
                             struct ap_device_info *info) {
    memset(info, 0, sizeof *info);
    info->bus = p->bus;
    info->vendor = p->vendor;
    info->product = p->product;
    info->interface_known = p->interface_number >= 0;
    info->interface_number = p->interface_number;
    memcpy(info->name, p->name, sizeof info->name);
    if (!p->descriptor_len)
        return AP_OK;
    return ap_hid_parse_descriptor(err, p->descriptor, p->descriptor_len, &info->descriptor);
}

static void set_driver(struct live_slot *slot) {
    slot->feed->driver = ap_driver_find(&slot->feed->info);
    pthread_mutex_lock(&slot->bus->lock);
    slot->about.driver = slot->feed->driver;
    slot->about.degrees = slot->feed->driver ? slot->feed->driver->degrees : 0;
    struct ap_live_mount mount = mount_of(slot->live, &slot->about.place);
    slot->mount = mount.tracker_from_body;
    slot->has_mount = mount.serial != NULL;
    slot->feed->info.bias = mount.bias;
    pthread_mutex_unlock(&slot->bus->lock);
}

static void begin_steps(struct live_slot *slot) {
    const struct ap_driver *driver = slot->feed->driver;
    slot->step_at = 0;
    slot->step_count = driver && driver->start ? driver->start(&slot->feed->info, slot->steps) : 0;
    for (int i = 0; i < slot->step_count; i++)
        slot->due_ns[i] = i ? INT64_MAX : 0;
}

// A broken one is as good as none: drivers that go by ids do without.
static void ask_descriptor(struct live_slot *slot) {
    uint8_t bytes[AP_HID_DESCRIPTOR_MAX];
    struct live_bus *bus = slot->bus;
    int n = bus->way.io->descriptor(bus->way.bus, slot->device, bytes, sizeof bytes);
    if (n > 0)
        ap_hid_parse_descriptor(NULL, bytes, (size_t)n, &slot->feed->info.descriptor);
}

static void open_device(struct live_slot *slot) {
    struct live_bus *bus = slot->bus;
    const struct ap_live_place *place = &slot->about.place;
    struct ap_error err;
    if (live_describe(&err, place, &slot->feed->info)) {
        fail(slot, AP_LIVE_FAILED, err.text);
        return;
    }
    set_driver(slot);
    bool is_told = place->descriptor_len || !bus->way.io->descriptor;
    if (!slot->feed->driver && is_told && !slot->live->all) {
        set_state(slot, AP_LIVE_NO_DRIVER);
        return;
    }
    if (place->denied) {
        char why[sizeof slot->about.why];
        ap_live_denied_text(place, slot->feed->driver, why, sizeof why);
        fail(slot, AP_LIVE_DENIED, why);
        return;
    }
    void *device = NULL;
    if (bus->way.io->open(&err, bus->way.bus, place, slot->index, &device)) {
        fail(slot, AP_LIVE_FAILED, err.text);
        return;
    }
    pthread_mutex_lock(&bus->lock);
    slot->device = device;
    slot->about.why[0] = '\0';
    set_state(slot, AP_LIVE_STARTING);
    pthread_mutex_unlock(&bus->lock);
    if (!is_told)
        ask_descriptor(slot);
    read_sensor_features(slot);
    set_driver(slot); // features may say that it is something else
    if (!slot->feed->driver && !slot->live->all) {
        close_device(slot);
        set_state(slot, AP_LIVE_NO_DRIVER);
        return;
    }
    begin_steps(slot);
}

// --- looking

static void look_at(struct live_bus *bus, const struct ap_live_place *place) {
    struct live_slot *slot = find_path(bus, place->path);
    if (slot && !is_same_device(&slot->about.place, place)) {
        // Another device has the node of one that went.
        lose(slot);
        close_device(slot);
        slot = NULL;
    }
    bool is_new = !slot;
    if (!slot)
        slot = find_gone(bus, place);
    if (!slot)
        slot = make_slot(bus);
    if (!slot)
        return;
    slot->seen = true;
    bool again = (live_slot_state(slot) == AP_LIVE_DENIED && !place->denied) ||
                 (live_slot_state(slot) == AP_LIVE_FAILED && now_of(bus) >= slot->retry_ns);
    if (!is_new && !again)
        return;
    pthread_mutex_lock(&bus->lock);
    slot->about.place = *place;
    pthread_mutex_unlock(&bus->lock);
    open_device(slot);
}

static void look(struct live_bus *bus) {
    struct ap_live *live = bus->live;
    for (int i = 0, count = live_slot_count(live); i < count; i++)
        if (live->slots[i]->bus == bus)
            live->slots[i]->seen = false;
    int n = bus->way.io->list(bus->way.bus, bus->places, AP_LIVE_DEVICES_MAX);
    for (int i = 0; i < n; i++) {
        // A stranger's: no terminal's commands, no lines of their own in a recording.
        ap_utf8_tidy(bus->places[i].name);
        ap_utf8_tidy(bus->places[i].serial);
        look_at(bus, &bus->places[i]);
    }
    for (int i = 0, count = live_slot_count(live); i < count; i++) {
        struct live_slot *slot = live->slots[i];
        if (slot->bus != bus || slot->seen)
            continue;
        lose(slot);
        close_device(slot);
    }
}

// What is due for a device; when it is next.
static int64_t tend(struct live_slot *slot, int64_t next_ns) {
    int64_t due_ns = next_ns;
    if (live_slot_state(slot) == AP_LIVE_FAILED)
        due_ns = slot->retry_ns;
    else if (slot->device && live_slot_state(slot) != AP_LIVE_GONE)
        due_ns = take_steps(slot);
    return due_ns < next_ns ? due_ns : next_ns;
}

int64_t live_keep_once(struct live_bus *bus) {
    struct ap_live *live = bus->live;
    look(bus);
    int64_t next_ns = now_of(bus) + LOOK_NS;
    for (int i = 0, count = live_slot_count(live); i < count; i++)
        if (live->slots[i]->bus == bus)
            next_ns = tend(live->slots[i], next_ns);
    atomic_fetch_add(&bus->scans, 1);
    return next_ns;
}

void *live_keep(void *arg) {
    struct live_bus *bus = arg;
    while (!atomic_load(&bus->stop)) {
        int64_t wait_ns = live_keep_once(bus) - now_of(bus);
        if (wait_ns > 0 && !atomic_load(&bus->stop))
            bus->way.io->watch(bus->way.bus, wait_ns);
    }
    return NULL;
}
