#include <math.h>
#include <string.h>

#include "src/base/json.h"
#include "src/device/inputlog_build.h"

// The buttons in a recording of IWER (WebXR's emulator; handlog_iwer.c reads its hands): "schema"
// says of each input source whether it has a gamepad, which then is the last of what a frame has of
// it: [[pressed, touched, value] or null for each button, axes…]. Of WebXR's "xr-standard" mapping;
// its sticks are positive downwards. Time 0 is the first frame.

enum { SCHEMAS_MAX = 64, BUTTONS_MAX = 64, AFTER_HEAD = 8 };

struct schema {
    json_int_t index;
    const char *device; // NULL: no gamepad, or nobody's
    size_t buttons, axes;
};

struct reading {
    struct ap_inputlog *log;
    struct schema schemas[SCHEMAS_MAX];
    size_t schema_count;
    int64_t t_ns;
};

// What a button is called on the left and on the right; NULL: there is no such component.
static const struct button {
    const char *value[2], *click[2], *touch[2];
} buttons[] = {
    {{"/input/trigger/value", "/input/trigger/value"},
     {NULL, NULL},
     {"/input/trigger/touch", "/input/trigger/touch"}},
    {{"/input/squeeze/value", "/input/squeeze/value"}, {NULL, NULL}, {NULL, NULL}},
    {{NULL, NULL},
     {"/input/trackpad/click", "/input/trackpad/click"},
     {"/input/trackpad/touch", "/input/trackpad/touch"}},
    {{NULL, NULL},
     {"/input/thumbstick/click", "/input/thumbstick/click"},
     {"/input/thumbstick/touch", "/input/thumbstick/touch"}},
    {{NULL, NULL}, {"/input/x/click", "/input/a/click"}, {"/input/x/touch", "/input/a/touch"}},
    {{NULL, NULL}, {"/input/y/click", "/input/b/click"}, {"/input/y/touch", "/input/b/touch"}},
    {{NULL, NULL}, {NULL, NULL}, {"/input/thumbrest/touch", "/input/thumbrest/touch"}},
};

enum { BUTTON_COUNT = sizeof buttons / sizeof *buttons };

static enum ap_status read_size(struct ap_error *err, const struct ap_json_at *source,
                                const char *key, size_t *size) {
    struct ap_json_at at = ap_json_member(source, key);
    json_int_t n = json_integer_value(at.value);
    if (!json_is_integer(at.value) || n < 0 || n > BUTTONS_MAX)
        return ap_json_fail(err, &at, "expected a whole number from 0 to %d", BUTTONS_MAX);
    *size = (size_t)n;
    return AP_OK;
}

static enum ap_status read_schema(struct ap_error *err, const struct ap_json_at *at,
                                  struct schema *out) {
    struct ap_json_at index = ap_json_element(at, 0), source = ap_json_element(at, 1);
    if (json_array_size(at->value) != 2 || !json_is_integer(index.value) ||
        !json_is_object(source.value))
        return ap_json_fail(err, at, "expected [index, {…}]");
    *out = (struct schema){.index = json_integer_value(index.value)};
    if (!json_is_true(json_object_get(source.value, "hasGamepad")))
        return AP_OK;
    const char *side;
    enum ap_status st = ap_json_string(err, &source, "handedness", &side);
    if (!st)
        st = read_size(err, &source, "numButtons", &out->buttons);
    if (!st)
        st = read_size(err, &source, "numAxes", &out->axes);
    if (!st)
        out->device = strcmp(side, "left") == 0    ? "left"
                      : strcmp(side, "right") == 0 ? "right"
                                                   : NULL;
    return st;
}

static enum ap_status read_schemas(struct ap_error *err, const struct ap_json_at *root,
                                   struct reading *r) {
    struct ap_json_at list = ap_json_member(root, "schema");
    size_t count = json_array_size(list.value);
    if (count < 1 || count > SCHEMAS_MAX)
        return ap_json_fail(err, &list, "expected a list of 1 to %d input sources", SCHEMAS_MAX);
    enum ap_status st = AP_OK;
    for (; !st && r->schema_count < count; r->schema_count++) {
        struct ap_json_at at = ap_json_element(&list, r->schema_count);
        st = read_schema(err, &at, &r->schemas[r->schema_count]);
    }
    return st;
}

static enum ap_status add(struct ap_error *err, struct reading *r, const struct ap_json_at *at,
                          const char *device, const char *path, int values, double x, double y) {
    // What never leaves its rest is most often not there: "xr-standard" pads with empty buttons.
    if (!path || (x == 0 && y == 0 && ap_inputlog_find(r->log, device, path) < 0))
        return AP_OK;
    struct ap_error why;
    struct ap_input_row row = {.t_ns = r->t_ns,
                               .device = device,
                               .path = {path, strlen(path)},
                               .value = {(float)x, (float)y},
                               .values = values};
    enum ap_status st = ap_inputlog_add(&why, r->log, &row);
    return st == AP_INPUT ? ap_json_fail(err, at, "%s", why.text)
           : st           ? ap_fail(err, st, "%s", why.text)
                          : AP_OK;
}

