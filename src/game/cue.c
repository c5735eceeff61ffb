#include "src/game/cue.h"

#include "src/geom/map.h"

static const int64_t longest_gap_ns = 100000000;
static const double fastest_m_s = 20, jump_grace_m = 0.005, clear_m = 0.005, slips_off = 0.55,
                    steepest_rad = 1.4;

void ap_cue_init(const struct ap_cue_params *params, struct ap_cue *cue) {
    *cue = (struct ap_cue){.params = *params, .axis = {0, 0, -1}};
    if (!(cue->params.reach_m > 0))
        cue->params.reach_m = 0.75;
    if (!(cue->params.tip_radius_m > 0))
        cue->params.tip_radius_m = 0.0058;
    if (!(cue->params.least_speed_m_s > 0))
        cue->params.least_speed_m_s = 0.03;
}

static bool is_finite(const struct ap_iso *m) {
    for (int i = 0; i < 16; i++)
        if (!isfinite(m->m[i / 4][i % 4]))
            return false;
    return true;
}

static struct ap_vec3 log_of(struct ap_space space, const struct ap_iso *frame_from_point) {
    const double(*m)[4] = frame_from_point->m;
    double rho = space.rho_m;
    struct ap_vec4 p = {rho * m[0][3], rho * m[1][3], rho * m[2][3], rho * m[3][3]};
    return ap_log_unchecked(space, p, 0);
}

// Where the bridge is seen from the right hand; a hand upon the other says nothing.
static struct ap_vec3 find_axis(const struct ap_cue *cue, struct ap_space space,
                                const struct ap_cue_hands *hands) {
    if (!hands->left_tracked || !is_finite(&hands->world_from_left))
        return cue->axis;
    struct ap_iso back = ap_iso_inverse(space, hands->world_from_right);
    struct ap_iso right_from_left = ap_iso_mul(back, hands->world_from_left);
    struct ap_vec3 to = log_of(space, &right_from_left);
    double length = ap_vec3_length(to);
    return length > 0.05 ? ap_vec3_scale(1 / length, to) : cue->axis;
}

// The turn that takes −z to the unit vector a, the shortest.
static struct ap_quat aim(struct ap_vec3 a) {
    struct ap_vec3 from = {0, 0, -1}, cross = ap_vec3_cross(from, a);
    double w = 1 + ap_vec3_dot(from, a);
    if (w < 1e-12)
        return (struct ap_quat){0, 1, 0, 0};
    return ap_quat_normalize((struct ap_quat){cross.x, cross.y, cross.z, w});
}

static bool tip_pose(double reach_m, struct ap_vec3 axis, struct ap_space space,
                     const struct ap_cue_hands *hands, struct ap_iso *world_from_tip) {
    if (!hands->right_tracked || !is_finite(&hands->world_from_right))
        return false;
    struct ap_iso along = ap_iso_translate(space, ap_vec3_scale(reach_m, axis));
    struct ap_iso at = ap_iso_mul(hands->world_from_right, along);
    *world_from_tip = ap_iso_mul(at, ap_iso_rotate(aim(axis)));
    return is_finite(world_from_tip);
}

bool ap_cue_pose(const struct ap_cue *cue, struct ap_space space, const struct ap_cue_hands *hands,
                 struct ap_iso *world_from_tip) {
    if (!hands->right_tracked || !is_finite(&hands->world_from_right))
        return false;
    return tip_pose(cue->params.reach_m, find_axis(cue, space, hands), space, hands,
                    world_from_tip);
}

// Appends a frame; false where the way begins anew with it.
static bool append(struct ap_cue *cue, int64_t t_ns, struct ap_vec3 tip, struct ap_vec3 axis) {
    bool follows = cue->count > 0;
    if (follows) {
        int64_t dt = t_ns - cue->sample[cue->count - 1].t_ns;
        double way = ap_vec3_length(ap_vec3_sub(tip, cue->sample[cue->count - 1].tip_m));
        follows =
            dt > 0 && dt <= longest_gap_ns && way <= fastest_m_s * (double)dt * 1e-9 + jump_grace_m;
    }
    if (!follows) {
        cue->count = 0;
        cue->armed = false;
    }
    if (cue->count == AP_CUE_SAMPLES) {
        for (int i = 1; i < AP_CUE_SAMPLES; i++)
            cue->sample[i - 1] = cue->sample[i];
        cue->count--;
    }
    cue->sample[cue->count].t_ns = t_ns;
    cue->sample[cue->count].tip_m = tip;
    cue->sample[cue->count++].axis = axis;
    return follows;
}

// The slope of the tip's way along the axis, by least squares over the frames kept: a tracker's
// noise is not a stroke.
static double speed_of(const struct ap_cue *cue, struct ap_vec3 axis) {
    double n = cue->count, st = 0, sx = 0, stt = 0, stx = 0;
    for (int i = 0; i < cue->count; i++) {
        double t = (double)(cue->sample[i].t_ns - cue->sample[0].t_ns) * 1e-9;
        double x = ap_vec3_dot(cue->sample[i].tip_m, axis);
        st += t;
        sx += x;
        stt += t * t;
        stx += t * x;
    }
    return (n * stx - st * sx) / (n * stt - st * st);
}

