#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "src/app/command.h"
#include "src/app/live_options.h"
#include "src/app/logs.h"
#include "src/app/play/session.h"
#include "src/app/play/simulated.h"
#include "src/app/room_file.h"
#include "src/app/runtime.h"
#include "src/base/clock.h"
#include "src/base/file.h"
#include "src/base/log.h"

static const char help[] =
    "The room, live: on the OpenXR runtime that is active on this machine, or, where none is (or\n"
    "with --simulated), in the simulated headset's window. There WASD, Q and E move the head and the\n"
    "mouse turns it; hold 1 or 2 to move the left or right hand instead; left and right mouse button\n"
    "are trigger and squeeze. The balls are struck with the cue in both hands; or hold the right squeeze\n"
    "(right mouse button), look where the cue ball is to go, and pull the trigger (docs/play.md). The\n"
    "game is kept, and goes on at the next start (--new-game begins anew). M (a controller's menu button) opens the menu: settings, and what every\n"
    "button does; what is chosen there is kept in $XDG_CONFIG_HOME/antipode/play.json. Y on a left\n"
    "controller switches between native and tourist view, B on a right one shuts an eye, the other,\n"
    "neither; the left stick pressed (F12) takes a picture of both eyes. Ctrl-C or closing the window\n"
    "ends it. With a LOG the simulated headset replays it in real time instead of listening to the\n"
    "keys. Trackers that are plugged in move head and hands by themselves (antipode devices lists\n"
    "them), the keys what has none; R or a button of theirs makes where everybody looks the front.\n"
    "Detail is chosen for 30 frames a second, and said, unless the settings say full.\n" AP_LOG_HELP
    "\n" AP_ROOM_HELP;

static volatile sig_atomic_t signalled;

static void on_signal(int sig) {
    (void)sig;
    signalled = 1;
}

static bool end_asked(void) {
    return signalled;
}

struct play_options {
    struct ap_room_options room;
    const char *game, *lines, *record;
    const char *room_file, *headset, *stereo, *pictures, *clock;
    struct ap_live_options live;
    bool no_devices;
    struct ap_text_list inputs;
    bool new_game, simulated, no_window, older_vulkan, stats, no_settings;
    double seconds;
};

static bool is_virtual(const struct play_options *o) {
    return o->clock && strcmp(o->clock, "virtual") == 0;
}

// What is plugged in is used without being asked for.
static bool use_devices(const struct play_options *o, bool given, int log_count) {
    if (given || log_count > 0 || o->no_devices || is_virtual(o) || !ap_live_is_plugged(&o->live))
        return given;
    ap_log(AP_LOG_INFO, "play: trackers are plugged in and move head and hands (--no-devices: the "
                        "keys do)");
    return true;
}

// The active runtime, or the simulated headset where there is none.
static enum ap_status choose_runtime(struct ap_error *err, const struct play_options *o,
                                     char **logs, int log_count, char settings[64],
                                     bool *simulated) {
    enum ap_status st = ap_live_options_check(err, &o->live);
    if (!st && o->no_devices && ap_live_options_given(&o->live))
        st = ap_fail(err, AP_USAGE,
                     "--no-devices, and --device, --position, --replay or --bus: not both");
    if (st)
        return st;
    char *configured = ap_runtime_configured();
    bool given = ap_live_options_given(&o->live);
    *simulated = o->simulated || log_count > 0 || o->headset || given || !configured;
    free(configured);
    if (given && log_count > 0)
        return ap_fail(err, AP_USAGE,
                       "--device, --position, --replay, --bus: where the head is can come "
                       "from a log or from devices, not from both");
    bool live = *simulated && use_devices(o, given, log_count);
    char *inputs[AP_TEXT_LIST_MAX];
    for (size_t i = 0; i < o->inputs.count; i++)
        inputs[i] = (char *)(uintptr_t)o->inputs.text[i];
    const struct ap_play_simulated how = {.headset = o->headset,
                                          .layout = o->stereo ? o->stereo : "left",
                                          .window = !o->no_window,
                                          .virtual_clock = is_virtual(o),
                                          .walk_s = o->seconds,
                                          .logs = logs,
                                          .inputs = inputs,
                                          .log_count = log_count,
                                          .input_count = (int)o->inputs.count,
                                          .live = live ? &o->live : NULL,
                                          .stats = o->stats};
    return *simulated ? ap_play_simulate(err, &how, settings) : AP_OK;
}

static enum ap_status read_settings(struct ap_error *err, const struct play_options *o,
                                    struct ap_play_settings *settings, char **path) {
    *settings = ap_play_settings_standard();
    *path = o->no_settings ? NULL : ap_play_settings_path();
    return *path ? ap_play_settings_read(err, *path, settings) : AP_OK;
}

static void say_stats(const struct ap_play *play, int64_t start_ns) {
    struct ap_play_stats stats = ap_play_stats(play);
    double seconds = (double)(ap_clock_now_ns() - start_ns) * 1e-9;
    printf("%lld frames in %.2f s, %lld drawn\n", (long long)stats.frames, seconds,
           (long long)stats.drawn);
    printf("%lld strikes of the cue\n", (long long)stats.strikes);
    ap_play_say_detail(play);
}

