#include "src/device/line_reader.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

// Twice the longest line: one that lies across the end is moved to the front at most once per
// AP_LINE_MAX bytes read.
enum { BUFFER_BYTES = 2 * AP_LINE_MAX };

enum ap_status ap_line_reader_open(struct ap_error *err, struct ap_line_reader *reader,
                                   const char *path) {
    bool standard = strcmp(path, "-") == 0;
    *reader = (struct ap_line_reader){.name = standard ? "standard input" : path, .fd = -1};
    reader->buffer = malloc(BUFFER_BYTES);
    if (!reader->buffer)
        return ap_fail(err, AP_ENVIRONMENT, "%s: out of memory", reader->name);
    reader->fd = standard ? STDIN_FILENO : open(path, O_RDONLY | O_CLOEXEC | O_NOCTTY);
    if (reader->fd < 0)
        return ap_fail(err, AP_INPUT, "%s: cannot open: %s", path, strerror(errno));
    return AP_OK;
}

static enum ap_status fill(struct ap_error *err, struct ap_line_reader *reader) {
    if (reader->start) {
        memmove(reader->buffer, reader->buffer + reader->start, reader->end - reader->start);
        reader->end -= reader->start;
        reader->start = 0;
    }
    ssize_t n;
    do
        n = read(reader->fd, reader->buffer + reader->end, BUFFER_BYTES - reader->end);
    while (n < 0 && errno == EINTR);
    if (n < 0)
        return ap_fail(err, AP_INPUT, "%s: cannot read: %s", reader->name, strerror(errno));
    reader->end += (size_t)n;
    reader->at_end = n == 0;
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
    for (;;) {
        char *at = reader->buffer + reader->start;
        size_t have = reader->end - reader->start;
        char *newline = memchr(at + searched, '\n', have - searched);
        size_t raw = newline ? (size_t)(newline + 1 - at) : have;
        // Two more for "\r\n".
        if (raw > AP_LINE_MAX + (newline ? 2 : 1)) {
            reader->line++;
            *kind = AP_LINE_TOO_LONG;
            return pass_over(err, reader);
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
    if (reader->fd > STDIN_FILENO)
        close(reader->fd);
    reader->fd = -1;
    free(reader->buffer);
    reader->buffer = NULL;
}
