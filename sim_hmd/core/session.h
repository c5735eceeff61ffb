#ifndef ANTIPODE_SIM_HMD_CORE_SESSION_H
#define ANTIPODE_SIM_HMD_CORE_SESSION_H

#include "sim_hmd/core/instance.h"
#include "sim_hmd/core/pacer.h"
#include "sim_hmd/ext/automation.h"
#include "sim_hmd/ext/debug_names.h"
#include "sim_hmd/input/haptics.h"
#include "src/geom/pose.h"
#include "src/gpu/gpu.h"

enum { SIM_MAX_RECENTRINGS = 16 };

struct sim_compositor;    // compose/frame.h
struct sim_layer_capture; // capture/layers.h
struct sim_frames_log;    // capture/frames_log.h
struct sim_garbage;       // core/swapchains.h

struct sim_recentring {
    XrTime from;
    struct ap_pose stage_from_local;
};

struct sim_session {
    struct sim_object object;
    // What every frame touches, side by side.
    struct sim_instance *instance;
    XrSessionState state;
    bool headless, running, exit_requested, lost;
    bool windowed; // the settings ask for the window
    bool watched;  // frames may be looked at: captured, logged or shown
    // The frame loop: waited frames that are not begun, and the begun one that is not ended.
    bool waited, begun;
    struct sim_prediction waited_frame, begun_frame;
    struct sim_pacer pacer;
    int64_t frame_limit;       // frames of this session; −1: no end
    int64_t discarded, missed; // since the last frame that was shown
    struct sim_frame_counts {
        int64_t shown, discarded, missed, late;
        int64_t margin_least_ns;
        double margin_sum_ns;
    } counts;
    XrFovf fov[2]; // the profile's, as its eyes
    struct ap_pose view_from_eye[2];
    // Images of swapchains that were destroyed while the queue may still have worked on them.
    struct sim_garbage *garbage;
    int recentring_count;
    struct sim_compositor *compositor;
    struct sim_layer_capture *layer_capture; // capture/session.h
    struct sim_frames_log *frames_log;

    struct ap_gpu gpu;
    int64_t formats[16];
    uint32_t format_count;
    struct sim_pulses pulses; // since the last line of frames_log
    // core/spaces.h: rising by time; what LOCAL was before the first of them.
    struct sim_recentring recentrings[SIM_MAX_RECENTRINGS];
    struct ap_pose oldest_local;
    size_t recentred; // of the settings' times
    int64_t first_frame_ns;
    uint32_t keys; // the window's, as of the last frame
    // Actions. The bindings are those that were suggested when the sets were attached.
    bool attached;
    struct sim_suggestion *bindings;
    uint32_t binding_count;
    int profile[SIM_TOP_COUNT]; // of sim_profiles, as of the last xrSyncActions; −1: none
    int64_t input_ns;           // XrTime of the last xrSyncActions
    struct sim_automation automation;
    struct sim_labels labels; // XR_EXT_debug_utils
};

// XR_ERROR_HANDLE_INVALID, or XR_ERROR_SESSION_LOST.
XrResult sim_session_get(XrSession handle, struct sim_session **session);

// The state machine.
void sim_session_set_state(struct sim_session *session, XrSessionState state);
bool sim_session_shows(const struct sim_session *session);
// SYNCHRONIZED, VISIBLE, FOCUSED at once: frame 0 is drawn, captured and has its input.
void sim_session_show(struct sim_session *session);
void sim_session_ask_to_end(struct sim_session *session);
void sim_session_lose(struct sim_session *session, const char *what);
// One line on the frames so far: what was missed, and by how much.
void sim_session_report(const struct sim_session *session);

#endif
