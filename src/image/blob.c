#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "src/image/image.h"
#include "src/image/srgb.h"

// A pixel on a disc's edge shows a·c + (1−a)·b in linear light: c the disc's colour, b the
// background's, a the coverage. Pixels that show c itself are the disc's core (a = 1). Around it
// lies the rim, where a is solved for by least squares over the three channels, with b from a plane
// fitted to the pixels beyond the rim. The centroid is that of a.
enum {
    RIM_PX = 2,   // an edge pixel has a core pixel within this many steps (discs of radius ≥ 1.2)
    NEAR_PX = 3,  // background is taken from this near an edge pixel
    REACH_PX = 5, // and from this near where it goes on alike
    MARGIN_PX = RIM_PX + REACH_PX,
};

enum kind { OUTSIDE, RIM, CORE, OTHER_CORE };

// The searched box and a margin round it, cut to the picture.
struct window {
    const struct ap_image *image;
    struct ap_srgb srgb;
    int x0, y0, width, height;      // the window
    int min_x, max_x, min_y, max_y; // the box in window pixels, inclusive
    uint8_t color[3];               // the core's bytes
    uint8_t *kind;                  // width·height
    float *cover;                   // width·height: coverage
    float *rest;                    // width·height: what is neither colour nor background
    int *stack;                     // width·height
};

static const uint8_t *pixel(const struct window *w, int x, int y) {
    return w->image->rgb + ((size_t)(w->y0 + y) * w->image->width + (size_t)(w->x0 + x)) * 3;
}

static bool shows(const struct window *w, int x, int y, const uint8_t color[3]) {
    return memcmp(pixel(w, x, y), color, 3) == 0;
}

static int clamp_floor(double v, int max) {
    return v > 0 ? (v < max ? (int)floor(v) : max) : 0; // NaN: 0
}

static bool open_window(struct window *w, const struct ap_image *image,
                        const struct ap_blob_query *q) {
    int last_x = (int)image->width - 1, last_y = (int)image->height - 1;
    int x0 = clamp_floor(q->min_i, last_x), x1 = clamp_floor(q->max_i, last_x);
    int y0 = clamp_floor(q->min_j, last_y), y1 = clamp_floor(q->max_j, last_y);
    if (!(q->max_i >= 0 && q->max_j >= 0 && q->min_i < image->width && q->min_j < image->height) ||
        x1 < x0 || y1 < y0)
        return false;
    w->image = image;
    w->x0 = x0 > MARGIN_PX ? x0 - MARGIN_PX : 0;
    w->y0 = y0 > MARGIN_PX ? y0 - MARGIN_PX : 0;
    int end_x = x1 + MARGIN_PX < last_x ? x1 + MARGIN_PX : last_x;
    int end_y = y1 + MARGIN_PX < last_y ? y1 + MARGIN_PX : last_y;
    w->width = end_x - w->x0 + 1;
    w->height = end_y - w->y0 + 1;
    w->min_x = x0 - w->x0;
    w->max_x = x1 - w->x0;
    w->min_y = y0 - w->y0;
    w->max_y = y1 - w->y0;
    size_t n = (size_t)w->width * (size_t)w->height;
    w->kind = calloc(n, sizeof *w->kind);
    w->cover = calloc(n, sizeof *w->cover);
    w->rest = calloc(n, sizeof *w->rest);
    w->stack = malloc(n * sizeof *w->stack);
    ap_srgb_init(&w->srgb);
    return w->kind && w->cover && w->rest && w->stack;
}

static bool has_pair(const struct window *w, const uint8_t color[3]) {
    for (int y = w->min_y; y <= w->max_y; y++)
        for (int x = w->min_x; x <= w->max_x; x++)
            if (shows(w, x, y, color) && ((x < w->max_x && shows(w, x + 1, y, color)) ||
                                          (y < w->max_y && shows(w, x, y + 1, color))))
                return true;
    return false;
}

// The core's bytes are the colour asked for; but a driver may round it one step off in a channel,
// so failing that the most frequent colour within one step is taken.
static bool find_color(struct window *w, const uint8_t asked[3]) {
    int count[27] = {0}, best = 13;
    for (int y = w->min_y; y <= w->max_y; y++)
        for (int x = w->min_x; x <= w->max_x; x++) {
            const uint8_t *p = pixel(w, x, y);
            int r = p[0] - asked[0] + 1, g = p[1] - asked[1] + 1, b = p[2] - asked[2] + 1;
            if (r >= 0 && r < 3 && g >= 0 && g < 3 && b >= 0 && b < 3)
                count[9 * r + 3 * g + b]++;
        }
    memcpy(w->color, asked, 3);
    if (count[13] > 0 && has_pair(w, asked))
        return true;
    for (int k = 0; k < 27; k++)
        if (count[k] > count[best])
            best = k;
    w->color[0] = (uint8_t)(asked[0] + best / 9 - 1);
    w->color[1] = (uint8_t)(asked[1] + best / 3 % 3 - 1);
    w->color[2] = (uint8_t)(asked[2] + best % 3 - 1);
    return count[best] > 0;
}

