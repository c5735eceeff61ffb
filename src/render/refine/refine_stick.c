#include "src/render/refine/refine_stick.h"

#include <math.h>

static const double PI = 3.14159265358979323846;
// Edges that are looked at: around the axis to find how many there need to be, and along it.
enum { TRIED_AROUND = 16, TRIED_ALONG = 8, LEAST_AROUND = 8, PLACES = 5, TRIES = 12 };
// A step is made so long that its error is about this of what is allowed.
static const double AIM = 0.9;

struct gauge {
    const struct ap_surface *surface;
    const struct ap_eyes *eyes;
};

static struct ap_surface_point point_at(const struct gauge *g, double along, double turn_rad) {
    struct ap_surface_point point = {.from = {cos(turn_rad), sin(turn_rad), 0}};
    ap_surface_place(g->surface, along, &point);
    ap_surface_see(g->surface, &point);
    return point;
}

static double length(struct ap_vec3 v) {
    return sqrt(ap_vec3_dot(v, v));
}

// How far off the edge between two points is; 0 where no eye sees it, and INFINITY where it is as
// long as it is far.
static double edge_px(const struct gauge *g, const struct ap_surface_point *a,
                      const struct ap_surface_point *b) {
    const struct ap_surface *s = g->surface;
    struct ap_surface_point m = ap_surface_middle(s, a, b);
    const struct ap_surface_point *points[3] = {a, b, &m};
    if (ap_surface_out_of_sight(s, points))
        return 0;
    for (int e = 0; e < 2 && s->mode == AP_VIEW_NATIVE && s->space.kappa != 0; e++)
        if (length(ap_vec3_sub(a->seen[e], b->seen[e])) > length(m.seen[e]))
            return INFINITY;
    double off = ap_surface_error_px(s, g->eyes, a, b, 0.5, &m);
    return off >= 0 ? off : INFINITY;
}

// The worst edge of a step along the axis.
static double step_px(const struct gauge *g, double from, double to) {
    double worst = 0;
    for (int i = 0; i < TRIED_ALONG; i++) {
        double turn = 2 * PI * i / TRIED_ALONG;
        struct ap_surface_point a = point_at(g, from, turn), b = point_at(g, to, turn);
        worst = fmax(worst, edge_px(g, &a, &b));
    }
    return worst;
}

// The step from `from` whose error is about `most_px`, or what is left; first tried: `step`.
static double step_from(const struct gauge *g, double from, double end, double step,
                        double most_px) {
    double good = 0;
    for (int i = 0; i < TRIES; i++) {
        double to = fmin(from + step, end), px = step_px(g, from, to);
        // Errors grow as the square of the step.
        double share = fmin(fmax(sqrt(AIM * most_px / fmax(px, 1e-9)), 0.3), 2.5);
        if (px <= most_px) {
            good = to - from;
            if (to >= end || share < 1.3)
                return good;
        } else if (good > 0) {
            return good;
        }
        step = (to - from) * share;
    }
    return good > 0 ? good : step;
}

static void find_rings(const struct gauge *g, double half, double most_px,
                       struct ap_stick_grid *grid) {
    double step = 2 * half;
    grid->along[0] = -half;
    grid->rings = 1;
    while (grid->rings < AP_STICK_RINGS - 1 && grid->along[grid->rings - 1] < half) {
        double from = grid->along[grid->rings - 1];
        step = step_from(g, from, half, fmax(step, 1e-3 * half), most_px);
        // No sliver at the end.
        double left = half - from;
        grid->along[grid->rings++] = step > left - 1e-6 * half ? half
                                     : step > 0.6 * left       ? from + left / 2
                                                               : from + step;
    }
    if (grid->along[grid->rings - 1] < half)
        grid->along[grid->rings++] = half;
}

static int corners_around(const struct gauge *g, double half, double most_px) {
    double worst = 0;
    for (int k = 0; k < PLACES; k++) {
        double along = half * (2.0 * k / (PLACES - 1) - 1);
        struct ap_surface_point ring[TRIED_AROUND];
        for (int i = 0; i < TRIED_AROUND; i++)
            ring[i] = point_at(g, along, 2 * PI * i / TRIED_AROUND);
        for (int i = 0; i < TRIED_AROUND; i++)
            worst = fmax(worst, edge_px(g, &ring[i], &ring[(i + 1) % TRIED_AROUND]));
    }
    double count = ceil(TRIED_AROUND * sqrt(worst / most_px));
    return (int)fmin(fmax(count, LEAST_AROUND), AP_STICK_AROUND);
}

struct ap_stick_grid ap_stick_grid_of(const struct ap_surface *surface, const struct ap_eyes *eyes,
                                      double edge_px) {
    const struct gauge g = {surface, eyes};
    struct ap_stick_grid grid = {.rings = 0};
    double half = surface->part->length_m / surface->space.rho_m / 2;
    grid.around = corners_around(&g, half, edge_px / 2);
    find_rings(&g, half, edge_px / 2, &grid);
    return grid;
}
