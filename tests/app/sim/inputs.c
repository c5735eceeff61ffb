#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <openxr/openxr.h>

// A program of somebody else's, for the tests of `antipode sim`: binds each path that it is given
// to an action of its own and prints the actions' states, a line a frame and action.
//   inputs PROFILE b:PATH f:PATH v:PATH…   (button, float, vector)
// It needs no graphics. Exit status 0 when the runtime has asked it to end. With a '!' before
// PROFILE it then ends its session once too often, as programs do.

enum { MAX_ACTIONS = 16 };

struct program {
    XrInstance instance;
    XrSession session;
    XrSessionState state;
    XrActionSet set;
    XrAction action[MAX_ACTIONS];
    char kind[MAX_ACTIONS];
    const char *path[MAX_ACTIONS];
    uint32_t count;
};

static void check(XrResult result, const char *what) {
    if (XR_SUCCEEDED(result))
        return;
    fprintf(stderr, "inputs: %s: %d\n", what, (int)result);
    exit(9);
}
#define CHECK(call) check(call, #call)

static XrPath path_of(const struct program *p, const char *text) {
    XrPath path;
    CHECK(xrStringToPath(p->instance, text, &path));
    return path;
}

static void open_session(struct program *p) {
    const char *extension = XR_MND_HEADLESS_EXTENSION_NAME;
    XrInstanceCreateInfo info = {
        .type = XR_TYPE_INSTANCE_CREATE_INFO,
        .applicationInfo = {.applicationName = "inputs", .apiVersion = XR_MAKE_VERSION(1, 0, 0)},
        .enabledExtensionCount = 1,
        .enabledExtensionNames = &extension};
    CHECK(xrCreateInstance(&info, &p->instance));
    XrSystemGetInfo get = {.type = XR_TYPE_SYSTEM_GET_INFO,
                           .formFactor = XR_FORM_FACTOR_HEAD_MOUNTED_DISPLAY};
    XrSessionCreateInfo session = {.type = XR_TYPE_SESSION_CREATE_INFO};
    CHECK(xrGetSystem(p->instance, &get, &session.systemId));
    CHECK(xrCreateSession(p->instance, &session, &p->session));
}

static void make_action(struct program *p, const char *argument) {
    if (strlen(argument) < 3 || argument[1] != ':' || p->count == MAX_ACTIONS)
        check(XR_ERROR_VALIDATION_FAILURE, argument);
    uint32_t i = p->count++;
    p->kind[i] = argument[0];
    p->path[i] = argument + 2;
    XrActionCreateInfo info = {.type = XR_TYPE_ACTION_CREATE_INFO,
                               .actionType = argument[0] == 'b'   ? XR_ACTION_TYPE_BOOLEAN_INPUT
                                             : argument[0] == 'f' ? XR_ACTION_TYPE_FLOAT_INPUT
                                                                  : XR_ACTION_TYPE_VECTOR2F_INPUT};
    snprintf(info.actionName, sizeof info.actionName, "action%u", i);
    snprintf(info.localizedActionName, sizeof info.localizedActionName, "Action %u", i);
    CHECK(xrCreateAction(p->set, &info, &p->action[i]));
}

static void bind(struct program *p, const char *profile) {
    XrActionSuggestedBinding bindings[MAX_ACTIONS];
    for (uint32_t i = 0; i < p->count; i++)
        bindings[i] = (XrActionSuggestedBinding){p->action[i], path_of(p, p->path[i])};
    XrInteractionProfileSuggestedBinding suggestion = {
        .type = XR_TYPE_INTERACTION_PROFILE_SUGGESTED_BINDING,
        .interactionProfile = path_of(p, profile),
        .countSuggestedBindings = p->count,
        .suggestedBindings = bindings};
    CHECK(xrSuggestInteractionProfileBindings(p->instance, &suggestion));
    XrSessionActionSetsAttachInfo attach = {.type = XR_TYPE_SESSION_ACTION_SETS_ATTACH_INFO,
                                            .countActionSets = 1,
                                            .actionSets = &p->set};
    CHECK(xrAttachSessionActionSets(p->session, &attach));
}

