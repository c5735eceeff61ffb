#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "src/base/clock.h"
#include "src/device/fusion/predict.h"

// Ways of prediction over real recordings: at every sample the pose 11, 20, 30 and 50 ms later is
// predicted from what was known then, and compared with the recording. CSV on standard output:
// median and 95th percentile of the errors, in degrees and millimetres. The folder with the
// recordings is the argument, or data/poses of $ANTIPODE_SHARED.

enum way { HOLD, CONSTANT, ACCELERATED, FADED_60, FADED_80, FADED_100, SHIPPED, WAYS };
static const char *const names[WAYS] = {
    "hold last",     "constant velocity", "constant acceleration", "damped 60 ms", "damped 80 ms",
    "damped 100 ms", "as shipped"};
static const double taus[WAYS] = {[FADED_60] = 0.06, [FADED_80] = 0.08, [FADED_100] = 0.1};
static const int horizons_ms[] = {11, 20, 30, 50};
enum { HORIZONS = 4, SAMPLES_MAX = 8192 };

static struct ap_history histories[WAYS];
static double degrees[WAYS][HORIZONS][SAMPLES_MAX], millimetres[WAYS][HORIZONS][SAMPLES_MAX];
static size_t counts[WAYS][HORIZONS];

static void start(void) {
    for (int w = 0; w < WAYS; w++) {
        struct ap_history_params params = {.tau_s = taus[w], .ahead_max_ns = 100000000};
        if (w == SHIPPED)
            params.ahead_max_ns = 0;
        if (w == CONSTANT)
            params.tau_s = (double)INFINITY;
        if (!ap_history_init(&histories[w], &params))
            abort();
        for (int h = 0; h < HORIZONS; h++)
            counts[w][h] = 0;
    }
}

static struct ap_vec3 turn_between(struct ap_quat a, struct ap_quat b) {
    struct ap_quat d = ap_quat_mul(b, ap_quat_conj(a));
    double s = d.w < 0 ? -1 : 1, size = hypot(hypot(d.x, d.y), d.z);
    double k = size > 0 ? 2 * s * atan2(size, s * d.w) / size : 0;
    return (struct ap_vec3){k * d.x, k * d.y, k * d.z};
}

// Velocity and acceleration from the last three samples; the rotation vector as if it were a place.
static struct ap_pose accelerate(const struct ap_sample s[3], double h_s) {
    double a = 1e-9 * (double)(s[1].t_ns - s[0].t_ns), b = 1e-9 * (double)(s[2].t_ns - s[1].t_ns);
    if (a > 0.06 || b > 0.06)
        return s[2].pose;
    struct ap_vec3 v0 = ap_vec3_scale(1 / a, turn_between(s[0].pose.q, s[1].pose.q));
    struct ap_vec3 v1 = ap_vec3_scale(1 / b, turn_between(s[1].pose.q, s[2].pose.q));
    struct ap_vec3 acc = ap_vec3_scale(2 / (a + b), ap_vec3_sub(v1, v0));
    struct ap_vec3 v = ap_vec3_add(v1, ap_vec3_scale(b / 2, acc)); // at the newest
    struct ap_vec3 mean = ap_vec3_add(v, ap_vec3_scale(h_s / 2, acc));
    struct ap_pose pose = ap_predict(s[2].pose, (struct ap_vec3){0, 0, 0}, mean, h_s, INFINITY);
    v0 = ap_vec3_scale(1 / a, ap_vec3_sub(s[1].pose.p, s[0].pose.p));
    v1 = ap_vec3_scale(1 / b, ap_vec3_sub(s[2].pose.p, s[1].pose.p));
    acc = ap_vec3_scale(2 / (a + b), ap_vec3_sub(v1, v0));
    v = ap_vec3_add(v1, ap_vec3_scale(b / 2 + h_s / 2, acc));
    pose.p = ap_vec3_add(pose.p, ap_vec3_scale(h_s, v));
    return pose;
}

static void compare(int w, int h, struct ap_pose got, struct ap_pose truth) {
    size_t i = counts[w][h]++;
    degrees[w][h][i] = ap_vec3_length(turn_between(truth.q, got.q)) * 180 / 3.14159265358979323846;
    millimetres[w][h][i] = 1e3 * ap_vec3_length(ap_vec3_sub(got.p, truth.p));
}

