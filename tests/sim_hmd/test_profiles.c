#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <stdio.h>
#include <string.h>

#include "sim_hmd/input/profiles.h"

// The interaction profiles against the specification's lists (OpenXR 1.0, section 6.4), written
// down a second time: what is listed is there, and nothing else is.

#define STICK(name) name " " name "/x " name "/y "
#define PAD_CT STICK("trackpad") "trackpad/click trackpad/touch "
#define POSES "grip/pose aim/pose "

// Inputs by name; ">" begins an output.
static const struct {
    const char *profile, *both, *left, *right, *head, *gamepad;
} listed[] = {
    {"khr/simple_controller", "select/click menu/click " POSES ">haptic", "", "", "", ""},
    {"google/daydream_controller", "select/click " PAD_CT POSES, "", "", "", ""},
    {"htc/vive_controller",
     "system/click squeeze/click menu/click trigger/click trigger/value " PAD_CT POSES ">haptic",
     "", "", "", ""},
    {"htc/vive_pro", "", "", "", "system/click volume_up/click volume_down/click mute_mic/click",
     ""},
    {"microsoft/motion_controller",
     "menu/click squeeze/click trigger/value thumbstick/click " STICK("thumbstick") PAD_CT POSES
     ">haptic",
     "", "", "", ""},
    {"microsoft/xbox_controller", "", "", "", "",
     "menu/click view/click a/click b/click x/click y/click dpad_down/click dpad_right/click "
     "dpad_up/click dpad_left/click shoulder_left/click shoulder_right/click "
     "thumbstick_left/click thumbstick_right/click trigger_left/value trigger_right/value " STICK(
         "thumbstick_left") STICK("thumbstick_right") ">haptic_left >haptic_right "
                                                      ">haptic_left_trigger "
                                                      ">haptic_right_trigger"},
    {"oculus/go_controller", "system/click trigger/click back/click " PAD_CT POSES, "", "", "", ""},
    {"oculus/touch_controller",
     "squeeze/value trigger/value trigger/touch thumbstick/click thumbstick/touch "
     "thumbrest/touch " STICK("thumbstick") POSES ">haptic",
     "x/click x/touch y/click y/touch menu/click", "a/click a/touch b/click b/touch system/click",
     "", ""},
    {"valve/index_controller",
     "system/click system/touch a/click a/touch b/click b/touch squeeze/value squeeze/force "
     "trigger/click trigger/value trigger/touch thumbstick/click thumbstick/touch "
     "trackpad/force trackpad/touch " STICK("thumbstick") STICK("trackpad") POSES ">haptic",
     "", "", "", ""},
};
enum { LISTED = sizeof listed / sizeof *listed };

static bool in_list(const char *list, const char *word) {
    size_t n = strlen(word);
    for (const char *at = list; (at = strstr(at, word)); at += n)
        if ((at == list || at[-1] == ' ') && (at[n] == ' ' || at[n] == '\0'))
            return true;
    return false;
}

static bool is_listed(size_t i, int top, const char *word) {
    const char *own = top == SIM_TOP_LEFT      ? listed[i].left
                      : top == SIM_TOP_RIGHT   ? listed[i].right
                      : top == SIM_TOP_HEAD    ? listed[i].head
                      : top == SIM_TOP_GAMEPAD ? listed[i].gamepad
                                               : "";
    return in_list(own, word) || (top <= SIM_TOP_RIGHT && in_list(listed[i].both, word));
}

static enum sim_kind kind_of(const char *word) {
    const char *part = strrchr(word, '/');
    if (word[0] == '>')
        return SIM_HAPTIC;
    if (!part)
        return SIM_VEC2;
    if (strcmp(part, "/pose") == 0)
        return SIM_POSE;
    return strcmp(part, "/click") == 0 || strcmp(part, "/touch") == 0 ? SIM_BOOL : SIM_FLOAT;
}

