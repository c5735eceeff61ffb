#ifndef ANTIPODE_SIM_HMD_COMPOSE_FRAME_H
#define ANTIPODE_SIM_HMD_COMPOSE_FRAME_H

#include <stdbool.h>
#include <stdint.h>
#include <vulkan/vulkan.h>

#define XR_USE_GRAPHICS_API_VULKAN
#include <openxr/openxr.h>
#include <openxr/openxr_platform.h>

#include "sim_hmd/core/settings.h"
#include "src/base/status.h"
#include "src/geom/pose.h"
#include "src/gpu/gpu.h"

// What xrEndFrame hands to the compositor: verified, resolved, no OpenXR handles left.

enum { SIM_MAX_LAYERS = 16 };

// What a layer is, in its own space (x right, y up, the middle of its picture at −z).
enum sim_layer_kind {
    SIM_LAYER_PROJECTION,
    SIM_LAYER_QUAD,     // in the plane z = 0, seen from +z only
    SIM_LAYER_CYLINDER, // about the y axis, seen from inside only
    SIM_LAYER_EQUIRECT, // both kinds: a part of a sphere, seen from inside only
    SIM_LAYER_CUBE,     // a cube map, infinitely far
};

// A projection view's depth, as submitted: released like the colours, in
// VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL. Nothing is composed with it.
struct sim_layer_depth {
    VkImage image;
    VkFormat format;
    uint32_t width_px, height_px, samples, array_layer;
    XrRect2Di rect;
    float min, max;      // of the values that were written, 0 ≤ min < max ≤ 1
    float near_m, far_m; // their distances; far may be the nearer one, and infinite
};

// One eye's picture of a layer. The image is released by the program, so it is in
// VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL and must be in it again afterwards; its usage includes
// TRANSFER_SRC and SAMPLED. The queue's earlier submissions write it: a submission on the same
// queue with a barrier sees them.
struct sim_layer_view {
    VkImage image;
    VkFormat format;
    uint32_t width_px, height_px; // of the whole image
    uint32_t samples;             // 1, 2, 4…
    uint32_t mips;                // 0 and 1: none but the whole image
    uint32_t array_layer;         // a cube's first of six
    XrRect2Di rect;               // inside the image; a cube's whole face
    // The layer's own space in STAGE: a projection's view, the pose of any other layer.
    struct ap_pose stage_from_view;
    XrPosef submitted_pose; // as submitted, in its own space
    XrFovf fov;             // a projection's
    // The pose is the display's pose of that eye to float rounding and the fov is its very floats:
    // with a rect of the eye's resolution the picture is copied bit for bit.
    bool at_display;
};

struct sim_layer {
    enum sim_layer_kind kind;
    bool blend_alpha;     // XR_COMPOSITION_LAYER_BLEND_TEXTURE_SOURCE_ALPHA_BIT
    bool unpremultiplied; // XR_COMPOSITION_LAYER_UNPREMULTIPLIED_ALPHA_BIT
    bool hidden[2];       // not for this eye, or its space has no place now
    // All but a projection have one picture: both eyes' views are the same.
    struct sim_layer_view view[2];
    double width_m, height_m; // a quad's
    double radius_m;          // a cylinder's and a sphere's; 0: infinitely far
    // The picture spans this angle about −z from its left to its right; up, a cylinder's runs from
    // its middle height/2 radii, a sphere's from the lower angle to the upper.
    double central_rad, height_radii, upper_rad, lower_rad;
    bool has_depth[2];               // of a projection's views
    struct sim_layer_depth depth[2]; // last: not touched where there is none
};

struct sim_frame {
    int64_t index; // k: frames since the session began
    XrTime display_time;
    // Since the frame that was shown before this one: frames that the program began and did not
    // end, and display periods for which it was too late. Periods are missed on the real clock
    // only.
    int64_t discarded, missed;
    int64_t margin_ns; // xrEndFrame came so long before the display time; 0 on the virtual clock
    bool capture;      // the settings ask for this frame's pictures
    struct ap_pose stage_from_eye[2]; // the display's
    XrFovf fov[2];
    uint32_t layer_count; // 0: black
    struct sim_layer layer[SIM_MAX_LAYERS];
};

// The compositor: owned by the session, called from one thread at a time (the runtime's lock is
// held), inside xrEndFrame, when the runtime may use the program's queue.
struct sim_compositor;

// gpu and settings outlive it. Makes the capture folder and starts the window as the settings ask.
enum ap_status sim_compositor_create(struct ap_error *err, const struct ap_gpu *gpu,
                                     const struct sim_settings *settings,
                                     struct sim_compositor **compositor);

// Composes, captures where frame->capture, shows in the window. May return before the pictures are
// on disk (writer threads), but not before it is done with the program's images. A writer's failure
// (full disk…) is returned by the next call.
enum ap_status sim_compositor_frame(struct ap_error *err, struct sim_compositor *compositor,
                                    const struct sim_frame *frame);

// True where the frame would be looked at (the window is open): shouldRender.
bool sim_compositor_wants_frames(const struct sim_compositor *compositor);

// Waits until every picture is on disk; reports what failed since the last call.
enum ap_status sim_compositor_flush(struct ap_error *err, struct sim_compositor *compositor);

// Flushes, joins writers, ends the window's process. Accepts NULL.
void sim_compositor_destroy(struct sim_compositor *compositor);

struct sim_window_input; // window/input.h
// False where there is no window.
bool sim_compositor_input(const struct sim_compositor *compositor, struct sim_window_input *input);

#endif
