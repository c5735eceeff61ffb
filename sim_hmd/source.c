#include "sim_hmd/source.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "sim_hmd/hand_tracking.h"
#include "sim_hmd/pacer.h"
#include "sim_hmd/source_inputs.h"
#include "sim_hmd/source_window.h"
#include "src/base/log.h"
#include "src/device/walk.h"

// A backend answers in its own time: nanoseconds since the session's first frame.
struct backend {
    enum ap_pose_state (*at)(const struct sim_source *source, enum sim_device device, int64_t ns,
                             struct ap_sample *sample);
    int64_t (*frame_count)(const struct sim_source *source, double refresh_hz); // NULL: no end
    void (*input)(struct sim_source *source, const struct sim_window_input *input,
                  double step_s); // NULL: none
};

struct sim_source {
    const struct backend *backend;
    int64_t first_xr_ns;
    struct ap_timeline *timeline; // logs
    int log_device[SIM_DEVICE_COUNT];
    struct ap_walk_params walk;
    struct sim_window_player player; // window
    struct ap_inputlog *inputs;      // NULL: none
    struct ap_handlog *hands;        // NULL: none
    bool warned_unheard;
    struct ap_pose first_local;
};

static const char *const device_names[SIM_DEVICE_COUNT] = {"head", "left", "right"};

static enum ap_pose_state log_at(const struct sim_source *s, enum sim_device device, int64_t ns,
                                 struct ap_sample *sample) {
    if (s->log_device[device] < 0)
        return AP_POSE_NONE;
    int64_t t0 = ap_timeline_start_ns(s->timeline), t;
    if (__builtin_add_overflow(t0, ns, &t))
        return AP_POSE_NONE;
    return ap_timeline_at(s->timeline, s->log_device[device], t, sample);
}

static int64_t log_frame_count(const struct sim_source *s, double refresh_hz) {
    return ap_timeline_frame_count(s->timeline, refresh_hz);
}

static enum ap_pose_state walk_at(const struct sim_source *s, enum sim_device device, int64_t ns,
                                  struct ap_sample *sample) {
    *sample = ap_walk_at(&s->walk, (int)device, ns);
    return AP_POSE_EXACT;
}

// A walk on the virtual clock ends like a recording of it.
static int64_t walk_frame_count(const struct sim_source *s, double refresh_hz) {
    return (int64_t)floor(ap_walk_duration_s(&s->walk) * refresh_hz + 1e-9) + 1;
}

static enum ap_pose_state window_at(const struct sim_source *s, enum sim_device device, int64_t ns,
                                    struct ap_sample *sample) {
    *sample = sim_window_player_at(&s->player, device);
    sample->t_ns = ns;
    return AP_POSE_EXACT;
}

static void window_input(struct sim_source *s, const struct sim_window_input *input,
                         double step_s) {
    sim_window_player_step(&s->player, input, step_s);
}

static const struct backend backends[] = {
    [SIM_POSES_WALK] = {.at = walk_at, .frame_count = walk_frame_count},
    [SIM_POSES_LOGS] = {.at = log_at, .frame_count = log_frame_count},
    [SIM_POSES_WINDOW] = {.at = window_at, .input = window_input},
};

static enum ap_status load_logs(struct ap_error *err, const struct sim_settings *settings,
                                struct sim_source *s) {
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
        s->log_device[d] = ap_timeline_find_device(s->timeline, device_names[d]);
    return AP_OK;
}

// Log time at an XrTime; false beyond 64 bits.
static bool log_time(const struct sim_source *s, int64_t xr_ns, int64_t *t_ns) {
    int64_t t0 = s->timeline ? ap_timeline_start_ns(s->timeline) : 0, ns;
    return !__builtin_sub_overflow(xr_ns, s->first_xr_ns, &ns) &&
           !__builtin_add_overflow(t0, ns, t_ns);
}

static enum ap_status load_inputs(struct ap_error *err, const struct sim_settings *settings,
                                  struct sim_source *s) {
    enum ap_status st = ap_inputlog_load(err, (const char *const *)settings->inputs,
                                         settings->input_count, &s->inputs);
    if (!st && s->timeline && ap_inputlog_end_ns(s->inputs) < ap_timeline_start_ns(s->timeline))
        ap_log(AP_LOG_WARNING,
               "%s: all of it lies before the first head pose at %lld ns; input logs have the "
               "pose logs' clock",
               settings->inputs[0], (long long)ap_timeline_start_ns(s->timeline));
    return st;
}

static void keep_first_local(struct sim_source *s);

enum ap_status sim_source_create(struct ap_error *err, const struct sim_settings *settings,
                                 struct sim_source **source) {
    struct sim_source *s = calloc(1, sizeof *s);
    if (!s)
        return ap_fail(err, AP_ENVIRONMENT, "out of memory");
    s->backend = &backends[settings->poses];
    s->first_xr_ns = SIM_FIRST_TIME_NS;
    s->walk = settings->walk;
    sim_window_player_init(&s->player);
    enum ap_status st = AP_OK;
    if (settings->poses == SIM_POSES_LOGS)
        st = load_logs(err, settings, s);
    if (!st && settings->input_count)
        st = load_inputs(err, settings, s);
    if (!st && settings->hands)
        st = ap_handlog_read(err, settings->hands, &s->hands);
    if (st) {
        sim_source_destroy(s);
        return st;
    }
    keep_first_local(s);
    *source = s;
    return AP_OK;
}

