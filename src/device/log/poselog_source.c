#include "src/device/log/poselog_source.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "src/device/hid/body_model.h"
#include "src/device/hid/recording.h"
#include "src/device/log/poselog_document.h"

enum ap_status ap_log_source_reject(struct ap_error *err, struct ap_log_source *source,
                                    const struct ap_bad_line *bad) {
    source->has_row = false;
    if (source->skip_bad) {
        source->skipped++;
        return AP_OK;
    }
    if (source->document)
        return ap_fail(err, AP_INPUT, "%s: frame %" PRId64 ": expected %s", source->reader.name,
                       source->frame, bad->expected);
    return ap_fail(err, AP_INPUT, "%s:%" PRId64 ":%zu: expected %s", source->reader.name,
                   source->reader.line, bad->column, bad->expected);
}

static enum ap_status reject_long_line(struct ap_error *err, struct ap_log_source *source) {
    struct ap_bad_line bad = {.column = AP_LINE_MAX + 1};
    snprintf(bad.expected, sizeof bad.expected, "a line of at most %d bytes", AP_LINE_MAX);
    return ap_log_source_reject(err, source, &bad);
}

static enum ap_status take_header(struct ap_error *err, struct ap_log_source *source,
                                  const char *line, size_t len) {
    free(source->header);
    source->header = malloc(len + 1);
    if (!source->header)
        return ap_fail(err, AP_ENVIRONMENT, "%s: out of memory", source->reader.name);
    memcpy(source->header, line, len);
    struct ap_bad_line bad;
    if (source->format == AP_LOG_NAMED
            ? ap_named_parse_header(source->header, len, &source->named->columns, &bad)
            : ap_csv_parse_header(source->header, len, &source->columns, &bad))
        return AP_OK;
    // Without its header nothing in the file can be read, so this is no line to skip.
    source->skip_bad = false;
    return ap_log_source_reject(err, source, &bad);
}

static enum ap_status reject_unknown(struct ap_error *err, struct ap_log_source *source) {
    struct ap_bad_line bad = {.column = 1};
    snprintf(bad.expected, sizeof bad.expected,
             "a pose log: CSV with the header t_ns,device,px,…, TUM lines (t x y z qx qy qz qw), "
             "EuRoC CSV, a raw HID recording, BSOR, or the JSON of IWER or A-Frame");
    return ap_log_source_reject(err, source, &bad);
}

static enum ap_status need_reports(struct ap_error *err, struct ap_log_source *source) {
    if (source->reports)
        return AP_OK;
    source->reports = ap_report_log_create();
    if (!source->reports)
        return ap_fail(err, AP_ENVIRONMENT, "%s: out of memory", source->reader.name);
    const struct ap_log_argument *a = &source->argument;
    ap_report_log_set_role(source->reports, a->role, &a->axes, a->invert);
    return AP_OK;
}

// Recorders write a device's feature reports, comments to anybody else, before its other lines.
static enum ap_status take_early_feature(struct ap_error *err, struct ap_log_source *source,
                                         const char *line, size_t len) {
    struct ap_bad_line bad;
    enum ap_status st = need_reports(err, source);
    if (st || ap_report_log_feed(source->reports, line, len, &bad) || source->early_bad_line)
        return st;
    source->early_bad_line = source->reader.line;
    source->early_bad = bad;
    return AP_OK;
}

// Now the format is known; what its early lines lacked can be said.
static enum ap_status begin_reports(struct ap_error *err, struct ap_log_source *source) {
    enum ap_status st = need_reports(err, source);
    if (st || !source->early_bad_line)
        return st;
    source->skipped += source->skip_bad;
    return source->skip_bad ? AP_OK
                            : ap_fail(err, AP_INPUT, "%s:%" PRId64 ":%zu: expected %s",
                                      source->reader.name, source->early_bad_line,
                                      source->early_bad.column, source->early_bad.expected);
}

