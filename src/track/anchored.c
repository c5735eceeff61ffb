#include "src/track/anchored.h"

#include <math.h>

#include "src/track/motion.h"

void ap_anchored_init(struct ap_anchored *anchored, struct ap_space space,
                      struct ap_vec3 room_origin, struct ap_pose room_from_anchor) {
    struct ap_motion first = ap_motion_from(room_origin, room_from_anchor);
    anchored->space = space;
    anchored->room_from_anchor = room_from_anchor;
    anchored->world_from_anchor = ap_wide_identity();
    ap_wide_move(space, &first, &anchored->world_from_anchor);
}

void ap_anchored_move(struct ap_anchored *anchored, struct ap_pose room_from_anchor) {
    struct ap_motion step = ap_motion_between(anchored->room_from_anchor, room_from_anchor);
    ap_wide_move(anchored->space, &step, &anchored->world_from_anchor);
    anchored->room_from_anchor = room_from_anchor;
}

struct ap_iso ap_anchored_place(const struct ap_anchored *anchored,
                                struct ap_pose room_from_device) {
    struct ap_motion offset = ap_motion_between(anchored->room_from_anchor, room_from_device);
    struct ap_wide_iso place = anchored->world_from_anchor;
    ap_wide_move(anchored->space, &offset, &place);
    return place.hi;
}

void ap_anchored_carry(struct ap_anchored *anchored, struct ap_pose room_from_grip,
                       struct ap_pose motion) {
    const struct ap_vec3 zero = {0, 0, 0};
    struct ap_motion grip = ap_motion_between(anchored->room_from_anchor, room_from_grip);
    struct ap_motion way = ap_motion_from(zero, motion);
    ap_wide_move(anchored->space, &grip, &anchored->world_from_anchor);
    ap_wide_move(anchored->space, &way, &anchored->world_from_anchor);
    ap_wide_unmove(anchored->space, &grip, &anchored->world_from_anchor);
}

void ap_anchored_rebase(struct ap_anchored *anchored, const struct ap_iso *high,
                        const struct ap_iso *low) {
    struct ap_wide_iso old = anchored->world_from_anchor;
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++) {
            struct ap_dd sum = ap_dd_of(0);
            for (int k = 0; k < 4; k++) {
                struct ap_dd a = {high->m[i][k], low->m[i][k]};
                struct ap_dd b = {old.hi.m[k][j], old.lo.m[k][j]};
                sum = ap_dd_add(sum, ap_dd_mul(a, b));
            }
            anchored->world_from_anchor.hi.m[i][j] = sum.hi;
            anchored->world_from_anchor.lo.m[i][j] = sum.lo;
        }
    // Off the group, what moves on is wrong by e^(2·distance) as much: a walk from cell to cell
    // would be lost after 36 rho. Far poses are left as they are (docs/accuracy.md).
    if (anchored->space.kappa && fabs(anchored->world_from_anchor.hi.m[3][3]) < 1e6)
        ap_wide_renew(anchored->space, &anchored->world_from_anchor);
}
