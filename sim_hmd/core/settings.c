#include "sim_hmd/core/settings.h"

#include <stdlib.h>
#include <string.h>

#include "sim_hmd/input/profiles.h"
#include "src/device/log/poselog_argument.h"
#include "src/base/file.h"
#include "src/base/json.h"
#include "src/device/inputlog.h"

static const char *const top_keys[] = {
    "headset",       "poses",  "clock",  "refresh_hz",  "refresh_rates_hz", "frames",
    "capture",       "window", "inputs", "controllers", "recentre_s",       "strict",
    "strict_report", "draw",   "hands",  NULL};
static const char *const log_keys[] = {"logs", "up", "head_frame", "skip_bad", "table_at", NULL};
static const char *const script_keys[] = {"script",     "table_edge_m", "table_height_m",
                                          "duration_s", "seed",         NULL};
static const char *const device_keys[] = {"devices", "position",    "replay", "bus",
                                          "stats",   "calibration", NULL};
static const char *const window_keys[] = {"window", NULL};
static const char *const capture_keys[] = {"dir",    "frames", "layers", "composed",
                                           "format", "lens",   "log",    NULL};

// Relative paths are relative to the settings file's folder. malloc'ed, NULL without memory.
static char *resolve_path(const char *settings_path, const char *path) {
    const char *slash = strrchr(settings_path, '/');
    if (path[0] == '/' || !slash)
        return strdup(path);
    char *dir = strndup(settings_path, (size_t)(slash - settings_path) + 1);
    char *joined = dir ? ap_path_join(dir, path) : NULL;
    free(dir);
    return joined;
}

static enum ap_status no_memory(struct ap_error *err) {
    return ap_fail(err, AP_ENVIRONMENT, "out of memory");
}

static enum ap_status read_headset(struct ap_error *err, const struct ap_json_at *root,
                                   struct sim_settings *s) {
    struct ap_json_at at = ap_json_member(root, "headset");
    if (json_is_object(at.value))
        return ap_headset_parse(err, &at, &s->profile);
    const char *name;
    enum ap_status st = ap_json_string(err, root, "headset", &name);
    if (st)
        return st;
    char *path = resolve_path(root->file, name);
    if (!path)
        return no_memory(err);
    st = ap_headset_read(err, path, &s->profile);
    free(path);
    return st;
}

// A log's path, with its role and options about it, as one of the settings.
static char *resolve_log(const char *settings_path, const char *source) {
    const char *slash = strrchr(settings_path, '/');
    if (!slash)
        return strdup(source);
    char *dir = strndup(settings_path, (size_t)(slash - settings_path) + 1);
    char *whole = dir ? ap_log_argument_in(source, dir) : NULL;
    free(dir);
    return whole;
}

static enum ap_status read_log_list(struct ap_error *err, const struct ap_json_at *poses,
                                    struct sim_settings *s) {
    struct ap_json_at logs = ap_json_member(poses, "logs");
    size_t count = json_array_size(logs.value);
    if (count < 1 || count > 256)
        return ap_json_fail(err, &logs, "expected a list of 1 to 256 pose logs");
    s->logs = calloc(count, sizeof *s->logs);
    if (!s->logs)
        return no_memory(err);
    for (; s->log_count < count; s->log_count++) {
        struct ap_json_at at = ap_json_element(&logs, s->log_count);
        const char *source = json_string_value(at.value);
        if (!source || !*source)
            return ap_json_fail(err, &at, "expected \"[head=|left=|right=]FILE[,KEY=VALUE…]\"");
        if (ap_log_argument_is_stdin(source))
            return ap_json_fail(err, &at, "standard input belongs to the program; name a file");
        s->logs[s->log_count] = resolve_log(poses->parent->file, source);
        if (!s->logs[s->log_count])
            return no_memory(err);
    }
    return AP_OK;
}

