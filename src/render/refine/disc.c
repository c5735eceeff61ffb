#include "src/render/refine/disc.h"

#include <math.h>

#include "src/view/silhouette.h"

static const double PI = 3.14159265358979323846;
// Exact points of the outline; cubic pieces between them are within 2e-6 of its size.
enum { POINTS = 40, PIECES_MAX = 24, RINGS_MAX = 24 };
static const double BAND_PX = 1.5; // on either side of the rim, inside at most half of the way
// A pixel farther inside than half its diagonal is covered whole, so half the way must be more.
static const double LEAST_PX = 1.6;
static const double SAGITTA_PX = 0.01;
// A smaller disc's depth is looked for along every eighth spoke.
static const double SMALL_PX = 24;

// What depth is made of: native, metres ahead and the angle from the nose the short way; else ahead
// is 1 and w that of the eye's homogeneous coordinates (shaders/part.glsl).
struct depth {
    double ahead, w;
};

struct rim {
    double i, j; // pixels
    struct depth depth;
};

struct disc {
    const struct ap_disc_params *params;
    int eye;
    struct ap_iso eye_from_nose;
    struct ap_pose eye_from_view;
    double px_per_a, px_per_b;
    struct rim rim[POINTS];
    double middle_i, middle_j, radius_px, inner_px;
    struct depth nearest;
    struct ap_vec4
        centre; // tourist: in the eye's coordinates, over rho; else in the nose's, metres
    int rings;
    double ring[RINGS_MAX + 1];                // of the way from the middle: 1, …, 0
    struct depth depth[POINTS][RINGS_MAX + 1]; // of the surface there, along each point's spoke
};

static struct depth homogeneous(struct ap_vec4 p, double sign) {
    return (struct depth){1, sign * p.w / (-sign * p.z)};
}

static double short_way(const struct disc *d, struct ap_vec3 tangent_m) {
    double t = ap_vec3_length(tangent_m) / d->params->viewer->space.rho_m;
    return d->params->image ? 2 * PI - t : t;
}

static struct depth depth_of(const struct disc *d, const struct ap_outline_point *point) {
    const struct ap_viewer *v = d->params->viewer;
    if (v->mode == AP_VIEW_NATIVE)
        return (struct depth){-ap_pose_apply(d->eye_from_view, point->tangent_m).z,
                              short_way(d, point->tangent_m)};
    struct ap_born_point born =
        ap_born_from_tangent(v->born, (struct ap_tangent_point){point->tangent_m});
    return homogeneous(ap_iso_apply(&d->eye_from_nose, born.x), born.behind ? -1 : 1);
}

// Tourist: a point at the distance t along a line is (S·line, C); seen the long way round, minus
// that.
static struct depth depth_at(const struct disc *d, double c, double s, struct ap_vec3 line) {
    return (struct depth){1, (d->params->image ? -c : c) / (s * -line.z)};
}

static void tourist_depths(struct disc *d, const struct ap_outline_point points[POINTS]) {
    const struct ap_viewer *v = d->params->viewer;
    struct ap_space space = v->space;
    double rho = space.rho_m, r = d->params->radius_m / rho, sign = d->params->image ? -1 : 1;
    struct ap_vec4 p = ap_iso_apply(&d->eye_from_nose, d->centre);
    d->centre = (struct ap_vec4){p.x / rho, p.y / rho, p.z / rho, p.w / rho};
    struct ap_vec3 u = ap_vec3_scale(sign, ap_vec3_normalize((struct ap_vec3){p.x, p.y, p.z}));
    double away = ap_vec3_length(ap_log_unchecked(space, p, 0)) / rho, near = away - sign * r;
    d->nearest = depth_at(d, ap_space_cos(space, near), ap_space_sin(space, near), u);
    // A right-angled triangle of the eye, the rim and the centre: C(d) = C(t)·C(r).
    double c = ap_space_cos(space, away) / ap_space_cos(space, r);
    double s = space.kappa == 0 ? sqrt(fmax(0, away * away - r * r)) : sqrt(fabs(1 - c * c));
    for (int k = 0; k < POINTS; k++)
        d->rim[k].depth = depth_at(d, space.kappa == 0 ? 1 : c, s, points[k].line);
}

