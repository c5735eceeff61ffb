#include "src/image/compare.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static enum ap_status check_sizes(struct ap_error *err, const struct ap_image *a,
                                  const struct ap_image *b) {
    if (a->width != b->width || a->height != b->height)
        return ap_fail(err, AP_INPUT, "pictures of %ux%u and %ux%u pixels cannot be compared",
                       a->width, a->height, b->width, b->height);
    return AP_OK;
}

// Both have 16 bits: these are compared, not the bytes.
static bool fine(const struct ap_image *a, const struct ap_image *b) {
    return a->grey && b->grey;
}

// The largest step of a pixel's channels in bytes, of 16 bits rounded up. Adds the three squares.
static int step_at(const struct ap_image *a, const struct ap_image *b, size_t k,
                   uint64_t *squares) {
    if (fine(a, b)) {
        uint64_t d = (uint64_t)abs(a->grey[k] - b->grey[k]);
        *squares += 3 * d * d;
        return (int)((d + 256) / 257);
    }
    const uint8_t *pa = a->rgb + 3 * k, *pb = b->rgb + 3 * k;
    int most = 0;
    for (int c = 0; c < 3; c++) {
        int d = abs(pa[c] - pb[c]);
        *squares += (uint64_t)(d * d);
        most = d > most ? d : most;
    }
    return most;
}

// ---- the largest patch: runs of differing pixels in a row, joined with those of the row above

struct run {
    uint32_t x0, x1, y; // x1 is its last pixel
    uint32_t parent;    // a root is its own
};

struct runs {
    struct run *run;
    size_t count, room;
};

static bool add_run(struct runs *runs, uint32_t x0, uint32_t x1, uint32_t y) {
    if (runs->count == runs->room) {
        size_t room = runs->room ? 2 * runs->room : 1024;
        struct run *more = room > UINT32_MAX ? NULL : realloc(runs->run, room * sizeof *runs->run);
        if (!more)
            return false;
        runs->run = more;
        runs->room = room;
    }
    runs->run[runs->count] = (struct run){x0, x1, y, (uint32_t)runs->count};
    runs->count++;
    return true;
}

static uint32_t root_of(struct run *run, uint32_t k) {
    while (run[k].parent != k) {
        run[k].parent = run[run[k].parent].parent;
        k = run[k].parent;
    }
    return k;
}

// The runs from `above` to `row` are the row above, those from `row` on the last one. The root is
// the earliest run, so that the outcome does not depend on the order of joining.
static void join_rows(struct runs *runs, size_t above, size_t row) {
    struct run *r = runs->run;
    for (size_t i = above, k = row; i < row && k < runs->count;) {
        if (r[i].x0 <= r[k].x1 + 1 && r[k].x0 <= r[i].x1 + 1) {
            uint32_t a = root_of(r, (uint32_t)i), b = root_of(r, (uint32_t)k);
            r[a > b ? a : b].parent = a > b ? b : a;
        }
        if (r[i].x1 < r[k].x1)
            i++;
        else
            k++;
    }
}

static void grow(struct ap_region *g, const struct run *run) {
    uint32_t x0 = g->pixels && g->x < run->x0 ? g->x : run->x0;
    uint32_t x1 = g->pixels && g->x + g->width > run->x1 + 1 ? g->x + g->width : run->x1 + 1;
    g->y = g->pixels ? g->y : run->y; // runs come row by row
    g->height = run->y - g->y + 1;
    g->x = x0;
    g->width = x1 - x0;
    g->pixels += run->x1 - run->x0 + 1;
}

static enum ap_status largest_of(struct ap_error *err, struct runs *runs,
                                 struct ap_region *largest) {
    struct ap_region best = {0};
    if (runs->count) {
        struct ap_region *patch = calloc(runs->count, sizeof *patch);
        if (!patch)
            return ap_fail(err, AP_ENVIRONMENT, "out of memory");
        for (size_t k = 0; k < runs->count; k++)
            grow(&patch[root_of(runs->run, (uint32_t)k)], &runs->run[k]);
        for (size_t k = 0; k < runs->count; k++)
            if (patch[k].pixels > best.pixels)
                best = patch[k];
        free(patch);
    }
    *largest = best;
    return AP_OK;
}

