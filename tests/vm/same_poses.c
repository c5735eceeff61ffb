#include "tests/vm/same_poses.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tests/vm/player.h"

enum { DEVICES_MAX = 8, SQUEEZED = 10 };
static const int64_t GAP_NS = 100000000;
static const double MOVES = 1e-4; // metres, parts of a quaternion: less has no time of its own
static const double SAME = 1e-6;

struct take {
    struct trace traces[DEVICES_MAX];
    int count;
};

static struct trace *trace_of(struct take *take, const char *name) {
    for (int i = 0; i < take->count; i++)
        if (strcmp(take->traces[i].name, name) == 0)
            return &take->traces[i];
    if (take->count == DEVICES_MAX)
        player_die("more than %d devices", DEVICES_MAX);
    struct trace *t = &take->traces[take->count++];
    snprintf(t->name, sizeof t->name, "%s", name);
    return t;
}

void trace_add(struct trace *t, const struct ap_sample *sample) {
    if ((t->count & (t->count - 1)) == 0) { // full at each power of two
        size_t room = t->count ? 2 * (size_t)t->count : 1;
        t->at = realloc(t->at, room * sizeof *t->at);
        if (!t->at)
            player_die("no memory");
    }
    t->at[t->count++] = *sample;
}

static void load(struct take *take, const char *path) {
    struct ap_error err = {""};
    struct ap_poselog *log = NULL;
    const struct ap_poselog_params params = {.sources = &path, .source_count = 1};
    struct ap_sample sample;
    bool got = true;
    if (ap_poselog_open(&err, &params, &log))
        player_die("%s", err.text);
    for (;;) {
        if (ap_poselog_next(&err, log, &sample, &got))
            player_die("%s", err.text);
        if (!got)
            break;
        trace_add(trace_of(take, ap_poselog_device_name(log, sample.device)), &sample);
    }
    ap_poselog_close(log);
}

struct parts {
    double at[7];
};

// The quaternion on the side of `like`.
static struct parts parts_of(struct ap_pose pose, struct ap_quat like) {
    struct ap_quat q = pose.q;
    double side = q.x * like.x + q.y * like.y + q.z * like.z + q.w * like.w < 0 ? -1 : 1;
    return (struct parts){
        {pose.p.x, pose.p.y, pose.p.z, side * q.x, side * q.y, side * q.z, side * q.w}};
}

static double dot(struct parts a, struct parts b, struct parts c, struct parts d) {
    double sum = 0;
    for (int i = 0; i < 7; i++)
        sum += (b.at[i] - a.at[i]) * (d.at[i] - c.at[i]);
    return sum;
}

struct nearest {
    double distance; // the largest part's
    double u;        // how far on the way, 0 to 1
    double length;   // of the way
};

// The point nearest to x on the way from a to b.
static struct nearest nearest_on(struct ap_pose a, struct ap_pose b, struct ap_pose x) {
    struct parts pa = parts_of(a, a.q), pb = parts_of(b, a.q), px = parts_of(x, a.q), pw = pa;
    double size2 = dot(pa, pb, pa, pb);
    struct nearest near = {.length = sqrt(size2)};
    for (int i = 0; i < 4 && size2 > 0; i++) { // a slerp's speed is nearly the chord's
        near.u = fmin(fmax(near.u + dot(pw, px, pa, pb) / size2, 0), 1);
        pw = parts_of(ap_pose_interpolate(a, b, near.u), a.q);
    }
    for (int i = 0; i < 7; i++)
        near.distance = fmax(near.distance, fabs(px.at[i] - pw.at[i]));
    return near;
}

static bool joined(const struct trace *t, int i) {
    return i > 0 && i < t->count && !t->at[i].reset && t->at[i].t_ns - t->at[i - 1].t_ns <= GAP_NS;
}

