#include "tests/device/live/fake_bus.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "tests/device/hid/bytes_of.h"

static struct timespec soon(int64_t ns) {
    struct timespec t;
    clock_gettime(CLOCK_REALTIME, &t);
    ns += t.tv_nsec;
    t.tv_sec += ns / 1000000000;
    t.tv_nsec = ns % 1000000000;
    return t;
}

static int list(void *arg, struct ap_live_place *places, int max) {
    struct fake_bus *fake = arg;
    int count = 0;
    pthread_mutex_lock(&fake->lock);
    for (int i = 0; i < FAKE_DEVICES && count < max; i++)
        if (fake->devices[i].plugged || fake->devices[i].dying)
            places[count++] = fake->devices[i].place;
    pthread_mutex_unlock(&fake->lock);
    return count;
}

static enum ap_status open_device(struct ap_error *err, void *arg,
                                  const struct ap_live_place *place, int tag, void **out) {
    struct fake_bus *fake = arg;
    enum ap_status st = AP_ENVIRONMENT;
    pthread_mutex_lock(&fake->lock);
    for (int i = 0; i < FAKE_DEVICES; i++) {
        struct fake_device *d = &fake->devices[i];
        if (!d->plugged || strcmp(d->place.path, place->path) != 0)
            continue;
        d->opened_count++;
        if (d->refuses_open || d->open)
            break;
        d->open = true;
        d->tag = tag;
        *out = d;
        st = AP_OK;
        break;
    }
    pthread_mutex_unlock(&fake->lock);
    return st ? ap_fail(err, st, "%s: cannot be opened", place->path) : AP_OK;
}

static void close_device(void *arg, void *device) {
    struct fake_bus *fake = arg;
    pthread_mutex_lock(&fake->lock);
    ((struct fake_device *)device)->open = false;
    pthread_mutex_unlock(&fake->lock);
}

static int get_feature(void *arg, void *device, uint8_t *bytes, size_t len) {
    struct fake_bus *fake = arg;
    struct fake_device *d = device;
    int got = -1;
    pthread_mutex_lock(&fake->lock);
    for (int i = 0; i < d->feature_count && !d->refuses_features; i++)
        if (d->features[i].bytes[0] == bytes[0]) {
            got = (int)(d->features[i].len < len ? d->features[i].len : len);
            memcpy(bytes, d->features[i].bytes, (size_t)got);
        }
    pthread_mutex_unlock(&fake->lock);
    return got;
}

static int take(void *arg, void *device, const uint8_t *bytes, size_t len) {
    struct fake_bus *fake = arg;
    struct fake_device *d = device;
    pthread_mutex_lock(&fake->lock);
    int got = d->refuses_features || len > sizeof d->sent[0].bytes ? -1 : (int)len;
    if (got > 0 && d->sent_count < FAKE_SENT) {
        d->sent_ns[d->sent_count] = fake->now_ns;
        d->sent[d->sent_count].len = len;
        memcpy(d->sent[d->sent_count++].bytes, bytes, len);
    }
    pthread_mutex_unlock(&fake->lock);
    return got;
}

// Something to do for one of the two, which may give the other something to do.
static void stir(struct fake_bus *fake) {
    fake->waiting = fake->watching = 0;
}

static int collect(struct fake_bus *fake, int *tags, int max) {
    int count = 0;
    for (int i = 0; i < FAKE_DEVICES && count < max && !fake->held; i++) {
        const struct fake_device *d = &fake->devices[i];
        if (d->open && (d->queued || !d->plugged))
            tags[count++] = d->tag;
    }
    return count;
}

