#include <getopt.h>
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "src/base/clock.h"
#include "src/device/live/live.h"
#include "src/device/poselog.h"
#include "tests/vm/reading.h"

// The live layer against the kernel: everything that is plugged in is followed for a while, and
// told at the end, a line each:
//
//   read N lost L strange S first F latency median … p99 … max … us      the raw reports
//   dated median … p99 … max … us                  a pose's time less the time it was sent
//   poses N worst D                                 of a quaternion's parts from the replayed one's
//   age median … p99 … max … us      of the role's newest report, asked about every 2 ms
//   state ROLE STATE at T             when the role's state changed, as it changes
//   device SERIAL STATE DRIVER reports R bad B gone G role ROLE…
//
//   live_watch [--for S] [--role ROLE] [--assign ROLE=WHICH]… [--recording FILE [--sent LOG]]
//              [--serial S] [--bus WAY]
//
// --serial: only this device's reports are looked at. At the end it says what processor time it
// took.

enum { ROWS_MAX = 200000, ASSIGN_MAX = 8 };

struct row {
    int64_t index, t_ns; // of the report in the recording
    struct ap_quat q;
};

struct watch {
    struct reading reading;
    const char *recording, *serial, *role, *bus;
    const char *assign[ASSIGN_MAX];
    int assign_count;
    double seconds;
    int device; // whose reports; −1: not known yet
    struct row *rows;
    int row_count;
    double *age_us;
    int age_count;
};

static struct watch watch = {.seconds = 3, .role = "head", .device = -1};

static void on_started(void *user, int device, const struct ap_live_place *place,
                       const struct ap_device_info *info, int64_t now_ns) {
    struct watch *w = user;
    (void)info, (void)now_ns;
    if (!w->serial || strcmp(w->serial, place->serial) == 0)
        w->device = device;
}

static void on_report(void *user, const struct ap_live_report *r) {
    struct watch *w = user;
    if (w->recording && r->device == w->device)
        reading_add(&w->reading, r->bytes, r->len);
}

// Comes behind the report's call: several of one report are of the same index.
static void on_pose(void *user, const struct ap_live_pose_row *r) {
    struct watch *w = user;
    if (r->device == w->device && w->row_count < ROWS_MAX)
        w->rows[w->row_count++] = (struct row){w->reading.next - 1, r->t_ns, r->pose.q};
}

