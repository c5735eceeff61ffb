#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <openxr/openxr_reflection.h>

#include "sim_hmd/core/instance.h"
#include "sim_hmd/input/source.h"
#include "src/base/clock.h"
#include "src/base/log.h"

// Instances, events, paths and the names of things.

XrResult XRAPI_CALL xrEnumerateApiLayerProperties(uint32_t capacity, uint32_t *count,
                                                  XrApiLayerProperties *properties) {
    return sim_two_calls(capacity, count, 0, NULL, sizeof *properties, properties);
}

XrResult XRAPI_CALL xrEnumerateInstanceExtensionProperties(const char *layer, uint32_t capacity,
                                                           uint32_t *count,
                                                           XrExtensionProperties *properties) {
    if (layer)
        return XR_ERROR_API_LAYER_NOT_PRESENT;
    if (!count || (capacity && !properties))
        return XR_ERROR_VALIDATION_FAILURE;
    *count = SIM_EXTENSION_COUNT;
    if (capacity == 0)
        return XR_SUCCESS;
    if (capacity < SIM_EXTENSION_COUNT)
        return XR_ERROR_SIZE_INSUFFICIENT;
    for (int i = 0; i < SIM_EXTENSION_COUNT; i++) {
        if (properties[i].type != XR_TYPE_EXTENSION_PROPERTIES)
            return XR_ERROR_VALIDATION_FAILURE;
        snprintf(properties[i].extensionName, sizeof properties[i].extensionName, "%s",
                 sim_extensions[i].name);
        properties[i].extensionVersion = sim_extensions[i].version;
    }
    return XR_SUCCESS;
}

static XrResult check_create_info(const XrInstanceCreateInfo *info) {
    if (!sim_is(info, XR_TYPE_INSTANCE_CREATE_INFO) || info->createFlags)
        return XR_ERROR_VALIDATION_FAILURE;
    const XrApplicationInfo *app = &info->applicationInfo;
    if (!memchr(app->applicationName, 0, sizeof app->applicationName) ||
        !memchr(app->engineName, 0, sizeof app->engineName))
        return XR_ERROR_VALIDATION_FAILURE;
    if (app->applicationName[0] == '\0')
        return XR_ERROR_NAME_INVALID;
    if (XR_VERSION_MAJOR(app->apiVersion) != 1 || XR_VERSION_MINOR(app->apiVersion) > 1)
        return XR_ERROR_API_VERSION_UNSUPPORTED;
    if (info->enabledApiLayerCount && !info->enabledApiLayerNames)
        return XR_ERROR_VALIDATION_FAILURE;
    if (info->enabledExtensionCount && !info->enabledExtensionNames)
        return XR_ERROR_VALIDATION_FAILURE;
    return XR_SUCCESS;
}

static XrResult enable_extensions(const XrInstanceCreateInfo *info, struct sim_instance *instance) {
    for (uint32_t i = 0; i < info->enabledExtensionCount; i++) {
        enum sim_extension_id id = sim_extension_find(info->enabledExtensionNames[i]);
        if (id == SIM_EXTENSION_COUNT)
            return XR_ERROR_EXTENSION_NOT_PRESENT;
        instance->enabled[id] = true;
    }
    return XR_SUCCESS;
}

static void free_instance(struct sim_object *object) {
    struct sim_instance *instance = (struct sim_instance *)object;
    sim_source_destroy(instance->source);
    sim_settings_finish(&instance->settings);
    sim_paths_finish(&instance->paths);
    sim_names_finish(&instance->names);
    free(instance->suggestions);
    free(instance);
}

// The environment's settings and what they name. The person who set them reads standard error.
static XrResult load_settings(struct sim_instance *instance) {
    struct ap_error err;
    // An empty variable is none: that is how scripts clear one.
    const char *path = getenv("ANTIPODE_SIM");
    enum ap_status st = sim_settings_read(&err, path && *path ? path : NULL, &instance->settings);
    if (!st)
        st = sim_source_create(&err, &instance->settings, &instance->source);
    if (!st)
        return XR_SUCCESS;
    ap_log(AP_LOG_ERROR, "%s", err.text);
    return st == AP_INPUT ? XR_ERROR_INITIALIZATION_FAILED : XR_ERROR_RUNTIME_FAILURE;
}

// A messenger in the chain hears what creation, and later destruction, has to say.
static XrResult take_messenger(const XrInstanceCreateInfo *info, struct sim_instance *instance) {
    const XrDebugUtilsMessengerCreateInfoEXT *messenger =
        sim_chained(info, XR_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT);
    if (!messenger || !instance->enabled[SIM_EXT_debug_utils])
        return XR_SUCCESS;
    XrResult result = sim_messenger_init(messenger, &instance->messenger);
    instance->chained = result == XR_SUCCESS;
    if (instance->chained)
        sim_messenger_begin(&instance->messenger);
    return result;
}

