#ifndef ANTIPODE_DEVICE_LOG_LINE_READER_H
#define ANTIPODE_DEVICE_LOG_LINE_READER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "src/base/status.h"
#include "src/device/log/byte_stream.h"

// Lines of a file or of standard input, packed or not, through one buffer of fixed size.

enum { AP_LINE_MAX = 1 << 16 }; // bytes, without the line's end

enum ap_line_kind { AP_LINE_TEXT, AP_LINE_TOO_LONG, AP_LINE_END };

struct ap_line_reader {
    const char *name; // for messages; the caller's
    struct ap_byte_stream bytes;
    char *buffer;
    size_t start, end; // what is not yet handed out
    size_t line_start; // of the newest line
    int64_t line;      // its number, from 1
    bool at_end, inside_long_line;
};

// "-" is standard input. AP_INPUT where the file cannot be opened. Close it in any case.
enum ap_status ap_line_reader_open(struct ap_error *err, struct ap_line_reader *reader,
                                   const char *path);

// The next line without its "\n" or "\r\n", and without a byte order mark; valid until the next
// call. A line that is too long is passed over as a whole, by the call after. Blocks on a pipe
// until a line is there.
enum ap_status ap_line_reader_next(struct ap_error *err, struct ap_line_reader *reader,
                                   enum ap_line_kind *kind, const char **line, size_t *len);

// What comes next, without taking it: up to AP_LINE_MAX bytes, as many as it needs for one that is
// neither blank nor part of a byte order mark to be among them. Waits for it.
enum ap_status ap_line_reader_peek(struct ap_error *err, struct ap_line_reader *reader,
                                   const char **bytes, size_t *len);

// All that is left, malloc'ed and NUL-terminated beyond *len; the caller frees it. AP_INPUT where
// it is more than max_len.
enum ap_status ap_line_reader_rest(struct ap_error *err, struct ap_line_reader *reader,
                                   size_t max_len, char **bytes, size_t *len);

// The newest line once more. Only directly after ap_line_reader_next gave AP_LINE_TEXT.
void ap_line_reader_unread(struct ap_line_reader *reader);

void ap_line_reader_close(struct ap_line_reader *reader);

#endif
