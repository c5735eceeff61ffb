#include "sim_hmd/ext/extensions.h"

#include <string.h>

#define PLAIN(name) [SIM_##name] = {"XR_" #name, XR_##name##_SPEC_VERSION, NULL},
#define WITH_FUNCTIONS(name)                                                                       \
    [SIM_##name] = {"XR_" #name, XR_##name##_SPEC_VERSION, sim_functions_##name},

const struct sim_extension sim_extensions[SIM_EXTENSION_COUNT] = {
    SIM_FUNCTION_EXTENSIONS(WITH_FUNCTIONS) SIM_PLAIN_EXTENSIONS(PLAIN)};

enum sim_extension_id sim_extension_find(const char *name) {
    int id = 0;
    while (id < SIM_EXTENSION_COUNT && strcmp(sim_extensions[id].name, name) != 0)
        id++;
    return (enum sim_extension_id)id;
}

PFN_xrVoidFunction sim_extension_function(const bool enabled[SIM_EXTENSION_COUNT],
                                          const char *name) {
    for (int id = 0; id < SIM_EXTENSION_COUNT; id++) {
        const struct sim_function *f = enabled[id] ? sim_extensions[id].functions : NULL;
        for (; f && f->name; f++)
            if (strcmp(f->name, name) == 0)
                return f->function;
    }
    return NULL;
}
