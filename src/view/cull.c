#include "src/view/cull.h"

#include <stddef.h>

// How it works. Everything that an eye sees lies in a pyramid: its apex the eye, four planes its
// sides. An object is hidden from the eye where some plane through the apex has the pyramid on one
// side and the object on the other. In native view the object's image is what log makes of it in
// tangent space, and the apex stands beside the nose; in tourist view the same in the eye's own
// coordinates, with the apex at the origin, where it is a matter of directions alone. So both are
// one code path over points in polar form: distance, direction.
//
// An object is bounded in two ways, either of which may prove it hidden: by the cone of its
// directions between its nearest and farthest distance, and by a Euclidean ball in tangent space.
// What is neither proved hidden nor seen to be visible is cut in two and tried again.

enum { PYRAMID_SIDES = 4, MAX_DEPTH = 6, MAX_CORNERS = 64 };

// Slack for what is computed later in float32: relative, and radians. The pictures' own error is
// below 3e-7.
#define SLACK 2e-6

struct pyramid {
    struct ap_vec3 apex;                  // over rho
    struct ap_vec3 normal[PYRAMID_SIDES]; // unit, inward
    struct ap_vec3 edge[PYRAMID_SIDES];   // unit, from the apex, between sides i and i+1
};

// A point of the space in units of rho, cartesian and polar, both kept to full relative precision.
struct polar {
    struct ap_vec3 v; // (x, y, z)
    double w;
    double r;         // distance
    struct ap_vec3 u; // direction, zero where there is none
};

struct sight {
    struct ap_space space; // rho_m = 1
    struct pyramid pyramid;
    int image;
    double radius; // of the thickening, over rho
};

// Unit vectors of ordinary size: no overflow to guard against, and this is the inner loop.
static struct ap_vec3 unit(struct ap_vec3 v) {
    double n2 = ap_vec3_dot(v, v);
    return n2 > 0 ? ap_vec3_scale(1 / sqrt(n2), v) : v;
}

static double S(const struct sight *s, double t) {
    return ap_space_sin(s->space, t);
}

static struct polar polar_of(struct ap_space space, struct ap_vec3 v, double w) {
    double n = ap_vec3_length(v);
    double r = space.kappa > 0 ? atan2(n, w) : space.kappa < 0 ? asinh(n) : n;
    return (struct polar){v, w, r, ap_vec3_normalize(v)};
}

// Distance from polar coordinates: no cancellation, however far the points are.
static double polar_distance(struct ap_space space, const struct polar *p, const struct polar *q) {
    double chord = ap_vec3_length(ap_vec3_sub(p->u, q->u)) / 2; // sin of half the angle
    double dr = (p->r - q->r) / 2;
    double a = ap_space_sin(space, dr);
    double h2 = a * a + ap_space_sin(space, p->r) * ap_space_sin(space, q->r) * chord * chord;
    double h = sqrt(fmax(h2, 0));
    return 2 * (space.kappa > 0 ? asin(fmin(h, 1)) : space.kappa < 0 ? asinh(h) : h);
}

static struct polar midpoint(struct ap_space space, const struct polar *p, const struct polar *q) {
    double n = 2 * ap_space_cos(space, polar_distance(space, p, q) / 2);
    if (!(n > 1e-9)) // antipodal in s3: no midpoint; the caller's bounds then say "anywhere"
        return *p;
    struct ap_vec3 v = ap_vec3_scale(1 / n, ap_vec3_add(p->v, q->v));
    return polar_of(space, v, (p->w + q->w) / n);
}

static struct pyramid pyramid_of(const struct ap_frustum *f, struct ap_quat turn,
                                 struct ap_vec3 apex) {
    struct ap_vec3 corner[PYRAMID_SIDES] = {{f->left, f->down, -1},
                                            {f->right, f->down, -1},
                                            {f->right, f->up, -1},
                                            {f->left, f->up, -1}};
    struct pyramid p = {.apex = apex};
    for (int i = 0; i < PYRAMID_SIDES; i++)
        p.edge[i] = unit(ap_quat_rotate(turn, corner[i]));
    struct ap_vec3 axis = {0, 0, 0};
    for (int i = 0; i < PYRAMID_SIDES; i++)
        axis = ap_vec3_add(axis, p.edge[i]);
    for (int i = 0; i < PYRAMID_SIDES; i++) {
        struct ap_vec3 n = ap_vec3_cross(p.edge[i], p.edge[(i + 1) % PYRAMID_SIDES]);
        n = unit(n);
        p.normal[i] = ap_vec3_dot(n, axis) < 0 ? ap_vec3_scale(-1, n) : n; // mirrored frusta too
    }
    return p;
}

