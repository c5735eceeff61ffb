#include "tests/sim_hmd/report.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>

// The lint: a program that is wrong in as many ways as there are calls hears of each by its name.
// The functions are the runtime's own, past the loader, which would catch some of it. Frames and
// what is in them: test_strict_frames.c.

static void structures_are_told(void **unused) {
    (void)unused;
    struct client program = {0}, *c = &program;
    report_start(c);
    XrReferenceSpaceCreateInfo info = {.type = XR_TYPE_VIEW,
                                       .referenceSpaceType = XR_REFERENCE_SPACE_TYPE_LOCAL,
                                       .poseInReferenceSpace.orientation.w = 1};
    XrSpace space;
#define SPACE(result, statement)                                                                   \
    WRONG(result, RT(xrCreateReferenceSpace)(c->session, &info, &space), "xrCreateReferenceSpace", \
          statement)
    SPACE(XR_ERROR_VALIDATION_FAILURE, "VUID-XrReferenceSpaceCreateInfo-type-type");
    info.type = XR_TYPE_REFERENCE_SPACE_CREATE_INFO;
    XrBaseInStructure unknown = {.type = (XrStructureType)12345};
    info.next = &unknown;
    SPACE(XR_SUCCESS, "VUID-XrReferenceSpaceCreateInfo-next-next");
    info.next = NULL;
    info.referenceSpaceType = (XrReferenceSpaceType)99;
    SPACE(XR_ERROR_REFERENCE_SPACE_UNSUPPORTED,
          "VUID-XrReferenceSpaceCreateInfo-referenceSpaceType-parameter");
    info.referenceSpaceType = XR_REFERENCE_SPACE_TYPE_LOCAL;
    info.poseInReferenceSpace.orientation.w = 2;
    SPACE(XR_ERROR_POSE_INVALID,
          "XR_ERROR_POSE_INVALID: XrReferenceSpaceCreateInfo::poseInReferenceSpace");
    info.poseInReferenceSpace.orientation.w = 1.005f;
    SPACE(XR_SUCCESS, "USE-quaternion: XrReferenceSpaceCreateInfo::poseInReferenceSpace");
    info.poseInReferenceSpace.orientation.w = 1;
    info.poseInReferenceSpace.position.y = NAN;
    SPACE(XR_ERROR_POSE_INVALID,
          "Floating point: XrReferenceSpaceCreateInfo::poseInReferenceSpace is finite");
    WRONG(XR_ERROR_VALIDATION_FAILURE, RT(xrCreateReferenceSpace)(c->session, NULL, &space),
          "xrCreateReferenceSpace", "VUID-xrCreateReferenceSpace-createInfo-parameter");
    XrSpaceVelocity first = {.type = XR_TYPE_SPACE_VELOCITY}, second = first;
    first.next = &second;
    XrSpaceLocation at = {.type = XR_TYPE_SPACE_LOCATION, .next = &first};
    WRONG(XR_SUCCESS, RT(xrLocateSpace)(c->view, c->stage, 1000000000, &at), "xrLocateSpace",
          "VUID-XrSpaceLocation-next-unique");
    at.next = NULL;
    WRONG(XR_ERROR_TIME_INVALID, RT(xrLocateSpace)(c->view, c->stage, 0, &at), "xrLocateSpace",
          "XR_ERROR_TIME_INVALID: Time");
    WRONG(XR_ERROR_HANDLE_INVALID, RT(xrLocateSpace)(c->view, XR_NULL_HANDLE, 1, &at),
          "xrLocateSpace", "VUID-xrLocateSpace-baseSpace-parameter");
    WRONG(XR_ERROR_HANDLE_INVALID, RT(xrLocateSpace)((XrSpace)c->session, c->stage, 1, &at),
          "xrLocateSpace", "VUID-xrLocateSpace-space-parameter");
    XrExtent2Df bounds;
    WRONG(XR_ERROR_REFERENCE_SPACE_UNSUPPORTED,
          RT(xrGetReferenceSpaceBoundsRect)(c->session, (XrReferenceSpaceType)77, &bounds),
          "xrGetReferenceSpaceBoundsRect",
          "VUID-xrGetReferenceSpaceBoundsRect-referenceSpaceType-parameter");
    WRONG(XR_ERROR_VALIDATION_FAILURE,
          RT(xrGetReferenceSpaceBoundsRect)(c->session, XR_REFERENCE_SPACE_TYPE_STAGE, NULL),
          "xrGetReferenceSpaceBoundsRect", "VUID-xrGetReferenceSpaceBoundsRect-bounds-parameter");
    report_stop(c);
}

