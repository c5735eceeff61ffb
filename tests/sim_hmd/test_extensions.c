#include <math.h>
#include <stdio.h>
#include <string.h>

#define XR_EXTENSION_PROTOTYPES
#include "sim_hmd/ext/newer.h"
#include "tests/sim_hmd/client.h"

// The extensions, as a program meets them through the loader. Sessions without graphics, but where
// images are what matters.

#define PROC(c, name)                                                                              \
    PFN_##name name##_;                                                                            \
    *(void **)&name##_ = client_proc((c)->instance, #name)

static void make_instance(struct client *c, const char *const *extensions, uint32_t count) {
    XrInstanceCreateInfo info = {
        .type = XR_TYPE_INSTANCE_CREATE_INFO,
        .applicationInfo = {.applicationName = "test", .apiVersion = XR_MAKE_VERSION(1, 0, 0)},
        .enabledExtensionCount = count,
        .enabledExtensionNames = extensions};
    XR_OK(xrCreateInstance(&info, &c->instance));
    XrSystemGetInfo get = {.type = XR_TYPE_SYSTEM_GET_INFO,
                           .formFactor = XR_FORM_FACTOR_HEAD_MOUNTED_DISPLAY};
    XR_OK(xrGetSystem(c->instance, &get, &c->system));
}

static XrSpace make_space(const struct client *c, XrReferenceSpaceType type) {
    XrReferenceSpaceCreateInfo info = {.type = XR_TYPE_REFERENCE_SPACE_CREATE_INFO,
                                       .referenceSpaceType = type,
                                       .poseInReferenceSpace.orientation.w = 1};
    XrSpace space = XR_NULL_HANDLE;
    XR_OK(xrCreateReferenceSpace(c->session, &info, &space));
    return space;
}

// A running session without graphics, with XR_MND_headless and one more extension.
static void start(struct client *c, const char *extension) {
    const char *const extensions[] = {XR_MND_HEADLESS_EXTENSION_NAME, extension};
    make_instance(c, extensions, extension ? 2 : 1);
    XrSessionCreateInfo info = {.type = XR_TYPE_SESSION_CREATE_INFO, .systemId = c->system};
    XR_OK(xrCreateSession(c->instance, &info, &c->session));
    XrSessionBeginInfo begin = {.type = XR_TYPE_SESSION_BEGIN_INFO,
                                .primaryViewConfigurationType =
                                    XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO};
    XR_OK(xrBeginSession(c->session, &begin));
    c->stage = make_space(c, XR_REFERENCE_SPACE_TYPE_STAGE);
    c->local = make_space(c, XR_REFERENCE_SPACE_TYPE_LOCAL);
}

static XrTime frame(struct client *c) {
    XrTime time = client_wait(c).predictedDisplayTime;
    client_begin(c);
    client_end_empty(c, time);
    return time;
}

// Every function is found with its extension, and without it by nobody.
static void functions_come_with_their_extension(void **state) {
    (void)state;
    static const char *const functions[][2] = {
        {XR_KHR_CONVERT_TIMESPEC_TIME_EXTENSION_NAME, "xrConvertTimespecTimeToTimeKHR"},
        {XR_KHR_VULKAN_ENABLE_EXTENSION_NAME, "xrGetVulkanGraphicsDeviceKHR"},
        {XR_KHR_VULKAN_ENABLE2_EXTENSION_NAME, "xrCreateVulkanDeviceKHR"},
        {XR_FB_DISPLAY_REFRESH_RATE_EXTENSION_NAME, "xrRequestDisplayRefreshRateFB"},
        {XR_KHR_VISIBILITY_MASK_EXTENSION_NAME, "xrGetVisibilityMaskKHR"},
        {XR_EXT_HAND_TRACKING_EXTENSION_NAME, "xrLocateHandJointsEXT"},
        {XR_EXT_DEBUG_UTILS_EXTENSION_NAME, "xrSessionInsertDebugUtilsLabelEXT"},
    };
    client_settings(NULL);
    for (size_t i = 0; i < sizeof functions / sizeof *functions; i++) {
        struct client c = {0};
        PFN_xrVoidFunction f = NULL;
        make_instance(&c, NULL, 0);
        XR_IS(XR_ERROR_FUNCTION_UNSUPPORTED,
              xrGetInstanceProcAddr(c.instance, functions[i][1], &f));
        assert_null(f);
        client_stop(&c);
        make_instance(&c, &functions[i][0], 1);
        XR_OK(xrGetInstanceProcAddr(c.instance, functions[i][1], &f));
        assert_non_null(f);
        client_stop(&c);
    }
}

