#ifndef ANTIPODE_IMAGE_COMPARE_H
#define ANTIPODE_IMAGE_COMPARE_H

#include "src/image/image.h"

// How far two pictures of one size are apart. Pure; any thread; the same numbers on every machine
// but for the last bits that its libm decides.

struct ap_region {
    uint32_t x, y, width, height; // the box round it
    uint64_t pixels;              // in it that differ; 0: none does
};

struct ap_difference {
    uint64_t pixels;          // in which any channel differs
    int largest_step;         // of one channel's byte, of 16 bits in bytes, rounded up
    double psnr_db;           // over all three channels' bytes, peak 255; INFINITY: the same
    struct ap_region largest; // the largest patch of differing pixels that touch, corners counted
};

// Two pictures of 16 bits (grey) are compared with all of them, peak 65535.
// AP_INPUT where the sizes differ; AP_ENVIRONMENT without memory.
enum ap_status ap_image_difference(struct ap_error *err, const struct ap_image *a,
                                   const struct ap_image *b, struct ap_difference *difference);

// Structural similarity (Wang, Bovik, Sheikh, Simoncelli 2004), 1 for the same picture: of
// 0.299 R + 0.587 G + 0.114 B of the bytes, Gaussian windows of 11×11 with sigma 1.5, K1 = 0.01,
// K2 = 0.03, L = 255, the mean over the windows that lie wholly inside. In a picture that is
// narrower or lower than 11 the window is the largest odd size that fits.
enum ap_status ap_image_ssim(struct ap_error *err, const struct ap_image *a,
                             const struct ap_image *b, double *ssim);

// FLIP for LDR pictures (Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström, Fairchild 2020):
// what a person sees who flips between the two, 0 to 1, the mean over the pixels. ppd: pixels per
// degree of the viewer's sight, above 0, at most 1000; the paper's viewer has AP_FLIP_PPD. map:
// NULL, or width·height numbers, each pixel's.
#define AP_FLIP_PPD 67.02064327658226
enum ap_status ap_image_flip(struct ap_error *err, const struct ap_image *reference,
                             const struct ap_image *test, double ppd, double *flip, float *map);

// The two pictures and a map of where they differ, side by side. The map: black where they are the
// same, then dark red over orange to white with the largest step of a pixel's channels (so small
// steps are seen: it goes with the square root), or with flip_map where it is not NULL.
enum ap_status ap_image_difference_picture(struct ap_error *err, const struct ap_image *a,
                                           const struct ap_image *b, const float *flip_map,
                                           struct ap_image *out);

#endif