static int wait_reports(void *arg, int *tags, int max, int64_t timeout_ns) {
    struct fake_bus *fake = arg;
    (void)timeout_ns; // the clock is the test's: a look now and then
    struct timespec until = soon(2000000);
    pthread_mutex_lock(&fake->lock);
    int count = collect(fake, tags, max);
    if (count > 0)
        stir(fake);
    fake->waiting += count == 0 && !fake->held;
    if (count == 0 && !fake->woken) {
        pthread_cond_broadcast(&fake->changed);
        pthread_cond_timedwait(&fake->changed, &fake->lock, &until);
        count = collect(fake, tags, max);
        if (count > 0)
            stir(fake);
    }
    fake->woken = false;
    pthread_mutex_unlock(&fake->lock);
    return count;
}

static void raise_flag(struct fake_bus *fake, bool *flag) {
    pthread_mutex_lock(&fake->lock);
    *flag = true;
    stir(fake);
    pthread_cond_broadcast(&fake->changed);
    pthread_mutex_unlock(&fake->lock);
}

static void wake(void *arg) {
    struct fake_bus *fake = arg;
    raise_flag(fake, &fake->woken);
}

static void rouse(void *arg) {
    struct fake_bus *fake = arg;
    raise_flag(fake, &fake->roused);
}

static enum ap_live_read read_report(void *arg, void *device, uint8_t *bytes, size_t size,
                                     size_t *len, int64_t *t_ns) {
    struct fake_bus *fake = arg;
    struct fake_device *d = device;
    (void)t_ns;
    enum ap_live_read got = AP_LIVE_READ_NOTHING;
    pthread_mutex_lock(&fake->lock);
    if (d->queued) {
        const struct fake_report *r = &d->queue[0];
        *len = r->len < size ? r->len : size;
        memcpy(bytes, r->bytes, *len);
        memmove(d->queue, d->queue + 1, (size_t)--d->queued * sizeof *d->queue);
        got = AP_LIVE_READ_REPORT;
    } else if (!d->plugged) {
        got = AP_LIVE_READ_GONE;
    }
    pthread_mutex_unlock(&fake->lock);
    return got;
}

static void watch(void *arg, int64_t timeout_ns) {
    struct fake_bus *fake = arg;
    (void)timeout_ns;
    struct timespec until = soon(2000000);
    pthread_mutex_lock(&fake->lock);
    fake->watching++;
    if (!fake->roused) {
        pthread_cond_broadcast(&fake->changed);
        pthread_cond_timedwait(&fake->changed, &fake->lock, &until);
    }
    fake->roused = false;
    pthread_mutex_unlock(&fake->lock);
}

static int64_t now_ns(void *arg) {
    struct fake_bus *fake = arg;
    pthread_mutex_lock(&fake->lock);
    int64_t now = fake->now_ns;
    pthread_mutex_unlock(&fake->lock);
    return now;
}

static void destroy(void *arg) {
    struct fake_bus *fake = arg;
    fake->destroyed = true;
}

static const struct ap_live_io io = {
    .name = "fake",
    .list = list,
    .open = open_device,
    .close = close_device,
    .get_feature = get_feature,
    .set_feature = take,
    .output = take,
    .wait = wait_reports,
    .wake = wake,
    .read = read_report,
    .queue_len = FAKE_QUEUE,
    .watch = watch,
    .rouse = rouse,
    .now_ns = now_ns,
    .destroy = destroy,
};

struct fake_bus *fake_bus_create(int64_t now) {
    struct fake_bus *fake = calloc(1, sizeof *fake);
    if (!fake)
        abort();
    pthread_mutex_init(&fake->lock, NULL);
    pthread_cond_init(&fake->changed, NULL);
    fake->now_ns = now;
    return fake;
}

void fake_bus_free(struct fake_bus *fake) {
    pthread_cond_destroy(&fake->changed);
    pthread_mutex_destroy(&fake->lock);
    free(fake);
}

struct ap_live_bus fake_way(struct fake_bus *fake) {
    return (struct ap_live_bus){&io, fake};
}

