#ifndef ANTIPODE_TESTS_VM_SAME_POSES_H
#define ANTIPODE_TESTS_VM_SAME_POSES_H

#include "src/device/poselog.h"

// Poses that were seen while a recording was played, against those of its file.

// A device's poses; times increase.
struct trace {
    char name[32];
    struct ap_sample *at;
    int count;
};

void trace_add(struct trace *trace, const struct ap_sample *sample);

// Whether the poses seen are the recording's, without trust in either's clock: each one (they come
// often, and interpolated between samples) must lie on the way from one replayed sample to the
// next, near the time when that was sent, and every way must have been seen. A line for each of
// the recording's devices:
//
//   DEVICE replayed N missed M seen S aside D late median … p99 … max … us
//
// aside: the farthest that a pose seen is from the way (metres, parts of a quaternion); late: how
// far its time is from when the way is there, where anything moves; missed: ways that nobody saw,
// but for the first ones: until the clocks are known dates are squeezed. A sample after a reset or
// a gap of more than 100 ms begins another way. sent_log: of a player's --sent.
void tell_same_poses(const char *recording, const char *sent_log, const struct trace *seen,
                     int seen_count, int64_t near_ns);

#endif