void sim_source_destroy(struct sim_source *source) {
    if (!source)
        return;
    ap_timeline_destroy(source->timeline);
    ap_inputlog_destroy(source->inputs);
    ap_handlog_destroy(source->hands);
    free(source);
}

void sim_source_start(struct sim_source *source, int64_t first_xr_ns) {
    source->first_xr_ns = first_xr_ns;
}

enum ap_pose_state sim_source_at(const struct sim_source *source, enum sim_device device,
                                 int64_t xr_ns, struct ap_sample *sample) {
    int64_t ns;
    if (__builtin_sub_overflow(xr_ns, source->first_xr_ns, &ns))
        return AP_POSE_NONE;
    return source->backend->at(source, device, ns, sample);
}

enum ap_pose_state sim_source_hand(const struct sim_source *source, int hand, int64_t xr_ns,
                                   struct ap_hand *out) {
    int64_t t_ns;
    if (source->hands)
        return log_time(source, xr_ns, &t_ns) ? ap_handlog_at(source->hands, hand, t_ns, out)
                                              : AP_POSE_NONE;
    struct ap_sample grip;
    enum ap_pose_state state =
        sim_source_at(source, hand == AP_HAND_LEFT ? SIM_LEFT : SIM_RIGHT, xr_ns, &grip);
    if (state)
        sim_make_hand(hand, grip.pose, (double)grip.trigger, (double)grip.squeeze, out);
    return state;
}

bool sim_source_component(const struct sim_source *source, const struct sim_component *component,
                          int top, int64_t xr_ns, float value[2]) {
    int64_t t_ns;
    return source->inputs && log_time(source, xr_ns, &t_ns) &&
           sim_inputs_at(source->inputs, component, top, t_ns, value);
}

// The top level path of a channel's device.
static int channel_top(struct ap_input_channel channel) {
    const char *slash = NULL;
    for (int top = 0; top < SIM_TOP_COUNT; top++) {
        slash = strrchr(sim_top_paths[top], '/');
        if (strcmp(slash + 1, channel.device) == 0)
            return top;
    }
    return -1;
}

bool sim_source_logs_device(const struct sim_source *source, int top) {
    int count = source->inputs ? ap_inputlog_channel_count(source->inputs) : 0;
    for (int c = 0; c < count; c++)
        if (channel_top(ap_inputlog_channel(source->inputs, c)) == top)
            return true;
    return false;
}

void sim_source_warn_unheard(struct sim_source *source, const int profile[SIM_TOP_COUNT]) {
    int count = source->inputs ? ap_inputlog_channel_count(source->inputs) : 0;
    if (source->warned_unheard)
        return;
    source->warned_unheard = true;
    for (int c = 0; c < count; c++) {
        struct ap_input_channel channel = ap_inputlog_channel(source->inputs, c);
        int top = channel_top(channel), p = top < 0 ? -1 : profile[top];
        if (p >= 0 && !sim_inputs_heard(source->inputs, c, p))
            ap_log(AP_LOG_WARNING, "the input log's %s %s is no input of the %s", channel.device,
                   channel.path, sim_profiles[p].name);
    }
}

int64_t sim_source_frame_count(const struct sim_source *source, double refresh_hz) {
    return source->backend->frame_count ? source->backend->frame_count(source, refresh_hz) : -1;
}

// Yaw from where the head looks; straight up or down it is the head's own twist.
static struct ap_pose level(struct ap_pose head) {
    struct ap_vec3 ahead = ap_quat_rotate(head.q, (struct ap_vec3){0, 0, -1});
    double yaw =
        hypot(ahead.x, ahead.z) > 1e-6 ? atan2(-ahead.x, -ahead.z) : 2 * atan2(head.q.y, head.q.w);
    return (struct ap_pose){.p = head.p,
                            .q = ap_quat_from_axis_angle((struct ap_vec3){0, 1, 0}, yaw)};
}

// What the window moves has no past: its first pose is kept.
static void keep_first_local(struct sim_source *s) {
    struct ap_sample head;
    s->first_local = (struct ap_pose){.p = {0, 1.6, 0}, .q = AP_QUAT_IDENTITY};
    if (s->backend->at(s, SIM_HEAD, 0, &head) != AP_POSE_NONE)
        s->first_local = level(head.pose);
}

struct ap_pose sim_source_stage_from_local(const struct sim_source *source) {
    return source->first_local;
}

bool sim_source_local_at(const struct sim_source *source, int64_t xr_ns, struct ap_pose *local) {
    struct ap_sample head;
    enum ap_pose_state state = sim_source_at(source, SIM_HEAD, xr_ns, &head);
    if (state == AP_POSE_NONE || state == AP_POSE_LOST)
        return false;
    *local = level(head.pose);
    return true;
}

void sim_source_input(struct sim_source *source, const struct sim_window_input *input,
                      double step_s) {
    if (source->backend->input)
        source->backend->input(source, input, step_s);
}
