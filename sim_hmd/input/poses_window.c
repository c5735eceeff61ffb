#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "sim_hmd/input/poses.h"
#include "sim_hmd/input/profiles.h"
#include "sim_hmd/window/input.h"

// A person who is moved by the window's keyboard and mouse: the mouse turns the head, WASD walk, Q
// and E sink and rise, and a hand that is held (1, 2) follows the mouse instead of the head.
struct player {
    struct ap_vec3 head_m;
    double yaw_rad, pitch_rad;
    struct ap_vec3 hand_m[2]; // in the head's upright frame
    double mouse_x_px, mouse_y_px, wheel;
    uint32_t keys;
    double push_s; // how long the wheel still pushes the right stick, forward or back
};

static const double WALK_M_PER_S = 1.4, SLOW_FACTOR = 0.25;
static const double TURN_RAD_PER_PX = 0.003, HAND_M_PER_PX = 0.001, REACH_M_PER_NOTCH = 0.02;
static const double MAX_PITCH_RAD = 1.5;
static const double PUSH_S_PER_NOTCH = 0.1, LONGEST_PUSH_S = 0.5;

static enum ap_status create(struct ap_error *err, const struct sim_settings *settings,
                             void **state) {
    (void)settings;
    struct player *player = malloc(sizeof *player);
    if (!player)
        return ap_fail(err, AP_ENVIRONMENT, "out of memory");
    // Before the table, looking down at it.
    *player = (struct player){.head_m = {0, 1.6, 1.0},
                              .pitch_rad = -0.6,
                              .hand_m = {{-0.2, -0.45, -0.35}, {0.2, -0.45, -0.35}}};
    *state = player;
    return AP_OK;
}

static double axis(uint32_t keys, uint32_t minus, uint32_t plus) {
    return (double)((keys & plus) != 0) - (double)((keys & minus) != 0);
}

static double clamp(double x, double low, double high) {
    return x < low ? low : x > high ? high : x;
}

static struct ap_quat yaw_of(const struct player *player) {
    return ap_quat_from_axis_angle((struct ap_vec3){0, 1, 0}, player->yaw_rad);
}

static void step(void *state, const struct sim_window_input *input, double step_s) {
    struct player *player = state;
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
        struct ap_vec3 *p = &player->hand_m[hand];
        p->x = clamp(p->x + dx * HAND_M_PER_PX, -0.8, 0.8);
        p->y = clamp(p->y - dy * HAND_M_PER_PX, -1.2, 0.8);
        p->z = clamp(p->z - notches * REACH_M_PER_NOTCH, -0.8, 0.3);
    }
    if (!held) {
        player->yaw_rad -= dx * TURN_RAD_PER_PX;
        player->pitch_rad =
            clamp(player->pitch_rad - dy * TURN_RAD_PER_PX, -MAX_PITCH_RAD, MAX_PITCH_RAD);
    }
    // With the right button down, as programs use a stick while they aim.
    bool pushes = !held && (input->keys & SIM_KEY_SQUEEZE);
    double still_s = fmax(0, fabs(player->push_s) - step_s);
    player->push_s = pushes ? copysign(still_s, player->push_s) + notches * PUSH_S_PER_NOTCH : 0;
    player->push_s = clamp(player->push_s, -LONGEST_PUSH_S, LONGEST_PUSH_S);
    double speed = WALK_M_PER_S * (input->keys & SIM_KEY_SLOW ? SLOW_FACTOR : 1);
    struct ap_vec3 go = {axis(input->keys, SIM_KEY_LEFT, SIM_KEY_RIGHT),
                         axis(input->keys, SIM_KEY_DOWN, SIM_KEY_UP),
                         axis(input->keys, SIM_KEY_FORWARD, SIM_KEY_BACK)};
    go = ap_vec3_scale(speed * step_s, ap_vec3_normalize(ap_quat_rotate(yaw_of(player), go)));
    player->head_m = ap_vec3_add(player->head_m, go);
    player->head_m.y = clamp(player->head_m.y, 0.2, 2.5);
}

