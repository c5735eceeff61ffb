#ifndef ANTIPODE_SIM_HMD_STRICT_STRICT_H
#define ANTIPODE_SIM_HMD_STRICT_STRICT_H

#include <stdbool.h>
#include <stddef.h>

#include <openxr/openxr.h>

#include "src/base/status.h"

// A lint for OpenXR programs (settings "strict", docs/strict.md). It stands before the runtime:
// while it is on, xrGetInstanceProcAddr hands out a wrapper of each function that looks at the
// arguments, calls the function, and looks at what came back. While it is off there are no
// wrappers, and no call knows of it.
// The folder strict holds it:
//   functions.inc  the functions and their parameters, spec.c the structures member by member
//   calls.c        the wrappers
//   check.c        arguments against those two tables: the VUIDs; names.c, describe.c: in words
//   results.c      what an error code says of the program
//   usage.c        what is lawful and doubtful all the same; swapchains.c: of images
//   strict.c       findings: once per function and statement, standard error, the report
// Any thread.

enum sim_level {
    SIM_ERROR,   // breaks the specification
    SIM_WARNING, // lawful, and probably not what was meant
    SIM_NOTE,    // lawful; on another runtime it may matter
};

// Between sim_strict_start, behind xrCreateInstance, and sim_strict_finish, at the end of the
// instance or of the process. Without the runtime's lock.
extern _Atomic bool sim_strict_on;
void sim_strict_start(const char *report); // NULL: no report; the text is copied
void sim_strict_finish(void);

// For what only the runtime itself can see: `return sim_strict(XR_ERROR_X, "xrDoX", "VUID-…", "n is
// %u", n)` says so where the lint is on, and gives the result back.
XrResult sim_strict(XrResult result, const char *function, const char *statement,
                    const char *format, ...) AP_PRINTF(4, 5);

// The function itself, or the wrapper that stands before it. The runtime's lock is held.
PFN_xrVoidFunction sim_strict_wrap(const char *name, PFN_xrVoidFunction function);

// The program asked for a function that there is not, or of an extension that it did not enable.
void sim_strict_no_function(const char *name);

#endif
