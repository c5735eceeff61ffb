#include "src/geom/arc.h"

// Powers of two that bring a number near 1, only where its square could overflow or underflow.
static int exponent_to_drop(double a) {
    if (a == 0 || (a > 0x1p-300 && a < 0x1p300))
        return 0;
    int e;
    frexp(a, &e);
    return e;
}

static double largest(struct ap_vec3 v) {
    return fmax(fmax(fabs(v.x), fabs(v.y)), fabs(v.z));
}

static struct ap_vec3 shift(struct ap_vec3 v, int e) {
    return e ? (struct ap_vec3){ldexp(v.x, e), ldexp(v.y, e), ldexp(v.z, e)} : v;
}

static struct ap_dd shift_dd(struct ap_dd a, int e) {
    return e ? (struct ap_dd){ldexp(a.hi, e), ldexp(a.lo, e)} : a;
}

static struct ap_dd plain_length(struct ap_vec3 v) {
    struct ap_dd sum = ap_dd_add(ap_dd_two_product(v.x, v.x), ap_dd_two_product(v.y, v.y));
    return ap_dd_sqrt(ap_dd_add(sum, ap_dd_two_product(v.z, v.z)));
}

struct ap_dd ap_length_dd(struct ap_vec3 v) {
    int e = exponent_to_drop(largest(v));
    return shift_dd(plain_length(shift(v, -e)), e);
}

double ap_polar(struct ap_vec3 v, struct ap_vec3 *unit) {
    int e = exponent_to_drop(largest(v));
    v = shift(v, -e);
    double n = plain_length(v).hi;
    *unit = n > 0 ? (struct ap_vec3){v.x / n, v.y / n, v.z / n} : v;
    return e ? ldexp(n, e) : n;
}

void ap_unit_dd(struct ap_vec3 v, struct ap_dd unit[3]) {
    v = shift(v, -exponent_to_drop(largest(v)));
    struct ap_dd n = plain_length(v);
    unit[0] = ap_dd_div(ap_dd_of(v.x), n);
    unit[1] = ap_dd_div(ap_dd_of(v.y), n);
    unit[2] = ap_dd_div(ap_dd_of(v.z), n);
}

static struct ap_dd shifted_quotient(struct ap_dd a, double b, int e) {
    int ea = exponent_to_drop(a.hi), eb = exponent_to_drop(b);
    struct ap_dd q = ap_dd_div(shift_dd(a, -ea), ap_dd_of(eb ? ldexp(b, -eb) : b));
    return shift_dd(q, ea - eb + e);
}

struct ap_dd ap_quotient_dd(struct ap_dd a, double b) {
    return a.hi == 0 ? ap_dd_of(0) : shifted_quotient(a, b, 0);
}

struct ap_arc ap_arc_of(struct ap_space space, struct ap_vec3 v_m) {
    int e = exponent_to_drop(largest(v_m));
    struct ap_vec3 v = shift(v_m, -e);
    struct ap_dd n = plain_length(v);
    if (!(n.hi > 0))
        return (struct ap_arc){{0, 0, 0}, {0, 0}};
    return (struct ap_arc){{v.x / n.hi, v.y / n.hi, v.z / n.hi},
                           shifted_quotient(n, space.rho_m, e)};
}

struct ap_turn ap_turn_of(struct ap_space space, struct ap_dd t) {
    double c = ap_space_cos(space, t.hi), s = ap_space_sin(space, t.hi);
    struct ap_turn turn = {c - space.kappa * s * t.lo, s + c * t.lo, 0};
    if (space.kappa > 0 && fabs(t.lo) > 0x1p-30) { // many turns: its square shows
        double c_lo = cos(t.lo), s_lo = sin(t.lo);
        turn = (struct ap_turn){c * c_lo - s * s_lo, s * c_lo + c * s_lo, 0};
    }
    if (space.kappa && t.hi > 0) {
        // S²/(1 + C) does not cancel near the base point; beyond a quarter turn C − 1 does not.
        double square = turn.s * (turn.s / (1 + turn.c));
        turn.c_minus_1 = turn.c > 0 ? -space.kappa * square : turn.c - 1;
    }
    return turn;
}

// t modulo 2·pi, to 161 bits of it.
static struct ap_dd less_full_turns(struct ap_dd t) {
    static const double two_pi[3] = {6.283185307179586, 2.4492935982947064e-16,
                                     -5.989539619436679e-33};
    double n = rint(t.hi / two_pi[0]);
    for (int i = 0; i < 3; i++)
        t = ap_dd_sub(t, ap_dd_two_product(n, two_pi[i]));
    return t;
}

// S and C − 1 for |t| <= 1/16 by their series in −kappa·t²; what is left out is below 2^-110.
static void series(int kappa, struct ap_dd t, struct ap_dd *s, struct ap_dd *c_minus_1) {
    struct ap_dd x = ap_dd_scale(-kappa, ap_dd_mul(t, t));
    struct ap_dd sum_s = ap_dd_of(1), sum_c = ap_dd_of(1);
    for (int k = 8; k > 0; k--) {
        sum_s = ap_dd_div(ap_dd_mul(sum_s, x), ap_dd_of(2.0 * k * (2 * k + 1)));
        sum_s = ap_dd_add(ap_dd_of(1), sum_s);
        sum_c = ap_dd_div(ap_dd_mul(sum_c, x), ap_dd_of((2.0 * k + 1) * (2 * k + 2)));
        sum_c = ap_dd_add(ap_dd_of(1), sum_c);
    }
    *s = ap_dd_mul(t, sum_s);
    *c_minus_1 = ap_dd_scale(0.5, ap_dd_mul(x, sum_c));
}

void ap_turn_dd(struct ap_space space, struct ap_dd t, struct ap_dd *s, struct ap_dd *c_minus_1) {
    if (space.kappa == 0) {
        *s = t;
        *c_minus_1 = ap_dd_of(0);
        return;
    }
    if (space.kappa > 0 && t.hi > 0x1p40) { // libm reduces what two doubles cannot
        struct ap_turn turn = ap_turn_of(space, t);
        *s = ap_dd_of(turn.s);
        *c_minus_1 = ap_dd_of(turn.c_minus_1);
        return;
    }
    if (space.kappa > 0 && t.hi > 3.2)
        t = less_full_turns(t);
    // Halve until the series is short, then double: S(2t) = 2·S·C, C(2t) − 1 = 2·(C − 1)·(C + 1).
    int halvings = 0;
    double size = fabs(t.hi);
    for (; size > 0x1p-4 && halvings < 16; size /= 2)
        halvings++;
    if (size > 0x1p-4) { // h3 beyond any double
        *s = *c_minus_1 = ap_dd_of(INFINITY);
        return;
    }
    series(space.kappa, shift_dd(t, -halvings), s, c_minus_1);
    for (; halvings > 0; halvings--) {
        *s = ap_dd_scale(2, ap_dd_mul(*s, ap_dd_add(*c_minus_1, ap_dd_of(1))));
        *c_minus_1 = ap_dd_scale(2, ap_dd_mul(*c_minus_1, ap_dd_add(*c_minus_1, ap_dd_of(2))));
    }
}
