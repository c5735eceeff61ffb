#include "src/device/log/line_reader.h"

#include <stdlib.h>
#include <string.h>

// Twice the longest line: one that lies across the end is moved to the front at most once per
// AP_LINE_MAX bytes read.
enum { BUFFER_BYTES = 2 * AP_LINE_MAX };

enum ap_status ap_line_reader_open(struct ap_error *err, struct ap_line_reader *reader,
                                   const char *path) {
    *reader = (struct ap_line_reader){.name = path, .bytes = {.fd = -1}};
    enum ap_status st = ap_byte_stream_open(err, &reader->bytes, path);
    reader->name = reader->bytes.name;
    if (st)
        return st;
    reader->buffer = malloc(BUFFER_BYTES);
    return reader->buffer ? AP_OK : ap_fail(err, AP_ENVIRONMENT, "%s: out of memory", reader->name);
}

static enum ap_status fill(struct ap_error *err, struct ap_line_reader *reader) {
    if (reader->start) {
        memmove(reader->buffer, reader->buffer + reader->start, reader->end - reader->start);
        reader->end -= reader->start;
        reader->start = 0;
    }
    size_t n = 0;
    enum ap_status st = ap_byte_stream_read(err, &reader->bytes, reader->buffer + reader->end,
                                            BUFFER_BYTES - reader->end, &n);
    reader->end += n;
    reader->at_end = !st && n == 0;
    return st;
}

static bool says_something(const char *bytes, size_t len) {
    for (size_t i = 0; i < len; i++)
        if (!strchr(" \t\r\n\xef\xbb\xbf", bytes[i]) || !bytes[i])
            return true;
    return false;
}

enum ap_status ap_line_reader_peek(struct ap_error *err, struct ap_line_reader *reader,
                                   const char **bytes, size_t *len) {
    size_t have = reader->end - reader->start;
    while (!reader->at_end && have < AP_LINE_MAX &&
           (have < 4 || !says_something(reader->buffer + reader->start, have))) {
        enum ap_status st = fill(err, reader);
        if (st)
            return st;
        have = reader->end - reader->start;
    }
    *bytes = reader->buffer + reader->start;
    *len = have < AP_LINE_MAX ? have : AP_LINE_MAX;
    return AP_OK;
}

// Room for at least one byte more and a NUL.
static bool make_room(char **bytes, size_t *room, size_t used) {
    if (*bytes && *room - used >= 2)
        return true;
    char *more = realloc(*bytes, 2 * *room);
    if (!more)
        return false;
    *bytes = more;
    *room *= 2;
    return true;
}

enum ap_status ap_line_reader_rest(struct ap_error *err, struct ap_line_reader *reader,
                                   size_t max_len, char **bytes, size_t *len) {
    size_t n = reader->end - reader->start, got = 1, room = BUFFER_BYTES;
    char *all = NULL;
    enum ap_status st = AP_OK;
    while (!st && got && n <= max_len) {
        if (!make_room(&all, &room, n)) {
            st = ap_fail(err, AP_ENVIRONMENT, "%s: out of memory", reader->name);
            break;
        }
        if (reader->start != reader->end)
            memcpy(all, reader->buffer + reader->start, n);
        reader->start = reader->end;
        st = ap_byte_stream_read(err, &reader->bytes, all + n, room - n - 1, &got);
        n += st ? 0 : got;
    }
    if (!st && n > max_len)
        st = ap_fail(err, AP_INPUT, "%s: larger than %zu bytes", reader->name, max_len);
    if (st) {
        free(all);
        return st;
    }
    reader->at_end = true;
    all[n] = '\0';
    *bytes = all;
    *len = n;
    return AP_OK;
}

// Drops the rest of a line that has outgrown the buffer's half.
static enum ap_status pass_over(struct ap_error *err, struct ap_line_reader *reader) {
    for (;;) {
        char *at = reader->buffer + reader->start;
        char *newline = memchr(at, '\n', reader->end - reader->start);
        reader->start = newline ? (size_t)(newline + 1 - reader->buffer) : reader->end;
        if (newline || reader->at_end)
            return AP_OK;
        enum ap_status st = fill(err, reader);
        if (st)
            return st;
    }
}

static void hand_out(struct ap_line_reader *reader, size_t raw, const char **line, size_t *len) {
    const char *text = reader->buffer + reader->start;
    reader->line_start = reader->start;
    reader->start += raw;
    if (raw && text[raw - 1] == '\n')
        raw--;
    if (raw && text[raw - 1] == '\r')
        raw--;
    if (reader->line == 1 && raw >= 3 && memcmp(text, "\xef\xbb\xbf", 3) == 0)
        text += 3, raw -= 3;
    *line = text;
    *len = raw;
}

enum ap_status ap_line_reader_next(struct ap_error *err, struct ap_line_reader *reader,
                                   enum ap_line_kind *kind, const char **line, size_t *len) {
    size_t searched = 0;
    // Only now: whoever stops at a line that is too long need not wait for its end, and a device
    // file has none.
    if (reader->inside_long_line) {
        enum ap_status st = pass_over(err, reader);
        if (st)
            return st;
        reader->inside_long_line = false;
    }
    for (;;) {
        char *at = reader->buffer + reader->start;
        size_t have = reader->end - reader->start;
        char *newline = memchr(at + searched, '\n', have - searched);
        size_t raw = newline ? (size_t)(newline + 1 - at) : have;
        // Two more for "\r\n".
        if (raw > AP_LINE_MAX + (newline ? 2 : 1)) {
            reader->line++;
            *kind = AP_LINE_TOO_LONG;
            reader->inside_long_line = true;
            return AP_OK;
        }
        if (newline || (reader->at_end && have)) {
            reader->line++;
            *kind = AP_LINE_TEXT;
            hand_out(reader, raw, line, len);
            return AP_OK;
        }
        if (reader->at_end) {
            *kind = AP_LINE_END;
            return AP_OK;
        }
        searched = have;
        enum ap_status st = fill(err, reader);
        if (st)
            return st;
    }
}

void ap_line_reader_unread(struct ap_line_reader *reader) {
    reader->start = reader->line_start;
    reader->line--;
}

void ap_line_reader_close(struct ap_line_reader *reader) {
    ap_byte_stream_close(&reader->bytes);
    free(reader->buffer);
    reader->buffer = NULL;
}
