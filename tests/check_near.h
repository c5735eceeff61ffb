#ifndef ANTIPODE_TESTS_CHECK_NEAR_H
#define ANTIPODE_TESTS_CHECK_NEAR_H

// cmocka wants these first: this stands before everything else in a test.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>

// Each check prints both values and the tolerance where it fails. NaN fails.
#define check_near(got, expected, tolerance)                                                       \
    check_near_at(__FILE__, __LINE__, #got, got, expected, tolerance)

static inline void check_near_at(const char *file, int line, const char *what, double got,
                                 double expected, double tolerance) {
    if (fabs(got - expected) <= tolerance)
        return;
    print_error("%s:%d: %s is %.17g, expected %.17g within %.3g (off by %.3g)\n", file, line, what,
                got, expected, tolerance, got - expected);
    _fail(file, line);
}

#endif
