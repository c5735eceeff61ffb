#include "src/game/physics.h"

#include <string.h>

#include "src/game/queue.h"
#include "src/game/segment.h"
#include "src/geom/map.h"

static const double standard_radius_m = 0.028575;

double ap_physics_ball_radius(const struct ap_table_shape *shape) {
    return fmin(standard_radius_m, 0.0835 * shape->inradius_m);
}

static enum ap_status fill_in(struct ap_error *err, const struct ap_table_shape *shape,
                              struct ap_physics_params *p) {
    struct {
        double *value, standard;
    } const list[] = {
        {&p->ball_radius_m, ap_physics_ball_radius(shape)},
        {&p->ball_mass_kg, 0.17},
        {&p->gravity_m_s2, 9.81},
        {&p->slide_friction, 0.2},
        {&p->roll_friction, 0.01},
        {&p->spin_friction, 0.0127},
        {&p->ball_restitution, 0.95},
        {&p->ball_friction, 0.05},
        {&p->cushion_restitution, 0.85},
        {&p->cushion_friction, 0.2},
        {&p->cushion_m, fmin(0.025, 0.07 * shape->inradius_m)},
        {&p->cue_mass_kg, 0.54},
        {&p->tip_restitution, 0.75},
    };
    for (size_t i = 0; i < sizeof list / sizeof *list; i++) {
        if (!isfinite(*list[i].value))
            return ap_fail(err, AP_USAGE, "a constant of the physics is not a finite number");
        if (*list[i].value == 0)
            *list[i].value = list[i].standard;
        if (*list[i].value < 0)
            *list[i].value = 0;
    }
    if (!(p->ball_radius_m > 0) || !(p->ball_mass_kg > 0) || !(p->gravity_m_s2 > 0) ||
        !(p->cue_mass_kg > 0))
        return ap_fail(err, AP_USAGE,
                       "radius and mass of a ball, gravity and the cue's mass must be above 0");
    if (p->ball_restitution > 1 || p->cushion_restitution > 1 || p->tip_restitution > 1)
        return ap_fail(err, AP_USAGE, "a restitution is at most 1");
    return AP_OK;
}

static void add_pocket(struct ap_physics *ph, struct ap_iso place) {
    struct ap_plane_frame f = ap_plane_of(&place);
    ph->pocket[ph->pocket_count++] = ap_plane_foot(&f, ph->shape.space.rho_m);
}

static void add_pockets(struct ap_physics *ph) {
    const struct ap_table_shape *t = &ph->shape;
    for (int k = 0; k < t->sides; k++)
        add_pocket(
            ph, ap_iso_mul(ap_iso_rotate_y((2 * k + 1) * M_PI / t->sides),
                           ap_iso_translate(t->space, (struct ap_vec3){0, 0, -t->circumradius_m})));
    for (int k = 1; k < 4 && ph->params.side_pockets; k += 2)
        add_pocket(ph, ap_table_edge_frame(t, k));
}

static void add_edges(struct ap_physics *ph) {
    for (int k = 0; k < ph->shape.sides; k++) {
        // Its own frame's z points inward, so it is rho·sin_kappa of the distance.
        struct ap_iso m = ap_iso_inverse(ph->shape.space, ap_table_edge_frame(&ph->shape, k));
        ph->edge[ph->edge_count++] = (struct ap_plane3){m.m[2][0], m.m[2][2], m.m[2][3]};
    }
}

// How near an edge a foot gets: the ball's centre keeps s from the surface that lies cushion_m
// inside of the upright plane over the edge.
static double nearest_edge(const struct ap_physics *ph) {
    struct ap_space space = ph->shape.space;
    double s = ph->params.ball_radius_m, rho = space.rho_m;
    double h = ap_space_sin(space, (ph->params.cushion_m + s) / rho) / ap_space_cos(space, s / rho);
    if (space.kappa > 0)
        return rho * asin(fmin(h, 1));
    return space.kappa < 0 ? rho * asinh(h) : rho * h;
}

