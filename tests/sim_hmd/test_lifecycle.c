#include "tests/sim_hmd/client.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "src/device/timeline.h"

// Instance, session, states and the frame loop, through the loader.

static void head_log(const char *name, int samples, int64_t step_ns) {
    static char text[200000];
    size_t n = (size_t)sprintf(text, "t_ns,device,px,py,pz,qx,qy,qz,qw\n");
    for (int k = 0; k < samples; k++)
        n += (size_t)sprintf(text + n, "%lld,head,%g,1.6,0,0,0,0,1\n",
                             7000000000LL + (long long)step_ns * k, 0.01 * k);
    client_file(name, text);
}

static void a_log_on_the_virtual_clock_gives_exactly_its_frames(void **state) {
    (void)state;
    head_log("a.csv", 20, 10000000); // 190 ms: at 72 Hz frames 0…13
    client_settings(
        "{\"poses\": {\"logs\": [\"a.csv\"]}, \"clock\": \"virtual\", \"refresh_hz\": 72}");
    for (int run = 0; run < 2; run++) { // two instances, one after another
        struct client c = {0};
        client_start(&c);
        int frames = 0;
        for (;; frames++) {
            client_poll(&c);
            if (c.state == XR_SESSION_STATE_STOPPING)
                break;
            assert_true(frames < 100);
            XrFrameState f = client_wait(&c);
            int64_t expected = ap_frame_time_ns(1000000000, frames, 72);
            if (f.predictedDisplayTime != expected)
                fail_msg("frame %d at %lld, expected %lld", frames,
                         (long long)f.predictedDisplayTime, (long long)expected);
            assert_int_equal(f.predictedDisplayPeriod, 13888889);
            assert_false(f.shouldRender); // nothing is captured
            client_begin(&c);
            client_end_empty(&c, f.predictedDisplayTime);
        }
        assert_int_equal(frames, 14);
        XR_OK(xrEndSession(c.session));
        client_poll(&c);
        assert_int_equal(c.state, XR_SESSION_STATE_EXITING);
        client_stop(&c);
    }
}

static void the_settings_may_ask_for_fewer_frames(void **state) {
    (void)state;
    client_settings("{\"poses\": {\"script\": \"walk\"}, \"clock\": \"virtual\", \"frames\": 3}");
    struct client c = {0};
    client_start(&c);
    for (int k = 0; k < 3; k++) {
        client_poll(&c);
        assert_int_not_equal(c.state, XR_SESSION_STATE_STOPPING);
        XrFrameState f = client_wait(&c);
        client_begin(&c);
        client_end_empty(&c, f.predictedDisplayTime);
    }
    client_poll(&c);
    assert_int_equal(c.state, XR_SESSION_STATE_STOPPING);
    // A program that draws on meanwhile gets frames that nobody sees.
    XrFrameState f = client_wait(&c);
    assert_false(f.shouldRender);
    client_begin(&c);
    client_end_empty(&c, f.predictedDisplayTime);
    XR_OK(xrEndSession(c.session));
    client_stop(&c);
}

static void every_frame_is_rendered_where_asked(void **state) {
    (void)state;
    client_settings("{\"clock\": \"virtual\", \"frames\": 3, \"draw\": \"all\"}");
    struct client c = {0};
    client_start(&c);
    for (int k = 0; k < 4; k++) {
        XrFrameState f = client_wait(&c);
        assert_int_equal(f.shouldRender, k < 3); // what comes after the last nobody sees
        client_begin(&c);
        client_end_empty(&c, f.predictedDisplayTime);
    }
    client_stop(&c);
}

static void captured_frames_are_rendered_and_others_are_not(void **state) {
    (void)state;
    char json[512];
    snprintf(json, sizeof json,
             "{\"clock\": \"virtual\", \"frames\": 8, \"capture\": {\"dir\": \"%s/cap\", "
             "\"frames\": \"1:7:3\"}}",
             client_folder());
    client_settings(json);
    struct client c = {0};
    client_start(&c);
    for (int k = 0; k < 8; k++) {
        XrFrameState f = client_wait(&c);
        assert_int_equal(f.shouldRender, k == 1 || k == 4);
        client_begin(&c);
        client_end_empty(&c, f.predictedDisplayTime);
    }
    client_stop(&c);
    char path[256];
    snprintf(path, sizeof path, "%s/cap/000004-right.png", client_folder());
    FILE *f = fopen(path, "rb"); // an empty frame is black, and on disk
    assert_non_null(f);
    fclose(f);
}

