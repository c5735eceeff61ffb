#include "src/device/inputlog.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "src/device/log/inputlog_build.h"
#include "src/device/log/line_reader.h"
#include "src/device/log/poselog_document.h"

struct point {
    int64_t t_ns;
    uint32_t order; // of reading: what makes the sort stable
    float value[2];
};

struct channel {
    const char *device;
    char path[AP_INPUT_PATH_MAX];
    int values;
    struct point *points;
    size_t count, room;
    size_t first_of_file; // points from here on come from the file being read
};

struct ap_inputlog {
    struct channel *channels;
    int channel_count;
    uint32_t rows;
    int64_t end_ns;
};

// What is known of a file while it is read.
struct reading {
    struct ap_line_reader lines;
    int64_t last_t_ns;
    bool begun; // a row or the header was there
};

static enum ap_status no_memory(struct ap_error *err) {
    return ap_fail(err, AP_ENVIRONMENT, "out of memory");
}

static enum ap_status reject(struct ap_error *err, const struct reading *r,
                             const struct ap_bad_line *bad) {
    return ap_fail(err, AP_INPUT, "%s:%" PRId64 ":%zu: expected %s", r->lines.name, r->lines.line,
                   bad->column, bad->expected);
}

static struct channel *find(const struct ap_inputlog *log, const char *device, const char *path,
                            size_t len) {
    for (int i = 0; i < log->channel_count; i++) {
        struct channel *c = &log->channels[i];
        if (strcmp(c->device, device) == 0 && strlen(c->path) == len &&
            memcmp(c->path, path, len) == 0)
            return c;
    }
    return NULL;
}

// The row's channel, made where it is new. Says in *bad what is wrong with it; NULL then.
static struct channel *channel_of(struct ap_inputlog *log, const char *line,
                                  const struct ap_input_row *row, struct ap_bad_line *bad) {
    struct channel *c = find(log, row->device, row->path.text, row->path.len);
    if (!c && log->channel_count == AP_INPUT_CHANNELS_MAX) {
        ap_bad_line_at(bad, line, row->path.text, "at most %d different inputs",
                       AP_INPUT_CHANNELS_MAX);
        return NULL;
    }
    if (!c) {
        c = &log->channels[log->channel_count++];
        *c = (struct channel){.device = row->device, .values = row->values};
        memcpy(c->path, row->path.text, row->path.len);
    }
    if (c->values == row->values)
        return c;
    ap_bad_line_at(bad, line, row->path.text, "%d value%s for %s as in its rows before", c->values,
                   c->values == 1 ? "" : "s", c->path);
    return NULL;
}

static enum ap_status append(struct ap_error *err, struct ap_inputlog *log, struct channel *c,
                             const struct ap_input_row *row) {
    if (log->rows == AP_INPUT_ROWS_MAX)
        return ap_fail(err, AP_INPUT, "the input logs have more than %d rows", AP_INPUT_ROWS_MAX);
    if (c->count == c->room) {
        size_t room = c->room ? 2 * c->room : 16;
        struct point *more = realloc(c->points, room * sizeof *more);
        if (!more)
            return no_memory(err);
        c->points = more;
        c->room = room;
    }
    c->points[c->count++] = (struct point){
        .t_ns = row->t_ns, .order = log->rows++, .value = {row->value[0], row->value[1]}};
    if (row->t_ns > log->end_ns)
        log->end_ns = row->t_ns;
    return AP_OK;
}

static enum ap_status take_row(struct ap_error *err, struct ap_inputlog *log, struct reading *r,
                               const char *line, size_t len) {
    struct ap_input_row row;
    struct ap_bad_line bad;
    if (!ap_inputlog_parse(line, len, &row, &bad))
        return reject(err, r, &bad);
    if (row.t_ns < r->last_t_ns) {
        ap_bad_line_at(&bad, line, line, "a time not before the line before (%" PRId64 " ns)",
                       r->last_t_ns);
        return reject(err, r, &bad);
    }
    r->last_t_ns = row.t_ns;
    struct channel *c = channel_of(log, line, &row, &bad);
    if (!c)
        return reject(err, r, &bad);
    if (c->count > c->first_of_file && c->points[c->count - 1].t_ns == row.t_ns) {
        ap_bad_line_at(&bad, line, line, "one value of %s %s at %" PRId64 " ns, not two", c->device,
                       c->path, row.t_ns);
        return reject(err, r, &bad);
    }
    return append(err, log, c, &row);
}

enum ap_status ap_inputlog_add(struct ap_error *err, struct ap_inputlog *log,
                               const struct ap_input_row *row) {
    struct ap_bad_line bad;
    struct channel *c = channel_of(log, row->path.text, row, &bad);
    if (!c)
        return ap_fail(err, AP_INPUT, "expected %s", bad.expected);
    if (c->count > c->first_of_file &&
        memcmp(c->points[c->count - 1].value, row->value, sizeof row->value) == 0)
        return AP_OK;
    return append(err, log, c, row);
}

// Optional, but what begins like one must be one.
static bool is_header(const char *line, size_t len) {
    return len >= 4 && memcmp(line, "t_ns", 4) == 0;
}

static enum ap_status take_header(struct ap_error *err, const struct reading *r, const char *line,
                                  size_t len) {
    static const char one[] = "t_ns,device,path,value", two[] = "t_ns,device,path,value,value2";
    if ((len == sizeof one - 1 && memcmp(line, one, len) == 0) ||
        (len == sizeof two - 1 && memcmp(line, two, len) == 0))
        return AP_OK;
    struct ap_bad_line bad;
    ap_bad_line_at(&bad, line, line, "the header %s or none", two);
    return reject(err, r, &bad);
}

