#include <math.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>

#include "src/app/progress.h"
#include "src/app/replay.h"
#include "src/base/clock.h"
#include "src/base/log.h"

// The frame loop of `replay`. The log is told twice: the simulated headset replays it through
// OpenXR, and the timeline holds it here in double. The trackers get the doubles; every pose that
// comes through the loader is held against them, so the door is proved at each frame.

// The runtime hands out float32: half an ulp at 64 m, and a unit quaternion's rounding.
static const double pose_tolerance = 1e-5;

static volatile sig_atomic_t interrupt_asked;

// The first asks the loop to end, and lets what is written be finished; a second one is not argued
// with.
static void on_interrupt(int sig) {
    if (interrupt_asked)
        signal(sig, SIG_DFL);
    interrupt_asked = 1;
}

struct loop {
    struct ap_replay *replay;
    struct ap_xr *xr;
    struct ap_gpu gpu;
    struct ap_renderer *renderer;
    uint32_t width, height;
    struct ap_frame_input input;
    int64_t next; // frame number
};

static double ms_since(int64_t *mark) {
    int64_t now = ap_clock_now_ns();
    double ms = (double)(now - *mark) * 1e-6;
    *mark = now;
    return ms;
}

static enum ap_status check_pose(struct ap_error *err, const char *device, int64_t frame,
                                 const struct ap_xr_located *located, struct ap_pose want) {
    double dp = ap_vec3_length(ap_vec3_sub(located->pose.p, want.p));
    struct ap_quat d = ap_quat_mul(ap_quat_conj(want.q), located->pose.q);
    double dq = 2 * ap_vec3_length((struct ap_vec3){d.x, d.y, d.z});
    double tolerance = pose_tolerance * fmax(1, ap_vec3_length(want.p) / 64);
    if (located->valid && dp <= tolerance && dq <= pose_tolerance)
        return AP_OK;
    return ap_fail(
        err, AP_ENVIRONMENT,
        "frame %lld: the runtime places %s %.3g m and %.3g rad from where the log has it "
        "(tolerance %.1g): is another runtime in the way?",
        (long long)frame, device, dp, dq, tolerance);
}

static const struct ap_xr_located *located_of(const struct ap_xr_frame *frame, const char *device) {
    if (strcmp(device, "head") == 0)
        return &frame->head;
    if (strcmp(device, "left") == 0)
        return &frame->hand[0].grip;
    return strcmp(device, "right") == 0 ? &frame->hand[1].grip : NULL;
}

// One device at frame k: pose, tracker, check, row.
static enum ap_status step_device(struct ap_error *err, struct loop *loop, int device,
                                  const struct ap_xr_frame *frame, int64_t t_ns) {
    struct ap_replay *replay = loop->replay;
    struct ap_sample sample;
    enum ap_pose_state state = ap_timeline_at(replay->timeline, device, t_ns, &sample);
    if (state == AP_POSE_NONE)
        return AP_OK;
    struct ap_frame_row row = {.frame = loop->next,
                               .t_ns = t_ns,
                               .device = ap_timeline_device_name(replay->timeline, device),
                               .state = state,
                               .pose = sample.pose};
    const struct ap_xr_located *located = located_of(frame, row.device);
    enum ap_status st = AP_OK;
    if (located)
        st = check_pose(err, row.device, loop->next, located, sample.pose);
    if (!st)
        st = ap_tracker_feed(err, replay->room.tracker, row.device, sample.pose, &row.has_row,
                             &row.world_from_device);
    if (st)
        return st;
    ap_replay_write_frame_row(replay, &row);
    if (row.has_row && strcmp(row.device, "head") == 0)
        loop->input.viewer.world_from_nose = row.world_from_device;
    for (int hand = 0; hand < 2; hand++)
        if (row.has_row && strcmp(row.device, hand ? "right" : "left") == 0) {
            loop->input.hand_tracked[hand] = true;
            loop->input.world_from_hand[hand] = row.world_from_device;
        }
    return AP_OK;
}

// In what order the devices of a frame are placed: what others are placed by, the head, the rest.
static int turn_of(const struct ap_replay *replay, int device) {
    const char *name = ap_timeline_device_name(replay->timeline, device);
    if (ap_tracker_leads(replay->room.tracker, name))
        return 0;
    return strcmp(name, "head") == 0 ? 1 : 2;
}

