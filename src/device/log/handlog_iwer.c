#include <string.h>

#include "src/device/log/handlog_format.h"
#include "src/device/log/iwer.h"

// The hands in a recording of IWER (iwer.h): joints are against the source's ray. A hand may come
// and go.

enum { JOINTS = AP_JOINT_COUNT - 1, JOINT_NUMBERS = 8 };

struct reading {
    struct ap_handlog *log;
    int64_t t_ns;
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

static enum ap_status check_schema(struct ap_error *err, void *user,
                                   const struct ap_json_at *source,
                                   const struct ap_iwer_source *what) {
    (void)user;
    return what->hand && ap_json_has(source, "jointSequence") ? check_joints(err, source) : AP_OK;
}

static enum ap_status read_hand(struct ap_error *err, const struct ap_json_at *source,
                                size_t column, struct ap_hand *hand) {
    struct ap_json_at list = ap_json_element(source, column);
    if (json_array_size(list.value) != JOINTS * JOINT_NUMBERS)
        return ap_json_fail(err, &list, "expected %d numbers for %d joints", JOINTS * JOINT_NUMBERS,
                            JOINTS);
    struct ap_pose ray;
    enum ap_status st = ap_iwer_pose(err, source, AP_IWER_RAY, &ray);
    for (size_t i = 0; !st && i < JOINTS; i++) {
        struct ap_hand_joint *joint = &hand->joint[AP_JOINT_WRIST + i];
        struct ap_pose ray_from_joint = AP_POSE_IDENTITY;
        st = ap_iwer_pose(err, &list, i * JOINT_NUMBERS, &ray_from_joint);
        if (!st)
            st = ap_iwer_numbers(err, &list, i * JOINT_NUMBERS + 7, 1, &joint->radius_m);
        struct ap_json_at at = ap_json_element(&list, i * JOINT_NUMBERS + 7);
        if (!st && !(joint->radius_m >= 0 && joint->radius_m <= 1))
            st = ap_json_fail(err, &at, "expected a radius from 0 to 1 m");
        joint->pose = ap_pose_mul(ray, ray_from_joint);
    }
    if (!st)
        ap_hand_derive_palm(hand);
    return st;
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
    if (!what->hand || !what->device)
        return AP_OK;
    struct ap_hand hand;
    struct ap_error why;
    enum ap_status st = read_hand(err, source, what->hand, &hand);
    if (st)
        return st;
    int side = strcmp(what->device, "left") == 0 ? AP_HAND_LEFT : AP_HAND_RIGHT;
    st = ap_handlog_add(&why, r->log, side, r->t_ns, &hand);
    return st == AP_INPUT ? ap_json_fail(err, source, "%s", why.text)
           : st           ? ap_fail(err, st, "%s", why.text)
                          : AP_OK;
}

enum ap_status ap_handlog_read_iwer(struct ap_error *err, struct ap_line_reader *reader,
                                    struct ap_handlog *log) {
    struct reading r = {.log = log};
    const struct ap_iwer_visitor visitor = {
        .user = &r, .schema = check_schema, .frame = take_frame, .source = take_source};
    return ap_iwer_read(err, reader, &visitor);
}
