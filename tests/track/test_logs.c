#include <stdlib.h>
#include <string.h>

#include "src/device/poselog.h"
#include "tests/track/continuity.h"
#include "tests/samples.h"
#include "tests/track/support.h"

// Whole recordings of real people against the twin, sample by sample. They lie outside the
// repository: the folder that ANTIPODE_SHARED names holds data/poses.

enum { SKIPPED = 77 };

static const char *folder;

struct recording {
    const char *name;
    const char *sources[3];
    size_t source_count;
    double table_x_m, table_z_m, table_yaw_rad;
    double s3_edge_m, h3_edge_m; // of the table; NAN: the default
};

static const struct recording vive_room = {
    "vive_room",
    {"head=vive_room_head.tum", "left=vive_room_left.tum", "right=vive_room_right.tum"},
    3,
    0.5,
    -1.6,
    0.3,
    1.5,
    NAN};
static const struct recording vive_across = {
    "vive_room, across the table",
    {"left=vive_room_left.tum", "head=vive_room_head.tum", "right=vive_room_right.tum"},
    3,
    0.55,
    -1.0,
    -2,
    1.5,
    NAN};
static const struct recording desk_walk = {"desk_walk", {"desk_walk_head.csv"}, 1, 0, 0, 0, 2, NAN};
static const struct recording beat_saber = {"quest2_beatsaber",
                                            {"head=quest2_beatsaber_head.tum",
                                             "left=quest2_beatsaber_left.tum",
                                             "right=quest2_beatsaber_right.tum"},
                                            3,
                                            0,
                                            -1.2,
                                            0,
                                            2,
                                            NAN};

static struct ap_poselog *open_recording(const struct recording *r, char paths[3][1024]) {
    static const char *sources[3];
    for (size_t i = 0; i < r->source_count; i++) {
        const char *equals = strchr(r->sources[i], '=');
        int role = equals ? (int)(equals - r->sources[i]) + 1 : 0;
        snprintf(paths[i], 1024, "%.*s%s/data/poses/%s", role, r->sources[i], folder,
                 r->sources[i] + role);
        sources[i] = paths[i];
    }
    const struct ap_poselog_params params = {.sources = sources,
                                             .source_count = r->source_count,
                                             .has_table = true,
                                             .table_x_m = r->table_x_m,
                                             .table_z_m = r->table_z_m,
                                             .table_yaw_rad = r->table_yaw_rad};
    struct ap_error err;
    struct ap_poselog *log;
    if (ap_poselog_open(&err, &params, &log))
        fail_msg("%s", err.text);
    return log;
}

static void run(const struct recording *r, const char *space, double radius_m,
                enum ap_tracker_kind kind, int64_t at_least) {
    struct ap_error err;
    struct ap_tracker_params params;
    const double edge_m = strcmp(space, "s3") == 0 ? r->s3_edge_m : r->h3_edge_m;
    const struct ap_track_setup setup = {.space = space,
                                         .radius_m = radius_m,
                                         .tracker = kind,
                                         .table_edge_m = isnan(radius_m) ? edge_m : NAN,
                                         .table_height_m = 0.75};
    if (ap_track_setup(&err, &setup, &params))
        fail_msg("%s", err.text);
    struct pair pair = pair_of(&params);
    char paths[3][1024];
    struct ap_poselog *log = open_recording(r, paths);
    int64_t samples = 0;
    for (bool got = true;; samples++) {
        struct ap_sample sample;
        if (ap_poselog_next(&err, log, &sample, &got))
            fail_msg("%s", err.text);
        if (!got)
            break;
        pair_feed(&pair, ap_poselog_device_name(log, sample.device), sample.pose);
    }
    ap_poselog_close(log);
    if (samples < at_least)
        fail_msg("%s: %lld samples, expected %lld at least", r->name, (long long)samples,
                 (long long)at_least);
    char what[160];
    snprintf(what, sizeof what, "%s, %s %.3g, %s", r->name, space, params.space.rho_m,
             ap_tracker_kind_name(kind));
    pair_check(&pair, what);
    pair_finish(&pair);
}

// All of them, or h3 alone.
static int first_space(void) {
    return 3 - test_samples(3);
}

static void head_and_hands(void **state) {
    (void)state;
    static const char *const spaces[] = {"s3", "e3", "h3"};
    for (int s = first_space(); s < 3; s++)
        for (int kind = s == 2 ? 0 : 2; kind < 3; kind++) // h3 is where errors grow
            run(&vive_room, spaces[s], NAN, (enum ap_tracker_kind)kind, 7700);
    run(&vive_across, "h3", NAN, AP_TRACKER_BILLIARDS, 7700);
}

static void walk_round_the_desk(void **state) {
    (void)state;
    static const char *const spaces[] = {"s3", "e3", "h3"};
    for (int s = first_space(); s < 3; s++)
        run(&desk_walk, spaces[s], NAN, AP_TRACKER_BILLIARDS, 6900);
    run(&desk_walk, "h3", NAN, AP_TRACKER_ANCHOR, 6900);
}

// The integrating tracker drifts: in a small space so far that a double's rounding on the way is
// visible at the end.
static void far_drift(void **state) {
    (void)state;
    run(&desk_walk, "h3", 0.3, AP_TRACKER_NAIVE, 6900);
    run(&beat_saber, "h3", NAN, AP_TRACKER_NAIVE, 16000);
}

// What a player sees in a real room: a step of head or hands is a step in the world, bounded by
// what the place stretches; the hand jumps where it passes two edges from the head, and nothing
// else.
static void follow(const struct recording *r, const char *space) {
    struct ap_error err;
    struct ap_tracker_params params;
    const double edge_m = strcmp(space, "s3") == 0 ? r->s3_edge_m : r->h3_edge_m;
    const struct ap_track_setup setup = {.space = space,
                                         .radius_m = NAN,
                                         .tracker = AP_TRACKER_BILLIARDS,
                                         .table_edge_m = edge_m,
                                         .table_height_m = 0.75};
    if (ap_track_setup(&err, &setup, &params))
        fail_msg("%s", err.text);
    struct continuity k = continuity_of(&params);
    char paths[3][1024];
    struct ap_poselog *log = open_recording(r, paths);
    for (;;) {
        struct ap_sample sample;
        bool got;
        if (ap_poselog_next(&err, log, &sample, &got))
            fail_msg("%s", err.text);
        if (!got)
            break;
        const char *name = ap_poselog_device_name(log, sample.device);
        continuity_feed(&k,
                        strcmp(name, "head") == 0   ? 0
                        : strcmp(name, "left") == 0 ? 1
                                                    : 2,
                        sample.pose);
    }
    ap_poselog_close(log);
    assert_true(k.steps > 1000);
    continuity_finish(&k, r->name);
}

static void nothing_else_jumps(void **state) {
    (void)state;
    static const char *const spaces[] = {"s3", "e3", "h3"};
    static const struct recording *const recordings[] = {&vive_room, &vive_across, &desk_walk,
                                                         &beat_saber};
    for (int s = first_space(); s < 3; s++)
        for (int r = 0; r < 4; r++)
            follow(recordings[r], spaces[s]);
}

int main(void) {
    folder = getenv("ANTIPODE_SHARED");
    if (!folder) {
        printf("skipped: ANTIPODE_SHARED does not name the folder with the recordings\n");
        return SKIPPED;
    }
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(head_and_hands),
        cmocka_unit_test(walk_round_the_desk),
        cmocka_unit_test(far_drift),
        cmocka_unit_test(nothing_else_jumps),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
