#include <stdlib.h>
#include <string.h>

#include "sim_hmd/core/device.h"
#include "sim_hmd/core/instance.h"

// XR_KHR_vulkan_enable and XR_KHR_vulkan_enable2. The runtime composes on the program's own device
// and queue and needs no extension; with enable2 it sees to it that the instance is one of Vulkan
// 1.1, which the compositor's shaders are compiled for.

static XrResult check(XrInstance handle, XrSystemId system, struct sim_instance **instance) {
    *instance = sim_instance_get(handle);
    if (!*instance)
        return XR_ERROR_HANDLE_INVALID;
    return system == SIM_SYSTEM_ID ? XR_SUCCESS : XR_ERROR_SYSTEM_INVALID;
}

static XrResult requirements(XrInstance handle, XrSystemId system,
                             XrGraphicsRequirementsVulkanKHR *out) {
    struct sim_instance *instance;
    XrResult result = check(handle, system, &instance);
    if (result != XR_SUCCESS)
        return result;
    if (!sim_is(out, XR_TYPE_GRAPHICS_REQUIREMENTS_VULKAN_KHR))
        return XR_ERROR_VALIDATION_FAILURE;
    out->minApiVersionSupported = XR_MAKE_VERSION(1, 0, 0);
    out->maxApiVersionSupported = XR_MAKE_VERSION(1, 999, 0xfff);
    instance->requirements_called = true;
    return XR_SUCCESS;
}

XrResult XRAPI_CALL xrGetVulkanGraphicsRequirementsKHR(XrInstance handle, XrSystemId system,
                                                       XrGraphicsRequirementsVulkanKHR *out) {
    SIM_LOCKED;
    return requirements(handle, system, out);
}

XrResult XRAPI_CALL xrGetVulkanGraphicsRequirements2KHR(XrInstance handle, XrSystemId system,
                                                        XrGraphicsRequirementsVulkanKHR *out) {
    SIM_LOCKED;
    return requirements(handle, system, out);
}

static XrResult no_extensions(XrInstance handle, XrSystemId system, uint32_t capacity,
                              uint32_t *count, char *buffer) {
    struct sim_instance *instance;
    XrResult result = check(handle, system, &instance);
    return result == XR_SUCCESS ? sim_two_call_text(capacity, count, "", buffer) : result;
}

XrResult XRAPI_CALL xrGetVulkanInstanceExtensionsKHR(XrInstance handle, XrSystemId system,
                                                     uint32_t capacity, uint32_t *count,
                                                     char *buffer) {
    SIM_LOCKED;
    return no_extensions(handle, system, capacity, count, buffer);
}

XrResult XRAPI_CALL xrGetVulkanDeviceExtensionsKHR(XrInstance handle, XrSystemId system,
                                                   uint32_t capacity, uint32_t *count,
                                                   char *buffer) {
    SIM_LOCKED;
    return no_extensions(handle, system, capacity, count, buffer);
}

XrResult XRAPI_CALL xrGetVulkanGraphicsDeviceKHR(XrInstance handle, XrSystemId system,
                                                 VkInstance vulkan, VkPhysicalDevice *device) {
    SIM_LOCKED;
    struct sim_instance *instance;
    XrResult result = check(handle, system, &instance);
    if (result != XR_SUCCESS)
        return result;
    return vulkan && device ? sim_choose_device(vulkan, device) : XR_ERROR_VALIDATION_FAILURE;
}

XrResult XRAPI_CALL xrGetVulkanGraphicsDevice2KHR(XrInstance handle,
                                                  const XrVulkanGraphicsDeviceGetInfoKHR *info,
                                                  VkPhysicalDevice *device) {
    SIM_LOCKED;
    struct sim_instance *instance;
    if (!sim_instance_get(handle))
        return XR_ERROR_HANDLE_INVALID;
    if (!sim_is(info, XR_TYPE_VULKAN_GRAPHICS_DEVICE_GET_INFO_KHR))
        return XR_ERROR_VALIDATION_FAILURE;
    XrResult result = check(handle, info->systemId, &instance);
    if (result != XR_SUCCESS)
        return result;
    if (!info->vulkanInstance || !device)
        return XR_ERROR_VALIDATION_FAILURE;
    return sim_choose_device(info->vulkanInstance, device);
}

