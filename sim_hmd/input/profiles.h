#ifndef ANTIPODE_SIM_HMD_INPUT_PROFILES_H
#define ANTIPODE_SIM_HMD_INPUT_PROFILES_H

#include <stdbool.h>

// Interaction profiles: which input paths each kind of controller has (OpenXR 1.0, section 6.4),
// and what of a pose log stands behind them.

enum sim_top {
    SIM_TOP_LEFT,
    SIM_TOP_RIGHT,
    SIM_TOP_HEAD,
    SIM_TOP_GAMEPAD,
    SIM_TOP_TREADMILL,
    SIM_TOP_COUNT
};
extern const char *const sim_top_paths[SIM_TOP_COUNT];

enum sim_kind { SIM_BOOL, SIM_FLOAT, SIM_VEC2, SIM_POSE, SIM_HAPTIC };

// What a component reads. SIM_REST never moves.
enum sim_input { SIM_REST, SIM_TRIGGER, SIM_SQUEEZE, SIM_SELECT, SIM_GRIP, SIM_AIM, SIM_PALM };

// Not of OpenXR 1.0's core.
enum sim_needs { SIM_NEEDS_1_1 = 1, SIM_NEEDS_PALM = 2 };

struct sim_component {
    const char *path; // after the top level user path: "/input/trigger/value"; NULL ends the list
    enum sim_kind kind;
    enum sim_input input;
    unsigned tops;  // 1 << enum sim_top, of those that have it
    unsigned needs; // enum sim_needs: what the instance must have for it
};

struct sim_profile {
    const char *path;
    const char *name; // for people
    const struct sim_component *components;
    unsigned needs;
};

// In the order of preference: the first that the program suggested bindings for is the current one.
// NULL path ends the list.
extern const struct sim_profile sim_profiles[];

// −1: not a profile.
int sim_profile_find(const char *path);

bool sim_profile_has_top(int profile, int top);

// The component that a binding path names, in full or by its parent ("…/input/trigger"), where an
// action of the kind takes the one of the parent's components that suits it, if any does; NULL
// where the profile has none such.
const struct sim_component *sim_profile_component(int profile, const char *path,
                                                  enum sim_kind wanted, int *top);

// Buttons and levers stand for each other; all else only for its own kind (OpenXR 11.4).
bool sim_kind_suits(enum sim_kind component, enum sim_kind wanted);

#endif
