#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "src/image/blob_window.h"

// A pixel on the rim shows a·c + (1 − a)·b in linear light: c the disc's colour, b the
// background's, a the share covered, which the outline's place says. b is not seen: it is foretold
// from the pixels around, with the covariance S of what such a foretelling is off. The pixel's
// residual p − a·c − (1 − a)·b then has the covariance (1 − a)²·S + Q, Q that of the bytes'
// rounding; so a pixel that is almost covered tells the rim's place well before any pattern, and so
// do channels in which the pattern does not vary. The place (and how much larger the disc is) is
// the least-squares solution with these weights. It is not drawn towards where it is looked for:
// the weights depend on the place, never on what was expected. Once the place is known roughly,
// what pixels of the rim that are covered little show of the background helps to foretell their
// neighbours'.
enum {
    REACH_PX = 5,  // background is learnt from this near a pixel
    PASSES = 4,    // the background is learnt anew
    STEPS = 12,    // Gauss–Newton within each
    LEAST_RIM = 6, // pixels
};
static const double FIRST_CLEAR_PX = 1.5, CLEAR_PX = 0.15; // of the outline: background
static const double BAND_PX = 0.75;                        // on either side of it: the rim
static const double SHAPE = 0.003;                         // of a share: what the outline is off
static const double SLOPE_EVIDENCE = 0.5; // px²: what holds a plane level where little says else
static const double SHARE_MOST = 0.6;     // covered more, a pixel tells nothing of the background
static const double SPREAD_PX2 = 1.5; // how fast what a pixel tells of another's background fades
static const double PI = 3.14159265358979323846;
static const double ROBUST = 1.5; // standard errors

enum kind { UNKNOWN, BACKGROUND, RIM, INSIDE };

struct rim {
    int x, y;
    double b[3];     // the background foretold
    double s[6];     // its covariance: rr, rg, rb, gg, gb, bb
    double shown[3]; // linear
    double rounding[3];
};

struct residual {
    double off, weight; // of the share: shown less foretold; 1/variance
    struct ap_cover c;
};

struct fit {
    struct ap_blob_window *w;
    const struct ap_outline *outline;
    struct ap_outline_place place;
    struct ap_cover *cover; // width·height
    struct rim *rim;
    size_t count, room;
    bool rough;   // the place is only known roughly
    double noise; // of a share, beside background and bytes
    double color[3];
    double variance_i, variance_j;
};

// --- the background

// Sums for a plane b + bx·dx + by·dy fitted to the background near one pixel, the nearest most.
struct plane {
    double m[6];    // 1, x, y, xx, xy, yy
    double v[3][3]; // channel: 1, x, y
    double vv[6];   // products of channels
    double w2;      // squares of weights
};

static void plane_add(struct plane *f, double weight, double x, double y, const double v[3]) {
    const double basis[3] = {1, x, y};
    int n = 0, k = 0;
    for (int i = 0; i < 3; i++)
        for (int j = i; j < 3; j++)
            f->m[n++] += weight * basis[i] * basis[j];
    for (int c = 0; c < 3; c++)
        for (int i = 0; i < 3; i++)
            f->v[c][i] += weight * v[c] * basis[i];
    for (int c = 0; c < 3; c++)
        for (int d = c; d < 3; d++)
            f->vv[k++] += weight * v[c] * v[d];
    f->w2 += weight * weight;
}

// Inverse of a symmetric 3×3 matrix given and returned by its upper half; false where it has none.
static bool invert(const double m[6], double inverse[6]) {
    double a = m[0], b = m[1], c = m[2], d = m[3], e = m[4], f = m[5];
    double co[6] = {d * f - e * e, c * e - b * f, b * e - c * d,
                    a * f - c * c, b * c - a * e, a * d - b * b};
    double det = a * co[0] + b * co[1] + c * co[2];
    if (!(det > 0) || !isfinite(det))
        return false;
    for (int k = 0; k < 6; k++)
        inverse[k] = co[k] / det;
    return true;
}

// Σ weight·(v − plane)(v' − plane') of two channels.
static double scatter(const struct plane *f, double beta[3][3], int c, int d, double products) {
    const double *p = beta[c], *q = beta[d], *m = f->m;
    double across = 0;
    for (int i = 0; i < 3; i++)
        across += q[i] * f->v[c][i] + p[i] * f->v[d][i];
    return products - across + p[0] * q[0] * m[0] + (p[0] * q[1] + p[1] * q[0]) * m[1] +
           (p[0] * q[2] + p[2] * q[0]) * m[2] + p[1] * q[1] * m[3] +
           (p[1] * q[2] + p[2] * q[1]) * m[4] + p[2] * q[2] * m[5];
}

