#ifndef ANTIPODE_XR_CLIENT_H
#define ANTIPODE_XR_CLIENT_H

#include <stdbool.h>
#include <stdint.h>
#include <vulkan/vulkan.h>

#include "src/base/status.h"
#include "src/geom/pose.h"

// An OpenXR client, for any runtime: instance, system, session states, reference spaces,
// swapchains, views, and actions for both hands. It knows no scene and no runtime. One thread.

struct ap_xr;

struct ap_xr_params {
    const char *application; // name, at most 63 bytes are used
    bool prefer_rgba;        // else the runtime's first sRGB format
    bool older_vulkan;       // XR_KHR_vulkan_enable, where the runtime's _enable2 does not work
};

// Chooses the Vulkan device by XR_KHR_vulkan_enable2 (or _enable), creates session, STAGE, LOCAL
// and VIEW spaces (LOCAL stands in where there is no STAGE, ap_xr_has_stage tells), actions and one
// array swapchain of two layers (or two swapchains). AP_ENVIRONMENT says what to do: no loader, no
// runtime, no Vulkan device…
enum ap_status ap_xr_create(struct ap_error *err, const struct ap_xr_params *params,
                            struct ap_xr **xr);
// Ends the session cleanly where it still runs; accepts NULL.
void ap_xr_destroy(struct ap_xr *xr);

struct ap_xr_vulkan {
    VkInstance instance;
    VkPhysicalDevice physical_device;
    VkDevice device;
    uint32_t queue_family;
    bool multiview; // the feature is enabled on the device
    VkFormat color_format;
    uint32_t width_px, height_px; // of the images: the larger of the eyes' sizes
};
struct ap_xr_vulkan ap_xr_vulkan(const struct ap_xr *xr);
const char *ap_xr_runtime_name(const struct ap_xr *xr);
const char *ap_xr_system_name(const struct ap_xr *xr);
bool ap_xr_has_stage(const struct ap_xr *xr);

enum ap_xr_state {
    AP_XR_WAITING, // not running yet: sleep a little and poll again
    AP_XR_RUNNING, // do a frame
    AP_XR_ENDED,   // asked to end, by either side
    AP_XR_LOST,    // session or instance lost
};

// Handles every pending event, begins and ends the session as the runtime says.
enum ap_status ap_xr_poll(struct ap_error *err, struct ap_xr *xr, enum ap_xr_state *state);

// Asks the runtime to end the session; poll until AP_XR_ENDED.
enum ap_status ap_xr_request_exit(struct ap_error *err, struct ap_xr *xr);

struct ap_xr_located {
    bool valid, tracked; // position and orientation both
    struct ap_pose pose; // in STAGE
};

struct ap_xr_hand {
    struct ap_xr_located grip, aim;
    float trigger, squeeze; // 0…1
    float stick_x,
        stick_y; // −1…1, right and away from the body; a trackpad where there is no stick
    bool select;
    bool primary, secondary; // A or X, B or Y, where the controller has them
    bool menu;               // or what stands in for it
    bool stick_click;        // the stick pressed
};

struct ap_xr_view {
    struct ap_pose view_from_eye; // in VIEW
    double left_rad, right_rad, up_rad, down_rad;
    uint32_t width_px, height_px; // its part of the image, from the image's top left corner
};

struct ap_xr_frame {
    int64_t time_ns; // predictedDisplayTime
    int64_t period_ns;
    bool should_render;
    struct ap_xr_located head; // VIEW in STAGE
    struct ap_xr_hand hand[2]; // left, right
    struct ap_xr_view view[2]; // left, right
};

// xrWaitFrame, xrBeginFrame, sync actions, locate everything at the display time. Every begun frame
// is owed one ap_xr_end_frame.
enum ap_status ap_xr_begin_frame(struct ap_error *err, struct ap_xr *xr, struct ap_xr_frame *frame);

// The images to draw into, only where should_render; acquire waits for them.
struct ap_xr_images {
    VkImage image[2]; // the same image twice for an array swapchain
    uint32_t layer[2];
};
enum ap_status ap_xr_acquire(struct ap_error *err, struct ap_xr *xr, struct ap_xr_images *images);

// Releases the images if they were acquired, submits one projection layer (none without) and the
// panels that are shown, ends.
enum ap_status ap_xr_end_frame(struct ap_error *err, struct ap_xr *xr,
                               const struct ap_xr_frame *frame);

// The bounds of the tracked room, centred in STAGE: along x and z, metres. False where the runtime
// does not know them.
bool ap_xr_stage_bounds(struct ap_xr *xr, double *width_m, double *depth_m);

// A rectangle with a picture on it, as a quad layer in front of the projection: text stays sharp,
// and the runtime may draw it later than the rest.
struct ap_xr_panel;

struct ap_xr_panel_params {
    uint32_t width_px, height_px;
};

// How it stands in the frames to come. Pose: +z toward the reader, +y up, at the middle.
struct ap_xr_panel_place {
    bool shown, in_view; // in VIEW, or in STAGE
    struct ap_pose pose;
    double width_m; // the height follows the picture's
    bool blended;   // by alpha, not premultiplied
};

// At most AP_XR_MAX_PANELS at a time; destroyed before the client, or with it.
enum { AP_XR_MAX_PANELS = 4 };
enum ap_status ap_xr_panel_create(struct ap_error *err, struct ap_xr *xr,
                                  const struct ap_xr_panel_params *params,
                                  struct ap_xr_panel **panel);
void ap_xr_panel_destroy(struct ap_xr_panel *panel);
void ap_xr_panel_set(struct ap_xr_panel *panel, const struct ap_xr_panel_place *place);

// The next picture: an image of the client's format to be written, COLOR_ATTACHMENT and
// TRANSFER_DST, in any layout; on release in COLOR_ATTACHMENT_OPTIMAL, the writing submitted to the
// queue. A panel without a picture yet is not shown.
enum ap_status ap_xr_panel_acquire(struct ap_error *err, struct ap_xr_panel *panel, VkImage *image);
enum ap_status ap_xr_panel_release(struct ap_error *err, struct ap_xr_panel *panel);

// hand 0 left, 1 right; amplitude 0…1; seconds ≤ 0: the shortest pulse. No error where there is no
// motor.
enum ap_status ap_xr_haptic(struct ap_error *err, struct ap_xr *xr, int hand, double seconds,
                            double amplitude);

#endif
