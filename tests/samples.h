#ifndef ANTIPODE_TESTS_SAMPLES_H
#define ANTIPODE_TESTS_SAMPLES_H

#include <stdlib.h>

// How many of n random examples a test of numbers takes: all of them, and a quarter under a
// sanitizer (tests/meson.build says so). There the memory is looked at, which a quarter shows as
// well; the numbers are proved by the builds without.
static inline int test_samples(int n) {
    return getenv("ANTIPODE_SANITIZE") ? (n + 3) / 4 : n;
}

#endif
