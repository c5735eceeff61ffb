#include "tests/sim_hmd/report.h"

#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>

// The lint: a program that is wrong in as many ways as there are calls hears of each by its name,
// and one that is right hears nothing. The functions are the runtime's own, past the loader, which
// would catch some of it.

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
                                              .sourcePath = get.subactionPath};
    uint32_t n;
    WRONG(XR_ERROR_VALIDATION_FAILURE,
          RT(xrGetInputSourceLocalizedName)(c->session, &name, 0, &n, NULL),
          "xrGetInputSourceLocalizedName",
          "VUID-XrInputSourceLocalizedNameGetInfo-whichComponents-requiredbitmask");
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
    return report_statements >= 90 ? 0 : 1;
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(a_right_program_hears_nothing, client_teardown),
        cmocka_unit_test_teardown(structures_are_told, client_teardown),
        cmocka_unit_test_teardown(instance_calls_are_told, client_teardown),
        cmocka_unit_test_teardown(sessions_are_told, client_teardown),
        cmocka_unit_test_teardown(frames_are_told, client_teardown),
        cmocka_unit_test_teardown(layers_are_told, client_teardown),
        cmocka_unit_test_teardown(doubtful_frames_are_told, client_teardown),
        cmocka_unit_test_teardown(swapchains_are_told, client_teardown),
        cmocka_unit_test_teardown(names_are_told, client_teardown),
        cmocka_unit_test_teardown(actions_are_told, client_teardown),
        cmocka_unit_test_teardown(overlapping_calls_are_told, client_teardown),
        cmocka_unit_test_teardown(extensions_not_enabled_are_told, client_teardown),
        cmocka_unit_test_teardown(a_report_is_summed_up, client_teardown),
        cmocka_unit_test_teardown(a_full_report_ends_nobody, client_teardown),
    };
    return cmocka_run_group_tests(tests, NULL, enough_statements);
}
