#include "src/view/window.h"

#include <math.h>

struct ap_gaze ap_gaze_all(const struct ap_frustum *f) {
    // Mirrored frusta have left and right exchanged.
    return (struct ap_gaze){{fmin(f->left, f->right), fmin(f->down, f->up)},
                            {fmax(f->left, f->right), fmax(f->down, f->up)}};
}

bool ap_gaze_add(struct ap_gaze *gaze, const struct ap_gaze *more) {
    bool grew = false;
    for (int axis = 0; axis < 2; axis++) {
        grew = grew || more->low[axis] < gaze->low[axis] || more->high[axis] > gaze->high[axis];
        gaze->low[axis] = fmin(gaze->low[axis], more->low[axis]);
        gaze->high[axis] = fmax(gaze->high[axis], more->high[axis]);
    }
    return grew;
}

bool ap_gaze_through(const struct ap_gaze *gaze, const struct ap_vec3 *corners, int count,
                     double lean_rad, struct ap_gaze *beyond) {
    const double widest = 1.5, leaning = sin(fmin(lean_rad, 1.5));
    double low[2] = {widest, widest}, high[2] = {-widest, -widest};
    *beyond = *gaze;
    for (int k = 0; k < count; k++) {
        double r = ap_vec3_length(corners[k]), ahead = -corners[k].z;
        if (!(ahead > 0.02 * r))
            return true;
        for (int axis = 0; axis < 2; axis++) {
            // A plane through the eye and its other axis, at the angle A, has all directions within
            // `leaning` of the window on one side if sin(A − angle)·across >= leaning·r at each
            // corner: such directions are a convex cone.
            double x = axis ? corners[k].y : corners[k].x, across = hypot(x, ahead);
            double angle = atan2(x, ahead), more = asin(fmin(leaning * r / across, 1));
            low[axis] = fmin(low[axis], angle - more);
            high[axis] = fmax(high[axis], angle + more);
        }
    }
    for (int axis = 0; axis < 2; axis++) {
        if (low[axis] > -widest)
            beyond->low[axis] = fmax(gaze->low[axis], tan(low[axis]));
        if (high[axis] < widest)
            beyond->high[axis] = fmin(gaze->high[axis], tan(high[axis]));
        if (!(beyond->low[axis] < beyond->high[axis]))
            return false;
    }
    return true;
}