int fake_plug_place(struct fake_bus *fake, const struct ap_live_place *place) {
    int device = 0;
    pthread_mutex_lock(&fake->lock);
    while (fake->devices[device].place.path[0])
        device++;
    struct fake_device *d = &fake->devices[device];
    d->place = *place;
    d->plugged = true;
    if (!d->place.path[0])
        snprintf(d->place.path, sizeof d->place.path, "/dev/hidraw%d", device);
    fake->roused = true;
    pthread_cond_broadcast(&fake->changed);
    pthread_mutex_unlock(&fake->lock);
    return device;
}

int fake_plug(struct fake_bus *fake, const char *serial, uint16_t bus, uint16_t vendor,
              uint16_t product, const char *name, const char *descriptor) {
    struct ap_live_place place = {
        .bus = bus, .vendor = vendor, .product = product, .interface_number = -1};
    snprintf(place.serial, sizeof place.serial, "%s", serial);
    snprintf(place.name, sizeof place.name, "%s", name);
    place.descriptor_len =
        bytes_of(descriptor, strlen(descriptor), place.descriptor, sizeof place.descriptor);
    return fake_plug_place(fake, &place);
}

void fake_unplug(struct fake_bus *fake, int device) {
    pthread_mutex_lock(&fake->lock);
    fake->devices[device].plugged = fake->devices[device].dying = false;
    pthread_cond_broadcast(&fake->changed);
    pthread_mutex_unlock(&fake->lock);
}

void fake_begin_unplug(struct fake_bus *fake, int device) {
    pthread_mutex_lock(&fake->lock);
    fake->devices[device].plugged = false;
    fake->devices[device].dying = true;
    pthread_cond_broadcast(&fake->changed);
    pthread_mutex_unlock(&fake->lock);
}

void fake_replug(struct fake_bus *fake, int device, const char *path) {
    pthread_mutex_lock(&fake->lock);
    struct fake_device *d = &fake->devices[device];
    d->plugged = true;
    d->queued = d->sent_count = 0;
    if (path)
        snprintf(d->place.path, sizeof d->place.path, "%s", path);
    fake->roused = true;
    pthread_cond_broadcast(&fake->changed);
    pthread_mutex_unlock(&fake->lock);
}

void fake_feature(struct fake_bus *fake, int device, const uint8_t *bytes, size_t len) {
    pthread_mutex_lock(&fake->lock);
    struct fake_device *d = &fake->devices[device];
    struct fake_report *f = &d->features[d->feature_count++];
    f->len = len;
    memcpy(f->bytes, bytes, len);
    pthread_mutex_unlock(&fake->lock);
}

void fake_send(struct fake_bus *fake, int device, const uint8_t *bytes, size_t len) {
    pthread_mutex_lock(&fake->lock);
    struct fake_device *d = &fake->devices[device];
    if (d->queued == FAKE_QUEUE) {
        d->dropped++;
    } else {
        d->queue[d->queued].len = len;
        memcpy(d->queue[d->queued++].bytes, bytes, len);
    }
    pthread_cond_broadcast(&fake->changed);
    pthread_mutex_unlock(&fake->lock);
}

void fake_set_now(struct fake_bus *fake, int64_t now) {
    pthread_mutex_lock(&fake->lock);
    fake->now_ns = now;
    pthread_mutex_unlock(&fake->lock);
}

void fake_hold(struct fake_bus *fake, bool held) {
    pthread_mutex_lock(&fake->lock);
    fake->held = held;
    pthread_cond_broadcast(&fake->changed);
    pthread_mutex_unlock(&fake->lock);
}

// Whoever waits twice with nothing to do has done what there was to do before the first time; and
// both have, without one having roused the other since.
bool fake_settle(struct fake_bus *fake) {
    struct timespec until = soon(5000000000);
    pthread_mutex_lock(&fake->lock);
    stir(fake);
    fake->roused = true;
    bool in_time = true;
    while (in_time && (fake->waiting < 2 || fake->watching < 2)) {
        pthread_cond_broadcast(&fake->changed);
        in_time = pthread_cond_timedwait(&fake->changed, &fake->lock, &until) == 0;
    }
    pthread_mutex_unlock(&fake->lock);
    return in_time;
}
