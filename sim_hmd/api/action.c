#include <stdlib.h>
#include <string.h>

#include "sim_hmd/input/actions.h"

// Action sets, actions, suggested bindings and their attachment to a session.

// Names are "well-formed single-level path names" (OpenXR 6.2).
static XrResult check_name(const char *name, size_t size) {
    size_t len = strnlen(name, size);
    if (len == size)
        return XR_ERROR_VALIDATION_FAILURE;
    if (len == 0)
        return XR_ERROR_NAME_INVALID;
    for (size_t i = 0; i < len; i++) {
        char c = name[i];
        if (!((c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-' || c == '_' || c == '.'))
            return XR_ERROR_PATH_FORMAT_INVALID;
    }
    return XR_SUCCESS;
}

static bool utf8(const unsigned char *s) {
    while (*s) {
        int more = *s < 0x80             ? 0
                   : (*s & 0xe0) == 0xc0 ? 1
                   : (*s & 0xf0) == 0xe0 ? 2
                   : (*s & 0xf8) == 0xf0 ? 3
                                         : -1;
        if (more < 0)
            return false;
        for (s++; more > 0; more--, s++)
            if ((*s & 0xc0) != 0x80)
                return false;
    }
    return true;
}

static XrResult check_localized(const char *name, size_t size) {
    if (strnlen(name, size) == size)
        return XR_ERROR_VALIDATION_FAILURE;
    return name[0] && utf8((const unsigned char *)name) ? XR_SUCCESS
                                                        : XR_ERROR_LOCALIZED_NAME_INVALID;
}

static void free_plain(struct sim_object *object) {
    free(object);
}

XrResult XRAPI_CALL xrCreateActionSet(XrInstance handle, const XrActionSetCreateInfo *info,
                                      XrActionSet *out) {
    SIM_LOCKED;
    struct sim_instance *instance = sim_instance_get(handle);
    if (!instance)
        return XR_ERROR_HANDLE_INVALID;
    if (!sim_is(info, XR_TYPE_ACTION_SET_CREATE_INFO) || !out)
        return XR_ERROR_VALIDATION_FAILURE;
    XrResult result = check_name(info->actionSetName, sizeof info->actionSetName);
    if (result == XR_SUCCESS)
        result = check_localized(info->localizedActionSetName, sizeof info->localizedActionSetName);
    if (result != XR_SUCCESS)
        return result;
    for (struct sim_object *o = instance->object.first_child; o; o = o->next) {
        const struct sim_action_set *other = (const struct sim_action_set *)o;
        if (o->type != SIM_ACTION_SET)
            continue;
        if (strcmp(other->name, info->actionSetName) == 0)
            return XR_ERROR_NAME_DUPLICATED;
        if (strcmp(other->localized, info->localizedActionSetName) == 0)
            return XR_ERROR_LOCALIZED_NAME_DUPLICATED;
    }
    struct sim_action_set *set = calloc(1, sizeof *set);
    if (!set)
        return XR_ERROR_OUT_OF_MEMORY;
    memcpy(set->name, info->actionSetName, sizeof set->name);
    memcpy(set->localized, info->localizedActionSetName, sizeof set->localized);
    set->priority = info->priority;
    if (!sim_object_add(&set->object, SIM_ACTION_SET, &instance->object, free_plain)) {
        free(set);
        return XR_ERROR_LIMIT_REACHED;
    }
    *out = SIM_HANDLE(XrActionSet, set);
    return XR_SUCCESS;
}

XrResult XRAPI_CALL xrDestroyActionSet(XrActionSet handle) {
    SIM_LOCKED;
    struct sim_action_set *set = sim_action_set_get(handle);
    if (!set)
        return XR_ERROR_HANDLE_INVALID;
    sim_object_destroy(&set->object);
    return XR_SUCCESS;
}

static XrResult check_action(const struct sim_action_set *set, const XrActionCreateInfo *info) {
    if (!sim_is(info, XR_TYPE_ACTION_CREATE_INFO))
        return XR_ERROR_VALIDATION_FAILURE;
    if (set->attached)
        return XR_ERROR_ACTIONSETS_ALREADY_ATTACHED;
    XrResult result = check_name(info->actionName, sizeof info->actionName);
    if (result == XR_SUCCESS)
        result = check_localized(info->localizedActionName, sizeof info->localizedActionName);
    if (result != XR_SUCCESS)
        return result;
    switch (info->actionType) {
    case XR_ACTION_TYPE_BOOLEAN_INPUT:
    case XR_ACTION_TYPE_FLOAT_INPUT:
    case XR_ACTION_TYPE_VECTOR2F_INPUT:
    case XR_ACTION_TYPE_POSE_INPUT:
    case XR_ACTION_TYPE_VIBRATION_OUTPUT:
        break;
    default:
        return XR_ERROR_VALIDATION_FAILURE;
    }
    if (info->countSubactionPaths && !info->subactionPaths)
        return XR_ERROR_VALIDATION_FAILURE;
    for (struct sim_object *o = set->object.first_child; o; o = o->next) {
        const struct sim_action *other = (const struct sim_action *)o;
        if (strcmp(other->name, info->actionName) == 0)
            return XR_ERROR_NAME_DUPLICATED;
        if (strcmp(other->localized, info->localizedActionName) == 0)
            return XR_ERROR_LOCALIZED_NAME_DUPLICATED;
    }
    return XR_SUCCESS;
}

static XrResult take_tops(const struct sim_paths *paths, const XrActionCreateInfo *info,
                          struct sim_action *action) {
    for (uint32_t i = 0; i < info->countSubactionPaths; i++) {
        if (!sim_path_text(paths, info->subactionPaths[i]))
            return XR_ERROR_PATH_INVALID;
        int top = sim_path_top(paths, info->subactionPaths[i]);
        if (top < 0 || action->top[top])
            return XR_ERROR_PATH_UNSUPPORTED;
        action->top[top] = action->has_tops = true;
    }
    return XR_SUCCESS;
}

XrResult XRAPI_CALL xrCreateAction(XrActionSet handle, const XrActionCreateInfo *info,
                                   XrAction *out) {
    SIM_LOCKED;
    struct sim_action_set *set = sim_action_set_get(handle);
    if (!set)
        return XR_ERROR_HANDLE_INVALID;
    XrResult result = check_action(set, info);
    if (result != XR_SUCCESS)
        return result;
    if (!out)
        return XR_ERROR_VALIDATION_FAILURE;
    struct sim_action *action = calloc(1, sizeof *action);
    if (!action)
        return XR_ERROR_OUT_OF_MEMORY;
    const struct sim_instance *instance = (const struct sim_instance *)set->object.parent;
    action->set = set;
    action->type = info->actionType;
    memcpy(action->name, info->actionName, sizeof action->name);
    memcpy(action->localized, info->localizedActionName, sizeof action->localized);
    result = take_tops(&instance->paths, info, action);
    if (result == XR_SUCCESS &&
        !sim_object_add(&action->object, SIM_ACTION, &set->object, free_plain))
        result = XR_ERROR_LIMIT_REACHED;
    if (result != XR_SUCCESS) {
        free(action);
        return result;
    }
    for (int top = 0; top < SIM_TOP_COUNT; top++)
        set->top[top] |= action->top[top];
    *out = SIM_HANDLE(XrAction, action);
    return XR_SUCCESS;
}

XrResult XRAPI_CALL xrDestroyAction(XrAction handle) {
    SIM_LOCKED;
    struct sim_action *action = sim_action_get(handle);
    if (!action)
        return XR_ERROR_HANDLE_INVALID;
    sim_object_destroy(&action->object);
    return XR_SUCCESS;
}

// One suggestion; *out is written only where it is good.
static XrResult read_suggestion(const struct sim_instance *instance, int profile,
                                const XrActionSuggestedBinding *in, struct sim_suggestion *out) {
    const struct sim_action *action = sim_action_get(in->action);
    if (!action || action->set->object.parent != &instance->object)
        return XR_ERROR_HANDLE_INVALID;
    if (action->set->attached)
        return XR_ERROR_ACTIONSETS_ALREADY_ATTACHED;
    const char *text = sim_path_text(&instance->paths, in->binding);
    if (!text)
        return XR_ERROR_PATH_INVALID;
    int top;
    const struct sim_component *c =
        sim_profile_component(profile, text, sim_actions_kind(action->type), &top);
    if (!c || !sim_instance_has(instance, c->needs))
        return XR_ERROR_PATH_UNSUPPORTED;
    *out = (struct sim_suggestion){profile, action->object.handle, c, top};
    return XR_SUCCESS;
}

// The profile's earlier suggestions go, as the specification says.
static XrResult store(struct sim_instance *instance, int profile,
                      const struct sim_suggestion *fresh, uint32_t count) {
    uint32_t kept = 0;
    for (uint32_t i = 0; i < instance->suggestion_count; i++)
        if (instance->suggestions[i].profile != profile)
            kept++;
    struct sim_suggestion *all = calloc(kept + count, sizeof *all);
    if (!all)
        return XR_ERROR_OUT_OF_MEMORY;
    kept = 0;
    for (uint32_t i = 0; i < instance->suggestion_count; i++)
        if (instance->suggestions[i].profile != profile)
            all[kept++] = instance->suggestions[i];
    memcpy(all + kept, fresh, count * sizeof *all);
    free(instance->suggestions);
    instance->suggestions = all;
    instance->suggestion_count = kept + count;
    return XR_SUCCESS;
}

XrResult XRAPI_CALL xrSuggestInteractionProfileBindings(
    XrInstance handle, const XrInteractionProfileSuggestedBinding *info) {
    SIM_LOCKED;
    struct sim_instance *instance = sim_instance_get(handle);
    if (!instance)
        return XR_ERROR_HANDLE_INVALID;
    if (!sim_is(info, XR_TYPE_INTERACTION_PROFILE_SUGGESTED_BINDING) ||
        !info->countSuggestedBindings || !info->suggestedBindings)
        return XR_ERROR_VALIDATION_FAILURE;
    const char *text = sim_path_text(&instance->paths, info->interactionProfile);
    if (!text)
        return XR_ERROR_PATH_INVALID;
    int profile = sim_profile_find(text);
    if (profile < 0 || !sim_instance_has(instance, sim_profiles[profile].needs))
        return XR_ERROR_PATH_UNSUPPORTED;
    struct sim_suggestion *fresh = calloc(info->countSuggestedBindings, sizeof *fresh);
    if (!fresh)
        return XR_ERROR_OUT_OF_MEMORY;
    XrResult result = XR_SUCCESS;
    for (uint32_t i = 0; i < info->countSuggestedBindings && result == XR_SUCCESS; i++)
        result = read_suggestion(instance, profile, &info->suggestedBindings[i], &fresh[i]);
    if (result == XR_SUCCESS)
        result = store(instance, profile, fresh, info->countSuggestedBindings);
    free(fresh);
    return result;
}

static void reset_states(struct sim_action_set *set) {
    for (struct sim_object *o = set->object.first_child; o; o = o->next) {
        struct sim_action *action = (struct sim_action *)o;
        memset(action->state, 0, sizeof action->state);
        memset(&action->combined, 0, sizeof action->combined);
    }
}

XrResult XRAPI_CALL xrAttachSessionActionSets(XrSession handle,
                                              const XrSessionActionSetsAttachInfo *info) {
    SIM_LOCKED;
    struct sim_session *session;
    XrResult result = sim_session_get(handle, &session);
    if (result != XR_SUCCESS)
        return result;
    if (!sim_is(info, XR_TYPE_SESSION_ACTION_SETS_ATTACH_INFO) || !info->countActionSets ||
        !info->actionSets)
        return XR_ERROR_VALIDATION_FAILURE;
    for (uint32_t i = 0; i < info->countActionSets; i++)
        if (!sim_action_set_get(info->actionSets[i]))
            return XR_ERROR_HANDLE_INVALID;
    if (session->attached)
        return XR_ERROR_ACTIONSETS_ALREADY_ATTACHED;
    if (!sim_actions_attach(session))
        return XR_ERROR_OUT_OF_MEMORY;
    for (uint32_t i = 0; i < info->countActionSets; i++) {
        struct sim_action_set *set = sim_action_set_get(info->actionSets[i]);
        set->attached = true;
        set->session = session->object.handle;
        reset_states(set);
    }
    return XR_SUCCESS;
}
