#include "src/geom/deep.h"

#include <stdlib.h>
#include <string.h>

// Short, for formulas.
typedef struct ap_fixed fx;

static fx num(double a) {
    return ap_fixed_of(a);
}

static fx add(fx a, fx b) {
    return ap_fixed_add(a, b);
}

static fx sub(fx a, fx b) {
    return ap_fixed_sub(a, b);
}

static fx mul(fx a, fx b) {
    return ap_fixed_mul(a, b);
}

static fx neg(fx a) {
    return ap_fixed_neg(a);
}

static fx twice(fx a) {
    return add(a, a);
}

struct ap_deep_iso ap_deep_identity(void) {
    struct ap_deep_iso m;
    memset(&m, 0, sizeof m);
    for (int i = 0; i < 4; i++)
        m.m[i][i] = num(1);
    return m;
}

struct ap_deep_iso ap_deep_mul(const struct ap_deep_iso *a, const struct ap_deep_iso *b) {
    struct ap_deep_iso out;
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++) {
            fx sum = mul(a->m[i][0], b->m[0][j]);
            for (int k = 1; k < 4; k++)
                sum = add(sum, mul(a->m[i][k], b->m[k][j]));
            out.m[i][j] = sum;
        }
    return out;
}

// G·Mᵀ·G.
struct ap_deep_iso ap_deep_inverse(const struct ap_deep_iso *a) {
    struct ap_deep_iso out;
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++)
            out.m[i][j] = (i == 3) != (j == 3) ? neg(a->m[j][i]) : a->m[j][i];
    return out;
}

// M ← M·(3 − M⁻¹·M)/2, with G·Mᵀ·G for the inverse.
struct ap_deep_iso ap_deep_renew(const struct ap_deep_iso *a) {
    struct ap_deep_iso back = ap_deep_inverse(a), near = ap_deep_mul(&back, a);
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++)
            near.m[i][j] = ap_fixed_divide(sub(i == j ? num(3) : num(0), near.m[i][j]), 2);
    return ap_deep_mul(a, &near);
}

bool ap_deep_fits(const struct ap_deep_iso *a) {
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++)
            if (!(fabs(ap_fixed_round(a->m[i][j]).hi) < 65536))
                return false;
    return true;
}

void ap_deep_round(const struct ap_deep_iso *a, struct ap_iso *high, struct ap_iso *low) {
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++) {
            struct ap_dd both = ap_fixed_round(a->m[i][j]);
            high->m[i][j] = both.hi;
            low->m[i][j] = both.lo;
        }
}

// Of q/|q|, any q of a length from 1 to 16.
static void rotation(const fx q[4], fx r[3][3]) {
    fx n = num(0);
    for (int i = 0; i < 4; i++)
        n = add(n, mul(q[i], q[i]));
    fx s = twice(ap_fixed_inverse(n)), one = num(1);
    fx x = mul(s, q[0]), y = mul(s, q[1]), z = mul(s, q[2]);
    fx xx = mul(x, q[0]), yy = mul(y, q[1]), zz = mul(z, q[2]);
    fx xy = mul(x, q[1]), yz = mul(y, q[2]), zx = mul(z, q[0]);
    fx xw = mul(x, q[3]), yw = mul(y, q[3]), zw = mul(z, q[3]);
    r[0][0] = sub(one, add(yy, zz));
    r[1][1] = sub(one, add(zz, xx));
    r[2][2] = sub(one, add(xx, yy));
    r[0][1] = sub(xy, zw);
    r[1][0] = add(xy, zw);
    r[1][2] = sub(yz, xw);
    r[2][1] = add(yz, xw);
    r[2][0] = sub(zx, yw);
    r[0][2] = add(zx, yw);
}

// The largest component between 1 and 2. False: 0, or not finite.
static bool quaternion(struct ap_quat a, fx q[4]) {
    const double parts[4] = {a.x, a.y, a.z, a.w};
    double most = 0;
    for (int i = 0; i < 4; i++)
        most = fmax(most, fabs(parts[i]));
    if (!isfinite(a.x + a.y + a.z + a.w) || !(most > 0))
        return false;
    for (int i = 0; i < 4; i++)
        q[i] = num(ldexp(parts[i], -ilogb(most)));
    return true;
}