static void instance_calls_are_told(void **unused) {
    (void)unused;
    struct client program = {0}, *c = &program;
    report_start(c);
    XrSystemGetInfo get = {.type = XR_TYPE_SYSTEM_GET_INFO, .formFactor = (XrFormFactor)9};
    XrSystemId id;
    assert_true(RT(xrGetSystem)(c->instance, &get, &id) < 0);
    SAYS("xrGetSystem", "VUID-XrSystemGetInfo-formFactor-parameter");
    XrSystemProperties properties = {.type = XR_TYPE_SYSTEM_PROPERTIES};
    WRONG(XR_ERROR_SYSTEM_INVALID, RT(xrGetSystemProperties)(c->instance, 77, &properties),
          "xrGetSystemProperties", "XR_ERROR_SYSTEM_INVALID: Systems");
    properties.type = XR_TYPE_UNKNOWN;
    WRONG(XR_ERROR_VALIDATION_FAILURE,
          RT(xrGetSystemProperties)(c->instance, c->system, &properties), "xrGetSystemProperties",
          "VUID-XrSystemProperties-type-type");
    uint32_t n;
    WRONG(XR_ERROR_VIEW_CONFIGURATION_TYPE_UNSUPPORTED,
          RT(xrEnumerateEnvironmentBlendModes)(
              c->instance, c->system, XR_VIEW_CONFIGURATION_TYPE_PRIMARY_MONO, 0, &n, NULL),
          "xrEnumerateEnvironmentBlendModes", "XR_ERROR_VIEW_CONFIGURATION_TYPE_UNSUPPORTED: View");
    WRONG(XR_ERROR_VALIDATION_FAILURE,
          RT(xrEnumerateViewConfigurations)(c->instance, c->system, 0, NULL, NULL),
          "xrEnumerateViewConfigurations",
          "VUID-xrEnumerateViewConfigurations-viewConfigurationTypeCountOutput-parameter");
    WRONG(XR_ERROR_VALIDATION_FAILURE,
          RT(xrEnumerateViewConfigurations)(c->instance, c->system, 4, &n, NULL),
          "xrEnumerateViewConfigurations",
          "VUID-xrEnumerateViewConfigurations-viewConfigurationTypes-parameter");
    XrViewConfigurationView views[2] = {{.type = XR_TYPE_VIEW}};
    WRONG(XR_ERROR_VALIDATION_FAILURE,
          RT(xrEnumerateViewConfigurationViews)(
              c->instance, c->system, XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO, 2, &n, views),
          "xrEnumerateViewConfigurationViews", "VUID-XrViewConfigurationView-type-type");
    XrPath path;
    WRONG(XR_ERROR_PATH_FORMAT_INVALID, RT(xrStringToPath)(c->instance, "/Bad Path", &path),
          "xrStringToPath", "XR_ERROR_PATH_FORMAT_INVALID: Well-Formed Path Strings");
    WRONG(XR_ERROR_VALIDATION_FAILURE, RT(xrStringToPath)(c->instance, "/a", NULL),
          "xrStringToPath", "VUID-xrStringToPath-path-parameter");
    WRONG(XR_ERROR_PATH_INVALID, RT(xrPathToString)(c->instance, 4711, 0, &n, NULL),
          "xrPathToString", "XR_ERROR_PATH_INVALID: Path Atom Type");
    WRONG(XR_ERROR_VALIDATION_FAILURE, RT(xrResultToString)(c->instance, XR_SUCCESS, NULL),
          "xrResultToString", "VUID-xrResultToString-buffer-parameter");
    XrInstanceProperties about = {.type = XR_TYPE_INSTANCE_PROPERTIES};
    WRONG(XR_ERROR_HANDLE_INVALID, RT(xrGetInstanceProperties)((XrInstance)c->session, &about),
          "xrGetInstanceProperties", "VUID-xrGetInstanceProperties-instance-parameter");
    report_stop(c);
}

