#include "xr/internal.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum action_id { GRIP, AIM, TRIGGER, SQUEEZE, SELECT, HAPTIC, ACTION_COUNT };

// Which input drives which action, for both hands, after "/user/hand/left" or "…/right".
struct profile_bindings {
    const char *profile;
    const char *input[ACTION_COUNT]; // NULL: this controller has none
};

static const struct profile_bindings profiles[] = {
    {"/interaction_profiles/khr/simple_controller",
     {"input/grip/pose", "input/aim/pose", NULL, NULL, "input/select/click", "output/haptic"}},
    {"/interaction_profiles/oculus/touch_controller",
     {"input/grip/pose", "input/aim/pose", "input/trigger/value", "input/squeeze/value",
      "input/trigger/value", "output/haptic"}},
    {"/interaction_profiles/valve/index_controller",
     {"input/grip/pose", "input/aim/pose", "input/trigger/value", "input/squeeze/value",
      "input/trigger/value", "output/haptic"}},
    {"/interaction_profiles/htc/vive_controller",
     {"input/grip/pose", "input/aim/pose", "input/trigger/value", "input/squeeze/click",
      "input/trigger/click", "output/haptic"}},
    {"/interaction_profiles/microsoft/motion_controller",
     {"input/grip/pose", "input/aim/pose", "input/trigger/value", "input/squeeze/click",
      "input/trigger/value", "output/haptic"}},
};

enum { PROFILE_COUNT = sizeof profiles / sizeof profiles[0] };

static enum ap_status to_path(struct ap_error *err, struct ap_xr *xr, const char *text,
                              XrPath *path) {
    return ap_xr_check(err, xr, ap_xrl.StringToPath(xr->instance, text, path), "xrStringToPath");
}

static enum ap_status create_action(struct ap_error *err, struct ap_xr *xr, const char *name,
                                    const char *title, XrActionType type, XrAction *action) {
    XrActionCreateInfo info = {.type = XR_TYPE_ACTION_CREATE_INFO,
                               .actionType = type,
                               .countSubactionPaths = 2,
                               .subactionPaths = xr->actions.hand};
    snprintf(info.actionName, sizeof info.actionName, "%s", name);
    snprintf(info.localizedActionName, sizeof info.localizedActionName, "%s", title);
    return ap_xr_check(err, xr, ap_xrl.CreateAction(xr->actions.set, &info, action),
                       "xrCreateAction");
}

static enum ap_status create_actions(struct ap_error *err, struct ap_xr *xr) {
    struct ap_xr_actions *a = &xr->actions;
    const struct {
        const char *name, *title;
        XrActionType type;
        XrAction *action;
    } list[] = {
        {"grip", "Where the hand is", XR_ACTION_TYPE_POSE_INPUT, &a->grip},
        {"aim", "Where the hand points", XR_ACTION_TYPE_POSE_INPUT, &a->aim},
        {"trigger", "Trigger", XR_ACTION_TYPE_FLOAT_INPUT, &a->trigger},
        {"squeeze", "Squeeze", XR_ACTION_TYPE_FLOAT_INPUT, &a->squeeze},
        {"select", "Select", XR_ACTION_TYPE_BOOLEAN_INPUT, &a->select},
        {"haptic", "Touch", XR_ACTION_TYPE_VIBRATION_OUTPUT, &a->haptic},
    };
    for (int i = 0; i < ACTION_COUNT; i++) {
        enum ap_status st =
            create_action(err, xr, list[i].name, list[i].title, list[i].type, list[i].action);
        if (st)
            return st;
    }
    return AP_OK;
}

static enum ap_status suggest(struct ap_error *err, struct ap_xr *xr,
                              const struct profile_bindings *profile) {
    const XrAction actions[ACTION_COUNT] = {xr->actions.grip,    xr->actions.aim,
                                            xr->actions.trigger, xr->actions.squeeze,
                                            xr->actions.select,  xr->actions.haptic};
    static const char *const hands[2] = {"/user/hand/left", "/user/hand/right"};
    XrActionSuggestedBinding bindings[2 * ACTION_COUNT];
    uint32_t count = 0;
    for (int i = 0; i < 2 * ACTION_COUNT; i++) {
        const char *input = profile->input[i / 2];
        if (!input)
            continue;
        char text[XR_MAX_PATH_LENGTH];
        snprintf(text, sizeof text, "%s/%s", hands[i % 2], input);
        bindings[count].action = actions[i / 2];
        enum ap_status st = to_path(err, xr, text, &bindings[count].binding);
        if (st)
            return st;
        count++;
    }
    XrInteractionProfileSuggestedBinding info = {.type =
                                                     XR_TYPE_INTERACTION_PROFILE_SUGGESTED_BINDING,
                                                 .countSuggestedBindings = count,
                                                 .suggestedBindings = bindings};
    enum ap_status st = to_path(err, xr, profile->profile, &info.interactionProfile);
    if (st)
        return st;
    XrResult r = ap_xrl.SuggestInteractionProfileBindings(xr->instance, &info);
    // A runtime need not know every controller; it must know one of these.
    return r == XR_ERROR_PATH_UNSUPPORTED
               ? AP_OK
               : ap_xr_check(err, xr, r, "xrSuggestInteractionProfileBindings");
}

