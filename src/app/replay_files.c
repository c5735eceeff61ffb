#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "src/app/replay.h"
#include "src/base/json.h"
#include "src/base/number.h"
#include "src/device/poselog.h"

static enum ap_status open_in(struct ap_error *err, const char *dir, const char *name,
                              struct ap_outfile *file) {
    char *path = ap_path_join(dir, name);
    if (!path)
        return ap_fail(err, AP_ENVIRONMENT, "out of memory");
    enum ap_status st = ap_outfile_open(err, path, file);
    free(path);
    return st;
}

enum ap_status ap_replay_tables_open(struct ap_error *err, struct ap_replay *replay) {
    struct ap_replay_tables *t = &replay->tables;
    enum ap_status st = open_in(err, replay->dir, "frames.csv", &t->frames);
    if (!st)
        st = open_in(err, replay->dir, "views.csv", &t->views);
    if (!st)
        st = open_in(err, replay->dir, "timing.csv", &t->timing);
    if (st) {
        ap_replay_tables_abort(replay);
        return st;
    }
    fputs("frame,t_ns,device,state,px,py,pz,qx,qy,qz,qw,m00,m01,m02,m03,m10,m11,m12,m13,"
          "m20,m21,m22,m23,m30,m31,m32,m33\n",
          t->frames.stream);
    fputs("frame,eye,fov_left_rad,fov_right_rad,fov_up_rad,fov_down_rad,draws,culled,back_draws,"
          "triangles,vertices,cells,cells_out_of_view,cells_too_small,cells_over_budget,"
          "cells_behind_walls,turned_away,back_hidden,refined,beyond_bound,over_budget,"
          "out_of_domain\n",
          t->views.stream);
    fputs("frame,wait_ms,track_ms,draw_ms,end_ms,place_ms,record_ms,submit_ms,gpu_ms\n",
          t->timing.stream);
    return AP_OK;
}

enum ap_status ap_replay_tables_commit(struct ap_error *err, struct ap_replay *replay) {
    struct ap_replay_tables *t = &replay->tables;
    enum ap_status st = ap_outfile_commit(err, &t->frames);
    if (!st)
        st = ap_outfile_commit(err, &t->views);
    if (!st)
        st = ap_outfile_commit(err, &t->timing);
    ap_replay_tables_abort(replay);
    return st;
}

void ap_replay_tables_abort(struct ap_replay *replay) {
    ap_outfile_abort(&replay->tables.frames);
    ap_outfile_abort(&replay->tables.views);
    ap_outfile_abort(&replay->tables.timing);
}

static void write_numbers(FILE *out, const double *values, int count) {
    for (int i = 0; i < count; i++) {
        char text[AP_DOUBLE_TEXT_MAX];
        ap_format_double(text, values[i]);
        fprintf(out, ",%s", text);
    }
}

void ap_replay_write_frame_row(struct ap_replay *replay, const struct ap_frame_row *row) {
    FILE *out = replay->tables.frames.stream;
    fprintf(out, "%lld,%lld,%s,%s", (long long)row->frame, (long long)row->t_ns, row->device,
            ap_pose_state_name(row->state));
    const struct ap_pose *p = &row->pose;
    const double pose[] = {p->p.x, p->p.y, p->p.z, p->q.x, p->q.y, p->q.z, p->q.w};
    write_numbers(out, pose, 7);
    if (row->has_row)
        write_numbers(out, &row->world_from_device.m[0][0], 16);
    else
        fputs(",,,,,,,,,,,,,,,,", out);
    fputc('\n', out);
}

void ap_replay_write_view_rows(struct ap_replay *replay, int64_t frame,
                               const struct ap_xr_view views[2],
                               const struct ap_frame_stats *stats) {
    FILE *out = replay->tables.views.stream;
    for (int eye = 0; eye < 2; eye++) {
        const struct ap_xr_view *v = &views[eye];
        const struct ap_eye_stats *s = &stats->eye[eye];
        const double fov[] = {v->left_rad, v->right_rad, v->up_rad, v->down_rad};
        fprintf(out, "%lld,%s", (long long)frame, eye ? "right" : "left");
        write_numbers(out, fov, 4);
        fprintf(out, ",%u,%u,%u,%llu,%llu,%u,%u,%u,%u,%u,%u,%u,%u,%u,%u,%u\n", s->draws, s->culled,
                s->back_draws, (unsigned long long)s->triangles, (unsigned long long)s->vertices,
                stats->cells.visited, stats->cells.cone, stats->cells.size, stats->cells.budget,
                stats->cells.walls, s->turned_away, s->back_hidden, stats->refined,
                stats->beyond_bound, stats->over_budget, stats->out_of_domain);
    }
}

void ap_replay_write_timing(struct ap_replay *replay, int64_t frame,
                            const struct ap_replay_times *t) {
    FILE *out = replay->tables.timing.stream;
    fprintf(out, "%lld,%.4f,%.4f,%.4f,%.4f,%.4f,%.4f,%.4f,", (long long)frame, t->wait_ms,
            t->track_ms, t->draw_ms, t->end_ms, t->place_ms, t->record_ms, t->submit_ms);
    if (isnan(t->gpu_ms))
        fputc('\n', out);
    else
        fprintf(out, "%.4f\n", t->gpu_ms);
}

enum ap_status ap_replay_write_poses(struct ap_error *err, const struct ap_replay *replay) {
    const struct ap_timeline *timeline = replay->timeline;
    struct ap_outfile file;
    enum ap_status st = open_in(err, replay->dir, "poses.csv", &file);
    if (st)
        return st;
    ap_poselog_write_header(file.stream);
    int64_t count = ap_timeline_sample_count(timeline);
    for (int64_t i = 0; i < count; i++) {
        struct ap_sample sample = ap_timeline_sample(timeline, i);
        ap_poselog_write_row(file.stream, ap_timeline_device_name(timeline, sample.device),
                             &sample);
    }
    return ap_outfile_commit(err, &file);
}

enum ap_status ap_replay_write_settings(struct ap_error *err, const struct ap_replay *replay) {
    json_t *root = json_pack("{s:o, s:{s:[s]}, s:s, s:{s:s, s:s}}", "headset",
                             ap_headset_to_json(&replay->headset), "poses", "logs", "./poses.csv",
                             "clock", "virtual", "capture", "dir", ".", "frames", replay->frames);
    char *text = root ? json_dumps(root, JSON_INDENT(2) | JSON_REAL_PRECISION(17)) : NULL;
    json_decref(root);
    char *path = ap_path_join(replay->dir, "sim.json");
    enum ap_status st = text && path ? ap_file_write(err, path, text, strlen(text))
                                     : ap_fail(err, AP_ENVIRONMENT, "out of memory");
    free(path);
    free(text);
    return st;
}
