#include <math.h>
#include <string.h>

#include "src/base/json.h"
#include "src/device/handlog_format.h"
#include "src/device/unit_quat.h"

// The recorder of IWER (WebXR's emulator): {"schema": [[index, {what an input source has}] …],
// "frames": [[t_ms, head 7, source …] …]} with source = [index, ray 7, then what its schema says it
// has: [grip 7], [25 joints of 7 and a radius, against the ray], …]. Poses are [px, py, pz, qx, qy,
// qz, qw], rounded to 1e-3; a hand may come and go. Times are counted from the first frame.

enum { JOINTS = AP_JOINT_COUNT - 1, JOINT_NUMBERS = 8, SCHEMAS_MAX = 64, RAY = 1, AFTER_RAY = 8 };

struct schema {
    json_int_t index;
    int hand;      // −1: no hand
    size_t column; // where a source's joints stand
};

struct reading {
    struct ap_handlog *log;
    struct schema schemas[SCHEMAS_MAX];
    size_t schema_count;
};

// WebXR's joints in WebXR's order: OpenXR's without the palm.
static const char *const webxr_names[JOINTS] = {
    "wrist",
    "thumb-metacarpal",
    "thumb-phalanx-proximal",
    "thumb-phalanx-distal",
    "thumb-tip",
    "index-finger-metacarpal",
    "index-finger-phalanx-proximal",
    "index-finger-phalanx-intermediate",
    "index-finger-phalanx-distal",
    "index-finger-tip",
    "middle-finger-metacarpal",
    "middle-finger-phalanx-proximal",
    "middle-finger-phalanx-intermediate",
    "middle-finger-phalanx-distal",
    "middle-finger-tip",
    "ring-finger-metacarpal",
    "ring-finger-phalanx-proximal",
    "ring-finger-phalanx-intermediate",
    "ring-finger-phalanx-distal",
    "ring-finger-tip",
    "pinky-finger-metacarpal",
    "pinky-finger-phalanx-proximal",
    "pinky-finger-phalanx-intermediate",
    "pinky-finger-phalanx-distal",
    "pinky-finger-tip",
};

static enum ap_status check_joints(struct ap_error *err, const struct ap_json_at *source) {
    struct ap_json_at list = ap_json_member(source, "jointSequence");
    if (json_array_size(list.value) != JOINTS)
        return ap_json_fail(err, &list, "expected WebXR's %d joints", JOINTS);
    for (size_t i = 0; i < JOINTS; i++) {
        struct ap_json_at at = ap_json_element(&list, i);
        const char *name = json_string_value(at.value);
        if (!name || strcmp(name, webxr_names[i]) != 0)
            return ap_json_fail(err, &at, "expected \"%s\"", webxr_names[i]);
    }
    return AP_OK;
}

static bool is_true(const struct ap_json_at *object, const char *key) {
    return json_is_true(json_object_get(object->value, key));
}