static void local_floor_is_local_on_the_floor(void **state) {
    (void)state;
    client_settings("{\"clock\": \"virtual\"}");
    struct client c = {0};
    start(&c, NULL);
    XrReferenceSpaceType types[8];
    uint32_t count;
    XR_OK(xrEnumerateReferenceSpaces(c.session, 8, &count, types));
    assert_int_equal(count, 3);
    XrReferenceSpaceCreateInfo info = {.type = XR_TYPE_REFERENCE_SPACE_CREATE_INFO,
                                       .referenceSpaceType =
                                           XR_REFERENCE_SPACE_TYPE_LOCAL_FLOOR_EXT,
                                       .poseInReferenceSpace.orientation.w = 1};
    XrSpace floor;
    XR_IS(XR_ERROR_REFERENCE_SPACE_UNSUPPORTED, xrCreateReferenceSpace(c.session, &info, &floor));
    client_stop(&c);

    start(&c, XR_EXT_LOCAL_FLOOR_EXTENSION_NAME);
    XR_OK(xrEnumerateReferenceSpaces(c.session, 8, &count, types));
    assert_int_equal(count, 4);
    assert_int_equal(types[3], XR_REFERENCE_SPACE_TYPE_LOCAL_FLOOR_EXT);
    XR_OK(xrCreateReferenceSpace(c.session, &info, &floor));
    XrTime time = frame(&c);
    XrSpaceLocation at = {.type = XR_TYPE_SPACE_LOCATION}, local = at;
    XR_OK(xrLocateSpace(floor, c.stage, time, &at));
    XR_OK(xrLocateSpace(c.local, c.stage, time, &local));
    assert_int_equal(at.locationFlags, 15);
    assert_true(at.pose.position.y == 0 && local.pose.position.y > 1);
    assert_true(at.pose.position.x == local.pose.position.x);
    assert_true(at.pose.position.z == local.pose.position.z);
    assert_memory_equal(&at.pose.orientation, &local.pose.orientation, sizeof(XrQuaternionf));
    XrExtent2Df bounds;
    XR_IS(
        XR_SPACE_BOUNDS_UNAVAILABLE,
        xrGetReferenceSpaceBoundsRect(c.session, XR_REFERENCE_SPACE_TYPE_LOCAL_FLOOR_EXT, &bounds));
    client_stop(&c);
}

static void depth_range_is_filled_where_enabled(void **state) {
    (void)state;
    client_settings(NULL);
    for (int on = 0; on < 2; on++) {
        struct client c = {0};
        const char *extension = XR_EXT_VIEW_CONFIGURATION_DEPTH_RANGE_EXTENSION_NAME;
        make_instance(&c, &extension, (uint32_t)on);
        XrViewConfigurationDepthRangeEXT range[2];
        XrViewConfigurationView views[2];
        for (int i = 0; i < 2; i++) {
            range[i] = (XrViewConfigurationDepthRangeEXT){
                .type = XR_TYPE_VIEW_CONFIGURATION_DEPTH_RANGE_EXT, .minNearZ = -7};
            views[i] = (XrViewConfigurationView){.type = XR_TYPE_VIEW_CONFIGURATION_VIEW,
                                                 .next = &range[i]};
        }
        uint32_t count;
        XR_OK(xrEnumerateViewConfigurationViews(
            c.instance, c.system, XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO, 2, &count, views));
        for (int i = 0; i < 2; i++) {
            if (!on) {
                assert_true(range[i].minNearZ == -7);
                continue;
            }
            assert_true(0 < range[i].minNearZ);
            assert_true(range[i].minNearZ <= range[i].recommendedNearZ);
            assert_true(range[i].recommendedNearZ < range[i].recommendedFarZ);
            assert_true(range[i].recommendedFarZ <= range[i].maxFarZ);
        }
        client_stop(&c);
    }
}

