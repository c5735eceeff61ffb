#ifndef ANTIPODE_TESTS_SIM_HMD_FUZZ_API_H
#define ANTIPODE_TESTS_SIM_HMD_FUZZ_API_H

#include <stdbool.h>
#include <stdint.h>
#include <vulkan/vulkan.h>

#define XR_USE_GRAPHICS_API_VULKAN
#include <openxr/openxr.h>
#include <openxr/openxr_platform.h>

// Random values, and handles that were once given out (fuzz_api.c); the calls (fuzz_calls.c).

enum fuzz_kind {
    FUZZ_INSTANCE,
    FUZZ_SESSION,
    FUZZ_SPACE,
    FUZZ_SWAPCHAIN,
    FUZZ_ACTION_SET,
    FUZZ_ACTION,
    FUZZ_KINDS,
};

extern _Thread_local bool fuzz_tame; // this call's values are right where they can be

uint64_t fuzz_u64(void);
bool fuzz_chance(unsigned percent);
uint32_t fuzz_below(uint32_t n);
int64_t fuzz_i64(void);
uint32_t fuzz_u32(void);
float fuzz_float(void);
XrPosef fuzz_pose(void);
XrFovf fuzz_fov(void);
XrStructureType fuzz_type(XrStructureType right);
const void *fuzz_next(void);

void fuzz_keep(enum fuzz_kind kind, uint64_t handle);
void fuzz_set_first(enum fuzz_kind kind, uint64_t handle);
uint64_t fuzz_handle(enum fuzz_kind kind);
PFN_xrVoidFunction fuzz_proc(const char *name);

// A new instance with device, session, swapchain, spaces and actions in the pools' first places;
// what there was is destroyed. False: no Vulkan.
bool fuzz_begin(void);
void fuzz_end(void);

// One random call; its result. Any thread.
XrResult fuzz_call(void);

#endif
