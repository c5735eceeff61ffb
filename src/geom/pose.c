#include "src/geom/pose.h"

// hot: what every frame of a runtime calls lies side by side, for the caches are cold then
// (docs/performance.md).
__attribute__((hot)) struct ap_pose ap_pose_mul(struct ap_pose a_from_b, struct ap_pose b_from_c) {
    return (struct ap_pose){ap_pose_apply(a_from_b, b_from_c.p),
                            ap_quat_normalize(ap_quat_mul(a_from_b.q, b_from_c.q))};
}

__attribute__((hot)) struct ap_pose ap_pose_inverse(struct ap_pose a_from_b) {
    struct ap_quat q = ap_quat_conj(a_from_b.q);
    return (struct ap_pose){ap_vec3_scale(-1, ap_quat_rotate(q, a_from_b.p)), q};
}

__attribute__((hot)) struct ap_vec3 ap_pose_apply(struct ap_pose a_from_b, struct ap_vec3 p_b) {
    return ap_vec3_add(ap_quat_rotate(a_from_b.q, p_b), a_from_b.p);
}

struct ap_pose ap_pose_interpolate(struct ap_pose a, struct ap_pose b, double t) {
    struct ap_vec3 way = ap_vec3_sub(b.p, a.p);
    return (struct ap_pose){ap_vec3_add(a.p, ap_vec3_scale(t, way)), ap_quat_slerp(a.q, b.q, t)};
}
