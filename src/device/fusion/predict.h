#ifndef ANTIPODE_DEVICE_FUSION_PREDICT_H
#define ANTIPODE_DEVICE_FUSION_PREDICT_H

#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>

#include "src/device/timeline.h"
#include "src/geom/pose.h"

// The newest poses of one live device, asked for poses at any time. One thread writes, any number
// read at the same time; nobody waits for anybody: a ring of slots, each with a sequence number
// that is odd while it is written. No allocation, no clock.

enum { AP_HISTORY_SLOTS = 1024, AP_HISTORY_WORDS = 13 };

// 0 means the value behind; docs/fusion.md has the measurements it comes from.
struct ap_history_params {
    double tau_s;           // 0.1: predicted velocities fade by e in so long; INFINITY: never
    int64_t ahead_max_ns;   // 40 ms: no farther; later poses stay where that one is
    int64_t lost_after_ns;  // 100 ms: so long after the newest sample (or between two) it is lost
    int64_t still_after_ns; // 60 ms: over a gap of more there is no velocity
    int64_t baseline_ns;    // 15 ms: the least time over which velocities are measured
    double jump_m_s;        // 30: faster is a jump, over which there is no velocity
};

struct ap_history_slot {
    atomic_uint_fast64_t sequence;
    atomic_uint_fast64_t words[AP_HISTORY_WORDS];
};

struct ap_history {
    struct ap_history_params params; // defaults filled in; constant after init
    atomic_uint_fast64_t written;
    int64_t last_t_ns; // the writer's own, like the next ones
    struct ap_pose last_pose;
    bool apart; // the next sample has nothing to do with the last one
    int64_t rejected;
    struct ap_history_slot slots[AP_HISTORY_SLOTS];
};

struct ap_history_answer {
    enum ap_pose_state state;
    struct ap_pose pose;
    struct ap_vec3 linear_m_s, angular_rad_s; // in the room; 0 where there is none
    int64_t age_ns; // asked time − the newest sample's; negative where that is newer
};

// False where a parameter is out of range. Before other threads know of it.
bool ap_history_init(struct ap_history *history, const struct ap_history_params *params);

// Writer: a sample. rate_rad_s is the gyroscope's, in the device's own axes, NULL where there is
// none. False, and only `rejected` changes, where the time does not increase, a number is not
// finite or the quaternion is far from unit.
bool ap_history_push(struct ap_history *history, int64_t t_ns, struct ap_pose pose,
                     const struct ap_vec3 *rate_rad_s);

// Writer: the next sample does not continue the last one (a recentring, the device's own reset).
void ap_history_reset(struct ap_history *history);

// Writer: from t_ns on the device is lost (unplugged), until the next sample.
void ap_history_lose(struct ap_history *history, int64_t t_ns);

// Reader: the pose at t_ns.
//   exact         a sample's time
//   interpolated  between two samples at most lost_after apart that belong together
//   predicted     after the newest one by at most lost_after
//   lost          else: the last pose before it is held (after the newest: as far as predicted)
//   none          before the first sample; the pose is then the identity
struct ap_history_answer ap_history_at(const struct ap_history *history, int64_t t_ns);

// The pose h_s later with velocities that fade with tau_s (INFINITY: not at all): the angle is
// rate·tau·(1 − e^(−h/tau)).
struct ap_pose ap_predict(struct ap_pose pose, struct ap_vec3 linear_m_s,
                          struct ap_vec3 angular_rad_s, double h_s, double tau_s);

#endif
