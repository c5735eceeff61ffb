#ifndef ANTIPODE_SIM_HMD_EXT_EXTENSIONS_H
#define ANTIPODE_SIM_HMD_EXT_EXTENSIONS_H

#include <stdbool.h>
#include <stdint.h>

#define XR_USE_GRAPHICS_API_VULKAN
#define XR_USE_TIMESPEC
#define XR_EXTENSION_PROTOTYPES
#include <vulkan/vulkan.h>
#include <openxr/openxr.h>
#include <openxr/openxr_platform.h>

#include "sim_hmd/ext/newer.h"

// The runtime's extensions. One more is one line here; with functions also a file that holds them
// and their list:
//     const struct sim_function sim_functions_EXT_x[] = {SIM_FUNCTION(xrDoX), {0}};
// Whatever else it changes asks instance->enabled[SIM_EXT_x]. docs/extensions.md says more.

// Without functions: new structures, values or paths only.
#define SIM_PLAIN_EXTENSIONS(X)                                                                    \
    X(MND_headless)                                                                                \
    X(KHR_vulkan_swapchain_format_list)                                                            \
    X(EXT_view_configuration_depth_range)                                                          \
    X(KHR_composition_layer_depth)                                                                 \
    X(KHR_composition_layer_cylinder)                                                              \
    X(KHR_composition_layer_equirect)                                                              \
    X(KHR_composition_layer_equirect2)                                                             \
    X(KHR_composition_layer_cube)                                                                  \
    X(EXT_palm_pose)                                                                               \
    X(EXT_local_floor)

#define SIM_FUNCTION_EXTENSIONS(X)                                                                 \
    X(KHR_vulkan_enable2)                                                                          \
    X(KHR_vulkan_enable)                                                                           \
    X(KHR_convert_timespec_time)                                                                   \
    X(FB_display_refresh_rate)                                                                     \
    X(EXT_debug_utils)                                                                             \
    X(EXT_hand_tracking)                                                                           \
    X(KHR_visibility_mask)                                                                         \
    X(KHR_locate_spaces)                                                                           \
    X(EXT_conformance_automation)

#define SIM_EXTENSION_ID(name) SIM_##name,
enum sim_extension_id {
    SIM_FUNCTION_EXTENSIONS(SIM_EXTENSION_ID) SIM_PLAIN_EXTENSIONS(SIM_EXTENSION_ID)
        SIM_EXTENSION_COUNT
};

// A list of functions ends with {0}.
struct sim_function {
    const char *name;
    PFN_xrVoidFunction function;
};
#define SIM_FUNCTION(name)                                                                         \
    { #name, (PFN_xrVoidFunction)name }

#define SIM_EXTENSION_FUNCTIONS(name) extern const struct sim_function sim_functions_##name[];
SIM_FUNCTION_EXTENSIONS(SIM_EXTENSION_FUNCTIONS)

struct sim_extension {
    const char *name;
    uint32_t version;
    const struct sim_function *functions; // NULL: none
};
extern const struct sim_extension sim_extensions[SIM_EXTENSION_COUNT];

// By its whole name, "XR_KHR_…". SIM_EXTENSION_COUNT: there is none.
enum sim_extension_id sim_extension_find(const char *name);

// NULL: none of the enabled extensions has it.
PFN_xrVoidFunction sim_extension_function(const bool enabled[SIM_EXTENSION_COUNT],
                                          const char *name);

#endif