static void make_actions(struct program *p, int argc, char **argv) {
    XrActionSetCreateInfo info = {.type = XR_TYPE_ACTION_SET_CREATE_INFO};
    strcpy(info.actionSetName, "set");
    strcpy(info.localizedActionSetName, "Set");
    CHECK(xrCreateActionSet(p->instance, &info, &p->set));
    for (int i = 2; i < argc; i++)
        make_action(p, argv[i]);
    bind(p, argv[1] + (argv[1][0] == '!'));
}

static void poll_events(struct program *p) {
    for (;;) {
        XrEventDataBuffer event = {.type = XR_TYPE_EVENT_DATA_BUFFER};
        if (xrPollEvent(p->instance, &event) != XR_SUCCESS)
            return;
        if (event.type != XR_TYPE_EVENT_DATA_SESSION_STATE_CHANGED)
            continue;
        XrEventDataSessionStateChanged changed;
        memcpy(&changed, &event, sizeof changed);
        p->state = changed.state;
        XrSessionBeginInfo begin = {.type = XR_TYPE_SESSION_BEGIN_INFO,
                                    .primaryViewConfigurationType =
                                        XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO};
        if (p->state == XR_SESSION_STATE_READY)
            CHECK(xrBeginSession(p->session, &begin));
        if (p->state == XR_SESSION_STATE_STOPPING)
            CHECK(xrEndSession(p->session));
    }
}

static void print_state(const struct program *p, int frame, uint32_t i) {
    XrActionStateGetInfo get = {.type = XR_TYPE_ACTION_STATE_GET_INFO, .action = p->action[i]};
    XrActionStateBoolean b = {.type = XR_TYPE_ACTION_STATE_BOOLEAN};
    XrActionStateFloat f = {.type = XR_TYPE_ACTION_STATE_FLOAT};
    XrActionStateVector2f v = {.type = XR_TYPE_ACTION_STATE_VECTOR2F};
    printf("%d %s", frame, p->path[i]);
    if (p->kind[i] == 'b') {
        CHECK(xrGetActionStateBoolean(p->session, &get, &b));
        printf(" %d %d\n", b.isActive, b.currentState);
    } else if (p->kind[i] == 'f') {
        CHECK(xrGetActionStateFloat(p->session, &get, &f));
        printf(" %d %g\n", f.isActive, (double)f.currentState);
    } else {
        CHECK(xrGetActionStateVector2f(p->session, &get, &v));
        printf(" %d %g %g\n", v.isActive, (double)v.currentState.x, (double)v.currentState.y);
    }
}

static void run_frame(struct program *p, int frame) {
    XrFrameState state = {.type = XR_TYPE_FRAME_STATE};
    CHECK(xrWaitFrame(p->session, NULL, &state));
    CHECK(xrBeginFrame(p->session, NULL));
    XrActiveActionSet active = {.actionSet = p->set};
    XrActionsSyncInfo sync = {
        .type = XR_TYPE_ACTIONS_SYNC_INFO, .countActiveActionSets = 1, .activeActionSets = &active};
    XrResult result = xrSyncActions(p->session, &sync);
    check(result, "xrSyncActions");
    for (uint32_t i = 0; result == XR_SUCCESS && i < p->count; i++)
        print_state(p, frame, i);
    XrFrameEndInfo end = {.type = XR_TYPE_FRAME_END_INFO,
                          .displayTime = state.predictedDisplayTime,
                          .environmentBlendMode = XR_ENVIRONMENT_BLEND_MODE_OPAQUE};
    CHECK(xrEndFrame(p->session, &end));
}

int main(int argc, char **argv) {
    struct program p = {0};
    if (argc < 3)
        return 2;
    open_session(&p);
    make_actions(&p, argc, argv);
    int frame = 0;
    while (p.state != XR_SESSION_STATE_EXITING) {
        poll_events(&p);
        if (p.state == XR_SESSION_STATE_READY || p.state == XR_SESSION_STATE_SYNCHRONIZED ||
            p.state == XR_SESSION_STATE_VISIBLE || p.state == XR_SESSION_STATE_FOCUSED)
            run_frame(&p, frame++);
    }
    if (argv[1][0] == '!')
        xrEndSession(p.session);
    CHECK(xrDestroySession(p.session));
    CHECK(xrDestroyInstance(p.instance));
    return 0;
}
