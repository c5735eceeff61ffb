#include <errno.h>
#include <png.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <zlib.h>

#include "src/base/file.h"
#include "src/image/grey.h"

enum { MAX_SIDE = 32768 };

// libpng leaves a failed call by longjmp. So that no local variable's value is ever in doubt, what
// must survive lives in one of these, and the function that calls setjmp only calls another.
struct png_job {
    png_structp png;
    png_infop info;
    FILE *stream;
    int64_t file_bytes; // −1: not known
    bool writes;
    const struct ap_pixels *pixels; // to be written: this, or
    const struct ap_grey *grey;     // this
    unsigned flags;                 // AP_PNG_…
    struct ap_image image;
    char why[256];
    enum ap_status status;
};

static void on_error(png_structp png, png_const_charp text) {
    struct png_job *job = png_get_error_ptr(png);
    // A failed write is told by errno better than by libpng's "Write Error".
    if (job->why[0] == '\0')
        snprintf(job->why, sizeof job->why, "%s",
                 job->writes && ferror(job->stream) && errno ? strerror(errno) : text);
    png_longjmp(png, 1);
}

static void on_warning(png_structp png, png_const_charp text) {
    (void)png;
    (void)text;
}

// What is the same for all.
static void begin_writing(struct png_job *job) {
    png_init_io(job->png, job->stream);
    // Measured on a drawn 1440×1600 scene (docs/capture-composition.md): 26 ms and 392 kB; level 6
    // takes 84 ms for 284 kB, all filters at this level 62 ms for 414 kB.
    png_set_compression_level(job->png, 1);
    png_set_filter(job->png, 0, PNG_FILTER_UP);
    png_set_compression_strategy(job->png, Z_DEFAULT_STRATEGY);
    png_set_compression_mem_level(job->png, 9);
    png_set_compression_buffer_size(job->png, 65536);
}