static bool has_header(enum ap_log_format format) {
    return format == AP_LOG_CSV || format == AP_LOG_NAMED;
}

// BSOR and JSON are read as a whole.
static enum ap_status read_document(struct ap_error *err, struct ap_log_source *source) {
    char *bytes;
    size_t len;
    enum ap_status st =
        ap_line_reader_rest(err, &source->reader, AP_LOG_DOCUMENT_MAX, &bytes, &len);
    if (st)
        return st;
    source->format = AP_LOG_DOCUMENT;
    st = ap_log_document_read(err, source->reader.name, bytes, len, source->skip_bad,
                              &source->document, &source->skipped);
    free(bytes);
    return st;
}

// What the format needs before its first line, which may be that line's header.
static enum ap_status begin_format(struct ap_error *err, struct ap_log_source *source,
                                   const char *line, size_t len) {
    if (source->format == AP_LOG_HID)
        return begin_reports(err, source);
    if (source->format == AP_LOG_IMU)
        source->imu = calloc(1, sizeof *source->imu);
    if (source->format == AP_LOG_NAMED)
        source->named = calloc(1, sizeof *source->named);
    if ((source->format == AP_LOG_IMU && !source->imu) ||
        (source->format == AP_LOG_NAMED && !source->named))
        return ap_fail(err, AP_ENVIRONMENT, "%s: out of memory", source->reader.name);
    return has_header(source->format) ? take_header(err, source, line, len) : AP_OK;
}

static enum ap_status find_line_format(struct ap_error *err, struct ap_log_source *source) {
    while (source->format == AP_LOG_UNKNOWN) {
        enum ap_line_kind kind;
        const char *line;
        size_t len;
        enum ap_status st = ap_line_reader_next(err, &source->reader, &kind, &line, &len);
        if (st)
            return st;
        if (kind == AP_LINE_END)
            return ap_fail(err, AP_INPUT, "%s: no pose in it; docs/pose-logs.md has the formats",
                           source->reader.name);
        if (kind == AP_LINE_TEXT && ap_hid_line_is_feature(line, len)) {
            st = take_early_feature(err, source, line, len);
            if (st)
                return st;
        }
        if (kind == AP_LINE_TEXT && ap_log_line_is_empty(line, len))
            continue;
        if (kind == AP_LINE_TEXT)
            source->format = ap_log_format_of(line, len);
        if (source->format != AP_LOG_UNKNOWN)
            st = begin_format(err, source, line, len);
        else
            st = kind == AP_LINE_TOO_LONG ? reject_long_line(err, source)
                                          : reject_unknown(err, source);
        if (st)
            return st;
        if (source->format != AP_LOG_UNKNOWN && !has_header(source->format))
            ap_line_reader_unread(&source->reader);
    }
    return AP_OK;
}

static enum ap_status find_format(struct ap_error *err, struct ap_log_source *source) {
    const char *bytes;
    size_t len;
    enum ap_status st = ap_line_reader_peek(err, &source->reader, &bytes, &len);
    if (st)
        return st;
    return ap_log_is_document(bytes, len) ? read_document(err, source)
                                          : find_line_format(err, source);
}

// A misspelt option is a part of the file's name, of which there is none then.
static enum ap_status open_file(struct ap_error *err, struct ap_log_source *source) {
    const char *path = source->argument.path;
    struct ap_error why;
    enum ap_status st = ap_line_reader_open(&why, &source->reader, path);
    const char *comma = strrchr(path, ',');
    if (st == AP_INPUT && comma && strchr(comma, '='))
        return ap_fail(err, st,
                       "%s (options are offset, time-scale, scale, axes, hand, up, frame "
                       "and invert)",
                       why.text);
    return st ? ap_fail(err, st, "%s", why.text) : AP_OK;
}