// Marks the pixels of the box joined to (x, y) that show the core's colour; returns how many.
static int flood(struct window *w, int x, int y, enum kind from, enum kind to, bool *cut) {
    int n = 0, top = 0;
    w->stack[top++] = y * w->width + x;
    w->kind[y * w->width + x] = (uint8_t)to;
    while (top > 0) {
        int at = w->stack[--top], ax = at % w->width, ay = at / w->width;
        n++;
        if (ax == w->min_x || ax == w->max_x || ay == w->min_y || ay == w->max_y)
            *cut = true;
        for (int dy = -1; dy <= 1; dy++)
            for (int dx = -1; dx <= 1; dx++) {
                int bx = ax + dx, by = ay + dy, b = by * w->width + bx;
                if (bx < w->min_x || bx > w->max_x || by < w->min_y || by > w->max_y ||
                    w->kind[b] != from || !shows(w, bx, by, w->color))
                    continue;
                w->kind[b] = (uint8_t)to;
                w->stack[top++] = b;
            }
    }
    return n;
}

// The largest connected patch of the colour becomes the core. *cut: it reaches the box's border.
static void find_core(struct window *w, bool *cut) {
    int best = 0, best_x = 0, best_y = 0;
    for (int y = w->min_y; y <= w->max_y; y++)
        for (int x = w->min_x; x <= w->max_x; x++) {
            if (w->kind[y * w->width + x] != OUTSIDE || !shows(w, x, y, w->color))
                continue;
            bool ignored;
            int n = flood(w, x, y, OUTSIDE, OTHER_CORE, &ignored);
            if (n > best) {
                best = n;
                best_x = x;
                best_y = y;
            }
        }
    *cut = false;
    flood(w, best_x, best_y, OTHER_CORE, CORE, cut);
}

static void mark_rim(struct window *w) {
    for (int y = 0; y < w->height; y++)
        for (int x = 0; x < w->width; x++) {
            if (w->kind[y * w->width + x] != CORE)
                continue;
            for (int by = y - RIM_PX; by <= y + RIM_PX; by++)
                for (int bx = x - RIM_PX; bx <= x + RIM_PX; bx++)
                    if (bx >= 0 && by >= 0 && bx < w->width && by < w->height &&
                        w->kind[by * w->width + bx] == OUTSIDE)
                        w->kind[by * w->width + bx] = RIM;
        }
}

// Sums of a plane fit b + bx·dx + by·dy over the background near one pixel.
struct fit {
    double n, x, y, xx, xy, yy;
    double v[3], xv[3], yv[3];
    double min[3], max[3];
};

static void fit_add(struct fit *f, double x, double y, const double v[3]) {
    f->n += 1;
    f->x += x;
    f->y += y;
    f->xx += x * x;
    f->xy += x * y;
    f->yy += y * y;
    for (int c = 0; c < 3; c++) {
        f->v[c] += v[c];
        f->xv[c] += x * v[c];
        f->yv[c] += y * v[c];
        f->min[c] = f->n == 1 ? v[c] : fmin(f->min[c], v[c]);
        f->max[c] = f->n == 1 ? v[c] : fmax(f->max[c], v[c]);
    }
}

// The plane's value at the pixel itself (dx = dy = 0), held near what was seen, so that a few
// pixels in a line or a far edge in the background do not throw it out.
static void fit_solve(const struct fit *f, double b[3]) {
    double mx = f->x / f->n, my = f->y / f->n;
    double xx = f->xx - f->n * mx * mx, xy = f->xy - f->n * mx * my, yy = f->yy - f->n * my * my;
    double det = xx * yy - xy * xy;
    for (int c = 0; c < 3; c++) {
        double mean = f->v[c] / f->n, spread = f->max[c] - f->min[c];
        if (spread == 0) {
            b[c] = f->min[c]; // exactly: rounding would make a coverage of an even background
            continue;
        }
        b[c] = mean;
        if (det > 1e-6 * f->n * f->n) {
            double xv = f->xv[c] - f->x * mean, yv = f->yv[c] - f->y * mean;
            b[c] = mean - mx * (yy * xv - xy * yv) / det - my * (xx * yv - xy * xv) / det;
        }
        b[c] = fmin(fmax(b[c], f->min[c] - spread), f->max[c] + spread);
        b[c] = fmin(fmax(b[c], 0), 1);
    }
}

