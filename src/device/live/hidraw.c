#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <linux/hidraw.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <sys/inotify.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <poll.h>
#include <unistd.h>

#include "src/base/clock.h"
#include "src/device/live/place.h"

// The kernel's own interface: a node for each HID interface, reports as they come. hidapi's hidraw
// backend stands on the same nodes, but gives no descriptor to wait on, so that a thread could read
// one device only; forgets what is queued when a device is unplugged; cannot give a report
// descriptor in Debian's version; and ends the program on a path that is none (docs/devices.md).

enum { WAKE_TAG = -1, QUEUE = 63 };

struct hidraw_bus {
    char root[LIVE_ROOT_MAX];
    int epoll, wake, rouse, inotify;
};

struct hidraw_device {
    int fd;
};

// --- what there is

static int by_number(const struct dirent **a, const struct dirent **b) {
    return strverscmp((*a)->d_name, (*b)->d_name);
}

static int is_hidraw(const struct dirent *entry) {
    return strncmp(entry->d_name, "hidraw", 6) == 0 && strlen(entry->d_name) < 20;
}

static int list(void *arg, struct ap_live_place *places, int max) {
    struct hidraw_bus *bus = arg;
    char path[LIVE_ROOT_MAX + 32];
    snprintf(path, sizeof path, "%s/sys/class/hidraw", bus->root);
    struct dirent **entries = NULL;
    int n = scandir(path, &entries, is_hidraw, by_number), count = 0;
    for (int i = 0; i < n; i++) {
        if (count < max && live_hidraw_place(bus->root, entries[i]->d_name, &places[count]))
            count++;
        free(entries[i]);
    }
    free(entries);
    return count;
}

// --- a device

static enum ap_status fail_open(struct ap_error *err, const char *path, int number) {
    return ap_fail(err, AP_ENVIRONMENT, "%s: cannot be opened: %s", path, strerror(number));
}

static enum ap_status open_device(struct ap_error *err, void *arg,
                                  const struct ap_live_place *place, int tag, void **out) {
    struct hidraw_bus *bus = arg;
    int fd = open(place->path, O_RDWR | O_NONBLOCK | O_CLOEXEC | O_NOCTTY);
    if (fd < 0)
        return fail_open(err, place->path, errno);
    struct stat s;
    int size = 0;
    struct hidraw_device *device = calloc(1, sizeof *device);
    enum ap_status st = device ? AP_OK : fail_open(err, place->path, ENOMEM);
    if (!st &&
        (fstat(fd, &s) != 0 || !S_ISCHR(s.st_mode) || ioctl(fd, HIDIOCGRDESCSIZE, &size) < 0))
        st = ap_fail(err, AP_ENVIRONMENT, "%s: is no hidraw node", place->path);
    struct epoll_event event = {.events = EPOLLIN, .data = {.u64 = (uint64_t)tag}};
    if (!st && epoll_ctl(bus->epoll, EPOLL_CTL_ADD, fd, &event) != 0)
        st = fail_open(err, place->path, errno);
    if (st) {
        free(device);
        close(fd);
        return st;
    }
    device->fd = fd;
    *out = device;
    return AP_OK;
}

enum ap_status ap_live_hidraw_resolve(struct ap_error *err, char path[AP_LIVE_PATH_MAX]) {
    char *real = realpath(path, NULL);
    if (!real)
        return AP_OK;
    bool fits = strlen(real) < AP_LIVE_PATH_MAX;
    enum ap_status st = AP_OK;
    if (!fits || !live_is_hidraw_node(real))
        st = ap_fail(err, AP_INPUT,
                     "%s: is no hidraw node; antipode devices lists what is plugged in", path);
    else
        memcpy(path, real, strlen(real) + 1);
    free(real);
    return st;
}

static void close_device(void *bus, void *arg) {
    (void)bus;
    struct hidraw_device *device = arg;
    close(device->fd); // which takes it out of the epoll set, too
    free(device);
}

static int get_feature(void *bus, void *device, uint8_t *bytes, size_t len) {
    (void)bus;
    return ioctl(((struct hidraw_device *)device)->fd, HIDIOCGFEATURE(len), bytes);
}

static int set_feature(void *bus, void *device, const uint8_t *bytes, size_t len) {
    (void)bus;
    uint8_t copy[AP_DRIVER_STEP_BYTES]; // the call's type wants it writable
    memcpy(copy, bytes, len);
    return ioctl(((struct hidraw_device *)device)->fd, HIDIOCSFEATURE(len), copy);
}

static int output(void *bus, void *device, const uint8_t *bytes, size_t len) {
    (void)bus;
    return (int)write(((struct hidraw_device *)device)->fd, bytes, len);
}

