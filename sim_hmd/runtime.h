#ifndef ANTIPODE_SIM_HMD_RUNTIME_H
#define ANTIPODE_SIM_HMD_RUNTIME_H

#include <stdbool.h>
#include <stdint.h>
#include <time.h>
#include <vulkan/vulkan.h>

#define XR_USE_GRAPHICS_API_VULKAN
#define XR_USE_TIMESPEC
#define XR_EXTENSION_PROTOTYPES
#include <openxr/openxr.h>
#include <openxr/openxr_platform.h>

#include "sim_hmd/automation.h"
#include "sim_hmd/haptics.h"
#include "sim_hmd/debug_utils.h"
#include "sim_hmd/extensions.h"
#include "sim_hmd/frame.h"
#include "sim_hmd/handles.h"
#include "sim_hmd/pacer.h"
#include "sim_hmd/profiles.h"
#include "sim_hmd/settings.h"
#include "sim_hmd/source.h"

// The runtime's objects. The api_*.c files hold the functions of OpenXR under their own names (they
// are hidden; the loader gets them from xrGetInstanceProcAddr): they take the lock, verify their
// arguments and dispatch. Everything declared here wants the lock held.

enum { SIM_SYSTEM_ID = 1, SIM_MAX_EVENTS = 128, SIM_MAX_IMAGES = 3, SIM_MAX_RECENTRINGS = 16 };

struct sim_paths {
    char **text; // XrPath = place + 1
    uint32_t count, capacity;
};

struct sim_events {
    XrEventDataBuffer queue[SIM_MAX_EVENTS];
    XrSession session[SIM_MAX_EVENTS]; // whom it is about
    uint32_t first, count, lost;
};

struct sim_suggestion {
    int profile; // of sim_profiles
    uint64_t action;
    const struct sim_component *component;
    int top; // enum sim_top
};

struct sim_instance {
    struct sim_object object;
    struct sim_settings settings;
    struct sim_source *source;
    int64_t epoch_ns;
    uint32_t minor; // OpenXR 1.minor, as the program asked
    bool enabled[SIM_EXTENSION_COUNT];
    bool requirements_called;
    struct sim_paths paths;
    struct sim_names names; // XR_EXT_debug_utils
    struct sim_events events;
    struct sim_suggestion *suggestions;
    uint32_t suggestion_count, suggestion_capacity;
    struct sim_session *session;
};

struct sim_recentring {
    XrTime from;
    struct ap_pose stage_from_local;
};

struct sim_session {
    struct sim_object object;
    struct sim_instance *instance;
    bool headless;
    struct ap_gpu gpu;
    struct sim_compositor *compositor;
    struct sim_layer_capture *layer_capture; // capture_session.c
    struct sim_frames_log *frames_log;
    int64_t formats[16];
    uint32_t format_count;
    XrSessionState state;
    bool running, exit_requested, lost;
    struct sim_pacer pacer;
    int64_t frame_limit; // frames of this session; −1: no end
    // The frame loop: waited frames that are not begun, and the begun one that is not ended.
    bool waited, begun;
    struct sim_prediction waited_frame, begun_frame;
    int64_t discarded, missed; // since the last frame that was shown
    struct sim_pulses pulses;  // since the last line of frames_log
    struct sim_frame_counts {
        int64_t shown, discarded, missed, late;
        int64_t margin_least_ns;
        double margin_sum_ns;
    } counts;
    // recentre.c: rising by time; what LOCAL was before the first of them.
    struct sim_recentring recentrings[SIM_MAX_RECENTRINGS];
    int recentring_count;
    struct ap_pose oldest_local;
    size_t recentred; // of the settings' times
    int64_t first_frame_ns;
    uint32_t keys; // the window's, as of the last frame
    // Images of swapchains that were destroyed while the queue may still have worked on them.
    struct sim_garbage *garbage;
    // Actions. The bindings are those that were suggested when the sets were attached.
    bool attached;
    struct sim_suggestion *bindings;
    uint32_t binding_count;
    int profile[SIM_TOP_COUNT]; // of sim_profiles, as of the last xrSyncActions; −1: none
    int64_t input_ns;           // XrTime of the last xrSyncActions
    struct sim_automation automation;
    struct sim_labels labels; // XR_EXT_debug_utils
};

