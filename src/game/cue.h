#ifndef ANTIPODE_GAME_CUE_H
#define ANTIPODE_GAME_CUE_H

#include <stdint.h>

#include "src/game/physics.h"

// The cue in two tracked hands: the right one holds it a reach behind the tip, the left one is the
// bridge that it lies in. The tip's way goes from frame to frame; a stroke is the moment in between
// at which it meets the ball, however fast it was. All is computed in the tangent space of the
// ball's centre, where distances from it and directions are exact; from frame to frame the tip goes
// on a straight line there.
//
// Loss of tracking never strikes: the left hand's loss leaves the cue lying in the right hand as it
// lay; the right hand's, a pose that is not finite, a gap of more than 100 ms or a jump faster than
// 20 m/s begins the way anew. Plain data, one thread at a time.

struct ap_cue_params {
    double reach_m;      // from the right grip to the tip's middle; 0: 0.75, as the room's cue is
    double tip_radius_m; // 0: 0.0058
    double least_speed_m_s; // slower touches do nothing; 0: 0.03
};

struct ap_cue_hands {
    bool right_tracked, left_tracked;
    struct ap_iso world_from_right, world_from_left; // virtual poses, as the trackers give them
};

enum { AP_CUE_SAMPLES = 5 };

struct ap_cue {
    struct ap_cue_params params;
    struct ap_vec3 axis; // from the right grip to the tip, in its frame
    struct {
        int64_t t_ns;
        struct ap_vec3 tip_m; // in the ball's tangent space
        struct ap_vec3 axis;
    } sample[AP_CUE_SAMPLES];
    int count;
    bool armed; // the tip has been clear of the ball
};

enum ap_cue_touch { AP_CUE_NOTHING, AP_CUE_HIT, AP_CUE_MISCUE };

struct ap_cue_hit {
    int64_t t_ns;        // between the last frame and this one
    struct ap_vec3 axis; // where the cue goes, in the ball's frame (y up)
    double speed_m_s;    // along the axis, by the last frames
    double right, above; // of the ball's middle, in ball radii, across the axis
};

void ap_cue_init(const struct ap_cue_params *params, struct ap_cue *cue);

// The cue as it lies now, its −z toward the tip, its origin the tip's middle: for drawing. False
// while the right hand is lost.
bool ap_cue_pose(const struct ap_cue *cue, struct ap_space space, const struct ap_cue_hands *hands,
                 struct ap_iso *world_from_tip);

// A frame, times increasing. world_from_ball: the ball's centre, y up; its radius. MISCUE: the tip
// meets the ball too far from its middle (above 0.55 radii); `hit` is told then too.
enum ap_cue_touch ap_cue_feed(struct ap_cue *cue, struct ap_space space, int64_t t_ns,
                              const struct ap_cue_hands *hands,
                              const struct ap_iso *world_from_ball, double ball_radius_m,
                              struct ap_cue_hit *hit);

// The centre of a ball on the table, y up: what ap_cue_feed wants.
struct ap_iso ap_cue_ball(const struct ap_physics *physics, int ball);

// The stroke that the hit is. Its elevation is held to what a stroke may have.
struct ap_strike ap_cue_strike(const struct ap_physics *physics, int ball,
                               const struct ap_cue_hit *hit);

#endif
