#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "src/base/clock.h"
#include "src/device/hid/recording.h"
#include "src/device/log/line_reader.h"
#include "src/device/live/io.h"

// Recordings as devices: plugged in at the beginning, unplugged after the last report, and between
// them each report at its time. The layer above cannot tell.

enum { FEATURES_MAX = 16 };

struct replay_report {
    int64_t t_ns; // since the recording's first
    size_t at, len;
};

struct replay_device {
    struct ap_live_place place;
    int64_t number; // of its D: line
    int feature_count;
    struct ap_feature_report features[FEATURES_MAX];
    struct replay_report *reports;
    size_t report_count, report_room, next;
    uint8_t *bytes;
    size_t byte_count, byte_room;
    int tag;
    bool open;
};

struct replay_bus {
    pthread_mutex_t lock;
    pthread_cond_t changed; // on the monotonic clock
    bool woken, roused;
    int64_t start_ns; // of what is the recordings' time 0; INT64_MAX: nothing is open yet
    struct replay_device *devices;
    int device_count;
};

// --- reading

static bool grow(void **memory, size_t *room, size_t need, size_t each) {
    if (need <= *room)
        return true;
    size_t wanted = *room ? *room * 2 : 256;
    while (wanted < need)
        wanted *= 2;
    void *more = realloc(*memory, wanted * each);
    if (!more)
        return false;
    *memory = more;
    *room = wanted;
    return true;
}

static struct replay_device *add_device(struct replay_bus *bus, const char *file, int64_t number) {
    struct replay_device *more =
        realloc(bus->devices, (size_t)(bus->device_count + 1) * sizeof *more);
    if (!more)
        return NULL;
    bus->devices = more;
    struct replay_device *d = &more[bus->device_count++];
    *d = (struct replay_device){.number = number};
    d->place.interface_number = -1;
    snprintf(d->place.path, sizeof d->place.path, "%.200s#%d", file, (int)number);
    memcpy(d->place.port, d->place.path, sizeof d->place.port);
    return d;
}

static bool add_report(struct replay_device *d, const struct ap_hid_line *line) {
    if (!grow((void **)&d->reports, &d->report_room, d->report_count + 1, sizeof *d->reports) ||
        !grow((void **)&d->bytes, &d->byte_room, d->byte_count + line->byte_count, 1))
        return false;
    d->reports[d->report_count++] =
        (struct replay_report){line->t_ns, d->byte_count, line->byte_count};
    memcpy(d->bytes + d->byte_count, line->bytes, line->byte_count);
    d->byte_count += line->byte_count;
    return true;
}

static void take_text(char *out, size_t size, struct ap_field text) {
    size_t n = text.len < size ? text.len : size - 1;
    memcpy(out, text.text, n);
    out[n] = '\0';
}

static bool take_line(struct replay_device *d, const struct ap_hid_line *line) {
    struct ap_live_place *p = &d->place;
    switch (line->kind) {
    case AP_HID_LINE_DESCRIPTOR:
        p->descriptor_len =
            line->byte_count < sizeof p->descriptor ? line->byte_count : sizeof p->descriptor;
        memcpy(p->descriptor, line->bytes, p->descriptor_len);
        return true;
    case AP_HID_LINE_NAME:
        take_text(p->name, sizeof p->name, line->text);
        return true;
    case AP_HID_LINE_IDS:
        p->bus = line->bus;
        p->vendor = line->vendor;
        p->product = line->product;
        return true;
    case AP_HID_LINE_FEATURE:
        if (d->feature_count < FEATURES_MAX && line->byte_count <= AP_DEVICE_FEATURE_BYTES) {
            struct ap_feature_report *f = &d->features[d->feature_count++];
            f->len = line->byte_count;
            memcpy(f->bytes, line->bytes, f->len);
        }
        return true;
    case AP_HID_LINE_REPORT:
        return add_report(d, line);
    case AP_HID_LINE_DEVICE:
    case AP_HID_LINE_NOTHING:
        break;
    }
    return true;
}

// What stands before the first D: line belongs to its device.
static struct replay_device *choose(struct replay_bus *bus, int first, const char *file,
                                    int64_t number, bool *numbered) {
    if (!*numbered) {
        *numbered = true;
        bus->devices[first].number = number;
        return &bus->devices[first];
    }
    for (int i = first; i < bus->device_count; i++)
        if (bus->devices[i].number == number)
            return &bus->devices[i];
    return add_device(bus, file, number);
}

