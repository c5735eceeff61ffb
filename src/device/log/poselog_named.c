#include "src/device/log/poselog_named.h"

#include <math.h>
#include <string.h>
#include <strings.h>

#include "src/device/log/decimal.h"
#include "src/device/log/poselog_fields.h"

static bool is(struct ap_field f, const char *word) {
    return f.len == strlen(word) && strncasecmp(f.text, word, f.len) == 0;
}

static bool ends_with(struct ap_field f, const char *word) {
    size_t n = strlen(word);
    return f.len > n && strncasecmp(f.text + f.len - n, word, n) == 0;
}

static bool begins_with(struct ap_field f, const char *word) {
    size_t n = strlen(word);
    return f.len >= n && strncasecmp(f.text, word, n) == 0;
}

bool ap_named_is_header(const char *line, size_t len) {
    struct ap_field fields[AP_LOG_COLUMNS_MAX];
    size_t n = ap_split_commas(line, len, fields, AP_LOG_COLUMNS_MAX);
    for (size_t i = 0; i < n && i < AP_LOG_COLUMNS_MAX; i++)
        if (ends_with(fields[i], "_pos_x"))
            return true;
    return false;
}

// Our names for what recorders call them; others keep theirs.
static void name_device(char name[AP_LOG_DEVICE_NAME_MAX], struct ap_field prefix) {
    static const struct {
        const char *prefix, *device;
    } known[] = {{"hmd", "head"},
                 {"head", "head"},
                 {"camera", "head"},
                 {"left_controller", "left"},
                 {"right_controller", "right"},
                 {"left_hand", "left"},
                 {"right_hand", "right"},
                 {"lefthand", "left"},
                 {"righthand", "right"},
                 {"controller_left", "left"},
                 {"controller_right", "right"}};
    for (size_t i = 0; i < sizeof known / sizeof *known; i++)
        if (is(prefix, known[i].prefix)) {
            memcpy(name, known[i].device, strlen(known[i].device) + 1);
            return;
        }
    memcpy(name, prefix.text, prefix.len);
    name[prefix.len] = 0;
}

// The column of that name, or `count`.
static size_t find(const struct ap_field *fields, size_t count, struct ap_field prefix,
                   const char *suffix) {
    for (size_t i = 0; i < count; i++)
        if (fields[i].len == prefix.len + strlen(suffix) &&
            memcmp(fields[i].text, prefix.text, prefix.len) == 0 && ends_with(fields[i], suffix))
            return i;
    return count;
}

static bool add_device(const char *line, const struct ap_field *fields, size_t count,
                       struct ap_field prefix, struct ap_named_columns *c,
                       struct ap_bad_line *bad) {
    static const char *const pos[] = {"_pos_x", "_pos_y", "_pos_z"}, *const rot[] = {
                                                                         "_rot_x", "_rot_y",
                                                                         "_rot_z", "_rot_w"};
    if (c->device_count == AP_NAMED_DEVICES_MAX || !ap_log_device_name_ok(prefix))
        return ap_bad_line_at(bad, line, prefix.text, "at most %d devices with names as in CSV",
                              AP_NAMED_DEVICES_MAX);
    struct ap_named_device *d = &c->devices[c->device_count];
    bool all = true;
    for (size_t i = 0; i < 3; i++)
        all = (d->pos[i] = find(fields, count, prefix, pos[i])) < count && all;
    for (size_t i = 0; i < 4; i++)
        all = (d->rot[i] = find(fields, count, prefix, rot[i])) < count && all;
    if (!all)
        return ap_bad_line_at(bad, line, prefix.text,
                              "columns %.*s_pos_x, _y, _z and %.*s_rot_x, _y, _z, _w",
                              (int)(prefix.len < 48 ? prefix.len : 48), prefix.text,
                              (int)(prefix.len < 48 ? prefix.len : 48), prefix.text);
    name_device(d->name, prefix);
    for (int i = 0; i < c->device_count; i++)
        if (strcmp(c->devices[i].name, d->name) == 0)
            return ap_bad_line_at(bad, line, prefix.text, "one device '%s', not two", d->name);
    c->device_count++;
    return true;
}

// time…, t_…, delta_time…: the first of them, in the unit that its name ends with.
static bool find_time(const struct ap_field *fields, size_t count, struct ap_named_columns *c) {
    static const struct {
        const char *suffix;
        double ns;
    } units[] = {{"_ns", 1}, {"_us", 1e3}, {"_ms", 1e6}, {"_s", 1e9}};
    for (size_t i = 0; i < count; i++) {
        if (!begins_with(fields[i], "time") && !begins_with(fields[i], "t_") &&
            !begins_with(fields[i], "delta_time"))
            continue;
        for (size_t u = 0; u < sizeof units / sizeof *units; u++)
            if (ends_with(fields[i], units[u].suffix)) {
                c->time = i;
                c->ns_per_unit = units[u].ns;
                return true;
            }
    }
    return false;
}

