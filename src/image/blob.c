#include "src/image/blob.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "src/image/blob_window.h"

static const double PI = 3.14159265358979323846;
enum { MARGIN_PX = 8 }; // round the box: where the background is learnt from

enum kind { OUTSIDE, CORE, OTHER_CORE };

static bool shows(const struct ap_blob_window *w, int x, int y, const uint8_t color[3]) {
    return memcmp(ap_blob_pixel(w, x, y), color, 3) == 0;
}

static int clamp_floor(double v, int max) {
    return v > 0 ? (v < max ? (int)floor(v) : max) : 0; // NaN: 0
}

struct box {
    double min_i, max_i, min_j, max_j;
};

static struct box box_of(const struct ap_blob_query *q) {
    struct box b = {INFINITY, -INFINITY, INFINITY, -INFINITY};
    for (size_t k = 0; k < q->count; k++) {
        const double *p = q->outline[k];
        if (!isfinite(p[0]) || !isfinite(p[1]))
            return (struct box){NAN, NAN, NAN, NAN};
        b.min_i = fmin(b.min_i, p[0] - q->reach_px);
        b.max_i = fmax(b.max_i, p[0] + q->reach_px);
        b.min_j = fmin(b.min_j, p[1] - q->reach_px);
        b.max_j = fmax(b.max_j, p[1] + q->reach_px);
    }
    return b;
}

static bool open_window(struct ap_blob_window *w, const struct ap_image *image,
                        const struct box *box) {
    int last_x = (int)image->width - 1, last_y = (int)image->height - 1;
    int x0 = clamp_floor(box->min_i, last_x), x1 = clamp_floor(box->max_i, last_x);
    int y0 = clamp_floor(box->min_j, last_y), y1 = clamp_floor(box->max_j, last_y);
    if (!(box->max_i >= 0 && box->max_j >= 0 && box->min_i < image->width &&
          box->min_j < image->height))
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
    w->stack = malloc(n * sizeof *w->stack);
    ap_srgb_init(&w->srgb);
    return w->kind && w->stack;
}

static bool has_pair(const struct ap_blob_window *w, const uint8_t color[3]) {
    for (int y = w->min_y; y <= w->max_y; y++)
        for (int x = w->min_x; x <= w->max_x; x++)
            if (shows(w, x, y, color) && ((x < w->max_x && shows(w, x + 1, y, color)) ||
                                          (y < w->max_y && shows(w, x, y + 1, color))))
                return true;
    return false;
}

// The core's bytes are the colour asked for; but a driver may round it one step off in a channel,
// so failing that the most frequent colour within one step is taken.
static bool find_color(struct ap_blob_window *w, const uint8_t asked[3]) {
    int count[27] = {0}, best = 13;
    for (int y = w->min_y; y <= w->max_y; y++)
        for (int x = w->min_x; x <= w->max_x; x++) {
            const uint8_t *p = ap_blob_pixel(w, x, y);
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
static int flood(struct ap_blob_window *w, int x, int y, enum kind from, enum kind to, bool *cut) {
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
static void find_core(struct ap_blob_window *w, bool *cut) {
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

// Where the core's middle says that the outline is, near enough to start from.
static struct ap_outline_place core_place(const struct ap_blob_window *w,
                                          const struct ap_outline *outline, double radius_px) {
    double n = 0, i = 0, j = 0;
    for (int y = w->min_y; y <= w->max_y; y++)
        for (int x = w->min_x; x <= w->max_x; x++)
            if (w->kind[y * w->width + x] == CORE) {
                n += 1;
                i += w->x0 + x + 0.5;
                j += w->y0 + y + 0.5;
            }
    return (struct ap_outline_place){i / n - outline->about_i, j / n - outline->about_j, 0,
                                     radius_px};
}

bool ap_find_blob(const struct ap_image *image, const struct ap_blob_query *query,
                  struct ap_blob *blob) {
    struct ap_blob_window w = {0};
    struct ap_outline outline = {.points = query->outline, .count = query->count};
    struct box box = box_of(query);
    bool found = image->width > 0 && image->height > 0 && open_window(&w, image, &box) &&
                 find_color(&w, query->color);
    if (found) {
        struct ap_blob made = {0};
        double area = ap_outline_area(&outline, &outline.about_i, &outline.about_j);
        find_core(&w, &made.touches_edge);
        struct ap_outline_place start = core_place(&w, &outline, sqrt(area / PI));
        found = area > 0 && ap_blob_fit(&w, &outline, start, &made);
        if (found)
            *blob = made;
    }
    free(w.kind);
    free(w.stack);
    return found;
}
