#include <string.h>

#include "src/base/number.h"
#include "src/device/log/decimal.h"
#include "src/device/log/poselog_fields.h"

// Our own CSV. The nine columns that make a pose may stand in any order; what is not ours is kept.

enum csv_role {
    ROLE_T,
    ROLE_DEVICE,
    ROLE_PX,
    ROLE_PY,
    ROLE_PZ,
    ROLE_QX,
    ROLE_QY,
    ROLE_QZ,
    ROLE_QW,
    ROLE_REQUIRED,
    ROLE_TRIGGER = ROLE_REQUIRED,
    ROLE_SQUEEZE,
    ROLE_SELECT,
    ROLE_RESET,
    ROLE_COUNT,
    ROLE_OTHER = ROLE_COUNT,
};

static const char *const role_names[ROLE_COUNT] = {"t_ns",    "device", "px",   "py", "pz",
                                                   "qx",      "qy",     "qz",   "qw", "trigger",
                                                   "squeeze", "select", "reset"};

static bool is_word(struct ap_field f, const char *word) {
    return f.len == strlen(word) && memcmp(f.text, word, f.len) == 0;
}

static uint8_t role_of(struct ap_field name) {
    for (uint8_t r = 0; r < ROLE_COUNT; r++)
        if (is_word(name, role_names[r]))
            return r;
    return ROLE_OTHER;
}

static bool seen_before(const struct ap_csv_columns *columns, size_t i) {
    struct ap_field name = columns->name[i];
    for (size_t k = 0; k < i; k++)
        if (columns->name[k].len == name.len &&
            memcmp(columns->name[k].text, name.text, name.len) == 0)
            return true;
    return false;
}

bool ap_csv_parse_header(const char *line, size_t len, struct ap_csv_columns *columns,
                         struct ap_bad_line *bad) {
    size_t n = ap_split_commas(line, len, columns->name, AP_LOG_COLUMNS_MAX);
    if (n > AP_LOG_COLUMNS_MAX)
        return ap_bad_line_at(bad, line, line, "a header of at most %d columns, not %zu",
                              AP_LOG_COLUMNS_MAX, n);
    bool found[ROLE_COUNT + 1] = {false};
    for (size_t i = 0; i < n; i++) {
        struct ap_field name = columns->name[i];
        columns->role[i] = role_of(name);
        found[columns->role[i]] = true;
        if (seen_before(columns, i))
            return ap_bad_line_at(bad, line, name.text, "each column name once, not '%.*s' again",
                                  (int)(name.len < 64 ? name.len : 64), name.text);
    }
    for (int r = 0; r < ROLE_REQUIRED; r++)
        if (!found[r])
            return ap_bad_line_at(bad, line, line,
                                  "the header t_ns,device,px,py,pz,qx,qy,qz,qw[,…]; it has no %s",
                                  role_names[r]);
    columns->count = n;
    return true;
}

static bool parse_fraction(const char *line, struct ap_field f, const char *name, float *value,
                           struct ap_bad_line *bad) {
    double v = 0;
    if (f.len && !(ap_decimal_double(f.text, f.len, &v) && v >= 0 && v <= 1))
        return ap_bad_line_at(bad, line, f.text, "%s between 0 and 1, or nothing", name);
    *value = (float)v;
    return true;
}

static bool parse_flag(const char *line, struct ap_field f, const char *name, bool *value,
                       struct ap_bad_line *bad) {
    if (f.len && !is_word(f, "0") && !is_word(f, "1"))
        return ap_bad_line_at(bad, line, f.text, "%s 0 or 1, or nothing", name);
    *value = is_word(f, "1");
    return true;
}

static bool parse_time(const char *line, struct ap_field f, struct ap_row *row,
                       struct ap_bad_line *bad) {
    bool read = ap_parse_int64(f.text, f.len, &row->t_ns);
    row->t_column = (size_t)(f.text - line) + 1;
    return ap_field_time(line, f.text, read, row->t_ns, "whole nanoseconds", bad);
}

static bool parse_device(const char *line, struct ap_field f, struct ap_row *row,
                         struct ap_bad_line *bad) {
    if (!ap_log_device_name_ok(f))
        return ap_bad_line_at(bad, line, f.text,
                              "a device: head, left, right or a name of 1 to %d bytes without "
                              "blanks and quotes",
                              AP_LOG_DEVICE_NAME_MAX - 1);
    row->device = f;
    row->device_column = (size_t)(f.text - line) + 1;
    return true;
}

bool ap_csv_parse(const char *line, size_t len, const struct ap_csv_columns *columns,
                  struct ap_field *fields, struct ap_row *row, struct ap_bad_line *bad) {
    size_t n = ap_split_commas(line, len, fields, columns->count);
    if (n != columns->count)
        return ap_bad_line_at(bad, line, line + len, "%zu fields as in the header, not %zu",
                              columns->count, n);
    double v[ROLE_REQUIRED];
    const char *quat_at = line;
    *row = (struct ap_row){0};
    for (size_t i = 0; i < n; i++) {
        uint8_t role = columns->role[i];
        struct ap_field f = fields[i];
        bool ok = true;
        if (role >= ROLE_PX && role <= ROLE_QW)
            ok = ap_field_number(line, f, role_names[role], &v[role], bad);
        else if (role == ROLE_T)
            ok = parse_time(line, f, row, bad);
        else if (role == ROLE_DEVICE)
            ok = parse_device(line, f, row, bad);
        else if (role == ROLE_TRIGGER)
            ok = parse_fraction(line, f, "trigger", &row->trigger, bad);
        else if (role == ROLE_SQUEEZE)
            ok = parse_fraction(line, f, "squeeze", &row->squeeze, bad);
        else if (role == ROLE_SELECT)
            ok = parse_flag(line, f, "select", &row->select, bad);
        else if (role == ROLE_RESET)
            ok = parse_flag(line, f, "reset", &row->reset, bad);
        if (!ok)
            return false;
        if (role == ROLE_QX)
            quat_at = f.text;
    }
    row->pose.p = (struct ap_vec3){v[ROLE_PX], v[ROLE_PY], v[ROLE_PZ]};
    row->pose.q = (struct ap_quat){v[ROLE_QX], v[ROLE_QY], v[ROLE_QZ], v[ROLE_QW]};
    return ap_field_quat(line, quat_at, &row->pose.q, bad);
}
