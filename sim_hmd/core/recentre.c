#include <string.h>

#include "sim_hmd/core/spaces.h"
#include "sim_hmd/input/source.h"
#include "sim_hmd/window/input.h"
#include "src/base/log.h"

// Recentring: LOCAL (and LOCAL_FLOOR) moves to where the head is, at a time that the settings name
// or when the person at the window asks for it. What was located before keeps the old origin.

SIM_HOT static struct ap_pose first_local(const struct sim_session *session) {
    return sim_source_stage_from_local(session->instance->source);
}

SIM_HOT struct ap_pose sim_local_in_stage(const struct sim_session *session, XrTime time) {
    for (int i = session->recentring_count - 1; i >= 0; i--)
        if (time >= session->recentrings[i].from)
            return session->recentrings[i].stage_from_local;
    return session->recentring_count ? session->oldest_local : first_local(session);
}

struct ap_pose sim_local_floor_in_stage(const struct sim_session *session, XrTime time) {
    struct ap_pose local = sim_local_in_stage(session, time);
    local.p.y = 0;
    return local;
}

static void announce(struct sim_session *session, XrReferenceSpaceType type, XrTime time,
                     struct ap_pose before, struct ap_pose after) {
    XrEventDataReferenceSpaceChangePending event = {
        .type = XR_TYPE_EVENT_DATA_REFERENCE_SPACE_CHANGE_PENDING,
        .session = SIM_HANDLE(XrSession, session),
        .referenceSpaceType = type,
        .changeTime = time,
        .poseValid = XR_TRUE,
        .poseInPreviousSpace = sim_pose_to_xr(ap_pose_mul(ap_pose_inverse(before), after))};
    sim_events_push(&session->instance->events, event.session, &event, sizeof event);
}

static void recentre(struct sim_session *session, XrTime time) {
    struct ap_pose before = sim_local_in_stage(session, time), after;
    struct ap_pose floor_before = sim_local_floor_in_stage(session, time);
    if (!sim_source_local_at(session->instance->source, time, &after)) {
        ap_log(AP_LOG_WARNING, "not recentred: the head is not tracked");
        return;
    }
    if (!session->recentring_count)
        session->oldest_local = before;
    if (session->recentring_count == SIM_MAX_RECENTRINGS) {
        session->oldest_local = session->recentrings[0].stage_from_local;
        session->recentring_count--;
        memmove(&session->recentrings[0], &session->recentrings[1],
                (size_t)session->recentring_count * sizeof *session->recentrings);
    }
    session->recentrings[session->recentring_count++] = (struct sim_recentring){time, after};
    announce(session, XR_REFERENCE_SPACE_TYPE_LOCAL, time, before, after);
    if (session->instance->enabled[SIM_EXT_local_floor])
        announce(session, XR_REFERENCE_SPACE_TYPE_LOCAL_FLOOR_EXT, time, floor_before,
                 sim_local_floor_in_stage(session, time));
}

SIM_HOT void sim_recentre_due(struct sim_session *session, const struct sim_prediction *frame,
                              uint32_t keys) {
    const struct sim_settings *settings = &session->instance->settings;
    bool due = keys & ~session->keys & SIM_KEY_RECENTRE;
    session->keys = keys;
    if (!frame->index)
        session->first_frame_ns = frame->display_ns;
    double s = (double)(frame->display_ns - session->first_frame_ns) * 1e-9;
    for (; session->recentred < settings->recentre_count &&
           s >= settings->recentre_s[session->recentred];
         session->recentred++)
        due = true;
    if (due)
        recentre(session, frame->display_ns);
}
