#ifndef ANTIPODE_GAME_CONTACT_H
#define ANTIPODE_GAME_CONTACT_H

#include "src/game/physics.h"

// Private to src/game: what meeting does to velocities and turns. Kinematics are exact (the body's
// motion is a Killing field; what friction acts on is its value at the point of contact), the
// impulses are Newton's restitution and Coulomb's friction. docs/physics.md has the derivation.

// Below this speed of parting nothing parts where there is friction: bounces that would get ever
// shorter end, and what leans on something leaves it now and then.
extern const double ap_least_parting_m_s;

// Balls i and j touch; n_i and n_j are the directions to the other in each one's frame.
struct ap_touch {
    int i, j;
    struct ap_plane2 n_i, n_j;
    double closing_m_s; // of the feet
    double impulse;     // out: change of each one's normal velocity, m/s
};

// The two directions and the closing speed.
void ap_touch_measure(const struct ap_physics *physics, struct ap_touch *touch);

enum { AP_TOUCHES_MAX = 48 };

// All touches of a moment that close, at once: none is first, so a symmetrical break stays
// symmetrical. Rounds follow until none closes; `told` is called for each impulse. All balls
// named must be committed to the moment; they must be begun anew afterwards.
void ap_touches_resolve(struct ap_physics *physics, struct ap_touch *touches, int count,
                        void (*told)(void *data, const struct ap_touch *touch), void *data);

// A ball meets a cushion; n points to it in the ball's frame. Returns the closing speed.
double ap_cushion_resolve(struct ap_physics *physics, struct ap_ball *ball, struct ap_plane2 n);

#endif
