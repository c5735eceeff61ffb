#ifndef ANTIPODE_BASE_JSON_H
#define ANTIPODE_BASE_JSON_H

#include <jansson.h>
#include <stdbool.h>

#include "src/base/status.h"

// Strict reading of JSON from outside, over jansson. Every error names the file and the place in it
// as a JSON pointer ("room.json: /objects/3/ball/radius_m: expected a number > 0").

// Reads a whole document (at most 16 MiB, no duplicate keys, depth bounded by jansson). The caller
// json_decref()s *root. AP_INPUT with line and column on a syntax error.
enum ap_status ap_json_read(struct ap_error *err, const char *path, json_t **root);

// The same of bytes that are there already; `path` names them in messages.
enum ap_status ap_json_parse(struct ap_error *err, const char *path, const char *bytes, size_t len,
                             json_t **root);

// A value and how it was reached; a cursor lives on the stack and points to its parent's.
struct ap_json_at {
    const json_t *value;
    const struct ap_json_at *parent; // NULL at the root
    const char *key;                 // in an object, else NULL
    size_t index;                    // in an array
    const char *file;                // at the root
};

struct ap_json_at ap_json_root(const json_t *root, const char *file);

// A member (value NULL where absent) or element; the place is kept for messages.
struct ap_json_at ap_json_member(const struct ap_json_at *at, const char *key);
struct ap_json_at ap_json_element(const struct ap_json_at *at, size_t index);

// AP_INPUT: "FILE: /pointer: text".
enum ap_status ap_json_fail(struct ap_error *err, const struct ap_json_at *at, const char *format,
                            ...) AP_PRINTF(3, 4);

// An object with no keys but these (NULL-terminated list).
enum ap_status ap_json_check_keys(struct ap_error *err, const struct ap_json_at *at,
                                  const char *const *allowed);

// Typed reads of a required member; finite numbers only. The string is owned by the document.
enum ap_status ap_json_number(struct ap_error *err, const struct ap_json_at *object,
                              const char *key, double *value);
enum ap_status ap_json_numbers(struct ap_error *err, const struct ap_json_at *object,
                               const char *key, size_t count, double *values);
enum ap_status ap_json_string(struct ap_error *err, const struct ap_json_at *object,
                              const char *key, const char **value);
enum ap_status ap_json_bool(struct ap_error *err, const struct ap_json_at *object, const char *key,
                            bool *value);

// True where the object has the key: `if (ap_json_has(&o, "lit")) st = ap_json_bool(…)`.
bool ap_json_has(const struct ap_json_at *object, const char *key);

#endif
