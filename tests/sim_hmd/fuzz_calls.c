#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <string.h>

#include "tests/sim_hmd/fuzz_api.h"

// One function a call of the API, each with structures whose fields are right, at an edge or
// random.

#define CALL(name, ...)                                                                            \
    (fuzz_proc(#name) ? ((PFN_##name)fuzz_proc(#name))(__VA_ARGS__) : XR_ERROR_FUNCTION_UNSUPPORTED)
#define INSTANCE ((XrInstance)fuzz_handle(FUZZ_INSTANCE))
#define SESSION ((XrSession)fuzz_handle(FUZZ_SESSION))
#define SPACE ((XrSpace)fuzz_handle(FUZZ_SPACE))
#define SWAPCHAIN ((XrSwapchain)fuzz_handle(FUZZ_SWAPCHAIN))
#define ACTION_SET ((XrActionSet)fuzz_handle(FUZZ_ACTION_SET))
#define ACTION ((XrAction)fuzz_handle(FUZZ_ACTION))
#define MAYBE(pointer) (fuzz_tame || fuzz_chance(95) ? (pointer) : NULL)

static XrInstance instance;
static XrSession session;
static VkInstance vk_instance;
static VkPhysicalDevice vk_physical;
static VkDevice vk_device;
static _Atomic XrTime display_time = 1000000000;
// A second xrWaitFrame before the first's frame is begun waits for another thread, as it must; here
// nobody would come.
static atomic_bool frame_pending;
static pthread_mutex_t waiting = PTHREAD_MUTEX_INITIALIZER;
static XrPath paths[8];

static uint32_t capacity(uint32_t most) {
    return fuzz_chance(40) ? 0 : fuzz_below(most + 1);
}

static XrTime some_time(void) {
    return fuzz_tame || fuzz_chance(70) ? display_time : fuzz_i64();
}

static XrPath some_path(void) {
    return fuzz_chance(80) ? paths[fuzz_below(8)] : fuzz_u64();
}

static const char *const words[] = {"/user/hand/left",
                                    "/user/hand/right",
                                    "/interaction_profiles/khr/simple_controller",
                                    "/interaction_profiles/oculus/touch_controller",
                                    "/user/hand/left/input/grip/pose",
                                    "/user/hand/right/input/select/click",
                                    "/user/hand/left/output/haptic",
                                    "/user/hand/left/input/trigger/value",
                                    "",
                                    "/",
                                    "no path",
                                    "/UPPER//case/..",
                                    "a_good-name.1"};

static const char *some_word(void) {
    return words[fuzz_below(sizeof words / sizeof words[0])];
}

// --- system and session

static XrResult call_system(void) {
    XrSystemGetInfo get = {fuzz_type(XR_TYPE_SYSTEM_GET_INFO), fuzz_next(),
                           (XrFormFactor)fuzz_below(4)};
    XrSystemId id = 0;
    XrSystemProperties properties = {.type = fuzz_type(XR_TYPE_SYSTEM_PROPERTIES)};
    XrInstanceProperties about = {.type = fuzz_type(XR_TYPE_INSTANCE_PROPERTIES)};
    XrEnvironmentBlendMode modes[4];
    XrViewConfigurationType types[4];
    XrViewConfigurationView views[2] = {{.type = fuzz_type(XR_TYPE_VIEW_CONFIGURATION_VIEW)},
                                        {.type = XR_TYPE_VIEW_CONFIGURATION_VIEW}};
    XrViewConfigurationProperties config = {.type =
                                                fuzz_type(XR_TYPE_VIEW_CONFIGURATION_PROPERTIES)};
    uint32_t n = 0;
    XrSystemId system = fuzz_chance(85) ? 1 : fuzz_u64();
    XrViewConfigurationType type = (XrViewConfigurationType)(fuzz_chance(70) ? 2 : fuzz_u32());
    char text[XR_MAX_RESULT_STRING_SIZE];
    switch (fuzz_below(9)) {
    case 0:
        return CALL(xrGetSystem, INSTANCE, MAYBE(&get), MAYBE(&id));
    case 1:
        return CALL(xrGetSystemProperties, INSTANCE, system, MAYBE(&properties));
    case 2:
        return CALL(xrGetInstanceProperties, INSTANCE, MAYBE(&about));
    case 3:
        return CALL(xrEnumerateEnvironmentBlendModes, INSTANCE, system, type, capacity(4),
                    MAYBE(&n), modes);
    case 4:
        return CALL(xrEnumerateViewConfigurations, INSTANCE, system, capacity(4), MAYBE(&n), types);
    case 5:
        return CALL(xrEnumerateViewConfigurationViews, INSTANCE, system, type, capacity(2),
                    MAYBE(&n), views);
    case 6:
        return CALL(xrGetViewConfigurationProperties, INSTANCE, system, type, MAYBE(&config));
    case 7:
        return CALL(xrResultToString, INSTANCE, (XrResult)fuzz_u32(), text);
    default:
        return CALL(xrStructureTypeToString, INSTANCE, (XrStructureType)fuzz_u32(), text);
    }
}

static XrResult call_session(void) {
    XrSessionBeginInfo begin = {
        fuzz_type(XR_TYPE_SESSION_BEGIN_INFO), fuzz_next(),
        (XrViewConfigurationType)(fuzz_tame || fuzz_chance(90) ? 2 : fuzz_u32())};
    XrEventDataBuffer event = {.type = fuzz_type(XR_TYPE_EVENT_DATA_BUFFER)};
    XrReferenceSpaceType types[8];
    int64_t formats[32];
    XrExtent2Df bounds;
    uint32_t n = 0;
    switch (fuzz_below(12)) {
    case 0:
        return CALL(xrBeginSession, SESSION, MAYBE(&begin));
    case 1:
        return fuzz_chance(20) ? CALL(xrEndSession, SESSION) : XR_SUCCESS;
    case 2:
        return fuzz_chance(1) ? CALL(xrRequestExitSession, SESSION) : XR_SUCCESS;
    case 3:
        return CALL(xrEnumerateReferenceSpaces, SESSION, capacity(8), MAYBE(&n), types);
    case 4:
        return CALL(xrEnumerateSwapchainFormats, SESSION, capacity(32), MAYBE(&n), formats);
    case 5:
        return CALL(xrGetReferenceSpaceBoundsRect, SESSION, (XrReferenceSpaceType)fuzz_u32(),
                    MAYBE(&bounds));
    default:
        return CALL(xrPollEvent, INSTANCE, MAYBE(&event));
    }
}

// --- spaces

static XrResult call_space(void) {
    XrReferenceSpaceCreateInfo reference = {.type = fuzz_type(XR_TYPE_REFERENCE_SPACE_CREATE_INFO),
                                            .next = fuzz_next(),
                                            .referenceSpaceType = (XrReferenceSpaceType)fuzz_u32(),
                                            .poseInReferenceSpace = fuzz_pose()};
    XrActionSpaceCreateInfo action = {.type = fuzz_type(XR_TYPE_ACTION_SPACE_CREATE_INFO),
                                      .next = fuzz_next(),
                                      .action = ACTION,
                                      .subactionPath = some_path(),
                                      .poseInActionSpace = fuzz_pose()};
    XrSpaceVelocity velocity = {.type = fuzz_type(XR_TYPE_SPACE_VELOCITY)};
    XrSpaceLocation at = {.type = fuzz_type(XR_TYPE_SPACE_LOCATION),
                          .next = fuzz_chance(30) ? &velocity : NULL};
    XrViewLocateInfo locate = {
        .type = fuzz_type(XR_TYPE_VIEW_LOCATE_INFO),
        .next = fuzz_next(),
        .viewConfigurationType =
            (XrViewConfigurationType)(fuzz_tame || fuzz_chance(90) ? 2 : fuzz_u32()),
        .displayTime = some_time(),
        .space = SPACE};
    XrViewState state = {.type = fuzz_type(XR_TYPE_VIEW_STATE)};
    XrView views[2] = {{.type = fuzz_type(XR_TYPE_VIEW)}, {.type = XR_TYPE_VIEW}};
    XrSpace space = XR_NULL_HANDLE;
    uint32_t n = 0;
    XrResult r;
    switch (fuzz_below(6)) {
    case 0:
        r = CALL(xrCreateReferenceSpace, SESSION, MAYBE(&reference), MAYBE(&space));
        break;
    case 1:
        r = CALL(xrCreateActionSpace, SESSION, MAYBE(&action), MAYBE(&space));
        break;
    case 2:
        return fuzz_chance(30) ? CALL(xrDestroySpace, SPACE) : XR_SUCCESS;
    case 3:
        return CALL(xrLocateViews, SESSION, MAYBE(&locate), MAYBE(&state), capacity(2), MAYBE(&n),
                    views);
    default:
        return CALL(xrLocateSpace, SPACE, SPACE, some_time(), MAYBE(&at));
    }
    if (r == XR_SUCCESS)
        fuzz_set_first(FUZZ_SPACE, (uint64_t)space);
    return r;
}

// --- swapchains

static XrSwapchainCreateInfo swapchain_info(void) {
    static const int64_t formats[] = {VK_FORMAT_R8G8B8A8_SRGB,
                                      VK_FORMAT_B8G8R8A8_UNORM,
                                      VK_FORMAT_D32_SFLOAT,
                                      VK_FORMAT_R16G16B16A16_SFLOAT,
                                      0,
                                      -5};
    bool tame = fuzz_tame || fuzz_chance(80); // wild sizes may really be allocated
    return (XrSwapchainCreateInfo){.type = fuzz_type(XR_TYPE_SWAPCHAIN_CREATE_INFO),
                                   .next = fuzz_next(),
                                   .createFlags = tame || fuzz_chance(90) ? 0 : fuzz_below(8),
                                   .usageFlags = tame || fuzz_chance(80) ? 1 : fuzz_below(512),
                                   .format = formats[fuzz_below(fuzz_tame ? 2 : 6)],
                                   .sampleCount = tame ? 1 : fuzz_u32(),
                                   .width = tame ? 16 : fuzz_below(70000),
                                   .height = tame ? 16 : fuzz_below(3),
                                   .faceCount = tame ? 1 : fuzz_below(8),
                                   .arraySize = tame ? 1 + fuzz_below(2) : fuzz_below(5),
                                   .mipCount = tame ? 1 : fuzz_below(20)};
}

static XrResult call_swapchain(void) {
    XrSwapchainCreateInfo info = swapchain_info();
    XrSwapchainImageVulkanKHR images[8];
    for (int i = 0; i < 8; i++)
        images[i] =
            (XrSwapchainImageVulkanKHR){.type = fuzz_type(XR_TYPE_SWAPCHAIN_IMAGE_VULKAN_KHR)};
    XrSwapchainImageAcquireInfo acquire = {fuzz_type(XR_TYPE_SWAPCHAIN_IMAGE_ACQUIRE_INFO),
                                           fuzz_next()};
    XrSwapchainImageWaitInfo wait = {fuzz_type(XR_TYPE_SWAPCHAIN_IMAGE_WAIT_INFO), fuzz_next(),
                                     fuzz_chance(50) ? XR_INFINITE_DURATION : fuzz_i64() % 1000};
    XrSwapchainImageReleaseInfo release = {fuzz_type(XR_TYPE_SWAPCHAIN_IMAGE_RELEASE_INFO),
                                           fuzz_next()};
    XrSwapchain swapchain = XR_NULL_HANDLE;
    uint32_t n = 0;
    XrResult r;
    switch (fuzz_below(12)) {
    case 0:
        r = CALL(xrCreateSwapchain, SESSION, MAYBE(&info), MAYBE(&swapchain));
        if (r == XR_SUCCESS)
            fuzz_set_first(FUZZ_SWAPCHAIN, (uint64_t)swapchain);
        return r;
    case 1:
        return fuzz_chance(10) ? CALL(xrDestroySwapchain, SWAPCHAIN) : XR_SUCCESS;
    case 2:
        return CALL(xrEnumerateSwapchainImages, SWAPCHAIN, capacity(8), MAYBE(&n),
                    (XrSwapchainImageBaseHeader *)images);
    case 3:
    case 4:
    case 5:
        return CALL(xrAcquireSwapchainImage, SWAPCHAIN, MAYBE(&acquire), MAYBE(&n));
    case 6:
    case 7:
    case 8:
        return CALL(xrWaitSwapchainImage, SWAPCHAIN, MAYBE(&wait));
    default:
        return CALL(xrReleaseSwapchainImage, SWAPCHAIN, MAYBE(&release));
    }
}

// --- frames

static XrSwapchainSubImage sub_image(void) {
    bool tame = fuzz_tame || fuzz_chance(85);
    return (XrSwapchainSubImage){
        .swapchain = SWAPCHAIN,
        .imageRect = {.offset = {tame ? 0 : (int32_t)fuzz_i64(), tame ? 0 : (int32_t)fuzz_i64()},
                      .extent = {tame ? 16 : (int32_t)fuzz_i64(), tame ? 16 : (int32_t)fuzz_i64()}},
        .imageArrayIndex = tame ? 0 : fuzz_u32()};
}

static XrResult end_frame(void) {
    XrCompositionLayerProjectionView views[2];
    for (int i = 0; i < 2; i++)
        views[i] = (XrCompositionLayerProjectionView){
            .type = fuzz_type(XR_TYPE_COMPOSITION_LAYER_PROJECTION_VIEW),
            .next = fuzz_next(),
            .pose = fuzz_pose(),
            .fov = fuzz_fov(),
            .subImage = sub_image()};
    XrCompositionLayerProjection projection = {
        .type = fuzz_type(XR_TYPE_COMPOSITION_LAYER_PROJECTION),
        .next = fuzz_next(),
        .layerFlags = fuzz_below(fuzz_tame ? 8 : 16),
        .space = SPACE,
        .viewCount = fuzz_tame || fuzz_chance(90) ? 2 : fuzz_below(3),
        .views = MAYBE(views)};
    XrCompositionLayerQuad quad = {
        .type = fuzz_type(XR_TYPE_COMPOSITION_LAYER_QUAD),
        .next = fuzz_next(),
        .layerFlags = fuzz_below(fuzz_tame ? 8 : 16),
        .space = SPACE,
        .eyeVisibility = (XrEyeVisibility)fuzz_below(fuzz_tame ? 3 : 5),
        .subImage = sub_image(),
        .pose = fuzz_pose(),
        .size = {fuzz_tame ? 1 : fuzz_float(), fuzz_tame ? 1 : fuzz_float()}};
    const XrCompositionLayerBaseHeader *layers[3] = {
        MAYBE((XrCompositionLayerBaseHeader *)&projection),
        MAYBE((XrCompositionLayerBaseHeader *)&quad),
        MAYBE((XrCompositionLayerBaseHeader *)&projection)};
    XrFrameEndInfo end = {
        .type = fuzz_type(XR_TYPE_FRAME_END_INFO),
        .next = fuzz_next(),
        .displayTime = some_time(),
        .environmentBlendMode =
            (XrEnvironmentBlendMode)(fuzz_tame || fuzz_chance(90) ? 1 : fuzz_u32()),
        .layerCount = fuzz_below(4),
        .layers = MAYBE(layers)};
    return CALL(xrEndFrame, SESSION, MAYBE(&end));
}

static XrResult call_frame(void) {
    XrFrameWaitInfo wait = {fuzz_type(XR_TYPE_FRAME_WAIT_INFO), fuzz_next()};
    XrFrameState state = {.type = fuzz_type(XR_TYPE_FRAME_STATE)};
    XrFrameBeginInfo begin = {fuzz_type(XR_TYPE_FRAME_BEGIN_INFO), fuzz_next()};
    XrResult r;
    switch (fuzz_below(3)) {
    case 0:
        if (pthread_mutex_trylock(&waiting) != 0)
            return XR_SUCCESS;
        r = XR_SUCCESS;
        if (!frame_pending) {
            r = CALL(xrWaitFrame, SESSION, MAYBE(&wait), MAYBE(&state));
            if (r == XR_SUCCESS) {
                frame_pending = true;
                display_time = state.predictedDisplayTime;
            }
        }
        pthread_mutex_unlock(&waiting);
        return r;
    case 1:
        r = CALL(xrBeginFrame, SESSION, MAYBE(&begin));
        if (r >= 0)
            frame_pending = false;
        return r;
    default:
        return end_frame();
    }
}

// --- actions

static XrResult make_action(void) {
    XrPath subaction[3] = {some_path(), some_path(), some_path()};
    XrActionCreateInfo info = {.type = fuzz_type(XR_TYPE_ACTION_CREATE_INFO),
                               .next = fuzz_next(),
                               .actionType = (XrActionType)fuzz_below(101),
                               .countSubactionPaths = fuzz_below(4),
                               .subactionPaths = MAYBE(subaction)};
    if (fuzz_chance(60))
        info.actionType = (XrActionType)(1 + fuzz_below(4));
    snprintf(info.actionName, sizeof info.actionName, "%s%u",
             fuzz_chance(85) ? "action" : some_word(), fuzz_below(1000));
    snprintf(info.localizedActionName, sizeof info.localizedActionName, "%s%u",
             fuzz_chance(85) ? "Action" : some_word(), fuzz_below(1000));
    if (fuzz_chance(3))
        memset(info.actionName, 'x', sizeof info.actionName); // not terminated
    XrAction action = XR_NULL_HANDLE;
    XrResult r = CALL(xrCreateAction, ACTION_SET, MAYBE(&info), MAYBE(&action));
    if (r == XR_SUCCESS)
        fuzz_set_first(FUZZ_ACTION, (uint64_t)action);
    return r;
}

static XrResult make_set(void) {
    XrActionSetCreateInfo info = {.type = fuzz_type(XR_TYPE_ACTION_SET_CREATE_INFO),
                                  .next = fuzz_next(),
                                  .priority = fuzz_u32()};
    snprintf(info.actionSetName, sizeof info.actionSetName, "%s%u",
             fuzz_chance(85) ? "set" : some_word(), fuzz_below(1000));
    snprintf(info.localizedActionSetName, sizeof info.localizedActionSetName, "Set%u",
             fuzz_below(1000));
    XrActionSet set = XR_NULL_HANDLE;
    XrResult r = CALL(xrCreateActionSet, INSTANCE, MAYBE(&info), MAYBE(&set));
    if (r == XR_SUCCESS)
        fuzz_set_first(FUZZ_ACTION_SET, (uint64_t)set);
    return r;
}

static XrResult bind(void) {
    XrActionSuggestedBinding bindings[3];
    for (int i = 0; i < 3; i++)
        bindings[i] = (XrActionSuggestedBinding){ACTION, some_path()};
    XrInteractionProfileSuggestedBinding suggest = {
        .type = fuzz_type(XR_TYPE_INTERACTION_PROFILE_SUGGESTED_BINDING),
        .next = fuzz_next(),
        .interactionProfile = some_path(),
        .countSuggestedBindings = fuzz_below(4),
        .suggestedBindings = MAYBE(bindings)};
    XrActionSet sets[2] = {ACTION_SET, ACTION_SET};
    XrSessionActionSetsAttachInfo attach = {.type =
                                                fuzz_type(XR_TYPE_SESSION_ACTION_SETS_ATTACH_INFO),
                                            .next = fuzz_next(),
                                            .countActionSets = fuzz_below(3),
                                            .actionSets = MAYBE(sets)};
    switch (fuzz_below(3)) {
    case 0:
        return CALL(xrSuggestInteractionProfileBindings, INSTANCE, MAYBE(&suggest));
    case 1:
        return fuzz_chance(5) ? CALL(xrAttachSessionActionSets, SESSION, MAYBE(&attach))
                              : XR_SUCCESS;
    default:
        return fuzz_chance(10)   ? CALL(xrDestroyAction, ACTION)
               : fuzz_chance(10) ? CALL(xrDestroyActionSet, ACTION_SET)
                                 : XR_SUCCESS;
    }
}

static XrResult read_action(void) {
    XrActionStateGetInfo get = {fuzz_type(XR_TYPE_ACTION_STATE_GET_INFO), fuzz_next(), ACTION,
                                fuzz_chance(50) ? XR_NULL_PATH : some_path()};
    XrActionStateBoolean b = {.type = fuzz_type(XR_TYPE_ACTION_STATE_BOOLEAN)};
    XrActionStateFloat f = {.type = fuzz_type(XR_TYPE_ACTION_STATE_FLOAT)};
    XrActionStateVector2f v = {.type = fuzz_type(XR_TYPE_ACTION_STATE_VECTOR2F)};
    XrActionStatePose p = {.type = fuzz_type(XR_TYPE_ACTION_STATE_POSE)};
    XrActiveActionSet active[2] = {{ACTION_SET, fuzz_chance(80) ? XR_NULL_PATH : some_path()},
                                   {ACTION_SET, XR_NULL_PATH}};
    XrActionsSyncInfo sync = {fuzz_type(XR_TYPE_ACTIONS_SYNC_INFO), fuzz_next(), fuzz_below(3),
                              MAYBE(active)};
    switch (fuzz_below(5)) {
    case 0:
        return CALL(xrGetActionStateBoolean, SESSION, MAYBE(&get), MAYBE(&b));
    case 1:
        return CALL(xrGetActionStateFloat, SESSION, MAYBE(&get), MAYBE(&f));
    case 2:
        return CALL(xrGetActionStateVector2f, SESSION, MAYBE(&get), MAYBE(&v));
    case 3:
        return CALL(xrGetActionStatePose, SESSION, MAYBE(&get), MAYBE(&p));
    default:
        return CALL(xrSyncActions, SESSION, MAYBE(&sync));
    }
}

static XrResult feel_and_name(void) {
    XrHapticVibration pulse = {.type = fuzz_type(XR_TYPE_HAPTIC_VIBRATION),
                               .next = fuzz_next(),
                               .duration = fuzz_i64(),
                               .frequency = fuzz_float(),
                               .amplitude = fuzz_float()};
    XrHapticActionInfo haptic = {fuzz_type(XR_TYPE_HAPTIC_ACTION_INFO), fuzz_next(), ACTION,
                                 fuzz_chance(50) ? XR_NULL_PATH : some_path()};
    XrInteractionProfileState profile = {.type = fuzz_type(XR_TYPE_INTERACTION_PROFILE_STATE)};
    XrBoundSourcesForActionEnumerateInfo sources = {
        fuzz_type(XR_TYPE_BOUND_SOURCES_FOR_ACTION_ENUMERATE_INFO), fuzz_next(), ACTION};
    XrInputSourceLocalizedNameGetInfo name = {
        fuzz_type(XR_TYPE_INPUT_SOURCE_LOCALIZED_NAME_GET_INFO), fuzz_next(), some_path(),
        fuzz_below(16)};
    XrPath found[4], path = XR_NULL_PATH;
    char text[256];
    uint32_t n = 0;
    switch (fuzz_below(7)) {
    case 0:
        return CALL(xrApplyHapticFeedback, SESSION, MAYBE(&haptic),
                    MAYBE((XrHapticBaseHeader *)&pulse));
    case 1:
        return CALL(xrStopHapticFeedback, SESSION, MAYBE(&haptic));
    case 2:
        return CALL(xrGetCurrentInteractionProfile, SESSION, some_path(), MAYBE(&profile));
    case 3:
        return CALL(xrEnumerateBoundSourcesForAction, SESSION, MAYBE(&sources), capacity(4),
                    MAYBE(&n), found);
    case 4:
        return CALL(xrGetInputSourceLocalizedName, SESSION, MAYBE(&name), capacity(255), MAYBE(&n),
                    text);
    case 5:
        return CALL(xrStringToPath, INSTANCE, MAYBE(some_word()), MAYBE(&path));
    default:
        return CALL(xrPathToString, INSTANCE, some_path(), capacity(255), MAYBE(&n), text);
    }
}

// --- beginnings

static void make_device(void) {
    VkApplicationInfo app = {.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO,
                             .apiVersion = VK_API_VERSION_1_0};
    VkInstanceCreateInfo vk = {.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO,
                               .pApplicationInfo = &app};
    XrVulkanInstanceCreateInfoKHR make = {.type = XR_TYPE_VULKAN_INSTANCE_CREATE_INFO_KHR,
                                          .systemId = 1,
                                          .pfnGetInstanceProcAddr = vkGetInstanceProcAddr,
                                          .vulkanCreateInfo = &vk};
    XrGraphicsRequirementsVulkan2KHR needs = {.type = XR_TYPE_GRAPHICS_REQUIREMENTS_VULKAN2_KHR};
    VkResult result = VK_SUCCESS;
    CALL(xrGetVulkanGraphicsRequirements2KHR, instance, 1, &needs);
    CALL(xrCreateVulkanInstanceKHR, instance, &make, &vk_instance, &result);
    XrVulkanGraphicsDeviceGetInfoKHR get = {.type = XR_TYPE_VULKAN_GRAPHICS_DEVICE_GET_INFO_KHR,
                                            .systemId = 1,
                                            .vulkanInstance = vk_instance};
    if (!vk_instance || CALL(xrGetVulkanGraphicsDevice2KHR, instance, &get, &vk_physical))
        return;
    float priority = 1;
    VkDeviceQueueCreateInfo queue = {.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO,
                                     .queueCount = 1,
                                     .pQueuePriorities = &priority};
    VkDeviceCreateInfo device = {.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
                                 .queueCreateInfoCount = 1,
                                 .pQueueCreateInfos = &queue};
    XrVulkanDeviceCreateInfoKHR info = {.type = XR_TYPE_VULKAN_DEVICE_CREATE_INFO_KHR,
                                        .systemId = 1,
                                        .pfnGetInstanceProcAddr = vkGetInstanceProcAddr,
                                        .vulkanPhysicalDevice = vk_physical,
                                        .vulkanCreateInfo = &device};
    CALL(xrCreateVulkanDeviceKHR, instance, &info, &vk_device, &result);
}

bool fuzz_begin(void) {
    fuzz_end();
    const char *extension = XR_KHR_VULKAN_ENABLE2_EXTENSION_NAME;
    XrInstanceCreateInfo info = {
        .type = XR_TYPE_INSTANCE_CREATE_INFO,
        .applicationInfo = {.applicationName = "fuzz", .apiVersion = XR_MAKE_VERSION(1, 0, 0)},
        .enabledExtensionCount = 1,
        .enabledExtensionNames = &extension};
    if (CALL(xrCreateInstance, &info, &instance) != XR_SUCCESS)
        return false;
    fuzz_set_first(FUZZ_INSTANCE, (uint64_t)instance);
    make_device();
    if (!vk_device)
        return false;
    XrGraphicsBindingVulkanKHR binding = {.type = XR_TYPE_GRAPHICS_BINDING_VULKAN_KHR,
                                          .instance = vk_instance,
                                          .physicalDevice = vk_physical,
                                          .device = vk_device};
    XrSessionCreateInfo create = {
        .type = XR_TYPE_SESSION_CREATE_INFO, .next = &binding, .systemId = 1};
    if (CALL(xrCreateSession, instance, &create, &session) != XR_SUCCESS)
        return false;
    fuzz_set_first(FUZZ_SESSION, (uint64_t)session);
    for (int i = 0; i < 8; i++)
        CALL(xrStringToPath, instance, words[i], &paths[i]);
    display_time = 1000000000;
    return true;
}

void fuzz_end(void) {
    // Half of the time the session is left to its instance.
    if (session && fuzz_chance(50))
        CALL(xrDestroySession, session);
    if (instance)
        CALL(xrDestroyInstance, instance);
    if (vk_device)
        vkDestroyDevice(vk_device, NULL);
    if (vk_instance)
        vkDestroyInstance(vk_instance, NULL);
    instance = XR_NULL_HANDLE;
    session = XR_NULL_HANDLE;
    vk_device = VK_NULL_HANDLE;
    vk_instance = VK_NULL_HANDLE;
    frame_pending = false;
}

XrResult fuzz_call(void) {
    static XrResult (*const calls[])(void) = {
        call_system, call_session, call_space, call_swapchain, call_frame,  call_frame,
        call_frame,  make_action,  make_set,   bind,           read_action, feel_and_name};
    return calls[fuzz_below(sizeof calls / sizeof calls[0])]();
}
