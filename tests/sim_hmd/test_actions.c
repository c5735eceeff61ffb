#include <math.h>
#include <stdio.h>
#include <string.h>

#define XR_EXTENSION_PROTOTYPES
#include "tests/sim_hmd/client.h"

// Actions as XR_EXT_conformance_automation drives them: profiles, bindings, priorities, spaces.
// Sessions without graphics on the virtual clock.

static PFN_xrSetInputDeviceActiveEXT set_active;
static PFN_xrSetInputDeviceStateBoolEXT set_bool;
static PFN_xrSetInputDeviceStateFloatEXT set_float;
static PFN_xrSetInputDeviceStateVector2fEXT set_vector;
static PFN_xrSetInputDeviceLocationEXT set_location;

static const char simple[] = "/interaction_profiles/khr/simple_controller";
static const char touch[] = "/interaction_profiles/oculus/touch_controller";

static XrPath path(const struct client *c, const char *text) {
    XrPath p = XR_NULL_PATH;
    XR_OK(xrStringToPath(c->instance, text, &p));
    return p;
}

static void start(struct client *c, const char *settings) {
    static const char *const extensions[] = {XR_MND_HEADLESS_EXTENSION_NAME,
                                             XR_EXT_CONFORMANCE_AUTOMATION_EXTENSION_NAME,
                                             "XR_EXT_palm_pose"};
    client_settings(settings ? settings : "{\"clock\": \"virtual\"}");
    client_extensions(extensions, 3);
    *c = (struct client){0};
    client_make_instance(c);
    *(void **)&set_active = client_proc(c->instance, "xrSetInputDeviceActiveEXT");
    *(void **)&set_bool = client_proc(c->instance, "xrSetInputDeviceStateBoolEXT");
    *(void **)&set_float = client_proc(c->instance, "xrSetInputDeviceStateFloatEXT");
    *(void **)&set_vector = client_proc(c->instance, "xrSetInputDeviceStateVector2fEXT");
    *(void **)&set_location = client_proc(c->instance, "xrSetInputDeviceLocationEXT");
    XrSessionCreateInfo info = {.type = XR_TYPE_SESSION_CREATE_INFO, .systemId = c->system};
    XR_OK(xrCreateSession(c->instance, &info, &c->session));
    XrSessionBeginInfo begin = {.type = XR_TYPE_SESSION_BEGIN_INFO};
    XR_OK(xrBeginSession(c->session, &begin));
    XrReferenceSpaceCreateInfo space = {.type = XR_TYPE_REFERENCE_SPACE_CREATE_INFO,
                                        .referenceSpaceType = XR_REFERENCE_SPACE_TYPE_STAGE,
                                        .poseInReferenceSpace.orientation.w = 1};
    XR_OK(xrCreateReferenceSpace(c->session, &space, &c->stage));
    client_wait(c);
}

static XrActionSet make_set(const struct client *c, const char *name, uint32_t priority) {
    XrActionSetCreateInfo info = {.type = XR_TYPE_ACTION_SET_CREATE_INFO, .priority = priority};
    strcpy(info.actionSetName, name);
    strcpy(info.localizedActionSetName, name);
    XrActionSet set = XR_NULL_HANDLE;
    XR_OK(xrCreateActionSet(c->instance, &info, &set));
    return set;
}

static XrAction make_action(const struct client *c, XrActionSet set, const char *name,
                            XrActionType type) {
    XrPath hands[2] = {path(c, "/user/hand/left"), path(c, "/user/hand/right")};
    XrActionCreateInfo info = {.type = XR_TYPE_ACTION_CREATE_INFO,
                               .actionType = type,
                               .countSubactionPaths = 2,
                               .subactionPaths = hands};
    strcpy(info.actionName, name);
    strcpy(info.localizedActionName, name);
    XrAction action = XR_NULL_HANDLE;
    XR_OK(xrCreateAction(set, &info, &action));
    return action;
}

struct binding {
    XrAction action;
    const char *path;
};

