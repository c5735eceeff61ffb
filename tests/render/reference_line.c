#include "tests/render/reference_surface.h"

#include <math.h>

static const double PI = 3.14159265358979323846;

void ref_exp(int kappa, const double t[3], double x[4]) {
    double r = sqrt(t[0] * t[0] + t[1] * t[1] + t[2] * t[2]), c, s;
    ref_cos_sin(kappa, r, &c, &s);
    double k = r > 0 ? s / r : 1;
    for (int i = 0; i < 3; i++)
        x[i] = k * t[i];
    x[3] = c;
}

static double dot3(const double a[3], const double b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

void ref_ray_point(const struct ref_ray *ray, double t, double x[4]) {
    double c, s, p[3];
    if (ray->tourist) {
        ref_cos_sin(ray->kappa, t, &c, &s);
        for (int i = 0; i < 4; i++)
            x[i] = c * ray->from[i] + s * ray->to[i];
        return;
    }
    for (int i = 0; i < 3; i++)
        p[i] = ray->from[i] + t * ray->to[i];
    ref_exp(ray->kappa, p, x);
}

double ref_ray_end(const struct ref_ray *ray) {
    if (ray->kappa <= 0)
        return INFINITY;
    if (ray->tourist)
        return 2 * PI;
    double b = dot3(ray->from, ray->to), c = dot3(ray->from, ray->from) - 4 * PI * PI;
    return -b + sqrt(b * b - c);
}

double ref_far(const struct ref_ray *ray, double t) {
    double p[3];
    if (ray->tourist)
        return t;
    for (int i = 0; i < 3; i++)
        p[i] = ray->from[i] + t * ray->to[i];
    return sqrt(dot3(p, p));
}

static bool forbidden_at(const struct ref_search *s, double t) {
    double far = ref_far(s->ray, t);
    return s->ray->kappa > 0 &&
           (fabs(far - PI) < s->forbidden || far > 2 * PI - (s->ray->tourist ? s->forbidden : 0));
}

// exp stretches h3's tangent space by up to sinh(r)/r across, at the distance r.
double ref_steepest(const struct ref_ray *ray, struct ref_span span) {
    double most = 0;
    if (ray->kappa >= 0 || ray->tourist)
        return 1;
    for (int side = 0; side < 2; side++) {
        double p[3], t = side ? span.end : span.begin;
        for (int i = 0; i < 3; i++)
            p[i] = ray->from[i] + t * ray->to[i];
        most = fmax(most, sqrt(dot3(p, p)));
    }
    return most > 0 ? sinh(most) / most : 1;
}

double ref_value_at(const struct ref_search *s, double t) {
    double x[4];
    ref_ray_point(s->ray, t, x);
    return ref_value(s->surfaces, s->p, x);
}

// By regula falsi with halving (Illinois), between two signs.
double ref_root(const struct ref_search *s, double a, double fa, double b, double fb) {
    for (int i = 0, side = 0; i < 100 && fabs(b - a) > 1e-15 + 4e-16 * fabs(b); i++) {
        double t = i % 8 == 7 ? (a + b) / 2 : (a * fb - b * fa) / (fb - fa);
        double f = ref_value_at(s, t);
        if (f == 0)
            return t;
        if ((f > 0) == (fb > 0)) {
            b = t;
            fb = f;
            fa *= side < 0 ? 0.5 : 1;
            side = -1;
        } else {
            a = t;
            fa = f;
            fb *= side > 0 ? 0.5 : 1;
            side = 1;
        }
    }
    return fabs(fa) < fabs(fb) ? a : b;
}

// Towards zero between a and b, by golden section, until it is crossed. *f: there.
static double dip_between(const struct ref_search *s, double a, double b, double sign, double *f) {
    const double g = 0.6180339887498949;
    double c = b - g * (b - a), d = a + g * (b - a);
    double fc = sign * ref_value_at(s, c), fd = sign * ref_value_at(s, d);
    for (int i = 0;
         i < 60 && fmin(fc, fd) > 0 && fmin(fc, fd) < s->steep * (b - a) && b - a > 1e-12; i++)
        if (fc < fd) {
            b = d;
            d = c;
            fd = fc;
            fc = sign * ref_value_at(s, c = b - g * (b - a));
        } else {
            a = c;
            c = d;
            fc = fd;
            fd = sign * ref_value_at(s, d = a + g * (b - a));
        }
    *f = sign * fmin(fc, fd);
    return fc < fd ? c : d;
}

static bool crossing(const struct ref_search *s, double a, double fa, double b, double fb,
                     double *root) {
    if (s->p->from_outside && fa < 0)
        return false;
    double t = ref_root(s, a, fa, b, fb), x[4];
    ref_ray_point(s->ray, t, x);
    if (forbidden_at(s, t) || !ref_within(s->surfaces, s->p, x))
        return false;
    *root = t;
    return true;
}

// A dip between three samples of one sign (or beside the first or last of two).
static bool first_in_dip(const struct ref_search *s, const double t[3], const double f[3],
                         bool first, double *root) {
    double low = first ? t[1] : t[0], f_low = first ? f[1] : f[0], f_dip;
    if (fmin(fabs(f[1]), fabs(f[2])) > s->steep * (t[2] - low))
        return false;
    double at = dip_between(s, low, t[2], f[2] > 0 ? 1 : -1, &f_dip);
    return (f_dip > 0) != (f[2] > 0) &&
           (crossing(s, low, f_low, at, f_dip, root) || crossing(s, at, f_dip, t[2], f[2], root));
}

static bool is_dip(const double f[3]) {
    return fabs(f[1]) <= fabs(f[0]) && fabs(f[1]) <= fabs(f[2]) && (f[0] > 0) == (f[1] > 0);
}

// The first place in a span where the surface is met: sign changes between samples, and twice
// within a dip.
static bool first_in(const struct ref_search *s, struct ref_span span, double *root) {
    int n = s->p->samples;
    double t[3] = {0}, f[3] = {0};
    for (int k = 0; k <= n; k++) {
        t[0] = t[1], f[0] = f[1];
        t[1] = t[2], f[1] = f[2];
        t[2] = span.begin + (span.end - span.begin) * k / n;
        f[2] = ref_value_at(s, t[2]);
        if (k > 0 && (f[1] > 0) != (f[2] > 0)) {
            if (crossing(s, t[1], f[1], t[2], f[2], root))
                return true;
        } else if (n > 1 && k > 0 && (k == 1 || k == n || is_dip(f)) &&
                   first_in_dip(s, t, f, k == 1, root)) {
            return true;
        }
    }
    return false;
}

// The same over a whole line of s3, in steps that all surfaces share.
static bool first_on_grid(const struct ref_search *s, struct ref_span span, double *root) {
    const struct ref_grid *g = s->ray->grid;
    double t[3] = {0}, f[3] = {0};
    for (int k = 0, seen = 0; k < g->count; k++) {
        if (k + 1 < g->count && g->t[k + 1] <= span.begin)
            continue;
        if (g->t[k] >= span.end + 2 * (g->t[1] - g->t[0])) // a dip before it takes two more
            break;
        t[0] = t[1], f[0] = f[1];
        t[1] = t[2], f[1] = f[2];
        t[2] = g->t[k];
        f[2] = ref_cheap(s->p, g->x[k]);
        if (seen++ == 0)
            continue;
        if ((f[1] > 0) != (f[2] > 0)) {
            if (crossing(s, t[1], ref_value_at(s, t[1]), t[2], ref_value_at(s, t[2]), root) &&
                *root >= span.begin)
                return true;
        } else if (seen == 2 || k + 1 == g->count || is_dip(f)) {
            for (int i = seen == 2; i < 3; i++)
                f[i] = ref_value_at(s, t[i]);
            if (first_in_dip(s, t, f, seen == 2, root) && *root >= span.begin)
                return true;
            for (int i = seen == 2; i < 3; i++)
                f[i] = ref_cheap(s->p, g->x[k - 2 + i]);
        }
    }
    return false;
}

void ref_fill_grid(const struct ref_ray *ray, double from, struct ref_grid *g) {
    double end = ref_ray_end(ray);
    g->count = ray->kappa > 0 ? REF_GRID : 0;
    for (int k = 0; k < g->count; k++) {
        g->t[k] = from + (end - from) * k / (REF_GRID - 1);
        ref_ray_point(ray, g->t[k], g->x[k]);
    }
}

bool ref_first(const struct ref_search *s, struct ref_span span, double *root) {
    bool on_grid = s->ray->kappa > 0 && span.end - span.begin > 0.5;
    return on_grid ? first_on_grid(s, span, root) : first_in(s, span, root);
}
