#include "src/game/plane.h"

struct ap_plane_frame ap_plane_mul(const struct ap_plane_frame *a, const struct ap_plane_frame *b) {
    struct ap_plane_frame c;
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++)
            c.m[i][k] = a->m[i][0] * b->m[0][k] + a->m[i][1] * b->m[1][k] + a->m[i][2] * b->m[2][k];
    return c;
}

struct ap_plane_frame ap_plane_translate(struct ap_space space, struct ap_plane2 v) {
    double length = ap_plane2_length(v), t = length / space.rho_m;
    if (!(length > 0))
        return AP_PLANE_FRAME_IDENTITY;
    double x = v.x / length, z = v.z / length;
    double half = ap_space_sin(space, t / 2), s = ap_space_sin(space, t);
    // C − 1 without cancellation.
    double less = -2 * space.kappa * half * half;
    return (struct ap_plane_frame){{{1 + less * x * x, less * x * z, s * x},
                                    {less * x * z, 1 + less * z * z, s * z},
                                    {-space.kappa * s * x, -space.kappa * s * z, 1 + less}}};
}

void ap_plane_orthonormalize(int kappa, struct ap_plane_frame *f) {
    double(*m)[3] = f->m;
    struct ap_plane3 p = {m[0][2], m[1][2], m[2][2]};
    if (kappa) {
        double n = 1 / sqrt(kappa * ap_plane_dot(kappa, p, p));
        p = (struct ap_plane3){n * p.x, n * p.z, n * p.w};
    } else {
        p.w = 1;
    }
    struct ap_plane3 e[2] = {{m[0][0], m[1][0], m[2][0]}, {m[0][1], m[1][1], m[2][1]}};
    for (int i = 0; i < 2; i++) {
        // Off the point, whose square is kappa, then off the first.
        double off = kappa * ap_plane_dot(kappa, e[i], p);
        e[i] = (struct ap_plane3){e[i].x - off * p.x, e[i].z - off * p.z,
                                  kappa ? e[i].w - off * p.w : 0};
        if (i == 1) {
            off = ap_plane_dot(kappa, e[1], e[0]);
            e[1] = (struct ap_plane3){e[1].x - off * e[0].x, e[1].z - off * e[0].z,
                                      e[1].w - off * e[0].w};
        }
        double n = 1 / sqrt(ap_plane_dot(kappa, e[i], e[i]));
        e[i] = (struct ap_plane3){n * e[i].x, n * e[i].z, n * e[i].w};
    }
    for (int i = 0; i < 2; i++) {
        m[0][i] = e[i].x;
        m[1][i] = e[i].z;
        m[2][i] = e[i].w;
    }
    m[0][2] = p.x;
    m[1][2] = p.z;
    m[2][2] = p.w;
}

static const int of_space[3] = {0, 2, 3}; // x, z, w

struct ap_iso ap_plane_lift(const struct ap_plane_frame *f) {
    struct ap_iso m = AP_ISO_IDENTITY;
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++)
            m.m[of_space[i]][of_space[k]] = f->m[i][k];
    return m;
}

struct ap_plane_frame ap_plane_of(const struct ap_iso *m) {
    struct ap_plane_frame f;
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++)
            f.m[i][k] = m->m[of_space[i]][of_space[k]];
    return f;
}

double ap_plane_distance(struct ap_space space, double chord2_m2) {
    double chord = sqrt(fmax(0, chord2_m2)), half = chord / (2 * space.rho_m);
    if (space.kappa > 0)
        return 2 * space.rho_m * asin(fmin(1, half));
    return space.kappa < 0 ? 2 * space.rho_m * asinh(half) : chord;
}

double ap_plane_chord2_of(struct ap_space space, double distance_m) {
    double chord = 2 * space.rho_m * ap_space_sin(space, distance_m / (2 * space.rho_m));
    return chord * chord;
}

double ap_plane_rolling_radius(struct ap_space space, double s_m) {
    double t = s_m / space.rho_m;
    if (space.kappa > 0)
        return space.rho_m * tan(t);
    return space.kappa < 0 ? space.rho_m * tanh(t) : s_m;
}