// All devices of frame k, each by where the anchor is now.
static enum ap_status step_devices(struct ap_error *err, struct loop *loop,
                                   const struct ap_xr_frame *frame) {
    const struct ap_timeline *timeline = loop->replay->timeline;
    int64_t t0 = ap_timeline_start_ns(timeline);
    int64_t t_ns = ap_frame_time_ns(t0, loop->next, loop->replay->headset.refresh_hz);
    if (frame->time_ns != t_ns - t0 + 1000000000)
        return ap_fail(err, AP_ENVIRONMENT, "frame %lld: the runtime's clock says %lld, not %lld",
                       (long long)loop->next, (long long)frame->time_ns,
                       (long long)(t_ns - t0 + 1000000000));
    loop->input.hand_tracked[0] = loop->input.hand_tracked[1] = false;
    enum ap_status st = AP_OK;
    for (int turn = 0; turn < 3; turn++)
        for (int d = 0; !st && d < ap_timeline_device_count(timeline); d++)
            if (turn_of(loop->replay, d) == turn)
                st = step_device(err, loop, d, frame, t_ns);
    return st ? st
              : ap_room_follow(err, &loop->replay->room, &loop->input.viewer.world_from_nose,
                               loop->input.world_from_hand);
}

static enum ap_status note_captured(struct ap_error *err, struct ap_replay *replay, int64_t frame) {
    if (replay->captured_count == replay->captured_room) {
        size_t more = replay->captured_room ? replay->captured_room * 2 : 64;
        int64_t *list = realloc(replay->captured, more * sizeof *list);
        if (!list)
            return ap_fail(err, AP_ENVIRONMENT, "out of memory");
        replay->captured = list;
        replay->captured_room = more;
    }
    replay->captured[replay->captured_count++] = frame;
    return AP_OK;
}

static void count_views(struct ap_replay_totals *totals, const struct ap_frame_stats *stats) {
    totals->cells.visited += stats->cells.visited;
    totals->cells.cone += stats->cells.cone;
    totals->cells.size += stats->cells.size;
    totals->cells.walls += stats->cells.walls;
    totals->cells.budget += stats->cells.budget;
    for (int eye = 0; eye < 2; eye++) {
        const struct ap_eye_stats *s = &stats->eye[eye];
        totals->draws += s->draws;
        totals->culled += s->culled;
        totals->turned_away += s->turned_away;
        totals->back_hidden += s->back_hidden;
        totals->back_draws += s->back_draws;
        totals->triangles += s->triangles;
        totals->vertices += s->vertices;
    }
    totals->refined += stats->refined;
    totals->unseen_facets += stats->unseen_facets;
    if (stats->beyond_bound > 0 && totals->beyond_bound == 0 && stats->over_budget == 0)
        ap_log(AP_LOG_WARNING,
               "some surfaces come too near for --max-error to hold everywhere, or need more "
               "triangles than a frame may have; --stats counts them");
    totals->beyond_bound += stats->beyond_bound;
    totals->over_budget += stats->over_budget;
    totals->held_bytes =
        stats->held_bytes > totals->held_bytes ? stats->held_bytes : totals->held_bytes;
    totals->out_of_domain += stats->out_of_domain;
}

static enum ap_status draw(struct ap_error *err, struct loop *loop, const struct ap_xr_frame *frame,
                           struct ap_replay_times *times) {
    struct ap_replay *replay = loop->replay;
    struct ap_xr_images images;
    enum ap_status st = ap_xr_acquire(err, loop->xr, &images);
    if (st)
        return st;
    loop->input.viewer = ap_room_viewer(&replay->room, loop->input.viewer.world_from_nose,
                                        frame->view, loop->width, loop->height);
    loop->input.closed_eyes = replay->room.closed_eyes;
    const struct ap_target target = {.image = {images.image[0], images.image[1]},
                                     .layer = {images.layer[0], images.layer[1]}};
    struct ap_frame_stats stats;
    st = ap_renderer_draw(err, loop->renderer, &loop->input, &target, &stats);
    if (st)
        return st;
    times->place_ms = stats.place_ms;
    times->record_ms = stats.record_ms;
    times->submit_ms = stats.submit_ms;
    ap_replay_write_view_rows(replay, loop->next, frame->view, &stats);
    count_views(&replay->totals, &stats);
    replay->totals.drawn++;
    return note_captured(err, replay, loop->next);
}

static void add_times(struct ap_replay_totals *totals, const struct ap_replay_times *times) {
    totals->wait_ms += times->wait_ms;
    totals->track_ms += times->track_ms;
    totals->draw_ms += times->draw_ms;
    totals->end_ms += times->end_ms;
    totals->place_ms += times->place_ms;
    totals->record_ms += times->record_ms;
    totals->submit_ms += times->submit_ms;
    totals->gpu_ms += isnan(times->gpu_ms) ? 0 : times->gpu_ms;
}

