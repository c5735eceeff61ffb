#ifndef ANTIPODE_SIM_HMD_STRICT_SPEC_H
#define ANTIPODE_SIM_HMD_STRICT_SPEC_H

#include "sim_hmd/strict/call.h"

// spec.c; by the names of the header.
extern const struct sim_values sim_values_XrActionType;
extern const struct sim_values sim_values_XrEnvironmentBlendMode;
extern const struct sim_values sim_values_XrEyeVisibility;
extern const struct sim_values sim_values_XrFormFactor;
extern const struct sim_values sim_values_XrHandEXT;
extern const struct sim_values sim_values_XrHandJointSetEXT;
extern const struct sim_values sim_values_XrHandJointsMotionRangeEXT;
extern const struct sim_values sim_values_XrObjectType;
extern const struct sim_values sim_values_XrReferenceSpaceType;
extern const struct sim_values sim_values_XrResult;
extern const struct sim_values sim_values_XrViewConfigurationType;
extern const struct sim_values sim_values_XrVisibilityMaskTypeKHR;

// The structures that the lint knows, each described in spec.c.
// clang-format off
#define SIM_SPECS(X) \
    X(XrApiLayerProperties) X(XrExtensionProperties) X(XrApplicationInfo) \
    X(XrInstanceCreateInfo) X(XrInstanceProperties) X(XrEventDataBuffer) X(XrSystemGetInfo) \
    X(XrSystemProperties) X(XrSessionCreateInfo) X(XrReferenceSpaceCreateInfo) \
    X(XrActionSpaceCreateInfo) X(XrSpaceLocation) X(XrViewConfigurationProperties) \
    X(XrViewConfigurationView) X(XrSwapchainCreateInfo) X(XrSwapchainImageAcquireInfo) \
    X(XrSwapchainImageWaitInfo) X(XrSwapchainImageReleaseInfo) X(XrSessionBeginInfo) \
    X(XrFrameWaitInfo) X(XrFrameState) X(XrFrameBeginInfo) X(XrFrameEndInfo) X(XrViewLocateInfo) \
    X(XrViewState) X(XrView) X(XrActionSetCreateInfo) X(XrActionCreateInfo) \
    X(XrActionSuggestedBinding) X(XrInteractionProfileSuggestedBinding) \
    X(XrSessionActionSetsAttachInfo) X(XrInteractionProfileState) X(XrActionStateGetInfo) \
    X(XrActionStateBoolean) X(XrActionStateFloat) X(XrActionStateVector2f) X(XrActionStatePose) \
    X(XrActiveActionSet) X(XrActionsSyncInfo) X(XrBoundSourcesForActionEnumerateInfo) \
    X(XrInputSourceLocalizedNameGetInfo) X(XrHapticActionInfo) X(XrDebugUtilsObjectNameInfoEXT) \
    X(XrDebugUtilsMessengerCreateInfoEXT) X(XrDebugUtilsLabelEXT) \
    X(XrDebugUtilsMessengerCallbackDataEXT) X(XrGraphicsRequirementsVulkanKHR) \
    X(XrVisibilityMaskKHR) X(XrHandTrackerCreateInfoEXT) X(XrHandJointsLocateInfoEXT) \
    X(XrHandJointLocationsEXT) X(XrVulkanInstanceCreateInfoKHR) X(XrVulkanDeviceCreateInfoKHR) \
    X(XrVulkanGraphicsDeviceGetInfoKHR) X(XrCompositionLayerCubeKHR) X(XrSwapchainSubImage) \
    X(XrCompositionLayerDepthInfoKHR) X(XrCompositionLayerCylinderKHR) \
    X(XrCompositionLayerEquirectKHR) X(XrGraphicsBindingVulkanKHR) X(XrSwapchainImageVulkanKHR) \
    X(XrSystemEyeGazeInteractionPropertiesEXT) X(XrEyeGazeSampleTimeEXT) \
    X(XrEventDataVisibilityMaskChangedKHR) X(XrCompositionLayerColorScaleBiasKHR) \
    X(XrViewConfigurationDepthRangeEXT) X(XrSystemHandTrackingPropertiesEXT) \
    X(XrHandJointVelocitiesEXT) X(XrViewConfigurationViewFovEPIC) \
    X(XrHandJointsMotionRangeInfoEXT) X(XrCompositionLayerEquirect2KHR) \
    X(XrEventDataDisplayRefreshRateChangedFB) X(XrCompositionLayerProjectionView) \
    X(XrCompositionLayerProjection) X(XrCompositionLayerQuad) X(XrHapticVibration) \
    X(XrSpaceVelocity) X(XrSpacesLocateInfo) X(XrSpaceLocations) X(XrSpaceVelocities)
// clang-format on
#define SIM_SPEC_EXTERN(S) extern const struct sim_spec sim_spec_##S;
SIM_SPECS(SIM_SPEC_EXTERN)

// What programs hand over as a base header is one of these here.
#define sim_spec_XrHapticBaseHeader sim_spec_XrHapticVibration
#define sim_spec_XrSwapchainImageBaseHeader sim_spec_XrSwapchainImageVulkanKHR

#endif