static bool same_row(const struct ap_image *a, const struct ap_image *b, uint32_t y) {
    size_t at = (size_t)y * a->width;
    if (fine(a, b))
        return memcmp(a->grey + at, b->grey + at, a->width * sizeof *a->grey) == 0;
    return memcmp(a->rgb + 3 * at, b->rgb + 3 * at, (size_t)a->width * 3) == 0;
}

// One row's runs and counts.
static bool read_row(const struct ap_image *a, const struct ap_image *b, uint32_t y,
                     struct runs *runs, struct ap_difference *d, uint64_t *squares) {
    if (same_row(a, b, y))
        return true;
    for (uint32_t x = 0, from = 0; x <= a->width; x++) {
        int step = x < a->width ? step_at(a, b, (size_t)y * a->width + x, squares) : 0;
        if (step) {
            d->largest_step = step > d->largest_step ? step : d->largest_step;
            d->pixels++;
            continue;
        }
        if (x > from && !add_run(runs, from, x - 1, y))
            return false;
        from = x + 1;
    }
    return true;
}

enum ap_status ap_image_difference(struct ap_error *err, const struct ap_image *a,
                                   const struct ap_image *b, struct ap_difference *difference) {
    enum ap_status st = check_sizes(err, a, b);
    if (st)
        return st;
    struct ap_difference d = {0};
    struct runs runs = {0};
    uint64_t squares = 0;
    size_t above = 0;
    for (uint32_t y = 0; y < a->height && !st; y++) {
        size_t row = runs.count;
        if (!read_row(a, b, y, &runs, &d, &squares))
            st = ap_fail(err, AP_ENVIRONMENT, "out of memory");
        join_rows(&runs, above, row);
        above = row;
    }
    if (!st)
        st = largest_of(err, &runs, &d.largest);
    double mean = (double)squares / (3.0 * a->width * a->height), peak = fine(a, b) ? 65535 : 255;
    d.psnr_db = squares ? 10 * log10(peak * peak / mean) : INFINITY;
    free(runs.run);
    if (!st)
        *difference = d;
    return st;
}

// ---- SSIM

enum { SSIM_WINDOW = 11, SSIM_SUMS = 5 }; // a, b, aa, bb, ab

struct window {
    int size;
    double weight[SSIM_WINDOW];
};

static struct window window_for(uint32_t side) {
    struct window w = {.size = side >= SSIM_WINDOW ? SSIM_WINDOW : (int)(side - 1) / 2 * 2 + 1};
    double sum = 0;
    for (int k = 0; k < w.size; k++) {
        double d = k - w.size / 2;
        w.weight[k] = exp(-d * d / (2 * 1.5 * 1.5));
        sum += w.weight[k];
    }
    for (int k = 0; k < w.size; k++)
        w.weight[k] /= sum;
    return w;
}

static double luma(const uint8_t *rgb) {
    return 0.299 * rgb[0] + 0.587 * rgb[1] + 0.114 * rgb[2];
}

// One row, its five products filtered along x, into out[sum][x], `across` places each.
static void filter_row(const struct ap_image *a, const struct ap_image *b, uint32_t y,
                       const struct window *w, uint32_t across, double *line, double *out) {
    size_t width = a->width, row = y * width * 3;
    for (size_t x = 0; x < width; x++) {
        double p = luma(a->rgb + row + 3 * x), q = luma(b->rgb + row + 3 * x);
        const double v[SSIM_SUMS] = {p, q, p * p, q * q, p * q};
        for (int s = 0; s < SSIM_SUMS; s++)
            line[s * width + x] = v[s];
    }
    for (int s = 0; s < SSIM_SUMS; s++)
        for (uint32_t x = 0; x < across; x++) {
            double sum = 0;
            for (int k = 0; k < w->size; k++)
                sum += w->weight[k] * line[s * width + x + (size_t)k];
            out[(size_t)s * across + x] = sum;
        }
}

