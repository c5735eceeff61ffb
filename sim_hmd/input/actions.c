#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "sim_hmd/core/spaces.h"
#include "sim_hmd/input/actions.h"
#include "sim_hmd/input/source.h"

// Thresholds at which a lever counts as a button (OpenXR 6.3 leaves them to the runtime).
static const float PRESSED = 0.5f;

bool sim_actions_attach(struct sim_session *session) {
    const struct sim_instance *instance = session->instance;
    size_t n = instance->suggestion_count;
    struct sim_suggestion *copy = calloc(n ? n : 1, sizeof *copy);
    if (!copy)
        return false;
    if (n)
        memcpy(copy, instance->suggestions, n * sizeof *copy);
    session->bindings = copy;
    session->binding_count = (uint32_t)n;
    session->attached = true;
    return true;
}

enum sim_kind sim_actions_kind(XrActionType type) {
    switch (type) {
    case XR_ACTION_TYPE_FLOAT_INPUT:
        return SIM_FLOAT;
    case XR_ACTION_TYPE_VECTOR2F_INPUT:
        return SIM_VEC2;
    case XR_ACTION_TYPE_POSE_INPUT:
        return SIM_POSE;
    case XR_ACTION_TYPE_VIBRATION_OUTPUT:
        return SIM_HAPTIC;
    default:
        return SIM_BOOL;
    }
}

// The hands hold a pair: a profile that is suggested for one is there for both.
static bool suggested(const struct sim_session *session, int profile, int top) {
    for (uint32_t i = 0; i < session->binding_count; i++) {
        const struct sim_suggestion *s = &session->bindings[i];
        if (s->profile == profile &&
            (s->top == top || (s->top <= SIM_TOP_RIGHT && top <= SIM_TOP_RIGHT)))
            return true;
    }
    return false;
}

int sim_actions_choose_profile(const struct sim_session *session, int top) {
    const struct sim_automation *automation = &session->automation;
    const struct sim_instance *instance = session->instance;
    if (automation->device[top] != SIM_OWN) {
        int driven = automation->profile[top];
        return suggested(session, driven, top) ? driven : -1;
    }
    // The hands are always there; anything else where input logs speak of it.
    if (top > SIM_TOP_RIGHT && !sim_source_logs_device(instance->source, top))
        return -1;
    int preferred = instance->settings.controllers;
    if (suggested(session, preferred, top))
        return preferred;
    for (int p = 0; sim_profiles[p].path; p++)
        if (suggested(session, p, top))
            return p;
    return -1;
}

static bool update_profiles(struct sim_session *session) {
    bool changed = false;
    for (int top = 0; top < SIM_TOP_COUNT; top++) {
        int now = sim_actions_choose_profile(session, top);
        changed |= now != session->profile[top];
        session->profile[top] = now;
    }
    if (changed)
        sim_source_warn_unheard(session->instance->source, session->profile);
    return changed;
}

// What an action may take from a binding that it was suggested with.
static bool live(const struct sim_session *session, const struct sim_suggestion *s,
                 enum sim_kind wanted) {
    return s->profile == session->profile[s->top] && sim_kind_suits(s->component->kind, wanted);
}

const struct sim_component *sim_actions_binding(const struct sim_session *session, uint64_t action,
                                                int top) {
    for (uint32_t i = 0; i < session->binding_count; i++) {
        const struct sim_suggestion *s = &session->bindings[i];
        if (s->action == action && s->top == top && live(session, s, SIM_POSE))
            return s->component;
    }
    return NULL;
}

// A hand's "select" is its trigger pulled, or what the log calls so.
static bool selects(const struct ap_sample *hand) {
    return hand->select || hand->trigger >= PRESSED;
}

