#include <hidapi.h>
#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "src/base/clock.h"
#include "src/device/live/place.h"
#include "src/device/live/queue.h"

// Whatever hidapi knows. It gives nothing that a thread could wait on for several devices, so each
// has a thread of its own that reads, dates and queues. Where there is a kernel's hidraw node
// behind a path, sysfs adds what hidapi cannot tell: where it is plugged in, permission, and,
// before hidapi 0.14, the report descriptor.

enum { QUEUE = 64, READ_MS = 20 };
static const int64_t LOOK_NS = 500000000; // nothing tells when a device comes

// Since 0.14, so perhaps not there.
int hid_get_report_descriptor(hid_device *device, unsigned char *bytes, size_t size)
    __attribute__((weak));

struct hidapi_bus {
    pthread_mutex_t lock;  // of everything but the devices' turns
    pthread_cond_t came;   // for the reader
    pthread_cond_t roused; // for the keeper
    bool has_come, is_roused;
    struct hidapi_device *devices;
};

// hidapi's calls about one device free each other's error texts, so only one may run at a time.
// Whoever wants to waits for its turn first: a mutex alone would hardly ever let the keeper in.
struct hidapi_device {
    struct hidapi_bus *bus;
    hid_device *hid;
    pthread_mutex_t turn, use;
    pthread_t thread;
    int tag;
    bool gone, closing; // the bus's lock
    struct live_queue queue;
    uint8_t *bytes; // the thread's
    struct hidapi_device *next;
};

// hid_exit ends hidapi for everybody in this process.
static pthread_mutex_t users_lock = PTHREAD_MUTEX_INITIALIZER;
static int users;

// --- what there is

// hidapi's strings are wide, one code point each.
static void copy_text(char *out, size_t size, const wchar_t *text) {
    size_t n = 0;
    for (; text && *text && n + 5 < size; text++) {
        unsigned long c = (unsigned long)*text;
        int more = c < 0x80 ? 0 : c < 0x800 ? 1 : c < 0x10000 ? 2 : 3;
        static const unsigned char first[] = {0, 0xc0, 0xe0, 0xf0};
        out[n++] = (char)(first[more] | (c >> (6 * more) & (more ? 0x3fu >> more : 0x7fu)));
        while (more-- > 0)
            out[n++] = (char)(0x80 | (c >> (6 * more) & 0x3f));
    }
    out[n] = '\0';
}

// As linux/input.h has them.
static uint16_t bus_number(const struct hid_device_info *info) {
    static const uint16_t numbers[] = {[HID_API_BUS_USB] = 3,
                                       [HID_API_BUS_BLUETOOTH] = 5,
                                       [HID_API_BUS_I2C] = 0x18,
                                       [HID_API_BUS_SPI] = 0x1c};
    unsigned type = (unsigned)info->bus_type;
    return type < sizeof numbers / sizeof *numbers ? numbers[type] : 0;
}

// The descriptor is not known yet; the collection's usage tells about sensors and caps.
static bool is_wanted(const struct hid_device_info *info, const struct ap_live_place *place) {
    return live_is_wanted(place) || info->usage_page == 0x20 ||
           (info->usage_page == 1 && info->usage == 8);
}

static bool read_place(const struct hid_device_info *info, struct ap_live_place *place) {
    static const char dev[] = "/dev/";
    if (!info->path || strlen(info->path) >= sizeof place->path)
        return false;
    bool is_node = strncmp(info->path, "/dev/hidraw", strlen("/dev/hidraw")) == 0;
    if (is_node)
        return live_hidraw_place("", info->path + strlen(dev), place);
    memset(place, 0, sizeof *place);
    snprintf(place->path, sizeof place->path, "%s", info->path);
    snprintf(place->port, sizeof place->port, "%s", info->path);
    copy_text(place->serial, sizeof place->serial, info->serial_number);
    copy_text(place->name, sizeof place->name, info->product_string);
    place->bus = bus_number(info);
    place->vendor = info->vendor_id;
    place->product = info->product_id;
    place->interface_number = info->interface_number;
    return is_wanted(info, place);
}

static bool is_listed(const struct ap_live_place *places, int count, const char *path) {
    for (int i = 0; i < count; i++)
        if (strcmp(places[i].path, path) == 0)
            return true;
    return false;
}

// A device stands there once for each of its collections.
static int list(void *bus, struct ap_live_place *places, int max) {
    (void)bus;
    int count = 0;
    struct hid_device_info *all = hid_enumerate(0, 0);
    for (const struct hid_device_info *i = all; i && count < max; i = i->next)
        if (i->path && !is_listed(places, count, i->path) && read_place(i, &places[count]))
            count++;
    hid_free_enumeration(all);
    return count;
}

// --- a device

static void take_turn(struct hidapi_device *d) {
    pthread_mutex_lock(&d->turn);
    pthread_mutex_lock(&d->use);
    pthread_mutex_unlock(&d->turn);
}