static void sessions_are_told(void **unused) {
    (void)unused;
    struct client program = {0}, *c = &program;
    report_settings();
    client_make_instance(c);
    XrSessionCreateInfo early = {.type = XR_TYPE_SESSION_CREATE_INFO, .systemId = c->system};
    XrGraphicsBindingVulkanKHR none = {.type = XR_TYPE_GRAPHICS_BINDING_VULKAN_KHR};
    XrSession session;
    WRONG(XR_ERROR_GRAPHICS_DEVICE_INVALID, RT(xrCreateSession)(c->instance, &early, &session),
          "xrCreateSession", "XR_ERROR_GRAPHICS_DEVICE_INVALID: Graphics API");
    early.next = &none;
    WRONG(XR_ERROR_GRAPHICS_REQUIREMENTS_CALL_MISSING,
          RT(xrCreateSession)(c->instance, &early, &session), "xrCreateSession",
          "XR_ERROR_GRAPHICS_REQUIREMENTS_CALL_MISSING: Graphics API");
    early.createFlags = 1;
    WRONG(XR_ERROR_VALIDATION_FAILURE, RT(xrCreateSession)(c->instance, &early, &session),
          "xrCreateSession", "VUID-XrSessionCreateInfo-createFlags-parameter");
    client_make_device(c);
    client_make_session(c);
    XrSessionBeginInfo begin = {.type = XR_TYPE_SESSION_BEGIN_INFO,
                                .primaryViewConfigurationType = (XrViewConfigurationType)50};
    WRONG(XR_ERROR_VIEW_CONFIGURATION_TYPE_UNSUPPORTED, RT(xrBeginSession)(c->session, &begin),
          "xrBeginSession", "VUID-XrSessionBeginInfo-primaryViewConfigurationType-parameter");
    XrFrameState f = {.type = XR_TYPE_FRAME_STATE};
    WRONG(XR_ERROR_SESSION_NOT_RUNNING, RT(xrWaitFrame)(c->session, NULL, &f), "xrWaitFrame",
          "XR_ERROR_SESSION_NOT_RUNNING: Session Lifecycle");
    begin.primaryViewConfigurationType = XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO;
    WRONG(XR_SUCCESS, RT(xrBeginSession)(c->session, &begin), "xrBeginSession",
          "USE-begin-before-ready");
    WRONG(XR_ERROR_SESSION_RUNNING, RT(xrBeginSession)(c->session, &begin), "xrBeginSession",
          "XR_ERROR_SESSION_RUNNING: Session Lifecycle");
    WRONG(XR_ERROR_SESSION_NOT_STOPPING, RT(xrEndSession)(c->session), "xrEndSession",
          "XR_ERROR_SESSION_NOT_STOPPING: Session Lifecycle");
    XR_OK(RT(xrRequestExitSession)(c->session));
    WRONG(XR_SUCCESS, RT(xrEndSession)(c->session), "xrEndSession", "USE-end-before-stopping");
    WRONG(XR_ERROR_SESSION_NOT_READY, RT(xrBeginSession)(c->session, &begin), "xrBeginSession",
          "XR_ERROR_SESSION_NOT_READY: Session Lifecycle");
    WRONG(XR_ERROR_HANDLE_INVALID, RT(xrEndSession)((XrSession)c->instance), "xrEndSession",
          "VUID-xrEndSession-session-parameter");
    report_stop(c);
}

