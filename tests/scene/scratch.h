#ifndef ANTIPODE_TESTS_SCENE_SCRATCH_H
#define ANTIPODE_TESTS_SCENE_SCRATCH_H

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "src/base/file.h"

// A folder of its own for a test's files; a file's name in it is only valid until the next call.
struct scratch {
    char dir[64];
};

static inline int scratch_open(struct scratch *s) {
    strcpy(s->dir, "/tmp/antipode-scene-XXXXXX");
    return mkdtemp(s->dir) ? 0 : -1;
}

static inline const char *scratch_path(const struct scratch *s, const char *name) {
    static char path[256];
    snprintf(path, sizeof path, "%s/%s", s->dir, name);
    return path;
}

static inline const char *scratch_write(const struct scratch *s, const char *name,
                                        const void *bytes, size_t len) {
    const char *path = scratch_path(s, name);
    struct ap_error err = {""};
    if (ap_file_write(&err, path, bytes, len))
        fprintf(stderr, "%s\n", err.text);
    return path;
}

static inline void scratch_remove(const struct scratch *s, const char *const *names) {
    for (; *names; names++)
        unlink(scratch_path(s, *names));
    rmdir(s->dir);
}

#endif
