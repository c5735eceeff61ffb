#ifndef ANTIPODE_DEVICE_HEADSETS_LENS_H
#define ANTIPODE_DEVICE_HEADSETS_LENS_H

#include <jansson.h>

#include "src/base/json.h"
#include "src/base/status.h"

// What a headset's lens does to its display, about the eye's −z axis: what the display shows at the
// tangents p is seen at p·(1 + k1·r² + k2·r⁴)·scale, r = |p|, scale 1 for green. docs/
// headset-profile.md. red_scale 0: no lens is described.
struct ap_lens {
    double k1, k2, red_scale, blue_scale;
};

// "at" is the lens's object. AP_INPUT also where the lens would fold the picture over within
// max_radius, in tangents.
enum ap_status ap_lens_parse(struct ap_error *err, const struct ap_json_at *at, double max_radius,
                             struct ap_lens *lens);

// NULL without memory.
json_t *ap_lens_to_json(const struct ap_lens *lens);

// By how much tangents of the display are multiplied, channel 0 red, 1 green, 2 blue; r2 = r².
static inline double ap_lens_factor(const struct ap_lens *lens, int channel, double r2) {
    double scale = channel == 0 ? lens->red_scale : channel == 2 ? lens->blue_scale : 1;
    return scale * (1 + r2 * (lens->k1 + r2 * lens->k2));
}

#endif
