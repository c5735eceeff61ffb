#include <string.h>

#include "sim_hmd/core/swapchains.h"
#include "sim_hmd/strict/call.h"

// Swapchains as the program uses them. Those beyond the bound are not followed.

enum { MAX_SWAPCHAINS = 128 };

struct chain {
    uint64_t handle; // 0: free
    int acquired;
    bool depth;
    bool drawn;                     // released since the frame was begun
    bool ever_released, ever_shown; // shown: submitted with a frame
};

static struct chain chains[MAX_SWAPCHAINS];

static struct chain *chain_of(uint64_t handle, bool add) {
    struct chain *empty = NULL;
    for (int i = 0; i < MAX_SWAPCHAINS; i++) {
        if (chains[i].handle == handle)
            return &chains[i];
        if (!chains[i].handle && !empty)
            empty = &chains[i];
    }
    if (!add || !empty)
        return NULL;
    *empty = (struct chain){.handle = handle};
    return empty;
}

static void let_go(const char *function, struct chain *c) {
    if (c->acquired)
        sim_strict_report(SIM_WARNING, function, "USE-image-not-released",
                          "swapchain 0x%llx ends with %d of its images acquired",
                          (unsigned long long)c->handle, c->acquired);
    // Depth serves the program's own drawing first; to hand it in is an offer.
    if (c->ever_released && !c->ever_shown && c->depth)
        sim_strict_report(SIM_NOTE, function, "USE-depth-never-submitted",
                          "swapchain 0x%llx of depth was drawn and never part of a layer: a "
                          "runtime that reprojects by depth has none",
                          (unsigned long long)c->handle);
    else if (c->ever_released && !c->ever_shown)
        sim_strict_report(SIM_WARNING, function, "USE-image-never-submitted",
                          "swapchain 0x%llx was drawn and never part of a layer",
                          (unsigned long long)c->handle);
    *c = (struct chain){0};
}

void sim_strict_swapchain_call(struct sim_strict_call *call) {
    const char *name = call->function->name;
    if (call->result < 0)
        return;
    if (strcmp(name, "xrCreateSwapchain") == 0) {
        struct chain *made = chain_of(sim_raw(*SIM_ARG(call, const XrSwapchain *, 2)), true);
        if (made)
            made->depth = SIM_ARG(call, const XrSwapchainCreateInfo *, 1)->usageFlags &
                          XR_SWAPCHAIN_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT;
        return;
    }
    if (strcmp(name, "xrDestroySwapchain") == 0) {
        struct chain *c = chain_of(call->v[0], false);
        if (c)
            let_go(name, c);
        return;
    }
    struct chain *c = chain_of(call->v[0], true);
    if (!c)
        return;
    if (strcmp(name, "xrAcquireSwapchainImage") == 0)
        c->acquired++;
    else if (strcmp(name, "xrReleaseSwapchainImage") == 0) {
        c->acquired--;
        c->drawn = c->ever_released = true;
    } else if (strcmp(name, "xrWaitSwapchainImage") == 0 &&
               SIM_ARG(call, const XrSwapchainImageWaitInfo *, 1)->timeout == XR_INFINITE_DURATION)
        sim_strict_found(
            call, SIM_NOTE, "USE-wait-forever",
            "timeout is XR_INFINITE_DURATION: a runtime that hangs, hangs the program");
}

bool sim_strict_swapchain_submitted(struct sim_strict_call *call, XrSwapchain swapchain) {
    struct chain *c = chain_of(sim_raw(swapchain), false);
    if (!c)
        return false;
    c->ever_shown = true;
    if (c->acquired)
        sim_strict_found(call, SIM_WARNING, "USE-image-acquired-at-end",
                         "swapchain 0x%llx is submitted with an image acquired: the one released "
                         "before it is shown",
                         (unsigned long long)c->handle);
    return c->drawn;
}

void sim_strict_swapchains_begin_frame(void) {
    for (int i = 0; i < MAX_SWAPCHAINS; i++)
        chains[i].drawn = false;
}

void sim_strict_swapchains_finish(const char *function) {
    for (int i = 0; i < MAX_SWAPCHAINS; i++)
        if (chains[i].handle)
            let_go(function, &chains[i]);
}

void sim_strict_swapchains_reset(void) {
    memset(chains, 0, sizeof chains);
}
