#include "src/device/poselog_source.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

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
             "a pose log: CSV with the header t_ns,device,px,…, TUM lines (t x y z qx qy qz qw) or "
             "EuRoC CSV");
    return ap_log_source_reject(err, source, &bad);
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
            return ap_fail(err, AP_INPUT, "%s: no pose in it; expected CSV, TUM or EuRoC lines",
                           source->reader.name);
        if (kind == AP_LINE_TEXT && ap_log_line_is_empty(line, len))
            continue;
        if (kind == AP_LINE_TEXT)
            source->format = ap_log_format_of(line, len);
        if (source->format == AP_LOG_HID)
            return ap_fail(err, AP_INPUT,
                           "%s: a raw HID recording, which this version does not read; convert it "
                           "to CSV, TUM or EuRoC",
                           source->reader.name);
        if (source->format == AP_LOG_CSV)
            st = take_header(err, source, line, len);
        else if (source->format != AP_LOG_UNKNOWN)
            ap_line_reader_unread(&source->reader);
        else
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

enum ap_status ap_log_source_advance(struct ap_error *err, struct ap_log_source *source) {
    source->has_row = false;
    while (!source->has_row && !source->at_end) {
        enum ap_line_kind kind;
        const char *line;
        size_t len;
        enum ap_status st = ap_line_reader_next(err, &source->reader, &kind, &line, &len);
        if (st)
            return st;
        struct ap_bad_line bad;
        if (kind == AP_LINE_END)
            source->at_end = true;
        else if (kind == AP_LINE_TOO_LONG)
            st = reject_long_line(err, source);
        else if (ap_log_line_is_empty(line, len))
            continue;
        else if (!parse(source, line, len, &bad))
            st = ap_log_source_reject(err, source, &bad);
        else {
            source->has_row = true;
            source->last_t_ns = source->row.t_ns;
            st = check_role(err, source);
        }
        if (st)
            return st;
    }
    return AP_OK;
}

struct ap_field ap_log_source_device(const struct ap_log_source *source) {
    static const struct ap_field head = {"head", 4};
    if (source->role.len)
        return source->role;
    return source->row.device.len ? source->row.device : head;
}
