#include "tests/vm/headset.h"

#include "tests/vm/player.h"

static const int64_t MS = 1000000;

void headset_need(XrResult result, const char *what) {
    if (XR_FAILED(result))
        player_die("%s: %d", what, (int)result);
}

void headset_open(struct headset *h) {
    const char *extensions[] = {"XR_MND_headless", XR_KHR_CONVERT_TIMESPEC_TIME_EXTENSION_NAME};
    const XrInstanceCreateInfo info = {
        .type = XR_TYPE_INSTANCE_CREATE_INFO,
        .applicationInfo = {.applicationName = "vm", .apiVersion = XR_MAKE_VERSION(1, 0, 0)},
        .enabledExtensionCount = 2,
        .enabledExtensionNames = extensions};
    XrSystemGetInfo get = {.type = XR_TYPE_SYSTEM_GET_INFO,
                           .formFactor = XR_FORM_FACTOR_HEAD_MOUNTED_DISPLAY};
    XrSessionCreateInfo session = {.type = XR_TYPE_SESSION_CREATE_INFO};
    headset_need(xrCreateInstance(&info, &h->instance), "xrCreateInstance");
    headset_need(xrGetSystem(h->instance, &get, &session.systemId), "xrGetSystem");
    headset_need(xrCreateSession(h->instance, &session, &h->session), "xrCreateSession");
    headset_need(xrGetInstanceProcAddr(h->instance, "xrConvertTimespecTimeToTimeKHR",
                                       (PFN_xrVoidFunction *)&h->to_time),
                 "xrConvertTimespecTimeToTimeKHR");
    XrReferenceSpaceCreateInfo space = {.type = XR_TYPE_REFERENCE_SPACE_CREATE_INFO,
                                        .poseInReferenceSpace.orientation.w = 1};
    space.referenceSpaceType = XR_REFERENCE_SPACE_TYPE_VIEW;
    headset_need(xrCreateReferenceSpace(h->session, &space, &h->view), "VIEW");
    space.referenceSpaceType = XR_REFERENCE_SPACE_TYPE_STAGE;
    headset_need(xrCreateReferenceSpace(h->session, &space, &h->stage), "STAGE");
}

void headset_begin(const struct headset *h) {
    XrEventDataBuffer event = {.type = XR_TYPE_EVENT_DATA_BUFFER};
    for (int64_t end = player_now_ns() + 5000 * MS; player_now_ns() < end;) {
        const XrEventDataSessionStateChanged *changed = (const void *)&event;
        event.type = XR_TYPE_EVENT_DATA_BUFFER;
        if (xrPollEvent(h->instance, &event) == XR_EVENT_UNAVAILABLE)
            nanosleep(&(struct timespec){.tv_nsec = MS}, NULL);
        else if (event.type == XR_TYPE_EVENT_DATA_SESSION_STATE_CHANGED &&
                 changed->state == XR_SESSION_STATE_READY) {
            const XrSessionBeginInfo info = {.type = XR_TYPE_SESSION_BEGIN_INFO,
                                             .primaryViewConfigurationType =
                                                 XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO};
            headset_need(xrBeginSession(h->session, &info), "xrBeginSession");
            return;
        }
    }
    player_die("the session does not become ready");
}

XrTime headset_time(const struct headset *h, int64_t t_ns) {
    const struct timespec ts = {.tv_sec = t_ns / 1000000000, .tv_nsec = t_ns % 1000000000};
    XrTime time;
    headset_need(h->to_time(h->instance, &ts, &time), "xrConvertTimespecTimeToTimeKHR");
    return time;
}

XrSpaceLocation headset_locate(const struct headset *h, XrSpace space, XrTime time) {
    XrSpaceLocation at = {.type = XR_TYPE_SPACE_LOCATION};
    headset_need(xrLocateSpace(space, h->stage, time, &at), "xrLocateSpace");
    return at;
}

void headset_close(struct headset *h) {
    xrDestroySession(h->session);
    xrDestroyInstance(h->instance);
}
