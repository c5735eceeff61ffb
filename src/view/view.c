#include "src/view/view.h"

#include <string.h>

static const char *const mode_names[] = {
    [AP_VIEW_NATIVE] = "native", [AP_VIEW_TOURIST] = "tourist", [AP_VIEW_BORN] = "native-of"};

enum ap_status ap_view_mode_from_name(struct ap_error *err, const char *name,
                                      enum ap_view_mode *mode) {
    for (int i = AP_VIEW_NATIVE; i <= AP_VIEW_BORN; i++)
        if (name && strcmp(name, mode_names[i]) == 0) {
            *mode = (enum ap_view_mode)i;
            return AP_OK;
        }
    return ap_fail(err, AP_USAGE, "unknown view '%s': expected native or tourist (or native-of)",
                   name ? name : "");
}

const char *ap_view_mode_name(enum ap_view_mode mode) {
    return mode_names[mode];
}

struct ap_space ap_viewer_born(const struct ap_viewer *viewer) {
    if (viewer->mode == AP_VIEW_NATIVE)
        return (struct ap_space){0, viewer->space.rho_m};
    return viewer->mode == AP_VIEW_TOURIST ? viewer->space : viewer->born;
}

enum ap_view_mode ap_view_mode_of(struct ap_space world, struct ap_space born) {
    if (born.kappa == 0)
        return AP_VIEW_NATIVE;
    bool own = born.kappa == world.kappa && born.rho_m == world.rho_m;
    return own ? AP_VIEW_TOURIST : AP_VIEW_BORN;
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

struct ap_born_point ap_born_from_tangent(struct ap_space born, struct ap_tangent_point p) {
    bool behind = born.kappa > 0 && ap_vec3_length(p.x) > M_PI * born.rho_m;
    return (struct ap_born_point){ap_exp(born, p.x), behind};
}

struct ap_iso ap_eye_from_nose(const struct ap_viewer *viewer, int eye) {
    struct ap_space born = ap_viewer_born(viewer);
    return ap_iso_inverse(born, ap_iso_from_pose(born, viewer->eye[eye].view_from_eye));
}

static bool line_of(const struct ap_viewer *viewer, int eye, struct ap_born_point p,
                    struct ap_vec3 *line) {
    struct ap_iso eye_from_nose = ap_eye_from_nose(viewer, eye);
    struct ap_vec4 q = ap_iso_apply(&eye_from_nose, p.x);
    // The long way round is seen in the opposite direction.
    struct ap_vec3 v = ap_vec3_scale(p.behind ? -1 : 1, (struct ap_vec3){q.x, q.y, q.z});
    if (!(ap_vec3_length(v) > 0))
        return false;
    *line = v;
    return true;
}

bool ap_sight_line_of_tangent(const struct ap_viewer *viewer, int eye, struct ap_tangent_point p,
                              struct ap_vec3 *line) {
    struct ap_space born = ap_viewer_born(viewer);
    if (born.kappa > 0 && !(ap_vec3_length(p.x) < 2 * M_PI * born.rho_m))
        return false;
    return line_of(viewer, eye, ap_born_from_tangent(born, p), line);
}

bool ap_sight_line(const struct ap_viewer *viewer, int eye, struct ap_nose_point nose, int image,
                   struct ap_vec3 *line) {
    if (image != 0 && (image != 1 || viewer->space.kappa <= 0))
        return false;
    if (viewer->mode == AP_VIEW_TOURIST) // log and exp of one space: left out
        return line_of(viewer, eye, (struct ap_born_point){nose.x, image == 1}, line);
    bool undefined = nose.x.x == 0 && nose.x.y == 0 && nose.x.z == 0;
    if (undefined && (image == 1 || nose.x.w < 0))
        return false;
    return ap_sight_line_of_tangent(viewer, eye, ap_tangent_from_nose(viewer->space, nose, image),
                                    line);
}

bool ap_direction(const struct ap_viewer *viewer, int eye, struct ap_vec4 world, int image,
                  double *a, double *b) {
    struct ap_vec3 v;
    if (!ap_sight_line(viewer, eye, ap_nose_from_world(viewer, world), image, &v) || !(v.z < 0))
        return false;
    double qa = v.x / -v.z, qb = v.y / -v.z;
    if (!isfinite(qa) || !isfinite(qb))
        return false;
    *a = qa;
    *b = qb;
    return true;
}
