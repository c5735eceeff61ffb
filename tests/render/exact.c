#include "tests/render/exact.h"

#include <math.h>

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