// The longest chord², from the circumradius.
static double longest(const struct ap_physics *ph) {
    double rho = ph->shape.space.rho_m;
    double c = ap_plane_chord2_of(ph->shape.space, 2 * ph->shape.circumradius_m);
    return ph->shape.space.kappa > 0 && (ph->params.no_cushions || c > 4 * rho * rho)
               ? 4 * rho * rho
               : c;
}

// The longest rho·sin(D/rho): in s3 at most rho, and at most the chord.
static double lever_of(const struct ap_physics *ph) {
    double rho2 = ph->shape.space.rho_m * ph->shape.space.rho_m;
    int kappa = ph->shape.space.kappa;
    if (kappa > 0)
        return sqrt(fmin(ph->longest_m2, rho2));
    return sqrt(ph->longest_m2 * (1 - kappa * ph->longest_m2 / (4 * rho2)));
}

static enum ap_status check_fit(struct ap_error *err, const struct ap_physics *ph) {
    const struct ap_table_shape *t = &ph->shape;
    double s = ph->params.ball_radius_m;
    if (t->space.kappa > 0 && s >= t->space.rho_m * M_PI / 4)
        return ap_fail(err, AP_USAGE,
                       "balls of radius %g m do not fit on a sphere of radius %g m: less than %g",
                       s, t->space.rho_m, t->space.rho_m * M_PI / 4);
    if (ph->params.no_cushions)
        return AP_OK;
    if (!(ph->edge_distance_m + s < t->inradius_m))
        return ap_fail(err, AP_USAGE,
                       "balls of radius %g m and cushions %g m wide do not fit on a table whose "
                       "edges are %g m from its middle",
                       s, ph->params.cushion_m, t->inradius_m);
    if (ph->pocket_count && !(ph->params.pocket_radius_m < 0.8 * t->inradius_m))
        return ap_fail(err, AP_USAGE, "pockets of radius %g m swallow a table of inradius %g m",
                       ph->params.pocket_radius_m, t->inradius_m);
    return AP_OK;
}

enum ap_status ap_physics_init(struct ap_error *err, const struct ap_table_shape *shape,
                               const struct ap_physics_params *params, struct ap_physics *out) {
    struct ap_physics ph = {.shape = *shape, .params = *params};
    enum ap_status st = fill_in(err, shape, &ph.params);
    if (st)
        return st;
    if ((ph.params.no_cushions && shape->space.kappa <= 0) ||
        (ph.params.side_pockets && shape->sides != 4))
        return ap_fail(err, AP_USAGE, "%s",
                       ph.params.no_cushions ? "only in s3 can the balls do without cushions"
                                             : "side pockets are for the square table of e3 only");
    ph.rolling_radius_m = ap_plane_rolling_radius(shape->space, ph.params.ball_radius_m);
    ph.touch_m2 = 4 * ph.rolling_radius_m * ph.rolling_radius_m;
    ph.edge_distance_m = nearest_edge(&ph);
    ph.edge_height_m =
        shape->space.rho_m * ap_space_sin(shape->space, ph.edge_distance_m / shape->space.rho_m);
    ph.longest_m2 = longest(&ph);
    ph.lever_m = lever_of(&ph);
    ph.edge_lever =
        shape->space.kappa < 0 ? cosh(2 * shape->circumradius_m / shape->space.rho_m) : 1;
    if (ph.params.pocket_radius_m == 0)
        ph.params.pocket_radius_m =
            sqrt(2) * (ph.params.cushion_m + ph.params.ball_radius_m) + ph.params.ball_radius_m;
    ph.capture_m2 = ap_plane_chord2_of(shape->space, ph.params.pocket_radius_m);
    if (!ph.params.no_cushions)
        add_edges(&ph);
    if (!ph.params.no_pockets && !ph.params.no_cushions)
        add_pockets(&ph);
    st = check_fit(err, &ph);
    if (st)
        return st;
    ap_queue_clear(&ph);
    *out = ph;
    return AP_OK;
}

