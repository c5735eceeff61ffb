#include "src/gpu/gpu.h"

#include <stdlib.h>
#include <string.h>

#include "src/base/log.h"

const char *ap_vk_result_name(VkResult result) {
    static const struct {
        VkResult code;
        const char *name;
    } names[] = {
#define AP_NAME(x) {x, #x}
        AP_NAME(VK_SUCCESS),
        AP_NAME(VK_NOT_READY),
        AP_NAME(VK_TIMEOUT),
        AP_NAME(VK_EVENT_SET),
        AP_NAME(VK_EVENT_RESET),
        AP_NAME(VK_INCOMPLETE),
        AP_NAME(VK_ERROR_OUT_OF_HOST_MEMORY),
        AP_NAME(VK_ERROR_OUT_OF_DEVICE_MEMORY),
        AP_NAME(VK_ERROR_INITIALIZATION_FAILED),
        AP_NAME(VK_ERROR_DEVICE_LOST),
        AP_NAME(VK_ERROR_MEMORY_MAP_FAILED),
        AP_NAME(VK_ERROR_LAYER_NOT_PRESENT),
        AP_NAME(VK_ERROR_EXTENSION_NOT_PRESENT),
        AP_NAME(VK_ERROR_FEATURE_NOT_PRESENT),
        AP_NAME(VK_ERROR_INCOMPATIBLE_DRIVER),
        AP_NAME(VK_ERROR_TOO_MANY_OBJECTS),
        AP_NAME(VK_ERROR_FORMAT_NOT_SUPPORTED),
        AP_NAME(VK_ERROR_FRAGMENTED_POOL),
        AP_NAME(VK_ERROR_OUT_OF_POOL_MEMORY),
        AP_NAME(VK_ERROR_INVALID_EXTERNAL_HANDLE),
        AP_NAME(VK_ERROR_FRAGMENTATION),
        AP_NAME(VK_ERROR_SURFACE_LOST_KHR),
        AP_NAME(VK_ERROR_NATIVE_WINDOW_IN_USE_KHR),
        AP_NAME(VK_SUBOPTIMAL_KHR),
        AP_NAME(VK_ERROR_OUT_OF_DATE_KHR),
        AP_NAME(VK_ERROR_UNKNOWN),
#undef AP_NAME
    };
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++)
        if (names[i].code == result)
            return names[i].name;
    return "an unknown VkResult";
}

enum ap_status ap_vk_check(struct ap_error *err, VkResult result, const char *what) {
    if (result == VK_SUCCESS)
        return AP_OK;
    return ap_fail(err, AP_ENVIRONMENT, "%s: %s", what, ap_vk_result_name(result));
}

enum ap_status ap_gpu_init(struct ap_error *err, VkInstance instance, VkPhysicalDevice physical,
                           VkDevice device, uint32_t family, uint32_t queue_index,
                           struct ap_gpu *gpu) {
    struct ap_gpu g = {.instance = instance,
                       .physical_device = physical,
                       .device = device,
                       .queue_family = family};
    vkGetPhysicalDeviceMemoryProperties(physical, &g.memory);
    vkGetPhysicalDeviceProperties(physical, &g.properties);
    vkGetDeviceQueue(device, family, queue_index, &g.queue);
    VkCommandPoolCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
        .flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT,
        .queueFamilyIndex = family,
    };
    enum ap_status st =
        ap_vk_check(err, vkCreateCommandPool(device, &info, NULL, &g.pool), "vkCreateCommandPool");
    if (st == AP_OK)
        *gpu = g;
    return st;
}

void ap_gpu_finish(struct ap_gpu *gpu) {
    if (!gpu->device && !gpu->instance)
        return;
    if (gpu->pool)
        vkDestroyCommandPool(gpu->device, gpu->pool, NULL);
    if (gpu->owns_device) {
        if (gpu->device)
            vkDestroyDevice(gpu->device, NULL);
        if (gpu->messenger) {
            PFN_vkDestroyDebugUtilsMessengerEXT destroy =
                (PFN_vkDestroyDebugUtilsMessengerEXT)vkGetInstanceProcAddr(
                    gpu->instance, "vkDestroyDebugUtilsMessengerEXT");
            destroy(gpu->instance, gpu->messenger, NULL);
        }
        vkDestroyInstance(gpu->instance, NULL);
    }
    memset(gpu, 0, sizeof *gpu);
}
