#ifndef ANTIPODE_SIM_HMD_CORE_API_H
#define ANTIPODE_SIM_HMD_CORE_API_H

#include <stdbool.h>
#include <stdint.h>
#include <time.h>
#include <vulkan/vulkan.h>

#define XR_USE_GRAPHICS_API_VULKAN
#define XR_USE_TIMESPEC
#define XR_EXTENSION_PROTOTYPES
#include <openxr/openxr.h>
#include <openxr/openxr_platform.h>

#include "sim_hmd/core/handles.h"

// What every function of OpenXR starts from. The files of api and ext hold those functions under
// their own names (they are hidden; the loader gets them from xrGetInstanceProcAddr): they take the
// lock, verify their arguments and dispatch. Everything that the other headers of core declare
// wants the lock held.

static inline uint64_t sim_raw(const void *handle) {
    return (uint64_t)(uintptr_t)handle;
}
#define SIM_HANDLE(handle_type, o) ((handle_type)(uintptr_t)(o)->object.handle)

// A structure of the caller's is there and is of this type.
static inline bool sim_is(const void *structure, XrStructureType type) {
    return structure && ((const XrBaseInStructure *)structure)->type == type;
}

// The structure of this type in the chain behind the caller's own; NULL: none. A chain that bites
// its tail is not followed for ever.
static inline void *sim_chained(const void *structure, XrStructureType type) {
    const XrBaseInStructure *s = ((const XrBaseInStructure *)structure)->next;
    for (int i = 0; s && i < 64; i++, s = s->next)
        if (s->type == type)
            return (void *)(uintptr_t)s;
    return NULL;
}

// The two calls of every list: *count = n always; items are copied where capacity is not zero.
XrResult sim_two_calls(uint32_t capacity, uint32_t *count, uint32_t n, const void *items,
                       size_t size, void *out);
XrResult sim_two_call_text(uint32_t capacity, uint32_t *count, const char *text, char *out);

#endif
