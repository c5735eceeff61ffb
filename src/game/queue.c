#include "src/game/queue.h"

#include <string.h>

#include "src/game/contact.h"
#include "src/game/segment.h"

// Contact: as near as rounding lets the chord² of touching be known; and for what touches in the
// same moment.
static const double touch_tolerance = 1e-13, together_tolerance = 1e-9;

// What touches and parts is not looked at again before this; until then it cannot come nearer than
// by ½·M of its square, 1e-17 m².
static const double least_step_s = 1e-9;

// Inline, of numbers that are numbers.
static double least(double a, double b) {
    return a < b ? a : b;
}

static double most(double a, double b) {
    return a > b ? a : b;
}

void ap_queue_clear(struct ap_physics *ph) {
    for (int i = 0; i < AP_BALLS_MAX; i++) {
        for (int j = 0; j < AP_BALLS_MAX; j++)
            ph->pair_s[i][j] = INFINITY;
        ph->cushion_s[i] = ph->pocket_s[i] = ph->row_s[i] = INFINITY;
    }
}

struct moment {
    struct ap_plane3 foot, velocity;
    double speed, acceleration; // upper bounds until the segment ends
};

static struct moment moment_of(const struct ap_physics *ph, int ball, double t_s) {
    const struct ap_ball *b = &ph->ball[ball];
    struct moment m = {.acceleration = 0};
    ap_segment_at(ph, b, t_s, &m.foot, &m.velocity);
    if (ap_ball_moves(b)) {
        m.acceleration = ap_plane2_length(b->acceleration_m_s2);
        m.speed = ap_plane2_length(b->velocity_m_s);
        if (b->state == AP_BALL_SLIDING && m.acceleration > 0)
            m.speed =
                most(m.speed, ap_plane2_length(ap_plane2_add(b->velocity_m_s, b->t_end_s - b->t0_s,
                                                             b->acceleration_m_s2)));
    }
    return m;
}

// The first x > 0 at which f + slope·x − ½·M·x² can be zero.
static double first_root(double f, double slope, double M) {
    f = most(f, 0);
    double root = sqrt(slope * slope + 2 * M * f);
    if (slope < 0)
        return 2 * f / (root - slope);
    return M > 0 ? (slope + root) / M : INFINITY;
}

// Bounds −d²/dt² of a chord² to something that may move too. <d, a> is at most |a|·rho·sin(D/rho);
// in s3 the surface bends away by chord²·v²/rho² more.
static double chord_bend(const struct ap_physics *ph, double accelerations, double speeds2) {
    double rho = ph->shape.space.rho_m, bend = 2 * accelerations * ph->lever_m;
    return ph->shape.space.kappa > 0 ? bend + ph->longest_m2 * speeds2 / (rho * rho) : bend;
}

struct chord {
    double over, slope, bend; // chord² − limit and its derivatives
};

static struct chord pair_chord(const struct ap_physics *ph, const struct moment *a,
                               const struct moment *b) {
    int kappa = ph->shape.space.kappa;
    struct ap_plane3 d = {a->foot.x - b->foot.x, a->foot.z - b->foot.z, a->foot.w - b->foot.w};
    struct ap_plane3 v = {a->velocity.x - b->velocity.x, a->velocity.z - b->velocity.z,
                          a->velocity.w - b->velocity.w};
    return (struct chord){.over = ap_plane_dot(kappa, d, d) - ph->touch_m2,
                          .slope = 2 * ap_plane_dot(kappa, d, v),
                          .bend = chord_bend(ph, a->acceleration + b->acceleration,
                                             a->speed * a->speed + b->speed * b->speed)};
}

static bool in_play(const struct ap_physics *ph, int ball) {
    return ph->ball[ball].state != AP_BALL_POCKETED;
}

// Past the end of either's segment it is looked at again anyway.
static double until_end(const struct ap_physics *ph, int i, int j, double t_s) {
    return t_s <= ph->ball[i].t_end_s && t_s <= ph->ball[j].t_end_s ? t_s : INFINITY;
}

static bool has_friction(const struct ap_physics *ph) {
    return ph->params.slide_friction > 0 || ph->params.roll_friction > 0;
}

