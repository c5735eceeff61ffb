#ifndef ANTIPODE_APP_REPLAY_H
#define ANTIPODE_APP_REPLAY_H

#include <stdbool.h>
#include <stdint.h>

#include "src/app/capture_dir.h"
#include "src/app/room.h"
#include "src/app/table_play.h"
#include "src/base/file.h"
#include "src/base/range.h"
#include "src/device/headset.h"
#include "src/device/timeline.h"
#include "src/render/renderer.h"

// `antipode replay`: replay.c reads the command line and runs the stages, replay_loop.c is the
// frame loop, replay_files.c writes the tables and replay_capture.c capture.json.

// The tables of a capture, open while the loop runs; committed together at its end.
struct ap_replay_tables {
    struct ap_outfile frames, views, timing;
};

// Where the time of a run went, ms, and what was drawn: for timing.csv and --stats.
struct ap_replay_totals {
    int64_t stepped, drawn;
    double wait_ms, track_ms, draw_ms, end_ms, run_ms;
    uint64_t draws, culled, turned_away, back_hidden, back_draws, triangles, vertices;
    uint64_t refined, beyond_bound, over_budget; // parts·images (struct ap_frame_stats)
    uint64_t out_of_domain;
    uint64_t unseen_facets;                        // triangles
    double place_ms, record_ms, submit_ms, gpu_ms; // of draw_ms but the last
    size_t held_bytes;                             // at the most
    struct {
        uint64_t visited, cone, walls, size, budget;
    } cells; // of a world of cells
};

struct ap_replay {
    const char *dir;
    struct ap_room room;
    struct ap_table_play *play; // NULL: the balls lie
    struct ap_timeline *timeline;
    struct ap_headset_profile headset;
    int64_t frame_count;
    char frames[80]; // "A:B:STEP": those that are drawn
    struct ap_replay_tables tables;
    struct ap_replay_totals totals;
    int64_t *captured; // frame numbers, in order
    size_t captured_count, captured_room;
    bool interrupted;
};

// Opens frames.csv, views.csv and timing.csv in replay->dir and writes their headers.
enum ap_status ap_replay_tables_open(struct ap_error *err, struct ap_replay *replay);
enum ap_status ap_replay_tables_commit(struct ap_error *err, struct ap_replay *replay);
void ap_replay_tables_abort(struct ap_replay *replay);

struct ap_frame_row {
    int64_t frame, t_ns;
    const char *device;
    enum ap_pose_state state;
    struct ap_pose pose; // in the table's frame
    bool has_row;        // false: no virtual pose (a hand before the head), columns empty
    struct ap_iso world_from_device;
};
void ap_replay_write_frame_row(struct ap_replay *replay, const struct ap_frame_row *row);
void ap_replay_write_view_rows(struct ap_replay *replay, int64_t frame,
                               const struct ap_xr_view views[2],
                               const struct ap_frame_stats *stats);
// Milliseconds of one frame that was drawn.
struct ap_replay_times {
    double wait_ms, track_ms, draw_ms, end_ms;
    double place_ms, record_ms, submit_ms; // of draw_ms
    double gpu_ms;                         // NAN: not known
};
void ap_replay_write_timing(struct ap_replay *replay, int64_t frame,
                            const struct ap_replay_times *times);

// DIR/poses.csv: the merged log in the table's frame, which the simulated headset replays.
// DIR/sim.json: the simulated headset's settings.
enum ap_status ap_replay_write_poses(struct ap_error *err, const struct ap_replay *replay);
enum ap_status ap_replay_write_settings(struct ap_error *err, const struct ap_replay *replay);

// DIR/capture.json.
enum ap_status ap_replay_write_capture(struct ap_error *err, const struct ap_replay *replay,
                                       const char *log, const char *command);

// Runs the whole log through the headset. SIGINT and SIGTERM end it early: replay->interrupted;
// they stay caught, so that the pages can be written too.
enum ap_status ap_replay_run(struct ap_error *err, struct ap_replay *replay);

#endif
