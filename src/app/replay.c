#include "src/app/replay.h"

#include <dirent.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "src/app/command.h"
#include "src/app/logs.h"
#include "src/app/page.h"
#include "src/app/progress.h"
#include "src/app/room_file.h"
#include "src/app/runtime.h"
#include "src/app/vergence.h"
#include "src/base/log.h"
#include "src/device/poselog.h"
#include "src/track/setup.h"

static const char help[] =
    "Replays pose logs through the simulated headset into curved space, headless, on a virtual\n"
    "clock: every frame is stepped, the chosen ones are drawn and captured. DIR gets the stereo\n"
    "pairs, side-by-side and red-cyan pictures, a contact sheet, frames.csv, views.csv, timing.csv,\n"
    "vergence.csv and index.html, a page to open in a browser. All but timing.csv is the same byte\n"
    "for byte in two runs. Ctrl-C ends it early; what was written stays whole.\n" AP_LOG_HELP
    "\n" AP_ROOM_HELP;

struct options {
    struct ap_room_options room;
    struct ap_log_options logs;
    const char *headset, *frames, *dir, *game, *shots, *saved;
    double pictures; // NAN: as --frames says
    bool force, stats;
};

static enum ap_status check_dir(struct ap_error *err, const struct options *o) {
    static const char *const signs[] = {"capture.json", "frames.csv", "index.html"};
    for (size_t i = 0; i < sizeof signs / sizeof signs[0]; i++) {
        char *path = ap_path_join(o->dir, signs[i]);
        bool there = path && ap_file_exists(path);
        free(path);
        if (there && !o->force)
            return ap_fail(
                err, AP_USAGE,
                "%s holds a capture already: give another --out, or --force to replace it", o->dir);
    }
    return ap_make_dirs(err, o->dir);
}

static bool is_picture(const char *name) {
    static const char *const kinds[] = {"-left.png", "-right.png", "-sbs.png", "-anaglyph.png"};
    size_t digits = strspn(name, "0123456789");
    for (size_t i = 0; digits >= 6 && i < sizeof kinds / sizeof kinds[0]; i++)
        if (strcmp(name + digits, kinds[i]) == 0)
            return true;
    return false;
}

static bool is_capture_file(const char *name) {
    static const char *const names[] = {"capture.json",      "frames.csv",  "views.csv",
                                        "timing.csv",        "index.html",  "vergence.csv",
                                        "vergence.png",      "contact.png", "frames.jsonl",
                                        "frames.jsonl.part", "game.json"};
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++)
        if (strcmp(name, names[i]) == 0)
            return true;
    // What a killed run left: ".NAME.PID-COUNT.part".
    size_t len = strlen(name);
    if (name[0] == '.' && len > 5 && strcmp(name + len - 5, ".part") == 0)
        return true;
    return is_picture(name);
}

// A capture's own files go, so that an older run's pictures are not taken for this one's; whatever
// else lies there stays.
static void clear_dir(const char *dir) {
    DIR *d = opendir(dir);
    if (!d)
        return;
    for (struct dirent *e = readdir(d); e; e = readdir(d))
        if (is_capture_file(e->d_name))
            unlinkat(dirfd(d), e->d_name, 0);
    closedir(d);
}

static enum ap_status read_timeline(struct ap_error *err, const struct ap_log_options *options,
                                    char *const *logs, int count, struct ap_timeline **timeline) {
    struct ap_poselog *log;
    enum ap_status st = ap_logs_open(err, options, logs, count, &log);
    if (st)
        return st;
    st = ap_timeline_load(err, log, timeline);
    ap_logs_warn_skipped(log);
    ap_poselog_close(log);
    return st;
}

static enum ap_status read_headset(struct ap_error *err, const char *path,
                                   struct ap_headset_profile *profile) {
    if (path)
        return ap_headset_read(err, path, profile);
    *profile = ap_headset_builtin();
    return AP_OK;
}

// Leaves out frames whose pictures did not reach the disk (an interrupted run).
static size_t whole_frames(const struct ap_replay *replay) {
    size_t n = 0;
    for (size_t i = 0; i < replay->captured_count; i++) {
        bool whole = true;
        for (int eye = 0; eye < 2; eye++) {
            char name[64];
            snprintf(name, sizeof name, "%06lld-%s.png", (long long)replay->captured[i],
                     eye ? "right" : "left");
            char *path = ap_path_join(replay->dir, name);
            whole = whole && path && ap_file_exists(path);
            free(path);
        }
        if (whole)
            replay->captured[n++] = replay->captured[i];
    }
    return n;
}

static void show_pictures(void *data, int64_t done, int64_t total) {
    (void)data;
    ap_progress_show("pictures", done, total);
}

