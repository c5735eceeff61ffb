#include "sim_hmd/core/negotiate.h"

#include <string.h>

#include "sim_hmd/core/instance.h"
#include "sim_hmd/strict/strict.h"
#include "src/base/log.h"

XrResult XRAPI_CALL xrNegotiateLoaderRuntimeInterface(const struct sim_loader_info *loader,
                                                      struct sim_runtime_request *request) {
    if (!loader || !request || loader->structType != SIM_LOADER_INFO ||
        loader->structVersion != 1 || loader->structSize != sizeof *loader ||
        request->structType != SIM_RUNTIME_REQUEST || request->structVersion != 1 ||
        request->structSize != sizeof *request)
        return XR_ERROR_INITIALIZATION_FAILED;
    if (loader->minInterfaceVersion > SIM_INTERFACE_VERSION ||
        loader->maxInterfaceVersion < SIM_INTERFACE_VERSION ||
        loader->minApiVersion > SIM_API_VERSION || loader->maxApiVersion < XR_MAKE_VERSION(1, 0, 0))
        return XR_ERROR_INITIALIZATION_FAILED;
    ap_log_set_prefix("antipode-sim");
    request->runtimeInterfaceVersion = SIM_INTERFACE_VERSION;
    request->runtimeApiVersion =
        loader->maxApiVersion < XR_MAKE_VERSION(1, 1, 0) ? XR_CURRENT_API_VERSION : SIM_API_VERSION;
    request->getInstanceProcAddr = xrGetInstanceProcAddr;
    return XR_SUCCESS;
}

// When a function may be asked for.
enum when { ALWAYS, INSTANCE, VERSION_1_1 };

// The core; extensions bring their own lists (extensions.h).
struct entry {
    const char *name;
    PFN_xrVoidFunction function;
    enum when when;
};

#define ENTRY(name, when)                                                                          \
    { #name, (PFN_xrVoidFunction)name, when }

static const struct entry entries[] = {
    ENTRY(xrGetInstanceProcAddr, INSTANCE),
    ENTRY(xrEnumerateApiLayerProperties, ALWAYS),
    ENTRY(xrEnumerateInstanceExtensionProperties, ALWAYS),
    ENTRY(xrCreateInstance, ALWAYS),
    ENTRY(xrDestroyInstance, INSTANCE),
    ENTRY(xrGetInstanceProperties, INSTANCE),
    ENTRY(xrPollEvent, INSTANCE),
    ENTRY(xrResultToString, INSTANCE),
    ENTRY(xrStructureTypeToString, INSTANCE),
    ENTRY(xrGetSystem, INSTANCE),
    ENTRY(xrGetSystemProperties, INSTANCE),
    ENTRY(xrEnumerateEnvironmentBlendModes, INSTANCE),
    ENTRY(xrCreateSession, INSTANCE),
    ENTRY(xrDestroySession, INSTANCE),
    ENTRY(xrEnumerateReferenceSpaces, INSTANCE),
    ENTRY(xrCreateReferenceSpace, INSTANCE),
    ENTRY(xrGetReferenceSpaceBoundsRect, INSTANCE),
    ENTRY(xrCreateActionSpace, INSTANCE),
    ENTRY(xrLocateSpace, INSTANCE),
    ENTRY(xrDestroySpace, INSTANCE),
    ENTRY(xrEnumerateViewConfigurations, INSTANCE),
    ENTRY(xrGetViewConfigurationProperties, INSTANCE),
    ENTRY(xrEnumerateViewConfigurationViews, INSTANCE),
    ENTRY(xrEnumerateSwapchainFormats, INSTANCE),
    ENTRY(xrCreateSwapchain, INSTANCE),
    ENTRY(xrDestroySwapchain, INSTANCE),
    ENTRY(xrEnumerateSwapchainImages, INSTANCE),
    ENTRY(xrAcquireSwapchainImage, INSTANCE),
    ENTRY(xrWaitSwapchainImage, INSTANCE),
    ENTRY(xrReleaseSwapchainImage, INSTANCE),
    ENTRY(xrBeginSession, INSTANCE),
    ENTRY(xrEndSession, INSTANCE),
    ENTRY(xrRequestExitSession, INSTANCE),
    ENTRY(xrWaitFrame, INSTANCE),
    ENTRY(xrBeginFrame, INSTANCE),
    ENTRY(xrEndFrame, INSTANCE),
    ENTRY(xrLocateViews, INSTANCE),
    ENTRY(xrStringToPath, INSTANCE),
    ENTRY(xrPathToString, INSTANCE),
    ENTRY(xrCreateActionSet, INSTANCE),
    ENTRY(xrDestroyActionSet, INSTANCE),
    ENTRY(xrCreateAction, INSTANCE),
    ENTRY(xrDestroyAction, INSTANCE),
    ENTRY(xrSuggestInteractionProfileBindings, INSTANCE),
    ENTRY(xrAttachSessionActionSets, INSTANCE),
    ENTRY(xrGetCurrentInteractionProfile, INSTANCE),
    ENTRY(xrGetActionStateBoolean, INSTANCE),
    ENTRY(xrGetActionStateFloat, INSTANCE),
    ENTRY(xrGetActionStateVector2f, INSTANCE),
    ENTRY(xrGetActionStatePose, INSTANCE),
    ENTRY(xrSyncActions, INSTANCE),
    ENTRY(xrEnumerateBoundSourcesForAction, INSTANCE),
    ENTRY(xrGetInputSourceLocalizedName, INSTANCE),
    ENTRY(xrApplyHapticFeedback, INSTANCE),
    ENTRY(xrStopHapticFeedback, INSTANCE),
    ENTRY(xrLocateSpaces, VERSION_1_1),
};

static bool may_ask(const struct sim_instance *instance, enum when when) {
    return when == ALWAYS || (instance && (when == INSTANCE || instance->minor >= 1));
}

// NULL: no such function, or none that may be asked for yet.
static PFN_xrVoidFunction find(const struct sim_instance *instance, const char *name) {
    for (size_t i = 0; i < sizeof entries / sizeof *entries; i++)
        if (strcmp(entries[i].name, name) == 0)
            return may_ask(instance, entries[i].when) ? entries[i].function : NULL;
    return instance ? sim_extension_function(instance->enabled, name) : NULL;
}

XrResult XRAPI_CALL xrGetInstanceProcAddr(XrInstance handle, const char *name,
                                          PFN_xrVoidFunction *function) {
    SIM_LOCKED;
    if (!name || !function)
        return XR_ERROR_VALIDATION_FAILURE;
    *function = NULL;
    const struct sim_instance *instance = sim_instance_get(handle);
    if (handle && !instance)
        return XR_ERROR_HANDLE_INVALID;
    *function = find(instance, name);
    if (*function) {
        *function = sim_strict_wrap(name, *function);
        return XR_SUCCESS;
    }
    sim_strict_no_function(name);
    return instance ? XR_ERROR_FUNCTION_UNSUPPORTED : XR_ERROR_HANDLE_INVALID;
}
