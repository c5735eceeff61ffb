#ifndef ANTIPODE_TESTS_VM_HEADSET_H
#define ANTIPODE_TESTS_VM_HEADSET_H

#include <stdbool.h>
#include <stdint.h>

#define XR_USE_TIMESPEC
#include <time.h>

#include <openxr/openxr.h>
#include <openxr/openxr_platform.h>

// What the virtual machine's OpenXR programs share: a session without graphics (XR_MND_headless)
// through the real loader. They end with a line where a call fails.

struct headset {
    XrInstance instance;
    XrSession session;
    XrSpace view, stage;
    PFN_xrConvertTimespecTimeToTimeKHR to_time;
};

void headset_need(XrResult result, const char *what);

// Instance, session, VIEW and STAGE.
void headset_open(struct headset *h);

// Waits until the session is ready and begins it.
void headset_begin(const struct headset *h);

// CLOCK_MONOTONIC as an XrTime.
XrTime headset_time(const struct headset *h, int64_t t_ns);

// Where the space is in STAGE.
XrSpaceLocation headset_locate(const struct headset *h, XrSpace space, XrTime time);

void headset_close(struct headset *h);

#endif
