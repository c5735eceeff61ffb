#include "src/device/log/poselog_argument.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "src/device/log/decimal.h"

static bool is_word_byte(char c, bool first) {
    bool letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
    return letter || (!first && ((c >= '0' && c <= '9') || c == '-'));
}

size_t ap_role_length(const char *argument) {
    size_t n = 0;
    while (is_word_byte(argument[n], n == 0))
        n++;
    return n > 0 && argument[n] == '=' ? n + 1 : 0;
}

static bool is(struct ap_field f, const char *word) {
    return f.len == strlen(word) && memcmp(f.text, word, f.len) == 0;
}

static bool one_of(struct ap_field f, const char *no, const char *yes, bool *value) {
    if (!is(f, no) && !is(f, yes))
        return false;
    *value = is(f, yes);
    return true;
}

static bool positive(struct ap_field f, double *value) {
    double v;
    if (!ap_decimal_double(f.text, f.len, &v) || !(v >= 1e-9 && v <= 1e9))
        return false;
    *value = v;
    return true;
}

static bool take_offset(struct ap_log_argument *a, struct ap_field f) {
    return ap_decimal_seconds_ns(f.text, f.len, &a->offset_ns);
}

static bool take_time_scale(struct ap_log_argument *a, struct ap_field f) {
    return positive(f, &a->time_scale);
}

static bool take_scale(struct ap_log_argument *a, struct ap_field f) {
    return positive(f, &a->scale_m);
}

static bool take_axes(struct ap_log_argument *a, struct ap_field f) {
    return ap_axes_parse(f.text, f.len, &a->axes);
}

// What left-handed worlds with +y up have: z forward.
static bool take_hand(struct ap_log_argument *a, struct ap_field f) {
    bool left = false;
    if (!one_of(f, "right", "left", &left))
        return false;
    return ap_axes_parse(left ? "xy-z" : "xyz", left ? 4 : 3, &a->axes);
}

static bool take_up(struct ap_log_argument *a, struct ap_field f) {
    a->has_up = true;
    return one_of(f, "y", "z", &a->z_up);
}

static bool take_frame(struct ap_log_argument *a, struct ap_field f) {
    a->has_frame = true;
    return one_of(f, "head", "optical", &a->optical);
}

static bool take_invert(struct ap_log_argument *a, struct ap_field f) {
    return one_of(f, "no", "yes", &a->invert);
}

static const struct key {
    const char *name, *expected;
    bool (*take)(struct ap_log_argument *argument, struct ap_field value);
} keys[] = {
    {"offset", "seconds, as in offset=-0.25", take_offset},
    {"time-scale", "a factor from 1e-9 to 1e9, as in time-scale=0.001", take_time_scale},
    {"scale", "metres of a unit from 1e-9 to 1e9, as in scale=0.01", take_scale},
    {"axes", "its axes that are our x, y and z, as in axes=xz-y", take_axes},
    {"hand", "left or right", take_hand},
    {"up", "y or z", take_up},
    {"frame", "head or optical", take_frame},
    {"invert", "yes or no", take_invert},
};

enum { KEYS = sizeof keys / sizeof *keys };

static const struct key *key_of(struct ap_field option) {
    const char *equals = memchr(option.text, '=', option.len);
    struct ap_field name = {option.text, equals ? (size_t)(equals - option.text) : 0};
    for (int i = 0; i < KEYS; i++)
        if (is(name, keys[i].name))
            return &keys[i];
    return NULL;
}

// Where the file's name ends. From the back: options, as long as there are any; an empty one ends
// them.
static size_t file_end(const char *argument, size_t role) {
    size_t end = strlen(argument);
    for (;;) {
        size_t comma = end;
        while (comma > role && argument[comma - 1] != ',')
            comma--;
        if (comma == role)
            return end;
        struct ap_field option = {argument + comma, end - comma};
        if (option.len == 0)
            return comma - 1;
        if (!key_of(option))
            return end;
        end = comma - 1;
    }
}

