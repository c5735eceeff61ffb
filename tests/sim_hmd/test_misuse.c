#include "tests/sim_hmd/client.h"

#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

// Programs that are wrong: dead, foreign and random handles, wrong structures, many threads. The
// answer is an error code, never a crash. The functions are the runtime's own, past the loader,
// which would catch some of it.

#define PROC(c, name)                                                                              \
    PFN_##name name##_;                                                                            \
    *(void **)&name##_ = client_proc((c)->instance, #name)

static void dead_and_foreign_handles_are_told(void **state) {
    (void)state;
    client_settings("{\"clock\": \"virtual\"}");
    struct client c = {0};
    client_start(&c);
    PROC(&c, xrDestroySpace);
    PROC(&c, xrLocateSpace);
    PROC(&c, xrDestroySwapchain);
    PROC(&c, xrDestroyAction);
    PROC(&c, xrWaitFrame);
    XrSpaceLocation at = {.type = XR_TYPE_SPACE_LOCATION};
    XrFrameState f = {.type = XR_TYPE_FRAME_STATE};
    XrSpace dead = c.local;
    XR_OK(xrDestroySpace(dead));
    XR_IS(XR_ERROR_HANDLE_INVALID, xrDestroySpace_(dead));
    XR_IS(XR_ERROR_HANDLE_INVALID, xrLocateSpace_(dead, c.stage, 1, &at));
    // Its place in the table is used again; the old handle is still dead.
    XrReferenceSpaceCreateInfo info = {.type = XR_TYPE_REFERENCE_SPACE_CREATE_INFO,
                                       .referenceSpaceType = XR_REFERENCE_SPACE_TYPE_LOCAL,
                                       .poseInReferenceSpace.orientation.w = 1};
    XR_OK(xrCreateReferenceSpace(c.session, &info, &c.local));
    assert_true(c.local != dead);
    XR_IS(XR_ERROR_HANDLE_INVALID, xrLocateSpace_(dead, c.stage, 1, &at));
    // Handles of another type.
    XR_IS(XR_ERROR_HANDLE_INVALID, xrDestroySwapchain_((XrSwapchain)c.stage));
    XR_IS(XR_ERROR_HANDLE_INVALID, xrDestroyAction_((XrAction)c.session));
    XR_IS(XR_ERROR_HANDLE_INVALID, xrWaitFrame_((XrSession)c.instance, NULL, &f));
    // A session takes its spaces along.
    XrSession session = c.session;
    XR_OK(xrDestroySession(session));
    XR_IS(XR_ERROR_HANDLE_INVALID, xrLocateSpace_(c.stage, c.stage, 1, &at));
    XR_IS(XR_ERROR_HANDLE_INVALID, xrWaitFrame_(session, NULL, &f));
    c.session = XR_NULL_HANDLE;
    client_stop(&c);
}

static void random_handles_never_crash(void **state) {
    (void)state;
    client_settings("{\"clock\": \"virtual\"}");
    struct client c = {0};
    client_start(&c);
    PROC(&c, xrLocateSpace);
    PROC(&c, xrAcquireSwapchainImage);
    PROC(&c, xrSyncActions);
    PROC(&c, xrGetActionStateFloat);
    PROC(&c, xrEndFrame);
    XrSpaceLocation at = {.type = XR_TYPE_SPACE_LOCATION};
    XrActionsSyncInfo sync = {.type = XR_TYPE_ACTIONS_SYNC_INFO};
    XrActionStateFloat value = {.type = XR_TYPE_ACTION_STATE_FLOAT};
    XrFrameEndInfo end = {.type = XR_TYPE_FRAME_END_INFO};
    uint64_t seed = 88172645463325252u;
    for (int k = 0; k < 20000; k++) {
        seed ^= seed << 13;
        seed ^= seed >> 7;
        seed ^= seed << 17;
        // Half of them near a live handle.
        uint64_t h = k & 1 ? seed : (uint64_t)(uintptr_t)c.stage ^ (1ull << (seed & 63));
        if (h == (uint64_t)(uintptr_t)c.view || h == (uint64_t)(uintptr_t)c.local)
            continue; // alive
        uint32_t index;
        XrActionStateGetInfo get = {.type = XR_TYPE_ACTION_STATE_GET_INFO,
                                    .action = (XrAction)(uintptr_t)h};
        XR_IS(XR_ERROR_HANDLE_INVALID, xrLocateSpace_((XrSpace)(uintptr_t)h, c.stage, 1, &at));
        XR_IS(XR_ERROR_HANDLE_INVALID,
              xrAcquireSwapchainImage_((XrSwapchain)(uintptr_t)h, NULL, &index));
        XR_IS(XR_ERROR_HANDLE_INVALID, xrSyncActions_((XrSession)(uintptr_t)h, &sync));
        XR_IS(XR_ERROR_HANDLE_INVALID, xrEndFrame_((XrSession)(uintptr_t)h, &end));
        XR_IS(XR_ERROR_HANDLE_INVALID, xrGetActionStateFloat_(c.session, &get, &value));
    }
    client_stop(&c);
}

