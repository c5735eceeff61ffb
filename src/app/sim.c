#include "src/app/sim.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "src/app/room_file.h"
#include "src/app/runtime.h"
#include "src/base/file.h"
#include "src/base/json.h"
#include "src/base/log.h"

static const char help[] =
    "Runs PROGRAM, any OpenXR program that draws with Vulkan, on the simulated headset: without a\n"
    "headset, a graphics card or a display. Poses come from pose logs (docs/pose-logs.md), or live from\n"
    "plugged-in trackers with --devices, --device, --position or --replay, else from\n"
    "keyboard and mouse with --window, else from a scripted walk; buttons and sticks from input logs\n"
    "(docs/input-logs.md). With --clock virtual time goes on by one frame as soon as the program has\n"
    "ended one, and a run repeats; --capture DIR keeps what each eye was shown, and the settings as\n"
    "DIR/sim.json. docs/ci.md is a recipe for tests.\n"
    "\n"
    "Exit status: the program's own, 128 + N where signal N ended it; 1 where --strict found errors;\n"
    "4 where the program cannot be started or was stopped by --timeout; before it starts, 2 and 3 as\n"
    "always.";

// Files of one run.
struct sim_run {
    char folder[64]; // of the temporary files; "": none yet
    char *settings;
    char *report; // NULL without --strict
};

static enum ap_status no_memory(struct ap_error *err) {
    return ap_fail(err, AP_ENVIRONMENT, "out of memory");
}

static enum ap_status make_folder(struct ap_error *err, struct sim_run *run) {
    const char *tmp = getenv("TMPDIR");
    int n = snprintf(run->folder, sizeof run->folder, "%s/antipode-sim-XXXXXX",
                     tmp && tmp[0] == '/' && strlen(tmp) < 40 ? tmp : "/tmp");
    if (n < 0 || !mkdtemp(run->folder)) {
        enum ap_status st =
            ap_fail(err, AP_ENVIRONMENT, "%s: cannot be made: %s", run->folder, strerror(errno));
        run->folder[0] = '\0';
        return st;
    }
    return AP_OK;
}

// Where a capture is kept, its settings and report are kept beside it.
static enum ap_status open_run(struct ap_error *err, const struct ap_sim_options *o,
                               struct sim_run *run) {
    enum ap_status st = o->capture ? ap_sim_capture_prepare(err, o) : make_folder(err, run);
    if (st)
        return st;
    char *dir = realpath(o->capture ? o->capture : run->folder, NULL);
    if (dir)
        run->settings = ap_path_join(dir, "sim.json");
    if (dir && o->strict)
        run->report = ap_path_join(dir, "strict.jsonl");
    free(dir);
    if (!run->settings || (o->strict && !run->report))
        return no_memory(err);
    return ap_sim_write_settings(err, o, run->settings, run->report);
}

static void close_run(struct sim_run *run) {
    if (run->folder[0]) {
        if (run->settings)
            unlink(run->settings);
        if (run->report)
            unlink(run->report);
        rmdir(run->folder);
    }
    free(run->settings);
    free(run->report);
}

static bool get_count(const json_t *summary, const char *key, int64_t *value) {
    const json_t *number = json_object_get(summary, key);
    *value = json_integer_value(number);
    return json_is_integer(number);
}

// The report's last line is {"errors": N, "warnings": M}.
static bool read_summary(const char *path, int64_t *errors, int64_t *warnings) {
    char *text = NULL;
    size_t len;
    if (ap_file_read(NULL, path, (size_t)1 << 30, &text, &len))
        return false;
    while (len > 0 && text[len - 1] == '\n')
        len--;
    size_t at = len;
    while (at > 0 && text[at - 1] != '\n')
        at--;
    json_t *summary = json_loadb(text + at, len - at, JSON_REJECT_DUPLICATES, NULL);
    bool ok = get_count(summary, "errors", errors) && get_count(summary, "warnings", warnings);
    json_decref(summary);
    free(text);
    return ok;
}

static enum ap_status judge(struct ap_error *err, const struct sim_run *run, const char *program) {
    int64_t errors, warnings;
    if (!ap_file_exists(run->report))
        return ap_fail(err, AP_DIFFERS, "--strict: %s made no OpenXR instance", program);
    if (!read_summary(run->report, &errors, &warnings))
        return ap_fail(err, AP_DIFFERS, "--strict: %s ended before its calls could be summed up",
                       program);
    if (errors == 0)
        return AP_OK;
    return ap_fail(err, AP_DIFFERS, "--strict: %s broke the specification in %lld call%s", program,
                   (long long)errors, errors == 1 ? "" : "s");
}

// How it ended, in words where it did not end well by itself.
static enum ap_status conclude(struct ap_error *err, const struct ap_sim_options *o,
                               const struct sim_run *run, const char *program,
                               const struct ap_sim_end *end) {
    if (end->timed_out)
        return ap_fail(err, AP_ENVIRONMENT, "%s had not ended after %g s and was stopped", program,
                       o->timeout_s);
    if (end->signal)
        return ap_fail(err, (enum ap_status)end->status, "%s was ended by signal %d (%s)", program,
                       end->signal, strsignal(end->signal));
    if (o->capture && ap_sim_capture_is_empty(o->capture))
        ap_log(AP_LOG_WARNING, "sim: %s: nothing was captured", o->capture);
    enum ap_status st = run->report ? judge(err, run, program) : AP_OK;
    return end->status ? (enum ap_status)end->status : st;
}

