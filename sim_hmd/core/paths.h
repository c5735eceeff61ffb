#ifndef ANTIPODE_SIM_HMD_CORE_PATHS_H
#define ANTIPODE_SIM_HMD_CORE_PATHS_H

#include "sim_hmd/core/api.h"

// XrPath and its text.

struct sim_paths {
    char **text; // XrPath = place + 1
    uint32_t count, capacity;
};

bool sim_path_valid(const char *text);
XrResult sim_path_make(struct sim_paths *paths, const char *text, XrPath *path);
const char *sim_path_text(const struct sim_paths *paths, XrPath path); // NULL: unknown
int sim_path_top(const struct sim_paths *paths, XrPath path);          // enum sim_top; −1: none
void sim_paths_finish(struct sim_paths *paths);

#endif
