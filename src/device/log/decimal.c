#include "src/device/log/decimal.h"

#include <float.h>
#include <string.h>

#include "src/base/number.h"

// A decimal number taken apart: ±digits·10^exponent, where `digits` are the text's without point
// and leading zeros.
struct decimal {
    bool negative;
    uint64_t digits;    // the first 19
    size_t digit_count; // all of them
    int64_t exponent;   // of the last digit
    const char *first;  // the first digit that counts; the point may stand among those after it
    const char *end;    // behind the last one
};

enum { MAX_EXPONENT = 1000000 };

static bool is_digit(char c) {
    return c >= '0' && c <= '9';
}

static const char *scan_digits(const char *p, const char *end, struct decimal *d) {
    uint64_t digits = d->digits;
    size_t count = d->digit_count;
    for (; p < end && is_digit(*p); p++) {
        if (!count && *p == '0')
            continue;
        if (!count)
            d->first = p;
        if (count++ < 19)
            digits = digits * 10 + (uint64_t)(*p - '0');
    }
    d->digits = digits;
    d->digit_count = count;
    return p;
}

static const char *scan_exponent(const char *p, const char *end, int64_t *exponent) {
    bool negative = false;
    if (p < end && (*p == '+' || *p == '-'))
        negative = *p++ == '-';
    if (p == end || !is_digit(*p))
        return NULL;
    int64_t e = 0;
    for (; p < end && is_digit(*p); p++)
        if (e < MAX_EXPONENT)
            e = e * 10 + (*p - '0');
    *exponent += negative ? -e : e;
    return p;
}

static bool take_apart(const char *text, size_t len, struct decimal *d) {
    const char *p = text, *end = text + len;
    *d = (struct decimal){0};
    if (p < end && (*p == '+' || *p == '-'))
        d->negative = *p++ == '-';
    const char *whole = p;
    p = scan_digits(p, end, d);
    size_t seen = (size_t)(p - whole);
    if (p < end && *p == '.') {
        const char *part = ++p;
        p = scan_digits(p, end, d);
        seen += (size_t)(p - part);
        d->exponent = -(int64_t)(p - part);
    }
    d->end = p;
    if (!seen)
        return false;
    if (p < end && (*p == 'e' || *p == 'E'))
        p = scan_exponent(p + 1, end, &d->exponent);
    return p == end;
}

static const double powers[] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,
                                1e8,  1e9,  1e10, 1e11, 1e12, 1e13, 1e14, 1e15,
                                1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};

// Clinger's observation: below 2^53 and up to 10^22 both operands are exact, so the one rounding
// of the division or product is the right one.
static bool from_exact(const struct decimal *d, double *value) {
    if (d->digits > UINT64_C(1) << 53 || d->exponent < -22 || d->exponent > 22)
        return false;
    double v = (double)d->digits;
    v = d->exponent < 0 ? v / powers[-d->exponent] : v * powers[d->exponent];
    *value = d->negative ? -v : v;
    return true;
}

#if LDBL_MANT_DIG == 64
// The same with x87's 64-bit mantissas, for the 17 digits our own writer gives. Rounding twice is
// harmless unless the first result lies exactly between two doubles; then the slow way decides.
static bool from_extended(const struct decimal *d, double *value) {
    static const long double extended[] = {1e0L,  1e1L,  1e2L,  1e3L,  1e4L,  1e5L,  1e6L,
                                           1e7L,  1e8L,  1e9L,  1e10L, 1e11L, 1e12L, 1e13L,
                                           1e14L, 1e15L, 1e16L, 1e17L, 1e18L, 1e19L, 1e20L,
                                           1e21L, 1e22L, 1e23L, 1e24L, 1e25L, 1e26L, 1e27L};
    if (d->exponent < -27 || d->exponent > 0)
        return false;
    long double v = (long double)d->digits / extended[-d->exponent];
    uint64_t mantissa;
    memcpy(&mantissa, &v, sizeof mantissa);
    if ((mantissa & 0x7ff) == 0x400)
        return false;
    *value = d->negative ? (double)-v : (double)v;
    return true;
}
#else
static bool from_extended(const struct decimal *d, double *value) {
    (void)d, (void)value;
    return false;
}
#endif

bool ap_decimal_double(const char *text, size_t len, double *value) {
    struct decimal d;
    if (!take_apart(text, len, &d))
        return false;
    if (d.digit_count <= 19 && (from_exact(&d, value) || from_extended(&d, value)))
        return true;
    return ap_parse_double(text, len, value);
}

bool ap_decimal_seconds_ns(const char *text, size_t len, int64_t *t_ns) {
    struct decimal d;
    if (!take_apart(text, len, &d))
        return false;
    // How many of the digits stand left of the nanosecond's point; the first one right of it alone
    // decides about rounding.
    int64_t whole = (int64_t)d.digit_count + d.exponent + 9;
    int64_t v = 0, taken = 0;
    for (const char *p = d.first; d.digit_count && p < d.end && taken <= whole; p++) {
        if (*p == '.')
            continue;
        if (taken++ < whole) {
            if (__builtin_mul_overflow(v, 10, &v) || __builtin_add_overflow(v, *p - '0', &v))
                return false;
        } else if (*p >= '5' && __builtin_add_overflow(v, 1, &v))
            return false;
    }
    for (; v && taken < whole; taken++)
        if (__builtin_mul_overflow(v, 10, &v))
            return false;
    *t_ns = d.negative ? -v : v;
    return true;
}
