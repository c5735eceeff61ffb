#include <stddef.h>

#include "sim_hmd/input/profiles_table.h"

// The interaction profiles that OpenXR 1.1 took into its core. The registry lists them.

#define TOUCH_BUTTONS                                                                              \
    BUTTON("/input/x/click", L), BUTTON("/input/x/touch", L), BUTTON("/input/y/click", L),         \
        BUTTON("/input/y/touch", L), BUTTON("/input/menu/click", L), BUTTON("/input/a/click", R),  \
        BUTTON("/input/a/touch", R), BUTTON("/input/b/click", R), BUTTON("/input/b/touch", R),     \
        BUTTON("/input/system/click", R)
#define TOUCH_COMMON                                                                               \
    TOUCH_BUTTONS, SQUEEZE("value", SIM_FLOAT), TRIGGER("value", SIM_FLOAT),                       \
        BUTTON("/input/trigger/touch", LR), STICK("/input/thumbstick", LR),                        \
        BUTTON("/input/thumbstick/click", LR), BUTTON("/input/thumbstick/touch", LR),              \
        BUTTON("/input/trigger/proximity", LR),                                                    \
        BUTTON("/input/thumb_resting_surfaces/proximity", LR), POSES, HAPTIC("/output/haptic")

const struct sim_component sim_vive_cosmos[] = {
    BUTTON("/input/x/click", L),
    BUTTON("/input/y/click", L),
    BUTTON("/input/menu/click", L),
    BUTTON("/input/a/click", R),
    BUTTON("/input/b/click", R),
    BUTTON("/input/system/click", R),
    BUTTON("/input/shoulder/click", LR),
    SQUEEZE("click", SIM_BOOL),
    TRIGGER("click", SIM_BOOL),
    TRIGGER("value", SIM_FLOAT),
    STICK("/input/thumbstick", LR),
    BUTTON("/input/thumbstick/click", LR),
    BUTTON("/input/thumbstick/touch", LR),
    POSES,
    HAPTIC("/output/haptic"),
    END,
};

const struct sim_component sim_vive_focus3[] = {
    BUTTON("/input/x/click", L),
    BUTTON("/input/y/click", L),
    BUTTON("/input/menu/click", L),
    BUTTON("/input/a/click", R),
    BUTTON("/input/b/click", R),
    BUTTON("/input/system/click", R),
    SQUEEZE("click", SIM_BOOL),
    BUTTON("/input/squeeze/touch", LR),
    SQUEEZE("value", SIM_FLOAT),
    TRIGGER("click", SIM_BOOL),
    BUTTON("/input/trigger/touch", LR),
    TRIGGER("value", SIM_FLOAT),
    STICK("/input/thumbstick", LR),
    BUTTON("/input/thumbstick/click", LR),
    BUTTON("/input/thumbstick/touch", LR),
    BUTTON("/input/thumbrest/touch", LR),
    POSES,
    HAPTIC("/output/haptic"),
    END,
};

const struct sim_component sim_odyssey[] = {
    BUTTON("/input/menu/click", LR),
    SQUEEZE("click", SIM_BOOL),
    TRIGGER("value", SIM_FLOAT),
    STICK("/input/thumbstick", LR),
    BUTTON("/input/thumbstick/click", LR),
    STICK("/input/trackpad", LR),
    BUTTON("/input/trackpad/click", LR),
    BUTTON("/input/trackpad/touch", LR),
    POSES,
    HAPTIC("/output/haptic"),
    END,
};

const struct sim_component sim_hp[] = {
    BUTTON("/input/x/click", L),
    BUTTON("/input/y/click", L),
    BUTTON("/input/a/click", R),
    BUTTON("/input/b/click", R),
    BUTTON("/input/menu/click", LR),
    SQUEEZE("value", SIM_FLOAT),
    TRIGGER("value", SIM_FLOAT),
    STICK("/input/thumbstick", LR),
    BUTTON("/input/thumbstick/click", LR),
    POSES,
    HAPTIC("/output/haptic"),
    END,
};

