#include "tests/sim_hmd/client.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "src/device/headset.h"
#include "src/device/timeline.h"

// What the runtime says of head, hands and eyes, against the log read by src/device itself.

// The head turns and moves, with a gap of 0.3 s after 0.2 s; the left hand comes late and leaves
// early; there is no right hand.
static void write_log(void) {
    static char text[100000];
    size_t n = (size_t)sprintf(text, "t_ns,device,px,py,pz,qx,qy,qz,qw,trigger,squeeze,select\n");
    for (int k = 0; k < 60; k++) {
        long long t = 3000000000LL + 10000000LL * k;
        double a = 0.02 * k;
        if (k <= 20 || k >= 50)
            n += (size_t)sprintf(text + n, "%lld,head,%.17g,%.17g,%.17g,0,%.17g,0,%.17g,0,0,0\n", t,
                                 0.3 * sin(a), 1.6 + 0.01 * k, 1 - a, sin(0.4 + a), cos(0.4 + a));
        if (k >= 10 && k <= 40)
            n += (size_t)sprintf(text + n, "%lld,left,%.17g,1.1,0.5,%.17g,0,0,%.17g,%.9g,%.9g,%d\n",
                                 t, 0.01 * k, sin(a), cos(a), k / 40.0, 1 - k / 40.0, k == 15);
    }
    client_file("walk.csv", text);
}

static const char settings[] =
    "{\"poses\": {\"logs\": [\"walk.csv\"]}, \"clock\": \"virtual\", \"refresh_hz\": 90, "
    "\"headset\": {\"name\": \"canted\", \"refresh_hz\": 72, \"ipd_m\": 0.061, \"eyes\": {"
    "\"left\": {\"resolution_px\": [64, 72], \"fov_rad\": {\"left\": -0.9, \"right\": 0.7, \"up\": "
    "0.8, \"down\": -0.85}, \"yaw_rad\": 0.1}, "
    "\"right\": {\"resolution_px\": [60, 72], \"fov_rad\": {\"left\": -0.7, \"right\": 0.9, "
    "\"up\": 0.8, \"down\": -0.85}, \"yaw_rad\": -0.1}}}}";

static struct ap_timeline *read_log(void) {
    char path[256];
    snprintf(path, sizeof path, "%s/walk.csv", client_folder());
    const char *source = path;
    struct ap_error err;
    struct ap_poselog *log;
    struct ap_timeline *timeline;
    assert_int_equal(
        ap_poselog_open(&err, &(struct ap_poselog_params){.sources = &source, .source_count = 1},
                        &log),
        AP_OK);
    assert_int_equal(ap_timeline_load(&err, log, &timeline), AP_OK);
    ap_poselog_close(log);
    return timeline;
}

static void near(double got, double expected, double tolerance, const char *what, int frame) {
    if (!(fabs(got - expected) <= tolerance))
        fail_msg("frame %d: %s is %.9g, expected %.9g ± %g", frame, what, got, expected, tolerance);
}

// To float rounding: positions of a few metres, unit quaternions of either sign.
static void pose_is(XrPosef got, struct ap_pose expected, const char *what, int frame) {
    double sign = got.orientation.x * expected.q.x + got.orientation.y * expected.q.y +
                              got.orientation.z * expected.q.z + got.orientation.w * expected.q.w <
                          0
                      ? -1
                      : 1;
    near(got.position.x, expected.p.x, 2e-7, what, frame);
    near(got.position.y, expected.p.y, 2e-7, what, frame);
    near(got.position.z, expected.p.z, 2e-7, what, frame);
    near(got.orientation.x, sign * expected.q.x, 1e-7, what, frame);
    near(got.orientation.y, sign * expected.q.y, 1e-7, what, frame);
    near(got.orientation.z, sign * expected.q.z, 1e-7, what, frame);
    near(got.orientation.w, sign * expected.q.w, 1e-7, what, frame);
}

static const XrSpaceLocationFlags valid =
    XR_SPACE_LOCATION_ORIENTATION_VALID_BIT | XR_SPACE_LOCATION_POSITION_VALID_BIT;
static const XrSpaceLocationFlags tracked =
    XR_SPACE_LOCATION_ORIENTATION_TRACKED_BIT | XR_SPACE_LOCATION_POSITION_TRACKED_BIT;

