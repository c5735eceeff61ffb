#include "sim_hmd/capture/frames_log.h"
#include "sim_hmd/capture/layers.h"
#include "sim_hmd/capture/session.h"
#include "sim_hmd/compose/frame.h"
#include "sim_hmd/core/spaces.h"
#include "src/base/clock.h"
#include "src/base/log.h"

// What a session captures beside the composed pictures: what the program submitted, and a line a
// frame.

enum ap_status sim_session_capture_open(struct ap_error *err, struct sim_session *session) {
    const struct sim_settings *s = &session->instance->settings;
    enum ap_status st = AP_OK;
    if (!s->capture_dir)
        return AP_OK;
    if (s->capture_layers)
        st = sim_layer_capture_create(err, &session->gpu, s, &session->layer_capture);
    return st ? st : sim_frames_log_create(err, s, &session->frames_log);
}

SIM_HOT enum ap_status sim_session_capture_frame(struct ap_error *err, struct sim_session *session,
                                                 const XrFrameEndInfo *info,
                                                 const struct sim_frame *frame, bool captured) {
    if (!session->frames_log)
        return AP_OK;
    enum ap_status st = AP_OK;
    if (session->layer_capture && captured)
        st = sim_layer_capture_frame(err, session->layer_capture, frame);
    if (st)
        return st;
    struct sim_located head = sim_head_in_stage(session, frame->display_time);
    struct sim_logged_frame logged = {.predicted = &session->begun_frame,
                                      .ended_ns = sim_pacer_now(&session->pacer, ap_clock_now_ns()),
                                      .head_state = head.state,
                                      .stage_from_head = head.pose,
                                      .info = info,
                                      .frame = frame,
                                      .pulses = &session->pulses,
                                      .captured = captured};
    st = sim_frames_log_frame(err, session->frames_log, &logged);
    if (sim_frames_log_wants(session->frames_log, captured))
        session->pulses = (struct sim_pulses){0};
    return st;
}

enum ap_status sim_session_capture_flush(struct ap_error *err, struct sim_session *session) {
    enum ap_status st = AP_OK;
    if (session->layer_capture)
        st = sim_layer_capture_flush(err, session->layer_capture);
    return st ? st : sim_frames_log_commit(err, session->frames_log);
}

void sim_session_capture_close(struct sim_session *session) {
    sim_layer_capture_destroy(session->layer_capture);
    // A session that a program drops without xrEndSession has ended all the same.
    struct ap_error err;
    if (!session->lost && sim_frames_log_commit(&err, session->frames_log))
        ap_log(AP_LOG_ERROR, "%s", err.text);
    sim_frames_log_destroy(session->frames_log);
}
