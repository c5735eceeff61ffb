#include <dirent.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "src/app/sim.h"
#include "src/base/file.h"

// "000030-left.png", "000030-layer0-right.pam"…: what the simulated headset writes.
static bool is_picture(const char *name) {
    size_t digits = strspn(name, "0123456789");
    return digits >= 6 && name[digits] == '-' && strchr(name, '.') != NULL;
}

static bool is_ours(const char *name) {
    return is_picture(name) || strcmp(name, "frames.jsonl") == 0 ||
           strcmp(name, "frames.jsonl.part") == 0 || strcmp(name, "frames.jsonl.part") == 0 ||
           strcmp(name, "strict.jsonl") == 0 || strcmp(name, "sim.json") == 0;
}

// How many such files the folder has; 0 where there is no folder.
static size_t count_files(const char *dir, bool (*wanted)(const char *name), bool remove_them) {
    size_t n = 0;
    DIR *d = opendir(dir);
    for (struct dirent *e = d ? readdir(d) : NULL; e; e = readdir(d)) {
        if (!wanted(e->d_name))
            continue;
        n++;
        char *path = remove_them ? ap_path_join(dir, e->d_name) : NULL;
        if (path)
            unlink(path);
        free(path);
    }
    if (d)
        closedir(d);
    return n;
}

enum ap_status ap_sim_capture_prepare(struct ap_error *err, const struct ap_sim_options *options) {
    const char *dir = options->capture;
    if (count_files(dir, is_ours, options->force) > 0 && !options->force)
        return ap_fail(err, AP_USAGE,
                       "%s holds a capture already: give another --capture, or --force to replace "
                       "it",
                       dir);
    return ap_make_dirs(err, dir);
}

bool ap_sim_capture_is_empty(const char *dir) {
    return count_files(dir, is_picture, false) == 0;
}