static enum ap_status read_inputs(struct ap_error *err, const struct ap_json_at *root,
                                  struct sim_settings *s) {
    struct ap_json_at inputs = ap_json_member(root, "inputs");
    size_t count = json_array_size(inputs.value);
    if (!json_is_array(inputs.value) || count > AP_INPUT_FILES_MAX)
        return ap_json_fail(err, &inputs, "expected a list of at most %d input logs",
                            AP_INPUT_FILES_MAX);
    s->inputs = calloc(count ? count : 1, sizeof *s->inputs);
    if (!s->inputs)
        return no_memory(err);
    for (; s->input_count < count; s->input_count++) {
        struct ap_json_at at = ap_json_element(&inputs, s->input_count);
        const char *path = json_string_value(at.value);
        if (!path || !*path || strcmp(path, "-") == 0)
            return ap_json_fail(err, &at, "expected a file's path");
        s->inputs[s->input_count] = resolve_path(root->file, path);
        if (!s->inputs[s->input_count])
            return no_memory(err);
    }
    return AP_OK;
}

// A member that is one of two words; absent leaves *second alone.
static enum ap_status read_choice(struct ap_error *err, const struct ap_json_at *object,
                                  const char *key, const char *first_word, const char *second_word,
                                  bool *second) {
    if (!ap_json_has(object, key))
        return AP_OK;
    struct ap_json_at at = ap_json_member(object, key);
    const char *word;
    enum ap_status st = ap_json_string(err, object, key, &word);
    if (st)
        return st;
    if (strcmp(word, first_word) != 0 && strcmp(word, second_word) != 0)
        return ap_json_fail(err, &at, "expected \"%s\" or \"%s\"", first_word, second_word);
    *second = strcmp(word, second_word) == 0;
    return AP_OK;
}

static enum ap_status read_logs(struct ap_error *err, const struct ap_json_at *poses,
                                struct sim_settings *s) {
    s->poses = SIM_POSES_LOGS;
    bool optical = false;
    double table[3];
    enum ap_status st = ap_json_check_keys(err, poses, log_keys);
    if (!st)
        st = read_log_list(err, poses, s);
    if (!st)
        st = read_choice(err, poses, "up", "y", "z", &s->z_up);
    if (!st)
        st = read_choice(err, poses, "head_frame", "head", "optical", &optical);
    if (!st && ap_json_has(poses, "skip_bad"))
        st = ap_json_bool(err, poses, "skip_bad", &s->skip_bad);
    if (!st && ap_json_has(poses, "table_at")) {
        st = ap_json_numbers(err, poses, "table_at", 3, table);
        if (!st) {
            s->has_table = true;
            s->table_x_m = table[0];
            s->table_z_m = table[1];
            s->table_yaw_rad = table[2];
        }
    }
    s->head_frame = optical ? AP_HEAD_FRAME_OPTICAL : AP_HEAD_FRAME_HEAD;
    return st;
}

static enum ap_status read_positive(struct ap_error *err, const struct ap_json_at *object,
                                    const char *key, double max, double *value) {
    if (!ap_json_has(object, key))
        return AP_OK;
    struct ap_json_at at = ap_json_member(object, key);
    double number;
    enum ap_status st = ap_json_number(err, object, key, &number);
    if (st)
        return st;
    if (!(number > 0 && number <= max))
        return ap_json_fail(err, &at, "expected a number > 0 and at most %g", max);
    *value = number;
    return AP_OK;
}

static enum ap_status read_count(struct ap_error *err, const struct ap_json_at *object,
                                 const char *key, int64_t *value) {
    struct ap_json_at at = ap_json_member(object, key);
    if (!json_is_integer(at.value) || json_integer_value(at.value) < 1)
        return ap_json_fail(err, &at, "expected a whole number of at least 1");
    *value = json_integer_value(at.value);
    return AP_OK;
}

