#include "src/geom/isometry.h"

#include "src/geom/arc.h"

const struct ap_iso AP_ISO_IDENTITY = {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}}};

struct ap_iso ap_iso_translate(struct ap_space space, struct ap_vec3 v_m) {
    struct ap_iso m = AP_ISO_IDENTITY;
    if (space.kappa == 0) {
        m.m[0][3] = v_m.x / space.rho_m;
        m.m[1][3] = v_m.y / space.rho_m;
        m.m[2][3] = v_m.z / space.rho_m;
        return m;
    }
    struct ap_arc arc = ap_arc_of(space, v_m);
    struct ap_turn turn = ap_turn_of(space, arc.t);
    const double u[3] = {arc.unit.x, arc.unit.y, arc.unit.z};
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++)
            m.m[i][j] += turn.c_minus_1 * (u[i] * u[j]);
        m.m[i][3] = turn.s * u[i];
        m.m[3][i] = -space.kappa * m.m[i][3];
    }
    m.m[3][3] = turn.c;
    return m;
}

struct ap_iso ap_iso_rotate(struct ap_quat q) {
    double xx = q.x * q.x, yy = q.y * q.y, zz = q.z * q.z;
    double xy = q.x * q.y, yz = q.y * q.z, zx = q.z * q.x;
    double wx = q.w * q.x, wy = q.w * q.y, wz = q.w * q.z;
    return (struct ap_iso){{{1 - 2 * (yy + zz), 2 * (xy - wz), 2 * (zx + wy), 0},
                            {2 * (xy + wz), 1 - 2 * (zz + xx), 2 * (yz - wx), 0},
                            {2 * (zx - wy), 2 * (yz + wx), 1 - 2 * (xx + yy), 0},
                            {0, 0, 0, 1}}};
}

struct ap_iso ap_iso_rotate_y(double angle_rad) {
    double c = cos(angle_rad), s = sin(angle_rad);
    return (struct ap_iso){{{c, 0, s, 0}, {0, 1, 0, 0}, {-s, 0, c, 0}, {0, 0, 0, 1}}};
}

struct ap_iso ap_iso_from_pose(struct ap_space space, struct ap_pose pose) {
    return ap_iso_mul(ap_iso_translate(space, pose.p), ap_iso_rotate(pose.q));
}

struct ap_iso ap_iso_mul(struct ap_iso a_from_b, struct ap_iso b_from_c) {
    struct ap_iso product;
    for (int i = 0; i < 4; i++) {
        const double *row = a_from_b.m[i];
        for (int j = 0; j < 4; j++)
            product.m[i][j] = row[0] * b_from_c.m[0][j] + row[1] * b_from_c.m[1][j] +
                              row[2] * b_from_c.m[2][j] + row[3] * b_from_c.m[3][j];
    }
    return product;
}

static struct ap_iso rigid_inverse(struct ap_iso m) {
    struct ap_iso inverse = AP_ISO_IDENTITY;
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++)
            inverse.m[i][j] = m.m[j][i];
        inverse.m[i][3] = -(m.m[0][i] * m.m[0][3] + m.m[1][i] * m.m[1][3] + m.m[2][i] * m.m[2][3]);
    }
    return inverse;
}

struct ap_iso ap_iso_inverse(struct ap_space space, struct ap_iso m) {
    if (space.kappa == 0)
        return rigid_inverse(m);
    struct ap_iso inverse;
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++)
            inverse.m[i][j] = (i == 3) != (j == 3) ? space.kappa * m.m[j][i] : m.m[j][i];
    return inverse;
}

struct ap_vec4 ap_iso_apply(const struct ap_iso *a_from_b, struct ap_vec4 p) {
    const double(*m)[4] = a_from_b->m;
    return (struct ap_vec4){m[0][0] * p.x + m[0][1] * p.y + m[0][2] * p.z + m[0][3] * p.w,
                            m[1][0] * p.x + m[1][1] * p.y + m[1][2] * p.z + m[1][3] * p.w,
                            m[2][0] * p.x + m[2][1] * p.y + m[2][2] * p.z + m[2][3] * p.w,
                            m[3][0] * p.x + m[3][1] * p.y + m[3][2] * p.z + m[3][3] * p.w};
}

// The form of two columns in double-double: far out in h3 it is a small difference of squares of
// e^t, and a plain sum would measure its own rounding.
static struct ap_dd form(const struct ap_iso *m, int a, int b, double weight) {
    struct ap_dd sum = ap_dd_scale(weight, ap_dd_two_product(m->m[3][a], m->m[3][b]));
    for (int i = 0; i < 3; i++)
        sum = ap_dd_add(sum, ap_dd_two_product(m->m[i][a], m->m[i][b]));
    return sum;
}

double ap_iso_defect(struct ap_space space, const struct ap_iso *m) {
    double worst = 0;
    int columns = space.kappa ? 4 : 3;
    for (int a = 0; a < columns; a++) {
        for (int b = a; b < columns; b++) {
            double expected = a != b ? 0 : a == 3 ? space.kappa : 1;
            struct ap_dd got = form(m, a, b, space.kappa);
            worst = fmax(worst, fabs(ap_dd_add(got, ap_dd_of(-expected)).hi));
        }
    }
    for (int j = 0; space.kappa == 0 && j < 4; j++)
        worst = fmax(worst, fabs(m->m[3][j] - (j == 3)));
    return worst;
}

static void scale_column(struct ap_iso *m, int column, double by) {
    for (int i = 0; i < 4; i++)
        m->m[i][column] *= by;
}

static void subtract_column(struct ap_iso *m, int from, double by, int column) {
    for (int i = 0; i < 4; i++)
        m->m[i][from] -= by * m->m[i][column];
}

struct ap_iso ap_iso_orthonormalize(struct ap_space space, struct ap_iso m) {
    static const int order[4] = {3, 0, 1, 2};
    int first = space.kappa ? 0 : 1;
    if (space.kappa == 0)
        for (int j = 0; j < 4; j++)
            m.m[3][j] = j == 3;
    for (int k = first; k < 4; k++) {
        for (int done = first; done < k; done++) {
            double sign = order[done] == 3 ? space.kappa : 1;
            double overlap = form(&m, order[k], order[done], space.kappa).hi;
            subtract_column(&m, order[k], sign * overlap, order[done]);
        }
        scale_column(&m, order[k], 1 / sqrt(fabs(form(&m, order[k], order[k], space.kappa).hi)));
    }
    return m;
}
