#ifndef ANTIPODE_BASE_RANGE_H
#define ANTIPODE_BASE_RANGE_H

#include <stdbool.h>
#include <stdint.h>

#include "src/base/status.h"

// Frame numbers "A:B:STEP": first, first + step, … below end; each part may be empty.
struct ap_range {
    int64_t first, end, step; // 0 ≤ first, end ≤ INT64_MAX, step ≥ 1
};

#define AP_RANGE_ALL ((struct ap_range){0, INT64_MAX, 1})

// "A:B:STEP", "A:B", ":", "::5"… AP_USAGE for anything else.
enum ap_status ap_range_parse(struct ap_error *err, const char *text, struct ap_range *range);

static inline bool ap_range_has(struct ap_range range, int64_t k) {
    return k >= range.first && k < range.end && (k - range.first) % range.step == 0;
}

#endif
