#include "src/device/walk_script.h"

#include <math.h>

#include "src/device/walk_path.h"

// What lies wholly before or behind is left out below: it adds exactly nothing.

double ap_walk_ramp(double t, double from, double ramp) {
    if (t <= from)
        return 0;
    double x = (t - from) / ramp;
    return x >= 1 ? 1 : x * x * x * (x * (6 * x - 15) + 10);
}

// 0, then 1 from `on` + ramp to `off`, then 0 from `off` + ramp.
static double pulse(double t, double on, double off, double ramp) {
    return ap_walk_ramp(t, on, ramp) - ap_walk_ramp(t, off, ramp);
}

// The way covered since `from` by somebody who speeds up to 1 with the same quintic.
static double ramp_way(double t, double from, double ramp) {
    if (t <= from)
        return 0;
    double x = (t - from) / ramp;
    if (x >= 1)
        return ramp * (x - 0.5);
    return ramp * x * x * x * x * (x * (x - 3) + 2.5);
}

// A stretch of walking, and how long the person stays behind it.
struct leg {
    double to_u;
    double speed_m_s, ramp_s;
    double stay_s;
};

enum { FIRST, ON, BACK, LAST, LEG_COUNT };

static const double START_U = 0.35, FIRST_STAY_S = 0.7;

static const struct leg legs[LEG_COUNT] = {
    [FIRST] = {1.5, 0.9, 0.9, 4.6},  // aims over edge 1
    [ON] = {2.8, 0.92, 0.9, 1.3},    // looks about the room
    [BACK] = {2.45, 0.5, 0.6, 0.3},  // a step back along the same edge
    [LAST] = {4.35, 0.95, 0.9, 4.7}, // round the corner where the first lap ends; aims again
};

struct times {
    double from[LEG_COUNT], to[LEG_COUNT], end;
};

static struct times schedule(double edge_m) {
    struct times times;
    double t = FIRST_STAY_S, u = START_U;
    for (int i = 0; i < LEG_COUNT; i++) {
        double way_m = fabs(legs[i].to_u - u) * ap_walk_path_edge_length_m(edge_m);
        times.from[i] = t;
        times.to[i] = t + way_m / legs[i].speed_m_s + legs[i].ramp_s;
        t = times.to[i] + legs[i].stay_s;
        u = legs[i].to_u;
    }
    times.end = t;
    return times;
}

double ap_walk_script_duration_s(double edge_m) {
    return schedule(edge_m).end;
}

static void walk_legs(const struct times *at, double edge_m, double t, struct ap_walk_state *s) {
    double u = START_U, before_u = START_U;
    for (int i = 0; i < LEG_COUNT && t > at->from[i]; i++) {
        const struct leg *leg = &legs[i];
        double brake = at->to[i] - leg->ramp_s;
        double way_s = ramp_way(t, at->from[i], leg->ramp_s) - ramp_way(t, brake, leg->ramp_s);
        double sign = leg->to_u > before_u ? 1 : -1;
        u += sign * way_s * leg->speed_m_s / ap_walk_path_edge_length_m(edge_m);
        s->pace += pulse(t, at->from[i], brake, leg->ramp_s);
        before_u = leg->to_u;
    }
    s->u = u;
}

// One bend over the edge from the time `a`: down, three strokes, the hit, up again.
static void aim(double a, double t, struct ap_walk_state *s) {
    if (t <= a || t >= a + 4.5)
        return;
    s->bend += pulse(t, a, a + 2.9, 1.45);
    double hold = pulse(t, a + 1.3, a + 2.4, 0.4);
    s->stroke += 0.6 * hold * sin(2 * M_PI * 1.5 * (t - a - 1.3));
    s->stroke += pulse(t, a + 2.55, a + 2.85, 0.25);
    s->trigger += pulse(t, a + 1.5, a + 2.7, 0.2);
    s->select |= t >= a + 2.6 && t < a + 2.8;
}

static double mix(double from, double to, double part) {
    return from + part * (to - from);
}

// Turns the attention to another thing.
static void attend(struct ap_walk_state *s, double table, double way, double shot, double part) {
    if (part == 0)
        return;
    s->on_table = mix(s->on_table, table, part);
    s->on_way = mix(s->on_way, way, part);
    s->on_shot = mix(s->on_shot, shot, part);
}

// While walking: mostly where it goes, with a look at the table in every other second.
static void look_while_walking(double from, double to, double t, struct ap_walk_state *s) {
    attend(s, 0, 1, 0, ap_walk_ramp(t, from - 0.2, 0.7));
    for (double k = from + 0.9; k + 1.2 < to && t > k; k += 2.1) {
        attend(s, 1, 0, 0, ap_walk_ramp(t, k, 0.5));
        attend(s, 0, 1, 0, ap_walk_ramp(t, k + 1.0, 0.55));
    }
    attend(s, 1, 0, 0, ap_walk_ramp(t, to - 0.7, 0.7));
}

static void look_about(double a, double t, struct ap_walk_state *s) {
    s->glance_yaw_rad += 0.75 * pulse(t, a, a + 0.9, 0.65);
    s->glance_yaw_rad -= 0.9 * pulse(t, a + 1.1, a + 2.0, 0.8);
    s->glance_pitch_rad += 0.62 * pulse(t, a, a + 2.1, 0.7);
}

struct ap_walk_state ap_walk_script_at(double edge_m, double t_s) {
    struct times at = schedule(edge_m);
    double laps = floor(t_s / at.end), t = t_s - laps * at.end;
    struct ap_walk_state s = {.on_table = 1};
    walk_legs(&at, edge_m, t, &s);
    s.u += 4 * laps;
    aim(at.to[FIRST] - 0.1, t, &s);
    aim(at.to[LAST] - 0.1, t, &s);
    s.facing = 1;
    const int walked[] = {FIRST, ON, LAST};
    for (int i = 0; i < 3; i++) {
        double from = at.from[walked[i]], to = at.to[walked[i]];
        s.facing -= pulse(t, from - 0.35, to - 1.0, 1.15);
        look_while_walking(from, to, t, &s);
        s.touch += pulse(t, from + 1.0, to - 1.1, 0.8);
    }
    for (int i = 0; i < 2; i++) {
        double a = at.to[i == 0 ? FIRST : LAST] - 0.1;
        attend(&s, 0, 0, 1, ap_walk_ramp(t, a + 0.4, 0.9));
        attend(&s, 1, 0, 0, ap_walk_ramp(t, a + 3.0, 0.9));
    }
    look_about(at.to[ON] - 0.5, t, &s);
    return s;
}
