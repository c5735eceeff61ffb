#include "tests/memory.h"
#include "tests/sim_hmd/client.h"

#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// Memory that is not there, at the runtime's i-th wish for it, for every i of a short program's
// life. The answer is an error that the specification knows, nothing is left over (the leak
// checker looks), and a life with memory succeeds afterwards. The runtime is linked into the test
// (meson.build), so that what fails is its own and not a library's.

// ---- A program that goes home at the first error, as it should

enum { W = 64, H = 48, FRAMES = 3 };

#define TRY(call)                                                                                  \
    do {                                                                                           \
        XrResult result_ = call;                                                                   \
        if (result_ < 0)                                                                           \
            return result_;                                                                        \
    } while (0)

static atomic_long heard; // messages by messengers

struct life {
    struct client *gpu; // whose device; NULL: without graphics
    XrInstance instance;
    XrSystemId system;
    XrSession session;
    XrSwapchain swapchain;
    XrSpace stage;
    XrActionSet set;
    XrAction trigger, pose;
    XrPath left;
};

static XrBool32 XRAPI_CALL hear(XrDebugUtilsMessageSeverityFlagsEXT severity,
                                XrDebugUtilsMessageTypeFlagsEXT type,
                                const XrDebugUtilsMessengerCallbackDataEXT *data, void *user) {
    (void)severity;
    (void)type;
    (void)user;
    heard += data->message && data->message[0];
    return XR_FALSE;
}

static const XrDebugUtilsMessengerCreateInfoEXT hears_all = {
    .type = XR_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT,
    .messageSeverities = XR_DEBUG_UTILS_MESSAGE_SEVERITY_VERBOSE_BIT_EXT |
                         XR_DEBUG_UTILS_MESSAGE_SEVERITY_INFO_BIT_EXT |
                         XR_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT |
                         XR_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT,
    .messageTypes = XR_DEBUG_UTILS_MESSAGE_TYPE_GENERAL_BIT_EXT |
                    XR_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT |
                    XR_DEBUG_UTILS_MESSAGE_TYPE_PERFORMANCE_BIT_EXT,
    .userCallback = hear};

static XrResult make_instance(struct life *l) {
    const char *names[] = {XR_KHR_VULKAN_ENABLE2_EXTENSION_NAME, XR_MND_HEADLESS_EXTENSION_NAME,
                           XR_EXT_DEBUG_UTILS_EXTENSION_NAME, XR_EXT_HAND_TRACKING_EXTENSION_NAME};
    XrInstanceCreateInfo info = {
        .type = XR_TYPE_INSTANCE_CREATE_INFO,
        .next = &hears_all,
        .applicationInfo = {.applicationName = "test", .apiVersion = XR_MAKE_VERSION(1, 0, 0)},
        .enabledExtensionCount = 4,
        .enabledExtensionNames = names};
    TRY(xrCreateInstance(&info, &l->instance));
    XrSystemGetInfo system = {.type = XR_TYPE_SYSTEM_GET_INFO,
                              .formFactor = XR_FORM_FACTOR_HEAD_MOUNTED_DISPLAY};
    return xrGetSystem(l->instance, &system, &l->system);
}

static XrResult make_actions(struct life *l) {
    XrActionSetCreateInfo set = {.type = XR_TYPE_ACTION_SET_CREATE_INFO,
                                 .actionSetName = "a",
                                 .localizedActionSetName = "A"};
    TRY(xrCreateActionSet(l->instance, &set, &l->set));
    TRY(xrStringToPath(l->instance, "/user/hand/left", &l->left));
    XrActionCreateInfo action = {.type = XR_TYPE_ACTION_CREATE_INFO,
                                 .actionName = "t",
                                 .localizedActionName = "T",
                                 .actionType = XR_ACTION_TYPE_FLOAT_INPUT,
                                 .countSubactionPaths = 1,
                                 .subactionPaths = &l->left};
    TRY(xrCreateAction(l->set, &action, &l->trigger));
    strcpy(action.actionName, "p");
    strcpy(action.localizedActionName, "P");
    action.actionType = XR_ACTION_TYPE_POSE_INPUT;
    TRY(xrCreateAction(l->set, &action, &l->pose));
    XrActionSuggestedBinding b[2] = {{.action = l->trigger}, {.action = l->pose}};
    TRY(xrStringToPath(l->instance, "/user/hand/left/input/trigger/value", &b[0].binding));
    TRY(xrStringToPath(l->instance, "/user/hand/left/input/grip/pose", &b[1].binding));
    XrInteractionProfileSuggestedBinding s = {.type = XR_TYPE_INTERACTION_PROFILE_SUGGESTED_BINDING,
                                              .countSuggestedBindings = 2,
                                              .suggestedBindings = b};
    TRY(xrStringToPath(l->instance, "/interaction_profiles/oculus/touch_controller",
                       &s.interactionProfile));
    return xrSuggestInteractionProfileBindings(l->instance, &s);
}

