#include "src/image/lens.h"

#include <math.h>

#include "src/image/srgb.h"

// Bilinear, the edge repeated; i and j count from the first pixel's centre.
static double sample(const struct ap_pixels *p, const double *linear, int byte, double i,
                     double j) {
    double fi = floor(i), fj = floor(j), a = i - fi, b = j - fj;
    long last_i = (long)p->width - 1, last_j = (long)p->height - 1;
    long i0 = fi < 0 ? 0 : (long)fi, i1 = (long)fi + 1 > last_i ? last_i : (long)fi + 1;
    long j0 = fj < 0 ? 0 : (long)fj, j1 = (long)fj + 1 > last_j ? last_j : (long)fj + 1;
    const uint8_t *upper = p->bytes + (size_t)j0 * p->stride + byte;
    const uint8_t *lower = p->bytes + (size_t)j1 * p->stride + byte;
    return (1 - b) * ((1 - a) * linear[upper[4 * i0]] + a * linear[upper[4 * i1]]) +
           b * ((1 - a) * linear[lower[4 * i0]] + a * linear[lower[4 * i1]]);
}

void ap_pixels_through_lens(const struct ap_pixels *p, const struct ap_lens_view *v,
                            uint8_t *rgba) {
    struct ap_srgb table;
    ap_srgb_init(&table);
    double per_x = p->width / (v->right - v->left), per_y = p->height / (v->up - v->down);
    for (uint32_t y = 0; y < p->height; y++)
        for (uint32_t x = 0; x < p->width; x++, rgba += 4) {
            double px = v->left + (x + 0.5) / per_x, py = v->up - (y + 0.5) / per_y;
            double r2 = px * px + py * py, seen = 1 + r2 * (v->k1 + r2 * v->k2);
            for (int c = 0; c < 3; c++) {
                double i = (px * seen * v->scale[c] - v->left) * per_x - 0.5;
                double j = (v->up - py * seen * v->scale[c]) * per_y - 0.5;
                bool inside = i >= -0.5 && i <= p->width - 0.5 && j >= -0.5 && j <= p->height - 0.5;
                int byte = p->bgra ? 2 - c : c;
                rgba[c] = inside ? ap_srgb_byte(&table, sample(p, table.linear, byte, i, j)) : 0;
            }
            rgba[3] = 255;
        }
}
