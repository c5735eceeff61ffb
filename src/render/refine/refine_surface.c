#include "src/render/refine/refine_surface.h"

#include <math.h>

static const double PI = 3.14159265358979323846;

// hypot would take half of all the time here, for lengths that do not occur.
static double length(struct ap_vec3 v) {
    return sqrt(ap_vec3_dot(v, v));
}

static struct ap_vec3 unit(struct ap_vec3 v) {
    double n = length(v);
    return n > 0 ? ap_vec3_scale(1 / n, v) : v;
}

enum ap_surface_shape ap_surface_shape_of(const struct ap_part *part) {
    if (part->kind == AP_PART_BALL || part->form == AP_FORM_SPHERE)
        return AP_SURFACE_BALL;
    return part->kind == AP_PART_STICK || part->form == AP_FORM_TUBE ? AP_SURFACE_TUBE
                                                                     : AP_SURFACE_SHEET;
}

bool ap_surface_is_bare(const struct ap_part *part) {
    return part->finish <= AP_FINISH_MATTE && ap_surface_shape_of(part) != AP_SURFACE_SHEET;
}

struct ap_surface ap_surface_of(const struct ap_viewer *viewer, const struct ap_eyes *eyes,
                                const struct ap_part *part, struct ap_iso nose_from_part,
                                int image) {
    struct ap_surface s = {.part = part,
                           .shape = ap_surface_shape_of(part),
                           .bare = ap_surface_is_bare(part),
                           .space = viewer->space,
                           .mode = viewer->mode,
                           .born = ap_viewer_born(viewer),
                           .image = image,
                           .nose_from_part = nose_from_part};
    double r = part->radius_m / s.space.rho_m;
    s.sine = ap_space_sin(s.space, r);
    s.cosine = ap_space_cos(s.space, r);
    for (int e = 0; e < 2; e++) {
        s.eye_from_part[e] = eyes->eye_from_nose[e];
        if (s.mode == AP_VIEW_TOURIST)
            s.eye_from_part[e] = ap_iso_mul(eyes->eye_from_nose[e], nose_from_part);
        s.eye_from_view[e] = ap_iso_from_pose((struct ap_space){0, 1},
                                              ap_pose_inverse(viewer->eye[e].view_from_eye));
        s.eye_m[e] = viewer->eye[e].view_from_eye.p;
        const struct ap_frustum *f = &viewer->eye[e].frustum;
        const struct ap_vec3 side[4] = {
            {1, 0, f->left}, {-1, 0, -f->right}, {0, 1, f->down}, {0, -1, -f->up}};
        for (int k = 0; k < 4; k++)
            s.inward[e][k] = ap_vec3_normalize(side[k]);
    }
    return s;
}

// The radius of a ball, or of a stick at the place `at` along its axis, over rho.
static double stick_radius(const struct ap_surface *s, double at) {
    if (s->part->kind != AP_PART_STICK)
        return s->part->radius_m / s->space.rho_m;
    double t = at * s->space.rho_m / s->part->length_m + 0.5;
    t = fmin(fmax(t, 0), 1);
    return (s->part->radius_m + t * (s->part->radius2_m - s->part->radius_m)) / s->space.rho_m;
}

static void radius_at(const struct ap_surface *s, double along, double *sine, double *cosine) {
    *sine = s->sine;
    *cosine = s->cosine;
    if (s->part->kind != AP_PART_STICK || s->part->radius_m == s->part->radius2_m)
        return;
    double r = stick_radius(s, along);
    *sine = ap_space_sin(s->space, r);
    *cosine = ap_space_cos(s->space, r);
}

// The axis of a stick is z, that of a solid's tube x.
static struct ap_vec4 turned(const struct ap_surface *s, struct ap_vec4 p) {
    return s->part->form == AP_FORM_TUBE ? (struct ap_vec4){p.z, p.x, p.y, p.w} : p;
}

struct ap_surface_point ap_surface_point_of(const struct ap_surface *s, struct ap_vec4 p) {
    struct ap_surface_point point = {.cosine = 1, .p = p};
    if (s->shape == AP_SURFACE_SHEET)
        point.p.y = 0;
    else if (s->shape == AP_SURFACE_BALL)
        point.from = unit((struct ap_vec3){p.x, p.y, p.z});
    else {
        point.from = unit((struct ap_vec3){p.y, p.z, 0});
        ap_surface_place(s,
                         s->space.kappa > 0   ? atan2(p.x, p.w)
                         : s->space.kappa < 0 ? atanh(p.x / p.w)
                                              : p.x / p.w,
                         &point);
    }
    return point;
}

void ap_surface_place(const struct ap_surface *s, double along, struct ap_surface_point *point) {
    point->along = along;
    point->sine = ap_space_sin(s->space, along);
    point->cosine = ap_space_cos(s->space, along);
}

