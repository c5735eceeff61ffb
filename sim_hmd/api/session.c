#include <stdlib.h>

#include "sim_hmd/capture/session.h"
#include "sim_hmd/compose/frame.h"
#include "sim_hmd/core/device.h"
#include "sim_hmd/core/swapchains.h"
#include "sim_hmd/input/source.h"
#include "src/base/clock.h"
#include "src/base/log.h"

// Sessions: creation on the program's Vulkan device, and the calls that move the state machine.

// In the order of preference. The first sRGB one is what programs take.
static const VkFormat colour_formats[] = {
    VK_FORMAT_R8G8B8A8_SRGB,          VK_FORMAT_B8G8R8A8_SRGB,
    VK_FORMAT_R8G8B8A8_UNORM,         VK_FORMAT_B8G8R8A8_UNORM,
    VK_FORMAT_R16G16B16A16_SFLOAT,    VK_FORMAT_A2B10G10R10_UNORM_PACK32,
    VK_FORMAT_B10G11R11_UFLOAT_PACK32};
static const VkFormat depth_formats[] = {VK_FORMAT_D32_SFLOAT, VK_FORMAT_D16_UNORM,
                                         VK_FORMAT_D24_UNORM_S8_UINT, VK_FORMAT_D32_SFLOAT_S8_UINT};

static void list_formats(struct sim_session *session, const VkFormat *formats, size_t count,
                         VkFormatFeatureFlags needed) {
    for (size_t i = 0; i < count; i++) {
        VkFormatProperties properties;
        vkGetPhysicalDeviceFormatProperties(session->gpu.physical_device, formats[i], &properties);
        if ((properties.optimalTilingFeatures & needed) == needed)
            session->formats[session->format_count++] = formats[i];
    }
}

static const XrGraphicsBindingVulkanKHR *find_binding(const XrSessionCreateInfo *info) {
    const XrBaseInStructure *s = info->next;
    while (s && s->type != XR_TYPE_GRAPHICS_BINDING_VULKAN_KHR)
        s = s->next;
    return (const XrGraphicsBindingVulkanKHR *)s;
}

static XrResult check_binding(const XrGraphicsBindingVulkanKHR *b) {
    if (!b->instance || !b->physicalDevice || !b->device)
        return XR_ERROR_GRAPHICS_DEVICE_INVALID;
    VkPhysicalDevice chosen;
    XrResult result = sim_choose_device(b->instance, &chosen);
    if (result == XR_ERROR_OUT_OF_MEMORY)
        return result;
    if (result != XR_SUCCESS || chosen != b->physicalDevice)
        return XR_ERROR_GRAPHICS_DEVICE_INVALID;
    uint32_t count = 0;
    vkGetPhysicalDeviceQueueFamilyProperties(b->physicalDevice, &count, NULL);
    return b->queueFamilyIndex < count ? XR_SUCCESS : XR_ERROR_GRAPHICS_DEVICE_INVALID;
}

static XrResult open_device(struct sim_session *session, const XrGraphicsBindingVulkanKHR *b) {
    struct ap_error err;
    if (ap_gpu_init(&err, b->instance, b->physicalDevice, b->device, b->queueFamilyIndex,
                    b->queueIndex, &session->gpu)) {
        ap_log(AP_LOG_ERROR, "%s", err.text);
        return XR_ERROR_GRAPHICS_DEVICE_INVALID;
    }
    list_formats(session, colour_formats, sizeof colour_formats / sizeof *colour_formats,
                 VK_FORMAT_FEATURE_COLOR_ATTACHMENT_BIT | VK_FORMAT_FEATURE_SAMPLED_IMAGE_BIT |
                     VK_FORMAT_FEATURE_BLIT_SRC_BIT);
    list_formats(session, depth_formats, sizeof depth_formats / sizeof *depth_formats,
                 VK_FORMAT_FEATURE_DEPTH_STENCIL_ATTACHMENT_BIT);
    if (sim_compositor_create(&err, &session->gpu, &session->instance->settings,
                              &session->compositor) ||
        sim_session_capture_open(&err, session)) {
        ap_log(AP_LOG_ERROR, "%s", err.text);
        return XR_ERROR_RUNTIME_FAILURE;
    }
    return XR_SUCCESS;
}

