#include "src/image/cover.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>

// An edge of the curve that runs down by dy through a pixel at the mean place x (0…1 across it)
// covers dy·(1 − x) of that pixel and dy of every one to the right of it. So each piece of an edge
// is noted in two neighbours, and the sum along the row is the share covered. Green's theorem: the
// share changes with a shift by the boundary's flux through it.
struct grid {
    struct ap_cover *cover;
    int width, height;
    double about_i, about_j, per_grow; // of the curve's place after the shift
};

struct point {
    double x, y;
};

static void note(struct grid *g, int row, struct point a, struct point b) {
    double dy = b.y - a.y, dx = b.x - a.x, x = (a.x + b.x) / 2, y = (a.y + b.y) / 2;
    int column = (int)floor(x);
    if (column >= g->width)
        return;
    struct ap_cover *at = g->cover + (size_t)row * (size_t)g->width;
    if (column < 0) {
        at[0].share += dy;
        return;
    }
    at += column;
    at->share += dy * (column + 1 - x);
    if (column + 1 < g->width)
        at[1].share += dy * (x - column);
    at->by_i -= dy;
    at->by_j += dx;
    at->by_grow += g->per_grow * (dx * (y - g->about_j) - dy * (x - g->about_i));
}

static struct point between(struct point a, struct point b, double t) {
    return (struct point){a.x + t * (b.x - a.x), a.y + t * (b.y - a.y)};
}

// Cuts a → b where a coordinate passes whole numbers; f of each piece.
static double next_cut(double at, double to, double *end) {
    double cut = to > at ? floor(at) + 1 : ceil(at) - 1;
    bool before = to > at ? cut < to : cut > to;
    *end = before ? cut : to;
    return before;
}

static void note_row(struct grid *g, int row, struct point a, struct point b) {
    struct point from = a;
    for (double x = a.x, end; x != b.x; x = end) {
        bool cut = next_cut(x, b.x, &end);
        struct point to = cut ? between(a, b, (end - a.x) / (b.x - a.x)) : b;
        to.x = end;
        note(g, row, from, to);
        from = to;
    }
    if (a.x == b.x)
        note(g, row, a, b);
}

static void note_edge(struct grid *g, struct point a, struct point b) {
    struct point from = a;
    for (double y = a.y, end; y != b.y; y = end) {
        bool cut = next_cut(y, b.y, &end);
        struct point to = cut ? between(a, b, (end - a.y) / (b.y - a.y)) : b;
        to.y = end;
        int row = (int)floor((y + end) / 2);
        if (row >= 0 && row < g->height)
            note_row(g, row, from, to);
        from = to;
    }
    int row = (int)floor(a.y);
    if (a.y == b.y && row >= 0 && row < g->height)
        note_row(g, row, a, b);
}

double ap_outline_area(const struct ap_outline *outline, double *centroid_i, double *centroid_j) {
    const double(*p)[2] = outline->points;
    double area = 0, i = 0, j = 0;
    for (size_t k = 0; k < outline->count; k++) {
        size_t next = k + 1 < outline->count ? k + 1 : 0;
        double ax = p[k][0] - p[0][0], ay = p[k][1] - p[0][1];
        double bx = p[next][0] - p[0][0], by = p[next][1] - p[0][1];
        double cross = ax * by - ay * bx;
        area += cross / 2;
        i += (ax + bx) * cross / 6;
        j += (ay + by) * cross / 6;
    }
    *centroid_i = p[0][0] + i / area;
    *centroid_j = p[0][1] + j / area;
    return fabs(area);
}

void ap_cover_outline(const struct ap_outline *outline, const struct ap_outline_place *place,
                      int x0, int y0, int width, int height, struct ap_cover *cover) {
    size_t pixels = (size_t)width * (size_t)height;
    memset(cover, 0, pixels * sizeof *cover);
    double scale = 1 + place->grow_px / place->radius_px;
    struct grid g = {cover,
                     width,
                     height,
                     outline->about_i + place->shift_i - x0,
                     outline->about_j + place->shift_j - y0,
                     1 / (place->radius_px * scale)};
    struct point first = {0, 0}, last = {0, 0};
    double turn = 0; // twice the area, signed: which way round the points run
    for (size_t k = 0; k <= outline->count; k++) {
        const double *p = outline->points[k % outline->count];
        struct point at = {g.about_i + scale * (p[0] - outline->about_i),
                           g.about_j + scale * (p[1] - outline->about_j)};
        if (k == 0)
            first = at;
        if (k == outline->count)
            at = first;
        if (k > 0) {
            note_edge(&g, last, at);
            turn += (last.x - first.x) * (at.y - first.y) - (last.y - first.y) * (at.x - first.x);
        }
        last = at;
    }
    // A left edge that runs towards greater j covers what is right of it.
    double sign = turn < 0 ? 1 : -1;
    for (int y = 0; y < height; y++) {
        double sum = 0;
        for (int x = 0; x < width; x++) {
            struct ap_cover *c = &cover[(size_t)y * (size_t)width + (size_t)x];
            sum += c->share;
            c->share = fmin(fmax(sign * sum, 0), 1);
            c->by_i *= sign;
            c->by_j *= sign;
            c->by_grow *= sign;
        }
    }
}
