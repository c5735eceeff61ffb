#include "sim_hmd/input/profiles.h"

#include <stddef.h>
#include <string.h>

#include "sim_hmd/input/profiles_table.h"

const char *const sim_top_paths[SIM_TOP_COUNT] = {"/user/hand/left", "/user/hand/right",
                                                  "/user/head", "/user/gamepad", "/user/treadmill"};

static const struct sim_component touch[] = {
    BUTTON("/input/x/click", L),
    BUTTON("/input/x/touch", L),
    BUTTON("/input/y/click", L),
    BUTTON("/input/y/touch", L),
    BUTTON("/input/menu/click", L),
    BUTTON("/input/a/click", R),
    BUTTON("/input/a/touch", R),
    BUTTON("/input/b/click", R),
    BUTTON("/input/b/touch", R),
    BUTTON("/input/system/click", R),
    {"/input/squeeze/value", SIM_FLOAT, SIM_SQUEEZE, LR, 0},
    {"/input/trigger/value", SIM_FLOAT, SIM_TRIGGER, LR, 0},
    BUTTON("/input/trigger/touch", LR),
    STICK("/input/thumbstick", LR),
    BUTTON("/input/thumbstick/click", LR),
    BUTTON("/input/thumbstick/touch", LR),
    BUTTON("/input/thumbrest/touch", LR),
    {"/input/trigger/proximity", SIM_BOOL, SIM_REST, LR, SIM_NEEDS_1_1},
    {"/input/thumb_resting_surfaces/proximity", SIM_BOOL, SIM_REST, LR, SIM_NEEDS_1_1},
    POSES,
    {"/output/haptic", SIM_HAPTIC, SIM_REST, LR, 0},
    END,
};

static const struct sim_component index_controller[] = {
    BUTTON("/input/system/click", LR),
    BUTTON("/input/system/touch", LR),
    BUTTON("/input/a/click", LR),
    BUTTON("/input/a/touch", LR),
    BUTTON("/input/b/click", LR),
    BUTTON("/input/b/touch", LR),
    {"/input/squeeze/value", SIM_FLOAT, SIM_SQUEEZE, LR, 0},
    AXIS("/input/squeeze/force", LR),
    {"/input/trigger/click", SIM_BOOL, SIM_TRIGGER, LR, 0},
    {"/input/trigger/value", SIM_FLOAT, SIM_TRIGGER, LR, 0},
    BUTTON("/input/trigger/touch", LR),
    STICK("/input/thumbstick", LR),
    BUTTON("/input/thumbstick/click", LR),
    BUTTON("/input/thumbstick/touch", LR),
    STICK("/input/trackpad", LR),
    AXIS("/input/trackpad/force", LR),
    BUTTON("/input/trackpad/touch", LR),
    POSES,
    {"/output/haptic", SIM_HAPTIC, SIM_REST, LR, 0},
    END,
};

static const struct sim_component motion[] = {
    BUTTON("/input/menu/click", LR),
    {"/input/squeeze/click", SIM_BOOL, SIM_SQUEEZE, LR, 0},
    {"/input/trigger/value", SIM_FLOAT, SIM_TRIGGER, LR, 0},
    STICK("/input/thumbstick", LR),
    BUTTON("/input/thumbstick/click", LR),
    STICK("/input/trackpad", LR),
    BUTTON("/input/trackpad/click", LR),
    BUTTON("/input/trackpad/touch", LR),
    POSES,
    {"/output/haptic", SIM_HAPTIC, SIM_REST, LR, 0},
    END,
};

static const struct sim_component vive[] = {
    BUTTON("/input/system/click", LR),
    {"/input/squeeze/click", SIM_BOOL, SIM_SQUEEZE, LR, 0},
    BUTTON("/input/menu/click", LR),
    {"/input/trigger/click", SIM_BOOL, SIM_TRIGGER, LR, 0},
    {"/input/trigger/value", SIM_FLOAT, SIM_TRIGGER, LR, 0},
    STICK("/input/trackpad", LR),
    BUTTON("/input/trackpad/click", LR),
    BUTTON("/input/trackpad/touch", LR),
    POSES,
    {"/output/haptic", SIM_HAPTIC, SIM_REST, LR, 0},
    END,
};

