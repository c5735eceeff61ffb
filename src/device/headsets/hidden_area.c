#include "src/device/headsets/hidden_area.h"

#include <math.h>
#include <stdbool.h>

enum { SEGMENTS = 64, MAX_CORNERS = SEGMENTS + 8, MAX_RAYS = MAX_CORNERS + 4 };
// Triangles flatter than this angle are where the outline lies on the picture's edge. In the
// float32 of those who take them they could turn over.
static const double FLAT_RAD = 1e-6;

struct point {
    double x, y;
};

struct polygon { // convex, counterclockwise
    int count;
    struct point at[MAX_CORNERS];
};

// Twice the area of the triangle.
static double cross(struct point a, struct point b, struct point c) {
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

static struct polygon fov_rectangle(const struct ap_eye_profile *eye) {
    double l = tan(eye->left_rad), r = tan(eye->right_rad);
    double d = tan(eye->down_rad), u = tan(eye->up_rad);
    return (struct polygon){4, {{l, d}, {r, d}, {r, u}, {l, u}}};
}

static struct polygon around_ellipse(const double seen[4]) {
    struct polygon p = {.count = SEGMENTS};
    double out = 1 / cos(M_PI / SEGMENTS);
    for (int i = 0; i < SEGMENTS; i++) {
        double a = 2 * M_PI * i / SEGMENTS;
        p.at[i] =
            (struct point){seen[0] + out * seen[2] * cos(a), seen[1] + out * seen[3] * sin(a)};
    }
    return p;
}

// What lies left of the line from a to b.
static struct polygon cut(const struct polygon *p, struct point a, struct point b) {
    struct polygon out = {0};
    for (int i = 0; i < p->count; i++) {
        struct point from = p->at[i], to = p->at[(i + 1) % p->count];
        double f = cross(a, b, from), t = cross(a, b, to);
        if (f >= 0)
            out.at[out.count++] = from;
        if ((f > 0 && t < 0) || (f < 0 && t > 0)) {
            double s = f / (f - t);
            out.at[out.count++] =
                (struct point){from.x + s * (to.x - from.x), from.y + s * (to.y - from.y)};
        }
    }
    return out;
}

// Where the ray from the center through p leaves the polygon, which holds the center.
static struct point leaves(const struct polygon *p, struct point center, struct point through) {
    struct point d = {through.x - center.x, through.y - center.y};
    double least = INFINITY;
    for (int i = 0; i < p->count; i++) {
        struct point a = p->at[i], b = p->at[(i + 1) % p->count];
        double across = d.x * (b.y - a.y) - d.y * (b.x - a.x);
        if (across > 0) // outward
            least = fmin(least, cross(a, b, center) / across);
    }
    return (struct point){center.x + least * d.x, center.y + least * d.y};
}

static void add_vertex(struct ap_mask *mask, struct point p) {
    mask->vertex[mask->vertex_count][0] = (double)(float)p.x;
    mask->vertex[mask->vertex_count++][1] = (double)(float)p.y;
}

static void add_triangle(struct ap_mask *mask, uint32_t a, uint32_t b, uint32_t c) {
    struct point p[3];
    const uint32_t index[3] = {a, b, c};
    for (int i = 0; i < 3; i++)
        p[i] = (struct point){mask->vertex[index[i]][0], mask->vertex[index[i]][1]};
    double ab = hypot(p[1].x - p[0].x, p[1].y - p[0].y);
    double ac = hypot(p[2].x - p[0].x, p[2].y - p[0].y);
    if (cross(p[0], p[1], p[2]) <= FLAT_RAD * ab * ac)
        return;
    for (int i = 0; i < 3; i++)
        mask->index[mask->index_count++] = index[i];
}

// Rays from the center through every corner of both, by their angle.
static int sort_rays(const struct polygon *seen, const struct polygon *whole, struct point center,
                     struct point rays[MAX_RAYS]) {
    double angle[MAX_RAYS];
    int count = 0;
    for (int i = 0; i < seen->count + whole->count; i++) {
        struct point p = i < seen->count ? seen->at[i] : whole->at[i - seen->count];
        double a = atan2(p.y - center.y, p.x - center.x);
        int at = count++;
        for (; at > 0 && angle[at - 1] > a; at--) {
            angle[at] = angle[at - 1];
            rays[at] = rays[at - 1];
        }
        angle[at] = a;
        rays[at] = p;
    }
    return count;
}

// A ring between the visible polygon and the picture's edge: a quadrangle between two rays.
static void hidden(struct ap_mask *mask, const struct polygon *seen, const struct polygon *whole,
                   struct point center) {
    struct point rays[MAX_RAYS];
    uint32_t count = (uint32_t)sort_rays(seen, whole, center, rays);
    for (uint32_t i = 0; i < count; i++) {
        add_vertex(mask, leaves(seen, center, rays[i]));
        add_vertex(mask, leaves(whole, center, rays[i]));
    }
    for (uint32_t i = 0; i < count; i++) {
        uint32_t a = 2 * i, b = 2 * ((i + 1) % count);
        add_triangle(mask, a, a + 1, b + 1);
        add_triangle(mask, a, b + 1, b);
    }
}

void ap_hidden_area_mask(const struct ap_eye_profile *eye, enum ap_mask_kind kind,
                         struct ap_mask *mask) {
    mask->vertex_count = mask->index_count = 0;
    if (!(eye->seen[2] > 0))
        return;
    struct polygon whole = fov_rectangle(eye), seen = around_ellipse(eye->seen);
    for (int i = 0; i < 4; i++)
        seen = cut(&seen, whole.at[i], whole.at[(i + 1) % 4]);
    if (kind == AP_MASK_HIDDEN) {
        hidden(mask, &seen, &whole, (struct point){eye->seen[0], eye->seen[1]});
        return;
    }
    for (int i = 0; i < seen.count; i++)
        add_vertex(mask, seen.at[i]);
    for (uint32_t i = 0; i < mask->vertex_count; i++)
        if (kind == AP_MASK_OUTLINE)
            mask->index[mask->index_count++] = i;
        else if (i >= 2)
            add_triangle(mask, 0, i - 1, i);
}
