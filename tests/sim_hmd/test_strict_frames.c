#include "tests/sim_hmd/report.h"

#include <pthread.h>
#include <stdio.h>
#include <string.h>

// The lint on frames, layers and swapchains: what is wrong is told by its name, and a program that
// is right hears nothing.

static XrSwapchain make_swapchain_of(struct client *c, XrSwapchainUsageFlags usage,
                                     int64_t format) {
    XrSwapchainCreateInfo info = {.type = XR_TYPE_SWAPCHAIN_CREATE_INFO,
                                  .usageFlags = usage,
                                  .format = format,
                                  .sampleCount = 1,
                                  .width = 32,
                                  .height = 32,
                                  .faceCount = 1,
                                  .arraySize = 1,
                                  .mipCount = 1};
    XrSwapchain swapchain = XR_NULL_HANDLE;
    XR_OK(RT(xrCreateSwapchain)(c->session, &info, &swapchain));
    return swapchain;
}

static XrSwapchain make_swapchain(struct client *c) {
    uint32_t n;
    int64_t formats[32];
    XR_OK(RT(xrEnumerateSwapchainFormats)(c->session, 32, &n, formats));
    return make_swapchain_of(c, XR_SWAPCHAIN_USAGE_COLOR_ATTACHMENT_BIT, formats[0]);
}

static XrSwapchain make_depth(struct client *c) {
    return make_swapchain_of(c, XR_SWAPCHAIN_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT,
                             VK_FORMAT_D16_UNORM);
}

static void draw(struct client *c, XrSwapchain swapchain) {
    uint32_t index;
    XrSwapchainImageWaitInfo wait = {.type = XR_TYPE_SWAPCHAIN_IMAGE_WAIT_INFO,
                                     .timeout = 1000000000};
    XR_OK(RT(xrAcquireSwapchainImage)(swapchain, NULL, &index));
    XR_OK(RT(xrWaitSwapchainImage)(swapchain, &wait));
    XR_OK(RT(xrReleaseSwapchainImage)(swapchain, NULL));
}

static XrResult locate(struct client *c, XrTime time, XrSpace space, XrView *views) {
    XrViewLocateInfo info = {.type = XR_TYPE_VIEW_LOCATE_INFO,
                             .viewConfigurationType = XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO,
                             .displayTime = time,
                             .space = space};
    XrViewState state = {.type = XR_TYPE_VIEW_STATE};
    uint32_t n;
    views[0] = views[1] = (XrView){.type = XR_TYPE_VIEW};
    return RT(xrLocateViews)(c->session, &info, &state, 2, &n, views);
}

// A frame's end with one projection layer, to be spoiled by the test.
struct ending {
    XrCompositionLayerProjectionView views[2];
    XrCompositionLayerProjection layer;
    const XrCompositionLayerBaseHeader *layers[1];
    XrFrameEndInfo info;
};

static void make_ending(struct ending *e, struct client *c, XrTime time, XrSwapchain swapchain,
                        const XrView *located) {
    memset(e, 0, sizeof *e);
    for (int i = 0; i < 2; i++) {
        e->views[i].type = XR_TYPE_COMPOSITION_LAYER_PROJECTION_VIEW;
        e->views[i].pose = located[i].pose;
        e->views[i].fov = located[i].fov;
        e->views[i].subImage.swapchain = swapchain;
        e->views[i].subImage.imageRect.extent = (XrExtent2Di){32, 32};
    }
    e->layer = (XrCompositionLayerProjection){.type = XR_TYPE_COMPOSITION_LAYER_PROJECTION,
                                              .space = c->stage,
                                              .viewCount = 2,
                                              .views = e->views};
    e->layers[0] = (const XrCompositionLayerBaseHeader *)&e->layer;
    e->info = (XrFrameEndInfo){.type = XR_TYPE_FRAME_END_INFO,
                               .displayTime = time,
                               .environmentBlendMode = XR_ENVIRONMENT_BLEND_MODE_OPAQUE,
                               .layerCount = 1,
                               .layers = e->layers};
}

