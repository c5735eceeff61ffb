#include <float.h>
#include <stdio.h>

#include "sim_hmd/compose/frame.h"
#include "sim_hmd/core/instance.h"

// The one system: a head-mounted display with two views.

enum { MAX_IMAGE_PX = 16384, MAX_SAMPLES = 4 };

XrResult XRAPI_CALL xrGetSystem(XrInstance handle, const XrSystemGetInfo *info,
                                XrSystemId *system) {
    SIM_LOCKED;
    if (!sim_instance_get(handle))
        return XR_ERROR_HANDLE_INVALID;
    if (!sim_is(info, XR_TYPE_SYSTEM_GET_INFO) || !system)
        return XR_ERROR_VALIDATION_FAILURE;
    if (info->formFactor != XR_FORM_FACTOR_HEAD_MOUNTED_DISPLAY)
        return XR_ERROR_FORM_FACTOR_UNSUPPORTED;
    *system = SIM_SYSTEM_ID;
    return XR_SUCCESS;
}

static XrResult check_system(XrInstance handle, XrSystemId system, struct sim_instance **instance) {
    *instance = sim_instance_get(handle);
    if (!*instance)
        return XR_ERROR_HANDLE_INVALID;
    return system == SIM_SYSTEM_ID ? XR_SUCCESS : XR_ERROR_SYSTEM_INVALID;
}

static XrResult check_view(XrInstance handle, XrSystemId system, XrViewConfigurationType type,
                           struct sim_instance **instance) {
    XrResult result = check_system(handle, system, instance);
    if (result != XR_SUCCESS)
        return result;
    return type == XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO
               ? XR_SUCCESS
               : XR_ERROR_VIEW_CONFIGURATION_TYPE_UNSUPPORTED;
}

XrResult XRAPI_CALL xrGetSystemProperties(XrInstance handle, XrSystemId system,
                                          XrSystemProperties *properties) {
    SIM_LOCKED;
    struct sim_instance *instance;
    XrResult result = check_system(handle, system, &instance);
    if (result != XR_SUCCESS)
        return result;
    if (!sim_is(properties, XR_TYPE_SYSTEM_PROPERTIES))
        return XR_ERROR_VALIDATION_FAILURE;
    properties->systemId = system;
    properties->vendorId = 0;
    snprintf(properties->systemName, sizeof properties->systemName, "%s",
             instance->settings.profile.name);
    properties->graphicsProperties =
        (XrSystemGraphicsProperties){MAX_IMAGE_PX, MAX_IMAGE_PX, SIM_MAX_LAYERS};
    properties->trackingProperties = (XrSystemTrackingProperties){XR_TRUE, XR_TRUE};
    XrSystemHandTrackingPropertiesEXT *hands =
        sim_chained(properties, XR_TYPE_SYSTEM_HAND_TRACKING_PROPERTIES_EXT);
    if (hands && instance->enabled[SIM_EXT_hand_tracking])
        hands->supportsHandTracking = XR_TRUE;
    return XR_SUCCESS;
}

XrResult XRAPI_CALL xrEnumerateEnvironmentBlendModes(XrInstance handle, XrSystemId system,
                                                     XrViewConfigurationType type,
                                                     uint32_t capacity, uint32_t *count,
                                                     XrEnvironmentBlendMode *modes) {
    SIM_LOCKED;
    struct sim_instance *instance;
    XrResult result = check_view(handle, system, type, &instance);
    if (result != XR_SUCCESS)
        return result;
    XrEnvironmentBlendMode opaque = XR_ENVIRONMENT_BLEND_MODE_OPAQUE;
    return sim_two_calls(capacity, count, 1, &opaque, sizeof opaque, modes);
}

XrResult XRAPI_CALL xrEnumerateViewConfigurations(XrInstance handle, XrSystemId system,
                                                  uint32_t capacity, uint32_t *count,
                                                  XrViewConfigurationType *types) {
    SIM_LOCKED;
    struct sim_instance *instance;
    XrResult result = check_system(handle, system, &instance);
    if (result != XR_SUCCESS)
        return result;
    XrViewConfigurationType stereo = XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO;
    return sim_two_calls(capacity, count, 1, &stereo, sizeof stereo, types);
}

XrResult XRAPI_CALL xrGetViewConfigurationProperties(XrInstance handle, XrSystemId system,
                                                     XrViewConfigurationType type,
                                                     XrViewConfigurationProperties *properties) {
    SIM_LOCKED;
    struct sim_instance *instance;
    XrResult result = check_view(handle, system, type, &instance);
    if (result != XR_SUCCESS)
        return result;
    if (!sim_is(properties, XR_TYPE_VIEW_CONFIGURATION_PROPERTIES))
        return XR_ERROR_VALIDATION_FAILURE;
    properties->viewConfigurationType = type;
    // The two eyes' fields of view differ and a program may submit its own: the compositor
    // reprojects.
    properties->fovMutable = XR_TRUE;
    return XR_SUCCESS;
}

// Room for supersampling. Programs make images of the largest size too, three at a time, in the
// memory of a machine without a GPU.
static uint32_t most_px(uint32_t recommended_px) {
    uint32_t most = recommended_px > 2048 ? 2 * recommended_px : 4096;
    return most < MAX_IMAGE_PX ? most : MAX_IMAGE_PX;
}

// What a program may take for its near and far planes: nothing here depends on it.
static void fill_depth_range(const struct sim_instance *instance, XrViewConfigurationView *view) {
    XrViewConfigurationDepthRangeEXT *range =
        sim_chained(view, XR_TYPE_VIEW_CONFIGURATION_DEPTH_RANGE_EXT);
    if (!range || !instance->enabled[SIM_EXT_view_configuration_depth_range])
        return;
    range->recommendedNearZ = 0.1f;
    range->minNearZ = 0.01f;
    range->recommendedFarZ = 1000.0f;
    range->maxFarZ = FLT_MAX;
}

XrResult XRAPI_CALL xrEnumerateViewConfigurationViews(XrInstance handle, XrSystemId system,
                                                      XrViewConfigurationType type,
                                                      uint32_t capacity, uint32_t *count,
                                                      XrViewConfigurationView *views) {
    SIM_LOCKED;
    struct sim_instance *instance;
    XrResult result = check_view(handle, system, type, &instance);
    if (result != XR_SUCCESS)
        return result;
    if (!count || (capacity && !views))
        return XR_ERROR_VALIDATION_FAILURE;
    *count = 2;
    if (capacity == 0)
        return XR_SUCCESS;
    if (capacity < 2)
        return XR_ERROR_SIZE_INSUFFICIENT;
    for (int i = 0; i < 2; i++) {
        if (views[i].type != XR_TYPE_VIEW_CONFIGURATION_VIEW)
            return XR_ERROR_VALIDATION_FAILURE;
        const struct ap_eye_profile *eye = &instance->settings.profile.eye[i];
        views[i].recommendedImageRectWidth = eye->width_px;
        views[i].recommendedImageRectHeight = eye->height_px;
        views[i].maxImageRectWidth = most_px(eye->width_px);
        views[i].maxImageRectHeight = most_px(eye->height_px);
        views[i].recommendedSwapchainSampleCount = 1;
        views[i].maxSwapchainSampleCount = MAX_SAMPLES;
        fill_depth_range(instance, &views[i]);
    }
    return XR_SUCCESS;
}
