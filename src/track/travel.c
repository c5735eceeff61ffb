#include "src/track/travel.h"

#include <math.h>

static const double dead_zone = 0.2, longest_step_s = 0.1;

// How fast the vignette closes and opens, and how fast the reach grows with the stick.
static const double vignette_per_s = 4, reach_per_s = 1.5;

static double given(double value, double otherwise) {
    return isfinite(value) && value > 0 ? value : otherwise;
}

void ap_travel_init(struct ap_travel *travel, const struct ap_travel_params *params) {
    const struct ap_travel_params p = params ? *params : (struct ap_travel_params){0};
    *travel = (struct ap_travel){.params = {.speed_mps = given(p.speed_mps, 1),
                                            .turn_rad = given(p.turn_rad, 0.52359877559829887),
                                            .fade_s = given(p.fade_s, 0.12),
                                            .reach_max_m = given(p.reach_max_m, 20),
                                            .no_vignette = p.no_vignette,
                                            .turn_smoothly = p.turn_smoothly}};
    travel->params.reach_m = fmin(given(p.reach_m, 1), travel->params.reach_max_m);
    travel->reach_m = travel->params.reach_m;
}

// Beyond the dead zone, 0…±1.
static double stick(double value) {
    if (!isfinite(value))
        return 0;
    double size = (fmin(fabs(value), 1) - dead_zone) / (1 - dead_zone);
    return size > 0 ? copysign(size, value) : 0;
}

static double step_s(struct ap_travel *travel, int64_t t_ns) {
    // In double, so that no two times can overflow.
    double dt = travel->started ? ((double)t_ns - (double)travel->t_ns) * 1e-9 : 0;
    travel->started = true;
    travel->t_ns = t_ns;
    return dt > 0 ? fmin(dt, longest_step_s) : 0;
}

static void carry(struct ap_travel_output *out, struct ap_pose grip, struct ap_vec3 way_m,
                  struct ap_quat turn) {
    out->carry = true;
    out->room_from_grip = grip;
    out->motion = (struct ap_pose){way_m, turn};
}

static const struct ap_quat no_turn = {0, 0, 0, 1};

// True: she flies.
static bool fly(const struct ap_travel *travel, const struct ap_travel_input *in, double dt,
                struct ap_travel_output *out) {
    struct ap_vec3 v = {stick(in->right), stick(in->up), -stick(in->forward)};
    double size = ap_vec3_length(v);
    if (size == 0)
        return false;
    // A diagonal is not faster.
    double way_m = travel->params.speed_mps * dt / fmax(size, 1);
    if (dt > 0)
        carry(out, in->room_from_head, ap_vec3_scale(way_m, v), no_turn);
    return true;
}

// About the vertical through the head, in the room's axes: the horizon stays.
static bool turn(struct ap_travel *travel, const struct ap_travel_input *in, double dt,
                 struct ap_travel_output *out) {
    double by = stick(in->turn);
    bool snap = !travel->params.turn_smoothly;
    bool again = snap && travel->turned;
    travel->turned = fabs(by) > (travel->turned ? 0.3 : 0.6);
    double angle = snap ? copysign(travel->params.turn_rad, by) : by * travel->params.turn_rad * dt;
    if (by == 0 || (snap && (again || !travel->turned)) || angle == 0)
        return false;
    const struct ap_pose grip = {in->room_from_head.p, no_turn};
    carry(out, grip, (struct ap_vec3){0, 0, 0},
          ap_quat_from_axis_angle((struct ap_vec3){0, 1, 0}, -angle));
    return true;
}

static void enter(struct ap_travel *travel, enum ap_travel_phase phase) {
    travel->phase = phase;
    travel->phase_t_ns = travel->t_ns;
}

static void point(struct ap_travel *travel, const struct ap_travel_input *in, double dt,
                  struct ap_travel_output *out) {
    // In proportion, so that near and far places are chosen alike.
    double reach_m = travel->reach_m * exp(reach_per_s * stick(in->forward) * dt);
    travel->reach_m = fmax(0.1, fmin(reach_m, travel->params.reach_max_m));
    out->pointing = true;
    out->reach_m = travel->reach_m;
    if (in->cancel)
        enter(travel, AP_TRAVEL_STAY);
    else if (!in->point) {
        travel->room_from_aim = in->room_from_aim;
        enter(travel, AP_TRAVEL_DARKEN);
    }
}

// Darkness falls, she goes, light comes.
static void fade(struct ap_travel *travel, struct ap_travel_output *out) {
    double part = (double)(travel->t_ns - travel->phase_t_ns) * 1e-9 / travel->params.fade_s;
    part = fmin(fmax(part, 0), 1);
    out->fade = travel->phase == AP_TRAVEL_DARKEN ? part : 1 - part;
    if (part < 1)
        return;
    if (travel->phase == AP_TRAVEL_LIGHTEN) {
        enter(travel, AP_TRAVEL_STAY);
        return;
    }
    carry(out, travel->room_from_aim, (struct ap_vec3){0, 0, -travel->reach_m}, no_turn);
    enter(travel, AP_TRAVEL_LIGHTEN);
}

struct ap_travel_output ap_travel_step(struct ap_travel *travel,
                                       const struct ap_travel_input *input) {
    struct ap_travel_output out = {0};
    double dt = step_s(travel, input->t_ns);
    bool flies = false;
    if (travel->phase == AP_TRAVEL_STAY && input->point && !travel->held && !input->cancel)
        enter(travel, AP_TRAVEL_POINT);
    travel->held = input->point;
    if (travel->phase == AP_TRAVEL_POINT)
        point(travel, input, dt, &out);
    else if (travel->phase != AP_TRAVEL_STAY)
        fade(travel, &out);
    else if (!turn(travel, input, dt, &out))
        flies = fly(travel, input, dt, &out);
    double wanted = flies && !travel->params.no_vignette ? 1 : 0;
    double most = vignette_per_s * dt;
    travel->vignette += fmax(-most, fmin(most, wanted - travel->vignette));
    out.vignette = travel->vignette;
    return out;
}
