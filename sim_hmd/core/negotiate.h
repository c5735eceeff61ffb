#ifndef ANTIPODE_SIM_HMD_CORE_NEGOTIATE_H
#define ANTIPODE_SIM_HMD_CORE_NEGOTIATE_H

#include <stddef.h>
#include <stdint.h>

#include <openxr/openxr.h>

// The loader's handshake, "OpenXR loader - design and operation", section "Loader/Runtime
// Negotiation". Debian's 1.0 development package has no header for it.

// OpenXR 1.1, which Debian's header does not know yet.
#define SIM_API_VERSION XR_MAKE_VERSION(1, 1, 41)

enum { SIM_LOADER_INFO = 1, SIM_RUNTIME_REQUEST = 3, SIM_INTERFACE_VERSION = 1 };

struct sim_loader_info {
    uint32_t structType, structVersion;
    size_t structSize;
    uint32_t minInterfaceVersion, maxInterfaceVersion;
    XrVersion minApiVersion, maxApiVersion;
};

struct sim_runtime_request {
    uint32_t structType, structVersion;
    size_t structSize;
    uint32_t runtimeInterfaceVersion;
    XrVersion runtimeApiVersion;
    PFN_xrGetInstanceProcAddr getInstanceProcAddr;
};

// The core functions, and when they may be asked for. Those of extensions: ext/extensions.h.
#define SIM_CORE_FUNCTIONS(X)                                                                      \
    X(xrGetInstanceProcAddr, INSTANCE)                                                             \
    X(xrEnumerateApiLayerProperties, ALWAYS)                                                       \
    X(xrEnumerateInstanceExtensionProperties, ALWAYS)                                              \
    X(xrCreateInstance, ALWAYS)                                                                    \
    X(xrDestroyInstance, INSTANCE)                                                                 \
    X(xrGetInstanceProperties, INSTANCE)                                                           \
    X(xrPollEvent, INSTANCE)                                                                       \
    X(xrResultToString, INSTANCE)                                                                  \
    X(xrStructureTypeToString, INSTANCE)                                                           \
    X(xrGetSystem, INSTANCE)                                                                       \
    X(xrGetSystemProperties, INSTANCE)                                                             \
    X(xrEnumerateEnvironmentBlendModes, INSTANCE)                                                  \
    X(xrCreateSession, INSTANCE)                                                                   \
    X(xrDestroySession, INSTANCE)                                                                  \
    X(xrEnumerateReferenceSpaces, INSTANCE)                                                        \
    X(xrCreateReferenceSpace, INSTANCE)                                                            \
    X(xrGetReferenceSpaceBoundsRect, INSTANCE)                                                     \
    X(xrCreateActionSpace, INSTANCE)                                                               \
    X(xrLocateSpace, INSTANCE)                                                                     \
    X(xrDestroySpace, INSTANCE)                                                                    \
    X(xrEnumerateViewConfigurations, INSTANCE)                                                     \
    X(xrGetViewConfigurationProperties, INSTANCE)                                                  \
    X(xrEnumerateViewConfigurationViews, INSTANCE)                                                 \
    X(xrEnumerateSwapchainFormats, INSTANCE)                                                       \
    X(xrCreateSwapchain, INSTANCE)                                                                 \
    X(xrDestroySwapchain, INSTANCE)                                                                \
    X(xrEnumerateSwapchainImages, INSTANCE)                                                        \
    X(xrAcquireSwapchainImage, INSTANCE)                                                           \
    X(xrWaitSwapchainImage, INSTANCE)                                                              \
    X(xrReleaseSwapchainImage, INSTANCE)                                                           \
    X(xrBeginSession, INSTANCE)                                                                    \
    X(xrEndSession, INSTANCE)                                                                      \
    X(xrRequestExitSession, INSTANCE)                                                              \
    X(xrWaitFrame, INSTANCE)                                                                       \
    X(xrBeginFrame, INSTANCE)                                                                      \
    X(xrEndFrame, INSTANCE)                                                                        \
    X(xrLocateViews, INSTANCE)                                                                     \
    X(xrStringToPath, INSTANCE)                                                                    \
    X(xrPathToString, INSTANCE)                                                                    \
    X(xrCreateActionSet, INSTANCE)                                                                 \
    X(xrDestroyActionSet, INSTANCE)                                                                \
    X(xrCreateAction, INSTANCE)                                                                    \
    X(xrDestroyAction, INSTANCE)                                                                   \
    X(xrSuggestInteractionProfileBindings, INSTANCE)                                               \
    X(xrAttachSessionActionSets, INSTANCE)                                                         \
    X(xrGetCurrentInteractionProfile, INSTANCE)                                                    \
    X(xrGetActionStateBoolean, INSTANCE)                                                           \
    X(xrGetActionStateFloat, INSTANCE)                                                             \
    X(xrGetActionStateVector2f, INSTANCE)                                                          \
    X(xrGetActionStatePose, INSTANCE)                                                              \
    X(xrSyncActions, INSTANCE)                                                                     \
    X(xrEnumerateBoundSourcesForAction, INSTANCE)                                                  \
    X(xrGetInputSourceLocalizedName, INSTANCE)                                                     \
    X(xrApplyHapticFeedback, INSTANCE)                                                             \
    X(xrStopHapticFeedback, INSTANCE)                                                              \
    X(xrLocateSpaces, VERSION_1_1)

// The library's only exported symbol.
__attribute__((visibility("default"))) XrResult XRAPI_CALL xrNegotiateLoaderRuntimeInterface(
    const struct sim_loader_info *loader, struct sim_runtime_request *request);

#endif