static XrResult add_action(struct client *c, XrActionSet set, const char *name, const char *shown,
                           XrActionType type, XrAction *action) {
    XrActionCreateInfo info = {.type = XR_TYPE_ACTION_CREATE_INFO, .actionType = type};
    strcpy(info.actionName, name);
    strcpy(info.localizedActionName, shown);
    return RT(xrCreateAction)(set, &info, action);
}

static void names_are_told(void **unused) {
    (void)unused;
    struct client program = {0}, *c = &program;
    report_start(c);
    XrActionSetCreateInfo info = {.type = XR_TYPE_ACTION_SET_CREATE_INFO,
                                  .actionSetName = "set",
                                  .localizedActionSetName = "Set"};
    XrActionSet set, other;
    XrAction a;
    XR_OK(RT(xrCreateActionSet)(c->instance, &info, &set));
    SAYS_NOTHING();
#define SET(result, statement)                                                                     \
    WRONG(result, RT(xrCreateActionSet)(c->instance, &info, &other), "xrCreateActionSet", statement)
    SET(XR_ERROR_NAME_DUPLICATED, "XR_ERROR_NAME_DUPLICATED: Input");
    strcpy(info.actionSetName, "two");
    SET(XR_ERROR_LOCALIZED_NAME_DUPLICATED, "XR_ERROR_LOCALIZED_NAME_DUPLICATED: Input");
    strcpy(info.localizedActionSetName, "\xff");
    SET(XR_ERROR_LOCALIZED_NAME_INVALID, "XR_ERROR_LOCALIZED_NAME_INVALID: Input");
    strcpy(info.localizedActionSetName, "Two");
    strcpy(info.actionSetName, "Two!");
    SET(XR_ERROR_PATH_FORMAT_INVALID, "XR_ERROR_PATH_FORMAT_INVALID: Well-Formed");
    memset(info.actionSetName, 'a', sizeof info.actionSetName);
    SET(XR_ERROR_VALIDATION_FAILURE, "VUID-XrActionSetCreateInfo-actionSetName-parameter");
    WRONG(XR_ERROR_NAME_INVALID, add_action(c, set, "", "A", XR_ACTION_TYPE_FLOAT_INPUT, &a),
          "xrCreateAction", "XR_ERROR_NAME_INVALID: Input");
    WRONG(XR_ERROR_VALIDATION_FAILURE, add_action(c, set, "a", "A", (XrActionType)55, &a),
          "xrCreateAction", "VUID-XrActionCreateInfo-actionType-parameter");
    XrActionCreateInfo sub = {.type = XR_TYPE_ACTION_CREATE_INFO,
                              .actionType = XR_ACTION_TYPE_FLOAT_INPUT,
                              .actionName = "sub",
                              .localizedActionName = "Sub",
                              .countSubactionPaths = 1};
    WRONG(XR_ERROR_VALIDATION_FAILURE, RT(xrCreateAction)(set, &sub, &a), "xrCreateAction",
          "VUID-XrActionCreateInfo-subactionPaths-parameter");
    XrPath path = 999;
    sub.subactionPaths = &path;
    WRONG(XR_ERROR_PATH_INVALID, RT(xrCreateAction)(set, &sub, &a), "xrCreateAction",
          "XR_ERROR_PATH_INVALID: XrActionCreateInfo::subactionPaths");
    XR_OK(RT(xrStringToPath)(c->instance, "/user/foot", &path));
    WRONG(XR_ERROR_PATH_UNSUPPORTED, RT(xrCreateAction)(set, &sub, &a), "xrCreateAction",
          "XR_ERROR_PATH_UNSUPPORTED: Actions");
    report_stop(c);
}