static void states_come_in_their_order(void **state) {
    (void)state;
    client_settings("{\"clock\": \"virtual\"}");
    struct client c = {0};
    client_make_instance(&c);
    client_make_device(&c);
    client_make_session(&c);
    XrSessionBeginInfo begin = {.type = XR_TYPE_SESSION_BEGIN_INFO,
                                .primaryViewConfigurationType =
                                    XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO};
    const XrSessionState expected[] = {XR_SESSION_STATE_IDLE,         XR_SESSION_STATE_READY,
                                       XR_SESSION_STATE_SYNCHRONIZED, XR_SESSION_STATE_VISIBLE,
                                       XR_SESSION_STATE_FOCUSED,      XR_SESSION_STATE_VISIBLE,
                                       XR_SESSION_STATE_SYNCHRONIZED, XR_SESSION_STATE_STOPPING,
                                       XR_SESSION_STATE_IDLE,         XR_SESSION_STATE_EXITING};
    XR_IS(XR_ERROR_SESSION_NOT_RUNNING, xrEndSession(c.session));
    XR_IS(XR_ERROR_SESSION_NOT_RUNNING, xrRequestExitSession(c.session));
    XR_OK(xrBeginSession(c.session, &begin));
    XR_IS(XR_ERROR_SESSION_RUNNING, xrBeginSession(c.session, &begin));
    XR_IS(XR_ERROR_SESSION_NOT_STOPPING, xrEndSession(c.session));
    XrFrameState f = client_wait(&c);
    client_begin(&c);
    client_end_empty(&c, f.predictedDisplayTime);
    XR_OK(xrRequestExitSession(c.session));
    XR_OK(xrEndSession(c.session));
    for (size_t i = 0; i < sizeof expected / sizeof *expected; i++) {
        XrEventDataBuffer event = {.type = XR_TYPE_EVENT_DATA_BUFFER};
        XR_OK(xrPollEvent(c.instance, &event));
        XrEventDataSessionStateChanged changed;
        memcpy(&changed, &event, sizeof changed);
        assert_int_equal(changed.type, XR_TYPE_EVENT_DATA_SESSION_STATE_CHANGED);
        assert_int_equal(changed.state, expected[i]);
        assert_true(changed.session == c.session);
    }
    XR_IS(XR_ERROR_SESSION_NOT_READY, xrBeginSession(c.session, &begin));
    client_stop(&c);
}

static void frame_calls_out_of_order_are_refused(void **state) {
    (void)state;
    client_settings("{\"clock\": \"virtual\"}");
    struct client c = {0};
    client_make_instance(&c);
    client_make_device(&c);
    client_make_session(&c);
    XrFrameState f = {.type = XR_TYPE_FRAME_STATE};
    XrFrameEndInfo end = {.type = XR_TYPE_FRAME_END_INFO,
                          .displayTime = 1,
                          .environmentBlendMode = XR_ENVIRONMENT_BLEND_MODE_OPAQUE};
    XR_IS(XR_ERROR_SESSION_NOT_RUNNING, xrWaitFrame(c.session, NULL, &f));
    XR_IS(XR_ERROR_SESSION_NOT_RUNNING, xrBeginFrame(c.session, NULL));
    XR_IS(XR_ERROR_SESSION_NOT_RUNNING, xrEndFrame(c.session, &end));
    XrSessionBeginInfo begin = {.type = XR_TYPE_SESSION_BEGIN_INFO,
                                .primaryViewConfigurationType =
                                    XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO};
    XR_OK(xrBeginSession(c.session, &begin));
    XR_IS(XR_ERROR_CALL_ORDER_INVALID, xrBeginFrame(c.session, NULL));
    XR_IS(XR_ERROR_CALL_ORDER_INVALID, xrEndFrame(c.session, &end));
    client_wait(&c);
    XR_IS(XR_ERROR_CALL_ORDER_INVALID, xrEndFrame(c.session, &end));
    client_begin(&c);
    client_wait(&c);
    XR_IS(XR_FRAME_DISCARDED, xrBeginFrame(c.session, NULL));
    end.displayTime = 0;
    XR_IS(XR_ERROR_TIME_INVALID, xrEndFrame(c.session, &end));
    end.displayTime = -5;
    XR_IS(XR_ERROR_TIME_INVALID, xrEndFrame(c.session, &end));
    end.displayTime = 1;
    end.environmentBlendMode = XR_ENVIRONMENT_BLEND_MODE_ADDITIVE;
    XR_IS(XR_ERROR_ENVIRONMENT_BLEND_MODE_UNSUPPORTED, xrEndFrame(c.session, &end));
    end.environmentBlendMode = XR_ENVIRONMENT_BLEND_MODE_OPAQUE;
    end.layerCount = 17;
    XR_IS(XR_ERROR_LAYER_LIMIT_EXCEEDED, xrEndFrame(c.session, &end));
    end.layerCount = 0;
    XR_OK(xrEndFrame(c.session, &end));
    client_stop(&c);
}

