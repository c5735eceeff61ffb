#include "src/game/segment.h"

#include <string.h>

// Below these a slip or a speed is none: what rounding leaves of one.
static const double no_slip_m_s = 1e-11, no_spin_rad_s = 1e-10;

// A series is not asked for more than this many turns of xi·t, (|v|·t + |a|·t²)/rho.
static const double series_reach = 4;

static double clip_positive(double v) {
    return v > 0 ? v : 0;
}

static void begin_spin(const struct ap_physics *ph, struct ap_ball *b) {
    double rate = 2.5 * clip_positive(ph->params.spin_friction) * ph->params.gravity_m_s2 /
                  ph->rolling_radius_m;
    double y = b->turn_rad_s.y;
    b->turn_rate_rad_s2.y = fabs(y) > no_spin_rad_s ? -copysign(rate, y) : 0;
    if (fabs(y) <= no_spin_rad_s)
        b->turn_rad_s.y = 0;
}

// Sliding, with friction or without.
static void begin_slide(const struct ap_physics *ph, struct ap_ball *b, struct ap_plane2 slip,
                        double speed) {
    double mu_g = clip_positive(ph->params.slide_friction) * ph->params.gravity_m_s2;
    double R = ph->rolling_radius_m;
    b->state = AP_BALL_SLIDING;
    b->t_end_s = INFINITY;
    if (!(mu_g > 0))
        return;
    b->acceleration_m_s2 = (struct ap_plane2){-mu_g * slip.x / speed, -mu_g * slip.z / speed};
    struct ap_plane2 rolling =
        ap_plane2_add((struct ap_plane2){0, 0}, -2.5 / R, b->acceleration_m_s2);
    ap_rolling_set(&b->turn_rate_rad_s2, rolling);
    b->t_end_s = b->t0_s + speed / (3.5 * mu_g);
}

static void begin_roll(const struct ap_physics *ph, struct ap_ball *b, double speed) {
    double mu_g = clip_positive(ph->params.roll_friction) * ph->params.gravity_m_s2;
    struct ap_plane2 v = b->velocity_m_s;
    b->state = AP_BALL_ROLLING;
    b->t_end_s = INFINITY;
    if (!(mu_g > 0))
        return;
    b->acceleration_m_s2 = (struct ap_plane2){-mu_g * v.x / speed, -mu_g * v.z / speed};
    struct ap_plane2 zero = {0, 0};
    ap_rolling_set(&b->turn_rate_rad_s2,
                   ap_plane2_add(zero, 1 / ph->rolling_radius_m, b->acceleration_m_s2));
    b->t_end_s = b->t0_s + speed / mu_g;
}

// next = (cur·xi0 + before·xi1)/(k + 1), row by row.
static void recur(int kappa, const double *cur, const double *before, struct ap_plane2 xi0,
                  struct ap_plane2 xi1, int k, double *next) {
    double f = 1.0 / (k + 1);
    for (int r = 0; r < 9; r += 3) {
        double c0 = cur[r + 2], c1 = before ? before[r + 2] : 0;
        next[r] = f * -kappa * (c0 * xi0.x + c1 * xi1.x);
        next[r + 1] = f * -kappa * (c0 * xi0.z + c1 * xi1.z);
        double w = cur[r] * xi0.x + cur[r + 1] * xi0.z;
        if (before)
            w += before[r] * xi1.x + before[r + 1] * xi1.z;
        next[r + 2] = f * w;
    }
    next[9] = next[10] = next[11] = 0;
}

static double norm_of(const double *m) {
    double sum = 0;
    for (int i = 0; i < 9; i++)
        sum += m[i] * m[i];
    return sqrt(sum);
}

static void begin_series(const struct ap_physics *ph, struct ap_ball *b) {
    double rho = ph->shape.space.rho_m;
    struct ap_plane2 zero = {0, 0};
    struct ap_plane2 xi0 = ap_plane2_add(zero, 1 / rho, b->velocity_m_s);
    struct ap_plane2 xi1 = ap_plane2_add(zero, 1 / rho, b->acceleration_m_s2);
    double alpha = ap_plane2_length(xi0), beta = ap_plane2_length(xi1);
    double t = b->t_end_s - b->t0_s;
    if (alpha * t + beta * t * t > series_reach) {
        t = 2 * series_reach / (alpha + sqrt(alpha * alpha + 4 * series_reach * beta));
        b->t_end_s = b->t0_s + t;
    }
    memset(b->series[0], 0, sizeof b->series[0]);
    for (int i = 0; i < 9; i += 4)
        b->series[0][i] = 1;
    // The size of what is left, where each further term is at most half of the two before.
    double power = 1, last = 2, term = 2;
    int k = 0;
    while (k + 1 < AP_SERIES_MAX &&
           (k + 1 < 2 * (alpha * t + beta * t * t) || last > 1e-17 || term > 1e-17)) {
        recur(ph->shape.space.kappa, b->series[k], k ? b->series[k - 1] : NULL, xi0, xi1, k,
              b->series[k + 1]);
        power *= t;
        last = term;
        term = norm_of(b->series[++k]) * power;
    }
    b->terms = k + 1;
}