#define PROC(l, name)                                                                              \
    PFN_##name name##_;                                                                            \
    TRY(xrGetInstanceProcAddr((l)->instance, #name, (PFN_xrVoidFunction *)&name##_))

static XrResult make_session(struct life *l) {
    XrGraphicsBindingVulkanKHR binding;
    XrSessionCreateInfo info = {.type = XR_TYPE_SESSION_CREATE_INFO, .systemId = l->system};
    if (l->gpu) {
        PROC(l, xrGetVulkanGraphicsRequirements2KHR);
        XrGraphicsRequirementsVulkanKHR needs = {.type = XR_TYPE_GRAPHICS_REQUIREMENTS_VULKAN_KHR};
        TRY(xrGetVulkanGraphicsRequirements2KHR_(l->instance, l->system, &needs));
        info = client_session_info(l->gpu, &binding);
    }
    TRY(xrCreateSession(l->instance, &info, &l->session));
    XrReferenceSpaceCreateInfo space = {.type = XR_TYPE_REFERENCE_SPACE_CREATE_INFO,
                                        .referenceSpaceType = XR_REFERENCE_SPACE_TYPE_STAGE,
                                        .poseInReferenceSpace.orientation.w = 1};
    TRY(xrCreateReferenceSpace(l->session, &space, &l->stage));
    XrSessionActionSetsAttachInfo attach = {.type = XR_TYPE_SESSION_ACTION_SETS_ATTACH_INFO,
                                            .countActionSets = 1,
                                            .actionSets = &l->set};
    TRY(xrAttachSessionActionSets(l->session, &attach));
    XrActionSpaceCreateInfo hand = {.type = XR_TYPE_ACTION_SPACE_CREATE_INFO,
                                    .action = l->pose,
                                    .poseInActionSpace.orientation.w = 1};
    XrSpace grip;
    TRY(xrCreateActionSpace(l->session, &hand, &grip));
    XrSessionBeginInfo begin = {.type = XR_TYPE_SESSION_BEGIN_INFO,
                                .primaryViewConfigurationType =
                                    XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO};
    return xrBeginSession(l->session, &begin);
}

static XrResult name_things(struct life *l) {
    PROC(l, xrSetDebugUtilsObjectNameEXT);
    PROC(l, xrSessionBeginDebugUtilsLabelRegionEXT);
    PROC(l, xrCreateHandTrackerEXT);
    PROC(l, xrCreateDebugUtilsMessengerEXT);
    PROC(l, xrSubmitDebugUtilsMessageEXT);
    XrDebugUtilsMessengerEXT messenger;
    TRY(xrCreateDebugUtilsMessengerEXT_(l->instance, &hears_all, &messenger));
    XrDebugUtilsMessengerCallbackDataEXT data = {
        .type = XR_TYPE_DEBUG_UTILS_MESSENGER_CALLBACK_DATA_EXT,
        .messageId = "a",
        .functionName = "b",
        .message = "words"};
    TRY(xrSubmitDebugUtilsMessageEXT_(l->instance, XR_DEBUG_UTILS_MESSAGE_SEVERITY_INFO_BIT_EXT,
                                      XR_DEBUG_UTILS_MESSAGE_TYPE_GENERAL_BIT_EXT, &data));
    XrDebugUtilsObjectNameInfoEXT name = {.type = XR_TYPE_DEBUG_UTILS_OBJECT_NAME_INFO_EXT,
                                          .objectType = XR_OBJECT_TYPE_SESSION,
                                          .objectHandle = (uint64_t)(uintptr_t)l->session,
                                          .objectName = "the session"};
    TRY(xrSetDebugUtilsObjectNameEXT_(l->instance, &name));
    XrDebugUtilsLabelEXT label = {.type = XR_TYPE_DEBUG_UTILS_LABEL_EXT, .labelName = "a part"};
    TRY(xrSessionBeginDebugUtilsLabelRegionEXT_(l->session, &label));
    XrHandTrackerCreateInfoEXT info = {.type = XR_TYPE_HAND_TRACKER_CREATE_INFO_EXT,
                                       .hand = XR_HAND_LEFT_EXT,
                                       .handJointSet = XR_HAND_JOINT_SET_DEFAULT_EXT};
    XrHandTrackerEXT tracker;
    return xrCreateHandTrackerEXT_(l->session, &info, &tracker);
}

static XrResult make_swapchain(struct life *l) {
    if (!l->gpu)
        return XR_SUCCESS;
    XrSwapchainCreateInfo info = {.type = XR_TYPE_SWAPCHAIN_CREATE_INFO,
                                  .usageFlags = XR_SWAPCHAIN_USAGE_COLOR_ATTACHMENT_BIT,
                                  .format = VK_FORMAT_R8G8B8A8_SRGB,
                                  .sampleCount = 1,
                                  .width = W,
                                  .height = H,
                                  .faceCount = 1,
                                  .arraySize = 2,
                                  .mipCount = 1};
    return xrCreateSwapchain(l->session, &info, &l->swapchain);
}

static XrResult end_frame(struct life *l, XrTime time) {
    XrFrameEndInfo end = {.type = XR_TYPE_FRAME_END_INFO,
                          .displayTime = time,
                          .environmentBlendMode = XR_ENVIRONMENT_BLEND_MODE_OPAQUE};
    if (!l->gpu)
        return xrEndFrame(l->session, &end);
    uint32_t index;
    XrSwapchainImageWaitInfo wait = {.type = XR_TYPE_SWAPCHAIN_IMAGE_WAIT_INFO};
    TRY(xrAcquireSwapchainImage(l->swapchain, NULL, &index));
    TRY(xrWaitSwapchainImage(l->swapchain, &wait));
    TRY(xrReleaseSwapchainImage(l->swapchain, NULL));
    XrViewLocateInfo info = {.type = XR_TYPE_VIEW_LOCATE_INFO,
                             .viewConfigurationType = XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO,
                             .displayTime = time,
                             .space = l->stage};
    XrViewState state = {.type = XR_TYPE_VIEW_STATE};
    XrView views[2] = {{.type = XR_TYPE_VIEW}, {.type = XR_TYPE_VIEW}};
    uint32_t count;
    TRY(xrLocateViews(l->session, &info, &state, 2, &count, views));
    XrCompositionLayerProjectionView shown[2];
    for (uint32_t eye = 0; eye < 2; eye++)
        shown[eye] =
            (XrCompositionLayerProjectionView){.type = XR_TYPE_COMPOSITION_LAYER_PROJECTION_VIEW,
                                               .pose = views[eye].pose,
                                               .fov = views[eye].fov,
                                               .subImage = {l->swapchain, {{0, 0}, {W, H}}, eye}};
    XrCompositionLayerProjection projection = {.type = XR_TYPE_COMPOSITION_LAYER_PROJECTION,
                                               .space = l->stage,
                                               .viewCount = 2,
                                               .views = shown};
    const XrCompositionLayerBaseHeader *layers[] = {(XrCompositionLayerBaseHeader *)&projection};
    end.layerCount = 1;
    end.layers = layers;
    return xrEndFrame(l->session, &end);
}

static XrResult run_frames(struct life *l) {
    for (int k = 0; k < FRAMES; k++) {
        XrFrameState frame = {.type = XR_TYPE_FRAME_STATE};
        XrActiveActionSet active = {.actionSet = l->set};
        XrActionsSyncInfo sync = {.type = XR_TYPE_ACTIONS_SYNC_INFO,
                                  .countActiveActionSets = 1,
                                  .activeActionSets = &active};
        TRY(xrWaitFrame(l->session, NULL, &frame));
        TRY(xrSyncActions(l->session, &sync));
        TRY(xrBeginFrame(l->session, NULL));
        TRY(end_frame(l, frame.predictedDisplayTime));
    }
    TRY(xrRequestExitSession(l->session));
    TRY(xrEndSession(l->session));
    return l->swapchain ? xrDestroySwapchain(l->swapchain) : XR_SUCCESS;
}

static XrResult live(struct client *gpu) {
    struct life l = {.gpu = gpu};
    static XrResult (*const parts[])(struct life *) = {make_instance, make_actions,   make_session,
                                                       name_things,   make_swapchain, run_frames};
    XrResult result = XR_SUCCESS;
    for (size_t k = 0; k < sizeof parts / sizeof *parts && result >= 0; k++)
        result = parts[k](&l);
    if (l.instance) // takes everything along; no error excuses it
        XR_OK(xrDestroyInstance(l.instance));
    return result;
}

// ---- The lives

static bool lawful(XrResult result) {
    return result == XR_ERROR_OUT_OF_MEMORY || result == XR_ERROR_LIMIT_REACHED ||
           result == XR_ERROR_RUNTIME_FAILURE || result == XR_ERROR_INITIALIZATION_FAILED ||
           result == XR_ERROR_SESSION_LOST || result == XR_SUCCESS;
}

static void try_every_wish(struct client *gpu, bool all) {
    int failures = 0;
    assert_int_equal(live(gpu), XR_SUCCESS);
    for (long i = 0;; i++) {
        memory_refuse(i, all);
        XrResult result = live(gpu);
        long refused = memory_allow();
        if (!lawful(result))
            fail_msg("wish %ld: result %d", i, result);
        failures += result < 0;
        assert_int_equal(live(gpu), XR_SUCCESS);
        if (!refused) {
            assert_int_equal(result, XR_SUCCESS);
            print_message("%ld wishes, %d programs went home, %ld messages\n", i, failures,
                          atomic_load(&heard));
            assert_true(failures > 10);
            assert_true(atomic_load(&heard) > i); // at least the one that is submitted
            return;
        }
    }
}

static void settings(const char *more) {
    char json[2048];
    snprintf(json, sizeof json,
             "{\"clock\": \"virtual\"%s, \"headset\": {\"name\": \"tiny\", \"refresh_hz\": 90, "
             "\"ipd_m\": 0.06, \"eyes\": {\"left\": {\"resolution_px\": [%d, %d], \"fov_rad\": "
             "{\"left\": -0.8, \"right\": 0.8, \"up\": 0.7, \"down\": -0.7}}, \"right\": "
             "{\"resolution_px\": [%d, %d], \"fov_rad\": {\"left\": -0.8, \"right\": 0.8, "
             "\"up\": 0.7, \"down\": -0.7}}}}}",
             more, W, H, W, H);
    client_settings(json);
}

static void without_graphics(void **state) {
    (void)state;
    settings("");
    try_every_wish(NULL, false);
    try_every_wish(NULL, true);
}

// The lint's own wishes too: its report and its findings. It answers with less, never with a crash.
static void with_the_lint(void **state) {
    (void)state;
    char strict[512];
    snprintf(strict, sizeof strict, ", \"strict\": true, \"strict_report\": \"%s/strict.jsonl\"",
             client_folder());
    settings(strict);
    try_every_wish(NULL, false);
    try_every_wish(NULL, true);
}

static void while_capturing(void **state) {
    (void)state;
    char capture[512];
    snprintf(capture, sizeof capture,
             ", \"capture\": {\"dir\": \"%s/c\", \"frames\": \"1:2\", \"layers\": true}",
             client_folder());
    settings(capture);
    struct client gpu = {0};
    client_make_instance(&gpu);
    client_make_device(&gpu);
    XR_OK(xrDestroyInstance(gpu.instance));
    gpu.instance = XR_NULL_HANDLE;
    try_every_wish(&gpu, false);
    try_every_wish(&gpu, true);
    client_stop(&gpu);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(without_graphics),
        cmocka_unit_test(with_the_lint),
        cmocka_unit_test(while_capturing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
