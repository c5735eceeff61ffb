#include "tests/sim_hmd/report.h"

#include <math.h>
#include <stdio.h>

// The lint on functions of extensions, of those above all whose arguments are no integers: numbers,
// vectors and poses by value.

static const char *const extensions[] = {XR_FB_DISPLAY_REFRESH_RATE_EXTENSION_NAME,
                                         XR_EXT_CONFORMANCE_AUTOMATION_EXTENSION_NAME};

static XrPath path(struct client *c, const char *text) {
    XrPath p = XR_NULL_PATH;
    XR_OK(RT(xrStringToPath)(c->instance, text, &p));
    return p;
}

static void begin(struct client *c) {
    client_extensions(extensions, 2);
    report_start(c);
}

static void refresh_rates_are_told(void **unused) {
    (void)unused;
    struct client program = {0}, *c = &program;
    begin(c);
    float rate = 0;
    XR_OK(RT(xrRequestDisplayRefreshRateFB)(c->session, 72.0f));
    XR_OK(RT(xrGetDisplayRefreshRateFB)(c->session, &rate));
    assert_float_equal(rate, 72.0f, 0); // the wrapper hands numbers on
    XR_OK(RT(xrRequestDisplayRefreshRateFB)(c->session, 0.0f));
    SAYS_NOTHING();
    WRONG(XR_ERROR_DISPLAY_REFRESH_RATE_UNSUPPORTED_FB,
          RT(xrRequestDisplayRefreshRateFB)(c->session, 71.5f), "xrRequestDisplayRefreshRateFB",
          "XR_ERROR_DISPLAY_REFRESH_RATE_UNSUPPORTED_FB: XR_FB_display_refresh_rate");
    WRONG(XR_ERROR_DISPLAY_REFRESH_RATE_UNSUPPORTED_FB,
          RT(xrRequestDisplayRefreshRateFB)(c->session, NAN), "xrRequestDisplayRefreshRateFB",
          "Floating point: xrRequestDisplayRefreshRateFB::displayRefreshRate is finite");
    WRONG(XR_ERROR_HANDLE_INVALID, RT(xrRequestDisplayRefreshRateFB)((XrSession)c->view, 72.0f),
          "xrRequestDisplayRefreshRateFB", "VUID-xrRequestDisplayRefreshRateFB-session-parameter");
    report_stop(c);
}

static void device_states_are_told(void **unused) {
    (void)unused;
    struct client program = {0}, *c = &program;
    begin(c);
    const XrPath left = path(c, "/user/hand/left"), never = 987654321;
    const XrPath profile = path(c, "/interaction_profiles/oculus/touch_controller");
    const XrPath trigger = path(c, "/user/hand/left/input/trigger/value");
    const XrPath stick = path(c, "/user/hand/left/input/thumbstick");
    const XrPath nose = path(c, "/user/hand/left/input/nose/value");
    XR_OK(RT(xrSetInputDeviceActiveEXT)(c->session, profile, left, XR_TRUE));
    XR_OK(RT(xrSetInputDeviceStateFloatEXT)(c->session, left, trigger, 0.25f));
    XR_OK(RT(xrSetInputDeviceStateVector2fEXT)(c->session, left, stick, (XrVector2f){0.5f, -1}));
    SAYS_NOTHING();
    WRONG(XR_ERROR_VALIDATION_FAILURE,
          RT(xrSetInputDeviceStateFloatEXT)(c->session, left, trigger, INFINITY),
          "xrSetInputDeviceStateFloatEXT",
          "Floating point: xrSetInputDeviceStateFloatEXT::state is finite");
    WRONG(XR_ERROR_PATH_INVALID, RT(xrSetInputDeviceStateFloatEXT)(c->session, left, never, 0.25f),
          "xrSetInputDeviceStateFloatEXT",
          "XR_ERROR_PATH_INVALID: xrSetInputDeviceStateFloatEXT::inputSourcePath is a path");
    WRONG(XR_ERROR_PATH_UNSUPPORTED,
          RT(xrSetInputDeviceStateFloatEXT)(c->session, left, nose, 0.25f),
          "xrSetInputDeviceStateFloatEXT", "XR_ERROR_PATH_UNSUPPORTED: XR_EXT_conformance_auto");
    WRONG(XR_ERROR_VALIDATION_FAILURE,
          RT(xrSetInputDeviceStateVector2fEXT)(c->session, left, stick, (XrVector2f){0, NAN}),
          "xrSetInputDeviceStateVector2fEXT",
          "Floating point: xrSetInputDeviceStateVector2fEXT::state is finite");
    WRONG(XR_ERROR_PATH_UNSUPPORTED,
          RT(xrSetInputDeviceStateVector2fEXT)(c->session, left, trigger, (XrVector2f){0, 0}),
          "xrSetInputDeviceStateVector2fEXT", "XR_ERROR_PATH_UNSUPPORTED: XR_EXT_conformance_auto");
    WRONG(XR_ERROR_PATH_INVALID,
          RT(xrSetInputDeviceActiveEXT)(c->session, XR_NULL_PATH, left, XR_TRUE),
          "xrSetInputDeviceActiveEXT",
          "XR_ERROR_PATH_INVALID: xrSetInputDeviceActiveEXT::interactionProfile is a path");
    WRONG(XR_ERROR_PATH_UNSUPPORTED,
          RT(xrSetInputDeviceActiveEXT)(c->session, trigger, left, XR_TRUE),
          "xrSetInputDeviceActiveEXT", "XR_ERROR_PATH_UNSUPPORTED: XR_EXT_conformance_automation");
    report_stop(c);
}