static enum ap_status take_options(struct ap_error *err, const char *argument, const char *at,
                                   struct ap_log_argument *out) {
    for (const char *end; *at; at = *end ? end + 1 : end) {
        end = strchr(at, ',') ? strchr(at, ',') : at + strlen(at);
        struct ap_field option = {at, (size_t)(end - at)};
        const struct key *key = option.len ? key_of(option) : NULL;
        if (!key)
            continue;
        size_t name = strlen(key->name) + 1;
        struct ap_field value = {at + name, option.len - name};
        if (!key->take(out, value))
            return ap_fail(err, AP_USAGE, "'%s': %s: expected %s", argument, key->name,
                           key->expected);
    }
    return AP_OK;
}

enum ap_status ap_log_argument_parse(struct ap_error *err, const char *argument,
                                     struct ap_log_argument *out) {
    struct ap_log_argument a = {.time_scale = 1};
    size_t role = ap_role_length(argument), end = file_end(argument, role), len = end - role;
    if (role)
        a.role = (struct ap_field){argument, role - 1};
    if (len == 0)
        return ap_fail(err, AP_USAGE, "'%s': expected a file name, as in left=hand.csv", argument);
    if (a.role.len >= AP_LOG_DEVICE_NAME_MAX)
        return ap_fail(err, AP_USAGE, "'%s': expected a device name of at most %d bytes", argument,
                       AP_LOG_DEVICE_NAME_MAX - 1);
    if (len >= sizeof a.path)
        return ap_fail(err, AP_USAGE, "'%s': expected a file name of at most %zu bytes", argument,
                       sizeof a.path - 1);
    memcpy(a.path, argument + role, len);
    enum ap_status st = take_options(err, argument, argument + end, &a);
    if (!st)
        *out = a;
    return st;
}

bool ap_log_argument_is_stdin(const char *argument) {
    size_t role = ap_role_length(argument);
    return file_end(argument, role) - role == 1 && argument[role] == '-';
}

char *ap_log_argument_in(const char *argument, const char *folder) {
    size_t role = ap_role_length(argument), len = strlen(argument), folder_len = strlen(folder);
    if (argument[role] == '/' || !argument[role] || ap_log_argument_is_stdin(argument))
        return strdup(argument);
    bool slash = folder_len > 0 && folder[folder_len - 1] != '/';
    char *whole = malloc(len + folder_len + 2);
    if (whole)
        snprintf(whole, len + folder_len + 2, "%.*s%s%s%s", (int)role, argument, folder,
                 slash ? "/" : "", argument + role);
    return whole;
}

static bool shift(const struct ap_log_argument *a, int64_t *t_ns) {
    static const int64_t FARTHEST_NS = INT64_C(4000000000000000000);
    if (a->time_scale != 1) { // 64 bits of mantissa are a nanosecond at any time there is
        long double t = (long double)*t_ns * (long double)a->time_scale;
        if (!(fabsl(t) <= (long double)FARTHEST_NS))
            return false;
        *t_ns = llroundl(t);
    }
    int64_t sum;
    if (__builtin_add_overflow(*t_ns, a->offset_ns, &sum) || sum > FARTHEST_NS ||
        sum < -FARTHEST_NS)
        return false;
    *t_ns = sum;
    return true;
}

bool ap_log_argument_apply(const struct ap_log_argument *a, bool is_placed, struct ap_row *row) {
    if (!shift(a, &row->t_ns))
        return false;
    if (!is_placed)
        return true;
    static const double FARTHEST_M = 1e9;
    struct ap_pose *pose = &row->pose;
    if (a->scale_m > 0)
        pose->p = ap_vec3_scale(a->scale_m, pose->p);
    if (!(fabs(pose->p.x) <= FARTHEST_M && fabs(pose->p.y) <= FARTHEST_M &&
          fabs(pose->p.z) <= FARTHEST_M))
        return false;
    pose->p = ap_axes_vec3(&a->axes, pose->p);
    pose->q = ap_axes_quat(&a->axes, pose->q);
    if (a->invert)
        *pose = ap_pose_inverse(*pose);
    return true;
}