// The next event that is not a session's change of state.
static bool next_event(struct client *c, XrEventDataBuffer *event) {
    do {
        *event = (XrEventDataBuffer){.type = XR_TYPE_EVENT_DATA_BUFFER};
        XrResult result = xrPollEvent(c->instance, event);
        if (result == XR_EVENT_UNAVAILABLE)
            return false;
        XR_OK(result);
    } while (event->type == XR_TYPE_EVENT_DATA_SESSION_STATE_CHANGED);
    return true;
}

static void refresh_rate_changes_the_grid(void **state) {
    (void)state;
    client_settings("{\"clock\": \"virtual\", \"refresh_hz\": 100, "
                    "\"refresh_rates_hz\": [120, 50.5]}");
    struct client c = {0};
    start(&c, XR_FB_DISPLAY_REFRESH_RATE_EXTENSION_NAME);
    PROC(&c, xrEnumerateDisplayRefreshRatesFB);
    PROC(&c, xrGetDisplayRefreshRateFB);
    PROC(&c, xrRequestDisplayRefreshRateFB);
    float rates[8], rate;
    uint32_t count;
    XR_OK(xrEnumerateDisplayRefreshRatesFB_(c.session, 0, &count, NULL));
    assert_int_equal(count, 3);
    XR_IS(XR_ERROR_SIZE_INSUFFICIENT,
          xrEnumerateDisplayRefreshRatesFB_(c.session, 2, &count, rates));
    XR_OK(xrEnumerateDisplayRefreshRatesFB_(c.session, 8, &count, rates));
    assert_true(rates[0] == 50.5f && rates[1] == 100 && rates[2] == 120);
    XR_OK(xrGetDisplayRefreshRateFB_(c.session, &rate));
    assert_true(rate == 100);
    XR_IS(XR_ERROR_VALIDATION_FAILURE, xrGetDisplayRefreshRateFB_(c.session, NULL));
    assert_int_equal(frame(&c), 1000000000);
    assert_int_equal(frame(&c), 1010000000);
    XR_IS(XR_ERROR_DISPLAY_REFRESH_RATE_UNSUPPORTED_FB,
          xrRequestDisplayRefreshRateFB_(c.session, 90));
    XR_IS(XR_ERROR_DISPLAY_REFRESH_RATE_UNSUPPORTED_FB,
          xrRequestDisplayRefreshRateFB_(c.session, NAN));
    XrEventDataBuffer event;
    assert_false(next_event(&c, &event));
    XR_OK(xrRequestDisplayRefreshRateFB_(c.session, 120));
    XR_OK(xrRequestDisplayRefreshRateFB_(c.session, 120)); // no change, no event
    assert_true(next_event(&c, &event));
    XrEventDataDisplayRefreshRateChangedFB changed;
    memcpy(&changed, &event, sizeof changed);
    assert_int_equal(changed.type, XR_TYPE_EVENT_DATA_DISPLAY_REFRESH_RATE_CHANGED_FB);
    assert_true(changed.fromDisplayRefreshRate == 100 && changed.toDisplayRefreshRate == 120);
    assert_false(next_event(&c, &event));
    XR_OK(xrGetDisplayRefreshRateFB_(c.session, &rate));
    assert_true(rate == 120);
    XrFrameState next = client_wait(&c);
    assert_int_equal(next.predictedDisplayTime, 1018333333);
    assert_int_equal(next.predictedDisplayPeriod, 8333333);
    client_begin(&c);
    XR_OK(xrRequestDisplayRefreshRateFB_(c.session, 0)); // no preference: the headset's own
    XR_OK(xrGetDisplayRefreshRateFB_(c.session, &rate));
    assert_true(rate == 100);
    client_stop(&c);
}