static enum ap_live_read read_report(void *bus, void *device, uint8_t *bytes, size_t size,
                                     size_t *len, int64_t *t_ns) {
    (void)bus, (void)t_ns;
    ssize_t n;
    do
        n = read(((struct hidraw_device *)device)->fd, bytes, size);
    while (n < 0 && errno == EINTR);
    if (n > 0) {
        *len = (size_t)n;
        return AP_LIVE_READ_REPORT;
    }
    return n < 0 && errno == EAGAIN ? AP_LIVE_READ_NOTHING : AP_LIVE_READ_GONE;
}

// --- waiting

static void drain_event(int fd) {
    uint64_t count;
    ssize_t n = read(fd, &count, sizeof count);
    (void)n; // it is non-blocking, and what it says does not matter
}

static void raise_event(int fd) {
    const uint64_t one = 1;
    ssize_t n = write(fd, &one, sizeof one);
    (void)n; // full means raised
}

static int milliseconds(int64_t ns) {
    return ns >= 1000000000 ? 1000 : (int)((ns + 999999) / 1000000);
}

static int wait_reports(void *arg, int *tags, int max, int64_t timeout_ns) {
    struct hidraw_bus *bus = arg;
    struct epoll_event events[64];
    int n = epoll_wait(bus->epoll, events, max < 64 ? max : 64, milliseconds(timeout_ns));
    int count = 0;
    for (int i = 0; i < n; i++) {
        int tag = (int)(int64_t)events[i].data.u64;
        if (tag == WAKE_TAG)
            drain_event(bus->wake);
        else
            tags[count++] = tag;
    }
    return count;
}

static void wake(void *bus) {
    raise_event(((struct hidraw_bus *)bus)->wake);
}

static void watch(void *arg, int64_t timeout_ns) {
    struct hidraw_bus *bus = arg;
    struct pollfd fds[2] = {{.fd = bus->rouse, .events = POLLIN},
                            {.fd = bus->inotify, .events = POLLIN}};
    char events[4096];
    if (poll(fds, 2, milliseconds(timeout_ns)) <= 0)
        return;
    drain_event(bus->rouse);
    while (read(bus->inotify, events, sizeof events) > 0)
        continue; // what it was is looked up
}

static void rouse(void *bus) {
    raise_event(((struct hidraw_bus *)bus)->rouse);
}

static int64_t now_ns(void *bus) {
    (void)bus;
    return ap_clock_now_ns();
}

static void destroy(void *arg) {
    struct hidraw_bus *bus = arg;
    const int fds[] = {bus->epoll, bus->wake, bus->rouse, bus->inotify};
    for (int i = 0; i < 4; i++)
        if (fds[i] >= 0)
            close(fds[i]);
    free(bus);
}

static const struct ap_live_io io = {
    .name = "hidraw",
    .list = list,
    .open = open_device,
    .close = close_device,
    .get_feature = get_feature,
    .set_feature = set_feature,
    .output = output,
    .wait = wait_reports,
    .wake = wake,
    .read = read_report,
    .queue_len = QUEUE,
    .watch = watch,
    .rouse = rouse,
    .now_ns = now_ns,
    .destroy = destroy,
};

enum ap_status ap_live_hidraw(struct ap_error *err, const char *root, struct ap_live_bus *out) {
    struct hidraw_bus *bus = calloc(1, sizeof *bus);
    if (!bus)
        return ap_fail(err, AP_ENVIRONMENT, "devices: out of memory");
    snprintf(bus->root, sizeof bus->root, "%s", root);
    bus->epoll = epoll_create1(EPOLL_CLOEXEC);
    bus->wake = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    bus->rouse = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    bus->inotify = inotify_init1(IN_CLOEXEC | IN_NONBLOCK);
    struct epoll_event event = {.events = EPOLLIN, .data = {.u64 = (uint64_t)WAKE_TAG}};
    if (bus->epoll < 0 || bus->wake < 0 || bus->rouse < 0 ||
        epoll_ctl(bus->epoll, EPOLL_CTL_ADD, bus->wake, &event) != 0) {
        int number = errno;
        destroy(bus);
        return ap_fail(err, AP_ENVIRONMENT, "devices: %s", strerror(number));
    }
    // Without it (a limit of the user's) plugging is seen at the next look, within a second.
    char dev[LIVE_ROOT_MAX + 8];
    snprintf(dev, sizeof dev, "%s/dev", bus->root);
    if (bus->inotify >= 0)
        inotify_add_watch(bus->inotify, dev, IN_CREATE | IN_DELETE | IN_ATTRIB);
    *out = (struct ap_live_bus){&io, bus};
    return AP_OK;
}
