#include <stdio.h>
#include <string.h>

#include "sim_hmd/input/actions.h"
#include "src/base/clock.h"

// Input: synchronisation, action states, where input comes from, haptics.

// The checks that all calls on one action share: it exists, and its set is attached to the session.
static XrResult get_action(const struct sim_session *session, XrAction handle,
                           struct sim_action **action) {
    *action = sim_action_get(handle);
    if (!*action)
        return XR_ERROR_HANDLE_INVALID;
    return (*action)->set->session == session->object.handle ? XR_SUCCESS
                                                             : XR_ERROR_ACTIONSET_NOT_ATTACHED;
}

static XrResult check_active_sets(const struct sim_session *session,
                                  const XrActionsSyncInfo *info) {
    for (uint32_t i = 0; i < info->countActiveActionSets; i++) {
        const XrActiveActionSet *active = &info->activeActionSets[i];
        const struct sim_action_set *set =
            sim_object_get(sim_raw(active->actionSet), SIM_ACTION_SET);
        if (!set)
            return XR_ERROR_HANDLE_INVALID;
        if (set->session != session->object.handle)
            return XR_ERROR_ACTIONSET_NOT_ATTACHED;
        if (active->subactionPath == XR_NULL_PATH)
            continue;
        const struct sim_paths *paths = &session->instance->paths;
        if (!sim_path_text(paths, active->subactionPath))
            return XR_ERROR_PATH_INVALID;
        int top = sim_path_top(paths, active->subactionPath);
        if (top < 0 || !set->top[top])
            return XR_ERROR_PATH_UNSUPPORTED;
    }
    return XR_SUCCESS;
}

static void announce_profiles(struct sim_session *session) {
    XrEventDataInteractionProfileChanged event = {
        .type = XR_TYPE_EVENT_DATA_INTERACTION_PROFILE_CHANGED,
        .session = SIM_HANDLE(XrSession, session)};
    sim_events_push(&session->instance->events, event.session, &event, sizeof event);
}

XrResult XRAPI_CALL xrSyncActions(XrSession handle, const XrActionsSyncInfo *info) {
    SIM_LOCKED;
    struct sim_session *session;
    XrResult result = sim_session_get(handle, &session);
    if (result != XR_SUCCESS)
        return result;
    if (!sim_is(info, XR_TYPE_ACTIONS_SYNC_INFO) ||
        (info->countActiveActionSets && !info->activeActionSets))
        return XR_ERROR_VALIDATION_FAILURE;
    result = check_active_sets(session, info);
    if (result != XR_SUCCESS)
        return result;
    // Hands are where they will be when the frame under way is shown: what a replay needs, and on
    // the real clock a prediction that comes true.
    session->input_ns = session->pacer.last_ns ? session->pacer.last_ns
                                               : sim_pacer_now(&session->pacer, ap_clock_now_ns());
    if (sim_actions_update(session, info))
        announce_profiles(session);
    return session->state == XR_SESSION_STATE_FOCUSED ? XR_SUCCESS : XR_SESSION_NOT_FOCUSED;
}

// What the four xrGetActionState… share.
static XrResult get_state(XrSession handle, const XrActionStateGetInfo *info, XrActionType type,
                          struct sim_action_state *state) {
    struct sim_session *session;
    struct sim_action *action;
    XrResult result = sim_session_get(handle, &session);
    if (result != XR_SUCCESS)
        return result;
    if (!sim_is(info, XR_TYPE_ACTION_STATE_GET_INFO))
        return XR_ERROR_VALIDATION_FAILURE;
    result = get_action(session, info->action, &action);
    if (result != XR_SUCCESS)
        return result;
    if (action->type != type)
        return XR_ERROR_ACTION_TYPE_MISMATCH;
    int top;
    result = sim_subaction(session->instance, action, info->subactionPath, &top);
    if (result != XR_SUCCESS)
        return result;
    *state = top < 0 ? action->combined : action->state[top];
    return XR_SUCCESS;
}

XrResult XRAPI_CALL xrGetActionStateBoolean(XrSession handle, const XrActionStateGetInfo *info,
                                            XrActionStateBoolean *out) {
    SIM_LOCKED;
    struct sim_action_state s;
    if (!sim_is(out, XR_TYPE_ACTION_STATE_BOOLEAN))
        return XR_ERROR_VALIDATION_FAILURE;
    XrResult result = get_state(handle, info, XR_ACTION_TYPE_BOOLEAN_INPUT, &s);
    if (result != XR_SUCCESS)
        return result;
    out->currentState = s.x != 0;
    out->changedSinceLastSync = s.changed;
    out->lastChangeTime = s.changed_at;
    out->isActive = s.active;
    return XR_SUCCESS;
}

