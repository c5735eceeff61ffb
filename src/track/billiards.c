#include "src/track/billiards.h"

#include "src/track/motion.h"

// rotY(−90°·turns)·(x, z), exactly.
static void turn_back(int turns, double x, double z, double *across, double *along) {
    switch (turns) {
    case 0:
        *across = x, *along = z;
        break;
    case 1:
        *across = -z, *along = x;
        break;
    case 2:
        *across = -x, *along = -z;
        break;
    default:
        *across = z, *along = -x;
        break;
    }
}

static int modulo(int64_t a, int n) {
    int r = (int)(a % n);
    return r < 0 ? r + n : r;
}

bool ap_perimeter_of(double x, double z, struct ap_perimeter *at) {
    for (int e = 0; e < 4; e++) {
        double across, along;
        turn_back(e, x, z, &across, &along);
        if (along < 0 && across > along && across <= -along) {
            *at = (struct ap_perimeter){e, across, -along};
            return true;
        }
    }
    return false;
}

// The sign of |a|·b − |c|·d, exactly and at any scale; b, d > 0.
static int compare_products(double a, double b, double c, double d) {
    if (a == 0 || c == 0)
        return (a != 0) - (c != 0);
    int ea, eb, ec, ed;
    struct ap_dd left = ap_dd_two_product(frexp(fabs(a), &ea), frexp(b, &eb));
    struct ap_dd right = ap_dd_two_product(frexp(fabs(c), &ec), frexp(d, &ed));
    // Both products are in [¼, 1).
    int shift = ea + eb - ec - ed;
    if (shift > 2 || shift < -2)
        return shift > 0 ? 1 : -1;
    left = ap_dd_scale(ldexp(1, shift), left);
    if (left.hi != right.hi)
        return left.hi > right.hi ? 1 : -1;
    return (left.lo > right.lo) - (left.lo < right.lo);
}

// The sign of the difference of the fractions, ½ − across/(2·out) each.
static int compare_fraction(struct ap_perimeter a, struct ap_perimeter b) {
    int sign_a = (a.across > 0) - (a.across < 0), sign_b = (b.across > 0) - (b.across < 0);
    if (sign_a != sign_b)
        return sign_a < sign_b ? 1 : -1;
    return -sign_a * compare_products(a.across, b.out, b.across, a.out);
}

struct ap_perimeter ap_perimeter_unwrap(struct ap_perimeter reference, struct ap_perimeter at) {
    int ahead = modulo(at.edge - reference.edge, 4);
    // The difference of the coordinates is `ahead` plus that of the fractions, which is in (−1, 1);
    // it belongs into (−2, 2].
    if (ahead == 3 || (ahead == 2 && compare_fraction(at, reference) > 0))
        ahead -= 4;
    at.edge = reference.edge + ahead;
    return at;
}

// (cos, sin)(2·pi·k/n).
static void turn_of(int k, int n, struct ap_dd *cosine, struct ap_dd *sine) {
    struct ap_dd root3 = ap_dd_sqrt(ap_dd_of(3)), root5 = ap_dd_sqrt(ap_dd_of(5));
    *cosine = ap_dd_of(k == 0);
    *sine = ap_dd_of(0);
    if (k == 0)
        return;
    int mirror = 2 * k > n ? n - k : k;
    if (n == 3) {
        *cosine = ap_dd_of(-0.5);
        *sine = ap_dd_scale(0.5, root3);
    } else if (n == 4) {
        *cosine = ap_dd_of(mirror == 2 ? -1 : 0);
        *sine = ap_dd_of(mirror == 2 ? 0 : 1);
    } else {
        struct ap_dd sign = ap_dd_of(mirror == 1 ? 1 : -1);
        *cosine = ap_dd_scale(0.25, ap_dd_add(ap_dd_mul(sign, root5), ap_dd_of(-1)));
        *sine = ap_dd_add(ap_dd_of(10), ap_dd_mul(ap_dd_scale(2, sign), root5));
        *sine = ap_dd_scale(0.25, ap_dd_sqrt(*sine));
    }
    if (mirror != k)
        *sine = ap_dd_neg(*sine);
}

