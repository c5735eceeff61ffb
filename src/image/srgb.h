#ifndef ANTIPODE_IMAGE_SRGB_H
#define ANTIPODE_IMAGE_SRGB_H

#include <stdint.h>

// The two directions of the sRGB curve as tables, for whole pictures: a stack object, 30 µs to
// make, no shared state. Private to this folder.
enum { AP_SRGB_STEPS = 4096 };
struct ap_srgb {
    double linear[256];               // of each byte
    double border[256];               // linear light from which on the byte is v (border[0] = 0)
    uint8_t guess[AP_SRGB_STEPS + 1]; // the byte at the lower end of each step of linear light
};

void ap_srgb_init(struct ap_srgb *table);

// The same byte as ap_srgb_from_linear.
static inline uint8_t ap_srgb_byte(const struct ap_srgb *table, double v) {
    if (!(v > 0))
        return 0;
    if (v >= 1)
        return 255;
    unsigned b = table->guess[(int)(v * AP_SRGB_STEPS)];
    while (b < 255 && v >= table->border[b + 1])
        b++;
    return (uint8_t)b;
}

#endif