static XrFrameState wait_and_begin(struct client *c) {
    XrFrameState f = {.type = XR_TYPE_FRAME_STATE};
    XR_OK(RT(xrWaitFrame)(c->session, NULL, &f));
    assert_true(RT(xrBeginFrame)(c->session, NULL) >= 0); // after a failed end: discarded
    return f;
}

static XrResult end(struct client *c, struct ending *e) {
    return RT(xrEndFrame)(c->session, &e->info);
}

static void end_empty(struct client *c, XrTime time) {
    XrFrameEndInfo info = {.type = XR_TYPE_FRAME_END_INFO,
                           .displayTime = time,
                           .environmentBlendMode = XR_ENVIRONMENT_BLEND_MODE_OPAQUE};
    XR_OK(RT(xrEndFrame)(c->session, &info));
}

static void ask_blend_modes(struct client *c) {
    uint32_t n;
    XR_OK(RT(xrEnumerateEnvironmentBlendModes)(
        c->instance, c->system, XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO, 0, &n, NULL));
}

static void destroy_spaces(struct client *c) {
    XR_OK(RT(xrDestroySpace)(c->view));
    XR_OK(RT(xrDestroySpace)(c->local));
    XR_OK(RT(xrDestroySpace)(c->stage));
}

static void end_session(struct client *c) {
    XR_OK(RT(xrRequestExitSession)(c->session));
    client_poll(c);
    XR_OK(RT(xrEndSession)(c->session));
}

// A program that does all as it should.
static void a_right_program_hears_nothing(void **unused) {
    (void)unused;
    struct client program = {0}, *c = &program;
    report_start(c);
    ask_blend_modes(c);
    XrSwapchain swapchain = make_swapchain(c);
    for (int k = 0; k < 12; k++) {
        client_poll(c);
        XrFrameState f = wait_and_begin(c);
        XrView views[2];
        XR_OK(locate(c, f.predictedDisplayTime, c->stage, views));
        if (!f.shouldRender) {
            end_empty(c, f.predictedDisplayTime);
            continue;
        }
        draw(c, swapchain);
        struct ending e;
        make_ending(&e, c, f.predictedDisplayTime, swapchain, views);
        XR_OK(end(c, &e));
    }
    end_session(c);
    XR_OK(RT(xrDestroySwapchain)(swapchain));
    destroy_spaces(c);
    SAYS_NOTHING();
    report_stop(c);
    assert_int_equal(report_errors, 0);
}

