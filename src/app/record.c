#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "src/app/live_options.h"
#include "src/base/clock.h"
#include "src/base/file.h"
#include "src/base/log.h"
#include "src/device/live/record.h"

// antipode record: the bytes of what is plugged in.

static const char help[] =
    "Records the raw reports of every tracker that is plugged in, or comes while it runs, into OUT\n"
    "(the text of the hid-recorder tools, feature reports as '# F:' comments; packed where the name\n"
    "ends in .gz or .zst), and the poses that they became into a CSV beside it: take.hid.gz and\n"
    "take.csv. Both are pose logs for track, replay and sim. Ctrl-C ends it; until then neither\n"
    "file is there, afterwards both are whole. Devices that no driver knows are left alone unless\n"
    "--all is given: then keyboards are recorded, too, and with them what is typed.\n"
    "Exit status: 0; 1 nothing was recorded; 2 usage; 3 a recording that cannot be read; 4 OUT\n"
    "cannot be written or devices cannot be looked for.";

static const int64_t MS = 1000000;

struct record_options {
    struct ap_live_options live;
    bool all, force;
    double seconds;
};

static void show_counts(struct ap_recorder *recorder, int64_t since_ns) {
    struct ap_record_counts c = ap_recorder_counts(recorder);
    fprintf(stderr,
            "\r%7.1f s  %d device%s  %" PRId64 " reports  %" PRId64 " poses  %" PRId64
            " dropped\033[K",
            (double)(ap_clock_now_ns() - since_ns) * 1e-9, c.devices, c.devices == 1 ? "" : "s",
            c.reports, c.poses, c.dropped);
}

// Recordings that are played end; devices do not.
static bool is_over(const struct ap_live *live) {
    struct ap_live_device d;
    int count = ap_live_device_count(live), gone = 0;
    for (int i = 0; i < count; i++) {
        ap_live_device_at(live, i, &d);
        gone += d.state == AP_LIVE_GONE || d.state == AP_LIVE_NO_DRIVER;
    }
    return count > 0 && gone == count;
}

static enum ap_status loop(struct ap_error *err, const struct record_options *o,
                           const struct ap_live *live, struct ap_recorder *recorder) {
    int64_t start_ns = ap_clock_now_ns(), now_ns = start_ns;
    int64_t end_ns = isnan(o->seconds) ? INT64_MAX : start_ns + (int64_t)(o->seconds * 1e9);
    bool terminal = isatty(STDERR_FILENO);
    int rounds = 0;
    enum ap_status st = AP_OK;
    while (!st && !ap_end_asked() && now_ns < end_ns && !(o->live.replay.count && is_over(live))) {
        now_ns += 50 * MS;
        ap_clock_sleep_until_ns(now_ns < end_ns ? now_ns : end_ns);
        st = ap_recorder_write(err, recorder, ap_clock_now_ns());
        if (terminal && ++rounds % 10 == 0)
            show_counts(recorder, start_ns);
    }
    if (terminal)
        fprintf(stderr, "\n");
    return st;
}

static void say_devices(const struct ap_live *live) {
    struct ap_live_device d;
    for (int i = 0; i < ap_live_device_count(live); i++) {
        ap_live_device_at(live, i, &d);
        if (d.why[0])
            ap_log(AP_LOG_WARNING, "record: %s", d.why);
        if (d.reports)
            printf("D: %d  %s  %s  %" PRId64 " reports, %" PRId64 " bad\n", i, d.place.name,
                   d.place.serial, d.reports, d.bad);
    }
}

static enum ap_status finish(struct ap_error *err, struct ap_recorder *recorder, const char *path) {
    struct ap_record_counts c = ap_recorder_counts(recorder);
    if (c.reports == 0)
        return ap_fail(err, AP_DIFFERS,
                       "no report came, so %s is not written; antipode devices says what is "
                       "plugged in",
                       path);
    enum ap_status st = ap_recorder_finish(err, recorder);
    if (!st)
        printf("%s: %" PRId64 " reports of %d device%s, %" PRId64 " poses beside it, %" PRId64
               " dropped\n",
               path, c.reports, c.devices, c.devices == 1 ? "" : "s", c.poses, c.dropped);
    return st;
}

static enum ap_status record(struct ap_error *err, const struct record_options *o,
                             const char *path) {
    struct ap_recorder *recorder = NULL;
    struct ap_live *live = NULL;
    char csv[4096];
    enum ap_status st = ap_record_csv_path(err, path, csv, sizeof csv);
    if (!st && !o->force && (ap_file_exists(path) || ap_file_exists(csv)))
        st = ap_fail(err, AP_USAGE, "%s is there already; --force replaces it",
                     ap_file_exists(path) ? path : csv);
    ap_catch_end();
    if (!st)
        st = ap_recorder_create(err, path, ap_clock_now_ns(), &recorder);
    if (!st)
        st = ap_live_options_open(
            err, &o->live,
            &(struct ap_live_params){.all = o->all, .listener = ap_recorder_listener(recorder)},
            &live);
    if (!st && !ap_live_settle(live, ap_clock_now_ns() + 3000 * MS))
        ap_log(AP_LOG_WARNING, "record: a device takes long to start");
    if (!st && ap_live_device_count(live) == 0)
        ap_log(AP_LOG_INFO, "record: nothing is plugged in yet; waiting (Ctrl-C ends it)");
    if (!st)
        st = loop(err, o, live, recorder);
    if (live)
        say_devices(live);
    ap_live_close(live);
    if (!st)
        st = finish(err, recorder, path);
    ap_recorder_destroy(recorder);
    return st;
}

static enum ap_status run(struct ap_error *err, int argc, char **argv) {
    // What is recorded is to replay to the same poses wherever it is replayed.
    struct record_options o = {.seconds = NAN, .live = {.uncalibrated = true}};
    const struct ap_option options[] = {
        {"seconds", AP_OPTION_NUMBER, &o.seconds, "S", "end after so long (Ctrl-C)"},
        {"all", AP_OPTION_FLAG, &o.all, "", "devices that no driver knows, too"},
        {"force", AP_OPTION_FLAG, &o.force, "", "replace what is there"},
        AP_LIVE_OPTION_TABLE(o.live),
    };
    const struct ap_usage usage = {.command = "record",
                                   .operands = "OUT",
                                   .text = help,
                                   .options = options,
                                   .option_count = sizeof options / sizeof options[0],
                                   .min_operands = 1,
                                   .max_operands = 1};
    int operands;
    bool done;
    enum ap_status st = ap_parse_options(err, &usage, argc, argv, &operands, &done);
    if (!st && !done && !isnan(o.seconds) && !(o.seconds > 0 && o.seconds <= 1e6))
        st = ap_fail(err, AP_USAGE, "--seconds: expected more than 0, at most 1000000, not %g",
                     o.seconds);
    if (!st && !done && strcmp(argv[1], "-") == 0)
        st = ap_fail(err, AP_USAGE, "two files are written, OUT and a CSV beside it: name a file");
    return st || done ? st : record(err, &o, argv[1]);
}

const struct ap_command ap_command_record = {"record", "raw reports of what is plugged in", run};
