#ifndef ANTIPODE_IMAGE_BLOB_WINDOW_H
#define ANTIPODE_IMAGE_BLOB_WINDOW_H

#include "src/image/blob.h"
#include "src/image/cover.h"
#include "src/image/srgb.h"

// What blob.c hands to blob_fit.c. Private to this folder.

// The searched box and a margin round it, cut to the picture.
struct ap_blob_window {
    const struct ap_image *image;
    struct ap_srgb srgb;
    int x0, y0, width, height;      // the window
    int min_x, max_x, min_y, max_y; // the box in window pixels, inclusive
    uint8_t color[3];               // the core's bytes
    uint8_t *kind;                  // width·height
    int *stack;                     // width·height
};

static inline const uint8_t *ap_blob_pixel(const struct ap_blob_window *w, int x, int y) {
    return w->image->rgb + ((size_t)(w->y0 + y) * w->image->width + (size_t)(w->x0 + x)) * 3;
}

// Fits the outline's place, from about where it is, to the pixels of its rim. Fills all of *blob
// but touches_edge, which it only sets. w->kind is overwritten. False: no memory, or nothing to go
// by.
bool ap_blob_fit(struct ap_blob_window *w, const struct ap_outline *outline,
                 struct ap_outline_place start, struct ap_blob *blob);

#endif
