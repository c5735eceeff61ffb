#include "src/device/handlog.h"

#include <stdlib.h>
#include <string.h>

#include "src/device/log/handlog_format.h"
#include "src/device/log/poselog_document.h"

// As in timeline.c: farther apart than this, the hand was lost.
static const int64_t LOST_AFTER_NS = 100000000;

struct frame {
    int64_t t_ns;
    struct ap_hand hand;
};

struct ap_handlog {
    struct {
        struct frame *frames;
        int64_t count, room;
    } hand[AP_HAND_COUNT];
};

const char *ap_joint_name(int joint) {
    static const char *const names[AP_JOINT_COUNT] = {"palm",
                                                      "wrist",
                                                      "thumb_metacarpal",
                                                      "thumb_proximal",
                                                      "thumb_distal",
                                                      "thumb_tip",
                                                      "index_metacarpal",
                                                      "index_proximal",
                                                      "index_intermediate",
                                                      "index_distal",
                                                      "index_tip",
                                                      "middle_metacarpal",
                                                      "middle_proximal",
                                                      "middle_intermediate",
                                                      "middle_distal",
                                                      "middle_tip",
                                                      "ring_metacarpal",
                                                      "ring_proximal",
                                                      "ring_intermediate",
                                                      "ring_distal",
                                                      "ring_tip",
                                                      "little_metacarpal",
                                                      "little_proximal",
                                                      "little_intermediate",
                                                      "little_distal",
                                                      "little_tip"};
    return joint >= 0 && joint < AP_JOINT_COUNT ? names[joint] : NULL;
}

void ap_hand_derive_palm(struct ap_hand *hand) {
    const struct ap_hand_joint *from = &hand->joint[AP_JOINT_MIDDLE], *to = from + 1;
    hand->joint[AP_JOINT_PALM] = *from;
    hand->joint[AP_JOINT_PALM].pose.p = ap_vec3_scale(0.5, ap_vec3_add(from->pose.p, to->pose.p));
}

enum ap_status ap_handlog_add(struct ap_error *err, struct ap_handlog *log, int hand, int64_t t_ns,
                              const struct ap_hand *frame) {
    int64_t n = log->hand[hand].count;
    const char *name = hand == AP_HAND_LEFT ? "left" : "right";
    if (n && t_ns <= log->hand[hand].frames[n - 1].t_ns)
        return ap_fail(err, AP_INPUT, "expected a time after the %s hand's last one", name);
    if (n == AP_HAND_FRAMES_MAX)
        return ap_fail(err, AP_INPUT, "more than %d frames of the %s hand", AP_HAND_FRAMES_MAX,
                       name);
    if (n == log->hand[hand].room) {
        int64_t room = n ? 2 * n : 64;
        struct frame *more = reallocarray(log->hand[hand].frames, (size_t)room, sizeof *more);
        if (!more)
            return ap_fail(err, AP_ENVIRONMENT, "out of memory for the hands");
        log->hand[hand].frames = more;
        log->hand[hand].room = room;
    }
    log->hand[hand].frames[n] = (struct frame){t_ns, *frame};
    log->hand[hand].count++;
    return AP_OK;
}

static enum ap_status read_file(struct ap_error *err, const char *path, struct ap_handlog *log) {
    struct ap_line_reader reader;
    const char *bytes;
    size_t len;
    enum ap_status st = ap_line_reader_open(err, &reader, path);
    if (!st)
        st = ap_line_reader_peek(err, &reader, &bytes, &len);
    if (!st)
        st = ap_log_is_document(bytes, len) ? ap_handlog_read_iwer(err, &reader, log)
                                            : ap_handlog_read_csv(err, &reader, log);
    ap_line_reader_close(&reader);
    return st;
}

enum ap_status ap_handlog_read(struct ap_error *err, const char *path, struct ap_handlog **log) {
    struct ap_handlog *l = calloc(1, sizeof *l);
    if (!l)
        return ap_fail(err, AP_ENVIRONMENT, "out of memory for the hands");
    enum ap_status st = read_file(err, path, l);
    if (!st && !l->hand[AP_HAND_LEFT].count && !l->hand[AP_HAND_RIGHT].count)
        st = ap_fail(err, AP_INPUT, "%s: holds no hand", path);
    if (st)
        ap_handlog_destroy(l);
    else
        *log = l;
    return st;
}

void ap_handlog_destroy(struct ap_handlog *log) {
    if (!log)
        return;
    for (int h = 0; h < AP_HAND_COUNT; h++)
        free(log->hand[h].frames);
    free(log);
}

int64_t ap_handlog_count(const struct ap_handlog *log, int hand) {
    return hand >= 0 && hand < AP_HAND_COUNT ? log->hand[hand].count : 0;
}

// The number of frames with time <= t_ns.
static int64_t count_until(const struct ap_handlog *log, int hand, int64_t t_ns) {
    int64_t low = 0, high = log->hand[hand].count;
    while (low < high) {
        int64_t middle = low + (high - low) / 2;
        if (log->hand[hand].frames[middle].t_ns <= t_ns)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

enum ap_pose_state ap_handlog_at(const struct ap_handlog *log, int hand, int64_t t_ns,
                                 struct ap_hand *out) {
    if (hand < 0 || hand >= AP_HAND_COUNT)
        return AP_POSE_NONE;
    int64_t n = count_until(log, hand, t_ns);
    if (n == 0)
        return AP_POSE_NONE;
    const struct frame *before = &log->hand[hand].frames[n - 1], *after = before + 1;
    *out = before->hand;
    if (before->t_ns == t_ns)
        return AP_POSE_EXACT;
    if (n == log->hand[hand].count || after->t_ns - before->t_ns > LOST_AFTER_NS)
        return AP_POSE_LOST;
    double part = (double)(t_ns - before->t_ns) / (double)(after->t_ns - before->t_ns);
    for (int j = 0; j < AP_JOINT_COUNT; j++) {
        const struct ap_hand_joint *a = &before->hand.joint[j], *b = &after->hand.joint[j];
        out->joint[j].pose = ap_pose_interpolate(a->pose, b->pose, part);
        out->joint[j].radius_m = a->radius_m + part * (b->radius_m - a->radius_m);
    }
    return AP_POSE_INTERPOLATED;
}
