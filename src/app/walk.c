#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "src/app/command.h"
#include "src/device/poselog.h"
#include "src/device/timeline.h"
#include "src/device/walk.h"

// antipode walk: the scripted walk as a pose log, for whoever has no recording at hand.

static const char help[] =
    "Writes a pose log (CSV) to standard output: a person of 1.70 m walks round a square table,\n"
    "a hand on its edge, bends over it and aims with a cue, looks about, steps back, goes on. Rows\n"
    "for head, left and right at each time from 0; the same for the same options. One round is\n"
    "about 24 s and visits five edges; a longer walk repeats it, a shorter one is cut.\n"
    "    antipode walk | antipode track --space h3 -\n"
    "Exit statuses: 0; 2 usage; 4 the output cannot be written.";

struct options {
    struct ap_walk_params walk;
    double seed, refresh_hz;
};

static enum ap_status check_range(struct ap_error *err, const char *name, double value, double low,
                                  double high) {
    if (value >= low && value <= high)
        return AP_OK;
    return ap_fail(err, AP_USAGE, "--%s: expected a number from %g to %g; see antipode walk --help",
                   name, low, high);
}

static enum ap_status check(struct ap_error *err, struct options *o) {
    struct ap_walk_params *walk = &o->walk;
    enum ap_status st = check_range(err, "table-edge", walk->table_edge_m, 0.3, 100);
    if (!st)
        st = check_range(err, "table-height", walk->table_height_m, 0.2, 1.5);
    if (!st && walk->duration_s != 0)
        st = check_range(err, "seconds", walk->duration_s, 0.001, 1e6);
    if (!st)
        st = check_range(err, "hz", o->refresh_hz, 0.1, 10000);
    if (!st)
        st = check_range(err, "seed", o->seed, 1, 0x1p53);
    if (!st && o->seed != floor(o->seed))
        st = ap_fail(err, AP_USAGE, "--seed: expected a whole number; see antipode walk --help");
    if (!st)
        walk->seed = (uint64_t)o->seed;
    return st;
}

static enum ap_status parse(struct ap_error *err, int argc, char **argv, struct options *o,
                            bool *done) {
    const struct ap_option options[] = {
        {"table-edge", AP_OPTION_NUMBER, &o->walk.table_edge_m, "M", "edge of the table (0.9)"},
        {"table-height", AP_OPTION_NUMBER, &o->walk.table_height_m, "M",
         "its surface above the floor (0.75)"},
        {"seconds", AP_OPTION_NUMBER, &o->walk.duration_s, "S", "how long (one round)"},
        {"seed", AP_OPTION_NUMBER, &o->seed, "N", "of the body's sway (1)"},
        {"hz", AP_OPTION_NUMBER, &o->refresh_hz, "HZ", "samples per second (90)"},
    };
    const struct ap_usage usage = {.command = "walk",
                                   .operands = "",
                                   .text = help,
                                   .options = options,
                                   .option_count = sizeof options / sizeof *options};
    int operand_count;
    enum ap_status st = ap_parse_options(err, &usage, argc, argv, &operand_count, done);
    return st || *done ? st : check(err, o);
}

static enum ap_status write_walk(struct ap_error *err, const struct options *o) {
    static const char *const names[] = {"head", "left", "right"};
    double end_ns = ap_walk_duration_s(&o->walk) * 1e9;
    ap_poselog_write_header(stdout);
    for (int64_t k = 0; !ferror(stdout); k++) {
        int64_t t_ns = ap_frame_time_ns(0, k, o->refresh_hz);
        if ((double)t_ns > end_ns)
            break;
        for (int device = 0; device < 3; device++) {
            struct ap_sample sample = ap_walk_at(&o->walk, device, t_ns);
            ap_poselog_write_row(stdout, names[device], &sample);
        }
    }
    if (fflush(stdout) || ferror(stdout))
        return ap_fail(err, AP_ENVIRONMENT, "cannot write to standard output: %s", strerror(errno));
    return AP_OK;
}

static enum ap_status run(struct ap_error *err, int argc, char **argv) {
    struct options o = {
        .walk = {.table_edge_m = 0.9, .table_height_m = 0.75}, .seed = 1, .refresh_hz = 90};
    bool done = false;
    enum ap_status st = parse(err, argc, argv, &o, &done);
    return st || done ? st : write_walk(err, &o);
}

const struct ap_command ap_command_walk = {
    "walk", "write a scripted walk round the table as a pose log", run};
