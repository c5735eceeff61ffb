#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <libusb-1.0/libusb.h>
#include <limits.h>
#include <poll.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include "src/base/clock.h"
#include "src/device/live/place.h"
#include "src/device/live/queue.h"
#include "src/device/live/usb_known.h"

// HID interfaces of USB devices that the kernel gives no hidraw node: sensors that its sensor hub
// keeps to itself (before 6.5), kernels without usbhid. Found in sysfs, for libusb's own list stays
// as it was where no udevd runs; opened by their node. Several transfers are always on their way,
// each dated when it is done.

enum { USB_BUS = 3, HID_CLASS = 3, TRANSFERS = 4, RING = 256 };
static const unsigned CONTROL_MS = 1000;
static const int64_t LOOK_NS = 500000000; // nothing tells when a device comes

struct usb_device {
    struct usb_bus *bus;
    int fd, interface, tag;
    libusb_device_handle *handle;
    uint8_t in, out; // endpoints; 0: none
    size_t packet;
    struct libusb_transfer *transfers[TRANSFERS];
    int pending; // transfers on their way
    bool gone, closing;
    struct live_queue queue;
    uint8_t *bytes; // a packet for each transfer
    struct usb_device *next;
};

// The ring and the list are under the lock: libusb's callbacks come from whoever handles events,
// which the keeper does, too, while it asks a device something.
struct usb_bus {
    libusb_context *context;
    pthread_mutex_t lock;
    struct usb_device *devices;
    struct ap_usb_known *known;
    int rouse;
};

// --- what there is

static const char DEVICES[] = "/sys/bus/usb/devices";

static size_t read_attribute(const char *folder, const char *name, char *text, size_t size) {
    char path[PATH_MAX];
    snprintf(path, sizeof path, "%s/%s/%s", DEVICES, folder, name);
    int fd = open(path, O_RDONLY | O_CLOEXEC);
    ssize_t n = fd < 0 ? 0 : read(fd, text, size - 1);
    if (fd >= 0)
        close(fd);
    size_t len = n > 0 ? (size_t)n : 0;
    while (len > 0 && text[len - 1] == '\n')
        len--;
    text[len] = '\0';
    return len;
}

static long read_number(const char *folder, const char *name, int base) {
    char text[32];
    return read_attribute(folder, name, text, sizeof text) ? strtol(text, NULL, base) : -1;
}

// The HID device that the kernel has made of the interface: whether there is one, its descriptor,
// and whether it has a hidraw node.
static bool look_for_hid(const char *interface, struct ap_live_place *place) {
    char path[PATH_MAX];
    bool has_node = false;
    snprintf(path, sizeof path, "%s/%s", DEVICES, interface);
    DIR *dir = opendir(path);
    for (struct dirent *e; dir && (e = readdir(dir));) {
        if (strncmp(e->d_name, "0003:", 5) != 0)
            continue;
        char name[512];
        snprintf(name, sizeof name, "%s/%s/%s/hidraw", DEVICES, interface, e->d_name);
        has_node |= access(name, F_OK) == 0;
        snprintf(name, sizeof name, "%s/%s/%s/report_descriptor", DEVICES, interface, e->d_name);
        FILE *f = fopen(name, "rbe");
        if (f) {
            place->descriptor_len = fread(place->descriptor, 1, sizeof place->descriptor, f);
            fclose(f);
        }
    }
    if (dir)
        closedir(dir);
    return has_node;
}

static void node_path(const char *device, char *path, size_t size) {
    snprintf(path, size, "/dev/bus/usb/%03ld/%03ld", read_number(device, "busnum", 10),
             read_number(device, "devnum", 10));
}

// What no driver of ours knows by its ids is asked for its descriptor, if the kernel leaves it
// alone.
static bool is_wanted(struct usb_bus *bus, const char *interface, const char *node, bool has_node,
                      struct ap_live_place *place) {
    char driver[PATH_MAX];
    snprintf(driver, sizeof driver, "%s/%s/driver", DEVICES, interface);
    const struct ap_usb_place asked = {.folder = interface,
                                       .node = node,
                                       .interface = place->interface_number,
                                       .is_taken = access(driver, F_OK) == 0,
                                       .has_node = has_node};
    if (!ap_usb_is_settled(bus->known, &asked))
        return false;
    if (place->descriptor_len || live_is_wanted(place))
        return live_is_wanted(place);
    place->descriptor_len =
        ap_usb_descriptor(bus->known, &asked, place->descriptor, sizeof place->descriptor);
    return place->descriptor_len && live_is_wanted(place);
}

