#include "sim_hmd/core/session.h"
#include "sim_hmd/input/source.h"

// XR_FB_display_refresh_rate: programs choose among the settings' rates.

XrResult XRAPI_CALL xrEnumerateDisplayRefreshRatesFB(XrSession handle, uint32_t capacity,
                                                     uint32_t *count, float *rates) {
    SIM_LOCKED;
    struct sim_session *session;
    XrResult result = sim_session_get(handle, &session);
    if (result != XR_SUCCESS)
        return result;
    const struct sim_settings *settings = &session->instance->settings;
    float all[SIM_MAX_RATES];
    for (size_t i = 0; i < settings->rate_count; i++)
        all[i] = (float)settings->rates_hz[i];
    return sim_two_calls(capacity, count, (uint32_t)settings->rate_count, all, sizeof *all, rates);
}

XrResult XRAPI_CALL xrGetDisplayRefreshRateFB(XrSession handle, float *rate) {
    SIM_LOCKED;
    struct sim_session *session;
    XrResult result = sim_session_get(handle, &session);
    if (result != XR_SUCCESS)
        return result;
    if (!rate)
        return XR_ERROR_VALIDATION_FAILURE;
    *rate = (float)session->pacer.refresh_hz;
    return XR_SUCCESS;
}

// A recording still ends with its last sample: as many frames at the new rate as are left of it.
static void renew_frame_limit(struct sim_session *session) {
    const struct sim_instance *instance = session->instance;
    const struct sim_pacer *pacer = &session->pacer;
    // At a frame a nanosecond.
    int64_t length_ns = sim_source_frame_count(instance->source, 1e9) - 1;
    if (pacer->clock != SIM_CLOCK_VIRTUAL || length_ns < 0)
        return;
    int64_t done = pacer->count, from_ns = pacer->last_ns - SIM_FIRST_TIME_NS;
    if (!done) { // the first frame is still to come
        done = 1;
        from_ns = 0;
    }
    int64_t limit = done;
    if (length_ns > from_ns) {
        int64_t more = (int64_t)((double)(length_ns - from_ns) * 1e-9 * pacer->refresh_hz) + 1;
        while (more > 0 && ap_frame_time_ns(from_ns, more, pacer->refresh_hz) > length_ns)
            more--;
        limit += more;
    }
    const int64_t frames = instance->settings.frames;
    session->frame_limit = frames && frames < limit ? frames : limit;
}

XrResult XRAPI_CALL xrRequestDisplayRefreshRateFB(XrSession handle, float rate) {
    SIM_LOCKED;
    struct sim_session *session;
    XrResult result = sim_session_get(handle, &session);
    if (result != XR_SUCCESS)
        return result;
    const struct sim_settings *settings = &session->instance->settings;
    // 0: the program has no wish; the headset's own rate.
    double wanted = rate == 0.0f ? settings->profile.refresh_hz : 0;
    for (size_t i = 0; i < settings->rate_count; i++)
        if ((float)settings->rates_hz[i] == rate)
            wanted = settings->rates_hz[i];
    if (wanted == 0)
        return XR_ERROR_DISPLAY_REFRESH_RATE_UNSUPPORTED_FB;
    if (wanted == session->pacer.refresh_hz)
        return XR_SUCCESS;
    XrEventDataDisplayRefreshRateChangedFB event = {
        .type = XR_TYPE_EVENT_DATA_DISPLAY_REFRESH_RATE_CHANGED_FB,
        .fromDisplayRefreshRate = (float)session->pacer.refresh_hz,
        .toDisplayRefreshRate = (float)wanted};
    sim_pacer_set_rate(&session->pacer, wanted);
    renew_frame_limit(session);
    sim_events_push(&session->instance->events, SIM_HANDLE(XrSession, session), &event,
                    sizeof event);
    return XR_SUCCESS;
}

const struct sim_function sim_functions_FB_display_refresh_rate[] = {
    SIM_FUNCTION(xrEnumerateDisplayRefreshRatesFB),
    SIM_FUNCTION(xrGetDisplayRefreshRateFB),
    SIM_FUNCTION(xrRequestDisplayRefreshRateFB),
    {0},
};