// A walk of a second: the frames of a session end with it whatever the rate becomes.
static void refresh_rate_keeps_the_end(void **state) {
    (void)state;
    client_settings("{\"clock\": \"virtual\", \"refresh_hz\": 100, \"refresh_rates_hz\": [50], "
                    "\"poses\": {\"script\": \"walk\", \"duration_s\": 1}}");
    struct client c = {0};
    start(&c, XR_FB_DISPLAY_REFRESH_RATE_EXTENSION_NAME);
    PROC(&c, xrRequestDisplayRefreshRateFB);
    int frames = 0;
    XrTime last = 0;
    for (; c.state != XR_SESSION_STATE_STOPPING && frames < 1000; frames++) {
        if (frames == 11) // shown at 0.1 s; 45 more in the 0.9 s that are left
            XR_OK(xrRequestDisplayRefreshRateFB_(c.session, 50));
        last = frame(&c);
        client_poll(&c);
    }
    assert_int_equal(frames, 11 + 45);
    assert_int_equal(last, 2000000000);
    client_stop(&c);
}

#define EYE(left, right, more)                                                                     \
    "{\"resolution_px\": [64, 64], \"fov_rad\": {\"left\": " left ", \"right\": " right            \
    ", \"up\": 0.7, \"down\": -0.7}" more "}"

static void visibility_mask_is_the_profiles(void **state) {
    (void)state;
    client_settings(
        "{\"clock\": \"virtual\", \"headset\": {\"name\": \"x\", \"refresh_hz\": 90, "
        "\"ipd_m\": 0.06, \"eyes\": {\"left\": " EYE("-0.7", "0.6", "") ", \"right\": " EYE(
            "-0.6", "0.7",
            ", \"hidden_area\": {\"outside_ellipse\": "
            "[0.05, 0, 0.8, 0.8]}") "}}}");
    struct client c = {0};
    start(&c, XR_KHR_VISIBILITY_MASK_EXTENSION_NAME);
    PROC(&c, xrGetVisibilityMaskKHR);
    const XrViewConfigurationType stereo = XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO;
    XrVector2f vertices[256];
    uint32_t indices[512];
    for (int type = 1; type <= 3; type++) {
        XrVisibilityMaskTypeKHR t = (XrVisibilityMaskTypeKHR)type;
        XrVisibilityMaskKHR mask = {.type = XR_TYPE_VISIBILITY_MASK_KHR, .vertexCountOutput = 9};
        XR_OK(xrGetVisibilityMaskKHR_(c.session, stereo, 0, t, &mask));
        assert_int_equal(mask.vertexCountOutput + mask.indexCountOutput, 0);
        XR_OK(xrGetVisibilityMaskKHR_(c.session, stereo, 1, t, &mask));
        assert_true(mask.vertexCountOutput > 3 && mask.indexCountOutput > 3);
        mask.vertices = vertices;
        mask.vertexCapacityInput = 256;
        XR_OK(xrGetVisibilityMaskKHR_(c.session, stereo, 1, t, &mask)); // asks for both counts
        mask.indices = indices;
        mask.indexCapacityInput = mask.indexCountOutput - 1;
        XR_IS(XR_ERROR_SIZE_INSUFFICIENT, xrGetVisibilityMaskKHR_(c.session, stereo, 1, t, &mask));
        mask.indexCapacityInput = 512;
        XR_OK(xrGetVisibilityMaskKHR_(c.session, stereo, 1, t, &mask));
        for (uint32_t i = 0; i < mask.indexCountOutput; i++) {
            assert_true(indices[i] < mask.vertexCountOutput);
            assert_true(fabsf(vertices[indices[i]].y) <= (float)tan(0.7));
        }
        mask.vertices = NULL;
        XR_IS(XR_ERROR_VALIDATION_FAILURE, xrGetVisibilityMaskKHR_(c.session, stereo, 1, t, &mask));
    }
    XrVisibilityMaskKHR mask = {.type = XR_TYPE_VISIBILITY_MASK_KHR};
    const XrVisibilityMaskTypeKHR line = XR_VISIBILITY_MASK_TYPE_LINE_LOOP_KHR;
    XR_IS(XR_ERROR_VALIDATION_FAILURE, xrGetVisibilityMaskKHR_(c.session, stereo, 2, line, &mask));
    XR_IS(XR_ERROR_VALIDATION_FAILURE,
          xrGetVisibilityMaskKHR_(c.session, stereo, 1, (XrVisibilityMaskTypeKHR)7, &mask));
    XR_IS(XR_ERROR_VIEW_CONFIGURATION_TYPE_UNSUPPORTED,
          xrGetVisibilityMaskKHR_(c.session, XR_VIEW_CONFIGURATION_TYPE_PRIMARY_MONO, 0, line,
                                  &mask));
    mask.type = XR_TYPE_UNKNOWN;
    XR_IS(XR_ERROR_VALIDATION_FAILURE, xrGetVisibilityMaskKHR_(c.session, stereo, 1, line, &mask));
    client_stop(&c);
}

