#ifndef ANTIPODE_GAME_QUEUE_H
#define ANTIPODE_GAME_QUEUE_H

#include "src/game/physics.h"

// Private to src/game: what may happen next. For each pair, ball and cushion, ball and pocket the
// queue holds a time before which it provably does not happen; only the least of them is made
// better, by one step of a Newton method that is kept on the safe side of the root by a bound of
// the second derivative: f(t + x) ≥ f + f'·x − ½·M·x².

void ap_queue_clear(struct ap_physics *physics);

// The balls of the mask have begun anew at t_s.
void ap_queue_renew(struct ap_physics *physics, unsigned balls, double t_s);

#endif
