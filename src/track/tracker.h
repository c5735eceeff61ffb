#ifndef ANTIPODE_TRACK_TRACKER_H
#define ANTIPODE_TRACK_TRACKER_H

#include <stdbool.h>
#include <stdint.h>

#include "src/base/status.h"
#include "src/geom/isometry.h"
#include "src/geom/table.h"

// Body coherence: poses in the room become poses in the curved world (Weeks 2021, section 3). The
// only place where the two meet. Three kinds: `naive` shows the incoherence, `anchor` hangs the
// hands on the head, `billiards` hangs head and hands on the table's edge.
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
    double table_edge_m; // billiards: the edge of both tables; in s3 and h3 it must fit the radius
};

struct ap_tracker;

// One thread at a time. AP_USAGE where the parameters contradict each other.
enum ap_status ap_tracker_create(struct ap_error *err, const struct ap_tracker_params *params,
                                 struct ap_tracker **tracker);
void ap_tracker_destroy(struct ap_tracker *tracker);

// Takes the next pose of a device ("head" is the head, every other name a hand), in the table's
// frame, and gives its virtual pose. False: no row (a hand before the first head sample, in anchor
// and billiards); it is counted. AP_INPUT where the virtual pose is not finite (farther out in h3
// than a double can tell, about 700 rho; a pose that is not finite), the tracker then stays as it
// was. AP_ENVIRONMENT only without memory (a new device name). Measured error of an entry against
// exact arithmetic: below 2e-16·max(1, |m33|), also after 1e6 samples. The quaternion need not be
// unit.
enum ap_status ap_tracker_feed(struct ap_error *err, struct ap_tracker *tracker, const char *device,
                               struct ap_pose table_from_device, bool *has_row,
                               struct ap_iso *world_from_device);

// Hand samples that gave no row.
int64_t ap_tracker_dropped(const struct ap_tracker *tracker);

#endif