enum ap_status ap_log_source_open(struct ap_error *err, struct ap_log_source *source,
                                  const char *argument, bool skip_bad) {
    *source = (struct ap_log_source){
        .reader = {.bytes = {.fd = -1}}, .skip_bad = skip_bad, .last_t_ns = INT64_MIN};
    enum ap_status st = ap_log_argument_parse(err, argument, &source->argument);
    if (!st)
        st = open_file(err, source);
    return st ? st : find_format(err, source);
}

void ap_log_source_finish(struct ap_log_source *source) {
    ap_line_reader_close(&source->reader);
    ap_report_log_destroy(source->reports);
    source->reports = NULL;
    ap_row_table_destroy(source->document);
    source->document = NULL;
    free(source->imu);
    source->imu = NULL;
    free(source->named);
    source->named = NULL;
    free(source->header);
    source->header = NULL;
}

static bool check_time(const struct ap_log_source *source, int64_t t_ns, size_t column,
                       struct ap_bad_line *bad) {
    if (t_ns >= source->last_t_ns)
        return true;
    ap_bad_line_at(bad, "", "",
                   "a time not before the line before (%" PRId64 " ns), not %" PRId64 " ns",
                   source->last_t_ns, t_ns);
    bad->column = column;
    return false;
}

// A role renames the one device of a CSV; which of several it would mean, nobody can say.
static enum ap_status check_role(struct ap_error *err, struct ap_log_source *source) {
    struct ap_field name = source->row.device;
    if (!source->argument.role.len || !name.len)
        return AP_OK;
    if (!source->only_device[0])
        memcpy(source->only_device, name.text, name.len);
    if (strlen(source->only_device) == name.len &&
        memcmp(source->only_device, name.text, name.len) == 0)
        return AP_OK;
    return ap_fail(err, AP_INPUT,
                   "%s:%" PRId64 ":%zu: expected only the device '%s', because %.*s= renames it; "
                   "leave the prefix away to read all the devices of this file",
                   source->reader.name, source->reader.line, source->row.device_column,
                   source->only_device, (int)source->argument.role.len, source->argument.role.text);
}

// Whether a format's rows say where their device is, or a body's model did.
static bool is_placed(enum ap_log_format format) {
    return format != AP_LOG_HID && format != AP_LOG_IMU;
}

// The row is the source's next one, as its options say.
static bool give_row(struct ap_log_source *source, struct ap_bad_line *bad) {
    source->last_t_ns = source->row.t_ns;
    if (!ap_log_argument_apply(&source->argument, is_placed(source->format), &source->row)) {
        ap_bad_line_at(bad, "", "",
                       "a time of at most 4e18 ns and a place of at most 1e9 m in "
                       "size, with the log's options too");
        bad->column = source->row.t_column;
        return false;
    }
    source->has_row = true;
    return true;
}

// Rates and forces: the fusion says how it is turned, the body of the role where it is.
static bool take_imu_line(struct ap_log_source *source, const char *line, size_t len,
                          struct ap_bad_line *bad) {
    struct ap_imu_line imu;
    bool has_row;
    if (!ap_imu_line_parse(line, len, &imu, bad) ||
        !check_time(source, imu.t_ns, imu.t_column, bad) ||
        !ap_log_imu_take(source->imu, &imu, &source->argument.axes, &source->row, &has_row, bad))
        return false;
    source->last_t_ns = imu.t_ns;
    if (!has_row)
        return true;
    struct ap_field role = ap_log_source_device(source);
    struct ap_pose *pose = &source->row.pose;
    if (source->argument.invert)
        pose->q = ap_quat_conj(pose->q);
    pose->p = ap_body_place(ap_body_part_of(role.text, role.len), pose->q);
    return give_row(source, bad);
}

static bool take_named_line(struct ap_log_source *source, const char *line, size_t len,
                            struct ap_bad_line *bad) {
    struct ap_log_named *n = source->named;
    n->count = n->given = 0;
    int count;
    if (!ap_named_parse(line, len, &n->columns, n->rows, &count, bad) ||
        (count && !check_time(source, n->rows[0].t_ns, n->rows[0].t_column, bad)))
        return false;
    n->count = count;
    return true;
}