static enum ap_status run_program(struct ap_error *err, const struct ap_sim_options *o,
                                  char **program) {
    struct sim_run run = {.folder = ""};
    struct ap_sim_end end;
    enum ap_status st = ap_sim_check(err, o);
    if (!st)
        st = open_run(err, o, &run);
    if (!st)
        st = ap_runtime_use_simulated(err, run.settings);
    if (!st)
        st = ap_sim_run_process(err, &(struct ap_sim_process){program, o->timeout_s, o->hold_stdin},
                                &end);
    if (!st)
        st = conclude(err, o, &run, program[0], &end);
    close_run(&run);
    return st;
}

static enum ap_status run_sim(struct ap_error *err, int argc, char **argv) {
    struct ap_sim_options o = {.clock = "real",
                               .logs = AP_LOG_OPTIONS_NONE,
                               .refresh_hz = NAN,
                               .frames = NAN,
                               .timeout_s = NAN};
    const struct ap_option options[] = {
        {"headset", AP_OPTION_TEXT, &o.headset, "FILE",
         "headset profile, or standard, wide, ci (standard)"},
        {"poses", AP_OPTION_LIST, &o.poses, "LOG",
         "[ROLE=]FILE[,KEY=VALUE...], a pose log; may be repeated"},
        {"devices", AP_OPTION_FLAG, &o.devices, "", "poses from what is plugged in"},
        AP_LIVE_OPTION_TABLE(o.live),
        {"input", AP_OPTION_LIST, &o.inputs, "LOG", "buttons and sticks by time; may be repeated"},
        {"hands", AP_OPTION_TEXT, &o.hands, "FILE", "recorded bare hands, for hand tracking"},
        {"recentre", AP_OPTION_LIST, &o.recentre_s, "S",
         "LOCAL comes to the head after S seconds; may be repeated"},
        {"clock", AP_OPTION_CHOICE, &o.clock, "real|virtual", "virtual: stepped by the frames"},
        {"refresh", AP_OPTION_NUMBER, &o.refresh_hz, "HZ", "instead of the headset's rate"},
        {"frames", AP_OPTION_NUMBER, &o.frames, "N", "then the program is asked to end"},
        {"capture", AP_OPTION_TEXT, &o.capture, "DIR", "write what each eye was shown"},
        {"capture-frames", AP_OPTION_TEXT, &o.capture_frames, "A:B:STEP",
         "which frames, half open (all)"},
        {"layers", AP_OPTION_FLAG, &o.layers, "", "capture what the program submitted, too"},
        {"lens", AP_OPTION_FLAG, &o.lens, "", "capture as the headset's lens wants it"},
        {"format", AP_OPTION_CHOICE, &o.format, "png|raw", "of the pictures; raw is PAM (png)"},
        {"log", AP_OPTION_CHOICE, &o.log, "captured|all", "frames in DIR/frames.jsonl (captured)"},
        {"force", AP_OPTION_FLAG, &o.force, "", "replace a capture in DIR"},
        {"draw-all", AP_OPTION_FLAG, &o.draw_all, "",
         "virtual clock: frames that are not captured are drawn, too"},
        {"controllers", AP_OPTION_TEXT, &o.controllers, "PROFILE",
         "what the hands hold, as valve/index_controller"},
        {"window", AP_OPTION_FLAG, &o.window, "", "show the eyes in a window"},
        {"layout", AP_OPTION_CHOICE, &o.layout, "pair|left|right|cross|anaglyph",
         "of the window (pair)"},
        {"strict", AP_OPTION_FLAG, &o.strict, "", "report calls that break the specification"},
        AP_LOG_OPTION_TABLE(o.logs),
        {"timeout", AP_OPTION_NUMBER, &o.timeout_s, "S", "stop the program after S seconds"},
        {"hold-stdin", AP_OPTION_FLAG, &o.hold_stdin, "",
         "an input that says nothing and does not end"},
    };
    const struct ap_usage usage = {.command = "sim",
                                   .operands = "[--] PROGRAM [ARGS...]",
                                   .text = help,
                                   .options = options,
                                   .option_count = sizeof options / sizeof options[0],
                                   .min_operands = 1,
                                   .max_operands = -1,
                                   .operand_ends_options = true};
    int words;
    bool done;
    enum ap_status st = ap_parse_options(err, &usage, argc, argv, &words, &done);
    if (st || done)
        return st;
    argv[1 + words] = NULL;
    double no_height = 0, no_edge = 0; // the program's own business
    struct ap_room_defaults room = {
        .table_at = &o.logs.table_at, .table_height_m = &no_height, .table_edge_m = &no_edge};
    st = ap_room_file_apply(err, o.logs.room, &room);
    return st ? st : run_program(err, &o, argv + 1);
}

const struct ap_command ap_command_sim = {"sim", "run any OpenXR program on the simulated headset",
                                          run_sim};