static enum ap_status create_spaces(struct ap_error *err, struct ap_xr *xr) {
    struct ap_xr_actions *a = &xr->actions;
    for (int i = 0; i < 4; i++) {
        int hand = i / 2;
        XrActionSpaceCreateInfo info = {.type = XR_TYPE_ACTION_SPACE_CREATE_INFO,
                                        .action = i % 2 ? a->aim : a->grip,
                                        .subactionPath = a->hand[hand],
                                        .poseInActionSpace = {.orientation = {0, 0, 0, 1}}};
        XrSpace *space = i % 2 ? &a->aim_space[hand] : &a->grip_space[hand];
        enum ap_status st = ap_xr_check(
            err, xr, ap_xrl.CreateActionSpace(xr->session, &info, space), "xrCreateActionSpace");
        if (st)
            return st;
    }
    return AP_OK;
}

enum ap_status ap_xr_actions_create(struct ap_error *err, struct ap_xr *xr) {
    struct ap_xr_actions *a = &xr->actions;
    enum ap_status st = to_path(err, xr, "/user/hand/left", &a->hand[0]);
    if (!st)
        st = to_path(err, xr, "/user/hand/right", &a->hand[1]);
    XrActionSetCreateInfo info = {.type = XR_TYPE_ACTION_SET_CREATE_INFO,
                                  .actionSetName = "hands",
                                  .localizedActionSetName = "Hands"};
    if (!st)
        st = ap_xr_check(err, xr, ap_xrl.CreateActionSet(xr->instance, &info, &a->set),
                         "xrCreateActionSet");
    if (!st)
        st = create_actions(err, xr);
    for (int i = 0; !st && i < PROFILE_COUNT; i++)
        st = suggest(err, xr, &profiles[i]);
    if (!st)
        st = create_spaces(err, xr);
    XrSessionActionSetsAttachInfo attach = {.type = XR_TYPE_SESSION_ACTION_SETS_ATTACH_INFO,
                                            .countActionSets = 1,
                                            .actionSets = &a->set};
    return st ? st
              : ap_xr_check(err, xr, ap_xrl.AttachSessionActionSets(xr->session, &attach),
                            "xrAttachSessionActionSets");
}

static enum ap_status read_float(struct ap_error *err, struct ap_xr *xr, XrAction action, int hand,
                                 float *value) {
    XrActionStateGetInfo get = {.type = XR_TYPE_ACTION_STATE_GET_INFO,
                                .action = action,
                                .subactionPath = xr->actions.hand[hand]};
    XrActionStateFloat state = {.type = XR_TYPE_ACTION_STATE_FLOAT};
    enum ap_status st = ap_xr_check(err, xr, ap_xrl.GetActionStateFloat(xr->session, &get, &state),
                                    "xrGetActionStateFloat");
    if (!st)
        *value = state.isActive ? fminf(fmaxf(state.currentState, 0), 1) : 0;
    return st;
}

static enum ap_status read_hand(struct ap_error *err, struct ap_xr *xr, XrTime time, int hand,
                                struct ap_xr_hand *out) {
    struct ap_xr_actions *a = &xr->actions;
    enum ap_status st = ap_xr_locate(err, xr, a->grip_space[hand], time, &out->grip);
    if (!st)
        st = ap_xr_locate(err, xr, a->aim_space[hand], time, &out->aim);
    if (!st)
        st = read_float(err, xr, a->trigger, hand, &out->trigger);
    if (!st)
        st = read_float(err, xr, a->squeeze, hand, &out->squeeze);
    XrActionStateGetInfo get = {
        .type = XR_TYPE_ACTION_STATE_GET_INFO, .action = a->select, .subactionPath = a->hand[hand]};
    XrActionStateBoolean select = {.type = XR_TYPE_ACTION_STATE_BOOLEAN};
    if (!st)
        st = ap_xr_check(err, xr, ap_xrl.GetActionStateBoolean(xr->session, &get, &select),
                         "xrGetActionStateBoolean");
    out->select = !st && select.isActive && select.currentState;
    return st;
}

enum ap_status ap_xr_actions_read(struct ap_error *err, struct ap_xr *xr, XrTime time,
                                  struct ap_xr_hand hands[2]) {
    memset(hands, 0, 2 * sizeof *hands);
    XrActiveActionSet active = {.actionSet = xr->actions.set};
    XrActionsSyncInfo sync = {
        .type = XR_TYPE_ACTIONS_SYNC_INFO, .countActiveActionSets = 1, .activeActionSets = &active};
    XrResult r = ap_xrl.SyncActions(xr->session, &sync);
    enum ap_status st = ap_xr_check(err, xr, r, "xrSyncActions");
    // Without focus the hands stay away: that is an answer, not an error.
    for (int hand = 0; !st && r != XR_SESSION_NOT_FOCUSED && hand < 2; hand++)
        st = read_hand(err, xr, time, hand, &hands[hand]);
    return st;
}

enum ap_status ap_xr_haptic(struct ap_error *err, struct ap_xr *xr, int hand, double seconds,
                            double amplitude) {
    XrHapticVibration pulse = {.type = XR_TYPE_HAPTIC_VIBRATION,
                               .duration = seconds > 0 ? (XrDuration)(seconds * 1e9)
                                                       : XR_MIN_HAPTIC_DURATION,
                               .frequency = XR_FREQUENCY_UNSPECIFIED,
                               .amplitude = (float)fmin(fmax(amplitude, 0), 1)};
    XrHapticActionInfo info = {.type = XR_TYPE_HAPTIC_ACTION_INFO,
                               .action = xr->actions.haptic,
                               .subactionPath = xr->actions.hand[hand]};
    return ap_xr_check(
        err, xr, ap_xrl.ApplyHapticFeedback(xr->session, &info, (const XrHapticBaseHeader *)&pulse),
        "xrApplyHapticFeedback");
}
