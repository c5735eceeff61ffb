#include <stdlib.h>
#include <string.h>

#include "sim_hmd/core/paths.h"
#include "sim_hmd/input/profiles.h"

static bool path_char(char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-' || c == '_' || c == '.';
}

// OpenXR 1.0, 6.2 "Well-formed path strings": "/name/name", no empty name, none of dots only.
bool sim_path_valid(const char *text) {
    size_t len = strnlen(text, XR_MAX_PATH_LENGTH);
    if (len < 2 || len >= XR_MAX_PATH_LENGTH || text[0] != '/')
        return false;
    for (const char *name = text; *name;) {
        name++; // the slash
        size_t n = strcspn(name, "/");
        bool other_than_dots = false;
        for (size_t i = 0; i < n; i++) {
            if (!path_char(name[i]))
                return false;
            other_than_dots |= name[i] != '.';
        }
        if (!other_than_dots)
            return false;
        name += n;
    }
    return true;
}

XrResult sim_path_make(struct sim_paths *paths, const char *text, XrPath *path) {
    if (!sim_path_valid(text))
        return XR_ERROR_PATH_FORMAT_INVALID;
    for (uint32_t i = 0; i < paths->count; i++)
        if (strcmp(paths->text[i], text) == 0) {
            *path = i + 1;
            return XR_SUCCESS;
        }
    if (paths->count == paths->capacity) {
        uint32_t capacity = paths->capacity ? 2 * paths->capacity : 64;
        char **bigger = realloc(paths->text, capacity * sizeof *bigger);
        if (!bigger)
            return XR_ERROR_OUT_OF_MEMORY;
        paths->text = bigger;
        paths->capacity = capacity;
    }
    char *copy = strdup(text);
    if (!copy)
        return XR_ERROR_OUT_OF_MEMORY;
    paths->text[paths->count++] = copy;
    *path = paths->count;
    return XR_SUCCESS;
}

const char *sim_path_text(const struct sim_paths *paths, XrPath path) {
    return path >= 1 && path <= paths->count ? paths->text[path - 1] : NULL;
}

int sim_path_top(const struct sim_paths *paths, XrPath path) {
    const char *text = sim_path_text(paths, path);
    for (int t = 0; text && t < SIM_TOP_COUNT; t++)
        if (strcmp(text, sim_top_paths[t]) == 0)
            return t;
    return -1;
}

void sim_paths_finish(struct sim_paths *paths) {
    for (uint32_t i = 0; i < paths->count; i++)
        free(paths->text[i]);
    free(paths->text);
}
