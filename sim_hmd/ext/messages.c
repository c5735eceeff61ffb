#include "sim_hmd/ext/messages.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdio.h>

#include "sim_hmd/core/handles.h"
#include "src/base/log.h"

enum { MAX_WAITING = 64, TEXT = 600, NAME = 128 };

struct waiting {
    const struct sim_messenger *whose; // an address to compare, no more
    PFN_xrDebugUtilsMessengerCallbackEXT callback;
    void *user;
    XrDebugUtilsMessageSeverityFlagsEXT severity;
    XrDebugUtilsMessageTypeFlagsEXT type;
    char id[NAME], function[NAME], text[TEXT];
};

static pthread_mutex_t mutex = PTHREAD_MUTEX_INITIALIZER;
static struct sim_messenger *messengers;
static struct waiting queue[MAX_WAITING];
static int first, count;

XrResult sim_messenger_init(const XrDebugUtilsMessengerCreateInfoEXT *info,
                            struct sim_messenger *messenger) {
    const XrDebugUtilsMessageSeverityFlagsEXT severities =
        XR_DEBUG_UTILS_MESSAGE_SEVERITY_VERBOSE_BIT_EXT |
        XR_DEBUG_UTILS_MESSAGE_SEVERITY_INFO_BIT_EXT |
        XR_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT |
        XR_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT;
    const XrDebugUtilsMessageTypeFlagsEXT types = XR_DEBUG_UTILS_MESSAGE_TYPE_GENERAL_BIT_EXT |
                                                  XR_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT |
                                                  XR_DEBUG_UTILS_MESSAGE_TYPE_PERFORMANCE_BIT_EXT |
                                                  XR_DEBUG_UTILS_MESSAGE_TYPE_CONFORMANCE_BIT_EXT;
    if (!info->userCallback || !info->messageSeverities || info->messageSeverities & ~severities ||
        !info->messageTypes || info->messageTypes & ~types)
        return XR_ERROR_VALIDATION_FAILURE;
    *messenger = (struct sim_messenger){.severities = info->messageSeverities,
                                        .types = info->messageTypes,
                                        .callback = info->userCallback,
                                        .user = info->userData};
    return XR_SUCCESS;
}

// One that is taken out is called without the mutex: the callback may bring new ones.
static void deliver(void) {
    for (;;) {
        pthread_mutex_lock(&mutex);
        bool any = count > 0;
        struct waiting w;
        if (any) {
            w = queue[first];
            first = (first + 1) % MAX_WAITING;
            count--;
        } else {
            atomic_store(&sim_after_unlock, (void (*)(void))0);
        }
        pthread_mutex_unlock(&mutex);
        if (!any)
            return;
        XrDebugUtilsMessengerCallbackDataEXT data = {
            .type = XR_TYPE_DEBUG_UTILS_MESSENGER_CALLBACK_DATA_EXT,
            .messageId = w.id,
            .functionName = w.function,
            .message = w.text};
        if (w.callback)
            w.callback(w.severity, w.type, &data, w.user);
    }
}

void sim_message(XrDebugUtilsMessageSeverityFlagsEXT severity, XrDebugUtilsMessageTypeFlagsEXT type,
                 const char *id, const char *function, const char *text) {
    pthread_mutex_lock(&mutex);
    for (const struct sim_messenger *m = messengers; m && count < MAX_WAITING; m = m->next) {
        if (!(m->severities & severity) || !(m->types & type))
            continue;
        struct waiting *w = &queue[(first + count++) % MAX_WAITING];
        *w = (struct waiting){.whose = m,
                              .callback = m->callback,
                              .user = m->user,
                              .severity = severity,
                              .type = type};
        snprintf(w->id, sizeof w->id, "%s", id);
        snprintf(w->function, sizeof w->function, "%s", function);
        snprintf(w->text, sizeof w->text, "%s", text);
        atomic_store(&sim_after_unlock, deliver);
    }
    pthread_mutex_unlock(&mutex);
}

static void hear(enum ap_log_level level, const char *text) {
    static const XrDebugUtilsMessageSeverityFlagsEXT severities[] = {
        [AP_LOG_ERROR] = XR_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT,
        [AP_LOG_WARNING] = XR_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT,
        [AP_LOG_INFO] = XR_DEBUG_UTILS_MESSAGE_SEVERITY_INFO_BIT_EXT};
    sim_message(severities[level], XR_DEBUG_UTILS_MESSAGE_TYPE_GENERAL_BIT_EXT, "antipode-sim", "",
                text);
}

void sim_messenger_begin(struct sim_messenger *messenger) {
    pthread_mutex_lock(&mutex);
    messenger->next = messengers;
    messengers = messenger;
    pthread_mutex_unlock(&mutex);
    ap_log_set_listener(hear);
}

void sim_messenger_end(struct sim_messenger *messenger) {
    pthread_mutex_lock(&mutex);
    struct sim_messenger **at = &messengers;
    while (*at && *at != messenger)
        at = &(*at)->next;
    if (*at)
        *at = messenger->next;
    if (!messengers)
        ap_log_set_listener(NULL);
    pthread_mutex_unlock(&mutex);
}

void sim_messenger_forget(struct sim_messenger *messenger) {
    sim_messenger_end(messenger);
    pthread_mutex_lock(&mutex);
    for (int i = 0; i < count; i++) {
        struct waiting *w = &queue[(first + i) % MAX_WAITING];
        if (w->whose == messenger)
            w->callback = NULL;
    }
    pthread_mutex_unlock(&mutex);
}

// A fork's child has none of the parent's messengers; another thread may have held the mutex.
static void forget_in_child(void) {
    pthread_mutex_init(&mutex, NULL);
    messengers = NULL;
    count = 0;
    ap_log_set_listener(NULL);
}

__attribute__((constructor)) static void watch_forks(void) {
    pthread_atfork(NULL, NULL, forget_in_child);
}
