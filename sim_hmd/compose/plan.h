#ifndef ANTIPODE_SIM_HMD_COMPOSE_PLAN_H
#define ANTIPODE_SIM_HMD_COMPOSE_PLAN_H

#include "sim_hmd/compose/pass.h"
#include "sim_hmd/compose/shape.h"
#include "sim_hmd/compose/frame.h"

// What the GPU is asked to do for one frame: the layers that each eye sees at all, and the images
// that are read for it.
struct sim_drawing {
    uint32_t layer; // of the frame
    struct sim_seen seen;
    uint32_t way; // bits of enum sim_way
};

// Drawings that one draw lays over one another.
struct sim_batch {
    uint32_t first, count; // of the eye's drawings
    struct sim_pass_key key;
    double from_uv[2], to_uv[2];
};

struct sim_use {
    VkImage image;
    VkImageLayout layout;
};

struct sim_plan {
    const struct sim_frame *frame;
    unsigned show; // bit e: eye e, in the window
    bool pictures; // of the eyes
    bool copy[2];  // this eye's picture is its only drawing's, bit for bit
    struct sim_drawing drawings[2][SIM_MAX_LAYERS]; // from below
    uint32_t count[2];
    struct sim_batch batches[2][SIM_MAX_LAYERS];
    uint32_t batch_count[2];
    struct sim_use uses[2 * SIM_MAX_LAYERS];
    uint32_t use_count;
};

void sim_plan_make(const struct sim_settings *settings, const struct sim_frame *frame,
                   unsigned show, struct sim_plan *plan);

// The layout that the frame's commands read this image in.
VkImageLayout sim_plan_layout(const struct sim_plan *plan, VkImage image);

// True where the shader reads this eye's layers.
bool sim_plan_samples(const struct sim_plan *plan, int eye);

#endif
