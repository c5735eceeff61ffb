#ifndef ANTIPODE_TRACK_CHAPERONE_H
#define ANTIPODE_TRACK_CHAPERONE_H

#include <stddef.h>

#include "src/geom/vec.h"

// The end of the tracked room, shown before somebody walks into it: a fence along the rectangle of
// OpenXR's stage bounds (xrGetReferenceSpaceBoundsRect), centred in STAGE, +y up, metres. The
// curved world knows nothing of the room, so its walls must be drawn; each line is short enough to
// be placed by ap_tracker_place at its two ends and drawn as a geodesic. Pure.
struct ap_chaperone {
    double width_m, depth_m; // along x and z; one of them not > 0: the room has no bounds
    double warn_m;           // the fence begins to show so far from it; 0: 0.5
};

enum { AP_CHAPERONE_MAX_LINES = 512 };

struct ap_chaperone_line {
    struct ap_vec3 a, b;
    double strength; // 0…1: how plainly to draw it
};

// How near the nearest of the points (head and hands, STAGE) is to the bounds: 0 farther than
// warn_m inside, 1 on them or outside. A point that is not finite counts as not there.
double ap_chaperone_alarm(const struct ap_chaperone *chaperone, const struct ap_vec3 *points,
                          size_t count);

// The fence near the points: squares of 0.25 m from the floor to 2 m, within 0.75 m of each point's
// foot on a wall it is nearer to than warn_m. Returns the number of lines, at most
// AP_CHAPERONE_MAX_LINES; the same line is never given twice.
size_t ap_chaperone_fence(const struct ap_chaperone *chaperone, const struct ap_vec3 *points,
                          size_t count, struct ap_chaperone_line lines[AP_CHAPERONE_MAX_LINES]);

#endif
