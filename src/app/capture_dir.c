#include "src/app/capture_dir.h"

#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "src/base/file.h"
#include "src/base/json.h"
#include "src/base/number.h"

enum {
    FORMAT_VERSION = 1,
    TARGETS_MAX = 4096,
    CAPTURED_MAX = 1000000,
    LINE_MAX_BYTES = 4096,
    FIELDS = 27, // frame, t_ns, device, state, 7 of the pose, 16 of the matrix
    FIRST_OF_MATRIX = 11
};

static const char HEADER[] = "frame,t_ns,device,state,px,py,pz,qx,qy,qz,qw,m00,m01,m02,m03,m10,m11,"
                             "m12,m13,m20,m21,m22,m23,m30,m31,m32,m33";

static enum ap_status no_memory(struct ap_error *err) {
    return ap_fail(err, AP_ENVIRONMENT, "out of memory");
}

// --- capture.json, read

static enum ap_status read_text(struct ap_error *err, const struct ap_json_at *object,
                                const char *key, char *text, size_t size) {
    const char *value;
    enum ap_status st = ap_json_string(err, object, key, &value);
    if (st)
        return st;
    if (strlen(value) >= size) {
        struct ap_json_at at = ap_json_member(object, key);
        return ap_json_fail(err, &at, "longer than %zu bytes", size - 1);
    }
    memcpy(text, value, strlen(value) + 1);
    return AP_OK;
}

static enum ap_status read_color(struct ap_error *err, const struct ap_json_at *object,
                                 const char *key, uint8_t color[3]) {
    const char *text;
    enum ap_status st = ap_json_string(err, object, key, &text);
    if (st)
        return st;
    if (strlen(text) != 7 || text[0] != '#' || strspn(text + 1, "0123456789abcdefABCDEF") != 6) {
        struct ap_json_at at = ap_json_member(object, key);
        return ap_json_fail(err, &at, "expected a colour like \"#ff2020\"");
    }
    unsigned long v = strtoul(text + 1, NULL, 16);
    for (int i = 0; i < 3; i++)
        color[i] = (uint8_t)(v >> (16 - 8 * i));
    return AP_OK;
}

static enum ap_status read_positive(struct ap_error *err, const struct ap_json_at *object,
                                    const char *key, double *value) {
    double v;
    enum ap_status st = ap_json_number(err, object, key, &v);
    if (st)
        return st;
    if (!(v > 0)) {
        struct ap_json_at at = ap_json_member(object, key);
        return ap_json_fail(err, &at, "expected a number > 0");
    }
    *value = v;
    return AP_OK;
}

static enum ap_status read_born(struct ap_error *err, const struct ap_json_at *root,
                                struct ap_space *born) {
    static const char *const keys[] = {"space", "radius_m", NULL};
    struct ap_json_at at = ap_json_member(root, "born");
    const char *name;
    double rho_m;
    enum ap_status st = ap_json_check_keys(err, &at, keys);
    if (!st)
        st = ap_json_string(err, &at, "space", &name);
    if (!st)
        st = read_positive(err, &at, "radius_m", &rho_m);
    if (st)
        return st;
    if (ap_space_from_name(NULL, name, rho_m, born))
        return ap_json_fail(err, &at, "expected the name and the radius of a space");
    return AP_OK;
}

static enum ap_status read_space(struct ap_error *err, const struct ap_json_at *root,
                                 struct ap_capture *c) {
    const char *name;
    double rho_m;
    enum ap_status st = ap_json_string(err, root, "space", &name);
    if (!st)
        st = read_positive(err, root, "radius_m", &rho_m);
    if (st)
        return st;
    if (ap_space_from_name(NULL, name, rho_m, &c->space)) {
        struct ap_json_at at = ap_json_member(root, "space");
        return ap_json_fail(err, &at, "expected \"s3\", \"e3\" or \"h3\"");
    }
    st = ap_json_string(err, root, "view", &name);
    if (st)
        return st;
    if (ap_view_mode_from_name(NULL, name, &c->view)) {
        struct ap_json_at at = ap_json_member(root, "view");
        return ap_json_fail(err, &at, "expected \"native\", \"tourist\" or \"native-of\"");
    }
    if (c->view == AP_VIEW_BORN) {
        st = read_born(err, root, &c->born);
        if (st)
            return st;
    }
    return read_text(err, root, "tracker", c->tracker, sizeof c->tracker);
}