static enum ap_status read_script(struct ap_error *err, const struct ap_json_at *poses,
                                  struct sim_settings *s) {
    s->poses = SIM_POSES_WALK;
    const char *script;
    struct ap_json_at at = ap_json_member(poses, "script");
    int64_t seed = 0;
    enum ap_status st = ap_json_check_keys(err, poses, script_keys);
    if (!st)
        st = ap_json_string(err, poses, "script", &script);
    if (!st && strcmp(script, "walk") != 0)
        st = ap_json_fail(err, &at, "no such script; there is \"walk\"");
    if (!st)
        st = read_positive(err, poses, "table_edge_m", 100, &s->walk.table_edge_m);
    if (!st)
        st = read_positive(err, poses, "table_height_m", 3, &s->walk.table_height_m);
    if (!st)
        st = read_positive(err, poses, "duration_s", 86400, &s->walk.duration_s);
    if (!st && ap_json_has(poses, "seed"))
        st = read_count(err, poses, "seed", &seed);
    s->walk.seed = (uint64_t)seed;
    return st;
}

static enum ap_status read_window(struct ap_error *err, const struct ap_json_at *poses,
                                  struct sim_settings *s) {
    bool window;
    enum ap_status st = ap_json_check_keys(err, poses, window_keys);
    if (!st)
        st = ap_json_bool(err, poses, "window", &window);
    if (st)
        return st;
    s->poses = window ? SIM_POSES_WINDOW : SIM_POSES_WALK;
    s->window |= window;
    return AP_OK;
}

// A list of words; of paths, made relative to the settings file's folder.
static enum ap_status read_texts(struct ap_error *err, const struct ap_json_at *object,
                                 const char *key, bool paths, struct sim_texts *texts) {
    if (!ap_json_has(object, key))
        return AP_OK;
    struct ap_json_at list = ap_json_member(object, key);
    size_t count = json_array_size(list.value);
    if (!json_is_array(list.value) || count > 64)
        return ap_json_fail(err, &list, "expected a list of at most 64 strings");
    texts->text = calloc(count ? count : 1, sizeof *texts->text);
    if (!texts->text)
        return no_memory(err);
    for (; texts->count < count; texts->count++) {
        struct ap_json_at at = ap_json_element(&list, texts->count);
        const char *text = json_string_value(at.value);
        if (!text || !*text)
            return ap_json_fail(err, &at, "expected a string that is not empty");
        char *copy = paths ? resolve_path(object->parent->file, text) : strdup(text);
        texts->text[texts->count] = copy;
        if (!copy)
            return no_memory(err);
    }
    return AP_OK;
}

static enum ap_status read_devices(struct ap_error *err, const struct ap_json_at *poses,
                                   struct sim_settings *s) {
    s->poses = SIM_POSES_DEVICES;
    enum ap_status st = ap_json_check_keys(err, poses, device_keys);
    if (!st)
        st = read_texts(err, poses, "devices", false, &s->devices.assign);
    if (!st)
        st = read_texts(err, poses, "position", false, &s->devices.position);
    if (!st)
        st = read_texts(err, poses, "replay", true, &s->devices.replay);
    if (!st)
        st = read_texts(err, poses, "bus", false, &s->devices.bus);
    const char *folder = NULL;
    if (!st && ap_json_has(poses, "calibration"))
        st = ap_json_string(err, poses, "calibration", &folder);
    if (!st && folder) {
        s->devices.calibration = resolve_path(poses->parent->file, folder);
        if (!s->devices.calibration)
            return no_memory(err);
    }
    if (!st && ap_json_has(poses, "stats"))
        st = ap_json_bool(err, poses, "stats", &s->devices.stats);
    return st;
}

