#include "src/image/image.h"

#include <math.h>
#include <stdlib.h>

#include "src/image/grey.h"
#include "src/image/srgb.h"

enum { MAX_SIDE = 32768 };

enum ap_status ap_image_create(struct ap_error *err, uint32_t width, uint32_t height,
                               struct ap_image *image) {
    if (width == 0 || height == 0 || width > MAX_SIDE || height > MAX_SIDE)
        return ap_fail(err, AP_INPUT, "a picture of %ux%u pixels: expected 1 to %d each way", width,
                       height, MAX_SIDE);
    uint8_t *rgb = calloc((size_t)width * height, 3);
    if (!rgb)
        return ap_fail(err, AP_ENVIRONMENT, "no memory for a picture of %ux%u pixels", width,
                       height);
    *image = (struct ap_image){.width = width, .height = height, .rgb = rgb};
    return AP_OK;
}

enum ap_status ap_image_make_grey(struct ap_error *err, struct ap_image *image) {
    image->grey = calloc((size_t)image->width * image->height, sizeof *image->grey);
    return image->grey ? AP_OK
                       : ap_fail(err, AP_ENVIRONMENT, "no memory for a picture of %ux%u pixels",
                                 image->width, image->height);
}

void ap_image_show_grey(struct ap_image *image) {
    for (size_t k = 0; k < (size_t)image->width * image->height; k++)
        for (int c = 0; c < 3; c++)
            image->rgb[3 * k + (size_t)c] = (uint8_t)((image->grey[k] + 128) / 257);
}

void ap_image_finish(struct ap_image *image) {
    free(image->rgb);
    free(image->grey);
    *image = (struct ap_image){0};
}

// IEC 61966-2-1, f the encoded value 0…1.
static double linear_from_encoded(double f) {
    return f <= 0.04045 ? f / 12.92 : pow((f + 0.055) / 1.055, 2.4);
}

double ap_linear_from_srgb(uint8_t v) {
    return linear_from_encoded(v / 255.0);
}

uint8_t ap_srgb_from_linear(double v) {
    if (!(v > 0))
        return 0;
    if (v >= 1)
        return 255;
    double f = v <= 0.0031308 ? 12.92 * v : 1.055 * pow(v, 1 / 2.4) - 0.055;
    return (uint8_t)floor(255 * f + 0.5);
}

void ap_srgb_init(struct ap_srgb *table) {
    for (int v = 0; v < 256; v++) {
        table->linear[v] = linear_from_encoded(v / 255.0);
        table->border[v] = v ? linear_from_encoded((v - 0.5) / 255.0) : 0;
    }
    unsigned b = 0;
    for (int s = 0; s <= AP_SRGB_STEPS; s++) {
        while (b < 255 && (double)s / AP_SRGB_STEPS >= table->border[b + 1])
            b++;
        table->guess[s] = (uint8_t)b;
    }
}
