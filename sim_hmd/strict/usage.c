#include <pthread.h>
#include <string.h>

#include "sim_hmd/input/actions.h"
#include "sim_hmd/strict/call.h"

// What the specification allows and a program hardly means: the frame loop, views, events, actions
// and the ends of things. Every statement's name begins with USE- (docs/strict.md).

typedef void (*hook_function)(struct sim_strict_call *call);

enum { MAX_LOCATED = 8, MAX_BOUND = 512, MANY_FRAMES = 100, STOPPING_FRAMES = 10 };

struct frame {
    bool valid, should_render, located;
    XrTime time;
};

struct located {
    uint64_t space; // 0: none
    XrTime time;
    XrViewStateFlags flags;
    XrPosef pose[2];
};

// Of the one session that a program has at a time.
struct session_use {
    struct frame waited, begun;
    bool begun_once;
    pthread_t begin_thread;
    struct located located[MAX_LOCATED];
    unsigned next_located;
    uint64_t frames, polled_at, stopping_at; // frame numbers
    XrSessionState polled_state;
    bool attached, synced;
    bool asked_formats;
};

static pthread_mutex_t mutex = PTHREAD_MUTEX_INITIALIZER;
static struct session_use use;
static bool asked_blend_modes; // of the system, before there is a session
static uint64_t bound[MAX_BOUND];
static size_t bound_count;

static bool ok(const struct sim_strict_call *call) {
    return call->result >= 0;
}

// The frame loop.

static void before_wait(struct sim_strict_call *call) {
    if (use.waited.valid && use.begun_once && pthread_equal(use.begin_thread, pthread_self()))
        sim_strict_found(call, SIM_WARNING, "USE-wait-twice",
                         "the frame waited for before is not begun, and this thread begins frames: "
                         "it may wait for itself");
}

static void after_wait(struct sim_strict_call *call) {
    if (!ok(call))
        return;
    const XrFrameState *state = SIM_ARG(call, const XrFrameState *, 2);
    use.waited = (struct frame){
        .valid = true, .should_render = state->shouldRender, .time = state->predictedDisplayTime};
    use.frames++;
    if (use.frames - use.polled_at > MANY_FRAMES)
        sim_strict_found(call, SIM_WARNING, "USE-events-not-polled",
                         "%d frames without xrPollEvent to XR_EVENT_UNAVAILABLE", MANY_FRAMES);
    if (use.polled_state == XR_SESSION_STATE_STOPPING &&
        use.frames - use.stopping_at > STOPPING_FRAMES)
        sim_strict_found(call, SIM_WARNING, "USE-stopping-ignored",
                         "%d frames since the event of the state STOPPING", STOPPING_FRAMES);
}

static void after_begin(struct sim_strict_call *call) {
    if (!ok(call))
        return;
    use.begun = use.waited;
    use.waited.valid = false;
    use.begun_once = true;
    use.begin_thread = pthread_self();
    sim_strict_swapchains_begin_frame();
    if (call->result == XR_FRAME_DISCARDED)
        sim_strict_found(call, SIM_WARNING, "USE-frame-discarded",
                         "the frame begun before was never ended");
}

static bool same_pose(const XrPosef *a, const XrPosef *b) {
    return memcmp(a, b, sizeof *a) == 0;
}

// The located views that an eye's submitted pose is from, best those of this frame's time.
static const struct located *origin_of(uint64_t space, const XrPosef *pose) {
    const struct located *best = NULL;
    for (int i = 0; i < MAX_LOCATED; i++) {
        const struct located *l = &use.located[i];
        if (l->space == space && (same_pose(&l->pose[0], pose) || same_pose(&l->pose[1], pose)) &&
            (!best || l->time == use.begun.time))
            best = l;
    }
    return best;
}

static void look_at_views(struct sim_strict_call *call, const XrCompositionLayerProjection *layer) {
    if (!use.begun.located) {
        sim_strict_found(call, SIM_WARNING, "USE-views-not-located",
                         "a projection layer, and no xrLocateViews at %lld",
                         (long long)use.begun.time);
        return;
    }
    for (uint32_t i = 0; i < layer->viewCount; i++) {
        const struct located *l = origin_of(sim_raw(layer->space), &layer->views[i].pose);
        if (!l)
            sim_strict_found(call, SIM_WARNING, "USE-views-unused",
                             "view %u has a pose that xrLocateViews did not give in this space", i);
        else if (l->time != use.begun.time)
            sim_strict_found(call, SIM_WARNING, "USE-views-other-time",
                             "view %u was located at %lld; the frame is shown at %lld", i,
                             (long long)l->time, (long long)use.begun.time);
        else if (!(l->flags & XR_VIEW_STATE_ORIENTATION_VALID_BIT))
            sim_strict_found(call, SIM_WARNING, "USE-views-invalid",
                             "view %u has a pose whose viewStateFlags said that it is not valid",
                             i);
    }
}

