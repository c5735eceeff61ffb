#include "src/device/timeline.h"

#include <stdlib.h>
#include <string.h>

// Neighbours farther apart than this are not joined by a straight line: the tracking was lost.
static const int64_t LOST_AFTER_NS = 100000000;

// Where a device's samples stand in the merged order.
struct track {
    char *name;
    int64_t *samples; // indices
    int64_t count, room;
};

struct ap_timeline {
    struct ap_sample *samples;
    int64_t count, room;
    struct track *tracks;
    int track_count;
    int head;
};

const char *ap_pose_state_name(enum ap_pose_state state) {
    static const char *const names[] = {"none", "exact", "interpolated", "lost", "predicted"};
    return names[state];
}

// Room for one more of the array's elements. False without memory.
static bool grow(void **array, int64_t count, int64_t *room, size_t element) {
    if (count < *room)
        return true;
    int64_t more = *room ? *room + *room / 2 : 256;
    void *p = reallocarray(*array, (size_t)more, element);
    if (!p)
        return false;
    *array = p;
    *room = more;
    return true;
}

static bool add_tracks(struct ap_timeline *t, const struct ap_poselog *log, int count) {
    if (count <= t->track_count)
        return true;
    struct track *tracks = reallocarray(t->tracks, (size_t)count, sizeof *tracks);
    if (!tracks)
        return false;
    t->tracks = tracks;
    while (t->track_count < count) {
        struct track *track = &t->tracks[t->track_count];
        *track = (struct track){.name = strdup(ap_poselog_device_name(log, t->track_count))};
        if (!track->name)
            return false;
        t->track_count++;
    }
    return true;
}

static bool add_sample(struct ap_timeline *t, const struct ap_poselog *log,
                       const struct ap_sample *sample) {
    if (!add_tracks(t, log, sample->device + 1))
        return false;
    struct track *track = &t->tracks[sample->device];
    void *samples = t->samples, *indices = track->samples;
    bool ok = grow(&samples, t->count, &t->room, sizeof *t->samples) &&
              grow(&indices, track->count, &track->room, sizeof *track->samples);
    t->samples = samples;
    track->samples = indices;
    if (!ok)
        return false;
    track->samples[track->count++] = t->count;
    t->samples[t->count++] = *sample;
    return true;
}

enum ap_status ap_timeline_load(struct ap_error *err, struct ap_poselog *log,
                                struct ap_timeline **timeline) {
    struct ap_timeline *t = calloc(1, sizeof *t);
    enum ap_status st = t ? AP_OK : ap_fail(err, AP_ENVIRONMENT, "out of memory for the poses");
    bool got = true;
    while (!st) {
        struct ap_sample sample;
        st = ap_poselog_next(err, log, &sample, &got);
        if (st || !got)
            break;
        if (!add_sample(t, log, &sample))
            st = ap_fail(err, AP_ENVIRONMENT, "out of memory for the poses");
    }
    if (!st) {
        t->head = ap_timeline_find_device(t, "head");
        if (t->head < 0)
            st = ap_fail(err, AP_INPUT,
                         "the pose logs hold no sample of the device 'head'; name one with "
                         "head=FILE");
    }
    if (st) {
        ap_timeline_destroy(t);
        return st;
    }
    *timeline = t;
    return AP_OK;
}

void ap_timeline_destroy(struct ap_timeline *t) {
    if (!t)
        return;
    for (int i = 0; i < t->track_count; i++) {
        free(t->tracks[i].name);
        free(t->tracks[i].samples);
    }
    free(t->tracks);
    free(t->samples);
    free(t);
}

int ap_timeline_device_count(const struct ap_timeline *t) {
    return t->track_count;
}

const char *ap_timeline_device_name(const struct ap_timeline *t, int device) {
    return device >= 0 && device < t->track_count ? t->tracks[device].name : NULL;
}

int ap_timeline_find_device(const struct ap_timeline *t, const char *name) {
    for (int i = 0; i < t->track_count; i++)
        if (t->tracks[i].count && strcmp(t->tracks[i].name, name) == 0)
            return i;
    return -1;
}

static const struct ap_sample *sample_of(const struct ap_timeline *t, int device, int64_t i) {
    return &t->samples[t->tracks[device].samples[i]];
}

int64_t ap_timeline_start_ns(const struct ap_timeline *t) {
    return sample_of(t, t->head, 0)->t_ns;
}

int64_t ap_timeline_end_ns(const struct ap_timeline *t) {
    return sample_of(t, t->head, t->tracks[t->head].count - 1)->t_ns;
}

int64_t ap_timeline_frame_count(const struct ap_timeline *t, double refresh_hz) {
    int64_t start = ap_timeline_start_ns(t), end = ap_timeline_end_ns(t);
    // t_low <= end < t_high, and the frame times never decrease.
    int64_t low = 0, high = 1;
    while (high < INT64_C(1) << 61 && ap_frame_time_ns(start, high, refresh_hz) <= end)
        high *= 2;
    while (high - low > 1) {
        int64_t middle = low + (high - low) / 2;
        if (ap_frame_time_ns(start, middle, refresh_hz) <= end)
            low = middle;
        else
            high = middle;
    }
    return low + 1;
}

// The number of a device's samples with time <= t_ns.
static int64_t count_until(const struct ap_timeline *t, int device, int64_t t_ns) {
    int64_t low = 0, high = t->tracks[device].count;
    while (low < high) {
        int64_t middle = low + (high - low) / 2;
        if (sample_of(t, device, middle)->t_ns <= t_ns)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

enum ap_pose_state ap_timeline_at(const struct ap_timeline *t, int device, int64_t t_ns,
                                  struct ap_sample *sample) {
    if (device < 0 || device >= t->track_count)
        return AP_POSE_NONE;
    int64_t n = count_until(t, device, t_ns);
    if (n == 0)
        return AP_POSE_NONE;
    const struct ap_sample *before = sample_of(t, device, n - 1);
    *sample = *before;
    sample->t_ns = t_ns;
    if (before->t_ns == t_ns)
        return AP_POSE_EXACT;
    if (n == t->tracks[device].count)
        return AP_POSE_LOST;
    const struct ap_sample *after = sample_of(t, device, n);
    int64_t gap = after->t_ns - before->t_ns;
    if (gap > LOST_AFTER_NS || after->reset)
        return AP_POSE_LOST;
    double part = (double)(t_ns - before->t_ns) / (double)gap;
    sample->pose = ap_pose_interpolate(before->pose, after->pose, part);
    return AP_POSE_INTERPOLATED;
}

int64_t ap_timeline_sample_count(const struct ap_timeline *t) {
    return t->count;
}

struct ap_sample ap_timeline_sample(const struct ap_timeline *t, int64_t index) {
    return t->samples[index];
}
