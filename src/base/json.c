#include "src/base/json.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "src/base/file.h"

enum { MAX_DOCUMENT_BYTES = 16 << 20 };

enum ap_status ap_json_read(struct ap_error *err, const char *path, json_t **root) {
    char *bytes;
    size_t len;
    enum ap_status st = ap_file_read(err, path, MAX_DOCUMENT_BYTES, &bytes, &len);
    if (st)
        return st;
    st = ap_json_parse(err, path, bytes, len, root);
    free(bytes);
    return st;
}

enum ap_status ap_json_parse(struct ap_error *err, const char *path, const char *bytes, size_t len,
                             json_t **root) {
    json_error_t why;
    json_t *value = json_loadb(bytes, len, JSON_REJECT_DUPLICATES, &why);
    if (!value && json_error_code(&why) == json_error_out_of_memory)
        return ap_fail(err, AP_ENVIRONMENT, "%s: out of memory", path);
    if (!value)
        return ap_fail(err, AP_INPUT, "%s:%d:%d: not JSON: %s", path, why.line, why.column,
                       why.text);
    *root = value;
    return AP_OK;
}

struct ap_json_at ap_json_root(const json_t *root, const char *file) {
    return (struct ap_json_at){.value = root, .file = file};
}

struct ap_json_at ap_json_member(const struct ap_json_at *at, const char *key) {
    return (struct ap_json_at){.value = json_object_get(at->value, key), .parent = at, .key = key};
}

struct ap_json_at ap_json_element(const struct ap_json_at *at, size_t index) {
    return (struct ap_json_at){
        .value = json_array_get(at->value, index), .parent = at, .index = index};
}

static const char *write_pointer(const struct ap_json_at *at, char *text, size_t size) {
    if (!at->parent) {
        text[0] = '\0';
        return at->file;
    }
    const char *file = write_pointer(at->parent, text, size);
    size_t n = strlen(text);
    if (at->key)
        snprintf(text + n, size - n, "/%s", at->key);
    else
        snprintf(text + n, size - n, "/%zu", at->index);
    return file;
}

enum ap_status ap_json_fail(struct ap_error *err, const struct ap_json_at *at, const char *format,
                            ...) {
    char where[256], what[512];
    const char *file = write_pointer(at, where, sizeof where);
    va_list args;
    va_start(args, format);
    vsnprintf(what, sizeof what, format, args);
    va_end(args);
    return ap_fail(err, AP_INPUT, "%s: %s: %s", file, where[0] ? where : "/", what);
}

static bool listed(const char *key, const char *const *allowed) {
    for (; *allowed; allowed++)
        if (strcmp(key, *allowed) == 0)
            return true;
    return false;
}

enum ap_status ap_json_check_keys(struct ap_error *err, const struct ap_json_at *at,
                                  const char *const *allowed) {
    if (!json_is_object(at->value))
        return ap_json_fail(err, at, "expected an object");
    const char *key;
    json_t *member;
    json_object_foreach((json_t *)at->value, key, member) {
        if (listed(key, allowed))
            continue;
        struct ap_json_at place = ap_json_member(at, key);
        char known[256] = "";
        for (const char *const *a = allowed; *a; a++) {
            size_t n = strlen(known);
            snprintf(known + n, sizeof known - n, "%s%s", a == allowed ? "" : ", ", *a);
        }
        return ap_json_fail(err, &place, "unknown key; known here: %s", known);
    }
    return AP_OK;
}

static enum ap_status read_number(struct ap_error *err, const struct ap_json_at *at,
                                  double *value) {
    if (!json_is_number(at->value))
        return ap_json_fail(err, at, "expected a number");
    double v = json_number_value(at->value);
    if (!isfinite(v))
        return ap_json_fail(err, at, "expected a finite number");
    *value = v;
    return AP_OK;
}

enum ap_status ap_json_number(struct ap_error *err, const struct ap_json_at *object,
                              const char *key, double *value) {
    struct ap_json_at at = ap_json_member(object, key);
    return read_number(err, &at, value);
}

enum ap_status ap_json_numbers(struct ap_error *err, const struct ap_json_at *object,
                               const char *key, size_t count, double *values) {
    struct ap_json_at at = ap_json_member(object, key);
    double read[16];
    if (!json_is_array(at.value) || json_array_size(at.value) != count || count > 16)
        return ap_json_fail(err, &at, "expected an array of %zu numbers", count);
    for (size_t i = 0; i < count; i++) {
        struct ap_json_at element = ap_json_element(&at, i);
        enum ap_status st = read_number(err, &element, &read[i]);
        if (st)
            return st;
    }
    memcpy(values, read, count * sizeof *values);
    return AP_OK;
}

enum ap_status ap_json_string(struct ap_error *err, const struct ap_json_at *object,
                              const char *key, const char **value) {
    struct ap_json_at at = ap_json_member(object, key);
    if (!json_is_string(at.value))
        return ap_json_fail(err, &at, "expected a string");
    *value = json_string_value(at.value);
    return AP_OK;
}

enum ap_status ap_json_bool(struct ap_error *err, const struct ap_json_at *object, const char *key,
                            bool *value) {
    struct ap_json_at at = ap_json_member(object, key);
    if (!json_is_boolean(at.value))
        return ap_json_fail(err, &at, "expected true or false");
    *value = json_is_true(at.value);
    return AP_OK;
}

bool ap_json_has(const struct ap_json_at *object, const char *key) {
    return json_object_get(object->value, key) != NULL;
}