// What hand tracking's tests share.
struct hands {
    PFN_xrCreateHandTrackerEXT create;
    PFN_xrDestroyHandTrackerEXT destroy;
    PFN_xrLocateHandJointsEXT locate;
    XrHandTrackerEXT tracker[2];
    XrHandJointLocationEXT joint[XR_HAND_JOINT_COUNT_EXT];
    XrHandJointVelocityEXT moves[XR_HAND_JOINT_COUNT_EXT];
    XrBool32 active;
};

static void make_hands(struct client *c, struct hands *h) {
    *(void **)&h->create = client_proc(c->instance, "xrCreateHandTrackerEXT");
    *(void **)&h->destroy = client_proc(c->instance, "xrDestroyHandTrackerEXT");
    *(void **)&h->locate = client_proc(c->instance, "xrLocateHandJointsEXT");
    for (int i = 0; i < 2; i++) {
        XrHandTrackerCreateInfoEXT info = {.type = XR_TYPE_HAND_TRACKER_CREATE_INFO_EXT,
                                           .hand = i ? XR_HAND_RIGHT_EXT : XR_HAND_LEFT_EXT};
        XR_OK(h->create(c->session, &info, &h->tracker[i]));
    }
}

static XrResult locate_hand(struct hands *h, int hand, XrSpace base, XrTime time) {
    XrHandJointVelocitiesEXT velocities = {.type = XR_TYPE_HAND_JOINT_VELOCITIES_EXT,
                                           .jointCount = XR_HAND_JOINT_COUNT_EXT,
                                           .jointVelocities = h->moves};
    XrHandJointLocationsEXT out = {.type = XR_TYPE_HAND_JOINT_LOCATIONS_EXT,
                                   .next = &velocities,
                                   .jointCount = XR_HAND_JOINT_COUNT_EXT,
                                   .jointLocations = h->joint};
    XrHandJointsLocateInfoEXT info = {
        .type = XR_TYPE_HAND_JOINTS_LOCATE_INFO_EXT, .baseSpace = base, .time = time};
    XrResult result = h->locate(h->tracker[hand], &info, &out);
    h->active = out.isActive;
    return result;
}