struct sim_space {
    struct sim_object object;
    struct sim_session *session;
    bool is_action;
    XrReferenceSpaceType reference;
    uint64_t action;
    int top; // −1: any
    // As of the last xrSyncActions. A space of any hand takes the first that is active, and keeps
    // it.
    int picked_top; // −1: none yet
    bool active;
    struct ap_pose parent_from_space;
};

struct sim_garbage {
    struct sim_garbage *next;
    struct ap_gpu_image image[SIM_MAX_IMAGES];
};

struct sim_swapchain {
    struct sim_object object;
    struct sim_session *session;
    XrSwapchainCreateInfo info; // next is NULL
    VkImageAspectFlags aspect;
    bool depth, static_image;
    bool used; // an image was acquired once: the layouts are set, the queue may work on it
    uint32_t image_count;
    struct ap_gpu_image image[SIM_MAX_IMAGES];
    uint32_t next;     // the next to acquire; the acquired ones lie before it, oldest first
    uint32_t acquired; // how many
    bool waited;       // the oldest acquired one was waited for
    int released;      // the last released image; −1: none yet
};

struct sim_action_set {
    struct sim_object object;
    char name[XR_MAX_ACTION_SET_NAME_SIZE];
    char localized[XR_MAX_LOCALIZED_ACTION_SET_NAME_SIZE];
    uint32_t priority;
    bool top[SIM_TOP_COUNT]; // subaction paths that actions were made with, though they be gone
    bool attached;           // once, to a session that may be gone
    uint64_t session;        // its handle
};

struct sim_action_state {
    bool active, changed;
    float x, y; // bool: 0 or 1 in x
    XrTime changed_at;
};

struct sim_action {
    struct sim_object object;
    struct sim_action_set *set;
    char name[XR_MAX_ACTION_NAME_SIZE];
    char localized[XR_MAX_LOCALIZED_ACTION_NAME_SIZE];
    XrActionType type;
    bool top[SIM_TOP_COUNT]; // subaction paths it was made with
    bool has_tops;
    struct sim_action_state state[SIM_TOP_COUNT];
    struct sim_action_state combined;
};

static inline uint64_t sim_raw(const void *handle) {
    return (uint64_t)(uintptr_t)handle;
}
#define SIM_HANDLE(handle_type, o) ((handle_type)(uintptr_t)(o)->object.handle)

// A structure of the caller's is there and is of this type.
static inline bool sim_is(const void *structure, XrStructureType type) {
    return structure && ((const XrBaseInStructure *)structure)->type == type;
}

// The structure of this type in the chain behind the caller's own; NULL: none. A chain that bites
// its tail is not followed for ever.
static inline void *sim_chained(const void *structure, XrStructureType type) {
    const XrBaseInStructure *s = ((const XrBaseInStructure *)structure)->next;
    for (int i = 0; s && i < 64; i++, s = s->next)
        if (s->type == type)
            return (void *)(uintptr_t)s;
    return NULL;
}

struct sim_instance *sim_instance_get(XrInstance handle);
// What of the interaction profiles' tables the program may name.
static inline bool sim_instance_has(const struct sim_instance *instance, unsigned needs) {
    return (!(needs & SIM_NEEDS_1_1) || instance->minor >= 1) &&
           (!(needs & SIM_NEEDS_PALM) || instance->enabled[SIM_EXT_palm_pose]);
}
// XR_ERROR_HANDLE_INVALID, or XR_ERROR_SESSION_LOST.
XrResult sim_session_get(XrSession handle, struct sim_session **session);
struct sim_space *sim_space_get(XrSpace handle);
XrResult sim_swapchain_get(XrSwapchain handle, struct sim_swapchain **swapchain);

// The two calls of every list: *count = n always; items are copied where capacity is not zero.
XrResult sim_two_calls(uint32_t capacity, uint32_t *count, uint32_t n, const void *items,
                       size_t size, void *out);
XrResult sim_two_call_text(uint32_t capacity, uint32_t *count, const char *text, char *out);

