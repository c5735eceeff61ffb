#include <math.h>
#include <string.h>

#include "sim_hmd/runtime.h"

// Thresholds at which a lever counts as a button (OpenXR 6.3 leaves them to the runtime).
static const float PRESSED = 0.5f;

void sim_actions_choose_profile(struct sim_session *session) {
    const struct sim_instance *instance = session->instance;
    session->profile = -1;
    for (int p = 0; sim_profiles[p].path && session->profile < 0; p++)
        for (uint32_t i = 0; i < instance->suggestion_count; i++)
            // The headset's controllers are a pair for the hands.
            if (instance->suggestions[i].profile == p &&
                instance->suggestions[i].top <= SIM_TOP_RIGHT) {
                session->profile = p;
                break;
            }
    sim_source_warn_unheard(instance->source, session->profile);
}

const struct sim_component *sim_actions_binding(const struct sim_session *session, uint64_t action,
                                                int top, int *bound_top) {
    const struct sim_instance *instance = session->instance;
    if (!session->attached || session->profile < 0)
        return NULL;
    for (uint32_t i = 0; i < instance->suggestion_count; i++) {
        const struct sim_suggestion *s = &instance->suggestions[i];
        if (s->profile != session->profile || s->action != action || (top >= 0 && s->top != top))
            continue;
        *bound_top = s->top;
        return s->component;
    }
    return NULL;
}

// A hand's "select" is its trigger pulled, or what the log calls so.
static bool selects(const struct ap_sample *hand) {
    return hand->select || hand->trigger >= PRESSED;
}

static float read_value(const struct sim_component *c, bool as_button,
                        const struct ap_sample *hand) {
    switch (c->input) {
    case SIM_TRIGGER:
        return as_button ? (float)selects(hand) : hand->trigger;
    case SIM_SQUEEZE:
        return as_button ? (float)(hand->squeeze >= PRESSED) : hand->squeeze;
    case SIM_SELECT:
        return (float)selects(hand);
    default:
        return 0.0f;
    }
}

// One binding into the state so far: the greatest deflection wins (OpenXR 11.5.1). What an input
// log says goes before what the pose log does; NULL: it says nothing.
static void read_binding(const struct sim_component *c, const struct sim_action *action,
                         const struct ap_sample *hand, const float *logged,
                         struct sim_action_state *now) {
    bool as_button = action->type == XR_ACTION_TYPE_BOOLEAN_INPUT || c->kind == SIM_BOOL;
    float x = logged ? logged[0] : read_value(c, as_button, hand), y = logged ? logged[1] : 0;
    if (as_button)
        x = (float)(x >= PRESSED);
    now->active = true;
    if (hypotf(x, y) > hypotf(now->x, now->y)) {
        now->x = x;
        now->y = y;
    }
}

static void settle(struct sim_action_state *state, struct sim_action_state now, XrTime time) {
    bool changed = now.active && state->active && (now.x != state->x || now.y != state->y);
    now.changed = changed;
    now.changed_at = changed || (now.active && !state->active) ? time : state->changed_at;
    if (!now.active)
        now.changed_at = 0;
    *state = now;
}

// A binding of a higher set takes its input away from the lower ones (OpenXR 11.4).
static bool overruled(const struct sim_session *session, const XrActionsSyncInfo *info,
                      const struct sim_suggestion *mine, uint32_t priority) {
    const struct sim_instance *instance = session->instance;
    for (uint32_t i = 0; i < instance->suggestion_count; i++) {
        const struct sim_suggestion *s = &instance->suggestions[i];
        if (s->profile != session->profile || s->component != mine->component ||
            s->top != mine->top)
            continue;
        const struct sim_action *action = sim_object_get(s->action, SIM_ACTION);
        if (!action || action->set->priority <= priority)
            continue;
        for (uint32_t j = 0; j < info->countActiveActionSets; j++)
            if (sim_raw(info->activeActionSets[j].actionSet) == action->set->object.handle)
                return true;
    }
    return false;
}

static bool set_active(const struct sim_session *session, const XrActionsSyncInfo *info,
                       const struct sim_action *action, int top) {
    for (uint32_t i = 0; i < info->countActiveActionSets; i++) {
        const XrActiveActionSet *a = &info->activeActionSets[i];
        if (sim_raw(a->actionSet) != action->set->object.handle)
            continue;
        if (a->subactionPath == XR_NULL_PATH ||
            sim_path_top(&session->instance->paths, a->subactionPath) == top)
            return true;
    }
    return false;
}

static void update_action(struct sim_session *session, const XrActionsSyncInfo *info,
                          struct sim_action *action) {
    const struct sim_instance *instance = session->instance;
    struct sim_action_state now[SIM_TOP_COUNT] = {0}, all = {0};
    bool focused = session->state == XR_SESSION_STATE_FOCUSED;
    for (uint32_t i = 0; focused && i < instance->suggestion_count; i++) {
        const struct sim_suggestion *s = &instance->suggestions[i];
        struct ap_sample hand = {0};
        if (s->profile != session->profile || s->action != action->object.handle ||
            s->top > SIM_TOP_RIGHT || !set_active(session, info, action, s->top) ||
            overruled(session, info, s, action->set->priority))
            continue;
        enum sim_device device = s->top == SIM_TOP_LEFT ? SIM_LEFT : SIM_RIGHT;
        float value[2], *logged = NULL;
        if (sim_source_component(instance->source, s->component, s->top, session->input_ns, value))
            logged = value;
        if (sim_source_at(instance->source, device, session->input_ns, &hand) == AP_POSE_NONE &&
            !logged)
            continue;
        read_binding(s->component, action, &hand, logged, &now[s->top]);
        read_binding(s->component, action, &hand, logged, &all);
    }
    for (int top = 0; top < SIM_TOP_COUNT; top++)
        settle(&action->state[top], now[top], session->input_ns);
    settle(&action->combined, all, session->input_ns);
}

void sim_actions_update(struct sim_session *session, const XrActionsSyncInfo *info) {
    for (struct sim_object *set = session->instance->object.first_child; set; set = set->next) {
        if (set->type != SIM_ACTION_SET ||
            ((struct sim_action_set *)set)->session != session->object.handle)
            continue;
        for (struct sim_object *action = set->first_child; action; action = action->next)
            update_action(session, info, (struct sim_action *)action);
    }
}
