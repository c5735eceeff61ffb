#include "src/gpu/gpu.h"

#include <stdlib.h>
#include <string.h>

#include "src/base/log.h"

static const char *const NO_DEVICE =
    "no Vulkan device: install mesa-vulkan-drivers for software rendering";

static VKAPI_ATTR VkBool32 VKAPI_CALL on_message(VkDebugUtilsMessageSeverityFlagBitsEXT severity,
                                                 VkDebugUtilsMessageTypeFlagsEXT types,
                                                 const VkDebugUtilsMessengerCallbackDataEXT *data,
                                                 void *user) {
    (void)types;
    bool error = (severity & VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT) != 0;
    ap_log(error ? AP_LOG_ERROR : AP_LOG_WARNING, "vulkan validation: %s", data->pMessage);
    if (error && user)
        ++*(int *)user;
    return VK_FALSE;
}

static bool has_layer(const char *name) {
    VkLayerProperties layers[64];
    uint32_t count = 64;
    VkResult r = vkEnumerateInstanceLayerProperties(&count, layers);
    if (r != VK_SUCCESS && r != VK_INCOMPLETE)
        return false;
    for (uint32_t i = 0; i < count; i++)
        if (strcmp(layers[i].layerName, name) == 0)
            return true;
    return false;
}

static enum ap_status create_instance(struct ap_error *err,
                                      const struct ap_gpu_headless_params *params,
                                      struct ap_gpu *gpu) {
    const char *layer = "VK_LAYER_KHRONOS_validation";
    const char *extension = VK_EXT_DEBUG_UTILS_EXTENSION_NAME;
    bool validate = params && params->validation && has_layer(layer);
    VkDebugUtilsMessengerCreateInfoEXT messages = {
        .sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT,
        .messageSeverity = VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT |
                           VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT,
        .messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT,
        .pfnUserCallback = on_message,
        .pUserData = params ? params->validation_errors : NULL,
    };
    VkApplicationInfo app = {.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO,
                             .pApplicationName = "antipode",
                             .apiVersion = VK_API_VERSION_1_1};
    VkInstanceCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO,
        .pNext = validate ? &messages : NULL,
        .pApplicationInfo = &app,
        .enabledLayerCount = validate ? 1 : 0,
        .ppEnabledLayerNames = &layer,
        .enabledExtensionCount = validate ? 1 : 0,
        .ppEnabledExtensionNames = &extension,
    };
    VkResult r = vkCreateInstance(&info, NULL, &gpu->instance);
    if (r == VK_ERROR_INCOMPATIBLE_DRIVER)
        return ap_fail(err, AP_ENVIRONMENT, "%s", NO_DEVICE);
    if (r != VK_SUCCESS)
        return ap_vk_check(err, r, "vkCreateInstance");
    if (!validate)
        return AP_OK;
    PFN_vkCreateDebugUtilsMessengerEXT create =
        (PFN_vkCreateDebugUtilsMessengerEXT)vkGetInstanceProcAddr(gpu->instance,
                                                                  "vkCreateDebugUtilsMessengerEXT");
    return create ? ap_vk_check(err, create(gpu->instance, &messages, NULL, &gpu->messenger),
                                "vkCreateDebugUtilsMessengerEXT")
                  : AP_OK;
}

// The first family that draws and computes, or UINT32_MAX.
static uint32_t graphics_family(VkPhysicalDevice device) {
    VkQueueFamilyProperties families[32];
    uint32_t count = 32;
    vkGetPhysicalDeviceQueueFamilyProperties(device, &count, families);
    VkQueueFlags want = VK_QUEUE_GRAPHICS_BIT | VK_QUEUE_COMPUTE_BIT;
    for (uint32_t i = 0; i < count; i++)
        if ((families[i].queueFlags & want) == want)
            return i;
    return UINT32_MAX;
}

// Any real GPU goes before a software one.
static int rank(const VkPhysicalDeviceProperties *properties) {
    switch (properties->deviceType) {
    case VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU:
        return 4;
    case VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU:
        return 3;
    case VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU:
        return 2;
    default:
        return 1;
    }
}

static enum ap_status choose_device(struct ap_error *err, struct ap_gpu *gpu) {
    VkPhysicalDevice devices[16];
    uint32_t count = 16;
    VkResult r = vkEnumeratePhysicalDevices(gpu->instance, &count, devices);
    if ((r != VK_SUCCESS && r != VK_INCOMPLETE) || count == 0)
        return ap_fail(err, AP_ENVIRONMENT, "%s", NO_DEVICE);
    int best = 0;
    for (uint32_t i = 0; i < count; i++) {
        VkPhysicalDeviceProperties properties;
        vkGetPhysicalDeviceProperties(devices[i], &properties);
        uint32_t family = graphics_family(devices[i]);
        if (family == UINT32_MAX || properties.apiVersion < VK_API_VERSION_1_1 ||
            rank(&properties) <= best)
            continue;
        best = rank(&properties);
        gpu->physical_device = devices[i];
        gpu->queue_family = family;
    }
    if (best == 0)
        return ap_fail(err, AP_ENVIRONMENT,
                       "no Vulkan 1.1 device that draws: install mesa-vulkan-drivers for software "
                       "rendering");
    return AP_OK;
}

static enum ap_status create_device(struct ap_error *err, struct ap_gpu *gpu) {
    VkPhysicalDeviceMultiviewFeatures has = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MULTIVIEW_FEATURES};
    VkPhysicalDeviceFeatures2 features = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2,
                                          .pNext = &has};
    vkGetPhysicalDeviceFeatures2(gpu->physical_device, &features);
    VkPhysicalDeviceMultiviewFeatures multiview = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MULTIVIEW_FEATURES, .multiview = has.multiview};
    float priority = 1;
    VkDeviceQueueCreateInfo queue = {.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO,
                                     .queueFamilyIndex = gpu->queue_family,
                                     .queueCount = 1,
                                     .pQueuePriorities = &priority};
    VkDeviceCreateInfo info = {.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
                               .pNext = &multiview,
                               .queueCreateInfoCount = 1,
                               .pQueueCreateInfos = &queue};
    return ap_vk_check(err, vkCreateDevice(gpu->physical_device, &info, NULL, &gpu->device),
                       "vkCreateDevice");
}

enum ap_status ap_gpu_create_headless(struct ap_error *err,
                                      const struct ap_gpu_headless_params *params,
                                      struct ap_gpu *gpu) {
    struct ap_gpu made = {.owns_device = true};
    enum ap_status st = create_instance(err, params, &made);
    if (st == AP_OK)
        st = choose_device(err, &made);
    if (st == AP_OK)
        st = create_device(err, &made);
    if (st == AP_OK) {
        VkDebugUtilsMessengerEXT messenger = made.messenger;
        st = ap_gpu_init(err, made.instance, made.physical_device, made.device, made.queue_family,
                         0, &made);
        made.owns_device = true;
        made.messenger = messenger;
    }
    if (st == AP_OK)
        *gpu = made;
    else
        ap_gpu_finish(&made);
    return st;
}
