#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <string.h>

#include "tests/sim_hmd/client.h"

// XR_EXT_debug_utils through the loader. Debian's has messengers of its own, which it gives up
// where the runtime has the extension: each message comes once.

struct debug {
    struct client c;
    PFN_xrSetDebugUtilsObjectNameEXT name;
    PFN_xrCreateDebugUtilsMessengerEXT create;
    PFN_xrDestroyDebugUtilsMessengerEXT destroy;
    PFN_xrSubmitDebugUtilsMessageEXT submit;
    PFN_xrSessionBeginDebugUtilsLabelRegionEXT begin;
    PFN_xrSessionEndDebugUtilsLabelRegionEXT end;
    PFN_xrSessionInsertDebugUtilsLabelEXT insert;
};

static const char *settings = "{\"clock\": \"virtual\"}";
static const void *chain; // of xrCreateInstance

static void start(struct debug *d) {
    client_settings(settings);
    const char *const extensions[] = {XR_MND_HEADLESS_EXTENSION_NAME,
                                      XR_EXT_DEBUG_UTILS_EXTENSION_NAME};
    XrInstanceCreateInfo info = {
        .type = XR_TYPE_INSTANCE_CREATE_INFO,
        .next = chain,
        .applicationInfo = {.applicationName = "test", .apiVersion = XR_MAKE_VERSION(1, 0, 0)},
        .enabledExtensionCount = 2,
        .enabledExtensionNames = extensions};
    XR_OK(xrCreateInstance(&info, &d->c.instance));
    XrSystemGetInfo get = {.type = XR_TYPE_SYSTEM_GET_INFO,
                           .formFactor = XR_FORM_FACTOR_HEAD_MOUNTED_DISPLAY};
    XR_OK(xrGetSystem(d->c.instance, &get, &d->c.system));
    XrSessionCreateInfo session = {.type = XR_TYPE_SESSION_CREATE_INFO, .systemId = d->c.system};
    XR_OK(xrCreateSession(d->c.instance, &session, &d->c.session));
    XrInstance i = d->c.instance;
    *(void **)&d->name = client_proc(i, "xrSetDebugUtilsObjectNameEXT");
    *(void **)&d->create = client_proc(i, "xrCreateDebugUtilsMessengerEXT");
    *(void **)&d->destroy = client_proc(i, "xrDestroyDebugUtilsMessengerEXT");
    *(void **)&d->submit = client_proc(i, "xrSubmitDebugUtilsMessageEXT");
    *(void **)&d->begin = client_proc(i, "xrSessionBeginDebugUtilsLabelRegionEXT");
    *(void **)&d->end = client_proc(i, "xrSessionEndDebugUtilsLabelRegionEXT");
    *(void **)&d->insert = client_proc(i, "xrSessionInsertDebugUtilsLabelEXT");
}

// What the last callbacks heard.
struct heard {
    XrInstance instance; // asked from within the callback
    int count;
    char message[64], names[256], labels[256];
};

static XrBool32 XRAPI_CALL listen(XrDebugUtilsMessageSeverityFlagsEXT severity,
                                  XrDebugUtilsMessageTypeFlagsEXT types,
                                  const XrDebugUtilsMessengerCallbackDataEXT *data, void *user) {
    struct heard *h = user;
    (void)severity;
    (void)types;
    h->count++;
    snprintf(h->message, sizeof h->message, "%s", data->message);
    h->names[0] = h->labels[0] = '\0';
    for (uint32_t i = 0; i < data->objectCount; i++) {
        const char *name = data->objects[i].objectName;
        snprintf(h->names + strlen(h->names), 64, "%s;", name ? name : "-");
    }
    for (uint32_t i = 0; i < data->sessionLabelCount; i++)
        snprintf(h->labels + strlen(h->labels), 64, "%s;", data->sessionLabels[i].labelName);
    if (h->instance) { // the runtime's lock is free
        char text[XR_MAX_RESULT_STRING_SIZE];
        XR_OK(xrResultToString(h->instance, XR_SUCCESS, text));
    }
    return XR_FALSE;
}

static const XrDebugUtilsMessageSeverityFlagsEXT warning =
    XR_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT;
static const XrDebugUtilsMessageTypeFlagsEXT general = XR_DEBUG_UTILS_MESSAGE_TYPE_GENERAL_BIT_EXT;

