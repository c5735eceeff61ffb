#ifndef ANTIPODE_BASE_LOG_H
#define ANTIPODE_BASE_LOG_H

#include "src/base/status.h"

// Messages for people, a line each on standard error: "antipode: warning: …". Any thread; a line is
// written whole. The runtime library, which lives in somebody else's process, sets its own prefix.
enum ap_log_level { AP_LOG_ERROR, AP_LOG_WARNING, AP_LOG_INFO };

void ap_log(enum ap_log_level level, const char *format, ...) AP_PRINTF(2, 3);

// Hears every line, without prefix and level, after it was written; in the
// thread that logs, whatever that holds. NULL: nobody. Any thread.
void ap_log_set_listener(void (*listener)(enum ap_log_level level, const char *text));

// A string that outlives the process's logging (a literal). Default "antipode".
void ap_log_set_prefix(const char *prefix);

#endif