// Where the table stands: as --room says, or on a real headset as `antipode calibrate table` found.
static enum ap_status use_room_file(struct ap_error *err, const char *asked, bool simulated,
                                    struct ap_room_defaults *defaults) {
    char *path = NULL;
    if (asked || simulated || ap_config_path(NULL, "room.json", &path))
        return ap_room_file_apply(err, asked, defaults);
    enum ap_status st = AP_OK;
    if (ap_file_exists(path)) {
        st = ap_room_file_apply(err, path, defaults);
        ap_log(AP_LOG_INFO, "play: the table stands as calibrated in %s", path);
    }
    free(path);
    return st;
}

static enum ap_status play_it(struct ap_error *err, const struct play_options *o, char **logs,
                              int log_count) {
    struct ap_play *play = NULL;
    char simulated_path[64] = "", *settings_path = NULL;
    bool simulated = false;
    struct ap_play_params params = {.room = o->room,
                                    .game = o->game,
                                    .lines = o->lines,
                                    .record = o->record,
                                    .keep_game = !o->no_settings,
                                    .new_game = o->new_game,
                                    .pictures = o->pictures,
                                    .older_vulkan = o->older_vulkan};
    enum ap_status st = read_settings(err, o, &params.settings, &settings_path);
    if (!st)
        st = choose_runtime(err, o, logs, log_count, simulated_path, &simulated);
    struct ap_room_defaults room = {.table_at = &params.room.table_at,
                                    .table_height_m = &params.room.table_height_m,
                                    .table_edge_m = &params.room.table_edge_m,
                                    .radius_given =
                                        !isnan(params.room.radius_m) || params.room.scene};
    if (!st)
        st = use_room_file(err, o->room_file, simulated, &room);
    int64_t start_ns = ap_clock_now_ns();
    params.settings_path = settings_path;
    params.one_eye = !st && simulated && !o->no_window && !o->stereo;
    if (!st)
        st = ap_play_open(err, &params, &play);
    if (simulated_path[0])
        unlink(simulated_path);
    bool unlimited = isnan(o->seconds) || is_virtual(o);
    int64_t end_ns = unlimited ? INT64_MAX : start_ns + (int64_t)(o->seconds * 1e9);
    if (!st)
        st = ap_play_run(err, play, end_asked, end_ns);
    if (!st && o->stats)
        say_stats(play, start_ns);
    ap_play_close(play);
    free(settings_path);
    return st;
}

static enum ap_status run(struct ap_error *err, int argc, char **argv) {
    struct play_options o = {.room = AP_ROOM_OPTIONS_NONE, .seconds = NAN};
    const struct ap_option options[] = {
        AP_ROOM_OPTION_TABLE(o.room),
        AP_LIVE_OPTION_TABLE(o.live),
        {"no-devices", AP_OPTION_FLAG, &o.no_devices, "", "not what is plugged in, but the keys"},
        {"room", AP_OPTION_TEXT, &o.room_file, "FILE",
         "table's place, height and edge as calibrated"},
        {"game", AP_OPTION_CHOICE, &o.game, "free|eight-ball|nine-ball|none",
         "what is played (default: the settings', free)"},
        {"new-game", AP_OPTION_FLAG, &o.new_game, "", "do not go on with the game that is kept"},
        {"lines", AP_OPTION_CHOICE, &o.lines, "on|off", "the path of the next shot (off)"},
        {"record", AP_OPTION_TEXT, &o.record, "DIR", "write the session down, to be replayed"},
        {"headset", AP_OPTION_TEXT, &o.headset, "FILE", "profile of the simulated headset"},
        {"stereo", AP_OPTION_CHOICE, &o.stereo, "pair|cross|anaglyph",
         "both eyes in the window (default: the left one)"},
        {"input", AP_OPTION_LIST, &o.inputs, "LOG", "buttons and sticks of the simulated headset"},
        {"pictures", AP_OPTION_TEXT, &o.pictures, "DIR", "where pictures of both eyes go (.)"},
        {"simulated", AP_OPTION_FLAG, &o.simulated, "",
         "the simulated headset, whatever is active"},
        {"no-window", AP_OPTION_FLAG, &o.no_window, "", "no window: poses from the scripted walk"},
        {"clock", AP_OPTION_CHOICE, &o.clock, "real|virtual",
         "of the simulated headset; virtual: every frame, however long it takes"},
        {"no-settings", AP_OPTION_FLAG, &o.no_settings, "",
         "do not read nor keep settings and game"},
        {"older-vulkan", AP_OPTION_FLAG, &o.older_vulkan, "",
         "XR_KHR_vulkan_enable, where the runtime's _enable2 does not work"},
        {"seconds", AP_OPTION_NUMBER, &o.seconds, "S", "end after so long"},
        {"stats", AP_OPTION_FLAG, &o.stats, "", "say at the end how many frames were drawn"},
    };
    const struct ap_usage usage = {.command = "play",
                                   .operands = "[LOG...]",
                                   .text = help,
                                   .options = options,
                                   .option_count = sizeof options / sizeof options[0],
                                   .max_operands = -1};
    int logs;
    bool done;
    enum ap_status st = ap_parse_options(err, &usage, argc, argv, &logs, &done);
    if (st || done)
        return st;
    signal(SIGINT, on_signal);
    signal(SIGTERM, on_signal);
    return play_it(err, &o, argv + 1, logs);
}

const struct ap_command ap_command_play = {
    "play", "walk about in the room, with a headset or in a window", run};