static int compare(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static void tell_numbers(const char *what, double *us, int n) {
    if (n == 0)
        return;
    qsort(us, (size_t)n, sizeof *us, compare);
    printf("%s median %.0f p99 %.0f max %.0f us\n", what, us[n / 2], us[(int)(0.99 * n)],
           us[n - 1]);
}

// How far the times of poses are from when their reports were sent.
static void tell_dates(struct watch *w) {
    FILE *file = w->reading.sent_log ? fopen(w->reading.sent_log, "r") : NULL;
    double *us = calloc((size_t)w->row_count + 1, sizeof *us);
    long long index, t_ns;
    int at = 0, n = 0;
    while (file && us && at < w->row_count && fscanf(file, "%lld %lld", &index, &t_ns) == 2)
        for (; at < w->row_count && w->rows[at].index == index; at++)
            us[n++] = fabs((double)(w->rows[at].t_ns - t_ns)) / 1e3;
    if (us)
        tell_numbers("dated", us, n);
    free(us);
    if (file)
        fclose(file);
}

static double distance(struct ap_quat a, struct ap_quat b) {
    return fmax(fmax(fabs(a.x - b.x), fabs(a.y - b.y)), fmax(fabs(a.z - b.z), fabs(a.w - b.w)));
}

// The recording once more, from its file: the k-th pose is that of report k (the recordings here
// have one pose a report).
static void tell_equality(struct watch *w) {
    const char *source = w->recording;
    struct ap_error err = {""};
    struct ap_poselog *log = NULL;
    const struct ap_poselog_params params = {.sources = &source, .source_count = 1};
    if (ap_poselog_open(&err, &params, &log))
        player_die("%s", err.text);
    int64_t n = (int64_t)w->reading.player.devices[0].report_count, k = 0;
    double worst = 0;
    struct ap_quat *replayed = calloc((size_t)n, sizeof *replayed);
    struct ap_sample sample;
    bool got = true;
    while (replayed && k < n && !ap_poselog_next(&err, log, &sample, &got) && got)
        replayed[k++] = sample.pose.q;
    for (int i = 0; i < w->row_count && k == n; i++)
        worst = fmax(worst, distance(replayed[w->rows[i].index % n], w->rows[i].q));
    printf("poses %d worst %.3g\n", w->row_count, worst);
    free(replayed);
    ap_poselog_close(log);
}

static void tell_devices(const struct ap_live *live) {
    for (int i = 0; i < ap_live_device_count(live); i++) {
        struct ap_live_device d;
        ap_live_device_at(live, i, &d);
        printf("device %s %s %s reports %" PRId64 " bad %" PRId64 " gone %" PRId64 " role",
               d.place.serial[0] ? d.place.serial : "-", ap_live_state_name(d.state),
               d.driver ? d.driver->name : "-", d.reports, d.bad, d.unplugged_count);
        for (int t = 0; t < d.tracker_count; t++)
            printf(" %s", d.role[t]);
        printf("%s%s\n", d.why[0] ? ": " : "", d.why);
    }
}

static const char *name_of(enum ap_pose_state state) {
    switch (state) {
    case AP_POSE_NONE:
        return "none";
    case AP_POSE_LOST:
        return "lost";
    default:
        return "tracked";
    }
}

static void follow(struct watch *w, struct ap_live *live) {
    int64_t end = player_now_ns() + (int64_t)(1e9 * w->seconds);
    const char *before = "none";
    while (!player_stop && player_now_ns() < end) {
        ap_clock_sleep_until_ns(ap_clock_now_ns() + 2030000);
        int64_t now = ap_live_now_ns(live);
        struct ap_live_answer a = ap_live_at(live, ap_live_role(live, w->role), now);
        const char *state = name_of(a.state);
        if (strcmp(state, before) != 0)
            printf("state %s %s at %" PRId64 "\n", w->role, state, now);
        before = state;
        if (a.state != AP_POSE_NONE && a.state != AP_POSE_LOST && w->age_count < 5 * ROWS_MAX)
            w->age_us[w->age_count++] = (double)a.age_ns / 1e3;
    }
}

static void on_signal(int number) {
    (void)number;
    player_stop = 1;
}

static void read_options(struct watch *w, int argc, char **argv) {
    static const struct option options[] = {
        {"for", required_argument, NULL, 'f'},       {"role", required_argument, NULL, 'r'},
        {"assign", required_argument, NULL, 'a'},    {"sent", required_argument, NULL, 't'},
        {"recording", required_argument, NULL, 'l'}, {"serial", required_argument, NULL, 's'},
        {"bus", required_argument, NULL, 'b'},       {NULL, 0, NULL, 0},
    };
    for (int letter; (letter = getopt_long(argc, argv, "", options, NULL)) != -1;) {
        if (letter == 'f')
            w->seconds = atof(optarg);
        else if (letter == 'r')
            w->role = optarg;
        else if (letter == 'a' && w->assign_count < ASSIGN_MAX)
            w->assign[w->assign_count++] = optarg;
        else if (letter == 't')
            w->reading.sent_log = optarg;
        else if (letter == 'l')
            w->recording = optarg;
        else if (letter == 's')
            w->serial = optarg;
        else if (letter == 'b')
            w->bus = optarg;
        else
            player_die("see live_watch.c for the options");
    }
}

int main(int argc, char **argv) {
    struct watch *w = &watch;
    struct ap_live *live = NULL;
    struct ap_error err = {""};
    read_options(w, argc, argv);
    setvbuf(stdout, NULL, _IOLBF, 0);
    sigaction(SIGTERM, &(struct sigaction){.sa_handler = on_signal}, NULL);
    if (w->recording)
        reading_open(&w->reading, w->recording, ROWS_MAX);
    w->rows = calloc(ROWS_MAX, sizeof *w->rows);
    w->age_us = calloc((size_t)5 * ROWS_MAX, sizeof *w->age_us);
    const struct ap_live_params params = {
        .assign = w->assign,
        .assign_count = (size_t)w->assign_count,
        .ways = &w->bus,
        .way_count = w->bus != NULL,
        .listener = {.user = w, .started = on_started, .report = on_report, .pose = on_pose}};
    if (!w->rows || !w->age_us || ap_live_open(&err, &params, &live))
        player_die("%s", err.text);
    printf("ready\n");
    follow(w, live);
    tell_devices(live);
    ap_live_close(live);
    if (w->recording) {
        reading_tell(&w->reading);
        tell_dates(w);
        tell_equality(w);
    }
    tell_numbers("age", w->age_us, w->age_count);
    printf("processor %.1f ms\n", (double)clock() * 1e3 / CLOCKS_PER_SEC);
    free(w->rows);
    free(w->age_us);
    return 0;
}