static XrSpaceLocationFlags flags_of(enum ap_pose_state state) {
    return state == AP_POSE_NONE ? 0 : state == AP_POSE_LOST ? valid : valid | tracked;
}

static XrSpaceLocation locate(XrSpace space, XrSpace base, XrTime time) {
    XrSpaceLocation at = {.type = XR_TYPE_SPACE_LOCATION};
    XR_OK(xrLocateSpace(space, base, time, &at));
    return at;
}

// Actions as a program sets them up, for the profiles that it names.
struct actions {
    XrActionSet set;
    XrAction grip, aim, trigger, squeeze, select, haptic;
    XrPath hand[2];
    XrSpace grip_space[2], aim_space[2];
};

static XrPath to_path(struct client *c, const char *text) {
    XrPath path;
    XR_OK(xrStringToPath(c->instance, text, &path));
    return path;
}

static XrAction make_action(struct actions *a, const char *name, XrActionType type) {
    XrActionCreateInfo info = {.type = XR_TYPE_ACTION_CREATE_INFO,
                               .actionType = type,
                               .countSubactionPaths = 2,
                               .subactionPaths = a->hand};
    strcpy(info.actionName, name);
    strcpy(info.localizedActionName, name);
    XrAction action;
    XR_OK(xrCreateAction(a->set, &info, &action));
    return action;
}

static void make_actions(struct client *c, struct actions *a) {
    XrActionSetCreateInfo info = {.type = XR_TYPE_ACTION_SET_CREATE_INFO,
                                  .actionSetName = "play",
                                  .localizedActionSetName = "Play"};
    XR_OK(xrCreateActionSet(c->instance, &info, &a->set));
    a->hand[0] = to_path(c, "/user/hand/left");
    a->hand[1] = to_path(c, "/user/hand/right");
    a->grip = make_action(a, "grip", XR_ACTION_TYPE_POSE_INPUT);
    a->aim = make_action(a, "aim", XR_ACTION_TYPE_POSE_INPUT);
    a->trigger = make_action(a, "trigger", XR_ACTION_TYPE_FLOAT_INPUT);
    a->squeeze = make_action(a, "squeeze", XR_ACTION_TYPE_FLOAT_INPUT);
    a->select = make_action(a, "select", XR_ACTION_TYPE_BOOLEAN_INPUT);
    a->haptic = make_action(a, "haptic", XR_ACTION_TYPE_VIBRATION_OUTPUT);
}

static void suggest(struct client *c, struct actions *a) {
    XrActionSuggestedBinding bindings[12];
    int n = 0;
    for (int h = 0; h < 2; h++) {
        const char *hand = h ? "right" : "left";
        const struct {
            XrAction action;
            const char *path;
        } list[] = {{a->grip, "input/grip/pose"},        {a->aim, "input/aim/pose"},
                    {a->trigger, "input/trigger/value"}, {a->squeeze, "input/squeeze/value"},
                    {a->select, "input/trigger"},        {a->haptic, "output/haptic"}};
        for (int i = 0; i < 6; i++) {
            char path[128];
            snprintf(path, sizeof path, "/user/hand/%s/%s", hand, list[i].path);
            bindings[n++] = (XrActionSuggestedBinding){list[i].action, to_path(c, path)};
        }
    }
    XrInteractionProfileSuggestedBinding info = {
        .type = XR_TYPE_INTERACTION_PROFILE_SUGGESTED_BINDING,
        .interactionProfile = to_path(c, "/interaction_profiles/oculus/touch_controller"),
        .countSuggestedBindings = (uint32_t)n,
        .suggestedBindings = bindings};
    XR_OK(xrSuggestInteractionProfileBindings(c->instance, &info));
}

static void attach(struct client *c, struct actions *a) {
    XrSessionActionSetsAttachInfo info = {.type = XR_TYPE_SESSION_ACTION_SETS_ATTACH_INFO,
                                          .countActionSets = 1,
                                          .actionSets = &a->set};
    XR_OK(xrAttachSessionActionSets(c->session, &info));
    for (int h = 0; h < 2; h++) {
        XrActionSpaceCreateInfo space = {.type = XR_TYPE_ACTION_SPACE_CREATE_INFO,
                                         .action = a->grip,
                                         .subactionPath = a->hand[h],
                                         .poseInActionSpace.orientation.w = 1};
        XR_OK(xrCreateActionSpace(c->session, &space, &a->grip_space[h]));
        space.action = a->aim;
        XR_OK(xrCreateActionSpace(c->session, &space, &a->aim_space[h]));
    }
}

