#include <math.h>
#include <stdlib.h>

#include "sim_hmd/input/poses.h"
#include "src/device/walk.h"

// The scripted walk round a table.

static enum ap_status create(struct ap_error *err, const struct sim_settings *settings,
                             void **state) {
    struct ap_walk_params *walk = malloc(sizeof *walk);
    if (!walk)
        return ap_fail(err, AP_ENVIRONMENT, "out of memory");
    *walk = settings->walk;
    *state = walk;
    return AP_OK;
}

static enum ap_pose_state at(const void *state, enum sim_device device, int64_t ns,
                             struct ap_sample *sample) {
    *sample = ap_walk_at(state, (int)device, ns);
    return AP_POSE_EXACT;
}

// A walk on the virtual clock ends like a recording of it.
static int64_t frame_count(const void *state, double refresh_hz) {
    return (int64_t)floor(ap_walk_duration_s(state) * refresh_hz + 1e-9) + 1;
}

const struct sim_poses_kind sim_poses_walk = {
    .create = create, .destroy = free, .at = at, .frame_count = frame_count};
