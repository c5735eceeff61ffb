#include "src/device/log/byte_stream.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "src/device/log/unpack.h"

enum { PACKED_BYTES = 1 << 16 };

// A file that is packed: what was read of it and not unpacked yet.
struct ap_unpacking {
    struct ap_unpacker *unpacker;
    size_t start, end;
    bool at_end;
    unsigned char bytes[PACKED_BYTES];
};

enum ap_status ap_byte_stream_open(struct ap_error *err, struct ap_byte_stream *stream,
                                   const char *path) {
    bool standard = strcmp(path, "-") == 0;
    *stream = (struct ap_byte_stream){.name = standard ? "standard input" : path, .fd = -1};
    stream->fd = standard ? STDIN_FILENO : open(path, O_RDONLY | O_CLOEXEC | O_NOCTTY);
    if (stream->fd < 0)
        return ap_fail(err, AP_INPUT, "%s: cannot open: %s", path, strerror(errno));
    return AP_OK;
}

static enum ap_status read_raw(struct ap_error *err, const struct ap_byte_stream *stream,
                               void *buffer, size_t room, size_t *count) {
    ssize_t n;
    do
        n = read(stream->fd, buffer, room);
    while (n < 0 && errno == EINTR);
    if (n < 0)
        return ap_fail(err, AP_INPUT, "%s: cannot read: %s", stream->name, strerror(errno));
    *count = (size_t)n;
    return AP_OK;
}

// The first bytes tell whether it is packed.
static enum ap_status begin(struct ap_error *err, struct ap_byte_stream *stream) {
    unsigned char first[4];
    size_t have = 0, n = 1;
    while (have < sizeof first && n > 0) {
        enum ap_status st = read_raw(err, stream, first + have, sizeof first - have, &n);
        if (st)
            return st;
        have += n;
    }
    stream->has_begun = true;
    enum ap_packing packing = ap_packing_of(first, have);
    if (packing == AP_PACKING_NONE) {
        memcpy(stream->first, first, have);
        stream->first_count = have;
        return AP_OK;
    }
    struct ap_unpacking *u = calloc(1, sizeof *u);
    if (u)
        u->unpacker = ap_unpacker_create(packing);
    if (!u || !u->unpacker) {
        free(u);
        return ap_fail(err, AP_ENVIRONMENT, "%s: out of memory for unpacking", stream->name);
    }
    memcpy(u->bytes, first, have);
    u->end = have;
    stream->unpacking = u;
    return AP_OK;
}

static enum ap_status read_packed(struct ap_error *err, struct ap_byte_stream *stream, void *buffer,
                                  size_t room, size_t *count) {
    struct ap_unpacking *u = stream->unpacking;
    for (;;) {
        if (u->start == u->end && !u->at_end) {
            u->start = u->end = 0;
            enum ap_status st = read_raw(err, stream, u->bytes, PACKED_BYTES, &u->end);
            if (st)
                return st;
            u->at_end = u->end == 0;
        }
        size_t taken = u->end - u->start, given = room;
        const char *why;
        if (!ap_unpacker_step(u->unpacker, u->bytes + u->start, &taken, buffer, &given, &why))
            return ap_fail(err, AP_INPUT, "%s: cannot unpack: %s", stream->name, why);
        u->start += taken;
        if (given) {
            *count = given;
            return AP_OK;
        }
        if (taken || !u->at_end)
            continue;
        if (!ap_unpacker_is_whole(u->unpacker))
            return ap_fail(err, AP_INPUT, "%s: cannot unpack: it ends too early", stream->name);
        *count = 0;
        return AP_OK;
    }
}

enum ap_status ap_byte_stream_read(struct ap_error *err, struct ap_byte_stream *stream,
                                   void *buffer, size_t room, size_t *count) {
    if (!stream->has_begun) {
        enum ap_status st = begin(err, stream);
        if (st)
            return st;
    }
    if (stream->unpacking)
        return read_packed(err, stream, buffer, room, count);
    size_t left = stream->first_count - stream->first_given;
    if (left == 0)
        return read_raw(err, stream, buffer, room, count);
    *count = left < room ? left : room;
    memcpy(buffer, stream->first + stream->first_given, *count);
    stream->first_given += *count;
    return AP_OK;
}

void ap_byte_stream_close(struct ap_byte_stream *stream) {
    if (stream->fd > STDIN_FILENO)
        close(stream->fd);
    stream->fd = -1;
    if (stream->unpacking)
        ap_unpacker_destroy(stream->unpacking->unpacker);
    free(stream->unpacking);
    stream->unpacking = NULL;
}