static enum ap_status read_poses(struct ap_error *err, const struct ap_json_at *root,
                                 struct sim_settings *s) {
    static const struct {
        const char *key; // that tells the kind
        enum ap_status (*read)(struct ap_error *err, const struct ap_json_at *poses,
                               struct sim_settings *s);
    } kinds[] = {{"logs", read_logs},
                 {"script", read_script},
                 {"window", read_window},
                 {"devices", read_devices}};
    struct ap_json_at poses = ap_json_member(root, "poses");
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++)
        if (json_object_get(poses.value, kinds[i].key))
            return kinds[i].read(err, &poses, s);
    enum ap_status st = ap_json_check_keys(err, &poses, (const char *const[]){NULL});
    return st ? st
              : ap_json_fail(err, &poses,
                             "expected \"logs\", \"script\", \"window\" or \"devices\"");
}

static enum ap_status read_flag(struct ap_error *err, const struct ap_json_at *object,
                                const char *key, bool *value) {
    return ap_json_has(object, key) ? ap_json_bool(err, object, key, value) : AP_OK;
}

// What is written of a captured frame, and how.
static enum ap_status read_outputs(struct ap_error *err, const struct ap_json_at *capture,
                                   struct sim_settings *s) {
    struct ap_json_at lens = ap_json_member(capture, "lens");
    enum ap_status st = read_flag(err, capture, "layers", &s->capture_layers);
    if (!st)
        st = read_flag(err, capture, "composed", &s->capture_composed);
    if (!st)
        st = read_flag(err, capture, "lens", &s->capture_lens);
    if (!st)
        st = read_choice(err, capture, "format", "png", "raw", &s->capture_raw);
    if (!st)
        st = read_choice(err, capture, "log", "captured", "all", &s->capture_log_all);
    for (int eye = 0; eye < 2 && !st && s->capture_lens; eye++)
        if (s->profile.eye[eye].lens.red_scale == 0)
            st = ap_json_fail(err, &lens, "the headset's profile describes no lens of this eye: %s",
                              eye ? "right" : "left");
    return st;
}

static enum ap_status read_capture(struct ap_error *err, const struct ap_json_at *root,
                                   struct sim_settings *s) {
    struct ap_json_at capture = ap_json_member(root, "capture");
    const char *dir, *frames = ":";
    enum ap_status st = ap_json_check_keys(err, &capture, capture_keys);
    if (!st)
        st = ap_json_string(err, &capture, "dir", &dir);
    if (!st && ap_json_has(&capture, "frames"))
        st = ap_json_string(err, &capture, "frames", &frames);
    if (!st)
        st = read_outputs(err, &capture, s);
    if (st)
        return st;
    struct ap_json_at at = ap_json_member(&capture, "frames");
    struct ap_error why;
    if (ap_range_parse(&why, frames, &s->capture_frames))
        return ap_json_fail(err, &at, "%s", why.text);
    s->capture_dir = resolve_path(root->file, dir);
    return s->capture_dir ? AP_OK : no_memory(err);
}

static void add_rate(struct sim_settings *s, double hz) {
    size_t at = 0;
    while (at < s->rate_count && s->rates_hz[at] < hz)
        at++;
    if (s->rate_count == SIM_MAX_RATES || (at < s->rate_count && s->rates_hz[at] == hz))
        return;
    memmove(&s->rates_hz[at + 1], &s->rates_hz[at], (s->rate_count - at) * sizeof *s->rates_hz);
    s->rates_hz[at] = hz;
    s->rate_count++;
}

static enum ap_status read_rates(struct ap_error *err, const struct ap_json_at *root,
                                 struct sim_settings *s) {
    struct ap_json_at list = ap_json_member(root, "refresh_rates_hz");
    size_t count = json_array_size(list.value);
    if (count < 1 || count >= SIM_MAX_RATES)
        return ap_json_fail(err, &list, "expected a list of 1 to %d rates", SIM_MAX_RATES - 1);
    for (size_t i = 0; i < count; i++) {
        struct ap_json_at at = ap_json_element(&list, i);
        double hz = json_number_value(at.value); // 0 where it is none
        if (!(hz > 0 && hz <= 10000))
            return ap_json_fail(err, &at, "expected a number > 0 and at most 10000");
        add_rate(s, hz);
    }
    return AP_OK;
}