// True where one of the structure's swapchains was drawn in this frame.
static bool look_at_images(struct sim_strict_call *call, const struct sim_spec *spec,
                           const char *structure) {
    bool drawn = false;
    for (const struct sim_member *m = spec->members; m->kind; m++) {
        const char *at = structure + m->offset;
        if (m->kind == MEMBER_HANDLE && m->object == SIM_SWAPCHAIN)
            drawn |= sim_strict_swapchain_submitted(call, *(const XrSwapchain *)at);
        if (m->kind == MEMBER_STRUCT)
            drawn |= look_at_images(call, m->spec, at);
        uint32_t n =
            m->kind == MEMBER_STRUCTS ? *(const uint32_t *)(structure + m->count_offset) : 0;
        for (uint32_t i = 0; i < n; i++)
            drawn |= look_at_images(call, m->spec, *(const char *const *)at + i * m->spec->size);
    }
    return drawn;
}

static void after_end(struct sim_strict_call *call) {
    if (!ok(call))
        return;
    const XrFrameEndInfo *info = SIM_ARG(call, const XrFrameEndInfo *, 1);
    if (info->displayTime != use.begun.time)
        sim_strict_found(call, SIM_WARNING, "USE-frame-displayTime",
                         "displayTime is %lld; xrWaitFrame predicted %lld",
                         (long long)info->displayTime, (long long)use.begun.time);
    if (!asked_blend_modes)
        sim_strict_found(call, SIM_NOTE, "USE-blend-mode-unasked",
                         "environmentBlendMode %d without xrEnumerateEnvironmentBlendModes",
                         (int)info->environmentBlendMode);
    bool drawn = false;
    for (uint32_t i = 0; i < info->layerCount; i++) {
        const XrCompositionLayerBaseHeader *layer = info->layers[i];
        const struct sim_spec *spec = sim_spec_find(layer->type);
        if (spec)
            drawn |= look_at_images(call, spec, (const char *)layer);
        if (layer->type == XR_TYPE_COMPOSITION_LAYER_PROJECTION)
            look_at_views(call, (const XrCompositionLayerProjection *)layer);
    }
    if (drawn && !use.begun.should_render)
        sim_strict_found(call, SIM_WARNING, "USE-should-render",
                         "images were drawn for a frame whose shouldRender is false");
    use.begun.valid = false;
}

static void after_locate_views(struct sim_strict_call *call) {
    const XrViewLocateInfo *info = SIM_ARG(call, const XrViewLocateInfo *, 1);
    const XrView *views = SIM_ARG(call, const XrView *, 5);
    if (!ok(call) || (uint32_t)call->v[3] < 2)
        return;
    struct located *l = &use.located[use.next_located++ % MAX_LOCATED];
    *l = (struct located){sim_raw(info->space),
                          info->displayTime,
                          SIM_ARG(call, const XrViewState *, 2)->viewStateFlags,
                          {views[0].pose, views[1].pose}};
    bool waited = use.waited.valid && info->displayTime == use.waited.time;
    bool begun = use.begun.valid && info->displayTime == use.begun.time;
    use.waited.located |= waited;
    use.begun.located |= begun;
    if (!waited && !begun && (use.waited.valid || use.begun.valid))
        sim_strict_found(call, SIM_WARNING, "USE-views-time",
                         "displayTime %lld is of no frame under way", (long long)info->displayTime);
}

// Events and the session.

static void after_poll(struct sim_strict_call *call) {
    const XrEventDataBuffer *event = SIM_ARG(call, const XrEventDataBuffer *, 1);
    if (call->result == XR_EVENT_UNAVAILABLE)
        use.polled_at = use.frames;
    if (call->result != XR_SUCCESS)
        return;
    if (event->type == XR_TYPE_EVENT_DATA_SESSION_STATE_CHANGED) {
        XrEventDataSessionStateChanged changed;
        memcpy(&changed, event, sizeof changed);
        use.polled_state = changed.state;
        use.stopping_at = use.frames;
    } else if (event->type == XR_TYPE_EVENT_DATA_EVENTS_LOST)
        sim_strict_found(call, SIM_WARNING, "USE-events-lost",
                         "the queue overflowed: events are not polled often enough");
}