// Whether a pair at t touches and closes (or, where there is friction, fails to part); else the
// time before which it does not.
static bool pair_step(const struct ap_physics *ph, int i, int j, const struct moment *a,
                      const struct moment *b, double t_s, double *next_s) {
    *next_s = INFINITY;
    if (!in_play(ph, i) || !in_play(ph, j) ||
        (!ap_ball_moves(&ph->ball[i]) && !ap_ball_moves(&ph->ball[j])))
        return false;
    struct chord c = pair_chord(ph, a, b);
    double tolerance = touch_tolerance * ph->touch_m2;
    if (c.over <= tolerance) {
        // Closing speed times 2·chord.
        double quiet = has_friction(ph) ? 1e-7 : -1e-12;
        if (-c.slope > -quiet * 4 * ph->rolling_radius_m)
            return true;
        *next_s = t_s + most(first_root(0, c.slope, c.bend), least_step_s);
    } else {
        *next_s = t_s + most(first_root(c.over, c.slope, c.bend), 2e-16 * t_s);
    }
    *next_s = until_end(ph, i, j, *next_s);
    return false;
}

static double dot3(struct ap_plane3 a, struct ap_plane3 b) {
    return a.x * b.x + a.z * b.z + a.w * b.w;
}

// The same of a ball and its nearest cushion; *edge is the one that is met.
static bool cushion_step(const struct ap_physics *ph, int i, const struct moment *m, double t_s,
                         int *edge, double *next_s) {
    struct ap_space space = ph->shape.space;
    *next_s = INFINITY;
    if (!in_play(ph, i) || !ap_ball_moves(&ph->ball[i]))
        return false;
    double bend = m->acceleration * ph->edge_lever +
                  (space.kappa > 0 ? m->speed * m->speed / space.rho_m : 0);
    for (int k = 0; k < ph->edge_count; k++) {
        double over = dot3(ph->edge[k], m->foot) - ph->edge_height_m;
        double slope = dot3(ph->edge[k], m->velocity);
        double step;
        if (over <= touch_tolerance * ph->rolling_radius_m) {
            double quiet = has_friction(ph) ? 1e-7 : -1e-12;
            if (-slope > -quiet) {
                *edge = k;
                return true;
            }
            step = most(first_root(0, slope, bend), least_step_s);
        } else {
            step = most(first_root(over, slope, bend), 2e-16 * t_s);
        }
        *next_s = least(*next_s, until_end(ph, i, i, t_s + step));
    }
    return false;
}

static bool pocket_step(const struct ap_physics *ph, int i, const struct moment *m, double t_s,
                        int *pocket, double *next_s) {
    int kappa = ph->shape.space.kappa;
    *next_s = INFINITY;
    if (!in_play(ph, i) || !ap_ball_moves(&ph->ball[i]))
        return false;
    double bend = chord_bend(ph, m->acceleration, m->speed * m->speed);
    for (int k = 0; k < ph->pocket_count; k++) {
        struct ap_plane3 d = {m->foot.x - ph->pocket[k].x, m->foot.z - ph->pocket[k].z,
                              m->foot.w - ph->pocket[k].w};
        double over = ap_plane_dot(kappa, d, d) - ph->capture_m2;
        double slope = 2 * ap_plane_dot(kappa, d, m->velocity);
        if (over <= touch_tolerance * ph->capture_m2) {
            *pocket = k;
            return true;
        }
        double step = most(first_root(over, slope, bend), 2e-16 * t_s);
        *next_s = least(*next_s, until_end(ph, i, i, t_s + step));
    }
    return false;
}

static void renew_row(struct ap_physics *ph, int i) {
    double first = least(ph->cushion_s[i], ph->pocket_s[i]);
    if (in_play(ph, i))
        first = least(first, ph->ball[i].t_end_s);
    for (int j = i + 1; j < ph->ball_count; j++)
        first = least(first, ph->pair_s[i][j]);
    ph->row_s[i] = first;
}

// A step that says "now" leaves now as the bound; the loop will find it.
void ap_queue_renew(struct ap_physics *ph, unsigned balls, double t_s) {
    struct moment m[AP_BALLS_MAX];
    int n = ph->ball_count, which;
    ph->changed_s = t_s;
    for (int i = 0; i < n; i++)
        if (in_play(ph, i))
            m[i] = moment_of(ph, i, t_s);
    for (int i = 0; i < n; i++) {
        if (!(balls >> i & 1))
            continue;
        for (int j = 0; j < n; j++) {
            int a = i < j ? i : j, b = i < j ? j : i;
            if (i == j || (j < i && (balls >> j & 1)))
                continue;
            if (pair_step(ph, a, b, &m[a], &m[b], t_s, &ph->pair_s[a][b]))
                ph->pair_s[a][b] = t_s;
        }
        if (cushion_step(ph, i, &m[i], t_s, &which, &ph->cushion_s[i]))
            ph->cushion_s[i] = t_s;
        if (pocket_step(ph, i, &m[i], t_s, &which, &ph->pocket_s[i]))
            ph->pocket_s[i] = t_s;
    }
    for (int i = 0; i < n; i++)
        renew_row(ph, i);
}

