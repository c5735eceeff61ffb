#ifndef ANTIPODE_DEVICE_LIVE_PLACE_H
#define ANTIPODE_DEVICE_LIVE_PLACE_H

#include "src/device/live/io.h"

// What several ways to devices ask sysfs and the drivers about a place.

enum { LIVE_ROOT_MAX = 128 };

// What sysfs knows of the hidraw node of that name ("hidraw3"); `root` stands before /sys and /dev.
// False where there is no such node; then *place is not to be looked at.
bool live_hidraw_place(const char *root, const char *node, struct ap_live_place *place);

// Whether the path's device is a hidraw node, by its number's subsystem: nothing is opened that
// might do something.
bool live_is_hidraw_node(const char *path);

// Whether a driver wants what is there, by its ids or its descriptor.
bool live_is_wanted(const struct ap_live_place *place);

#endif
