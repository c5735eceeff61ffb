#ifndef ANTIPODE_BASE_FILE_H
#define ANTIPODE_BASE_FILE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

#include "src/base/status.h"

// A file being written; different files from different threads at once. The bytes go to a hidden
// neighbour of `path` (".NAME.PID-COUNT.part"); only ap_outfile_commit gives them their final name,
// so nobody ever sees half a file there.
struct ap_outfile {
    FILE *stream; // write here; errors are collected and reported by commit
    char *path;
    char *part;
};

// AP_ENVIRONMENT where the folder cannot be written or the path is there and no plain file. On
// success the caller owes one commit or abort.
enum ap_status ap_outfile_open(struct ap_error *err, const char *path, struct ap_outfile *out);

// Flushes, closes and renames. On any failure (a full disk…) the part is removed, AP_ENVIRONMENT.
// Either way the outfile is finished.
enum ap_status ap_outfile_commit(struct ap_error *err, struct ap_outfile *file);

// Drops what was written. Accepts a zeroed or finished outfile.
void ap_outfile_abort(struct ap_outfile *file);

// Open, write all, commit.
enum ap_status ap_file_write(struct ap_error *err, const char *path, const void *bytes, size_t len);

// Reads a whole file of at most max_len bytes; *bytes is malloc'ed, NUL-terminated beyond *len, the
// caller frees it. AP_INPUT where it cannot be read or is larger.
enum ap_status ap_file_read(struct ap_error *err, const char *path, size_t max_len, char **bytes,
                            size_t *len);

// mkdir -p. AP_ENVIRONMENT.
enum ap_status ap_make_dirs(struct ap_error *err, const char *path);

bool ap_file_exists(const char *path);

// "dir/name", malloc'ed; NULL without memory.
char *ap_path_join(const char *dir, const char *name);

#endif
