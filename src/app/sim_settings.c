#include <errno.h>
#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "src/app/runtime.h"
#include "src/app/sim.h"
#include "src/base/file.h"
#include "src/base/number.h"
#include "src/base/range.h"
#include "src/device/headset.h"
#include "src/device/inputlog.h"
#include "src/device/log/poselog_argument.h"
#include "src/track/setup.h"

// --- what can be known before the program runs

// What is read here once must be there for the runtime to read again.
static bool is_plain_file(const char *path) {
    struct stat s;
    return stat(path, &s) == 0 && S_ISREG(s.st_mode);
}

// A shipped profile may be named by its word: "ci".
static char *headset_path(const char *headset) {
    if (headset[strcspn(headset, "./")] || is_plain_file(headset))
        return strdup(headset);
    char name[256];
    snprintf(name, sizeof name, "headsets/%s.json", headset);
    char *shipped = ap_shared_path(name);
    return shipped ? shipped : strdup(headset);
}

static enum ap_status check_headset(struct ap_error *err, const char *headset) {
    if (!headset)
        return AP_OK;
    struct ap_headset_profile profile;
    char *path = headset_path(headset);
    enum ap_status st =
        path ? ap_headset_read(err, path, &profile) : ap_fail(err, AP_ENVIRONMENT, "out of memory");
    free(path);
    return st;
}

static enum ap_status check_logs(struct ap_error *err, const struct ap_sim_options *o) {
    enum ap_status st = AP_OK;
    for (size_t i = 0; !st && i < o->poses.count; i++) {
        const char *log = o->poses.text[i];
        struct ap_poselog *open = NULL;
        struct ap_log_argument argument;
        if (ap_log_argument_is_stdin(log))
            return ap_fail(err, AP_USAGE,
                           "--poses %s: standard input is the program's; name a file", log);
        st = ap_log_argument_parse(err, log, &argument);
        if (st || (ap_file_exists(argument.path) && !is_plain_file(argument.path)))
            continue; // a pipe is for the runtime to read
        st = ap_logs_open(err, &o->logs, (char *[]){(char *)(uintptr_t)log}, 1, &open);
        ap_poselog_close(open);
    }
    for (size_t i = 0; !st && i < o->inputs.count; i++) {
        struct ap_inputlog *log = NULL;
        if (ap_file_exists(o->inputs.text[i]) && !is_plain_file(o->inputs.text[i]))
            continue;
        st = ap_inputlog_load(err, &o->inputs.text[i], 1, &log);
        ap_inputlog_destroy(log);
    }
    return st;
}

static bool parse_seconds(const char *text, double *s) {
    return ap_parse_double(text, strlen(text), s) && *s >= 0;
}

static enum ap_status check_recentre(struct ap_error *err, const struct ap_text_list *list) {
    double before = -1, s;
    for (size_t i = 0; i < list->count; i++, before = s)
        if (!parse_seconds(list->text[i], &s) || s <= before)
            return ap_fail(err, AP_USAGE, "--recentre: expected rising seconds, not '%s'",
                           list->text[i]);
    return AP_OK;
}

static enum ap_status check_numbers(struct ap_error *err, const struct ap_sim_options *o) {
    if (!isnan(o->frames) &&
        !(o->frames >= 1 && o->frames <= 1e15 && o->frames == floor(o->frames)))
        return ap_fail(err, AP_USAGE, "--frames: expected a whole number of at least 1, not %g",
                       o->frames);
    if (!isnan(o->refresh_hz) && !(o->refresh_hz > 0 && o->refresh_hz <= 10000))
        return ap_fail(err, AP_USAGE, "--refresh: expected a rate of at most 10000 Hz, not %g",
                       o->refresh_hz);
    if (!isnan(o->timeout_s) && !(o->timeout_s > 0))
        return ap_fail(err, AP_USAGE, "--timeout: expected seconds > 0, not %g", o->timeout_s);
    return check_recentre(err, &o->recentre_s);
}

