#ifndef ANTIPODE_TESTS_SIM_HMD_PAINTER_H
#define ANTIPODE_TESTS_SIM_HMD_PAINTER_H

#include "tests/sim_hmd/client.h"

// A client that draws by copying: what stands in its buffer is what its images hold.

struct painter {
    struct client c;
    VkBuffer buffer;
    VkDeviceMemory memory;
    uint8_t *mapped; // the buffer
    VkCommandPool pool;
    VkQueue queue;
};

// With the client's settings.
void painter_start(struct painter *p, VkDeviceSize buffer_bytes);
void painter_stop(struct painter *p);

// The image that a swapchain gives next, acquired and waited for.
VkImage painter_acquire(XrSwapchain swapchain);

// A command buffer that is begun; painter_submit ends and submits it, and waits for nothing.
VkCommandBuffer painter_begin(struct painter *p);
void painter_submit(struct painter *p, VkCommandBuffer cmd);

// All layers of an image into another layout.
void painter_turn(VkCommandBuffer cmd, VkImage image, VkImageAspectFlags aspect, VkImageLayout from,
                  VkImageLayout to);

// A captured file; the string stands until the next call.
const char *painter_path(const char *dir, const char *name);

#endif