static enum ap_status read_lines(struct ap_error *err, struct replay_bus *bus, const char *file,
                                 struct ap_line_reader *reader) {
    static _Thread_local struct ap_hid_line line;
    int first = bus->device_count;
    bool numbered = false;
    struct replay_device *d = add_device(bus, file, 0);
    for (;;) {
        const char *text;
        size_t len;
        enum ap_line_kind kind;
        enum ap_status st = ap_line_reader_next(err, reader, &kind, &text, &len);
        if (st || kind == AP_LINE_END)
            return st;
        if (kind == AP_LINE_TOO_LONG)
            return ap_fail(err, AP_INPUT, "%s:%lld: a line of more than %d bytes", file,
                           (long long)reader->line, AP_LINE_MAX);
        struct ap_bad_line bad;
        if (!ap_hid_parse_line(text, len, &line, &bad))
            return ap_fail(err, AP_INPUT, "%s:%lld:%zu: expected %s", file, (long long)reader->line,
                           bad.column, bad.expected);
        if (d && line.kind == AP_HID_LINE_DEVICE)
            d = choose(bus, first, file, line.device, &numbered);
        if (!d || !take_line(d, &line))
            return ap_fail(err, AP_ENVIRONMENT, "%s: out of memory", file);
    }
}

// Every recording begins at its own first report. Devices without reports are none.
static enum ap_status begin_at_zero(struct ap_error *err, struct replay_bus *bus, int first,
                                    const char *file) {
    int64_t t0 = INT64_MAX;
    size_t reports = 0;
    for (int i = first; i < bus->device_count; i++)
        if (bus->devices[i].report_count && bus->devices[i].reports[0].t_ns < t0)
            t0 = bus->devices[i].reports[0].t_ns;
    for (int i = first; i < bus->device_count; i++) {
        struct replay_device *d = &bus->devices[i];
        int64_t before = 0;
        for (size_t r = 0; r < d->report_count; r++, reports++) {
            int64_t t = d->reports[r].t_ns - t0;
            d->reports[r].t_ns = before = t > before ? t : before;
        }
    }
    return reports ? AP_OK : ap_fail(err, AP_INPUT, "%s: no report in this HID recording", file);
}

static enum ap_status read_recording(struct ap_error *err, struct replay_bus *bus,
                                     const char *file) {
    struct ap_line_reader reader;
    int first = bus->device_count;
    enum ap_status st = ap_line_reader_open(err, &reader, file);
    if (!st)
        st = read_lines(err, bus, file, &reader);
    ap_line_reader_close(&reader);
    return st ? st : begin_at_zero(err, bus, first, file);
}

// --- time

static int64_t now_ns(void *bus) {
    (void)bus;
    return ap_clock_now_ns();
}

static bool is_over(const struct replay_device *d) {
    return d->next >= d->report_count;
}

static int64_t due_ns(const struct replay_bus *bus, const struct replay_device *d) {
    return bus->start_ns == INT64_MAX ? INT64_MAX : bus->start_ns + d->reports[d->next].t_ns;
}

// Until `until_ns` or the flag; the flag is taken back. The lock is held.
static void sleep_until(struct replay_bus *bus, int64_t until_ns, bool *flag) {
    struct timespec until = {.tv_sec = (time_t)(until_ns / 1000000000),
                             .tv_nsec = (long)(until_ns % 1000000000)};
    if (!*flag)
        pthread_cond_timedwait(&bus->changed, &bus->lock, &until);
    *flag = false;
}

static void raise_flag(struct replay_bus *bus, bool *flag) {
    pthread_mutex_lock(&bus->lock);
    *flag = true;
    pthread_cond_broadcast(&bus->changed);
    pthread_mutex_unlock(&bus->lock);
}

static void wake(void *arg) {
    struct replay_bus *bus = arg;
    raise_flag(bus, &bus->woken);
}

static void rouse(void *arg) {
    struct replay_bus *bus = arg;
    raise_flag(bus, &bus->roused);
}

static void watch(void *arg, int64_t timeout_ns) {
    struct replay_bus *bus = arg;
    pthread_mutex_lock(&bus->lock);
    sleep_until(bus, ap_clock_now_ns() + timeout_ns, &bus->roused);
    pthread_mutex_unlock(&bus->lock);
}

// What has something at `now`; *next_ns is when somebody has.
static int collect(struct replay_bus *bus, int64_t now, int *tags, int max, int64_t *next_ns) {
    int count = 0;
    for (int i = 0; i < bus->device_count && count < max; i++) {
        struct replay_device *d = &bus->devices[i];
        int64_t due = d->open && !is_over(d) ? due_ns(bus, d) : d->open ? 0 : INT64_MAX;
        if (due <= now)
            tags[count++] = d->tag;
        else if (due < *next_ns)
            *next_ns = due;
    }
    return count;
}

static int wait_reports(void *arg, int *tags, int max, int64_t timeout_ns) {
    struct replay_bus *bus = arg;
    int64_t now = ap_clock_now_ns(), next_ns = now + timeout_ns;
    pthread_mutex_lock(&bus->lock);
    int count = collect(bus, now, tags, max, &next_ns);
    if (count == 0) {
        sleep_until(bus, next_ns, &bus->woken);
        count = collect(bus, ap_clock_now_ns(), tags, max, &next_ns);
    }
    pthread_mutex_unlock(&bus->lock);
    return count;
}

