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

enum ap_xr_action {
    AP_XR_GRIP,
    AP_XR_AIM,
    AP_XR_TRIGGER,
    AP_XR_SQUEEZE,
    AP_XR_STICK,
    AP_XR_SELECT,
    AP_XR_PRIMARY,
    AP_XR_SECONDARY,
    AP_XR_MENU,
    AP_XR_STICK_CLICK,
    AP_XR_HAPTIC,
    AP_XR_ACTION_COUNT
};

struct ap_xr_actions {
    XrActionSet set;
    XrAction action[AP_XR_ACTION_COUNT];
    XrPath hand[2];
    XrSpace grip_space[2], aim_space[2];
};

struct ap_xr_panel {
    struct ap_xr *xr;
    struct ap_xr_panel_params params;
    struct ap_xr_panel_place place;
    struct ap_xr_swapchain swapchain;
    bool has_picture;
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
    struct ap_xr_panel *panel[AP_XR_MAX_PANELS]; // NULL: free
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
// One image is handed out; acquire waits for it.
enum ap_status ap_xr_swapchain_create(struct ap_error *err, struct ap_xr *xr,
                                      const XrSwapchainCreateInfo *info,
                                      struct ap_xr_swapchain *swapchain);
enum ap_status ap_xr_swapchain_acquire(struct ap_error *err, struct ap_xr *xr,
                                       struct ap_xr_swapchain *swapchain);
enum ap_status ap_xr_swapchain_release(struct ap_error *err, struct ap_xr *xr,
                                       struct ap_xr_swapchain *swapchain);

// The layers of the panels that are shown, in their order. Returns how many.
uint32_t ap_xr_panel_layers(const struct ap_xr *xr,
                            XrCompositionLayerQuad layers[AP_XR_MAX_PANELS]);

enum ap_status ap_xr_actions_create(struct ap_error *err, struct ap_xr *xr);

// Syncs the actions and fills both hands at the time.
enum ap_status ap_xr_actions_read(struct ap_error *err, struct ap_xr *xr, XrTime time,
                                  struct ap_xr_hand hands[2]);

struct ap_pose ap_pose_from_xr(XrPosef pose);
XrPosef ap_pose_to_xr(struct ap_pose pose);
enum ap_status ap_xr_locate(struct ap_error *err, struct ap_xr *xr, XrSpace space, XrTime time,
                            struct ap_xr_located *located);

#endif