// Beside its sides, planes that may separate the pyramid from something about `centre` (tangent
// space) lean on one of its edges (i < 4) or on its apex and face the centre squarely. False where
// that one would cut the pyramid.
static bool leaning_plane(const struct pyramid *p, struct ap_vec3 centre, int i,
                          struct ap_vec3 *plane) {
    struct ap_vec3 c = ap_vec3_sub(centre, p->apex), n = ap_vec3_scale(-1, c);
    if (i < PYRAMID_SIDES)
        n = ap_vec3_add(n, ap_vec3_scale(ap_vec3_dot(c, p->edge[i]), p->edge[i]));
    n = unit(n);
    bool valid = ap_vec3_dot(n, n) > 0;
    for (int k = 0; k < PYRAMID_SIDES; k++)
        valid = valid && ap_vec3_dot(n, p->edge[k]) >= -1e-12;
    *plane = n;
    return valid;
}

// What is known of a piece of an object.
struct piece {
    struct ap_vec3 dir[MAX_CORNERS]; // of its corners as they are seen
    int count;
    double spread; // how far, as an angle, the thickening reaches out of the corners' hull
    double cos_spread, sin_spread;
    double near, far;    // nearest and farthest distance as seen
    struct ap_vec3 ball; // centre of a Euclidean ball around its image
    double ball_radius;  // INFINITY where there is none
};

// The ball about `centre` that holds a piece, with its image in tangent space (formulas: "How much
// is visible"). On the long way round a point at distance r is seen at 2·pi − r, and directions
// across the line of sight are stretched by r'/|sin r'| there as well; that is largest at an end of
// the range, since it falls and then rises between pi and 2·pi.
static void enclose(const struct sight *s, const struct polar *centre, double reach,
                    struct piece *piece) {
    bool s3 = s->space.kappa > 0;
    double lo = centre->r - reach, hi = centre->r + reach;
    if (s3 && reach >= M_PI / 2 - SLACK)
        lo = 0, hi = M_PI;
    double seen = s->image ? 2 * M_PI - centre->r : centre->r;
    double r0 = s->image ? 2 * M_PI - hi : lo, r1 = s->image ? 2 * M_PI - lo : hi;
    double stretch = 1;
    if (s3 && s->image)
        stretch = fmax(r0 / -sin(r0), r1 / -sin(r1));
    else if (s3)
        stretch = r1 / sin(r1);
    bool bounded = !s3 || (hi < M_PI - SLACK && (!s->image || lo > SLACK));
    piece->ball = ap_vec3_scale(s->image ? -seen : seen, centre->u);
    piece->ball_radius = bounded ? reach * stretch * (1 + SLACK) : INFINITY;
    piece->near = fmax(s->image ? fmax(r0, M_PI) : lo, 0) * (1 - SLACK);
    piece->far = (!s3 ? r1 : fmin(r1, s->image ? 2 * M_PI : M_PI)) * (1 + SLACK);
}

// The angle that a ball of the thickening's radius subtends at most, over distances lo…hi.
static double spread_of(const struct sight *s, double lo, double hi) {
    if (s->radius <= 0)
        return SLACK;
    bool s3 = s->space.kappa > 0;
    if (s->radius >= lo || (s3 && s->radius + hi >= M_PI))
        return M_PI;
    double away = s3 ? fmin(sin(lo), sin(hi)) : S(s, lo);
    double q = S(s, s->radius) / away;
    return q < 1 ? asin(q) + SLACK : M_PI;
}

