#include "src/device/log/iwer.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "src/device/log/poselog_document.h"
#include "src/device/unit_quat.h"

enum { AFTER_HEAD = 8, AFTER_RAY = 8 };

struct reading {
    const struct ap_iwer_visitor *visitor;
    struct ap_iwer_source sources[AP_IWER_SOURCES_MAX];
    size_t source_count;
    double first_ms;
    int64_t t_ns;
};

static bool is_true(const struct ap_json_at *object, const char *key) {
    return json_is_true(json_object_get(object->value, key));
}

static enum ap_status read_size(struct ap_error *err, const struct ap_json_at *source,
                                const char *key, size_t *size) {
    struct ap_json_at at = ap_json_member(source, key);
    json_int_t n = json_integer_value(at.value);
    if (!json_is_integer(at.value) || n < 0 || n > AP_IWER_BUTTONS_MAX)
        return ap_json_fail(err, &at, "expected a whole number from 0 to %d", AP_IWER_BUTTONS_MAX);
    *size = (size_t)n;
    return AP_OK;
}

// [index, {"handedness": …, "hasGrip": …, "hasHand": …, …}]; what else it says is not ours.
static enum ap_status read_schema(struct ap_error *err, const struct reading *r,
                                  const struct ap_json_at *at, struct ap_iwer_source *out) {
    struct ap_json_at index = ap_json_element(at, 0), source = ap_json_element(at, 1);
    if (json_array_size(at->value) != 2 || !json_is_integer(index.value) ||
        !json_is_object(source.value))
        return ap_json_fail(err, at, "expected [index, {…}]");
    *out = (struct ap_iwer_source){.index = json_integer_value(index.value)};
    size_t next = AFTER_RAY;
    if (is_true(&source, "hasGrip"))
        out->grip = next++;
    if (is_true(&source, "hasHand"))
        out->hand = next++;
    if (is_true(&source, "hasGamepad"))
        out->gamepad = next;
    const char *side = "";
    enum ap_status st = AP_OK;
    if (next > AFTER_RAY || out->gamepad || ap_json_has(&source, "handedness"))
        st = ap_json_string(err, &source, "handedness", &side);
    if (!st && out->gamepad)
        st = read_size(err, &source, "numButtons", &out->buttons);
    if (!st && out->gamepad)
        st = read_size(err, &source, "numAxes", &out->axes);
    if (st)
        return st;
    out->device = strcmp(side, "left") == 0 ? "left" : strcmp(side, "right") == 0 ? "right" : NULL;
    return r->visitor->schema ? r->visitor->schema(err, r->visitor->user, &source, out) : AP_OK;
}

static enum ap_status read_schemas(struct ap_error *err, const struct ap_json_at *root,
                                   struct reading *r) {
    struct ap_json_at list = ap_json_member(root, "schema");
    size_t count = json_array_size(list.value);
    if (count < 1 || count > AP_IWER_SOURCES_MAX)
        return ap_json_fail(err, &list, "expected a list of 1 to %d input sources",
                            AP_IWER_SOURCES_MAX);
    enum ap_status st = AP_OK;
    for (; !st && r->source_count < count; r->source_count++) {
        struct ap_json_at at = ap_json_element(&list, r->source_count);
        st = read_schema(err, r, &at, &r->sources[r->source_count]);
    }
    return st;
}

static enum ap_status take_source(struct ap_error *err, const struct reading *r,
                                  const struct ap_json_at *source) {
    struct ap_json_at index = ap_json_element(source, 0);
    const struct ap_iwer_source *what = NULL;
    for (size_t i = 0; i < r->source_count; i++)
        if (json_is_integer(index.value) && r->sources[i].index == json_integer_value(index.value))
            what = &r->sources[i];
    if (!what)
        return ap_json_fail(err, &index, "expected the index of an input source in /schema");
    return r->visitor->source(err, r->visitor->user, what, source);
}

static enum ap_status take_time(struct ap_error *err, struct reading *r,
                                const struct ap_json_at *frame, size_t i) {
    struct ap_json_at at = ap_json_element(frame, 0);
    double ms = json_number_value(at.value);
    if (!json_is_number(at.value) || !(fabs(ms) <= 1e12))
        return ap_json_fail(err, &at, "expected a time in milliseconds");
    if (i == 0)
        r->first_ms = ms;
    int64_t t_ns = llround((ms - r->first_ms) * 1e6);
    if (t_ns < r->t_ns)
        return ap_json_fail(err, &at, "expected a time not before the frame before");
    r->t_ns = t_ns;
    return AP_OK;
}

