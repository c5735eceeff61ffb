#include <math.h>
#include <string.h>

#include "src/device/log/inputlog_build.h"
#include "src/device/log/iwer.h"

// The buttons in a recording of IWER (iwer.h): [[pressed, touched, value] or null for each button,
// axes…], of WebXR's "xr-standard" mapping; its sticks are positive downwards.

struct reading {
    struct ap_inputlog *log;
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
                                  size_t i, const struct ap_json_at *pad) {
    double v[3];
    bool there;
    enum ap_status st = ap_iwer_button(err, pad, i, v, &there);
    if (st || !there || i >= BUTTON_COUNT)
        return st;
    struct ap_json_at at = ap_json_element(pad, i);
    int side = strcmp(device, "right") == 0;
    st = add(err, r, &at, device, buttons[i].click[side], 1, v[0] != 0, 0);
    if (!st)
        st = add(err, r, &at, device, buttons[i].touch[side], 1, v[1] != 0, 0);
    return st ? st : add(err, r, &at, device, buttons[i].value[side], 1, v[2], 0);
}

static enum ap_status take_axes(struct ap_error *err, struct reading *r,
                                const struct ap_iwer_source *s, const struct ap_json_at *pad) {
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

static enum ap_status take_frame(struct ap_error *err, void *user, int64_t t_ns,
                                 const struct ap_json_at *frame) {
    (void)err, (void)frame;
    struct reading *r = user;
    r->t_ns = t_ns;
    return AP_OK;
}

static enum ap_status take_source(struct ap_error *err, void *user,
                                  const struct ap_iwer_source *what,
                                  const struct ap_json_at *source) {
    struct reading *r = user;
    if (!what->gamepad || !what->device)
        return AP_OK;
    struct ap_json_at pad = ap_json_element(source, what->gamepad);
    size_t count = json_array_size(pad.value);
    if (count != what->buttons + what->axes)
        return ap_json_fail(err, &pad, "expected %zu buttons and %zu axes", what->buttons,
                            what->axes);
    enum ap_status st = AP_OK;
    for (size_t i = 0; !st && i < what->buttons; i++)
        st = take_button(err, r, what->device, i, &pad);
    return st ? st : take_axes(err, r, what, &pad);
}

enum ap_status ap_inputlog_read_iwer(struct ap_error *err, struct ap_line_reader *reader,
                                     struct ap_inputlog *log) {
    struct reading r = {.log = log};
    const struct ap_iwer_visitor visitor = {.user = &r, .frame = take_frame, .source = take_source};
    return ap_iwer_read(err, reader, &visitor);
}
