#ifndef ANTIPODE_SIM_HMD_CORE_DEVICE_H
#define ANTIPODE_SIM_HMD_CORE_DEVICE_H

#include "sim_hmd/core/api.h"

// The device that programs must use, the fastest kind there is. XR_ERROR_OUT_OF_MEMORY,
// XR_ERROR_RUNTIME_FAILURE.
XrResult sim_choose_device(VkInstance vulkan, VkPhysicalDevice *out);

#endif