// (C, S) of inradius/rho: cos(pi/4)/sin(pi/n) and the leg that goes with it.
static void inradius_of(struct ap_space space, double edge_m, struct ap_dd *c, struct ap_dd *s) {
    if (space.kappa == 0) {
        *c = ap_dd_of(1);
        *s = ap_dd_div(ap_dd_of(edge_m / 2), ap_dd_of(space.rho_m));
    } else if (space.kappa > 0) { // c² = 2/3
        struct ap_dd third = ap_dd_div(ap_dd_of(1), ap_dd_of(3));
        *c = ap_dd_sqrt(ap_dd_scale(2, third));
        *s = ap_dd_sqrt(third);
    } else { // c² = ½/sin²36° = 8/(10 − 2·√5)
        struct ap_dd below = ap_dd_sub(ap_dd_of(10), ap_dd_scale(2, ap_dd_sqrt(ap_dd_of(5))));
        struct ap_dd square = ap_dd_div(ap_dd_of(8), below);
        *c = ap_dd_sqrt(square);
        *s = ap_dd_sqrt(ap_dd_sub(square, ap_dd_of(1)));
    }
}

static void put(struct ap_wide_iso *m, int i, int j, struct ap_dd a) {
    m->hi.m[i][j] = a.hi;
    m->lo.m[i][j] = a.lo;
}

void ap_billiards_init(struct ap_space space, double edge_m, double height_m,
                       struct ap_billiards *table) {
    struct ap_dd c, s, cosine, sine;
    *table = (struct ap_billiards){space, edge_m, height_m, 4 - space.kappa, {{{{{0}}}, {{{0}}}}}};
    inradius_of(space, edge_m, &c, &s);
    for (int k = 0; k < table->sides; k++) {
        // rotY(a)·translate(0, 0, −inradius), written out.
        struct ap_wide_iso *m = &table->world_from_edge[k];
        turn_of(k, table->sides, &cosine, &sine);
        *m = ap_wide_identity();
        put(m, 0, 0, cosine);
        put(m, 0, 2, ap_dd_mul(sine, c));
        put(m, 0, 3, ap_dd_neg(ap_dd_mul(sine, s)));
        put(m, 2, 0, ap_dd_neg(sine));
        put(m, 2, 2, ap_dd_mul(cosine, c));
        put(m, 2, 3, ap_dd_neg(ap_dd_mul(cosine, s)));
        put(m, 3, 2, ap_dd_scale(space.kappa, s));
        put(m, 3, 3, c);
    }
}

// rotY(−90°·turns)·r, exactly.
static void turn_rows_back(int turns, struct ap_dd r[3][3]) {
    for (; turns > 0; turns--)
        for (int j = 0; j < 3; j++) {
            struct ap_dd x = r[0][j];
            r[0][j] = ap_dd_neg(r[2][j]);
            r[2][j] = x;
        }
}

struct ap_iso ap_billiards_place(const struct ap_billiards *table, struct ap_perimeter c,
                                 struct ap_pose pose) {
    int turns = modulo(c.edge, 4);
    struct ap_vec3 origin = {0, table->height_m, 0};
    struct ap_motion motion = ap_motion_from(origin, pose);
    double across, along;
    turn_back(turns, pose.p.x, pose.p.z, &across, &along);
    // The anchor stands at (−s, −L/2): −s is the same fraction of L/2 as across is of out.
    struct ap_dd half = ap_dd_of(table->edge_m / 2);
    struct ap_dd side = ap_dd_mul(half, ap_dd_div(ap_dd_of(c.across), ap_dd_of(c.out)));
    motion.p_m[0] = ap_dd_sub(ap_dd_of(across), side);
    motion.p_m[2] = ap_dd_add(ap_dd_of(along), half);
    turn_rows_back(turns, motion.r);

    struct ap_wide_iso place = table->world_from_edge[modulo(c.edge, table->sides)];
    struct ap_dd to_anchor[3] = {side, ap_dd_of(0), ap_dd_of(0)};
    ap_wide_translate(table->space, to_anchor, &place);
    ap_wide_move(table->space, &motion, &place);
    return place.hi;
}