static void describe(const struct sight *s, const struct polar *corners, int count,
                     const struct polar *centre, struct piece *piece) {
    double reach = 0;
    for (int i = 0; i < count; i++)
        reach = fmax(reach, polar_distance(s->space, centre, &corners[i]));
    enclose(s, centre, reach + s->radius, piece);
    double lo = fmax(centre->r - reach, 0), hi = centre->r + reach;
    if (s->space.kappa > 0 && reach >= M_PI / 2 - SLACK)
        lo = 0, hi = M_PI;
    piece->spread = spread_of(s, lo, hi);
    piece->count = count;
    for (int i = 0; i < count; i++) {
        piece->dir[i] = ap_vec3_scale(s->image ? -1 : 1, corners[i].u);
        if (ap_vec3_dot(corners[i].u, corners[i].u) == 0)
            piece->spread = M_PI; // at the nose or its antipode: seen everywhere
    }
    piece->cos_spread = cos(piece->spread);
    piece->sin_spread = sin(piece->spread);
}

// The cosine of the least angle between n and the piece's directions.
static double cone_cosine(const struct piece *piece, struct ap_vec3 n) {
    double most = -1;
    for (int i = 0; i < piece->count; i++)
        most = fmax(most, ap_vec3_dot(n, piece->dir[i]));
    // Corners that all lie behind the plane carry their whole hull with them, and the corner
    // nearest to the plane is the hull's nearest point; otherwise the hull may reach any direction.
    if ((most >= 0 && piece->count > 1) || most >= piece->cos_spread)
        return 1;
    return most * piece->cos_spread + sqrt(fmax(1 - most * most, 0)) * piece->sin_spread;
}

static bool hidden_behind(const struct sight *s, const struct piece *piece, struct ap_vec3 n) {
    double h = ap_vec3_dot(n, s->pyramid.apex);
    double c = cone_cosine(piece, n);
    // The largest n·Q over the cone between its nearest and farthest distance; for a plane through
    // the nose distances do not matter.
    if (h == 0 ? c < 0 : c * (c > 0 ? piece->far : piece->near) < h)
        return true;
    return ap_vec3_dot(n, piece->ball) + piece->ball_radius < h - SLACK * fabs(h);
}

static bool piece_hidden(const struct sight *s, const struct piece *piece) {
    for (int i = 0; i < PYRAMID_SIDES; i++)
        if (hidden_behind(s, piece, s->pyramid.normal[i]))
            return true;
    struct ap_vec3 plane;
    for (int i = 0; i <= PYRAMID_SIDES; i++)
        if (leaning_plane(&s->pyramid, piece->ball, i, &plane) && hidden_behind(s, piece, plane))
            return true;
    return false;
}

// For pieces whose image is a spherical polygon seen from the apex itself (tourist view): planes
// through two of the corners separate as well, and with the sides they are all there is to try.
static bool hidden_past_an_edge(const struct sight *s, const struct piece *piece) {
    if (ap_vec3_dot(s->pyramid.apex, s->pyramid.apex) > 0 || piece->count < 2 || piece->spread > 1)
        return false;
    for (int i = 0; i < piece->count; i++) {
        struct ap_vec3 n =
            ap_vec3_normalize(ap_vec3_cross(piece->dir[i], piece->dir[(i + 1) % piece->count]));
        double most = 0, least = 0, corner_most = -1, corner_least = 1;
        for (int k = 0; k < piece->count; k++) {
            most = fmax(most, ap_vec3_dot(n, piece->dir[k]));
            least = fmin(least, ap_vec3_dot(n, piece->dir[k]));
        }
        for (int k = 0; k < PYRAMID_SIDES; k++) {
            corner_most = fmax(corner_most, ap_vec3_dot(n, s->pyramid.edge[k]));
            corner_least = fmin(corner_least, ap_vec3_dot(n, s->pyramid.edge[k]));
        }
        double margin = piece->sin_spread;
        if ((most <= 1e-12 && corner_least > margin) || (least >= -1e-12 && corner_most < -margin))
            return true;
    }
    return false;
}

static bool corner_visible(const struct sight *s, const struct polar *corner) {
    double r = s->image ? -(2 * M_PI - corner->r) : corner->r;
    struct ap_vec3 q = ap_vec3_sub(ap_vec3_scale(r, corner->u), s->pyramid.apex);
    for (int i = 0; i < PYRAMID_SIDES; i++)
        if (ap_vec3_dot(s->pyramid.normal[i], q) < 0)
            return false;
    return true;
}

