#ifndef ANTIPODE_TESTS_SIM_HMD_REPORT_H
#define ANTIPODE_TESTS_SIM_HMD_REPORT_H

#include "tests/sim_hmd/client.h"

// What the lint says of a test's program, by its report. Each statement is expected right after the
// call that it is about.

// Finds a function of the runtime, past the loader, and calls it.
#define RT(name) ((PFN_##name)(uintptr_t)client_proc(c->instance, #name))

extern char report_path[256];
extern int report_errors;     // of all instances since the settings were written
extern int report_statements; // as many were expected and came

void report_settings(void);
void report_start(struct client *c); // with these settings, until the session runs
// The instance goes, and with it the verdict comes: as many errors as were seen.
void report_stop(struct client *c);

// What the report says since the last look.
char *report_news(void);

// The news has a line of the function whose statement begins so.
void report_says(const char *file, int line, const char *function, const char *statement);
void report_says_nothing(const char *file, int line);

#define SAYS(function, statement) report_says(__FILE__, __LINE__, function, statement)
#define WRONG(result, call, function, statement)                                                   \
    do {                                                                                           \
        XR_IS(result, call);                                                                       \
        SAYS(function, statement);                                                                 \
    } while (0)
#define SAYS_NOTHING() report_says_nothing(__FILE__, __LINE__)

#endif