// `interface` is a folder's name: DEVICE:CONFIGURATION.INTERFACE.
static bool read_place(struct usb_bus *bus, const char *interface, struct ap_live_place *place) {
    char device[64], node[64];
    memset(place, 0, sizeof *place);
    if (read_number(interface, "bInterfaceClass", 16) != HID_CLASS || strlen(interface) > 60)
        return false;
    memcpy(device, interface, strcspn(interface, ":"));
    device[strcspn(interface, ":")] = '\0';
    place->bus = USB_BUS;
    place->vendor = (uint16_t)read_number(device, "idVendor", 16);
    place->product = (uint16_t)read_number(device, "idProduct", 16);
    place->interface_number = (int)read_number(interface, "bInterfaceNumber", 16);
    node_path(device, node, sizeof node);
    bool has_node = look_for_hid(interface, place);
    if (!is_wanted(bus, interface, node, has_node, place))
        return false;
    snprintf(place->path, sizeof place->path, "usb:%s:%d", device, place->interface_number);
    snprintf(place->port, sizeof place->port, "%s", interface);
    read_attribute(device, "serial", place->serial, sizeof place->serial);
    read_attribute(device, "product", place->name, sizeof place->name);
    place->denied = access(node, R_OK | W_OK) != 0;
    return true;
}

static int list(void *arg, struct ap_live_place *places, int max) {
    struct usb_bus *bus = arg;
    int count = 0;
    ap_usb_known_look(bus->known, ap_clock_now_ns());
    DIR *dir = opendir(DEVICES);
    for (struct dirent *e; dir && count < max && (e = readdir(dir));)
        if (strchr(e->d_name, ':') && read_place(bus, e->d_name, &places[count]))
            count++;
    if (dir)
        closedir(dir);
    return count;
}

// --- reports

static void LIBUSB_CALL on_report(struct libusb_transfer *transfer) {
    struct usb_device *d = transfer->user_data;
    int64_t now_ns = ap_clock_now_ns();
    pthread_mutex_lock(&d->bus->lock);
    if (transfer->status == LIBUSB_TRANSFER_COMPLETED && transfer->actual_length > 0) {
        live_queue_push(&d->queue, now_ns, transfer->buffer, (size_t)transfer->actual_length);
    }
    bool again = transfer->status == LIBUSB_TRANSFER_COMPLETED ||
                 transfer->status == LIBUSB_TRANSFER_ERROR ||
                 transfer->status == LIBUSB_TRANSFER_STALL;
    if (d->closing || !again || libusb_submit_transfer(transfer) != 0) {
        d->gone = true;
        d->pending--;
    }
    pthread_mutex_unlock(&d->bus->lock);
}

static enum ap_live_read read_report(void *bus, void *device, uint8_t *bytes, size_t size,
                                     size_t *len, int64_t *t_ns) {
    struct usb_device *d = device;
    (void)bus;
    enum ap_live_read got = AP_LIVE_READ_NOTHING;
    pthread_mutex_lock(&d->bus->lock);
    if (live_queue_pop(&d->queue, bytes, size, len, t_ns))
        got = AP_LIVE_READ_REPORT;
    else if (d->gone)
        got = AP_LIVE_READ_GONE;
    pthread_mutex_unlock(&d->bus->lock);
    return got;
}

static int collect(struct usb_bus *bus, int *tags, int max) {
    int count = 0;
    pthread_mutex_lock(&bus->lock);
    for (struct usb_device *d = bus->devices; d && count < max; d = d->next)
        if (!live_queue_is_empty(&d->queue) || (d->gone && !d->closing))
            tags[count++] = d->tag;
    pthread_mutex_unlock(&bus->lock);
    return count;
}

static int wait_reports(void *arg, int *tags, int max, int64_t timeout_ns) {
    struct usb_bus *bus = arg;
    int count = collect(bus, tags, max);
    struct timeval time = {.tv_sec = (time_t)(timeout_ns / 1000000000),
                           .tv_usec = (suseconds_t)(timeout_ns % 1000000000 / 1000)};
    if (count == 0) {
        libusb_handle_events_timeout_completed(bus->context, &time, NULL);
        count = collect(bus, tags, max);
    }
    return count;
}

static void wake(void *bus) {
    libusb_interrupt_event_handler(((struct usb_bus *)bus)->context);
}

// --- a device

