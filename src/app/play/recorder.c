#include "src/app/play/recorder.h"

#include <math.h>
#include <stdlib.h>

#include "src/base/number.h"
#include "src/device/poselog.h"

static enum ap_status open_in(struct ap_error *err, const char *dir, const char *name,
                              struct ap_outfile *file) {
    char *path = ap_path_join(dir, name);
    enum ap_status st =
        path ? ap_outfile_open(err, path, file) : ap_fail(err, AP_ENVIRONMENT, "out of memory");
    free(path);
    return st;
}

static enum ap_status save_in(struct ap_error *err, const char *dir, const char *name,
                              const struct ap_game *game) {
    char *path = ap_path_join(dir, name);
    enum ap_status st =
        path ? ap_game_save(err, game, path) : ap_fail(err, AP_ENVIRONMENT, "out of memory");
    free(path);
    return st;
}

static bool holds_recording(const char *dir) {
    static const char *const names[] = {"start.json", "poses.csv", "inputs.csv", "shots.txt",
                                        "game.json"};
    bool any = false;
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        char *path = ap_path_join(dir, names[i]);
        any |= path && ap_file_exists(path);
        free(path);
    }
    return any;
}

enum ap_status ap_play_recorder_begin(struct ap_error *err, const char *dir,
                                      const struct ap_game *game, const char *command,
                                      struct ap_play_recorder *out) {
    struct ap_play_recorder r = {.last_ns = INT64_MIN, .open = true};
    if (holds_recording(dir))
        return ap_fail(err, AP_USAGE, "%s holds a recording already: choose another folder", dir);
    enum ap_status st = ap_make_dirs(err, dir);
    r.dir = st ? NULL : ap_path_join(dir, "");
    if (!st && !r.dir)
        st = ap_fail(err, AP_ENVIRONMENT, "out of memory");
    if (!st)
        st = save_in(err, dir, "start.json", game);
    if (!st)
        st = open_in(err, dir, "poses.csv", &r.poses);
    if (!st)
        st = open_in(err, dir, "inputs.csv", &r.inputs);
    if (!st)
        st = open_in(err, dir, "shots.txt", &r.shots);
    if (st) {
        ap_play_recorder_abort(&r);
        return st;
    }
    ap_poselog_write_header(r.poses.stream);
    fprintf(r.shots.stream, "# to see it again: %s\n", command);
    for (int i = 0; i < 20; i++)
        r.values[i / 10][i % 10] = NAN;
    *out = r;
    return AP_OK;
}

static void write_inputs(struct ap_play_recorder *r, int64_t t_ns, int hand,
                         const struct ap_xr_hand *h) {
    // As a Touch controller has them.
    static const char *const paths[2][10] = {
        {"trigger/value", "squeeze/value", "thumbstick", NULL, "x/click", "y/click", "menu/click",
         "thumbstick/click", NULL, NULL},
        {"trigger/value", "squeeze/value", "thumbstick", NULL, "a/click", "b/click", NULL,
         "thumbstick/click", NULL, NULL}};
    const double now[10] = {(double)h->trigger,
                            (double)h->squeeze,
                            (double)h->stick_x,
                            (double)h->stick_y,
                            h->primary,
                            h->secondary,
                            h->menu,
                            h->stick_click};
    double *was = r->values[hand];
    for (int i = 0; i < 10; i++) {
        bool stick = i == 2;
        if (!paths[hand][i] || (now[i] == was[i] && !(stick && now[3] != was[3])))
            continue;
        char a[AP_DOUBLE_TEXT_MAX], b[AP_DOUBLE_TEXT_MAX];
        int na = (int)ap_format_double(a, now[i]), nb = (int)ap_format_double(b, now[3]);
        fprintf(r->inputs.stream, "%lld,%s,/input/%s,%.*s%s%.*s\n", (long long)t_ns,
                hand ? "right" : "left", paths[hand][i], na, a, stick ? "," : "", stick ? nb : 0,
                b);
    }
    for (int i = 0; i < 10; i++)
        was[i] = now[i];
}

static void write_pose(struct ap_play_recorder *r, int64_t t_ns, const char *device,
                       const struct ap_xr_located *located, const struct ap_xr_hand *hand) {
    struct ap_pose p = located->pose;
    if (!located->valid || !located->tracked ||
        !isfinite(p.p.x + p.p.y + p.p.z + p.q.x + p.q.y + p.q.z + p.q.w))
        return;
    const struct ap_sample sample = {.t_ns = t_ns,
                                     .pose = p,
                                     .trigger = hand ? hand->trigger : 0,
                                     .squeeze = hand ? hand->squeeze : 0,
                                     .select = hand && hand->select};
    ap_poselog_write_row(r->poses.stream, device, &sample);
}

void ap_play_recorder_frame(struct ap_play_recorder *r, int64_t t_ns,
                            const struct ap_xr_frame *frame) {
    if (!r->open || t_ns <= r->last_ns)
        return;
    r->last_ns = t_ns;
    write_pose(r, t_ns, "head", &frame->head, NULL);
    for (int h = 0; h < 2; h++) {
        write_pose(r, t_ns, h ? "right" : "left", &frame->hand[h].grip, &frame->hand[h]);
        write_inputs(r, t_ns, h, &frame->hand[h]);
    }
}

void ap_play_recorder_line(struct ap_play_recorder *r, const char *line) {
    if (r->open)
        fprintf(r->shots.stream, "%s\n", line);
}

enum ap_status ap_play_recorder_finish(struct ap_error *err, struct ap_play_recorder *r,
                                       const struct ap_game *game) {
    if (!r->open)
        return AP_OK;
    char end[AP_DOUBLE_TEXT_MAX];
    int n = (int)ap_format_double(end, game->physics.now_s);
    fprintf(r->shots.stream, "end time=%.*s\n", n, end);
    enum ap_status st = save_in(err, r->dir, "game.json", game);
    if (!st)
        st = ap_outfile_commit(err, &r->poses);
    if (!st)
        st = ap_outfile_commit(err, &r->inputs);
    if (!st)
        st = ap_outfile_commit(err, &r->shots);
    ap_play_recorder_abort(r);
    return st;
}

void ap_play_recorder_abort(struct ap_play_recorder *r) {
    ap_outfile_abort(&r->poses);
    ap_outfile_abort(&r->inputs);
    ap_outfile_abort(&r->shots);
    free(r->dir);
    *r = (struct ap_play_recorder){.open = false};
}
