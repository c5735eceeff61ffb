#include <stdlib.h>

#include "sim_hmd/core/device.h"

static int rank(VkPhysicalDeviceType type) {
    switch (type) {
    case VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU:
        return 4;
    case VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU:
        return 3;
    case VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU:
        return 2;
    case VK_PHYSICAL_DEVICE_TYPE_CPU:
        return 1;
    default:
        return 0;
    }
}

XrResult sim_choose_device(VkInstance vulkan, VkPhysicalDevice *out) {
    uint32_t count = 0;
    if (vkEnumeratePhysicalDevices(vulkan, &count, NULL) != VK_SUCCESS || !count)
        return XR_ERROR_RUNTIME_FAILURE;
    VkPhysicalDevice *all = calloc(count, sizeof *all);
    if (!all)
        return XR_ERROR_OUT_OF_MEMORY;
    VkPhysicalDevice best = VK_NULL_HANDLE;
    int best_rank = -1;
    if (vkEnumeratePhysicalDevices(vulkan, &count, all) == VK_SUCCESS)
        for (uint32_t i = 0; i < count; i++) {
            VkPhysicalDeviceProperties properties;
            vkGetPhysicalDeviceProperties(all[i], &properties);
            if (rank(properties.deviceType) > best_rank) {
                best = all[i];
                best_rank = rank(properties.deviceType);
            }
        }
    free(all);
    if (!best)
        return XR_ERROR_RUNTIME_FAILURE;
    *out = best;
    return XR_SUCCESS;
}