static void suggest(const struct client *c, const char *profile, const struct binding *list,
                    uint32_t count) {
    XrActionSuggestedBinding bindings[16];
    for (uint32_t i = 0; i < count; i++)
        bindings[i] = (XrActionSuggestedBinding){list[i].action, path(c, list[i].path)};
    XrInteractionProfileSuggestedBinding info = {.type =
                                                     XR_TYPE_INTERACTION_PROFILE_SUGGESTED_BINDING,
                                                 .interactionProfile = path(c, profile),
                                                 .countSuggestedBindings = count,
                                                 .suggestedBindings = bindings};
    XR_OK(xrSuggestInteractionProfileBindings(c->instance, &info));
}

static void attach(const struct client *c, const XrActionSet *sets, uint32_t count) {
    XrSessionActionSetsAttachInfo info = {.type = XR_TYPE_SESSION_ACTION_SETS_ATTACH_INFO,
                                          .countActionSets = count,
                                          .actionSets = sets};
    XR_OK(xrAttachSessionActionSets(c->session, &info));
}

static void sync(const struct client *c, const XrActiveActionSet *active, uint32_t count) {
    XrActionsSyncInfo info = {.type = XR_TYPE_ACTIONS_SYNC_INFO,
                              .countActiveActionSets = count,
                              .activeActionSets = active};
    XR_OK(xrSyncActions(c->session, &info));
}

static XrActionStateBoolean get_bool(const struct client *c, XrAction action, const char *hand) {
    XrActionStateGetInfo info = {.type = XR_TYPE_ACTION_STATE_GET_INFO,
                                 .action = action,
                                 .subactionPath = hand ? path(c, hand) : XR_NULL_PATH};
    XrActionStateBoolean s = {.type = XR_TYPE_ACTION_STATE_BOOLEAN};
    XR_OK(xrGetActionStateBoolean(c->session, &info, &s));
    return s;
}

static XrActionStateFloat get_float(const struct client *c, XrAction action) {
    XrActionStateGetInfo info = {.type = XR_TYPE_ACTION_STATE_GET_INFO, .action = action};
    XrActionStateFloat s = {.type = XR_TYPE_ACTION_STATE_FLOAT};
    XR_OK(xrGetActionStateFloat(c->session, &info, &s));
    return s;
}

static XrActionStateVector2f get_vector(const struct client *c, XrAction action) {
    XrActionStateGetInfo info = {.type = XR_TYPE_ACTION_STATE_GET_INFO, .action = action};
    XrActionStateVector2f s = {.type = XR_TYPE_ACTION_STATE_VECTOR2F};
    XR_OK(xrGetActionStateVector2f(c->session, &info, &s));
    return s;
}

static XrPath current(const struct client *c, const char *hand) {
    XrInteractionProfileState s = {.type = XR_TYPE_INTERACTION_PROFILE_STATE};
    XR_OK(xrGetCurrentInteractionProfile(c->session, path(c, hand), &s));
    return s.interactionProfile;
}

static int profile_events(const struct client *c) {
    int n = 0;
    XrEventDataBuffer event = {.type = XR_TYPE_EVENT_DATA_BUFFER};
    while (xrPollEvent(c->instance, &event) == XR_SUCCESS)
        n += event.type == XR_TYPE_EVENT_DATA_INTERACTION_PROFILE_CHANGED;
    return n;
}

static void profiles_change_in_sync_only(void **state) {
    (void)state;
    struct client c;
    start(&c, NULL);
    XrActionSet set = make_set(&c, "set", 0);
    XrAction click = make_action(&c, set, "click", XR_ACTION_TYPE_BOOLEAN_INPUT);
    suggest(&c, simple, &(struct binding){click, "/user/hand/left/input/select/click"}, 1);
    suggest(&c, touch, &(struct binding){click, "/user/hand/left/input/x/click"}, 1);
    attach(&c, &set, 1);
    XrActiveActionSet active = {.actionSet = set};
    assert_int_equal(current(&c, "/user/hand/left"), XR_NULL_PATH);
    sync(&c, &active, 1);
    assert_int_equal(current(&c, "/user/hand/left"), path(&c, touch));
    assert_int_equal(profile_events(&c), 1);
    sync(&c, &active, 1);
    assert_int_equal(profile_events(&c), 0); // nothing new
    XR_OK(set_active(c.session, path(&c, simple), path(&c, "/user/hand/left"), XR_TRUE));
    assert_int_equal(current(&c, "/user/hand/left"), path(&c, touch));
    sync(&c, &active, 1);
    assert_int_equal(current(&c, "/user/hand/left"), path(&c, simple));
    assert_int_equal(current(&c, "/user/hand/right"), path(&c, touch));
    assert_int_equal(profile_events(&c), 1);
    // A gamepad that nobody speaks of is not there.
    assert_int_equal(current(&c, "/user/gamepad"), XR_NULL_PATH);
    client_stop(&c);
}

