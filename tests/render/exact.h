#ifndef ANTIPODE_TESTS_RENDER_EXACT_H
#define ANTIPODE_TESTS_RENDER_EXACT_H

#include <stdint.h>

#include "src/view/exact.h"

// What the tests of the bound on errors share: places at random.

struct exact_random {
    uint64_t seed;
};
double exact_uniform(struct exact_random *random, double low, double high);

// Two eyes that are not quite where they should be, at the base point; a radius of 0.5 to 3 m.
struct ap_viewer exact_viewer(struct exact_random *random, int kappa, enum ap_view_mode mode);

#endif