static void tell(struct ap_physics *ph, double t_s, enum ap_physics_kind kind, int a, int b,
                 double speed) {
    if (ph->told_count < AP_TOLD_MAX)
        ph->told[ph->told_count++] =
            (struct ap_physics_event){.t_s = t_s, .kind = kind, .a = a, .b = b, .speed_m_s = speed};
    ph->counters.events++;
}

struct told_touch {
    struct ap_physics *ph;
    double t_s;
};

static void tell_touch(void *data, const struct ap_touch *touch) {
    struct told_touch *t = data;
    tell(t->ph, t->t_s, AP_EVENT_BALLS, touch->i, touch->j, touch->closing_m_s);
}

static bool touches(const struct ap_physics *ph, const struct moment *a, const struct moment *b) {
    return ap_plane_chord2(ph->shape.space.kappa, a->foot, b->foot) <=
           ph->touch_m2 * (1 + together_tolerance);
}

// All that touches what touches i and j, i and j's own touch first.
static int gather(const struct ap_physics *ph, int i, int j, double t_s, struct ap_touch *list,
                  unsigned *balls) {
    struct moment m[AP_BALLS_MAX];
    for (int k = 0; k < ph->ball_count; k++)
        if (in_play(ph, k))
            m[k] = moment_of(ph, k, t_s);
    list[0] = (struct ap_touch){.i = i, .j = j};
    int count = 1;
    *balls = 1u << i | 1u << j;
    for (unsigned grown = 0; grown != *balls;) {
        grown = *balls;
        for (int k = 0; k < ph->ball_count; k++)
            for (int l = k + 1; l < ph->ball_count; l++) {
                bool in = (grown >> k & 1) || (grown >> l & 1);
                bool both = (grown >> k & 1) && (grown >> l & 1);
                if (in && !both && in_play(ph, k) && in_play(ph, l) && touches(ph, &m[k], &m[l]))
                    *balls |= 1u << k | 1u << l;
            }
    }
    for (int k = 0; k < ph->ball_count; k++)
        for (int l = k + 1; l < ph->ball_count && count < AP_TOUCHES_MAX; l++)
            if ((*balls >> k & 1) && (*balls >> l & 1) && !(k == i && l == j) &&
                touches(ph, &m[k], &m[l]))
                list[count++] = (struct ap_touch){.i = k, .j = l};
    return count;
}

static void meet_ball(struct ap_physics *ph, int i, int j, double t_s) {
    struct ap_touch list[AP_TOUCHES_MAX];
    struct told_touch told = {ph, t_s};
    unsigned balls;
    int count = gather(ph, i, j, t_s, list, &balls);
    for (int k = 0; k < ph->ball_count; k++)
        if (balls >> k & 1) {
            ap_segment_commit(ph, &ph->ball[k], t_s);
            ph->ball[k].t0_s = t_s;
        }
    for (int u = 0; u < count; u++)
        ap_touch_measure(ph, &list[u]);
    ap_touches_resolve(ph, list, count, tell_touch, &told);
    for (int k = 0; k < ph->ball_count; k++)
        if (balls >> k & 1)
            ap_segment_begin(ph, &ph->ball[k], t_s);
    ap_queue_renew(ph, balls, t_s);
}

static void meet_cushion(struct ap_physics *ph, int i, int edge, double t_s) {
    struct ap_ball *b = &ph->ball[i];
    ap_segment_commit(ph, b, t_s);
    const struct ap_plane3 *e = &ph->edge[edge];
    const struct ap_plane_frame *f = &b->world_from_foot;
    struct ap_plane2 n = {-(e->x * f->m[0][0] + e->z * f->m[1][0] + e->w * f->m[2][0]),
                          -(e->x * f->m[0][1] + e->z * f->m[1][1] + e->w * f->m[2][1])};
    double length = ap_plane2_length(n);
    n = (struct ap_plane2){n.x / length, n.z / length};
    double closing = ap_cushion_resolve(ph, b, n);
    tell(ph, t_s, AP_EVENT_CUSHION, i, edge, closing);
    ap_segment_begin(ph, b, t_s);
    ap_queue_renew(ph, 1u << i, t_s);
}