// paths.c
bool sim_path_valid(const char *text);
XrResult sim_path_make(struct sim_paths *paths, const char *text, XrPath *path);
const char *sim_path_text(const struct sim_paths *paths, XrPath path); // NULL: unknown
int sim_path_top(const struct sim_paths *paths, XrPath path);          // enum sim_top; −1: none
void sim_paths_finish(struct sim_paths *paths);

// events.c
void sim_events_push(struct sim_events *events, XrSession session, const void *event, size_t size);
bool sim_events_pop(struct sim_events *events, XrEventDataBuffer *event);
void sim_events_forget(struct sim_events *events, XrSession session);

// session.c: the state machine.
void sim_session_set_state(struct sim_session *session, XrSessionState state);
bool sim_session_shows(const struct sim_session *session);
// SYNCHRONIZED, VISIBLE, FOCUSED at once: frame 0 is drawn, captured and has its input.
void sim_session_show(struct sim_session *session);
void sim_session_ask_to_end(struct sim_session *session);
void sim_session_lose(struct sim_session *session, const char *what);
// One line on the frames so far: what was missed, and by how much.
void sim_session_report(const struct sim_session *session);
void sim_session_collect_garbage(struct sim_session *session);

// capture_session.c: what is captured beside the composed pictures; nothing where the settings ask
// for none. The flush makes all of it whole.
enum ap_status sim_session_capture_open(struct ap_error *err, struct sim_session *session);
enum ap_status sim_session_capture_frame(struct ap_error *err, struct sim_session *session,
                                         const XrFrameEndInfo *info, const struct sim_frame *frame,
                                         bool captured);
enum ap_status sim_session_capture_flush(struct ap_error *err, struct sim_session *session);
void sim_session_capture_close(struct sim_session *session);

// api_vulkan.c: the device that programs must use, the fastest kind there is.
XrResult sim_choose_device(VkInstance vulkan, VkPhysicalDevice *out);

// spaces.c
struct sim_located {
    enum ap_pose_state state;
    struct ap_pose pose; // stage_from_space; the identity where there is none
};
struct sim_located sim_space_in_stage(const struct sim_space *space, XrTime time);
struct sim_located sim_head_in_stage(const struct sim_session *session, XrTime time);
bool sim_pose_from_xr(XrPosef in, struct ap_pose *out); // false: XR_ERROR_POSE_INVALID
XrPosef sim_pose_to_xr(struct ap_pose pose);
XrFovf sim_fov(const struct sim_session *session, int eye);
enum ap_pose_state sim_worse_state(enum ap_pose_state a, enum ap_pose_state b);
XrSpaceLocationFlags sim_location_flags(enum ap_pose_state state);

// recentre.c
struct ap_pose sim_local_in_stage(const struct sim_session *session, XrTime time);
struct ap_pose sim_local_floor_in_stage(const struct sim_session *session, XrTime time);
void sim_recentre_due(struct sim_session *session, const struct sim_prediction *frame,
                      uint32_t keys);

// A pose is measured against itself this long ago for its velocity: backward differences, which are
// exact for the straight lines and arcs that interpolation gives.
enum { SIM_VELOCITY_STEP_NS = 1000000 };
void sim_velocity(struct ap_pose now, struct ap_pose then, XrVector3f *linear, XrVector3f *angular);

// layers.c: verifies what xrEndFrame was given and resolves it.
XrResult sim_layers_resolve(struct sim_session *session, const XrFrameEndInfo *info,
                            struct sim_frame *frame);

// api_action.c: XR_NULL_PATH gives −1; XR_ERROR_PATH_UNSUPPORTED where the action was not made with
// the path.
XrResult sim_subaction(const struct sim_instance *instance, const struct sim_action *action,
                       XrPath path, int *top);

// actions.c
// False without memory.
bool sim_actions_attach(struct sim_session *session);
// The profile that the next xrSyncActions makes current; −1: none.
int sim_actions_choose_profile(const struct sim_session *session, int top);
// True where a current profile changed.
bool sim_actions_update(struct sim_session *session, const XrActionsSyncInfo *info);
enum sim_kind sim_actions_kind(XrActionType type);
// The place in the world of a pose action's binding; NULL where it has none.
const struct sim_component *sim_actions_binding(const struct sim_session *session, uint64_t action,
                                                int top);

#endif