static const struct sim_component simple[] = {
    {"/input/select/click", SIM_BOOL, SIM_SELECT, LR, 0},
    BUTTON("/input/menu/click", LR),
    POSES,
    {"/output/haptic", SIM_HAPTIC, SIM_REST, LR, 0},
    END,
};

static const struct sim_component go[] = {
    BUTTON("/input/system/click", LR),
    {"/input/trigger/click", SIM_BOOL, SIM_TRIGGER, LR, 0},
    BUTTON("/input/back/click", LR),
    STICK("/input/trackpad", LR),
    BUTTON("/input/trackpad/click", LR),
    BUTTON("/input/trackpad/touch", LR),
    POSES,
    END,
};

static const struct sim_component daydream[] = {
    {"/input/select/click", SIM_BOOL, SIM_SELECT, LR, 0},
    STICK("/input/trackpad", LR),
    BUTTON("/input/trackpad/click", LR),
    BUTTON("/input/trackpad/touch", LR),
    POSES,
    END,
};

static const struct sim_component vive_pro[] = {
    BUTTON("/input/system/click", HEAD),
    BUTTON("/input/volume_up/click", HEAD),
    BUTTON("/input/volume_down/click", HEAD),
    BUTTON("/input/mute_mic/click", HEAD),
    END,
};

static const struct sim_component gamepad[] = {
    BUTTON("/input/menu/click", PAD),
    BUTTON("/input/view/click", PAD),
    BUTTON("/input/a/click", PAD),
    BUTTON("/input/b/click", PAD),
    BUTTON("/input/x/click", PAD),
    BUTTON("/input/y/click", PAD),
    BUTTON("/input/dpad_down/click", PAD),
    BUTTON("/input/dpad_right/click", PAD),
    BUTTON("/input/dpad_up/click", PAD),
    BUTTON("/input/dpad_left/click", PAD),
    BUTTON("/input/shoulder_left/click", PAD),
    BUTTON("/input/shoulder_right/click", PAD),
    BUTTON("/input/thumbstick_left/click", PAD),
    BUTTON("/input/thumbstick_right/click", PAD),
    AXIS("/input/trigger_left/value", PAD),
    AXIS("/input/trigger_right/value", PAD),
    STICK("/input/thumbstick_left", PAD),
    STICK("/input/thumbstick_right", PAD),
    {"/output/haptic_left", SIM_HAPTIC, SIM_REST, PAD, 0},
    {"/output/haptic_right", SIM_HAPTIC, SIM_REST, PAD, 0},
    {"/output/haptic_left_trigger", SIM_HAPTIC, SIM_REST, PAD, 0},
    {"/output/haptic_right_trigger", SIM_HAPTIC, SIM_REST, PAD, 0},
    END,
};