static void hands_are_there_without_a_recording(void **state) {
    (void)state;
    client_settings("{\"clock\": \"virtual\"}");
    struct client c = {0};
    start(&c, XR_EXT_HAND_TRACKING_EXTENSION_NAME);
    XrSystemHandTrackingPropertiesEXT has = {.type = XR_TYPE_SYSTEM_HAND_TRACKING_PROPERTIES_EXT};
    XrSystemProperties system = {.type = XR_TYPE_SYSTEM_PROPERTIES, .next = &has};
    XR_OK(xrGetSystemProperties(c.instance, c.system, &system));
    assert_int_equal(has.supportsHandTracking, XR_TRUE);
    struct hands h;
    make_hands(&c, &h);
    XrTime time = frame(&c) + 500000000;
    for (int hand = 0; hand < 2; hand++) {
        XR_OK(locate_hand(&h, hand, c.stage, time));
        assert_int_equal(h.active, XR_TRUE);
        XrVector3f before = h.joint[XR_HAND_JOINT_INDEX_TIP_EXT].pose.position;
        XrVector3f speed = h.moves[XR_HAND_JOINT_INDEX_TIP_EXT].linearVelocity;
        for (int j = 0; j < XR_HAND_JOINT_COUNT_EXT; j++) {
            assert_int_equal(h.joint[j].locationFlags, 15);
            assert_int_equal(h.moves[j].velocityFlags, 3);
            assert_true(h.joint[j].radius > 0 && h.joint[j].pose.position.y > 0.3f);
        }
        // The velocity is the way: over 2 ms.
        XR_OK(locate_hand(&h, hand, c.stage, time + 2000000));
        XrVector3f after = h.joint[XR_HAND_JOINT_INDEX_TIP_EXT].pose.position;
        double off = hypot((double)(after.x - before.x) / 0.002 - (double)speed.x,
                           (double)(after.z - before.z) / 0.002 - (double)speed.z);
        if (off > 0.02)
            fail_msg("velocity off by %g m/s, tolerance 0.02", off);
    }
    client_stop(&c);
}

static void hands_refuse_what_is_wrong(void **state) {
    (void)state;
    client_settings("{\"clock\": \"virtual\"}");
    struct client c = {0};
    start(&c, XR_EXT_HAND_TRACKING_EXTENSION_NAME);
    struct hands h;
    make_hands(&c, &h);
    XrHandTrackerCreateInfoEXT info = {.type = XR_TYPE_HAND_TRACKER_CREATE_INFO_EXT, .hand = 3};
    XrHandTrackerEXT more;
    XR_IS(XR_ERROR_VALIDATION_FAILURE, h.create(c.session, &info, &more));
    info.hand = XR_HAND_LEFT_EXT;
    info.handJointSet = 1;
    XR_IS(XR_ERROR_VALIDATION_FAILURE, h.create(c.session, &info, &more));
    XR_IS(XR_ERROR_VALIDATION_FAILURE, h.create(c.session, NULL, &more));
    XR_IS(XR_ERROR_HANDLE_INVALID, h.create((XrSession)c.instance, &info, &more));
    XR_IS(XR_ERROR_TIME_INVALID, locate_hand(&h, 0, c.stage, 0));
    XR_IS(XR_ERROR_TIME_INVALID, locate_hand(&h, 0, c.stage, -5));
    XR_IS(XR_ERROR_HANDLE_INVALID, locate_hand(&h, 0, (XrSpace)c.session, 1000000000));
    XR_OK(locate_hand(&h, 0, c.stage, 1));
    XR_OK(locate_hand(&h, 0, c.stage, INT64_MAX));
    XrHandJointLocationsEXT out = {
        .type = XR_TYPE_HAND_JOINT_LOCATIONS_EXT, .jointCount = 25, .jointLocations = h.joint};
    XrHandJointsLocateInfoEXT where = {
        .type = XR_TYPE_HAND_JOINTS_LOCATE_INFO_EXT, .baseSpace = c.stage, .time = 1000000000};
    XR_IS(XR_ERROR_VALIDATION_FAILURE, h.locate(h.tracker[0], &where, &out));
    out.jointCount = 26;
    XrHandJointVelocitiesEXT velocities = {.type = XR_TYPE_HAND_JOINT_VELOCITIES_EXT,
                                           .jointCount = 26};
    out.next = &velocities;
    XR_IS(XR_ERROR_VALIDATION_FAILURE, h.locate(h.tracker[0], &where, &out));
    XR_OK(h.destroy(h.tracker[0]));
    XR_IS(XR_ERROR_HANDLE_INVALID, h.destroy(h.tracker[0]));
    XR_IS(XR_ERROR_HANDLE_INVALID, locate_hand(&h, 0, c.stage, 1000000000));
    XR_OK(xrDestroySession(c.session)); // takes the other one along
    c.session = XR_NULL_HANDLE;
    XR_IS(XR_ERROR_HANDLE_INVALID, h.destroy(h.tracker[1]));
    client_stop(&c);
}