static enum ap_status read_target(struct ap_error *err, const struct ap_json_at *at,
                                  struct ap_space space, struct ap_capture_target *target) {
    static const char *const keys[] = {"name", "color", "at", "radius_m", NULL};
    double p[4];
    enum ap_status st = ap_json_check_keys(err, at, keys);
    if (!st)
        st = read_text(err, at, "name", target->name, sizeof target->name);
    if (!st)
        st = read_color(err, at, "color", target->color);
    if (!st)
        st = read_positive(err, at, "radius_m", &target->radius_m);
    if (!st)
        st = ap_json_numbers(err, at, "at", 4, p);
    if (st)
        return st;
    target->at = (struct ap_vec4){p[0], p[1], p[2], p[3]};
    struct ap_error why;
    if (ap_point_check(&why, space, target->at)) {
        struct ap_json_at place = ap_json_member(at, "at");
        return ap_json_fail(err, &place, "%s", why.text);
    }
    return AP_OK;
}

static enum ap_status read_targets(struct ap_error *err, const struct ap_json_at *root,
                                   struct ap_capture *c) {
    struct ap_json_at list = ap_json_member(root, "targets");
    size_t n = json_array_size(list.value);
    if (!json_is_array(list.value) || n > TARGETS_MAX)
        return ap_json_fail(err, &list, "expected an array of at most %d targets", TARGETS_MAX);
    c->targets = calloc(n ? n : 1, sizeof *c->targets);
    if (!c->targets)
        return no_memory(err);
    for (; c->target_count < n; c->target_count++) {
        struct ap_json_at at = ap_json_element(&list, c->target_count);
        enum ap_status st = read_target(err, &at, c->space, &c->targets[c->target_count]);
        if (st)
            return st;
    }
    return AP_OK;
}

static enum ap_status read_frame_list(struct ap_error *err, const struct ap_json_at *root,
                                      struct ap_capture *c) {
    static const char *const keys[] = {"total", "captured", NULL};
    struct ap_json_at at = ap_json_member(root, "frames");
    enum ap_status st = ap_json_check_keys(err, &at, keys);
    if (st)
        return st;
    struct ap_json_at total = ap_json_member(&at, "total");
    if (!json_is_integer(total.value) || json_integer_value(total.value) < 0)
        return ap_json_fail(err, &total, "expected a whole number >= 0");
    c->total_frames = json_integer_value(total.value);
    struct ap_json_at list = ap_json_member(&at, "captured");
    size_t n = json_array_size(list.value);
    if (!json_is_array(list.value) || n > CAPTURED_MAX)
        return ap_json_fail(err, &list, "expected an array of at most %d frames", CAPTURED_MAX);
    c->frames = calloc(n ? n : 1, sizeof *c->frames);
    if (!c->frames)
        return no_memory(err);
    for (; c->frame_count < n; c->frame_count++) {
        struct ap_json_at one = ap_json_element(&list, c->frame_count);
        int64_t least = c->frame_count ? c->frames[c->frame_count - 1].frame + 1 : 0;
        int64_t k = json_integer_value(one.value);
        if (!json_is_integer(one.value) || k < least || k >= c->total_frames)
            return ap_json_fail(err, &one, "expected rising frame numbers below %" PRId64,
                                c->total_frames);
        c->frames[c->frame_count].frame = k;
    }
    return AP_OK;
}

static enum ap_status read_table(struct ap_error *err, const struct ap_json_at *root,
                                 struct ap_capture *c) {
    c->has_table = ap_json_has(root, "table_edge_m") || ap_json_has(root, "table_height_m");
    if (!c->has_table)
        return AP_OK;
    enum ap_status st = read_positive(err, root, "table_edge_m", &c->table_edge_m);
    if (!st)
        st = ap_json_number(err, root, "table_height_m", &c->table_height_m);
    return st;
}

