#ifndef ANTIPODE_TRACK_WALKER_H
#define ANTIPODE_TRACK_WALKER_H

#include "src/geom/deep.h"
#include "src/track/anchored.h"

// Private to src/track: an anchor whose pose is kept in 256 bits as well, where that was asked for
// and as long as it stays within 11 rho of the base point, which it does who goes from cell to
// cell. Some 20 µs a step.
struct ap_walker {
    struct ap_anchored anchored; // its pose is the deep one, rounded
    bool is_deep;
    struct ap_deep_iso deep;
};

void ap_walker_init(struct ap_walker *walker, bool deep, struct ap_space space,
                    struct ap_vec3 room_origin, struct ap_pose room_from_anchor);
void ap_walker_move(struct ap_walker *walker, struct ap_pose room_from_anchor);
void ap_walker_carry(struct ap_walker *walker, struct ap_pose room_from_grip,
                     struct ap_pose motion);

// deep: the same isometry, or NULL: from now on double-double will do.
void ap_walker_rebase(struct ap_walker *walker, const struct ap_iso *high, const struct ap_iso *low,
                      const struct ap_deep_iso *deep);

#endif
