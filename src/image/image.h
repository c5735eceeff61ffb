#ifndef ANTIPODE_IMAGE_IMAGE_H
#define ANTIPODE_IMAGE_IMAGE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "src/base/status.h"

// 8-bit RGB pictures, sRGB, row 0 at the top. Pixel (i, j) has its centre at (i+½, j+½).
struct ap_image {
    uint32_t width, height;
    uint8_t *rgb; // 3·width·height
    // Of a picture of one channel of 16 bits its values, of which rgb then has the upper bits; else
    // NULL.
    uint16_t *grey;
};

// Zeroed (black) pixels. AP_ENVIRONMENT without memory; AP_INPUT for a size of 0 or over 32768.
enum ap_status ap_image_create(struct ap_error *err, uint32_t width, uint32_t height,
                               struct ap_image *image);
void ap_image_finish(struct ap_image *image);

// PNG through ap_outfile: whole or not at all. The bytes depend on the pixels only. Any thread.
enum ap_status ap_png_write(struct ap_error *err, const char *path, const struct ap_image *image);

// From rows of 4-byte pixels, without a copy of the picture: R,G,B at the byte offsets 0,1,2 (or
// 2,1,0 where bgra).
struct ap_pixels {
    const uint8_t *bytes;
    uint32_t width, height;
    size_t stride;
    bool bgra;
};

// Flags: the fourth byte as alpha, as it is; a note (gAMA) that the bytes are linear light and not
// sRGB.
enum { AP_PNG_ALPHA = 1, AP_PNG_LINEAR = 2 };
enum ap_status ap_png_write_pixels(struct ap_error *err, const char *path,
                                   const struct ap_pixels *pixels, unsigned flags);

enum ap_status ap_png_read(struct ap_error *err, const char *path, struct ap_image *image);

// PAM (Netpbm's P7): a header of text, then R,G,B,A bytes, row by row; nothing is compressed.
// linear: a comment in the header says so.
enum ap_status ap_pam_write_pixels(struct ap_error *err, const char *path,
                                   const struct ap_pixels *pixels, bool linear);

// One channel of 16 bits that is no light (a depth), 0 to 65535, row by row without gaps. As PNG,
// or as PAM (raw: GRAYSCALE, MAXVAL 65535, the upper byte first).
struct ap_grey {
    const uint16_t *values;
    uint32_t width, height;
};
enum ap_status ap_grey_write(struct ap_error *err, const char *path, const struct ap_grey *grey,
                             bool raw);

// PNG, or PAM with RGB or RGB_ALPHA of 8 bits (alpha is dropped) or GRAYSCALE of 16, by the file's
// first bytes. AP_INPUT.
enum ap_status ap_picture_read(struct ap_error *err, const char *path, struct ap_image *image);

// sRGB byte ↔ linear light 0…1.
double ap_linear_from_srgb(uint8_t v);
uint8_t ap_srgb_from_linear(double v);

// Side by side; red-cyan (left eye red, half-colour, in linear light); a sheet of n equally large
// cells, `columns` wide. Inputs of one size, else AP_INPUT.
enum ap_status ap_image_side_by_side(struct ap_error *err, const struct ap_image *left,
                                     const struct ap_image *right, struct ap_image *out);
enum ap_status ap_image_anaglyph(struct ap_error *err, const struct ap_image *left,
                                 const struct ap_image *right, struct ap_image *out);
enum ap_status ap_image_contact_sheet(struct ap_error *err, const struct ap_image *cells, size_t n,
                                      uint32_t columns, uint32_t gap_px, struct ap_image *out);

// Box-filtered in linear light to the given size (not larger than the source).
enum ap_status ap_image_shrink(struct ap_error *err, const struct ap_image *in, uint32_t width,
                               uint32_t height, struct ap_image *out);

#endif