static enum ap_status read_root(struct ap_error *err, const struct ap_json_at *root,
                                struct ap_capture *c) {
    static const char *const keys[] = {
        "antipode_capture", "space",      "radius_m", "view",    "tracker",     "table_edge_m",
        "table_height_m",   "frames",     "log",      "command", "interrupted", "born",
        "headset",          "background", "targets",  NULL};
    struct ap_json_at version = ap_json_member(root, "antipode_capture");
    if (!json_is_integer(version.value) || json_integer_value(version.value) != FORMAT_VERSION)
        return ap_json_fail(err, &version, "expected %d: this is not a capture this program reads",
                            FORMAT_VERSION);
    struct ap_json_at headset = ap_json_member(root, "headset");
    enum ap_status st = ap_json_check_keys(err, root, keys);
    if (!st)
        st = read_space(err, root, c);
    if (!st)
        st = read_table(err, root, c);
    if (!st)
        st = ap_json_bool(err, root, "interrupted", &c->interrupted);
    if (!st)
        st = read_text(err, root, "log", c->log_name, sizeof c->log_name);
    if (!st && ap_json_has(root, "command"))
        st = read_text(err, root, "command", c->command, sizeof c->command);
    if (!st)
        st = read_color(err, root, "background", c->background);
    if (!st)
        st = ap_headset_parse(err, &headset, &c->headset);
    if (!st)
        st = read_frame_list(err, root, c);
    if (!st)
        st = read_targets(err, root, c);
    return st;
}

static enum ap_status read_json(struct ap_error *err, const char *dir, struct ap_capture *c) {
    json_t *root = NULL;
    char *path = ap_path_join(dir, "capture.json");
    if (!path)
        return no_memory(err);
    enum ap_status st;
    if (!ap_file_exists(path)) {
        st = ap_fail(err, AP_INPUT, "%s: no capture here; `antipode replay --out DIR` makes one",
                     dir);
        goto out;
    }
    st = ap_json_read(err, path, &root);
    if (st)
        goto out;
    struct ap_json_at at = ap_json_root(root, path);
    st = read_root(err, &at, c);
out:
    json_decref(root);
    free(path);
    return st;
}

// --- frames.csv, read

struct table_reader {
    const char *path;
    int64_t line;
    size_t next; // the captured frame looked for
    size_t kept; // captured frames found so far, moved to the front
    size_t step_room;
    int64_t frame, t_ns;
    const char *device;
    bool has_matrix;    // not where the tracker gave no pose (a hand before the first head)
    double numbers[23]; // pose and matrix
};

static enum ap_status bad_line(struct ap_error *err, const struct table_reader *r, int field,
                               const char *expected) {
    return ap_fail(err, AP_INPUT, "%s:%" PRId64 ": field %d: expected %s", r->path, r->line,
                   field + 1, expected);
}

static bool is_state(const char *text) {
    return !strcmp(text, "exact") || !strcmp(text, "interpolated") || !strcmp(text, "lost");
}

static enum ap_status split_line(struct ap_error *err, struct table_reader *r, char *line) {
    char *field[FIELDS];
    int n = 0;
    for (char *at = line; at; n++) {
        char *comma = strchr(at, ',');
        if (comma)
            *comma++ = '\0';
        if (n < FIELDS)
            field[n] = at;
        at = comma;
    }
    if (n != FIELDS)
        return ap_fail(err, AP_INPUT, "%s:%" PRId64 ": expected %d fields, found %d", r->path,
                       r->line, FIELDS, n);
    if (!ap_parse_int64(field[0], strlen(field[0]), &r->frame) || r->frame < 0)
        return bad_line(err, r, 0, "a frame number");
    if (!ap_parse_int64(field[1], strlen(field[1]), &r->t_ns))
        return bad_line(err, r, 1, "a time in nanoseconds");
    if (field[2][0] == '\0' || strlen(field[2]) > 63)
        return bad_line(err, r, 2, "a device's name of 1 to 63 bytes");
    r->device = field[2];
    if (!is_state(field[3]))
        return bad_line(err, r, 3, "exact, interpolated or lost");
    r->has_matrix = field[FIRST_OF_MATRIX][0] != '\0';
    for (int i = 4; i < FIELDS; i++) {
        if (i >= FIRST_OF_MATRIX && !r->has_matrix && field[i][0] == '\0')
            continue;
        if (!ap_parse_double(field[i], strlen(field[i]), &r->numbers[i - 4]))
            return bad_line(err, r, i, "a finite number");
    }
    return AP_OK;
}