static float read_hand(const struct sim_component *c, bool as_button,
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

// What a program drives goes before what an input log says, and that before the pose log's hand.
// False where the device is not there.
static bool read_input(const struct sim_session *session, const struct sim_suggestion *s,
                       bool as_button, float value[2]) {
    struct sim_source *source = session->instance->source;
    enum sim_driven driven = session->automation.device[s->top];
    value[0] = value[1] = 0;
    if (driven == SIM_SWITCHED_OFF)
        return false;
    const struct sim_automated *set =
        sim_automation_find(&session->automation, s->top, s->component->path);
    if (set) {
        memcpy(value, set->value, sizeof set->value);
        return true;
    }
    if (driven == SIM_SWITCHED_ON)
        return true;
    if (sim_source_component(source, s->component, s->top, session->input_ns, value))
        return true;
    if (s->top > SIM_TOP_RIGHT)
        return sim_source_logs_device(source, s->top);
    struct ap_sample hand = {0};
    enum sim_device device = s->top == SIM_TOP_LEFT ? SIM_LEFT : SIM_RIGHT;
    if (sim_source_at(source, device, session->input_ns, &hand) == AP_POSE_NONE)
        return false;
    value[0] = read_hand(s->component, as_button, &hand);
    return true;
}

// One binding into the state so far: the greatest deflection wins (OpenXR 11.5.1).
static void read_binding(const struct sim_session *session, const struct sim_suggestion *s,
                         const struct sim_action *action, struct sim_action_state *now,
                         struct sim_action_state *all) {
    bool as_button = action->type == XR_ACTION_TYPE_BOOLEAN_INPUT || s->component->kind == SIM_BOOL;
    float v[2];
    if (!read_input(session, s, as_button, v))
        return;
    if (as_button)
        v[0] = (float)(v[0] >= PRESSED);
    now->active = all->active = true;
    if (hypotf(v[0], v[1]) > hypotf(now->x, now->y)) {
        now->x = v[0];
        now->y = v[1];
    }
    if (hypotf(v[0], v[1]) > hypotf(all->x, all->y)) {
        all->x = v[0];
        all->y = v[1];
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

// A binding of a higher set takes its input away from the lower ones (OpenXR 11.4).
static bool overruled(const struct sim_session *session, const XrActionsSyncInfo *info,
                      const struct sim_suggestion *mine, uint32_t priority) {
    for (uint32_t i = 0; i < session->binding_count; i++) {
        const struct sim_suggestion *s = &session->bindings[i];
        if (s->component != mine->component || s->top != mine->top)
            continue;
        const struct sim_action *action = sim_object_get(s->action, SIM_ACTION);
        if (action && action->set->priority > priority &&
            live(session, s, sim_actions_kind(action->type)) &&
            set_active(session, info, action, s->top))
            return true;
    }
    return false;
}

static void update_action(struct sim_session *session, const XrActionsSyncInfo *info,
                          struct sim_action *action) {
    struct sim_action_state now[SIM_TOP_COUNT] = {0}, all = {0};
    bool focused = session->state == XR_SESSION_STATE_FOCUSED;
    enum sim_kind wanted = sim_actions_kind(action->type);
    for (uint32_t i = 0; focused && i < session->binding_count; i++) {
        const struct sim_suggestion *s = &session->bindings[i];
        if (s->action != action->object.handle || !live(session, s, wanted) ||
            !set_active(session, info, action, s->top) ||
            overruled(session, info, s, action->set->priority))
            continue;
        read_binding(session, s, action, &now[s->top], &all);
    }
    for (int top = 0; top < SIM_TOP_COUNT; top++)
        settle(&action->state[top], now[top], session->input_ns);
    settle(&action->combined, all, session->input_ns);
}

// A destroyed action's spaces go on as they were.
static void update_space(struct sim_space *space) {
    const struct sim_action *action = sim_object_get(space->action, SIM_ACTION);
    if (!action)
        return;
    for (int top = 0; top < SIM_TOP_COUNT && space->picked_top < 0; top++)
        if (action->state[top].active && (space->top < 0 || space->top == top))
            space->picked_top = top;
    space->active = space->picked_top >= 0 && action->state[space->picked_top].active;
}

bool sim_actions_update(struct sim_session *session, const XrActionsSyncInfo *info) {
    bool changed = update_profiles(session);
    for (struct sim_object *set = session->instance->object.first_child; set; set = set->next) {
        if (set->type != SIM_ACTION_SET ||
            ((struct sim_action_set *)set)->session != session->object.handle)
            continue;
        for (struct sim_object *action = set->first_child; action; action = action->next)
            update_action(session, info, (struct sim_action *)action);
    }
    for (struct sim_object *o = session->object.first_child; o; o = o->next)
        if (o->type == SIM_SPACE && ((struct sim_space *)o)->is_action)
            update_space((struct sim_space *)o);
    return changed;
}
