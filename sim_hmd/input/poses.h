#ifndef ANTIPODE_SIM_HMD_INPUT_POSES_H
#define ANTIPODE_SIM_HMD_INPUT_POSES_H

#include <stdbool.h>
#include <stdint.h>

#include "sim_hmd/core/settings.h"
#include "src/device/timeline.h"

// Where head and hands are: a file poses_x.c for each kind of source, its table here and in
// source.c's list, its key of the settings' "poses" in core/settings.c. Times are nanoseconds since
// the session's first frame; poses are in STAGE. The runtime's lock is held; nothing here blocks.

enum sim_device { SIM_HEAD, SIM_LEFT, SIM_RIGHT, SIM_DEVICE_COUNT };

struct sim_window_input;
struct sim_component;

struct sim_poses_kind {
    // *state is NULL where the kind needs none.
    enum ap_status (*create)(struct ap_error *err, const struct sim_settings *settings,
                             void **state);
    void (*destroy)(void *state); // NULL accepted
    enum ap_pose_state (*at)(const void *state, enum sim_device device, int64_t ns,
                             struct ap_sample *sample);
    // The others may be NULL.
    // When, on the machine's monotonic clock, the first frame is shown (the real clock's sessions).
    void (*start)(void *state, int64_t machine_ns);
    int64_t (*frame_count)(const void *state, double refresh_hz); // NULL: no end
    // What time the first frame has on the source's own clock, which is the input logs', too;
    // NULL: 0.
    int64_t (*start_ns)(const void *state);
    // Steps what the window's keyboard and mouse move.
    void (*input)(void *state, const struct sim_window_input *input, double step_s);
    // What it says of a controller's component now; false: nothing, see the sample's trigger,
    // squeeze and select. value[1] only of SIM_VEC2.
    bool (*component)(const void *state, const struct sim_component *component, int top,
                      float value[2]);
    // What it says of a time changes as it learns more: it is asked anew each time.
    bool learns;
};

extern const struct sim_poses_kind sim_poses_walk, sim_poses_logs, sim_poses_window,
    sim_poses_devices;

#endif
