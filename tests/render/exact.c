#include "tests/render/exact.h"

#include <math.h>

static const double PI = 3.14159265358979323846;

double exact_uniform(struct exact_random *random, double low, double high) {
    random->seed = random->seed * 6364136223846793005u + 1442695040888963407u;
    return low + (high - low) * (double)(random->seed >> 11) / 9007199254740992.0;
}

struct ap_viewer exact_viewer(struct exact_random *r, int kappa, enum ap_view_mode mode) {
    struct ap_viewer v = {.space = {kappa, exp(exact_uniform(r, log(0.5), log(3)))},
                          .mode = mode,
                          .world_from_nose = AP_ISO_IDENTITY};
    for (int e = 0; e < 2; e++) {
        v.eye[e].view_from_eye = AP_POSE_IDENTITY;
        struct ap_vec3 *p = &v.eye[e].view_from_eye.p;
        p->x = e ? 0.032 : -0.032;
        p->y = exact_uniform(r, -0.01, 0.01);
        p->z = exact_uniform(r, -0.02, 0.02);
        v.eye[e].view_from_eye.q =
            ap_quat_from_axis_angle((struct ap_vec3){0, 1, 0}, exact_uniform(r, -0.1, 0.1));
        v.eye[e].frustum = (struct ap_frustum){-1.2, 1.0, 1.1, -1.1};
    }
    return v;
}

bool exact_project(const struct ap_viewer *v, const uint32_t size_px[2], int e,
                   struct ap_vec3 tangent_m, double px[2]) {
    const struct ap_frustum *f = &v->eye[e].frustum;
    struct ap_eye_point p = ap_eye_from_tangent(&v->eye[e], (struct ap_tangent_point){tangent_m});
    double a = p.x.x / -p.x.z, b = p.x.y / -p.x.z;
    px[0] = size_px[0] * (a - f->left) / (f->right - f->left);
    px[1] = size_px[1] * (f->up - b) / (f->up - f->down);
    return p.x.z < 0 && ap_vec3_length(p.x) > AP_NEAR_M && a > f->left && a < f->right &&
           b > f->down && b < f->up;
}

// Along the geodesic y goes as C·n.y + S·v.y.
bool exact_on_plane(struct ap_space space, const struct ap_iso *part_from_nose, struct ap_vec3 u,
                    double d_flat_m, struct ap_vec3 *at_m) {
    const double(*m)[4] = part_from_nose->m;
    double n = m[1][3], w = m[1][0] * u.x + m[1][1] * u.y + m[1][2] * u.z, rho = space.rho_m;
    double t = space.kappa > 0 ? atan2(-n, w) : space.kappa < 0 ? atanh(-n / w) : -n / w;
    if (space.kappa > 0)
        t += PI * round((d_flat_m / rho - t) / PI);
    *at_m = ap_vec3_scale(t * rho, u);
    return isfinite(t) && t > 0;
}