// A right hand that goes up by 1 m/s for 50 ms.
static void recorded_hands_are_the_recordings(void **state) {
    (void)state;
    static const char *const names[] = {"metacarpal", "proximal", "intermediate", "distal", "tip"};
    static const char *const fingers[] = {"thumb", "index", "middle", "ring", "little"};
    static char text[16384];
    size_t at = (size_t)sprintf(text, "t_ns,hand,joint,px,py,pz,qx,qy,qz,qw,radius\n");
    for (int k = 0; k < 2; k++) {
        double y = 1 + 0.05 * k;
        at += (size_t)sprintf(text + at, "%d,right,wrist,0.25,%g,-0.5,0,0,0,1,0.02\n", 50000000 * k,
                              y);
        for (int i = 0; i < 25; i++)
            if (i != 2) // the thumb has no intermediate bone
                at += (size_t)sprintf(text + at, "%d,right,%s_%s,0.25,%g,-0.5,0,0,0,1,0.01\n",
                                      50000000 * k, fingers[i / 5], names[i % 5], y);
    }
    client_file("hands.csv", text);
    client_settings("{\"clock\": \"virtual\", \"refresh_hz\": 100, \"hands\": \"hands.csv\"}");
    struct client c = {0};
    start(&c, XR_EXT_HAND_TRACKING_EXTENSION_NAME);
    struct hands h;
    make_hands(&c, &h);
    XrTime time = frame(&c);
    XR_OK(locate_hand(&h, 0, c.stage, time)); // there is no left one
    assert_int_equal(h.active, XR_FALSE);
    assert_int_equal(h.joint[5].locationFlags | h.moves[5].velocityFlags, 0);
    time = frame(&c);
    XR_OK(locate_hand(&h, 1, c.stage, time));
    assert_int_equal(h.active, XR_TRUE);
    const XrPosef pose = h.joint[XR_HAND_JOINT_LITTLE_TIP_EXT].pose;
    assert_true(pose.position.x == 0.25f && pose.position.z == -0.5f);
    if (fabs((double)pose.position.y - 1.01) > 1e-7)
        fail_msg("%.9g, expected 1.01 within 1e-7", (double)pose.position.y);
    double up = (double)h.moves[XR_HAND_JOINT_WRIST_EXT].linearVelocity.y;
    if (fabs(up - 1) > 1e-6)
        fail_msg("%.9g m/s, expected 1 within 1e-6", up);
    assert_true(h.joint[1].radius == 0.02f);
    XR_OK(locate_hand(&h, 1, c.stage, time + 60000000)); // after the recording's end
    assert_int_equal(h.active, XR_FALSE);
    client_stop(&c);
    client_settings("{\"hands\": \"nowhere.csv\"}");
    XrInstance none;
    XR_IS(XR_ERROR_INITIALIZATION_FAILED, client_try_instance(&none));
}

static void timespec_goes_there_and_back(void **state) {
    (void)state;
    client_settings(NULL);
    struct client c = {0};
    start(&c, XR_KHR_CONVERT_TIMESPEC_TIME_EXTENSION_NAME);
    PROC(&c, xrConvertTimespecTimeToTimeKHR);
    PROC(&c, xrConvertTimeToTimespecTimeKHR);
    struct timespec now, back;
    assert_int_equal(clock_gettime(CLOCK_MONOTONIC, &now), 0);
    XrTime time;
    XR_OK(xrConvertTimespecTimeToTimeKHR_(c.instance, &now, &time));
    XR_OK(xrConvertTimeToTimespecTimeKHR_(c.instance, time, &back));
    assert_int_equal(back.tv_sec, now.tv_sec);
    assert_int_equal(back.tv_nsec, now.tv_nsec);
    const struct timespec bad[] = {{.tv_sec = INT64_MAX},
                                   {.tv_sec = INT64_MIN},
                                   {.tv_nsec = -1},
                                   {.tv_nsec = 1000000000},
                                   {.tv_sec = INT64_MAX / 1000000000, .tv_nsec = 999999999},
                                   {.tv_sec = INT64_MIN / 1000000000},
                                   {.tv_sec = -5}};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        XR_IS(XR_ERROR_TIME_INVALID, xrConvertTimespecTimeToTimeKHR_(c.instance, &bad[i], &time));
    const XrTime never[] = {0, -1, INT64_MIN};
    for (size_t i = 0; i < sizeof never / sizeof *never; i++)
        XR_IS(XR_ERROR_TIME_INVALID, xrConvertTimeToTimespecTimeKHR_(c.instance, never[i], &back));
    client_stop(&c);
}

