#include "xr/internal.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

// Which input drives which action, after "/user/hand/left" or "…/right". NULL: this controller has
// none. Where the two hands differ, right_* stands for the right one's.
struct profile_bindings {
    const char *profile;
    const char *input[AP_XR_ACTION_COUNT];
    const char *right_primary, *right_secondary;
    bool menu_left_only;
};

#define COMMON                                                                                     \
    [AP_XR_GRIP] = "input/grip/pose", [AP_XR_AIM] = "input/aim/pose",                              \
    [AP_XR_HAPTIC] = "output/haptic"

static const struct profile_bindings profiles[] = {
    {.profile = "/interaction_profiles/khr/simple_controller",
     .input = {COMMON, [AP_XR_SELECT] = "input/select/click", [AP_XR_MENU] = "input/menu/click"}},
    {.profile = "/interaction_profiles/oculus/touch_controller",
     .input =
         {COMMON, [AP_XR_TRIGGER] = "input/trigger/value", [AP_XR_SQUEEZE] = "input/squeeze/value",
          [AP_XR_SELECT] = "input/trigger/value", [AP_XR_STICK] = "input/thumbstick",
          [AP_XR_PRIMARY] = "input/x/click", [AP_XR_SECONDARY] = "input/y/click",
          [AP_XR_MENU] = "input/menu/click", [AP_XR_STICK_CLICK] = "input/thumbstick/click"},
     .right_primary = "input/a/click",
     .right_secondary = "input/b/click",
     .menu_left_only = true},
    {.profile = "/interaction_profiles/valve/index_controller",
     .input = {COMMON, [AP_XR_TRIGGER] = "input/trigger/value",
               [AP_XR_SQUEEZE] = "input/squeeze/value", [AP_XR_SELECT] = "input/trigger/value",
               [AP_XR_STICK] = "input/thumbstick", [AP_XR_PRIMARY] = "input/a/click",
               [AP_XR_SECONDARY] = "input/b/click", [AP_XR_MENU] = "input/thumbstick/click"}},
    {.profile = "/interaction_profiles/htc/vive_controller",
     .input =
         {COMMON, [AP_XR_TRIGGER] = "input/trigger/value", [AP_XR_SQUEEZE] = "input/squeeze/click",
          [AP_XR_SELECT] = "input/trigger/click", [AP_XR_STICK] = "input/trackpad",
          [AP_XR_PRIMARY] = "input/trackpad/click", [AP_XR_MENU] = "input/menu/click"}},
    {.profile = "/interaction_profiles/microsoft/motion_controller",
     .input = {COMMON, [AP_XR_TRIGGER] = "input/trigger/value",
               [AP_XR_SQUEEZE] = "input/squeeze/click", [AP_XR_SELECT] = "input/trigger/value",
               [AP_XR_STICK] = "input/thumbstick", [AP_XR_PRIMARY] = "input/trackpad/click",
               [AP_XR_SECONDARY] = "input/thumbstick/click", [AP_XR_MENU] = "input/menu/click"}},
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
    static const struct {
        const char *name, *title;
        XrActionType type;
    } list[AP_XR_ACTION_COUNT] = {
        [AP_XR_GRIP] = {"grip", "Where the hand is", XR_ACTION_TYPE_POSE_INPUT},
        [AP_XR_AIM] = {"aim", "Where the hand points", XR_ACTION_TYPE_POSE_INPUT},
        [AP_XR_TRIGGER] = {"trigger", "Trigger", XR_ACTION_TYPE_FLOAT_INPUT},
        [AP_XR_SQUEEZE] = {"squeeze", "Squeeze", XR_ACTION_TYPE_FLOAT_INPUT},
        [AP_XR_STICK] = {"stick", "Move and turn", XR_ACTION_TYPE_VECTOR2F_INPUT},
        [AP_XR_SELECT] = {"select", "Select", XR_ACTION_TYPE_BOOLEAN_INPUT},
        [AP_XR_PRIMARY] = {"primary", "First button", XR_ACTION_TYPE_BOOLEAN_INPUT},
        [AP_XR_SECONDARY] = {"secondary", "Second button", XR_ACTION_TYPE_BOOLEAN_INPUT},
        [AP_XR_MENU] = {"menu", "Menu", XR_ACTION_TYPE_BOOLEAN_INPUT},
        [AP_XR_STICK_CLICK] = {"stick_click", "Picture", XR_ACTION_TYPE_BOOLEAN_INPUT},
        [AP_XR_HAPTIC] = {"haptic", "Touch", XR_ACTION_TYPE_VIBRATION_OUTPUT},
    };
    for (int i = 0; i < AP_XR_ACTION_COUNT; i++) {
        enum ap_status st = create_action(err, xr, list[i].name, list[i].title, list[i].type,
                                          &xr->actions.action[i]);
        if (st)
            return st;
    }
    return AP_OK;
}