// From what the loop left on disk to the page: everything here can be made again from DIR.
static enum ap_status finish(struct ap_error *err, const struct ap_replay *replay) {
    struct ap_capture capture;
    enum ap_status st = ap_capture_read(err, replay->dir, &capture);
    if (st)
        return st;
    struct ap_vergence_row *rows = NULL;
    size_t count = 0;
    const struct ap_progress progress = {.step = show_pictures};
    st = ap_pictures_write(err, &capture, &progress);
    ap_progress_end();
    if (!st)
        st = ap_vergence_measure(err, &capture, &rows, &count);
    if (!st)
        st = ap_vergence_write(err, &capture, rows, count);
    if (!st)
        st = ap_page_write(err, &capture, rows, count);
    free(rows);
    ap_capture_finish(&capture);
    return st;
}

// The command line as it was given, but for --out, so that two runs leave the same bytes.
static void keep_command(char *text, size_t size, int argc, char **argv) {
    size_t n = (size_t)snprintf(text, size, "antipode");
    for (int i = 0; i < argc && n < size; i++) {
        if (strcmp(argv[i], "--out") == 0)
            i++;
        else if (strncmp(argv[i], "--out=", 6) != 0 && strcmp(argv[i], "--force") != 0)
            n += (size_t)snprintf(text + n, size - n, " %s", argv[i]);
    }
}

static void print_stats(const struct ap_replay *replay) {
    const struct ap_replay_totals *t = &replay->totals;
    double views = t->drawn > 0 ? 2.0 * (double)t->drawn : 1;
    printf("frames: %lld stepped, %lld drawn\n", (long long)t->stepped, (long long)t->drawn);
    printf(
        "an eye, on average: %.1f draws (%.1f of them behind s3's antipode), %.1f culled (%.1f of them turned away, %.1f behind what is before s3's antipode), "
        "%.0f triangles, %.0f vertices mapped\n",
        (double)t->draws / views, (double)t->back_draws / views, (double)t->culled / views,
        (double)t->turned_away / views, (double)t->back_hidden / views,
        (double)t->triangles / views, (double)t->vertices / views);
    printf("a frame, on average: %.1f parts with triangles of their own (%.0f of those left out: "
           "out of sight or turned away), %.2f beyond --max-error (%.2f of them for the budget), "
           "%.2f out of domain\n",
           2 * (double)t->refined / views, 2 * (double)t->unseen_facets / views,
           2 * (double)t->beyond_bound / views, 2 * (double)t->over_budget / views,
           2 * (double)t->out_of_domain / views);
    printf("drawing, ms a frame: placing, culling and refining %.2f, recording %.2f, submitting "
           "%.2f; the GPU %.2f\n",
           2 * t->place_ms / views, 2 * t->record_ms / views, 2 * t->submit_ms / views,
           2 * t->gpu_ms / views);
    double frames = views / 2;
    if (replay->room.scene->honeycomb)
        printf("a frame: %.0f cells drawn, %.0f out of view, %.0f behind walls, %.0f too small, "
               "%.0f over the budget; the head went on to another cell %lld times\n",
               (double)t->cells.visited / frames, (double)t->cells.cone / frames,
               (double)t->cells.walls / frames, (double)t->cells.size / frames,
               (double)t->cells.budget / frames, (long long)replay->room.cells_crossed);
    printf("memory: at most %.2f MiB of meshes, lists and cells, of a budget of %.3g MiB\n",
           (double)t->held_bytes / 1048576, (double)ap_scene_budget(replay->room.scene) / 1048576);
    printf("time: %.1f ms in all; wait %.1f, track %.1f, draw %.1f, end %.1f\n", t->run_ms,
           t->wait_ms, t->track_ms, t->draw_ms, t->end_ms);
}

static enum ap_status save_game(struct ap_error *err, const struct ap_replay *replay) {
    char *path = ap_path_join(replay->dir, "game.json");
    enum ap_status st = path ? AP_OK : ap_fail(err, AP_ENVIRONMENT, "out of memory");
    if (!st && !replay->interrupted)
        st = ap_table_play_finish(err, replay->play);
    if (!st)
        st = ap_game_save(err, &replay->play->game, path);
    free(path);
    return st;
}

static enum ap_status replay_into(struct ap_error *err, const char *log, const char *command,
                                  struct ap_replay *replay) {
    clear_dir(replay->dir);
    enum ap_status st = ap_replay_write_poses(err, replay);
    if (!st)
        st = ap_replay_write_settings(err, replay);
    char *settings = st ? NULL : ap_path_join(replay->dir, "sim.json");
    if (!st)
        st = ap_runtime_use_simulated(err, settings);
    free(settings);
    if (!st)
        st = ap_replay_tables_open(err, replay);
    if (st)
        return st;
    st = ap_replay_run(err, replay);
    if (st) {
        ap_replay_tables_abort(replay);
        return st;
    }
    st = ap_replay_tables_commit(err, replay);
    if (!st && replay->play)
        st = save_game(err, replay);
    replay->captured_count = whole_frames(replay);
    if (!st)
        st = ap_replay_write_capture(err, replay, log, command);
    return st ? st : finish(err, replay);
}

