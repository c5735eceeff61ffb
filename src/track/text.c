#include "src/track/text.h"

#include <math.h>
#include <stdint.h>
#include <string.h>

#include "src/base/number.h"

__extension__ typedef unsigned __int128 u128;

static const uint64_t tens[] = {1u,
                                10u,
                                100u,
                                1000u,
                                10000u,
                                100000u,
                                1000000u,
                                10000000u,
                                100000000u,
                                1000000000u,
                                10000000000u,
                                100000000000u,
                                1000000000000u,
                                10000000000000u,
                                100000000000000u,
                                1000000000000000u,
                                10000000000000000u,
                                100000000000000000u};

// x·10^k to the nearest integer, ties to even; x in [1e-4, 1e17), k in 0…21: below 2^128
// throughout.
static uint64_t scaled(double x, int k) {
    int e;
    u128 n = (u128)(uint64_t)ldexp(frexp(x, &e), 53);
    n *= tens[k > 17 ? 17 : k];
    n *= tens[k > 17 ? k - 17 : 0];
    e -= 53;
    if (e >= 0)
        return (uint64_t)(n << e);
    u128 whole = n >> -e, rest = n - (whole << -e), half = (u128)1 << (-e - 1);
    return (uint64_t)whole + (rest > half || (rest == half && (whole & 1)));
}

// 17 digits: x = digits·10^(exponent − 16).
static uint64_t digits_of(double x, int *exponent) {
    int e2;
    frexp(x, &e2);
    int e10 = (int)floor((e2 - 1) * 0.30102999566398120); // that of x or one less
    uint64_t n = scaled(x, 16 - e10);
    if (n >= tens[17]) // also where x rounds up to the next power of ten
        n = scaled(x, 16 - ++e10);
    *exponent = e10;
    return n;
}

static char *put(char *at, const char *bytes, int count) {
    memcpy(at, bytes, (size_t)count);
    return at + count;
}

static char *put_fixed(char *at, const char *digit, int count, int exponent) {
    if (exponent < 0) {
        at = put(at, "0.000", 1 - exponent);
        return put(at, digit, count);
    }
    at = put(at, digit, exponent + 1); // zeros among them where count is less
    if (count <= exponent + 1)
        return at;
    *at++ = '.';
    return put(at, digit + exponent + 1, count - exponent - 1);
}

size_t ap_number_text(char *text, double value) {
    double x = fabs(value);
    if (!(x >= 1e-4 && x < 1e16)) {
        if (value != 0)
            return ap_format_double(text, value);
        memcpy(text, "-0", 2);
        text[0] = signbit(value) ? '-' : '0';
        return signbit(value) ? 2 : 1;
    }
    int exponent;
    uint64_t n = digits_of(x, &exponent);
    char digit[17];
    for (int i = 16; i >= 0; i--, n /= 10)
        digit[i] = (char)('0' + n % 10);
    int count = 17;
    while (count > 1 && digit[count - 1] == '0')
        count--;
    char *at = text;
    if (value < 0)
        *at++ = '-';
    at = put_fixed(at, digit, count, exponent);
    return (size_t)(at - text);
}

size_t ap_iso_text(char text[AP_ISO_TEXT_MAX], const struct ap_iso *m) {
    size_t len = 0;
    for (int i = 0; i < 16; i++) {
        if (i)
            text[len++] = ',';
        len += ap_number_text(text + len, m->m[i / 4][i % 4]);
    }
    return len;
}