static void find_endpoints(struct usb_device *d) {
    struct libusb_config_descriptor *config = NULL;
    if (libusb_get_active_config_descriptor(libusb_get_device(d->handle), &config) != 0)
        return;
    for (int i = 0; i < config->bNumInterfaces; i++) {
        if (config->interface[i].num_altsetting < 1)
            continue;
        const struct libusb_interface_descriptor *a = &config->interface[i].altsetting[0];
        for (int e = 0; a->bInterfaceNumber == d->interface && e < a->bNumEndpoints; e++) {
            const struct libusb_endpoint_descriptor *end = &a->endpoint[e];
            if ((end->bmAttributes & 3) != LIBUSB_TRANSFER_TYPE_INTERRUPT)
                continue;
            if (end->bEndpointAddress & LIBUSB_ENDPOINT_IN) {
                d->in = end->bEndpointAddress;
                d->packet = end->wMaxPacketSize & 0x7ffu;
            } else {
                d->out = end->bEndpointAddress;
            }
        }
    }
    libusb_free_config_descriptor(config);
}

static bool submit(struct usb_device *d) {
    d->bytes = d->packet ? calloc(TRANSFERS, d->packet) : NULL;
    if (!d->bytes || !live_queue_init(&d->queue, RING, d->packet))
        return false;
    for (int i = 0; i < TRANSFERS; i++) {
        struct libusb_transfer *t = d->transfers[i] = libusb_alloc_transfer(0);
        if (!t)
            return false;
        libusb_fill_interrupt_transfer(t, d->handle, d->in, d->bytes + (size_t)i * d->packet,
                                       (int)d->packet, on_report, d, 0);
        pthread_mutex_lock(&d->bus->lock);
        bool sent = libusb_submit_transfer(t) == 0;
        d->pending += sent;
        pthread_mutex_unlock(&d->bus->lock);
        if (!sent)
            return false;
    }
    return true;
}

static void unlink_device(struct usb_device *d) {
    pthread_mutex_lock(&d->bus->lock);
    d->closing = true;
    for (struct usb_device **at = &d->bus->devices; *at; at = &(*at)->next)
        if (*at == d) {
            *at = d->next;
            break;
        }
    pthread_mutex_unlock(&d->bus->lock);
}

static int pending_of(struct usb_device *d) {
    pthread_mutex_lock(&d->bus->lock);
    int pending = d->pending;
    pthread_mutex_unlock(&d->bus->lock);
    return pending;
}

static void close_device(void *bus, void *arg) {
    struct usb_device *d = arg;
    (void)bus;
    unlink_device(d);
    for (int i = 0; i < TRANSFERS; i++)
        if (d->transfers[i])
            libusb_cancel_transfer(d->transfers[i]);
    while (pending_of(d) > 0) {
        struct timeval time = {.tv_usec = 10000};
        libusb_handle_events_timeout_completed(d->bus->context, &time, NULL);
    }
    for (int i = 0; i < TRANSFERS; i++)
        libusb_free_transfer(d->transfers[i]);
    if (d->handle) {
        libusb_release_interface(d->handle, d->interface);
        libusb_close(d->handle);
    }
    if (d->fd >= 0)
        close(d->fd);
    live_queue_finish(&d->queue);
    free(d->bytes);
    free(d);
}

static int claim(struct usb_device *d) {
    int r = libusb_wrap_sys_device(d->bus->context, (intptr_t)d->fd, &d->handle);
    if (r)
        return r;
    libusb_set_auto_detach_kernel_driver(d->handle, 1);
    r = libusb_claim_interface(d->handle, d->interface);
    if (r)
        return r;
    find_endpoints(d);
    return d->in && submit(d) ? 0 : LIBUSB_ERROR_IO;
}

static enum ap_status open_device(struct ap_error *err, void *arg,
                                  const struct ap_live_place *place, int tag, void **out) {
    struct usb_bus *bus = arg;
    char folder[64], node[64];
    const char *name = place->path + strlen("usb:");
    size_t n = strcspn(name, ":");
    if (n >= sizeof folder)
        return ap_fail(err, AP_ENVIRONMENT, "%s: is no USB device", place->path);
    memcpy(folder, name, n);
    folder[n] = '\0';
    node_path(folder, node, sizeof node);
    struct usb_device *d = calloc(1, sizeof *d);
    if (!d)
        return ap_fail(err, AP_ENVIRONMENT, "%s: out of memory", place->path);
    *d = (struct usb_device){.bus = bus, .interface = place->interface_number, .tag = tag};
    d->fd = open(node, O_RDWR | O_CLOEXEC);
    int r = 0;
    if (d->fd < 0)
        ap_fail(err, AP_ENVIRONMENT, "%s (%s): cannot be opened: %s", place->path, node,
                strerror(errno));
    else if ((r = claim(d)) != 0)
        ap_fail(err, AP_ENVIRONMENT, "%s (%s): cannot be opened: %s", place->path, node,
                libusb_strerror(r));
    if (d->fd < 0 || r) {
        close_device(bus, d);
        return AP_ENVIRONMENT;
    }
    pthread_mutex_lock(&bus->lock);
    d->next = bus->devices;
    bus->devices = d;
    pthread_mutex_unlock(&bus->lock);
    *out = d;
    return AP_OK;
}