static XrResult suggest(struct client *c, XrAction action, const char *text) {
    XrActionSuggestedBinding b = {.action = action};
    XrInteractionProfileSuggestedBinding info = {.type =
                                                     XR_TYPE_INTERACTION_PROFILE_SUGGESTED_BINDING,
                                                 .countSuggestedBindings = 1,
                                                 .suggestedBindings = &b};
    XR_OK(RT(xrStringToPath)(c->instance, "/interaction_profiles/khr/simple_controller",
                             &info.interactionProfile));
    XR_OK(RT(xrStringToPath)(c->instance, text, &b.binding));
    return RT(xrSuggestInteractionProfileBindings)(c->instance, &info);
}

static void haptics_and_names_are_told(struct client *c, XrAction buzz, XrPath hand) {
    XrHapticActionInfo haptic = {.type = XR_TYPE_HAPTIC_ACTION_INFO, .action = buzz};
    XrHapticVibration v = {.type = XR_TYPE_HAPTIC_VIBRATION, .amplitude = 2, .duration = -5};
    XrHapticBaseHeader *header = (XrHapticBaseHeader *)&v;
    RT(xrApplyHapticFeedback)(c->session, &haptic, header);
    SAYS("xrApplyHapticFeedback", "XrHapticVibration: amplitude is between 0 and 1");
    v.amplitude = 1;
    v.duration = -7;
    v.frequency = -1;
    RT(xrApplyHapticFeedback)(c->session, &haptic, header);
    SAYS("xrApplyHapticFeedback", "XrHapticVibration: frequency is not negative");
    WRONG(XR_ERROR_VALIDATION_FAILURE, RT(xrApplyHapticFeedback)(c->session, &haptic, NULL),
          "xrApplyHapticFeedback", "VUID-xrApplyHapticFeedback-hapticFeedback-parameter");
    XrInputSourceLocalizedNameGetInfo name = {.type = XR_TYPE_INPUT_SOURCE_LOCALIZED_NAME_GET_INFO,
                                              .sourcePath = hand};
    uint32_t n;
    WRONG(XR_ERROR_VALIDATION_FAILURE,
          RT(xrGetInputSourceLocalizedName)(c->session, &name, 0, &n, NULL),
          "xrGetInputSourceLocalizedName",
          "VUID-XrInputSourceLocalizedNameGetInfo-whichComponents-requiredbitmask");
}

