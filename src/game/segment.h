#ifndef ANTIPODE_GAME_SEGMENT_H
#define ANTIPODE_GAME_SEGMENT_H

#include "src/game/physics.h"

// Private to src/game: a ball between two events. Its frame obeys F' = F·xi(t), xi the plane's
// transvection with the foot's velocity V(t) = v + a·t, which friction makes linear in the parallel
// frame. Where v and a are parallel that is a geodesic and a closed form; else a power series with
// the recursion (k + 1)·F[k+1] = F[k]·xi0 + F[k-1]·xi1, entire, cut where what is left is below
// 1e-17 of the frame.

// Decides what the ball does from t_s on, from its frame, velocity and turn, which are those at
// t_s. A slide that would need more than AP_SERIES_MAX terms ends early and is begun anew there.
void ap_segment_begin(const struct ap_physics *physics, struct ap_ball *ball, double t_s);

// Foot and velocity at t_s, world coordinates.
void ap_segment_at(const struct ap_physics *physics, const struct ap_ball *ball, double t_s,
                   struct ap_plane3 *foot_m, struct ap_plane3 *velocity_m_s);

// Brings frame, velocity, turn and orientation to t_s.
void ap_segment_commit(const struct ap_physics *physics, struct ap_ball *ball, double t_s);

// Whether a slide ends at t_end_s because slip does, not because its series does.
bool ap_segment_slip_ends(const struct ap_physics *physics, const struct ap_ball *ball);

// turn × up: the velocity over R of a ball that rolls with that turn; and back.
static inline struct ap_plane2 ap_rolling_of(struct ap_vec3 turn) {
    return (struct ap_plane2){-turn.z, turn.x};
}

static inline void ap_rolling_set(struct ap_vec3 *turn, struct ap_plane2 rolling) {
    turn->z = -rolling.x;
    turn->x = rolling.z;
}

// Velocity of the body at the point of contact.
static inline struct ap_plane2 ap_slip_of(const struct ap_physics *physics,
                                          const struct ap_ball *ball) {
    return ap_plane2_add(ball->velocity_m_s, -physics->rolling_radius_m,
                         ap_rolling_of(ball->turn_rad_s));
}

static inline bool ap_ball_moves(const struct ap_ball *ball) {
    return ball->state == AP_BALL_SLIDING || ball->state == AP_BALL_ROLLING;
}

#endif
