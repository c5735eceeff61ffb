#include "src/device/log/poselog_format.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "src/device/log/decimal.h"
#include "src/device/log/poselog_fields.h"
#include "src/device/log/poselog_named.h"
#include "src/device/unit_quat.h"

static bool is_blank(char c) {
    return c == ' ' || c == '\t';
}

bool ap_log_line_is_empty(const char *line, size_t len) {
    size_t i = 0;
    while (i < len && is_blank(line[i]))
        i++;
    return i == len || line[i] == '#';
}

bool ap_bad_line_at(struct ap_bad_line *bad, const char *line, const char *at, const char *format,
                    ...) {
    bad->column = (size_t)(at - line) + 1;
    va_list args;
    va_start(args, format);
    vsnprintf(bad->expected, sizeof bad->expected, format, args);
    va_end(args);
    return false;
}

static struct ap_field trimmed(const char *text, const char *end) {
    while (text < end && is_blank(*text))
        text++;
    while (end > text && is_blank(end[-1]))
        end--;
    return (struct ap_field){text, (size_t)(end - text)};
}

size_t ap_split_commas(const char *line, size_t len, struct ap_field *fields, size_t max) {
    const char *end = line + len, *from = line;
    size_t n = 0;
    for (const char *p = line; p < end; p++) {
        if (*p != ',')
            continue;
        if (n < max)
            fields[n] = trimmed(from, p);
        n++;
        from = p + 1;
    }
    if (n < max)
        fields[n] = trimmed(from, end);
    return n + 1;
}

size_t ap_split_blanks(const char *line, size_t len, struct ap_field *fields, size_t max) {
    const char *end = line + len, *p = line;
    size_t n = 0;
    for (;;) {
        while (p < end && is_blank(*p))
            p++;
        if (p == end)
            return n;
        const char *from = p;
        while (p < end && !is_blank(*p))
            p++;
        if (n < max)
            fields[n] = (struct ap_field){from, (size_t)(p - from)};
        n++;
    }
}

// A number this large is a mistake, and nothing computed from a smaller one overflows.
static const double FARTHEST_M = 1e9;

bool ap_field_number(const char *line, struct ap_field f, const char *name, double *value,
                     struct ap_bad_line *bad) {
    if (ap_decimal_double(f.text, f.len, value) && *value <= FARTHEST_M && *value >= -FARTHEST_M)
        return true;
    return ap_bad_line_at(bad, line, f.text, "a decimal number for %s, at most 1e9 in size", name);
}

bool ap_field_time(const char *line, const char *at, bool read, int64_t t_ns, const char *unit,
                   struct ap_bad_line *bad) {
    // Differences of two such times, and what a clock adds to them, stay within 64 bits.
    static const int64_t FARTHEST_NS = INT64_C(4000000000000000000);
    if (read && t_ns <= FARTHEST_NS && t_ns >= -FARTHEST_NS)
        return true;
    return ap_bad_line_at(bad, line, at, "the time in %s, at most 4e18 ns in size", unit);
}

bool ap_field_quat(const char *line, const char *at, struct ap_quat *q, struct ap_bad_line *bad) {
    if (ap_quat_make_unit(q))
        return true;
    return ap_bad_line_at(bad, line, at, "a unit quaternion, its length between 0.9 and 1.1");
}

bool ap_log_device_name_ok(struct ap_field name) {
    if (name.len == 0 || name.len >= AP_LOG_DEVICE_NAME_MAX)
        return false;
    for (size_t i = 0; i < name.len; i++) {
        unsigned char c = (unsigned char)name.text[i];
        if (c <= ' ' || c == ',' || c == '"' || c == '\'' || c == 0x7f)
            return false;
    }
    return true;
}

enum ap_log_format ap_log_format_of(const char *line, size_t len) {
    struct ap_field fields[2];
    double number;
    size_t commas = ap_split_commas(line, len, fields, 2) - 1;
    bool numeric = ap_decimal_double(fields[0].text, fields[0].len, &number);
    if (commas && !numeric)
        return ap_named_is_header(line, len) ? AP_LOG_NAMED : AP_LOG_CSV;
    if (commas)
        return commas == 6 ? AP_LOG_IMU : AP_LOG_EUROC;
    if (!ap_split_blanks(line, len, fields, 2))
        return AP_LOG_UNKNOWN;
    if (ap_decimal_double(fields[0].text, fields[0].len, &number))
        return AP_LOG_TUM;
    // hid-recorder: "D: 0", "R: 253 05 0c …", "N: name", "E: 000000.000000 14 …"
    if (fields[0].len == 2 && fields[0].text[1] == ':' && strchr("DRNPIE", fields[0].text[0]))
        return AP_LOG_HID;
    return AP_LOG_UNKNOWN;
}
