// The event-driven solver: a break shot's cost in the three spaces, and run time against error
// beside a time-stepping one that has the same contacts and friction. CSV on standard output:
// what,space,step_s,cpu_ms,error_m. docs/physics.gnuplot draws it.
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "src/game/contact.h"
#include "src/game/rack.h"
#include "src/game/segment.h"

static double cpu_ms(void) {
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return (double)t.tv_sec * 1e3 + (double)t.tv_nsec * 1e-6;
}

static int ascending(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static void open_table(int kappa, bool pockets, struct ap_physics *ph) {
    struct ap_table_shape shape = ap_table_from_edge(kappa, 0.9, 1);
    struct ap_physics_params params = {.no_pockets = !pockets};
    struct ap_error err;
    if (ap_physics_init(&err, &shape, &params, ph)) {
        fprintf(stderr, "%s\n", err.text);
        exit(1);
    }
}

static void time_break(int kappa, bool pockets) {
    enum { RUNS = 301 };
    static struct ap_physics first, ph;
    static double ms[RUNS];
    struct ap_error err;
    open_table(kappa, pockets, &first);
    if (ap_rack_set(&err, &first, AP_GAME_EIGHT))
        exit(1);
    struct ap_strike s = {.speed_m_s = 6, .above = 0.1};
    s.direction = ap_physics_toward(&first, 0, 1);
    for (int i = 0; i < RUNS; i++) {
        ph = first;
        double t = cpu_ms();
        ap_physics_strike(&err, &ph, 0, &s);
        ap_physics_advance(&ph, 60, NULL, NULL);
        ms[i] = cpu_ms() - t;
    }
    qsort(ms, RUNS, sizeof *ms, ascending);
    printf("break%s,%s,,%.4f,\n", pockets ? "" : "-no-pockets", ap_space_name(first.shape.space),
           ms[RUNS / 2]);
    fprintf(stderr, "%s%s: %llu events, %llu bounds made better, %.1f s played\n",
            ap_space_name(first.shape.space), pockets ? "" : " without pockets", ph.counters.events,
            ph.counters.tries, ph.changed_s);
}

// Five balls and a shot that meets some of them and the cushions; turned by `turn` about the
// centre.
static void set_shot(int kappa, double turn, struct ap_physics *ph) {
    static const double at[5][2] = {
        {0.02, 0.2}, {0.03, -0.05}, {-0.1, -0.1}, {0.12, 0.05}, {-0.08, 0.12}};
    struct ap_error err;
    open_table(kappa, false, ph);
    double c = cos(turn), s = sin(turn);
    for (int i = 0; i < 5; i++)
        if (ap_physics_place(
                &err, ph, i,
                (struct ap_plane2){c * at[i][0] + s * at[i][1], c * at[i][1] - s * at[i][0]})) {
            fprintf(stderr, "%s\n", err.text);
            exit(1);
        }
    struct ap_strike shot = {
        .direction = ap_physics_toward(ph, 0, 1), .speed_m_s = 1, .right = 0.2, .above = 0.1};
    ap_physics_strike(&err, ph, 0, &shot);
}

static const double until_s = 1.5;

// A step of a ball by the midpoint of its velocity.
static void step_ball(struct ap_physics *ph, struct ap_ball *b, double h) {
    struct ap_plane2 v0 = b->velocity_m_s, slip = ap_slip_of(ph, b), a = {0, 0};
    double g = ph->params.gravity_m_s2, R = ph->rolling_radius_m, u = ap_plane2_length(slip);
    double fade = 2.5 * ph->params.spin_friction * g / R * h;
    b->turn_rad_s.y =
        fabs(b->turn_rad_s.y) > fade ? b->turn_rad_s.y - copysign(fade, b->turn_rad_s.y) : 0;
    double slide = ph->params.slide_friction * g, roll = ph->params.roll_friction * g;
    struct ap_plane2 q = ap_rolling_of(b->turn_rad_s);
    if (u > 3.5 * slide * h) {
        a = (struct ap_plane2){-slide * slip.x / u, -slide * slip.z / u};
        b->velocity_m_s = ap_plane2_add(v0, h, a);
        ap_rolling_set(&b->turn_rad_s, ap_plane2_add(q, -2.5 / R * h, a));
    } else {
        // What slip is left is taken at once, then it rolls.
        struct ap_plane2 v = ap_plane2_add(v0, -2.0 / 7, slip), zero = {0, 0};
        double speed = ap_plane2_length(v);
        b->velocity_m_s = speed > roll * h ? ap_plane2_add(v, -roll * h / speed, v) : zero;
        ap_rolling_set(&b->turn_rad_s, ap_plane2_add(zero, 1 / R, b->velocity_m_s));
    }
    struct ap_plane2 way = {(v0.x + b->velocity_m_s.x) * h / 2, (v0.z + b->velocity_m_s.z) * h / 2};
    struct ap_plane_frame move = ap_plane_translate(ph->shape.space, way);
    b->world_from_foot = ap_plane_mul(&b->world_from_foot, &move);
    ap_plane_orthonormalize(ph->shape.space.kappa, &b->world_from_foot);
}

static void nobody(void *data, const struct ap_touch *touch) {
    (void)data;
    (void)touch;
}

static void step_contacts(struct ap_physics *ph) {
    double rho = ph->shape.space.rho_m;
    struct ap_plane3 foot[AP_BALLS_MAX];
    for (int i = 0; i < ph->ball_count; i++) {
        struct ap_ball *b = &ph->ball[i];
        foot[i] = ap_plane_foot(&b->world_from_foot, rho);
        for (int k = 0; k < ph->edge_count; k++) {
            const struct ap_plane3 *e = &ph->edge[k];
            if (e->x * foot[i].x + e->z * foot[i].z + e->w * foot[i].w >= ph->edge_height_m)
                continue;
            const struct ap_plane_frame *f = &b->world_from_foot;
            struct ap_plane2 n = {-(e->x * f->m[0][0] + e->z * f->m[1][0] + e->w * f->m[2][0]),
                                  -(e->x * f->m[0][1] + e->z * f->m[1][1] + e->w * f->m[2][1])};
            double size = ap_plane2_length(n);
            n = (struct ap_plane2){n.x / size, n.z / size};
            if (ap_plane2_dot(b->velocity_m_s, n) > 0)
                ap_cushion_resolve(ph, b, n);
        }
        for (int j = 0; j < i; j++) {
            struct ap_touch touch = {.i = j, .j = i};
            if (ap_plane_chord2(ph->shape.space.kappa, foot[i], foot[j]) >= ph->touch_m2)
                continue;
            ap_touch_measure(ph, &touch);
            if (touch.closing_m_s > 0)
                ap_touches_resolve(ph, &touch, 1, nobody, NULL);
        }
    }
}

static double farthest(const struct ap_physics *a, const struct ap_physics *b, double turn) {
    double most = 0, c = cos(turn), s = sin(turn);
    for (int i = 0; i < a->ball_count; i++) {
        struct ap_plane3 p = ap_physics_motion(a, i, a->now_s).foot_m;
        struct ap_plane3 q = ap_physics_motion(b, i, b->now_s).foot_m;
        struct ap_plane3 back = {c * q.x - s * q.z, s * q.x + c * q.z, q.w};
        most = fmax(most, sqrt(fmax(0, ap_plane_chord2(a->shape.space.kappa, p, back))));
    }
    return most;
}

static void compare(int kappa) {
    static struct ap_physics exact, turned, ph;
    set_shot(kappa, 0, &exact);
    double turn = 2 * M_PI / exact.shape.sides;
    set_shot(kappa, turn, &turned);
    ap_physics_advance(&turned, until_s, NULL, NULL);
    enum { RUNS = 101 };
    double ms[RUNS];
    struct ap_physics first = exact;
    for (int i = 0; i < RUNS; i++) {
        exact = first;
        double t = cpu_ms();
        ap_physics_advance(&exact, until_s, NULL, NULL);
        ms[i] = cpu_ms() - t;
    }
    qsort(ms, RUNS, sizeof *ms, ascending);
    const char *space = ap_space_name(exact.shape.space);
    // The table's own symmetry: the same shot a corner further, whose roundings are others.
    printf("events,%s,,%.5f,%.3g\n", space, ms[RUNS / 2], farthest(&exact, &turned, turn));
    fprintf(stderr, "%s: %llu events in %.1f s\n", space, exact.counters.events, until_s);
    for (double h = 1e-2; h > 2e-6; h /= sqrt(10)) {
        long steps = lround(until_s / h);
        ph = first;
        double t = cpu_ms();
        for (long k = 0; k < steps; k++) {
            for (int i = 0; i < ph.ball_count; i++)
                step_ball(&ph, &ph.ball[i], until_s / (double)steps);
            step_contacts(&ph);
        }
        t = cpu_ms() - t;
        for (int i = 0; i < ph.ball_count; i++) { // as they stand
            ph.ball[i].state = AP_BALL_AT_REST;
            ph.ball[i].t0_s = ph.now_s = 0;
        }
        printf("steps,%s,%.3g,%.4f,%.3g\n", space, h, t, farthest(&exact, &ph, 0));
    }
}

int main(void) {
    printf("what,space,step_s,cpu_ms,error_m\n");
    for (int kappa = 1; kappa >= -1; kappa--) {
        time_break(kappa, true);
        time_break(kappa, false);
        compare(kappa);
    }
    return 0;
}
