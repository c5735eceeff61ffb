#include "tests/track/exact.h"

#include <assert.h>
#include <math.h>
#include <mpfr.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// Numbers of one sample come from a pool that the next sample reuses, so that formulas can be
// written as formulas.
typedef mpfr_ptr real;

enum { BITS = 448, POOL = 16384, DEVICES = 8 };

static mpfr_t pool[POOL];
static int pool_used, pool_made;

static real fresh(void) {
    assert(pool_used < POOL);
    if (pool_used == pool_made)
        mpfr_init2(pool[pool_made++], BITS);
    return pool[pool_used++];
}

static real num(double a) {
    real r = fresh();
    mpfr_set_d(r, a, MPFR_RNDN);
    return r;
}

#define BINARY(name, function)                                                                     \
    static real name(mpfr_srcptr a, mpfr_srcptr b) {                                               \
        real r = fresh();                                                                          \
        function(r, a, b, MPFR_RNDN);                                                              \
        return r;                                                                                  \
    }
#define UNARY(name, function)                                                                      \
    static real name(mpfr_srcptr a) {                                                              \
        real r = fresh();                                                                          \
        function(r, a, MPFR_RNDN);                                                                 \
        return r;                                                                                  \
    }
BINARY(add, mpfr_add)
BINARY(sub, mpfr_sub)
BINARY(mul, mpfr_mul)
BINARY(quo, mpfr_div)
UNARY(root, mpfr_sqrt)
UNARY(neg, mpfr_neg)
UNARY(cosine, mpfr_cos)
UNARY(sine, mpfr_sin)
UNARY(hcosine, mpfr_cosh)
UNARY(hsine, mpfr_sinh)
UNARY(arccos, mpfr_acos)
UNARY(arcosh, mpfr_acosh)

static real pi_times(double a) {
    real r = fresh();
    mpfr_const_pi(r, MPFR_RNDN);
    return mul(r, num(a));
}

struct vec {
    real x[3];
};

struct quat {
    real x, y, z, w;
};

struct mat {
    real m[4][4];
};

// What outlives a sample.
struct kept {
    bool used;
    char name[32];
    mpfr_t p[3], q[4], v[16];
};

struct exact {
    struct ap_tracker_params params;
    struct kept devices[DEVICES];
    struct kept head;
    mpfr_t c, own_c;
    bool has_head;
    mpfr_t row[16];
};

static struct vec vec(real x, real y, real z) {
    return (struct vec){{x, y, z}};
}

static struct quat quat_mul(struct quat a, struct quat b) {
    struct quat r;
    r.w = sub(sub(sub(mul(a.w, b.w), mul(a.x, b.x)), mul(a.y, b.y)), mul(a.z, b.z));
    r.x = sub(add(add(mul(a.w, b.x), mul(a.x, b.w)), mul(a.y, b.z)), mul(a.z, b.y));
    r.y = add(add(sub(mul(a.w, b.y), mul(a.x, b.z)), mul(a.y, b.w)), mul(a.z, b.x));
    r.z = add(sub(add(mul(a.w, b.z), mul(a.x, b.y)), mul(a.y, b.x)), mul(a.z, b.w));
    return r;
}

static struct quat conjugate(struct quat q) {
    return (struct quat){neg(q.x), neg(q.y), neg(q.z), q.w};
}

static struct quat quat_of(struct ap_quat a) {
    struct quat q = {num(a.x), num(a.y), num(a.z), num(a.w)};
    real n = root(add(add(mul(q.x, q.x), mul(q.y, q.y)), add(mul(q.z, q.z), mul(q.w, q.w))));
    return (struct quat){quo(q.x, n), quo(q.y, n), quo(q.z, n), quo(q.w, n)};
}

static struct vec turned(struct quat q, struct vec v) {
    struct quat r =
        quat_mul(quat_mul(q, (struct quat){v.x[0], v.x[1], v.x[2], num(0)}), conjugate(q));
    return vec(r.x, r.y, r.z);
}

static struct vec minus(struct vec a, struct vec b) {
    return vec(sub(a.x[0], b.x[0]), sub(a.x[1], b.x[1]), sub(a.x[2], b.x[2]));
}

static struct mat identity(void) {
    struct mat m;
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++)
            m.m[i][j] = num(i == j);
    return m;
}

static struct mat times(struct mat a, struct mat b) {
    struct mat r;
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++) {
            r.m[i][j] = num(0);
            for (int k = 0; k < 4; k++)
                r.m[i][j] = add(r.m[i][j], mul(a.m[i][k], b.m[k][j]));
        }
    return r;
}