// "A:B:STEP" of what is to be drawn, once the number of frames is known.
static enum ap_status choose_frames(struct ap_error *err, const struct options *o,
                                    int64_t frame_count, char *text, size_t size) {
    struct ap_range range = AP_RANGE_ALL;
    if (o->frames && !isnan(o->pictures))
        return ap_fail(err, AP_USAGE, "--frames and --pictures contradict: give one of them");
    if (!isnan(o->pictures) && !(o->pictures >= 1))
        return ap_fail(err, AP_USAGE, "--pictures: expected a number of at least 1");
    if (!isnan(o->pictures))
        range.step = (int64_t)fmax(1, floor((double)frame_count / o->pictures));
    enum ap_status st = o->frames ? ap_range_parse(err, o->frames, &range) : AP_OK;
    if (!st && range.end == INT64_MAX)
        snprintf(text, size, "%lld::%lld", (long long)range.first, (long long)range.step);
    else if (!st)
        snprintf(text, size, "%lld:%lld:%lld", (long long)range.first, (long long)range.end,
                 (long long)range.step);
    return st;
}

static enum ap_status open_replay(struct ap_error *err, const struct options *o, char **logs,
                                  int log_count, struct ap_replay *replay) {
    enum ap_status st = read_headset(err, o->headset, &replay->headset);
    if (!st)
        st = ap_room_open(err, &o->room, &replay->room);
    const struct ap_table_play_params play = {o->game, o->shots, o->saved};
    if (!st && (o->game || o->shots || o->saved))
        st = ap_table_play_open(err, replay->room.scene, &play, &replay->play);
    if (!st)
        st = read_timeline(err, &o->logs, logs, log_count, &replay->timeline);
    if (st)
        return st;
    replay->frame_count = ap_timeline_frame_count(replay->timeline, replay->headset.refresh_hz);
    st = choose_frames(err, o, replay->frame_count, replay->frames, sizeof replay->frames);
    return st ? st : check_dir(err, o);
}

static enum ap_status run(struct ap_error *err, int argc, char **argv) {
    struct options o = {.room = AP_ROOM_OPTIONS_NONE,
                        .pictures = NAN,
                        .logs = AP_LOG_OPTIONS_NONE,
                        .dir = "antipode-out"};
    const struct ap_option options[] = {
        AP_ROOM_OPTION_TABLE(o.room),
        {"headset", AP_OPTION_TEXT, &o.headset, "FILE", "headset profile (default: standard)"},
        {"frames", AP_OPTION_TEXT, &o.frames, "A:B:STEP", "frames to draw, half open (all)"},
        {"pictures", AP_OPTION_NUMBER, &o.pictures, "N", "instead: about N, evenly over the log"},
        {"out", AP_OPTION_TEXT, &o.dir, "DIR", "where to write (antipode-out)"},
        {"force", AP_OPTION_FLAG, &o.force, "", "replace a capture in DIR"},
        {"game", AP_OPTION_CHOICE, &o.game, "free|eight-ball|nine-ball",
         "play: the balls move, DIR/game.json is the game at the end"},
        {"shots", AP_OPTION_TEXT, &o.shots, "FILE", "a script of shots (docs/billiards.md)"},
        {"saved", AP_OPTION_TEXT, &o.saved, "FILE", "go on with a saved game"},
        AP_LOG_OPTION_TABLE(o.logs),
        {"stats", AP_OPTION_FLAG, &o.stats, "", "say what was drawn, skipped and how long it took"},
    };
    const struct ap_usage usage = {.command = "replay",
                                   .operands = "LOG...",
                                   .text = help,
                                   .options = options,
                                   .option_count = sizeof options / sizeof options[0],
                                   .min_operands = 1,
                                   .max_operands = -1};
    char command[1024];
    keep_command(command, sizeof command, argc, argv);
    int logs;
    bool done;
    enum ap_status st = ap_parse_options(err, &usage, argc, argv, &logs, &done);
    if (st || done)
        return st;
    struct ap_room_defaults room = {.table_at = &o.logs.table_at,
                                    .table_height_m = &o.room.table_height_m,
                                    .table_edge_m = &o.room.table_edge_m,
                                    .radius_given = !isnan(o.room.radius_m) || o.room.scene};
    st = ap_room_file_apply(err, o.logs.room, &room);
    if (st)
        return st;
    struct ap_replay replay = {.dir = o.dir};
    st = open_replay(err, &o, argv + 1, logs, &replay);
    if (!st)
        st = replay_into(err, argv[1], command, &replay);
    if (!st && o.stats)
        print_stats(&replay);
    if (!st && replay.interrupted)
        st = ap_fail(err, AP_DIFFERS, "interrupted after frame %lld of %lld; %s/index.html says so",
                     (long long)replay.totals.stepped, (long long)replay.frame_count, o.dir);
    free(replay.captured);
    ap_table_play_close(replay.play);
    ap_timeline_destroy(replay.timeline);
    ap_room_close(&replay.room);
    return st;
}

const struct ap_command ap_command_replay = {
    "replay", "replay a pose log through the simulated headset into pictures", run};