static void actions_are_told(void **unused) {
    (void)unused;
    struct client program = {0}, *c = &program;
    report_start(c);
    XrActionSetCreateInfo info = {.type = XR_TYPE_ACTION_SET_CREATE_INFO,
                                  .actionSetName = "set",
                                  .localizedActionSetName = "Set"};
    XrActionSet set;
    XrAction click, buzz, idle;
    XR_OK(RT(xrCreateActionSet)(c->instance, &info, &set));
    XR_OK(add_action(c, set, "click", "Click", XR_ACTION_TYPE_BOOLEAN_INPUT, &click));
    XR_OK(add_action(c, set, "buzz", "Buzz", XR_ACTION_TYPE_VIBRATION_OUTPUT, &buzz));
    XR_OK(add_action(c, set, "idle", "Idle", XR_ACTION_TYPE_FLOAT_INPUT, &idle));
    static const char select[] = "/user/hand/left/input/select/click";
    WRONG(XR_ERROR_PATH_UNSUPPORTED, suggest(c, click, "/user/hand/left/input/nose/click"),
          "xrSuggestInteractionProfileBindings", "XR_ERROR_PATH_UNSUPPORTED: Interaction Profile");
    WRONG(XR_ERROR_HANDLE_INVALID, suggest(c, XR_NULL_HANDLE, select),
          "xrSuggestInteractionProfileBindings", "VUID-XrActionSuggestedBinding-action-parameter");
    XR_OK(suggest(c, click, select));
    assert_true(
        RT(xrSyncActions)(c->session, &(XrActionsSyncInfo){.type = XR_TYPE_ACTIONS_SYNC_INFO}));
    SAYS("xrSyncActions", "USE-sync-unattached");
    XrActiveActionSet active = {.actionSet = set};
    XrActionsSyncInfo sync = {
        .type = XR_TYPE_ACTIONS_SYNC_INFO, .countActiveActionSets = 1, .activeActionSets = &active};
    WRONG(XR_ERROR_ACTIONSET_NOT_ATTACHED, RT(xrSyncActions)(c->session, &sync), "xrSyncActions",
          "XR_ERROR_ACTIONSET_NOT_ATTACHED: Action Sets");
    XrSessionActionSetsAttachInfo attach = {.type = XR_TYPE_SESSION_ACTION_SETS_ATTACH_INFO};
    WRONG(XR_ERROR_VALIDATION_FAILURE, RT(xrAttachSessionActionSets)(c->session, &attach),
          "xrAttachSessionActionSets", "VUID-XrSessionActionSetsAttachInfo-actionSets-arraylength");
    attach.countActionSets = 1;
    attach.actionSets = &set;
    WRONG(XR_SUCCESS, RT(xrAttachSessionActionSets)(c->session, &attach),
          "xrAttachSessionActionSets", "USE-action-unbound");
    WRONG(XR_ERROR_ACTIONSETS_ALREADY_ATTACHED, RT(xrAttachSessionActionSets)(c->session, &attach),
          "xrAttachSessionActionSets", "XR_ERROR_ACTIONSETS_ALREADY_ATTACHED: Action Sets");
    WRONG(XR_ERROR_ACTIONSETS_ALREADY_ATTACHED, suggest(c, click, select),
          "xrSuggestInteractionProfileBindings",
          "XR_ERROR_ACTIONSETS_ALREADY_ATTACHED: Action Sets: bindings");
    XrAction late;
    WRONG(XR_ERROR_ACTIONSETS_ALREADY_ATTACHED,
          add_action(c, set, "late", "Late", XR_ACTION_TYPE_FLOAT_INPUT, &late), "xrCreateAction",
          "XR_ERROR_ACTIONSETS_ALREADY_ATTACHED: Action Sets: immutable");
    XrActionStateGetInfo get = {.type = XR_TYPE_ACTION_STATE_GET_INFO, .action = click};
    XrActionStateBoolean b = {.type = XR_TYPE_ACTION_STATE_BOOLEAN};
    XrActionStateFloat x = {.type = XR_TYPE_ACTION_STATE_FLOAT};
    WRONG(XR_SUCCESS, RT(xrGetActionStateBoolean)(c->session, &get, &b), "xrGetActionStateBoolean",
          "USE-actions-never-synced");
    sync.activeActionSets = NULL;
    WRONG(XR_ERROR_VALIDATION_FAILURE, RT(xrSyncActions)(c->session, &sync), "xrSyncActions",
          "VUID-XrActionsSyncInfo-activeActionSets-parameter");
    sync.activeActionSets = &active;
    assert_true(RT(xrSyncActions)(c->session, &sync) >= 0);
    SAYS_NOTHING();
    WRONG(XR_ERROR_ACTION_TYPE_MISMATCH, RT(xrGetActionStateFloat)(c->session, &get, &x),
          "xrGetActionStateFloat", "XR_ERROR_ACTION_TYPE_MISMATCH: Actions");
    XR_OK(RT(xrStringToPath)(c->instance, "/user/hand/left", &get.subactionPath));
    WRONG(XR_ERROR_PATH_UNSUPPORTED, RT(xrGetActionStateBoolean)(c->session, &get, &b),
          "xrGetActionStateBoolean", "XR_ERROR_PATH_UNSUPPORTED: Actions");
    get.action = XR_NULL_HANDLE;
    WRONG(XR_ERROR_HANDLE_INVALID, RT(xrGetActionStateBoolean)(c->session, &get, &b),
          "xrGetActionStateBoolean", "VUID-XrActionStateGetInfo-action-parameter");
    haptics_and_names_are_told(c, buzz, get.subactionPath);
    report_stop(c);
}