static void free_session(struct sim_object *object) {
    struct sim_session *session = (struct sim_session *)object;
    sim_session_report(session);
    if (!session->headless && session->gpu.device) {
        sim_session_collect_garbage(session);
        sim_session_capture_close(session);
        sim_compositor_destroy(session->compositor);
        ap_gpu_finish(&session->gpu);
    }
    struct sim_instance *instance = session->instance;
    if (instance->session == session) {
        sim_events_forget(&instance->events, SIM_HANDLE(XrSession, session));
        instance->session = NULL;
    }
    sim_automation_finish(&session->automation);
    free(session->bindings);
    sim_labels_finish(&session->labels);
    free(session);
}

static int64_t frame_limit(const struct sim_instance *instance) {
    const struct sim_settings *s = &instance->settings;
    int64_t limit = s->frames ? s->frames : -1;
    if (s->clock == SIM_CLOCK_VIRTUAL) {
        int64_t recorded = sim_source_frame_count(instance->source, s->profile.refresh_hz);
        if (recorded >= 0 && (limit < 0 || recorded < limit))
            limit = recorded;
    }
    return limit;
}

static XrResult make_session(struct sim_instance *instance,
                             const XrGraphicsBindingVulkanKHR *binding, XrSession *out) {
    struct sim_session *session = calloc(1, sizeof *session);
    if (!session)
        return XR_ERROR_OUT_OF_MEMORY;
    const struct sim_settings *settings = &instance->settings;
    session->instance = instance;
    session->headless = !binding;
    session->windowed = binding && settings->window;
    session->watched = binding && (settings->window || settings->capture_dir);
    for (int eye = 0; eye < 2; eye++) {
        const struct ap_eye_profile *e = &settings->profile.eye[eye];
        session->fov[eye] =
            (XrFovf){(float)e->left_rad, (float)e->right_rad, (float)e->up_rad, (float)e->down_rad};
        session->view_from_eye[eye] = ap_headset_view_from_eye(&settings->profile, eye);
    }
    for (int top = 0; top < SIM_TOP_COUNT; top++)
        session->profile[top] = -1;
    session->frame_limit = frame_limit(instance);
    sim_pacer_init(&session->pacer, settings->clock, settings->profile.refresh_hz,
                   instance->epoch_ns);
    XrResult result = binding ? open_device(session, binding) : XR_SUCCESS;
    if (result == XR_SUCCESS &&
        !sim_object_add(&session->object, SIM_SESSION, &instance->object, free_session))
        result = XR_ERROR_LIMIT_REACHED;
    if (result != XR_SUCCESS) {
        free_session(&session->object);
        return result;
    }
    instance->session = session;
    int64_t now_ns = ap_clock_now_ns();
    sim_source_start(instance->source, sim_pacer_now(&session->pacer, now_ns), now_ns);
    sim_session_set_state(session, XR_SESSION_STATE_IDLE);
    sim_session_set_state(session, XR_SESSION_STATE_READY);
    *out = SIM_HANDLE(XrSession, session);
    return XR_SUCCESS;
}

XrResult XRAPI_CALL xrCreateSession(XrInstance handle, const XrSessionCreateInfo *info,
                                    XrSession *out) {
    SIM_LOCKED;
    struct sim_instance *instance = sim_instance_get(handle);
    if (!instance)
        return XR_ERROR_HANDLE_INVALID;
    if (!sim_is(info, XR_TYPE_SESSION_CREATE_INFO) || info->createFlags || !out)
        return XR_ERROR_VALIDATION_FAILURE;
    if (info->systemId != SIM_SYSTEM_ID)
        return XR_ERROR_SYSTEM_INVALID;
    const XrGraphicsBindingVulkanKHR *binding = find_binding(info);
    if (!binding && !instance->enabled[SIM_MND_headless])
        return XR_ERROR_GRAPHICS_DEVICE_INVALID;
    if (binding && !instance->enabled[SIM_KHR_vulkan_enable] &&
        !instance->enabled[SIM_KHR_vulkan_enable2])
        return XR_ERROR_GRAPHICS_DEVICE_INVALID;
    if (binding && !instance->requirements_called)
        return XR_ERROR_GRAPHICS_REQUIREMENTS_CALL_MISSING;
    XrResult result = binding ? check_binding(binding) : XR_SUCCESS;
    if (result != XR_SUCCESS)
        return result;
    if (instance->session)
        return XR_ERROR_LIMIT_REACHED;
    return make_session(instance, binding, out);
}

