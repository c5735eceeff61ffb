#include <stdlib.h>
#include <string.h>

#include "tests/vm/headset.h"
#include "tests/vm/player.h"
#include "tests/vm/same_poses.h"

// An OpenXR program that asks where head and hands (their grips) are while a recording is played:
// each STEP ms where they were 100 ms ago, when all reports of then have come. On SIGTERM it tells
// whether that was what the recording says (same_poses.h).
//
//   headset_poses STEP RECORDING SENT-LOG NEAR-MS

enum { HANDS = 2, DEVICES, ROUND = 8 }; // so many steps are asked about at a time
static const int64_t BACK_NS = 100000000;

struct program {
    struct headset headset;
    XrActionSet set;
    XrAction grip;
    XrSpace hands[HANDS];
};

static XrPath path_of(const struct program *p, const char *text) {
    XrPath path;
    headset_need(xrStringToPath(p->headset.instance, text, &path), text);
    return path;
}

static void make_hands(struct program *p) {
    const XrPath hands[HANDS] = {path_of(p, "/user/hand/left"), path_of(p, "/user/hand/right")};
    const XrActionSetCreateInfo set = {.type = XR_TYPE_ACTION_SET_CREATE_INFO,
                                       .actionSetName = "set",
                                       .localizedActionSetName = "Set"};
    headset_need(xrCreateActionSet(p->headset.instance, &set, &p->set), "xrCreateActionSet");
    const XrActionCreateInfo grip = {.type = XR_TYPE_ACTION_CREATE_INFO,
                                     .actionName = "grip",
                                     .localizedActionName = "Grip",
                                     .actionType = XR_ACTION_TYPE_POSE_INPUT,
                                     .countSubactionPaths = HANDS,
                                     .subactionPaths = hands};
    headset_need(xrCreateAction(p->set, &grip, &p->grip), "xrCreateAction");
    const XrActionSuggestedBinding bindings[HANDS] = {
        {p->grip, path_of(p, "/user/hand/left/input/grip/pose")},
        {p->grip, path_of(p, "/user/hand/right/input/grip/pose")}};
    const XrInteractionProfileSuggestedBinding suggested = {
        .type = XR_TYPE_INTERACTION_PROFILE_SUGGESTED_BINDING,
        .interactionProfile = path_of(p, "/interaction_profiles/khr/simple_controller"),
        .countSuggestedBindings = HANDS,
        .suggestedBindings = bindings};
    headset_need(xrSuggestInteractionProfileBindings(p->headset.instance, &suggested), "bindings");
    const XrSessionActionSetsAttachInfo attach = {.type = XR_TYPE_SESSION_ACTION_SETS_ATTACH_INFO,
                                                  .countActionSets = 1,
                                                  .actionSets = &p->set};
    headset_need(xrAttachSessionActionSets(p->headset.session, &attach), "attach");
    for (int i = 0; i < HANDS; i++) {
        const XrActionSpaceCreateInfo space = {.type = XR_TYPE_ACTION_SPACE_CREATE_INFO,
                                               .action = p->grip,
                                               .subactionPath = hands[i],
                                               .poseInActionSpace.orientation.w = 1};
        headset_need(xrCreateActionSpace(p->headset.session, &space, &p->hands[i]), "a hand");
    }
}

static void sync_actions(const struct program *p) {
    const XrActiveActionSet active = {.actionSet = p->set};
    const XrActionsSyncInfo info = {
        .type = XR_TYPE_ACTIONS_SYNC_INFO, .countActiveActionSets = 1, .activeActionSets = &active};
    XrEventDataBuffer event = {.type = XR_TYPE_EVENT_DATA_BUFFER};
    while (xrPollEvent(p->headset.instance, &event) == XR_SUCCESS)
        event.type = XR_TYPE_EVENT_DATA_BUFFER;
    headset_need(xrSyncActions(p->headset.session, &info), "xrSyncActions");
}

// What is not tracked is not seen.
static void look(const struct program *p, struct trace *trace, XrSpace space, int64_t t_ns) {
    const XrSpaceLocation at = headset_locate(&p->headset, space, headset_time(&p->headset, t_ns));
    const XrSpaceLocationFlags needed =
        XR_SPACE_LOCATION_ORIENTATION_TRACKED_BIT | XR_SPACE_LOCATION_POSITION_VALID_BIT;
    XrVector3f v = at.pose.position;
    XrQuaternionf q = at.pose.orientation;
    if ((at.locationFlags & needed) == needed)
        trace_add(trace, &(struct ap_sample){
                             .t_ns = t_ns,
                             .pose = {{(double)v.x, (double)v.y, (double)v.z},
                                      {(double)q.x, (double)q.y, (double)q.z, (double)q.w}}});
}

static void on_signal(int number) {
    (void)number;
    player_stop = 1;
}

int main(int argc, char **argv) {
    struct program p = {.set = XR_NULL_HANDLE};
    struct trace traces[DEVICES] = {{.name = "head"}, {.name = "left"}, {.name = "right"}};
    int64_t step_ns = argc == 5 ? (int64_t)(1e6 * atof(argv[1])) : 0;
    if (step_ns < 1000)
        player_die("see headset_poses.c for the arguments");
    setvbuf(stdout, NULL, _IOLBF, 0);
    sigaction(SIGTERM, &(struct sigaction){.sa_handler = on_signal}, NULL);
    headset_open(&p.headset);
    make_hands(&p);
    headset_begin(&p.headset);
    printf("ready\n");
    int64_t next = player_now_ns();
    while (!player_stop) {
        for (int64_t now; !player_stop && (now = player_now_ns()) < next + ROUND * step_ns;)
            nanosleep(&(struct timespec){.tv_nsec = next + ROUND * step_ns - now}, NULL);
        sync_actions(&p);
        for (int i = 0; i < ROUND; i++, next += step_ns) {
            look(&p, &traces[0], p.headset.view, next - BACK_NS);
            look(&p, &traces[1], p.hands[0], next - BACK_NS);
            look(&p, &traces[2], p.hands[1], next - BACK_NS);
        }
    }
    headset_close(&p.headset);
    tell_same_poses(argv[2], argv[3], traces, DEVICES, (int64_t)(1e6 * atof(argv[4])));
    for (int i = 0; i < DEVICES; i++)
        free(traces[i].at);
    return 0;
}
