#include "src/view/light.h"

#include <math.h>

static const double AMBIENT = 0.17, FILL = 0.17, LAMP = 0.95, BRIGHTEST = 4; // as in light.glsl

static double inner(struct ap_space space, struct ap_vec4 a, struct ap_vec4 b) {
    return a.x * b.x + a.y * b.y + a.z * b.z + space.kappa * a.w * b.w;
}

// The unit tangent vector at p towards q, and S(d/rho). In units of rho.
static struct ap_vec4 toward(struct ap_space space, struct ap_vec4 p, struct ap_vec4 q,
                             double *sine) {
    double rho = space.rho_m;
    struct ap_vec4 a = {p.x / rho, p.y / rho, p.z / rho, p.w / rho};
    struct ap_vec4 b = {q.x / rho, q.y / rho, q.z / rho, q.w / rho};
    double c = space.kappa == 0 ? 1 : space.kappa * inner(space, a, b);
    struct ap_vec4 v = {b.x - c * a.x, b.y - c * a.y, b.z - c * a.z, b.w - c * a.w};
    double s = sqrt(inner(space, v, v));
    *sine = s;
    return (struct ap_vec4){v.x / s, v.y / s, v.z / s, v.w / s};
}

struct ap_lamplight ap_lamp_light(struct ap_space space, const struct ap_lamp *lamp,
                                  const struct ap_lit_point *point) {
    double s, reach = ap_space_sin(space, lamp->reach_m / space.rho_m);
    struct ap_vec4 to_lamp = toward(space, point->at, lamp->at, &s);
    return (struct ap_lamplight){inner(space, point->normal, to_lamp),
                                 fmin(reach * reach / (s * s), BRIGHTEST)};
}

static double smooth_step(double low, double high, double x) {
    double t = fmin(fmax((x - low) / (high - low), 0), 1);
    return t * t * (3 - 2 * t);
}

struct ap_hidden ap_hidden_by_ball(struct ap_space space, const struct ap_lamp *lamp,
                                   const struct ap_lit_point *point, struct ap_vec4 ball,
                                   double radius_m) {
    double lamp_s, ball_s;
    struct ap_vec4 to_lamp = toward(space, point->at, lamp->at, &lamp_s);
    struct ap_vec4 to_ball = toward(space, point->at, ball, &ball_s);
    double sine = fmin(ap_space_sin(space, radius_m / space.rho_m) / ball_s, 1);
    double lamp_sine = ap_space_sin(space, lamp->radius_m / space.rho_m) / lamp_s;
    double along = fmin(fmax(inner(space, to_ball, to_lamp), -1), 1);
    double beyond = sqrt(1 - along * along) * sqrt(1 - sine * sine) - along * sine;
    double up = inner(space, point->normal, to_ball);
    return (struct ap_hidden){fmax(0, up) * sine * sine,
                              1 - smooth_step(-lamp_sine, lamp_sine, beyond)};
}

double ap_surface_strength(struct ap_space space, const struct ap_lamp *lamp,
                           const struct ap_lit_point *point, struct ap_vec4 nose,
                           double surroundings_hidden, double lamp_left) {
    double s;
    struct ap_lamplight light = ap_lamp_light(space, lamp, point);
    struct ap_vec4 to_nose = toward(space, point->at, nose, &s);
    double facing = fmax(0, inner(space, point->normal, to_nose));
    double open = fmax(0, 1 - surroundings_hidden);
    return (AMBIENT + FILL * facing) * open +
           LAMP * fmax(0, light.cosine) * light.falloff * lamp_left;
}
