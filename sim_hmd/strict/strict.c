#include "sim_hmd/strict/strict.h"

#include <errno.h>
#include <fcntl.h>
#include <jansson.h>
#include <pthread.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "sim_hmd/core/quiet_write.h"
#include "sim_hmd/ext/messages.h"
#include "sim_hmd/strict/call.h"
#include "src/base/log.h"

// What was found, once per function and statement. Bounded: what does not fit is counted.

enum { MAX_FINDINGS = 512, MAX_EXTENSIONS = 64, TEXT = 512 };

struct finding {
    enum sim_level level;
    const char *function; // literals
    char statement[192];
    uint64_t count;
};

_Atomic bool sim_strict_on;

static struct {
    pthread_mutex_t mutex;
    struct finding findings[MAX_FINDINGS];
    size_t count;
    uint64_t dropped; // findings beyond the bound
    char extensions[MAX_EXTENSIONS][XR_MAX_EXTENSION_NAME_SIZE];
    size_t extension_count;
    int report; // −1: none
    char *path;
    pid_t process;
} strict = {.mutex = PTHREAD_MUTEX_INITIALIZER, .report = -1};

static const char *const level_names[] = {"error", "warning", "note"};

static void write_line(json_t *line) {
    if (strict.report >= 0 && line) {
        // One write, so that the lines of several processes do not mix.
        char *text = json_dumps(line, JSON_COMPACT | JSON_PRESERVE_ORDER);
        size_t len = text ? strlen(text) : 0;
        if (text)
            text[len] = '\n'; // in the end's place
        if (text && !sim_write_quietly(strict.report, text, len + 1)) {
            ap_log(AP_LOG_ERROR, "strict: the report cannot be written: %s", strerror(errno));
            close(strict.report);
            strict.report = -1;
        }
        free(text);
    }
    json_decref(line);
}

// A fork's child has no instance, so nothing to be blamed for, and the report is the parent's.
static void forget_in_child(void) {
    sim_strict_on = false;
    strict.report = -1;
    pthread_mutex_init(&strict.mutex, NULL); // another thread may have held it
}

static void watch_forks(void) {
    pthread_atfork(NULL, NULL, forget_in_child);
}

void sim_strict_start(const char *report) {
    static pthread_once_t once = PTHREAD_ONCE_INIT;
    pthread_once(&once, watch_forks);
    sim_strict_finish();
    sim_strict_usage_reset();
    pthread_mutex_lock(&strict.mutex);
    strict.count = strict.extension_count = 0;
    strict.dropped = 0;
    strict.process = getpid();
    strict.report = report ? open(report, O_WRONLY | O_APPEND | O_CREAT | O_CLOEXEC, 0666) : -1;
    free(strict.path); // a fork's child has its parent's
    strict.path = report ? strdup(report) : NULL;
    if (report && strict.report < 0)
        ap_log(AP_LOG_ERROR, "strict: %s: %s", report, strerror(errno));
    // A process that dies leaves this as the report's last line, not a verdict.
    write_line(json_pack("{s:I}", "process", (json_int_t)strict.process));
    sim_strict_on = true;
    pthread_mutex_unlock(&strict.mutex);
}

// NULL: the table is full.
static struct finding *find(const char *function, const char *statement) {
    for (size_t i = 0; i < strict.count; i++)
        if (strcmp(strict.findings[i].function, function) == 0 &&
            strcmp(strict.findings[i].statement, statement) == 0)
            return &strict.findings[i];
    if (strict.count == MAX_FINDINGS)
        return NULL;
    struct finding *f = &strict.findings[strict.count++];
    *f = (struct finding){.function = function};
    snprintf(f->statement, sizeof f->statement, "%s", statement);
    return f;
}

// Names come from the program and may be anything; the report is UTF-8.
static void make_printable(char *text) {
    for (; *text; text++)
        if (*text < ' ' || *text > '~')
            *text = '?';
}

static void tell(enum sim_level level, const char *function, const char *statement,
                 const char *values) {
    static const XrDebugUtilsMessageSeverityFlagsEXT severities[] = {
        [SIM_ERROR] = XR_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT,
        [SIM_WARNING] = XR_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT,
        [SIM_NOTE] = XR_DEBUG_UTILS_MESSAGE_SEVERITY_INFO_BIT_EXT};
    sim_message(severities[level], XR_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT, statement,
                function, values);
}

static void report(enum sim_level level, const char *function, const char *statement,
                   const char *format, va_list args) {
    pthread_mutex_lock(&strict.mutex);
    char cut[sizeof((struct finding *)0)->statement];
    snprintf(cut, sizeof cut, "%s", statement);
    struct finding *f = sim_strict_on ? find(function, cut) : NULL;
    if (!f)
        strict.dropped += sim_strict_on;
    else if (f->count++ == 0) {
        char values[TEXT];
        vsnprintf(values, sizeof values, format, args);
        make_printable(values);
        f->level = level;
        fprintf(stderr, "antipode-sim: strict: %s: %s: %s: %s\n", level_names[level], function, cut,
                values);
        tell(level, function, cut, values);
        write_line(json_pack("{s:s, s:s, s:s, s:s}", "level", level_names[level], "function",
                             function, "statement", cut, "values", values));
    }
    pthread_mutex_unlock(&strict.mutex);
}