// Without a list those that headsets have as a rule.
static enum ap_status settle_rates(struct ap_error *err, const struct ap_json_at *root,
                                   struct sim_settings *s) {
    static const double usual[] = {60, 72, 80, 90, 120};
    enum ap_status st = AP_OK;
    if (root && ap_json_has(root, "refresh_rates_hz"))
        st = read_rates(err, root, s);
    else
        for (size_t i = 0; i < sizeof usual / sizeof *usual; i++)
            add_rate(s, usual[i]);
    add_rate(s, s->profile.refresh_hz);
    return st;
}

static enum ap_status read_recentre(struct ap_error *err, const struct ap_json_at *root,
                                    struct sim_settings *s) {
    struct ap_json_at list = ap_json_member(root, "recentre_s");
    size_t count = json_array_size(list.value);
    if (count < 1 || count > SIM_MAX_RECENTRE_TIMES)
        return ap_json_fail(err, &list, "expected a list of 1 to %d times in seconds",
                            SIM_MAX_RECENTRE_TIMES);
    double last = 0;
    for (size_t i = 0; i < count; i++) {
        struct ap_json_at at = ap_json_element(&list, i);
        double t = json_is_number(at.value) ? json_number_value(at.value) : -1;
        if (!(t > last && t <= 1e6))
            return ap_json_fail(err, &at, "expected seconds, rising from more than 0");
        s->recentre_s[s->recentre_count++] = last = t;
    }
    return AP_OK;
}

static enum ap_status read_controllers(struct ap_error *err, const struct ap_json_at *root,
                                       struct sim_settings *s) {
    struct ap_json_at at = ap_json_member(root, "controllers");
    const char *path;
    enum ap_status st = ap_json_string(err, root, "controllers", &path);
    if (st)
        return st;
    s->controllers = sim_profile_find(path);
    if (s->controllers < 0 || !sim_profile_has_top(s->controllers, SIM_TOP_LEFT))
        return ap_json_fail(err, &at, "expected an interaction profile of the hands, as \"%s\"",
                            sim_profiles[0].path);
    return AP_OK;
}

static enum ap_status read_strict(struct ap_error *err, const struct ap_json_at *root,
                                  struct sim_settings *s) {
    const char *report;
    enum ap_status st = AP_OK;
    if (ap_json_has(root, "strict"))
        st = ap_json_bool(err, root, "strict", &s->strict);
    if (st || !ap_json_has(root, "strict_report"))
        return st;
    struct ap_json_at at = ap_json_member(root, "strict_report");
    st = ap_json_string(err, root, "strict_report", &report);
    if (!st && !s->strict)
        st = ap_json_fail(err, &at, "there is no report without \"strict\": true");
    if (st)
        return st;
    s->strict_report = resolve_path(root->file, report);
    return s->strict_report ? AP_OK : no_memory(err);
}

static enum ap_status read_hands(struct ap_error *err, const struct ap_json_at *root,
                                 struct sim_settings *s) {
    const char *path;
    enum ap_status st = ap_json_string(err, root, "hands", &path);
    if (st)
        return st;
    struct ap_json_at at = ap_json_member(root, "hands");
    if (!*path || strcmp(path, "-") == 0)
        return ap_json_fail(err, &at, "expected a file's path");
    s->hands = resolve_path(root->file, path);
    return s->hands ? AP_OK : no_memory(err);
}

// true, false, or how it is laid out.
static enum ap_status read_shown(struct ap_error *err, const struct ap_json_at *root,
                                 struct sim_settings *s) {
    static const char *const layouts[SIM_LAYOUT_COUNT] = {"pair", "left", "right", "cross",
                                                          "anaglyph"};
    struct ap_json_at at = ap_json_member(root, "window");
    if (json_is_boolean(at.value)) {
        s->window |= json_is_true(at.value);
        return AP_OK;
    }
    const char *word = json_string_value(at.value);
    for (int i = 0; word && i < SIM_LAYOUT_COUNT; i++)
        if (strcmp(word, layouts[i]) == 0) {
            s->window = true;
            s->window_layout = (enum sim_layout)i;
            return AP_OK;
        }
    return ap_json_fail(err, &at,
                        "expected true, false, \"pair\", \"left\", \"right\", "
                        "\"cross\" or \"anaglyph\"");
}