static void null_and_mistyped_structures_are_refused(void **state) {
    (void)state;
    client_settings("{\"clock\": \"virtual\"}");
    struct client c = {0};
    client_start(&c);
    PROC(&c, xrWaitFrame);
    PROC(&c, xrEndFrame);
    PROC(&c, xrGetSystem);
    PROC(&c, xrLocateViews);
    PROC(&c, xrCreateSwapchain);
    PROC(&c, xrSuggestInteractionProfileBindings);
    PROC(&c, xrCreateActionSet);
    PROC(&c, xrStringToPath);
    XrFrameState wrong = {.type = XR_TYPE_VIEW};
    XrSwapchain swapchain;
    XrSystemId system;
    XR_IS(XR_ERROR_VALIDATION_FAILURE, xrWaitFrame_(c.session, NULL, NULL));
    XR_IS(XR_ERROR_VALIDATION_FAILURE, xrWaitFrame_(c.session, NULL, &wrong));
    XR_IS(XR_ERROR_VALIDATION_FAILURE, xrEndFrame_(c.session, NULL));
    XR_IS(XR_ERROR_VALIDATION_FAILURE, xrGetSystem_(c.instance, NULL, &system));
    XR_IS(XR_ERROR_VALIDATION_FAILURE, xrLocateViews_(c.session, NULL, NULL, 0, NULL, NULL));
    XR_IS(XR_ERROR_VALIDATION_FAILURE, xrCreateSwapchain_(c.session, NULL, &swapchain));
    XR_IS(XR_ERROR_VALIDATION_FAILURE, xrSuggestInteractionProfileBindings_(c.instance, NULL));
    XR_IS(XR_ERROR_VALIDATION_FAILURE, xrCreateActionSet_(c.instance, NULL, NULL));
    XR_IS(XR_ERROR_VALIDATION_FAILURE, xrStringToPath_(c.instance, NULL, NULL));
    client_stop(&c);
}

static void paths_are_checked(void **state) {
    (void)state;
    client_settings(NULL);
    struct client c = {0};
    client_make_instance(&c);
    static const char *const bad[] = {"",      "/",    "user",  "/user/", "//user", "/User",
                                      "/u er", "/u/.", "/u/..", "/u/...", "/u//v",  "/\xc3\xa4"};
    XrPath path;
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        XR_IS(XR_ERROR_PATH_FORMAT_INVALID, xrStringToPath(c.instance, bad[i], &path));
    char text[XR_MAX_PATH_LENGTH + 8];
    memset(text, 'a', sizeof text);
    text[0] = '/';
    text[XR_MAX_PATH_LENGTH - 1] = '\0';
    XR_OK(xrStringToPath(c.instance, text, &path));
    char back[XR_MAX_PATH_LENGTH];
    uint32_t count;
    XR_IS(XR_ERROR_SIZE_INSUFFICIENT, xrPathToString(c.instance, path, 10, &count, back));
    XR_OK(xrPathToString(c.instance, path, XR_MAX_PATH_LENGTH, &count, back));
    assert_int_equal(count, XR_MAX_PATH_LENGTH);
    assert_string_equal(back, text);
    text[XR_MAX_PATH_LENGTH - 1] = 'a';
    text[XR_MAX_PATH_LENGTH] = '\0';
    XR_IS(XR_ERROR_PATH_FORMAT_INVALID, xrStringToPath(c.instance, text, &path));
    XR_IS(XR_ERROR_PATH_INVALID, xrPathToString(c.instance, 4711, 0, &count, NULL));
    char name[XR_MAX_RESULT_STRING_SIZE];
    XR_OK(xrResultToString(c.instance, XR_ERROR_LAYER_INVALID, name));
    assert_string_equal(name, "XR_ERROR_LAYER_INVALID");
    XR_OK(xrResultToString(c.instance, (XrResult)-54321, name));
    assert_string_equal(name, "XR_UNKNOWN_FAILURE_-54321");
    XR_OK(xrResultToString(c.instance, (XrResult)54321, name));
    assert_string_equal(name, "XR_UNKNOWN_SUCCESS_54321");
    client_stop(&c);
}

static XrAction action_in(XrActionSet set, const char *name, XrActionType type, XrResult expected) {
    XrActionCreateInfo info = {.type = XR_TYPE_ACTION_CREATE_INFO, .actionType = type};
    strcpy(info.actionName, name);
    strcpy(info.localizedActionName, name);
    XrAction action = XR_NULL_HANDLE;
    XR_IS(expected, xrCreateAction(set, &info, &action));
    return action;
}

