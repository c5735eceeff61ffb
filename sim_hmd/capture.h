#ifndef ANTIPODE_SIM_HMD_CAPTURE_H
#define ANTIPODE_SIM_HMD_CAPTURE_H

#include <stdint.h>

#include "src/base/status.h"
#include "src/image/image.h"

// A few threads that do what a frame leaves behind (wait for the GPU, encode, write), so that the
// program in whose process we are does not wait for it. Every call is for one thread at a time; the
// jobs run on the others, with all signals blocked, so that none of the program's handlers does.
struct sim_capture;

struct sim_capture_job {
    enum ap_status (*run)(struct ap_error *err, void *user, int what);
    void *user;
    int what;
};

// dir is made; NULL: the jobs write nowhere. AP_ENVIRONMENT.
enum ap_status sim_capture_create(struct ap_error *err, const char *dir, int threads,
                                  struct sim_capture **capture);

// First come, first served. Blocks while 64 jobs wait.
void sim_capture_add(struct sim_capture *capture, const struct sim_capture_job *job);

// Writes NNNNNN-left.png or -right.png into the folder, whole or not at all. From a job.
enum ap_status sim_capture_write(struct ap_error *err, const struct sim_capture *capture,
                                 int64_t frame, int eye, const struct ap_pixels *pixels);

// The first failure of a job since the last call, AP_OK where there is none.
enum ap_status sim_capture_error(struct ap_error *err, struct sim_capture *capture);

// Returns when no job waits or runs.
void sim_capture_drain(struct sim_capture *capture);

// Drains, joins. Accepts NULL.
void sim_capture_destroy(struct sim_capture *capture);

#endif