static enum ap_status read_all(struct ap_error *err, const struct ap_json_at *root,
                               struct sim_settings *s) {
    bool virtual_clock = false;
    enum ap_status st = ap_json_check_keys(err, root, top_keys);
    if (!st && ap_json_has(root, "headset"))
        st = read_headset(err, root, s);
    if (!st && ap_json_has(root, "poses"))
        st = read_poses(err, root, s);
    if (!st)
        st = read_choice(err, root, "clock", "real", "virtual", &virtual_clock);
    s->clock = virtual_clock ? SIM_CLOCK_VIRTUAL : SIM_CLOCK_REAL;
    if (!st && virtual_clock && s->poses == SIM_POSES_DEVICES) {
        struct ap_json_at at = ap_json_member(root, "clock");
        st = ap_json_fail(err, &at, "devices move in real time: expected \"real\"");
    }
    if (!st)
        st = read_positive(err, root, "refresh_hz", 10000, &s->profile.refresh_hz);
    if (!st)
        st = settle_rates(err, root, s);
    if (!st && ap_json_has(root, "frames"))
        st = read_count(err, root, "frames", &s->frames);
    if (!st)
        st = read_choice(err, root, "draw", "captured", "all", &s->draw_all);
    if (!st && ap_json_has(root, "capture"))
        st = read_capture(err, root, s);
    if (!st && ap_json_has(root, "inputs"))
        st = read_inputs(err, root, s);
    if (!st && ap_json_has(root, "recentre_s"))
        st = read_recentre(err, root, s);
    if (!st && ap_json_has(root, "hands"))
        st = read_hands(err, root, s);
    if (!st && ap_json_has(root, "controllers"))
        st = read_controllers(err, root, s);
    if (!st)
        st = read_strict(err, root, s);
    if (!st && ap_json_has(root, "window"))
        st = read_shown(err, root, s);
    return st;
}

enum ap_status sim_settings_read(struct ap_error *err, const char *path,
                                 struct sim_settings *settings) {
    struct sim_settings s = {
        .profile = ap_headset_builtin(), .capture_frames = AP_RANGE_ALL, .capture_composed = true};
    if (path) {
        json_t *root = NULL;
        enum ap_status st = ap_json_read(err, path, &root);
        if (st)
            return st;
        struct ap_json_at at = ap_json_root(root, path);
        st = read_all(err, &at, &s);
        json_decref(root);
        if (st) {
            sim_settings_finish(&s);
            return st;
        }
    } else {
        settle_rates(err, NULL, &s);
    }
    *settings = s;
    return AP_OK;
}

static void free_texts(struct sim_texts *texts) {
    for (size_t i = 0; i < texts->count; i++)
        free(texts->text[i]);
    free(texts->text);
}

void sim_settings_finish(struct sim_settings *settings) {
    free_texts(&settings->devices.assign);
    free(settings->devices.calibration);
    free_texts(&settings->devices.position);
    free_texts(&settings->devices.bus);
    free_texts(&settings->devices.replay);
    for (size_t i = 0; i < settings->log_count; i++)
        free(settings->logs[i]);
    free(settings->logs);
    for (size_t i = 0; i < settings->input_count; i++)
        free(settings->inputs[i]);
    free(settings->inputs);
    free(settings->hands);
    free(settings->capture_dir);
    free(settings->strict_report);
    *settings = (struct sim_settings){0};
}

bool sim_settings_captures(const struct sim_settings *settings, int64_t frame) {
    return settings->capture_dir && ap_range_has(settings->capture_frames, frame);
}
