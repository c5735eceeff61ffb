#ifndef ANTIPODE_DEVICE_CALIBRATION_MOUNT_H
#define ANTIPODE_DEVICE_CALIBRATION_MOUNT_H

#include <stdbool.h>
#include <stdint.h>

#include "src/base/status.h"
#include "src/geom/pose.h"

// How a tracker sits on a head or in a hand, from its orientations alone: its wearer looks (points)
// level ahead for a second, then nods: down first, then up. At rest the vertical gives one axis of
// the body, the nod another; the tracker's heading does not matter. No clock, no allocation.

struct ap_mount {
    bool started;
    int64_t start_ns;
    int64_t still_count, count;
    struct ap_quat first, level;
    struct ap_vec3 up_sum;    // in the tracker's axes
    struct ap_vec3 down;      // the way of the first 10°; zero: not yet
    struct ap_vec3 moment[3]; // of the rotation vectors from `level`
    double farthest_rad, unrest_rad;
};

struct ap_mount_result {
    struct ap_quat tracker_from_body;
    double nod_rad;     // how far it went
    double straight;    // 0: a nod about one axis; 1: about anything
    double upright_rad; // how far the nod's axis was from level
};

// All zero is a fresh one. Orientations tracker to room, +y up, in the order of time.
void ap_mount_add(struct ap_mount *mount, int64_t t_ns, struct ap_quat room_from_tracker);

// Whether the second of looking ahead is over.
bool ap_mount_is_level(const struct ap_mount *mount);

// AP_INPUT: it moved in the first second (2°), the nod was below 15°, or no nod (about more than
// one axis, or the axis over 20° off level). The error of the result is that of the wearer: what
// the head was off level, and the nod off straight.
enum ap_status ap_mount_result(struct ap_error *err, const struct ap_mount *mount,
                               struct ap_mount_result *result);

#endif