static struct mat translate(struct ap_space space, struct vec v) {
    struct mat m = identity();
    real n = root(add(add(mul(v.x[0], v.x[0]), mul(v.x[1], v.x[1])), mul(v.x[2], v.x[2])));
    if (mpfr_zero_p(n))
        return m;
    real t = quo(n, num(space.rho_m));
    real c = space.kappa > 0 ? cosine(t) : space.kappa < 0 ? hcosine(t) : num(1);
    real s = space.kappa > 0 ? sine(t) : space.kappa < 0 ? hsine(t) : t;
    for (int i = 0; i < 3; i++) {
        real u = quo(v.x[i], n);
        for (int j = 0; j < 3; j++)
            m.m[i][j] = add(m.m[i][j], mul(sub(c, num(1)), mul(u, quo(v.x[j], n))));
        m.m[i][3] = mul(s, u);
        m.m[3][i] = mul(num(-space.kappa), mul(s, u));
    }
    m.m[3][3] = c;
    return m;
}

static struct mat rotate(struct quat q) {
    struct mat m = identity();
    for (int j = 0; j < 3; j++) {
        struct vec e = turned(q, vec(num(j == 0), num(j == 1), num(j == 2)));
        for (int i = 0; i < 3; i++)
            m.m[i][j] = e.x[i];
    }
    return m;
}

static struct quat about_y(real angle) {
    real half = quo(angle, num(2));
    return (struct quat){num(0), sine(half), num(0), cosine(half)};
}

static void kept_init(struct kept *kept) {
    for (int i = 0; i < 3; i++)
        mpfr_init2(kept->p[i], BITS);
    for (int i = 0; i < 4; i++)
        mpfr_init2(kept->q[i], BITS);
    for (int i = 0; i < 16; i++)
        mpfr_init2(kept->v[i], BITS);
}

static void kept_finish(struct kept *kept) {
    for (int i = 0; i < 3; i++)
        mpfr_clear(kept->p[i]);
    for (int i = 0; i < 4; i++)
        mpfr_clear(kept->q[i]);
    for (int i = 0; i < 16; i++)
        mpfr_clear(kept->v[i]);
}

struct exact *exact_create(const struct ap_tracker_params *params) {
    struct exact *x = calloc(1, sizeof *x);
    assert(x);
    x->params = *params;
    for (int i = 0; i < DEVICES; i++)
        kept_init(&x->devices[i]);
    kept_init(&x->head);
    mpfr_init2(x->c, BITS);
    mpfr_init2(x->own_c, BITS);
    mpfr_set_d(x->c, 0.5, MPFR_RNDN);
    for (int i = 0; i < 16; i++)
        mpfr_init2(x->row[i], BITS);
    return x;
}

void exact_destroy(struct exact *x) {
    if (!x)
        return;
    for (int i = 0; i < DEVICES; i++)
        kept_finish(&x->devices[i]);
    kept_finish(&x->head);
    mpfr_clear(x->c);
    mpfr_clear(x->own_c);
    for (int i = 0; i < 16; i++)
        mpfr_clear(x->row[i]);
    free(x);
    for (int i = 0; i < pool_made; i++)
        mpfr_clear(pool[i]);
    pool_made = pool_used = 0;
    mpfr_free_cache();
}

static void give_row(struct exact *x, struct mat m) {
    for (int i = 0; i < 16; i++)
        mpfr_set(x->row[i], m.m[i / 4][i % 4], MPFR_RNDN);
}

static struct mat kept_mat(struct kept *k) {
    struct mat m;
    for (int i = 0; i < 16; i++)
        m.m[i / 4][i % 4] = k->v[i];
    return m;
}

// V·translate(dp)·rotate(dq), (dp, dq) the pose in the kept one's frame.
static struct mat beside(struct exact *x, struct kept *k, struct vec p, struct quat q) {
    struct quat back = conjugate((struct quat){k->q[0], k->q[1], k->q[2], k->q[3]});
    struct vec dp = turned(back, minus(p, vec(k->p[0], k->p[1], k->p[2])));
    struct mat m = times(kept_mat(k), translate(x->params.space, dp));
    return times(m, rotate(quat_mul(back, q)));
}

