#include <math.h>

#include "src/game/physics.h"
#include "src/game/segment.h"

enum { POINTS_MAX = 4096 }; // between two events, of one ball

// The points of ball i after from_s and up to to_s, where `way` since the last one calls for them.
static void between(const struct ap_physics *ph, int i, double from_s, double to_s, double step_m,
                    double *way, const struct ap_path_sink *sink) {
    const struct ap_ball *b = &ph->ball[i];
    if (!ap_ball_moves(b) || !(step_m > 0))
        return;
    double v = ap_plane2_length(b->velocity_m_s), a = ap_plane2_length(b->acceleration_m_s2);
    *way += (v + a * (to_s - b->t0_s)) * (to_s - from_s);
    int n = (int)fmin(POINTS_MAX, floor(*way / step_m));
    for (int k = 1; k <= n; k++) {
        double t = from_s + (to_s - from_s) * k / n;
        sink->point(sink->data, i, t, ap_physics_motion(ph, i, t).foot_m, NULL);
    }
    if (n > 0)
        *way = 0;
}

// Not every end of a formula is an event: a long curved slide goes on by another.
static double first_end(const struct ap_physics *ph, double until_s) {
    for (int i = 0; i < ph->ball_count; i++)
        if (ph->ball[i].t_end_s > ph->now_s)
            until_s = fmin(until_s, ph->ball[i].t_end_s);
    return until_s;
}

static void tell_event(const struct ap_physics *ph, const struct ap_physics_event *e,
                       const struct ap_path_sink *sink) {
    sink->point(sink->data, e->a, e->t_s, ap_physics_motion(ph, e->a, e->t_s).foot_m, e);
    if (e->kind == AP_EVENT_BALLS)
        sink->point(sink->data, e->b, e->t_s, ap_physics_motion(ph, e->b, e->t_s).foot_m, e);
}

void ap_physics_path(const struct ap_physics *physics, double limit_s, double step_m,
                     const struct ap_path_sink *sink) {
    struct ap_physics ph = *physics, before;
    double until_s = ph.now_s + limit_s, way[AP_BALLS_MAX] = {0};
    for (int i = 0; i < ph.ball_count; i++)
        if (ap_ball_moves(&ph.ball[i]))
            sink->point(sink->data, i, ph.now_s, ap_physics_motion(&ph, i, ph.now_s).foot_m, NULL);
    for (;;) {
        struct ap_physics_event event;
        before = ph;
        if (ph.now_s >= until_s || (ap_physics_at_rest(&ph) && ph.told_next == ph.told_count))
            return;
        double end_s = first_end(&ph, until_s);
        bool more = ap_physics_next(&ph, end_s, &event);
        double to_s = more ? event.t_s : end_s;
        for (int i = 0; i < before.ball_count && to_s > before.now_s; i++)
            between(&before, i, before.now_s, to_s, step_m, &way[i], sink);
        if (more)
            tell_event(&ph, &event, sink);
    }
}
