#include "src/base/status.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

enum ap_status ap_fail(struct ap_error *err, enum ap_status status, const char *format, ...) {
    if (!err)
        return status;
    char text[AP_ERROR_TEXT_MAX];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    for (char *c = text; *c; c++)
        if ((unsigned char)*c < 0x20 || *c == 0x7f)
            *c = '?';
    memcpy(err->text, text, sizeof text);
    return status;
}