static enum ap_status take_line(struct ap_error *err, struct ap_inputlog *log, struct reading *r,
                                enum ap_line_kind kind, const char *line, size_t len) {
    struct ap_bad_line bad = {.column = AP_LINE_MAX + 1};
    if (kind == AP_LINE_TOO_LONG) {
        snprintf(bad.expected, sizeof bad.expected, "a line of at most %d bytes", AP_LINE_MAX);
        return reject(err, r, &bad);
    }
    if (ap_log_line_is_empty(line, len))
        return AP_OK;
    bool header = !r->begun && is_header(line, len);
    r->begun = true;
    return header ? take_header(err, r, line, len) : take_row(err, log, r, line, len);
}

static enum ap_status read_lines(struct ap_error *err, struct ap_inputlog *log, struct reading *r) {
    enum ap_status st = AP_OK;
    while (!st) {
        enum ap_line_kind kind;
        const char *line = NULL;
        size_t len = 0;
        st = ap_line_reader_next(err, &r->lines, &kind, &line, &len);
        if (!st && kind == AP_LINE_END)
            break;
        if (!st)
            st = take_line(err, log, r, kind, line, len);
    }
    return !st && !r->begun
               ? ap_fail(err, AP_INPUT,
                         "%s: no input in it; expected t_ns,device,path,value[,value2]",
                         r->lines.name)
               : st;
}

static enum ap_status read_document(struct ap_error *err, struct ap_inputlog *log,
                                    struct reading *r) {
    uint32_t rows = log->rows;
    enum ap_status st = ap_inputlog_read_iwer(err, &r->lines, log);
    return st || log->rows > rows ? st
                                  : ap_fail(err, AP_INPUT, "%s: no input in it", r->lines.name);
}

static enum ap_status read_file(struct ap_error *err, struct ap_inputlog *log, const char *path) {
    struct reading r = {.last_t_ns = INT64_MIN};
    const char *bytes;
    size_t len;
    for (int i = 0; i < log->channel_count; i++)
        log->channels[i].first_of_file = log->channels[i].count;
    enum ap_status st = ap_line_reader_open(err, &r.lines, path);
    if (!st)
        st = ap_line_reader_peek(err, &r.lines, &bytes, &len);
    if (!st)
        st =
            ap_log_is_document(bytes, len) ? read_document(err, log, &r) : read_lines(err, log, &r);
    ap_line_reader_close(&r.lines);
    return st;
}

static int by_time(const void *a, const void *b) {
    const struct point *p = a, *q = b;
    if (p->t_ns != q->t_ns)
        return p->t_ns < q->t_ns ? -1 : 1;
    return p->order < q->order ? -1 : p->order > q->order;
}

static void sort_channels(struct ap_inputlog *log) {
    for (int i = 0; i < log->channel_count; i++)
        qsort(log->channels[i].points, log->channels[i].count, sizeof(struct point), by_time);
}

enum ap_status ap_inputlog_load(struct ap_error *err, const char *const *paths, size_t count,
                                struct ap_inputlog **log) {
    if (count > AP_INPUT_FILES_MAX)
        return ap_fail(err, AP_USAGE, "%zu input logs; expected at most %d", count,
                       AP_INPUT_FILES_MAX);
    struct ap_inputlog *l = calloc(1, sizeof *l);
    if (l)
        l->channels = calloc(AP_INPUT_CHANNELS_MAX, sizeof *l->channels);
    enum ap_status st = l && l->channels ? AP_OK : no_memory(err);
    if (!st)
        l->end_ns = INT64_MIN;
    for (size_t i = 0; !st && i < count; i++)
        st = read_file(err, l, paths[i]);
    if (st) {
        ap_inputlog_destroy(l);
        return st;
    }
    sort_channels(l);
    *log = l;
    return AP_OK;
}

void ap_inputlog_destroy(struct ap_inputlog *log) {
    if (!log)
        return;
    for (int i = 0; i < log->channel_count; i++)
        free(log->channels[i].points);
    free(log->channels);
    free(log);
}

int ap_inputlog_channel_count(const struct ap_inputlog *log) {
    return log->channel_count;
}

struct ap_input_channel ap_inputlog_channel(const struct ap_inputlog *log, int channel) {
    const struct channel *c = &log->channels[channel];
    return (struct ap_input_channel){c->device, c->path, c->values};
}

int ap_inputlog_find(const struct ap_inputlog *log, const char *device, const char *path) {
    const struct channel *c = find(log, device, path, strlen(path));
    return c ? (int)(c - log->channels) : -1;
}

bool ap_inputlog_at(const struct ap_inputlog *log, int channel, int64_t t_ns, float value[2]) {
    const struct channel *c = &log->channels[channel];
    size_t low = 0, high = c->count; // points[low − 1] ≤ t < points[high]
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        if (c->points[middle].t_ns <= t_ns)
            low = middle + 1;
        else
            high = middle;
    }
    if (low == 0)
        return false;
    value[0] = c->points[low - 1].value[0];
    value[1] = c->points[low - 1].value[1];
    return true;
}

int64_t ap_inputlog_end_ns(const struct ap_inputlog *log) {
    return log->end_ns;
}
