#ifndef ANTIPODE_DEVICE_LIVE_IO_H
#define ANTIPODE_DEVICE_LIVE_IO_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "src/base/status.h"
#include "src/device/hid/driver.h"

// How live devices are reached: a table of functions for each way there is (the kernel's hidraw,
// libusb), and for the tests' twin, which plays recordings and fails where it is told to. live.c
// knows no other way to a device, nor another clock.

enum {
    AP_LIVE_PATH_MAX = 256,
    AP_LIVE_NAME_MAX = 128,
    AP_LIVE_SERIAL_MAX = 64,
};

// A place where a device may be opened.
struct ap_live_place {
    char path[AP_LIVE_PATH_MAX];     // "/dev/hidraw3", "usb:1-2.1:3"
    char port[AP_LIVE_PATH_MAX];     // where it is plugged in; tells equal devices without serials
    char serial[AP_LIVE_SERIAL_MAX]; // "": none
    char name[AP_LIVE_NAME_MAX];
    uint16_t bus, vendor, product; // bus as in linux/input.h: 3 USB, 5 Bluetooth, 6 virtual
    int interface_number;          // of a USB device; −1: unknown
    bool denied;                   // we may not open it
    size_t descriptor_len;
    uint8_t descriptor[AP_HID_DESCRIPTOR_MAX];
};

enum ap_live_read { AP_LIVE_READ_REPORT, AP_LIVE_READ_NOTHING, AP_LIVE_READ_GONE };

struct ap_live_io {
    const char *name; // "hidraw"

    // Everything there is, at most `max`; the number. Blocks for as long as a look into sysfs does.
    int (*list)(void *bus, struct ap_live_place *places, int max);

    // Reports from now on. `tag` is what wait gives back for it. AP_ENVIRONMENT with a sentence.
    enum ap_status (*open)(struct ap_error *err, void *bus, const struct ap_live_place *place,
                           int tag, void **device);
    void (*close)(void *bus, void *device);

    // The keeper's thread only, may block for as long as the device lets them. The id's byte first
    // in `bytes` (0 where reports are not numbered). The number of bytes, the id's included;
    // negative: refused.
    int (*get_feature)(void *bus, void *device, uint8_t *bytes, size_t len);
    int (*set_feature)(void *bus, void *device, const uint8_t *bytes, size_t len);
    int (*output)(void *bus, void *device, const uint8_t *bytes, size_t len);

    // The report descriptor of an open device whose place had none; NULL: places always have one.
    int (*descriptor)(void *bus, void *device, uint8_t *bytes, size_t size);

    // The reader's thread only. wait blocks until an opened device has something (its tag) or is
    // gone, `wake` has been called, or the time is over; the number of tags. read never blocks;
    // *t_ns is when the report came where the way knows better than "now".
    int (*wait)(void *bus, int *tags, int max, int64_t timeout_ns);
    void (*wake)(void *bus);
    enum ap_live_read (*read)(void *bus, void *device, uint8_t *bytes, size_t size, size_t *len,
                              int64_t *t_ns);
    // What may stand in a queue that lost reports because it was full; 0: queues lose the old ones.
    int queue_len;

    // The keeper's thread only: blocks until devices may have come or gone, `rouse` has been
    // called (any thread), or the time is over.
    void (*watch)(void *bus, int64_t timeout_ns);
    void (*rouse)(void *bus);

    int64_t (*now_ns)(void *bus); // monotonic; any thread
    void (*destroy)(void *bus);   // nothing is open any more
};

struct ap_live_bus {
    const struct ap_live_io *io;
    void *bus;
};

// /dev/hidraw*: places from /sys/class/hidraw, plugging from inotify on /dev. `root` stands before
// both ("" for the machine's own); tests give a folder. AP_ENVIRONMENT.
enum ap_status ap_live_hidraw(struct ap_error *err, const char *root, struct ap_live_bus *bus);

// A path that somebody gave: links are followed; one that is not there yet stays. AP_INPUT for what
// is there and is no hidraw node.
enum ap_status ap_live_hidraw_resolve(struct ap_error *err, char path[AP_LIVE_PATH_MAX]);

// Raw HID recordings that are played, each from its first report on, as if their devices were
// plugged in and, at the end, unplugged. AP_INPUT for what cannot be read.
enum ap_status ap_live_replay(struct ap_error *err, const char *const *files, size_t count,
                              struct ap_live_bus *bus);

// USB devices that a driver knows and that no hidraw node stands for, by libusb.
enum ap_status ap_live_usb(struct ap_error *err, struct ap_live_bus *bus);

// Whatever hidapi knows (its hidraw backend: the nodes of ap_live_hidraw). A thread for each
// device. Only in programs that are built with hidapi. AP_ENVIRONMENT.
enum ap_status ap_live_hidapi(struct ap_error *err, struct ap_live_bus *bus);

#endif
