#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "src/base/file.h"
#include "src/base/number.h"
#include "src/image/grey.h"

// https://netpbm.sourceforge.net/doc/pam.html

enum { MAX_SIDE = 32768, MAX_HEADER_LINES = 64, MAX_HEADER_LINE = 256 };

static void write_row(FILE *stream, const struct ap_pixels *p, uint32_t y, uint8_t *swapped) {
    const uint8_t *row = p->bytes + (size_t)y * p->stride;
    size_t n = (size_t)p->width * 4;
    if (p->bgra) {
        for (size_t i = 0; i < n; i += 4) {
            swapped[i] = row[i + 2];
            swapped[i + 1] = row[i + 1];
            swapped[i + 2] = row[i];
            swapped[i + 3] = row[i + 3];
        }
        row = swapped;
    }
    fwrite(row, 1, n, stream);
}

enum ap_status ap_pam_write_pixels(struct ap_error *err, const char *path,
                                   const struct ap_pixels *p, bool linear) {
    if (p->width == 0 || p->height == 0 || p->width > MAX_SIDE || p->height > MAX_SIDE ||
        p->stride < (size_t)p->width * 4)
        return ap_fail(err, AP_INPUT, "%s: a picture of %ux%u pixels in rows of %zu bytes", path,
                       p->width, p->height, p->stride);
    uint8_t *swapped = malloc((size_t)p->width * 4);
    if (!swapped)
        return ap_fail(err, AP_ENVIRONMENT, "%s: no memory to write it", path);
    struct ap_outfile file;
    enum ap_status st = ap_outfile_open(err, path, &file);
    if (!st) {
        fprintf(file.stream, "P7\n%sWIDTH %u\nHEIGHT %u\nDEPTH 4\nMAXVAL 255\n",
                linear ? "# linear light\n" : "", p->width, p->height);
        fputs("TUPLTYPE RGB_ALPHA\nENDHDR\n", file.stream);
        for (uint32_t y = 0; y < p->height && !ferror(file.stream); y++)
            write_row(file.stream, p, y, swapped);
        st = ap_outfile_commit(err, &file);
    }
    free(swapped);
    return st;
}

enum ap_status ap_pam_write_grey(struct ap_error *err, const char *path, const struct ap_grey *g) {
    struct ap_outfile file;
    enum ap_status st = ap_outfile_open(err, path, &file);
    if (st)
        return st;
    fprintf(file.stream, "P7\nWIDTH %u\nHEIGHT %u\nDEPTH 1\nMAXVAL 65535\n", g->width, g->height);
    fputs("TUPLTYPE GRAYSCALE\nENDHDR\n", file.stream);
    for (size_t k = 0; k < (size_t)g->width * g->height && !ferror(file.stream); k++) {
        putc(g->values[k] >> 8, file.stream);
        putc(g->values[k] & 255, file.stream);
    }
    return ap_outfile_commit(err, &file);
}

struct header {
    int64_t width, height, depth, maxval;
};

// "KEY value" into the member that is meant; other keys are let pass, as the format asks.
static bool read_key(const char *line, struct header *h) {
    static const char *const keys[] = {"WIDTH ", "HEIGHT ", "DEPTH ", "MAXVAL "};
    int64_t *const values[] = {&h->width, &h->height, &h->depth, &h->maxval};
    for (int k = 0; k < 4; k++) {
        size_t n = strlen(keys[k]);
        if (strncmp(line, keys[k], n) == 0)
            return ap_parse_int64(line + n, strlen(line + n), values[k]);
    }
    return true;
}

static const char *read_header(FILE *f, struct header *h) {
    char line[MAX_HEADER_LINE];
    for (int k = 0; k < MAX_HEADER_LINES; k++) {
        if (!fgets(line, sizeof line, f))
            return "the header is cut short";
        size_t n = strcspn(line, "\n");
        if (line[n] != '\n')
            return "a line of the header is too long";
        line[n] = '\0';
        if (k == 0 ? strcmp(line, "P7") != 0 : !read_key(line, h))
            return "the header cannot be read";
        if (strcmp(line, "ENDHDR") != 0)
            continue;
        if (h->width < 1 || h->height < 1 || h->width > MAX_SIDE || h->height > MAX_SIDE)
            return "WIDTH and HEIGHT: expected 1 to 32768";
        bool colour = (h->depth == 3 || h->depth == 4) && h->maxval == 255;
        if (!colour && (h->depth != 1 || h->maxval != 65535))
            return "expected DEPTH 3 or 4 and MAXVAL 255, or 1 and 65535";
        return NULL;
    }
    return "the header is too long";
}

static size_t pixel_bytes(const struct header *h) {
    return h->depth == 1 ? 2 : (size_t)h->depth;
}

static const char *read_grey(FILE *f, struct ap_image *image) {
    struct ap_error err;
    if (ap_image_make_grey(&err, image))
        return "out of memory";
    for (size_t k = 0; k < (size_t)image->width * image->height; k++) {
        int high = getc(f), low = getc(f);
        if (low == EOF)
            return "the pixels are cut short";
        image->grey[k] = (uint16_t)(high << 8 | low);
    }
    ap_image_show_grey(image);
    return NULL;
}

static const char *read_pixels(FILE *f, const struct header *h, struct ap_image *image) {
    size_t width = (size_t)h->width, depth = (size_t)h->depth;
    uint8_t *row = malloc(width * depth);
    const char *why = row ? NULL : "out of memory";
    for (size_t y = 0; y < (size_t)h->height && !why; y++) {
        if (fread(row, depth, width, f) != width)
            why = "the pixels are cut short";
        for (size_t x = 0; x < width && !why; x++)
            memcpy(image->rgb + 3 * (y * width + x), row + depth * x, 3);
    }
    free(row);
    return why;
}

static enum ap_status pam_read(struct ap_error *err, const char *path, struct ap_image *image) {
    FILE *f = fopen(path, "rb");
    if (!f)
        return ap_fail(err, AP_INPUT, "%s: cannot be read: %s", path, strerror(errno));
    struct header h = {0};
    struct ap_image made = {0};
    const char *why = read_header(f, &h);
    // A header that promises more than there is gets no memory.
    long here = why ? 0 : ftell(f);
    if (!why && here >= 0 && fseek(f, 0, SEEK_END) == 0) {
        if (ftell(f) - here < h.width * h.height * (long)pixel_bytes(&h))
            why = "the pixels are cut short";
        else
            fseek(f, here, SEEK_SET);
    }
    enum ap_status st =
        why ? AP_OK : ap_image_create(err, (uint32_t)h.width, (uint32_t)h.height, &made);
    if (!st && !why)
        why = h.depth == 1 ? read_grey(f, &made) : read_pixels(f, &h, &made);
    fclose(f);
    if (why)
        st = ap_fail(err, AP_INPUT, "%s: not a whole PAM picture: %s", path, why);
    if (st)
        ap_image_finish(&made);
    else
        *image = made;
    return st;
}

enum ap_status ap_picture_read(struct ap_error *err, const char *path, struct ap_image *image) {
    char magic[3] = {0};
    FILE *f = fopen(path, "rb");
    if (!f)
        return ap_fail(err, AP_INPUT, "%s: cannot be read: %s", path, strerror(errno));
    size_t n = fread(magic, 1, 2, f);
    fclose(f);
    return n == 2 && strcmp(magic, "P7") == 0 ? pam_read(err, path, image)
                                              : ap_png_read(err, path, image);
}