// 1 where the profile has it.
static int check_word(size_t i, int top, const char *word) {
    char profile[128], path[160];
    snprintf(profile, sizeof profile, "/interaction_profiles/%s", listed[i].profile);
    int p = sim_profile_find(profile);
    assert_true(p >= 0);
    snprintf(path, sizeof path, "%s/%s/%s", sim_top_paths[top], word[0] == '>' ? "output" : "input",
             word + (word[0] == '>'));
    int t = -1;
    const struct sim_component *c = sim_profile_component(p, path, kind_of(word), &t);
    bool has = c && strcmp(c->path, path + strlen(sim_top_paths[top])) == 0;
    if (has != is_listed(i, top, word))
        fail_msg("%s %s: %s", profile, path, has ? "is not in the specification" : "is missing");
    if (has && (c->kind != kind_of(word) || t != top))
        fail_msg("%s %s: is of the wrong kind", profile, path);
    return has;
}

static int check_list(const char *list, size_t i, int top) {
    char copy[1024];
    int n = 0;
    snprintf(copy, sizeof copy, "%s", list);
    char *rest = NULL;
    for (char *word = strtok_r(copy, " ", &rest); word; word = strtok_r(NULL, " ", &rest))
        n += check_word(i, top, word);
    return n;
}

static void every_path_of_every_profile(void **state) {
    (void)state;
    int found = 0;
    for (size_t i = 0; i < LISTED; i++)
        for (int top = 0; top < SIM_TOP_COUNT; top++) {
            if (top <= SIM_TOP_RIGHT)
                found += check_list(listed[i].both, i, top);
            found += check_list(listed[i].left, i, top) + check_list(listed[i].right, i, top) +
                     check_list(listed[i].head, i, top) + check_list(listed[i].gamepad, i, top);
        }
    assert_int_equal(found, 214); // of nine profiles
}

static void no_profile_has_anothers_paths(void **state) {
    (void)state;
    for (size_t i = 0; i < LISTED; i++)
        for (size_t j = 0; j < LISTED; j++)
            for (int top = 0; top < SIM_TOP_COUNT; top++) {
                check_list(listed[j].both, i, top);
                check_list(listed[j].left, i, top);
                check_list(listed[j].right, i, top);
                check_list(listed[j].head, i, top);
                check_list(listed[j].gamepad, i, top);
            }
}

static void parents_are_taken_by_kind(void **state) {
    (void)state;
    static const struct {
        const char *profile, *path;
        enum sim_kind wanted;
        const char *component;
    } cases[] = {
        {"valve/index_controller", "/input/trigger", SIM_BOOL, "/input/trigger/click"},
        {"valve/index_controller", "/input/trigger", SIM_FLOAT, "/input/trigger/value"},
        {"oculus/touch_controller", "/input/trigger", SIM_BOOL, "/input/trigger/value"},
        {"oculus/touch_controller", "/input/thumbstick", SIM_VEC2, "/input/thumbstick"},
        {"oculus/touch_controller", "/input/thumbstick", SIM_BOOL, "/input/thumbstick/click"},
        {"oculus/touch_controller", "/input/grip", SIM_POSE, "/input/grip/pose"},
        {"htc/vive_controller", "/input/squeeze", SIM_FLOAT, "/input/squeeze/click"},
        {"htc/vive_controller", "/input/squeeze/click", SIM_POSE, "/input/squeeze/click"},
        {"htc/vive_controller", "/input/thumbstick", SIM_VEC2, NULL},
        {"htc/vive_controller", "/input", SIM_BOOL, NULL},
        {"htc/vive_controller", "/input/trig", SIM_BOOL, NULL},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char profile[128], path[160];
        snprintf(profile, sizeof profile, "/interaction_profiles/%s", cases[i].profile);
        snprintf(path, sizeof path, "/user/hand/left%s", cases[i].path);
        int top;
        const struct sim_component *c =
            sim_profile_component(sim_profile_find(profile), path, cases[i].wanted, &top);
        if (!cases[i].component)
            assert_null(c);
        else if (!c || strcmp(c->path, cases[i].component) != 0)
            fail_msg("%s %s: %s, expected %s", profile, path, c ? c->path : "nothing",
                     cases[i].component);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_path_of_every_profile),
        cmocka_unit_test(no_profile_has_anothers_paths),
        cmocka_unit_test(parents_are_taken_by_kind),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
