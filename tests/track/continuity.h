#ifndef ANTIPODE_TESTS_TRACK_CONTINUITY_H
#define ANTIPODE_TESTS_TRACK_CONTINUITY_H

#include "src/geom/map.h"
#include "tests/track/support.h"

// What jumps on a billiards table, and nothing else does (shared conventions): this follows every
// device by its own reckoning of the perimeter and bounds each virtual step by the physical one.
// Between two samples the anchor slides |dc| edges along the table and the device moves by |dd|
// with respect to it; at distance D from the edge a slide is stretched by cosh(D/rho), a motion by
// sinh(D/rho)/(D/rho) at most (h3; not at all in s3 and e3).

struct follower {
    bool seen;
    struct ap_vec3 p, d; // in the table's frame; from the anchor, in the room's axes
    double c;
    struct ap_vec4 world;
};

struct continuity {
    struct ap_tracker *tracker;
    struct ap_tracker_params params;
    struct follower device[3]; // head, left, right
    double worst;              // of step/bound
    int64_t steps, flips, near_axis;
    double c_low, c_high;
};

static inline struct continuity continuity_of(const struct ap_tracker_params *params) {
    return (struct continuity){.tracker = tracker_of(params), .params = *params};
}

// Where the ray from the centre crosses the square: the perimeter in [0, 4), and the crossing.
static inline double perimeter(double edge_m, struct ap_vec3 p, struct ap_vec3 *anchor) {
    double out = fmax(fabs(p.x), fabs(p.z)), half = edge_m / 2;
    *anchor = (struct ap_vec3){p.x * half / out, 0, p.z * half / out};
    if (-p.z == out)
        return 0.5 - p.x / (2 * out) >= 0 ? 0.5 - p.x / (2 * out) : 0;
    if (-p.x == out)
        return 1.5 + p.z / (2 * out);
    return p.z == out ? 2.5 + p.x / (2 * out) : 3.5 - p.z / (2 * out);
}

static inline double nearest(double c, double reference) {
    return c + 4 * floor((reference - c) / 4 + 0.5);
}

static inline double step_bound(const struct ap_tracker_params *params, const struct follower *a,
                                const struct follower *b) {
    double slide_m = fabs(a->c - b->c) * params->table_edge_m;
    double move_m = ap_vec3_length(ap_vec3_sub(a->d, b->d));
    if (params->space.kappa == 0)
        return ap_vec3_length(ap_vec3_sub(a->p, b->p)) + 1e-9;
    if (params->space.kappa > 0)
        return slide_m + move_m + 1e-9;
    double far = fmax(ap_vec3_length(a->d), ap_vec3_length(b->d)) / params->space.rho_m;
    return slide_m * cosh(far) + move_m * sinh(far) / far + 1e-9;
}

static inline void continuity_check(struct continuity *k, int which, const struct follower *was,
                                    const struct follower *now) {
    bool near_axis = fmin(hypot(was->p.x, was->p.z), hypot(now->p.x, now->p.z)) < 0.1;
    // The segment between them may pass nearer than either.
    struct ap_vec3 way = ap_vec3_sub(now->p, was->p);
    double across = fabs(was->p.x * way.z - was->p.z * way.x), size = hypot(way.x, way.z);
    near_axis = near_axis || (size > 0.05 && across < 0.1 * size);
    if (near_axis) {
        k->near_axis++;
        return;
    }
    if (fabs(now->c - was->c) > 2) {
        k->flips++;
        if (which == 0)
            fail_msg("the head's coordinate jumped from %g to %g", was->c, now->c);
        return;
    }
    struct ap_error err;
    double step_m;
    if (ap_distance(&err, k->params.space, was->world, now->world, &step_m))
        fail_msg("%s", err.text);
    double bound_m = step_bound(&k->params, was, now);
    k->steps++;
    k->worst = fmax(k->worst, step_m / bound_m);
    if (!(step_m <= bound_m))
        fail_msg("%s: a virtual step of %.12g m, bound %.12g m, at c %.6g to %.6g",
                 which == 0 ? "head" : "hand", step_m, bound_m, was->c, now->c);
}

static inline void continuity_feed(struct continuity *k, int which, struct ap_pose pose) {
    static const char *const names[] = {"head", "left", "right"};
    struct ap_iso m;
    if (!feed(k->tracker, names[which], pose, &m))
        return;
    struct follower now = {.seen = true, .p = pose.p}, *was = &k->device[which];
    now.p.y -= k->params.table_height_m;
    struct ap_vec3 anchor;
    now.c = perimeter(k->params.table_edge_m, now.p, &anchor);
    now.d = ap_vec3_sub(now.p, anchor);
    double rho = k->params.space.rho_m;
    now.world =
        (struct ap_vec4){rho * m.m[0][3], rho * m.m[1][3], rho * m.m[2][3], rho * m.m[3][3]};
    if (which > 0)
        now.c = nearest(now.c, k->device[0].c);
    else if (was->seen)
        now.c = nearest(now.c, was->c);
    if (which == 0) {
        k->c_low = was->seen ? fmin(k->c_low, now.c) : now.c;
        k->c_high = was->seen ? fmax(k->c_high, now.c) : now.c;
    }
    if (was->seen)
        continuity_check(k, which, was, &now);
    *was = now;
}

static inline void continuity_finish(struct continuity *k, const char *what) {
    printf("%-34s %-2s %7lld steps, at most %.4f of the bound; %lld flips of a hand, %lld within "
           "0.1 m of the axis; c %.2f to %.2f\n",
           what, ap_space_name(k->params.space), (long long)k->steps, k->worst, (long long)k->flips,
           (long long)k->near_axis, k->c_low, k->c_high);
    ap_tracker_destroy(k->tracker);
}

#endif
