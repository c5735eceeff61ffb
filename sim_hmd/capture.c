#include "sim_hmd/capture.h"

#include <inttypes.h>
#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "src/base/file.h"

enum { MAX_THREADS = 8, MAX_JOBS = 64 };

struct sim_capture {
    char *dir;
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
        enum ap_status st = job.run(&error, job.user, job.what);
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

enum ap_status sim_capture_create(struct ap_error *err, const char *dir, int threads,
                                  struct sim_capture **capture) {
    struct sim_capture *c = calloc(1, sizeof *c);
    if (!c)
        return ap_fail(err, AP_ENVIRONMENT, "out of memory");
    pthread_mutex_init(&c->lock, NULL);
    pthread_cond_init(&c->work, NULL);
    pthread_cond_init(&c->room, NULL);
    enum ap_status st = AP_OK;
    if (dir) {
        c->dir = strdup(dir);
        st = c->dir ? ap_make_dirs(err, dir) : ap_fail(err, AP_ENVIRONMENT, "out of memory");
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

enum ap_status sim_capture_write(struct ap_error *err, const struct sim_capture *c, int64_t frame,
                                 int eye, const struct ap_pixels *pixels) {
    char name[64];
    snprintf(name, sizeof name, "%06" PRId64 "-%s.png", frame, eye ? "right" : "left");
    char *path = ap_path_join(c->dir, name);
    if (!path)
        return ap_fail(err, AP_ENVIRONMENT, "out of memory");
    enum ap_status st = ap_png_write_pixels(err, path, pixels);
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

void sim_capture_drain(struct sim_capture *c) {
    pthread_mutex_lock(&c->lock);
    while (c->count > 0 || c->running > 0)
        pthread_cond_wait(&c->room, &c->lock);
    pthread_mutex_unlock(&c->lock);
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
    free(c->dir);
    free(c);
}
