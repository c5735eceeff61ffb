#ifndef ANTIPODE_DEVICE_WALK_H
#define ANTIPODE_DEVICE_WALK_H

#include <stdint.h>

#include "src/device/poselog.h"

// Scripted motion: a person who walks round a square table with a hand on its edge, stops, bends
// over it, aims, turns back. Head and both hands; human in speed, sway, head bob and turning rates.
// Deterministic: a pure function of (params, t). Room frame: the table's centre above the origin.
struct ap_walk_params {
    double table_edge_m;   // 0: 0.9
    double table_height_m; // 0: 0.75
    double duration_s;     // 0: the default walk's own
    uint64_t seed;         // of the sway; 0: 1
};

double ap_walk_duration_s(const struct ap_walk_params *params);

// device 0 head, 1 left, 2 right; t_ns from 0. Times outside the walk give its ends.
struct ap_sample ap_walk_at(const struct ap_walk_params *params, int device, int64_t t_ns);

#endif