// A point as far as `across` is the sine and `home` the cosine of, from the axis; with those turned
// by a quarter the normal there.
static struct ap_vec4 around_axis(struct ap_space space, const struct ap_surface_point *point,
                                  double across, double home) {
    double ss = point->sine, cs = point->cosine;
    struct ap_vec3 u = ap_vec3_scale(across, point->from);
    return (struct ap_vec4){u.x, u.y, cs * u.z + ss * home, cs * home - space.kappa * ss * u.z};
}

struct ap_vec4 ap_surface_normal(const struct ap_surface *s, const struct ap_surface_point *point) {
    if (s->shape == AP_SURFACE_SHEET)
        return (struct ap_vec4){0, 1, 0, 0};
    if (s->part->kind == AP_PART_BALL)
        return (struct ap_vec4){point->from.x, point->from.y, point->from.z, 0};
    double sine, cosine;
    radius_at(s, point->along, &sine, &cosine);
    return turned(s, around_axis(s->space, point, cosine, -s->space.kappa * sine));
}

// At X the line of sight from E goes on as (C·X − E)/S, up to a sign, and <N, X> = 0.
static double tourist_away(const struct ap_surface *s, int e, struct ap_vec4 n,
                           const struct ap_surface_point *point) {
    const double(*m)[4] = s->eye_from_part[e].m;
    double w = m[3][0] * n.x + m[3][1] * n.y + m[3][2] * n.z + m[3][3] * n.w;
    double sine = length(point->seen[e]) / s->space.rho_m, away = -s->space.kappa * w / sine;
    if (s->space.kappa == 0) {
        struct ap_vec4 turned_n = ap_iso_apply(&s->eye_from_part[e], n);
        away = ap_vec3_dot((struct ap_vec3){turned_n.x, turned_n.y, turned_n.z}, point->toward[e]);
    }
    return s->image ? -away : away;
}

// The log map keeps lengths along the line of sight and stretches those across it; a normal is
// stretched the other way.
void ap_surface_face(const struct ap_surface *s, struct ap_surface_point *point) {
    struct ap_vec4 n = ap_surface_normal(s, point);
    if (s->part->kind == AP_PART_BALL)
        n = (struct ap_vec4){s->cosine * n.x, s->cosine * n.y, s->cosine * n.z,
                             -s->space.kappa * s->sine};
    for (int e = 0; e < 2 && s->mode == AP_VIEW_TOURIST; e++)
        point->away[e] = tourist_away(s, e, n, point);
    if (s->mode != AP_VIEW_NATIVE)
        return;
    n = ap_iso_apply(&s->nose_from_part, n);
    double d = length(point->tangent_m), t = d / s->space.rho_m; // of image 1 beyond half a turn
    struct ap_vec3 u = ap_vec3_scale(1 / d, point->tangent_m), across = {n.x, n.y, n.z};
    // Along the way that leads there, which is u in both images.
    double ss = ap_space_sin(s->space, t), along = ap_vec3_dot(across, u);
    double away = ap_space_cos(s->space, t) * along - ss * n.w;
    across = ap_vec3_sub(across, ap_vec3_scale(along, u));
    point->outward = unit(ap_vec3_add(ap_vec3_scale(away, u), ap_vec3_scale(ss / t, across)));
}

// The log map by its plain formula, good to 5e-15 (docs/accuracy.md), at a third of the time: a
// frame's triangles ask for it millions of times.
static struct ap_vec3 log_of(struct ap_space space, struct ap_vec4 p, int image) {
    struct ap_vec3 v = {p.x, p.y, p.z};
    double r = length(v) / space.rho_m, w = p.w / space.rho_m, theta;
    if (space.kappa == 0)
        return ap_vec3_scale(1 / w, v);
    if (r < 1e-7) // there the formula has nothing to divide by
        return ap_log_unchecked(space, p, image);
    theta = space.kappa < 0 ? asinh(r) : atan2(r, w);
    return ap_vec3_scale((image ? theta - 2 * PI : theta) / r, v);
}

static struct ap_vec3 from_view(const struct ap_surface *s, int e, struct ap_vec3 v) {
    const double(*m)[4] = s->eye_from_view[e].m;
    return (struct ap_vec3){m[0][0] * v.x + m[0][1] * v.y + m[0][2] * v.z + m[0][3],
                            m[1][0] * v.x + m[1][1] * v.y + m[1][2] * v.z + m[1][3],
                            m[2][0] * v.x + m[2][1] * v.y + m[2][2] * v.z + m[2][3]};
}

static void see_from(struct ap_surface_point *point, int e, struct ap_vec3 seen) {
    point->seen[e] = seen;
    point->toward[e] = unit(seen);
}

static double share_of(double across, double shown) {
    return shown > 0 ? across / shown : 1;
}

