#include "src/device/live/usb_descriptor.h"

#include <fcntl.h>
#include <linux/usbdevice_fs.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include "src/device/hid/descriptor.h"

enum { KEPT = 32, ANSWER_MS = 200 };
// From an interface; the standard request, and a HID report descriptor.
enum { FROM_INTERFACE = 0x81, GET_DESCRIPTOR = 6, REPORT_DESCRIPTOR = 0x22 };

struct ap_usb_descriptors {
    int next; // the oldest goes first
    struct {
        char key[128]; // folder and node: a device that is plugged in again has another node
        size_t len;
        uint8_t bytes[AP_HID_DESCRIPTOR_MAX];
    } kept[KEPT];
};

struct ap_usb_descriptors *ap_usb_descriptors_create(void) {
    return calloc(1, sizeof(struct ap_usb_descriptors));
}

void ap_usb_descriptors_destroy(struct ap_usb_descriptors *descriptors) {
    free(descriptors);
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

size_t ap_usb_descriptor(struct ap_usb_descriptors *d, const struct ap_usb_place *place,
                         uint8_t *bytes, size_t size) {
    char key[sizeof d->kept[0].key];
    int at = 0;
    if ((size_t)snprintf(key, sizeof key, "%s %s", place->folder, place->node) >= sizeof key)
        return 0;
    while (at < KEPT && strcmp(d->kept[at].key, key) != 0)
        at++;
    if (at == KEPT) {
        uint8_t asked[AP_HID_DESCRIPTOR_MAX];
        int n = place->is_taken ? -1 : ask(place->node, place->interface, asked, sizeof asked);
        if (n < 0)
            return 0;
        at = d->next;
        d->next = (d->next + 1) % KEPT;
        memcpy(d->kept[at].key, key, sizeof key);
        d->kept[at].len = (size_t)n;
        memcpy(d->kept[at].bytes, asked, (size_t)n);
    }
    size_t len = d->kept[at].len < size ? d->kept[at].len : size;
    memcpy(bytes, d->kept[at].bytes, len);
    return len;
}
