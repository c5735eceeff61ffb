#include "src/geom/arc.h"
#include "src/geom/isometry.h"

// A product of translations cancels where the walk comes back (h3: factors of e^t on both sides),
// so it is carried in double-double and rounded once.

struct matrix_dd {
    struct ap_dd m[4][4];
};

static struct matrix_dd translation(struct ap_space space, struct ap_vec3 v_m) {
    struct matrix_dd m = {{{{0, 0}}}};
    for (int i = 0; i < 4; i++)
        m.m[i][i] = ap_dd_of(1);
    struct ap_dd t = ap_arc_of(space, v_m).t, unit[3], s, c_minus_1;
    if (!(t.hi > 0))
        return m;
    ap_turn_dd(space, t, &s, &c_minus_1);
    ap_unit_dd(v_m, unit);
    for (int i = 0; i < 3; i++) {
        for (int j = 0; space.kappa && j < 3; j++)
            m.m[i][j] = ap_dd_add(m.m[i][j], ap_dd_mul(c_minus_1, ap_dd_mul(unit[i], unit[j])));
        m.m[i][3] = ap_dd_mul(s, unit[i]);
        m.m[3][i] = ap_dd_scale(-space.kappa, m.m[i][3]);
    }
    m.m[3][3] = ap_dd_add(c_minus_1, ap_dd_of(1));
    return m;
}

static struct matrix_dd product(const struct matrix_dd *a, const struct matrix_dd *b) {
    struct matrix_dd out;
    for (int i = 0; i < 4; i++) {
        for (int j = 0; j < 4; j++) {
            struct ap_dd sum = ap_dd_mul(a->m[i][0], b->m[0][j]);
            for (int k = 1; k < 4; k++)
                sum = ap_dd_add(sum, ap_dd_mul(a->m[i][k], b->m[k][j]));
            out.m[i][j] = sum;
        }
    }
    return out;
}

struct ap_iso ap_iso_walk(struct ap_space space, const struct ap_vec3 *steps_m, size_t count) {
    struct matrix_dd all = translation(space, (struct ap_vec3){0, 0, 0});
    for (size_t i = 0; i < count; i++) {
        struct matrix_dd step = translation(space, steps_m[i]);
        all = product(&all, &step);
    }
    struct ap_iso m;
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++)
            m.m[i][j] = all.m[i][j].hi;
    return m;
}