bool ap_named_parse_header(const char *line, size_t len, struct ap_named_columns *columns,
                           struct ap_bad_line *bad) {
    struct ap_field fields[AP_LOG_COLUMNS_MAX];
    size_t n = ap_split_commas(line, len, fields, AP_LOG_COLUMNS_MAX);
    struct ap_named_columns c = {.count = n, .scale_m = 1};
    if (n > AP_LOG_COLUMNS_MAX)
        return ap_bad_line_at(bad, line, line, "a header of at most %d columns, not %zu",
                              AP_LOG_COLUMNS_MAX, n);
    if (!find_time(fields, n, &c))
        return ap_bad_line_at(bad, line, line,
                              "a column of times, as time_ms, t_s or timestamp_ns");
    // The "who is Alyx?" recordings alone call their time so, and are in centimetres.
    if (is(fields[c.time], "delta_time_ms"))
        c.scale_m = 0.01;
    for (size_t i = 0; i < n; i++) {
        struct ap_field prefix = {fields[i].text, fields[i].len - strlen("_pos_x")};
        if (ends_with(fields[i], "_pos_x") && !add_device(line, fields, n, prefix, &c, bad))
            return false;
    }
    *columns = c;
    return true;
}

// *there = false where the device was not tracked.
static bool read_device(const char *line, const struct ap_field *f, const struct ap_named_device *d,
                        struct ap_pose *pose, bool *there, struct ap_bad_line *bad) {
    double v[7], size = 0;
    size_t empty = 0;
    for (int i = 0; i < 7; i++) {
        struct ap_field field = f[i < 3 ? d->pos[i] : d->rot[i - 3]];
        v[i] = 0;
        empty += field.len == 0;
        if (field.len && !ap_field_number(line, field, d->name, &v[i], bad))
            return false;
        size += i < 3 ? 0 : fabs(v[i]);
    }
    *there = size > 0 || (empty > 0 && empty < 7);
    if (!*there)
        return true;
    if (empty)
        return ap_bad_line_at(bad, line, f[d->pos[0]].text, "seven numbers of %s, or none",
                              d->name);
    *pose = (struct ap_pose){{v[0], v[1], v[2]}, {v[3], v[4], v[5], v[6]}};
    return ap_field_quat(line, f[d->rot[0]].text, &pose->q, bad);
}

// Through long double: whole nanoseconds stay what they are.
static bool read_time(const char *line, struct ap_field f, double ns_per_unit, int64_t *t_ns,
                      struct ap_bad_line *bad) {
    double value;
    if (ns_per_unit == 1e9)
        return ap_field_time(line, f.text, ap_decimal_seconds_ns(f.text, f.len, t_ns), *t_ns,
                             "decimal seconds", bad);
    bool read = ap_decimal_double(f.text, f.len, &value) && fabs(value) <= 4e18 / ns_per_unit;
    *t_ns = read ? (int64_t)llroundl((long double)value * (long double)ns_per_unit) : 0;
    return ap_field_time(line, f.text, read, *t_ns, "the unit of its column", bad);
}

bool ap_named_parse(const char *line, size_t len, const struct ap_named_columns *c,
                    struct ap_row rows[AP_NAMED_DEVICES_MAX], int *count, struct ap_bad_line *bad) {
    struct ap_field f[AP_LOG_COLUMNS_MAX];
    size_t n = ap_split_commas(line, len, f, AP_LOG_COLUMNS_MAX);
    if (n != c->count)
        return ap_bad_line_at(bad, line, line + len, "%zu fields as in the header, not %zu",
                              c->count, n);
    int64_t t_ns = 0;
    if (!read_time(line, f[c->time], c->ns_per_unit, &t_ns, bad))
        return false;
    int rows_count = 0;
    for (int i = 0; i < c->device_count; i++) {
        const struct ap_named_device *d = &c->devices[i];
        struct ap_pose pose;
        bool there;
        if (!read_device(line, f, d, &pose, &there, bad))
            return false;
        if (there)
            rows[rows_count++] =
                (struct ap_row){.t_ns = t_ns,
                                .device = {d->name, strlen(d->name)},
                                .pose = pose,
                                .t_column = (size_t)(f[c->time].text - line) + 1,
                                .device_column = (size_t)(f[d->pos[0]].text - line) + 1};
    }
    *count = rows_count;
    return true;
}
