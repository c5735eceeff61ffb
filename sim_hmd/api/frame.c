#include <stdlib.h>
#include <string.h>

#include "sim_hmd/capture/session.h"
#include "sim_hmd/compose/frame.h"
#include "sim_hmd/core/layers.h"
#include "sim_hmd/core/spaces.h"
#include "sim_hmd/core/swapchains.h"
#include "sim_hmd/input/source.h"
#include "sim_hmd/window/input.h"
#include "src/base/clock.h"

// The frame loop: xrWaitFrame, xrBeginFrame, xrEndFrame, and xrLocateViews.

// Blocks until the frame before is begun, as the specification asks of overlapping frames. The
// lock is given up meanwhile: everything is looked up again.
SIM_HOT static XrResult wait_for_turn(XrSession handle, struct sim_session **session) {
    for (;;) {
        XrResult result = sim_session_get(handle, session);
        if (result != XR_SUCCESS)
            return result;
        if (!(*session)->running)
            return XR_ERROR_SESSION_NOT_RUNNING;
        if (!(*session)->waited)
            return XR_SUCCESS;
        sim_wait();
    }
}

SIM_HOT static XrResult sleep_until(XrSession handle, int64_t machine_ns,
                                    struct sim_session **session) {
    if (machine_ns != INT64_MIN)
        sim_sleep_until(machine_ns);
    XrResult result = sim_session_get(handle, session);
    if (result == XR_SUCCESS && !(*session)->running)
        return XR_ERROR_SESSION_NOT_RUNNING;
    return result;
}

SIM_HOT static bool past_the_end(const struct sim_session *session, int64_t index) {
    return session->frame_limit >= 0 && index >= session->frame_limit;
}

SIM_HOT static bool should_render(const struct sim_session *session, int64_t index) {
    if (!sim_session_shows(session) || past_the_end(session, index) || session->headless)
        return false;
    if (session->pacer.clock == SIM_CLOCK_REAL)
        return true;
    const struct sim_settings *settings = &session->instance->settings;
    return settings->draw_all || sim_settings_captures(settings, index) ||
           sim_compositor_wants_frames(session->compositor);
}

SIM_HOT static void take_window_input(struct sim_session *session,
                                      const struct sim_prediction *frame) {
    struct sim_window_input input = {0};
    if (session->compositor && sim_compositor_input(session->compositor, &input))
        sim_source_input(session->instance->source, &input, (double)frame->period_ns * 1e-9);
    sim_recentre_due(session, frame, input.keys);
    if (input.closed)
        sim_session_ask_to_end(session);
}

// XrTime, where a line of the frame tells it.
static int64_t now_for_log(const struct sim_session *session) {
    return session->frames_log ? sim_pacer_now(&session->pacer, ap_clock_now_ns()) : 0;
}

SIM_HOT XrResult XRAPI_CALL xrWaitFrame(XrSession handle, const XrFrameWaitInfo *info,
                                        XrFrameState *state) {
    SIM_LOCKED;
    if (!sim_object_get(sim_raw(handle), SIM_SESSION))
        return XR_ERROR_HANDLE_INVALID;
    if ((info && info->type != XR_TYPE_FRAME_WAIT_INFO) || !sim_is(state, XR_TYPE_FRAME_STATE))
        return XR_ERROR_VALIDATION_FAILURE;
    struct sim_session *session;
    XrResult result = wait_for_turn(handle, &session);
    if (result != XR_SUCCESS)
        return result;
    bool first = session->pacer.count == 0;
    struct sim_prediction frame = sim_pacer_next(&session->pacer, ap_clock_now_ns());
    session->waited = true;
    session->waited_frame = frame;
    if (first) {
        sim_source_start(session->instance->source, frame.display_ns,
                         frame.display_ns - SIM_FIRST_TIME_NS + session->pacer.epoch_ns);
        if (session->state == XR_SESSION_STATE_READY)
            sim_session_show(session);
    }
    if (!session->windowed)
        sim_recentre_due(session, &frame, 0);
    sim_source_prepare(session->instance->source, &session->pacer);
    result = sleep_until(handle, frame.wake_machine_ns, &session);
    if (result != XR_SUCCESS)
        return result;
    session->waited_frame.waited_ns = now_for_log(session);
    if (session->windowed)
        take_window_input(session, &frame);
    state->predictedDisplayTime = frame.display_ns;
    state->predictedDisplayPeriod = frame.period_ns;
    state->shouldRender = should_render(session, frame.index);
    return XR_SUCCESS;
}

