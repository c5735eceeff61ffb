#include <string.h>

#include "src/base/number.h"
#include "src/device/log/decimal.h"
#include "src/device/inputlog.h"
#include "src/device/log/poselog_fields.h"

// "t_ns,device,path,value[,value2]": one line, by itself.

static const char *const devices[] = {"left", "right", "head", "gamepad", "treadmill"};

enum { DEVICE_COUNT = sizeof devices / sizeof *devices };

static bool is_word(struct ap_field f, const char *word) {
    return f.len == strlen(word) && memcmp(f.text, word, f.len) == 0;
}

static bool parse_device(const char *line, struct ap_field f, struct ap_input_row *row,
                         struct ap_bad_line *bad) {
    for (int d = 0; d < DEVICE_COUNT; d++)
        if (is_word(f, devices[d])) {
            row->device = devices[d];
            return true;
        }
    return ap_bad_line_at(bad, line, f.text, "left, right, head, gamepad or treadmill");
}

static bool path_byte(char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_' || c == '-' || c == '.';
}

// Lower-case words between single slashes, the first of them "input".
static bool parse_path(const char *line, struct ap_field f, struct ap_input_row *row,
                       struct ap_bad_line *bad) {
    static const char start[] = "/input/";
    size_t n = sizeof start - 1;
    bool ok = f.len > n && f.len < AP_INPUT_PATH_MAX && memcmp(f.text, start, n) == 0;
    for (size_t i = n; ok && i < f.len; i++) {
        bool slash = f.text[i] == '/';
        ok = slash ? f.text[i - 1] != '/' && i + 1 < f.len : path_byte(f.text[i]);
    }
    if (!ok)
        return ap_bad_line_at(bad, line, f.text,
                              "a path like /input/trigger/value, at most %d bytes",
                              AP_INPUT_PATH_MAX - 1);
    row->path = f;
    return true;
}

static struct ap_field last_word(struct ap_field path) {
    size_t at = path.len;
    while (at > 0 && path.text[at - 1] != '/')
        at--;
    return (struct ap_field){path.text + at, path.len - at};
}

// OpenXR's component names say what values there are.
static bool parse_value(const char *line, struct ap_field path, struct ap_field f, float *value,
                        struct ap_bad_line *bad) {
    struct ap_field word = last_word(path);
    bool button = is_word(word, "click") || is_word(word, "touch") || is_word(word, "ready");
    bool lever = is_word(word, "value") || is_word(word, "force");
    double v = 0;
    bool ok = ap_decimal_double(f.text, f.len, &v) && v <= 1 && v >= (button || lever ? 0 : -1);
    if (!ok || (button && v != 0 && v != 1))
        return ap_bad_line_at(bad, line, f.text, "%s for %.*s",
                              button  ? "0 or 1"
                              : lever ? "a number from 0 to 1"
                                      : "a number from -1 to 1",
                              (int)path.len, path.text);
    *value = (float)v;
    return true;
}

static bool is_pose(struct ap_field path) {
    return is_word(last_word(path), "pose");
}

bool ap_inputlog_parse(const char *line, size_t len, struct ap_input_row *row,
                       struct ap_bad_line *bad) {
    struct ap_field f[5];
    size_t n = ap_split_commas(line, len, f, 5);
    if (n < 4 || n > 5)
        return ap_bad_line_at(bad, line, n < 4 ? line + len : line,
                              "t_ns,device,path,value[,value2], not %zu fields", n);
    *row = (struct ap_input_row){.values = n == 5 && f[4].len ? 2 : 1};
    bool read = ap_parse_int64(f[0].text, f[0].len, &row->t_ns);
    if (!ap_field_time(line, f[0].text, read, row->t_ns, "whole nanoseconds", bad) ||
        !parse_device(line, f[1], row, bad) || !parse_path(line, f[2], row, bad))
        return false;
    if (is_pose(row->path))
        return ap_bad_line_at(bad, line, f[2].text,
                              "an input that has a value; poses come from pose logs");
    for (int i = 0; i < row->values; i++)
        if (!parse_value(line, row->path, f[3 + i], &row->value[i], bad))
            return false;
    return true;
}
