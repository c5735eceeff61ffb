#ifndef ANTIPODE_DEVICE_LIVE_USB_DESCRIPTOR_H
#define ANTIPODE_DEVICE_LIVE_USB_DESCRIPTOR_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

// Report descriptors of HID interfaces that no kernel driver has, asked for once for each time a
// device is plugged in. One thread at a time.

struct ap_usb_descriptors;

// NULL without memory.
struct ap_usb_descriptors *ap_usb_descriptors_create(void);
void ap_usb_descriptors_destroy(struct ap_usb_descriptors *descriptors);

struct ap_usb_place {
    const char *folder; // of the interface, under /sys/bus/usb/devices
    const char *node;   // of the device
    int interface;
    bool is_taken; // a driver has it (or we have): only what is known already is given
};

// The descriptor of an interface into bytes; its length, 0 where it may not be asked or the device
// does not answer within 0.2 s. HID 1.11, section 7.1.1.
size_t ap_usb_descriptor(struct ap_usb_descriptors *descriptors, const struct ap_usb_place *place,
                         uint8_t *bytes, size_t size);

#endif
