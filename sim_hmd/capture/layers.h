#ifndef ANTIPODE_SIM_HMD_CAPTURE_LAYERS_H
#define ANTIPODE_SIM_HMD_CAPTURE_LAYERS_H

#include "sim_hmd/capture/capture.h"
#include "sim_hmd/compose/frame.h"

// Reads back what the program submitted, each layer's pictures as they are, beside whatever the
// compositor does: its own command buffers, its own writers, a bounded amount of memory, beyond
// which a call waits for the writers. One thread at a time, where the queue may be used.
struct sim_layer_capture;

// gpu and settings outlive it. AP_ENVIRONMENT.
enum ap_status sim_layer_capture_create(struct ap_error *err, const struct ap_gpu *gpu,
                                        const struct sim_settings *settings,
                                        struct sim_layer_capture **capture);

// Copies of the frame's pictures are on their way when it returns; the images may be drawn to
// again by what is submitted to the queue later. A writer's failure is returned by a later call.
enum ap_status sim_layer_capture_frame(struct ap_error *err, struct sim_layer_capture *capture,
                                       const struct sim_frame *frame);

// The pictures that a layer gives, and how many they are: a projection's two and the depths that
// came with them, a cube's six faces, any other layer's one. Not depths of several samples.
enum { SIM_LAYER_PARTS_MAX = 6 };
int sim_layer_capture_parts(const struct sim_layer *layer,
                            enum sim_part parts[SIM_LAYER_PARTS_MAX]);

// Waits until every picture is on disk; reports what failed since the last call.
enum ap_status sim_layer_capture_flush(struct ap_error *err, struct sim_layer_capture *capture);

void sim_layer_capture_destroy(struct sim_layer_capture *capture); // flushes; accepts NULL

#endif
