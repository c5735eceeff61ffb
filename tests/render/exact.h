#ifndef ANTIPODE_TESTS_RENDER_EXACT_H
#define ANTIPODE_TESTS_RENDER_EXACT_H

#include <stdint.h>

#include "src/view/view.h"

// What the tests of the bound on errors share: places at random, and where points are seen,
// exactly.

struct exact_random {
    uint64_t seed;
};
double exact_uniform(struct exact_random *random, double low, double high);

// Two eyes that are not quite where they should be, at the base point; a radius of 0.5 to 3 m.
struct ap_viewer exact_viewer(struct exact_random *random, int kappa, enum ap_view_mode mode);

// Pixels of an eye's picture; false where it does not show there.
bool exact_project(const struct ap_viewer *viewer, const uint32_t size_px[2], int eye,
                   struct ap_vec3 tangent_m, double px[2]);

// The point of the plane y = 0 of the part in the direction u (unit) from the nose, that about
// d_flat_m away. False: there is none.
bool exact_on_plane(struct ap_space space, const struct ap_iso *part_from_nose, struct ap_vec3 u,
                    double d_flat_m, struct ap_vec3 *at_m);

#endif
