#ifndef ANTIPODE_SIM_HMD_EXT_DEBUG_NAMES_H
#define ANTIPODE_SIM_HMD_EXT_DEBUG_NAMES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <openxr/openxr.h>

// What XR_EXT_debug_utils keeps: names of an instance's objects, labels of a session. Both are
// empty as zeros. The runtime's lock is held.

enum { SIM_MAX_NAMES = 65536, SIM_MAX_LABELS = 1024 };

struct sim_name {
    XrObjectType type;
    uint64_t handle;
    char *text;
};

struct sim_names {
    struct sim_name *at;
    uint32_t count, capacity;
};

// NULL or "" takes the name away. XR_ERROR_OUT_OF_MEMORY, XR_ERROR_LIMIT_REACHED.
XrResult sim_names_set(struct sim_names *names, XrObjectType type, uint64_t handle,
                       const char *text);
const char *sim_names_get(const struct sim_names *names, XrObjectType type,
                          uint64_t handle); // NULL: none
void sim_names_finish(struct sim_names *names);

// Regions, the oldest first; the last one may be a single label, which the next call takes away.
struct sim_labels {
    char *text[SIM_MAX_LABELS];
    uint32_t count;
    bool single;
};

// Of a region (single false) or a single one.
XrResult sim_labels_push(struct sim_labels *labels, const char *text, bool single);
void sim_labels_pop(struct sim_labels *labels); // the innermost region; none: nothing
void sim_labels_finish(struct sim_labels *labels);

#endif
