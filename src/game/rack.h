#ifndef ANTIPODE_GAME_RACK_H
#define ANTIPODE_GAME_RACK_H

#include "src/game/rules.h"

// Balls set for a game: the rack's apex toward +z, its middle 0.28 inradii beyond the centre, the
// cue ball on the head spot 0.6 inradii before it. The lattice is flat in the tangent plane and
// spread until the closest two balls are 1.002 of a touch apart, as nothing else fits where the
// space is curved. AP_INPUT: it does not fit; the sentence says which ball and why.
enum ap_status ap_rack_set(struct ap_error *err, struct ap_physics *physics,
                           enum ap_game_kind kind);

// A place for a ball as near as may be to the wanted one (the spot, then rings about it). False
// where the table is full.
bool ap_rack_free_place(const struct ap_physics *physics, int ball, struct ap_plane2 wanted_m,
                        struct ap_plane2 *place_m);

struct ap_plane2 ap_rack_head_spot(const struct ap_physics *physics);
struct ap_plane2 ap_rack_foot_spot(const struct ap_physics *physics);

// At the break the cue ball stands behind the line through the head spot, a twentieth of an
// inradius of grace: z at least this.
double ap_rack_head_line(const struct ap_physics *physics);

#endif