SIM_HOT XrResult XRAPI_CALL xrBeginFrame(XrSession handle, const XrFrameBeginInfo *info) {
    SIM_LOCKED;
    struct sim_session *session;
    XrResult result = sim_session_get(handle, &session);
    if (result != XR_SUCCESS)
        return result;
    if (info && info->type != XR_TYPE_FRAME_BEGIN_INFO)
        return XR_ERROR_VALIDATION_FAILURE;
    if (!session->running)
        return XR_ERROR_SESSION_NOT_RUNNING;
    if (!session->waited)
        return XR_ERROR_CALL_ORDER_INVALID;
    bool discarded = session->begun;
    session->discarded += discarded;
    session->missed += session->waited_frame.missed;
    session->begun = true;
    session->begun_frame = session->waited_frame;
    session->begun_frame.begun_ns = now_for_log(session);
    session->waited = false;
    sim_wake();
    return discarded ? XR_FRAME_DISCARDED : XR_SUCCESS;
}

SIM_HOT static XrResult check_end(const struct sim_session *session, const XrFrameEndInfo *info) {
    if (!session->running)
        return XR_ERROR_SESSION_NOT_RUNNING;
    if (!session->begun)
        return XR_ERROR_CALL_ORDER_INVALID;
    if (info->displayTime <= 0)
        return XR_ERROR_TIME_INVALID;
    switch (info->environmentBlendMode) {
    case XR_ENVIRONMENT_BLEND_MODE_OPAQUE:
        return XR_SUCCESS;
    case XR_ENVIRONMENT_BLEND_MODE_ADDITIVE:
    case XR_ENVIRONMENT_BLEND_MODE_ALPHA_BLEND:
        return XR_ERROR_ENVIRONMENT_BLEND_MODE_UNSUPPORTED;
    default:
        return XR_ERROR_VALIDATION_FAILURE;
    }
}

// How long before its display time the begun frame is ended; negative: too late for it.
SIM_HOT static int64_t margin_ns(const struct sim_session *session) {
    if (session->pacer.clock == SIM_CLOCK_VIRTUAL)
        return 0;
    return session->begun_frame.display_ns - sim_pacer_now(&session->pacer, ap_clock_now_ns());
}

SIM_HOT static void count_frame(struct sim_session *session, int64_t margin) {
    struct sim_frame_counts *counts = &session->counts;
    if (!counts->shown || margin < counts->margin_least_ns)
        counts->margin_least_ns = margin;
    counts->margin_sum_ns += (double)margin;
    counts->late += margin < 0;
    counts->shown++;
    counts->discarded += session->discarded;
    counts->missed += session->missed;
    session->discarded = session->missed = 0;
}

// The headset shows the frame when it was predicted, whatever time the program names.
SIM_HOT static XrResult show_frame(struct sim_session *session, const XrFrameEndInfo *info,
                                   int64_t margin) {
    static struct sim_frame frame; // large; the lock guards it; each layer is zeroed as it is used
    frame.index = session->begun_frame.index;
    frame.display_time = session->begun_frame.display_ns;
    frame.discarded = session->discarded;
    frame.missed = session->missed;
    frame.margin_ns = margin;
    frame.capture = false;
    XrResult result = sim_layers_resolve(session, info, &frame);
    if (result != XR_SUCCESS || session->headless)
        return result;
    if (session->garbage)
        sim_session_collect_garbage(session);
    if (!session->watched)
        return XR_SUCCESS;
    const struct sim_settings *settings = &session->instance->settings;
    bool seen = !past_the_end(session, frame.index);
    bool captured = seen && sim_settings_captures(settings, frame.index);
    frame.capture = captured && settings->capture_composed;
    struct ap_error err;
    if ((seen && sim_session_capture_frame(&err, session, info, &frame, captured)) ||
        sim_compositor_frame(&err, session->compositor, &frame)) {
        sim_session_lose(session, err.text);
        return XR_ERROR_SESSION_LOST;
    }
    return XR_SUCCESS;
}

