#include <errno.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "src/app/command.h"
#include "src/app/logs.h"
#include "src/app/room_file.h"
#include "src/base/log.h"
#include "src/device/poselog.h"
#include "src/track/setup.h"
#include "src/track/text.h"

// antipode track: pose logs in, virtual poses out, a row at a time. Memory does not grow with the
// log.

static const char help[] =
    "Places every pose of the logs in the curved space and writes CSV to standard output:\n"
    "t_ns,device,m00,m01,...,m33, a row per sample in the order of the logs' times, the matrix from\n"
    "the device to the virtual world, 17 significant digits.\n" AP_LOG_HELP "\n"
    "A hand's samples before the head's first give no row (but in 'naive'), nor do those of others\n"
    "before the anchor's first; a warning counts them.\n"
    "Radius: --radius, else the table's for its edge (s3, h3), else 1.\n"
    "Exit statuses: 0; 2 usage; 3 a log that cannot be read; 4 the output cannot be written.";

struct options {
    const char *space, *tracker, *anchor;
    double radius_m, table_edge_m, table_height_m;
    struct ap_log_options logs;
};

static enum ap_status parse(struct ap_error *err, int argc, char **argv, struct options *o,
                            int *operand_count, bool *done) {
    const struct ap_option options[] = {
        {"space", AP_OPTION_CHOICE, &o->space, "h3|s3|e3", "the curved space (h3)"},
        {"radius", AP_OPTION_NUMBER, &o->radius_m, "M", "its radius in metres"},
        {"tracker", AP_OPTION_CHOICE, &o->tracker, "billiards|anchor|naive",
         "what the body hangs on (billiards)"},
        {"anchor", AP_OPTION_TEXT, &o->anchor, "DEVICE",
         "of the anchor tracker: head, left, right, hands or a name (head)"},
        {"table-edge", AP_OPTION_NUMBER, &o->table_edge_m, "M",
         "edge of the physical and the virtual table (0.9)"},
        {"table-height", AP_OPTION_NUMBER, &o->table_height_m, "M",
         "the table's surface above the floor (0.75)"},
        AP_LOG_OPTION_TABLE(o->logs),
    };
    const struct ap_usage usage = {.command = "track",
                                   .operands = "LOG…",
                                   .text = help,
                                   .options = options,
                                   .option_count = sizeof options / sizeof *options,
                                   .min_operands = 1,
                                   .max_operands = -1};
    return ap_parse_options(err, &usage, argc, argv, operand_count, done);
}

static enum ap_status open_tracker(struct ap_error *err, const struct options *o,
                                   struct ap_tracker **tracker) {
    struct ap_track_setup setup = {.space = o->space,
                                   .radius_m = o->radius_m,
                                   .table_edge_m = o->table_edge_m,
                                   .table_height_m = o->table_height_m,
                                   .anchor = o->anchor};
    struct ap_tracker_params params;
    enum ap_status st = ap_tracker_kind_from_name(err, o->tracker, &setup.tracker);
    if (!st)
        st = ap_track_setup(err, &setup, &params);
    return st ? st : ap_tracker_create(err, &params, tracker);
}

static enum ap_status write_failed(struct ap_error *err) {
    return ap_fail(err, AP_ENVIRONMENT, "cannot write to standard output: %s", strerror(errno));
}

static enum ap_status write_header(struct ap_error *err) {
    fputs("t_ns,device", stdout);
    for (int i = 0; i < 16; i++)
        printf(",m%d%d", i / 4, i % 4);
    return putchar('\n') == EOF ? write_failed(err) : AP_OK;
}

static enum ap_status write_row(struct ap_error *err, int64_t t_ns, const char *device,
                                const struct ap_iso *m) {
    char numbers[AP_ISO_TEXT_MAX + 1];
    size_t len = ap_iso_text(numbers, m);
    numbers[len++] = '\n';
    bool written =
        printf("%" PRId64 ",%s,", t_ns, device) > 0 && fwrite(numbers, 1, len, stdout) == len;
    return written ? AP_OK : write_failed(err);
}

static enum ap_status write_rows(struct ap_error *err, struct ap_poselog *log,
                                 struct ap_tracker *tracker) {
    enum ap_status st = write_header(err);
    while (!st) {
        struct ap_sample sample;
        struct ap_iso m;
        bool got = false, has_row = false;
        st = ap_poselog_next(err, log, &sample, &got);
        if (st || !got)
            break;
        const char *device = ap_poselog_device_name(log, sample.device);
        st = ap_tracker_feed(err, tracker, device, sample.pose, &has_row, &m);
        if (st == AP_INPUT) {
            struct ap_error cause = err ? *err : (struct ap_error){""};
            return ap_fail(err, st, "at t_ns %" PRId64 ": %s", sample.t_ns, cause.text);
        }
        if (!st && has_row)
            st = write_row(err, sample.t_ns, device, &m);
    }
    return st;
}

static void warn(const struct ap_poselog *log, const struct ap_tracker *tracker,
                 const char *anchor) {
    int64_t dropped = ap_tracker_dropped(tracker);
    const char *lead = anchor ? anchor : "head";
    bool has_lead = strcmp(lead, "hands") == 0;
    for (int i = 0; i < ap_poselog_device_count(log); i++)
        has_lead = has_lead || strcmp(ap_poselog_device_name(log, i), lead) == 0;
    if (dropped > 0)
        ap_log(AP_LOG_WARNING, "track: %" PRId64 " %ssample%s before the %s gave no row%s%s%s%s%s",
               dropped, anchor ? "" : "hand ", dropped == 1 ? "" : "s",
               anchor ? "anchor's first" : "head's first",
               has_lead ? "" : "; the logs have no device '", has_lead ? "" : lead,
               has_lead ? "" : "' (", has_lead ? "" : lead, has_lead ? "" : "=FILE names it)");
    ap_logs_warn_skipped(log);
}

static enum ap_status run_track(struct ap_error *err, int argc, char **argv) {
    struct options o = {.space = "h3",
                        .tracker = "billiards",
                        .logs = AP_LOG_OPTIONS_NONE,
                        .radius_m = NAN,
                        .table_edge_m = NAN,
                        .table_height_m = NAN};
    struct ap_tracker *tracker = NULL;
    struct ap_poselog *log = NULL;
    int count = 0;
    bool done = false;
    enum ap_status st = parse(err, argc, argv, &o, &count, &done);
    if (st || done)
        return st;
    struct ap_room_defaults room = {.table_at = &o.logs.table_at,
                                    .table_height_m = &o.table_height_m,
                                    .table_edge_m = &o.table_edge_m,
                                    .radius_given = !isnan(o.radius_m)};
    st = ap_room_file_apply(err, o.logs.room, &room);
    if (isnan(o.table_height_m))
        o.table_height_m = AP_TABLE_HEIGHT_DEFAULT_MM / 1000.0;
    if (!st)
        st = open_tracker(err, &o, &tracker);
    if (!st)
        st = ap_logs_open(err, &o.logs, argv + 1, count, &log);
    if (st)
        goto out;
    st = write_rows(err, log, tracker);
    if (fflush(stdout) != 0 && !st)
        st = write_failed(err);
    warn(log, tracker, o.anchor);
out:
    ap_poselog_close(log);
    ap_tracker_destroy(tracker);
    return st;
}

const struct ap_command ap_command_track = {
    "track", "pose logs as virtual poses in the curved space, as CSV", run_track};