static XrDebugUtilsMessengerEXT make_messenger(struct debug *d, struct heard *h) {
    XrDebugUtilsMessengerCreateInfoEXT info = {.type =
                                                   XR_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT,
                                               .messageSeverities = warning,
                                               .messageTypes = general,
                                               .userCallback = listen,
                                               .userData = h};
    XrDebugUtilsMessengerEXT messenger = XR_NULL_HANDLE;
    XR_OK(d->create(d->c.instance, &info, &messenger));
    return messenger;
}

static XrResult say(struct debug *d, XrDebugUtilsMessageSeverityFlagsEXT severity,
                    XrDebugUtilsMessageTypeFlagsEXT types, const char *text) {
    XrDebugUtilsObjectNameInfoEXT objects[2] = {
        {.type = XR_TYPE_DEBUG_UTILS_OBJECT_NAME_INFO_EXT,
         .objectType = XR_OBJECT_TYPE_INSTANCE,
         .objectHandle = (uint64_t)(uintptr_t)d->c.instance},
        {.type = XR_TYPE_DEBUG_UTILS_OBJECT_NAME_INFO_EXT,
         .objectType = XR_OBJECT_TYPE_SESSION,
         .objectHandle = (uint64_t)(uintptr_t)d->c.session}};
    XrDebugUtilsMessengerCallbackDataEXT data = {
        .type = XR_TYPE_DEBUG_UTILS_MESSENGER_CALLBACK_DATA_EXT,
        .messageId = "id",
        .functionName = "f",
        .message = text,
        .objectCount = 2,
        .objects = objects};
    return d->submit(d->c.instance, severity, types, &data);
}

static void messages_go_to_those_who_want_them(void **state) {
    (void)state;
    struct debug d = {0};
    start(&d);
    struct heard a = {.instance = d.c.instance}, b = {0};
    XrDebugUtilsMessengerEXT first = make_messenger(&d, &a), second = make_messenger(&d, &b);
    XR_OK(say(&d, warning, general, "one"));
    assert_int_equal(a.count, 1);
    assert_int_equal(b.count, 1);
    assert_string_equal(a.message, "one");
    XR_OK(say(&d, XR_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT, general, "two"));
    XR_OK(say(&d, warning, XR_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT, "three"));
    assert_int_equal(a.count, 1);
    XR_OK(d.destroy(first));
    XR_OK(say(&d, warning, general, "four"));
    assert_int_equal(a.count, 1);
    assert_int_equal(b.count, 2);
    XR_OK(d.destroy(second));
    XR_OK(say(&d, warning, general, "five"));
    assert_int_equal(b.count, 2);
    client_stop(&d.c);
}

static XrResult set_name(struct debug *d, XrObjectType type, const void *handle, const char *name) {
    XrDebugUtilsObjectNameInfoEXT info = {.type = XR_TYPE_DEBUG_UTILS_OBJECT_NAME_INFO_EXT,
                                          .objectType = type,
                                          .objectHandle = (uint64_t)(uintptr_t)handle,
                                          .objectName = name};
    return d->name(d->c.instance, &info);
}

static void objects_have_names(void **state) {
    (void)state;
    struct debug d = {0};
    start(&d);
    struct heard h = {0};
    make_messenger(&d, &h);
    XR_OK(set_name(&d, XR_OBJECT_TYPE_SESSION, d.c.session, "the session"));
    XR_OK(say(&d, warning, general, "x"));
    assert_string_equal(h.names, "-;the session;");
    XR_OK(set_name(&d, XR_OBJECT_TYPE_SESSION, d.c.session, "another"));
    XR_OK(set_name(&d, XR_OBJECT_TYPE_INSTANCE, d.c.instance, "instance"));
    XR_OK(say(&d, warning, general, "x"));
    assert_string_equal(h.names, "instance;another;");
    XR_OK(set_name(&d, XR_OBJECT_TYPE_SESSION, d.c.session, ""));
    XR_OK(say(&d, warning, general, "x"));
    assert_string_equal(h.names, "instance;-;");
    // Many that come and go.
    for (int i = 0; i < 500; i++) {
        XrReferenceSpaceCreateInfo info = {.type = XR_TYPE_REFERENCE_SPACE_CREATE_INFO,
                                           .referenceSpaceType = XR_REFERENCE_SPACE_TYPE_STAGE,
                                           .poseInReferenceSpace.orientation.w = 1};
        XrSpace space;
        XR_OK(xrCreateReferenceSpace(d.c.session, &info, &space));
        XR_OK(set_name(&d, XR_OBJECT_TYPE_SPACE, space, "space"));
        XR_OK(xrDestroySpace(space));
    }
    XR_OK(say(&d, warning, general, "x"));
    assert_string_equal(h.names, "instance;-;");
    client_stop(&d.c);
}

