#ifndef ANTIPODE_SIM_HMD_SOURCE_WINDOW_H
#define ANTIPODE_SIM_HMD_SOURCE_WINDOW_H

#include "sim_hmd/frame.h"
#include "src/device/poselog.h"

// A person who is moved by the window's keyboard and mouse: the mouse turns the head, WASD walk, Q
// and E sink and rise, and a hand that is held (1, 2) follows the mouse instead of the head.
struct sim_window_player {
    struct ap_vec3 head_m;
    double yaw_rad, pitch_rad;
    struct ap_vec3 hand_m[2]; // in the head's upright frame
    double mouse_x_px, mouse_y_px, wheel;
    uint32_t keys;
};

void sim_window_player_init(struct sim_window_player *player);
void sim_window_player_step(struct sim_window_player *player, const struct sim_window_input *input,
                            double step_s);

// device 0 head, 1 left, 2 right.
struct ap_sample sim_window_player_at(const struct sim_window_player *player, int device);

#endif
