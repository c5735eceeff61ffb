#include <stdio.h>
#include <string.h>

#include "sim_hmd/strict/call.h"

// What an error code says of the program, where no argument was found wrong: the rule that it
// broke. Also the runtime's next check, which nobody told the lint of, is reported this way.

struct rule {
    const char *function; // NULL: any; the first that fits is taken
    XrResult result;
    enum sim_level level;
    const char *text;
};

static const struct rule rules[] = {
    {"xrBeginFrame", XR_ERROR_CALL_ORDER_INVALID, SIM_ERROR,
     "Frame Submission: each xrBeginFrame has an xrWaitFrame of its own before it"},
    {"xrEndFrame", XR_ERROR_CALL_ORDER_INVALID, SIM_ERROR,
     "Frame Submission: xrEndFrame ends a frame that xrBeginFrame began"},
    {"xrAcquireSwapchainImage", XR_ERROR_CALL_ORDER_INVALID, SIM_ERROR,
     "Swapchain Images: no more are acquired than there are, a static image once"},
    {"xrWaitSwapchainImage", XR_ERROR_CALL_ORDER_INVALID, SIM_ERROR,
     "Swapchain Images: one that is acquired is waited for, once"},
    {"xrReleaseSwapchainImage", XR_ERROR_CALL_ORDER_INVALID, SIM_ERROR,
     "Swapchain Images: one is released after it was waited for"},
    {NULL, XR_ERROR_CALL_ORDER_INVALID, SIM_ERROR, "the order of calls"},
    {"xrBeginSession", XR_ERROR_SESSION_RUNNING, SIM_ERROR,
     "Session Lifecycle: a session is begun once"},
    {"xrBeginSession", XR_ERROR_SESSION_NOT_READY, SIM_ERROR,
     "Session Lifecycle: a session is begun in the state READY"},
    {"xrEndSession", XR_ERROR_SESSION_NOT_STOPPING, SIM_ERROR,
     "Session Lifecycle: a session is ended in the state STOPPING"},
    {NULL, XR_ERROR_SESSION_NOT_RUNNING, SIM_ERROR,
     "Session Lifecycle: between xrBeginSession and xrEndSession"},
    {NULL, XR_ERROR_TIME_INVALID, SIM_ERROR, "Time: a time is positive and the runtime's"},
    {NULL, XR_ERROR_POSE_INVALID, SIM_ERROR, "Coordinate System: finite poses, unit quaternions"},
    {NULL, XR_ERROR_INDEX_OUT_OF_RANGE, SIM_ERROR, "an index is below its count"},
    {"xrEndFrame", XR_ERROR_LAYER_INVALID, SIM_ERROR,
     "Composition: a layer is of an enabled type and its swapchains have a released image"},
    {"xrEndFrame", XR_ERROR_LAYER_LIMIT_EXCEEDED, SIM_ERROR,
     "Composition: no more layers than XrSystemGraphicsProperties::maxLayerCount"},
    {"xrEndFrame", XR_ERROR_SWAPCHAIN_RECT_INVALID, SIM_ERROR,
     "Composition: XrSwapchainSubImage::imageRect lies within the image"},
    {"xrEndFrame", XR_ERROR_ENVIRONMENT_BLEND_MODE_UNSUPPORTED, SIM_ERROR,
     "Environment Blend Mode: one of xrEnumerateEnvironmentBlendModes"},
    {NULL, XR_ERROR_VIEW_CONFIGURATION_TYPE_UNSUPPORTED, SIM_ERROR,
     "View Configurations: one of xrEnumerateViewConfigurations"},
    {"xrCreateSwapchain", XR_ERROR_SWAPCHAIN_FORMAT_UNSUPPORTED, SIM_ERROR,
     "Swapchain Images: one of xrEnumerateSwapchainFormats"},
    {NULL, XR_ERROR_FEATURE_UNSUPPORTED, SIM_WARNING, "a feature that a runtime need not have"},
    {NULL, XR_ERROR_REFERENCE_SPACE_UNSUPPORTED, SIM_ERROR,
     "Reference Spaces: one of xrEnumerateReferenceSpaces"},
    {"xrCreateSession", XR_ERROR_GRAPHICS_REQUIREMENTS_CALL_MISSING, SIM_ERROR,
     "Graphics API: the requirements are asked for before a session is created"},
    {"xrCreateSession", XR_ERROR_GRAPHICS_DEVICE_INVALID, SIM_ERROR,
     "Graphics API: a binding of an enabled API, on the device that the runtime named"},
    {NULL, XR_ERROR_SYSTEM_INVALID, SIM_ERROR, "Systems: an XrSystemId of xrGetSystem"},
    {NULL, XR_ERROR_NAME_DUPLICATED, SIM_ERROR, "Input: names are unique"},
    {NULL, XR_ERROR_NAME_INVALID, SIM_ERROR, "Input: names are not empty"},
    {NULL, XR_ERROR_LOCALIZED_NAME_DUPLICATED, SIM_ERROR, "Input: localized names are unique"},
    {NULL, XR_ERROR_LOCALIZED_NAME_INVALID, SIM_ERROR,
     "Input: localized names are UTF-8 and not empty"},
    {NULL, XR_ERROR_PATH_FORMAT_INVALID, SIM_ERROR,
     "Well-Formed Path Strings: a-z, 0-9, -, _, . and /, no empty part"},
    {NULL, XR_ERROR_PATH_INVALID, SIM_ERROR, "Path Atom Type: a path of xrStringToPath"},
    {"xrSuggestInteractionProfileBindings", XR_ERROR_PATH_UNSUPPORTED, SIM_WARNING,
     "Interaction Profile Paths: a profile and its components as listed"},
    {"xrCreateAction", XR_ERROR_PATH_UNSUPPORTED, SIM_ERROR,
     "Actions: subactionPaths are different top level user paths"},
    {"xrSetInputDeviceActiveEXT", XR_ERROR_PATH_UNSUPPORTED, SIM_ERROR,
     "XR_EXT_conformance_automation: a profile that the runtime has, for a hand that it is for"},
    {"xrSetInputDeviceStateBoolEXT", XR_ERROR_PATH_UNSUPPORTED, SIM_ERROR,
     "XR_EXT_conformance_automation: an input of this type of the device that is active"},
    {"xrSetInputDeviceStateFloatEXT", XR_ERROR_PATH_UNSUPPORTED, SIM_ERROR,
     "XR_EXT_conformance_automation: an input of this type of the device that is active"},
    {"xrSetInputDeviceStateVector2fEXT", XR_ERROR_PATH_UNSUPPORTED, SIM_ERROR,
     "XR_EXT_conformance_automation: an input of this type of the device that is active"},
    {"xrSetInputDeviceLocationEXT", XR_ERROR_PATH_UNSUPPORTED, SIM_ERROR,
     "XR_EXT_conformance_automation: a pose of the device that is active"},
    {NULL, XR_ERROR_DISPLAY_REFRESH_RATE_UNSUPPORTED_FB, SIM_ERROR,
     "XR_FB_display_refresh_rate: 0 or one of xrEnumerateDisplayRefreshRatesFB"},
    {NULL, XR_ERROR_PATH_UNSUPPORTED, SIM_ERROR,
     "Actions: a subaction path that the action was created with"},
    {NULL, XR_ERROR_ACTION_TYPE_MISMATCH, SIM_ERROR, "Actions: the action is of the call's type"},
    {NULL, XR_ERROR_ACTIONSET_NOT_ATTACHED, SIM_ERROR,
     "Action Sets: attached by xrAttachSessionActionSets before use"},
    {"xrAttachSessionActionSets", XR_ERROR_ACTIONSETS_ALREADY_ATTACHED, SIM_ERROR,
     "Action Sets: attached once, all together"},
    {"xrSuggestInteractionProfileBindings", XR_ERROR_ACTIONSETS_ALREADY_ATTACHED, SIM_ERROR,
     "Action Sets: bindings are suggested before they are attached"},
    {NULL, XR_ERROR_ACTIONSETS_ALREADY_ATTACHED, SIM_ERROR,
     "Action Sets: immutable once they are attached"},
    {NULL, XR_ERROR_HANDLE_INVALID, SIM_ERROR, "Valid Usage for Object Handles"},
    {NULL, XR_ERROR_VALIDATION_FAILURE, SIM_ERROR, "Valid Usage"},
    {NULL, XR_ERROR_SIZE_INSUFFICIENT, SIM_WARNING,
     "Buffer Size Parameters: ask for the size with a capacity of 0"},
    {NULL, XR_ERROR_API_VERSION_UNSUPPORTED, SIM_ERROR,
     "API Version Numbers: 1.0 works everywhere"},
    {NULL, XR_ERROR_EXTENSION_NOT_PRESENT, SIM_ERROR,
     "Extensions: one of xrEnumerateInstanceExtensionProperties"},
    {NULL, XR_ERROR_API_LAYER_NOT_PRESENT, SIM_ERROR,
     "API Layers: one of xrEnumerateApiLayerProperties"},
    {NULL, XR_ERROR_FUNCTION_UNSUPPORTED, SIM_ERROR, "functions of enabled extensions only"},
};

