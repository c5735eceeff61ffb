#ifndef ANTIPODE_SIM_HMD_INPUT_ACTIONS_H
#define ANTIPODE_SIM_HMD_INPUT_ACTIONS_H

#include "sim_hmd/core/session.h"
#include "sim_hmd/input/profiles.h"

struct sim_suggestion {
    int profile; // of sim_profiles
    uint64_t action;
    const struct sim_component *component;
    int top; // enum sim_top
};

struct sim_action_set {
    struct sim_object object;
    char name[XR_MAX_ACTION_SET_NAME_SIZE];
    char localized[XR_MAX_LOCALIZED_ACTION_SET_NAME_SIZE];
    uint32_t priority;
    bool top[SIM_TOP_COUNT]; // subaction paths that actions were made with, though they be gone
    bool attached;           // once, to a session that may be gone
    uint64_t session;        // its handle
};

struct sim_action_state {
    bool active, changed;
    float x, y; // bool: 0 or 1 in x
    XrTime changed_at;
};

struct sim_action {
    struct sim_object object;
    struct sim_action_set *set;
    char name[XR_MAX_ACTION_NAME_SIZE];
    char localized[XR_MAX_LOCALIZED_ACTION_NAME_SIZE];
    XrActionType type;
    bool top[SIM_TOP_COUNT]; // subaction paths it was made with
    bool has_tops;
    struct sim_action_state state[SIM_TOP_COUNT];
    struct sim_action_state combined;
};

struct sim_action_set *sim_action_set_get(XrActionSet handle); // NULL: none
struct sim_action *sim_action_get(XrAction handle);            // NULL: none

// XR_NULL_PATH gives −1; XR_ERROR_PATH_UNSUPPORTED where the action was not made with
// the path.
XrResult sim_subaction(const struct sim_instance *instance, const struct sim_action *action,
                       XrPath path, int *top);

// False without memory.
bool sim_actions_attach(struct sim_session *session);
// The profile that the next xrSyncActions makes current; −1: none.
int sim_actions_choose_profile(const struct sim_session *session, int top);
// True where a current profile changed.
bool sim_actions_update(struct sim_session *session, const XrActionsSyncInfo *info);
enum sim_kind sim_actions_kind(XrActionType type);
// The place in the world of a pose action's binding; NULL where it has none.
const struct sim_component *sim_actions_binding(const struct sim_session *session, uint64_t action,
                                                int top);

#endif
