#include <stdlib.h>

#include "sim_hmd/core/session.h"
#include "src/base/clock.h"
#include "src/base/log.h"

void sim_session_set_state(struct sim_session *session, XrSessionState state) {
    if (session->state == state)
        return;
    session->state = state;
    XrEventDataSessionStateChanged event = {
        .type = XR_TYPE_EVENT_DATA_SESSION_STATE_CHANGED,
        .session = SIM_HANDLE(XrSession, session),
        .state = state,
        .time = sim_pacer_now(&session->pacer, ap_clock_now_ns()),
    };
    sim_events_push(&session->instance->events, event.session, &event, sizeof event);
}

SIM_HOT bool sim_session_shows(const struct sim_session *session) {
    return session->state == XR_SESSION_STATE_VISIBLE || session->state == XR_SESSION_STATE_FOCUSED;
}

// Down the ladder to STOPPING, one event a rung; the program answers with xrEndSession.
void sim_session_ask_to_end(struct sim_session *session) {
    if (!session->running || session->state == XR_SESSION_STATE_STOPPING)
        return;
    if (session->state == XR_SESSION_STATE_FOCUSED)
        sim_session_set_state(session, XR_SESSION_STATE_VISIBLE);
    if (session->state == XR_SESSION_STATE_VISIBLE)
        sim_session_set_state(session, XR_SESSION_STATE_SYNCHRONIZED);
    sim_session_set_state(session, XR_SESSION_STATE_STOPPING);
}

void sim_session_lose(struct sim_session *session, const char *what) {
    if (session->lost)
        return;
    ap_log(AP_LOG_ERROR, "%s; the session is lost", what);
    session->lost = true;
    session->running = false;
    sim_session_set_state(session, XR_SESSION_STATE_LOSS_PENDING);
    sim_wake();
}

void sim_session_report(const struct sim_session *session) {
    const struct sim_frame_counts *c = &session->counts;
    if (session->pacer.clock != SIM_CLOCK_REAL || !c->shown)
        return;
    ap_log(AP_LOG_INFO,
           "%lld frames: %lld display periods missed, %lld frames discarded, %lld ended late; "
           "%.1f ms to the display on average, %.1f at the least",
           (long long)c->shown, (long long)c->missed, (long long)c->discarded, (long long)c->late,
           c->margin_sum_ns / (double)c->shown * 1e-6, (double)c->margin_least_ns * 1e-6);
}
