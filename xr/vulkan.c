#include "xr/internal.h"

#include <stdlib.h>
#include <string.h>

// The two ways by which a runtime takes part in making the Vulkan instance and device:
// XR_KHR_vulkan_enable2 (the runtime makes them from our wishes) and XR_KHR_vulkan_enable (we make
// them with the extensions that it names).

enum { MAX_NAMES = 64, MAX_FAMILIES = 32 };

static enum ap_status get_proc(struct ap_error *err, struct ap_xr *xr, const char *name,
                               PFN_xrVoidFunction *function) {
    return ap_xr_check(err, xr, ap_xrl.GetInstanceProcAddr(xr->instance, name, function), name);
}

#define GET_PROC(err, xr, name, fn) get_proc(err, xr, #name, (PFN_xrVoidFunction *)(fn))

static enum ap_status vulkan_failed(struct ap_error *err, VkResult result, const char *call) {
    if (result == VK_SUCCESS)
        return AP_OK;
    return ap_fail(err, AP_ENVIRONMENT,
                   "%s: VkResult %d: is a Vulkan driver installed? (software: mesa-vulkan-drivers)",
                   call, (int)result);
}

// "VK_KHR_a VK_KHR_b" split in place.
static uint32_t split_names(char *text, const char *names[MAX_NAMES]) {
    uint32_t n = 0;
    char *save = NULL;
    for (char *w = strtok_r(text, " ", &save); w && n < MAX_NAMES; w = strtok_r(NULL, " ", &save))
        names[n++] = w;
    return n;
}

// What the runtime's string call says, malloc'ed.
static enum ap_status get_names(struct ap_error *err, struct ap_xr *xr, const char *call,
                                char **text) {
    XrResult(XRAPI_PTR * function)(XrInstance, XrSystemId, uint32_t, uint32_t *, char *);
    enum ap_status st = get_proc(err, xr, call, (PFN_xrVoidFunction *)&function);
    if (st)
        return st;
    uint32_t size = 0;
    st = ap_xr_check(err, xr, function(xr->instance, xr->system, 0, &size, NULL), call);
    if (st)
        return st;
    char *names = calloc(1, (size_t)size + 1);
    if (!names)
        return ap_fail(err, AP_ENVIRONMENT, "out of memory");
    if (size > 0)
        st = ap_xr_check(err, xr, function(xr->instance, xr->system, size, &size, names), call);
    if (st)
        free(names);
    else
        *text = names;
    return st;
}

// The newest Vulkan version that the runtime takes, at most 1.1 (multiview is core there).
static enum ap_status get_version(struct ap_error *err, struct ap_xr *xr, uint32_t *version) {
    PFN_xrGetVulkanGraphicsRequirements2KHR requirements;
    // The older extension's call has the same signature and, but for its name, the same meaning.
    enum ap_status st = get_proc(err, xr,
                                 xr->vulkan2 ? "xrGetVulkanGraphicsRequirements2KHR"
                                             : "xrGetVulkanGraphicsRequirementsKHR",
                                 (PFN_xrVoidFunction *)&requirements);
    if (st)
        return st;
    XrGraphicsRequirementsVulkanKHR range = {.type = XR_TYPE_GRAPHICS_REQUIREMENTS_VULKAN_KHR};
    st = ap_xr_check(err, xr, requirements(xr->instance, xr->system, &range),
                     "xrGetVulkanGraphicsRequirements");
    if (st)
        return st;
    XrVersion want = XR_MAKE_VERSION(1, 1, 0);
    if (range.minApiVersionSupported > want)
        want = range.minApiVersionSupported;
    if (range.maxApiVersionSupported != 0 && want > range.maxApiVersionSupported)
        want = range.maxApiVersionSupported;
    *version = VK_MAKE_VERSION(XR_VERSION_MAJOR(want), XR_VERSION_MINOR(want), 0);
    return AP_OK;
}

static enum ap_status create_instance(struct ap_error *err, struct ap_xr *xr, uint32_t version) {
    VkApplicationInfo app = {.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO,
                             .pApplicationName = "antipode",
                             .pEngineName = "antipode",
                             .apiVersion = version};
    VkInstanceCreateInfo info = {.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO,
                                 .pApplicationInfo = &app};
    if (xr->vulkan2) {
        PFN_xrCreateVulkanInstanceKHR create;
        enum ap_status st = GET_PROC(err, xr, xrCreateVulkanInstanceKHR, &create);
        if (st)
            return st;
        XrVulkanInstanceCreateInfoKHR wrap = {.type = XR_TYPE_VULKAN_INSTANCE_CREATE_INFO_KHR,
                                              .systemId = xr->system,
                                              .pfnGetInstanceProcAddr = vkGetInstanceProcAddr,
                                              .vulkanCreateInfo = &info};
        VkResult vk = VK_SUCCESS;
        st = ap_xr_check(err, xr, create(xr->instance, &wrap, &xr->vk_instance, &vk),
                         "xrCreateVulkanInstanceKHR");
        return st ? st : vulkan_failed(err, vk, "vkCreateInstance");
    }
    char *text;
    enum ap_status st = get_names(err, xr, "xrGetVulkanInstanceExtensionsKHR", &text);
    if (st)
        return st;
    const char *names[MAX_NAMES];
    info.enabledExtensionCount = split_names(text, names);
    info.ppEnabledExtensionNames = names;
    st = vulkan_failed(err, vkCreateInstance(&info, NULL, &xr->vk_instance), "vkCreateInstance");
    free(text);
    return st;
}

