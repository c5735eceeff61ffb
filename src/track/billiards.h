#ifndef ANTIPODE_TRACK_BILLIARDS_H
#define ANTIPODE_TRACK_BILLIARDS_H

#include <stdint.h>

#include "src/geom/isometry.h"
#include "src/track/anchored.h"

// Private to src/track: the perimeter of the square table, and poses hung on its edge (Weeks 2021,
// section 3.1).

// The unwrapped perimeter coordinate c = edge + ½ − across/(2·out): the device stands at
// (across, −out) in the frame of its edge, out > 0, −out < across ≤ out. Kept as an integer and the
// two coordinates themselves, which are the input's doubles, so that corners and ties are decided
// exactly, however many laps have been walked.
struct ap_perimeter {
    int64_t edge;
    double across, out;
};

// Where an unwrapped coordinate starts: c = 0.5.
#define AP_PERIMETER_START ((struct ap_perimeter){0, 0, 1})

// The position of (x, z), its edge in 0…3. False straight above the centre.
bool ap_perimeter_of(double x, double z, struct ap_perimeter *at);

// The value congruent to `at` that is nearest to `reference`; an exact tie goes to the larger.
struct ap_perimeter ap_perimeter_unwrap(struct ap_perimeter reference, struct ap_perimeter at);

struct ap_billiards {
    struct ap_space space;
    double edge_m, height_m;
    int sides;
    struct ap_wide_iso world_from_edge[5];
};

// The edge must fit the radius in s3 and h3: the inradius is taken from the number of sides alone.
void ap_billiards_init(struct ap_space space, double edge_m, double height_m,
                       struct ap_billiards *table);

// The virtual pose of a device whose anchor is `c`.
struct ap_iso ap_billiards_place(const struct ap_billiards *table, struct ap_perimeter c,
                                 struct ap_pose table_from_device);

#endif