static enum ap_status take_button(struct ap_error *err, struct reading *r, const char *device,
                                  size_t i, const struct ap_json_at *at) {
    if (json_is_null(at->value))
        return AP_OK;
    double v[3];
    for (size_t k = 0; k < 3; k++) {
        struct ap_json_at number = ap_json_element(at, k);
        v[k] = json_number_value(number.value);
        if (!json_is_number(number.value) || !(v[k] >= 0 && v[k] <= 1))
            return ap_json_fail(err, at, "expected [pressed, touched, value], each from 0 to 1");
    }
    if (i >= BUTTON_COUNT)
        return AP_OK;
    int side = strcmp(device, "right") == 0;
    enum ap_status st = add(err, r, at, device, buttons[i].click[side], 1, v[0] != 0, 0);
    if (!st)
        st = add(err, r, at, device, buttons[i].touch[side], 1, v[1] != 0, 0);
    return st ? st : add(err, r, at, device, buttons[i].value[side], 1, v[2], 0);
}

static enum ap_status take_axes(struct ap_error *err, struct reading *r, const struct schema *s,
                                const struct ap_json_at *pad) {
    static const char *const paths[] = {"/input/trackpad", "/input/thumbstick"};
    for (size_t i = 0; i + 1 < s->axes && i < 4; i += 2) {
        struct ap_json_at x = ap_json_element(pad, s->buttons + i),
                          y = ap_json_element(pad, s->buttons + i + 1);
        double vx = json_number_value(x.value), vy = json_number_value(y.value);
        if (!json_is_number(x.value) || !json_is_number(y.value) ||
            !(fabs(vx) <= 1 && fabs(vy) <= 1))
            return ap_json_fail(err, &x, "expected two numbers from -1 to 1");
        enum ap_status st = add(err, r, &x, s->device, paths[i / 2], 2, vx, vy != 0 ? -vy : 0);
        if (st)
            return st;
    }
    return AP_OK;
}

static enum ap_status take_source(struct ap_error *err, struct reading *r,
                                  const struct ap_json_at *source) {
    struct ap_json_at index = ap_json_element(source, 0);
    const struct schema *s = NULL;
    for (size_t i = 0; i < r->schema_count; i++)
        if (json_is_integer(index.value) && r->schemas[i].index == json_integer_value(index.value))
            s = &r->schemas[i];
    if (!s)
        return ap_json_fail(err, &index, "expected the index of an input source in /schema");
    if (!s->device)
        return AP_OK;
    struct ap_json_at pad = ap_json_element(source, json_array_size(source->value) - 1);
    size_t count = json_array_size(pad.value);
    if (count != s->buttons + s->axes)
        return ap_json_fail(err, &pad, "expected %zu buttons and %zu axes", s->buttons, s->axes);
    enum ap_status st = AP_OK;
    for (size_t i = 0; !st && i < s->buttons; i++) {
        struct ap_json_at at = ap_json_element(&pad, i);
        st = take_button(err, r, s->device, i, &at);
    }
    return st ? st : take_axes(err, r, s, &pad);
}

// A frame that is not the first must not be before the one before it.
static enum ap_status take_time(struct ap_error *err, struct reading *r,
                                const struct ap_json_at *frame, size_t i, double *first_ms) {
    struct ap_json_at at = ap_json_element(frame, 0);
    double ms = json_number_value(at.value);
    if (!json_is_number(at.value) || !(fabs(ms) <= 1e12))
        return ap_json_fail(err, &at, "expected a time in milliseconds");
    if (i == 0)
        *first_ms = ms;
    int64_t t_ns = llround((ms - *first_ms) * 1e6);
    if (t_ns < r->t_ns)
        return ap_json_fail(err, &at, "expected a time not before the frame before");
    r->t_ns = t_ns;
    return AP_OK;
}

static enum ap_status read_all(struct ap_error *err, const struct ap_json_at *root,
                               struct reading *r) {
    enum ap_status st = read_schemas(err, root, r);
    struct ap_json_at frames = ap_json_member(root, "frames");
    if (!st && !json_is_array(frames.value))
        st = ap_json_fail(err, &frames, "expected a list of frames");
    double first_ms = 0;
    for (size_t i = 0; !st && i < json_array_size(frames.value); i++) {
        struct ap_json_at frame = ap_json_element(&frames, i);
        st = take_time(err, r, &frame, i, &first_ms);
        for (size_t k = AFTER_HEAD; !st && k < json_array_size(frame.value); k++) {
            struct ap_json_at source = ap_json_element(&frame, k);
            st = take_source(err, r, &source);
        }
    }
    return st;
}

enum ap_status ap_inputlog_read_iwer(struct ap_error *err, const char *path,
                                     struct ap_inputlog *log) {
    json_t *root;
    enum ap_status st = ap_json_read(err, path, &root);
    if (st)
        return st;
    struct ap_json_at at = ap_json_root(root, path);
    struct reading r = {.log = log};
    st = read_all(err, &at, &r);
    json_decref(root);
    return st;
}
