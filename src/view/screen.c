#include "src/view/screen.h"

#include <math.h>

static const double PI = 3.14159265358979323846;

static double eye_distance(const struct ap_viewer *viewer) {
    return fmax(ap_vec3_length(viewer->eye[0].view_from_eye.p),
                ap_vec3_length(viewer->eye[1].view_from_eye.p));
}

static struct ap_vec3 direction(struct ap_vec4 p) {
    return ap_vec3_normalize((struct ap_vec3){p.x, p.y, p.z});
}

bool ap_screen_of(const struct ap_viewer *viewer, const struct ap_vec4 *corners, int count,
                  double near_m, double far_m, double slack_rad, struct ap_screen *screen) {
    double rho = viewer->space.rho_m, eye = eye_distance(viewer);
    if (viewer->mode != AP_VIEW_NATIVE || viewer->space.kappa <= 0 || count < 3 ||
        count > AP_SCREEN_SIDES || !(near_m > 4 * (eye + AP_NEAR_M)) ||
        !(far_m < (PI - 0.3) * rho - eye))
        return false;
    struct ap_screen made = {.sides = count};
    struct ap_vec3 middle = {0, 0, 0};
    for (int i = 0; i < count; i++)
        middle = ap_vec3_add(middle, direction(corners[i]));
    middle = ap_vec3_normalize(middle);
    for (int i = 0; i < count; i++) {
        struct ap_vec3 n =
            ap_vec3_cross(direction(corners[i]), direction(corners[(i + 1) % count]));
        double length = ap_vec3_length(n), side = ap_vec3_dot(n, middle);
        if (!(fabs(side) > 1e-3 * length)) // seen from its edge, or it is no cone
            return false;
        made.inward[i] = ap_vec3_scale((side < 0 ? -1 : 1) / length, n);
    }
    // The straight edges in tangent space pass a little nearer than the geodesics.
    made.lean_rad = asin(fmin(1, eye / (0.8 * near_m))) + asin(fmin(1, eye / (PI * rho - eye))) +
                    slack_rad + 1e-5;
    *screen = made;
    return true;
}

bool ap_screen_hides_back(const struct ap_viewer *viewer, const struct ap_screen *screen,
                          const struct ap_vec4 *points, int count, double radius_m, double near_m,
                          double far_m) {
    double rho = viewer->space.rho_m;
    double away = fmin(sin(near_m / rho), sin(fmin(far_m / rho, PI)));
    double spread = screen->lean_rad;
    if (radius_m > 0) {
        double q = sin(radius_m / rho) / away;
        if (!(away > 0) || !(q < 1) || !(radius_m < PI / 2 * rho))
            return false;
        spread += asin(q);
    }
    if (!(spread < PI / 2))
        return false;
    double least = sin(spread);
    for (int i = 0; i < count; i++) {
        struct ap_vec3 u = direction(points[i]);
        for (int k = 0; k < screen->sides; k++)
            if (!(-ap_vec3_dot(screen->inward[k], u) > least))
                return false;
    }
    return true;
}
