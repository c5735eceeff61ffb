#include "xr/internal.h"

#include <stdio.h>
#include <string.h>

enum { MAX_EXTENSIONS = 512 };

static const char *result_name(const struct ap_xr *xr, XrResult result,
                               char text[XR_MAX_RESULT_STRING_SIZE]) {
    if (!xr->instance || ap_xrl.ResultToString(xr->instance, result, text) != XR_SUCCESS)
        snprintf(text, XR_MAX_RESULT_STRING_SIZE, "XrResult %d", (int)result);
    return text;
}

enum ap_status ap_xr_check(struct ap_error *err, struct ap_xr *xr, XrResult result,
                           const char *call) {
    if (XR_SUCCEEDED(result))
        return AP_OK;
    if (result == XR_ERROR_SESSION_LOST || result == XR_ERROR_INSTANCE_LOST)
        xr->lost = true;
    char name[XR_MAX_RESULT_STRING_SIZE];
    return ap_fail(err, AP_ENVIRONMENT, "%s: %s (OpenXR runtime: %s)", call,
                   result_name(xr, result, name), xr->runtime_name[0] ? xr->runtime_name : "none");
}

static enum ap_status choose_extension(struct ap_error *err, bool older, bool *vulkan2) {
    uint32_t count = 0;
    XrResult r = ap_xrl.EnumerateInstanceExtensionProperties(NULL, 0, &count, NULL);
    if (r != XR_SUCCESS)
        return ap_fail(err, AP_ENVIRONMENT,
                       "no OpenXR runtime could be loaded (XrResult %d): check the manifest that "
                       "XR_RUNTIME_JSON or active_runtime.json names, or unset XR_RUNTIME_JSON to "
                       "use the simulated headset ('antipode doctor' tells more)",
                       (int)r);
    static XrExtensionProperties properties[MAX_EXTENSIONS];
    if (count > MAX_EXTENSIONS)
        count = MAX_EXTENSIONS;
    for (uint32_t i = 0; i < count; i++)
        properties[i] = (XrExtensionProperties){.type = XR_TYPE_EXTENSION_PROPERTIES};
    r = ap_xrl.EnumerateInstanceExtensionProperties(NULL, count, &count, properties);
    bool one = false, two = false;
    for (uint32_t i = 0; r == XR_SUCCESS && i < count; i++) {
        const char *name = properties[i].extensionName;
        one |= strcmp(name, XR_KHR_VULKAN_ENABLE_EXTENSION_NAME) == 0;
        two |= strcmp(name, XR_KHR_VULKAN_ENABLE2_EXTENSION_NAME) == 0;
    }
    if (!one && !two)
        return ap_fail(err, AP_ENVIRONMENT,
                       "the OpenXR runtime offers no Vulkan (XR_KHR_vulkan_enable2 or _enable): "
                       "choose another runtime with XR_RUNTIME_JSON");
    *vulkan2 = two && !(older && one);
    return AP_OK;
}

static enum ap_status get_system(struct ap_error *err, struct ap_xr *xr) {
    XrSystemGetInfo get = {.type = XR_TYPE_SYSTEM_GET_INFO,
                           .formFactor = XR_FORM_FACTOR_HEAD_MOUNTED_DISPLAY};
    XrResult r = ap_xrl.GetSystem(xr->instance, &get, &xr->system);
    if (r == XR_ERROR_FORM_FACTOR_UNAVAILABLE)
        return ap_fail(err, AP_ENVIRONMENT,
                       "%s: no headset is there right now: plug it in, or switch it on",
                       xr->runtime_name);
    enum ap_status st = ap_xr_check(err, xr, r, "xrGetSystem");
    if (st)
        return st;
    XrSystemProperties properties = {.type = XR_TYPE_SYSTEM_PROPERTIES};
    r = ap_xrl.GetSystemProperties(xr->instance, xr->system, &properties);
    if (r == XR_SUCCESS)
        memcpy(xr->system_name, properties.systemName, sizeof xr->system_name);
    return ap_xr_check(err, xr, r, "xrGetSystemProperties");
}

enum ap_status ap_xr_instance_create(struct ap_error *err, const struct ap_xr_params *params,
                                     struct ap_xr *xr) {
    enum ap_status st = choose_extension(err, params->older_vulkan, &xr->vulkan2);
    if (st)
        return st;
    const char *extension =
        xr->vulkan2 ? XR_KHR_VULKAN_ENABLE2_EXTENSION_NAME : XR_KHR_VULKAN_ENABLE_EXTENSION_NAME;
    XrInstanceCreateInfo info = {
        .type = XR_TYPE_INSTANCE_CREATE_INFO,
        .applicationInfo = {.applicationVersion = 1,
                            .engineName = "antipode",
                            .engineVersion = 1,
                            .apiVersion = XR_MAKE_VERSION(1, 0, 0)},
        .enabledExtensionCount = 1,
        .enabledExtensionNames = &extension,
    };
    snprintf(info.applicationInfo.applicationName, XR_MAX_APPLICATION_NAME_SIZE, "%.63s",
             params->application);
    XrResult r = ap_xrl.CreateInstance(&info, &xr->instance);
    if (r != XR_SUCCESS) {
        xr->instance = XR_NULL_HANDLE;
        return ap_xr_check(err, xr, r, "xrCreateInstance");
    }
    XrInstanceProperties properties = {.type = XR_TYPE_INSTANCE_PROPERTIES};
    if (ap_xrl.GetInstanceProperties(xr->instance, &properties) == XR_SUCCESS)
        memcpy(xr->runtime_name, properties.runtimeName, sizeof xr->runtime_name);
    return get_system(err, xr);
}
