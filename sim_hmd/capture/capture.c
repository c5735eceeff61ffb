#include "sim_hmd/capture/capture.h"

#include <inttypes.h>
#include <math.h>
#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "src/base/file.h"
#include "src/image/lens.h"

enum { MAX_THREADS = 8, MAX_JOBS = 64 };

struct sim_capture {
    const struct sim_settings *settings; // NULL: nothing is written
    pthread_t threads[MAX_THREADS];
    int thread_count;
    pthread_mutex_t lock;
    pthread_cond_t work, room; // a job has come or quit was set; a job has been taken or done
    struct sim_capture_job jobs[MAX_JOBS];
    int first, count, running;
    bool quit;
    enum ap_status status; // of the first failure that nobody has asked for yet
    struct ap_error error;
};

// A fork waits until no picture is half written: its child would write what is buffered of it a
// second time at its exit.
static pthread_rwlock_t writing = PTHREAD_RWLOCK_WRITER_NONRECURSIVE_INITIALIZER_NP;
static pthread_once_t watch_forks_once = PTHREAD_ONCE_INIT;

static void before_fork(void) {
    pthread_rwlock_wrlock(&writing);
}

static void after_fork(void) {
    pthread_rwlock_unlock(&writing);
}

static void after_fork_in_child(void) {
    pthread_rwlock_init(&writing, NULL);
}

static void watch_forks(void) {
    pthread_atfork(before_fork, after_fork, after_fork_in_child);
}

static void *work(void *arg) {
    struct sim_capture *c = arg;
    pthread_mutex_lock(&c->lock);
    for (;;) {
        while (c->count == 0 && !c->quit)
            pthread_cond_wait(&c->work, &c->lock);
        if (c->count == 0)
            break;
        struct sim_capture_job job = c->jobs[c->first];
        c->first = (c->first + 1) % MAX_JOBS;
        c->count--;
        c->running++;
        pthread_cond_broadcast(&c->room);
        pthread_mutex_unlock(&c->lock);
        struct ap_error error = {{0}};
        pthread_rwlock_rdlock(&writing);
        enum ap_status st = job.run(&error, job.user, job.what);
        pthread_rwlock_unlock(&writing);
        pthread_mutex_lock(&c->lock);
        if (st && !c->status) {
            c->status = st;
            c->error = error;
        }
        c->running--;
        pthread_cond_broadcast(&c->room);
    }
    pthread_mutex_unlock(&c->lock);
    return NULL;
}

static enum ap_status start_threads(struct ap_error *err, struct sim_capture *c, int threads) {
    sigset_t all, old;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &old);
    int failed = 0;
    while (c->thread_count < threads && c->thread_count < MAX_THREADS && !failed) {
        failed = pthread_create(&c->threads[c->thread_count], NULL, work, c);
        if (!failed)
            c->thread_count++;
    }
    pthread_sigmask(SIG_SETMASK, &old, NULL);
    if (c->thread_count == 0)
        return ap_fail(err, AP_ENVIRONMENT, "no thread to write the capture: %s", strerror(failed));
    return AP_OK;
}

enum ap_status sim_capture_create(struct ap_error *err, const struct sim_settings *settings,
                                  int threads, struct sim_capture **capture) {
    struct sim_capture *c = calloc(1, sizeof *c);
    if (!c)
        return ap_fail(err, AP_ENVIRONMENT, "out of memory");
    pthread_once(&watch_forks_once, watch_forks);
    pthread_mutex_init(&c->lock, NULL);
    pthread_cond_init(&c->work, NULL);
    pthread_cond_init(&c->room, NULL);
    enum ap_status st = AP_OK;
    if (settings && settings->capture_dir) {
        c->settings = settings;
        st = ap_make_dirs(err, settings->capture_dir);
    }
    if (!st)
        st = start_threads(err, c, threads < 1 ? 1 : threads);
    if (st)
        sim_capture_destroy(c);
    else
        *capture = c;
    return st;
}

void sim_capture_add(struct sim_capture *c, const struct sim_capture_job *job) {
    pthread_mutex_lock(&c->lock);
    while (c->count == MAX_JOBS)
        pthread_cond_wait(&c->room, &c->lock);
    c->jobs[(c->first + c->count) % MAX_JOBS] = *job;
    c->count++;
    pthread_cond_signal(&c->work);
    pthread_mutex_unlock(&c->lock);
}

void sim_capture_name(const struct sim_settings *settings, int64_t frame, int layer,
                      enum sim_part part, char name[SIM_CAPTURE_NAME_MAX]) {
    static const char *const parts[] = {"-left", "-right", "-depth-left", "-depth-right", "-right",
                                        "-left", "-up",    "-down",       "-back",        "-front",
                                        ""};
    char which[24] = "";
    if (layer >= 0)
        snprintf(which, sizeof which, "-layer%d", layer);
    snprintf(name, SIM_CAPTURE_NAME_MAX, "%06" PRId64 "%s%s.%s", frame, which, parts[part],
             settings->capture_raw ? "pam" : "png");
}