static void frames_are_told(void **unused) {
    (void)unused;
    struct client program = {0}, *c = &program;
    report_start(c);
    WRONG(XR_ERROR_CALL_ORDER_INVALID, RT(xrBeginFrame)(c->session, NULL), "xrBeginFrame",
          "XR_ERROR_CALL_ORDER_INVALID: Frame Submission");
    XrFrameState f = {.type = XR_TYPE_FRAME_STATE, .next = NULL};
    XrFrameWaitInfo wait = {.type = XR_TYPE_FRAME_BEGIN_INFO};
    WRONG(XR_ERROR_VALIDATION_FAILURE, RT(xrWaitFrame)(c->session, &wait, &f), "xrWaitFrame",
          "VUID-XrFrameWaitInfo-type-type");
    WRONG(XR_ERROR_VALIDATION_FAILURE, RT(xrWaitFrame)(c->session, NULL, NULL), "xrWaitFrame",
          "VUID-xrWaitFrame-frameState-parameter");
    f = wait_and_begin(c);
    SAYS_NOTHING();
    XrFrameEndInfo info = {.type = XR_TYPE_FRAME_END_INFO,
                           .displayTime = f.predictedDisplayTime,
                           .environmentBlendMode = (XrEnvironmentBlendMode)9};
#define ENDED(result, statement)                                                                   \
    WRONG(result, RT(xrEndFrame)(c->session, &info), "xrEndFrame", statement)
    ENDED(XR_ERROR_VALIDATION_FAILURE, "VUID-XrFrameEndInfo-environmentBlendMode-parameter");
    info.environmentBlendMode = XR_ENVIRONMENT_BLEND_MODE_ADDITIVE;
    ENDED(XR_ERROR_ENVIRONMENT_BLEND_MODE_UNSUPPORTED,
          "XR_ERROR_ENVIRONMENT_BLEND_MODE_UNSUPPORTED: Environment Blend Mode");
    info.environmentBlendMode = XR_ENVIRONMENT_BLEND_MODE_OPAQUE;
    info.displayTime = 0;
    ENDED(XR_ERROR_TIME_INVALID, "XR_ERROR_TIME_INVALID: Time");
    info.displayTime = f.predictedDisplayTime;
    info.layerCount = 1;
    ENDED(XR_ERROR_VALIDATION_FAILURE, "VUID-XrFrameEndInfo-layers-parameter");
    info.layerCount = 0;
    info.type = XR_TYPE_FRAME_STATE;
    ENDED(XR_ERROR_VALIDATION_FAILURE, "VUID-XrFrameEndInfo-type-type");
    info.type = XR_TYPE_FRAME_END_INFO;
    info.displayTime += 5;
    ENDED(XR_SUCCESS, "USE-frame-displayTime");
    ENDED(XR_ERROR_CALL_ORDER_INVALID, "XR_ERROR_CALL_ORDER_INVALID: Frame Submission");
    wait_and_begin(c);
    XR_OK(RT(xrWaitFrame)(c->session, NULL, &f));
    SAYS_NOTHING();
    WRONG(XR_FRAME_DISCARDED, RT(xrBeginFrame)(c->session, NULL), "xrBeginFrame",
          "USE-frame-discarded");
    for (int k = 0; k < 110; k++)
        f = wait_and_begin(c), end_empty(c, f.predictedDisplayTime);
    SAYS("xrWaitFrame", "USE-events-not-polled");
    XR_OK(RT(xrDestroySession)(c->session));
    SAYS("xrDestroySession", "USE-session-not-ended");
    c->session = XR_NULL_HANDLE;
    report_stop(c);
}