static bool find_rim(struct disc *d) {
    const struct ap_disc_params *p = d->params;
    const struct ap_frustum *f = &p->viewer->eye[d->eye].frustum;
    struct ap_outline_point points[POINTS], nearest;
    d->centre = ap_nose_from_world(p->viewer, p->world_centre).x;
    if (!ap_ball_outline(p->viewer, d->eye, p->world_centre, p->radius_m, p->image, POINTS, points,
                         &nearest))
        return false;
    bool tourist = p->viewer->mode == AP_VIEW_TOURIST;
    for (int k = 0; k < POINTS; k++) {
        struct ap_vec3 line = points[k].line;
        d->rim[k].i = (line.x / -line.z - f->left) * d->px_per_a;
        d->rim[k].j = (f->up - line.y / -line.z) * d->px_per_b;
        if (!tourist)
            d->rim[k].depth = depth_of(d, &points[k]);
        d->middle_i += d->rim[k].i / POINTS;
        d->middle_j += d->rim[k].j / POINTS;
    }
    if (tourist)
        tourist_depths(d, points);
    else
        d->nearest = depth_of(d, &nearest);
    double least = INFINITY;
    for (int k = 0; k < POINTS; k++) {
        double r = hypot(d->rim[k].i - d->middle_i, d->rim[k].j - d->middle_j);
        d->radius_px = fmax(d->radius_px, r);
        least = fmin(least, r);
        if (!isfinite(r) || !isfinite(d->rim[k].depth.w) || !(d->rim[k].depth.ahead > AP_NEAR_M))
            return false;
    }
    d->inner_px = fmin(BAND_PX, least / 2);
    return least > LEAST_PX && isfinite(d->nearest.w) && d->nearest.ahead > AP_NEAR_M;
}

// --- depth inside of the rim

static struct ap_vec3 line_at(const struct disc *d, double i, double j) {
    const struct ap_frustum *f = &d->params->viewer->eye[d->eye].frustum;
    return ap_vec3_normalize(
        (struct ap_vec3){f->left + i / d->px_per_a, f->up - j / d->px_per_b, -1});
}

// Tourist: where a geodesic from the eye meets the ball first, a·S + κ·b·C = κ·c (1 for e3's κ); by
// what of the centre lies beside the line, since a small radius's C has no digits left.
static bool meet_tourist(const struct disc *d, struct ap_vec3 u, struct depth *out) {
    struct ap_space space = d->params->viewer->space;
    double r = d->params->radius_m / space.rho_m, s = ap_space_sin(space, r);
    struct ap_vec3 m = {d->centre.x, d->centre.y, d->centre.z};
    double a = ap_vec3_dot(m, u), b = d->centre.w, c = ap_space_cos(space, r);
    struct ap_vec3 beside = ap_vec3_sub(m, ap_vec3_scale(a, u));
    double square = s * s - ap_vec3_dot(beside, beside), root = sqrt(fmax(square, 0));
    // Both over the same positive number.
    *out = (struct depth){1, (c * b + space.kappa * root * a) / (c * a - root * b) / -u.z};
    return square > 0 && isfinite(out->w);
}

// Below 0 inside of the ball: the square of the chord to its centre, less that of its radius.
static double beyond(const struct disc *d, struct ap_vec3 tangent_m) {
    struct ap_space space = d->params->viewer->space;
    struct ap_vec4 p = ap_exp(space, tangent_m), c = d->centre;
    double x = p.x - c.x, y = p.y - c.y, z = p.z - c.z, w = p.w - c.w;
    double half = 2 * space.rho_m * ap_space_sin(space, d->params->radius_m / space.rho_m / 2);
    return x * x + y * y + z * z + space.kappa * w * w - half * half;
}

