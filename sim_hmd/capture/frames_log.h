#ifndef ANTIPODE_SIM_HMD_CAPTURE_FRAMES_LOG_H
#define ANTIPODE_SIM_HMD_CAPTURE_FRAMES_LOG_H

#include "sim_hmd/compose/frame.h"
#include "sim_hmd/input/haptics.h"
#include "sim_hmd/core/pacer.h"
#include "src/device/timeline.h"

// frames.jsonl in the capture folder: a line for each frame (docs/simulated-headset.md). Until it
// is whole it is called frames.jsonl.part; each line goes there by itself, so that what a killed
// program leaves ends with a whole line. On the virtual clock nothing in it depends on the
// machine's time. Every call accepts NULL: there is no log. One thread at a time.
struct sim_frames_log;

// In the settings' capture folder, which is there; a log of an earlier run is removed.
// AP_ENVIRONMENT.
enum ap_status sim_frames_log_create(struct ap_error *err, const struct sim_settings *settings,
                                     struct sim_frames_log **log);

// The frame that ends: as it was predicted, begun and ended (XrTime; the real clock's only), as it
// was submitted, and as it was resolved.
struct sim_logged_frame {
    const struct sim_prediction *predicted;
    int64_t ended_ns;
    enum ap_pose_state head_state;
    struct ap_pose stage_from_head;
    const XrFrameEndInfo *info; // verified
    const struct sim_frame *frame;
    const struct sim_pulses *pulses; // since the line before
    bool captured;
};
// True where the settings ask for a line of this frame.
bool sim_frames_log_wants(const struct sim_frames_log *log, bool captured);

// Nothing where the settings ask for captured frames only and this is none. AP_ENVIRONMENT.
enum ap_status sim_frames_log_frame(struct ap_error *err, struct sim_frames_log *log,
                                    const struct sim_logged_frame *logged);

// Gives the file its name; a second call does nothing. AP_ENVIRONMENT.
enum ap_status sim_frames_log_commit(struct ap_error *err, struct sim_frames_log *log);

void sim_frames_log_destroy(struct sim_frames_log *log); // removes what is not committed

#endif