// The integrating device: naive's all, anchor's head.
static void integrate(struct exact *x, struct kept *k, struct vec p, struct quat q) {
    struct mat m = k->used ? beside(x, k, p, q) : times(translate(x->params.space, p), rotate(q));
    give_row(x, m);
    k->used = true;
    for (int i = 0; i < 16; i++)
        mpfr_set(k->v[i], x->row[i], MPFR_RNDN);
    for (int i = 0; i < 3; i++)
        mpfr_set(k->p[i], p.x[i], MPFR_RNDN);
    const real parts[4] = {q.x, q.y, q.z, q.w};
    for (int i = 0; i < 4; i++)
        mpfr_set(k->q[i], parts[i], MPFR_RNDN);
}

static struct kept *device_of(struct exact *x, const char *name) {
    for (int i = 0; i < DEVICES; i++) {
        struct kept *k = &x->devices[i];
        if (!k->used)
            snprintf(k->name, sizeof k->name, "%s", name);
        if (strcmp(k->name, name) == 0)
            return k;
    }
    abort();
}

// Edge e: outward (nx, nz), counterclockwise from above (tx, tz).
static const int normals[4][2] = {{0, -1}, {-1, 0}, {0, 1}, {1, 0}};
static const int tangents[4][2] = {{-1, 0}, {0, 1}, {1, 0}, {0, -1}};

// In [0, 4), from the point where the ray meets the square of edge 2.
static real perimeter(struct vec p) {
    real x = p.x[0], z = p.x[2];
    real far = mpfr_cmpabs(x, z) > 0 ? x : z;
    far = mpfr_signbit(far) ? neg(far) : far;
    for (int e = 0; e < 4; e++) {
        real out = add(mul(num(normals[e][0]), x), mul(num(normals[e][1]), z));
        real along = add(mul(num(tangents[e][0]), x), mul(num(tangents[e][1]), z));
        // The end of an edge is the beginning of the next.
        if (mpfr_equal_p(out, far) && mpfr_less_p(along, far))
            return add(num(e + 0.5), quo(quo(along, far), num(2)));
    }
    abort();
}

// c + 4k nearest to the reference, a tie upward. Quotients carry 256 bits: two that ought to be
// equal differ by less than 2^-200.
static real nearest(real c, mpfr_srcptr reference) {
    real k = quo(sub(sub(reference, c), num(2)), num(4)), whole = fresh();
    mpfr_rint(whole, k, MPFR_RNDN);
    real miss = sub(k, whole);
    if (!mpfr_zero_p(miss) && mpfr_get_exp(miss) > -200)
        mpfr_rint(whole, k, MPFR_RNDD);
    return add(c, mul(num(4), add(whole, num(1))));
}

static long wrapped(long a, long n) {
    return ((a % n) + n) % n;
}

static struct mat billiards(struct exact *x, mpfr_srcptr c, struct vec p, struct quat q) {
    const struct ap_space space = x->params.space;
    int n = space.kappa > 0 ? 3 : space.kappa < 0 ? 5 : 4;
    real floor_c = fresh(), edge = num(x->params.table_edge_m), rho = num(space.rho_m);
    mpfr_rint(floor_c, c, MPFR_RNDD);
    long e = mpfr_get_si(floor_c, MPFR_RNDN);
    real s = mul(sub(sub(c, floor_c), num(0.5)), edge);
    struct quat turn = about_y(pi_times(0.5 * (double)wrapped(e, 4)));
    struct vec anchor = turned(turn, vec(neg(s), num(0), neg(quo(edge, num(2)))));
    struct vec d = turned(conjugate(turn), minus(p, anchor));
    struct quat r = quat_mul(conjugate(turn), q);
    real ratio = quo(cosine(pi_times(0.25)), sine(quo(pi_times(1), num(n))));
    real inradius = space.kappa > 0   ? mul(rho, arccos(ratio))
                    : space.kappa < 0 ? mul(rho, arcosh(ratio))
                                      : quo(edge, num(2));
    struct mat m = rotate(about_y(quo(pi_times(2.0 * (double)wrapped(e, n)), num(n))));
    m = times(m, translate(space, vec(num(0), num(0), neg(inradius))));
    m = times(m, translate(space, vec(neg(s), num(0), num(0))));
    return times(times(m, translate(space, d)), rotate(r));
}

static void feed_billiards(struct exact *x, bool is_head, struct vec p, struct quat q) {
    if (mpfr_zero_p(p.x[0]) && mpfr_zero_p(p.x[2]))
        mpfr_set(x->own_c, x->c, MPFR_RNDN);
    else if (is_head && !x->has_head)
        mpfr_set(x->own_c, perimeter(p), MPFR_RNDN);
    else
        mpfr_set(x->own_c, nearest(perimeter(p), x->c), MPFR_RNDN);
    if (is_head)
        mpfr_set(x->c, x->own_c, MPFR_RNDN);
    give_row(x, billiards(x, x->own_c, p, q));
}