static void after_begin_session(struct sim_strict_call *call) {
    if (ok(call) && use.polled_state != XR_SESSION_STATE_READY)
        sim_strict_found(call, SIM_WARNING, "USE-begin-before-ready",
                         "the event of the state READY is not polled yet");
}

static void look_at_actions(const char *function) {
    if (use.attached && !use.synced && use.frames > STOPPING_FRAMES)
        sim_strict_report(SIM_WARNING, function, "USE-actions-never-synced",
                          "%llu frames with action sets attached and no xrSyncActions",
                          (unsigned long long)use.frames);
}

static void after_end_session(struct sim_strict_call *call) {
    if (!ok(call))
        return;
    if (use.polled_state != XR_SESSION_STATE_STOPPING)
        sim_strict_found(call, SIM_WARNING, "USE-end-before-stopping",
                         "the event of the state STOPPING is not polled yet");
    look_at_actions(call->function->name);
}

static void after_create_session(struct sim_strict_call *call) {
    if (ok(call))
        use = (struct session_use){0};
}

struct census {
    unsigned sessions, spaces, swapchains, sets;
};

static void count(const struct sim_object *object, struct census *n) {
    for (const struct sim_object *o = object->first_child; o; o = o->next) {
        n->sessions += o->type == SIM_SESSION;
        n->spaces += o->type == SIM_SPACE;
        n->swapchains += o->type == SIM_SWAPCHAIN;
        n->sets += o->type == SIM_ACTION_SET;
        count(o, n);
    }
}

static void look_at_children(struct sim_strict_call *call, enum sim_level level,
                             const char *statement) {
    struct census n = {0};
    const struct sim_object *object;
    {
        SIM_LOCKED;
        object = sim_object_get(call->v[0], call->function->params[0].object);
        if (object)
            count(object, &n);
    }
    if (n.sessions || n.spaces || n.swapchains || n.sets)
        sim_strict_found(call, level, statement,
                         "alive: %u sessions, %u spaces, %u swapchains, %u action sets", n.sessions,
                         n.spaces, n.swapchains, n.sets);
}

static void before_destroy_session(struct sim_strict_call *call) {
    look_at_children(call, SIM_NOTE, "USE-children-alive");
    bool running;
    {
        SIM_LOCKED;
        const struct sim_session *session = sim_object_get(call->v[0], SIM_SESSION);
        running = session && session->running;
    }
    if (running)
        sim_strict_found(call, SIM_WARNING, "USE-session-not-ended",
                         "a running session is destroyed: no xrRequestExitSession, STOPPING and "
                         "xrEndSession");
    sim_strict_swapchains_finish(call->function->name);
    look_at_actions(call->function->name);
}

static void before_destroy_instance(struct sim_strict_call *call) {
    look_at_children(call, SIM_WARNING, "USE-children-alive");
}

// Actions.

static void after_suggest(struct sim_strict_call *call) {
    const XrInteractionProfileSuggestedBinding *info =
        SIM_ARG(call, const XrInteractionProfileSuggestedBinding *, 1);
    for (uint32_t i = 0; ok(call) && i < info->countSuggestedBindings; i++)
        if (bound_count < MAX_BOUND)
            bound[bound_count++] = sim_raw(info->suggestedBindings[i].action);
}

static bool is_bound(uint64_t action) {
    bool found = bound_count == MAX_BOUND;
    for (size_t i = 0; i < bound_count && !found; i++)
        found = bound[i] == action;
    return found;
}

static void after_attach(struct sim_strict_call *call) {
    const XrSessionActionSetsAttachInfo *info =
        SIM_ARG(call, const XrSessionActionSetsAttachInfo *, 1);
    if (!ok(call))
        return;
    use.attached = true;
    char name[XR_MAX_ACTION_NAME_SIZE] = "";
    {
        SIM_LOCKED;
        for (uint32_t i = 0; i < info->countActionSets; i++) {
            const struct sim_object *set =
                sim_object_get(sim_raw(info->actionSets[i]), SIM_ACTION_SET);
            for (const struct sim_object *o = set ? set->first_child : NULL; o; o = o->next)
                if (!is_bound(o->handle))
                    memcpy(name, ((const struct sim_action *)o)->name, sizeof name);
        }
    }
    if (name[0])
        sim_strict_found(call, SIM_NOTE, "USE-action-unbound",
                         "no binding was suggested for action \"%s\"", name);
}

static void after_sync(struct sim_strict_call *call) {
    use.synced |= ok(call) && use.attached;
    if (ok(call) && !use.attached)
        sim_strict_found(call, SIM_WARNING, "USE-sync-unattached",
                         "no action sets are attached: nothing to read");
}

