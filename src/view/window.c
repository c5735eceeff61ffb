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
                     double leaning, struct ap_gaze *beyond) {
    double low[2] = {INFINITY, INFINITY}, high[2] = {-INFINITY, -INFINITY};
    *beyond = *gaze;
    for (int k = 0; k < count; k++) {
        const struct ap_vec3 *c = &corners[k];
        double square = ap_vec3_dot(*c, *c), ahead = -c->z;
        double sine = leaning * sqrt(square);
        if (!(ahead > 0) || !(ahead * ahead > 0.0004 * square))
            return true;
        for (int axis = 0; axis < 2; axis++) {
            // A plane through the eye and its other axis, at the angle A, has all directions within
            // asin(leaning) of the window on one side if sin(A − angle)·across >= leaning·r at each
            // corner: such directions are a convex cone. Its tangent, by that of a difference:
            double x = axis ? c->y : c->x, turned = x * x + ahead * ahead - sine * sine;
            double cosine = sqrt(fmax(turned, 0));
            double below = ahead * cosine + x * sine, above = ahead * cosine - x * sine;
            low[axis] = below > 0 && turned > 0
                            ? fmin(low[axis], (x * cosine - ahead * sine) / below)
                            : -INFINITY;
            high[axis] = above > 0 && turned > 0
                             ? fmax(high[axis], (x * cosine + ahead * sine) / above)
                             : INFINITY;
        }
    }
    for (int axis = 0; axis < 2; axis++) {
        beyond->low[axis] = fmax(gaze->low[axis], low[axis]);
        beyond->high[axis] = fmin(gaze->high[axis], high[axis]);
        if (!(beyond->low[axis] < beyond->high[axis]))
            return false;
    }
    return true;
}
