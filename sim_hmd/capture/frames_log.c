#include "sim_hmd/capture/frames_log.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "sim_hmd/capture/frames_line.h"
#include "sim_hmd/core/quiet_write.h"
#include "src/base/file.h"

struct sim_frames_log {
    const struct sim_settings *settings;
    char *path, *part;
    int fd;                // −1: closed
    bool begun, committed; // begun: the file is ours
    struct sim_line line;
};

static enum ap_status cannot(struct ap_error *err, const char *path) {
    return ap_fail(err, AP_ENVIRONMENT, "%s: cannot be written: %s", path, strerror(errno));
}

enum ap_status sim_frames_log_create(struct ap_error *err, const struct sim_settings *settings,
                                     struct sim_frames_log **log) {
    struct sim_frames_log *l = calloc(1, sizeof *l);
    if (!l)
        return ap_fail(err, AP_ENVIRONMENT, "out of memory");
    l->settings = settings;
    l->fd = -1;
    l->path = ap_path_join(settings->capture_dir, "frames.jsonl");
    l->part = ap_path_join(settings->capture_dir, "frames.jsonl.part");
    enum ap_status st = l->path && l->part ? AP_OK : ap_fail(err, AP_ENVIRONMENT, "out of memory");
    if (!st) {
        // What lies there is another run's, or a stranger's link.
        if ((unlink(l->path) != 0 && errno != ENOENT) || (unlink(l->part) != 0 && errno != ENOENT))
            st = cannot(err, l->path);
        else
            l->fd = open(l->part, O_WRONLY | O_CREAT | O_EXCL | O_APPEND | O_CLOEXEC, 0666);
        if (!st && l->fd < 0)
            st = cannot(err, l->part);
        l->begun = l->fd >= 0;
    }
    if (st)
        sim_frames_log_destroy(l);
    else
        *log = l;
    return st;
}

bool sim_frames_log_wants(const struct sim_frames_log *l, bool captured) {
    return l && l->fd >= 0 && (captured || l->settings->capture_log_all);
}

enum ap_status sim_frames_log_frame(struct ap_error *err, struct sim_frames_log *l,
                                    const struct sim_logged_frame *logged) {
    if (!sim_frames_log_wants(l, logged->captured))
        return AP_OK;
    sim_line_write(&l->line, l->settings, logged);
    if (l->line.failed) {
        l->line.failed = false;
        return ap_fail(err, AP_ENVIRONMENT, "%s: no memory for a frame's line", l->part);
    }
    return sim_write_quietly(l->fd, l->line.text, l->line.len) ? AP_OK : cannot(err, l->part);
}

enum ap_status sim_frames_log_commit(struct ap_error *err, struct sim_frames_log *l) {
    if (!l || l->fd < 0)
        return AP_OK;
    int failed = close(l->fd);
    l->fd = -1;
    l->committed = !failed && rename(l->part, l->path) == 0;
    return l->committed ? AP_OK : cannot(err, l->path);
}

void sim_frames_log_destroy(struct sim_frames_log *l) {
    if (!l)
        return;
    if (l->fd >= 0)
        close(l->fd);
    if (l->begun && !l->committed)
        unlink(l->part);
    free(l->line.text);
    free(l->path);
    free(l->part);
    free(l);
}
