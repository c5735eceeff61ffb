#ifndef ANTIPODE_TESTS_VIEW_RANDOM_H
#define ANTIPODE_TESTS_VIEW_RANDOM_H

#include <math.h>
#include <stdint.h>

#include "src/view/view.h"

// The same numbers in every run.
struct dice {
    uint64_t state;
};

static inline double roll(struct dice *dice, double lo, double hi) {
    dice->state ^= dice->state << 13;
    dice->state ^= dice->state >> 7;
    dice->state ^= dice->state << 17;
    return lo + (hi - lo) * (double)(dice->state >> 11) * 0x1p-53;
}

static inline struct ap_vec3 roll_direction(struct dice *dice) {
    for (;;) {
        struct ap_vec3 v = {roll(dice, -1, 1), roll(dice, -1, 1), roll(dice, -1, 1)};
        double n = ap_vec3_length(v);
        if (n > 0.01 && n <= 1)
            return ap_vec3_scale(1 / n, v);
    }
}

static inline struct ap_quat roll_turn(struct dice *dice, double most_rad) {
    struct ap_vec3 axis = roll_direction(dice);
    return ap_quat_from_axis_angle(axis, roll(dice, -most_rad, most_rad));
}

// Eyes of an ordinary headset, somewhat canted; the nose at the world's base point.
static inline struct ap_viewer roll_viewer(struct dice *dice, int kappa, enum ap_view_mode mode) {
    struct ap_viewer v = {.space = {kappa, roll(dice, 0.3, 3)}, .mode = mode};
    v.world_from_nose = AP_ISO_IDENTITY;
    double ipd = roll(dice, 0.05, 0.08);
    for (int e = 0; e < 2; e++) {
        v.eye[e].view_from_eye.p =
            (struct ap_vec3){e ? ipd / 2 : -ipd / 2, roll(dice, -0.01, 0.01), 0};
        v.eye[e].view_from_eye.q = roll_turn(dice, 0.2);
        v.eye[e].frustum = (struct ap_frustum){roll(dice, -1.4, -0.5), roll(dice, 0.5, 1.4),
                                               roll(dice, 0.5, 1.3), roll(dice, -1.3, -0.5)};
    }
    if (mode == AP_VIEW_BORN)
        v.born = (struct ap_space){(int)floor(roll(dice, -1, 1.999)), roll(dice, 0.3, 3)};
    return v;
}

#endif