XrResult XRAPI_CALL xrGetActionStateFloat(XrSession handle, const XrActionStateGetInfo *info,
                                          XrActionStateFloat *out) {
    SIM_LOCKED;
    struct sim_action_state s;
    if (!sim_is(out, XR_TYPE_ACTION_STATE_FLOAT))
        return XR_ERROR_VALIDATION_FAILURE;
    XrResult result = get_state(handle, info, XR_ACTION_TYPE_FLOAT_INPUT, &s);
    if (result != XR_SUCCESS)
        return result;
    out->currentState = s.x;
    out->changedSinceLastSync = s.changed;
    out->lastChangeTime = s.changed_at;
    out->isActive = s.active;
    return XR_SUCCESS;
}

XrResult XRAPI_CALL xrGetActionStateVector2f(XrSession handle, const XrActionStateGetInfo *info,
                                             XrActionStateVector2f *out) {
    SIM_LOCKED;
    struct sim_action_state s;
    if (!sim_is(out, XR_TYPE_ACTION_STATE_VECTOR2F))
        return XR_ERROR_VALIDATION_FAILURE;
    XrResult result = get_state(handle, info, XR_ACTION_TYPE_VECTOR2F_INPUT, &s);
    if (result != XR_SUCCESS)
        return result;
    out->currentState = (XrVector2f){s.x, s.y};
    out->changedSinceLastSync = s.changed;
    out->lastChangeTime = s.changed_at;
    out->isActive = s.active;
    return XR_SUCCESS;
}

XrResult XRAPI_CALL xrGetActionStatePose(XrSession handle, const XrActionStateGetInfo *info,
                                         XrActionStatePose *out) {
    SIM_LOCKED;
    struct sim_action_state s;
    if (!sim_is(out, XR_TYPE_ACTION_STATE_POSE))
        return XR_ERROR_VALIDATION_FAILURE;
    XrResult result = get_state(handle, info, XR_ACTION_TYPE_POSE_INPUT, &s);
    if (result != XR_SUCCESS)
        return result;
    out->isActive = s.active;
    return XR_SUCCESS;
}

XrResult XRAPI_CALL xrGetCurrentInteractionProfile(XrSession handle, XrPath top,
                                                   XrInteractionProfileState *state) {
    SIM_LOCKED;
    struct sim_session *session;
    XrResult result = sim_session_get(handle, &session);
    if (result != XR_SUCCESS)
        return result;
    if (!sim_is(state, XR_TYPE_INTERACTION_PROFILE_STATE))
        return XR_ERROR_VALIDATION_FAILURE;
    if (!session->attached)
        return XR_ERROR_ACTIONSET_NOT_ATTACHED;
    struct sim_paths *paths = &session->instance->paths;
    if (!sim_path_text(paths, top))
        return XR_ERROR_PATH_INVALID;
    int t = sim_path_top(paths, top);
    if (t < 0)
        return XR_ERROR_PATH_UNSUPPORTED;
    state->interactionProfile = XR_NULL_PATH;
    if (session->profile[t] < 0)
        return XR_SUCCESS;
    return sim_path_make(paths, sim_profiles[session->profile[t]].path, &state->interactionProfile);
}

XrResult XRAPI_CALL
xrEnumerateBoundSourcesForAction(XrSession handle, const XrBoundSourcesForActionEnumerateInfo *info,
                                 uint32_t capacity, uint32_t *count, XrPath *sources) {
    SIM_LOCKED;
    struct sim_session *session;
    struct sim_action *action;
    XrResult result = sim_session_get(handle, &session);
    if (result != XR_SUCCESS)
        return result;
    if (!sim_is(info, XR_TYPE_BOUND_SOURCES_FOR_ACTION_ENUMERATE_INFO))
        return XR_ERROR_VALIDATION_FAILURE;
    result = get_action(session, info->action, &action);
    if (result != XR_SUCCESS)
        return result;
    struct sim_instance *instance = session->instance;
    XrPath found[64];
    uint32_t n = 0;
    for (uint32_t i = 0; i < session->binding_count && n < 64; i++) {
        const struct sim_suggestion *s = &session->bindings[i];
        if (s->profile != session->profile[s->top] || s->action != action->object.handle ||
            !sim_kind_suits(s->component->kind, sim_actions_kind(action->type)))
            continue;
        char text[XR_MAX_PATH_LENGTH];
        snprintf(text, sizeof text, "%s%s", sim_top_paths[s->top], s->component->path);
        result = sim_path_make(&instance->paths, text, &found[n]);
        if (result != XR_SUCCESS)
            return result;
        bool again = false;
        for (uint32_t j = 0; j < n; j++)
            again |= found[j] == found[n];
        n += !again;
    }
    return sim_two_calls(capacity, count, n, found, sizeof *found, sources);
}