void ap_physics_set(struct ap_physics *ph, int ball, const struct ap_plane_frame *foot,
                    struct ap_plane2 velocity, struct ap_vec3 turn, struct ap_quat orientation) {
    for (; ph->ball_count <= ball; ph->ball_count++)
        ph->ball[ph->ball_count] =
            (struct ap_ball){.state = AP_BALL_POCKETED, .pocket = -1, .t_end_s = INFINITY};
    struct ap_ball *b = &ph->ball[ball];
    *b = (struct ap_ball){.state = AP_BALL_AT_REST,
                          .pocket = -1,
                          .world_from_foot = *foot,
                          .velocity_m_s = velocity,
                          .turn_rad_s = turn,
                          .foot_from_ball = orientation};
    ap_segment_begin(ph, b, ph->now_s);
    ap_queue_renew(ph, 1u << ball, ph->now_s);
}

void ap_physics_remove(struct ap_physics *ph, int ball) {
    ph->ball[ball] = (struct ap_ball){.state = AP_BALL_POCKETED,
                                      .pocket = -1,
                                      .t_end_s = INFINITY,
                                      .world_from_foot = AP_PLANE_FRAME_IDENTITY,
                                      .foot_from_ball = AP_QUAT_IDENTITY};
    ap_queue_renew(ph, 1u << ball, ph->now_s);
}

static enum ap_status check_place(struct ap_error *err, const struct ap_physics *ph, int ball,
                                  struct ap_plane3 p) {
    struct ap_space space = ph->shape.space;
    const double grace = 1e-12 * ph->touch_m2;
    for (int k = 0; k < ph->edge_count; k++) {
        const struct ap_plane3 *e = &ph->edge[k];
        if (!(e->x * p.x + e->z * p.z + e->w * p.w >= ph->edge_height_m))
            return ap_fail(err, AP_INPUT, "there ball %d is not on the table, but over edge %d",
                           ball, k);
    }
    for (int k = 0; k < ph->pocket_count; k++)
        if (ap_plane_chord2(space.kappa, p, ph->pocket[k]) <= ph->capture_m2)
            return ap_fail(err, AP_INPUT, "there ball %d would fall into pocket %d", ball, k);
    for (int k = 0; k < ph->ball_count; k++) {
        if (k == ball || ph->ball[k].state == AP_BALL_POCKETED)
            continue;
        struct ap_plane3 q = ap_physics_motion(ph, k, ph->now_s).foot_m;
        if (ap_plane_chord2(space.kappa, p, q) < ph->touch_m2 - grace)
            return ap_fail(err, AP_INPUT, "there ball %d would overlap ball %d", ball, k);
    }
    return AP_OK;
}

enum ap_status ap_physics_place(struct ap_error *err, struct ap_physics *ph, int ball,
                                struct ap_plane2 at) {
    if (ball < 0 || ball >= AP_BALLS_MAX)
        return ap_fail(err, AP_INPUT, "no ball %d: there are at most %d", ball, AP_BALLS_MAX);
    if (!isfinite(at.x) || !isfinite(at.z))
        return ap_fail(err, AP_INPUT, "the place of ball %d is not a finite number", ball);
    // Beyond the corners, before exp of something huge.
    if (!ph->params.no_cushions && ap_plane2_length(at) > ph->shape.circumradius_m)
        return ap_fail(err, AP_INPUT, "there ball %d is not on the table", ball);
    struct ap_plane_frame foot = ap_plane_translate(ph->shape.space, at);
    enum ap_status st = check_place(err, ph, ball, ap_plane_foot(&foot, ph->shape.space.rho_m));
    if (st)
        return st;
    struct ap_quat q = ball < ph->ball_count ? ph->ball[ball].foot_from_ball : AP_QUAT_IDENTITY;
    if (q.x == 0 && q.y == 0 && q.z == 0 && q.w == 0)
        q = AP_QUAT_IDENTITY;
    ap_physics_set(ph, ball, &foot, (struct ap_plane2){0, 0}, (struct ap_vec3){0, 0, 0}, q);
    return AP_OK;
}