static bool keep(struct hidapi_device *d, int n, const uint8_t *bytes) {
    int64_t now_ns = ap_clock_now_ns();
    pthread_mutex_lock(&d->bus->lock);
    if (n > 0)
        live_queue_push(&d->queue, now_ns, bytes, (size_t)n);
    d->gone |= n < 0;
    bool is_over = d->gone || d->closing;
    if (n != 0) {
        d->bus->has_come = true;
        pthread_cond_signal(&d->bus->came);
    }
    pthread_mutex_unlock(&d->bus->lock);
    return !is_over;
}

// At an unplug hidapi fails while there are still reports in the kernel's queue; a read without a
// time limit gives them, and fails when there are no more.
static void *read_all(void *arg) {
    struct hidapi_device *d = arg;
    int limit_ms = READ_MS, n;
    do {
        take_turn(d);
        n = hid_read_timeout(d->hid, d->bytes, AP_HID_REPORT_MAX, limit_ms);
        pthread_mutex_unlock(&d->use);
        if (n < 0 && limit_ms > 0) {
            limit_ms = -1;
            n = 0;
        }
    } while (keep(d, n, d->bytes));
    return NULL;
}

static void unlink_device(struct hidapi_device *d) {
    pthread_mutex_lock(&d->bus->lock);
    d->closing = true;
    for (struct hidapi_device **at = &d->bus->devices; *at; at = &(*at)->next)
        if (*at == d) {
            *at = d->next;
            break;
        }
    pthread_mutex_unlock(&d->bus->lock);
}

static void free_device(struct hidapi_device *d) {
    if (d->hid)
        hid_close(d->hid);
    pthread_mutex_destroy(&d->turn);
    pthread_mutex_destroy(&d->use);
    live_queue_finish(&d->queue);
    free(d->bytes);
    free(d);
}

static void close_device(void *bus, void *arg) {
    struct hidapi_device *d = arg;
    (void)bus;
    unlink_device(d);
    pthread_join(d->thread, NULL);
    free_device(d);
}

// A signal would end hidapi's wait as if the device was gone.
static bool start_thread(struct hidapi_device *d) {
    sigset_t all, before;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);
    bool started = pthread_create(&d->thread, NULL, read_all, d) == 0;
    pthread_sigmask(SIG_SETMASK, &before, NULL);
    return started;
}

static enum ap_status fail_open(struct ap_error *err, const char *path, const char *why) {
    return ap_fail(err, AP_ENVIRONMENT, "%s: hidapi cannot open it: %s", path, why);
}

// hidapi 0.13.1 ends the program on a node that is no hidraw.
static enum ap_status open_device(struct ap_error *err, void *arg,
                                  const struct ap_live_place *place, int tag, void **out) {
    struct hidapi_bus *bus = arg;
    if (place->path[0] == '/' && !live_is_hidraw_node(place->path))
        return fail_open(err, place->path, "it is no hidraw node");
    struct hidapi_device *d = calloc(1, sizeof *d);
    if (!d)
        return fail_open(err, place->path, "out of memory");
    *d = (struct hidapi_device){.bus = bus, .tag = tag, .bytes = malloc(AP_HID_REPORT_MAX)};
    pthread_mutex_init(&d->turn, NULL);
    pthread_mutex_init(&d->use, NULL);
    bool has_memory = live_queue_init(&d->queue, QUEUE, AP_HID_REPORT_MAX) && d->bytes;
    d->hid = has_memory ? hid_open_path(place->path) : NULL;
    if (!d->hid || !start_thread(d)) {
        const char *why = !has_memory ? "out of memory" : d->hid ? "no thread" : "it refuses";
        free_device(d);
        return fail_open(err, place->path, why);
    }
    pthread_mutex_lock(&bus->lock);
    d->next = bus->devices;
    bus->devices = d;
    pthread_mutex_unlock(&bus->lock);
    *out = d;
    return AP_OK;
}

static int get_feature(void *bus, void *device, uint8_t *bytes, size_t len) {
    struct hidapi_device *d = device;
    (void)bus;
    take_turn(d);
    int n = hid_get_feature_report(d->hid, bytes, len);
    pthread_mutex_unlock(&d->use);
    return n;
}

static int send(struct hidapi_device *d, int (*call)(hid_device *, const unsigned char *, size_t),
                const uint8_t *bytes, size_t len) {
    take_turn(d);
    int n = call(d->hid, bytes, len);
    pthread_mutex_unlock(&d->use);
    return n;
}

static int set_feature(void *bus, void *device, const uint8_t *bytes, size_t len) {
    (void)bus;
    return send(device, hid_send_feature_report, bytes, len);
}

static int output(void *bus, void *device, const uint8_t *bytes, size_t len) {
    (void)bus;
    return send(device, hid_write, bytes, len);
}