void ap_surface_see(const struct ap_surface *s, struct ap_surface_point *point) {
    double rho = s->space.rho_m;
    if (s->shape != AP_SURFACE_SHEET) {
        double sine, cosine;
        radius_at(s, point->along, &sine, &cosine);
        point->p = turned(s, around_axis(s->space, point, sine, cosine));
    }
    struct ap_vec4 p_m = {rho * point->p.x, rho * point->p.y, rho * point->p.z, rho * point->p.w};
    if (s->mode == AP_VIEW_TOURIST) {
        double sign = s->image ? -1 : 1;
        for (int e = 0; e < 2; e++) {
            struct ap_vec4 q = ap_iso_apply(&s->eye_from_part[e], p_m);
            see_from(point, e, ap_vec3_scale(sign, (struct ap_vec3){q.x, q.y, q.z}));
        }
        point->share = 1;
        return;
    }
    struct ap_vec4 nose = ap_iso_apply(&s->nose_from_part, p_m);
    double across = length((struct ap_vec3){nose.x, nose.y, nose.z});
    point->tangent_m = log_of(s->space, nose, s->image);
    point->share = share_of(across, length(point->tangent_m));
    if (s->mode == AP_VIEW_BORN) {
        struct ap_born_point born =
            ap_born_from_tangent(s->born, (struct ap_tangent_point){point->tangent_m});
        point->share = share_of(across, length((struct ap_vec3){born.x.x, born.x.y, born.x.z}));
        for (int e = 0; e < 2; e++) {
            struct ap_vec4 q = ap_iso_apply(&s->eye_from_part[e], born.x);
            double sign = born.behind ? -1 : 1;
            see_from(point, e, ap_vec3_scale(sign, (struct ap_vec3){q.x, q.y, q.z}));
        }
        return;
    }
    for (int e = 0; e < 2; e++)
        see_from(point, e, from_view(s, e, point->tangent_m));
}

struct ap_surface_point ap_surface_middle(const struct ap_surface *s,
                                          const struct ap_surface_point *a,
                                          const struct ap_surface_point *b) {
    struct ap_surface_point m = {0};
    if (s->shape != AP_SURFACE_SHEET) {
        // Halfway between two points of a line of the plane, in the space's own measure.
        double ss = a->sine + b->sine, cs = a->cosine + b->cosine;
        double n = s->space.kappa > 0   ? sqrt(cs * cs + ss * ss)
                   : s->space.kappa < 0 ? sqrt(cs * cs - ss * ss)
                                        : cs;
        m.along = (a->along + b->along) / 2;
        m.sine = ss / n;
        m.cosine = cs / n;
        m.from = unit(ap_vec3_add(a->from, b->from));
    } else {
        struct ap_vec4 p = {a->p.x + b->p.x, 0, a->p.z + b->p.z, a->p.w + b->p.w};
        double r2 = p.x * p.x + p.z * p.z;
        double n = s->space.kappa > 0   ? sqrt(p.w * p.w + r2)
                   : s->space.kappa < 0 ? sqrt(p.w * p.w - r2)
                                        : p.w;
        m.p = (struct ap_vec4){p.x / n, 0, p.z / n, p.w / n};
    }
    ap_surface_see(s, &m);
    return m;
}

static double clamped(double t) {
    return t < 0 ? 0 : t > 1 ? 1 : t;
}

// The direction u against the nearest of those of the straight line between the directions p and q;
// the square of the angle, by its sine. Of a plane through the eye, however long the line is.
static double off_line2(struct ap_vec3 p, struct ap_vec3 q, struct ap_vec3 u) {
    struct ap_vec3 across = ap_vec3_cross(p, q), along = ap_vec3_sub(q, p);
    double size = ap_vec3_dot(across, across), up = ap_vec3_dot(u, p), uq = ap_vec3_dot(u, q),
           pq = ap_vec3_dot(p, q);
    if (size > 1e-16 && uq >= up * pq && up >= uq * pq) {
        double off = ap_vec3_dot(u, across);
        return off * off / size;
    }
    double square = ap_vec3_dot(along, along);
    double t = square > 0 ? ap_vec3_dot(ap_vec3_sub(u, p), along) / square : 0;
    struct ap_vec3 c = ap_vec3_add(p, ap_vec3_scale(clamped(t), along)), x = ap_vec3_cross(u, c);
    return ap_vec3_dot(u, c) > 0 ? ap_vec3_dot(x, x) / ap_vec3_dot(c, c) : 4;
}

// How far m is from the straight line from a to b, of its distance, squared.
static double off_chord2(struct ap_vec3 a, struct ap_vec3 b, struct ap_vec3 m) {
    struct ap_vec3 along = ap_vec3_sub(b, a), from = ap_vec3_sub(m, a);
    double square = ap_vec3_dot(along, along);
    double t = square > 0 ? ap_vec3_dot(from, along) / square : 0;
    struct ap_vec3 off = ap_vec3_sub(from, ap_vec3_scale(t, along));
    return ap_vec3_dot(off, off) / ap_vec3_dot(m, m);
}

