#include "src/track/motion.h"

static void rotation(const struct ap_dd q[4], struct ap_dd r[3][3]) {
    struct ap_dd n = ap_dd_of(0);
    for (int i = 0; i < 4; i++)
        n = ap_dd_add(n, ap_dd_mul(q[i], q[i]));
    struct ap_dd s = ap_dd_div(ap_dd_of(2), n), one = ap_dd_of(1);
    struct ap_dd x = ap_dd_mul(s, q[0]), y = ap_dd_mul(s, q[1]), z = ap_dd_mul(s, q[2]);
    struct ap_dd xx = ap_dd_mul(x, q[0]), yy = ap_dd_mul(y, q[1]), zz = ap_dd_mul(z, q[2]);
    struct ap_dd xy = ap_dd_mul(x, q[1]), yz = ap_dd_mul(y, q[2]), zx = ap_dd_mul(z, q[0]);
    struct ap_dd xw = ap_dd_mul(x, q[3]), yw = ap_dd_mul(y, q[3]), zw = ap_dd_mul(z, q[3]);
    r[0][0] = ap_dd_sub(one, ap_dd_add(yy, zz));
    r[1][1] = ap_dd_sub(one, ap_dd_add(zz, xx));
    r[2][2] = ap_dd_sub(one, ap_dd_add(xx, yy));
    r[0][1] = ap_dd_sub(xy, zw);
    r[1][0] = ap_dd_add(xy, zw);
    r[1][2] = ap_dd_sub(yz, xw);
    r[2][1] = ap_dd_add(yz, xw);
    r[2][0] = ap_dd_sub(zx, yw);
    r[0][2] = ap_dd_add(zx, yw);
}

// conj(a)·b of the four-component doubles, each sum of four products in double-double.
static void quat_between(struct ap_quat a, struct ap_quat b, struct ap_dd q[4]) {
    const double term[4][4][2] = {
        {{a.w, b.x}, {-a.x, b.w}, {-a.y, b.z}, {a.z, b.y}},
        {{a.w, b.y}, {-a.y, b.w}, {-a.z, b.x}, {a.x, b.z}},
        {{a.w, b.z}, {-a.z, b.w}, {-a.x, b.y}, {a.y, b.x}},
        {{a.w, b.w}, {a.x, b.x}, {a.y, b.y}, {a.z, b.z}},
    };
    for (int i = 0; i < 4; i++) {
        q[i] = ap_dd_of(0);
        for (int j = 0; j < 4; j++)
            q[i] = ap_dd_add(q[i], ap_dd_two_product(term[i][j][0], term[i][j][1]));
    }
}

static void quat_wide(struct ap_quat a, struct ap_dd q[4]) {
    q[0] = ap_dd_of(a.x);
    q[1] = ap_dd_of(a.y);
    q[2] = ap_dd_of(a.z);
    q[3] = ap_dd_of(a.w);
}

static void difference(struct ap_vec3 a, struct ap_vec3 b, struct ap_dd d[3]) {
    d[0] = ap_dd_two_sum(a.x, -b.x);
    d[1] = ap_dd_two_sum(a.y, -b.y);
    d[2] = ap_dd_two_sum(a.z, -b.z);
}

struct ap_motion ap_motion_between(struct ap_pose a, struct ap_pose b) {
    struct ap_motion motion;
    struct ap_dd q[4], r[3][3], d[3];
    quat_wide(a.q, q);
    rotation(q, r);
    difference(b.p, a.p, d);
    for (int i = 0; i < 3; i++) {
        motion.p_m[i] = ap_dd_mul(r[0][i], d[0]);
        motion.p_m[i] = ap_dd_add(motion.p_m[i], ap_dd_mul(r[1][i], d[1]));
        motion.p_m[i] = ap_dd_add(motion.p_m[i], ap_dd_mul(r[2][i], d[2]));
    }
    quat_between(a.q, b.q, q);
    rotation(q, motion.r);
    return motion;
}

struct ap_motion ap_motion_from(struct ap_vec3 origin, struct ap_pose pose) {
    struct ap_motion motion;
    struct ap_dd q[4];
    difference(pose.p, origin, motion.p_m);
    quat_wide(pose.q, q);
    rotation(q, motion.r);
    return motion;
}

static struct ap_dd get(const struct ap_wide_iso *m, int i, int j) {
    return (struct ap_dd){m->hi.m[i][j], m->lo.m[i][j]};
}

static void put(struct ap_wide_iso *m, int i, int j, struct ap_dd a) {
    m->hi.m[i][j] = a.hi;
    m->lo.m[i][j] = a.lo;
}

struct ap_wide_iso ap_wide_identity(void) {
    struct ap_wide_iso m = {0};
    for (int i = 0; i < 4; i++)
        m.hi.m[i][i] = 1;
    return m;
}