// Adds the pixels beyond the rim that lie within reach of (x, y); with `like`, only those that
// differ from its mean by no more than twice its spread and a little: a second object a few pixels
// off is not the background that the rim is mixed with.
static void fit_around(const struct window *w, int x, int y, int reach, const struct fit *like,
                       struct fit *f) {
    for (int dy = -reach; dy <= reach; dy++)
        for (int dx = -reach; dx <= reach; dx++) {
            int bx = x + dx, by = y + dy;
            if (bx < 0 || by < 0 || bx >= w->width || by >= w->height ||
                w->kind[by * w->width + bx] != OUTSIDE)
                continue;
            const uint8_t *p = pixel(w, bx, by);
            double v[3] = {w->srgb.linear[p[0]], w->srgb.linear[p[1]], w->srgb.linear[p[2]]};
            bool fits = true;
            for (int c = 0; c < 3 && like; c++)
                fits = fits && fabs(v[c] - like->v[c] / like->n) <=
                                   2 * (like->max[c] - like->min[c]) + 0.01;
            if (fits)
                fit_add(f, dx, dy, v);
        }
}

static bool background(const struct window *w, int x, int y, double b[3]) {
    struct fit near = {0}, f = {0};
    for (int reach = NEAR_PX; reach <= REACH_PX && near.n < 3; reach++) {
        near = (struct fit){0};
        fit_around(w, x, y, reach, NULL, &near);
    }
    if (near.n < 1)
        return false;
    fit_around(w, x, y, REACH_PX, &near, &f);
    fit_solve(f.n > near.n ? &f : &near, b);
    return true;
}

// The a that makes |shown − (a·c + (1−a)·b)| least, and that rest in units of |c − b|: what the
// pixel shows that is neither the colour nor the background.
static double coverage(const struct window *w, int x, int y, double *rest) {
    double b[3], along = 0, length = 0, square = 0;
    *rest = 0;
    if (!background(w, x, y, b))
        return 0;
    const uint8_t *p = pixel(w, x, y);
    for (int c = 0; c < 3; c++) {
        double d = w->srgb.linear[w->color[c]] - b[c];
        double shown = w->srgb.linear[p[c]] - b[c];
        along += shown * d;
        square += shown * shown;
        length += d * d;
    }
    if (length > 0)
        *rest = sqrt(fmax(square - along * along / length, 0) / length);
    return length > 0 ? fmin(fmax(along / length, 0), 1) : 0;
}

static void cover(struct window *w) {
    for (int y = 0; y < w->height; y++)
        for (int x = 0; x < w->width; x++) {
            int at = y * w->width + x;
            double rest = 0;
            if (w->kind[at] == CORE)
                w->cover[at] = 1;
            else if (w->kind[at] == RIM)
                w->cover[at] = (float)coverage(w, x, y, &rest);
            w->rest[at] = (float)rest;
        }
}

// An edge pixel has one beside it that is covered well; a rim pixel without is background, and what
// the bytes' rounding feigns there is noise.
static bool counts(const struct window *w, int x, int y) {
    for (int by = y - 1; by <= y + 1; by++)
        for (int bx = x - 1; bx <= x + 1; bx++)
            if (bx >= 0 && by >= 0 && bx < w->width && by < w->height &&
                w->cover[by * w->width + bx] > 0.4F)
                return true;
    return false;
}

static void measure(const struct window *w, struct ap_blob *blob) {
    double sum = 0, sum_i = 0, sum_j = 0;
    int last_x = (int)w->image->width - 1, last_y = (int)w->image->height - 1;
    for (int y = 0; y < w->height; y++)
        for (int x = 0; x < w->width; x++) {
            double a = (double)w->cover[y * w->width + x];
            if (a == 0 || !counts(w, x, y))
                continue;
            int i = w->x0 + x, j = w->y0 + y;
            sum += a;
            blob->strange_px += (double)w->rest[y * w->width + x];
            sum_i += a * (i + 0.5);
            sum_j += a * (j + 0.5);
            // What a byte's rounding can feign in one pixel does not make the disc cut.
            if (a > 0.02 && (i == 0 || j == 0 || i == last_x || j == last_y))
                blob->touches_edge = true;
        }
    blob->i = sum_i / sum;
    blob->j = sum_j / sum;
    blob->area_px = sum;
}

bool ap_find_blob(const struct ap_image *image, const struct ap_blob_query *query,
                  struct ap_blob *blob) {
    struct window w = {0};
    bool found = image->width > 0 && image->height > 0 && open_window(&w, image, query) &&
                 find_color(&w, query->color);
    if (found) {
        struct ap_blob made = {0};
        find_core(&w, &made.touches_edge);
        mark_rim(&w);
        cover(&w);
        measure(&w, &made);
        *blob = made;
    }
    free(w.kind);
    free(w.cover);
    free(w.rest);
    free(w.stack);
    return found;
}
