#include "sim_hmd/input/source.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "sim_hmd/input/hand_model.h"
#include "sim_hmd/core/hot.h"
#include "sim_hmd/core/pacer.h"
#include "sim_hmd/input/log_inputs.h"
#include "src/base/log.h"

static const struct sim_poses_kind *const kinds[] = {
    [SIM_POSES_WALK] = &sim_poses_walk,
    [SIM_POSES_LOGS] = &sim_poses_logs,
    [SIM_POSES_WINDOW] = &sim_poses_window,
    [SIM_POSES_DEVICES] = &sim_poses_devices,
};

// Poses that were asked for last, so that the calls of a frame, which all ask for its display time
// (and a moment before it, for velocities), evaluate them once.
enum { REMEMBERED = 2, AHEAD = 32 };
struct remembered {
    bool there;
    enum ap_pose_state state;
    int64_t ns;
    struct ap_sample sample;
};

struct sim_source {
    const struct sim_poses_kind *kind;
    void *poses; // the kind's state
    int64_t first_xr_ns;
    struct ap_pose first_local;
    struct sim_source_stats stats;
    bool asked[SIM_DEVICE_COUNT]; // since sim_source_prepare
    int next_ahead[SIM_DEVICE_COUNT];
    struct remembered remembered[SIM_DEVICE_COUNT][REMEMBERED]; // newest first
    struct remembered ahead[SIM_DEVICE_COUNT][AHEAD];           // of the frames to come
    struct ap_inputlog *inputs;                                 // NULL: none
    struct ap_handlog *hands;                                   // NULL: none
    bool warned_unheard;
};

static int64_t start_ns(const struct sim_source *s) {
    return s->kind->start_ns ? s->kind->start_ns(s->poses) : 0;
}

// Log time at an XrTime; false beyond 64 bits.
static bool log_time(const struct sim_source *s, int64_t xr_ns, int64_t *t_ns) {
    int64_t ns;
    return !__builtin_sub_overflow(xr_ns, s->first_xr_ns, &ns) &&
           !__builtin_add_overflow(start_ns(s), ns, t_ns);
}

static enum ap_status load_inputs(struct ap_error *err, const struct sim_settings *settings,
                                  struct sim_source *s) {
    enum ap_status st = ap_inputlog_load(err, (const char *const *)settings->inputs,
                                         settings->input_count, &s->inputs);
    if (!st && s->kind->start_ns && ap_inputlog_end_ns(s->inputs) < start_ns(s))
        ap_log(AP_LOG_WARNING,
               "%s: all of it lies before the first head pose at %lld ns; input logs have the "
               "pose logs' clock",
               settings->inputs[0], (long long)start_ns(s));
    return st;
}

static void keep_first_local(struct sim_source *s);

static void forget(struct sim_source *s) {
    memset(s->remembered, 0, sizeof s->remembered);
    memset(s->ahead, 0, sizeof s->ahead);
}

enum ap_status sim_source_create(struct ap_error *err, const struct sim_settings *settings,
                                 struct sim_source **source) {
    struct sim_source *s = calloc(1, sizeof *s);
    if (!s)
        return ap_fail(err, AP_ENVIRONMENT, "out of memory");
    s->kind = kinds[settings->poses];
    s->first_xr_ns = SIM_FIRST_TIME_NS;
    enum ap_status st = s->kind->create(err, settings, &s->poses);
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
    source->kind->destroy(source->poses);
    ap_inputlog_destroy(source->inputs);
    ap_handlog_destroy(source->hands);
    free(source);
}

void sim_source_start(struct sim_source *source, int64_t first_xr_ns, int64_t machine_ns) {
    source->first_xr_ns = first_xr_ns;
    forget(source);
    if (source->kind->start)
        source->kind->start(source->poses, machine_ns);
}

static struct remembered evaluate(struct sim_source *source, enum sim_device device, int64_t ns) {
    struct remembered r = {.there = !source->kind->learns, .ns = ns};
    r.state = source->kind->at(source->poses, device, ns, &r.sample);
    source->stats.evaluated++;
    return r;
}