static XrResult sync(struct client *c, struct actions *a) {
    XrActiveActionSet active = {.actionSet = a->set};
    XrActionsSyncInfo info = {
        .type = XR_TYPE_ACTIONS_SYNC_INFO, .countActiveActionSets = 1, .activeActionSets = &active};
    return xrSyncActions(c->session, &info);
}

static void check_eyes(struct client *c, XrTime time, struct ap_sample head,
                       enum ap_pose_state state, int frame) {
    // The profile as the settings give it.
    const struct ap_headset_profile profile = {.ipd_m = 0.061,
                                               .eye = {{.yaw_rad = 0.1}, {.yaw_rad = -0.1}}};
    XrView views[2] = {{.type = XR_TYPE_VIEW}, {.type = XR_TYPE_VIEW}};
    XrViewLocateInfo info = {.type = XR_TYPE_VIEW_LOCATE_INFO,
                             .viewConfigurationType = XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO,
                             .displayTime = time,
                             .space = c->stage};
    XrViewState view_state = {.type = XR_TYPE_VIEW_STATE};
    uint32_t count;
    XR_OK(xrLocateViews(c->session, &info, &view_state, 2, &count, views));
    assert_int_equal(count, 2);
    assert_int_equal(view_state.viewStateFlags, flags_of(state));
    for (int eye = 0; eye < 2; eye++)
        pose_is(views[eye].pose, ap_pose_mul(head.pose, ap_headset_view_from_eye(&profile, eye)),
                "an eye in STAGE", frame);
    assert_true(views[0].fov.angleLeft == -0.9f && views[1].fov.angleRight == 0.9f);
    info.space = c->view;
    XR_OK(xrLocateViews(c->session, &info, &view_state, 2, &count, views));
    for (int eye = 0; eye < 2; eye++)
        pose_is(views[eye].pose, ap_headset_view_from_eye(&profile, eye), "an eye in VIEW", frame);
    near(views[0].pose.position.x, -0.0305, 1e-9, "the left eye's x", frame);
}

static XrActionStateFloat get_float(struct client *c, XrAction action, XrPath hand) {
    XrActionStateGetInfo info = {
        .type = XR_TYPE_ACTION_STATE_GET_INFO, .action = action, .subactionPath = hand};
    XrActionStateFloat s = {.type = XR_TYPE_ACTION_STATE_FLOAT};
    XR_OK(xrGetActionStateFloat(c->session, &info, &s));
    return s;
}

static XrActionStateBoolean get_bool(struct client *c, XrAction action, XrPath hand) {
    XrActionStateGetInfo info = {
        .type = XR_TYPE_ACTION_STATE_GET_INFO, .action = action, .subactionPath = hand};
    XrActionStateBoolean s = {.type = XR_TYPE_ACTION_STATE_BOOLEAN};
    XR_OK(xrGetActionStateBoolean(c->session, &info, &s));
    return s;
}

static void check_hand(struct client *c, struct actions *a, const struct ap_timeline *log,
                       XrTime time, int frame) {
    struct ap_sample hand;
    int64_t t = time - 1000000000 + ap_timeline_start_ns(log);
    enum ap_pose_state state = ap_timeline_at(log, ap_timeline_find_device(log, "left"), t, &hand);
    XrSpaceLocation grip = locate(a->grip_space[0], c->stage, time);
    assert_int_equal(grip.locationFlags, flags_of(state));
    XrActionStateFloat trigger = get_float(c, a->trigger, a->hand[0]);
    assert_int_equal(trigger.isActive, state != AP_POSE_NONE);
    if (state != AP_POSE_NONE) {
        pose_is(grip.pose, hand.pose, "the left grip", frame);
        XrSpaceLocation aim = locate(a->aim_space[0], c->stage, time);
        pose_is(aim.pose, hand.pose, "the left aim", frame); // no offset in this profile
        assert_true(trigger.currentState == hand.trigger);
        assert_true(get_float(c, a->squeeze, a->hand[0]).currentState == hand.squeeze);
        assert_int_equal(get_bool(c, a->select, a->hand[0]).currentState,
                         hand.select || hand.trigger >= 0.5f);
        assert_true(get_float(c, a->trigger, XR_NULL_PATH).currentState == hand.trigger);
    }
    assert_int_equal(locate(a->grip_space[1], c->stage, time).locationFlags, 0);
    assert_false(get_float(c, a->trigger, a->hand[1]).isActive);
}

