#include <math.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include "src/app/page.h"
#include "src/base/file.h"
#include "src/image/image.h"

// The contact sheet: the left eye's pictures, at most CELLS_MAX of them, evenly chosen.
enum { THREADS = 2, CELLS_MAX = 48, CELL_WIDTH = 240, GAP_PX = 4 };

static enum ap_status no_memory(struct ap_error *err) {
    return ap_fail(err, AP_ENVIRONMENT, "out of memory");
}

struct work {
    const struct ap_capture *capture;
    const struct ap_progress *progress;
    struct ap_image *cells; // one a captured frame; empty where it is not on the sheet
    size_t cell_count;      // how many are wanted
    atomic_size_t next;
    atomic_int stop;
    pthread_mutex_t lock; // of what follows
    int64_t done;
    enum ap_status status; // the first failure
    struct ap_error error;
};

static enum ap_status read_eye(struct ap_error *err, const struct ap_capture *c, int64_t frame,
                               const char *name, struct ap_image *image, bool *found) {
    char *path = ap_capture_picture_path(c, frame, name);
    if (!path)
        return no_memory(err);
    *found = ap_file_exists(path);
    enum ap_status st = *found ? ap_png_read(err, path, image) : AP_OK;
    free(path);
    return st;
}

// The picture on black of the given size, in its upper left corner.
static enum ap_status pad(struct ap_error *err, struct ap_image *image, uint32_t width,
                          uint32_t height) {
    if (image->width == width && image->height == height)
        return AP_OK;
    struct ap_image made = {0};
    enum ap_status st = ap_image_create(err, width, height, &made);
    if (st)
        return st;
    for (uint32_t y = 0; y < image->height; y++)
        memcpy(made.rgb + (size_t)y * width * 3, image->rgb + (size_t)y * image->width * 3,
               (size_t)image->width * 3);
    ap_image_finish(image);
    *image = made;
    return AP_OK;
}

// Moved to the right by px, black where nothing is left.
static void move_right(struct ap_image *image, long px) {
    long w = image->width, keep = w - labs(px);
    for (uint32_t y = 0; y < image->height && px != 0; y++) {
        uint8_t *row = image->rgb + (size_t)y * image->width * 3;
        memmove(row + (px > 0 ? 3 * px : 0), row + (px < 0 ? -3 * px : 0), (size_t)keep * 3);
        memset(px > 0 ? row : row + 3 * keep, 0, (size_t)labs(px) * 3);
    }
}

static enum ap_status write_as(struct ap_error *err, const struct ap_capture *c, int64_t frame,
                               const char *name, const struct ap_image *image) {
    char *path = ap_capture_picture_path(c, frame, name);
    if (!path)
        return no_memory(err);
    enum ap_status st = ap_png_write(err, path, image);
    free(path);
    return st;
}

typedef enum ap_status (*compose_fn)(struct ap_error *err, const struct ap_image *left,
                                     const struct ap_image *right, struct ap_image *out);

static enum ap_status write_pair(struct ap_error *err, const struct ap_capture *c, int64_t frame,
                                 const struct ap_image eye[2], compose_fn compose,
                                 const char *name) {
    struct ap_image made = {0};
    enum ap_status st = compose(err, &eye[0], &eye[1], &made);
    if (!st)
        st = write_as(err, c, frame, name, &made);
    ap_image_finish(&made);
    return st;
}

static bool on_sheet(const struct work *w, size_t k) {
    size_t n = w->capture->frame_count;
    return k * w->cell_count / n != (k + 1) * w->cell_count / n;
}

static enum ap_status make_cell(struct ap_error *err, const struct ap_image *left,
                                struct ap_image *cell) {
    uint32_t width = left->width < CELL_WIDTH ? left->width : CELL_WIDTH;
    uint32_t height = (uint32_t)((uint64_t)left->height * width / left->width);
    return ap_image_shrink(err, left, width, height ? height : 1, cell);
}

