#include <string.h>

#include "sim_hmd/compose/frame.h"
#include "sim_hmd/strict/spec.h"

#include <openxr/openxr_reflection.h>

// The structures of OpenXR 1.0 and of the extensions that the lint knows, member by member, as
// the registry describes them. Members that nothing can be said of are left out, and so are those
// of structures that are only written.

#define OR_BIT(name, value) | (uint64_t)(value)
#define BITS(T) (0 XR_LIST_BITS_##T(OR_BIT))

#define MEMBERS(S) static const struct sim_member members_##S[]
#define MEMBER(S, m, k, o)                                                                         \
    .name = #m, .kind = MEMBER_##k, .optional = (o), .offset = offsetof(S, m),                     \
    .size = sizeof(((S *)0)->m)
#define OPTIONAL 1
#define COUNTED(S, c) .count_offset = offsetof(S, c)
#define HANDLE(S, m, t, o)                                                                         \
    { MEMBER(S, m, HANDLE, o), .object = SIM_##t }
#define HANDLES(S, m, c, t, o)                                                                     \
    { MEMBER(S, m, HANDLES, o), COUNTED(S, c), .object = SIM_##t }
#define ENUM(S, m, t)                                                                              \
    { MEMBER(S, m, ENUM, 0), .values = &sim_values_##t }
#define FLAGS(S, m, t, o)                                                                          \
    { MEMBER(S, m, FLAGS, o), .mask = BITS(t) }
#define INSIDE(S, m, t)                                                                            \
    { MEMBER(S, m, STRUCT, 0), .spec = &sim_spec_##t }
#define STRUCTS(S, m, c, t, o)                                                                     \
    { MEMBER(S, m, STRUCTS, o), COUNTED(S, c), .spec = &sim_spec_##t }
#define VIEWS(S, m, c, t)                                                                          \
    { MEMBER(S, m, STRUCTS, 0), COUNTED(S, c), .spec = &sim_spec_##t, .most = 2 }
#define LAYERS(S, m, c, o)                                                                         \
    { MEMBER(S, m, LAYERS, o), COUNTED(S, c), .most = SIM_MAX_LAYERS }
#define NAMES(S, m, c, o)                                                                          \
    { MEMBER(S, m, NAMES, o), COUNTED(S, c) }
#define ITEMS(S, m, c, o)                                                                          \
    { MEMBER(S, m, ITEMS, o), COUNTED(S, c) }
#define PATHS(S, m, c, o)                                                                          \
    { MEMBER(S, m, PATHS, o), COUNTED(S, c) }
#define PATH(S, m, o)                                                                              \
    { MEMBER(S, m, PATH, o) }
#define CHARS(S, m)                                                                                \
    { MEMBER(S, m, CHARS, 0) }
#define TEXT(S, m, o)                                                                              \
    { MEMBER(S, m, TEXT, o) }
#define NOT_NULL(S, m)                                                                             \
    { MEMBER(S, m, POINTER, 0) }
#define FLOATS(S, m, n)                                                                            \
    { MEMBER(S, m, FLOATS, 0) }
#define POSE(S, m)                                                                                 \
    { MEMBER(S, m, POSE, 0) }
#define FOV(S, m)                                                                                  \
    { MEMBER(S, m, FOV, 0) }
#define TIME(S, m)                                                                                 \
    { MEMBER(S, m, TIME, 0) }
#define NUMBER(S, m)                                                                               \
    { MEMBER(S, m, NUMBER, 0) }
#define END                                                                                        \
    { 0 }
#define SPEC(S, t, e, m)                                                                           \
    const struct sim_spec sim_spec_##S = {#S, (XrStructureType)(t), sizeof(S), e, m};

static const struct sim_member no_members[] = {END};

SPEC(XrApiLayerProperties, XR_TYPE_API_LAYER_PROPERTIES, NULL, no_members)
SPEC(XrExtensionProperties, XR_TYPE_EXTENSION_PROPERTIES, NULL, no_members)
MEMBERS(XrApplicationInfo) = {
    NUMBER(XrApplicationInfo, apiVersion),
    CHARS(XrApplicationInfo, applicationName),
    CHARS(XrApplicationInfo, engineName),
    END,
};
SPEC(XrApplicationInfo, 0, NULL, members_XrApplicationInfo)

MEMBERS(XrInstanceCreateInfo) = {
    FLAGS(XrInstanceCreateInfo, createFlags, XrInstanceCreateFlags, OPTIONAL),
    INSIDE(XrInstanceCreateInfo, applicationInfo, XrApplicationInfo),
    NAMES(XrInstanceCreateInfo, enabledApiLayerNames, enabledApiLayerCount, OPTIONAL),
    NAMES(XrInstanceCreateInfo, enabledExtensionNames, enabledExtensionCount, OPTIONAL),
    END,
};
SPEC(XrInstanceCreateInfo, XR_TYPE_INSTANCE_CREATE_INFO, NULL, members_XrInstanceCreateInfo)

SPEC(XrInstanceProperties, XR_TYPE_INSTANCE_PROPERTIES, NULL, no_members)
SPEC(XrEventDataBuffer, XR_TYPE_EVENT_DATA_BUFFER, NULL, no_members)
MEMBERS(XrSystemGetInfo) = {
    ENUM(XrSystemGetInfo, formFactor, XrFormFactor),
    END,
};
SPEC(XrSystemGetInfo, XR_TYPE_SYSTEM_GET_INFO, NULL, members_XrSystemGetInfo)

SPEC(XrSystemProperties, XR_TYPE_SYSTEM_PROPERTIES, NULL, no_members)
MEMBERS(XrSessionCreateInfo) = {
    NUMBER(XrSessionCreateInfo, systemId),
    FLAGS(XrSessionCreateInfo, createFlags, XrSessionCreateFlags, OPTIONAL),
    END,
};
SPEC(XrSessionCreateInfo, XR_TYPE_SESSION_CREATE_INFO, NULL, members_XrSessionCreateInfo)

MEMBERS(XrReferenceSpaceCreateInfo) = {
    ENUM(XrReferenceSpaceCreateInfo, referenceSpaceType, XrReferenceSpaceType),
    POSE(XrReferenceSpaceCreateInfo, poseInReferenceSpace),
    END,
};
SPEC(XrReferenceSpaceCreateInfo, XR_TYPE_REFERENCE_SPACE_CREATE_INFO, NULL,
     members_XrReferenceSpaceCreateInfo)

MEMBERS(XrActionSpaceCreateInfo) = {
    HANDLE(XrActionSpaceCreateInfo, action, ACTION, 0),
    PATH(XrActionSpaceCreateInfo, subactionPath, OPTIONAL),
    POSE(XrActionSpaceCreateInfo, poseInActionSpace),
    END,
};
SPEC(XrActionSpaceCreateInfo, XR_TYPE_ACTION_SPACE_CREATE_INFO, NULL,
     members_XrActionSpaceCreateInfo)

SPEC(XrSpaceLocation, XR_TYPE_SPACE_LOCATION, NULL, no_members)
SPEC(XrViewConfigurationProperties, XR_TYPE_VIEW_CONFIGURATION_PROPERTIES, NULL, no_members)
SPEC(XrViewConfigurationView, XR_TYPE_VIEW_CONFIGURATION_VIEW, NULL, no_members)
MEMBERS(XrSwapchainCreateInfo) = {
    NUMBER(XrSwapchainCreateInfo, format),
    NUMBER(XrSwapchainCreateInfo, sampleCount),
    NUMBER(XrSwapchainCreateInfo, width),
    NUMBER(XrSwapchainCreateInfo, height),
    NUMBER(XrSwapchainCreateInfo, faceCount),
    NUMBER(XrSwapchainCreateInfo, arraySize),
    NUMBER(XrSwapchainCreateInfo, mipCount),
    FLAGS(XrSwapchainCreateInfo, createFlags, XrSwapchainCreateFlags, OPTIONAL),
    FLAGS(XrSwapchainCreateInfo, usageFlags, XrSwapchainUsageFlags, OPTIONAL),
    END,
};
SPEC(XrSwapchainCreateInfo, XR_TYPE_SWAPCHAIN_CREATE_INFO, NULL, members_XrSwapchainCreateInfo)

SPEC(XrSwapchainImageAcquireInfo, XR_TYPE_SWAPCHAIN_IMAGE_ACQUIRE_INFO, NULL, no_members)
MEMBERS(XrSwapchainImageWaitInfo) = {
    NUMBER(XrSwapchainImageWaitInfo, timeout),
    END,
};
SPEC(XrSwapchainImageWaitInfo, XR_TYPE_SWAPCHAIN_IMAGE_WAIT_INFO, NULL,
     members_XrSwapchainImageWaitInfo)

SPEC(XrSwapchainImageReleaseInfo, XR_TYPE_SWAPCHAIN_IMAGE_RELEASE_INFO, NULL, no_members)
MEMBERS(XrSessionBeginInfo) = {
    ENUM(XrSessionBeginInfo, primaryViewConfigurationType, XrViewConfigurationType),
    END,
};
SPEC(XrSessionBeginInfo, XR_TYPE_SESSION_BEGIN_INFO, NULL, members_XrSessionBeginInfo)

SPEC(XrFrameWaitInfo, XR_TYPE_FRAME_WAIT_INFO, NULL, no_members)
SPEC(XrFrameState, XR_TYPE_FRAME_STATE, NULL, no_members)
SPEC(XrFrameBeginInfo, XR_TYPE_FRAME_BEGIN_INFO, NULL, no_members)
MEMBERS(XrFrameEndInfo) = {
    TIME(XrFrameEndInfo, displayTime),
    ENUM(XrFrameEndInfo, environmentBlendMode, XrEnvironmentBlendMode),
    LAYERS(XrFrameEndInfo, layers, layerCount, OPTIONAL),
    END,
};
SPEC(XrFrameEndInfo, XR_TYPE_FRAME_END_INFO, NULL, members_XrFrameEndInfo)

MEMBERS(XrViewLocateInfo) = {
    ENUM(XrViewLocateInfo, viewConfigurationType, XrViewConfigurationType),
    TIME(XrViewLocateInfo, displayTime),
    HANDLE(XrViewLocateInfo, space, SPACE, 0),
    END,
};
SPEC(XrViewLocateInfo, XR_TYPE_VIEW_LOCATE_INFO, NULL, members_XrViewLocateInfo)

SPEC(XrViewState, XR_TYPE_VIEW_STATE, NULL, no_members)
SPEC(XrView, XR_TYPE_VIEW, NULL, no_members)
MEMBERS(XrActionSetCreateInfo) = {
    CHARS(XrActionSetCreateInfo, actionSetName),
    CHARS(XrActionSetCreateInfo, localizedActionSetName),
    END,
};
SPEC(XrActionSetCreateInfo, XR_TYPE_ACTION_SET_CREATE_INFO, NULL, members_XrActionSetCreateInfo)

MEMBERS(XrActionCreateInfo) = {
    CHARS(XrActionCreateInfo, actionName),
    ENUM(XrActionCreateInfo, actionType, XrActionType),
    PATHS(XrActionCreateInfo, subactionPaths, countSubactionPaths, OPTIONAL),
    CHARS(XrActionCreateInfo, localizedActionName),
    END,
};
SPEC(XrActionCreateInfo, XR_TYPE_ACTION_CREATE_INFO, NULL, members_XrActionCreateInfo)

MEMBERS(XrActionSuggestedBinding) = {
    HANDLE(XrActionSuggestedBinding, action, ACTION, 0),
    PATH(XrActionSuggestedBinding, binding, 0),
    END,
};
SPEC(XrActionSuggestedBinding, 0, NULL, members_XrActionSuggestedBinding)

MEMBERS(XrInteractionProfileSuggestedBinding) = {
    PATH(XrInteractionProfileSuggestedBinding, interactionProfile, 0),
    STRUCTS(XrInteractionProfileSuggestedBinding, suggestedBindings, countSuggestedBindings,
            XrActionSuggestedBinding, 0),
    END,
};
SPEC(XrInteractionProfileSuggestedBinding, XR_TYPE_INTERACTION_PROFILE_SUGGESTED_BINDING, NULL,
     members_XrInteractionProfileSuggestedBinding)

MEMBERS(XrSessionActionSetsAttachInfo) = {
    HANDLES(XrSessionActionSetsAttachInfo, actionSets, countActionSets, ACTION_SET, 0),
    END,
};
SPEC(XrSessionActionSetsAttachInfo, XR_TYPE_SESSION_ACTION_SETS_ATTACH_INFO, NULL,
     members_XrSessionActionSetsAttachInfo)

SPEC(XrInteractionProfileState, XR_TYPE_INTERACTION_PROFILE_STATE, NULL, no_members)
MEMBERS(XrActionStateGetInfo) = {
    HANDLE(XrActionStateGetInfo, action, ACTION, 0),
    PATH(XrActionStateGetInfo, subactionPath, OPTIONAL),
    END,
};
SPEC(XrActionStateGetInfo, XR_TYPE_ACTION_STATE_GET_INFO, NULL, members_XrActionStateGetInfo)

SPEC(XrActionStateBoolean, XR_TYPE_ACTION_STATE_BOOLEAN, NULL, no_members)
SPEC(XrActionStateFloat, XR_TYPE_ACTION_STATE_FLOAT, NULL, no_members)
SPEC(XrActionStateVector2f, XR_TYPE_ACTION_STATE_VECTOR2F, NULL, no_members)
SPEC(XrActionStatePose, XR_TYPE_ACTION_STATE_POSE, NULL, no_members)
MEMBERS(XrActiveActionSet) = {
    HANDLE(XrActiveActionSet, actionSet, ACTION_SET, 0),
    PATH(XrActiveActionSet, subactionPath, OPTIONAL),
    END,
};
SPEC(XrActiveActionSet, 0, NULL, members_XrActiveActionSet)

MEMBERS(XrActionsSyncInfo) = {
    STRUCTS(XrActionsSyncInfo, activeActionSets, countActiveActionSets, XrActiveActionSet,
            OPTIONAL),
    END,
};
SPEC(XrActionsSyncInfo, XR_TYPE_ACTIONS_SYNC_INFO, NULL, members_XrActionsSyncInfo)

MEMBERS(XrBoundSourcesForActionEnumerateInfo) = {
    HANDLE(XrBoundSourcesForActionEnumerateInfo, action, ACTION, 0),
    END,
};
SPEC(XrBoundSourcesForActionEnumerateInfo, XR_TYPE_BOUND_SOURCES_FOR_ACTION_ENUMERATE_INFO, NULL,
     members_XrBoundSourcesForActionEnumerateInfo)

MEMBERS(XrInputSourceLocalizedNameGetInfo) = {
    PATH(XrInputSourceLocalizedNameGetInfo, sourcePath, 0),
    FLAGS(XrInputSourceLocalizedNameGetInfo, whichComponents, XrInputSourceLocalizedNameFlags, 0),
    END,
};
SPEC(XrInputSourceLocalizedNameGetInfo, XR_TYPE_INPUT_SOURCE_LOCALIZED_NAME_GET_INFO, NULL,
     members_XrInputSourceLocalizedNameGetInfo)

MEMBERS(XrHapticActionInfo) = {
    HANDLE(XrHapticActionInfo, action, ACTION, 0),
    PATH(XrHapticActionInfo, subactionPath, OPTIONAL),
    END,
};
SPEC(XrHapticActionInfo, XR_TYPE_HAPTIC_ACTION_INFO, NULL, members_XrHapticActionInfo)

MEMBERS(XrDebugUtilsObjectNameInfoEXT) = {
    ENUM(XrDebugUtilsObjectNameInfoEXT, objectType, XrObjectType),
    TEXT(XrDebugUtilsObjectNameInfoEXT, objectName, OPTIONAL),
    END,
};
SPEC(XrDebugUtilsObjectNameInfoEXT, XR_TYPE_DEBUG_UTILS_OBJECT_NAME_INFO_EXT, NULL,
     members_XrDebugUtilsObjectNameInfoEXT)

MEMBERS(XrDebugUtilsMessengerCreateInfoEXT) = {
    FLAGS(XrDebugUtilsMessengerCreateInfoEXT, messageSeverities,
          XrDebugUtilsMessageSeverityFlagsEXT, 0),
    FLAGS(XrDebugUtilsMessengerCreateInfoEXT, messageTypes, XrDebugUtilsMessageTypeFlagsEXT, 0),
    END,
};
SPEC(XrDebugUtilsMessengerCreateInfoEXT, XR_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT,
     "XrInstanceCreateInfo", members_XrDebugUtilsMessengerCreateInfoEXT)

MEMBERS(XrDebugUtilsLabelEXT) = {
    TEXT(XrDebugUtilsLabelEXT, labelName, 0),
    END,
};
SPEC(XrDebugUtilsLabelEXT, XR_TYPE_DEBUG_UTILS_LABEL_EXT, NULL, members_XrDebugUtilsLabelEXT)

MEMBERS(XrDebugUtilsMessengerCallbackDataEXT) = {
    TEXT(XrDebugUtilsMessengerCallbackDataEXT, messageId, OPTIONAL),
    TEXT(XrDebugUtilsMessengerCallbackDataEXT, functionName, OPTIONAL),
    TEXT(XrDebugUtilsMessengerCallbackDataEXT, message, 0),
    STRUCTS(XrDebugUtilsMessengerCallbackDataEXT, objects, objectCount,
            XrDebugUtilsObjectNameInfoEXT, OPTIONAL),
    STRUCTS(XrDebugUtilsMessengerCallbackDataEXT, sessionLabels, sessionLabelCount,
            XrDebugUtilsLabelEXT, OPTIONAL),
    END,
};
SPEC(XrDebugUtilsMessengerCallbackDataEXT, XR_TYPE_DEBUG_UTILS_MESSENGER_CALLBACK_DATA_EXT, NULL,
     members_XrDebugUtilsMessengerCallbackDataEXT)

SPEC(XrGraphicsRequirementsVulkanKHR, XR_TYPE_GRAPHICS_REQUIREMENTS_VULKAN_KHR, NULL, no_members)
MEMBERS(XrVisibilityMaskKHR) = {
    ITEMS(XrVisibilityMaskKHR, vertices, vertexCapacityInput, OPTIONAL),
    ITEMS(XrVisibilityMaskKHR, indices, indexCapacityInput, OPTIONAL),
    END,
};
SPEC(XrVisibilityMaskKHR, XR_TYPE_VISIBILITY_MASK_KHR, NULL, members_XrVisibilityMaskKHR)

MEMBERS(XrHandTrackerCreateInfoEXT) = {
    ENUM(XrHandTrackerCreateInfoEXT, hand, XrHandEXT),
    ENUM(XrHandTrackerCreateInfoEXT, handJointSet, XrHandJointSetEXT),
    END,
};
SPEC(XrHandTrackerCreateInfoEXT, XR_TYPE_HAND_TRACKER_CREATE_INFO_EXT, NULL,
     members_XrHandTrackerCreateInfoEXT)

MEMBERS(XrHandJointsLocateInfoEXT) = {
    HANDLE(XrHandJointsLocateInfoEXT, baseSpace, SPACE, 0),
    TIME(XrHandJointsLocateInfoEXT, time),
    END,
};
SPEC(XrHandJointsLocateInfoEXT, XR_TYPE_HAND_JOINTS_LOCATE_INFO_EXT, NULL,
     members_XrHandJointsLocateInfoEXT)

MEMBERS(XrHandJointLocationsEXT) = {
    ITEMS(XrHandJointLocationsEXT, jointLocations, jointCount, 0),
    END,
};
SPEC(XrHandJointLocationsEXT, XR_TYPE_HAND_JOINT_LOCATIONS_EXT, NULL,
     members_XrHandJointLocationsEXT)

MEMBERS(XrVulkanInstanceCreateInfoKHR) = {
    FLAGS(XrVulkanInstanceCreateInfoKHR, createFlags, XrVulkanInstanceCreateFlagsKHR, OPTIONAL),
    NOT_NULL(XrVulkanInstanceCreateInfoKHR, vulkanCreateInfo),
    END,
};
SPEC(XrVulkanInstanceCreateInfoKHR, XR_TYPE_VULKAN_INSTANCE_CREATE_INFO_KHR, NULL,
     members_XrVulkanInstanceCreateInfoKHR)

MEMBERS(XrVulkanDeviceCreateInfoKHR) = {
    FLAGS(XrVulkanDeviceCreateInfoKHR, createFlags, XrVulkanDeviceCreateFlagsKHR, OPTIONAL),
    NOT_NULL(XrVulkanDeviceCreateInfoKHR, vulkanCreateInfo),
    END,
};
SPEC(XrVulkanDeviceCreateInfoKHR, XR_TYPE_VULKAN_DEVICE_CREATE_INFO_KHR, NULL,
     members_XrVulkanDeviceCreateInfoKHR)

SPEC(XrVulkanGraphicsDeviceGetInfoKHR, XR_TYPE_VULKAN_GRAPHICS_DEVICE_GET_INFO_KHR, NULL,
     no_members)
MEMBERS(XrCompositionLayerCubeKHR) = {
    FLAGS(XrCompositionLayerCubeKHR, layerFlags, XrCompositionLayerFlags, OPTIONAL),
    HANDLE(XrCompositionLayerCubeKHR, space, SPACE, 0),
    ENUM(XrCompositionLayerCubeKHR, eyeVisibility, XrEyeVisibility),
    HANDLE(XrCompositionLayerCubeKHR, swapchain, SWAPCHAIN, 0),
    FLOATS(XrCompositionLayerCubeKHR, orientation, 4),
    END,
};
SPEC(XrCompositionLayerCubeKHR, XR_TYPE_COMPOSITION_LAYER_CUBE_KHR, NULL,
     members_XrCompositionLayerCubeKHR)

MEMBERS(XrSwapchainSubImage) = {
    NUMBER(XrSwapchainSubImage, imageRect.offset.x),
    NUMBER(XrSwapchainSubImage, imageRect.offset.y),
    NUMBER(XrSwapchainSubImage, imageRect.extent.width),
    NUMBER(XrSwapchainSubImage, imageRect.extent.height),
    NUMBER(XrSwapchainSubImage, imageArrayIndex),
    HANDLE(XrSwapchainSubImage, swapchain, SWAPCHAIN, 0),
    END,
};
SPEC(XrSwapchainSubImage, 0, NULL, members_XrSwapchainSubImage)

MEMBERS(XrCompositionLayerDepthInfoKHR) = {
    INSIDE(XrCompositionLayerDepthInfoKHR, subImage, XrSwapchainSubImage),
    FLOATS(XrCompositionLayerDepthInfoKHR, minDepth, 1),
    FLOATS(XrCompositionLayerDepthInfoKHR, maxDepth, 1),
    FLOATS(XrCompositionLayerDepthInfoKHR, nearZ, 1),
    FLOATS(XrCompositionLayerDepthInfoKHR, farZ, 1),
    END,
};
SPEC(XrCompositionLayerDepthInfoKHR, XR_TYPE_COMPOSITION_LAYER_DEPTH_INFO_KHR,
     "XrCompositionLayerProjectionView", members_XrCompositionLayerDepthInfoKHR)

MEMBERS(XrCompositionLayerCylinderKHR) = {
    FLAGS(XrCompositionLayerCylinderKHR, layerFlags, XrCompositionLayerFlags, OPTIONAL),
    HANDLE(XrCompositionLayerCylinderKHR, space, SPACE, 0),
    ENUM(XrCompositionLayerCylinderKHR, eyeVisibility, XrEyeVisibility),
    INSIDE(XrCompositionLayerCylinderKHR, subImage, XrSwapchainSubImage),
    POSE(XrCompositionLayerCylinderKHR, pose),
    FLOATS(XrCompositionLayerCylinderKHR, radius, 1),
    FLOATS(XrCompositionLayerCylinderKHR, centralAngle, 1),
    FLOATS(XrCompositionLayerCylinderKHR, aspectRatio, 1),
    END,
};
SPEC(XrCompositionLayerCylinderKHR, XR_TYPE_COMPOSITION_LAYER_CYLINDER_KHR, NULL,
     members_XrCompositionLayerCylinderKHR)

MEMBERS(XrCompositionLayerEquirectKHR) = {
    FLAGS(XrCompositionLayerEquirectKHR, layerFlags, XrCompositionLayerFlags, OPTIONAL),
    HANDLE(XrCompositionLayerEquirectKHR, space, SPACE, 0),
    ENUM(XrCompositionLayerEquirectKHR, eyeVisibility, XrEyeVisibility),
    INSIDE(XrCompositionLayerEquirectKHR, subImage, XrSwapchainSubImage),
    POSE(XrCompositionLayerEquirectKHR, pose),
    FLOATS(XrCompositionLayerEquirectKHR, radius, 1),
    FLOATS(XrCompositionLayerEquirectKHR, scale, 2),
    FLOATS(XrCompositionLayerEquirectKHR, bias, 2),
    END,
};
SPEC(XrCompositionLayerEquirectKHR, XR_TYPE_COMPOSITION_LAYER_EQUIRECT_KHR, NULL,
     members_XrCompositionLayerEquirectKHR)

MEMBERS(XrGraphicsBindingVulkanKHR) = {
    NUMBER(XrGraphicsBindingVulkanKHR, queueFamilyIndex),
    NUMBER(XrGraphicsBindingVulkanKHR, queueIndex),
    END,
};
SPEC(XrGraphicsBindingVulkanKHR, XR_TYPE_GRAPHICS_BINDING_VULKAN_KHR, "XrSessionCreateInfo",
     members_XrGraphicsBindingVulkanKHR)

SPEC(XrSwapchainImageVulkanKHR, XR_TYPE_SWAPCHAIN_IMAGE_VULKAN_KHR, NULL, no_members)
SPEC(XrSystemEyeGazeInteractionPropertiesEXT, XR_TYPE_SYSTEM_EYE_GAZE_INTERACTION_PROPERTIES_EXT,
     "XrSystemProperties", no_members)
SPEC(XrEyeGazeSampleTimeEXT, XR_TYPE_EYE_GAZE_SAMPLE_TIME_EXT, "XrSpaceLocation", no_members)
SPEC(XrEventDataVisibilityMaskChangedKHR, XR_TYPE_EVENT_DATA_VISIBILITY_MASK_CHANGED_KHR, NULL,
     no_members)
MEMBERS(XrCompositionLayerColorScaleBiasKHR) = {
    FLOATS(XrCompositionLayerColorScaleBiasKHR, colorScale, 4),
    FLOATS(XrCompositionLayerColorScaleBiasKHR, colorBias, 4),
    END,
};
SPEC(XrCompositionLayerColorScaleBiasKHR, XR_TYPE_COMPOSITION_LAYER_COLOR_SCALE_BIAS_KHR,
     "XrCompositionLayerBaseHeader", members_XrCompositionLayerColorScaleBiasKHR)

SPEC(XrViewConfigurationDepthRangeEXT, XR_TYPE_VIEW_CONFIGURATION_DEPTH_RANGE_EXT,
     "XrViewConfigurationView", no_members)
SPEC(XrSystemHandTrackingPropertiesEXT, XR_TYPE_SYSTEM_HAND_TRACKING_PROPERTIES_EXT,
     "XrSystemProperties", no_members)
SPEC(XrHandJointVelocitiesEXT, XR_TYPE_HAND_JOINT_VELOCITIES_EXT, "XrHandJointLocationsEXT",
     no_members)
SPEC(XrViewConfigurationViewFovEPIC, XR_TYPE_VIEW_CONFIGURATION_VIEW_FOV_EPIC,
     "XrViewConfigurationView", no_members)
MEMBERS(XrHandJointsMotionRangeInfoEXT) = {
    ENUM(XrHandJointsMotionRangeInfoEXT, handJointsMotionRange, XrHandJointsMotionRangeEXT),
    END,
};
SPEC(XrHandJointsMotionRangeInfoEXT, XR_TYPE_HAND_JOINTS_MOTION_RANGE_INFO_EXT,
     "XrHandJointsLocateInfoEXT", members_XrHandJointsMotionRangeInfoEXT)

MEMBERS(XrCompositionLayerEquirect2KHR) = {
    FLAGS(XrCompositionLayerEquirect2KHR, layerFlags, XrCompositionLayerFlags, OPTIONAL),
    HANDLE(XrCompositionLayerEquirect2KHR, space, SPACE, 0),
    ENUM(XrCompositionLayerEquirect2KHR, eyeVisibility, XrEyeVisibility),
    INSIDE(XrCompositionLayerEquirect2KHR, subImage, XrSwapchainSubImage),
    POSE(XrCompositionLayerEquirect2KHR, pose),
    FLOATS(XrCompositionLayerEquirect2KHR, radius, 1),
    FLOATS(XrCompositionLayerEquirect2KHR, centralHorizontalAngle, 1),
    FLOATS(XrCompositionLayerEquirect2KHR, upperVerticalAngle, 1),
    FLOATS(XrCompositionLayerEquirect2KHR, lowerVerticalAngle, 1),
    END,
};
SPEC(XrCompositionLayerEquirect2KHR, XR_TYPE_COMPOSITION_LAYER_EQUIRECT2_KHR, NULL,
     members_XrCompositionLayerEquirect2KHR)

SPEC(XrEventDataDisplayRefreshRateChangedFB, XR_TYPE_EVENT_DATA_DISPLAY_REFRESH_RATE_CHANGED_FB,
     NULL, no_members)
MEMBERS(XrCompositionLayerProjectionView) = {
    POSE(XrCompositionLayerProjectionView, pose),
    FOV(XrCompositionLayerProjectionView, fov),
    INSIDE(XrCompositionLayerProjectionView, subImage, XrSwapchainSubImage),
    END,
};
SPEC(XrCompositionLayerProjectionView, XR_TYPE_COMPOSITION_LAYER_PROJECTION_VIEW, NULL,
     members_XrCompositionLayerProjectionView)

MEMBERS(XrCompositionLayerProjection) = {
    FLAGS(XrCompositionLayerProjection, layerFlags, XrCompositionLayerFlags, OPTIONAL),
    HANDLE(XrCompositionLayerProjection, space, SPACE, 0),
    VIEWS(XrCompositionLayerProjection, views, viewCount, XrCompositionLayerProjectionView),
    END,
};
SPEC(XrCompositionLayerProjection, XR_TYPE_COMPOSITION_LAYER_PROJECTION, NULL,
     members_XrCompositionLayerProjection)

MEMBERS(XrCompositionLayerQuad) = {
    FLAGS(XrCompositionLayerQuad, layerFlags, XrCompositionLayerFlags, OPTIONAL),
    HANDLE(XrCompositionLayerQuad, space, SPACE, 0),
    ENUM(XrCompositionLayerQuad, eyeVisibility, XrEyeVisibility),
    INSIDE(XrCompositionLayerQuad, subImage, XrSwapchainSubImage),
    POSE(XrCompositionLayerQuad, pose),
    FLOATS(XrCompositionLayerQuad, size, 2),
    END,
};
SPEC(XrCompositionLayerQuad, XR_TYPE_COMPOSITION_LAYER_QUAD, NULL, members_XrCompositionLayerQuad)

MEMBERS(XrHapticVibration) = {
    FLOATS(XrHapticVibration, frequency, 1),
    FLOATS(XrHapticVibration, amplitude, 1),
    END,
};
SPEC(XrHapticVibration, XR_TYPE_HAPTIC_VIBRATION, NULL, members_XrHapticVibration)

SPEC(XrSpaceVelocity, XR_TYPE_SPACE_VELOCITY, "XrSpaceLocation", no_members)

MEMBERS(XrSpacesLocateInfo) = {
    HANDLE(XrSpacesLocateInfo, baseSpace, SPACE, 0),
    TIME(XrSpacesLocateInfo, time),
    HANDLES(XrSpacesLocateInfo, spaces, spaceCount, SPACE, 0),
    END,
};
SPEC(XrSpacesLocateInfo, XR_TYPE_SPACES_LOCATE_INFO, NULL, members_XrSpacesLocateInfo)
SPEC(XrSpaceLocations, XR_TYPE_SPACE_LOCATIONS, NULL, no_members)
SPEC(XrSpaceVelocities, XR_TYPE_SPACE_VELOCITIES, "XrSpaceLocations", no_members)

#define SPEC_OF(S) &sim_spec_##S,
static const struct sim_spec *const specs[] = {SIM_SPECS(SPEC_OF)};

const struct sim_spec *sim_spec_find(XrStructureType type) {
    for (size_t i = 0; i < sizeof specs / sizeof *specs; i++)
        if (specs[i]->type == type && type != XR_TYPE_UNKNOWN)
            return specs[i];
    return NULL;
}