static void every_frame_has_the_logs_poses(void **state) {
    (void)state;
    write_log();
    client_settings(settings);
    struct ap_timeline *log = read_log();
    struct client c = {0};
    struct actions a;
    client_start(&c);
    make_actions(&c, &a);
    suggest(&c, &a);
    attach(&c, &a);
    XR_IS(XR_SESSION_NOT_FOCUSED, sync(&c, &a));
    int frames = (int)ap_timeline_frame_count(log, 90);
    int seen[4] = {0};
    for (int k = 0; k < frames; k++) {
        XrTime time = client_wait(&c).predictedDisplayTime;
        client_begin(&c);
        XR_OK(sync(&c, &a));
        struct ap_sample head;
        enum ap_pose_state s =
            ap_timeline_at(log, 0, time - 1000000000 + ap_timeline_start_ns(log), &head);
        seen[s]++;
        XrSpaceLocation at = locate(c.view, c.stage, time);
        assert_int_equal(at.locationFlags, flags_of(s));
        pose_is(at.pose, head.pose, "the head", k);
        check_eyes(&c, time, head, s, k);
        check_hand(&c, &a, log, time, k);
        client_end_empty(&c, time);
    }
    assert_int_equal(frames, 54);
    assert_true(seen[AP_POSE_EXACT] > 3 && seen[AP_POSE_INTERPOLATED] > 3 &&
                seen[AP_POSE_LOST] > 3);
    client_poll(&c);
    assert_int_equal(c.state, XR_SESSION_STATE_STOPPING);
    XrInteractionProfileState profile = {.type = XR_TYPE_INTERACTION_PROFILE_STATE};
    XR_OK(xrGetCurrentInteractionProfile(c.session, a.hand[0], &profile));
    assert_true(profile.interactionProfile ==
                to_path(&c, "/interaction_profiles/oculus/touch_controller"));
    client_stop(&c);
    ap_timeline_destroy(log);
}

static void local_is_level_at_the_first_head_pose(void **state) {
    (void)state;
    write_log();
    client_settings(settings);
    struct client c = {0};
    client_start(&c);
    XrTime time = client_wait(&c).predictedDisplayTime;
    XrSpaceLocation at = locate(c.local, c.stage, time);
    pose_is(at.pose, (struct ap_pose){{0, 1.6, 1}, {0, sin(0.4), 0, cos(0.4)}}, "LOCAL in STAGE",
            0);
    at = locate(c.view, c.local, time);
    pose_is(at.pose, AP_POSE_IDENTITY, "VIEW in LOCAL", 0);
    // A space with an offset, located in itself and in its parent.
    XrReferenceSpaceCreateInfo info = {.type = XR_TYPE_REFERENCE_SPACE_CREATE_INFO,
                                       .referenceSpaceType = XR_REFERENCE_SPACE_TYPE_STAGE,
                                       .poseInReferenceSpace = {{0, 1, 0, 0}, {1, 2, 3}}};
    XrSpace offset;
    XR_OK(xrCreateReferenceSpace(c.session, &info, &offset));
    pose_is(locate(offset, c.stage, time).pose, (struct ap_pose){{1, 2, 3}, {0, 1, 0, 0}},
            "an offset space", 0);
    pose_is(locate(c.stage, offset, time).pose, (struct ap_pose){{1, -2, 3}, {0, -1, 0, 0}},
            "STAGE in an offset space", 0);
    pose_is(locate(offset, offset, time).pose, AP_POSE_IDENTITY, "a space in itself", 0);
    client_stop(&c);
}

