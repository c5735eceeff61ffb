#include "src/device/poselog.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "src/device/log/poselog_source.h"

enum { SOURCES_MAX = 64, DEVICES_MAX = 256 };

struct device {
    char name[AP_LOG_DEVICE_NAME_MAX];
    size_t len;
    bool is_head;
    int64_t last_t_ns; // of its newest sample
};

struct ap_poselog {
    struct ap_poselog_params params;
    struct ap_pose table_from_room;
    struct ap_log_source *sources;
    size_t source_count;
    struct ap_log_source *given; // whose row the newest sample was; advanced only when asked again
    struct device devices[DEVICES_MAX];
    int device_count;
    enum ap_status failed; // a log that failed goes on failing, with the same sentence
    struct ap_error why;
};

static enum ap_status open_sources(struct ap_error *err, struct ap_poselog *log) {
    const struct ap_poselog_params *params = &log->params;
    bool have_stdin = false;
    for (size_t i = 0; i < params->source_count; i++) {
        struct ap_log_source *source = &log->sources[log->source_count++];
        enum ap_status st = ap_log_source_open(err, source, params->sources[i], params->skip_bad);
        if (st)
            return st;
        if (source->reader.bytes.fd == 0 && have_stdin)
            return ap_fail(err, AP_USAGE, "'%s': standard input can be read only once",
                           params->sources[i]);
        have_stdin = have_stdin || source->reader.bytes.fd == 0;
    }
    return AP_OK;
}

// The head's or a hand's room pose seen from the table's frame: (X, 0, Z) after rotY(YAW).
static struct ap_pose find_table_from_room(const struct ap_poselog_params *params) {
    double half = params->table_yaw_rad / 2;
    struct ap_pose room_from_table = {{params->table_x_m, 0, params->table_z_m},
                                      {0, sin(half), 0, cos(half)}};
    return ap_pose_inverse(room_from_table);
}

enum ap_status ap_poselog_open(struct ap_error *err, const struct ap_poselog_params *params,
                               struct ap_poselog **log) {
    if (params->source_count < 1 || params->source_count > SOURCES_MAX)
        return ap_fail(err, AP_USAGE, "expected 1 to %d pose logs, not %zu", SOURCES_MAX,
                       params->source_count);
    if (params->has_table && !(isfinite(params->table_x_m) && isfinite(params->table_z_m) &&
                               isfinite(params->table_yaw_rad)))
        return ap_fail(err, AP_USAGE, "expected finite numbers for where the table stands");
    struct ap_poselog *l = calloc(1, sizeof *l);
    struct ap_log_source *sources = calloc(params->source_count, sizeof *sources);
    if (!l || !sources) {
        free(l);
        free(sources);
        return ap_fail(err, AP_ENVIRONMENT, "out of memory for pose logs");
    }
    l->params = *params;
    l->sources = sources;
    if (params->has_table)
        l->table_from_room = find_table_from_room(params);
    enum ap_status st = open_sources(err, l);
    if (st) {
        ap_poselog_close(l);
        return st;
    }
    *log = l;
    return AP_OK;
}

static int find_device(const struct ap_poselog *log, struct ap_field name) {
    for (int i = 0; i < log->device_count; i++)
        if (log->devices[i].len == name.len &&
            memcmp(log->devices[i].name, name.text, name.len) == 0)
            return i;
    return -1;
}

static int add_device(struct ap_poselog *log, struct ap_field name) {
    struct device *d = &log->devices[log->device_count];
    memcpy(d->name, name.text, name.len);
    d->len = name.len;
    d->is_head = name.len == 4 && memcmp(name.text, "head", 4) == 0;
    d->last_t_ns = INT64_MIN;
    return log->device_count++;
}

// Reads every source to its next row; the one whose row comes first, NULL at the end of all. Of
// equal times the first argument's comes first: that keeps the sort stable.
static enum ap_status find_first(struct ap_error *err, struct ap_poselog *log,
                                 struct ap_log_source **first) {
    *first = NULL;
    for (size_t i = 0; i < log->source_count; i++) {
        struct ap_log_source *s = &log->sources[i];
        if (!s->has_row && !s->at_end) {
            enum ap_status st = ap_log_source_advance(err, s);
            if (st)
                return st;
        }
        if (s->has_row && (!*first || s->row.t_ns < (*first)->row.t_ns))
            *first = s;
    }
    return AP_OK;
}

