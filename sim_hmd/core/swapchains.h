#ifndef ANTIPODE_SIM_HMD_CORE_SWAPCHAINS_H
#define ANTIPODE_SIM_HMD_CORE_SWAPCHAINS_H

#include "sim_hmd/core/session.h"

enum { SIM_MAX_IMAGES = 3 };

struct sim_garbage {
    struct sim_garbage *next;
    struct ap_gpu_image image[SIM_MAX_IMAGES];
};

struct sim_swapchain {
    struct sim_object object;
    struct sim_session *session;
    XrSwapchainCreateInfo info; // next is NULL
    VkImageAspectFlags aspect;
    bool depth, static_image;
    bool used; // an image was acquired once: the layouts are set, the queue may work on it
    uint32_t image_count;
    struct ap_gpu_image image[SIM_MAX_IMAGES];
    uint32_t next;     // the next to acquire; the acquired ones lie before it, oldest first
    uint32_t acquired; // how many
    bool waited;       // the oldest acquired one was waited for
    int released;      // the last released image; −1: none yet
};

// XR_ERROR_HANDLE_INVALID, or XR_ERROR_SESSION_LOST.
XrResult sim_swapchain_get(XrSwapchain handle, struct sim_swapchain **swapchain);

// Waits for the queue and frees what lies on session->garbage.
void sim_session_collect_garbage(struct sim_session *session);

#endif
