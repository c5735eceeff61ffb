#ifndef ANTIPODE_SIM_HMD_COMPOSE_SLOT_H
#define ANTIPODE_SIM_HMD_COMPOSE_SLOT_H

#include "sim_hmd/compose/pass.h"
#include "sim_hmd/compose/plan.h"
#include "sim_hmd/compose/frame.h"

enum { SIM_MAX_VIEWS = 2 * SIM_MAX_LAYERS };

// What one frame in flight needs: a command buffer, its fence, the host's buffers that the pictures
// are read back into, and what the frame made for itself. Free again when the fence has been
// reached and the last job is done with the buffers.
struct sim_slot {
    VkCommandBuffer cmd;
    VkFence fence;
    VkDescriptorPool descriptors;
    VkDescriptorSet sets[2][SIM_MAX_LAYERS]; // of an eye's batches
    struct ap_gpu_buffer shapes;             // what the sets say of their layers
    struct ap_gpu_buffer eye[2], preview;    // made when first needed
    VkImageView views[SIM_MAX_VIEWS];
    uint32_t view_count;
    struct ap_gpu_image resolved[SIM_MAX_VIEWS];
    uint32_t resolved_count;
    int64_t frame;
    bool bgra[2];
    int pending; // jobs; the compositor's lock
    struct sim_compositor *owner;
};

enum ap_status sim_slot_create(struct ap_error *err, const struct ap_gpu *gpu, VkCommandPool pool,
                               struct sim_slot *slot);
void sim_slot_destroy(const struct ap_gpu *gpu, struct sim_slot *slot); // accepts a zeroed one

// Drops what the last frame made.
void sim_slot_recycle(const struct ap_gpu *gpu, struct sim_slot *slot);

// The sets have the pass's layout; made when a frame is first composed.
enum ap_status sim_slot_descriptors(struct ap_error *err, const struct ap_gpu *gpu,
                                    const struct sim_pass *pass, struct sim_slot *slot);

// Makes what a batch of the eye's draws readable by the shader: sets[eye][batch]. Multisampled
// images are resolved first, by commands put into slot->cmd.
enum ap_status sim_slot_bind(struct ap_error *err, const struct ap_gpu *gpu,
                             const struct sim_pass *pass, struct sim_slot *slot,
                             const struct sim_plan *plan, int eye, uint32_t batch);

#endif