// The first u of [0, 1] at which |from + u·step| is `reach`, coming nearer; false: none.
static bool first_touch(struct ap_vec3 from, struct ap_vec3 step, double reach, double *u) {
    double a = ap_vec3_dot(step, step), b = ap_vec3_dot(from, step);
    double c = ap_vec3_dot(from, from) - reach * reach, root = b * b - a * c;
    if (c <= 0 || !(b < 0) || root < 0)
        return false;
    *u = c / (-b + sqrt(root));
    return *u <= 1;
}

static enum ap_cue_touch touch(struct ap_cue *cue, double u, double ball_radius_m,
                               struct ap_cue_hit *hit) {
    int last = cue->count - 1;
    struct ap_vec3 from = cue->sample[last - 1].tip_m;
    struct ap_vec3 at =
        ap_vec3_add(from, ap_vec3_scale(u, ap_vec3_sub(cue->sample[last].tip_m, from)));
    struct ap_vec3 axis =
        ap_vec3_normalize(ap_vec3_add(ap_vec3_scale(1 - u, cue->sample[last - 1].axis),
                                      ap_vec3_scale(u, cue->sample[last].axis)));
    double speed = speed_of(cue, axis);
    if (!(speed >= cue->params.least_speed_m_s) || !(speed <= fastest_m_s))
        return AP_CUE_NOTHING;
    // Across the axis: right is level, above is across both.
    struct ap_vec3 right = ap_vec3_normalize(ap_vec3_cross(axis, (struct ap_vec3){0, 1, 0}));
    struct ap_vec3 above = ap_vec3_cross(right, axis);
    double scale = 1 / (ball_radius_m + cue->params.tip_radius_m);
    int64_t t0 = cue->sample[last - 1].t_ns;
    *hit = (struct ap_cue_hit){.t_ns =
                                   t0 + (int64_t)llround(u * (double)(cue->sample[last].t_ns - t0)),
                               .axis = axis,
                               .speed_m_s = speed,
                               .right = scale * ap_vec3_dot(at, right),
                               .above = scale * ap_vec3_dot(at, above)};
    cue->armed = false;
    return hypot(hit->right, hit->above) > slips_off ? AP_CUE_MISCUE : AP_CUE_HIT;
}

enum ap_cue_touch ap_cue_feed(struct ap_cue *cue, struct ap_space space, int64_t t_ns,
                              const struct ap_cue_hands *hands,
                              const struct ap_iso *world_from_ball, double ball_radius_m,
                              struct ap_cue_hit *hit) {
    struct ap_iso world_from_tip;
    if (hands->right_tracked && is_finite(&hands->world_from_right))
        cue->axis = find_axis(cue, space, hands);
    if (!tip_pose(cue->params.reach_m, cue->axis, space, hands, &world_from_tip)) {
        cue->count = 0;
        cue->armed = false;
        return AP_CUE_NOTHING;
    }
    struct ap_iso ball_from_world = ap_iso_inverse(space, *world_from_ball);
    struct ap_iso ball_from_tip = ap_iso_mul(ball_from_world, world_from_tip);
    struct ap_vec3 tip = log_of(space, &ball_from_tip);
    // The axis, carried in parallel from the tip to the ball's centre.
    struct ap_iso back = ap_iso_translate(space, ap_vec3_scale(-1, tip));
    struct ap_iso turn = ap_iso_mul(back, ball_from_tip);
    struct ap_vec3 axis = {-turn.m[0][2], -turn.m[1][2], -turn.m[2][2]};
    if (!isfinite(tip.x + tip.y + tip.z) || !isfinite(axis.x + axis.y + axis.z)) {
        cue->count = 0;
        return AP_CUE_NOTHING;
    }
    bool follows = append(cue, t_ns, tip, axis);
    double reach = ball_radius_m + cue->params.tip_radius_m, u;
    enum ap_cue_touch result = AP_CUE_NOTHING;
    if (follows && cue->armed) {
        struct ap_vec3 from = cue->sample[cue->count - 2].tip_m;
        if (first_touch(from, ap_vec3_sub(tip, from), reach, &u))
            result = touch(cue, u, ball_radius_m, hit);
    }
    if (ap_vec3_length(tip) > reach + clear_m)
        cue->armed = true;
    return result;
}

struct ap_iso ap_cue_ball(const struct ap_physics *ph, int ball) {
    struct ap_iso m = ap_physics_world_from_ball(ph, ball);
    // Its own turning undone: the foot's frame, lifted.
    struct ap_quat q = ap_physics_turn(ph, ball);
    return ap_iso_mul(m, ap_iso_rotate(ap_quat_conj(q)));
}

struct ap_strike ap_cue_strike(const struct ap_physics *ph, int ball,
                               const struct ap_cue_hit *hit) {
    struct ap_iso m = ap_cue_ball(ph, ball);
    struct ap_iso down =
        ap_iso_translate(ph->shape.space, (struct ap_vec3){0, -ph->params.ball_radius_m, 0});
    struct ap_iso foot = ap_iso_mul(m, down);
    struct ap_plane_frame f = ap_plane_of(&foot);
    struct ap_strike s = {.direction =
                              ap_plane_apply(&f, (struct ap_plane3){hit->axis.x, hit->axis.z, 0}),
                          .speed_m_s = hit->speed_m_s,
                          .right = hit->right,
                          .above = hit->above,
                          .elevation_rad = asin(fmin(fmax(-hit->axis.y, 0), 1))};
    s.elevation_rad = fmin(s.elevation_rad, steepest_rad);
    return s;
}
