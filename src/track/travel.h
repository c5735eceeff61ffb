#ifndef ANTIPODE_TRACK_TRAVEL_H
#define ANTIPODE_TRACK_TRAVEL_H

#include <stdbool.h>
#include <stdint.h>

#include "src/geom/pose.h"

// How a visitor goes where her room does not reach: she flies, turns in jumps, or points along a
// geodesic and is at its far end after a short darkness. A state machine from buttons and sticks to
// motions for ap_tracker_carry, and to what her eyes should be spared (darkness, a vignette). Pure:
// time comes with the input. Plain data, no memory; one thread at a time.

struct ap_travel_params {
    double speed_mps;   // flying with the stick all the way; 0: 1
    double turn_rad;    // of a turn; 0: 30°
    double fade_s;      // to darkness, and the same back; 0: 0.12
    double reach_m;     // how far a teleport points at first; 0: 1
    double reach_max_m; // and at most; 0: 20
    bool no_vignette;   // flying does not narrow the view
    bool turn_smoothly; // by turn_rad a second with the stick, instead of in jumps
};

// What the hands ask for at time t. Sticks from −1 to 1 (what is outside, or not finite, is taken
// as the nearest of these, or 0); a dead zone of 0.2 is taken off here.
struct ap_travel_input {
    int64_t t_ns;
    double right, forward, up; // flying, in the axes of the head
    double turn;               // to the right
    bool point;                // held: aim a teleport; let go: go
    bool cancel;               // while pointing: stay
    struct ap_pose room_from_head, room_from_aim;
};

// What to do in this frame: at most one motion.
struct ap_travel_output {
    bool carry; // call ap_tracker_carry(room_from_grip, motion)
    struct ap_pose room_from_grip, motion;
    bool pointing; // draw the geodesic from the aim pose along its −z, so long
    double reach_m;
    double fade;     // 0: the world, 1: darkness
    double vignette; // 0: none, 1: the narrowest
};

enum ap_travel_phase { AP_TRAVEL_STAY, AP_TRAVEL_POINT, AP_TRAVEL_DARKEN, AP_TRAVEL_LIGHTEN };

struct ap_travel {
    struct ap_travel_params params; // no zeroes left
    enum ap_travel_phase phase;
    bool started, held; // held: the teleport's button was down
    bool turned;        // the stick has not come back since
    int64_t t_ns, phase_t_ns;
    double reach_m, vignette;
    struct ap_pose room_from_aim; // when the button was let go
};

void ap_travel_init(struct ap_travel *travel, const struct ap_travel_params *params); // NULL: 0s

// The next frame. The first call only starts the clock. Time that stands still or runs back counts
// as no time; a gap of more than 0.1 s counts as 0.1 s, so that nobody is thrown across a world by
// a frame that came late.
struct ap_travel_output ap_travel_step(struct ap_travel *travel,
                                       const struct ap_travel_input *input);

#endif