void sim_strict_report(enum sim_level level, const char *function, const char *statement,
                       const char *format, ...) {
    va_list args;
    va_start(args, format);
    report(level, function, statement, format, args);
    va_end(args);
}

// The call whose wrapper runs in this thread: sim_strict must not be said again by its result.
static _Thread_local int errors_here;

XrResult sim_strict(XrResult result, const char *function, const char *statement,
                    const char *format, ...) {
    if (!sim_strict_on)
        return result;
    va_list args;
    va_start(args, format);
    report(SIM_ERROR, function, statement, format, args);
    va_end(args);
    errors_here++;
    return result;
}

int sim_strict_errors_here(void) {
    int n = errors_here;
    errors_here = 0;
    return n;
}

void sim_strict_found(struct sim_strict_call *call, enum sim_level level, const char *statement,
                      const char *format, ...) {
    va_list args;
    va_start(args, format);
    report(level, call->function->name, statement, format, args);
    va_end(args);
    call->errors += level == SIM_ERROR;
}

void sim_strict_enable(const char *extension) {
    pthread_mutex_lock(&strict.mutex);
    if (strict.extension_count < MAX_EXTENSIONS)
        snprintf(strict.extensions[strict.extension_count++], XR_MAX_EXTENSION_NAME_SIZE, "%s",
                 extension);
    pthread_mutex_unlock(&strict.mutex);
}

static bool listed(const char *extension) {
    for (size_t i = 0; i < strict.extension_count; i++)
        if (strcmp(strict.extensions[i], extension) == 0)
            return true;
    return false;
}

bool sim_strict_enabled(const char *extension) {
    // The loader serves XR_EXT_debug_utils itself where the runtime has it not, and does not tell.
    if (strcmp(extension, XR_EXT_DEBUG_UTILS_EXTENSION_NAME) == 0)
        return true;
    pthread_mutex_lock(&strict.mutex);
    bool enabled = listed(extension);
    // The second Vulkan extension took the structures of the first along.
    if (strcmp(extension, XR_KHR_VULKAN_ENABLE_EXTENSION_NAME) == 0)
        enabled |= listed(XR_KHR_VULKAN_ENABLE2_EXTENSION_NAME);
    pthread_mutex_unlock(&strict.mutex);
    return enabled;
}

// Several instances or programs may share a report: its last line is the verdict on all of them.
static void add_earlier(size_t n[3]) {
    FILE *f = strict.report >= 0 && strict.path ? fopen(strict.path, "re") : NULL;
    char *line = NULL;
    size_t size = 0, errors, warnings, notes, earlier[3] = {0};
    while (f && getline(&line, &size, f) > 0)
        if (sscanf(line, "{\"errors\":%zu,\"warnings\":%zu,\"notes\":%zu}", &errors, &warnings,
                   &notes) == 3) {
            earlier[SIM_ERROR] = errors;
            earlier[SIM_WARNING] = warnings;
            earlier[SIM_NOTE] = notes;
        }
    for (int i = 0; i < 3; i++)
        n[i] += earlier[i];
    free(line);
    if (f)
        fclose(f);
}

static void sum_up(void) {
    size_t n[3] = {0};
    json_t *counts = json_array();
    for (size_t i = 0; i < strict.count; i++) {
        const struct finding *f = &strict.findings[i];
        n[f->level]++;
        json_array_append_new(counts,
                              json_pack("{s:s, s:s, s:I}", "function", f->function, "statement",
                                        f->statement, "count", (json_int_t)f->count));
        if (f->count > 1)
            fprintf(stderr, "antipode-sim: strict: %llu times: %s: %s\n",
                    (unsigned long long)f->count, f->function, f->statement);
    }
    if (strict.dropped)
        fprintf(stderr, "antipode-sim: strict: and %llu findings beyond the first %d\n",
                (unsigned long long)strict.dropped, MAX_FINDINGS);
    fprintf(stderr, "antipode-sim: strict: %zu errors, %zu warnings, %zu notes\n", n[SIM_ERROR],
            n[SIM_WARNING], n[SIM_NOTE]);
    write_line(json_pack("{s:o}", "counts", counts));
    add_earlier(n);
    write_line(json_pack("{s:I, s:I, s:I}", "errors", (json_int_t)n[SIM_ERROR], "warnings",
                         (json_int_t)n[SIM_WARNING], "notes", (json_int_t)n[SIM_NOTE]));
}

void sim_strict_finish(void) {
    if (!sim_strict_on || strict.process != getpid()) // a fork's child has nothing to say
        return;
    sim_strict_usage_finish();
    pthread_mutex_lock(&strict.mutex);
    sum_up();
    sim_strict_on = false;
    if (strict.report >= 0)
        close(strict.report);
    strict.report = -1;
    free(strict.path);
    strict.path = NULL;
    pthread_mutex_unlock(&strict.mutex);
}

// The process ends without xrDestroyInstance.
__attribute__((destructor)) static void finish_at_exit(void) {
    if (sim_strict_on && strict.process == getpid())
        sim_strict_report(SIM_WARNING, "xrDestroyInstance", "USE-instance-not-destroyed",
                          "the process ended with its instance alive");
    sim_strict_finish();
}