static void write_grey_rows(struct png_job *job) {
    const struct ap_grey *g = job->grey;
    const uint16_t one = 1;
    begin_writing(job);
    png_set_IHDR(job->png, job->info, g->width, g->height, 16, PNG_COLOR_TYPE_GRAY,
                 PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_write_info(job->png, job->info);
    if (*(const uint8_t *)&one) // the file has the upper byte first
        png_set_swap(job->png);
    for (uint32_t y = 0; y < g->height; y++)
        png_write_row(job->png, (const uint8_t *)(g->values + (size_t)y * g->width));
    png_write_end(job->png, NULL);
}

static void write_rows(struct png_job *job) {
    const struct ap_pixels *p = job->pixels;
    bool packed = p->stride == 0; // rows of 3 bytes: ap_png_write
    size_t stride = packed ? (size_t)p->width * 3 : p->stride;
    begin_writing(job);
    bool alpha = job->flags & AP_PNG_ALPHA;
    png_set_IHDR(job->png, job->info, p->width, p->height, 8,
                 alpha ? PNG_COLOR_TYPE_RGB_ALPHA : PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    if (job->flags & AP_PNG_LINEAR)
        png_set_gAMA(job->png, job->info, 1.0);
    else
        png_set_sRGB(job->png, job->info, PNG_sRGB_INTENT_PERCEPTUAL);
    png_write_info(job->png, job->info);
    if (!packed && !alpha)
        png_set_filler(job->png, 0, PNG_FILLER_AFTER);
    if (p->bgra)
        png_set_bgr(job->png);
    for (uint32_t y = 0; y < p->height; y++)
        png_write_row(job->png, p->bytes + y * stride);
    png_write_end(job->png, NULL);
}

static bool try_write(struct png_job *job) {
    if (setjmp(png_jmpbuf(job->png)))
        return false;
    if (job->grey)
        write_grey_rows(job);
    else
        write_rows(job);
    return true;
}

static enum ap_status write_png(struct ap_error *err, const char *path,
                                const struct ap_pixels *pixels, const struct ap_grey *grey,
                                unsigned flags) {
    struct ap_outfile file = {0};
    struct png_job job = {.writes = true, .pixels = pixels, .grey = grey, .flags = flags};
    enum ap_status st = ap_outfile_open(err, path, &file);
    if (st)
        return st;
    job.stream = file.stream;
    job.png = png_create_write_struct(PNG_LIBPNG_VER_STRING, &job, on_error, on_warning);
    job.info = job.png ? png_create_info_struct(job.png) : NULL;
    if (!job.info)
        st = ap_fail(err, AP_ENVIRONMENT, "%s: no memory to write it", path);
    else if (!try_write(&job))
        st = ap_fail(err, AP_ENVIRONMENT, "%s: cannot be written: %s", path, job.why);
    png_destroy_write_struct(&job.png, &job.info);
    if (st) {
        ap_outfile_abort(&file);
        return st;
    }
    return ap_outfile_commit(err, &file);
}

static enum ap_status check_size(struct ap_error *err, const char *path, uint32_t width,
                                 uint32_t height) {
    if (width == 0 || height == 0 || width > MAX_SIDE || height > MAX_SIDE)
        return ap_fail(err, AP_INPUT, "%s: a picture of %ux%u pixels: expected 1 to %d each way",
                       path, width, height, MAX_SIDE);
    return AP_OK;
}

enum ap_status ap_png_write(struct ap_error *err, const char *path, const struct ap_image *image) {
    enum ap_status st = check_size(err, path, image->width, image->height);
    if (st)
        return st;
    struct ap_pixels packed = {image->rgb, image->width, image->height, 0, false};
    return write_png(err, path, &packed, NULL, 0);
}

enum ap_status ap_png_write_pixels(struct ap_error *err, const char *path,
                                   const struct ap_pixels *pixels, unsigned flags) {
    enum ap_status st = check_size(err, path, pixels->width, pixels->height);
    if (st)
        return st;
    if (pixels->stride < (size_t)pixels->width * 4)
        return ap_fail(err, AP_INPUT, "%s: rows of %zu bytes are too short for %u pixels", path,
                       pixels->stride, pixels->width);
    return write_png(err, path, pixels, NULL, flags);
}

enum ap_status ap_grey_write(struct ap_error *err, const char *path, const struct ap_grey *grey,
                             bool raw) {
    enum ap_status st = check_size(err, path, grey->width, grey->height);
    if (st)
        return st;
    return raw ? ap_pam_write_grey(err, path, grey) : write_png(err, path, NULL, grey, 0);
}

// Deflate makes at most 1032 bytes of one, so a short file that promises a huge picture is refused
// before any memory is taken for it.
static bool plausible(const struct png_job *job, uint32_t height) {
    double bytes = (double)png_get_rowbytes(job->png, job->info) * height;
    return job->file_bytes < 0 || bytes <= 1032.0 * (double)job->file_bytes;
}

// One channel of 16 bits, nothing transparent.
static bool is_grey_16(const struct png_job *job) {
    return png_get_bit_depth(job->png, job->info) == 16 &&
           png_get_color_type(job->png, job->info) == PNG_COLOR_TYPE_GRAY &&
           !png_get_valid(job->png, job->info, PNG_INFO_tRNS);
}

static void read_grey_rows(struct png_job *job) {
    struct ap_image *image = &job->image;
    struct ap_error error = {{0}};
    const uint16_t one = 1;
    job->status = ap_image_make_grey(&error, image);
    if (job->status)
        png_error(job->png, error.text);
    job->status = AP_INPUT;
    if (*(const uint8_t *)&one)
        png_set_swap(job->png);
    int passes = png_set_interlace_handling(job->png);
    png_read_update_info(job->png, job->info);
    for (int pass = 0; pass < passes; pass++)
        for (uint32_t y = 0; y < image->height; y++)
            png_read_row(job->png, (uint8_t *)(image->grey + (size_t)y * image->width), NULL);
    png_read_end(job->png, NULL);
    ap_image_show_grey(image);
}

static void read_rows(struct png_job *job) {
    png_structp png = job->png;
    png_init_io(png, job->stream);
    png_set_user_limits(png, MAX_SIDE, MAX_SIDE);
    png_set_chunk_malloc_max(png, 1 << 20);
    png_set_chunk_cache_max(png, 16);
    png_read_info(png, job->info);
    uint32_t width = png_get_image_width(png, job->info);
    uint32_t height = png_get_image_height(png, job->info);
    if (!plausible(job, height))
        png_error(png, "the file is cut short");
    struct ap_error error = {{0}};
    job->status = ap_image_create(&error, width, height, &job->image);
    if (job->status)
        png_error(png, error.text);
    job->status = AP_INPUT;
    if (is_grey_16(job)) {
        read_grey_rows(job);
        return;
    }
    png_set_expand(png);
    png_set_scale_16(png);
    png_set_gray_to_rgb(png);
    png_set_strip_alpha(png);
    int passes = png_set_interlace_handling(png);
    png_read_update_info(png, job->info);
    if (png_get_rowbytes(png, job->info) != (size_t)width * 3)
        png_error(png, "a kind of PNG that is not read here");
    for (int pass = 0; pass < passes; pass++)
        for (uint32_t y = 0; y < height; y++)
            png_read_row(png, job->image.rgb + (size_t)y * width * 3, NULL);
    png_read_end(png, NULL);
}

static bool try_read(struct png_job *job) {
    if (setjmp(png_jmpbuf(job->png)))
        return false;
    read_rows(job);
    return true;
}

enum ap_status ap_png_read(struct ap_error *err, const char *path, struct ap_image *image) {
    struct png_job job = {.file_bytes = -1, .status = AP_INPUT};
    enum ap_status st = AP_OK;
    struct stat info;
    job.stream = fopen(path, "rb");
    if (!job.stream)
        return ap_fail(err, AP_INPUT, "%s: cannot be read: %s", path, strerror(errno));
    if (fstat(fileno(job.stream), &info) == 0 && S_ISREG(info.st_mode))
        job.file_bytes = info.st_size;
    job.png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &job, on_error, on_warning);
    job.info = job.png ? png_create_info_struct(job.png) : NULL;
    if (!job.info) {
        st = ap_fail(err, AP_ENVIRONMENT, "%s: no memory to read it", path);
        goto out;
    }
    if (!try_read(&job)) {
        st = ap_fail(err, job.status, "%s: not a whole PNG picture: %s", path, job.why);
        goto out;
    }
    *image = job.image;
    job.image = (struct ap_image){0};
out:
    ap_image_finish(&job.image);
    png_destroy_read_struct(&job.png, &job.info, NULL);
    fclose(job.stream);
    return st;
}
