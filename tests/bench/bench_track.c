#include <inttypes.h>
#include <stdio.h>

#include "src/base/clock.h"
#include "src/base/number.h"
#include "src/device/walk.h"
#include "src/track/setup.h"
#include "src/track/text.h"

// Nanoseconds per sample of each tracker, over the scripted walk (head and both hands), and of the
// text of a row against printf's.

enum { SAMPLES = 60000 };

static struct ap_sample samples[SAMPLES];
static struct ap_iso rows[SAMPLES];
static const char *const names[] = {"head", "left", "right"};

static void bench_tracker(const char *space, enum ap_tracker_kind kind) {
    struct ap_error err = {""};
    const struct ap_track_setup setup = {.space = space,
                                         .radius_m = (double)NAN,
                                         .tracker = kind,
                                         .table_edge_m = (double)NAN,
                                         .table_height_m = 0.75};
    struct ap_tracker_params params;
    struct ap_tracker *tracker = NULL;
    if (ap_track_setup(&err, &setup, &params) || ap_tracker_create(&err, &params, &tracker)) {
        printf("%s\n", err.text);
        return;
    }
    int64_t start = ap_clock_now_ns();
    for (int i = 0; i < SAMPLES; i++) {
        bool row;
        if (ap_tracker_feed(&err, tracker, names[samples[i].device], samples[i].pose, &row,
                            &rows[i]))
            printf("%s\n", err.text);
    }
    int64_t took = ap_clock_now_ns() - start;
    printf("%s %-9s %6.0f ns a sample\n", space, ap_tracker_kind_name(kind),
           (double)took / SAMPLES);
    ap_tracker_destroy(tracker);
}

static void bench_text(void) {
    char text[AP_ISO_TEXT_MAX];
    size_t bytes = 0, slow_bytes = 0;
    int64_t start = ap_clock_now_ns();
    for (int i = 0; i < SAMPLES; i++)
        bytes += ap_iso_text(text, &rows[i]);
    int64_t fast = ap_clock_now_ns() - start;
    start = ap_clock_now_ns();
    for (int i = 0; i < SAMPLES; i++)
        for (int j = 0; j < 16; j++)
            slow_bytes += ap_format_double(text, rows[i].m[j / 4][j % 4]);
    int64_t slow = ap_clock_now_ns() - start;
    printf("text of a row: %.0f ns, with printf %.0f ns (%.0f bytes)\n", (double)fast / SAMPLES,
           (double)slow / SAMPLES, (double)bytes / SAMPLES);
    if (slow_bytes + 15 * (size_t)SAMPLES != bytes)
        printf("the two texts differ in length\n");
}

int main(void) {
    static const char *const spaces[] = {"s3", "e3", "h3"};
    const struct ap_walk_params walk = {0};
    double duration_s = ap_walk_duration_s(&walk);
    for (int i = 0; i < SAMPLES; i++)
        samples[i] = ap_walk_at(&walk, i % 3, (int64_t)(1e9 * duration_s * i / SAMPLES));
    for (int s = 0; s < 3; s++)
        for (int kind = 0; kind < 3; kind++)
            bench_tracker(spaces[s], (enum ap_tracker_kind)kind);
    bench_text();
    return 0;
}
