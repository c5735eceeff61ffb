#include "src/device/live/usb_known.h"

#include <fcntl.h>
#include <linux/usbdevice_fs.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include "src/device/hid/descriptor.h"

enum { KEPT = 64, ANSWER_MS = 200 };
static const int64_t SETTLED_NS = 400000000;
// From an interface; the standard request, and a HID report descriptor.
enum { FROM_INTERFACE = 0x81, GET_DESCRIPTOR = 6, REPORT_DESCRIPTOR = 0x22 };

struct known {
    char key[128]; // folder and node: a device that is plugged in again has another node
    bool was_there, was_asked;
    int64_t since_ns;
    size_t len;
    uint8_t bytes[AP_HID_DESCRIPTOR_MAX];
};

struct ap_usb_known {
    int next; // the oldest goes first
    int looks;
    int64_t now_ns;
    struct known kept[KEPT];
};

struct ap_usb_known *ap_usb_known_create(void) {
    return calloc(1, sizeof(struct ap_usb_known));
}

void ap_usb_known_destroy(struct ap_usb_known *known) {
    free(known);
}

void ap_usb_known_look(struct ap_usb_known *known, int64_t now_ns) {
    known->looks++;
    known->now_ns = now_ns;
}

static struct known *find(struct ap_usb_known *k, const struct ap_usb_place *place) {
    char key[sizeof k->kept[0].key];
    snprintf(key, sizeof key, "%s %s", place->node, place->folder);
    for (int i = 0; i < KEPT; i++)
        if (strcmp(k->kept[i].key, key) == 0)
            return &k->kept[i];
    struct known *one = &k->kept[k->next];
    k->next = (k->next + 1) % KEPT;
    memcpy(one->key, key, sizeof key);
    one->was_there = k->looks <= 1;
    one->was_asked = false;
    one->since_ns = k->now_ns;
    one->len = 0;
    return one;
}

bool ap_usb_is_settled(struct ap_usb_known *known, const struct ap_usb_place *place) {
    struct known *one = find(known, place);
    if (place->has_node) {
        one->was_there = false;
        one->since_ns = known->now_ns;
        return false;
    }
    return one->was_there || known->now_ns - one->since_ns >= SETTLED_NS;
}

// The length, or −1 where the node may not be opened (yet: udev's rules come later).
static int ask(const char *node, int interface, uint8_t *bytes, uint16_t size) {
    struct usbdevfs_ctrltransfer transfer = {.bRequestType = FROM_INTERFACE,
                                             .bRequest = GET_DESCRIPTOR,
                                             .wValue = REPORT_DESCRIPTOR << 8,
                                             .wIndex = (uint16_t)interface,
                                             .wLength = size,
                                             .timeout = ANSWER_MS,
                                             .data = bytes};
    int fd = open(node, O_RDWR | O_CLOEXEC);
    if (fd < 0)
        return -1;
    int n = ioctl(fd, USBDEVFS_CONTROL, &transfer);
    close(fd);
    return n < 0 ? 0 : n;
}

size_t ap_usb_descriptor(struct ap_usb_known *known, const struct ap_usb_place *place,
                         uint8_t *bytes, size_t size) {
    struct known *one = find(known, place);
    if (!one->was_asked && !place->is_taken) {
        int n = ask(place->node, place->interface, one->bytes, sizeof one->bytes);
        one->was_asked = n >= 0;
        one->len = n > 0 ? (size_t)n : 0;
    }
    size_t len = one->len < size ? one->len : size;
    memcpy(bytes, one->bytes, len);
    return len;
}
