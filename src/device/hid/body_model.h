#ifndef ANTIPODE_DEVICE_HID_BODY_MODEL_H
#define ANTIPODE_DEVICE_HID_BODY_MODEL_H

#include <stddef.h>

#include "src/geom/pose.h"

// Where a tracker that only knows how it is turned stands on somebody's body. The body stands at
// the room's origin and looks along −z; docs/devices.md has the figures.

enum ap_body_part { AP_BODY_HEAD, AP_BODY_LEFT_HAND, AP_BODY_RIGHT_HAND, AP_BODY_OTHER };

// "head", "left", "right"; anything else is AP_BODY_OTHER.
enum ap_body_part ap_body_part_of(const char *role, size_t len);

// The head turns about the neck, a hand about the elbow; what is neither stands 1 m high.
struct ap_vec3 ap_body_place(enum ap_body_part part, struct ap_quat q);

#endif