// The plane's value at the pixel itself, and what it may be off: the scatter about the plane, more
// where few pixels say it or all of them lie to one side.
static void plane_solve(const struct plane *f, struct rim *r) {
    double n = f->m[0], m[6], inverse[6] = {0}, beta[3][3];
    memcpy(m, f->m, sizeof m);
    m[3] += SLOPE_EVIDENCE;
    m[5] += SLOPE_EVIDENCE;
    bool slopes = invert(m, inverse);
    for (int c = 0; c < 3; c++) {
        // About the mean, so that an even background is foretold exactly.
        double mean = f->v[c][0] / n;
        double x = f->v[c][1] - mean * f->m[1], y = f->v[c][2] - mean * f->m[2];
        beta[c][0] = mean + inverse[1] * x + inverse[2] * y;
        beta[c][1] = inverse[3] * x + inverse[4] * y;
        beta[c][2] = inverse[4] * x + inverse[5] * y;
        r->b[c] = fmin(fmax(beta[c][0], 0), 1);
    }
    double samples = n * n / f->w2, leverage = slopes ? n * inverse[0] : 4;
    double factor = samples / fmax(samples - 2, 0.5) * (1 + leverage / samples);
    int k = 0;
    for (int c = 0; c < 3; c++)
        for (int d = c; d < 3; d++, k++) {
            double s = factor / n * scatter(f, beta, c, d, f->vv[k]);
            r->s[k] = c == d ? fmax(s, 0) : s;
        }
}

// What a pixel near by shows of the background, linear, and how much of its light that is.
static double background_seen(const struct fit *f, int x, int y, double v[3]) {
    const struct ap_blob_window *w = f->w;
    int at = y * w->width + x;
    double covered = w->kind[at] == BACKGROUND ? 0 : f->cover[at].share;
    bool tells =
        w->kind[at] == BACKGROUND || (w->kind[at] == RIM && !f->rough && covered <= SHARE_MOST);
    const uint8_t *p = ap_blob_pixel(w, x, y);
    for (int c = 0; c < 3 && tells; c++)
        v[c] = (w->srgb.linear[p[c]] - covered * f->color[c]) / (1 - covered);
    return tells ? 1 - covered : 0;
}

static bool learn_background(const struct fit *f, struct rim *r) {
    const struct ap_blob_window *w = f->w;
    struct plane plane = {0};
    int n = 0;
    for (int dy = -REACH_PX; dy <= REACH_PX; dy++)
        for (int dx = -REACH_PX; dx <= REACH_PX; dx++) {
            int x = r->x + dx, y = r->y + dy, d2 = dx * dx + dy * dy;
            if (x < 0 || y < 0 || x >= w->width || y >= w->height || d2 == 0 ||
                d2 > REACH_PX * REACH_PX)
                continue;
            double v[3], seen = background_seen(f, x, y, v);
            if (seen == 0)
                continue;
            plane_add(&plane, exp(-d2 / SPREAD_PX2) * seen * seen, dx, dy, v);
            n++;
        }
    if (n < 3)
        return false;
    plane_solve(&plane, r);
    return true;
}

// --- the rim

static void cover_at(const struct fit *f, double grow_px) {
    struct ap_outline_place place = f->place;
    place.grow_px += grow_px;
    ap_cover_outline(f->outline, &place, f->w->x0, f->w->y0, f->w->width, f->w->height, f->cover);
}

static void mark(const struct fit *f, double clear_px) {
    const struct ap_blob_window *w = f->w;
    size_t n = (size_t)w->width * (size_t)w->height;
    cover_at(f, clear_px);
    for (size_t k = 0; k < n; k++)
        w->kind[k] = f->cover[k].share > 0 ? UNKNOWN : BACKGROUND;
    cover_at(f, BAND_PX);
    for (size_t k = 0; k < n; k++)
        if (f->cover[k].share > 0 && w->kind[k] == UNKNOWN)
            w->kind[k] = RIM;
    cover_at(f, -BAND_PX);
    for (size_t k = 0; k < n; k++)
        if (f->cover[k].share >= 1)
            w->kind[k] = INSIDE;
}