static void format_list_is_checked(void **state) {
    (void)state;
    client_settings("{\"clock\": \"virtual\"}");
    struct client c = {0};
    const char *const extensions[] = {XR_KHR_VULKAN_ENABLE2_EXTENSION_NAME,
                                      XR_KHR_VULKAN_SWAPCHAIN_FORMAT_LIST_EXTENSION_NAME};
    make_instance(&c, extensions, 2);
    client_make_device(&c);
    client_make_session(&c);
    const VkFormat formats[] = {VK_FORMAT_R8G8B8A8_SRGB, VK_FORMAT_R8G8B8A8_UNORM};
    XrVulkanSwapchainFormatListCreateInfoKHR list = {
        .type = XR_TYPE_VULKAN_SWAPCHAIN_FORMAT_LIST_CREATE_INFO_KHR,
        .viewFormatCount = 2,
        .viewFormats = formats};
    XrSwapchainCreateInfo info = {.type = XR_TYPE_SWAPCHAIN_CREATE_INFO,
                                  .next = &list,
                                  .usageFlags = XR_SWAPCHAIN_USAGE_COLOR_ATTACHMENT_BIT |
                                                XR_SWAPCHAIN_USAGE_MUTABLE_FORMAT_BIT,
                                  .format = VK_FORMAT_R8G8B8A8_SRGB,
                                  .sampleCount = 1,
                                  .width = 16,
                                  .height = 16,
                                  .faceCount = 1,
                                  .arraySize = 1,
                                  .mipCount = 1};
    XrSwapchain swapchain;
    XR_OK(xrCreateSwapchain(c.session, &info, &swapchain));
    XR_OK(xrDestroySwapchain(swapchain));
    info.usageFlags = XR_SWAPCHAIN_USAGE_COLOR_ATTACHMENT_BIT;
    XR_IS(XR_ERROR_VALIDATION_FAILURE, xrCreateSwapchain(c.session, &info, &swapchain));
    list.viewFormatCount = 1;
    XR_OK(xrCreateSwapchain(c.session, &info, &swapchain));
    XR_OK(xrDestroySwapchain(swapchain));
    list.viewFormats = NULL;
    XR_IS(XR_ERROR_VALIDATION_FAILURE, xrCreateSwapchain(c.session, &info, &swapchain));
    const VkFormat none = VK_FORMAT_UNDEFINED;
    list.viewFormats = &none;
    XR_IS(XR_ERROR_VALIDATION_FAILURE, xrCreateSwapchain(c.session, &info, &swapchain));
    client_stop(&c);
}

#define TEST(name) cmocka_unit_test_teardown(name, client_teardown)

int main(void) {
    const struct CMUnitTest tests[] = {
        TEST(functions_come_with_their_extension),
        TEST(local_floor_is_local_on_the_floor),
        TEST(depth_range_is_filled_where_enabled),
        TEST(refresh_rate_changes_the_grid),
        TEST(refresh_rate_keeps_the_end),
        TEST(visibility_mask_is_the_profiles),
        TEST(hands_are_there_without_a_recording),
        TEST(hands_refuse_what_is_wrong),
        TEST(recorded_hands_are_the_recordings),
        TEST(timespec_goes_there_and_back),
        TEST(format_list_is_checked),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
