#include "src/track/chaperone.h"

#include <math.h>
#include <stdbool.h>

static const double grid_m = 0.25, near_m = 0.75, warn_default_m = 0.5;

enum { ROWS = 8 }; // 2 m

// A wall as seen from inside: points at (along, y) on it are middle + along·right.
struct wall {
    struct ap_vec3 middle, right;
    double half_m;
};

static struct wall wall_of(const struct ap_chaperone *c, int side) {
    double x = c->width_m / 2, z = c->depth_m / 2;
    switch (side) {
    case 0:
        return (struct wall){{0, 0, -z}, {1, 0, 0}, x};
    case 1:
        return (struct wall){{x, 0, 0}, {0, 0, 1}, z};
    case 2:
        return (struct wall){{0, 0, z}, {-1, 0, 0}, x};
    default:
        return (struct wall){{-x, 0, 0}, {0, 0, -1}, z};
    }
}

static bool has_bounds(const struct ap_chaperone *c) {
    return isfinite(c->width_m) && isfinite(c->depth_m) && c->width_m > 0 && c->depth_m > 0;
}

static double warn_of(const struct ap_chaperone *c) {
    return isfinite(c->warn_m) && c->warn_m > 0 ? c->warn_m : warn_default_m;
}

static bool is_there(struct ap_vec3 p) {
    return isfinite(p.x) && isfinite(p.y) && isfinite(p.z);
}

// How far inside of the wall, negative outside.
static double inside_m(const struct ap_chaperone *c, int side, struct ap_vec3 p) {
    switch (side) {
    case 0:
        return p.z + c->depth_m / 2;
    case 1:
        return c->width_m / 2 - p.x;
    case 2:
        return c->depth_m / 2 - p.z;
    default:
        return p.x + c->width_m / 2;
    }
}

static double strength_of(const struct ap_chaperone *c, double inside) {
    return fmin(fmax(1 - inside / warn_of(c), 0), 1);
}

double ap_chaperone_alarm(const struct ap_chaperone *c, const struct ap_vec3 *points,
                          size_t count) {
    double alarm = 0;
    for (size_t i = 0; has_bounds(c) && i < count; i++)
        for (int side = 0; side < 4 && is_there(points[i]); side++)
            alarm = fmax(alarm, strength_of(c, inside_m(c, side, points[i])));
    return alarm;
}

// How plainly the place (along, y) of a wall shows: by the nearest point that it warns.
static double strength_at(const struct ap_chaperone *c, int side, const struct wall *wall,
                          double along, double y, const struct ap_vec3 *points, size_t count) {
    double strength = 0;
    for (size_t i = 0; i < count; i++) {
        if (!is_there(points[i]))
            continue;
        struct ap_vec3 d = ap_vec3_sub(points[i], wall->middle);
        double off = hypot(ap_vec3_dot(d, wall->right) - along, points[i].y - y);
        double near = fmin(fmax(1 - off / near_m, 0), 1);
        strength = fmax(strength, near * strength_of(c, inside_m(c, side, points[i])));
    }
    return strength;
}

struct fence {
    const struct ap_chaperone *c;
    const struct ap_vec3 *points;
    size_t point_count, count;
    struct ap_chaperone_line *lines;
};

static void add_line(struct fence *fence, int side, const struct wall *wall, const double from[2],
                     const double to[2]) {
    double strength = strength_at(fence->c, side, wall, (from[0] + to[0]) / 2,
                                  (from[1] + to[1]) / 2, fence->points, fence->point_count);
    if (!(strength > 0) || fence->count == AP_CHAPERONE_MAX_LINES)
        return;
    struct ap_chaperone_line *line = &fence->lines[fence->count++];
    line->a = ap_vec3_add(wall->middle, ap_vec3_scale(from[0], wall->right));
    line->b = ap_vec3_add(wall->middle, ap_vec3_scale(to[0], wall->right));
    line->a.y = from[1];
    line->b.y = to[1];
    line->strength = strength;
}

// The grid's columns first…last of a wall that any point is near enough to; false: none.
static bool columns_of(const struct fence *fence, int side, const struct wall *wall, int *first,
                       int *last) {
    double low = INFINITY, high = -INFINITY;
    for (size_t i = 0; i < fence->point_count; i++) {
        struct ap_vec3 p = fence->points[i];
        if (!is_there(p) || !(strength_of(fence->c, inside_m(fence->c, side, p)) > 0))
            continue;
        double along = ap_vec3_dot(ap_vec3_sub(p, wall->middle), wall->right);
        low = fmin(low, along - near_m);
        high = fmax(high, along + near_m);
    }
    low = fmax(low, -wall->half_m);
    high = fmin(high, wall->half_m);
    if (!(low <= high) || high - low > grid_m * AP_CHAPERONE_MAX_LINES || fabs(low) > 1e6)
        return false;
    *first = (int)floor(low / grid_m);
    *last = (int)ceil(high / grid_m);
    return true;
}

static void add_wall(struct fence *fence, int side) {
    struct wall wall = wall_of(fence->c, side);
    int first, last;
    if (!columns_of(fence, side, &wall, &first, &last))
        return;
    for (int i = first; i <= last; i++) {
        double x = fmin(fmax(i * grid_m, -wall.half_m), wall.half_m);
        double next = fmin((i + 1) * grid_m, wall.half_m);
        for (int row = 0; row <= ROWS; row++) {
            double y = row * grid_m;
            if (row < ROWS)
                add_line(fence, side, &wall, (double[2]){x, y}, (double[2]){x, y + grid_m});
            if (next > x)
                add_line(fence, side, &wall, (double[2]){x, y}, (double[2]){next, y});
        }
    }
}

size_t ap_chaperone_fence(const struct ap_chaperone *chaperone, const struct ap_vec3 *points,
                          size_t count, struct ap_chaperone_line lines[AP_CHAPERONE_MAX_LINES]) {
    struct fence fence = {.c = chaperone, .points = points, .point_count = count, .lines = lines};
    for (int side = 0; has_bounds(chaperone) && side < 4; side++)
        add_wall(&fence, side);
    return fence.count;
}