static void settings_choose_the_controllers(void **state) {
    (void)state;
    struct client c;
    start(&c, "{\"clock\": \"virtual\", \"controllers\": "
              "\"/interaction_profiles/khr/simple_controller\"}");
    XrActionSet set = make_set(&c, "set", 0);
    XrAction click = make_action(&c, set, "click", XR_ACTION_TYPE_BOOLEAN_INPUT);
    suggest(&c, touch, &(struct binding){click, "/user/hand/left/input/x/click"}, 1);
    suggest(&c, simple, &(struct binding){click, "/user/hand/left/input/select/click"}, 1);
    attach(&c, &set, 1);
    sync(&c, &(XrActiveActionSet){.actionSet = set}, 1);
    assert_int_equal(current(&c, "/user/hand/left"), path(&c, simple));
    client_stop(&c);
}

static void a_device_that_is_off_is_inactive(void **state) {
    (void)state;
    struct client c;
    start(&c, NULL);
    XrActionSet set = make_set(&c, "set", 0);
    XrAction click = make_action(&c, set, "click", XR_ACTION_TYPE_BOOLEAN_INPUT);
    const struct binding list[] = {{click, "/user/hand/left/input/select/click"},
                                   {click, "/user/hand/right/input/select/click"}};
    suggest(&c, simple, list, 2);
    attach(&c, &set, 1);
    XrActiveActionSet active = {.actionSet = set};
    XrPath left = path(&c, "/user/hand/left"),
           button = path(&c, "/user/hand/left/input/select/click");
    XR_OK(set_active(c.session, path(&c, simple), left, XR_TRUE));
    XR_OK(set_bool(c.session, left, button, XR_TRUE));
    sync(&c, &active, 1);
    assert_true(get_bool(&c, click, "/user/hand/left").currentState);
    assert_false(get_bool(&c, click, "/user/hand/left").changedSinceLastSync); // it was not active
    XR_OK(set_active(c.session, path(&c, simple), left, XR_FALSE));
    assert_true(get_bool(&c, click, "/user/hand/left").isActive); // until the next sync
    sync(&c, &active, 1);
    XrActionStateBoolean s = get_bool(&c, click, "/user/hand/left");
    assert_false(s.isActive || s.currentState || s.changedSinceLastSync || s.lastChangeTime);
    assert_true(get_bool(&c, click, NULL).isActive); // the right hand
    XR_OK(set_active(c.session, path(&c, simple), left, XR_TRUE));
    XR_OK(set_bool(c.session, left, button, XR_FALSE));
    sync(&c, &active, 1);
    XR_OK(set_bool(c.session, left, button, XR_TRUE));
    sync(&c, &active, 1);
    s = get_bool(&c, click, "/user/hand/left");
    assert_true(s.currentState && s.changedSinceLastSync && s.lastChangeTime > 0);
    client_stop(&c);
}

