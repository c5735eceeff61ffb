#ifndef ANTIPODE_DEVICE_HANDLOG_H
#define ANTIPODE_DEVICE_HANDLOG_H

#include <stdint.h>

#include "src/base/status.h"
#include "src/device/timeline.h"
#include "src/geom/pose.h"

// Recorded bare hands: docs/extensions.md has the two formats (our own CSV, and the JSON of IWER's
// recorder), told by content. Poses are in the room, STAGE axes. Joints as OpenXR numbers and
// orients them (XrHandJointEXT): -z toward the finger's tip, +y out of the back of the hand.
// Immutable after loading; any number of threads may read.

enum { AP_HAND_LEFT, AP_HAND_RIGHT, AP_HAND_COUNT };
enum {
    AP_JOINT_PALM,
    AP_JOINT_WRIST,
    AP_JOINT_THUMB,       // metacarpal, proximal, distal, tip
    AP_JOINT_INDEX = 6,   // metacarpal, proximal, intermediate, distal, tip
    AP_JOINT_MIDDLE = 11, // so do the others
    AP_JOINT_RING = 16,
    AP_JOINT_LITTLE = 21,
    AP_JOINT_COUNT = 26,
};
enum { AP_HAND_FRAMES_MAX = 200000 }; // of a hand

struct ap_hand_joint {
    struct ap_pose pose;
    double radius_m;
};

struct ap_hand {
    struct ap_hand_joint joint[AP_JOINT_COUNT];
};

struct ap_handlog;

// Reads the file to its end. AP_INPUT: where and what was expected; a file without a hand.
enum ap_status ap_handlog_read(struct ap_error *err, const char *path, struct ap_handlog **log);
void ap_handlog_destroy(struct ap_handlog *log);

int64_t ap_handlog_count(const struct ap_handlog *log, int hand); // frames

// As ap_timeline_at: exact, interpolated between frames at most 100 ms apart, else lost (the newest
// one before t is held). Before the first one AP_POSE_NONE: *out untouched.
enum ap_pose_state ap_handlog_at(const struct ap_handlog *log, int hand, int64_t t_ns,
                                 struct ap_hand *out);

// The palm is the middle of the middle finger's metacarpal, turned like it.
void ap_hand_derive_palm(struct ap_hand *hand);

// "palm", "wrist", "thumb_metacarpal" … "little_tip".
const char *ap_joint_name(int joint);

#endif