static void layers_are_told(void **unused) {
    (void)unused;
    struct client program = {0}, *c = &program;
    report_start(c);
    ask_blend_modes(c);
    XrSwapchain swapchain = make_swapchain(c);
    client_poll(c);
    XrFrameState f = wait_and_begin(c);
    XrView views[2];
    struct ending e;
    XrQuaternionf q;
    XrFovf fov;
    XR_OK(locate(c, f.predictedDisplayTime, c->stage, views));
    make_ending(&e, c, f.predictedDisplayTime, swapchain, views);
    SAYS_NOTHING();
#define END(result, statement) WRONG(result, end(c, &e), "xrEndFrame", statement)
    END(XR_ERROR_LAYER_INVALID, "XR_ERROR_LAYER_INVALID: Composition");
    draw(c, swapchain);
    e.layer.layerFlags = 0x100;
    end(c, &e);
    SAYS("xrEndFrame", "VUID-XrCompositionLayerProjection-layerFlags-parameter");
    f = wait_and_begin(c);
    XR_OK(locate(c, f.predictedDisplayTime, c->stage, views));
    make_ending(&e, c, f.predictedDisplayTime, swapchain, views);
    report_news();
    e.layer.space = XR_NULL_HANDLE;
    END(XR_ERROR_HANDLE_INVALID, "VUID-XrCompositionLayerProjection-space-parameter");
    e.layer.space = c->stage;
    e.layer.viewCount = 0;
    END(XR_ERROR_VALIDATION_FAILURE, "VUID-XrCompositionLayerProjection-views-arraylength");
    e.layer.viewCount = 2;
    e.layer.views = NULL;
    END(XR_ERROR_VALIDATION_FAILURE, "VUID-XrCompositionLayerProjection-views-parameter");
    e.layer.views = e.views;
    e.views[1].type = XR_TYPE_VIEW;
    END(XR_ERROR_VALIDATION_FAILURE, "VUID-XrCompositionLayerProjectionView-type-type");
    e.views[1].type = XR_TYPE_COMPOSITION_LAYER_PROJECTION_VIEW;
    e.views[0].subImage.swapchain = (XrSwapchain)c->stage;
    END(XR_ERROR_HANDLE_INVALID, "VUID-XrSwapchainSubImage-swapchain-parameter");
    e.views[0].subImage.swapchain = swapchain;
    e.views[0].subImage.imageRect.extent.width = 33;
    END(XR_ERROR_SWAPCHAIN_RECT_INVALID, "XR_ERROR_SWAPCHAIN_RECT_INVALID: Composition");
    e.views[0].subImage.imageRect.extent.width = 32;
    q = e.views[0].pose.orientation;
    e.views[0].pose.orientation = (XrQuaternionf){0, 0, 0, 0};
    END(XR_ERROR_POSE_INVALID, "XR_ERROR_POSE_INVALID: XrCompositionLayerProjectionView::pose");
    e.views[0].pose.orientation = q;
    fov = e.views[0].fov;
    e.views[0].fov.angleUp = 2;
    end(c, &e);
    SAYS("xrEndFrame", "XrFovf: XrCompositionLayerProjectionView::fov");
    e.views[0].fov = fov;
    const XrCompositionLayerBaseHeader *null_layer = NULL;
    e.info.layers = &null_layer;
    WRONG(XR_ERROR_LAYER_INVALID, end(c, &e), "xrEndFrame", "VUID-XrFrameEndInfo-layers-parameter");
    XrCompositionLayerDepthInfoKHR depth = {.type = XR_TYPE_COMPOSITION_LAYER_DEPTH_INFO_KHR};
    e.info.layers = e.layers;
    e.views[0].next = &depth;
    end(c, &e);
    SAYS("xrEndFrame", "VUID-XrCompositionLayerProjectionView-next-next");
    report_stop(c);
}

static void doubtful_frames_are_told(void **unused) {
    (void)unused;
    struct client program = {0}, *c = &program;
    report_start(c);
    XrSwapchain swapchain = make_swapchain(c), spare = make_swapchain(c);
    XrView views[2], old[2];
    struct ending e;
    XrFrameState f = wait_and_begin(c); // frame 0 is drawn
    XR_OK(locate(c, f.predictedDisplayTime, c->stage, old));
    draw(c, swapchain);
    draw(c, spare);
    make_ending(&e, c, f.predictedDisplayTime, swapchain, old);
    WRONG(XR_SUCCESS, end(c, &e), "xrEndFrame", "USE-blend-mode-unasked");
    ask_blend_modes(c);
    f = wait_and_begin(c); // frame 1 is not
    make_ending(&e, c, f.predictedDisplayTime, swapchain, old);
    WRONG(XR_SUCCESS, end(c, &e), "xrEndFrame", "USE-views-not-located");
    f = wait_and_begin(c);
    WRONG(XR_SUCCESS, locate(c, f.predictedDisplayTime + 7, c->stage, views), "xrLocateViews",
          "USE-views-time");
    XR_OK(locate(c, f.predictedDisplayTime, c->stage, views));
    make_ending(&e, c, f.predictedDisplayTime, swapchain, old);
    WRONG(XR_SUCCESS, end(c, &e), "xrEndFrame", "USE-views-other-time");
    f = wait_and_begin(c);
    XR_OK(locate(c, f.predictedDisplayTime, c->stage, views));
    make_ending(&e, c, f.predictedDisplayTime, swapchain, views);
    e.views[0].pose.position.x += 1;
    WRONG(XR_SUCCESS, end(c, &e), "xrEndFrame", "USE-views-unused");
    f = wait_and_begin(c);
    assert_false(f.shouldRender);
    XR_OK(locate(c, f.predictedDisplayTime, c->stage, views));
    draw(c, swapchain);
    make_ending(&e, c, f.predictedDisplayTime, swapchain, views);
    WRONG(XR_SUCCESS, end(c, &e), "xrEndFrame", "USE-should-render");
    f = wait_and_begin(c);
    XR_OK(locate(c, f.predictedDisplayTime, c->stage, views));
    uint32_t index;
    XR_OK(RT(xrAcquireSwapchainImage)(swapchain, NULL, &index));
    make_ending(&e, c, f.predictedDisplayTime, swapchain, views);
    e.views[0].fov = (XrFovf){0.8f, -0.8f, 0.8f, -0.8f};
    WRONG(XR_SUCCESS, end(c, &e), "xrEndFrame", "USE-image-acquired-at-end");
    WRONG(XR_SUCCESS, RT(xrDestroySwapchain)(swapchain), "xrDestroySwapchain",
          "USE-image-not-released");
    WRONG(XR_SUCCESS, RT(xrDestroySwapchain)(spare), "xrDestroySwapchain",
          "USE-image-never-submitted");
    spare = make_depth(c);
    draw(c, spare);
    WRONG(XR_SUCCESS, RT(xrDestroySwapchain)(spare), "xrDestroySwapchain",
          "USE-depth-never-submitted");
    XR_OK(RT(xrRequestExitSession)(c->session));
    client_poll(c);
    for (int k = 0; k < 12; k++)
        f = wait_and_begin(c), end_empty(c, f.predictedDisplayTime);
    SAYS("xrWaitFrame", "USE-stopping-ignored");
    XR_OK(RT(xrEndSession)(c->session));
    XR_OK(xrDestroyInstance(c->instance));
    SAYS("xrDestroyInstance", "USE-children-alive");
    c->session = XR_NULL_HANDLE;
    c->instance = XR_NULL_HANDLE;
    client_stop(c);
}

