#ifndef ANTIPODE_DEVICE_TIMELINE_H
#define ANTIPODE_DEVICE_TIMELINE_H

#include <stdbool.h>
#include <stdint.h>

#include "src/base/status.h"
#include "src/device/poselog.h"

// A whole recording in memory, asked for poses at any time: what the simulated headset and `replay`
// both stand on, so that they agree. Immutable after loading; any number of threads may read.

enum ap_pose_state {
    AP_POSE_NONE,
    AP_POSE_EXACT,
    AP_POSE_INTERPOLATED,
    AP_POSE_LOST,
    AP_POSE_PREDICTED
};

// "exact", "interpolated", "lost", "predicted"; "none". A recording never predicts.
const char *ap_pose_state_name(enum ap_pose_state state);

struct ap_timeline;

// Reads the log to its end (and leaves it open; the caller closes it). AP_INPUT: a bad line, or no
// head sample in the whole log.
enum ap_status ap_timeline_load(struct ap_error *err, struct ap_poselog *log,
                                struct ap_timeline **timeline);
void ap_timeline_destroy(struct ap_timeline *timeline);

int ap_timeline_device_count(const struct ap_timeline *timeline);
const char *ap_timeline_device_name(const struct ap_timeline *timeline, int device);
int ap_timeline_find_device(const struct ap_timeline *timeline, const char *name); // −1: none

// First and last head sample, log time.
int64_t ap_timeline_start_ns(const struct ap_timeline *timeline);
int64_t ap_timeline_end_ns(const struct ap_timeline *timeline);

// t_0 + round(k·1e9/Hz), the exact quotient of the nearest doubles, halves away from zero.
int64_t ap_frame_time_ns(int64_t t0_ns, int64_t frame, double refresh_hz);

// Number of frames with t_k ≤ the last head sample.
int64_t ap_timeline_frame_count(const struct ap_timeline *timeline, double refresh_hz);

// The pose at t: exact at a sample, interpolated between neighbours at most 100 ms apart (and of
// one reference), else lost (the newest sample before t is held). AP_POSE_NONE before the first
// sample: *sample untouched. trigger, squeeze, select: those of the newest sample at or before t.
// sample->t_ns = t.
enum ap_pose_state ap_timeline_at(const struct ap_timeline *timeline, int device, int64_t t_ns,
                                  struct ap_sample *sample);

// The samples themselves, in merged order, for whoever writes them out again.
int64_t ap_timeline_sample_count(const struct ap_timeline *timeline);
struct ap_sample ap_timeline_sample(const struct ap_timeline *timeline, int64_t index);

#endif