static bool add_rim(struct fit *f, int x, int y) {
    if (f->count == f->room) {
        size_t room = f->room ? 2 * f->room : 256;
        struct rim *more = realloc(f->rim, room * sizeof *more);
        if (!more)
            return false;
        f->rim = more;
        f->room = room;
    }
    struct rim r = {.x = x, .y = y};
    const uint8_t *p = ap_blob_pixel(f->w, x, y);
    const double *linear = f->w->srgb.linear;
    for (int c = 0; c < 3; c++) {
        double below = linear[p[c] > 0 ? p[c] - 1 : 0], above = linear[p[c] < 255 ? p[c] + 1 : 255];
        double step = (above - below) / (p[c] > 0 && p[c] < 255 ? 2 : 1);
        r.shown[c] = linear[p[c]];
        r.rounding[c] = step * step / 12;
    }
    if (learn_background(f, &r))
        f->rim[f->count++] = r;
    return true;
}

static bool collect_rim(struct fit *f, double clear_px) {
    mark(f, clear_px);
    cover_at(f, 0);
    f->count = 0;
    for (int y = 0; y < f->w->height; y++)
        for (int x = 0; x < f->w->width; x++)
            if (f->w->kind[y * f->w->width + x] == RIM && !add_rim(f, x, y))
                return false;
    return f->count >= LEAST_RIM;
}

// How far a pixel's share is from the outline's, and how well it tells.
static struct residual residual_of(const struct fit *f, const struct rim *r) {
    struct residual e = {.c = f->cover[r->y * f->w->width + r->x]};
    double rest = 1 - e.c.share, v[6], inverse[6], d[3], off[3];
    for (int k = 0; k < 6; k++)
        v[k] = rest * rest * r->s[k];
    v[0] += r->rounding[0];
    v[3] += r->rounding[1];
    v[5] += r->rounding[2];
    for (int c = 0; c < 3; c++) {
        d[c] = f->color[c] - r->b[c];
        off[c] = r->shown[c] - e.c.share * f->color[c] - rest * r->b[c];
    }
    if (!invert(v, inverse))
        return e;
    double t[3] = {inverse[0] * d[0] + inverse[1] * d[1] + inverse[2] * d[2],
                   inverse[1] * d[0] + inverse[3] * d[1] + inverse[4] * d[2],
                   inverse[2] * d[0] + inverse[4] * d[1] + inverse[5] * d[2]};
    double weight = t[0] * d[0] + t[1] * d[1] + t[2] * d[2];
    if (!(weight > 0))
        return e;
    e.off = (t[0] * off[0] + t[1] * off[1] + t[2] * off[2]) / weight;
    e.weight = 1 / (1 / weight + f->noise * f->noise);
    return e;
}

static bool step(struct fit *f, double change[3]) {
    double m[6] = {0}, v[3] = {0}, inverse[6];
    cover_at(f, 0);
    for (size_t k = 0; k < f->count; k++) {
        struct residual e = residual_of(f, &f->rim[k]);
        double off = fabs(e.off) * sqrt(e.weight);
        double weight = e.weight * (off > ROBUST ? ROBUST / off : 1);
        const double g[3] = {e.c.by_i, e.c.by_j, e.c.by_grow};
        int n = 0;
        for (int i = 0; i < 3; i++) {
            v[i] += weight * g[i] * e.off;
            for (int j = i; j < 3; j++)
                m[n++] += weight * g[i] * g[j];
        }
    }
    if (!invert(m, inverse))
        return false;
    change[0] = inverse[0] * v[0] + inverse[1] * v[1] + inverse[2] * v[2];
    change[1] = inverse[1] * v[0] + inverse[3] * v[1] + inverse[4] * v[2];
    change[2] = inverse[2] * v[0] + inverse[4] * v[1] + inverse[5] * v[2];
    f->variance_i = inverse[0];
    f->variance_j = inverse[3];
    return true;
}

static bool solve(struct fit *f) {
    for (int k = 0; k < STEPS; k++) {
        double change[3];
        if (!step(f, change))
            return false;
        double length = sqrt(change[0] * change[0] + change[1] * change[1] + change[2] * change[2]);
        double part = length > 0.7 ? 0.7 / length : 1;
        f->place.shift_i += part * change[0];
        f->place.shift_j += part * change[1];
        f->place.grow_px += part * change[2];
        if (f->place.grow_px < -0.5 * f->place.radius_px)
            return false;
        if (length < 1e-6)
            break;
    }
    return isfinite(f->place.shift_i + f->place.shift_j + f->place.grow_px);
}

