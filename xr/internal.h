#ifndef ANTIPODE_XR_INTERNAL_H
#define ANTIPODE_XR_INTERNAL_H

#include <vulkan/vulkan.h>
#define XR_USE_GRAPHICS_API_VULKAN
#include <openxr/openxr.h>
#include <openxr/openxr_platform.h>

#include "xr/client.h"
#include "xr/loader.h"

enum { AP_XR_MAX_IMAGES = 16 };

// One swapchain of two layers, or, where the runtime refuses arrays, one for each eye.
struct ap_xr_swapchain {
    XrSwapchain handle;
    uint32_t image_count;
    VkImage images[AP_XR_MAX_IMAGES];
    uint32_t acquired; // index, while drawing
};

struct ap_xr_actions {
    XrActionSet set;
    XrAction grip, aim, trigger, squeeze, select, haptic;
    XrPath hand[2];
    XrSpace grip_space[2], aim_space[2];
};

struct ap_xr {
    XrInstance instance;
    XrSystemId system;
    bool vulkan2; // XR_KHR_vulkan_enable2 rather than XR_KHR_vulkan_enable
    char runtime_name[XR_MAX_RUNTIME_NAME_SIZE];
    char system_name[XR_MAX_SYSTEM_NAME_SIZE];

    VkInstance vk_instance;
    VkPhysicalDevice vk_physical;
    VkDevice vk_device;
    uint32_t queue_family;
    bool multiview;

    XrSession session;
    XrSessionState state;
    bool running, ended, lost;
    XrSpace stage, view;
    bool has_stage;
    XrEnvironmentBlendMode blend;

    VkFormat format;
    XrViewConfigurationView config[2];
    uint32_t width, height; // of a swapchain image: the larger of the eyes'
    int swapchain_count;    // 1 (array) or 2
    struct ap_xr_swapchain swapchain[2];
    bool drawing;      // images are acquired
    XrView located[2]; // in STAGE, of the frame that is being drawn

    struct ap_xr_actions actions;
};

// AP_ENVIRONMENT "call: XR_ERROR_…"; notes that the session or the instance is lost.
enum ap_status ap_xr_check(struct ap_error *err, struct ap_xr *xr, XrResult result,
                           const char *call);

enum ap_status ap_xr_instance_create(struct ap_error *err, const struct ap_xr_params *params,
                                     struct ap_xr *xr);
enum ap_status ap_xr_vulkan_create(struct ap_error *err, struct ap_xr *xr);
enum ap_status ap_xr_session_create(struct ap_error *err, struct ap_xr *xr);
enum ap_status ap_xr_swapchains_create(struct ap_error *err, const struct ap_xr_params *params,
                                       struct ap_xr *xr);
enum ap_status ap_xr_actions_create(struct ap_error *err, struct ap_xr *xr);

// Syncs the actions and fills both hands at the time.
enum ap_status ap_xr_actions_read(struct ap_error *err, struct ap_xr *xr, XrTime time,
                                  struct ap_xr_hand hands[2]);

struct ap_pose ap_pose_from_xr(XrPosef pose);
enum ap_status ap_xr_locate(struct ap_error *err, struct ap_xr *xr, XrSpace space, XrTime time,
                            struct ap_xr_located *located);

#endif