// [index, {"handedness": …, "hasGrip": …, "hasHand": …, …}]; what else it says is not ours.
static enum ap_status read_schema(struct ap_error *err, const struct ap_json_at *at,
                                  struct schema *out) {
    struct ap_json_at index = ap_json_element(at, 0), source = ap_json_element(at, 1);
    if (json_array_size(at->value) != 2 || !json_is_integer(index.value) ||
        !json_is_object(source.value))
        return ap_json_fail(err, at, "expected [index, {…}]");
    *out = (struct schema){.index = json_integer_value(index.value), .hand = -1};
    if (!is_true(&source, "hasHand"))
        return AP_OK;
    const char *side;
    enum ap_status st = ap_json_string(err, &source, "handedness", &side);
    if (!st && ap_json_has(&source, "jointSequence"))
        st = check_joints(err, &source);
    if (st)
        return st;
    if (strcmp(side, "left") == 0)
        out->hand = AP_HAND_LEFT;
    else if (strcmp(side, "right") == 0)
        out->hand = AP_HAND_RIGHT;
    out->column = AFTER_RAY + is_true(&source, "hasGrip");
    return AP_OK;
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

// Numbers of an array from a place on. Coordinates of more than a kilometre are no hand's.
static enum ap_status read_numbers(struct ap_error *err, const struct ap_json_at *array,
                                   size_t first, size_t count, double *values) {
    for (size_t i = 0; i < count; i++) {
        struct ap_json_at at = ap_json_element(array, first + i);
        values[i] = json_number_value(at.value);
        if (!json_is_number(at.value) || !(fabs(values[i]) <= 1000))
            return ap_json_fail(err, &at, "expected a number from -1000 to 1000");
    }
    return AP_OK;
}

static enum ap_status read_pose(struct ap_error *err, const struct ap_json_at *array, size_t first,
                                struct ap_pose *pose) {
    double v[7];
    enum ap_status st = read_numbers(err, array, first, 7, v);
    if (st)
        return st;
    *pose = (struct ap_pose){{v[0], v[1], v[2]}, {v[3], v[4], v[5], v[6]}};
    struct ap_json_at at = ap_json_element(array, first + 3);
    return ap_quat_make_unit(&pose->q) ? AP_OK
                                       : ap_json_fail(err, &at, "expected a unit quaternion");
}

static enum ap_status read_hand(struct ap_error *err, const struct ap_json_at *source,
                                size_t column, struct ap_hand *hand) {
    struct ap_json_at list = ap_json_element(source, column);
    if (json_array_size(list.value) != JOINTS * JOINT_NUMBERS)
        return ap_json_fail(err, &list, "expected %d numbers for %d joints", JOINTS * JOINT_NUMBERS,
                            JOINTS);
    struct ap_pose ray;
    enum ap_status st = read_pose(err, source, RAY, &ray);
    for (size_t i = 0; !st && i < JOINTS; i++) {
        struct ap_hand_joint *joint = &hand->joint[AP_JOINT_WRIST + i];
        struct ap_pose ray_from_joint = AP_POSE_IDENTITY;
        st = read_pose(err, &list, i * JOINT_NUMBERS, &ray_from_joint);
        if (!st)
            st = read_numbers(err, &list, i * JOINT_NUMBERS + 7, 1, &joint->radius_m);
        struct ap_json_at at = ap_json_element(&list, i * JOINT_NUMBERS + 7);
        if (!st && !(joint->radius_m >= 0 && joint->radius_m <= 1))
            st = ap_json_fail(err, &at, "expected a radius from 0 to 1 m");
        joint->pose = ap_pose_mul(ray, ray_from_joint);
    }
    if (!st)
        ap_hand_derive_palm(hand);
    return st;
}

static enum ap_status take_source(struct ap_error *err, struct reading *r,
                                  const struct ap_json_at *source, int64_t t_ns) {
    struct ap_json_at index = ap_json_element(source, 0);
    const struct schema *schema = NULL;
    for (size_t i = 0; i < r->schema_count; i++)
        if (json_is_integer(index.value) && r->schemas[i].index == json_integer_value(index.value))
            schema = &r->schemas[i];
    if (!schema)
        return ap_json_fail(err, &index, "expected the index of an input source in /schema");
    if (schema->hand < 0)
        return AP_OK;
    struct ap_hand hand;
    struct ap_error why;
    enum ap_status st = read_hand(err, source, schema->column, &hand);
    if (st)
        return st;
    st = ap_handlog_add(&why, r->log, schema->hand, t_ns, &hand);
    return st == AP_INPUT ? ap_json_fail(err, source, "%s", why.text)
           : st           ? ap_fail(err, st, "%s", why.text)
                          : AP_OK;
}

static enum ap_status read_time(struct ap_error *err, const struct ap_json_at *frame, double *ms) {
    struct ap_json_at at = ap_json_element(frame, 0);
    *ms = json_number_value(at.value);
    if (!json_is_number(at.value) || !(fabs(*ms) <= 1e12))
        return ap_json_fail(err, &at, "expected a time in milliseconds");
    return AP_OK;
}

static enum ap_status take_frame(struct ap_error *err, struct reading *r,
                                 const struct ap_json_at *frame, double first_ms) {
    double ms;
    enum ap_status st = read_time(err, frame, &ms);
    if (st)
        return st;
    size_t count = json_array_size(frame->value);
    for (size_t i = AFTER_RAY; !st && i < count; i++) { // the head's seven after the time
        struct ap_json_at source = ap_json_element(frame, i);
        st = take_source(err, r, &source, llround((ms - first_ms) * 1e6));
    }
    return st;
}

static enum ap_status read_all(struct ap_error *err, const struct ap_json_at *root,
                               struct reading *r) {
    enum ap_status st = read_schemas(err, root, r);
    struct ap_json_at frames = ap_json_member(root, "frames"), first = ap_json_element(&frames, 0);
    if (!st && !json_is_array(frames.value))
        st = ap_json_fail(err, &frames, "expected a list of frames");
    double first_ms = 0;
    size_t count = json_array_size(frames.value);
    if (!st && count)
        st = read_time(err, &first, &first_ms);
    for (size_t i = 0; !st && i < count; i++) {
        struct ap_json_at frame = ap_json_element(&frames, i);
        st = take_frame(err, r, &frame, first_ms);
    }
    return st;
}

enum ap_status ap_handlog_read_iwer(struct ap_error *err, const char *path,
                                    struct ap_handlog *log) {
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
