#include "src/geom/map.h"

#include "src/geom/arc.h"

struct ap_vec4 ap_exp(struct ap_space space, struct ap_vec3 v) {
    struct ap_vec4 flat = {v.x, v.y, v.z, space.rho_m};
    if (space.kappa == 0)
        return flat;
    struct ap_arc arc = ap_arc_of(space, v);
    struct ap_turn turn = ap_turn_of(space, arc.t);
    flat.w = space.rho_m * turn.c;
    if (arc.t.hi < 1e-8) // S = t to 2e-17 of it, and v has lost nothing
        return flat;
    double r = space.rho_m * turn.s;
    return (struct ap_vec4){r * arc.unit.x, r * arc.unit.y, r * arc.unit.z, flat.w};
}

// asinh of |(x,y,z)|/rho, also where that overflows (a small radius and a far point).
static double asinh_of_quotient(double n_m, double rho_m) {
    double r = ap_quotient_dd(ap_dd_of(n_m), rho_m).hi;
    return isfinite(r) ? asinh(r) : log(n_m) - log(rho_m / 2);
}

struct ap_vec3 ap_log_unchecked(struct ap_space space, struct ap_vec4 p, int image) {
    struct ap_vec3 v = {p.x, p.y, p.z};
    if (space.kappa == 0) {
        double f = space.rho_m / p.w;
        return f == 1 ? v : ap_vec3_scale(f, v);
    }
    struct ap_vec3 unit;
    double n = ap_polar(v, &unit), theta;
    if (!(n > 0))
        return v;
    if (space.kappa < 0) {
        theta = asinh_of_quotient(n, space.rho_m);
    } else {
        theta = atan2(n, p.w);
        if (image) // 2·pi − theta, with what the double 2·pi lacks
            theta = -((6.283185307179586 - theta) + 2.4492935982947064e-16);
    }
    if (fabs(theta) < 1e-8 && p.w > 0) // theta = r to 2e-17 of it
        return space.kappa < 0 ? v : ap_vec3_scale(space.rho_m / p.w, v);
    return ap_vec3_scale(theta * space.rho_m, unit);
}

double ap_base_distance(struct ap_space space, struct ap_vec4 p) {
    double r = sqrt(p.x * p.x + p.y * p.y + p.z * p.z), rho = space.rho_m;
    return space.kappa == 0  ? r * (rho / p.w)
           : space.kappa < 0 ? rho * asinh(r / rho)
                             : rho * atan2(r, p.w);
}

static bool is_finite(struct ap_vec4 p) {
    return isfinite(p.x) && isfinite(p.y) && isfinite(p.z) && isfinite(p.w);
}

enum ap_status ap_point_check(struct ap_error *err, struct ap_space space, struct ap_vec4 p) {
    const double tolerance = 1e-9, rho = space.rho_m;
    const char *name = ap_space_name(space);
    if (!is_finite(p))
        return ap_fail(err, AP_INPUT, "the point (%g, %g, %g, %g) is not finite", p.x, p.y, p.z,
                       p.w);
    if (space.kappa < 0 && p.w <= 0)
        return ap_fail(err, AP_INPUT, "the point is not on h3: its w is %.9g, must be above 0",
                       p.w);
    double n = ap_length_dd((struct ap_vec3){p.x, p.y, p.z}).hi, off, most;
    if (space.kappa < 0) {
        off = fabs(p.w - hypot(rho, n));
        most = tolerance * p.w;
    } else {
        off = fabs((space.kappa > 0 ? hypot(n, p.w) : p.w) - rho);
        most = tolerance * rho;
    }
    if (off <= most)
        return AP_OK;
    return ap_fail(err, AP_INPUT,
                   "the point (%.17g, %.17g, %.17g, %.17g) is %.3g m off %s of radius %g m "
                   "(allowed: %.3g m)",
                   p.x, p.y, p.z, p.w, off, name, rho, most);
}

enum ap_status ap_log_map(struct ap_error *err, struct ap_space space, struct ap_vec4 p, int image,
                          struct ap_vec3 *v_m) {
    enum ap_status st = ap_point_check(err, space, p);
    if (st)
        return st;
    if (image != 0 && (image != 1 || space.kappa <= 0))
        return ap_fail(err, AP_INPUT, "%s has no image %d of a point (s3 has 0 and 1, others 0)",
                       ap_space_name(space), image);
    bool on_axis = p.x == 0 && p.y == 0 && p.z == 0;
    if (on_axis && space.kappa > 0 && p.w < 0)
        return ap_fail(err, AP_INPUT, "the antipode lies in every direction: its log is undefined");
    if (on_axis && image == 1)
        return ap_fail(err, AP_INPUT, "the long way round to the base point has no direction");
    *v_m = ap_log_unchecked(space, p, image);
    return AP_OK;
}

// The squared length of a×b, each product exact, so that nearly parallel vectors keep their angle.
static double cross_length(struct ap_vec3 a, struct ap_vec3 b) {
    return ap_vec3_length((struct ap_vec3){ap_dd_minor(a.y, b.z, a.z, b.y).hi,
                                           ap_dd_minor(a.z, b.x, a.x, b.z).hi,
                                           ap_dd_minor(a.x, b.y, a.y, b.x).hi});
}

