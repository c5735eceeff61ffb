#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "src/image/image.h"
#include "src/image/srgb.h"

static enum ap_status same_size(struct ap_error *err, const struct ap_image *a,
                                const struct ap_image *b) {
    if (a->width != b->width || a->height != b->height)
        return ap_fail(err, AP_INPUT, "pictures of %ux%u and %ux%u pixels: expected one size",
                       a->width, a->height, b->width, b->height);
    return AP_OK;
}

// 64-bit sizes, so that a product over 32 bits is refused and not wrapped.
static enum ap_status create(struct ap_error *err, uint64_t width, uint64_t height,
                             struct ap_image *image) {
    uint32_t w = width > UINT32_MAX ? UINT32_MAX : (uint32_t)width;
    uint32_t h = height > UINT32_MAX ? UINT32_MAX : (uint32_t)height;
    return ap_image_create(err, w, h, image);
}

static void paste(const struct ap_image *from, uint32_t x, uint32_t y, struct ap_image *onto) {
    for (uint32_t row = 0; row < from->height; row++)
        memcpy(onto->rgb + ((size_t)(y + row) * onto->width + x) * 3,
               from->rgb + (size_t)row * from->width * 3, (size_t)from->width * 3);
}

enum ap_status ap_image_side_by_side(struct ap_error *err, const struct ap_image *left,
                                     const struct ap_image *right, struct ap_image *out) {
    struct ap_image made = {0};
    enum ap_status st = same_size(err, left, right);
    if (!st)
        st = create(err, (uint64_t)left->width * 2, left->height, &made);
    if (st)
        return st;
    paste(left, 0, 0, &made);
    paste(right, left->width, 0, &made);
    *out = made;
    return AP_OK;
}

enum ap_status ap_image_anaglyph(struct ap_error *err, const struct ap_image *left,
                                 const struct ap_image *right, struct ap_image *out) {
    struct ap_image made = {0};
    enum ap_status st = same_size(err, left, right);
    if (!st)
        st = create(err, left->width, left->height, &made);
    if (st)
        return st;
    struct ap_srgb srgb;
    ap_srgb_init(&srgb);
    // The luminance of BT.709, whose primaries sRGB has.
    double weight[3][256];
    for (int v = 0; v < 256; v++) {
        weight[0][v] = 0.2126 * srgb.linear[v];
        weight[1][v] = 0.7152 * srgb.linear[v];
        weight[2][v] = 0.0722 * srgb.linear[v];
    }
    size_t n = (size_t)left->width * left->height;
    for (size_t k = 0; k < n; k++) {
        const uint8_t *l = left->rgb + 3 * k, *r = right->rgb + 3 * k;
        uint8_t *o = made.rgb + 3 * k;
        // A grey stays exactly that grey, whatever the weights round to.
        o[0] = l[0] == l[1] && l[1] == l[2]
                   ? l[0]
                   : ap_srgb_byte(&srgb, weight[0][l[0]] + weight[1][l[1]] + weight[2][l[2]]);
        o[1] = r[1];
        o[2] = r[2];
    }
    *out = made;
    return AP_OK;
}

enum ap_status ap_image_contact_sheet(struct ap_error *err, const struct ap_image *cells, size_t n,
                                      uint32_t columns, uint32_t gap_px, struct ap_image *out) {
    enum { GAP_GREY = 48 }; // so that a black cell shows its edges
    if (n == 0 || columns == 0 || n > UINT32_MAX)
        return ap_fail(err, AP_INPUT, "a contact sheet of %zu pictures in %u columns", n, columns);
    enum ap_status st = AP_OK;
    for (size_t k = 1; k < n && !st; k++)
        st = same_size(err, &cells[0], &cells[k]);
    if (st)
        return st;
    uint64_t across = n < columns ? n : columns, down = (n + columns - 1) / columns;
    uint64_t step_x = (uint64_t)cells[0].width + gap_px,
             step_y = (uint64_t)cells[0].height + gap_px;
    struct ap_image made = {0};
    st = create(err, across * step_x + gap_px, down * step_y + gap_px, &made);
    if (st)
        return st;
    memset(made.rgb, GAP_GREY, (size_t)made.width * made.height * 3);
    for (size_t k = 0; k < n; k++)
        paste(&cells[k], (uint32_t)(gap_px + k % columns * step_x),
              (uint32_t)(gap_px + k / columns * step_y), &made);
    *out = made;
    return AP_OK;
}

// Of a picture that is shrunk: the sums of columns over the rows of one cell, and where cells end.
struct shrink {
    const struct ap_image *in;
    struct ap_srgb srgb;
    uint32_t width;  // in cells
    double *columns; // 3·in->width
};

static void add_row(struct shrink *s, uint32_t y, double weight) {
    const uint8_t *row = s->in->rgb + (size_t)y * s->in->width * 3;
    for (size_t k = 0; k < (size_t)s->in->width * 3; k++)
        s->columns[k] += weight * s->srgb.linear[row[k]];
}

// The mean of the columns of cell i, times how many they are, into sum[3].
static void add_columns(const struct shrink *s, uint32_t i, double sum[3]) {
    double scale = (double)s->in->width / s->width;
    double from = i * scale, to = i + 1 == s->width ? s->in->width : (i + 1) * scale;
    sum[0] = sum[1] = sum[2] = 0;
    for (uint32_t x = (uint32_t)from; x < to && x < s->in->width; x++) {
        double w = (to < x + 1.0 ? to : x + 1.0) - (from > x ? from : x);
        for (size_t c = 0; c < 3; c++)
            sum[c] += w * s->columns[3 * (size_t)x + c];
    }
}

enum ap_status ap_image_shrink(struct ap_error *err, const struct ap_image *in, uint32_t width,
                               uint32_t height, struct ap_image *out) {
    if (width > in->width || height > in->height)
        return ap_fail(err, AP_INPUT, "a picture of %ux%u pixels cannot be shrunk to %ux%u",
                       in->width, in->height, width, height);
    struct ap_image made = {0};
    enum ap_status st = create(err, width, height, &made);
    if (st)
        return st;
    if (width == in->width && height == in->height) {
        memcpy(made.rgb, in->rgb, (size_t)width * height * 3);
        *out = made;
        return AP_OK;
    }
    size_t values = (size_t)in->width * 3;
    struct shrink s = {.in = in, .width = width, .columns = malloc(values * sizeof *s.columns)};
    if (!s.columns) {
        ap_image_finish(&made);
        return ap_fail(err, AP_ENVIRONMENT, "no memory to shrink a picture");
    }
    ap_srgb_init(&s.srgb);
    double scale = (double)in->height / height;
    double area = scale * in->width / width;
    for (uint32_t j = 0; j < height; j++) {
        double from = j * scale, to = j + 1 == height ? in->height : (j + 1) * scale;
        memset(s.columns, 0, values * sizeof *s.columns);
        for (uint32_t y = (uint32_t)from; y < to && y < in->height; y++)
            add_row(&s, y, fmin(to, y + 1.0) - fmax(from, y));
        for (uint32_t i = 0; i < width; i++) {
            double sum[3];
            add_columns(&s, i, sum);
            for (size_t c = 0; c < 3; c++)
                made.rgb[((size_t)j * width + i) * 3 + c] = ap_srgb_byte(&s.srgb, sum[c] / area);
        }
    }
    free(s.columns);
    *out = made;
    return AP_OK;
}
