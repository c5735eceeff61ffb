#include "src/view/view.h"

#include <string.h>

static const char *const mode_names[] = {
    [AP_VIEW_NATIVE] = "native", [AP_VIEW_TOURIST] = "tourist"};

enum ap_status ap_view_mode_from_name(struct ap_error *err, const char *name,
                                      enum ap_view_mode *mode) {
    for (int i = AP_VIEW_NATIVE; i <= AP_VIEW_TOURIST; i++)
        if (name && strcmp(name, mode_names[i]) == 0) {
            *mode = (enum ap_view_mode)i;
            return AP_OK;
        }
    return ap_fail(err, AP_USAGE, "unknown view '%s': expected native or tourist",
                   name ? name : "");
}

const char *ap_view_mode_name(enum ap_view_mode mode) {
    return mode == AP_VIEW_TOURIST ? mode_names[AP_VIEW_TOURIST] : mode_names[AP_VIEW_NATIVE];
}

struct ap_nose_point ap_nose_from_world(const struct ap_viewer *viewer, struct ap_vec4 world) {
    struct ap_iso nose_from_world = ap_iso_inverse(viewer->space, viewer->world_from_nose);
    return (struct ap_nose_point){ap_iso_apply(&nose_from_world, world)};
}

struct ap_tangent_point ap_tangent_from_nose(struct ap_space space, struct ap_nose_point p,
                                             int image) {
    return (struct ap_tangent_point){ap_log_unchecked(space, p.x, image)};
}

struct ap_eye_point ap_eye_from_tangent(const struct ap_view_eye *eye, struct ap_tangent_point p) {
    return (struct ap_eye_point){ap_pose_apply(ap_pose_inverse(eye->view_from_eye), p.x)};
}

struct ap_iso ap_eye_from_nose(const struct ap_viewer *viewer, int eye) {
    return ap_iso_inverse(viewer->space,
                          ap_iso_from_pose(viewer->space, viewer->eye[eye].view_from_eye));
}

static bool quotients(double x, double y, double z, double *a, double *b) {
    double qa = x / -z, qb = y / -z;
    if (!isfinite(qa) || !isfinite(qb))
        return false;
    *a = qa;
    *b = qb;
    return true;
}

bool ap_direction(const struct ap_viewer *viewer, int eye, struct ap_vec4 world, int image,
                  double *a, double *b) {
    if (image != 0 && (image != 1 || viewer->space.kappa <= 0))
        return false;
    struct ap_nose_point nose = ap_nose_from_world(viewer, world);
    if (viewer->mode == AP_VIEW_TOURIST) {
        struct ap_iso eye_from_nose = ap_eye_from_nose(viewer, eye);
        struct ap_vec4 p = ap_iso_apply(&eye_from_nose, nose.x);
        // The long way round is seen in the opposite direction, −(x, y, z): what is in front has
        // z > 0, and the quotients are the same.
        bool front = image == 0 ? p.z < 0 : p.z > 0;
        return front && quotients(p.x, p.y, p.z, a, b);
    }
    // At the nose's antipode (image 0), and at the nose itself (image 1), there is no direction.
    bool undefined = nose.x.x == 0 && nose.x.y == 0 && nose.x.z == 0;
    if (undefined && (image == 1 || nose.x.w < 0))
        return false;
    struct ap_eye_point p =
        ap_eye_from_tangent(&viewer->eye[eye], ap_tangent_from_nose(viewer->space, nose, image));
    return p.x.z < 0 && quotients(p.x.x, p.x.y, p.x.z, a, b);
}
