#include "src/base/file.h"

#include <errno.h>
#include <fcntl.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static enum ap_status no_memory(struct ap_error *err) {
    return ap_fail(err, AP_ENVIRONMENT, "out of memory");
}

// A hidden neighbour's name that nobody else has: the process and a count.
static char *part_name(const char *path) {
    static atomic_uint count;
    const char *slash = strrchr(path, '/');
    int dir_len = slash ? (int)(slash - path) + 1 : 0;
    size_t size = strlen(path) + 64;
    char *part = malloc(size);
    if (part)
        snprintf(part, size, "%.*s.%s.%ld-%u.part", dir_len, path, path + dir_len, (long)getpid(),
                 atomic_fetch_add(&count, 1));
    return part;
}

// O_EXCL: a stranger's link of that name is not followed. The umask decides who may read the file.
// A name that a killed process of the same number left behind is passed over.
static int open_part(const char *path, char **part) {
    int fd = -1;
    for (int tries = 0; tries < 100; tries++) {
        free(*part);
        *part = part_name(path);
        if (!*part)
            return -1;
        fd = open(*part, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
        if (fd >= 0 || errno != EEXIST)
            break;
    }
    return fd;
}

// A folder, a device, a pipe: a new name would put a file in its place, which nobody means.
static enum ap_status check_target(struct ap_error *err, const char *path) {
    size_t len = strlen(path);
    struct stat s;
    if (len == 0)
        return ap_fail(err, AP_ENVIRONMENT, "a file's name is empty");
    if (path[len - 1] == '/' || (stat(path, &s) == 0 && !S_ISREG(s.st_mode)))
        return ap_fail(err, AP_ENVIRONMENT, "%s: is no plain file and cannot be replaced", path);
    return AP_OK;
}

enum ap_status ap_outfile_open(struct ap_error *err, const char *path, struct ap_outfile *out) {
    if (check_target(err, path))
        return AP_ENVIRONMENT;
    struct ap_outfile file = {.path = strdup(path)};
    enum ap_status st = AP_OK;
    int fd = open_part(path, &file.part);
    if (!file.path || !file.part) {
        st = no_memory(err);
        goto out;
    }
    if (fd < 0) {
        st = ap_fail(err, AP_ENVIRONMENT, "%s: cannot be written: %s", path, strerror(errno));
        goto out;
    }
    file.stream = fdopen(fd, "wb");
    if (!file.stream) {
        st = no_memory(err);
        goto out;
    }
    *out = file;
    return AP_OK;
out:
    if (fd >= 0) {
        close(fd);
        unlink(file.part);
    }
    free(file.path);
    free(file.part);
    return st;
}

static void forget(struct ap_outfile *file) {
    free(file->path);
    free(file->part);
    *file = (struct ap_outfile){0};
}

enum ap_status ap_outfile_commit(struct ap_error *err, struct ap_outfile *file) {
    bool failed = ferror(file->stream) != 0;
    int why = errno;
    if (fflush(file->stream) != 0) {
        failed = true;
        why = errno;
    }
    if (fclose(file->stream) != 0 && !failed) {
        failed = true;
        why = errno;
    }
    if (!failed && rename(file->part, file->path) != 0) {
        failed = true;
        why = errno;
    }
    enum ap_status st = AP_OK;
    if (failed) {
        unlink(file->part);
        st = ap_fail(err, AP_ENVIRONMENT, "%s: cannot be written: %s", file->path,
                     why ? strerror(why) : "write error (is the disk full?)");
    }
    forget(file);
    return st;
}

void ap_outfile_abort(struct ap_outfile *file) {
    if (!file->stream)
        return;
    fclose(file->stream);
    unlink(file->part);
    forget(file);
}

enum ap_status ap_file_write(struct ap_error *err, const char *path, const void *bytes,
                             size_t len) {
    struct ap_outfile file;
    enum ap_status st = ap_outfile_open(err, path, &file);
    if (st)
        return st;
    fwrite(bytes, 1, len, file.stream);
    return ap_outfile_commit(err, &file);
}

enum ap_status ap_file_read(struct ap_error *err, const char *path, size_t max_len, char **bytes,
                            size_t *len) {
    FILE *f = fopen(path, "rb");
    if (!f)
        return ap_fail(err, AP_INPUT, "%s: cannot be read: %s", path, strerror(errno));
    enum ap_status st = AP_OK;
    size_t n = 0, room = 0;
    char *buffer = NULL;
    for (;;) {
        if (n + 1 >= room) {
            room = room ? room * 2 : 65536;
            char *more = realloc(buffer, room);
            if (!more) {
                st = no_memory(err);
                goto out;
            }
            buffer = more;
        }
        size_t got = fread(buffer + n, 1, room - n - 1, f);
        n += got;
        if (n > max_len) {
            st = ap_fail(err, AP_INPUT, "%s: larger than %zu bytes", path, max_len);
            goto out;
        }
        if (got == 0)
            break;
    }
    if (ferror(f)) {
        st = ap_fail(err, AP_INPUT, "%s: cannot be read: %s", path, strerror(errno));
        goto out;
    }
    buffer[n] = '\0';
    *bytes = buffer;
    *len = n;
    buffer = NULL;
out:
    free(buffer);
    fclose(f);
    return st;
}

enum ap_status ap_make_dirs(struct ap_error *err, const char *path) {
    char *p = strdup(path);
    if (!p)
        return no_memory(err);
    enum ap_status st = AP_OK;
    for (char *c = p + 1; st == AP_OK; c++) {
        if (*c != '/' && *c != '\0')
            continue;
        char kept = *c;
        *c = '\0';
        struct stat s;
        if (mkdir(p, 0777) != 0 && !(stat(p, &s) == 0 && S_ISDIR(s.st_mode)))
            st = ap_fail(err, AP_ENVIRONMENT, "%s: the folder cannot be made: %s", p,
                         strerror(errno));
        *c = kept;
        if (kept == '\0')
            break;
    }
    free(p);
    return st;
}

bool ap_file_exists(const char *path) {
    return access(path, F_OK) == 0;
}

char *ap_path_join(const char *dir, const char *name) {
    size_t n = strlen(dir);
    bool slash = n > 0 && dir[n - 1] == '/';
    size_t size = n + strlen(name) + 2;
    char *p = malloc(size);
    if (p)
        snprintf(p, size, "%s%s%s", dir, slash ? "" : "/", name);
    return p;
}
