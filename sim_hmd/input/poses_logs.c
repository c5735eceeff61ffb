#include <stdlib.h>

#include "sim_hmd/input/poses.h"
#include "src/base/log.h"

// Pose logs, read to their end.

struct logs {
    struct ap_timeline *timeline;
    int device[SIM_DEVICE_COUNT];
};

static const char *const device_names[SIM_DEVICE_COUNT] = {"head", "left", "right"};

static enum ap_status load_logs(struct ap_error *err, const struct sim_settings *settings,
                                struct logs *s) {
    struct ap_poselog *log = NULL;
    enum ap_status st = ap_poselog_open(err,
                                        &(struct ap_poselog_params){
                                            .sources = (const char *const *)settings->logs,
                                            .source_count = settings->log_count,
                                            .z_up = settings->z_up,
                                            .head_frame = settings->head_frame,
                                            .skip_bad = settings->skip_bad,
                                            .has_table = settings->has_table,
                                            .table_x_m = settings->table_x_m,
                                            .table_z_m = settings->table_z_m,
                                            .table_yaw_rad = settings->table_yaw_rad,
                                        },
                                        &log);
    if (st)
        return st;
    st = ap_timeline_load(err, log, &s->timeline);
    int64_t skipped = ap_poselog_skipped(log);
    if (!st && skipped)
        ap_log(AP_LOG_WARNING, "%lld bad lines of the pose logs skipped", (long long)skipped);
    ap_poselog_close(log);
    if (st)
        return st;
    for (int d = 0; d < SIM_DEVICE_COUNT; d++)
        s->device[d] = ap_timeline_find_device(s->timeline, device_names[d]);
    return AP_OK;
}

static void destroy(void *state) {
    struct logs *s = state;
    if (s)
        ap_timeline_destroy(s->timeline);
    free(s);
}

static enum ap_status create(struct ap_error *err, const struct sim_settings *settings,
                             void **state) {
    struct logs *s = calloc(1, sizeof *s);
    if (!s)
        return ap_fail(err, AP_ENVIRONMENT, "out of memory");
    enum ap_status st = load_logs(err, settings, s);
    if (st) {
        destroy(s);
        return st;
    }
    *state = s;
    return AP_OK;
}

static enum ap_pose_state at(const void *state, enum sim_device device, int64_t ns,
                             struct ap_sample *sample) {
    const struct logs *s = state;
    int64_t t;
    if (s->device[device] < 0 || __builtin_add_overflow(ap_timeline_start_ns(s->timeline), ns, &t))
        return AP_POSE_NONE;
    return ap_timeline_at(s->timeline, s->device[device], t, sample);
}

static int64_t frame_count(const void *state, double refresh_hz) {
    const struct logs *s = state;
    return ap_timeline_frame_count(s->timeline, refresh_hz);
}

static int64_t start_ns(const void *state) {
    const struct logs *s = state;
    return ap_timeline_start_ns(s->timeline);
}

const struct sim_poses_kind sim_poses_logs = {.create = create,
                                              .destroy = destroy,
                                              .at = at,
                                              .frame_count = frame_count,
                                              .start_ns = start_ns};