static int compare(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

// The way nearest to the pose, among those near its time: its sample's index, or −1. Ways that go
// through it count as passed.
static int find_way(const struct trace *replayed, int from, const struct ap_sample *s,
                    int64_t near_ns, bool *passed, struct nearest *best) {
    int way = -1;
    best->distance = INFINITY;
    for (int i = from; i < replayed->count && replayed->at[i - 1].t_ns < s->t_ns + near_ns; i++) {
        if (!joined(replayed, i))
            continue;
        struct nearest n = nearest_on(replayed->at[i - 1].pose, replayed->at[i].pose, s->pose);
        passed[i] |= n.distance < SAME; // at rest several are
        if (n.distance < best->distance) {
            *best = n;
            way = i;
        }
    }
    // Beyond the end of a way there is only what the runtime predicts.
    if (way >= 0 && (((best->u == 1 || best->length == 0) && !joined(replayed, way + 1)) ||
                     (best->u == 0 && !joined(replayed, way - 1))))
        return -1;
    return way;
}

static int missed(const struct trace *replayed, const bool *passed) {
    int count = 0;
    for (int i = SQUEEZED; i < replayed->count; i++)
        count += joined(replayed, i) && !passed[i];
    return count;
}

static void tell(const struct trace *replayed, const struct trace *seen, int64_t near_ns) {
    bool *passed = calloc((size_t)replayed->count, sizeof *passed);
    double *late_us = calloc((size_t)seen->count + 1, sizeof *late_us), aside = 0;
    int from = 1, looked = 0, late_count = 0;
    if (!passed || !late_us)
        player_die("no memory");
    for (int k = 0; k < seen->count; k++) {
        const struct ap_sample *s = &seen->at[k];
        struct nearest best;
        while (from < replayed->count && replayed->at[from].t_ns < s->t_ns - near_ns)
            from++;
        int way = find_way(replayed, from, s, near_ns, passed, &best);
        if (way < 0)
            continue;
        looked++;
        passed[way] = true;
        aside = fmax(aside, best.distance);
        const struct ap_sample *a = &replayed->at[way - 1], *b = &replayed->at[way];
        double t = (double)a->t_ns + best.u * (double)(b->t_ns - a->t_ns);
        if (best.length > MOVES)
            late_us[late_count++] = fabs((double)s->t_ns - t) / 1e3;
    }
    printf("%s replayed %d missed %d seen %d aside %.2g", replayed->name, replayed->count,
           missed(replayed, passed), looked, aside);
    if (late_count > 0) {
        qsort(late_us, (size_t)late_count, sizeof *late_us, compare);
        printf(" late median %.0f p99 %.0f max %.0f us", late_us[late_count / 2],
               late_us[(int)(0.99 * late_count)], late_us[late_count - 1]);
    }
    printf("\n");
    free(passed);
    free(late_us);
}

// The recording's times become those of sending. Every report's time is another.
static void date(struct take *take, const char *recording, const char *sent_log) {
    static struct player player;
    player_load(&player, recording);
    const struct player_device *d = &player.devices[0];
    int64_t *sent_ns = calloc(d->report_count, sizeof *sent_ns);
    FILE *file = fopen(sent_log, "r");
    long long index, t_ns;
    size_t count = 0;
    while (sent_ns && file && fscanf(file, "%lld %lld", &index, &t_ns) == 2 &&
           (size_t)index == count && count < d->report_count)
        sent_ns[count++] = t_ns;
    if (count < d->report_count)
        player_die("%s: %zu of %zu reports were sent", sent_log, count, d->report_count);
    for (int i = 0; i < take->count; i++)
        for (size_t k = 0, r = 0; k < (size_t)take->traces[i].count; k++) {
            struct ap_sample *sample = &take->traces[i].at[k];
            while (r < count && d->reports[r].t_ns < sample->t_ns)
                r++;
            if (r == count)
                player_die("%s: a pose after the last report", recording);
            sample->t_ns = sent_ns[r];
        }
    fclose(file);
    free(sent_ns);
}

void tell_same_poses(const char *recording, const char *sent_log, const struct trace *seen,
                     int seen_count, int64_t near_ns) {
    static const struct trace nothing;
    struct take replayed = {.count = 0};
    load(&replayed, recording);
    date(&replayed, recording, sent_log);
    for (int i = 0; i < replayed.count; i++) {
        const struct trace *s = &nothing;
        for (int k = 0; k < seen_count; k++)
            if (strcmp(seen[k].name, replayed.traces[i].name) == 0)
                s = &seen[k];
        tell(&replayed.traces[i], s, near_ns);
        free(replayed.traces[i].at);
    }
}