// What only the log as a whole can know about a row.
static bool accept(struct ap_poselog *log, const struct ap_log_source *source, int *device,
                   struct ap_bad_line *bad) {
    const struct ap_row *row = &source->row;
    struct ap_field name = ap_log_source_device(source);
    int d = find_device(log, name);
    if (d < 0 && log->device_count == DEVICES_MAX) {
        // Only own CSV has so many; the row's text is still in the reader's buffer.
        bad->column = row->device_column;
        static const char too_many[] = "at most 256 devices in all the logs";
        memcpy(bad->expected, too_many, sizeof too_many);
        return false;
    }
    if (d < 0)
        d = add_device(log, name);
    if (log->devices[d].last_t_ns >= row->t_ns) {
        ap_bad_line_at(bad, "", "", "a time after the last one of '%s' (%" PRId64 " ns)",
                       log->devices[d].name, log->devices[d].last_t_ns);
        bad->column = row->t_column;
        return false;
    }
    log->devices[d].last_t_ns = row->t_ns;
    *device = d;
    return true;
}

// Quarter and half turns are permutations but for one factor, so they are written out: positions
// and the optical frame's turn stay exact.
static struct ap_pose y_up_from_z_up(struct ap_pose pose) {
    const double h = 0.70710678118654752440;
    struct ap_quat turn = {-h, 0, 0, h};
    return (struct ap_pose){{pose.p.x, pose.p.z, -pose.p.y}, ap_quat_mul(turn, pose.q)};
}

// A camera's axes are x right, y down, z forward: half a turn about x from a head's.
static struct ap_quat head_from_optical(struct ap_quat q) {
    return (struct ap_quat){q.w, q.z, -q.y, -q.x};
}

// A log's own options come before those of all logs.
static struct ap_pose to_table(const struct ap_poselog *log, const struct ap_log_argument *own,
                               struct ap_pose pose, bool is_head) {
    bool all_optical = is_head && log->params.head_frame == AP_HEAD_FRAME_OPTICAL;
    if (own->has_up ? own->z_up : log->params.z_up)
        pose = y_up_from_z_up(pose);
    if (own->has_frame ? own->optical : all_optical)
        pose.q = head_from_optical(pose.q);
    if (log->params.has_table)
        pose = ap_pose_mul(log->table_from_room, pose);
    return pose;
}

static enum ap_status next(struct ap_error *err, struct ap_poselog *log, struct ap_sample *sample,
                           bool *got) {
    if (log->given)
        log->given->has_row = false;
    log->given = NULL;
    for (;;) {
        struct ap_log_source *s;
        enum ap_status st = find_first(err, log, &s);
        if (st)
            return st;
        if (!s) {
            *got = false;
            return AP_OK;
        }
        int device;
        struct ap_bad_line bad;
        if (accept(log, s, &device, &bad)) {
            log->given = s;
            *sample = (struct ap_sample){
                .t_ns = s->row.t_ns,
                .device = device,
                .pose = to_table(log, &s->argument, s->row.pose, log->devices[device].is_head),
                .trigger = s->row.trigger,
                .squeeze = s->row.squeeze,
                .select = s->row.select,
                .reset = s->row.reset};
            *got = true;
            return AP_OK;
        }
        st = ap_log_source_reject(err, s, &bad);
        if (st)
            return st;
    }
}

enum ap_status ap_poselog_next(struct ap_error *err, struct ap_poselog *log,
                               struct ap_sample *sample, bool *got) {
    if (!log->failed)
        log->failed = next(&log->why, log, sample, got);
    return log->failed ? ap_fail(err, log->failed, "%s", log->why.text) : AP_OK;
}

int ap_poselog_device_count(const struct ap_poselog *log) {
    return log->device_count;
}

const char *ap_poselog_device_name(const struct ap_poselog *log, int device) {
    return device >= 0 && device < log->device_count ? log->devices[device].name : NULL;
}

int64_t ap_poselog_skipped(const struct ap_poselog *log) {
    int64_t n = 0;
    for (size_t i = 0; i < log->source_count; i++)
        n += log->sources[i].skipped;
    return n;
}

bool ap_poselog_column(const struct ap_poselog *log, const char *name, const char **text,
                       size_t *len) {
    const struct ap_log_source *s = log->given;
    if (!s || s->format != AP_LOG_CSV)
        return false;
    size_t n = strlen(name);
    for (size_t i = 0; i < s->columns.count; i++) {
        if (s->columns.name[i].len != n || memcmp(s->columns.name[i].text, name, n) != 0)
            continue;
        *text = s->fields[i].text;
        *len = s->fields[i].len;
        return true;
    }
    return false;
}

void ap_poselog_close(struct ap_poselog *log) {
    if (!log)
        return;
    for (size_t i = 0; i < log->source_count; i++)
        ap_log_source_finish(&log->sources[i]);
    free(log->sources);
    free(log);
}