bool exact_feed(struct exact *x, const char *device, struct ap_pose pose) {
    pool_used = 0;
    bool is_head = strcmp(device, "head") == 0;
    enum ap_tracker_kind kind = x->params.kind;
    if (kind != AP_TRACKER_NAIVE && !is_head && !x->has_head)
        return false;
    struct quat q = quat_of(pose.q);
    struct vec p =
        vec(num(pose.p.x), sub(num(pose.p.y), num(x->params.table_height_m)), num(pose.p.z));
    if (kind == AP_TRACKER_NAIVE)
        integrate(x, device_of(x, device), p, q);
    else if (kind == AP_TRACKER_BILLIARDS)
        feed_billiards(x, is_head, p, q);
    else if (is_head)
        integrate(x, &x->head, p, q);
    else
        give_row(x, beside(x, &x->head, p, q));
    x->has_head |= is_head;
    return true;
}

double exact_error(const struct exact *x, const struct ap_iso *m) {
    mpfr_t d;
    mpfr_init2(d, BITS);
    double worst = 0;
    for (int i = 0; i < 16; i++) {
        mpfr_sub_d(d, x->row[i], m->m[i / 4][i % 4], MPFR_RNDN);
        double miss = mpfr_get_d(d, MPFR_RNDA);
        if (!(fabs(miss) <= worst))
            worst = fabs(miss);
    }
    mpfr_clear(d);
    double size = 1;
    for (int i = x->params.space.kappa == 0 ? 0 : 15; i < 16; i++)
        size = fmax(size, fabs(mpfr_get_d(x->row[i], MPFR_RNDA)));
    return worst / size;
}

double exact_coordinate(const struct exact *x) {
    return mpfr_get_d(x->own_c, MPFR_RNDN);
}

static void keep_head(struct exact *x, struct mat m) {
    give_row(x, m);
    for (int i = 0; i < 16; i++)
        mpfr_set(x->head.v[i], x->row[i], MPFR_RNDN);
}

// The dodecahedron's normal nearest to `out`: a pole, or 1/√5 up or down and at a multiple of 18°.
static struct vec normal_near(struct ap_vec3 out) {
    if (fabs(out.y) > 0.9)
        return vec(num(0), num(out.y > 0 ? 1 : -1), num(0));
    real five = root(num(5)), flat = quo(num(2), five);
    real turn = quo(pi_times(round(atan2(out.z, out.x) / (M_PI / 10))), num(10));
    return vec(mul(flat, cosine(turn)), quo(num(out.y > 0 ? 1 : -1), five), mul(flat, sine(turn)));
}

void exact_cross_534(struct exact *x, struct ap_vec3 out) {
    pool_used = 0;
    // Neighbouring planes, (C·u, S) and (C·v, S) with u·v = 1/√5, meet at a right angle:
    // C²/√5 = S².
    real five = root(num(5)), cosine_between = quo(num(1), five);
    real s2 = quo(cosine_between, sub(num(1), cosine_between));
    real s = root(s2), c = root(add(num(1), s2));
    struct vec u = normal_near(out);
    const real n[4] = {mul(c, u.x[0]), mul(c, u.x[1]), mul(c, u.x[2]), s};
    struct mat m = identity();
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++) {
            real both = mul(num(j == 3 ? 2 : -2), mul(n[i], n[j]));
            m.m[i][j] = add(m.m[i][j], both);
        }
    keep_head(x, times(m, kept_mat(&x->head)));
}

double exact_miss(const struct exact *x, const struct ap_iso *high, const struct ap_iso *low) {
    pool_used = 0;
    struct mat m, back;
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++) {
            bool minus_one = (i == 3) != (j == 3);
            back.m[i][j] = fresh();
            mpfr_mul_si(back.m[i][j], x->row[4 * j + i], minus_one ? -1 : 1, MPFR_RNDN);
            m.m[i][j] = add(num(high->m[i][j]), num(low ? low->m[i][j] : 0));
        }
    m = times(back, m);
    double worst = 0;
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++) {
            double miss = fabs(mpfr_get_d(sub(m.m[i][j], num(i == j)), MPFR_RNDA));
            worst = miss > worst || isnan(miss) ? miss : worst;
        }
    return worst;
}

double exact_distance(const struct exact *x) {
    pool_used = 0;
    return mpfr_get_d(arcosh(x->row[15]), MPFR_RNDN);
}