static XrResult suggest(struct client *c, const char *profile, XrAction action, const char *text) {
    XrActionSuggestedBinding b = {.action = action};
    XrInteractionProfileSuggestedBinding info = {.type =
                                                     XR_TYPE_INTERACTION_PROFILE_SUGGESTED_BINDING,
                                                 .countSuggestedBindings = 1,
                                                 .suggestedBindings = &b};
    XR_OK(xrStringToPath(c->instance, profile, &info.interactionProfile));
    XR_OK(xrStringToPath(c->instance, text, &b.binding));
    return xrSuggestInteractionProfileBindings(c->instance, &info);
}

static void actions_are_checked(void **state) {
    (void)state;
    client_settings("{\"clock\": \"virtual\"}");
    struct client c = {0};
    client_start(&c);
    static const char touch[] = "/interaction_profiles/oculus/touch_controller";
    XrActionSetCreateInfo info = {.type = XR_TYPE_ACTION_SET_CREATE_INFO,
                                  .actionSetName = "a",
                                  .localizedActionSetName = "A"};
    XrActionSet set, other;
    XR_OK(xrCreateActionSet(c.instance, &info, &set));
    XR_IS(XR_ERROR_NAME_DUPLICATED, xrCreateActionSet(c.instance, &info, &other));
    strcpy(info.actionSetName, "b");
    XR_IS(XR_ERROR_LOCALIZED_NAME_DUPLICATED, xrCreateActionSet(c.instance, &info, &other));
    strcpy(info.actionSetName, "Bad Name");
    XR_IS(XR_ERROR_PATH_FORMAT_INVALID, xrCreateActionSet(c.instance, &info, &other));
    strcpy(info.actionSetName, "b");
    strcpy(info.localizedActionSetName, "\xff");
    XR_IS(XR_ERROR_LOCALIZED_NAME_INVALID, xrCreateActionSet(c.instance, &info, &other));
    XrAction x = action_in(set, "x", XR_ACTION_TYPE_FLOAT_INPUT, XR_SUCCESS);
    action_in(set, "x", XR_ACTION_TYPE_FLOAT_INPUT, XR_ERROR_NAME_DUPLICATED);
    action_in(set, "", XR_ACTION_TYPE_FLOAT_INPUT, XR_ERROR_NAME_INVALID);
    action_in(set, "y", (XrActionType)99, XR_ERROR_VALIDATION_FAILURE);
    XR_OK(suggest(&c, touch, x, "/user/hand/left/input/trigger/value"));
    XR_OK(suggest(&c, touch, x, "/user/hand/left/input/grip/pose")); // types are not checked
    XR_IS(XR_ERROR_PATH_UNSUPPORTED, suggest(&c, touch, x, "/user/hand/left/input/a/click"));
    XR_IS(XR_ERROR_PATH_UNSUPPORTED, suggest(&c, touch, x, "/user/hand/left/input"));
    XR_IS(XR_ERROR_PATH_UNSUPPORTED, suggest(&c, "/interaction_profiles/no/such", x, "/user/x"));
    XrActionsSyncInfo sync = {.type = XR_TYPE_ACTIONS_SYNC_INFO};
    XR_IS(XR_SESSION_NOT_FOCUSED, xrSyncActions(c.session, &sync)); // names no set
    XrActiveActionSet active = {.actionSet = set};
    sync.countActiveActionSets = 1;
    sync.activeActionSets = &active;
    XR_IS(XR_ERROR_ACTIONSET_NOT_ATTACHED, xrSyncActions(c.session, &sync));
    XrSessionActionSetsAttachInfo attach = {
        .type = XR_TYPE_SESSION_ACTION_SETS_ATTACH_INFO, .countActionSets = 1, .actionSets = &set};
    XR_OK(xrAttachSessionActionSets(c.session, &attach));
    XR_IS(XR_ERROR_ACTIONSETS_ALREADY_ATTACHED, xrAttachSessionActionSets(c.session, &attach));
    action_in(set, "late", XR_ACTION_TYPE_FLOAT_INPUT, XR_ERROR_ACTIONSETS_ALREADY_ATTACHED);
    XR_IS(XR_ERROR_ACTIONSETS_ALREADY_ATTACHED,
          suggest(&c, touch, x, "/user/hand/left/input/trigger/value"));
    XrActionStateGetInfo get = {.type = XR_TYPE_ACTION_STATE_GET_INFO, .action = x};
    XrActionStateBoolean b = {.type = XR_TYPE_ACTION_STATE_BOOLEAN};
    XR_IS(XR_ERROR_ACTION_TYPE_MISMATCH, xrGetActionStateBoolean(c.session, &get, &b));
    XrActionStateFloat f = {.type = XR_TYPE_ACTION_STATE_FLOAT};
    XR_OK(xrStringToPath(c.instance, "/user/hand/left", &get.subactionPath));
    XR_IS(XR_ERROR_PATH_UNSUPPORTED, xrGetActionStateFloat(c.session, &get, &f));
    client_stop(&c);
}