static void fall(struct ap_physics *ph, int i, int pocket, double t_s) {
    struct ap_ball *b = &ph->ball[i];
    ap_segment_commit(ph, b, t_s);
    tell(ph, t_s, AP_EVENT_POCKET, i, pocket, ap_plane2_length(b->velocity_m_s));
    b->state = AP_BALL_POCKETED;
    b->pocket = pocket;
    b->velocity_m_s = b->acceleration_m_s2 = (struct ap_plane2){0, 0};
    b->turn_rad_s = b->turn_rate_rad_s2 = (struct ap_vec3){0, 0, 0};
    b->t_end_s = INFINITY;
    ap_queue_renew(ph, 1u << i, t_s);
}

static void change(struct ap_physics *ph, int i, double t_s) {
    struct ap_ball *b = &ph->ball[i];
    enum ap_ball_state was = b->state;
    ap_segment_commit(ph, b, t_s);
    b->t0_s = t_s;
    if (was == AP_BALL_SLIDING && ap_segment_slip_ends(ph, b)) {
        struct ap_plane2 zero = {0, 0};
        ap_rolling_set(&b->turn_rad_s,
                       ap_plane2_add(zero, 1 / ph->rolling_radius_m, b->velocity_m_s));
    } else if (was == AP_BALL_ROLLING) {
        b->velocity_m_s = (struct ap_plane2){0, 0};
        b->turn_rad_s.x = b->turn_rad_s.z = 0;
    } else if (was == AP_BALL_SPINNING) {
        b->turn_rad_s.y = 0;
    }
    ap_segment_begin(ph, b, t_s);
    if (b->state == AP_BALL_ROLLING && was == AP_BALL_SLIDING)
        tell(ph, t_s, AP_EVENT_ROLL, i, -1, 0);
    else if (!ap_ball_moves(b) && was != AP_BALL_SPINNING)
        tell(ph, t_s, AP_EVENT_STOP, i, -1, 0);
    ap_queue_renew(ph, 1u << i, t_s);
}

// Makes row i's least bound better, or does what it stands for.
static void step_row(struct ap_physics *ph, int i, double t_s) {
    ph->counters.tries++;
    int which = 0;
    if (ph->pocket_s[i] == t_s) {
        struct moment m = moment_of(ph, i, t_s);
        if (pocket_step(ph, i, &m, t_s, &which, &ph->pocket_s[i]))
            fall(ph, i, which, t_s);
        else
            renew_row(ph, i);
        return;
    }
    for (int j = i + 1; j < ph->ball_count; j++) {
        if (ph->pair_s[i][j] != t_s)
            continue;
        struct moment a = moment_of(ph, i, t_s), b = moment_of(ph, j, t_s);
        if (pair_step(ph, i, j, &a, &b, t_s, &ph->pair_s[i][j]))
            meet_ball(ph, i, j, t_s);
        else
            renew_row(ph, i);
        return;
    }
    if (ph->cushion_s[i] == t_s) {
        struct moment m = moment_of(ph, i, t_s);
        if (cushion_step(ph, i, &m, t_s, &which, &ph->cushion_s[i]))
            meet_cushion(ph, i, which, t_s);
        else
            renew_row(ph, i);
        return;
    }
    change(ph, i, t_s);
}

bool ap_physics_next(struct ap_physics *ph, double until_s, struct ap_physics_event *event) {
    for (;;) {
        if (ph->told_next < ph->told_count) {
            *event = ph->told[ph->told_next++];
            ph->now_s = most(ph->now_s, event->t_s);
            return true;
        }
        ph->told_count = ph->told_next = 0;
        int first = 0;
        for (int i = 1; i < ph->ball_count; i++)
            if (ph->row_s[i] < ph->row_s[first])
                first = i;
        double t_s = ph->ball_count > 0 ? ph->row_s[first] : INFINITY;
        if (!(t_s <= until_s)) {
            ph->now_s = most(ph->now_s, until_s);
            return false;
        }
        step_row(ph, first, t_s);
    }
}

void ap_physics_advance(struct ap_physics *ph, double until_s,
                        void (*seen)(void *data, const struct ap_physics_event *event),
                        void *data) {
    struct ap_physics_event event;
    while (ap_physics_next(ph, until_s, &event))
        if (seen)
            seen(data, &event);
}