static int device_index(struct ap_capture *c, const char *name) {
    for (int i = 0; i < c->device_count; i++)
        if (strcmp(c->devices[i], name) == 0)
            return i;
    if (c->device_count == AP_CAPTURE_DEVICES_MAX)
        return -1;
    snprintf(c->devices[c->device_count], sizeof c->devices[0], "%s", name);
    return c->device_count++;
}

static enum ap_status keep_step(struct ap_error *err, struct table_reader *r,
                                struct ap_capture *c) {
    int device = device_index(c, r->device);
    if (device < 0)
        return AP_OK;
    if (c->step_count == r->step_room) {
        size_t room = r->step_room ? 2 * r->step_room : 256;
        struct ap_capture_step *more = realloc(c->steps, room * sizeof *more);
        if (!more)
            return no_memory(err);
        c->steps = more;
        r->step_room = room;
    }
    const double *p = r->numbers, *m = r->numbers + 7;
    double rho = c->space.rho_m;
    c->steps[c->step_count++] =
        (struct ap_capture_step){.device = device,
                                 .table_p_m = {p[0], p[1], p[2]},
                                 .world_p = {m[3] * rho, m[7] * rho, m[11] * rho, m[15] * rho}};
    return AP_OK;
}

// Rows come in the order of frames, so one pass finds the head of each captured frame; a captured
// frame without one is dropped.
static enum ap_status keep_head(struct ap_error *err, struct table_reader *r,
                                struct ap_capture *c) {
    while (r->next < c->frame_count && c->frames[r->next].frame < r->frame)
        r->next++;
    if (strcmp(r->device, "head") != 0 || r->next == c->frame_count ||
        c->frames[r->next].frame != r->frame)
        return AP_OK;
    struct ap_capture_frame f = {.frame = r->frame, .t_ns = r->t_ns};
    const double *n = r->numbers;
    f.table_from_head = (struct ap_pose){{n[0], n[1], n[2]}, {n[3], n[4], n[5], n[6]}};
    memcpy(f.world_from_head.m, n + 7, sizeof f.world_from_head.m);
    // Compared with what the sizes of the entries allow: far away in h3 they grow like e^d.
    double w = fabs(f.world_from_head.m[3][3]);
    double defect = ap_iso_defect(c->space, &f.world_from_head);
    if (!(defect <= 1e-9 * (1 + w * w)))
        return ap_fail(err, AP_INPUT,
                       "%s:%" PRId64 ": the matrix is no isometry of the space (off by %.3g)",
                       r->path, r->line, defect);
    r->next++;
    c->frames[r->kept++] = f;
    return AP_OK;
}

static enum ap_status read_rows(struct ap_error *err, FILE *file, struct table_reader *r,
                                struct ap_capture *c) {
    char line[LINE_MAX_BYTES];
    int64_t last = -1;
    while (fgets(line, sizeof line, file)) {
        r->line++;
        size_t n = strlen(line);
        if (n + 1 == sizeof line)
            return ap_fail(err, AP_INPUT, "%s:%" PRId64 ": the line is too long", r->path, r->line);
        while (n && (line[n - 1] == '\n' || line[n - 1] == '\r'))
            line[--n] = '\0';
        if (r->line == 1) {
            if (strcmp(line, HEADER) != 0)
                return ap_fail(err, AP_INPUT, "%s:1: expected the header \"%.32s…\"", r->path,
                               HEADER);
            continue;
        }
        enum ap_status st = split_line(err, r, line);
        if (!st && r->frame < last)
            st = bad_line(err, r, 0, "frame numbers that do not fall");
        if (!st && r->has_matrix)
            st = keep_step(err, r, c);
        if (!st && r->has_matrix)
            st = keep_head(err, r, c);
        if (st)
            return st;
        last = r->frame;
    }
    if (ferror(file))
        return ap_fail(err, AP_INPUT, "%s: cannot be read: %s", r->path, strerror(errno));
    if (r->line == 0)
        return ap_fail(err, AP_INPUT, "%s: empty; expected the header \"%.32s…\"", r->path, HEADER);
    c->frame_count = r->kept;
    return AP_OK;
}