static enum ap_status choose_device(struct ap_error *err, struct ap_xr *xr) {
    if (xr->vulkan2) {
        PFN_xrGetVulkanGraphicsDevice2KHR get;
        enum ap_status st = GET_PROC(err, xr, xrGetVulkanGraphicsDevice2KHR, &get);
        XrVulkanGraphicsDeviceGetInfoKHR info = {.type =
                                                     XR_TYPE_VULKAN_GRAPHICS_DEVICE_GET_INFO_KHR,
                                                 .systemId = xr->system,
                                                 .vulkanInstance = xr->vk_instance};
        return st ? st
                  : ap_xr_check(err, xr, get(xr->instance, &info, &xr->vk_physical),
                                "xrGetVulkanGraphicsDevice2KHR");
    }
    PFN_xrGetVulkanGraphicsDeviceKHR get;
    enum ap_status st = GET_PROC(err, xr, xrGetVulkanGraphicsDeviceKHR, &get);
    return st ? st
              : ap_xr_check(err, xr,
                            get(xr->instance, xr->system, xr->vk_instance, &xr->vk_physical),
                            "xrGetVulkanGraphicsDeviceKHR");
}

static enum ap_status choose_family(struct ap_error *err, struct ap_xr *xr) {
    VkQueueFamilyProperties families[MAX_FAMILIES];
    uint32_t count = MAX_FAMILIES;
    vkGetPhysicalDeviceQueueFamilyProperties(xr->vk_physical, &count, families);
    for (uint32_t i = 0; i < count; i++)
        if (families[i].queueFlags & VK_QUEUE_GRAPHICS_BIT) {
            xr->queue_family = i;
            return AP_OK;
        }
    return ap_fail(err, AP_ENVIRONMENT, "the headset's Vulkan device has no graphics queue");
}

static enum ap_status create_device2(struct ap_error *err, struct ap_xr *xr,
                                     const VkDeviceCreateInfo *info) {
    PFN_xrCreateVulkanDeviceKHR create;
    enum ap_status st = GET_PROC(err, xr, xrCreateVulkanDeviceKHR, &create);
    if (st)
        return st;
    XrVulkanDeviceCreateInfoKHR wrap = {.type = XR_TYPE_VULKAN_DEVICE_CREATE_INFO_KHR,
                                        .systemId = xr->system,
                                        .pfnGetInstanceProcAddr = vkGetInstanceProcAddr,
                                        .vulkanPhysicalDevice = xr->vk_physical,
                                        .vulkanCreateInfo = info};
    VkResult vk = VK_SUCCESS;
    st = ap_xr_check(err, xr, create(xr->instance, &wrap, &xr->vk_device, &vk),
                     "xrCreateVulkanDeviceKHR");
    return st ? st : vulkan_failed(err, vk, "vkCreateDevice");
}

static enum ap_status create_device(struct ap_error *err, struct ap_xr *xr, uint32_t version) {
    float priority = 1;
    VkDeviceQueueCreateInfo queue = {.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO,
                                     .queueFamilyIndex = xr->queue_family,
                                     .queueCount = 1,
                                     .pQueuePriorities = &priority};
    VkPhysicalDeviceFeatures has, want = {0};
    vkGetPhysicalDeviceFeatures(xr->vk_physical, &has);
    want.shaderClipDistance = has.shaderClipDistance;
    VkPhysicalDeviceMultiviewFeatures multiview = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MULTIVIEW_FEATURES};
    VkDeviceCreateInfo info = {.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
                               .queueCreateInfoCount = 1,
                               .pQueueCreateInfos = &queue,
                               .pEnabledFeatures = &want};
    VkPhysicalDeviceProperties properties;
    vkGetPhysicalDeviceProperties(xr->vk_physical, &properties);
    if (version >= VK_API_VERSION_1_1 && properties.apiVersion >= VK_API_VERSION_1_1) {
        VkPhysicalDeviceFeatures2 query = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2,
                                           .pNext = &multiview};
        vkGetPhysicalDeviceFeatures2(xr->vk_physical, &query);
        multiview.pNext = NULL;
        multiview.multiviewGeometryShader = multiview.multiviewTessellationShader = VK_FALSE;
        info.pNext = &multiview;
        xr->multiview = multiview.multiview;
    }
    if (xr->vulkan2)
        return create_device2(err, xr, &info);
    char *text;
    enum ap_status st = get_names(err, xr, "xrGetVulkanDeviceExtensionsKHR", &text);
    if (st)
        return st;
    const char *names[MAX_NAMES];
    info.enabledExtensionCount = split_names(text, names);
    info.ppEnabledExtensionNames = names;
    st = vulkan_failed(err, vkCreateDevice(xr->vk_physical, &info, NULL, &xr->vk_device),
                       "vkCreateDevice");
    free(text);
    return st;
}

enum ap_status ap_xr_vulkan_create(struct ap_error *err, struct ap_xr *xr) {
    uint32_t version;
    enum ap_status st = get_version(err, xr, &version);
    if (!st)
        st = create_instance(err, xr, version);
    if (!st)
        st = choose_device(err, xr);
    if (!st)
        st = choose_family(err, xr);
    if (!st)
        st = create_device(err, xr, version);
    return st;
}