// Where an eye sees the place of the straight edge from a to b that stands for the surface at the
// share k of it: coordinates are interpolated times what log (or exp after it) made of them
// (shaders/part.glsl), so it is what the nose sees in the direction of that place on the geodesic.
static struct ap_vec3 drawn(const struct ap_surface_point *a, const struct ap_surface_point *b,
                            double k, int e) {
    double x = (1 - k) * a->share, y = k * b->share, sum = x + y;
    return ap_vec3_add(ap_vec3_scale(x / sum, a->seen[e]), ap_vec3_scale(y / sum, b->seen[e]));
}

// Pixels a radian at this place of the picture, at most those at its corner.
static double pixels_at(const struct ap_eyes *eyes, int e, struct ap_vec3 seen) {
    double across = seen.x * seen.x + seen.y * seen.y, ahead = seen.z * seen.z;
    double corner = eyes->slope[e] * eyes->slope[e];
    double slope2 = across < corner * ahead ? across / ahead : corner;
    return eyes->pixels[e] * (1 + slope2);
}

bool ap_surface_is_straight(const struct ap_surface *s) {
    bool flat = s->mode == AP_VIEW_NATIVE && s->space.kappa == 0;
    return s->shape == AP_SURFACE_SHEET && (s->mode == AP_VIEW_TOURIST || flat);
}

double ap_surface_error_px(const struct ap_surface *s, const struct ap_eyes *eyes,
                           const struct ap_surface_point *a, const struct ap_surface_point *b,
                           double k, const struct ap_surface_point *m) {
    double worst = 0;
    bool native = s->mode == AP_VIEW_NATIVE, sheet = s->shape == AP_SURFACE_SHEET;
    if (ap_surface_is_straight(s))
        return 0;
    for (int e = 0; e < 2; e++) {
        struct ap_vec3 c = drawn(a, b, k, e), u = m->toward[e], x = ap_vec3_cross(c, u);
        // Squares: of the angle, by its sine, and of the error in depth.
        double square = ap_vec3_dot(c, u) > 0 ? ap_vec3_dot(x, x) / ap_vec3_dot(c, c) : 4;
        double pixels = pixels_at(eyes, e, m->seen[e]);
        if (s->bare) {
            double deep = off_chord2(a->seen[e], b->seen[e], m->seen[e]) / 16;
            // Along itself, too, where s3 stretches it so that its depth is not looked at.
            double along = native && s->any_depth ? square / 16 : 0;
            square = fmax(off_line2(a->toward[e], b->toward[e], u), along);
            square = native && !s->any_depth && deep > square ? deep : square;
        } else if (native && !s->any_depth) {
            struct ap_vec3 off = ap_vec3_sub(c, m->seen[e]);
            double deep = ap_vec3_dot(off, off) / ap_vec3_dot(m->seen[e], m->seen[e]) / 16;
            if (sheet) // the sum of both
                square += deep + 2 * sqrt(square * deep);
            else
                square = deep > square ? deep : square;
        }
        square *= pixels * pixels;
        worst = square <= worst ? worst : square; // what is no number is the worst
    }
    return sqrt(worst);
}

// What lies outside a plane of a frustum by so much of the longest edge cannot bulge into the
// picture.
static const double BULGE = 0.6;

static struct ap_vec3 place_from(const struct ap_surface *s, const struct ap_surface_point *p,
                                 int e) {
    return s->mode == AP_VIEW_TOURIST ? p->toward[e] : p->seen[e];
}

// Native: metres; tourist: directions.
bool ap_surface_out_of_sight(const struct ap_surface *s,
                             const struct ap_surface_point *const p[3]) {
    double reach = s->mode == AP_VIEW_TOURIST ? 0.5 : s->space.rho_m / 2;
    if (s->mode == AP_VIEW_BORN)
        return false;
    for (int e = 0; e < 2; e++) {
        struct ap_vec3 at[3];
        double longest = 0;
        for (int i = 0; i < 3; i++)
            at[i] = place_from(s, p[i], e);
        for (int i = 0; i < 3; i++)
            longest = fmax(longest, length(ap_vec3_sub(at[i], at[(i + 1) % 3])));
        if (longest > reach)
            return false;
        bool out = false;
        for (int k = 0; k < 4 && !out; k++) {
            struct ap_vec3 n = s->inward[e][k];
            double limit = -BULGE * longest;
            out = ap_vec3_dot(n, at[0]) < limit && ap_vec3_dot(n, at[1]) < limit &&
                  ap_vec3_dot(n, at[2]) < limit;
        }
        if (!out)
            return false;
    }
    return true;
}
