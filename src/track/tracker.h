#ifndef ANTIPODE_TRACK_TRACKER_H
#define ANTIPODE_TRACK_TRACKER_H

#include <stdbool.h>
#include <stdint.h>

#include "src/base/status.h"
#include "src/geom/deep.h"
#include "src/geom/isometry.h"
#include "src/geom/table.h"

// Body coherence: poses in the room become poses in the curved world (Weeks 2021, section 3). The
// only place where the two meet. Three kinds: `naive` shows the incoherence, `anchor` hangs
// everything on one device (the head, unless another is chosen), `billiards` hangs head and hands
// on the table's edge.
enum ap_tracker_kind { AP_TRACKER_NAIVE, AP_TRACKER_ANCHOR, AP_TRACKER_BILLIARDS };

enum ap_status ap_tracker_kind_from_name(struct ap_error *err, const char *name,
                                         enum ap_tracker_kind *kind);
const char *ap_tracker_kind_name(enum ap_tracker_kind kind);

struct ap_tracker_params {
    enum ap_tracker_kind kind;
    struct ap_space space;
    // The room point that corresponds to the virtual base point is (0, table_height_m, 0); 0 where
    // there is no table.
    double table_height_m;
    // Where the table stands in the room whose poses are fed, and how it is turned; all 0: poses
    // are in the table's frame already.
    double table_x_m, table_z_m, table_yaw_rad;
    double table_edge_m; // billiards: the edge of both tables; in s3 and h3 it must fit the radius
    // anchor: the device that moves freely and that everything else hangs on; "" is "head"; "hands"
    // is the middle of "left" and "right", facing half way between them, once both have been seen.
    char anchor[64];
    // anchor, in h3: keep the anchor's pose in 256 bits, for a walker whom ap_tracker_rebase takes
    // from cell to cell. Ends where she is more than 11 rho from the base point.
    bool deep;
};

struct ap_tracker;

// One thread at a time. AP_USAGE where the parameters contradict each other.
enum ap_status ap_tracker_create(struct ap_error *err, const struct ap_tracker_params *params,
                                 struct ap_tracker **tracker);
void ap_tracker_destroy(struct ap_tracker *tracker);

// Takes the next pose of a device ("head" is the head, every other name a hand), in the room that
// the parameters say where the table is in, and gives its virtual pose. False: no row (a hand
// before the first head sample in billiards, a device before the anchor's first in anchor); it is
// counted. AP_INPUT where the virtual pose is not finite (farther out in h3 than a double can tell,
// about 700 rho; a pose that is not finite), the tracker then stays as it was. AP_ENVIRONMENT only
// without memory (a new device name). Measured error of an entry against exact arithmetic: below
// 2e-16·max(1, |m33|), also after 1e6 samples. The quaternion need not be unit.
enum ap_status ap_tracker_feed(struct ap_error *err, struct ap_tracker *tracker, const char *device,
                               struct ap_pose room_from_device, bool *has_row,
                               struct ap_iso *world_from_device);

// Samples that gave no row.
int64_t ap_tracker_dropped(const struct ap_tracker *tracker);

// Whether others are placed by where this device is. A frame loop feeds such a device before the
// others, so that all are placed by where it is now.
bool ap_tracker_leads(const struct ap_tracker *tracker, const char *device);

// Where something that rests in the room is now (a wall, a mark on the floor): as a hand would be
// there, but nothing is remembered of it. In naive by the head's own integration. False before
// there is anything to place it by, or where the place is not finite.
bool ap_tracker_place(const struct ap_tracker *tracker, struct ap_pose room_from_thing,
                      struct ap_iso *world_from_thing);

// Takes the visitor where the room does not reach: ap_anchored_carry of the anchor. AP_USAGE in
// billiards and naive (the table holds her, or nothing does) and before the anchor's first sample;
// AP_INPUT where the place would not be finite. The tracker then stays as it was.
enum ap_status ap_tracker_carry(struct ap_error *err, struct ap_tracker *tracker,
                                struct ap_pose room_from_grip, struct ap_pose motion);

// The world's coordinates change (ap_anchored_rebase) for everything that moves in it. deep: the
// same isometry in 256 bits, or NULL; a deep anchor ends where it is NULL. AP_USAGE in billiards:
// the table stands where it stands.
enum ap_status ap_tracker_rebase(struct ap_error *err, struct ap_tracker *tracker,
                                 const struct ap_iso *high, const struct ap_iso *low,
                                 const struct ap_deep_iso *deep);

#endif