// conj(a)·b.
static void quotient(const fx a[4], const fx b[4], fx q[4]) {
    q[0] = sub(add(sub(mul(a[3], b[0]), mul(a[0], b[3])), mul(a[2], b[1])), mul(a[1], b[2]));
    q[1] = sub(add(sub(mul(a[3], b[1]), mul(a[1], b[3])), mul(a[0], b[2])), mul(a[2], b[0]));
    q[2] = sub(add(sub(mul(a[3], b[2]), mul(a[2], b[3])), mul(a[1], b[0])), mul(a[0], b[1]));
    q[3] = add(add(mul(a[3], b[3]), mul(a[0], b[0])), add(mul(a[1], b[1]), mul(a[2], b[2])));
}

// Of x = t²: (C − 1)/t² and S/t, entire functions. Series below t = 1/4, doubled above.
static void functions(fx x, fx *cos1, fx *sinc) {
    fx one = num(1), e = one, f = one;
    int doublings = 0, terms = 1;
    double size = ap_fixed_round(x).hi;
    for (; size > 0.0625; doublings++, size /= 4)
        x = ap_fixed_divide(x, 4);
    for (double bound = size; bound > 1e-66; terms++)
        bound *= size / ((2.0 * terms + 2) * (2.0 * terms + 3));
    for (uint32_t n = 2 * (uint32_t)terms; n > 0; n -= 2) {
        f = add(one, ap_fixed_divide(mul(x, f), n * (n + 1)));
        e = add(one, ap_fixed_divide(mul(x, e), (n + 1) * (n + 2)));
    }
    e = ap_fixed_divide(e, 2);
    for (; doublings > 0; doublings--) {
        fx c = add(one, mul(x, e));
        f = mul(f, c);
        e = ap_fixed_divide(mul(e, add(one, c)), 2);
        x = twice(twice(x));
    }
    *cos1 = e;
    *sinc = f;
}

// w over rho.
static struct ap_deep_iso translation(const fx w[3]) {
    struct ap_deep_iso m = ap_deep_identity();
    fx x = num(0), cos1, sinc;
    for (int i = 0; i < 3; i++)
        x = add(x, mul(w[i], w[i]));
    functions(x, &cos1, &sinc);
    for (int i = 0; i < 3; i++) {
        fx along = mul(cos1, w[i]);
        for (int j = 0; j < 3; j++)
            m.m[i][j] = add(m.m[i][j], mul(along, w[j]));
        m.m[i][3] = m.m[3][i] = mul(sinc, w[i]);
    }
    m.m[3][3] = add(num(1), mul(x, cos1));
    return m;
}

bool ap_deep_between(double rho_m, struct ap_pose a, struct ap_pose b, struct ap_deep_iso *out) {
    const double from[3] = {a.p.x, a.p.y, a.p.z}, to[3] = {b.p.x, b.p.y, b.p.z};
    const double most = fmin(1, rho_m) * 0x1p30;
    fx qa[4], qb[4], q[4], r[3][3], d[3], w[3];
    double length = ap_vec3_length(ap_vec3_sub(b.p, a.p));
    if (!(length < 11 * rho_m) || !quaternion(a.q, qa) || !quaternion(b.q, qb))
        return false;
    for (int i = 0; i < 3; i++)
        if (!(fabs(from[i]) < most && fabs(to[i]) < most))
            return false;
    // In units of a power of two next to rho.
    int scale = ilogb(rho_m);
    fx per_rho = ap_fixed_inverse(num(ldexp(rho_m, -scale)));
    for (int i = 0; i < 3; i++)
        d[i] = mul(per_rho, sub(num(ldexp(to[i], -scale)), num(ldexp(from[i], -scale))));
    rotation(qa, r);
    for (int i = 0; i < 3; i++)
        w[i] = add(add(mul(r[0][i], d[0]), mul(r[1][i], d[1])), mul(r[2][i], d[2]));
    quotient(qa, qb, q);
    rotation(q, r);
    struct ap_deep_iso turn = ap_deep_identity(), move = translation(w);
    for (int i = 0; i < 3; i++)
        memcpy(turn.m[i], r[i], sizeof r[i]);
    *out = ap_deep_mul(&move, &turn);
    return true;
}