// Threads that create, use and destroy everything at once, on one session.
struct worker {
    struct client *c;
    unsigned seed;
    int unexpected;
};

static void *make_and_destroy(void *data) {
    struct worker *w = data;
    for (int k = 0; k < 400; k++) {
        XrReferenceSpaceCreateInfo info = {.type = XR_TYPE_REFERENCE_SPACE_CREATE_INFO,
                                           .referenceSpaceType = XR_REFERENCE_SPACE_TYPE_VIEW,
                                           .poseInReferenceSpace.orientation.w = 1};
        XrSpace space;
        XrSpaceLocation at = {.type = XR_TYPE_SPACE_LOCATION};
        char text[64];
        XrPath path;
        snprintf(text, sizeof text, "/user/%u/%d", w->seed, k % 50);
        w->unexpected += xrCreateReferenceSpace(w->c->session, &info, &space) != XR_SUCCESS;
        w->unexpected += xrLocateSpace(space, w->c->stage, 1 + k, &at) != XR_SUCCESS;
        w->unexpected += xrStringToPath(w->c->instance, text, &path) != XR_SUCCESS;
        w->unexpected += xrDestroySpace(space) != XR_SUCCESS;
    }
    return NULL;
}

static void *run_frames(void *data) {
    struct worker *w = data;
    for (int k = 0; k < 300; k++) {
        XrFrameState f = {.type = XR_TYPE_FRAME_STATE};
        XrFrameEndInfo end = {.type = XR_TYPE_FRAME_END_INFO,
                              .displayTime = 1,
                              .environmentBlendMode = XR_ENVIRONMENT_BLEND_MODE_OPAQUE};
        w->unexpected += xrWaitFrame(w->c->session, NULL, &f) != XR_SUCCESS;
        w->unexpected += xrBeginFrame(w->c->session, NULL) != XR_SUCCESS;
        w->unexpected += xrEndFrame(w->c->session, &end) != XR_SUCCESS;
    }
    return NULL;
}

static void threads_do_not_disturb_each_other(void **state) {
    (void)state;
    client_settings("{\"clock\": \"virtual\"}");
    struct client c = {0};
    client_start(&c);
    pthread_t thread[5];
    struct worker worker[5];
    for (unsigned i = 0; i < 5; i++) {
        worker[i] = (struct worker){.c = &c, .seed = i};
        assert_int_equal(
            pthread_create(&thread[i], NULL, i ? make_and_destroy : run_frames, &worker[i]), 0);
    }
    for (int i = 0; i < 5; i++) {
        pthread_join(thread[i], NULL);
        assert_int_equal(worker[i].unexpected, 0);
    }
    client_stop(&c);
}

// A wait for the frame after an unbegun one ends when the frame is begun, from another thread.
static void *begin_later(void *data) {
    struct client *c = data;
    struct timespec t = {.tv_nsec = 30000000};
    nanosleep(&t, NULL);
    return (void *)(intptr_t)xrBeginFrame(c->session, NULL);
}

static void waiting_ahead_blocks_until_the_frame_is_begun(void **state) {
    (void)state;
    client_settings("{\"clock\": \"virtual\"}");
    struct client c = {0};
    client_start(&c);
    client_wait(&c);
    pthread_t thread;
    void *result;
    assert_int_equal(pthread_create(&thread, NULL, begin_later, &c), 0);
    client_wait(&c);
    pthread_join(thread, &result);
    assert_int_equal((intptr_t)result, XR_SUCCESS);
    client_stop(&c);
}

// Hundreds of instances in one process: nothing is left over, and the library is unloaded each
// time.
static void instances_come_and_go(void **state) {
    (void)state;
    client_settings(NULL);
    for (int k = 0; k < 200; k++) {
        XrInstance instance;
        XR_OK(client_try_instance(&instance));
        XR_OK(xrDestroyInstance(instance));
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(dead_and_foreign_handles_are_told, client_teardown),
        cmocka_unit_test_teardown(random_handles_never_crash, client_teardown),
        cmocka_unit_test_teardown(null_and_mistyped_structures_are_refused, client_teardown),
        cmocka_unit_test_teardown(paths_are_checked, client_teardown),
        cmocka_unit_test_teardown(actions_are_checked, client_teardown),
        cmocka_unit_test_teardown(threads_do_not_disturb_each_other, client_teardown),
        cmocka_unit_test_teardown(waiting_ahead_blocks_until_the_frame_is_begun, client_teardown),
        cmocka_unit_test_teardown(instances_come_and_go, client_teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
