#ifndef ANTIPODE_SIM_HMD_EXT_AUTOMATION_H
#define ANTIPODE_SIM_HMD_EXT_AUTOMATION_H

#include <stdbool.h>
#include <stdint.h>

#include "sim_hmd/input/profiles.h"
#include "src/device/timeline.h"
#include "src/geom/pose.h"

// Input devices as a program drives them through XR_EXT_conformance_automation. What it has not
// touched stays the headset's own.

enum sim_driven { SIM_OWN, SIM_SWITCHED_OFF, SIM_SWITCHED_ON };

struct sim_automated {
    int top;
    char path[64]; // "/input/trigger/value"
    float value[2];
    bool has_pose;
    enum ap_pose_state state;
    struct ap_pose stage_from_device;
};

struct sim_automation {
    enum sim_driven device[SIM_TOP_COUNT];
    int profile[SIM_TOP_COUNT]; // of those that are not the headset's own
    struct sim_automated *inputs;
    uint32_t count, capacity;
};

// NULL: the program has not set it.
const struct sim_automated *sim_automation_find(const struct sim_automation *automation, int top,
                                                const char *path);
void sim_automation_finish(struct sim_automation *automation);

#endif