XrResult XRAPI_CALL xrDestroySession(XrSession handle) {
    SIM_LOCKED;
    struct sim_session *session = sim_object_get(sim_raw(handle), SIM_SESSION);
    if (!session)
        return XR_ERROR_HANDLE_INVALID;
    sim_object_destroy(&session->object);
    sim_wake();
    return XR_SUCCESS;
}

void sim_session_show(struct sim_session *session) {
    sim_session_set_state(session, XR_SESSION_STATE_SYNCHRONIZED);
    sim_session_set_state(session, XR_SESSION_STATE_VISIBLE);
    sim_session_set_state(session, XR_SESSION_STATE_FOCUSED);
}

XrResult XRAPI_CALL xrBeginSession(XrSession handle, const XrSessionBeginInfo *info) {
    SIM_LOCKED;
    struct sim_session *session;
    XrResult result = sim_session_get(handle, &session);
    if (result != XR_SUCCESS)
        return result;
    if (!sim_is(info, XR_TYPE_SESSION_BEGIN_INFO))
        return XR_ERROR_VALIDATION_FAILURE;
    if (session->running)
        return XR_ERROR_SESSION_RUNNING;
    if (session->state != XR_SESSION_STATE_READY)
        return XR_ERROR_SESSION_NOT_READY;
    if (!session->headless &&
        info->primaryViewConfigurationType != XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO)
        return XR_ERROR_VIEW_CONFIGURATION_TYPE_UNSUPPORTED;
    session->running = true;
    // A session without graphics need not run a frame loop (XR_MND_headless).
    if (session->headless)
        sim_session_show(session);
    if (session->exit_requested)
        sim_session_ask_to_end(session);
    return XR_SUCCESS;
}

XrResult XRAPI_CALL xrEndSession(XrSession handle) {
    SIM_LOCKED;
    struct sim_session *session;
    XrResult result = sim_session_get(handle, &session);
    if (result != XR_SUCCESS)
        return result;
    if (!session->running)
        return XR_ERROR_SESSION_NOT_RUNNING;
    if (session->state != XR_SESSION_STATE_STOPPING)
        return XR_ERROR_SESSION_NOT_STOPPING;
    struct ap_error err;
    if (session->compositor && (sim_compositor_flush(&err, session->compositor) ||
                                sim_session_capture_flush(&err, session))) {
        sim_session_lose(session, err.text);
        return XR_ERROR_SESSION_LOST;
    }
    session->running = session->waited = session->begun = false;
    sim_session_set_state(session, XR_SESSION_STATE_IDLE);
    sim_session_set_state(session, XR_SESSION_STATE_EXITING);
    sim_wake();
    return XR_SUCCESS;
}

XrResult XRAPI_CALL xrRequestExitSession(XrSession handle) {
    SIM_LOCKED;
    struct sim_session *session;
    XrResult result = sim_session_get(handle, &session);
    if (result != XR_SUCCESS)
        return result;
    if (!session->running)
        return XR_ERROR_SESSION_NOT_RUNNING;
    session->exit_requested = true;
    // Through SYNCHRONIZED, also from READY, so that a program sees a lawful path of states.
    if (session->state == XR_SESSION_STATE_READY)
        sim_session_set_state(session, XR_SESSION_STATE_SYNCHRONIZED);
    sim_session_ask_to_end(session);
    return XR_SUCCESS;
}

XrResult XRAPI_CALL xrEnumerateSwapchainFormats(XrSession handle, uint32_t capacity,
                                                uint32_t *count, int64_t *formats) {
    SIM_LOCKED;
    struct sim_session *session;
    XrResult result = sim_session_get(handle, &session);
    if (result != XR_SUCCESS)
        return result;
    return sim_two_calls(capacity, count, session->format_count, session->formats,
                         sizeof *session->formats, formats);
}
