#include "sim_hmd/ext/debug_names.h"

#include <stdlib.h>
#include <string.h>

static struct sim_name *find(const struct sim_names *names, XrObjectType type, uint64_t handle) {
    for (uint32_t i = 0; i < names->count; i++)
        if (names->at[i].handle == handle && names->at[i].type == type)
            return &names->at[i];
    return NULL;
}

static XrResult add(struct sim_names *names, struct sim_name name) {
    if (names->count == SIM_MAX_NAMES)
        return XR_ERROR_LIMIT_REACHED;
    if (names->count == names->capacity) {
        uint32_t capacity = names->capacity ? 2 * names->capacity : 16;
        struct sim_name *more = realloc(names->at, capacity * sizeof *more);
        if (!more)
            return XR_ERROR_OUT_OF_MEMORY;
        names->at = more;
        names->capacity = capacity;
    }
    names->at[names->count++] = name;
    return XR_SUCCESS;
}

XrResult sim_names_set(struct sim_names *names, XrObjectType type, uint64_t handle,
                       const char *text) {
    struct sim_name *old = find(names, type, handle);
    if (!text || !*text) {
        if (old) {
            free(old->text);
            *old = names->at[--names->count];
        }
        return XR_SUCCESS;
    }
    char *copy = strdup(text);
    if (!copy)
        return XR_ERROR_OUT_OF_MEMORY;
    if (old) {
        free(old->text);
        old->text = copy;
        return XR_SUCCESS;
    }
    XrResult result = add(names, (struct sim_name){type, handle, copy});
    if (result != XR_SUCCESS)
        free(copy);
    return result;
}

const char *sim_names_get(const struct sim_names *names, XrObjectType type, uint64_t handle) {
    const struct sim_name *name = find(names, type, handle);
    return name ? name->text : NULL;
}

void sim_names_finish(struct sim_names *names) {
    for (uint32_t i = 0; i < names->count; i++)
        free(names->at[i].text);
    free(names->at);
    *names = (struct sim_names){0};
}

static void drop_last(struct sim_labels *labels) {
    if (labels->count)
        free(labels->text[--labels->count]);
}

static void drop_single(struct sim_labels *labels) {
    if (labels->single)
        drop_last(labels);
    labels->single = false;
}

XrResult sim_labels_push(struct sim_labels *labels, const char *text, bool single) {
    if (labels->count - labels->single == SIM_MAX_LABELS)
        return XR_ERROR_LIMIT_REACHED;
    char *copy = strdup(text);
    if (!copy)
        return XR_ERROR_OUT_OF_MEMORY;
    drop_single(labels);
    labels->text[labels->count++] = copy;
    labels->single = single;
    return XR_SUCCESS;
}

void sim_labels_pop(struct sim_labels *labels) {
    drop_single(labels);
    drop_last(labels);
}

void sim_labels_finish(struct sim_labels *labels) {
    while (labels->count)
        drop_last(labels);
    labels->single = false;
}
