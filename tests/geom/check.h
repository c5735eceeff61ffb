#ifndef ANTIPODE_TESTS_GEOM_CHECK_H
#define ANTIPODE_TESTS_GEOM_CHECK_H

// Included by every test of the folder, after nothing else.
#include "tests/check_near.h"

#include <stdio.h>
#include <stdlib.h>

#include "src/geom/isometry.h"
#include "src/geom/map.h"
#include "tests/geom/reference.h"

static inline double largest_entry(const struct ap_iso *m) {
    double largest = 0;
    for (int i = 0; i < 16; i++)
        largest = fmax(largest, fabs(m->m[i / 4][i % 4]));
    return largest;
}

// NaN where either has one.
static inline double iso_difference(const struct ap_iso *a, const struct ap_iso *b) {
    double most = 0;
    for (int i = 0; i < 16; i++) {
        double d = fabs(a->m[i / 4][i % 4] - b->m[i / 4][i % 4]);
        most = d > most || isnan(d) ? d : most;
    }
    return most;
}

#define check_iso(got, expected, tolerance)                                                        \
    check_near_at(__FILE__, __LINE__, "largest difference of " #got,                               \
                  iso_difference(got, expected), 0, tolerance)

static inline struct ap_iso mul3(struct ap_iso a, struct ap_iso b, struct ap_iso c) {
    return ap_iso_mul(ap_iso_mul(a, b), c);
}

static inline struct ap_vec4 base_point(struct ap_space space) {
    return (struct ap_vec4){0, 0, 0, space.rho_m};
}

static inline struct ap_quat random_quat(struct ref_random *r) {
    return ap_quat_from_axis_angle(ref_direction(r), ref_uniform(r, -3.1, 3.1));
}

#endif