// The line's first row, of formats whose lines are one.
static bool take_row_line(struct ap_log_source *source, const char *line, size_t len,
                          struct ap_bad_line *bad) {
    struct ap_row *row = &source->row;
    bool ok = source->format == AP_LOG_CSV
                  ? ap_csv_parse(line, len, &source->columns, source->fields, row, bad)
              : source->format == AP_LOG_TUM ? ap_tum_parse(line, len, row, bad)
                                             : ap_euroc_parse(line, len, row, bad);
    return ok && check_time(source, row->t_ns, row->t_column, bad) && give_row(source, bad);
}

// A line of most formats: one row. Of a recording: none, or one for each tracker.
static bool take_line(struct ap_log_source *source, const char *line, size_t len,
                      struct ap_bad_line *bad) {
    if (source->format == AP_LOG_HID)
        return ap_report_log_feed(source->reports, line, len, bad);
    if (ap_log_line_is_empty(line, len))
        return true;
    return source->format == AP_LOG_IMU     ? take_imu_line(source, line, len, bad)
           : source->format == AP_LOG_NAMED ? take_named_line(source, line, len, bad)
                                            : take_row_line(source, line, len, bad);
}

// A row of what was taken before; false: there is none. What the options make of it may be bad.
static bool take_kept(struct ap_log_source *source, bool *ok, struct ap_bad_line *bad) {
    struct ap_log_named *n = source->named;
    bool got = source->format == AP_LOG_HID ? ap_report_log_take(source->reports, &source->row)
               : source->format == AP_LOG_DOCUMENT
                   ? ap_row_table_take(source->document, &source->row, &source->frame)
                   : n && n->given < n->count;
    if (got && n) {
        source->row = n->rows[n->given++];
        source->row.pose.p = ap_vec3_scale(source->argument.scale_m > 0 ? 1 : n->columns.scale_m,
                                           source->row.pose.p);
    }
    *ok = !got || give_row(source, bad);
    return got;
}

static enum ap_status at_end(struct ap_error *err, struct ap_log_source *source) {
    source->at_end = true;
    if (source->format == AP_LOG_IMU && source->imu->first_count < AP_LOG_IMU_FIRST)
        return ap_fail(err, AP_INPUT, "%s: no pose in it; rates and forces of fewer than %d lines",
                       source->reader.name, AP_LOG_IMU_FIRST);
    return source->format == AP_LOG_HID
               ? ap_report_log_check_end(err, source->reports, source->reader.name)
               : AP_OK;
}

static enum ap_status next_line(struct ap_error *err, struct ap_log_source *source) {
    enum ap_line_kind kind;
    const char *line;
    size_t len;
    enum ap_status st = ap_line_reader_next(err, &source->reader, &kind, &line, &len);
    if (st)
        return st;
    struct ap_bad_line bad;
    if (kind == AP_LINE_END)
        return at_end(err, source);
    if (kind == AP_LINE_TOO_LONG)
        return reject_long_line(err, source);
    return take_line(source, line, len, &bad) ? AP_OK : ap_log_source_reject(err, source, &bad);
}

enum ap_status ap_log_source_advance(struct ap_error *err, struct ap_log_source *source) {
    source->has_row = false;
    while (!source->has_row && !source->at_end) {
        struct ap_bad_line bad;
        bool ok;
        enum ap_status st = AP_OK;
        if (!take_kept(source, &ok, &bad))
            st = next_line(err, source);
        else if (!ok)
            st = ap_log_source_reject(err, source, &bad);
        if (st)
            return st;
    }
    return source->has_row ? check_role(err, source) : AP_OK;
}

struct ap_field ap_log_source_device(const struct ap_log_source *source) {
    static const struct ap_field head = {"head", 4};
    if (source->argument.role.len)
        return source->argument.role;
    return source->row.device.len ? source->row.device : head;
}