static double ssim_of(const double v[SSIM_SUMS]) {
    const double c1 = 0.01 * 255 * 0.01 * 255, c2 = 0.03 * 255 * 0.03 * 255;
    double ab = v[0] * v[1], aa = v[0] * v[0], bb = v[1] * v[1];
    return (2 * ab + c1) * (2 * (v[4] - ab) + c2) /
           ((aa + bb + c1) * ((v[2] - aa) + (v[3] - bb) + c2));
}

// The windows whose last row is y; ring holds the filtered rows, row r at place r % size.
static double ssim_row(const double *ring, const struct window *w, uint32_t y, uint32_t across) {
    double total = 0;
    size_t one = (size_t)SSIM_SUMS * across;
    for (uint32_t x = 0; x < across; x++) {
        double v[SSIM_SUMS] = {0};
        for (int k = 0; k < w->size; k++) {
            size_t at = (y + 1 + (size_t)k) % (size_t)w->size * one + x;
            for (int s = 0; s < SSIM_SUMS; s++)
                v[s] += w->weight[k] * ring[at + (size_t)s * across];
        }
        total += ssim_of(v);
    }
    return total;
}

enum ap_status ap_image_ssim(struct ap_error *err, const struct ap_image *a,
                             const struct ap_image *b, double *ssim) {
    enum ap_status st = check_sizes(err, a, b);
    if (st)
        return st;
    // What is the same is 1, not 1 but for rounding.
    if (memcmp(a->rgb, b->rgb, (size_t)a->width * a->height * 3) == 0) {
        *ssim = 1;
        return AP_OK;
    }
    struct window along = window_for(a->width), down = window_for(a->height);
    uint32_t across = a->width - (uint32_t)along.size + 1;
    double *line = malloc((size_t)SSIM_SUMS * a->width * sizeof *line);
    double *ring = malloc((size_t)SSIM_SUMS * across * (size_t)down.size * sizeof *ring);
    double total = 0;
    if (!line || !ring)
        st = ap_fail(err, AP_ENVIRONMENT, "out of memory");
    for (uint32_t y = 0; y < a->height && !st; y++) {
        filter_row(a, b, y, &along, across, line,
                   ring + (size_t)SSIM_SUMS * across * (y % (uint32_t)down.size));
        if (y + 1 >= (uint32_t)down.size)
            total += ssim_row(ring, &down, y, across);
    }
    if (!st)
        *ssim = total / ((double)across * (a->height - (uint32_t)down.size + 1));
    free(line);
    free(ring);
    return st;
}

// ---- the picture

static void heat(double v, uint8_t rgb[3]) {
    static const double stop[5][3] = {
        {0, 0, 0}, {120, 0, 40}, {230, 60, 20}, {255, 190, 40}, {255, 255, 255}};
    double at = 4 * (v < 0 ? 0 : v > 1 ? 1 : v);
    int k = at >= 4 ? 3 : (int)at;
    for (int c = 0; c < 3; c++)
        rgb[c] = (uint8_t)(stop[k][c] + (at - k) * (stop[k + 1][c] - stop[k][c]) + 0.5);
}

enum ap_status ap_image_difference_picture(struct ap_error *err, const struct ap_image *a,
                                           const struct ap_image *b, const float *flip_map,
                                           struct ap_image *out) {
    struct ap_image made = {0};
    enum ap_status st = check_sizes(err, a, b);
    if (!st && a->width > UINT32_MAX / 3)
        st = ap_fail(err, AP_INPUT, "pictures of %u pixels across are too wide", a->width);
    if (!st)
        st = ap_image_create(err, 3 * a->width, a->height, &made);
    if (st)
        return st;
    size_t row = (size_t)a->width * 3;
    for (uint32_t y = 0; y < a->height; y++) {
        uint8_t *to = made.rgb + 3 * y * row;
        uint64_t squares = 0;
        memcpy(to, a->rgb + y * row, row);
        memcpy(to + row, b->rgb + y * row, row);
        for (size_t x = 0; x < a->width; x++) {
            int step = step_at(a, b, (size_t)y * a->width + x, &squares);
            double v = flip_map ? (double)flip_map[(size_t)y * a->width + x]
                       : step   ? 0.1 + 0.9 * sqrt(step / 255.0)
                                : 0;
            heat(v, to + 2 * row + 3 * x);
        }
    }
    *out = made;
    return AP_OK;
}
