#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <dlfcn.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define XR_EXTENSION_PROTOTYPES
#include "sim_hmd/core/negotiate.h"
#include "sim_hmd/ext/newer.h"

// OpenXR 1.1 as a newer loader negotiates it; Debian's knows 1.0 only. This test is the loader.

static PFN_xrGetInstanceProcAddr get;
static XrInstance instance;

#define PROC(name)                                                                                 \
    PFN_##name name##_;                                                                            \
    assert_int_equal(get(instance, #name, (PFN_xrVoidFunction *)&name##_), XR_SUCCESS)

static XrVersion negotiate(XrVersion max) {
    char path[4096];
    const char *build = getenv("ANTIPODE_BUILD");
    assert_non_null(build);
    snprintf(path, sizeof path, "%s/sim_hmd/libopenxr_antipode.so", build);
    void *library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    if (!library)
        fail_msg("%s", dlerror());
    XrResult(XRAPI_PTR * shake)(const struct sim_loader_info *, struct sim_runtime_request *);
    *(void **)&shake = dlsym(library, "xrNegotiateLoaderRuntimeInterface");
    assert_non_null(shake);
    const struct sim_loader_info loader = {.structType = SIM_LOADER_INFO,
                                           .structVersion = 1,
                                           .structSize = sizeof loader,
                                           .minInterfaceVersion = 1,
                                           .maxInterfaceVersion = 1,
                                           .minApiVersion = XR_MAKE_VERSION(1, 0, 0),
                                           .maxApiVersion = max};
    struct sim_runtime_request request = {
        .structType = SIM_RUNTIME_REQUEST, .structVersion = 1, .structSize = sizeof request};
    assert_int_equal(shake(&loader, &request), XR_SUCCESS);
    get = request.getInstanceProcAddr;
    return request.runtimeApiVersion;
}

static void make_instance(XrVersion version) {
    static const char *const extensions[] = {XR_MND_HEADLESS_EXTENSION_NAME};
    XrInstanceCreateInfo info = {
        .type = XR_TYPE_INSTANCE_CREATE_INFO,
        .applicationInfo = {.applicationName = "test", .apiVersion = version},
        .enabledExtensionCount = 1,
        .enabledExtensionNames = extensions};
    unsetenv("ANTIPODE_SIM");
    instance = XR_NULL_HANDLE;
    PROC(xrCreateInstance);
    assert_int_equal(xrCreateInstance_(&info, &instance), XR_SUCCESS);
}

static XrSession make_session(void) {
    XrSystemGetInfo get_system = {.type = XR_TYPE_SYSTEM_GET_INFO,
                                  .formFactor = XR_FORM_FACTOR_HEAD_MOUNTED_DISPLAY};
    XrSessionCreateInfo info = {.type = XR_TYPE_SESSION_CREATE_INFO};
    XrSession session;
    PROC(xrGetSystem);
    PROC(xrCreateSession);
    assert_int_equal(xrGetSystem_(instance, &get_system, &info.systemId), XR_SUCCESS);
    assert_int_equal(xrCreateSession_(instance, &info, &session), XR_SUCCESS);
    return session;
}

static XrSpace make_space(XrSession session, XrReferenceSpaceType type, float x) {
    PROC(xrCreateReferenceSpace);
    XrReferenceSpaceCreateInfo info = {
        .type = XR_TYPE_REFERENCE_SPACE_CREATE_INFO,
        .referenceSpaceType = type,
        .poseInReferenceSpace = {.orientation.w = 1, .position.x = x}};
    XrSpace space = XR_NULL_HANDLE;
    assert_int_equal(xrCreateReferenceSpace_(session, &info, &space), XR_SUCCESS);
    return space;
}

static XrResult suggest(const char *profile, const char *binding) {
    static int count;
    PROC(xrStringToPath);
    PROC(xrCreateActionSet);
    PROC(xrCreateAction);
    PROC(xrSuggestInteractionProfileBindings);
    XrActionSetCreateInfo set_info = {.type = XR_TYPE_ACTION_SET_CREATE_INFO};
    sprintf(set_info.actionSetName, "set%d", count);
    sprintf(set_info.localizedActionSetName, "set%d", count++);
    XrActionCreateInfo action_info = {.type = XR_TYPE_ACTION_CREATE_INFO,
                                      .actionName = "a",
                                      .localizedActionName = "a",
                                      .actionType = XR_ACTION_TYPE_POSE_INPUT};
    XrActionSet set;
    XrActionSuggestedBinding suggested;
    XrInteractionProfileSuggestedBinding info = {.type =
                                                     XR_TYPE_INTERACTION_PROFILE_SUGGESTED_BINDING,
                                                 .countSuggestedBindings = 1,
                                                 .suggestedBindings = &suggested};
    assert_int_equal(xrCreateActionSet_(instance, &set_info, &set), XR_SUCCESS);
    assert_int_equal(xrCreateAction_(set, &action_info, &suggested.action), XR_SUCCESS);
    assert_int_equal(xrStringToPath_(instance, profile, &info.interactionProfile), XR_SUCCESS);
    assert_int_equal(xrStringToPath_(instance, binding, &suggested.binding), XR_SUCCESS);
    return xrSuggestInteractionProfileBindings_(instance, &info);
}

static const char touch[] = "/interaction_profiles/oculus/touch_controller";
static const char pro[] = "/interaction_profiles/meta/touch_pro_controller";

static void old_programs_see_1_0(void **state) {
    (void)state;
    assert_int_equal(XR_VERSION_MINOR(negotiate(XR_MAKE_VERSION(1, 0, 34))), 0);
    assert_int_equal(XR_VERSION_MINOR(negotiate(XR_MAKE_VERSION(1, 1, 0))), 1);
    make_instance(XR_MAKE_VERSION(1, 0, 0));
    PFN_xrVoidFunction f;
    assert_int_equal(get(instance, "xrLocateSpaces", &f), XR_ERROR_FUNCTION_UNSUPPORTED);
    assert_int_equal(suggest(touch, "/user/hand/left/input/grip_surface/pose"),
                     XR_ERROR_PATH_UNSUPPORTED);
    assert_int_equal(suggest(pro, "/user/hand/left/input/grip/pose"), XR_ERROR_PATH_UNSUPPORTED);
    uint32_t count;
    PROC(xrEnumerateReferenceSpaces);
    assert_int_equal(xrEnumerateReferenceSpaces_(make_session(), 0, &count, NULL), XR_SUCCESS);
    assert_int_equal(count, 3);
    PROC(xrDestroyInstance);
    assert_int_equal(xrDestroyInstance_(instance), XR_SUCCESS);
}

static void new_ones_see_1_1(void **state) {
    (void)state;
    negotiate(XR_MAKE_VERSION(1, 1, 0));
    make_instance(XR_MAKE_VERSION(1, 1, 0));
    assert_int_equal(suggest(touch, "/user/hand/left/input/grip_surface/pose"), XR_SUCCESS);
    assert_int_equal(suggest(pro, "/user/hand/left/input/grip/pose"), XR_SUCCESS);
    assert_int_equal(suggest(touch, "/user/hand/left/input/palm_ext/pose"),
                     XR_ERROR_PATH_UNSUPPORTED); // an extension's
    XrSession session = make_session();
    XrSpace spaces[] = {make_space(session, XR_REFERENCE_SPACE_TYPE_LOCAL_FLOOR_EXT, 1),
                        make_space(session, XR_REFERENCE_SPACE_TYPE_STAGE, 2)};
    PROC(xrLocateSpaces);
    XrSpaceLocationData found[2];
    XrSpaceVelocityData moving[2];
    XrSpaceVelocities velocities = {
        .type = XR_TYPE_SPACE_VELOCITIES, .velocityCount = 2, .velocities = moving};
    XrSpaceLocations locations = {.type = XR_TYPE_SPACE_LOCATIONS,
                                  .next = &velocities,
                                  .locationCount = 2,
                                  .locations = found};
    XrSpacesLocateInfo info = {.type = XR_TYPE_SPACES_LOCATE_INFO,
                               .baseSpace = make_space(session, XR_REFERENCE_SPACE_TYPE_STAGE, 0),
                               .time = 1000000000,
                               .spaceCount = 2,
                               .spaces = spaces};
    assert_int_equal(xrLocateSpaces_(session, &info, &locations), XR_SUCCESS);
    assert_true(found[0].locationFlags && found[1].locationFlags);
    assert_true(fabsf(found[0].pose.position.y) < 1e-6f && found[1].pose.position.x == 2);
    assert_true(moving[1].velocityFlags && moving[1].linearVelocity.x == 0);
    info.time = 0;
    assert_int_equal(xrLocateSpaces_(session, &info, &locations), XR_ERROR_TIME_INVALID);
    info.time = 1;
    locations.locationCount = 1;
    assert_int_equal(xrLocateSpaces_(session, &info, &locations), XR_ERROR_VALIDATION_FAILURE);
    locations.locationCount = 2;
    velocities.velocityCount = 3;
    assert_int_equal(xrLocateSpaces_(session, &info, &locations), XR_ERROR_VALIDATION_FAILURE);
    velocities.velocityCount = 2;
    spaces[1] = (XrSpace)(uintptr_t)77;
    assert_int_equal(xrLocateSpaces_(session, &info, &locations), XR_ERROR_HANDLE_INVALID);
    PROC(xrDestroyInstance);
    assert_int_equal(xrDestroyInstance_(instance), XR_SUCCESS);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(old_programs_see_1_0),
        cmocka_unit_test(new_ones_see_1_1),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
