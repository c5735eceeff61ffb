#include <math.h>

#include "src/device/timeline.h"

__extension__ typedef unsigned __int128 wide;

static int bit_length(wide v) {
    int n = 0;
    for (; v; v >>= 1)
        n++;
    return n;
}

// round(k·1e9 / (m·2^e)), halves away from zero, INT64_MAX where it does not fit; m < 2^53.
static int64_t divide(wide k, wide m, int e) {
    wide numerator = k * 1000000000u;
    if (e < 0) {
        // Above 2^117 the quotient by m < 2^53 is above 2^63, and the shift might lose bits.
        if (bit_length(numerator) - e > 118)
            return INT64_MAX;
        numerator <<= -e;
    } else {
        if (bit_length(m) + e > 110) // the numerator is below 2^94
            return 0;
        m <<= e;
    }
    wide quotient = (2 * numerator + m) / (2 * m);
    return quotient > INT64_MAX ? INT64_MAX : (int64_t)quotient;
}

// A refresh rate is a double, that is m·2^e with whole m, so the quotient is one of whole numbers
// and no rounding comes before the one that is wanted.
int64_t ap_frame_time_ns(int64_t t0_ns, int64_t frame, double refresh_hz) {
    if (!(refresh_hz > 0) || !isfinite(refresh_hz))
        return t0_ns;
    int e;
    double fraction = frexp(refresh_hz, &e);
    uint64_t m = (uint64_t)ldexp(fraction, 53);
    e -= 53;
    int zeros = __builtin_ctzll(m);
    m >>= zeros;
    e += zeros;
    uint64_t k = frame < 0 ? 0 - (uint64_t)frame : (uint64_t)frame;
    int64_t way = divide(k, m, e), t;
    if (frame < 0)
        return __builtin_sub_overflow(t0_ns, way, &t) ? INT64_MIN : t;
    return __builtin_add_overflow(t0_ns, way, &t) ? INT64_MAX : t;
}
