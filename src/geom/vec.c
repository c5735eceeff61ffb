#include "src/geom/vec.h"

// hot: what every frame of a runtime calls lies side by side, for the caches are cold then
// (docs/performance.md).
__attribute__((hot)) struct ap_quat ap_quat_mul(struct ap_quat a, struct ap_quat b) {
    return (struct ap_quat){a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
                            a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
                            a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w,
                            a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z};
}

__attribute__((hot)) struct ap_quat ap_quat_normalize(struct ap_quat q) {
    double n = hypot(hypot(q.x, q.y), hypot(q.z, q.w));
    return (struct ap_quat){q.x / n, q.y / n, q.z / n, q.w / n};
}

// v + 2w(u×v) + 2u×(u×v): the small rotations keep their small differences.
__attribute__((hot)) struct ap_vec3 ap_quat_rotate(struct ap_quat q, struct ap_vec3 v) {
    struct ap_vec3 u = {q.x, q.y, q.z};
    struct ap_vec3 t = ap_vec3_scale(2, ap_vec3_cross(u, v));
    return ap_vec3_add(v, ap_vec3_add(ap_vec3_scale(q.w, t), ap_vec3_cross(u, t)));
}

struct ap_quat ap_quat_from_axis_angle(struct ap_vec3 axis, double angle_rad) {
    double s = sin(angle_rad / 2);
    return (struct ap_quat){s * axis.x, s * axis.y, s * axis.z, cos(angle_rad / 2)};
}

struct ap_quat ap_quat_slerp(struct ap_quat a, struct ap_quat b, double t) {
    if (a.x == b.x && a.y == b.y && a.z == b.z && a.w == b.w)
        return a;
    if (a.x * b.x + a.y * b.y + a.z * b.z + a.w * b.w < 0)
        b = (struct ap_quat){-b.x, -b.y, -b.z, -b.w};
    // The half angle from chords: exact for near and for opposite rotations alike.
    double difference = hypot(hypot(a.x - b.x, a.y - b.y), hypot(a.z - b.z, a.w - b.w));
    double sum = hypot(hypot(a.x + b.x, a.y + b.y), hypot(a.z + b.z, a.w + b.w));
    double angle = 2 * atan2(difference, sum), s = sin(angle);
    double ka = 1 - t, kb = t;
    if (s > 0) {
        ka = sin((1 - t) * angle) / s;
        kb = sin(t * angle) / s;
    }
    return ap_quat_normalize((struct ap_quat){ka * a.x + kb * b.x, ka * a.y + kb * b.y,
                                              ka * a.z + kb * b.z, ka * a.w + kb * b.w});
}