static int by_size(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static void report(const char *name) {
    for (int w = 0; w < WAYS; w++)
        for (int h = 0; h < HORIZONS; h++) {
            size_t n = counts[w][h];
            qsort(degrees[w][h], n, sizeof(double), by_size);
            qsort(millimetres[w][h], n, sizeof(double), by_size);
            printf("%s,%s,%d,%zu,%.3f,%.3f,%.2f,%.2f\n", name, names[w], horizons_ms[h], n,
                   degrees[w][h][n / 2], degrees[w][h][n * 95 / 100], millimetres[w][h][n / 2],
                   millimetres[w][h][n * 95 / 100]);
        }
}

static void feed(const struct ap_timeline *timeline, int64_t i, const struct ap_sample last[3]) {
    struct ap_sample truth;
    for (int w = 0; w < WAYS; w++)
        ap_history_push(&histories[w], last[2].t_ns, last[2].pose, NULL);
    for (int h = 0; h < HORIZONS && i >= 2; h++) {
        int64_t t = last[2].t_ns + horizons_ms[h] * INT64_C(1000000);
        enum ap_pose_state state = ap_timeline_at(timeline, 0, t, &truth);
        if (state != AP_POSE_EXACT && state != AP_POSE_INTERPOLATED)
            continue;
        for (int w = 0; w < WAYS; w++) {
            struct ap_pose got = last[2].pose;
            if (w == ACCELERATED)
                got = accelerate(last, 1e-3 * horizons_ms[h]);
            else if (w != HOLD)
                got = ap_history_at(&histories[w], t).pose;
            compare(w, h, got, truth.pose);
        }
    }
}

static struct ap_timeline *load(const char *path) {
    struct ap_error err;
    char source[1100];
    snprintf(source, sizeof source, "head=%s", path);
    const char *sources[] = {source};
    struct ap_poselog *log = NULL;
    struct ap_timeline *timeline = NULL;
    if (ap_poselog_open(&err, &(struct ap_poselog_params){.sources = sources, .source_count = 1},
                        &log) ||
        ap_timeline_load(&err, log, &timeline))
        fprintf(stderr, "%s\n", err.text);
    ap_poselog_close(log);
    return timeline;
}

// Nanoseconds a question for the head 15 ms ahead takes.
static void time_it(const struct ap_history *history, int64_t t_ns) {
    double sum = 0;
    int64_t begin = ap_clock_now_ns();
    for (int i = 0; i < 200000; i++)
        sum += ap_history_at(history, t_ns + i % 1000).pose.p.x;
    int64_t took = ap_clock_now_ns() - begin;
    fprintf(stderr, "a prediction takes %.0f ns (%.3g)\n", (double)took / 200000, sum);
}

int main(int argc, char **argv) {
    static const char *const files[] = {
        "vive_room_head",        "vive_room_left",        "vive_room_right",
        "vive_crouch_head",      "vive_crouch_left",      "vive_crouch_right",
        "quest2_beatsaber_head", "quest2_beatsaber_left", "quest2_beatsaber_right"};
    const char *shared = getenv("ANTIPODE_SHARED");
    if (argc < 2 && !shared) {
        printf("skipped: ANTIPODE_SHARED is not set, and no folder was given\n");
        return 77;
    }
    printf("recording,way,horizon_ms,samples,median_deg,p95_deg,median_mm,p95_mm\n");
    for (size_t f = 0; f < sizeof files / sizeof files[0]; f++) {
        char path[1024];
        snprintf(path, sizeof path, "%s/%s%s.tum", argc > 1 ? argv[1] : shared,
                 argc > 1 ? "" : "data/poses/", files[f]);
        struct ap_timeline *timeline = load(path);
        if (!timeline)
            return 1;
        start();
        struct ap_sample last[3] = {0};
        int64_t n = ap_timeline_sample_count(timeline);
        for (int64_t i = 0; i < n && i < SAMPLES_MAX; i++) {
            last[0] = last[1];
            last[1] = last[2];
            last[2] = ap_timeline_sample(timeline, i);
            feed(timeline, i, last);
        }
        report(files[f]);
        time_it(&histories[SHIPPED], last[2].t_ns + 15000000);
        ap_timeline_destroy(timeline);
    }
    return 0;
}