static enum ap_status write_frame(struct ap_error *err, struct work *w, size_t k) {
    const struct ap_capture *c = w->capture;
    int64_t frame = c->frames[k].frame;
    struct ap_image eye[2] = {{0}, {0}};
    bool found;
    enum ap_status st = read_eye(err, c, frame, "left.png", &eye[0], &found);
    if (!st && found)
        st = read_eye(err, c, frame, "right.png", &eye[1], &found);
    if (st || !found)
        goto out;
    if (on_sheet(w, k))
        st = make_cell(err, &eye[0], &w->cells[k]);
    uint32_t width = eye[0].width > eye[1].width ? eye[0].width : eye[1].width;
    uint32_t height = eye[0].height > eye[1].height ? eye[0].height : eye[1].height;
    for (int e = 0; e < 2 && !st; e++)
        st = pad(err, &eye[e], width, height);
    if (!st)
        st = write_pair(err, c, frame, eye, ap_image_side_by_side, "sbs.png");
    // For red-cyan glasses what lies at infinity must coincide, however uneven the eyes are.
    if (!st) {
        move_right(&eye[1], lround(ap_capture_eye_shift(c, INFINITY) * width));
        st = write_pair(err, c, frame, eye, ap_image_anaglyph, "anaglyph.png");
    }
out:
    ap_image_finish(&eye[0]);
    ap_image_finish(&eye[1]);
    return st;
}

static void *work_on(void *data) {
    struct work *w = data;
    int64_t total = (int64_t)w->capture->frame_count;
    while (!atomic_load(&w->stop)) {
        size_t k = atomic_fetch_add(&w->next, 1);
        if (k >= w->capture->frame_count)
            break;
        struct ap_error err;
        enum ap_status st = write_frame(&err, w, k);
        pthread_mutex_lock(&w->lock);
        if (st && !w->status) {
            w->status = st;
            w->error = err;
            atomic_store(&w->stop, 1);
        }
        w->done++;
        if (w->progress && w->progress->step)
            w->progress->step(w->progress->data, w->done, total);
        pthread_mutex_unlock(&w->lock);
    }
    return NULL;
}

// The nearest to twice as wide as high that leaves few cells empty.
static uint32_t sheet_columns(size_t n) {
    uint32_t columns = 1;
    while (columns < 8 && (size_t)columns * columns < 2 * n)
        columns++;
    return columns;
}

static enum ap_status write_sheet(struct ap_error *err, struct work *w) {
    size_t n = 0;
    for (size_t k = 0; k < w->capture->frame_count; k++)
        if (w->cells[k].rgb) {
            struct ap_image cell = w->cells[k];
            w->cells[k] = (struct ap_image){0};
            w->cells[n++] = cell;
        }
    if (n == 0)
        return AP_OK;
    struct ap_image sheet = {0};
    char *path = ap_path_join(w->capture->dir, "contact.png");
    enum ap_status st = path ? AP_OK : no_memory(err);
    if (!st)
        st = ap_image_contact_sheet(err, w->cells, n, sheet_columns(n), GAP_PX, &sheet);
    if (!st)
        st = ap_png_write(err, path, &sheet);
    ap_image_finish(&sheet);
    free(path);
    return st;
}

enum ap_status ap_pictures_write(struct ap_error *err, const struct ap_capture *capture,
                                 const struct ap_progress *progress) {
    size_t n = capture->frame_count;
    struct work w = {.capture = capture,
                     .progress = progress,
                     .cell_count = n < CELLS_MAX ? n : CELLS_MAX,
                     .lock = PTHREAD_MUTEX_INITIALIZER};
    w.cells = calloc(n ? n : 1, sizeof *w.cells);
    if (!w.cells)
        return no_memory(err);
    // This thread is one of the workers; where no other can be had it does the work alone.
    pthread_t thread[THREADS - 1];
    int started = 0;
    while (started < THREADS - 1 && pthread_create(&thread[started], NULL, work_on, &w) == 0)
        started++;
    work_on(&w);
    for (int i = 0; i < started; i++)
        pthread_join(thread[i], NULL);
    enum ap_status st = w.status;
    if (st)
        ap_fail(err, st, "%s", w.error.text);
    else
        st = write_sheet(err, &w);
    for (size_t k = 0; k < n; k++)
        ap_image_finish(&w.cells[k]);
    free(w.cells);
    return st;
}