// HID 1.11, section 7.2: GET_REPORT and SET_REPORT. Without numbers the leading 0 is not sent.
enum { GET_REPORT = 1, SET_REPORT = 9, TO_INTERFACE = 0x21, FROM_INTERFACE = 0xa1 };
enum { OUTPUT = 2, FEATURE = 3 };

static int get_feature(void *bus, void *device, uint8_t *bytes, size_t len) {
    struct usb_device *d = device;
    (void)bus;
    size_t skip = bytes[0] == 0;
    int r = libusb_control_transfer(d->handle, FROM_INTERFACE, GET_REPORT,
                                    (uint16_t)(FEATURE << 8 | bytes[0]), (uint16_t)d->interface,
                                    bytes + skip, (uint16_t)(len - skip), CONTROL_MS);
    return r < 0 ? r : r + (int)skip;
}

static int descriptor(void *bus, void *device, uint8_t *bytes, size_t size) {
    struct usb_device *d = device;
    (void)bus;
    return libusb_control_transfer(d->handle, LIBUSB_ENDPOINT_IN | LIBUSB_RECIPIENT_INTERFACE,
                                   LIBUSB_REQUEST_GET_DESCRIPTOR, LIBUSB_DT_REPORT << 8,
                                   (uint16_t)d->interface, bytes, (uint16_t)size, CONTROL_MS);
}

static int set_report(struct usb_device *d, int kind, const uint8_t *bytes, size_t len) {
    size_t skip = bytes[0] == 0;
    return libusb_control_transfer(d->handle, TO_INTERFACE, SET_REPORT,
                                   (uint16_t)(kind << 8 | bytes[0]), (uint16_t)d->interface,
                                   (uint8_t *)(uintptr_t)(bytes + skip), (uint16_t)(len - skip),
                                   CONTROL_MS);
}

static int set_feature(void *bus, void *device, const uint8_t *bytes, size_t len) {
    (void)bus;
    return set_report(device, FEATURE, bytes, len);
}

static int output(void *bus, void *device, const uint8_t *bytes, size_t len) {
    struct usb_device *d = device;
    (void)bus;
    size_t skip = bytes[0] == 0;
    int sent = 0;
    if (!d->out)
        return set_report(d, OUTPUT, bytes, len);
    return libusb_interrupt_transfer(d->handle, d->out, (uint8_t *)(uintptr_t)(bytes + skip),
                                     (int)(len - skip), &sent, CONTROL_MS);
}

// --- the bus

static void watch(void *arg, int64_t timeout_ns) {
    struct usb_bus *bus = arg;
    struct pollfd fd = {.fd = bus->rouse, .events = POLLIN};
    int64_t ns = timeout_ns < LOOK_NS ? timeout_ns : LOOK_NS;
    uint64_t count;
    if (poll(&fd, 1, (int)((ns + 999999) / 1000000)) > 0 &&
        read(bus->rouse, &count, sizeof count) < 0)
        return;
}

static void rouse(void *bus) {
    const uint64_t one = 1;
    ssize_t n = write(((struct usb_bus *)bus)->rouse, &one, sizeof one);
    (void)n;
}

static int64_t now_ns(void *bus) {
    (void)bus;
    return ap_clock_now_ns();
}

static void destroy(void *arg) {
    struct usb_bus *bus = arg;
    if (bus->context)
        libusb_exit(bus->context);
    if (bus->rouse >= 0)
        close(bus->rouse);
    ap_usb_known_destroy(bus->known);
    pthread_mutex_destroy(&bus->lock);
    free(bus);
}

static const struct ap_live_io io = {
    .name = "libusb",
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

enum ap_status ap_live_usb(struct ap_error *err, struct ap_live_bus *out) {
    struct usb_bus *bus = calloc(1, sizeof *bus);
    if (!bus)
        return ap_fail(err, AP_ENVIRONMENT, "devices: out of memory");
    pthread_mutex_init(&bus->lock, NULL);
    bus->rouse = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    libusb_set_option(NULL, LIBUSB_OPTION_NO_DEVICE_DISCOVERY);
    bus->known = ap_usb_known_create();
    int r = bus->rouse < 0 || !bus->known ? LIBUSB_ERROR_NO_MEM : libusb_init(&bus->context);
    if (r) {
        destroy(bus);
        return ap_fail(err, AP_ENVIRONMENT, "devices: libusb: %s", libusb_strerror(r));
    }
    *out = (struct ap_live_bus){&io, bus};
    return AP_OK;
}