static void label(struct debug *d, PFN_xrSessionBeginDebugUtilsLabelRegionEXT f, const char *text) {
    XrDebugUtilsLabelEXT info = {.type = XR_TYPE_DEBUG_UTILS_LABEL_EXT, .labelName = text};
    XR_OK(f(d->c.session, &info));
}

static void labels_nest(void **state) {
    (void)state;
    struct debug d = {0};
    start(&d);
    struct heard h = {0};
    make_messenger(&d, &h);
    static const struct {
        char what; // begin, insert, end
        const char *text, *labels;
    } steps[] = {{'i', "1", "1;"},   {'b', "A", "A;"},     {'i', "2", "2;A;"}, {'i', "3", "3;A;"},
                 {'b', "B", "B;A;"}, {'i', "4", "4;B;A;"}, {'e', NULL, "A;"},  {'i', "5", "5;A;"},
                 {'e', NULL, ""},    {'e', NULL, ""},      {'b', "C", "C;"}};
    for (size_t i = 0; i < sizeof steps / sizeof *steps; i++) {
        if (steps[i].what == 'e')
            XR_OK(d.end(d.c.session));
        else
            label(&d, steps[i].what == 'b' ? d.begin : d.insert, steps[i].text);
        XR_OK(say(&d, warning, general, "x"));
        assert_string_equal(h.labels, steps[i].labels);
    }
    client_stop(&d.c);
}

// The runtime's own functions, past the loader, which would catch some of it.
static void what_is_wrong_is_refused(void **state) {
    (void)state;
    struct debug d = {0};
    start(&d);
    XrDebugUtilsMessengerCreateInfoEXT info = {.type =
                                                   XR_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT,
                                               .messageSeverities = warning,
                                               .messageTypes = general};
    XrDebugUtilsMessengerEXT messenger;
    XR_IS(XR_ERROR_VALIDATION_FAILURE, d.create(d.c.instance, &info, &messenger));
    info.userCallback = listen;
    info.messageSeverities = 0;
    XR_IS(XR_ERROR_VALIDATION_FAILURE, d.create(d.c.instance, &info, &messenger));
    info.messageSeverities = 2;
    XR_IS(XR_ERROR_VALIDATION_FAILURE, d.create(d.c.instance, &info, &messenger));
    XR_IS(XR_ERROR_VALIDATION_FAILURE, say(&d, warning, 0, "x"));
    XR_IS(XR_ERROR_VALIDATION_FAILURE, say(&d, 1ull << 40, general, "x"));
    XR_IS(XR_ERROR_VALIDATION_FAILURE, say(&d, warning, general, NULL));
    XR_IS(XR_ERROR_VALIDATION_FAILURE, set_name(&d, XR_OBJECT_TYPE_UNKNOWN, d.c.session, "x"));
    XR_IS(XR_ERROR_VALIDATION_FAILURE, set_name(&d, XR_OBJECT_TYPE_SESSION, NULL, "x"));
    XR_IS(XR_ERROR_HANDLE_INVALID, set_name(&d, XR_OBJECT_TYPE_SPACE, d.c.session, "x"));
    XR_IS(XR_ERROR_HANDLE_INVALID, set_name(&d, (XrObjectType)12345, d.c.session, "x"));
    XR_IS(XR_ERROR_VALIDATION_FAILURE, d.begin(d.c.session, NULL));
    for (int i = 0; i < 1024; i++)
        label(&d, d.begin, "deep");
    XrDebugUtilsLabelEXT deeper = {.type = XR_TYPE_DEBUG_UTILS_LABEL_EXT, .labelName = "deeper"};
    XR_IS(XR_ERROR_LIMIT_REACHED, d.begin(d.c.session, &deeper));
    XR_IS(XR_ERROR_LIMIT_REACHED, d.insert(d.c.session, &deeper));
    client_stop(&d.c);
}

// What the runtime itself says.
struct told {
    XrInstance instance;
    int general, validation;
    char id[64], function[64], text[256];
};

