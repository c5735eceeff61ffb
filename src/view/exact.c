#include "src/view/exact.h"

#include <math.h>

static const double PI = 3.14159265358979323846;

bool ap_exact_pixel_at(const struct ap_view_eye *eye, const uint32_t size_px[2], struct ap_vec3 at,
                       double px[2]) {
    const struct ap_frustum *f = &eye->frustum;
    double a = at.x / -at.z, b = at.y / -at.z;
    px[0] = size_px[0] * (a - f->left) / (f->right - f->left);
    px[1] = size_px[1] * (f->up - b) / (f->up - f->down);
    return at.z < 0 && ap_vec3_length(at) > AP_NEAR_M && a > f->left && a < f->right &&
           b > f->down && b < f->up;
}

bool ap_exact_pixel(const struct ap_viewer *viewer, const uint32_t size_px[2], int eye,
                    struct ap_vec3 tangent_m, double px[2]) {
    const struct ap_view_eye *of = &viewer->eye[eye];
    return ap_exact_pixel_at(of, size_px,
                             ap_eye_from_tangent(of, (struct ap_tangent_point){tangent_m}).x, px);
}

bool ap_exact_on_plane(struct ap_space space, const struct ap_iso *part_from_nose, struct ap_vec3 u,
                       double d_flat_m, struct ap_vec3 *tangent_m) {
    const double(*m)[4] = part_from_nose->m;
    double n = m[1][3], w = m[1][0] * u.x + m[1][1] * u.y + m[1][2] * u.z, rho = space.rho_m;
    double t = space.kappa > 0 ? atan2(-n, w) : space.kappa < 0 ? atanh(-n / w) : -n / w;
    if (space.kappa > 0)
        t += PI * round((d_flat_m / rho - t) / PI);
    *tangent_m = ap_vec3_scale(t * rho, u);
    return isfinite(t) && t > 0;
}

static double to_segment(const double q[2], const double a[2], const double b[2]) {
    double d[2] = {b[0] - a[0], b[1] - a[1]}, o[2] = {q[0] - a[0], q[1] - a[1]};
    double square = d[0] * d[0] + d[1] * d[1];
    double t = square > 0 ? fmin(fmax((d[0] * o[0] + d[1] * o[1]) / square, 0), 1) : 0;
    return hypot(o[0] - t * d[0], o[1] - t * d[1]);
}

double ap_exact_outside(const double q[2], const double a[2], const double b[2],
                        const double c[2]) {
    const double *corner[4] = {a, b, c, a};
    double least = INFINITY, area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    bool in = true;
    for (int k = 0; k < 3; k++) {
        const double *p = corner[k], *n = corner[k + 1];
        in = in && (n[0] - p[0]) * (q[1] - p[1]) - (n[1] - p[1]) * (q[0] - p[0]) <= 0;
        least = fmin(least, to_segment(q, p, n));
    }
    return area >= 0 ? INFINITY : in ? 0 : least;
}