static void before_state(struct sim_strict_call *call) {
    if (use.attached && !use.synced)
        sim_strict_found(call, SIM_WARNING, "USE-actions-never-synced",
                         "an action's state is read before any xrSyncActions");
}

static void before_haptics(struct sim_strict_call *call) {
    const XrHapticVibration *v = SIM_ARG(call, const XrHapticVibration *, 2);
    if (!v || v->type != XR_TYPE_HAPTIC_VIBRATION)
        return;
    if (!(v->amplitude >= 0 && v->amplitude <= 1))
        sim_strict_found(call, SIM_ERROR, "XrHapticVibration: amplitude is between 0 and 1",
                         "amplitude is %g", (double)v->amplitude);
    if (!(v->frequency >= 0))
        sim_strict_found(call, SIM_ERROR, "XrHapticVibration: frequency is not negative",
                         "frequency is %g", (double)v->frequency);
    if (v->duration < XR_MIN_HAPTIC_DURATION)
        sim_strict_found(call, SIM_ERROR, "XrHapticVibration: duration is not negative",
                         "duration is %lld", (long long)v->duration);
}

// Questions that a program is expected to ask.

static void after_blend_modes(struct sim_strict_call *call) {
    asked_blend_modes |= ok(call);
}

static void after_formats(struct sim_strict_call *call) {
    use.asked_formats |= ok(call);
}

static void after_create_swapchain(struct sim_strict_call *call) {
    if (ok(call) && !use.asked_formats)
        sim_strict_found(call, SIM_NOTE, "USE-format-unasked",
                         "format %lld without xrEnumerateSwapchainFormats",
                         (long long)SIM_ARG(call, const XrSwapchainCreateInfo *, 1)->format);
    sim_strict_swapchain_call(call);
}

static const struct {
    const char *function;
    hook_function before, after;
} hooks[] = {
    {"xrWaitFrame", before_wait, after_wait},
    {"xrBeginFrame", NULL, after_begin},
    {"xrEndFrame", NULL, after_end},
    {"xrLocateViews", NULL, after_locate_views},
    {"xrPollEvent", NULL, after_poll},
    {"xrCreateSession", NULL, after_create_session},
    {"xrBeginSession", NULL, after_begin_session},
    {"xrEndSession", NULL, after_end_session},
    {"xrDestroySession", before_destroy_session, NULL},
    {"xrDestroyInstance", before_destroy_instance, NULL},
    {"xrSuggestInteractionProfileBindings", NULL, after_suggest},
    {"xrAttachSessionActionSets", NULL, after_attach},
    {"xrSyncActions", NULL, after_sync},
    {"xrGetActionStateBoolean", before_state, NULL},
    {"xrGetActionStateFloat", before_state, NULL},
    {"xrGetActionStateVector2f", before_state, NULL},
    {"xrGetActionStatePose", before_state, NULL},
    {"xrApplyHapticFeedback", before_haptics, NULL},
    {"xrEnumerateEnvironmentBlendModes", NULL, after_blend_modes},
    {"xrEnumerateSwapchainFormats", NULL, after_formats},
    {"xrCreateSwapchain", NULL, after_create_swapchain},
    {"xrAcquireSwapchainImage", NULL, sim_strict_swapchain_call},
    {"xrWaitSwapchainImage", NULL, sim_strict_swapchain_call},
    {"xrReleaseSwapchainImage", NULL, sim_strict_swapchain_call},
    {"xrDestroySwapchain", NULL, sim_strict_swapchain_call},
};

void sim_strict_usage(struct sim_strict_call *call, bool after) {
    for (size_t i = 0; i < sizeof hooks / sizeof *hooks; i++) {
        hook_function hook = after ? hooks[i].after : hooks[i].before;
        if (!hook || strcmp(hooks[i].function, call->function->name) != 0)
            continue;
        pthread_mutex_lock(&mutex);
        hook(call);
        pthread_mutex_unlock(&mutex);
    }
}

void sim_strict_usage_reset(void) {
    pthread_mutex_lock(&mutex);
    use = (struct session_use){0};
    asked_blend_modes = false;
    bound_count = 0;
    sim_strict_swapchains_reset();
    pthread_mutex_unlock(&mutex);
}

// The runtime's lock is not taken: the process may end within a call.
void sim_strict_usage_finish(void) {
    pthread_mutex_lock(&mutex);
    sim_strict_swapchains_finish("xrDestroyInstance");
    look_at_actions("xrDestroyInstance");
    pthread_mutex_unlock(&mutex);
}