static XrBool32 XRAPI_CALL hear(XrDebugUtilsMessageSeverityFlagsEXT severity,
                                XrDebugUtilsMessageTypeFlagsEXT types,
                                const XrDebugUtilsMessengerCallbackDataEXT *data, void *user) {
    struct told *t = user;
    // Debian's loader speaks to messengers, too.
    bool logged = strcmp(data->messageId, "antipode-sim") == 0;
    if (!logged && !(types & XR_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT))
        return XR_FALSE;
    assert_int_not_equal(severity, 0);
    t->general += logged;
    t->validation += !logged;
    snprintf(t->id, sizeof t->id, "%s", data->messageId);
    snprintf(t->function, sizeof t->function, "%s", data->functionName);
    snprintf(t->text, sizeof t->text, "%s", data->message);
    char text[XR_MAX_RESULT_STRING_SIZE];
    if (t->instance) // the runtime's lock is free
        XR_OK(xrResultToString(t->instance, XR_SUCCESS, text));
    return XR_FALSE;
}

static XrDebugUtilsMessengerCreateInfoEXT hearing(struct told *t) {
    return (XrDebugUtilsMessengerCreateInfoEXT){
        .type = XR_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT,
        .messageSeverities = XR_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT |
                             XR_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT |
                             XR_DEBUG_UTILS_MESSAGE_SEVERITY_INFO_BIT_EXT,
        .messageTypes = XR_DEBUG_UTILS_MESSAGE_TYPE_GENERAL_BIT_EXT |
                        XR_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT,
        .userCallback = hear,
        .userData = t};
}

static void says(const struct told *t, int logged, int found, const char *words) {
    if (t->general != logged || t->validation != found || !strstr(t->text, words))
        fail_msg("%d and %d messages, '%s'; expected %d and %d, '%s'", t->general, t->validation,
                 t->text, logged, found, words);
}

static void a_frame(struct debug *d) {
    XrFrameState f = client_wait(&d->c);
    client_begin(&d->c);
    client_end_empty(&d->c, f.predictedDisplayTime);
}

static void the_runtime_speaks(void **state) {
    (void)state;
    struct debug d = {0};
    struct told created = {0}, made = {0};
    XrDebugUtilsMessengerCreateInfoEXT info = hearing(&created), other = hearing(&made);
    chain = &info;
    // Settings that are wrong: nobody but the chained messenger can hear of it.
    client_settings("{\"clocks\": 1}");
    const char *const extension = XR_EXT_DEBUG_UTILS_EXTENSION_NAME;
    XrInstanceCreateInfo create = {
        .type = XR_TYPE_INSTANCE_CREATE_INFO,
        .next = chain,
        .applicationInfo = {.applicationName = "test", .apiVersion = XR_MAKE_VERSION(1, 0, 0)},
        .enabledExtensionCount = 1,
        .enabledExtensionNames = &extension};
    assert_true(xrCreateInstance(&create, &d.c.instance) < 0);
    says(&created, 1, 0, "clocks");
    created = (struct told){0};
    d.c.instance = XR_NULL_HANDLE;
    settings = "{\"clock\": \"real\", \"refresh_hz\": 120, \"strict\": true}";
    start(&d);
    XrDebugUtilsMessengerEXT messenger = XR_NULL_HANDLE;
    XR_OK(d.create(d.c.instance, &other, &messenger));
    made.instance = d.c.instance;
    XrPath path;
    XrInstance instance = d.c.instance;
    PFN_xrStringToPath to_path =
        (PFN_xrStringToPath)(uintptr_t)client_proc(instance, "xrStringToPath");
    XR_IS(XR_ERROR_PATH_FORMAT_INVALID, to_path(instance, "x", &path));
    XR_IS(XR_ERROR_PATH_FORMAT_INVALID, to_path(instance, "x", &path));
    XR_OK(d.destroy(messenger)); // gives up the lock, if nobody has before
    says(&made, 0, 1, "x");
    assert_string_equal(made.function, "xrStringToPath");
    // Of the runtime the chained one hears creation and destruction only; Debian's loader makes it
    // a messenger for the time between.
    assert_int_equal(created.general, 0);
    XrSessionBeginInfo begin = {.type = XR_TYPE_SESSION_BEGIN_INFO,
                                .primaryViewConfigurationType =
                                    XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO};
    XR_OK(xrBeginSession(d.c.session, &begin));
    a_frame(&d);
    a_frame(&d);
    XR_OK(xrDestroyInstance(d.c.instance));
    assert_int_equal(created.general, 1); // once, though there were two
    assert_non_null(strstr(created.text, "2 frames"));
    says(&made, 0, 1, "x");
    chain = NULL;
    settings = "{\"clock\": \"virtual\"}";
}

// ---- Messengers that come and go while other threads are wrong

enum { THREADS = 4, ROUNDS = 25, INSTANCES = 3 };

