#ifndef ANTIPODE_SIM_HMD_CORE_INSTANCE_H
#define ANTIPODE_SIM_HMD_CORE_INSTANCE_H

#include "sim_hmd/core/api.h"
#include "sim_hmd/core/events.h"
#include "sim_hmd/core/paths.h"
#include "sim_hmd/core/settings.h"
#include "sim_hmd/ext/debug_names.h"
#include "sim_hmd/ext/extensions.h"
#include "sim_hmd/ext/messages.h"
#include "sim_hmd/input/profiles.h"

enum { SIM_SYSTEM_ID = 1 };

struct sim_session;
struct sim_source;
struct sim_suggestion; // input/actions.h

struct sim_instance {
    struct sim_object object;
    struct sim_source *source;
    struct sim_session *session;
    int64_t epoch_ns;
    uint32_t minor; // OpenXR 1.minor, as the program asked
    bool enabled[SIM_EXTENSION_COUNT];
    bool requirements_called;
    struct sim_settings settings;
    struct sim_paths paths;
    struct sim_names names; // XR_EXT_debug_utils
    bool chained;           // to its creation: a messenger that hears creation and destruction
    struct sim_messenger messenger;
    struct sim_suggestion *suggestions;
    uint32_t suggestion_count, suggestion_capacity;
    struct sim_events events;
};

struct sim_instance *sim_instance_get(XrInstance handle); // NULL: none

// What of the interaction profiles' tables the program may name.
static inline bool sim_instance_has(const struct sim_instance *instance, unsigned needs) {
    return (!(needs & SIM_NEEDS_1_1) || instance->minor >= 1) &&
           (!(needs & SIM_NEEDS_PALM) || instance->enabled[SIM_EXT_palm_pose]);
}

#endif
