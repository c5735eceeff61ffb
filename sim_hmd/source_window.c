#include "sim_hmd/source_window.h"

static const double WALK_M_PER_S = 1.4, SLOW_FACTOR = 0.25;
static const double TURN_RAD_PER_PX = 0.003, HAND_M_PER_PX = 0.001, REACH_M_PER_NOTCH = 0.02;
static const double MAX_PITCH_RAD = 1.5;

void sim_window_player_init(struct sim_window_player *player) {
    *player = (struct sim_window_player){.head_m = {0, 1.6, 1.0},
                                         .hand_m = {{-0.2, -0.45, -0.35}, {0.2, -0.45, -0.35}}};
}

static double axis(uint32_t keys, uint32_t minus, uint32_t plus) {
    return (double)((keys & plus) != 0) - (double)((keys & minus) != 0);
}

static double clamp(double x, double low, double high) {
    return x < low ? low : x > high ? high : x;
}

static struct ap_quat yaw_of(const struct sim_window_player *player) {
    return ap_quat_from_axis_angle((struct ap_vec3){0, 1, 0}, player->yaw_rad);
}

void sim_window_player_step(struct sim_window_player *player, const struct sim_window_input *input,
                            double step_s) {
    double dx = input->mouse_x_px - player->mouse_x_px;
    double dy = input->mouse_y_px - player->mouse_y_px;
    double notches = input->wheel - player->wheel;
    player->mouse_x_px = input->mouse_x_px;
    player->mouse_y_px = input->mouse_y_px;
    player->wheel = input->wheel;
    player->keys = input->keys;
    bool held = false;
    for (int hand = 0; hand < 2; hand++) {
        if (!(input->keys & (hand ? SIM_KEY_HAND_RIGHT : SIM_KEY_HAND_LEFT)))
            continue;
        held = true;
        struct ap_vec3 *at = &player->hand_m[hand];
        at->x = clamp(at->x + dx * HAND_M_PER_PX, -0.8, 0.8);
        at->y = clamp(at->y - dy * HAND_M_PER_PX, -1.2, 0.8);
        at->z = clamp(at->z - notches * REACH_M_PER_NOTCH, -0.8, 0.3);
    }
    if (!held) {
        player->yaw_rad -= dx * TURN_RAD_PER_PX;
        player->pitch_rad =
            clamp(player->pitch_rad - dy * TURN_RAD_PER_PX, -MAX_PITCH_RAD, MAX_PITCH_RAD);
    }
    double speed = WALK_M_PER_S * (input->keys & SIM_KEY_SLOW ? SLOW_FACTOR : 1);
    struct ap_vec3 go = {axis(input->keys, SIM_KEY_LEFT, SIM_KEY_RIGHT),
                         axis(input->keys, SIM_KEY_DOWN, SIM_KEY_UP),
                         axis(input->keys, SIM_KEY_FORWARD, SIM_KEY_BACK)};
    go = ap_vec3_scale(speed * step_s, ap_vec3_normalize(ap_quat_rotate(yaw_of(player), go)));
    player->head_m = ap_vec3_add(player->head_m, go);
    player->head_m.y = clamp(player->head_m.y, 0.2, 2.5);
}

struct ap_sample sim_window_player_at(const struct sim_window_player *player, int device) {
    struct ap_quat yaw = yaw_of(player);
    struct ap_quat pitch = ap_quat_from_axis_angle((struct ap_vec3){1, 0, 0}, player->pitch_rad);
    struct ap_sample sample = {.device = device, .pose = {player->head_m, ap_quat_mul(yaw, pitch)}};
    if (device == 0)
        return sample;
    sample.pose.p = ap_vec3_add(player->head_m, ap_quat_rotate(yaw, player->hand_m[device - 1]));
    // The right hand holds the buttons unless only the left one is held.
    bool left_only = (player->keys & SIM_KEY_HAND_LEFT) && !(player->keys & SIM_KEY_HAND_RIGHT);
    if ((device == 1) == left_only) {
        sample.trigger = player->keys & SIM_KEY_TRIGGER ? 1 : 0;
        sample.squeeze = player->keys & SIM_KEY_SQUEEZE ? 1 : 0;
        sample.select = (player->keys & SIM_KEY_TRIGGER) != 0;
    }
    return sample;
}
