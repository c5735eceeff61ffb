#ifndef ANTIPODE_DEVICE_UNIT_QUAT_H
#define ANTIPODE_DEVICE_UNIT_QUAT_H

#include <stdbool.h>

#include "src/geom/vec.h"

// Quaternions from outside: 0.9 < |q| < 1.1 is renormalised, anything else (NaN too) refused and
// left. What is unit up to rounding stays as it is, so that writing and reading change no bit.
static inline bool ap_quat_make_unit(struct ap_quat *q) {
    double square = q->x * q->x + q->y * q->y + q->z * q->z + q->w * q->w;
    double length = sqrt(square);
    if (!(length > 0.9 && length < 1.1))
        return false;
    if (fabs(square - 1) > 1e-15) {
        q->x /= length;
        q->y /= length;
        q->z /= length;
        q->w /= length;
    }
    return true;
}

#endif