static enum ap_status write_picture(struct ap_error *err, const struct sim_capture *c,
                                    const char *name, const struct ap_pixels *pixels,
                                    unsigned flags) {
    char *path = ap_path_join(c->settings->capture_dir, name);
    if (!path)
        return ap_fail(err, AP_ENVIRONMENT, "out of memory");
    enum ap_status st = c->settings->capture_raw
                            ? ap_pam_write_pixels(err, path, pixels, flags & AP_PNG_LINEAR)
                            : ap_png_write_pixels(err, path, pixels, flags);
    free(path);
    return st;
}

static enum ap_status write_through_lens(struct ap_error *err, const struct sim_capture *c,
                                         const char *name, int eye,
                                         const struct ap_pixels *pixels) {
    const struct ap_eye_profile *p = &c->settings->profile.eye[eye];
    struct ap_lens_view view = {.left = tan(p->left_rad),
                                .right = tan(p->right_rad),
                                .up = tan(p->up_rad),
                                .down = tan(p->down_rad),
                                .k1 = p->lens.k1,
                                .k2 = p->lens.k2,
                                .scale = {p->lens.red_scale, 1, p->lens.blue_scale}};
    uint8_t *rgba = malloc((size_t)pixels->width * pixels->height * 4);
    if (!rgba)
        return ap_fail(err, AP_ENVIRONMENT, "%s: no memory for the lens", name);
    ap_pixels_through_lens(pixels, &view, rgba);
    struct ap_pixels seen = {rgba, pixels->width, pixels->height, (size_t)pixels->width * 4, false};
    enum ap_status st = write_picture(err, c, name, &seen, 0);
    free(rgba);
    return st;
}

enum ap_status sim_capture_write(struct ap_error *err, const struct sim_capture *c, int64_t frame,
                                 int eye, const struct ap_pixels *pixels) {
    char name[SIM_CAPTURE_NAME_MAX];
    sim_capture_name(c->settings, frame, -1, eye ? SIM_PART_RIGHT : SIM_PART_LEFT, name);
    return c->settings->capture_lens ? write_through_lens(err, c, name, eye, pixels)
                                     : write_picture(err, c, name, pixels, 0);
}

enum ap_status sim_capture_write_layer(struct ap_error *err, const struct sim_capture *c,
                                       const struct sim_capture_layer *which,
                                       const struct ap_pixels *pixels) {
    char name[SIM_CAPTURE_NAME_MAX];
    sim_capture_name(c->settings, which->frame, which->layer, which->part, name);
    return write_picture(err, c, name, pixels,
                         (which->alpha ? AP_PNG_ALPHA : 0u) | (which->linear ? AP_PNG_LINEAR : 0u));
}

enum ap_status sim_capture_write_depth(struct ap_error *err, const struct sim_capture *c,
                                       const struct sim_capture_layer *which,
                                       const struct ap_grey *depth) {
    char name[SIM_CAPTURE_NAME_MAX];
    sim_capture_name(c->settings, which->frame, which->layer, which->part, name);
    char *path = ap_path_join(c->settings->capture_dir, name);
    if (!path)
        return ap_fail(err, AP_ENVIRONMENT, "out of memory");
    enum ap_status st = ap_grey_write(err, path, depth, c->settings->capture_raw);
    free(path);
    return st;
}

enum ap_status sim_capture_error(struct ap_error *err, struct sim_capture *c) {
    pthread_mutex_lock(&c->lock);
    enum ap_status st = c->status;
    if (st)
        ap_fail(err, st, "%s", c->error.text);
    c->status = AP_OK;
    pthread_mutex_unlock(&c->lock);
    return st;
}

enum ap_status sim_capture_flush(struct ap_error *err, struct sim_capture *c) {
    if (!c)
        return AP_OK;
    pthread_mutex_lock(&c->lock);
    while (c->count > 0 || c->running > 0)
        pthread_cond_wait(&c->room, &c->lock);
    pthread_mutex_unlock(&c->lock);
    return sim_capture_error(err, c);
}

void sim_capture_destroy(struct sim_capture *c) {
    if (!c)
        return;
    pthread_mutex_lock(&c->lock);
    c->quit = true; // the threads leave when the last job is done
    pthread_cond_broadcast(&c->work);
    pthread_mutex_unlock(&c->lock);
    for (int k = 0; k < c->thread_count; k++)
        pthread_join(c->threads[k], NULL);
    pthread_cond_destroy(&c->room);
    pthread_cond_destroy(&c->work);
    pthread_mutex_destroy(&c->lock);
    free(c);
}
