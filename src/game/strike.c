#include <math.h>

#include "src/game/physics.h"
#include "src/game/queue.h"
#include "src/game/segment.h"

static const double slips_off = 0.55, fastest_m_s = 20, steepest_rad = 1.4;

static enum ap_status check(struct ap_error *err, const struct ap_physics *ph, int ball,
                            const struct ap_strike *s) {
    if (ball < 0 || ball >= ph->ball_count || ph->ball[ball].state == AP_BALL_POCKETED)
        return ap_fail(err, AP_INPUT, "ball %d is not on the table: it cannot be struck", ball);
    const double all[] = {s->direction.x, s->direction.z, s->direction.w,  s->speed_m_s,
                          s->right,       s->above,       s->elevation_rad};
    for (size_t i = 0; i < sizeof all / sizeof *all; i++)
        if (!isfinite(all[i]))
            return ap_fail(err, AP_INPUT, "a number of the stroke is not finite");
    if (!(s->speed_m_s > 0) || s->speed_m_s > fastest_m_s)
        return ap_fail(err, AP_INPUT, "the cue's speed is %g m/s: expected above 0, at most %g",
                       s->speed_m_s, fastest_m_s);
    if (hypot(s->right, s->above) > slips_off)
        return ap_fail(err, AP_INPUT,
                       "the tip meets the ball %g radii off its middle: above %g it slips off",
                       hypot(s->right, s->above), slips_off);
    if (s->elevation_rad < 0 || s->elevation_rad > steepest_rad)
        return ap_fail(err, AP_INPUT, "the cue is inclined by %g rad: expected 0 to %g",
                       s->elevation_rad, steepest_rad);
    return AP_OK;
}

// The tip pushes along the cue with an impulse that its own mass, the ball's and the ball's turning
// decide; the felt takes what points down.
static void push(const struct ap_physics *ph, struct ap_ball *b, struct ap_plane2 d,
                 const struct ap_strike *s) {
    double m = ph->params.ball_mass_kg, R = ph->rolling_radius_m;
    double c = cos(s->elevation_rad), sn = sin(s->elevation_rad);
    double offset2 = s->right * s->right + s->above * s->above;
    double ease = 1 / ph->params.cue_mass_kg + c * c / m + 2.5 * offset2 / m;
    double impulse = (1 + ph->params.tip_restitution) * s->speed_m_s / ease;
    b->velocity_m_s = ap_plane2_add(b->velocity_m_s, impulse * c / m, d);
    double turn = 2.5 * impulse / (m * R);
    struct ap_plane2 right = ap_plane2_side(d);
    b->turn_rad_s.x += turn * (s->right * sn * d.x - s->above * right.x);
    b->turn_rad_s.z += turn * (s->right * sn * d.z - s->above * right.z);
    b->turn_rad_s.y += turn * s->right * c;
}

enum ap_status ap_physics_strike(struct ap_error *err, struct ap_physics *ph, int ball,
                                 const struct ap_strike *strike) {
    enum ap_status st = check(err, ph, ball, strike);
    if (st)
        return st;
    struct ap_ball b = ph->ball[ball];
    ap_segment_commit(ph, &b, fmin(ph->now_s, b.t_end_s));
    struct ap_plane2 d =
        ap_plane_local(ph->shape.space.kappa, &b.world_from_foot, strike->direction);
    double length = ap_plane2_length(d);
    if (!(length > 0))
        return ap_fail(err, AP_INPUT, "the stroke has no direction along the table");
    push(ph, &b, (struct ap_plane2){d.x / length, d.z / length}, strike);
    ap_segment_begin(ph, &b, ph->now_s);
    ph->ball[ball] = b;
    ap_queue_renew(ph, 1u << ball, ph->now_s);
    return AP_OK;
}

static struct ap_plane3 direction_of(const struct ap_physics *ph, int ball, struct ap_plane2 d) {
    struct ap_ball b = ph->ball[ball];
    ap_segment_commit(ph, &b, fmin(ph->now_s, b.t_end_s));
    return ap_plane_apply(&b.world_from_foot, (struct ap_plane3){d.x, d.z, 0});
}

struct ap_plane3 ap_physics_toward_point(const struct ap_physics *ph, int ball,
                                         struct ap_plane3 q) {
    struct ap_plane3 p = ap_physics_motion(ph, ball, ph->now_s).foot_m;
    struct ap_plane3 d = {q.x - p.x, q.z - p.z, q.w - p.w};
    struct ap_ball b = ph->ball[ball];
    ap_segment_commit(ph, &b, fmin(ph->now_s, b.t_end_s));
    return direction_of(ph, ball, ap_plane_local(ph->shape.space.kappa, &b.world_from_foot, d));
}

struct ap_plane3 ap_physics_toward(const struct ap_physics *ph, int a, int b) {
    return ap_physics_toward_point(ph, a, ap_physics_motion(ph, b, ph->now_s).foot_m);
}

// The foot's own frame has gone many ways; the one carried straight from the centre has not.
struct ap_plane3 ap_physics_heading(const struct ap_physics *ph, int ball, double angle_rad) {
    struct ap_space space = ph->shape.space;
    struct ap_plane3 p = ap_physics_motion(ph, ball, ph->now_s).foot_m;
    double r = hypot(p.x, p.z);
    double theta = space.kappa > 0   ? atan2(r, p.w)
                   : space.kappa < 0 ? asinh(r / space.rho_m)
                                     : r / space.rho_m;
    double k = r > 0 ? theta * space.rho_m / r : 0;
    struct ap_plane_frame f = ap_plane_translate(space, (struct ap_plane2){k * p.x, k * p.z});
    return ap_plane_apply(&f, (struct ap_plane3){-sin(angle_rad), -cos(angle_rad), 0});
}
