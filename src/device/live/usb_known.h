#ifndef ANTIPODE_DEVICE_LIVE_USB_KNOWN_H
#define ANTIPODE_DEVICE_LIVE_USB_KNOWN_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

// What is remembered of HID interfaces of USB devices, for each time they are plugged in: since
// when they have been there, and the report descriptor of those that no kernel driver has. One
// thread at a time.

struct ap_usb_known;

// NULL without memory.
struct ap_usb_known *ap_usb_known_create(void);
void ap_usb_known_destroy(struct ap_usb_known *known);

struct ap_usb_place {
    const char *folder; // of the interface, under /sys/bus/usb/devices
    const char *node;   // of the device
    int interface;
    bool is_taken; // a driver has it (or we have): only what is known already is given
    bool has_node; // the kernel gives it to everybody by hidraw
};

// A new look at now_ns begins. What is there at the first one has been there.
void ap_usb_known_look(struct ap_usb_known *known, int64_t now_ns);

// False for 0.4 s from the look on that found it, and from the last one that found it with a node:
// the kernel's own driver may be on its way, and two must not fight for an interface; or it is
// being unplugged, and what is left of it for a moment is no other device.
bool ap_usb_is_settled(struct ap_usb_known *known, const struct ap_usb_place *place);

// The descriptor of an interface into bytes; its length, 0 where it may not be asked or the device
// does not answer within 0.2 s. HID 1.11, section 7.1.1.
size_t ap_usb_descriptor(struct ap_usb_known *known, const struct ap_usb_place *place,
                         uint8_t *bytes, size_t size);

#endif