static enum ap_status read_table_file(struct ap_error *err, const char *dir, struct ap_capture *c) {
    char *path = ap_path_join(dir, "frames.csv");
    if (!path)
        return no_memory(err);
    enum ap_status st;
    FILE *file = fopen(path, "rb");
    if (file) {
        struct table_reader r = {.path = path};
        st = read_rows(err, file, &r, c);
        fclose(file);
    } else {
        st = ap_fail(err, AP_INPUT, "%s: cannot be read: %s", path, strerror(errno));
    }
    free(path);
    return st;
}

enum ap_status ap_capture_read(struct ap_error *err, const char *dir, struct ap_capture *capture) {
    struct ap_capture c = {.dir = strdup(dir)};
    enum ap_status st = c.dir ? AP_OK : no_memory(err);
    if (!st)
        st = read_json(err, dir, &c);
    if (!st)
        st = read_table_file(err, dir, &c);
    if (st) {
        ap_capture_finish(&c);
        return st;
    }
    *capture = c;
    return AP_OK;
}

void ap_capture_finish(struct ap_capture *capture) {
    free(capture->dir);
    free(capture->targets);
    free(capture->frames);
    free(capture->steps);
    *capture = (struct ap_capture){0};
}

// --- capture.json, written

static json_t *color_json(const uint8_t color[3]) {
    return json_sprintf("#%02x%02x%02x", color[0], color[1], color[2]);
}

static json_t *targets_json(const struct ap_capture *c) {
    json_t *list = json_array();
    for (size_t i = 0; list && i < c->target_count; i++) {
        const struct ap_capture_target *t = &c->targets[i];
        json_t *one = json_pack("{s:s, s:o, s:[f,f,f,f], s:f}", "name", t->name, "color",
                                color_json(t->color), "at", t->at.x, t->at.y, t->at.z, t->at.w,
                                "radius_m", t->radius_m);
        if (json_array_append_new(list, one) != 0) {
            json_decref(list);
            return NULL;
        }
    }
    return list;
}

static json_t *frames_json(const struct ap_capture *c) {
    json_t *list = json_array();
    for (size_t i = 0; list && i < c->frame_count; i++)
        if (json_array_append_new(list, json_integer(c->frames[i].frame)) != 0) {
            json_decref(list);
            return NULL;
        }
    return json_pack("{s:I, s:o}", "total", (json_int_t)c->total_frames, "captured", list);
}

// A file's name may be any bytes; JSON takes UTF-8 only.
static json_t *text_json(const char *text) {
    json_t *value = json_string(text);
    char *plain = value ? NULL : strdup(text);
    if (!plain)
        return value;
    for (char *p = plain; *p; p++)
        if (*p & 0x80)
            *p = '?';
    value = json_string(plain);
    free(plain);
    return value;
}