// Whether velocity and acceleration share a line, and which.
static bool find_line(struct ap_ball *b) {
    struct ap_plane2 v = b->velocity_m_s, a = b->acceleration_m_s2;
    double vv = ap_plane2_length(v), aa = ap_plane2_length(a);
    b->along = vv > 0   ? (struct ap_plane2){v.x / vv, v.z / vv}
               : aa > 0 ? (struct ap_plane2){a.x / aa, a.z / aa}
                        : (struct ap_plane2){1, 0};
    return vv == 0 || fabs(v.x * a.z - v.z * a.x) <= 2e-15 * vv * aa;
}

void ap_segment_begin(const struct ap_physics *ph, struct ap_ball *b, double t_s) {
    b->t0_s = t_s;
    b->acceleration_m_s2 = (struct ap_plane2){0, 0};
    b->turn_rate_rad_s2 = (struct ap_vec3){0, 0, 0};
    b->straight = true;
    begin_spin(ph, b);
    struct ap_plane2 slip = ap_slip_of(ph, b);
    double slip_speed = ap_plane2_length(slip), speed = ap_plane2_length(b->velocity_m_s);
    bool friction = ph->params.slide_friction > 0;
    if (slip_speed > no_slip_m_s && (friction || speed > 0)) {
        begin_slide(ph, b, slip, slip_speed);
    } else if (speed > no_slip_m_s || (!friction && speed > 0)) {
        begin_roll(ph, b, speed);
    } else {
        b->velocity_m_s = (struct ap_plane2){0, 0};
        if (friction)
            b->turn_rad_s.x = b->turn_rad_s.z = 0;
        bool spins = b->turn_rate_rad_s2.y != 0;
        b->state = spins ? AP_BALL_SPINNING : AP_BALL_AT_REST;
        b->t_end_s = spins ? t_s + fabs(b->turn_rad_s.y / b->turn_rate_rad_s2.y) : INFINITY;
    }
    b->straight = find_line(b);
    if (!b->straight)
        begin_series(ph, b);
}

bool ap_segment_slip_ends(const struct ap_physics *ph, const struct ap_ball *b) {
    return ap_plane2_length(ap_slip_of(ph, b)) < 1e-9;
}

static void series_at(const struct ap_ball *b, double t, struct ap_plane_frame *g) {
    double sum[12];
    memcpy(sum, b->series[b->terms - 1], sizeof sum);
    for (int k = b->terms - 2; k >= 0; k--)
        for (int i = 0; i < 12; i++) // four at a time where the machine can
            sum[i] = sum[i] * t + b->series[k][i];
    memcpy(g->m, sum, sizeof g->m);
}

// Way along the line at t, and the speed along it.
static double way_at(const struct ap_ball *b, double t, double *speed) {
    double v = ap_plane2_dot(b->velocity_m_s, b->along);
    double a = ap_plane2_dot(b->acceleration_m_s2, b->along);
    *speed = v + a * t;
    return (v + 0.5 * a * t) * t;
}

void ap_segment_at(const struct ap_physics *ph, const struct ap_ball *b, double t_s,
                   struct ap_plane3 *foot, struct ap_plane3 *velocity) {
    struct ap_space space = ph->shape.space;
    double rho = space.rho_m, t = t_s - b->t0_s;
    const struct ap_plane_frame *f = &b->world_from_foot;
    if (!ap_ball_moves(b)) {
        *foot = ap_plane_foot(f, rho);
        *velocity = (struct ap_plane3){0, 0, 0};
    } else if (b->straight) {
        double speed, way = way_at(b, t, &speed) / rho;
        double c, s;
        if (space.kappa > 0) {
            sincos(way, &s, &c); // the hottest line of s3: one reduction for both
        } else {
            c = ap_space_cos(space, way);
            s = ap_space_sin(space, way);
        }
        *foot = ap_plane_apply(
            f, (struct ap_plane3){rho * s * b->along.x, rho * s * b->along.z, rho * c});
        *velocity =
            ap_plane_apply(f, (struct ap_plane3){speed * c * b->along.x, speed * c * b->along.z,
                                                 -space.kappa * speed * s});
    } else {
        struct ap_plane_frame g;
        series_at(b, t, &g);
        struct ap_plane2 v = ap_plane2_add(b->velocity_m_s, t, b->acceleration_m_s2);
        struct ap_plane3 local = {v.x, v.z, 0};
        *foot = ap_plane_apply(f, ap_plane_foot(&g, rho));
        *velocity = ap_plane_apply(f, ap_plane_apply(&g, local));
    }
}

static double length_of(struct ap_vec3 v) {
    return sqrt(ap_vec3_dot(v, v));
}

