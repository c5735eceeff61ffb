#include "src/geom/fixed.h"

#include <stdbool.h>

enum { LIMBS = 4, FRACTION = 216 };

__extension__ typedef unsigned __int128 wide;

static bool is_negative(struct ap_fixed a) {
    return a.limb[LIMBS - 1] >> 63;
}

struct ap_fixed ap_fixed_add(struct ap_fixed a, struct ap_fixed b) {
    wide carry = 0;
    for (int i = 0; i < LIMBS; i++) {
        carry += (wide)a.limb[i] + b.limb[i];
        a.limb[i] = (uint64_t)carry;
        carry >>= 64;
    }
    return a;
}

struct ap_fixed ap_fixed_neg(struct ap_fixed a) {
    wide carry = 1;
    for (int i = 0; i < LIMBS; i++) {
        carry += (uint64_t)~a.limb[i];
        a.limb[i] = (uint64_t)carry;
        carry >>= 64;
    }
    return a;
}

struct ap_fixed ap_fixed_sub(struct ap_fixed a, struct ap_fixed b) {
    return ap_fixed_add(a, ap_fixed_neg(b));
}

static struct ap_fixed size_of(struct ap_fixed a) {
    return is_negative(a) ? ap_fixed_neg(a) : a;
}

struct ap_fixed ap_fixed_of(double a) {
    struct ap_fixed out = {{0}};
    int exponent;
    double fraction = frexp(fabs(a), &exponent);
    uint64_t digits = (uint64_t)ldexp(fraction, 53);
    int at = exponent - 53 + FRACTION; // of the lowest digit
    if (at <= -64)
        return out;
    if (at < 0) {
        digits >>= -at;
        at = 0;
    }
    int limb = at / 64, shift = at % 64;
    out.limb[limb] = digits << shift;
    if (shift && limb + 1 < LIMBS)
        out.limb[limb + 1] = digits >> (64 - shift);
    return a < 0 ? ap_fixed_neg(out) : out;
}

static double near(struct ap_fixed a) {
    struct ap_fixed size = size_of(a);
    double sum = 0;
    for (int i = 0; i < LIMBS; i++)
        sum += ldexp((double)size.limb[i], 64 * i - FRACTION);
    return is_negative(a) ? -sum : sum;
}

struct ap_dd ap_fixed_round(struct ap_fixed a) {
    double high = near(a);
    return ap_dd_quick_sum(high, near(ap_fixed_sub(a, ap_fixed_of(high))));
}

struct ap_fixed ap_fixed_mul(struct ap_fixed a, struct ap_fixed b) {
    enum { WHOLE = FRACTION / 64, SHIFT = FRACTION % 64 };
    bool negative = is_negative(a) != is_negative(b);
    uint64_t product[2 * LIMBS] = {0};
    a = size_of(a);
    b = size_of(b);
    for (int i = 0; i < LIMBS; i++) {
        uint64_t carry = 0;
        for (int j = 0; j < LIMBS; j++) {
            wide sum = (wide)a.limb[i] * b.limb[j] + product[i + j] + carry;
            product[i + j] = (uint64_t)sum;
            carry = (uint64_t)(sum >> 64);
        }
        product[i + LIMBS] = carry;
    }
    struct ap_fixed out;
    for (int i = 0; i < LIMBS; i++)
        out.limb[i] = product[i + WHOLE] >> SHIFT | product[i + WHOLE + 1] << (64 - SHIFT);
    return negative ? ap_fixed_neg(out) : out;
}

struct ap_fixed ap_fixed_divide(struct ap_fixed a, uint32_t n) {
    struct ap_fixed size = size_of(a);
    wide rest = 0;
    for (int i = LIMBS - 1; i >= 0; i--) {
        rest = rest << 64 | size.limb[i];
        size.limb[i] = (uint64_t)(rest / n);
        rest %= n;
    }
    return is_negative(a) ? ap_fixed_neg(size) : size;
}

struct ap_fixed ap_fixed_inverse(struct ap_fixed a) {
    struct ap_fixed x = ap_fixed_of(1 / near(a)), two = ap_fixed_of(2);
    for (int step = 0; step < 3; step++)
        x = ap_fixed_mul(x, ap_fixed_sub(two, ap_fixed_mul(a, x)));
    return x;
}

struct ap_fixed ap_fixed_sqrt(struct ap_fixed a) {
    struct ap_fixed x = ap_fixed_of(1 / sqrt(near(a))), three = ap_fixed_of(3);
    for (int step = 0; step < 3; step++) {
        struct ap_fixed rest = ap_fixed_sub(three, ap_fixed_mul(a, ap_fixed_mul(x, x)));
        x = ap_fixed_divide(ap_fixed_mul(x, rest), 2);
    }
    return ap_fixed_mul(a, x);
}