static const char *input_of(const struct profile_bindings *profile, int hand, int action) {
    if (hand == 1 && action == AP_XR_PRIMARY && profile->right_primary)
        return profile->right_primary;
    if (hand == 1 && action == AP_XR_SECONDARY && profile->right_secondary)
        return profile->right_secondary;
    if (hand == 1 && action == AP_XR_MENU && profile->menu_left_only)
        return NULL;
    return profile->input[action];
}

static enum ap_status suggest(struct ap_error *err, struct ap_xr *xr,
                              const struct profile_bindings *profile) {
    static const char *const hands[2] = {"/user/hand/left", "/user/hand/right"};
    XrActionSuggestedBinding bindings[2 * AP_XR_ACTION_COUNT];
    uint32_t count = 0;
    for (int i = 0; i < 2 * AP_XR_ACTION_COUNT; i++) {
        const char *input = input_of(profile, i % 2, i / 2);
        if (!input)
            continue;
        char text[XR_MAX_PATH_LENGTH];
        snprintf(text, sizeof text, "%s/%s", hands[i % 2], input);
        bindings[count].action = xr->actions.action[i / 2];
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
                                        .action = a->action[i % 2 ? AP_XR_AIM : AP_XR_GRIP],
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

// The first failure stays; what follows it reads as rest.
struct reading {
    struct ap_error *err;
    enum ap_status st;
    struct ap_xr *xr;
    XrActionStateGetInfo get;
};

static XrActionStateGetInfo *about(struct reading *r, enum ap_xr_action action) {
    r->get.action = r->xr->actions.action[action];
    return &r->get;
}

static float read_float(struct reading *r, enum ap_xr_action action) {
    XrActionStateFloat state = {.type = XR_TYPE_ACTION_STATE_FLOAT};
    if (!r->st)
        r->st = ap_xr_check(r->err, r->xr,
                            ap_xrl.GetActionStateFloat(r->xr->session, about(r, action), &state),
                            "xrGetActionStateFloat");
    return !r->st && state.isActive ? fminf(fmaxf(state.currentState, 0), 1) : 0;
}

static bool read_bool(struct reading *r, enum ap_xr_action action) {
    XrActionStateBoolean state = {.type = XR_TYPE_ACTION_STATE_BOOLEAN};
    if (!r->st)
        r->st = ap_xr_check(r->err, r->xr,
                            ap_xrl.GetActionStateBoolean(r->xr->session, about(r, action), &state),
                            "xrGetActionStateBoolean");
    return !r->st && state.isActive && state.currentState;
}

static XrVector2f read_vector(struct reading *r, enum ap_xr_action action) {
    XrActionStateVector2f state = {.type = XR_TYPE_ACTION_STATE_VECTOR2F};
    if (!r->st)
        r->st = ap_xr_check(r->err, r->xr,
                            ap_xrl.GetActionStateVector2f(r->xr->session, about(r, action), &state),
                            "xrGetActionStateVector2f");
    return !r->st && state.isActive ? state.currentState : (XrVector2f){0, 0};
}

static enum ap_status read_hand(struct ap_error *err, struct ap_xr *xr, XrTime time, int hand,
                                struct ap_xr_hand *out) {
    struct ap_xr_actions *a = &xr->actions;
    struct reading r = {
        .err = err,
        .xr = xr,
        .get = {.type = XR_TYPE_ACTION_STATE_GET_INFO, .subactionPath = a->hand[hand]}};
    r.st = ap_xr_locate(err, xr, a->grip_space[hand], time, &out->grip);
    if (!r.st)
        r.st = ap_xr_locate(err, xr, a->aim_space[hand], time, &out->aim);
    out->trigger = read_float(&r, AP_XR_TRIGGER);
    out->squeeze = read_float(&r, AP_XR_SQUEEZE);
    XrVector2f stick = read_vector(&r, AP_XR_STICK);
    out->stick_x = fminf(fmaxf(stick.x, -1), 1);
    out->stick_y = fminf(fmaxf(stick.y, -1), 1);
    out->select = read_bool(&r, AP_XR_SELECT);
    out->primary = read_bool(&r, AP_XR_PRIMARY);
    out->secondary = read_bool(&r, AP_XR_SECONDARY);
    out->menu = read_bool(&r, AP_XR_MENU);
    out->stick_click = read_bool(&r, AP_XR_STICK_CLICK);
    return r.st;
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
                               .action = xr->actions.action[AP_XR_HAPTIC],
                               .subactionPath = xr->actions.hand[hand]};
    return ap_xr_check(
        err, xr, ap_xrl.ApplyHapticFeedback(xr->session, &info, (const XrHapticBaseHeader *)&pulse),
        "xrApplyHapticFeedback");
}
