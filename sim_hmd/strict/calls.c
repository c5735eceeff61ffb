#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#include "sim_hmd/core/instance.h"
#include "sim_hmd/strict/spec.h"

// A wrapper of every function: arguments, the function itself, the result.

static void before(struct sim_strict_call *call);
static XrResult after(struct sim_strict_call *call, XrResult result);

// A parameter is (its type, how it becomes a number, its description).
#define TYPE(type, number, ...) type
#define NUMBER(type, number, ...) number
#define DESCRIPTION(type, number, ...) __VA_ARGS__
#define ITSELF(v) (uint64_t)(uintptr_t)(v)
#define ADDRESS(v) (uint64_t)(uintptr_t) & (v) // what is no number is looked at where it lies
#define PARAM(n, k, ...)                                                                           \
    { .name = #n, .kind = PARAM_##k, __VA_ARGS__ }
#define HANDLE(T, n) (T, ITSELF, PARAM(n, HANDLE, .object = OBJECT_##T))
#define OTHER_HANDLE(T, n) (T, ITSELF, PARAM(n, VALUE, 0))
#define VALUE(T, n) (T, ITSELF, PARAM(n, VALUE, 0))
#define PATH(n) (XrPath, ITSELF, PARAM(n, PATH, 0))
#define FLOATS(T, n) (T, ADDRESS, PARAM(n, FLOATS, .size = sizeof(T)))
#define POSE(n) (XrPosef, ADDRESS, PARAM(n, POSE, .size = sizeof(XrPosef)))
#define ENUM(T, n) (T, ITSELF, PARAM(n, ENUM, .values = &sim_values_##T))
#define IN(T, n) (const T *, ITSELF, PARAM(n, IN, .spec = &sim_spec_##T))
#define OPTIONAL_IN(T, n) (const T *, ITSELF, PARAM(n, IN, .optional = true, .spec = &sim_spec_##T))
#define OUT(T, n) (T *, ITSELF, PARAM(n, OUT, .spec = &sim_spec_##T))
#define OUT_ARRAY(T, n) (T *, ITSELF, PARAM(n, OUT_ARRAY, .spec = &sim_spec_##T))
#define POINTER(T, n) (T *, ITSELF, PARAM(n, POINTER, 0))
#define STRING(n) (const char *, ITSELF, PARAM(n, STRING, 0))
#define OPTIONAL_STRING(n) (const char *, ITSELF, PARAM(n, STRING, .optional = true))
#define BUFFER(n) (char *, ITSELF, PARAM(n, POINTER, 0))
#define CAPACITY(n) (uint32_t, ITSELF, PARAM(n, CAPACITY, 0))
#define COUNT(n) (uint32_t *, ITSELF, PARAM(n, POINTER, 0))
#define ARRAY(T, n) (T *, ITSELF, PARAM(n, ARRAY, 0))
#define OBJECT_XrInstance SIM_INSTANCE
#define OBJECT_XrSession SIM_SESSION
#define OBJECT_XrSpace SIM_SPACE
#define OBJECT_XrSwapchain SIM_SWAPCHAIN
#define OBJECT_XrActionSet SIM_ACTION_SET
#define OBJECT_XrAction SIM_ACTION

#define T_(P) TYPE P
#define D_(P) DESCRIPTION P
#define N_(P, v) NUMBER P(v)
#define CALL1(f, A)                                                                                \
    static struct sim_strict_function call_##f = {.name = #f, .count = 1, .params = {D_(A)}};      \
    static XRAPI_ATTR XrResult XRAPI_CALL strict_##f(T_(A) a) {                                    \
        struct sim_strict_call call = {.function = &call_##f, .v = {N_(A, a)}};                    \
        before(&call);                                                                             \
        return after(&call, ((PFN_##f)call_##f.real)(a));                                          \
    }
#define CALL2(f, A, B)                                                                             \
    static struct sim_strict_function call_##f = {                                                 \
        .name = #f, .count = 2, .params = {D_(A), D_(B)}};                                         \
    static XRAPI_ATTR XrResult XRAPI_CALL strict_##f(T_(A) a, T_(B) b) {                           \
        struct sim_strict_call call = {.function = &call_##f, .v = {N_(A, a), N_(B, b)}};          \
        before(&call);                                                                             \
        return after(&call, ((PFN_##f)call_##f.real)(a, b));                                       \
    }
#define CALL3(f, A, B, C)                                                                          \
    static struct sim_strict_function call_##f = {                                                 \
        .name = #f, .count = 3, .params = {D_(A), D_(B), D_(C)}};                                  \
    static XRAPI_ATTR XrResult XRAPI_CALL strict_##f(T_(A) a, T_(B) b, T_(C) c) {                  \
        struct sim_strict_call call = {.function = &call_##f,                                      \
                                       .v = {N_(A, a), N_(B, b), N_(C, c)}};                       \
        before(&call);                                                                             \
        return after(&call, ((PFN_##f)call_##f.real)(a, b, c));                                    \
    }
#define CALL4(f, A, B, C, D)                                                                       \
    static struct sim_strict_function call_##f = {                                                 \
        .name = #f, .count = 4, .params = {D_(A), D_(B), D_(C), D_(D)}};                           \
    static XRAPI_ATTR XrResult XRAPI_CALL strict_##f(T_(A) a, T_(B) b, T_(C) c, T_(D) d) {         \
        struct sim_strict_call call = {.function = &call_##f,                                      \
                                       .v = {N_(A, a), N_(B, b), N_(C, c), N_(D, d)}};             \
        before(&call);                                                                             \
        return after(&call, ((PFN_##f)call_##f.real)(a, b, c, d));                                 \
    }
#define CALL5(f, A, B, C, D, E)                                                                    \
    static struct sim_strict_function call_##f = {                                                 \
        .name = #f, .count = 5, .params = {D_(A), D_(B), D_(C), D_(D), D_(E)}};                    \
    static XRAPI_ATTR XrResult XRAPI_CALL strict_##f(T_(A) a, T_(B) b, T_(C) c, T_(D) d,           \
                                                     T_(E) e) {                                    \
        struct sim_strict_call call = {.function = &call_##f,                                      \
                                       .v = {N_(A, a), N_(B, b), N_(C, c), N_(D, d), N_(E, e)}};   \
        before(&call);                                                                             \
        return after(&call, ((PFN_##f)call_##f.real)(a, b, c, d, e));                              \
    }
#define CALL6(f, A, B, C, D, E, F)                                                                 \
    static struct sim_strict_function call_##f = {                                                 \
        .name = #f, .count = 6, .params = {D_(A), D_(B), D_(C), D_(D), D_(E), D_(F)}};             \
    static XRAPI_ATTR XrResult XRAPI_CALL strict_##f(T_(A) a, T_(B) b, T_(C) c, T_(D) d, T_(E) e,  \
                                                     T_(F) f) {                                    \
        struct sim_strict_call call = {                                                            \
            .function = &call_##f,                                                                 \
            .v = {N_(A, a), N_(B, b), N_(C, c), N_(D, d), N_(E, e), N_(F, f)}};                    \
        before(&call);                                                                             \
        return after(&call, ((PFN_##f)call_##f.real)(a, b, c, d, e, f));                           \
    }

// One function by two names.
typedef PFN_xrLocateSpaces PFN_xrLocateSpacesKHR;

// clang-format off
#include "sim_hmd/strict/functions.inc"
// clang-format on

#undef CALL1
#define CALL1(f, ...) {&call_##f, (PFN_xrVoidFunction)strict_##f},
#undef CALL2
#define CALL2(f, ...) {&call_##f, (PFN_xrVoidFunction)strict_##f},
#undef CALL3
#define CALL3(f, ...) {&call_##f, (PFN_xrVoidFunction)strict_##f},
#undef CALL4
#define CALL4(f, ...) {&call_##f, (PFN_xrVoidFunction)strict_##f},
#undef CALL5
#define CALL5(f, ...) {&call_##f, (PFN_xrVoidFunction)strict_##f},
#undef CALL6
#define CALL6(f, ...) {&call_##f, (PFN_xrVoidFunction)strict_##f},
static const struct {
    struct sim_strict_function *call;
    PFN_xrVoidFunction wrapper;
} wrappers[] = {
// clang-format off
#include "sim_hmd/strict/functions.inc"
    // clang-format on
};

// The calls under way in all threads, to see those that must not overlap. A program with more
// threads than this is not looked at closely.
enum { MAX_UNDER_WAY = 32 };
static struct {
    pthread_mutex_t mutex;
    const struct sim_strict_call *calls[MAX_UNDER_WAY];
} under_way = {.mutex = PTHREAD_MUTEX_INITIALIZER};

static bool uses(const struct sim_strict_call *call, uint64_t handle) {
    for (int i = 0; i < call->function->count; i++)
        if (call->function->params[i].kind == PARAM_HANDLE && call->v[i] == handle)
            return true;
    return false;
}

static bool in_group(const char *name, const char *a, const char *b) {
    return strcmp(name, a) == 0 || strcmp(name, b) == 0;
}

// What the specification's "Host Synchronization" forbids; NULL: the two may overlap.
static const char *forbidden(const struct sim_strict_call *a, const struct sim_strict_call *b) {
    const char *x = a->function->name, *y = b->function->name;
    if (strncmp(x, "xrDestroy", 9) == 0 && uses(b, a->v[0]))
        return "Threading Behavior: nothing else uses a handle while it is destroyed";
    if (a->v[0] != b->v[0])
        return NULL;
    if (in_group(x, "xrWaitFrame", "") && in_group(y, "xrWaitFrame", ""))
        return "Threading Behavior: one xrWaitFrame at a time";
    if (in_group(x, "xrBeginFrame", "xrEndFrame") && in_group(y, "xrBeginFrame", "xrEndFrame"))
        return "Threading Behavior: xrBeginFrame and xrEndFrame one at a time";
    return NULL;
}

static void enter(struct sim_strict_call *call) {
    const char *why = NULL, *other = "";
    int place = -1;
    pthread_mutex_lock(&under_way.mutex);
    for (int i = 0; i < MAX_UNDER_WAY; i++) {
        const struct sim_strict_call *o = under_way.calls[i];
        if (!o)
            place = i;
        else if (!why && (why = forbidden(call, o)))
            other = o->function->name;
    }
    if (place >= 0)
        under_way.calls[place] = call;
    pthread_mutex_unlock(&under_way.mutex);
    if (why)
        sim_strict_found(call, SIM_ERROR, why, "%s is under way in another thread", other);
}

static void leave(const struct sim_strict_call *call) {
    pthread_mutex_lock(&under_way.mutex);
    for (int i = 0; i < MAX_UNDER_WAY; i++)
        if (under_way.calls[i] == call)
            under_way.calls[i] = NULL;
    pthread_mutex_unlock(&under_way.mutex);
}

static bool creates_instance(const struct sim_strict_call *call) {
    return strcmp(call->function->name, "xrCreateInstance") == 0;
}

static _Atomic bool in_use; // another call than xrCreateInstance came

static void before(struct sim_strict_call *call) {
    if (!sim_strict_on || creates_instance(call))
        return;
    in_use = true;
    sim_strict_errors_here();
    enter(call);
    sim_strict_check(call);
    sim_strict_usage(call, false);
}

static void enable_extensions(const XrInstanceCreateInfo *info) {
    for (uint32_t i = 0; i < info->enabledExtensionCount; i++)
        sim_strict_enable(info->enabledExtensionNames[i]);
}

// The instance's settings, or where it came to none, perhaps before they were read, the file's. The
// lint's locks are never taken under the runtime's, but by sim_strict, which asks for no others.
static void start_as_settings_say(const struct sim_strict_call *call) {
    struct sim_settings settings;
    struct ap_error err;
    if (call->result < 0) {
        if (sim_settings_read(&err, getenv("ANTIPODE_SIM"), &settings))
            return;
        if (settings.strict)
            sim_strict_start(settings.strict_report);
        sim_settings_finish(&settings);
        return;
    }
    bool strict;
    char *report = NULL;
    {
        SIM_LOCKED;
        const struct sim_instance *instance = sim_instance_get(*SIM_ARG(call, XrInstance *, 1));
        strict = instance && instance->settings.strict;
        if (strict && instance->settings.strict_report)
            report = strdup(instance->settings.strict_report);
    }
    if (strict)
        sim_strict_start(report);
    free(report);
}

static void created_instance(struct sim_strict_call *call) {
    start_as_settings_say(call);
    if (!sim_strict_on)
        return;
    in_use = false;
    if (call->result >= 0)
        enable_extensions(SIM_ARG(call, const XrInstanceCreateInfo *, 0));
    sim_strict_check(call);
    sim_strict_judge(call);
    if (call->result < 0)
        sim_strict_finish();
}

static XrResult after(struct sim_strict_call *call, XrResult result) {
    call->result = result;
    if (creates_instance(call))
        created_instance(call);
    else if (sim_strict_on) {
        leave(call);
        call->errors += sim_strict_errors_here();
        sim_strict_usage(call, true);
        sim_strict_judge(call);
        if (strcmp(call->function->name, "xrDestroyInstance") == 0 && result >= 0)
            sim_strict_finish();
    }
    return result;
}

PFN_xrVoidFunction sim_strict_wrap(const char *name, PFN_xrVoidFunction function) {
    if (!sim_strict_on && strcmp(name, "xrCreateInstance") != 0)
        return function;
    for (size_t i = 0; i < sizeof wrappers / sizeof *wrappers; i++) {
        struct sim_strict_function *call = wrappers[i].call;
        if (strcmp(call->name, name) != 0)
            continue;
        if (!call->real)
            call->real = function;
        return wrappers[i].wrapper;
    }
    return function;
}

// The loader itself asks for all that it knows, as soon as there is an instance.
void sim_strict_no_function(const char *name) {
    if (sim_strict_on && in_use)
        sim_strict_report(SIM_WARNING, "xrGetInstanceProcAddr",
                          "XR_ERROR_FUNCTION_UNSUPPORTED: functions of enabled extensions only",
                          "%s", name);
}