const struct sim_profile sim_profiles[] = {
    {"/interaction_profiles/oculus/touch_controller", "Touch controller", touch, 0},
    {"/interaction_profiles/valve/index_controller", "Index controller", index_controller, 0},
    {"/interaction_profiles/microsoft/motion_controller", "Motion controller", motion, 0},
    {"/interaction_profiles/htc/vive_controller", "Vive controller", vive, 0},
    {"/interaction_profiles/khr/simple_controller", "Simple controller", simple, 0},
    {"/interaction_profiles/oculus/go_controller", "Go controller", go, 0},
    {"/interaction_profiles/google/daydream_controller", "Daydream controller", daydream, 0},
    {"/interaction_profiles/htc/vive_pro", "Vive Pro", vive_pro, 0},
    {"/interaction_profiles/microsoft/xbox_controller", "Gamepad", gamepad, 0},
    {"/interaction_profiles/htc/vive_cosmos_controller", "Vive Cosmos controller", sim_vive_cosmos,
     SIM_NEEDS_1_1},
    {"/interaction_profiles/htc/vive_focus3_controller", "Vive Focus 3 controller", sim_vive_focus3,
     SIM_NEEDS_1_1},
    {"/interaction_profiles/samsung/odyssey_controller", "Odyssey controller", sim_odyssey,
     SIM_NEEDS_1_1},
    {"/interaction_profiles/hp/mixed_reality_controller", "HP Mixed Reality controller", sim_hp,
     SIM_NEEDS_1_1},
    {"/interaction_profiles/ml/ml2_controller", "Magic Leap 2 controller", sim_ml2, SIM_NEEDS_1_1},
    {"/interaction_profiles/meta/touch_pro_controller", "Touch Pro controller", sim_touch_pro,
     SIM_NEEDS_1_1},
    {"/interaction_profiles/meta/touch_plus_controller", "Touch Plus controller", sim_touch_plus,
     SIM_NEEDS_1_1},
    {"/interaction_profiles/meta/touch_controller_rift_cv1", "Rift CV1 controller", sim_touch_cv1,
     SIM_NEEDS_1_1},
    {"/interaction_profiles/meta/touch_controller_quest_1_rift_s", "Rift S controller",
     sim_touch_rift_s, SIM_NEEDS_1_1},
    {"/interaction_profiles/meta/touch_controller_quest_2", "Quest 2 controller", sim_touch_quest2,
     SIM_NEEDS_1_1},
    {"/interaction_profiles/bytedance/pico_neo3_controller", "PICO Neo3 controller", sim_pico_neo3,
     SIM_NEEDS_1_1},
    {"/interaction_profiles/bytedance/pico4_controller", "PICO 4 controller", sim_pico4,
     SIM_NEEDS_1_1},
    {"/interaction_profiles/bytedance/pico_g3_controller", "PICO G3 controller", sim_pico_g3,
     SIM_NEEDS_1_1},
    {NULL, NULL, NULL, 0},
};

int sim_profile_find(const char *path) {
    for (int i = 0; sim_profiles[i].path; i++)
        if (strcmp(sim_profiles[i].path, path) == 0)
            return i;
    return -1;
}

bool sim_profile_has_top(int profile, int top) {
    for (const struct sim_component *c = sim_profiles[profile].components; c->path; c++)
        if (c->tops & 1u << top)
            return true;
    return false;
}

bool sim_kind_suits(enum sim_kind component, enum sim_kind wanted) {
    bool scalar = component == SIM_BOOL || component == SIM_FLOAT;
    return component == wanted || (scalar && (wanted == SIM_BOOL || wanted == SIM_FLOAT));
}

// "/input/trigger" stands for one of the trigger's components. How well the component suits a path
// and what is wanted of it; 0: it is not named.
static int rank(const struct sim_component *c, const char *path, enum sim_kind wanted) {
    size_t n = strlen(path);
    if (strncmp(c->path, path, n) != 0 || !strchr(path + 1, '/'))
        return 0;
    bool suits = sim_kind_suits(c->kind, wanted);
    if (c->path[n] == '\0')
        return suits ? 6 : 2;
    if (c->path[n] != '/')
        return 0;
    if (!suits)
        return 1;
    const char *part = c->path + n + 1;
    if (c->kind == wanted && (strcmp(part, "click") == 0 || strcmp(part, "value") == 0))
        return 5;
    return strcmp(part, "click") == 0 || strcmp(part, "value") == 0 ? 4 : 3;
}

static const struct sim_component *find(const struct sim_component *c, const char *path, int top,
                                        enum sim_kind wanted) {
    const struct sim_component *best = NULL;
    int best_rank = 0;
    for (; c->path; c++) {
        int r = c->tops & 1u << top ? rank(c, path, wanted) : 0;
        if (r <= best_rank)
            continue;
        best = c;
        best_rank = r;
    }
    return best;
}

const struct sim_component *sim_profile_component(int profile, const char *path,
                                                  enum sim_kind wanted, int *top) {
    for (int t = 0; t < SIM_TOP_COUNT; t++) {
        size_t n = strlen(sim_top_paths[t]);
        if (strncmp(path, sim_top_paths[t], n) != 0 || path[n] != '/')
            continue;
        const struct sim_component *c = find(sim_profiles[profile].components, path + n, t, wanted);
        if (c)
            *top = t;
        return c;
    }
    return NULL;
}