// --- devices

static int list(void *arg, struct ap_live_place *places, int max) {
    struct replay_bus *bus = arg;
    int count = 0;
    pthread_mutex_lock(&bus->lock);
    for (int i = 0; i < bus->device_count && count < max; i++)
        if (!is_over(&bus->devices[i]))
            places[count++] = bus->devices[i].place;
    pthread_mutex_unlock(&bus->lock);
    return count;
}

// Time begins a moment after the first device is opened, so that the others are open, too.
static enum ap_status open_device(struct ap_error *err, void *arg,
                                  const struct ap_live_place *place, int tag, void **out) {
    static const int64_t AFTER_NS = 100000000;
    struct replay_bus *bus = arg;
    enum ap_status st = AP_ENVIRONMENT;
    pthread_mutex_lock(&bus->lock);
    for (int i = 0; i < bus->device_count && st; i++) {
        struct replay_device *d = &bus->devices[i];
        if (strcmp(d->place.path, place->path) != 0)
            continue;
        d->tag = tag;
        d->open = true;
        *out = d;
        if (bus->start_ns == INT64_MAX)
            bus->start_ns = ap_clock_now_ns() + AFTER_NS;
        pthread_cond_broadcast(&bus->changed);
        st = AP_OK;
    }
    pthread_mutex_unlock(&bus->lock);
    return st ? ap_fail(err, st, "%s: is no recording", place->path) : AP_OK;
}

static void close_device(void *arg, void *device) {
    struct replay_bus *bus = arg;
    pthread_mutex_lock(&bus->lock);
    ((struct replay_device *)device)->open = false;
    pthread_mutex_unlock(&bus->lock);
}

static int get_feature(void *bus, void *device, uint8_t *bytes, size_t len) {
    const struct replay_device *d = device;
    (void)bus;
    for (int i = d->feature_count; i-- > 0;)
        if (d->features[i].len && d->features[i].bytes[0] == bytes[0]) {
            size_t n = d->features[i].len < len ? d->features[i].len : len;
            memcpy(bytes, d->features[i].bytes, n);
            return (int)n;
        }
    return -1;
}

// What is sent to a recording does nothing.
static int swallow(void *bus, void *device, const uint8_t *bytes, size_t len) {
    (void)bus, (void)device, (void)bytes;
    return (int)len;
}

static enum ap_live_read read_report(void *arg, void *device, uint8_t *bytes, size_t size,
                                     size_t *len, int64_t *t_ns) {
    struct replay_bus *bus = arg;
    struct replay_device *d = device;
    enum ap_live_read got = AP_LIVE_READ_NOTHING;
    pthread_mutex_lock(&bus->lock);
    if (is_over(d)) {
        got = AP_LIVE_READ_GONE;
    } else if (due_ns(bus, d) <= ap_clock_now_ns()) {
        const struct replay_report *r = &d->reports[d->next];
        *t_ns = due_ns(bus, d);
        *len = r->len < size ? r->len : size;
        memcpy(bytes, d->bytes + r->at, *len);
        d->next++;
        got = AP_LIVE_READ_REPORT;
    }
    pthread_mutex_unlock(&bus->lock);
    return got;
}

static void destroy(void *arg) {
    struct replay_bus *bus = arg;
    for (int i = 0; i < bus->device_count; i++) {
        free(bus->devices[i].reports);
        free(bus->devices[i].bytes);
    }
    free(bus->devices);
    pthread_cond_destroy(&bus->changed);
    pthread_mutex_destroy(&bus->lock);
    free(bus);
}

static const struct ap_live_io io = {
    .name = "replay",
    .list = list,
    .open = open_device,
    .close = close_device,
    .get_feature = get_feature,
    .set_feature = swallow,
    .output = swallow,
    .wait = wait_reports,
    .wake = wake,
    .read = read_report,
    .watch = watch,
    .rouse = rouse,
    .now_ns = now_ns,
    .destroy = destroy,
};

enum ap_status ap_live_replay(struct ap_error *err, const char *const *files, size_t count,
                              struct ap_live_bus *out) {
    struct replay_bus *bus = calloc(1, sizeof *bus);
    if (!bus)
        return ap_fail(err, AP_ENVIRONMENT, "devices: out of memory");
    bus->start_ns = INT64_MAX;
    pthread_condattr_t monotonic;
    pthread_condattr_init(&monotonic);
    pthread_condattr_setclock(&monotonic, CLOCK_MONOTONIC);
    pthread_cond_init(&bus->changed, &monotonic);
    pthread_condattr_destroy(&monotonic);
    pthread_mutex_init(&bus->lock, NULL);
    enum ap_status st = AP_OK;
    for (size_t i = 0; i < count && !st; i++)
        st = read_recording(err, bus, files[i]);
    if (st) {
        destroy(bus);
        return st;
    }
    *out = (struct ap_live_bus){&io, bus};
    return AP_OK;
}
