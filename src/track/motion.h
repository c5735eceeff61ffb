#ifndef ANTIPODE_TRACK_MOTION_H
#define ANTIPODE_TRACK_MOTION_H

#include <stdbool.h>

#include "src/geom/pose.h"
#include "src/geom/space.h"
#include "src/geom/dd.h"
#include "src/track/anchored.h"

// Private to src/track: physical motions re-read as motions of the curved space, in double-double.
// Quaternions need not be unit: the rotation is that of q/|q|, exactly.

struct ap_motion {
    struct ap_dd p_m[3];
    struct ap_dd r[3][3];
};

// The motion from one room pose to another, in the first one's local frame.
struct ap_motion ap_motion_between(struct ap_pose room_from_a, struct ap_pose room_from_b);

// The pose itself, its position measured from `origin`.
struct ap_motion ap_motion_from(struct ap_vec3 origin, struct ap_pose room_from_device);

struct ap_wide_iso ap_wide_identity(void);

// m·translate(v).
void ap_wide_translate(struct ap_space space, const struct ap_dd v_m[3], struct ap_wide_iso *m);

// m·r.
void ap_wide_turn(const struct ap_dd r[3][3], struct ap_wide_iso *m);

// m·translate(p)·rotate(r).
void ap_wide_move(struct ap_space space, const struct ap_motion *motion, struct ap_wide_iso *m);

// m·(translate(p)·rotate(r))⁻¹.
void ap_wide_unmove(struct ap_space space, const struct ap_motion *motion, struct ap_wide_iso *m);

// One step of Newton's iteration back onto the group: m·(3 − m⁻¹·m)/2, with G·mᵀ·G for the inverse.
// s3 and h3, m33 below 1e6: changes a correct matrix by 1e-32·m33² of itself.
void ap_wide_renew(struct ap_space space, struct ap_wide_iso *m);

// False where an entry overflowed: too far out in h3, or a motion that is not finite.
bool ap_iso_is_finite(const struct ap_iso *m);

#endif