static enum ap_status step(struct ap_error *err, struct loop *loop) {
    struct ap_replay_totals *totals = &loop->replay->totals;
    struct ap_xr_frame frame;
    int64_t mark = ap_clock_now_ns();
    enum ap_status st = ap_xr_begin_frame(err, loop->xr, &frame);
    if (st)
        return st;
    struct ap_replay_times times = {.wait_ms = ms_since(&mark), .gpu_ms = NAN};
    st = step_devices(err, loop, &frame);
    if (!st && loop->replay->play)
        st = ap_table_play_step(err, loop->replay->play,
                                (double)(frame.time_ns - 1000000000) * 1e-9);
    if (st)
        return st;
    times.track_ms = ms_since(&mark);
    if (frame.should_render)
        st = draw(err, loop, &frame, &times);
    if (st)
        return st;
    times.draw_ms = ms_since(&mark);
    st = ap_xr_end_frame(err, loop->xr, &frame);
    times.end_ms = ms_since(&mark);
    if (frame.should_render) {
        ap_renderer_gpu_ms(loop->renderer, &times.gpu_ms);
        ap_replay_write_timing(loop->replay, loop->next, &times);
    }
    add_times(totals, &times);
    totals->stepped++;
    loop->next++;
    return st;
}

static enum ap_status run_frames(struct ap_error *err, struct loop *loop) {
    struct ap_replay *replay = loop->replay;
    bool asked = false;
    for (;;) {
        if (interrupt_asked && !asked) {
            asked = replay->interrupted = true;
            enum ap_status st = ap_xr_request_exit(err, loop->xr);
            if (st)
                return st;
        }
        enum ap_xr_state state;
        enum ap_status st = ap_xr_poll(err, loop->xr, &state);
        if (st)
            return st;
        if (state == AP_XR_ENDED)
            break;
        if (state == AP_XR_LOST)
            return ap_fail(err, AP_ENVIRONMENT,
                           "the session was lost after frame %lld of %lld; the pictures written so "
                           "far are whole",
                           (long long)loop->next, (long long)replay->frame_count);
        if (state == AP_XR_WAITING) {
            ap_clock_sleep_until_ns(ap_clock_now_ns() + 1000000);
            continue;
        }
        st = step(err, loop);
        if (st)
            return st;
        ap_progress_show(ap_space_name(replay->room.scene->space), loop->next, replay->frame_count);
    }
    if (!replay->interrupted && loop->next != replay->frame_count)
        return ap_fail(err, AP_ENVIRONMENT, "the runtime ended after frame %lld of %lld",
                       (long long)loop->next, (long long)replay->frame_count);
    return AP_OK;
}

static enum ap_status open_loop(struct ap_error *err, struct loop *loop) {
    const struct ap_xr_params params = {.application = "antipode replay"};
    enum ap_status st = ap_xr_create(err, &params, &loop->xr);
    if (st)
        return st;
    struct ap_xr_vulkan vk = ap_xr_vulkan(loop->xr);
    st = ap_gpu_init(err, vk.instance, vk.physical_device, vk.device, vk.queue_family, 0,
                     &loop->gpu);
    if (st)
        return st;
    loop->width = vk.width_px;
    loop->height = vk.height_px;
    struct ap_renderer_params render = {.color_format = vk.color_format,
                                        .width = vk.width_px,
                                        .height = vk.height_px,
                                        .now_ns = ap_clock_now_ns,
                                        .no_multiview = !vk.multiview};
    ap_room_renderer_params(&loop->replay->room, &render);
    return ap_renderer_create(err, &loop->gpu, loop->replay->room.scene, &render, &loop->renderer);
}

static void close_loop(struct loop *loop) {
    ap_renderer_destroy(loop->renderer);
    if (loop->gpu.device)
        ap_gpu_finish(&loop->gpu);
    ap_xr_destroy(loop->xr); // joins the runtime's writers: every picture is on disk now
}

enum ap_status ap_replay_run(struct ap_error *err, struct ap_replay *replay) {
    struct loop loop = {.replay = replay, .input.viewer.world_from_nose = AP_ISO_IDENTITY};
    struct sigaction act = {.sa_handler = on_interrupt};
    interrupt_asked = 0;
    sigaction(SIGINT, &act, NULL);
    sigaction(SIGTERM, &act, NULL);
    int64_t start = ap_clock_now_ns();
    enum ap_status st = open_loop(err, &loop);
    if (!st)
        st = run_frames(err, &loop);
    close_loop(&loop);
    ap_progress_end();
    replay->totals.run_ms = ms_since(&start);
    return st;
}