// "Left hand Touch controller trigger": the parts that the program asks for.
static void describe(int top, int profile, const struct sim_component *c,
                     XrInputSourceLocalizedNameFlags parts, char *text, size_t size) {
    static const char *const tops[SIM_TOP_COUNT] = {"Left hand", "Right hand", "Head", "Gamepad",
                                                    "Treadmill"};
    char component[64];
    const char *name = strchr(c->path + 1, '/') + 1;
    snprintf(component, sizeof component, "%.*s", (int)strcspn(name, "/"), name);
    for (char *p = component; *p; p++)
        if (*p == '_')
            *p = ' ';
    const char *const words[] = {
        parts & XR_INPUT_SOURCE_LOCALIZED_NAME_USER_PATH_BIT ? tops[top] : "",
        parts & XR_INPUT_SOURCE_LOCALIZED_NAME_INTERACTION_PROFILE_BIT ? sim_profiles[profile].name
                                                                       : "",
        parts & XR_INPUT_SOURCE_LOCALIZED_NAME_COMPONENT_BIT ? component : ""};
    size_t at = 0;
    text[0] = '\0';
    for (int i = 0; i < 3; i++)
        if (words[i][0])
            at += (size_t)snprintf(text + at, size - at, "%s%s", at ? " " : "", words[i]);
}

// Of the profiles that are current, or will be after the next xrSyncActions.
static const struct sim_component *find_source(const struct sim_session *session, const char *path,
                                               int *top, int *profile) {
    for (int t = 0; t < SIM_TOP_COUNT; t++) {
        *profile =
            session->profile[t] >= 0 ? session->profile[t] : sim_actions_choose_profile(session, t);
        const struct sim_component *c =
            *profile < 0 ? NULL : sim_profile_component(*profile, path, SIM_BOOL, top);
        if (c && *top == t && sim_instance_has(session->instance, c->needs))
            return c;
    }
    return NULL;
}

XrResult XRAPI_CALL xrGetInputSourceLocalizedName(XrSession handle,
                                                  const XrInputSourceLocalizedNameGetInfo *info,
                                                  uint32_t capacity, uint32_t *count,
                                                  char *buffer) {
    SIM_LOCKED;
    struct sim_session *session;
    XrResult result = sim_session_get(handle, &session);
    if (result != XR_SUCCESS)
        return result;
    const XrInputSourceLocalizedNameFlags all =
        XR_INPUT_SOURCE_LOCALIZED_NAME_USER_PATH_BIT |
        XR_INPUT_SOURCE_LOCALIZED_NAME_INTERACTION_PROFILE_BIT |
        XR_INPUT_SOURCE_LOCALIZED_NAME_COMPONENT_BIT;
    if (!sim_is(info, XR_TYPE_INPUT_SOURCE_LOCALIZED_NAME_GET_INFO) || !info->whichComponents ||
        info->whichComponents & ~all)
        return XR_ERROR_VALIDATION_FAILURE;
    if (!session->attached)
        return XR_ERROR_ACTIONSET_NOT_ATTACHED;
    const char *path = sim_path_text(&session->instance->paths, info->sourcePath);
    if (!path)
        return XR_ERROR_PATH_INVALID;
    int top, profile;
    const struct sim_component *c = find_source(session, path, &top, &profile);
    if (!c)
        return XR_ERROR_PATH_UNSUPPORTED;
    char text[256];
    describe(top, profile, c, info->whichComponents, text, sizeof text);
    return sim_two_call_text(capacity, count, text, buffer);
}

// A pulse where the program may send one; its values are the caller's.
static XrResult feel(XrSession handle, const XrHapticActionInfo *info, struct sim_pulse pulse) {
    struct sim_session *session;
    struct sim_action *action;
    XrResult result = sim_session_get(handle, &session);
    if (result != XR_SUCCESS)
        return result;
    if (!sim_is(info, XR_TYPE_HAPTIC_ACTION_INFO))
        return XR_ERROR_VALIDATION_FAILURE;
    result = get_action(session, info->action, &action);
    if (result != XR_SUCCESS)
        return result;
    if (action->type != XR_ACTION_TYPE_VIBRATION_OUTPUT)
        return XR_ERROR_ACTION_TYPE_MISMATCH;
    result = sim_subaction(session->instance, action, info->subactionPath, &pulse.top);
    if (result != XR_SUCCESS)
        return result;
    if (session->state != XR_SESSION_STATE_FOCUSED)
        return XR_SESSION_NOT_FOCUSED;
    pulse.frame = session->begun_frame.index;
    sim_pulses_add(&session->pulses, pulse);
    return XR_SUCCESS;
}

XrResult XRAPI_CALL xrApplyHapticFeedback(XrSession handle, const XrHapticActionInfo *info,
                                          const XrHapticBaseHeader *feedback) {
    SIM_LOCKED;
    if (!sim_is(feedback, XR_TYPE_HAPTIC_VIBRATION))
        return XR_ERROR_VALIDATION_FAILURE;
    const XrHapticVibration *v = (const XrHapticVibration *)feedback;
    return feel(handle, info,
                (struct sim_pulse){.duration_ns = v->duration,
                                   .frequency_hz = v->frequency,
                                   .amplitude = v->amplitude});
}

XrResult XRAPI_CALL xrStopHapticFeedback(XrSession handle, const XrHapticActionInfo *info) {
    SIM_LOCKED;
    return feel(handle, info, (struct sim_pulse){.stop = true});
}