// Native: where the eye's line, straight in tangent space, enters the ball, from a guess.
static bool meet_native(const struct disc *d, struct ap_vec3 u, double guess_ahead,
                        struct depth *out) {
    const struct ap_pose *eye = &d->params->viewer->eye[d->eye].view_from_eye;
    struct ap_vec3 line = ap_quat_rotate(eye->q, u);
    double s = guess_ahead / -u.z, step = 0.02 * d->params->radius_m, before = s - step;
    double g_before = beyond(d, ap_vec3_add(eye->p, ap_vec3_scale(before, line)));
    for (int i = 0; i < 8; i++) {
        double g = beyond(d, ap_vec3_add(eye->p, ap_vec3_scale(s, line)));
        double slope = (g - g_before) / (s - before);
        if (!(slope < 0) || !isfinite(g))
            return false; // it does not enter here
        before = s, g_before = g;
        step = -g / slope;
        s += step;
        if (fabs(step) < 1e-6 * d->params->radius_m) {
            struct ap_vec3 at = ap_vec3_add(eye->p, ap_vec3_scale(s, line));
            *out = (struct depth){s * -u.z, short_way(d, at)};
            return out->ahead > AP_NEAR_M;
        }
    }
    return false;
}

// Facets between the rings fall short of a round surface by what an outline of as many corners
// would.
static void find_rings(struct disc *d) {
    double fine = fmin(fmax(d->params->max_error_px, 0.02) / d->radius_px, 1);
    d->rings = (int)fmin(fmax(3, ceil(PI / 4 / acos(1 - fine))), RINGS_MAX);
    for (int n = 0; n <= d->rings; n++)
        d->ring[n] = n < d->rings ? cos(PI / 2 * n / d->rings) : 0;
}

static struct depth between(struct depth a, struct depth b, double t) {
    return (struct depth){a.ahead + t * (b.ahead - a.ahead), a.w + t * (b.w - a.w)};
}

static void find_depths(struct disc *d) {
    enum ap_view_mode mode = d->params->viewer->mode;
    int stride = d->radius_px < SMALL_PX ? 8 : 1;
    for (int k = 0; k < POINTS; k += stride)
        for (int n = 0; n <= d->rings; n++) {
            const struct rim *rim = &d->rim[k];
            double out = hypot(rim->i - d->middle_i, rim->j - d->middle_j);
            double way = d->ring[n] * (1 - d->inner_px / out), bulge = sqrt(1 - way * way);
            struct ap_vec3 u = line_at(d, d->middle_i + way * (rim->i - d->middle_i),
                                       d->middle_j + way * (rim->j - d->middle_j));
            struct depth guess = between(rim->depth, d->nearest, bulge), *at = &d->depth[k][n];
            bool met = mode == AP_VIEW_TOURIST  ? meet_tourist(d, u, at)
                       : mode == AP_VIEW_NATIVE ? meet_native(d, u, guess.ahead, at)
                                                : false;
            if (!met)
                *at = guess;
        }
    for (int k = 0; stride > 1 && k < POINTS; k++)
        for (int n = 0; k % stride && n <= d->rings; n++)
            d->depth[k][n] = between(d->depth[k - k % stride][n],
                                     d->depth[(k - k % stride + stride) % POINTS][n],
                                     (double)(k % stride) / stride);
}

// --- triangles

// A vertex at a place of the picture; out: pixels outside the rim.
static enum ap_status vertex(struct ap_error *err, const struct disc *d, struct ap_mesh_data *data,
                             double i, double j, double out, double ni, double nj,
                             struct depth depth) {
    const struct ap_frustum *f = &d->params->viewer->eye[d->eye].frustum;
    return ap_mesh_data_vertex(
        err, data,
        (struct ap_vec4){f->left + i / d->px_per_a, f->up - j / d->px_per_b, depth.ahead, depth.w},
        (struct ap_vec4){-out, ni, nj, d->eye});
}

// How the outline goes on at point k, a step; from four neighbours, to the fourth order.
static double slope(const struct disc *d, int k, bool j) {
    double x[4];
    static const int BESIDE[4] = {-2, -1, 1, 2};
    for (int n = 0; n < 4; n++) {
        const struct rim *r = &d->rim[(k + BESIDE[n] + POINTS) % POINTS];
        x[n] = j ? r->j : r->i;
    }
    return (x[0] - 8 * x[1] + 8 * x[2] - x[3]) / 12;
}

// The outline at t of the way from point k to the next, the way it goes there and how that turns.
struct curve {
    double at, along, turn;
};