static enum ap_status take_frame(struct ap_error *err, struct reading *r,
                                 const struct ap_json_at *frame, size_t i) {
    const struct ap_iwer_visitor *v = r->visitor;
    enum ap_status st = take_time(err, r, frame, i);
    if (!st && v->frame)
        st = v->frame(err, v->user, r->t_ns, frame);
    size_t count = v->source ? json_array_size(frame->value) : 0;
    for (size_t k = AFTER_HEAD; !st && k < count; k++) {
        struct ap_json_at source = ap_json_element(frame, k);
        st = take_source(err, r, &source);
    }
    return st;
}

enum ap_status ap_iwer_visit(struct ap_error *err, const struct ap_json_at *root,
                             const struct ap_iwer_visitor *visitor) {
    struct reading r = {.visitor = visitor};
    enum ap_status st = read_schemas(err, root, &r);
    struct ap_json_at frames = ap_json_member(root, "frames");
    if (!st && !json_is_array(frames.value))
        st = ap_json_fail(err, &frames, "expected a list of frames");
    for (size_t i = 0; !st && i < json_array_size(frames.value); i++) {
        struct ap_json_at frame = ap_json_element(&frames, i);
        struct ap_error why;
        st = take_frame(&why, &r, &frame, i);
        if (st == AP_INPUT && visitor->bad)
            st = visitor->bad(err, visitor->user, &why);
        else if (st)
            st = ap_fail(err, st, "%s", why.text);
    }
    return st;
}

enum ap_status ap_iwer_read(struct ap_error *err, struct ap_line_reader *reader,
                            const struct ap_iwer_visitor *visitor) {
    char *bytes = NULL;
    size_t len;
    json_t *root = NULL;
    enum ap_status st = ap_line_reader_rest(err, reader, AP_LOG_DOCUMENT_MAX, &bytes, &len);
    if (!st)
        st = ap_json_parse(err, reader->name, bytes, len, &root);
    if (!st) {
        struct ap_json_at at = ap_json_root(root, reader->name);
        st = ap_iwer_visit(err, &at, visitor);
    }
    json_decref(root);
    free(bytes);
    return st;
}

enum ap_status ap_iwer_numbers(struct ap_error *err, const struct ap_json_at *array, size_t first,
                               size_t count, double *values) {
    for (size_t i = 0; i < count; i++) {
        struct ap_json_at at = ap_json_element(array, first + i);
        values[i] = json_number_value(at.value);
        if (!json_is_number(at.value) || !(fabs(values[i]) <= 1000))
            return ap_json_fail(err, &at, "expected a number from -1000 to 1000");
    }
    return AP_OK;
}

enum ap_status ap_iwer_pose(struct ap_error *err, const struct ap_json_at *array, size_t first,
                            struct ap_pose *pose) {
    double v[7];
    enum ap_status st = ap_iwer_numbers(err, array, first, 7, v);
    if (st)
        return st;
    *pose = (struct ap_pose){{v[0], v[1], v[2]}, {v[3], v[4], v[5], v[6]}};
    struct ap_json_at at = ap_json_element(array, first + 3);
    return ap_quat_make_unit(&pose->q) ? AP_OK
                                       : ap_json_fail(err, &at, "expected a unit quaternion");
}

enum ap_status ap_iwer_button(struct ap_error *err, const struct ap_json_at *gamepad, size_t i,
                              double values[3], bool *there) {
    struct ap_json_at at = ap_json_element(gamepad, i);
    for (size_t k = 0; k < 3; k++)
        values[k] = 0;
    *there = at.value && !json_is_null(at.value);
    for (size_t k = 0; *there && k < 3; k++) {
        struct ap_json_at number = ap_json_element(&at, k);
        values[k] = json_number_value(number.value);
        if (!json_is_number(number.value) || !(values[k] >= 0 && values[k] <= 1))
            return ap_json_fail(err, &at, "expected [pressed, touched, value], each from 0 to 1");
    }
    return AP_OK;
}