static void values_are_converted_between_buttons_and_levers_only(void **state) {
    (void)state;
    struct client c;
    start(&c, NULL);
    XrActionSet set = make_set(&c, "set", 0);
    XrAction lever = make_action(&c, set, "lever", XR_ACTION_TYPE_FLOAT_INPUT);
    XrAction button = make_action(&c, set, "button", XR_ACTION_TYPE_BOOLEAN_INPUT);
    XrAction stick = make_action(&c, set, "stick", XR_ACTION_TYPE_VECTOR2F_INPUT);
    XrAction x = make_action(&c, set, "x", XR_ACTION_TYPE_FLOAT_INPUT);
    XrAction wrong = make_action(&c, set, "wrong", XR_ACTION_TYPE_BOOLEAN_INPUT);
    const struct binding list[] = {{lever, "/user/hand/left/input/x/click"},
                                   {button, "/user/hand/left/input/trigger/value"},
                                   {stick, "/user/hand/left/input/thumbstick"},
                                   {x, "/user/hand/left/input/thumbstick/x"},
                                   {wrong, "/user/hand/left/input/grip/pose"}};
    suggest(&c, touch, list, 5);
    attach(&c, &set, 1);
    XrActiveActionSet active = {.actionSet = set};
    XrPath left = path(&c, "/user/hand/left");
    XR_OK(set_active(c.session, path(&c, touch), left, XR_TRUE));
    XR_OK(set_bool(c.session, left, path(&c, list[0].path), XR_TRUE));
    XR_OK(set_float(c.session, left, path(&c, list[1].path), 0.75f));
    XR_OK(set_vector(c.session, left, path(&c, list[2].path), (XrVector2f){-0.5f, 0.25f}));
    sync(&c, &active, 1);
    assert_true(get_float(&c, lever).currentState == 1);
    assert_true(get_bool(&c, button, NULL).currentState);
    assert_true(get_vector(&c, stick).currentState.x == -0.5f);
    assert_true(get_float(&c, x).currentState == -0.5f); // the stick's own axis
    assert_false(get_bool(&c, wrong, NULL).isActive);
    XR_OK(set_float(c.session, left, path(&c, list[1].path), 0.25f));
    XR_OK(set_float(c.session, left, path(&c, list[3].path), 1));
    sync(&c, &active, 1);
    assert_false(get_bool(&c, button, NULL).currentState);
    XrVector2f v = get_vector(&c, stick).currentState;
    assert_true(v.x == 1 && v.y == 0.25f);
    client_stop(&c);
}

static void driving_is_checked(void **state) {
    (void)state;
    struct client c;
    start(&c, NULL);
    XrPath left = path(&c, "/user/hand/left"), t = path(&c, touch);
    XrPath trigger = path(&c, "/user/hand/left/input/trigger/value");
    XrPosef pose = {.orientation.w = 1};
    XR_IS(XR_ERROR_HANDLE_INVALID, set_active((XrSession)(uintptr_t)7, t, left, XR_TRUE));
    XR_IS(XR_ERROR_PATH_INVALID, set_active(c.session, (XrPath)12345, left, XR_TRUE));
    XR_IS(XR_ERROR_PATH_UNSUPPORTED, set_active(c.session, left, left, XR_TRUE));
    XR_IS(XR_ERROR_PATH_UNSUPPORTED, set_active(c.session, t, path(&c, "/user/gamepad"), XR_TRUE));
    XR_OK(set_active(c.session, t, left, XR_TRUE));
    XR_IS(XR_ERROR_PATH_UNSUPPORTED, set_bool(c.session, left, trigger, XR_TRUE)); // a lever
    XR_IS(XR_ERROR_PATH_UNSUPPORTED,
          set_bool(c.session, left, path(&c, "/user/hand/left/input/select/click"), XR_TRUE));
    XR_IS(XR_ERROR_PATH_UNSUPPORTED,
          set_float(c.session, path(&c, "/user/hand/right"), trigger, 1));
    XR_IS(XR_ERROR_VALIDATION_FAILURE, set_float(c.session, left, trigger, NAN));
    XrPath grip = path(&c, "/user/hand/left/input/grip/pose");
    XR_IS(XR_ERROR_HANDLE_INVALID,
          set_location(c.session, left, grip, (XrSpace)(uintptr_t)9, pose));
    XR_IS(XR_ERROR_PATH_UNSUPPORTED, set_location(c.session, left, trigger, c.stage, pose));
    pose.orientation.w = 0;
    XR_IS(XR_ERROR_POSE_INVALID, set_location(c.session, left, grip, c.stage, pose));
    client_stop(&c);
}