// NULL without memory, and where a target's name is not UTF-8.
static json_t *capture_json(const struct ap_capture *c) {
    json_t *root = json_pack("{s:i, s:s, s:f, s:s, s:s}", "antipode_capture", FORMAT_VERSION,
                             "space", ap_space_name(c->space), "radius_m", c->space.rho_m, "view",
                             ap_view_mode_name(c->view), "tracker", c->tracker);
    bool bad = !root;
    if (c->has_table) {
        bad |= json_object_set_new(root, "table_edge_m", json_real(c->table_edge_m)) != 0;
        bad |= json_object_set_new(root, "table_height_m", json_real(c->table_height_m)) != 0;
    }
    if (c->view == AP_VIEW_BORN)
        bad |= json_object_set_new(root, "born",
                                   json_pack("{s:s, s:f}", "space", ap_space_name(c->born),
                                             "radius_m", c->born.rho_m)) != 0;
    bad |= json_object_set_new(root, "frames", frames_json(c)) != 0;
    bad |= json_object_set_new(root, "interrupted", json_boolean(c->interrupted)) != 0;
    bad |= json_object_set_new(root, "log", text_json(c->log_name)) != 0;
    if (c->command[0])
        bad |= json_object_set_new(root, "command", text_json(c->command)) != 0;
    bad |= json_object_set_new(root, "headset", ap_headset_to_json(&c->headset)) != 0;
    bad |= json_object_set_new(root, "background", color_json(c->background)) != 0;
    bad |= json_object_set_new(root, "targets", targets_json(c)) != 0;
    if (bad) {
        json_decref(root);
        return NULL;
    }
    return root;
}

enum ap_status ap_capture_write(struct ap_error *err, const char *dir,
                                const struct ap_capture *capture) {
    char *path = ap_path_join(dir, "capture.json");
    json_t *root = capture_json(capture);
    char *text = root ? json_dumps(root, JSON_INDENT(1) | JSON_REAL_PRECISION(17)) : NULL;
    enum ap_status st = AP_OK;
    if (!path || !text) {
        st = ap_fail(
            err, AP_ENVIRONMENT,
            "%s: capture.json cannot be made: out of memory, or a target's name is not UTF-8", dir);
        goto out;
    }
    struct ap_outfile file;
    st = ap_outfile_open(err, path, &file);
    if (st)
        goto out;
    fprintf(file.stream, "%s\n", text);
    st = ap_outfile_commit(err, &file);
out:
    free(text);
    free(path);
    json_decref(root);
    return st;
}

// --- what follows from it

static struct ap_view_eye rounded_eye(const struct ap_headset_profile *headset, int e) {
    struct ap_pose p = ap_headset_view_from_eye(headset, e);
    const struct ap_eye_profile *eye = &headset->eye[e];
    return (struct ap_view_eye){
        .view_from_eye = {{(float)p.p.x, (float)p.p.y, (float)p.p.z},
                          {(float)p.q.x, (float)p.q.y, (float)p.q.z, (float)p.q.w}},
        .frustum = {tan((float)eye->left_rad), tan((float)eye->right_rad), tan((float)eye->up_rad),
                    tan((float)eye->down_rad)}};
}

struct ap_viewer ap_capture_viewer(const struct ap_capture *capture, size_t frame) {
    return (struct ap_viewer){
        .space = capture->space,
        .mode = capture->view,
        .born = capture->born,
        .world_from_nose = capture->frames[frame].world_from_head,
        .eye = {rounded_eye(&capture->headset, 0), rounded_eye(&capture->headset, 1)}};
}

double ap_capture_eye_shift(const struct ap_capture *capture, double distance_m) {
    double at[2];
    for (int e = 0; e < 2; e++) {
        struct ap_view_eye eye = rounded_eye(&capture->headset, e);
        struct ap_vec3 p = eye.view_from_eye.p;
        struct ap_vec3 d = {-p.x / distance_m, -p.y / distance_m, -1 - p.z / distance_m};
        d = ap_quat_rotate(ap_quat_conj(eye.view_from_eye.q), d);
        at[e] = (d.x / -d.z - eye.frustum.left) / (eye.frustum.right - eye.frustum.left);
        if (!(d.z < 0 && at[e] > 0 && at[e] < 1))
            return 0;
    }
    return at[0] - at[1];
}

char *ap_capture_picture_path(const struct ap_capture *capture, int64_t frame, const char *suffix) {
    char name[64];
    snprintf(name, sizeof name, "%06" PRId64 "-%s", frame, suffix);
    return ap_path_join(capture->dir, name);
}
