#ifndef ANTIPODE_BASE_STATUS_H
#define ANTIPODE_BASE_STATUS_H

// What every fallible call returns. The numbers are the program's exit statuses, so that an error
// that reaches main() needs no translation.
enum ap_status {
    AP_OK = 0,
    AP_DIFFERS = 1,     // finished, with reported errors or differences
    AP_USAGE = 2,       // the caller's arguments
    AP_INPUT = 3,       // a file, a stream, a number from outside
    AP_ENVIRONMENT = 4, // what the machine lacks: a device, a library, memory, disk space
};

enum { AP_ERROR_TEXT_MAX = 1024 };

// The sentence that goes with a status: where, what, and what to do about it; one line, no newline
// at its end. Fallible functions take it first and their outputs last; NULL is allowed; on success
// it is untouched, on failure the outputs are.
struct ap_error {
    char text[AP_ERROR_TEXT_MAX];
};

#if defined(__GNUC__)
#define AP_PRINTF(fmt, args) __attribute__((format(printf, fmt, args)))
#else
#define AP_PRINTF(fmt, args)
#endif

// Writes the sentence (cut at AP_ERROR_TEXT_MAX, control characters replaced by '?') and returns
// status, so that a failing function ends in `return ap_fail(err, AP_INPUT, "…")`. The arguments
// may point into err itself: `ap_fail(err, st, "%s: %s", path, err->text)`.
enum ap_status ap_fail(struct ap_error *err, enum ap_status status, const char *format, ...)
    AP_PRINTF(3, 4);

#endif