static bool wants_capture(const struct ap_sim_options *o) {
    return o->capture_frames || o->layers || o->lens || o->format || o->log || o->force;
}

static bool is_live(const struct ap_sim_options *o) {
    return o->devices || ap_live_options_given(&o->live);
}

static enum ap_status check_devices(struct ap_error *err, const struct ap_sim_options *o) {
    bool live = is_live(o);
    if (live && o->poses.count)
        return ap_fail(err, AP_USAGE,
                       "--poses and --devices: where the head is can come from "
                       "logs or from devices, not from both");
    if (live && strcmp(o->clock, "real") != 0)
        return ap_fail(err, AP_USAGE,
                       "--clock virtual: devices move in real time; for a run that "
                       "repeats, give the recording to --poses");
    return ap_live_options_check(err, &o->live);
}

enum ap_status ap_sim_check(struct ap_error *err, const struct ap_sim_options *o) {
    struct ap_range range;
    double x, z, yaw;
    enum ap_status st = check_numbers(err, o);
    if (!st)
        st = check_devices(err, o);
    if (!st && !o->capture && wants_capture(o))
        st = ap_fail(err, AP_USAGE,
                     "--capture-frames, --layers, --lens, --format, --log and --force need "
                     "--capture DIR");
    if (!st && o->layout && !o->window)
        st = ap_fail(err, AP_USAGE, "--layout needs --window");
    if (!st && o->capture_frames)
        st = ap_range_parse(err, o->capture_frames, &range);
    if (!st && o->logs.table_at)
        st = ap_table_at_parse(err, o->logs.table_at, &x, &z, &yaw);
    if (!st && o->hands && !ap_file_exists(o->hands))
        st = ap_fail(err, AP_INPUT, "%s: cannot open: %s", o->hands, strerror(errno));
    if (!st)
        st = check_headset(err, o->headset);
    return st ? st : check_logs(err, o);
}

// --- the settings

static const char PROFILES[] = "/interaction_profiles/";

// The program may change its folder, so every path is made absolute. NULL without memory.
static char *absolute(const char *path) {
    if (path[0] == '/')
        return strdup(path);
    char *here = getcwd(NULL, 0);
    char *whole = here ? ap_path_join(here, path) : NULL;
    free(here);
    return whole;
}

// NULL for a path that is not UTF-8, which JSON cannot hold.
static json_t *path_json(const char *path) {
    char *whole = absolute(path);
    json_t *value = whole ? json_string(whole) : NULL;
    free(whole);
    return value;
}

static json_t *log_json(const char *log) {
    char *here = getcwd(NULL, 0), *whole = here ? ap_log_argument_in(log, here) : NULL;
    json_t *value = whole ? json_string(whole) : NULL;
    free(whole);
    free(here);
    return value;
}

static json_t *headset_json(const char *headset) {
    char *path = headset_path(headset);
    json_t *value = path ? path_json(path) : NULL;
    free(path);
    return value;
}

static bool set(json_t *object, const char *key, json_t *value) {
    return json_object_set_new(object, key, value) == 0;
}

static json_t *poses_json(const struct ap_sim_options *o) {
    if (is_live(o))
        return ap_live_options_json(&o->live, true);
    if (!o->poses.count)
        return o->window ? json_pack("{s:b}", "window", 1) : json_pack("{s:s}", "script", "walk");
    json_t *logs = json_array();
    bool ok = logs != NULL;
    for (size_t i = 0; ok && i < o->poses.count; i++) {
        ok = json_array_append_new(logs, log_json(o->poses.text[i])) == 0;
    }
    json_t *poses = json_pack("{s:o, s:s, s:s, s:b}", "logs", logs, "up", o->logs.up, "head_frame",
                              o->logs.head_frame, "skip_bad", o->logs.skip_bad);
    double x, z, yaw;
    if (poses && o->logs.table_at && !ap_table_at_parse(NULL, o->logs.table_at, &x, &z, &yaw))
        ok = set(poses, "table_at", json_pack("[f, f, f]", x, z, yaw)) && ok;
    if (ok)
        return poses;
    json_decref(poses);
    return NULL;
}

