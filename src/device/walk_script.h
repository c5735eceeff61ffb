#ifndef ANTIPODE_DEVICE_WALK_SCRIPT_H
#define ANTIPODE_DEVICE_WALK_SCRIPT_H

// What the scripted person does when: walks on, stops, bends over the edge and aims, looks about,
// steps back. One round of it ends as it began, a lap of the table farther, so it can be repeated.

// The state of the body at a time; every number is twice continuously differentiable in it.
struct ap_walk_state {
    double u;       // place along the path (walk_path.h)
    double pace;    // 0 at rest … 1 walking, for what comes with steps
    double facing;  // 0: toward where the path goes, 1: toward the table
    double bend;    // 0 upright … 1 bent over the edge, hands on the cue
    double stroke;  // the cue hand's way forward, −1…1
    double touch;   // 1: the left hand is on the table's edge
    double trigger; // 0…1
    int select;     // 1 during the hit

    // The head's attention, weights that sum to 1.
    double on_table, on_way, on_shot;
    double glance_yaw_rad, glance_pitch_rad; // added to it
};

double ap_walk_script_duration_s(double edge_m);
struct ap_walk_state ap_walk_script_at(double edge_m, double t_s);

// 0 before t = from, 1 after from + ramp, smooth between (the quintic of minimum jerk).
double ap_walk_ramp(double t, double from, double ramp);

#endif
