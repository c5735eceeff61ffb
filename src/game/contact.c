#include "src/game/contact.h"

#include "src/game/segment.h"

const double ap_least_parting_m_s = 1e-3;

// Slower approaches than this are rounding.
static const double no_closing_m_s = 1e-12;

static const int rounds_max = 200;

void ap_touch_measure(const struct ap_physics *ph, struct ap_touch *touch) {
    int kappa = ph->shape.space.kappa;
    double rho = ph->shape.space.rho_m;
    const struct ap_ball *a = &ph->ball[touch->i], *b = &ph->ball[touch->j];
    struct ap_plane3 p = ap_plane_foot(&a->world_from_foot, rho);
    struct ap_plane3 q = ap_plane_foot(&b->world_from_foot, rho);
    struct ap_plane3 d = {q.x - p.x, q.z - p.z, q.w - p.w}, back = {-d.x, -d.z, -d.w};
    struct ap_plane2 n = ap_plane_local(kappa, &a->world_from_foot, d);
    struct ap_plane2 m = ap_plane_local(kappa, &b->world_from_foot, back);
    double nn = ap_plane2_length(n), mm = ap_plane2_length(m);
    touch->n_i = (struct ap_plane2){n.x / nn, n.z / nn};
    touch->n_j = (struct ap_plane2){m.x / mm, m.z / mm};
    touch->closing_m_s =
        ap_plane2_dot(a->velocity_m_s, touch->n_i) + ap_plane2_dot(b->velocity_m_s, touch->n_j);
}

static bool has_friction(const struct ap_physics *ph) {
    return ph->params.slide_friction > 0 || ph->params.roll_friction > 0;
}

// Where nothing parts any more: what makes the ball push on towards n is taken from its turn.
static void stop_pushing(const struct ap_physics *ph, struct ap_ball *b, struct ap_plane2 n) {
    struct ap_plane2 rolling = ap_rolling_of(b->turn_rad_s);
    double more =
        ap_plane2_dot(rolling, n) - ap_plane2_dot(b->velocity_m_s, n) / ph->rolling_radius_m;
    if (more > 0)
        ap_rolling_set(&b->turn_rad_s, ap_plane2_add(rolling, -more, n));
}

// What friction at a contact toward n works on, per unit of impulse along the felt (side) and up:
// the body's velocity there is side·V_s + twist·(turn about n) − arm·(turn about up) sideways, and
// R·(turn about the side) upward. V_s is the foot's velocity along n × up.
struct grip {
    double side, twist, arm, R, mass, inertia;
};

static struct grip grip_of(const struct ap_physics *ph) {
    double rho = ph->shape.space.rho_m, R = ph->rolling_radius_m, tau = R / rho;
    int kappa = ph->shape.space.kappa;
    double g2 = 1 - kappa * tau * tau, m = ph->params.ball_mass_kg;
    return (struct grip){.side = g2,
                         .twist = kappa * R * tau * tau,
                         .arm = R * sqrt(g2),
                         .R = R,
                         .mass = m,
                         .inertia = 0.4 * m * R * R};
}

static void grip_velocity(const struct grip *g, const struct ap_ball *b, struct ap_plane2 n,
                          double *along, double *up) {
    struct ap_plane2 s = ap_plane2_side(n), turn = {b->turn_rad_s.x, b->turn_rad_s.z};
    *along = g->side * ap_plane2_dot(b->velocity_m_s, s) + g->twist * ap_plane2_dot(turn, n) -
             g->arm * b->turn_rad_s.y;
    *up = g->R * ap_plane2_dot(turn, s);
}

// An impulse on the body at the contact, newton seconds, sideways and up.
static void grip_push(const struct grip *g, struct ap_ball *b, struct ap_plane2 n, double along,
                      double up) {
    struct ap_plane2 s = ap_plane2_side(n);
    b->velocity_m_s = ap_plane2_add(b->velocity_m_s, g->side * along / g->mass, s);
    double about_n = g->twist * along / g->inertia, about_s = g->R * up / g->inertia;
    b->turn_rad_s.x += about_n * n.x + about_s * s.x;
    b->turn_rad_s.z += about_n * n.z + about_s * s.z;
    b->turn_rad_s.y -= g->arm * along / g->inertia;
}

