#ifndef ANTIPODE_TESTS_DEVICE_LIVE_FAKE_HIDAPI_H
#define ANTIPODE_TESTS_DEVICE_LIVE_FAKE_HIDAPI_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <wchar.h>

// hidapi without devices: the library's functions, which the linker takes instead of its own. As
// its hidraw backend it fails at once when a device goes, whatever its queue still holds, and a
// read without a time limit gives what is left. Two calls about one device at a time end the test.

enum { FAKE_HID_DEVICES = 4, FAKE_HID_QUEUE = 64 };

struct fake_hid {
    const char *path; // NULL: no such device
    unsigned short vendor, product, usage_page, usage;
    wchar_t *serial, *name;
    int collections;           // how often it is enumerated
    const uint8_t *descriptor; // NULL: cannot be had
    size_t descriptor_len;
    // What the test sees.
    int opened, closed, sent_count;
    uint8_t sent[8][64]; // what was sent last, outputs and features
};

extern struct fake_hid fake_hid[FAKE_HID_DEVICES];

void fake_hid_reset(void);
void fake_hid_plug(int device, bool plugged);
void fake_hid_report(int device, const uint8_t *bytes, size_t len);
// Reads find nothing, as if the thread was elsewhere.
void fake_hid_hold(bool held);
int fake_hid_users(void); // hid_init less hid_exit

#endif