static struct polar centre_of(struct ap_space space, const struct polar *c, int count) {
    if (count == 1)
        return c[0];
    if (count == 2)
        return midpoint(space, &c[0], &c[1]);
    if (count > 3)
        return midpoint(space, &c[0], &c[count / 2]);
    // A triangle: the normalised sum of its corners.
    double n2 = 3, d = 0;
    for (int i = 0; i < 3; i++) {
        d = polar_distance(space, &c[i], &c[(i + 1) % 3]);
        n2 += 2 * ap_space_cos(space, d);
    }
    double n = space.kappa ? sqrt(fmax(n2, 0)) : 3;
    if (!(n > 1e-9))
        return c[0];
    struct ap_vec3 v = ap_vec3_add(ap_vec3_add(c[0].v, c[1].v), c[2].v);
    return polar_of(space, ap_vec3_scale(1 / n, v), (c[0].w + c[1].w + c[2].w) / n);
}

static bool hull_visible(const struct sight *s, const struct polar *corners, int count, int depth);

// Cuts a segment in two or a triangle in four.
static bool halves_visible(const struct sight *s, const struct polar *c, int count, int depth) {
    if (count == 2) {
        struct polar m = midpoint(s->space, &c[0], &c[1]);
        struct polar a[2] = {c[0], m}, b[2] = {m, c[1]};
        return hull_visible(s, a, 2, depth) || hull_visible(s, b, 2, depth);
    }
    struct polar m[3];
    for (int i = 0; i < 3; i++)
        m[i] = midpoint(s->space, &c[i], &c[(i + 1) % 3]);
    for (int i = 0; i < 3; i++) {
        struct polar part[3] = {c[i], m[i], m[(i + 2) % 3]};
        if (hull_visible(s, part, 3, depth))
            return true;
    }
    return hull_visible(s, m, 3, depth);
}

// Recursive, at most MAX_DEPTH deep, and shallow wherever the answer is plain.
static bool hull_visible(const struct sight *s, const struct polar *corners, int count, int depth) {
    for (int i = 0; i < count; i++)
        if (corner_visible(s, &corners[i]))
            return true;
    struct piece piece;
    struct polar centre = centre_of(s->space, corners, count);
    describe(s, corners, count, &centre, &piece);
    if (piece_hidden(s, &piece) || hidden_past_an_edge(s, &piece))
        return false;
    return depth == 0 || count < 2 || halves_visible(s, corners, count, depth - 1);
}

static bool bounds_visible(const struct sight *s, const struct polar *corners, int count) {
    if (count <= 3)
        return hull_visible(s, corners, count, MAX_DEPTH);
    for (int i = 0; i < count; i++)
        if (corner_visible(s, &corners[i]))
            return true;
    struct piece whole;
    struct polar centre = centre_of(s->space, corners, count);
    describe(s, corners, count, &centre, &whole);
    if (piece_hidden(s, &whole))
        return false;
    for (int i = 1; i + 1 < count; i++) {
        struct polar fan[3] = {corners[0], corners[i], corners[i + 1]};
        if (hull_visible(s, fan, 3, MAX_DEPTH))
            return true;
    }
    return false;
}

static struct pyramid pyramid_seen(const struct ap_viewer *viewer, int eye) {
    const struct ap_view_eye *e = &viewer->eye[eye];
    if (viewer->mode == AP_VIEW_TOURIST)
        return pyramid_of(&e->frustum, AP_QUAT_IDENTITY, (struct ap_vec3){0, 0, 0});
    return pyramid_of(&e->frustum, e->view_from_eye.q,
                      ap_vec3_scale(1 / viewer->space.rho_m, e->view_from_eye.p));
}

static void corners_of(const struct ap_viewer *viewer, const struct ap_bounds *bounds,
                       const struct ap_iso *sight_from_nose, struct polar *corners) {
    double rho = viewer->space.rho_m;
    for (int i = 0; i < bounds->count; i++) {
        struct ap_vec4 p = ap_iso_apply(sight_from_nose, bounds->nose_points[i]);
        struct ap_vec3 v = {p.x / rho, p.y / rho, p.z / rho};
        corners[i] = polar_of((struct ap_space){viewer->space.kappa, 1}, v, p.w / rho);
    }
}