static int descriptor(void *bus, void *device, uint8_t *bytes, size_t size) {
    struct hidapi_device *d = device;
    (void)bus;
    if (!hid_get_report_descriptor)
        return -1;
    take_turn(d);
    int n = hid_get_report_descriptor(d->hid, bytes, size);
    pthread_mutex_unlock(&d->use);
    return n;
}

static enum ap_live_read read_report(void *arg, void *device, uint8_t *bytes, size_t size,
                                     size_t *len, int64_t *t_ns) {
    struct hidapi_bus *bus = arg;
    struct hidapi_device *d = device;
    enum ap_live_read got = AP_LIVE_READ_NOTHING;
    pthread_mutex_lock(&bus->lock);
    if (live_queue_pop(&d->queue, bytes, size, len, t_ns))
        got = AP_LIVE_READ_REPORT;
    else if (d->gone)
        got = AP_LIVE_READ_GONE;
    pthread_mutex_unlock(&bus->lock);
    return got;
}

// --- waiting

// Until *flag, which is put down, or the time is over. The lock is held.
static void wait_for(struct hidapi_bus *bus, pthread_cond_t *cond, bool *flag, int64_t timeout_ns) {
    int64_t until_ns = ap_clock_now_ns() + timeout_ns;
    struct timespec t = {(time_t)(until_ns / 1000000000), (long)(until_ns % 1000000000)};
    while (!*flag && pthread_cond_timedwait(cond, &bus->lock, &t) == 0)
        continue;
    *flag = false;
}

static int wait_reports(void *arg, int *tags, int max, int64_t timeout_ns) {
    struct hidapi_bus *bus = arg;
    int count = 0;
    pthread_mutex_lock(&bus->lock);
    wait_for(bus, &bus->came, &bus->has_come, timeout_ns);
    for (struct hidapi_device *d = bus->devices; d && count < max; d = d->next)
        if (!live_queue_is_empty(&d->queue) || d->gone)
            tags[count++] = d->tag;
    pthread_mutex_unlock(&bus->lock);
    return count;
}

static void raise_flag(struct hidapi_bus *bus, pthread_cond_t *cond, bool *flag) {
    pthread_mutex_lock(&bus->lock);
    *flag = true;
    pthread_cond_signal(cond);
    pthread_mutex_unlock(&bus->lock);
}

static void wake(void *arg) {
    struct hidapi_bus *bus = arg;
    raise_flag(bus, &bus->came, &bus->has_come);
}

static void watch(void *arg, int64_t timeout_ns) {
    struct hidapi_bus *bus = arg;
    pthread_mutex_lock(&bus->lock);
    wait_for(bus, &bus->roused, &bus->is_roused, timeout_ns < LOOK_NS ? timeout_ns : LOOK_NS);
    pthread_mutex_unlock(&bus->lock);
}

static void rouse(void *arg) {
    struct hidapi_bus *bus = arg;
    raise_flag(bus, &bus->roused, &bus->is_roused);
}

static int64_t now_ns(void *bus) {
    (void)bus;
    return ap_clock_now_ns();
}

// --- the bus

static void destroy(void *arg) {
    struct hidapi_bus *bus = arg;
    pthread_mutex_lock(&users_lock);
    if (--users == 0)
        hid_exit();
    pthread_mutex_unlock(&users_lock);
    pthread_cond_destroy(&bus->came);
    pthread_cond_destroy(&bus->roused);
    pthread_mutex_destroy(&bus->lock);
    free(bus);
}

static const struct ap_live_io io = {
    .name = "hidapi",
    .list = list,
    .open = open_device,
    .close = close_device,
    .get_feature = get_feature,
    .set_feature = set_feature,
    .output = output,
    .descriptor = descriptor,
    .wait = wait_reports,
    .wake = wake,
    .read = read_report,
    .watch = watch,
    .rouse = rouse,
    .now_ns = now_ns,
    .destroy = destroy,
};

enum ap_status ap_live_hidapi(struct ap_error *err, struct ap_live_bus *out) {
    struct hidapi_bus *bus = calloc(1, sizeof *bus);
    if (!bus)
        return ap_fail(err, AP_ENVIRONMENT, "devices: out of memory");
    pthread_mutex_lock(&users_lock);
    bool is_there = hid_init() == 0;
    users += is_there;
    pthread_mutex_unlock(&users_lock);
    if (!is_there) {
        free(bus);
        return ap_fail(err, AP_ENVIRONMENT, "devices: hidapi does not start");
    }
    pthread_condattr_t clock;
    pthread_condattr_init(&clock);
    pthread_condattr_setclock(&clock, CLOCK_MONOTONIC); // ap_clock_now_ns's
    pthread_mutex_init(&bus->lock, NULL);
    pthread_cond_init(&bus->came, &clock);
    pthread_cond_init(&bus->roused, &clock);
    pthread_condattr_destroy(&clock);
    *out = (struct ap_live_bus){&io, bus};
    return AP_OK;
}