struct ap_ball_motion ap_physics_motion(const struct ap_physics *ph, int ball, double t_s) {
    struct ap_ball b = ph->ball[ball];
    struct ap_ball_motion m;
    t_s = fmin(fmax(t_s, b.t0_s), b.t_end_s);
    ap_segment_at(ph, &b, t_s, &m.foot_m, &m.velocity_m_s);
    ap_segment_commit(ph, &b, t_s);
    struct ap_plane2 rolling = ap_rolling_of(b.turn_rad_s);
    m.rolling_rad_s =
        ap_plane_apply(&b.world_from_foot, (struct ap_plane3){rolling.x, rolling.z, 0});
    m.spin_rad_s = b.turn_rad_s.y;
    return m;
}

struct ap_iso ap_physics_world_from_ball(const struct ap_physics *ph, int ball) {
    struct ap_ball b = ph->ball[ball];
    ap_segment_commit(ph, &b, fmin(fmax(ph->now_s, b.t0_s), b.t_end_s));
    struct ap_iso foot = ap_plane_lift(&b.world_from_foot);
    struct ap_iso up =
        ap_iso_translate(ph->shape.space, (struct ap_vec3){0, ph->params.ball_radius_m, 0});
    return ap_iso_mul(ap_iso_mul(foot, up), ap_iso_rotate(b.foot_from_ball));
}

struct ap_quat ap_physics_turn(const struct ap_physics *ph, int ball) {
    struct ap_ball b = ph->ball[ball];
    ap_segment_commit(ph, &b, fmin(fmax(ph->now_s, b.t0_s), b.t_end_s));
    return b.foot_from_ball;
}

bool ap_physics_at_rest(const struct ap_physics *ph) {
    for (int i = 0; i < ph->ball_count; i++)
        if (ph->ball[i].state != AP_BALL_AT_REST && ph->ball[i].state != AP_BALL_POCKETED)
            return false;
    return true;
}

double ap_physics_energy(const struct ap_physics *ph) {
    double m = ph->params.ball_mass_kg, R = ph->rolling_radius_m, sum = 0;
    for (int i = 0; i < ph->ball_count; i++) {
        if (ph->ball[i].state == AP_BALL_POCKETED)
            continue;
        struct ap_ball b = ph->ball[i];
        ap_segment_commit(ph, &b, fmin(fmax(ph->now_s, b.t0_s), b.t_end_s));
        sum += 0.5 * m * ap_plane2_dot(b.velocity_m_s, b.velocity_m_s) +
               0.2 * m * R * R * ap_vec3_dot(b.turn_rad_s, b.turn_rad_s);
    }
    return sum;
}

void ap_physics_momentum(const struct ap_physics *ph, double about[3]) {
    double m = ph->params.ball_mass_kg, rho = ph->shape.space.rho_m;
    about[0] = about[1] = about[2] = 0;
    for (int i = 0; i < ph->ball_count; i++) {
        if (ph->ball[i].state == AP_BALL_POCKETED)
            continue;
        struct ap_plane3 p, v;
        ap_segment_at(ph, &ph->ball[i], fmin(ph->now_s, ph->ball[i].t_end_s), &p, &v);
        // The pairing with the transvections along x and z at the base point, and the turn about y.
        about[0] += m * (v.x * p.w - v.w * p.x) / rho;
        about[1] += m * (v.z * p.w - v.w * p.z) / rho;
        about[2] += m * (p.z * v.x - p.x * v.z);
    }
}
