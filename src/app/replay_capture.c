#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "src/app/replay.h"

// capture.json: what makes the folder tell its own story (capture_dir.h).

static size_t count_targets(const struct ap_scene *scene) {
    size_t n = 0;
    for (size_t i = 0; i < scene->part_count; i++)
        n += scene->parts[i].target;
    return n;
}

static void fill_targets(const struct ap_scene *scene, struct ap_capture *capture) {
    const struct ap_vec4 base = {0, 0, 0, scene->space.rho_m};
    for (size_t i = 0; i < scene->part_count; i++) {
        const struct ap_part *part = &scene->parts[i];
        if (!part->target)
            continue;
        struct ap_capture_target *t = &capture->targets[capture->target_count++];
        snprintf(t->name, sizeof t->name, "%s", part->name);
        for (int c = 0; c < 3; c++)
            t->color[c] = (uint8_t)lrint(part->color_srgb[c] * 255);
        t->at = ap_iso_apply(&part->carrier_from_part, base);
        t->radius_m = part->radius_m;
    }
}

static const char *base_name(const char *path) {
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

enum ap_status ap_replay_write_capture(struct ap_error *err, const struct ap_replay *replay,
                                       const char *log, const char *command) {
    const struct ap_scene *scene = replay->room.scene;
    struct ap_capture capture = {.space = scene->space,
                                 .view = replay->room.view,
                                 .born = replay->room.born,
                                 .headset = replay->headset,
                                 .total_frames = replay->frame_count,
                                 .table_edge_m = replay->room.tracker_params.table_edge_m,
                                 .table_height_m = replay->room.tracker_params.table_height_m,
                                 .has_table = replay->room.has_table,
                                 .interrupted = replay->interrupted};
    snprintf(capture.tracker, sizeof capture.tracker, "%s",
             ap_tracker_kind_name(replay->room.tracker_params.kind));
    snprintf(capture.log_name, sizeof capture.log_name, "%s", base_name(log));
    snprintf(capture.command, sizeof capture.command, "%s", command);
    for (int c = 0; c < 3; c++)
        capture.background[c] = (uint8_t)lrint(scene->background_srgb[c] * 255);
    capture.targets = calloc(count_targets(scene) + 1, sizeof *capture.targets);
    capture.frames = calloc(replay->captured_count + 1, sizeof *capture.frames);
    enum ap_status st = AP_OK;
    if (capture.targets && capture.frames) {
        fill_targets(scene, &capture);
        capture.frame_count = replay->captured_count;
        for (size_t i = 0; i < replay->captured_count; i++)
            capture.frames[i].frame = replay->captured[i];
        st = ap_capture_write(err, replay->dir, &capture);
    } else {
        st = ap_fail(err, AP_ENVIRONMENT, "out of memory");
    }
    free(capture.targets);
    free(capture.frames);
    return st;
}