static json_t *inputs_json(const struct ap_sim_options *o) {
    json_t *list = json_array();
    for (size_t i = 0; list && i < o->inputs.count; i++)
        if (json_array_append_new(list, path_json(o->inputs.text[i])) != 0) {
            json_decref(list);
            return NULL;
        }
    return list;
}

static json_t *recentre_json(const struct ap_sim_options *o) {
    json_t *list = json_array();
    for (size_t i = 0; list && i < o->recentre_s.count; i++) {
        double s = 0;
        parse_seconds(o->recentre_s.text[i], &s);
        if (json_array_append_new(list, json_real(s)) != 0) {
            json_decref(list);
            return NULL;
        }
    }
    return list;
}

// The settings lie in the folder itself.
static json_t *capture_json(const struct ap_sim_options *o) {
    json_t *capture = json_pack("{s:s}", "dir", ".");
    bool ok = capture != NULL;
    if (o->capture_frames)
        ok = set(capture, "frames", json_string(o->capture_frames)) && ok;
    if (o->layers)
        ok = set(capture, "layers", json_true()) && ok;
    if (o->lens)
        ok = set(capture, "lens", json_true()) && ok;
    if (o->format)
        ok = set(capture, "format", json_string(o->format)) && ok;
    if (o->log)
        ok = set(capture, "log", json_string(o->log)) && ok;
    if (ok)
        return capture;
    json_decref(capture);
    return NULL;
}

static json_t *settings_json(const struct ap_sim_options *o, const char *strict_report) {
    json_t *root = json_pack("{s:s}", "clock", o->clock);
    if (!root)
        return NULL;
    bool ok = set(root, "poses", poses_json(o));
    if (o->headset)
        ok = ok && set(root, "headset", headset_json(o->headset));
    if (o->hands)
        ok = ok && set(root, "hands", path_json(o->hands));
    if (o->recentre_s.count)
        ok = ok && set(root, "recentre_s", recentre_json(o));
    if (o->controllers)
        ok = ok &&
             set(root, "controllers",
                 json_sprintf("%s%s", o->controllers[0] == '/' ? "" : PROFILES, o->controllers));
    if (o->draw_all)
        ok = ok && set(root, "draw", json_string("all"));
    if (o->inputs.count)
        ok = ok && set(root, "inputs", inputs_json(o));
    if (!isnan(o->refresh_hz))
        ok = ok && set(root, "refresh_hz", json_real(o->refresh_hz));
    if (!isnan(o->frames))
        ok = ok && set(root, "frames", json_integer((json_int_t)o->frames));
    if (o->capture)
        ok = ok && set(root, "capture", capture_json(o));
    if (o->window)
        ok = ok && set(root, "window", o->layout ? json_string(o->layout) : json_true());
    if (o->strict)
        ok = ok && set(root, "strict", json_true()) &&
             set(root, "strict_report", path_json(strict_report));
    if (ok)
        return root;
    json_decref(root);
    return NULL;
}

enum ap_status ap_sim_write_settings(struct ap_error *err, const struct ap_sim_options *o,
                                     const char *path, const char *strict_report) {
    json_t *root = settings_json(o, strict_report);
    char *text = root ? json_dumps(root, JSON_INDENT(1) | JSON_REAL_PRECISION(17)) : NULL;
    json_decref(root);
    if (!text)
        return ap_fail(err, AP_ENVIRONMENT,
                       "the settings cannot be made: out of memory, or a path is not UTF-8");
    struct ap_outfile file;
    enum ap_status st = ap_outfile_open(err, path, &file);
    if (!st) {
        fprintf(file.stream, "%s\n", text);
        st = ap_outfile_commit(err, &file);
    }
    free(text);
    return st;
}
