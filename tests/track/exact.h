#ifndef ANTIPODE_TESTS_TRACK_EXACT_H
#define ANTIPODE_TESTS_TRACK_EXACT_H

#include <stdbool.h>

#include "src/geom/pose.h"
#include "src/track/tracker.h"

// The three trackers in 448-bit arithmetic, written from the conventions alone: no code, no
// formula rearrangement shared with src/track. One at a time per process (its numbers come from one
// pool).
struct exact;

struct exact *exact_create(const struct ap_tracker_params *params);
void exact_destroy(struct exact *exact);

// False: no row.
bool exact_feed(struct exact *exact, const char *device, struct ap_pose pose);

// Of the last pose: the largest |m − exact| / max(1, |exact m33|); in e3, where m33 is 1 however
// far away a pose is, over its largest entry.
double exact_error(const struct exact *exact, const struct ap_iso *m);

// The unwrapped coordinate of the device fed last (billiards).
double exact_coordinate(const struct exact *exact);

// h3, anchor: the world's frame becomes that of the cell of {5,3,4} across the face whose normal is
// nearest to `out`, a mirror image. Written from the dodecahedron's closed form.
void exact_cross_534(struct exact *exact, struct ap_vec3 out);

// h3: how far from the exact last pose V the isometry m = high + low (NULL: 0) is, seen from V: the
// largest entry of |V⁻¹·m − 1|; where that is small, an offset over rho or an angle.
double exact_miss(const struct exact *exact, const struct ap_iso *high, const struct ap_iso *low);

// h3: of the last pose from the base point, over rho.
double exact_distance(const struct exact *exact);

#endif