SIM_HOT XrResult XRAPI_CALL xrEndFrame(XrSession handle, const XrFrameEndInfo *info) {
    SIM_LOCKED;
    struct sim_session *session;
    XrResult result = sim_session_get(handle, &session);
    if (result != XR_SUCCESS)
        return result;
    if (!sim_is(info, XR_TYPE_FRAME_END_INFO))
        return XR_ERROR_VALIDATION_FAILURE;
    int64_t margin = margin_ns(session);
    result = check_end(session, info);
    if (result == XR_SUCCESS)
        result = show_frame(session, info, margin);
    if (result != XR_SUCCESS)
        return result;
    session->begun = false;
    count_frame(session, margin);
    if (past_the_end(session, session->begun_frame.index + 1))
        sim_session_ask_to_end(session);
    return XR_SUCCESS;
}

SIM_HOT static XrViewStateFlags view_flags(enum ap_pose_state state) {
    // The bits of XrViewStateFlags are those of XrSpaceLocationFlags.
    return (XrViewStateFlags)sim_location_flags(state);
}

SIM_HOT static void fill_views(const struct sim_session *session, const struct sim_space *space,
                               XrTime time, XrViewState *state, XrView *views) {
    struct sim_located base = sim_space_in_stage(space, time);
    struct sim_located head = sim_head_in_stage(session, time);
    enum ap_pose_state worst = sim_worse_state(base.state, head.state);
    struct ap_pose base_from_view =
        worst ? ap_pose_mul(ap_pose_inverse(base.pose), head.pose) : AP_POSE_IDENTITY;
    // In VIEW the eyes stand where the profile says, to the last bit and tracked or not.
    if (!space->is_action && space->reference == XR_REFERENCE_SPACE_TYPE_VIEW)
        base_from_view = ap_pose_inverse(space->parent_from_space);
    state->viewStateFlags = view_flags(worst);
    for (int eye = 0; eye < 2; eye++) {
        views[eye].pose = sim_pose_to_xr(ap_pose_mul(base_from_view, session->view_from_eye[eye]));
        views[eye].fov = session->fov[eye];
    }
}

SIM_HOT XrResult XRAPI_CALL xrLocateViews(XrSession handle, const XrViewLocateInfo *info,
                                          XrViewState *state, uint32_t capacity, uint32_t *count,
                                          XrView *views) {
    SIM_LOCKED;
    struct sim_session *session;
    XrResult result = sim_session_get(handle, &session);
    if (result != XR_SUCCESS)
        return result;
    if (!sim_is(info, XR_TYPE_VIEW_LOCATE_INFO) || !sim_is(state, XR_TYPE_VIEW_STATE) || !count ||
        (capacity && !views))
        return XR_ERROR_VALIDATION_FAILURE;
    struct sim_space *space = sim_space_get(info->space);
    if (!space)
        return XR_ERROR_HANDLE_INVALID;
    if (space->session != session)
        return XR_ERROR_VALIDATION_FAILURE;
    if (info->viewConfigurationType != XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO)
        return XR_ERROR_VIEW_CONFIGURATION_TYPE_UNSUPPORTED;
    if (info->displayTime <= 0)
        return XR_ERROR_TIME_INVALID;
    *count = 2;
    if (capacity == 0)
        return XR_SUCCESS;
    if (capacity < 2)
        return XR_ERROR_SIZE_INSUFFICIENT;
    for (int i = 0; i < 2; i++)
        if (views[i].type != XR_TYPE_VIEW)
            return XR_ERROR_VALIDATION_FAILURE;
    fill_views(session, space, info->displayTime, state, views);
    return XR_SUCCESS;
}
