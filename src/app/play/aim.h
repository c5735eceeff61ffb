#ifndef ANTIPODE_APP_PLAY_AIM_H
#define ANTIPODE_APP_PLAY_AIM_H

#include "src/game/physics.h"

// Aiming without a cue in two hands: while a button is held the cue ball's line leads to where the
// eyes rest on the table; sticks set how fast the cue is and where its tip meets the ball. Pure.

struct ap_play_aim {
    bool active;
    double speed_m_s;    // of the cue, 0.1…8
    double right, above; // of the ball's middle, in radii, at most 0.5 in all
    bool has_target;
    struct ap_plane3 target_m; // on the table's plane
    bool was_trigger, was_place;
};

struct ap_play_aim_input {
    double dt_s;
    bool held, trigger, place;
    double power, tip_x, tip_y; // sticks, −1…1
    const struct ap_iso *world_from_head;
};

enum ap_aim_wish { AP_AIM_NOTHING, AP_AIM_STRIKE, AP_AIM_PLACE };

struct ap_play_aim ap_play_aim_standard(void);

// A frame. A button counts once, and only if it was pressed while aiming.
enum ap_aim_wish ap_play_aim_step(struct ap_play_aim *aim, struct ap_space space,
                                  const struct ap_play_aim_input *input);

// Where the geodesic along −z of a frame comes down to the table's plane; of one that does not
// within 3 rho (s3: a far eighth of a turn for one that rises), what is below it there, so that she
// may look above the horizon, too. False where nothing finite is.
bool ap_play_aim_target(struct ap_space space, const struct ap_iso *world_from_eye,
                        struct ap_plane3 *target_m);

// The stroke that is aimed at from a ball; false: no line leads to the target.
bool ap_play_aim_strike(const struct ap_play_aim *aim, const struct ap_physics *physics, int ball,
                        struct ap_strike *strike);

// The cue of that stroke, drawn back the farther the faster it is to be: −z to its tip, which is
// the origin.
struct ap_iso ap_play_aim_cue(const struct ap_play_aim *aim, const struct ap_physics *physics,
                              int ball, const struct ap_strike *strike, double tip_radius_m);

#endif