static struct curve curve(const struct disc *d, int k, double t, bool j) {
    const struct rim *a = &d->rim[k], *b = &d->rim[(k + 1) % POINTS];
    double p = j ? a->j : a->i, q = j ? b->j : b->i, u = slope(d, k, j),
           v = slope(d, (k + 1) % POINTS, j);
    double c2 = 3 * (q - p) - 2 * u - v, c3 = 2 * (p - q) + u + v;
    return (struct curve){p + t * (u + t * (c2 + t * c3)), u + t * (2 * c2 + 3 * t * c3),
                          2 * c2 + 6 * t * c3};
}

// The shader takes the rim for straight where it meets a pixel. On the average over a pixel's width
// it lies so much farther in, in pixels: the mean of x^2/2 over the radius of its bend.
static double bulge_px(struct curve i, struct curve j) {
    double speed = hypot(i.along, j.along);
    return fmin(fabs(i.along * j.turn - j.along * i.turn) / (24 * speed * speed * speed), 0.05);
}

// The vertices of one spoke: outside the rim, inside it, then inward to the middle.
static enum ap_status spoke(struct ap_error *err, const struct disc *d, struct ap_mesh_data *data,
                            int k, double t) {
    struct curve ci = curve(d, k, t, false), cj = curve(d, k, t, true);
    double i = ci.at, j = cj.at, length = hypot(ci.along, cj.along), bulge_out = bulge_px(ci, cj);
    double ni = cj.along / length, nj = -ci.along / length;
    if (ni * (i - d->middle_i) + nj * (j - d->middle_j) < 0)
        ni = -ni, nj = -nj;
    int next = (k + 1) % POINTS;
    struct depth edge = between(d->rim[k].depth, d->rim[next].depth, t);
    enum ap_status st =
        vertex(err, d, data, i + BAND_PX * ni, j + BAND_PX * nj, BAND_PX + bulge_out, ni, nj, edge);
    double in_i = i - d->inner_px * ni, in_j = j - d->inner_px * nj;
    for (int n = 0; st == AP_OK && n <= d->rings; n++) {
        double f = d->ring[n];
        st = vertex(err, d, data, d->middle_i + f * (in_i - d->middle_i),
                    d->middle_j + f * (in_j - d->middle_j), (n ? 0 : bulge_out) - d->inner_px, ni,
                    nj, between(d->depth[k][n], d->depth[next][n], t));
    }
    return st;
}

enum ap_status ap_disc_append(struct ap_error *err, const struct ap_disc_params *params, int eye,
                              struct ap_mesh_data *data, uint32_t first_vertex,
                              enum ap_disc_made *made) {
    const struct ap_viewer *v = params->viewer;
    const struct ap_frustum *f = &v->eye[eye].frustum;
    struct disc d = {.params = params,
                     .eye = eye,
                     .eye_from_nose = ap_eye_from_nose(v, eye),
                     .eye_from_view = ap_pose_inverse(v->eye[eye].view_from_eye),
                     .px_per_a = params->width_px / (f->right - f->left),
                     .px_per_b = params->height_px / (f->up - f->down)};
    *made = find_rim(&d) ? AP_DISC_MADE : AP_DISC_UNFIT;
    if (!*made)
        return AP_OK;
    double spokes = PI * sqrt(d.radius_px / (2 * SAGITTA_PX));
    int pieces = (int)fmin(fmax(1, ceil(spokes / POINTS)), PIECES_MAX), count = POINTS * pieces;
    enum ap_status st = AP_OK;
    uint32_t base = (uint32_t)data->vertex_count - first_vertex;
    find_rings(&d);
    find_depths(&d);
    uint32_t each = (uint32_t)d.rings + 2;
    if ((size_t)count * (2 * each - 3) > params->triangles_max) {
        *made = AP_DISC_NO_ROOM;
        return AP_OK;
    }
    for (int n = 0; st == AP_OK && n < count; n++)
        st = spoke(err, &d, data, n / pieces, (double)(n % pieces) / pieces);
    for (int n = 0; st == AP_OK && n < count; n++)
        for (uint32_t ring = 0; st == AP_OK && ring + 1 < each; ring++) {
            uint32_t a = base + (uint32_t)n * each + ring,
                     b = base + (uint32_t)((n + 1) % count) * each + ring;
            st = ap_mesh_data_triangle(err, data, a, b, b + 1);
            if (st == AP_OK && ring + 2 < each) // the innermost ring is a point
                st = ap_mesh_data_triangle(err, data, a, b + 1, a + 1);
        }
    return st;
}