// Of x = t²: cos1 = (C − 1)/t², sinc = S/t, both entire functions of x, so that no square root and
// no quotient stands near t = 0. Power series below t = 1/4, doubling of the angle above.
static void functions(int kappa, struct ap_dd x, struct ap_dd *cos1, struct ap_dd *sinc) {
    struct ap_dd one = ap_dd_of(1);
    if (kappa == 0 || !isfinite(x.hi)) {
        *cos1 = ap_dd_of(kappa == 0 ? 0 : NAN);
        *sinc = kappa == 0 ? one : *cos1;
        return;
    }
    int doublings = 0, terms = 1;
    for (; x.hi > 0.0625; doublings++)
        x = ap_dd_scale(0.25, x);
    for (double bound = x.hi; bound > 1e-34; terms++)
        bound *= x.hi / ((2.0 * terms + 2) * (2.0 * terms + 3));
    struct ap_dd e = one, f = one, y = ap_dd_scale(kappa > 0 ? -1 : 1, x);
    for (int k = terms; k > 0; k--) {
        double n = 2.0 * k;
        f = ap_dd_add(one, ap_dd_div(ap_dd_mul(y, f), ap_dd_of(n * (n + 1))));
        e = ap_dd_add(one, ap_dd_div(ap_dd_mul(y, e), ap_dd_of((n + 1) * (n + 2))));
    }
    e = ap_dd_scale(kappa > 0 ? -0.5 : 0.5, e);
    for (; doublings > 0; doublings--) {
        struct ap_dd c = ap_dd_add(one, ap_dd_mul(x, e));
        f = ap_dd_mul(f, c);
        e = ap_dd_scale(0.5, ap_dd_mul(e, ap_dd_add(one, c)));
        x = ap_dd_scale(4, x);
    }
    *cos1 = e;
    *sinc = f;
}

void ap_wide_translate(struct ap_space space, const struct ap_dd v_m[3], struct ap_wide_iso *m) {
    struct ap_dd w[3], x = ap_dd_of(0), cos1, sinc;
    struct ap_dd per_rho = ap_dd_div(ap_dd_of(1), ap_dd_of(space.rho_m));
    for (int j = 0; j < 3; j++) {
        w[j] = ap_dd_mul(v_m[j], per_rho);
        x = ap_dd_add(x, ap_dd_mul(w[j], w[j]));
    }
    functions(space.kappa, x, &cos1, &sinc);
    struct ap_dd c = ap_dd_add(ap_dd_of(1), ap_dd_mul(x, cos1));
    struct ap_dd back = ap_dd_scale(-space.kappa, sinc);
    for (int i = 0; i < 4; i++) {
        struct ap_dd along = ap_dd_of(0), last = get(m, i, 3);
        for (int j = 0; j < 3; j++)
            along = ap_dd_add(along, ap_dd_mul(get(m, i, j), w[j]));
        struct ap_dd pull = ap_dd_add(ap_dd_mul(cos1, along), ap_dd_mul(back, last));
        for (int j = 0; j < 3; j++)
            put(m, i, j, ap_dd_add(get(m, i, j), ap_dd_mul(pull, w[j])));
        put(m, i, 3, ap_dd_add(ap_dd_mul(c, last), ap_dd_mul(sinc, along)));
    }
}

void ap_wide_turn(const struct ap_dd r[3][3], struct ap_wide_iso *m) {
    for (int i = 0; i < 4; i++) {
        struct ap_dd row[3];
        for (int j = 0; j < 3; j++) {
            row[j] = ap_dd_mul(get(m, i, 0), r[0][j]);
            row[j] = ap_dd_add(row[j], ap_dd_mul(get(m, i, 1), r[1][j]));
            row[j] = ap_dd_add(row[j], ap_dd_mul(get(m, i, 2), r[2][j]));
        }
        for (int j = 0; j < 3; j++)
            put(m, i, j, row[j]);
    }
}

void ap_wide_move(struct ap_space space, const struct ap_motion *motion, struct ap_wide_iso *m) {
    ap_wide_translate(space, motion->p_m, m);
    ap_wide_turn(motion->r, m);
}

void ap_wide_unmove(struct ap_space space, const struct ap_motion *motion, struct ap_wide_iso *m) {
    struct ap_motion back;
    for (int i = 0; i < 3; i++) {
        back.p_m[i] = ap_dd_neg(motion->p_m[i]);
        for (int j = 0; j < 3; j++)
            back.r[i][j] = motion->r[j][i];
    }
    ap_wide_turn(((const struct ap_motion *)&back)->r, m);
    ap_wide_translate(space, back.p_m, m);
}

void ap_wide_renew(struct ap_space space, struct ap_wide_iso *m) {
    struct ap_wide_iso old = *m;
    struct ap_dd near[4][4];
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++) {
            struct ap_dd sum = ap_dd_of(i == j ? 3 : 0);
            for (int k = 0; k < 4; k++) {
                double sign = (i == 3) != (k == 3) ? -space.kappa : -1;
                struct ap_dd both = ap_dd_mul(get(&old, k, i), get(&old, k, j));
                sum = ap_dd_add(sum, ap_dd_scale(sign, both));
            }
            near[i][j] = ap_dd_scale(0.5, sum);
        }
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++) {
            struct ap_dd sum = ap_dd_of(0);
            for (int k = 0; k < 4; k++)
                sum = ap_dd_add(sum, ap_dd_mul(get(&old, i, k), near[k][j]));
            put(m, i, j, sum);
        }
}

bool ap_iso_is_finite(const struct ap_iso *m) {
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++)
            if (!isfinite(m->m[i][j]))
                return false;
    return true;
}