// OpenXR 11.4: the higher set has the input, but only of the hand that it is active for.
static void a_higher_set_takes_the_input(void **state) {
    (void)state;
    struct client c;
    start(&c, NULL);
    XrActionSet sets[2] = {make_set(&c, "high", 3), make_set(&c, "low", 2)};
    XrAction high = make_action(&c, sets[0], "high", XR_ACTION_TYPE_BOOLEAN_INPUT);
    XrAction low = make_action(&c, sets[1], "low", XR_ACTION_TYPE_BOOLEAN_INPUT);
    XrAction both = make_action(&c, sets[1], "both", XR_ACTION_TYPE_BOOLEAN_INPUT);
    const struct binding list[] = {
        {high, "/user/hand/left/input/select/click"}, {high, "/user/hand/right/input/select/click"},
        {low, "/user/hand/left/input/select/click"},  {low, "/user/hand/right/input/select/click"},
        {both, "/user/hand/left/input/select/click"}, {both, "/user/hand/left/input/menu/click"}};
    suggest(&c, simple, list, 6);
    attach(&c, sets, 2);
    XrPath left = path(&c, "/user/hand/left"), right = path(&c, "/user/hand/right");
    const XrActiveActionSet all[] = {{sets[0], XR_NULL_PATH}, {sets[1], XR_NULL_PATH}};
    sync(&c, all, 2);
    assert_true(get_bool(&c, high, NULL).isActive);
    assert_false(get_bool(&c, low, NULL).isActive);
    assert_true(get_bool(&c, both, NULL).isActive); // by its menu button
    const XrActiveActionSet some[] = {{sets[0], right}, {sets[1], left}, {sets[1], right}};
    sync(&c, some, 3);
    assert_true(get_bool(&c, low, "/user/hand/left").isActive);
    assert_false(get_bool(&c, low, "/user/hand/right").isActive);
    sync(&c, &all[1], 1);
    assert_true(get_bool(&c, low, NULL).isActive);
    assert_false(get_bool(&c, high, NULL).isActive);
    client_stop(&c);
}

static bool located(const struct client *c, XrSpace space, XrPosef *pose) {
    XrSpaceLocation at = {.type = XR_TYPE_SPACE_LOCATION};
    XR_OK(xrLocateSpace(space, c->stage, 1000000000, &at));
    *pose = at.pose;
    return at.locationFlags != 0;
}

static void an_action_space_keeps_the_hand_it_took(void **state) {
    (void)state;
    struct client c;
    start(&c, NULL);
    XrActionSet set = make_set(&c, "set", 0);
    XrAction grip = make_action(&c, set, "grip", XR_ACTION_TYPE_POSE_INPUT);
    const struct binding list[] = {{grip, "/user/hand/left/input/grip/pose"},
                                   {grip, "/user/hand/right/input/grip/pose"}};
    suggest(&c, simple, list, 2);
    attach(&c, &set, 1);
    XrActionSpaceCreateInfo info = {.type = XR_TYPE_ACTION_SPACE_CREATE_INFO,
                                    .action = grip,
                                    .poseInActionSpace.orientation.w = 1};
    XrSpace any, right;
    XR_OK(xrCreateActionSpace(c.session, &info, &any));
    info.subactionPath = path(&c, "/user/hand/right");
    XR_OK(xrCreateActionSpace(c.session, &info, &right));
    XrPosef pose;
    assert_false(located(&c, any, &pose)); // nothing was synchronised
    XrPath left = path(&c, "/user/hand/left"), s = path(&c, simple);
    XrActiveActionSet active = {.actionSet = set};
    XR_OK(set_location(c.session, left, path(&c, list[0].path), c.stage,
                       (XrPosef){.orientation.w = 1, .position = {1, 2, 3}}));
    sync(&c, &active, 1);
    assert_true(located(&c, any, &pose) && located(&c, right, &pose) && located(&c, any, &pose));
    assert_true(pose.position.x == 1 && pose.position.y == 2 && pose.position.z == 3);
    XR_OK(set_active(c.session, s, left, XR_FALSE));
    assert_false(located(&c, any, &pose)); // at once
    sync(&c, &active, 1);
    assert_false(located(&c, any, &pose)); // and it does not turn to the right hand
    XR_OK(set_active(c.session, s, left, XR_TRUE));
    assert_false(located(&c, any, &pose)); // not before the next sync
    sync(&c, &active, 1);
    assert_true(located(&c, any, &pose));
    XR_OK(xrDestroyAction(grip));
    const XrActiveActionSet hand = {set, left}; // the set still knows the hand
    sync(&c, &hand, 1);
    assert_true(located(&c, any, &pose) && located(&c, right, &pose));
    client_stop(&c);
}