static void velocity_is_the_logs(void **state) {
    (void)state;
    client_file("v.csv", "t_ns,device,px,py,pz,qx,qy,qz,qw\n"
                         "0,head,0,1.6,0,0,0,0,1\n"
                         "100000000,head,0.05,1.6,-0.1,0,0.049979169270678331,0,"
                         "0.99875026039496628\n"); // 0.1 rad
    client_settings("{\"poses\": {\"logs\": [\"v.csv\"]}, \"clock\": \"virtual\"}");
    struct client c = {0};
    client_start(&c);
    client_wait(&c);
    XrSpaceVelocity v = {.type = XR_TYPE_SPACE_VELOCITY};
    XrSpaceLocation at = {.type = XR_TYPE_SPACE_LOCATION, .next = &v};
    XR_OK(xrLocateSpace(c.view, c.stage, 1050000000, &at));
    assert_int_equal(v.velocityFlags,
                     XR_SPACE_VELOCITY_LINEAR_VALID_BIT | XR_SPACE_VELOCITY_ANGULAR_VALID_BIT);
    near(v.linearVelocity.x, 0.5, 1e-6, "the speed along x", 0);
    near(v.linearVelocity.z, -1, 1e-6, "the speed along z", 0);
    near(v.angularVelocity.y, 1, 1e-6, "the turning rate", 0);
    client_stop(&c);
}

static void bad_times_and_poses_are_refused(void **state) {
    (void)state;
    client_settings("{\"clock\": \"virtual\"}");
    struct client c = {0};
    client_start(&c);
    XrSpaceLocation at = {.type = XR_TYPE_SPACE_LOCATION};
    XR_IS(XR_ERROR_TIME_INVALID, xrLocateSpace(c.view, c.stage, 0, &at));
    XR_IS(XR_ERROR_TIME_INVALID, xrLocateSpace(c.view, c.stage, -1, &at));
    XR_OK(xrLocateSpace(c.view, c.stage, 1, &at));
    XR_OK(xrLocateSpace(c.view, c.stage, INT64_MAX, &at));
    XrSpaceLocation wrong = {.type = XR_TYPE_VIEW};
    XR_IS(XR_ERROR_VALIDATION_FAILURE, xrLocateSpace(c.view, c.stage, 1, &wrong));
    XrViewLocateInfo info = {.type = XR_TYPE_VIEW_LOCATE_INFO,
                             .viewConfigurationType = XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO,
                             .displayTime = 0,
                             .space = c.stage};
    XrViewState view_state = {.type = XR_TYPE_VIEW_STATE};
    XrView views[2] = {{.type = XR_TYPE_VIEW}, {.type = XR_TYPE_VIEW}};
    uint32_t count;
    XR_IS(XR_ERROR_TIME_INVALID, xrLocateViews(c.session, &info, &view_state, 2, &count, views));
    info.displayTime = 1000000000;
    XR_IS(XR_ERROR_SIZE_INSUFFICIENT,
          xrLocateViews(c.session, &info, &view_state, 1, &count, views));
    info.viewConfigurationType = XR_VIEW_CONFIGURATION_TYPE_PRIMARY_MONO;
    XR_IS(XR_ERROR_VIEW_CONFIGURATION_TYPE_UNSUPPORTED,
          xrLocateViews(c.session, &info, &view_state, 2, &count, views));
    XrReferenceSpaceCreateInfo space = {.type = XR_TYPE_REFERENCE_SPACE_CREATE_INFO,
                                        .referenceSpaceType = XR_REFERENCE_SPACE_TYPE_VIEW};
    XrSpace out;
    XR_IS(XR_ERROR_POSE_INVALID, xrCreateReferenceSpace(c.session, &space, &out)); // q = 0
    space.poseInReferenceSpace.orientation.w = NAN;
    XR_IS(XR_ERROR_POSE_INVALID, xrCreateReferenceSpace(c.session, &space, &out));
    space.poseInReferenceSpace.orientation.w = 1;
    space.referenceSpaceType = (XrReferenceSpaceType)99;
    XR_IS(XR_ERROR_REFERENCE_SPACE_UNSUPPORTED, xrCreateReferenceSpace(c.session, &space, &out));
    client_stop(&c);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(every_frame_has_the_logs_poses, client_teardown),
        cmocka_unit_test_teardown(local_is_level_at_the_first_head_pose, client_teardown),
        cmocka_unit_test_teardown(velocity_is_the_logs, client_teardown),
        cmocka_unit_test_teardown(bad_times_and_poses_are_refused, client_teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