// A Vulkan 1.0 loader has no such function and refuses a higher version.
static bool has_vulkan_1_1(PFN_vkGetInstanceProcAddr get) {
    PFN_vkEnumerateInstanceVersion enumerate =
        (PFN_vkEnumerateInstanceVersion)get(VK_NULL_HANDLE, "vkEnumerateInstanceVersion");
    uint32_t version = VK_API_VERSION_1_0;
    return enumerate && enumerate(&version) == VK_SUCCESS && version >= VK_API_VERSION_1_1;
}

XrResult XRAPI_CALL xrCreateVulkanInstanceKHR(XrInstance handle,
                                              const XrVulkanInstanceCreateInfoKHR *info,
                                              VkInstance *vulkan, VkResult *vk_result) {
    SIM_LOCKED;
    struct sim_instance *instance;
    if (!sim_instance_get(handle))
        return XR_ERROR_HANDLE_INVALID;
    if (!sim_is(info, XR_TYPE_VULKAN_INSTANCE_CREATE_INFO_KHR) || info->createFlags ||
        !info->pfnGetInstanceProcAddr || !info->vulkanCreateInfo || !vulkan || !vk_result)
        return XR_ERROR_VALIDATION_FAILURE;
    XrResult result = check(handle, info->systemId, &instance);
    if (result != XR_SUCCESS)
        return result;
    PFN_vkCreateInstance create =
        (PFN_vkCreateInstance)info->pfnGetInstanceProcAddr(VK_NULL_HANDLE, "vkCreateInstance");
    if (!create)
        return XR_ERROR_RUNTIME_FAILURE;
    VkApplicationInfo app = {.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO};
    VkInstanceCreateInfo raised = *info->vulkanCreateInfo;
    if (raised.pApplicationInfo)
        app = *raised.pApplicationInfo;
    if (app.apiVersion < VK_API_VERSION_1_1 && has_vulkan_1_1(info->pfnGetInstanceProcAddr))
        app.apiVersion = VK_API_VERSION_1_1;
    raised.pApplicationInfo = &app;
    *vk_result = create(&raised, info->vulkanAllocator, vulkan);
    return XR_SUCCESS;
}

XrResult XRAPI_CALL xrCreateVulkanDeviceKHR(XrInstance handle,
                                            const XrVulkanDeviceCreateInfoKHR *info,
                                            VkDevice *device, VkResult *vk_result) {
    SIM_LOCKED;
    struct sim_instance *instance;
    if (!sim_instance_get(handle))
        return XR_ERROR_HANDLE_INVALID;
    if (!sim_is(info, XR_TYPE_VULKAN_DEVICE_CREATE_INFO_KHR) || info->createFlags ||
        !info->pfnGetInstanceProcAddr || !info->vulkanPhysicalDevice || !info->vulkanCreateInfo ||
        !device || !vk_result)
        return XR_ERROR_VALIDATION_FAILURE;
    XrResult result = check(handle, info->systemId, &instance);
    if (result != XR_SUCCESS)
        return result;
    // vkCreateDevice is an instance's function, and the instance is not named here; the loader that
    // made the physical device dispatches by it.
    *vk_result = vkCreateDevice(info->vulkanPhysicalDevice, info->vulkanCreateInfo,
                                info->vulkanAllocator, device);
    return XR_SUCCESS;
}

const struct sim_function sim_functions_KHR_vulkan_enable[] = {
    SIM_FUNCTION(xrGetVulkanInstanceExtensionsKHR),
    SIM_FUNCTION(xrGetVulkanDeviceExtensionsKHR),
    SIM_FUNCTION(xrGetVulkanGraphicsDeviceKHR),
    SIM_FUNCTION(xrGetVulkanGraphicsRequirementsKHR),
    {0},
};

const struct sim_function sim_functions_KHR_vulkan_enable2[] = {
    SIM_FUNCTION(xrCreateVulkanInstanceKHR),
    SIM_FUNCTION(xrCreateVulkanDeviceKHR),
    SIM_FUNCTION(xrGetVulkanGraphicsDevice2KHR),
    SIM_FUNCTION(xrGetVulkanGraphicsRequirements2KHR),
    {0},
};