static void swapchains_are_told(void **unused) {
    (void)unused;
    struct client program = {0}, *c = &program;
    report_start(c);
    XrSwapchain swapchain = make_swapchain(c), other;
    uint32_t index;
    WRONG(XR_ERROR_VALIDATION_FAILURE, RT(xrAcquireSwapchainImage)(swapchain, NULL, NULL),
          "xrAcquireSwapchainImage", "VUID-xrAcquireSwapchainImage-index-parameter");
    XrSwapchainImageWaitInfo wait = {.type = XR_TYPE_SWAPCHAIN_IMAGE_WAIT_INFO,
                                     .timeout = XR_INFINITE_DURATION};
    WRONG(XR_ERROR_CALL_ORDER_INVALID, RT(xrWaitSwapchainImage)(swapchain, &wait),
          "xrWaitSwapchainImage", "XR_ERROR_CALL_ORDER_INVALID: Swapchain Images");
    XR_OK(RT(xrAcquireSwapchainImage)(swapchain, NULL, &index));
    WRONG(XR_ERROR_CALL_ORDER_INVALID, RT(xrReleaseSwapchainImage)(swapchain, NULL),
          "xrReleaseSwapchainImage", "XR_ERROR_CALL_ORDER_INVALID: Swapchain Images");
    WRONG(XR_SUCCESS, RT(xrWaitSwapchainImage)(swapchain, &wait), "xrWaitSwapchainImage",
          "USE-wait-forever");
    WRONG(XR_ERROR_VALIDATION_FAILURE, RT(xrWaitSwapchainImage)(swapchain, NULL),
          "xrWaitSwapchainImage", "VUID-xrWaitSwapchainImage-waitInfo-parameter");
    XrResult result = XR_SUCCESS;
    while (result == XR_SUCCESS)
        result = RT(xrAcquireSwapchainImage)(swapchain, NULL, &index);
    assert_int_equal(result, XR_ERROR_CALL_ORDER_INVALID);
    SAYS("xrAcquireSwapchainImage", "XR_ERROR_CALL_ORDER_INVALID: Swapchain Images");
    uint32_t n;
    XrSwapchainImageVulkanKHR images[8] = {{.type = XR_TYPE_VIEW}, {.type = XR_TYPE_VIEW}};
    WRONG(XR_ERROR_VALIDATION_FAILURE,
          RT(xrEnumerateSwapchainImages)(swapchain, 8, &n, (XrSwapchainImageBaseHeader *)images),
          "xrEnumerateSwapchainImages", "VUID-XrSwapchainImageVulkanKHR-type-type");
    XrSwapchainCreateInfo info = {.type = XR_TYPE_SWAPCHAIN_CREATE_INFO, .format = 12345};
#define CREATED(result, statement)                                                                 \
    WRONG(result, RT(xrCreateSwapchain)(c->session, &info, &other), "xrCreateSwapchain", statement)
    CREATED(XR_ERROR_SWAPCHAIN_FORMAT_UNSUPPORTED,
            "XR_ERROR_SWAPCHAIN_FORMAT_UNSUPPORTED: Swapchain Images");
    info.usageFlags = 1ull << 40;
    CREATED(XR_ERROR_VALIDATION_FAILURE, "VUID-XrSwapchainCreateInfo-usageFlags-parameter");
    info.usageFlags = 0;
    info.createFlags = 1ull << 20;
    CREATED(XR_ERROR_VALIDATION_FAILURE, "VUID-XrSwapchainCreateInfo-createFlags-parameter");
    info.createFlags = 0;
    int64_t formats[32];
    XR_OK(RT(xrEnumerateSwapchainFormats)(c->session, 32, &n, formats));
    info.format = formats[0];
    CREATED(XR_ERROR_VALIDATION_FAILURE, "XrSwapchainCreateInfo: sizes and counts");
    WRONG(XR_ERROR_HANDLE_INVALID, RT(xrDestroySwapchain)((XrSwapchain)c->session),
          "xrDestroySwapchain", "VUID-xrDestroySwapchain-swapchain-parameter");
    report_stop(c);
}