XrResult XRAPI_CALL xrCreateInstance(const XrInstanceCreateInfo *info, XrInstance *out) {
    SIM_LOCKED;
    XrResult result = check_create_info(info);
    if (result != XR_SUCCESS)
        return result;
    if (!out)
        return XR_ERROR_VALIDATION_FAILURE;
    // API layers are the loader's: it has loaded those that are named, and names them to us.
    struct sim_instance *instance = calloc(1, sizeof *instance);
    if (!instance)
        return XR_ERROR_OUT_OF_MEMORY;
    result = enable_extensions(info, instance);
    instance->minor = XR_VERSION_MINOR(info->applicationInfo.apiVersion);
    if (instance->minor >= 1) // took it into the core, value for value
        instance->enabled[SIM_EXT_local_floor] = true;
    if (result == XR_SUCCESS)
        result = take_messenger(info, instance);
    if (result == XR_SUCCESS)
        result = load_settings(instance);
    instance->epoch_ns = ap_clock_now_ns();
    if (result == XR_SUCCESS &&
        !sim_object_add(&instance->object, SIM_INSTANCE, NULL, free_instance))
        result = XR_ERROR_LIMIT_REACHED;
    if (instance->chained)
        sim_messenger_end(&instance->messenger);
    if (result != XR_SUCCESS) {
        free_instance(&instance->object);
        return result;
    }
    *out = SIM_HANDLE(XrInstance, instance);
    return XR_SUCCESS;
}

XrResult XRAPI_CALL xrDestroyInstance(XrInstance handle) {
    SIM_LOCKED;
    struct sim_instance *instance = sim_instance_get(handle);
    if (!instance)
        return XR_ERROR_HANDLE_INVALID;
    struct sim_messenger last = instance->messenger;
    bool chained = instance->chained;
    if (chained)
        sim_messenger_begin(&last);
    sim_object_destroy(&instance->object);
    if (chained)
        sim_messenger_end(&last);
    sim_wake();
    return XR_SUCCESS;
}

XrResult XRAPI_CALL xrGetInstanceProperties(XrInstance handle, XrInstanceProperties *properties) {
    SIM_LOCKED;
    if (!sim_instance_get(handle))
        return XR_ERROR_HANDLE_INVALID;
    if (!sim_is(properties, XR_TYPE_INSTANCE_PROPERTIES))
        return XR_ERROR_VALIDATION_FAILURE;
    properties->runtimeVersion = XR_MAKE_VERSION(0, 1, 0);
    snprintf(properties->runtimeName, sizeof properties->runtimeName, "antipode simulated headset");
    return XR_SUCCESS;
}

XrResult XRAPI_CALL xrPollEvent(XrInstance handle, XrEventDataBuffer *event) {
    SIM_LOCKED;
    struct sim_instance *instance = sim_instance_get(handle);
    if (!instance)
        return XR_ERROR_HANDLE_INVALID;
    // Programs reuse the buffer with whatever type the last event left in it.
    if (!event)
        return XR_ERROR_VALIDATION_FAILURE;
    return sim_events_pop(&instance->events, event) ? XR_SUCCESS : XR_EVENT_UNAVAILABLE;
}

#define NAME(name, value)                                                                          \
    case name:                                                                                     \
        text = #name;                                                                              \
        break;

XrResult XRAPI_CALL xrResultToString(XrInstance handle, XrResult value,
                                     char buffer[XR_MAX_RESULT_STRING_SIZE]) {
    SIM_LOCKED;
    if (!sim_instance_get(handle))
        return XR_ERROR_HANDLE_INVALID;
    if (!buffer)
        return XR_ERROR_VALIDATION_FAILURE;
    const char *text = NULL;
    switch (value) { XR_LIST_ENUM_XrResult(NAME) default : break; }
    if (text)
        snprintf(buffer, XR_MAX_RESULT_STRING_SIZE, "%s", text);
    else
        snprintf(buffer, XR_MAX_RESULT_STRING_SIZE, "XR_UNKNOWN_%s_%d",
                 value < 0 ? "FAILURE" : "SUCCESS", (int)value);
    return XR_SUCCESS;
}

XrResult XRAPI_CALL xrStructureTypeToString(XrInstance handle, XrStructureType value,
                                            char buffer[XR_MAX_STRUCTURE_NAME_SIZE]) {
    SIM_LOCKED;
    if (!sim_instance_get(handle))
        return XR_ERROR_HANDLE_INVALID;
    if (!buffer)
        return XR_ERROR_VALIDATION_FAILURE;
    const char *text = NULL;
    switch (value) { XR_LIST_ENUM_XrStructureType(NAME) default : break; }
    if (text)
        snprintf(buffer, XR_MAX_STRUCTURE_NAME_SIZE, "%s", text);
    else
        snprintf(buffer, XR_MAX_STRUCTURE_NAME_SIZE, "XR_UNKNOWN_STRUCTURE_TYPE_%lld",
                 (long long)value);
    return XR_SUCCESS;
}

XrResult XRAPI_CALL xrStringToPath(XrInstance handle, const char *text, XrPath *path) {
    SIM_LOCKED;
    struct sim_instance *instance = sim_instance_get(handle);
    if (!instance)
        return XR_ERROR_HANDLE_INVALID;
    if (!text || !path)
        return XR_ERROR_VALIDATION_FAILURE;
    return sim_path_make(&instance->paths, text, path);
}

XrResult XRAPI_CALL xrPathToString(XrInstance handle, XrPath path, uint32_t capacity,
                                   uint32_t *count, char *buffer) {
    SIM_LOCKED;
    struct sim_instance *instance = sim_instance_get(handle);
    if (!instance)
        return XR_ERROR_HANDLE_INVALID;
    const char *text = sim_path_text(&instance->paths, path);
    return text ? sim_two_call_text(capacity, count, text, buffer) : XR_ERROR_PATH_INVALID;
}
