#ifndef ANTIPODE_IMAGE_LENS_H
#define ANTIPODE_IMAGE_LENS_H

#include "src/image/image.h"

// What a display shows so that a person sees a plain perspective picture through a lens. Tangents
// are x/−z and y/−z from the lens's axis; the picture spans them evenly from left to right and from
// up to down, and so does the display.
struct ap_lens_view {
    double left, right, up, down;
    double k1, k2;   // the display's p is seen at p·(1 + k1·r² + k2·r⁴)·scale, r = |p|
    double scale[3]; // red, green, blue
};

// Writes width·height R,G,B,A bytes: each channel sampled where it is seen, bilinearly, in linear
// light, black outside the picture, alpha 255. Pure; any thread.
void ap_pixels_through_lens(const struct ap_pixels *pixels, const struct ap_lens_view *view,
                            uint8_t *rgba);

#endif