static void extensions_not_enabled_are_told(void **unused) {
    (void)unused;
    struct client program = {0}, *c = &program;
    report_start(c);
    PFN_xrVoidFunction f;
    PFN_xrGetInstanceProcAddr get =
        (PFN_xrGetInstanceProcAddr)(uintptr_t)client_proc(c->instance, "xrGetInstanceProcAddr");
    assert_true(get(c->instance, "xrConvertTimeToTimespecTimeKHR", &f) < 0);
    XrGraphicsBindingVulkanKHR binding;
    XrSessionCreateInfo info = client_session_info(c, &binding);
    XrHandJointsMotionRangeInfoEXT range = {.type = XR_TYPE_HAND_JOINTS_MOTION_RANGE_INFO_EXT};
    XrSession session;
    binding.next = &range;
    assert_true(RT(xrCreateSession)(c->instance, &info, &session) < 0);
    SAYS("xrCreateSession", "VUID-XrSessionCreateInfo-next-next");
    // A next that was never set is told, not followed.
    XrFrameState state = {.type = XR_TYPE_FRAME_STATE, .next = (void *)(uintptr_t)0xdeadbeef0};
    WRONG(XR_SUCCESS, RT(xrWaitFrame)(c->session, NULL, &state), "xrWaitFrame",
          "VUID-XrFrameState-next-next");
    report_stop(c);
}

// Two instances, one report: its last line is the verdict on both.
static void a_report_is_summed_up(void **unused) {
    (void)unused;
    report_settings();
    for (int k = 1; k <= 2; k++) {
        struct client program = {0}, *c = &program;
        client_make_instance(c);
        XrPath path;
        XR_IS(XR_ERROR_PATH_FORMAT_INVALID, RT(xrStringToPath)(c->instance, "x", &path));
        client_stop(c);
        char expected[64];
        snprintf(expected, sizeof expected, "{\"errors\":%d,\"warnings\":0,\"notes\":0}", k);
        assert_non_null(strstr(report_news(), expected));
    }
}

// A report that may not grow: the program lives, and so does the lint. No SIGXFSZ.
static void a_full_report_ends_nobody(void **unused) {
    (void)unused;
    struct client client = {0}, *c = &client;
    struct rlimit old, small;
    report_settings();
    getrlimit(RLIMIT_FSIZE, &old);
    small = old;
    small.rlim_cur = 100; // bytes
    setrlimit(RLIMIT_FSIZE, &small);
    client_make_instance(c);
    XrPath path;
    for (int k = 0; k < 3; k++)
        XR_IS(XR_ERROR_PATH_FORMAT_INVALID, RT(xrStringToPath)(c->instance, "x", &path));
    client_stop(c);
    setrlimit(RLIMIT_FSIZE, &old);
    struct stat report;
    assert_int_equal(stat(report_path, &report), 0);
    assert_int_equal(report.st_size, 100);
}

static int enough_statements(void **unused) {
    (void)unused;
    printf("%d wrong uses told by name\n", report_statements);
    return report_statements >= 55 ? 0 : 1;
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(structures_are_told, client_teardown),
        cmocka_unit_test_teardown(instance_calls_are_told, client_teardown),
        cmocka_unit_test_teardown(sessions_are_told, client_teardown),
        cmocka_unit_test_teardown(names_are_told, client_teardown),
        cmocka_unit_test_teardown(actions_are_told, client_teardown),
        cmocka_unit_test_teardown(extensions_not_enabled_are_told, client_teardown),
        cmocka_unit_test_teardown(a_report_is_summed_up, client_teardown),
        cmocka_unit_test_teardown(a_full_report_ends_nobody, client_teardown),
    };
    return cmocka_run_group_tests(tests, NULL, enough_statements);
}
