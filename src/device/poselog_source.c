#include "src/device/poselog_source.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "src/device/hid/recording.h"

static bool is_word_byte(char c, bool first) {
    bool letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
    return letter || (!first && ((c >= '0' && c <= '9') || c == '-'));
}

// "left=x.csv" has a role, "./a=b.csv" and "2=1" have none.
static const char *split_role(const char *argument, struct ap_field *role) {
    size_t n = 0;
    while (is_word_byte(argument[n], n == 0))
        n++;
    if (n == 0 || argument[n] != '=')
        return argument;
    *role = (struct ap_field){argument, n};
    return argument + n + 1;
}

enum ap_status ap_log_source_reject(struct ap_error *err, struct ap_log_source *source,
                                    const struct ap_bad_line *bad) {
    source->has_row = false;
    if (source->skip_bad) {
        source->skipped++;
        return AP_OK;
    }
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
    if (ap_csv_parse_header(source->header, len, &source->columns, &bad))
        return AP_OK;
    // Without its header nothing in the file can be read, so this is no line to skip.
    source->skip_bad = false;
    return ap_log_source_reject(err, source, &bad);
}

static enum ap_status reject_unknown(struct ap_error *err, struct ap_log_source *source) {
    struct ap_bad_line bad = {.column = 1};
    snprintf(bad.expected, sizeof bad.expected,
             "a pose log: CSV with the header t_ns,device,px,…, TUM lines (t x y z qx qy qz qw), "
             "EuRoC CSV or a raw HID recording");
    return ap_log_source_reject(err, source, &bad);
}

static enum ap_status need_reports(struct ap_error *err, struct ap_log_source *source) {
    if (source->reports)
        return AP_OK;
    source->reports = ap_report_log_create();
    if (!source->reports)
        return ap_fail(err, AP_ENVIRONMENT, "%s: out of memory", source->reader.name);
    ap_report_log_set_role(source->reports, source->role);
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

static enum ap_status find_format(struct ap_error *err, struct ap_log_source *source) {
    while (source->format == AP_LOG_UNKNOWN) {
        enum ap_line_kind kind;
        const char *line;
        size_t len;
        enum ap_status st = ap_line_reader_next(err, &source->reader, &kind, &line, &len);
        if (st)
            return st;
        if (kind == AP_LINE_END)
            return ap_fail(err, AP_INPUT,
                           "%s: no pose in it; expected CSV, TUM, EuRoC or HID lines",
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
        if (source->format == AP_LOG_CSV)
            st = take_header(err, source, line, len);
        else if (source->format == AP_LOG_HID)
            st = begin_reports(err, source);
        if (source->format != AP_LOG_CSV && source->format != AP_LOG_UNKNOWN)
            ap_line_reader_unread(&source->reader);
        else if (source->format == AP_LOG_UNKNOWN)
            st = kind == AP_LINE_TOO_LONG ? reject_long_line(err, source)
                                          : reject_unknown(err, source);
        if (st)
            return st;
    }
    return AP_OK;
}

enum ap_status ap_log_source_open(struct ap_error *err, struct ap_log_source *source,
                                  const char *argument, bool skip_bad) {
    *source =
        (struct ap_log_source){.reader = {.fd = -1}, .skip_bad = skip_bad, .last_t_ns = INT64_MIN};
    const char *path = split_role(argument, &source->role);
    if (!*path)
        return ap_fail(err, AP_USAGE, "'%s': expected a file name, as in left=hand.csv", argument);
    if (source->role.len >= AP_LOG_DEVICE_NAME_MAX)
        return ap_fail(err, AP_USAGE, "'%s': expected a device name of at most %d bytes", argument,
                       AP_LOG_DEVICE_NAME_MAX - 1);
    enum ap_status st = ap_line_reader_open(err, &source->reader, path);
    return st ? st : find_format(err, source);
}

void ap_log_source_finish(struct ap_log_source *source) {
    ap_line_reader_close(&source->reader);
    ap_report_log_destroy(source->reports);
    source->reports = NULL;
    free(source->header);
    source->header = NULL;
}

static bool parse(struct ap_log_source *source, const char *line, size_t len,
                  struct ap_bad_line *bad) {
    struct ap_row *row = &source->row;
    bool ok = source->format == AP_LOG_CSV
                  ? ap_csv_parse(line, len, &source->columns, source->fields, row, bad)
              : source->format == AP_LOG_TUM ? ap_tum_parse(line, len, row, bad)
                                             : ap_euroc_parse(line, len, row, bad);
    if (!ok)
        return false;
    if (row->t_ns >= source->last_t_ns)
        return true;
    return ap_bad_line_at(bad, line, line + row->t_column - 1,
                          "a time not before the line before (%" PRId64 " ns), not %" PRId64 " ns",
                          source->last_t_ns, row->t_ns);
}

// A role renames the one device of a CSV; which of several it would mean, nobody can say.
static enum ap_status check_role(struct ap_error *err, struct ap_log_source *source) {
    struct ap_field name = source->row.device;
    if (!source->role.len || !name.len)
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
                   source->only_device, (int)source->role.len, source->role.text);
}

static void give_row(struct ap_log_source *source) {
    source->has_row = true;
    source->last_t_ns = source->row.t_ns;
}

// A line of a text format: one row. A line of a recording: none, or one for each tracker.
static bool take_line(struct ap_log_source *source, const char *line, size_t len,
                      struct ap_bad_line *bad) {
    if (source->format == AP_LOG_HID) {
        if (!ap_report_log_feed(source->reports, line, len, bad))
            return false;
        if (ap_report_log_take(source->reports, &source->row))
            give_row(source);
        return true;
    }
    if (ap_log_line_is_empty(line, len))
        return true;
    if (!parse(source, line, len, bad))
        return false;
    give_row(source);
    return true;
}

static enum ap_status at_end(struct ap_error *err, struct ap_log_source *source) {
    source->at_end = true;
    return source->format == AP_LOG_HID
               ? ap_report_log_check_end(err, source->reports, source->reader.name)
               : AP_OK;
}

enum ap_status ap_log_source_advance(struct ap_error *err, struct ap_log_source *source) {
    source->has_row = false;
    if (source->format == AP_LOG_HID && ap_report_log_take(source->reports, &source->row))
        give_row(source);
    while (!source->has_row && !source->at_end) {
        enum ap_line_kind kind;
        const char *line;
        size_t len;
        enum ap_status st = ap_line_reader_next(err, &source->reader, &kind, &line, &len);
        if (st)
            return st;
        struct ap_bad_line bad;
        if (kind == AP_LINE_END)
            st = at_end(err, source);
        else if (kind == AP_LINE_TOO_LONG)
            st = reject_long_line(err, source);
        else if (!take_line(source, line, len, &bad))
            st = ap_log_source_reject(err, source, &bad);
        if (st)
            return st;
    }
    return source->has_row ? check_role(err, source) : AP_OK;
}

struct ap_field ap_log_source_device(const struct ap_log_source *source) {
    static const struct ap_field head = {"head", 4};
    if (source->role.len)
        return source->role;
    return source->row.device.len ? source->row.device : head;
}
