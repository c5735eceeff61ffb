#ifndef ANTIPODE_SIM_HMD_CAPTURE_CAPTURE_H
#define ANTIPODE_SIM_HMD_CAPTURE_CAPTURE_H

#include <stdint.h>

#include "sim_hmd/core/settings.h"
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

// The settings, which outlive it, say where to and how; their folder is made. NULL, or without a
// folder: the jobs write nowhere. AP_ENVIRONMENT.
enum ap_status sim_capture_create(struct ap_error *err, const struct sim_settings *settings,
                                  int threads, struct sim_capture **capture);

// First come, first served. Blocks while 64 jobs wait.
void sim_capture_add(struct sim_capture *capture, const struct sim_capture_job *job);

enum { SIM_CAPTURE_NAME_MAX = 64 };

// What a picture is of. The first two are eyes' numbers, faces come in the order of a cube map's
// layers.
enum sim_part {
    SIM_PART_LEFT,
    SIM_PART_RIGHT,
    SIM_PART_DEPTH_LEFT,
    SIM_PART_DEPTH_RIGHT,
    SIM_PART_FACE, // and five more: right (+x), left, up, down, back (+z), front
    SIM_PART_ONLY = SIM_PART_FACE + 6, // a layer's one picture
};

// The name of a picture: NNNNNN-left.png, NNNNNN-layerK-right.png where layer is not negative,
// NNNNNN-layerK.png of a layer's one picture, NNNNNN-layerK-depth-left.png,
// NNNNNN-layerK-front.png.
void sim_capture_name(const struct sim_settings *settings, int64_t frame, int layer,
                      enum sim_part part, char name[SIM_CAPTURE_NAME_MAX]);

// Writes an eye's composed picture into the folder, whole or not at all, through the lens where the
// settings ask for it. From a job.
enum ap_status sim_capture_write(struct ap_error *err, const struct sim_capture *capture,
                                 int64_t frame, int eye, const struct ap_pixels *pixels);

// A layer's, as it is. alpha: PNG keeps it (PAM always does); linear: the bytes are linear light.
struct sim_capture_layer {
    int64_t frame;
    int layer;
    enum sim_part part;
    bool alpha, linear;
};
enum ap_status sim_capture_write_layer(struct ap_error *err, const struct sim_capture *capture,
                                       const struct sim_capture_layer *which,
                                       const struct ap_pixels *pixels);

// A layer's depth.
enum ap_status sim_capture_write_depth(struct ap_error *err, const struct sim_capture *capture,
                                       const struct sim_capture_layer *which,
                                       const struct ap_grey *depth);

// The first failure of a job since the last call, AP_OK where there is none.
enum ap_status sim_capture_error(struct ap_error *err, struct sim_capture *capture);

// Returns when no job waits or runs, with the first failure since the last call. Accepts NULL.
enum ap_status sim_capture_flush(struct ap_error *err, struct sim_capture *capture);

// Drains, joins. Accepts NULL.
void sim_capture_destroy(struct sim_capture *capture);

#endif