// --- whether to believe it

static int by_size(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return x < y ? -1 : x > y;
}

// The noise that makes half of the residuals less than what half of a bell's are: a renderer that
// samples its edges shows shares that are off by a tenth.
static bool find_noise(struct fit *f) {
    double *off = malloc(f->count * sizeof *off);
    if (!off)
        return false;
    f->noise = SHAPE;
    cover_at(f, 0);
    for (int k = 0; k < 7; k++, f->noise *= 2) {
        size_t n = 0;
        for (size_t i = 0; i < f->count; i++) {
            struct residual e = residual_of(f, &f->rim[i]);
            if (e.c.share > 0.02 && e.c.share < 0.98 && e.weight > 0)
                off[n++] = fabs(e.off) * sqrt(e.weight);
        }
        qsort(off, n, sizeof *off, by_size);
        if (n == 0 || off[n / 2] < 0.8)
            break;
    }
    free(off);
    return true;
}

enum { SIDES = 64 };

// The rim in overlapping parts of some eight pixels: how far each lies out, beyond three times its
// own standard error.
static double worst_side(const struct fit *f) {
    double m[SIDES] = {0}, v[SIDES] = {0}, worst = 0;
    double around = 2 * PI * f->place.radius_px;
    int sides = (int)fmin(fmax(around / 4, 8), SIDES);
    for (size_t k = 0; k < f->count; k++) {
        struct residual e = residual_of(f, &f->rim[k]);
        double out = hypot(e.c.by_i, e.c.by_j);
        double i = f->rim[k].x + f->w->x0 + 0.5 - f->outline->about_i - f->place.shift_i;
        double j = f->rim[k].y + f->w->y0 + 0.5 - f->outline->about_j - f->place.shift_j;
        int side = (int)floor((atan2(j, i) / (2 * PI) + 0.5) * sides) % sides;
        m[side] += e.weight * out * out;
        v[side] += e.weight * out * e.off;
    }
    for (int k = 0; k < sides; k++) {
        int next = (k + 1) % sides;
        double weight = m[k] + m[next];
        if (weight > 0)
            worst = fmax(worst, fabs(v[k] + v[next]) / weight - 3 / sqrt(weight));
    }
    return worst;
}

static double strange(const struct fit *f) {
    double sum = 0;
    for (int y = 0; y < f->w->height; y++)
        for (int x = 0; x < f->w->width; x++)
            sum += f->w->kind[y * f->w->width + x] == INSIDE &&
                   memcmp(ap_blob_pixel(f->w, x, y), f->w->color, 3) != 0;
    for (size_t k = 0; k < f->count; k++) {
        struct residual e = residual_of(f, &f->rim[k]);
        if (e.weight > 0 && fabs(e.off) * sqrt(e.weight) > 4)
            sum += fmin(fabs(e.off), e.c.share); // no more of the disc can be hidden there
    }
    return sum;
}

bool ap_blob_fit(struct ap_blob_window *w, const struct ap_outline *outline,
                 struct ap_outline_place start, struct ap_blob *blob) {
    size_t pixels = (size_t)w->width * (size_t)w->height;
    struct fit f = {.w = w, .outline = outline, .place = start, .noise = SHAPE};
    bool ok = false;
    f.cover = malloc(pixels * sizeof *f.cover);
    if (!f.cover)
        goto out;
    for (int c = 0; c < 3; c++)
        f.color[c] = w->srgb.linear[w->color[c]];
    for (int pass = 0; pass < PASSES; pass++) {
        f.rough = pass == 0;
        if (!collect_rim(&f, pass == 0 ? FIRST_CLEAR_PX : CLEAR_PX) || !solve(&f) ||
            !find_noise(&f))
            goto out;
    }
    if (!solve(&f))
        goto out;
    cover_at(&f, 0);
    blob->shift_i = f.place.shift_i;
    blob->shift_j = f.place.shift_j;
    blob->grow_px = f.place.grow_px;
    blob->sigma_px = sqrt(fmax(f.variance_i, f.variance_j));
    blob->side_px = worst_side(&f);
    blob->strange_px = strange(&f);
    ok = true;
out:
    free(f.cover);
    free(f.rim);
    return ok;
}
