#include "sim_hmd/input/log_inputs.h"

#include <stdio.h>
#include <string.h>

static const char *const devices[SIM_TOP_COUNT] = {"left", "right", "head", "gamepad", "treadmill"};

// Where a lever counts as pressed, as in actions.c.
static const float PRESSED = 0.5f;

// What else of the same input a component may take its values from, in the order of preference.
// "" is the input itself: "/input/thumbstick", or "/input/a" for short.
static const struct substitute {
    const char *component, *from;
    int axis;     // of the channel's two
    bool pressed; // as a button
} substitutes[] = {
    {"x", "", 0, false},          {"y", "", 1, false},         {"value", "", 0, false},
    {"value", "click", 0, false}, {"click", "value", 0, true}, {"click", "", 0, true},
};

enum { SUBSTITUTE_COUNT = sizeof substitutes / sizeof *substitutes, CANDIDATES_MAX = 8 };

struct candidate {
    int channel;
    int axis;
    bool pressed;
};

// "/input/trigger/value": the length of "/input/trigger", and "value"; "" where there is none.
static int split(const char *path, const char **component) {
    const char *input = strchr(path + 1, '/');
    const char *end = input ? strchr(input + 1, '/') : NULL;
    *component = end ? end + 1 : "";
    return (int)(end ? (size_t)(end - path) : strlen(path));
}

static int add(const struct ap_inputlog *log, int top, const char *path, int axis, bool pressed,
               struct candidate *list, int n) {
    int channel = ap_inputlog_find(log, devices[top], path);
    if (channel < 0)
        return n;
    list[n] = (struct candidate){channel, axis, pressed};
    return n + 1;
}

// The channels behind a component, best first.
static int candidates(const struct ap_inputlog *log, const char *path, int top,
                      struct candidate list[CANDIDATES_MAX]) {
    const char *component;
    int input_len = split(path, &component), n = add(log, top, path, 0, false, list, 0);
    for (int i = 0; i < SUBSTITUTE_COUNT; i++) {
        const struct substitute *s = &substitutes[i];
        if (strcmp(s->component, component) != 0)
            continue;
        char from[2 * AP_INPUT_PATH_MAX];
        snprintf(from, sizeof from, "%.*s%s%s", input_len, path, s->from[0] ? "/" : "", s->from);
        n = add(log, top, from, s->axis, s->pressed, list, n);
    }
    // What a simple controller selects with is a trigger, here as in the pose logs.
    if (strcmp(path, "/input/select/click") == 0)
        n += candidates(log, "/input/trigger/click", top, list + n);
    else if (strcmp(path, "/input/trigger/value") == 0 || strcmp(path, "/input/trigger/click") == 0)
        n = add(log, top, "/input/select/click", 0, false, list, n);
    return n;
}

static bool scalar_at(const struct ap_inputlog *log, const char *path, int top, int64_t t_ns,
                      float *value) {
    struct candidate list[CANDIDATES_MAX];
    int n = candidates(log, path, top, list);
    for (int i = 0; i < n; i++) {
        float v[2];
        if (!ap_inputlog_at(log, list[i].channel, t_ns, v))
            continue;
        *value = list[i].pressed ? (float)(v[list[i].axis] >= PRESSED) : v[list[i].axis];
        return true;
    }
    return false;
}

static void axis_path(char path[2 * AP_INPUT_PATH_MAX], const char *stick, const char *axis) {
    snprintf(path, 2 * AP_INPUT_PATH_MAX, "%s/%s", stick, axis);
}

bool sim_inputs_at(const struct ap_inputlog *log, const struct sim_component *component, int top,
                   int64_t t_ns, float value[2]) {
    value[0] = value[1] = 0;
    if (component->kind != SIM_VEC2)
        return scalar_at(log, component->path, top, t_ns, value);
    int whole = ap_inputlog_find(log, devices[top], component->path);
    if (whole >= 0 && ap_inputlog_at(log, whole, t_ns, value))
        return true;
    char path[2 * AP_INPUT_PATH_MAX];
    axis_path(path, component->path, "x");
    bool x = scalar_at(log, path, top, t_ns, &value[0]);
    axis_path(path, component->path, "y");
    return scalar_at(log, path, top, t_ns, &value[1]) || x;
}

bool sim_inputs_heard(const struct ap_inputlog *log, int channel, int profile) {
    const char *device = ap_inputlog_channel(log, channel).device;
    for (const struct sim_component *c = sim_profiles[profile].components; c->path; c++)
        for (int top = 0; top < SIM_TOP_COUNT; top++) {
            struct candidate list[CANDIDATES_MAX];
            if (!(c->tops & 1u << top) || strcmp(devices[top], device) != 0)
                continue;
            int n = candidates(log, c->path, top, list);
            for (int i = 0; i < n; i++)
                if (list[i].channel == channel)
                    return true;
        }
    return false;
}
