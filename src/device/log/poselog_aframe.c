#include <math.h>
#include <string.h>

#include "src/device/log/poselog_document.h"

// Motion captures of A-Frame: {"camera" or an id: {"poses": [{"position": {x, y, z}, "rotation":
// {x, y, z} in degrees, "timestamp": ms}…], "events": [{"name", "detail": {"id"},
// "timestamp"}…]}…}, or the same within {"recording": …}. Rotations are about y, then x, then z.
// Time 0 is the first pose of all.

static const double DEGREE = 3.14159265358979323846 / 180;

struct capture {
    struct ap_document *document;
    double first_ms;
};

// What pressing a button means; ids are those of the Vive's controllers.
static const struct press {
    const char *name; // of the event
    int id;           // −1: the name says it
    bool squeeze, down;
} presses[] = {
    {"buttondown", 1, false, true},   {"buttonup", 1, false, false},
    {"buttondown", 2, true, true},    {"buttonup", 2, true, false},
    {"triggerdown", -1, false, true}, {"triggerup", -1, false, false},
    {"gripdown", -1, true, true},     {"gripup", -1, true, false},
};

// Beginnings of ids, of which the first one that fits names the device.
static const struct {
    const char *word, *device;
} names[] = {{"camera", "head"}, {"head", "head"}, {"left", "left"}, {"right", "right"}};

static const char *device_of(const char *id) {
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        if (strncasecmp(id, names[i].word, strlen(names[i].word)) == 0)
            return names[i].device;
    return id;
}

static enum ap_status read_ms(struct ap_error *err, const struct ap_json_at *object, double *ms) {
    enum ap_status st = ap_json_number(err, object, "timestamp", ms);
    struct ap_json_at at = ap_json_member(object, "timestamp");
    return !st && !(fabs(*ms) <= 1e12) ? ap_json_fail(err, &at, "expected a time in milliseconds")
                                       : st;
}

static enum ap_status read_triple(struct ap_error *err, const struct ap_json_at *pose,
                                  const char *key, double limit, double v[3]) {
    static const char *const letters[3] = {"x", "y", "z"};
    struct ap_json_at at = ap_json_member(pose, key);
    if (!json_is_object(at.value))
        return ap_json_fail(err, &at, "expected an object with x, y and z");
    for (int i = 0; i < 3; i++) {
        enum ap_status st = ap_json_number(err, &at, letters[i], &v[i]);
        if (st)
            return st;
        if (!(fabs(v[i]) <= limit))
            return ap_json_fail(err, &at, "expected numbers of at most %g in size", limit);
    }
    return AP_OK;
}

static struct ap_quat from_euler_yxz(const double degrees[3]) {
    struct ap_quat q[3];
    for (int i = 0; i < 3; i++) {
        double half = degrees[i] * DEGREE / 2, s = sin(half);
        q[i] = (struct ap_quat){i == 0 ? s : 0, i == 1 ? s : 0, i == 2 ? s : 0, cos(half)};
    }
    return ap_quat_normalize(ap_quat_mul(ap_quat_mul(q[1], q[0]), q[2]));
}

static enum ap_status read_pose(struct ap_error *err, const struct capture *c,
                                const struct ap_json_at *at, struct ap_table_row *row, double *ms) {
    double p[3], r[3];
    enum ap_status st = read_ms(err, at, ms);
    if (!st)
        st = read_triple(err, at, "position", 1e6, p);
    if (!st)
        st = read_triple(err, at, "rotation", 1e6, r);
    if (st)
        return st;
    row->t_ns = llround((*ms - c->first_ms) * 1e6);
    row->frame = (int64_t)at->index;
    row->pose = (struct ap_pose){{p[0], p[1], p[2]}, from_euler_yxz(r)};
    return AP_OK;
}

static void press(struct ap_table_row *row, const struct ap_json_at *event) {
    const char *name = json_string_value(json_object_get(event->value, "name"));
    const json_t *detail = json_object_get(event->value, "detail");
    const json_t *id = json_object_get(detail, "id");
    for (size_t i = 0; name && i < sizeof presses / sizeof *presses; i++) {
        const struct press *p = &presses[i];
        if (strcmp(name, p->name) != 0 ||
            (p->id >= 0 && !(json_is_integer(id) && json_integer_value(id) == p->id)))
            continue;
        if (p->squeeze)
            row->squeeze = p->down ? 1 : 0;
        else
            row->trigger = p->down ? 1 : 0;
        row->select = row->trigger > 0;
    }
}

// Everything of one device: its poses by time, and what had been pressed at each.
static enum ap_status take_device(struct ap_error *err, const struct capture *c, const char *id,
                                  const struct ap_json_at *device) {
    struct ap_json_at poses = ap_json_member(device, "poses"),
                      events = ap_json_member(device, "events");
    struct ap_table_row row = {0};
    size_t count = json_array_size(poses.value), next = 0;
    double last_ms = -INFINITY;
    enum ap_status st = AP_OK;
    for (size_t i = 0; !st && i < count; i++) {
        struct ap_json_at at = ap_json_element(&poses, i);
        struct ap_error why;
        double ms = 0;
        st = read_pose(&why, c, &at, &row, &ms);
        if (!st && !(ms >= last_ms))
            st = ap_json_fail(&why, &at, "expected a time not before the pose before");
        if (st) {
            st = ap_document_reject(err, c->document, &why);
            continue;
        }
        for (; next < json_array_size(events.value); next++) {
            struct ap_json_at event = ap_json_element(&events, next);
            double event_ms;
            if (read_ms(NULL, &event, &event_ms))
                continue;
            if (event_ms > ms)
                break;
            press(&row, &event);
        }
        if (ms > last_ms) // two poses of one moment: the first one
            st = ap_document_add(err, c->document, device_of(id), row);
        last_ms = ms;
    }
    return st;
}

// The first time of all; false where there is no device in the object.
static bool find_first(const struct ap_json_at *devices, double *first_ms) {
    bool found = false;
    const char *key;
    json_t *value;
    *first_ms = INFINITY;
    json_object_foreach((json_t *)devices->value, key, value) {
        struct ap_json_at device = ap_json_member(devices, key),
                          poses = ap_json_member(&device, "poses");
        found = found || json_is_array(poses.value);
        for (size_t i = 0; i < json_array_size(poses.value); i++) {
            struct ap_json_at pose = ap_json_element(&poses, i);
            double ms;
            if (!read_ms(NULL, &pose, &ms))
                *first_ms = fmin(*first_ms, ms);
        }
    }
    return found;
}

enum ap_status ap_aframe_read(struct ap_error *err, struct ap_document *document,
                              const struct ap_json_at *root) {
    struct ap_json_at inner = ap_json_member(root, "recording");
    const struct ap_json_at *devices = json_is_object(inner.value) ? &inner : root;
    struct capture c = {.document = document};
    if (!json_is_object(devices->value) || !find_first(devices, &c.first_ms))
        return ap_json_fail(err, root,
                            "expected a motion capture ({\"camera\": {\"poses\": […]}, …}) or a "
                            "recording of IWER ({\"schema\": …, \"frames\": …})");
    const char *key;
    json_t *value;
    json_object_foreach((json_t *)devices->value, key, value) {
        struct ap_json_at device = ap_json_member(devices, key);
        enum ap_status st = take_device(err, &c, key, &device);
        if (st)
            return st;
    }
    return AP_OK;
}