const struct sim_component sim_ml2[] = {
    BUTTON("/input/menu/click", LR),
    BUTTON("/input/home/click", LR),
    TRIGGER("click", SIM_BOOL),
    TRIGGER("value", SIM_FLOAT),
    STICK("/input/trackpad", LR),
    BUTTON("/input/trackpad/click", LR),
    AXIS("/input/trackpad/force", LR),
    BUTTON("/input/trackpad/touch", LR),
    POSES,
    BUTTON("/input/shoulder/click", LR),
    HAPTIC("/output/haptic"),
    END,
};

const struct sim_component sim_touch_pro[] = {
    TOUCH_COMMON,
    BUTTON("/input/thumbrest/touch", LR),
    AXIS("/input/thumbrest/force", LR),
    AXIS("/input/stylus/force", LR),
    AXIS("/input/trigger_curl/value", LR),
    AXIS("/input/trigger_slide/value", LR),
    HAPTIC("/output/haptic_trigger"),
    HAPTIC("/output/haptic_thumb"),
    END,
};

const struct sim_component sim_touch_plus[] = {
    TOUCH_COMMON,
    BUTTON("/input/thumbrest/touch", LR),
    AXIS("/input/trigger_curl/value", LR),
    AXIS("/input/trigger_slide/value", LR),
    AXIS("/input/trigger/force", LR),
    END,
};

const struct sim_component sim_touch_cv1[] = {
    TOUCH_COMMON,
    BUTTON("/input/thumbrest/touch", LR),
    END,
};

const struct sim_component sim_touch_rift_s[] = {
    TOUCH_COMMON,
    END,
};

const struct sim_component sim_touch_quest2[] = {
    TOUCH_COMMON,
    BUTTON("/input/thumbrest/touch", LR),
    END,
};

const struct sim_component sim_pico_neo3[] = {
    BUTTON("/input/x/click", L),
    BUTTON("/input/x/touch", L),
    BUTTON("/input/y/click", L),
    BUTTON("/input/y/touch", L),
    BUTTON("/input/a/click", R),
    BUTTON("/input/a/touch", R),
    BUTTON("/input/b/click", R),
    BUTTON("/input/b/touch", R),
    BUTTON("/input/system/click", LR),
    BUTTON("/input/menu/click", LR),
    SQUEEZE("click", SIM_BOOL),
    SQUEEZE("value", SIM_FLOAT),
    TRIGGER("click", SIM_BOOL),
    BUTTON("/input/trigger/touch", LR),
    TRIGGER("value", SIM_FLOAT),
    STICK("/input/thumbstick", LR),
    BUTTON("/input/thumbstick/click", LR),
    BUTTON("/input/thumbstick/touch", LR),
    POSES,
    HAPTIC("/output/haptic"),
    END,
};

const struct sim_component sim_pico4[] = {
    BUTTON("/input/x/click", L),
    BUTTON("/input/x/touch", L),
    BUTTON("/input/y/click", L),
    BUTTON("/input/menu/click", L),
    BUTTON("/input/y/touch", L),
    BUTTON("/input/a/click", R),
    BUTTON("/input/a/touch", R),
    BUTTON("/input/b/click", R),
    BUTTON("/input/b/touch", R),
    BUTTON("/input/system/click", LR),
    SQUEEZE("click", SIM_BOOL),
    SQUEEZE("value", SIM_FLOAT),
    TRIGGER("click", SIM_BOOL),
    BUTTON("/input/trigger/touch", LR),
    TRIGGER("value", SIM_FLOAT),
    STICK("/input/thumbstick", LR),
    BUTTON("/input/thumbstick/click", LR),
    BUTTON("/input/thumbstick/touch", LR),
    POSES,
    HAPTIC("/output/haptic"),
    END,
};

const struct sim_component sim_pico_g3[] = {
    TRIGGER("click", SIM_BOOL),
    TRIGGER("value", SIM_FLOAT),
    BUTTON("/input/menu/click", LR),
    POSES,
    {"/input/thumbstick", SIM_VEC2, SIM_REST, LR, 0},
    BUTTON("/input/thumbstick/click", LR),
    END,
};
