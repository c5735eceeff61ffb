#ifndef ANTIPODE_DEVICE_LOG_BYTE_STREAM_H
#define ANTIPODE_DEVICE_LOG_BYTE_STREAM_H

#include <stdbool.h>
#include <stddef.h>

#include "src/base/status.h"

// The bytes of a file or of standard input. What was packed by gzip or zstd (told by its first
// bytes, several packed files one after the other too) comes out unpacked. Memory does not grow
// with the file: 64 KiB, and what unpacking needs, at most 128 MiB (zstd's --long=27).

struct ap_unpacking;

struct ap_byte_stream {
    const char *name; // for messages; the caller's
    int fd;           // −1: closed
    bool has_begun;
    struct ap_unpacking *unpacking; // NULL: it is not packed
    unsigned char first[4];         // what was read to find that out
    size_t first_count, first_given;
};

// "-" is standard input. AP_INPUT where the file cannot be opened. Nothing is read yet. Close it in
// any case.
enum ap_status ap_byte_stream_open(struct ap_error *err, struct ap_byte_stream *stream,
                                   const char *path);

// At least one byte and at most `room`, or 0 at the end. Blocks on a pipe. AP_INPUT where the file
// cannot be read, or what is packed is broken or ends too early.
enum ap_status ap_byte_stream_read(struct ap_error *err, struct ap_byte_stream *stream,
                                   void *buffer, size_t room, size_t *count);

void ap_byte_stream_close(struct ap_byte_stream *stream);

#endif
