#ifndef ANTIPODE_XR_LOADER_H
#define ANTIPODE_XR_LOADER_H

#include <openxr/openxr.h>

#include "src/base/status.h"

// The OpenXR loader, opened when it is first needed: geometry, tracking and everything else of the
// program works on a machine without it, and its absence is a sentence rather than a failed start.
// ap_xrl.WaitFrame(…) is xrWaitFrame(…).

// clang-format off
#define AP_XR_FUNCTIONS(X) \
    X(AcquireSwapchainImage) X(ApplyHapticFeedback) X(AttachSessionActionSets) X(BeginFrame) \
    X(BeginSession) X(CreateAction) X(CreateActionSet) X(CreateActionSpace) \
    X(CreateInstance) X(CreateReferenceSpace) X(CreateSession) X(CreateSwapchain) \
    X(DestroyActionSet) X(DestroyInstance) X(DestroySession) X(EndFrame) X(EndSession) \
    X(EnumerateEnvironmentBlendModes) X(EnumerateInstanceExtensionProperties) \
    X(EnumerateReferenceSpaces) X(EnumerateSwapchainFormats) X(EnumerateSwapchainImages) \
    X(EnumerateViewConfigurationViews) X(GetActionStateBoolean) X(GetActionStateFloat) \
    X(GetActionStateVector2f) X(GetReferenceSpaceBoundsRect) X(DestroySwapchain) \
    X(GetInstanceProcAddr) X(GetInstanceProperties) X(GetSystem) X(GetSystemProperties) \
    X(LocateSpace) X(LocateViews) X(PollEvent) X(ReleaseSwapchainImage) \
    X(RequestExitSession) X(ResultToString) X(StringToPath) \
    X(SuggestInteractionProfileBindings) X(SyncActions) X(WaitFrame) X(WaitSwapchainImage)
// clang-format on

struct ap_xr_loader {
#define AP_XR_MEMBER(name) PFN_xr##name name;
    AP_XR_FUNCTIONS(AP_XR_MEMBER)
#undef AP_XR_MEMBER
};

// Filled by ap_xr_loader_open; then read-only, any thread.
extern struct ap_xr_loader ap_xrl;

// Once for the process; later calls do nothing. AP_ENVIRONMENT where there is no loader.
enum ap_status ap_xr_loader_open(struct ap_error *err);

#endif
