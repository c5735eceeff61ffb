#ifndef ANTIPODE_GEOM_DD_H
#define ANTIPODE_GEOM_DD_H

#include <math.h>

// A number as the unevaluated sum of two doubles (hi nearest to the sum, about 106 bits), for where
// a rounding error must be carried along: arc lengths, cancelling sums, walks. Relative error of
// each operation below 2^-100 away from overflow and underflow. Dekker 1971, Knuth's two-sum; the
// product's error comes from fma.
struct ap_dd {
    double hi, lo;
};

static inline struct ap_dd ap_dd_of(double a) {
    return (struct ap_dd){a, 0};
}

// Domain |a| >= |b| or a = 0.
static inline struct ap_dd ap_dd_quick_sum(double a, double b) {
    double s = a + b;
    return (struct ap_dd){s, b - (s - a)};
}

static inline struct ap_dd ap_dd_two_sum(double a, double b) {
    double s = a + b, bb = s - a;
    return (struct ap_dd){s, (a - (s - bb)) + (b - bb)};
}

static inline struct ap_dd ap_dd_two_product(double a, double b) {
    double p = a * b;
    return (struct ap_dd){p, fma(a, b, -p)};
}

static inline struct ap_dd ap_dd_add(struct ap_dd a, struct ap_dd b) {
    struct ap_dd s = ap_dd_two_sum(a.hi, b.hi), t = ap_dd_two_sum(a.lo, b.lo);
    s = ap_dd_quick_sum(s.hi, s.lo + t.hi);
    return ap_dd_quick_sum(s.hi, s.lo + t.lo);
}

static inline struct ap_dd ap_dd_neg(struct ap_dd a) {
    return (struct ap_dd){-a.hi, -a.lo};
}

static inline struct ap_dd ap_dd_sub(struct ap_dd a, struct ap_dd b) {
    return ap_dd_add(a, ap_dd_neg(b));
}

static inline struct ap_dd ap_dd_mul(struct ap_dd a, struct ap_dd b) {
    struct ap_dd p = ap_dd_two_product(a.hi, b.hi);
    return ap_dd_quick_sum(p.hi, p.lo + (a.hi * b.lo + a.lo * b.hi));
}

static inline struct ap_dd ap_dd_scale(double s, struct ap_dd a) {
    return ap_dd_mul(ap_dd_of(s), a);
}

static inline struct ap_dd ap_dd_div(struct ap_dd a, struct ap_dd b) {
    double q = a.hi / b.hi;
    struct ap_dd rest = ap_dd_sub(a, ap_dd_scale(q, b));
    struct ap_dd sum = ap_dd_quick_sum(q, rest.hi / b.hi);
    rest = ap_dd_sub(a, ap_dd_mul(sum, b));
    return ap_dd_quick_sum(sum.hi, sum.lo + rest.hi / b.hi);
}

// Domain a >= 0.
static inline struct ap_dd ap_dd_sqrt(struct ap_dd a) {
    if (!(a.hi > 0))
        return ap_dd_of(0);
    double s = sqrt(a.hi);
    struct ap_dd rest = ap_dd_sub(a, ap_dd_two_product(s, s));
    return ap_dd_quick_sum(s, rest.hi / (2 * s));
}

// a·b − c·d, each product exact.
static inline struct ap_dd ap_dd_minor(double a, double b, double c, double d) {
    return ap_dd_sub(ap_dd_two_product(a, b), ap_dd_two_product(c, d));
}

#endif
