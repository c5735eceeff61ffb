#ifndef ANTIPODE_SIM_HMD_INPUT_SOURCE_H
#define ANTIPODE_SIM_HMD_INPUT_SOURCE_H

#include <stdint.h>

#include "sim_hmd/input/profiles.h"
#include "sim_hmd/core/pacer.h"
#include "sim_hmd/input/poses.h"
#include "src/device/handlog.h"
#include "src/device/timeline.h"

// Where head and hands are at a time: pose logs, the scripted walk, or the window's keyboard and
// mouse (poses.h has the kinds), with what input logs and recorded hands add. Poses are in STAGE.
// Log time = XrTime − (XrTime of the session's first frame) + t_0; on the virtual clock that first
// frame is at 1e9.

struct sim_source;

// Reads the logs to their end. AP_INPUT as their readers say it.
enum ap_status sim_source_create(struct ap_error *err, const struct sim_settings *settings,
                                 struct sim_source **source);
void sim_source_destroy(struct sim_source *source);

// When the session's first frame is shown, in XrTime and on the machine's monotonic clock. First
// told when the session is made, as that very moment.
void sim_source_start(struct sim_source *source, int64_t first_xr_ns, int64_t machine_ns);

// As the kind of source says it (poses.h). What was asked for last is remembered, unless the kind
// learns: the calls of a frame all ask for the same moment.
enum ap_pose_state sim_source_at(struct sim_source *source, enum sim_device device, int64_t xr_ns,
                                 struct ap_sample *sample);

// Has the devices that were asked for since the last call ready for the frame that was predicted
// last: xrWaitFrame does so before it sleeps. On the real clock it evaluates the frames that follow
// in the same go, for the first of them costs ten times the others: 11 ms of sleep empty the
// caches.
void sim_source_prepare(struct sim_source *source, const struct sim_pacer *pacer);

struct sim_source_stats {
    int64_t asked, remembered; // of sim_source_at
    int64_t evaluated;         // poses that the kind was asked for, ahead or not
};
struct sim_source_stats sim_source_stats(const struct sim_source *source);

// The bare hand (AP_HAND_LEFT, AP_HAND_RIGHT): the recorded one, or a made-up one in the
// controller's place where the settings name no recording.
enum ap_pose_state sim_source_hand(struct sim_source *source, int hand, int64_t xr_ns,
                                   struct ap_hand *out);

// What the input logs say of a component at a time, or else the kind of poses; false where they say
// nothing (yet).
bool sim_source_component(const struct sim_source *source, const struct sim_component *component,
                          int top, int64_t xr_ns, float value[2]);

// The input logs speak of this device (enum sim_top).
bool sim_source_logs_device(const struct sim_source *source, int top);

// Warns, once, of logged inputs that the current profiles (of sim_profiles; −1: none) do not have.
void sim_source_warn_unheard(struct sim_source *source, const int profile[SIM_TOP_COUNT]);

// The frames of a session on the virtual clock; −1: no end.
int64_t sim_source_frame_count(const struct sim_source *source, double refresh_hz);

// LOCAL: at the first head pose's position and yaw, level.
struct ap_pose sim_source_stage_from_local(const struct sim_source *source);
// The same of the head at another time; false where it is not tracked.
bool sim_source_local_at(struct sim_source *source, int64_t xr_ns, struct ap_pose *local);

// Steps what the window's keyboard and mouse move; the others ignore it.
void sim_source_input(struct sim_source *source, const struct sim_window_input *input,
                      double step_s);

#endif
