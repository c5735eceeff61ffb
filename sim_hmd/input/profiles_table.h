#ifndef ANTIPODE_SIM_HMD_INPUT_PROFILES_TABLE_H
#define ANTIPODE_SIM_HMD_INPUT_PROFILES_TABLE_H

#include "sim_hmd/input/profiles.h"

// The words that the tables of interaction profiles are written in: profiles.c holds those of
// OpenXR 1.0, profiles_newer.c those that 1.1 added.

#define L (1u << SIM_TOP_LEFT)
#define R (1u << SIM_TOP_RIGHT)
#define LR (L | R)
#define HEAD (1u << SIM_TOP_HEAD)
#define PAD (1u << SIM_TOP_GAMEPAD)

#define BUTTON(path, tops)                                                                         \
    { path, SIM_BOOL, SIM_REST, tops, 0 }
#define AXIS(path, tops)                                                                           \
    { path, SIM_FLOAT, SIM_REST, tops, 0 }
#define STICK(path, tops)                                                                          \
    {path, SIM_VEC2, SIM_REST, tops, 0}, AXIS(path "/x", tops), AXIS(path "/y", tops)
#define TRIGGER(part, kind)                                                                        \
    { "/input/trigger/" part, kind, SIM_TRIGGER, LR, 0 }
#define SQUEEZE(part, kind)                                                                        \
    { "/input/squeeze/" part, kind, SIM_SQUEEZE, LR, 0 }
#define POSE(path, input, needs)                                                                   \
    { path, SIM_POSE, input, LR, needs }
#define POSES                                                                                      \
    POSE("/input/grip/pose", SIM_GRIP, 0), POSE("/input/aim/pose", SIM_AIM, 0),                    \
        POSE("/input/grip_surface/pose", SIM_PALM, SIM_NEEDS_1_1),                                 \
        POSE("/input/palm_ext/pose", SIM_PALM, SIM_NEEDS_PALM)
#define HAPTIC(path)                                                                               \
    { path, SIM_HAPTIC, SIM_REST, LR, 0 }
#define END                                                                                        \
    { NULL, SIM_BOOL, SIM_REST, 0, 0 }

// What sim_profiles takes from profiles_newer.c.
extern const struct sim_component sim_vive_cosmos[], sim_vive_focus3[], sim_odyssey[], sim_hp[],
    sim_ml2[], sim_touch_pro[], sim_touch_plus[], sim_touch_cv1[], sim_touch_rift_s[],
    sim_touch_quest2[], sim_pico_neo3[], sim_pico4[], sim_pico_g3[];

#endif
