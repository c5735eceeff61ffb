#include "src/base/log.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

static const char *prefix = "antipode";

void ap_log_set_prefix(const char *p) {
    prefix = p;
}

static void (*_Atomic listener)(enum ap_log_level level, const char *text);

void ap_log_set_listener(void (*l)(enum ap_log_level level, const char *text)) {
    listener = l;
}

void ap_log(enum ap_log_level level, const char *format, ...) {
    static const char *const names[] = {"error: ", "warning: ", ""};
    char line[AP_ERROR_TEXT_MAX + 64];
    int n = snprintf(line, sizeof line - 1, "%s: %s", prefix, names[level]);
    if (n < 0)
        return;
    va_list args;
    va_start(args, format);
    int m = vsnprintf(line + n, sizeof line - 1 - (size_t)n, format, args);
    va_end(args);
    if (m < 0)
        return;
    size_t len = strlen(line);
    line[len] = '\n';
    // One write, so that lines from several threads and processes do not mix.
    fwrite(line, 1, len + 1, stderr);
    void (*heard)(enum ap_log_level level, const char *text) = listener;
    line[len] = '\0';
    if (heard)
        heard(level, line + n);
}