static struct ap_dd dot_dd(struct ap_vec3 a, struct ap_vec3 b) {
    struct ap_dd sum = ap_dd_add(ap_dd_two_product(a.x, b.x), ap_dd_two_product(a.y, b.y));
    return ap_dd_add(sum, ap_dd_two_product(a.z, b.z));
}

// Coordinates in units near rho, by a power of two: no square overflows that need not.
static struct ap_vec4 near_one(struct ap_vec4 p, int exponent) {
    return (struct ap_vec4){ldexp(p.x, -exponent), ldexp(p.y, -exponent), ldexp(p.z, -exponent),
                            ldexp(p.w, -exponent)};
}

// The angle between the two 4-vectors, from their six minors and their product.
static double angle_s3(struct ap_vec4 p, struct ap_vec4 q) {
    struct ap_vec3 a = {p.x, p.y, p.z}, b = {q.x, q.y, q.z};
    double with_w = ap_vec3_length((struct ap_vec3){ap_dd_minor(p.x, q.w, p.w, q.x).hi,
                                                    ap_dd_minor(p.y, q.w, p.w, q.y).hi,
                                                    ap_dd_minor(p.z, q.w, p.w, q.z).hi});
    double dot = ap_dd_add(dot_dd(a, b), ap_dd_two_product(p.w, q.w)).hi;
    return atan2(hypot(cross_length(a, b), with_w), dot);
}

static double distance_e3(struct ap_vec4 p, struct ap_vec4 q, double rho) {
    struct ap_vec3 d = {ap_dd_minor(p.x, q.w, q.x, p.w).hi, ap_dd_minor(p.y, q.w, q.y, p.w).hi,
                        ap_dd_minor(p.z, q.w, q.z, p.w).hi};
    return ap_vec3_length(d) / (p.w * q.w) * rho;
}

// |p/|p| − q/|q||, from the sine of the angle where it is less than a right one.
static double chord_of_directions(struct ap_vec3 p, struct ap_vec3 q) {
    double size_p = ap_length_dd(p).hi, size_q = ap_length_dd(q).hi;
    if (!(size_p > 0 && size_q > 0))
        return 0;
    int ep = ilogb(size_p), eq = ilogb(size_q); // powers of two, so that nothing is rounded
    p = (struct ap_vec3){ldexp(p.x, -ep), ldexp(p.y, -ep), ldexp(p.z, -ep)};
    q = (struct ap_vec3){ldexp(q.x, -eq), ldexp(q.y, -eq), ldexp(q.z, -eq)};
    double sizes = ldexp(size_p, -ep) * ldexp(size_q, -eq), dot = dot_dd(p, q).hi;
    return dot > 0 ? cross_length(p, q) * sqrt(2 / (sizes * (sizes + dot)))
                   : sqrt(2 * (1 - dot / sizes));
}

// asinh(a) − asinh(b) for a = |p|/rho, b = |q|/rho: (a² − b²)/sinh(asinh a + asinh b), the squares
// subtracted before anything is rounded.
static double radial_difference(struct ap_vec3 p, struct ap_vec3 q, double a, double b,
                                double rho) {
    if (a > 1e100 || b > 1e100)
        return asinh(a) - asinh(b);
    const double ps[3] = {p.x, p.y, p.z}, qs[3] = {q.x, q.y, q.z};
    struct ap_dd squares = {0, 0};
    for (int i = 0; i < 3; i++)
        squares = ap_dd_add(squares,
                            ap_dd_mul(ap_dd_two_sum(ps[i], -qs[i]), ap_dd_two_sum(ps[i], qs[i])));
    double sum = a * hypot(1, b) + b * hypot(1, a);
    return sum > 0 ? asinh(squares.hi / rho / rho / sum) : 0;
}

// sinh²(d/2) = sinh²((a − b)/2) + sinh a·sinh b·sin²(gamma/2), with the distances a, b from the
// base point and the angle gamma between them: a sum of squares, in which nothing cancels.
static double arc_h3(struct ap_vec3 p, struct ap_vec3 q, double rho) {
    double sinh_a = ap_length_dd(p).hi / rho, sinh_b = ap_length_dd(q).hi / rho;
    double radial = radial_difference(p, q, sinh_a, sinh_b, rho);
    double sideways = chord_of_directions(p, q) / 2 * (sqrt(sinh_a) * sqrt(sinh_b));
    return 2 * asinh(hypot(sinh(radial / 2), sideways));
}

enum ap_status ap_distance(struct ap_error *err, struct ap_space space, struct ap_vec4 p,
                           struct ap_vec4 q, double *d_m) {
    enum ap_status st = ap_point_check(err, space, p);
    if (!st)
        st = ap_point_check(err, space, q);
    if (st)
        return st;
    int e;
    double rho = frexp(space.rho_m, &e);
    p = near_one(p, e);
    q = near_one(q, e);
    double d;
    if (space.kappa > 0)
        d = angle_s3(p, q) * rho;
    else if (space.kappa == 0)
        d = distance_e3(p, q, rho);
    else
        d = arc_h3((struct ap_vec3){p.x, p.y, p.z}, (struct ap_vec3){q.x, q.y, q.z}, rho) * rho;
    *d_m = ldexp(d, e);
    return AP_OK;
}
