#ifndef ANTIPODE_TRACK_WIDE_H
#define ANTIPODE_TRACK_WIDE_H

#include "src/geom/isometry.h"

// An isometry in double-double: the sum of two matrices, hi the nearest doubles. A virtual pose is
// the product of thousands of increments, and in h3 an error made far out comes back multiplied by
// e^(2·distance/rho), which double alone does not carry. Nobody but src/track computes with the
// halves.
struct ap_wide_iso {
    struct ap_iso hi, lo;
};

#endif