// How much of one newton second along (along, up), a unit vector, comes back as velocity, of one
// body.
static double grip_ease(const struct grip *g, double along, double up) {
    double a = g->side * g->side / g->mass + (g->twist * g->twist + g->arm * g->arm) / g->inertia;
    return a * along * along + g->R * g->R / g->inertia * up * up;
}

// The friction of one touch, its normal impulse known: Coulomb's, along the slip there was, at most
// what ends the slip. Both sides of it, so that what a round does does not hang on its order.
struct rub {
    double along, up;
};

static struct rub rub_of(double mu, double normal, double slip_along, double slip_up,
                         double ease_of_both) {
    double slip = hypot(slip_along, slip_up);
    if (!(slip > 0) || !(mu > 0))
        return (struct rub){0, 0};
    double push = fmin(mu * normal, slip / ease_of_both) / slip;
    return (struct rub){-push * slip_along, -push * slip_up};
}

static struct rub touch_rub(const struct ap_physics *ph, const struct grip *g,
                            const struct ap_touch *t) {
    double along_i, up_i, along_j, up_j;
    grip_velocity(g, &ph->ball[t->i], t->n_i, &along_i, &up_i);
    grip_velocity(g, &ph->ball[t->j], t->n_j, &along_j, &up_j);
    // j's side points the other way.
    double along = along_i + along_j, up = up_i - up_j, slip = hypot(along, up);
    double ease = slip > 0 ? 2 * grip_ease(g, along / slip, up / slip) : 1;
    double normal = g->mass * t->impulse / sqrt(g->side);
    return rub_of(ph->params.ball_friction, normal, along, up, ease);
}

// Solves A·x = b, n×n, by elimination with pivots; A is destroyed. False where singular.
static bool solve(int n, double a[][AP_TOUCHES_MAX], double *b) {
    for (int c = 0; c < n; c++) {
        int p = c;
        for (int r = c + 1; r < n; r++)
            if (fabs(a[r][c]) > fabs(a[p][c]))
                p = r;
        if (fabs(a[p][c]) < 1e-9)
            return false;
        for (int k = 0; k < n && p != c; k++) {
            double x = a[c][k];
            a[c][k] = a[p][k];
            a[p][k] = x;
        }
        double x = b[c];
        b[c] = b[p];
        b[p] = x;
        for (int r = c + 1; r < n; r++) {
            double f = a[r][c] / a[c][c];
            for (int k = c; k < n; k++)
                a[r][k] -= f * a[c][k];
            b[r] -= f * b[c];
        }
    }
    for (int r = n - 1; r >= 0; r--) {
        for (int k = r + 1; k < n; k++)
            b[r] -= a[r][k] * b[k];
        b[r] /= a[r][r];
    }
    return true;
}

// How much an impulse of 1 m/s at touch v slows the closing of touch u.
static double coupling(const struct ap_touch *u, const struct ap_touch *v) {
    double sum = 0;
    if (u->i == v->i)
        sum += ap_plane2_dot(u->n_i, v->n_i);
    if (u->i == v->j)
        sum += ap_plane2_dot(u->n_i, v->n_j);
    if (u->j == v->i)
        sum += ap_plane2_dot(u->n_j, v->n_i);
    if (u->j == v->j)
        sum += ap_plane2_dot(u->n_j, v->n_j);
    return sum;
}

// The speed at which it parts.
static double parting(const struct ap_physics *ph, double restitution, double closing) {
    double v = restitution * closing;
    return has_friction(ph) ? fmax(v, ap_least_parting_m_s) : v;
}

