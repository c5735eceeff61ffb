#include "sim_hmd/window/arrange.h"

#include <math.h>
#include <string.h>

#include "src/image/image.h"

// Columns from…from + count of each row, to column `to` of rows of `pitch` pixels.
static void copy_columns(const struct sim_pair *pair, uint32_t from, uint32_t count, uint32_t to,
                         uint32_t pitch, uint8_t *out) {
    for (uint32_t y = 0; y < pair->height_px; y++)
        memcpy(out + 4 * ((size_t)y * pitch + to),
               pair->rgba + 4 * ((size_t)y * pair->width_px + from), 4 * (size_t)count);
}

// sRGB bytes by luminance, 1/16 apart in 255 of linear light: fine enough for 8 bits of red.
struct luminance {
    uint16_t weight[3][256]; // of 4095
    uint8_t byte[4096];
};

static void make_luminance(struct luminance *l) {
    static const double bt709[3] = {0.2126, 0.7152, 0.0722};
    for (int v = 0; v < 256; v++) {
        double linear = ap_linear_from_srgb((uint8_t)v);
        for (int c = 0; c < 3; c++)
            l->weight[c][v] = (uint16_t)(bt709[c] * linear * 4092 + 0.5);
    }
    for (int v = 0; v < 4096; v++)
        l->byte[v] = ap_srgb_from_linear(fmin(v / 4092.0, 1));
}

static void anaglyph(const struct sim_pair *pair, uint32_t width, uint8_t *out) {
    static struct luminance l;
    if (l.byte[4095] == 0)
        make_luminance(&l);
    for (uint32_t y = 0; y < pair->height_px; y++) {
        const uint8_t *left = pair->rgba + 4 * (size_t)y * pair->width_px;
        const uint8_t *right = left + 4 * (size_t)pair->split_px;
        for (uint32_t x = 0; x < width; x++, left += 4, right += 4, out += 4) {
            out[0] = l.byte[l.weight[0][left[0]] + l.weight[1][left[1]] + l.weight[2][left[2]]];
            out[1] = right[1];
            out[2] = right[2];
            out[3] = 255;
        }
    }
}

void sim_arrange(const struct sim_pair *pair, enum sim_window_layout layout, uint8_t *out,
                 uint32_t *width_px, uint32_t *height_px) {
    uint32_t left = pair->split_px, right = pair->width_px - pair->split_px;
    *width_px = pair->width_px;
    *height_px = pair->height_px;
    if (left == 0 || layout == SIM_WINDOW_PAIR) {
        memcpy(out, pair->rgba, 4 * (size_t)pair->width_px * pair->height_px);
    } else if (layout == SIM_WINDOW_CROSS) {
        copy_columns(pair, left, right, 0, pair->width_px, out);
        copy_columns(pair, 0, left, right, pair->width_px, out);
    } else if (layout == SIM_WINDOW_LEFT) {
        *width_px = left;
        copy_columns(pair, 0, left, 0, left, out);
    } else {
        *width_px = left < right ? left : right;
        anaglyph(pair, *width_px, out);
    }
}