struct worker {
    struct debug *d;
    atomic_int heard;
    int failed;
};

static XrBool32 XRAPI_CALL count(XrDebugUtilsMessageSeverityFlagsEXT severity,
                                 XrDebugUtilsMessageTypeFlagsEXT types,
                                 const XrDebugUtilsMessengerCallbackDataEXT *data, void *user) {
    (void)severity;
    struct worker *w = user;
    char text[XR_MAX_RESULT_STRING_SIZE];
    if (types & XR_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT)
        atomic_fetch_add(&w->heard, 1);
    // The runtime may be called.
    if (!data->message || xrResultToString(w->d->c.instance, XR_SUCCESS, text) != XR_SUCCESS)
        atomic_store(&w->heard, -1000000);
    return XR_FALSE;
}

// Of each function's mistake the first of all threads is told, to all messengers that there are.
static void be_wrong(const struct debug *d) {
    const XrInstance i = d->c.instance;
#define WRONG(name, ...) ((PFN_##name)(uintptr_t)client_proc(i, #name))(__VA_ARGS__)
    XrPath path;
    uint32_t n;
    WRONG(xrStringToPath, i, "x", &path);
    WRONG(xrPathToString, i, 123456789, 0, &n, NULL);
    WRONG(xrGetSystem, i, NULL, NULL);
    WRONG(xrGetSystemProperties, i, 7, NULL);
    WRONG(xrPollEvent, i, NULL);
    WRONG(xrCreateActionSet, i, NULL, NULL);
    WRONG(xrEnumerateViewConfigurations, i, 7, 0, NULL, NULL);
    WRONG(xrWaitFrame, d->c.session, NULL, NULL);
    WRONG(xrSyncActions, d->c.session, NULL);
    WRONG(xrLocateViews, d->c.session, NULL, NULL, 0, NULL, NULL);
#undef WRONG
}

static void *work(void *data) {
    struct worker *w = data;
    XrDebugUtilsMessengerCreateInfoEXT info = {
        .type = XR_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT,
        .messageSeverities = XR_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT |
                             XR_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT,
        .messageTypes = XR_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT,
        .userCallback = count,
        .userData = w};
    PFN_xrCreateDebugUtilsMessengerEXT create =
        (PFN_xrCreateDebugUtilsMessengerEXT)(uintptr_t)client_proc(
            w->d->c.instance, "xrCreateDebugUtilsMessengerEXT");
    PFN_xrDestroyDebugUtilsMessengerEXT destroy =
        (PFN_xrDestroyDebugUtilsMessengerEXT)(uintptr_t)client_proc(
            w->d->c.instance, "xrDestroyDebugUtilsMessengerEXT");
    for (int k = 0; k < ROUNDS; k++) {
        XrDebugUtilsMessengerEXT messenger;
        w->failed += create(w->d->c.instance, &info, &messenger) != XR_SUCCESS;
        be_wrong(w->d);
        w->failed += destroy(messenger) != XR_SUCCESS;
    }
    return NULL;
}

static void messengers_come_and_go(void **state) {
    (void)state;
    for (int k = 0; k < INSTANCES; k++) {
        struct debug d = {0};
        struct worker workers[THREADS];
        pthread_t threads[THREADS];
        int heard = 0;
        settings = "{\"clock\": \"virtual\", \"strict\": true}";
        start(&d);
        for (int i = 0; i < THREADS; i++) {
            workers[i] = (struct worker){.d = &d};
            assert_int_equal(pthread_create(&threads[i], NULL, work, &workers[i]), 0);
        }
        for (int i = 0; i < THREADS; i++) {
            pthread_join(threads[i], NULL);
            assert_int_equal(workers[i].failed, 0);
            assert_true(atomic_load(&workers[i].heard) >= 0);
            heard += atomic_load(&workers[i].heard);
        }
        // Ten functions are wrong; whoever is first has a messenger of its own.
        if (heard < 10 || heard > 40 * THREADS)
            fail_msg("%d messages, expected 10 to %d", heard, 40 * THREADS);
        client_stop(&d.c);
    }
    settings = "{\"clock\": \"virtual\"}";
}

#define TEST(name) cmocka_unit_test_teardown(name, client_teardown)

int main(void) {
    const struct CMUnitTest tests[] = {
        TEST(messages_go_to_those_who_want_them),
        TEST(objects_have_names),
        TEST(labels_nest),
        TEST(what_is_wrong_is_refused),
        TEST(the_runtime_speaks),
        TEST(messengers_come_and_go),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
