#ifndef ANTIPODE_TESTS_TRACK_SUPPORT_H
#define ANTIPODE_TESTS_TRACK_SUPPORT_H

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <cmocka.h>

#include "src/track/setup.h"
#include "src/track/tracker.h"
#include "tests/track/exact.h"

// The product's promise is 1e-12; what is measured is a rounding of the exact answer, and a test
// that allowed a thousand times more would not see the reason for it break.
#define TRACK_TOLERANCE 4e-16

static inline double noise(uint64_t *state) {
    *state = *state * 6364136223846793005u + 1442695040888963407u;
    return (double)(int64_t)(*state >> 11) * 0x1p-52 - 1; // [−1, 1)
}

static inline struct ap_tracker_params params_of(const char *space, double radius_m,
                                                 enum ap_tracker_kind kind) {
    struct ap_error err;
    struct ap_tracker_params params;
    const struct ap_track_setup setup = {.space = space,
                                         .radius_m = radius_m,
                                         .tracker = kind,
                                         .table_edge_m = NAN,
                                         .table_height_m = 0.75};
    if (ap_track_setup(&err, &setup, &params))
        fail_msg("%s", err.text);
    return params;
}

static inline struct ap_tracker *tracker_of(const struct ap_tracker_params *params) {
    struct ap_error err;
    struct ap_tracker *tracker;
    if (ap_tracker_create(&err, params, &tracker))
        fail_msg("%s", err.text);
    return tracker;
}

// False: no row.
static inline bool feed(struct ap_tracker *tracker, const char *device, struct ap_pose pose,
                        struct ap_iso *m) {
    struct ap_error err;
    bool has_row;
    if (ap_tracker_feed(&err, tracker, device, pose, &has_row, m))
        fail_msg("%s", err.text);
    return has_row;
}

static inline struct ap_pose pose_at(double x, double y, double z) {
    return (struct ap_pose){{x, y, z}, {0, 0, 0, 1}};
}

static inline double largest_difference(const struct ap_iso *a, const struct ap_iso *b) {
    double worst = 0;
    for (int i = 0; i < 16; i++)
        worst = fmax(worst, fabs(a->m[i / 4][i % 4] - b->m[i / 4][i % 4]));
    return worst;
}

// A tracker and its exact twin, fed alike.
struct pair {
    struct ap_tracker *tracker;
    struct exact *exact;
    double worst, reach; // worst error and largest m33 so far
    struct ap_iso last;
};

static inline struct pair pair_of(const struct ap_tracker_params *params) {
    return (struct pair){tracker_of(params), exact_create(params), 0, 0, {{{0}}}};
}

static inline bool pair_feed(struct pair *pair, const char *device, struct ap_pose pose) {
    bool row = feed(pair->tracker, device, pose, &pair->last);
    if (row != exact_feed(pair->exact, device, pose))
        fail_msg("%s: row %d, expected %d", device, row, !row);
    if (!row)
        return false;
    double error = exact_error(pair->exact, &pair->last);
    pair->worst = error <= pair->worst ? pair->worst : error; // a NaN wins
    pair->reach = fmax(pair->reach, fabs(pair->last.m[3][3]));
    return true;
}

static inline void pair_check(struct pair *pair, const char *what) {
    printf("%-44s worst %.2g (tolerance %.2g), m33 to %.3g\n", what, pair->worst, TRACK_TOLERANCE,
           pair->reach);
    if (!(pair->worst <= TRACK_TOLERANCE))
        fail_msg("%s: error %g, tolerance %g", what, pair->worst, TRACK_TOLERANCE);
}

static inline void pair_finish(struct pair *pair) {
    ap_tracker_destroy(pair->tracker);
    exact_destroy(pair->exact);
}

#endif