static void device_places_are_told(void **unused) {
    (void)unused;
    struct client program = {0}, *c = &program;
    begin(c);
    const XrPath left = path(c, "/user/hand/left");
    const XrPath profile = path(c, "/interaction_profiles/oculus/touch_controller");
    const XrPath grip = path(c, "/user/hand/left/input/grip/pose");
    XrPosef pose = {{0, 0, 0, 1}, {0.125f, 1, -0.5f}};
    XR_OK(RT(xrSetInputDeviceActiveEXT)(c->session, profile, left, XR_TRUE));
    XR_OK(RT(xrSetInputDeviceLocationEXT)(c->session, left, grip, c->stage, pose));
    SAYS_NOTHING();
    pose.orientation.w = 1.0f + 1.0f / 512;
    WRONG(XR_SUCCESS, RT(xrSetInputDeviceLocationEXT)(c->session, left, grip, c->stage, pose),
          "xrSetInputDeviceLocationEXT", "USE-quaternion: xrSetInputDeviceLocationEXT::pose");
    pose.orientation.w = 2;
    WRONG(XR_ERROR_POSE_INVALID,
          RT(xrSetInputDeviceLocationEXT)(c->session, left, grip, c->stage, pose),
          "xrSetInputDeviceLocationEXT",
          "XR_ERROR_POSE_INVALID: xrSetInputDeviceLocationEXT::pose has a unit quaternion");
    pose = (XrPosef){{0, 0, 0, 1}, {0, INFINITY, 0}};
    WRONG(XR_ERROR_POSE_INVALID,
          RT(xrSetInputDeviceLocationEXT)(c->session, left, grip, c->stage, pose),
          "xrSetInputDeviceLocationEXT",
          "Floating point: xrSetInputDeviceLocationEXT::pose is finite");
    pose = (XrPosef){{0, 0, 0, 1}, {0, 0, 0}};
    WRONG(XR_ERROR_HANDLE_INVALID,
          RT(xrSetInputDeviceLocationEXT)(c->session, left, grip, XR_NULL_HANDLE, pose),
          "xrSetInputDeviceLocationEXT", "VUID-xrSetInputDeviceLocationEXT-space-parameter");
    WRONG(XR_ERROR_PATH_UNSUPPORTED,
          RT(xrSetInputDeviceLocationEXT)(c->session, left, left, c->stage, pose),
          "xrSetInputDeviceLocationEXT", "XR_ERROR_PATH_UNSUPPORTED: XR_EXT_conformance_autom");
    report_stop(c);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(refresh_rates_are_told, client_teardown),
        cmocka_unit_test_teardown(device_states_are_told, client_teardown),
        cmocka_unit_test_teardown(device_places_are_told, client_teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