static enum ap_pose_state at(const void *state, enum sim_device device, int64_t ns,
                             struct ap_sample *out) {
    const struct player *player = state;
    struct ap_quat yaw = yaw_of(player);
    struct ap_quat pitch = ap_quat_from_axis_angle((struct ap_vec3){1, 0, 0}, player->pitch_rad);
    *out = (struct ap_sample){
        .device = device, .t_ns = ns, .pose = {player->head_m, ap_quat_mul(yaw, pitch)}};
    if (device == SIM_HEAD)
        return AP_POSE_EXACT;
    out->pose.p =
        ap_vec3_add(player->head_m, ap_quat_rotate(yaw, player->hand_m[device - SIM_LEFT]));
    // The right hand holds the buttons unless only the left one is held.
    bool left_only = (player->keys & SIM_KEY_HAND_LEFT) && !(player->keys & SIM_KEY_HAND_RIGHT);
    if ((device == SIM_LEFT) == left_only) {
        out->trigger = player->keys & SIM_KEY_TRIGGER ? 1 : 0;
        out->squeeze = player->keys & SIM_KEY_SQUEEZE ? 1 : 0;
        out->select = (player->keys & SIM_KEY_TRIGGER) != 0;
    }
    return AP_POSE_EXACT;
}

// Sticks and buttons by key, whatever the controller calls them. The left hand, then the right.
static const struct stick {
    uint32_t left, right, down, up;
} sticks[2] = {
    {SIM_KEY_STICK_LEFT, SIM_KEY_STICK_RIGHT, SIM_KEY_STICK_DOWN, SIM_KEY_STICK_UP},
    {SIM_KEY_TURN_LEFT, SIM_KEY_TURN_RIGHT, SIM_KEY_RIGHT_STICK_DOWN, SIM_KEY_RIGHT_STICK_UP}};

static const struct button {
    int top;
    const char *path;
    uint32_t key;
} buttons[] = {
    {SIM_TOP_LEFT, "/input/x/click", SIM_KEY_X},
    {SIM_TOP_LEFT, "/input/y/click", SIM_KEY_Y},
    {SIM_TOP_LEFT, "/input/a/click", SIM_KEY_X},
    {SIM_TOP_LEFT, "/input/b/click", SIM_KEY_Y},
    {SIM_TOP_RIGHT, "/input/a/click", SIM_KEY_A},
    {SIM_TOP_RIGHT, "/input/b/click", SIM_KEY_B},
    {SIM_TOP_LEFT, "/input/menu/click", SIM_KEY_MENU},
    {SIM_TOP_LEFT, "/input/thumbstick/click", SIM_KEY_STICK_CLICK},
    {SIM_TOP_RIGHT, "/input/thumbstick/click", SIM_KEY_RIGHT_STICK_CLICK},
    {SIM_TOP_LEFT, "/input/trackpad/click", SIM_KEY_X},
    {SIM_TOP_RIGHT, "/input/trackpad/click", SIM_KEY_A},
};

// "/input/thumbstick", or a trackpad where the controller has no stick; its whole, x or y.
static bool stick_component(const struct player *player, const char *path, int top,
                            float value[2]) {
    static const char *const names[] = {"/input/thumbstick", "/input/trackpad"};
    for (int i = 0; i < 2; i++) {
        size_t length = strlen(names[i]);
        if (strncmp(path, names[i], length) != 0)
            continue;
        const struct stick *s = &sticks[top == SIM_TOP_RIGHT];
        float x = (float)axis(player->keys, s->left, s->right);
        float y = (float)axis(player->keys, s->down, s->up);
        if (top == SIM_TOP_RIGHT && player->push_s != 0)
            y = player->push_s > 0 ? 1 : -1;
        const char *of = path + length;
        if (*of && strcmp(of, "/x") != 0 && strcmp(of, "/y") != 0)
            return false;
        value[0] = of[0] && of[1] == 'y' ? y : x;
        value[1] = *of ? 0 : y;
        return true;
    }
    return false;
}

static bool component(const void *state, const struct sim_component *c, int top, float value[2]) {
    const struct player *player = state;
    if (top > SIM_TOP_RIGHT)
        return false;
    for (size_t i = 0; i < sizeof buttons / sizeof *buttons; i++)
        if (buttons[i].top == top && strcmp(buttons[i].path, c->path) == 0) {
            value[0] = (player->keys & buttons[i].key) != 0;
            return true;
        }
    return stick_component(player, c->path, top, value);
}

const struct sim_poses_kind sim_poses_window = {
    .create = create, .destroy = free, .at = at, .input = step, .component = component};