static struct ap_quat axis_times(struct ap_vec3 w, struct ap_quat q) {
    return (struct ap_quat){w.x * q.w + w.y * q.z - w.z * q.y, w.y * q.w + w.z * q.x - w.x * q.z,
                            w.z * q.w + w.x * q.y - w.y * q.x, -w.x * q.x - w.y * q.y - w.z * q.z};
}

// q' = ½·(w0 + w1·t)∘q over t: the series of an entire function, in steps of at most 1.5 rad.
static struct ap_quat turn_series(struct ap_vec3 w0, struct ap_vec3 w1, double t,
                                  struct ap_quat q) {
    enum { TERMS = 19 };
    double most = fmax(length_of(w0), length_of(ap_vec3_add(w0, ap_vec3_scale(t, w1))));
    int steps = 1 + (int)fmin(1e6, (most * t + length_of(w1) * t * t * 0.1) / 1.5);
    double h = t / steps;
    for (int i = 0; i < steps; i++) {
        struct ap_vec3 a = ap_vec3_scale(0.5 * h, ap_vec3_add(w0, ap_vec3_scale(i * h, w1)));
        struct ap_vec3 b = ap_vec3_scale(0.5 * h * h, w1);
        struct ap_quat before = {0, 0, 0, 0}, term = q;
        for (int k = 0; k < TERMS; k++) {
            struct ap_quat p = axis_times(a, term), r = axis_times(b, before);
            double f = 1.0 / (k + 1);
            before = term;
            term = (struct ap_quat){f * (p.x + r.x), f * (p.y + r.y), f * (p.z + r.z),
                                    f * (p.w + r.w)};
            q = (struct ap_quat){q.x + term.x, q.y + term.y, q.z + term.z, q.w + term.w};
        }
        q = ap_quat_normalize(q);
    }
    return q;
}

// Turned by w0 + w1·t over t.
static struct ap_quat turned(struct ap_vec3 w0, struct ap_vec3 w1, double t, struct ap_quat q) {
    struct ap_vec3 whole = ap_vec3_add(ap_vec3_scale(t, w0), ap_vec3_scale(0.5 * t * t, w1));
    double cross = length_of(ap_vec3_cross(w0, w1));
    if (cross > 1e-13 * length_of(w0) * length_of(w1))
        return turn_series(w0, w1, t, q);
    double angle = length_of(whole);
    if (!(angle > 0))
        return q;
    struct ap_vec3 axis = ap_vec3_scale(1 / angle, whole);
    return ap_quat_normalize(ap_quat_mul(ap_quat_from_axis_angle(axis, angle), q));
}

// The turn about the ball's centre in the foot's frame: what rolls at Omega about the point of
// contact turns at Omega/cos_kappa(s/rho) about its centre against a frame that goes with the foot.
static void commit_turn(const struct ap_physics *ph, struct ap_ball *b, double t) {
    struct ap_space space = ph->shape.space;
    double c = 1 / ap_space_cos(space, ph->params.ball_radius_m / space.rho_m);
    struct ap_vec3 w0 = b->turn_rad_s, w1 = b->turn_rate_rad_s2;
    w0.x *= c;
    w0.z *= c;
    w1.x *= c;
    w1.z *= c;
    // Vertical spin stops earlier than the rest, and never turns round.
    double spins = w1.y != 0 ? fmin(t, -w0.y / w1.y) : t;
    b->foot_from_ball = turned(w0, w1, spins, b->foot_from_ball);
    if (spins < t) {
        w0 = ap_vec3_add(w0, ap_vec3_scale(spins, w1));
        w0.y = w1.y = 0;
        b->foot_from_ball = turned(w0, w1, t - spins, b->foot_from_ball);
    }
    struct ap_vec3 end = ap_vec3_add(b->turn_rad_s, ap_vec3_scale(t, b->turn_rate_rad_s2));
    if (spins < t || end.y * b->turn_rad_s.y <= 0)
        end.y = b->turn_rate_rad_s2.y != 0 ? 0 : b->turn_rad_s.y;
    b->turn_rad_s = end;
}

void ap_segment_commit(const struct ap_physics *ph, struct ap_ball *b, double t_s) {
    double t = t_s - b->t0_s;
    if (!(t > 0))
        return;
    if (ap_ball_moves(b)) {
        struct ap_plane_frame g;
        if (b->straight) {
            double speed, way = way_at(b, t, &speed);
            struct ap_plane2 v = {way * b->along.x, way * b->along.z};
            g = ap_plane_translate(ph->shape.space, v);
        } else {
            series_at(b, t, &g);
        }
        b->world_from_foot = ap_plane_mul(&b->world_from_foot, &g);
        ap_plane_orthonormalize(ph->shape.space.kappa, &b->world_from_foot);
        b->velocity_m_s = ap_plane2_add(b->velocity_m_s, t, b->acceleration_m_s2);
    }
    commit_turn(ph, b, t);
    b->t0_s = t_s;
}
