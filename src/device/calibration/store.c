#include "src/device/calibration/store.h"

#include <dirent.h>
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "src/base/file.h"
#include "src/base/json.h"

enum { VERSION = 1, FILE_NAME_MAX = 3 * AP_CALIBRATION_KEY_MAX + 8 };

void ap_device_key(char *key, size_t size, const char *serial, uint16_t vendor, uint16_t product) {
    if (serial[0])
        snprintf(key, size, "%s", serial);
    else
        snprintf(key, size, "%04x:%04x", vendor, product);
}

// --- files

// A key is what a device says: whatever is not a letter, a digit, '-' or '_' is %XX in the name.
static void file_name(char name[FILE_NAME_MAX], const char *key) {
    static const char plain[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_";
    size_t n = 0;
    for (const char *c = key; *c && n + 9 < FILE_NAME_MAX; c++)
        n += (size_t)snprintf(name + n, FILE_NAME_MAX - n, strchr(plain, *c) ? "%c" : "%%%02X",
                              (unsigned char)*c);
    snprintf(name + n, FILE_NAME_MAX - n, ".json");
}

// malloc'ed "DIR/devices/KEY.json"; NULL without memory.
static char *device_path(const char *dir, const char *key) {
    char name[FILE_NAME_MAX], below[FILE_NAME_MAX + 8];
    file_name(name, key);
    snprintf(below, sizeof below, "devices/%s", name);
    return ap_path_join(dir, below);
}

static enum ap_status no_memory(struct ap_error *err) {
    return ap_fail(err, AP_ENVIRONMENT, "out of memory");
}

static enum ap_status write_json(struct ap_error *err, const char *path, json_t *root) {
    char *text = root ? json_dumps(root, JSON_INDENT(2) | JSON_REAL_PRECISION(17)) : NULL;
    size_t len = text ? strlen(text) : 0;
    if (text)
        text[len++] = '\n'; // in the place of the NUL
    enum ap_status st = text ? ap_file_write(err, path, text, len) : no_memory(err);
    free(text);
    json_decref(root);
    return st;
}

// --- JSON

static enum ap_status check_version(struct ap_error *err, const struct ap_json_at *root) {
    double version;
    enum ap_status st = ap_json_number(err, root, "version", &version);
    struct ap_json_at at = ap_json_member(root, "version");
    if (!st && version != VERSION)
        st = ap_json_fail(err, &at, "this program reads version %d, not %g: calibrate again",
                          VERSION, version);
    return st;
}

static enum ap_status read_within(struct ap_error *err, const struct ap_json_at *object,
                                  const char *key, double least, double most, double *value) {
    double v;
    enum ap_status st = ap_json_number(err, object, key, &v);
    struct ap_json_at at = ap_json_member(object, key);
    if (!st && !(v >= least && v <= most))
        st = ap_json_fail(err, &at, "expected a number from %g to %g, not %.17g", least, most, v);
    if (!st)
        *value = v;
    return st;
}

static enum ap_status read_vec3(struct ap_error *err, const struct ap_json_at *object,
                                const char *key, double longest, struct ap_vec3 *value) {
    double v[3];
    enum ap_status st = ap_json_numbers(err, object, key, 3, v);
    struct ap_json_at at = ap_json_member(object, key);
    if (st)
        return st;
    struct ap_vec3 out = {v[0], v[1], v[2]};
    if (ap_vec3_length(out) > longest)
        return ap_json_fail(err, &at, "expected a vector of length up to %g", longest);
    *value = out;
    return AP_OK;
}

static enum ap_status read_bias(struct ap_error *err, const struct ap_json_at *root,
                                struct ap_rest_result *rest) {
    static const char *const keys[] = {"gyro_rad_s", "accel_m_s2",       "seconds",
                                       "poses",      "gyro_sigma_rad_s", NULL};
    struct ap_json_at at = ap_json_member(root, "bias");
    double poses = 0;
    enum ap_status st = ap_json_check_keys(err, &at, keys);
    if (!st)
        st = read_vec3(err, &at, "gyro_rad_s", 0.1, &rest->bias.gyr_rad_s);
    if (!st)
        st = read_vec3(err, &at, "accel_m_s2", 1, &rest->bias.acc_m_s2);
    if (!st)
        st = read_within(err, &at, "seconds", 0, 1e9, &rest->seconds);
    if (!st)
        st = read_within(err, &at, "poses", 1, AP_RESTS_MAX, &poses);
    if (!st)
        st = read_within(err, &at, "gyro_sigma_rad_s", 0, 1, &rest->gyr_sigma_rad_s);
    rest->poses = (int)poses;
    return st;
}

static enum ap_status read_mount(struct ap_error *err, const struct ap_json_at *root,
                                 struct ap_quat *q) {
    static const char *const keys[] = {"tracker_from_body", NULL};
    struct ap_json_at object = ap_json_member(root, "mount");
    double v[4];
    enum ap_status st = ap_json_check_keys(err, &object, keys);
    if (!st)
        st = ap_json_numbers(err, &object, "tracker_from_body", 4, v);
    if (st)
        return st;
    struct ap_json_at at = ap_json_member(&object, "tracker_from_body");
    double square = v[0] * v[0] + v[1] * v[1] + v[2] * v[2] + v[3] * v[3];
    if (!(fabs(square - 1) < 1e-6))
        return ap_json_fail(err, &at, "expected a unit quaternion x, y, z, w");
    *q = ap_quat_normalize((struct ap_quat){v[0], v[1], v[2], v[3]});
    return AP_OK;
}

static enum ap_status parse_device(struct ap_error *err, const struct ap_json_at *root,
                                   struct ap_device_calibration *out) {
    static const char *const keys[] = {"version", "device", "bias", "mount", NULL};
    struct ap_device_calibration c = {.tracker_from_body = AP_QUAT_IDENTITY};
    const char *key = "";
    enum ap_status st = ap_json_check_keys(err, root, keys);
    if (!st)
        st = check_version(err, root);
    if (!st)
        st = ap_json_string(err, root, "device", &key);
    struct ap_json_at at = ap_json_member(root, "device");
    if (!st && (!*key || strlen(key) >= sizeof c.key))
        st = ap_json_fail(err, &at, "expected 1 to %d bytes", AP_CALIBRATION_KEY_MAX - 1);
    c.has_bias = ap_json_has(root, "bias");
    c.has_mount = ap_json_has(root, "mount");
    if (!st && c.has_bias)
        st = read_bias(err, root, &c.rest);
    if (!st && c.has_mount)
        st = read_mount(err, root, &c.tracker_from_body);
    if (st)
        return st;
    snprintf(c.key, sizeof c.key, "%s", key);
    *out = c;
    return AP_OK;
}

static enum ap_status read_device_file(struct ap_error *err, const char *path,
                                       struct ap_device_calibration *out) {
    json_t *root = NULL;
    enum ap_status st = ap_json_read(err, path, &root);
    if (st)
        return st;
    struct ap_json_at at = ap_json_root(root, path);
    st = parse_device(err, &at, out);
    json_decref(root);
    return st;
}

static json_t *vec3_json(struct ap_vec3 v) {
    return json_pack("[f,f,f]", v.x, v.y, v.z);
}

static json_t *bias_json(const struct ap_rest_result *r) {
    return json_pack("{s:o,s:o,s:f,s:i,s:f}", "gyro_rad_s", vec3_json(r->bias.gyr_rad_s),
                     "accel_m_s2", vec3_json(r->bias.acc_m_s2), "seconds", r->seconds, "poses",
                     r->poses, "gyro_sigma_rad_s", r->gyr_sigma_rad_s);
}

// --- devices

enum ap_status ap_calibration_read(struct ap_error *err, const char *dir, const char *key,
                                   struct ap_device_calibration *calibration, bool *found) {
    char *path = device_path(dir, key);
    if (!path)
        return no_memory(err);
    bool there = ap_file_exists(path);
    enum ap_status st = there ? read_device_file(err, path, calibration) : AP_OK;
    free(path);
    if (!st)
        *found = there;
    return st;
}

enum ap_status ap_calibration_write(struct ap_error *err, const char *dir,
                                    const struct ap_device_calibration *c) {
    if (!c->key[0] || strlen(c->key) >= sizeof c->key)
        return ap_fail(err, AP_USAGE, "expected the device's serial, 1 to %d bytes",
                       AP_CALIBRATION_KEY_MAX - 1);
    json_t *root = json_pack("{s:i,s:s}", "version", VERSION, "device", c->key);
    struct ap_quat q = c->tracker_from_body;
    if (!root)
        return ap_fail(err, AP_USAGE, "the serial is no UTF-8 text");
    if ((c->has_bias && json_object_set_new(root, "bias", bias_json(&c->rest)) != 0) ||
        (c->has_mount &&
         json_object_set_new(
             root, "mount", json_pack("{s:[f,f,f,f]}", "tracker_from_body", q.x, q.y, q.z, q.w)))) {
        json_decref(root);
        return no_memory(err);
    }
    char *folder = ap_path_join(dir, "devices"), *path = device_path(dir, c->key);
    enum ap_status st = folder && path ? ap_make_dirs(err, folder) : no_memory(err);
    if (st)
        json_decref(root);
    else
        st = write_json(err, path, root);
    free(folder);
    free(path);
    return st;
}

static int by_name(const struct dirent **a, const struct dirent **b) {
    return strcmp((*a)->d_name, (*b)->d_name);
}

static int is_json(const struct dirent *entry) {
    size_t len = strlen(entry->d_name);
    return len > 5 && entry->d_name[0] != '.' && strcmp(entry->d_name + len - 5, ".json") == 0;
}

enum ap_status ap_calibration_list(struct ap_error *err, const char *dir, int max,
                                   struct ap_device_calibration *all, int *count) {
    struct dirent **entries = NULL;
    char *folder = ap_path_join(dir, "devices");
    if (!folder)
        return no_memory(err);
    enum ap_status st = AP_OK;
    int n = scandir(folder, &entries, is_json, by_name);
    if (n < 0 && errno != ENOENT)
        st = ap_fail(err, AP_INPUT, "%s: %s", folder, strerror(errno));
    if (n > max)
        st = ap_fail(err, AP_INPUT, "%s: %d files: at most %d devices", folder, n, max);
    for (int i = 0; i < n && !st; i++) {
        char *path = ap_path_join(folder, entries[i]->d_name);
        st = path ? read_device_file(err, path, &all[i]) : no_memory(err);
        free(path);
    }
    for (int i = 0; i < n; i++)
        free(entries[i]);
    free(entries);
    free(folder);
    if (!st)
        *count = n > 0 ? n : 0;
    return st;
}

enum ap_status ap_calibration_forget(struct ap_error *err, const char *dir, const char *key,
                                     bool *found) {
    char *path = device_path(dir, key);
    if (!path)
        return no_memory(err);
    enum ap_status st = AP_OK;
    bool gone = unlink(path) == 0;
    if (!gone && errno != ENOENT)
        st = ap_fail(err, AP_ENVIRONMENT, "%s: %s", path, strerror(errno));
    free(path);
    if (!st)
        *found = gone;
    return st;
}

// --- the room

static enum ap_status parse_room(struct ap_error *err, const struct ap_json_at *root,
                                 struct ap_room_calibration *out) {
    static const char *const keys[] = {"version", "table", NULL};
    static const char *const table_keys[] = {"x_m",    "z_m",   "yaw_rad", "height_m",
                                             "edge_m", "rms_m", NULL};
    struct ap_room_calibration r = {0};
    enum ap_status st = ap_json_check_keys(err, root, keys);
    if (!st)
        st = check_version(err, root);
    struct ap_json_at table = ap_json_member(root, "table");
    if (!st)
        st = ap_json_check_keys(err, &table, table_keys);
    if (!st)
        st = read_within(err, &table, "x_m", -1000, 1000, &r.table.x_m);
    if (!st)
        st = read_within(err, &table, "z_m", -1000, 1000, &r.table.z_m);
    if (!st)
        st = read_within(err, &table, "yaw_rad", -M_PI, M_PI, &r.table.yaw_rad);
    if (!st)
        st = read_within(err, &table, "height_m", 0.05, 3, &r.table.height_m);
    if (!st)
        st = read_within(err, &table, "edge_m", 0.2, 5, &r.table.edge_m);
    if (!st)
        st = read_within(err, &table, "rms_m", 0, 1, &r.rms_m);
    if (!st)
        *out = r;
    return st;
}

enum ap_status ap_room_file_read(struct ap_error *err, const char *path,
                                 struct ap_room_calibration *room) {
    json_t *root = NULL;
    enum ap_status st = ap_json_read(err, path, &root);
    if (st)
        return st;
    struct ap_json_at at = ap_json_root(root, path);
    st = parse_room(err, &at, room);
    json_decref(root);
    return st;
}

enum ap_status ap_room_file_write(struct ap_error *err, const char *path,
                                  const struct ap_room_calibration *r) {
    const struct ap_table_place *t = &r->table;
    if (!(t->height_m >= 0.05 && t->height_m <= 3))
        return ap_fail(err, AP_INPUT,
                       "the surface is %.3f m above the room's floor: expected 0.05 to 3 m (is the "
                       "room's floor calibrated?)",
                       t->height_m);
    return write_json(err, path,
                      json_pack("{s:i,s:{s:f,s:f,s:f,s:f,s:f,s:f}}", "version", VERSION, "table",
                                "x_m", t->x_m, "z_m", t->z_m, "yaw_rad", t->yaw_rad, "height_m",
                                t->height_m, "edge_m", t->edge_m, "rms_m", r->rms_m));
}