// Impulses of those that close; one that would have to pull is left out, and the rest again.
static void find_impulses(const struct ap_physics *ph, struct ap_touch **active, int count) {
    double a[AP_TOUCHES_MAX][AP_TOUCHES_MAX], x[AP_TOUCHES_MAX];
    double e = ph->params.ball_restitution;
    if (count == 1) {
        active[0]->impulse = (active[0]->closing_m_s + parting(ph, e, active[0]->closing_m_s)) / 2;
        return;
    }
    bool out[AP_TOUCHES_MAX] = {false};
    for (int tries = 0; tries < count; tries++) {
        int index[AP_TOUCHES_MAX], n = 0;
        for (int u = 0; u < count; u++)
            if (!out[u])
                index[n++] = u;
        for (int u = 0; u < n; u++) {
            for (int v = 0; v < n; v++)
                a[u][v] = coupling(active[index[u]], active[index[v]]);
            double closing = active[index[u]]->closing_m_s;
            x[u] = closing + parting(ph, e, closing);
        }
        if (!solve(n, a, x))
            break;
        bool pulls = false;
        for (int u = 0; u < n; u++) {
            active[index[u]]->impulse = x[u];
            if (!(x[u] >= 0)) {
                out[index[u]] = pulls = true;
                active[index[u]]->impulse = 0;
            }
        }
        if (!pulls)
            return;
    }
    // A tangle that cannot be solved at once: the fastest alone.
    int most = 0;
    for (int u = 0; u < count; u++) {
        active[u]->impulse = 0;
        if (active[u]->closing_m_s > active[most]->closing_m_s)
            most = u;
    }
    active[most]->impulse =
        (active[most]->closing_m_s + parting(ph, e, active[most]->closing_m_s)) / 2;
}

static void apply(struct ap_physics *ph, const struct grip *g, const struct ap_touch *t,
                  struct rub rub) {
    struct ap_ball *a = &ph->ball[t->i], *b = &ph->ball[t->j];
    a->velocity_m_s = ap_plane2_add(a->velocity_m_s, -t->impulse, t->n_i);
    b->velocity_m_s = ap_plane2_add(b->velocity_m_s, -t->impulse, t->n_j);
    grip_push(g, a, t->n_i, rub.along, rub.up);
    grip_push(g, b, t->n_j, rub.along, -rub.up);
    bool rests =
        has_friction(ph) && ph->params.ball_restitution * t->closing_m_s < ap_least_parting_m_s;
    if (rests) {
        stop_pushing(ph, a, t->n_i);
        stop_pushing(ph, b, t->n_j);
    }
}

void ap_touches_resolve(struct ap_physics *ph, struct ap_touch *touches, int count,
                        void (*told)(void *data, const struct ap_touch *touch), void *data) {
    struct grip g = grip_of(ph);
    for (int round = 0; round < rounds_max; round++) {
        struct ap_touch *active[AP_TOUCHES_MAX];
        struct rub rub[AP_TOUCHES_MAX];
        int n = 0;
        for (int u = 0; u < count; u++) {
            struct ap_touch *t = &touches[u];
            t->closing_m_s = ap_plane2_dot(ph->ball[t->i].velocity_m_s, t->n_i) +
                             ap_plane2_dot(ph->ball[t->j].velocity_m_s, t->n_j);
            // The first round has the one that was found; how exactly it closes is its own matter.
            if (t->closing_m_s > no_closing_m_s || (round == 0 && u == 0))
                active[n++] = t;
        }
        if (n == 0)
            return;
        ph->counters.rounds++;
        find_impulses(ph, active, n);
        for (int u = 0; u < n; u++)
            rub[u] = touch_rub(ph, &g, active[u]);
        for (int u = 0; u < n; u++) {
            if (!(active[u]->impulse > 0))
                continue;
            apply(ph, &g, active[u], rub[u]);
            told(data, active[u]);
        }
    }
}

double ap_cushion_resolve(struct ap_physics *ph, struct ap_ball *b, struct ap_plane2 n) {
    struct grip g = grip_of(ph);
    double closing = ap_plane2_dot(b->velocity_m_s, n);
    double leaves = parting(ph, ph->params.cushion_restitution, closing);
    double change = closing + leaves, along, up;
    grip_velocity(&g, b, n, &along, &up);
    double slip = hypot(along, up);
    double ease = slip > 0 ? grip_ease(&g, along / slip, up / slip) : 1;
    struct rub rub =
        rub_of(ph->params.cushion_friction, g.mass * change / sqrt(g.side), along, up, ease);
    b->velocity_m_s = ap_plane2_add(b->velocity_m_s, -change, n);
    grip_push(&g, b, n, rub.along, rub.up);
    if (leaves <= ap_least_parting_m_s && has_friction(ph))
        stop_pushing(ph, b, n);
    return closing;
}
