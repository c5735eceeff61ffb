#ifndef ANTIPODE_RENDER_LOGMAP_LOGMAP_DEVICE_H
#define ANTIPODE_RENDER_LOGMAP_LOGMAP_DEVICE_H

#include "src/gpu/gpu.h"

// The log map on the device itself, by a compute shader that includes the renderer's own
// shaders/logmap.glsl: what tests, doctor and bench measure. One thread.

enum ap_logmap_way {
    AP_LOGMAP_POLYNOMIAL, // what the renderer does
    AP_LOGMAP_COSINE,     // the paper's: clamp, then the built-in acos or acosh of w
    AP_LOGMAP_SINE,       // the built-in atan of (r, w), or asinh of r
};

struct ap_logmap_device;

// For at most `most` points at a time. Borrows gpu. AP_ENVIRONMENT.
enum ap_status ap_logmap_device_create(struct ap_error *err, const struct ap_gpu *gpu, size_t most,
                                       struct ap_logmap_device **device);
void ap_logmap_device_destroy(struct ap_logmap_device *device);

// kappa and image as for ap_logmap_float; p: points over rho, q: tangent points over rho (the
// fourth number is 0). Done `repeats` times over, to be timed; waits for the end.
enum ap_status ap_logmap_device_map(struct ap_error *err, struct ap_logmap_device *device,
                                    enum ap_logmap_way way, const int kappa_image[2],
                                    const float (*p)[4], size_t count, float (*q)[4], int repeats);

// The worst relative error of the renderer's log map on this device in one space and image, over
// `points` places spread from 1e-8 rho to 80 rho (h3, e3) or to 1e-5 of s3's antipode, against
// double; and at what distance, over rho.
enum ap_status ap_logmap_device_error(struct ap_error *err, struct ap_logmap_device *device,
                                      const int kappa_image[2], size_t points, double *worst,
                                      double *at);

#endif
