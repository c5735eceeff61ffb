#include "src/app/runtime.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "src/base/file.h"

// First existing of "EXEDIR/candidate", malloc'ed.
static char *beside_program(const char *const *candidates) {
    char exe[4096];
    ssize_t n = readlink("/proc/self/exe", exe, sizeof exe - 1);
    if (n <= 0)
        return NULL;
    exe[n] = '\0';
    char *slash = strrchr(exe, '/');
    if (slash)
        *slash = '\0';
    for (; *candidates; candidates++) {
        char *path = ap_path_join(exe, *candidates);
        char *real = path ? realpath(path, NULL) : NULL;
        free(path);
        if (real)
            return real;
    }
    return NULL;
}

enum ap_status ap_runtime_manifest(struct ap_error *err, char **path) {
    static const char *const places[] = {"../../sim_hmd/openxr_antipode.json",
                                         "../share/openxr/1/openxr_antipode.json", NULL};
    char *found = beside_program(places);
    if (!found)
        return ap_fail(
            err, AP_ENVIRONMENT,
            "openxr_antipode.json, the simulated headset's manifest, is not where it was "
            "installed (share/openxr/1): run meson install again");
    *path = found;
    return AP_OK;
}

char *ap_shared_path(const char *name) {
    char built[256], installed[256];
    snprintf(built, sizeof built, "../device/%s", name);
    snprintf(installed, sizeof installed, "../share/antipode/%s", name);
    const char *const places[] = {built, installed, NULL};
    return beside_program(places);
}

static char *active_in(const char *dir, size_t len) {
    char path[4096];
    snprintf(path, sizeof path, "%.*s/openxr/1/active_runtime.json", (int)len, dir);
    return len > 0 && ap_file_exists(path) ? strdup(path) : NULL;
}

static char *active_in_list(const char *dirs) {
    for (const char *d = dirs; *d;) {
        size_t len = strcspn(d, ":");
        char *found = active_in(d, len);
        if (found)
            return found;
        d += len + (d[len] == ':');
    }
    return NULL;
}

// The order of the OpenXR loader's specification ("Runtime discovery" on Linux).
char *ap_runtime_configured(void) {
    const char *v = getenv("XR_RUNTIME_JSON");
    if (v && *v)
        return strdup(v);
    const char *home = getenv("HOME"), *config = getenv("XDG_CONFIG_HOME");
    char fallback[4096];
    snprintf(fallback, sizeof fallback, "%s/.config", home ? home : "");
    char *found = active_in_list(config && *config ? config : fallback);
    const char *dirs = getenv("XDG_CONFIG_DIRS");
    if (!found)
        found = active_in_list(dirs && *dirs ? dirs : "/etc/xdg");
    return found ? found : active_in_list("/usr/local/etc:/etc");
}

enum ap_status ap_runtime_use_simulated(struct ap_error *err, const char *settings_path) {
    char *manifest = NULL;
    enum ap_status st = ap_runtime_manifest(err, &manifest);
    if (st)
        return st;
    bool set =
        setenv("XR_RUNTIME_JSON", manifest, 1) == 0 &&
        (settings_path ? setenv("ANTIPODE_SIM", settings_path, 1) : unsetenv("ANTIPODE_SIM")) == 0;
    free(manifest);
    return set ? AP_OK : ap_fail(err, AP_ENVIRONMENT, "out of memory");
}
