#include "src/app/play/aim.h"

#include <math.h>

#include "src/geom/map.h"

static const double slowest_m_s = 0.1, fastest_m_s = 8, power_per_s = 1.5, tip_per_s = 0.5;
static const double farthest_tip = 0.5;
// The butt clears the cushion.
static const double elevation_rad = 0.07;

struct ap_play_aim ap_play_aim_standard(void) {
    return (struct ap_play_aim){.speed_m_s = 2};
}

bool ap_play_aim_target(struct ap_space space, const struct ap_iso *world_from_eye,
                        struct ap_plane3 *target) {
    const double(*m)[4] = world_from_eye->m;
    double far = space.kappa > 0 ? 0.7853981633974483 : 3;
    // The point at t rho is C·eye + S·ahead; its height is nothing where T = height / fall.
    double height = m[1][3], fall = m[1][2], t = height / fall;
    bool down = t > 0 && (space.kappa >= 0 || t < 1);
    t = !down ? far : space.kappa > 0 ? atan(t) : space.kappa < 0 ? fmin(atanh(t), far) : t;
    double c = ap_space_cos(space, t), s = ap_space_sin(space, t);
    struct ap_plane3 p = {c * m[0][3] - s * m[0][2], c * m[2][3] - s * m[2][2],
                          c * m[3][3] - s * m[3][2]};
    double norm = space.kappa == 0 ? 1 : sqrt(fabs(ap_plane_dot(space.kappa, p, p)));
    double k = space.rho_m / norm;
    if (!isfinite(k * (p.x + p.z + p.w)) || !(fabs(p.w) < 1e6))
        return false;
    *target = (struct ap_plane3){k * p.x, k * p.z, k * p.w};
    return true;
}

static double clean(double stick) {
    return isfinite(stick) && fabs(stick) > 0.15 ? fmin(fmax(stick, -1), 1) : 0;
}

static bool pressed(bool down, bool *was) {
    bool now = down && !*was;
    *was = down;
    return now;
}

enum ap_aim_wish ap_play_aim_step(struct ap_play_aim *aim, struct ap_space space,
                                  const struct ap_play_aim_input *in) {
    bool trigger = pressed(in->trigger, &aim->was_trigger);
    bool place = pressed(in->place, &aim->was_place);
    bool was_active = aim->active;
    aim->active = in->held;
    aim->has_target = in->held && ap_play_aim_target(space, in->world_from_head, &aim->target_m);
    if (!in->held)
        return AP_AIM_NOTHING;
    double dt_s = fmin(fmax(in->dt_s, 0), 0.1);
    aim->speed_m_s *= exp(power_per_s * clean(in->power) * dt_s);
    aim->speed_m_s = fmin(fmax(aim->speed_m_s, slowest_m_s), fastest_m_s);
    aim->right += tip_per_s * clean(in->tip_x) * dt_s;
    aim->above += tip_per_s * clean(in->tip_y) * dt_s;
    double shrink = fmin(1, farthest_tip / fmax(hypot(aim->right, aim->above), farthest_tip));
    aim->right *= shrink;
    aim->above *= shrink;
    if (!was_active || !aim->has_target)
        return AP_AIM_NOTHING;
    return trigger ? AP_AIM_STRIKE : place ? AP_AIM_PLACE : AP_AIM_NOTHING;
}

bool ap_play_aim_strike(const struct ap_play_aim *aim, const struct ap_physics *ph, int ball,
                        struct ap_strike *strike) {
    if (!aim->has_target || ball >= ph->ball_count || ph->ball[ball].state == AP_BALL_POCKETED)
        return false;
    struct ap_plane3 d = ap_physics_toward_point(ph, ball, aim->target_m);
    double length = sqrt(fmax(ap_plane_dot(ph->shape.space.kappa, d, d), 0));
    if (!(length > 1e-3 * ph->params.ball_radius_m) || !isfinite(length))
        return false;
    *strike = (struct ap_strike){.direction = {d.x / length, d.z / length, d.w / length},
                                 .speed_m_s = aim->speed_m_s,
                                 .right = aim->right,
                                 .above = aim->above,
                                 .elevation_rad = elevation_rad};
    return true;
}

struct ap_iso ap_play_aim_cue(const struct ap_play_aim *aim, const struct ap_physics *ph, int ball,
                              const struct ap_strike *strike, double tip_radius_m) {
    struct ap_space space = ph->shape.space;
    struct ap_plane3 foot = ap_physics_motion(ph, ball, ph->now_s).foot_m;
    struct ap_vec3 to = ap_log_unchecked(space, (struct ap_vec4){foot.x, 0, foot.z, foot.w}, 0);
    struct ap_iso at = ap_iso_translate(space, to);
    struct ap_plane_frame f = ap_plane_of(&at);
    struct ap_plane2 d = ap_plane_local(space.kappa, &f, strike->direction);
    struct ap_vec3 up = {0, ph->params.ball_radius_m, 0};
    struct ap_iso turn = ap_iso_rotate_y(atan2(-d.x, -d.z));
    struct ap_iso centre = ap_iso_mul(ap_iso_mul(at, turn), ap_iso_translate(space, up));
    struct ap_quat tilt =
        ap_quat_from_axis_angle((struct ap_vec3){1, 0, 0}, -strike->elevation_rad);
    double reach = ph->params.ball_radius_m + tip_radius_m;
    double off2 = aim->right * aim->right + aim->above * aim->above;
    struct ap_vec3 tip = {aim->right * reach, aim->above * reach,
                          reach * sqrt(1 - off2) + 0.01 + 0.03 * strike->speed_m_s};
    return ap_iso_mul(ap_iso_mul(centre, ap_iso_rotate(tilt)), ap_iso_translate(space, tip));
}
