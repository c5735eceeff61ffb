#ifndef ANTIPODE_TRACK_ANCHORED_H
#define ANTIPODE_TRACK_ANCHORED_H

#include "src/geom/isometry.h"

// An isometry in double-double: the sum of two matrices, hi the nearest doubles. A virtual pose is
// the product of thousands of increments, and in h3 an error made far out comes back multiplied by
// e^(2·distance/rho), which double alone does not carry. Nobody but src/track computes with lo.
struct ap_wide_iso {
    struct ap_iso hi, lo;
};

// Body coherence in general (Weeks 2021, section 3.2). The caller chooses an anchor: any frame it
// computes from head, hands and objects, as a pose in the room. The anchor's motion from one frame
// to the next, taken in its own local frame, is re-read as a motion of the curved space and moves
// the virtual anchor; every device then stands to the virtual anchor as it stands to the physical
// one. Whatever is placed relative to one anchor stays coherent with everything else that is.
//
// A frame of a program: compute the anchor's pose, ap_anchored_move, then ap_anchored_place for
// each device. Let the head weigh most in the anchor: hands that move the view are unpleasant.
//
// Plain data, no memory to release; one thread at a time. Poses are metres in the room, quaternions
// of any length but 0. Measured error of an entry m against exact arithmetic, over 1e6 samples and
// out to 14 rho and back: below 2e-16·max(1, |m33|).
struct ap_anchored {
    struct ap_space space;
    struct ap_pose room_from_anchor;      // where it was last
    struct ap_wide_iso world_from_anchor; // .hi is the virtual anchor
};

// The anchor's first pose: the virtual anchor is translate(p)·rotate(q), p measured from the room
// point `room_origin`, which corresponds to the virtual base point.
void ap_anchored_init(struct ap_anchored *anchored, struct ap_space space,
                      struct ap_vec3 room_origin, struct ap_pose room_from_anchor);

// The anchor's next pose: V ← V·translate(dp)·rotate(dq), (dp, dq) in its previous local frame.
void ap_anchored_move(struct ap_anchored *anchored, struct ap_pose room_from_anchor);

// world_from_device = V·translate(dp)·rotate(dq), (dp, dq) the device in the anchor's frame.
// Entries that are not finite: farther out in h3 than a double can tell (about 700 rho).
struct ap_iso ap_anchored_place(const struct ap_anchored *anchored,
                                struct ap_pose room_from_device);

// Going where the room does not reach (flying, turning in jumps, teleporting): nothing moves in the
// room, and everything moves in the world as if a device at `room_from_grip` had been moved by
// `motion` in its own frame. V ← V·g·m·g⁻¹ with g the grip in the anchor's frame, each of them
// translate(p)·rotate(q). Coherent: what stands to the anchor as it did, still does. To fly, grip
// the head and translate; to turn about oneself, grip the point of the head with the room's axes
// and rotate about +y; to go to the far end of a geodesic pointed out by a hand, grip the hand and
// translate along its −z.
void ap_anchored_carry(struct ap_anchored *anchored, struct ap_pose room_from_grip,
                       struct ap_pose motion);

// The world's coordinates change: V ← m·V, m = high + low an isometry. A walker of a tiling keeps
// to the frame of the cell that she is in by this.
void ap_anchored_rebase(struct ap_anchored *anchored, const struct ap_iso *high,
                        const struct ap_iso *low);

#endif