static void sessions_need_a_good_device(void **state) {
    (void)state;
    client_settings(NULL);
    struct client c = {0};
    client_make_instance(&c);
    XrGraphicsBindingVulkanKHR b;
    XrSessionCreateInfo info = client_session_info(&c, &b);
    XrSession session;
    XR_IS(XR_ERROR_GRAPHICS_REQUIREMENTS_CALL_MISSING,
          xrCreateSession(c.instance, &info, &session));
    client_make_device(&c);
    info = client_session_info(&c, &b);
    info.next = NULL;
    XR_IS(XR_ERROR_GRAPHICS_DEVICE_INVALID, xrCreateSession(c.instance, &info, &session));
    info.next = &b;
    b.device = VK_NULL_HANDLE;
    XR_IS(XR_ERROR_GRAPHICS_DEVICE_INVALID, xrCreateSession(c.instance, &info, &session));
    info = client_session_info(&c, &b);
    b.queueFamilyIndex = 99;
    XR_IS(XR_ERROR_GRAPHICS_DEVICE_INVALID, xrCreateSession(c.instance, &info, &session));
    info = client_session_info(&c, &b);
    info.systemId = 77;
    XR_IS(XR_ERROR_SYSTEM_INVALID, xrCreateSession(c.instance, &info, &session));
    info.systemId = c.system;
    XR_OK(xrCreateSession(c.instance, &info, &session));
    XrSession second;
    XR_IS(XR_ERROR_LIMIT_REACHED, xrCreateSession(c.instance, &info, &second));
    XR_OK(xrDestroySession(session));
    XR_OK(xrCreateSession(c.instance, &info, &session)); // again, and its events are its own
    XrEventDataBuffer event = {.type = XR_TYPE_EVENT_DATA_BUFFER};
    int events = 0;
    while (xrPollEvent(c.instance, &event) == XR_SUCCESS)
        events++;
    assert_int_equal(events, 2); // IDLE and READY of the second session
    XR_OK(xrDestroySession(session));
    client_stop(&c);
}

static void the_real_clock_keeps_the_headsets_rate(void **state) {
    (void)state;
    client_settings("{\"refresh_hz\": 50}");
    struct client c = {0};
    client_start(&c);
    XrTime first = 0, last = 0;
    for (int k = 0; k < 11; k++) {
        XrFrameState f = client_wait(&c);
        assert_true(f.shouldRender);
        assert_int_equal(f.predictedDisplayPeriod, 20000000);
        if (k == 0)
            first = f.predictedDisplayTime;
        else
            assert_int_equal((f.predictedDisplayTime - first) % 20000000, 0); // on the grid
        assert_true(f.predictedDisplayTime > last);
        last = f.predictedDisplayTime;
        client_begin(&c);
        client_end_empty(&c, f.predictedDisplayTime);
    }
    assert_true(last - first >= 10 * 20000000LL); // later only where the machine is busy
    client_stop(&c);
}

static void bad_settings_say_where_and_make_no_instance(void **state) {
    (void)state;
    static const char *const bad[] = {
        "{\"clock\": \"slow\"}",
        "{\"clok\": \"real\"}",
        "{\"poses\": {\"logs\": [\"nowhere.csv\"]}}",
        "{\"poses\": {\"script\": \"run\"}}",
        "{\"headset\": {\"name\": \"x\"}}",
        "{\"frames\": 0}",
        "{",
    };
    XrInstance instance;
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        client_settings(bad[i]);
        XR_IS(XR_ERROR_INITIALIZATION_FAILED, client_try_instance(&instance));
    }
    setenv("ANTIPODE_SIM", "/nonexistent/settings.json", 1);
    XR_IS(XR_ERROR_INITIALIZATION_FAILED, client_try_instance(&instance));
    setenv("ANTIPODE_SIM", "", 1); // as good as unset
    XR_OK(client_try_instance(&instance));
    XR_OK(xrDestroyInstance(instance));
    client_settings(NULL);
    XR_OK(client_try_instance(&instance));
    XrInstanceProperties p = {.type = XR_TYPE_INSTANCE_PROPERTIES};
    XR_OK(xrGetInstanceProperties(instance, &p));
    assert_string_equal(p.runtimeName, "antipode simulated headset");
    XR_OK(xrDestroyInstance(instance));
}

