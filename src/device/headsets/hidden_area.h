#ifndef ANTIPODE_DEVICE_HEADSETS_HIDDEN_AREA_H
#define ANTIPODE_DEVICE_HEADSETS_HIDDEN_AREA_H

#include <stdint.h>

#include "src/device/headset.h"

// What of an eye's picture cannot be seen, as triangles: on the plane z = -1 of the eye's view, in
// tangents (x right, y up), counterclockwise. The ellipse is drawn round by a polygon outside it,
// so that nothing is hidden that can be seen.

enum ap_mask_kind {
    AP_MASK_HIDDEN,  // triangles
    AP_MASK_VISIBLE, // triangles
    AP_MASK_OUTLINE, // a closed line round the visible part
};

enum { AP_MASK_MAX_VERTICES = 160, AP_MASK_MAX_INDICES = 480 };

struct ap_mask {
    uint32_t vertex_count, index_count;
    double vertex[AP_MASK_MAX_VERTICES][2]; // each a float32's value
    uint32_t index[AP_MASK_MAX_INDICES];
};

// Both counts are 0 where the eye sees all.
void ap_hidden_area_mask(const struct ap_eye_profile *eye, enum ap_mask_kind kind,
                         struct ap_mask *mask);

#endif