// The runtime's own troubles, and answers to a question, are nobody's fault.
static bool innocent(XrResult result) {
    switch (result) {
    case XR_ERROR_RUNTIME_FAILURE:
    case XR_ERROR_OUT_OF_MEMORY:
    case XR_ERROR_LIMIT_REACHED:
    case XR_ERROR_INITIALIZATION_FAILED:
    case XR_ERROR_SESSION_LOST:
    case XR_ERROR_INSTANCE_LOST:
    case XR_ERROR_FORM_FACTOR_UNSUPPORTED:
    case XR_ERROR_FORM_FACTOR_UNAVAILABLE:
    case XR_ERROR_RUNTIME_UNAVAILABLE:
        return true;
    default:
        return result >= 0;
    }
}

void sim_strict_judge(struct sim_strict_call *call) {
    if (call->errors || innocent(call->result))
        return;
    struct rule rule = {NULL, call->result, SIM_ERROR, "an error of the call"};
    for (size_t i = 0; i < sizeof rules / sizeof *rules; i++)
        if (rules[i].result == call->result &&
            (!rules[i].function || strcmp(rules[i].function, call->function->name) == 0)) {
            rule = rules[i];
            break;
        }
    char statement[160], values[400];
    snprintf(statement, sizeof statement, "%s: %s", sim_result_name(call->result), rule.text);
    sim_strict_describe(call, values, sizeof values);
    sim_strict_found(call, rule.level, statement, "%s", values);
}