// Seen by somebody born in another space: the object lies in a ball of tangent space, which exp
// takes into a ball of hers; there she is a tourist.
static unsigned visible_to_born(const struct ap_viewer *viewer, const struct ap_bounds *bounds,
                                int image) {
    struct sight s = {.space = {viewer->space.kappa, 1}, .image = image};
    s.radius = fmax(bounds->radius_m, 0) / viewer->space.rho_m;
    struct polar corners[MAX_CORNERS];
    struct ap_iso same = AP_ISO_IDENTITY;
    corners_of(viewer, bounds, &same, corners);
    struct polar centre = centre_of(s.space, corners, bounds->count);
    struct piece piece;
    describe(&s, corners, bounds->count, &centre, &piece);
    double radius_m = piece.ball_radius * viewer->space.rho_m;
    struct ap_vec3 middle = ap_vec3_scale(viewer->space.rho_m, piece.ball);
    double reach_m = radius_m, far = (ap_vec3_length(middle) + reach_m) / viewer->born.rho_m;
    if (!(far < 300)) // nothing is known; beyond, cosh has no use for a bound
        return 3;
    if (viewer->born.kappa < 0 && far > 0)
        radius_m *= sinh(far) / far; // exp stretches what lies across the line of sight
    struct ap_vec4 at = ap_exp(viewer->born, middle);
    struct ap_viewer tourist = *viewer;
    tourist.space = viewer->born;
    tourist.mode = AP_VIEW_TOURIST;
    struct ap_bounds ball = {&at, 1, radius_m * (1 + SLACK)};
    double near = far - 2 * reach_m / viewer->born.rho_m;
    unsigned seen = 0;
    if (viewer->born.kappa <= 0 || near < M_PI + SLACK)
        seen |= ap_visible_eyes(&tourist, &ball, 0);
    if (viewer->born.kappa > 0 && far > M_PI - SLACK && near < 2 * M_PI)
        seen |= ap_visible_eyes(&tourist, &ball, 1);
    return seen;
}

unsigned ap_visible_eyes(const struct ap_viewer *viewer, const struct ap_bounds *bounds,
                         int image) {
    if (image != 0 && (image != 1 || viewer->space.kappa <= 0))
        return 0;
    if (bounds->count < 1)
        return 0;
    if (bounds->count > MAX_CORNERS)
        return 3;
    if (viewer->mode == AP_VIEW_BORN)
        return visible_to_born(viewer, bounds, image);
    struct sight s = {.space = {viewer->space.kappa, 1}, .image = image};
    s.radius = fmax(bounds->radius_m, 0) / viewer->space.rho_m;
    struct polar corners[MAX_CORNERS];
    bool tourist = viewer->mode == AP_VIEW_TOURIST;
    unsigned seen = 0;
    for (int e = 0; e < 2; e++) {
        s.pyramid = pyramid_seen(viewer, e);
        struct ap_iso sight_from_nose = tourist ? ap_eye_from_nose(viewer, e) : AP_ISO_IDENTITY;
        if (tourist || e == 0) // in native view both eyes look at the same tangent space
            corners_of(viewer, bounds, &sight_from_nose, corners);
        seen |= bounds_visible(&s, corners, bounds->count) ? 1u << e : 0u;
    }
    return seen;
}

bool ap_turned_away(const struct ap_viewer *viewer, double eye_m, const struct ap_facing *facing,
                    int image) {
    const struct ap_space space = {viewer->space.kappa, 1};
    double rho = viewer->space.rho_m, least = INFINITY, sign = image ? 1 : -1;
    const struct ap_vec3 nose = {facing->nose.x, facing->nose.y, facing->nose.z};
    if (facing->count == 0 || viewer->mode == AP_VIEW_BORN)
        return false;
    for (int i = 0; i < facing->count; i++)
        least = fmin(least, sign * ap_vec3_dot(nose, facing->out[i]) / rho);
    if (!(least > 0))
        return false;
    double apart = 2 * eye_m / rho, far = facing->far_m / rho, near = facing->near_m / rho;
    if (space.kappa > 0) // lengths across the line of sight are stretched: h or more
        return far < M_PI - 0.3 && (!image || near > 0.3) &&
               asin(fmin(least, 1)) - facing->bulge_m / rho > apart;
    // How far a plane passes that touches the image at the distance `far`, where it is least: the
    // normal's part along the line of sight is S(h)/S(far), the rest counts S(far)/far times in
    // tangent space.
    double reach = ap_space_sin(space, far), c = fmin(least / reach, 1), stretch = reach / far;
    double plane = far * c / sqrt(c * c + (1 - c * c) * stretch * stretch);
    return plane > apart;
}
