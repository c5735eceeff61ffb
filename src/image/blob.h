#ifndef ANTIPODE_IMAGE_BLOB_H
#define ANTIPODE_IMAGE_BLOB_H

#include "src/image/image.h"

// Where a disc of one even colour is in a picture, to a few thousandths of a pixel, whatever stands
// behind it: its outline's shape is known, its place and size are what is looked for.
struct ap_blob_query {
    uint8_t color[3];           // as written in the scene
    const double (*outline)[2]; // its shape, a closed polygon (i, j) in pixels
    size_t count;               // at least 3
    double reach_px;            // how far from that place the disc is looked for
};
struct ap_blob {
    double shift_i, shift_j; // how far the disc is from the outline, pixels
    double grow_px;          // how much larger: what all of its rim lies farther out
    double sigma_px;         // standard error of the shift by what stands behind and the bytes
    double side_px;          // how far a part of the rim lies off that place, beyond its own error
    double strange_px;       // pixels' worth of the disc that something may hide
    bool touches_edge;       // of the picture or of what was searched
};
// The rim's pixels are unmixed in linear light; what stands behind them is foretold from the pixels
// round them. Measured on 1,840 discs of 2.2 to 25 px before pictures of the billiards rooms:
// docs/vergence.md. A disc that something hides in part shows it in grow_px, sigma_px, side_px or
// strange_px. Pure; needs 32 bytes a pixel of the box searched.
// False: no pixel of that colour within reach, or no memory.
bool ap_find_blob(const struct ap_image *image, const struct ap_blob_query *query,
                  struct ap_blob *blob);

#endif
