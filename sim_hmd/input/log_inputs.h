#ifndef ANTIPODE_SIM_HMD_INPUT_LOG_INPUTS_H
#define ANTIPODE_SIM_HMD_INPUT_LOG_INPUTS_H

#include <stdbool.h>
#include <stdint.h>

#include "sim_hmd/input/profiles.h"
#include "src/device/inputlog.h"

// What input logs mean for the controllers at hand (docs/input-logs.md). A log that was written for
// one kind of controller drives another as far as that has the same inputs: a component that the
// log does not name takes the same input's other component ("trigger/click" from "trigger/value").

// False where the logs say nothing of the component at this (log) time. value[1] is 0 but for
// SIM_VEC2.
bool sim_inputs_at(const struct ap_inputlog *log, const struct sim_component *component, int top,
                   int64_t t_ns, float value[2]);

// True where some component of the profile (of sim_profiles) listens to the channel.
bool sim_inputs_heard(const struct ap_inputlog *log, int channel, int profile);

#endif
