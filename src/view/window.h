#ifndef ANTIPODE_VIEW_WINDOW_H
#define ANTIPODE_VIEW_WINDOW_H

#include "src/view/view.h"

// Looking through windows in opaque walls: what an eye may still see beyond them.

// A part of an eye's picture, in tangents (x/−z, y/−z) of the eye's axes.
struct ap_gaze {
    double low[2], high[2];
};

struct ap_gaze ap_gaze_all(const struct ap_frustum *frustum);

// Grows `gaze` to hold `more` as well; true where it did.
bool ap_gaze_add(struct ap_gaze *gaze, const struct ap_gaze *more);

// What of `gaze` is left beyond a convex window with these corners: directions in the eye's axes,
// of any length, from the nose (native; the eye sees each of its points within the angle whose sine
// is `leaning` of that) or from the eye itself (tourist). False: nothing. Conservative: a box about the window,
// and all of `gaze` where a corner is not before the eye.
bool ap_gaze_through(const struct ap_gaze *gaze, const struct ap_vec3 *corners, int count,
                     double leaning, struct ap_gaze *beyond);

#endif