static fx cosine_of(int n) {
    if (n == 3)
        return num(0.5);
    if (n == 4)
        return ap_fixed_sqrt(num(0.5));
    return ap_fixed_divide(add(num(1), ap_fixed_sqrt(num(5))), 4);
}

// The simplex as in tiling.c: three mirrors through the centre, and (C, S) of the inradius.
static void simplex(struct ap_symbol s, struct ap_deep_iso mirror[3], fx *c, fx *sh) {
    fx zero = num(0), one = num(1), cp = cosine_of(s.p);
    fx sp = ap_fixed_sqrt(sub(one, mul(cp, cp)));
    fx z = neg(mul(cosine_of(s.q), ap_fixed_inverse(sp)));
    fx y = ap_fixed_sqrt(sub(one, mul(z, z)));
    const fx normal[3][3] = {{one, zero, zero}, {neg(cp), zero, sp}, {zero, neg(y), z}};
    for (int k = 0; k < 3; k++) {
        mirror[k] = ap_deep_identity();
        for (int i = 0; i < 3; i++)
            for (int j = 0; j < 3; j++)
                mirror[k].m[i][j] = sub(mirror[k].m[i][j], twice(mul(normal[k][i], normal[k][j])));
    }
    *c = mul(cosine_of(s.r), ap_fixed_inverse(y));
    *sh = ap_fixed_sqrt(sub(mul(*c, *c), one));
}

// Which symmetry of the cell this is.
static int symmetry_of(const struct ap_tiling *t, const struct ap_deep_iso *m) {
    for (int g = 0; g < t->symmetry_count; g++) {
        double far = 0;
        for (int i = 0; i < 3; i++)
            for (int j = 0; j < 3; j++)
                far = fmax(far, fabs(ap_fixed_round(m->m[i][j]).hi - t->symmetry[g].turn.m[i][j]));
        if (far < 1e-9)
            return g;
    }
    return -1;
}

// All symmetries as words of mirrors, the shortest first. False: they are not the tiling's.
static bool group(const struct ap_tiling *t, const struct ap_deep_iso mirror[3],
                  struct ap_deep_iso *turn) {
    bool known[AP_CELL_SYMMETRIES] = {true};
    int list[AP_CELL_SYMMETRIES] = {0}, count = 1;
    turn[0] = ap_deep_identity();
    for (int at = 0; at < count; at++)
        for (int k = 0; k < 3; k++) {
            struct ap_deep_iso next = ap_deep_mul(&mirror[k], &turn[list[at]]);
            int g = symmetry_of(t, &next);
            if (g < 0)
                return false;
            if (known[g])
                continue;
            known[g] = true;
            turn[g] = next;
            list[count++] = g;
        }
    return count == t->symmetry_count;
}

// Reflection in the plane at (C, S) along the unit vector u.
static struct ap_deep_iso reflection(const fx u[3], fx c, fx s) {
    const fx normal[4] = {mul(c, u[0]), mul(c, u[1]), mul(c, u[2]), s};
    struct ap_deep_iso m = ap_deep_identity();
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++) {
            fx both = twice(mul(normal[i], normal[j]));
            m.m[i][j] = j == 3 ? add(m.m[i][j], both) : sub(m.m[i][j], both);
        }
    return m;
}

bool ap_deep_steps(const struct ap_tiling *t, const struct ap_pairing *pairing,
                   struct ap_deep_iso step[AP_CELL_FACES]) {
    struct ap_deep_iso mirror[3];
    struct ap_deep_iso *turn = t->space.kappa < 0 ? malloc(AP_CELL_SYMMETRIES * sizeof *turn) : 0;
    if (!turn)
        return false;
    fx c, s;
    simplex(t->symbol, mirror, &c, &s);
    bool good = group(t, mirror, turn);
    for (int f = 0; good && f < t->face_count; f++) {
        const struct ap_deep_iso *to = &turn[t->turn_to_face[f]];
        const fx u[3] = {neg(to->m[0][1]), neg(to->m[1][1]), neg(to->m[2][1])};
        struct ap_deep_iso plane = reflection(u, c, s);
        step[f] = ap_deep_mul(&plane, &turn[pairing->turn[f]]);
    }
    free(turn);
    return good;
}