// Two threads begin to wait for frames of one session.
static void *wait_too(void *data) {
    struct client *c = data;
    XrFrameState f = {.type = XR_TYPE_FRAME_STATE};
    return (void *)(intptr_t)RT(xrWaitFrame)(c->session, NULL, &f);
}

static void overlapping_calls_are_told(void **unused) {
    (void)unused;
    struct client program = {0}, *c = &program;
    report_start(c);
    wait_and_begin(c);
    XrFrameState f = {.type = XR_TYPE_FRAME_STATE};
    XR_OK(RT(xrWaitFrame)(c->session, NULL, &f)); // as a pipelined program does
    pthread_t threads[2];                         // each waits for a frame to be begun
    for (int i = 0; i < 2; i++)
        assert_int_equal(pthread_create(&threads[i], NULL, wait_too, c), 0);
    struct timespec moment = {.tv_nsec = 200000000};
    nanosleep(&moment, NULL);
    assert_int_equal(RT(xrBeginFrame)(c->session, NULL), XR_FRAME_DISCARDED);
    nanosleep(&moment, NULL);
    assert_int_equal(RT(xrBeginFrame)(c->session, NULL), XR_FRAME_DISCARDED);
    for (int i = 0; i < 2; i++)
        pthread_join(threads[i], NULL);
    SAYS("xrWaitFrame", "Threading Behavior: one xrWaitFrame at a time");
    report_stop(c);
}

static int enough_statements(void **unused) {
    (void)unused;
    printf("%d wrong uses told by name\n", report_statements);
    return report_statements >= 45 ? 0 : 1;
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(a_right_program_hears_nothing, client_teardown),
        cmocka_unit_test_teardown(frames_are_told, client_teardown),
        cmocka_unit_test_teardown(layers_are_told, client_teardown),
        cmocka_unit_test_teardown(doubtful_frames_are_told, client_teardown),
        cmocka_unit_test_teardown(swapchains_are_told, client_teardown),
        cmocka_unit_test_teardown(overlapping_calls_are_told, client_teardown),
    };
    return cmocka_run_group_tests(tests, NULL, enough_statements);
}