static void a_session_may_do_without_graphics(void **state) {
    (void)state;
    client_settings("{\"clock\": \"virtual\", \"frames\": 2}");
    const char *const extensions[] = {XR_MND_HEADLESS_EXTENSION_NAME,
                                      XR_KHR_CONVERT_TIMESPEC_TIME_EXTENSION_NAME};
    XrInstanceCreateInfo info = {
        .type = XR_TYPE_INSTANCE_CREATE_INFO,
        .applicationInfo = {.applicationName = "test", .apiVersion = XR_MAKE_VERSION(1, 0, 0)},
        .enabledExtensionCount = 2,
        .enabledExtensionNames = extensions};
    struct client c = {.system = 1};
    XR_OK(xrCreateInstance(&info, &c.instance));
    XrSystemGetInfo get = {.type = XR_TYPE_SYSTEM_GET_INFO,
                           .formFactor = XR_FORM_FACTOR_HEAD_MOUNTED_DISPLAY};
    XR_OK(xrGetSystem(c.instance, &get, &c.system));
    PFN_xrConvertTimespecTimeToTimeKHR to_time;
    PFN_xrConvertTimeToTimespecTimeKHR to_timespec;
    *(void **)&to_time = client_proc(c.instance, "xrConvertTimespecTimeToTimeKHR");
    *(void **)&to_timespec = client_proc(c.instance, "xrConvertTimeToTimespecTimeKHR");
    struct timespec now, back;
    XrTime time;
    clock_gettime(CLOCK_MONOTONIC, &now);
    XR_OK(to_time(c.instance, &now, &time));
    assert_true(time >= 1000000000 && time < 2000000000);
    XR_OK(to_timespec(c.instance, time, &back));
    assert_true(back.tv_sec == now.tv_sec && back.tv_nsec == now.tv_nsec);
    XR_IS(XR_ERROR_TIME_INVALID, to_timespec(c.instance, 0, &back));
    PFN_xrVoidFunction none;
    XR_IS(XR_ERROR_FUNCTION_UNSUPPORTED, // of an extension that is not enabled
          xrGetInstanceProcAddr(c.instance, "xrCreateVulkanInstanceKHR", &none));

    XrSessionCreateInfo create = {.type = XR_TYPE_SESSION_CREATE_INFO, .systemId = c.system};
    XR_OK(xrCreateSession(c.instance, &create, &c.session));
    XrSessionBeginInfo begin = {.type = XR_TYPE_SESSION_BEGIN_INFO};
    XR_OK(xrBeginSession(c.session, &begin));
    client_poll(&c);
    assert_int_equal(c.state, XR_SESSION_STATE_FOCUSED); // without a frame loop
    uint32_t formats;
    XR_OK(xrEnumerateSwapchainFormats(c.session, 0, &formats, NULL));
    assert_int_equal(formats, 0);
    for (int k = 0; k < 2; k++) {
        XrFrameState f = client_wait(&c);
        assert_false(f.shouldRender);
        client_begin(&c);
        client_end_empty(&c, f.predictedDisplayTime);
    }
    client_poll(&c);
    assert_int_equal(c.state, XR_SESSION_STATE_STOPPING);
    client_stop(&c);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(a_log_on_the_virtual_clock_gives_exactly_its_frames,
                                  client_teardown),
        cmocka_unit_test_teardown(the_settings_may_ask_for_fewer_frames, client_teardown),
        cmocka_unit_test_teardown(every_frame_is_rendered_where_asked, client_teardown),
        cmocka_unit_test_teardown(captured_frames_are_rendered_and_others_are_not, client_teardown),
        cmocka_unit_test_teardown(states_come_in_their_order, client_teardown),
        cmocka_unit_test_teardown(frame_calls_out_of_order_are_refused, client_teardown),
        cmocka_unit_test_teardown(sessions_need_a_good_device, client_teardown),
        cmocka_unit_test_teardown(the_real_clock_keeps_the_headsets_rate, client_teardown),
        cmocka_unit_test_teardown(a_session_may_do_without_graphics, client_teardown),
        cmocka_unit_test_teardown(bad_settings_say_where_and_make_no_instance, client_teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