// Off the handle to its outer side, fingers between the handle and the ray across it.
static void the_palm_lies_beside_the_handle(void **state) {
    (void)state;
    struct client c;
    start(&c, NULL);
    XrActionSet set = make_set(&c, "set", 0);
    XrAction grip = make_action(&c, set, "grip", XR_ACTION_TYPE_POSE_INPUT);
    XrAction palm = make_action(&c, set, "palm", XR_ACTION_TYPE_POSE_INPUT);
    const struct binding list[] = {{grip, "/user/hand/left/input/grip/pose"},
                                   {palm, "/user/hand/left/input/palm_ext/pose"},
                                   {grip, "/user/hand/right/input/grip/pose"},
                                   {palm, "/user/hand/right/input/palm_ext/pose"}};
    suggest(&c, simple, list, 4);
    attach(&c, &set, 1);
    sync(&c, &(XrActiveActionSet){.actionSet = set}, 1);
    for (int hand = 0; hand < 2; hand++) {
        XrActionSpaceCreateInfo info = {.type = XR_TYPE_ACTION_SPACE_CREATE_INFO,
                                        .action = grip,
                                        .subactionPath =
                                            path(&c, hand ? "/user/hand/right" : "/user/hand/left"),
                                        .poseInActionSpace.orientation.w = 1};
        XrSpace grip_space, palm_space;
        XR_OK(xrCreateActionSpace(c.session, &info, &grip_space));
        info.action = palm;
        XR_OK(xrCreateActionSpace(c.session, &info, &palm_space));
        sync(&c, &(XrActiveActionSet){.actionSet = set}, 1);
        XrSpaceLocation at = {.type = XR_TYPE_SPACE_LOCATION};
        XR_OK(xrLocateSpace(palm_space, grip_space, 1000000000, &at));
        assert_true(at.locationFlags & XR_SPACE_LOCATION_POSITION_VALID_BIT);
        assert_true(fabsf(at.pose.position.x - (hand ? 0.02f : -0.02f)) < 1e-6f);
        // -45 degrees about x.
        float sign = at.pose.orientation.w < 0 ? -1 : 1;
        assert_true(fabsf(sign * at.pose.orientation.x + 0.38268343f) < 1e-6f);
    }
    client_stop(&c);
}

static void attached_bindings_stay(void **state) {
    (void)state;
    struct client c;
    start(&c, NULL);
    XrActionSet first = make_set(&c, "first", 0), second = make_set(&c, "second", 0);
    XrAction click = make_action(&c, first, "click", XR_ACTION_TYPE_BOOLEAN_INPUT);
    XrAction other = make_action(&c, second, "other", XR_ACTION_TYPE_BOOLEAN_INPUT);
    suggest(&c, simple, &(struct binding){click, "/user/hand/left/input/select/click"}, 1);
    attach(&c, &first, 1);
    suggest(&c, simple, &(struct binding){other, "/user/hand/left/input/select/click"}, 1);
    sync(&c, &(XrActiveActionSet){.actionSet = first}, 1);
    assert_true(get_bool(&c, click, NULL).isActive);
    client_stop(&c);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(profiles_change_in_sync_only, client_teardown),
        cmocka_unit_test_teardown(settings_choose_the_controllers, client_teardown),
        cmocka_unit_test_teardown(a_device_that_is_off_is_inactive, client_teardown),
        cmocka_unit_test_teardown(values_are_converted_between_buttons_and_levers_only,
                                  client_teardown),
        cmocka_unit_test_teardown(driving_is_checked, client_teardown),
        cmocka_unit_test_teardown(a_higher_set_takes_the_input, client_teardown),
        cmocka_unit_test_teardown(an_action_space_keeps_the_hand_it_took, client_teardown),
        cmocka_unit_test_teardown(the_palm_lies_beside_the_handle, client_teardown),
        cmocka_unit_test_teardown(attached_bindings_stay, client_teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