SIM_HOT static bool is_of(const struct remembered *r, int64_t ns) {
    return r->there && r->ns == ns;
}

SIM_HOT static void put_first(struct remembered list[REMEMBERED], const struct remembered *r) {
    for (int i = REMEMBERED - 1; i > 0; i--)
        list[i] = list[i - 1];
    list[0] = *r;
}

SIM_HOT static const struct remembered *recall(struct sim_source *source, enum sim_device device,
                                               int64_t ns) {
    struct remembered *list = source->remembered[device];
    source->stats.asked++;
    for (int i = 0; i < REMEMBERED; i++)
        if (is_of(&list[i], ns)) {
            source->stats.remembered++;
            return &list[i];
        }
    struct remembered r = evaluate(source, device, ns);
    put_first(list, &r);
    return list;
}

SIM_HOT enum ap_pose_state sim_source_at(struct sim_source *source, enum sim_device device,
                                         int64_t xr_ns, struct ap_sample *sample) {
    int64_t ns;
    if (__builtin_sub_overflow(xr_ns, source->first_xr_ns, &ns))
        return AP_POSE_NONE;
    source->asked[device] = true;
    const struct remembered *r = recall(source, device, ns);
    if (r->state != AP_POSE_NONE)
        *sample = r->sample;
    return r->state;
}

SIM_HOT static void prepare(struct sim_source *source, enum sim_device device,
                            const struct sim_pacer *pacer) {
    struct remembered *list = source->remembered[device], *ahead = source->ahead[device];
    int *next = &source->next_ahead[device];
    int64_t ns = sim_pacer_ahead(pacer, 0) - source->first_xr_ns;
    if (is_of(&list[0], ns))
        return;
    if (*next == AHEAD || !is_of(&ahead[*next], ns)) {
        int count = pacer->clock == SIM_CLOCK_REAL ? AHEAD : 1;
        for (int i = 0; i < count; i++)
            ahead[i] = evaluate(source, device, sim_pacer_ahead(pacer, i) - source->first_xr_ns);
        for (int i = count; i < AHEAD; i++)
            ahead[i].there = false;
        *next = 0;
    }
    put_first(list, &ahead[(*next)++]);
}

SIM_HOT void sim_source_prepare(struct sim_source *source, const struct sim_pacer *pacer) {
    // What learns, or moves with the window's next input, is not known yet.
    if (source->kind->learns || source->kind->input)
        return;
    for (int d = 0; d < SIM_DEVICE_COUNT; d++) {
        if (source->asked[d])
            prepare(source, (enum sim_device)d, pacer);
        source->asked[d] = false;
    }
}

struct sim_source_stats sim_source_stats(const struct sim_source *source) {
    return source->stats;
}

enum ap_pose_state sim_source_hand(struct sim_source *source, int hand, int64_t xr_ns,
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
    if (source->inputs && log_time(source, xr_ns, &t_ns) &&
        sim_inputs_at(source->inputs, component, top, t_ns, value))
        return true;
    return source->kind->component && source->kind->component(source->poses, component, top, value);
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
    return source->kind->frame_count ? source->kind->frame_count(source->poses, refresh_hz) : -1;
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
    if (s->kind->at(s->poses, SIM_HEAD, 0, &head) != AP_POSE_NONE)
        s->first_local = level(head.pose);
}

SIM_HOT struct ap_pose sim_source_stage_from_local(const struct sim_source *source) {
    return source->first_local;
}

bool sim_source_local_at(struct sim_source *source, int64_t xr_ns, struct ap_pose *local) {
    struct ap_sample head;
    enum ap_pose_state state = sim_source_at(source, SIM_HEAD, xr_ns, &head);
    if (state == AP_POSE_NONE || state == AP_POSE_LOST)
        return false;
    *local = level(head.pose);
    return true;
}

void sim_source_input(struct sim_source *source, const struct sim_window_input *input,
                      double step_s) {
    if (!source->kind->input)
        return;
    forget(source);
    source->kind->input(source->poses, input, step_s);
}
