#include "src/game/rack.h"

#include <string.h>

// The usual racks, row by row from the apex; 0 ends a row.
static const int eight_rack[] = {1, 0, 9, 2, 0, 10, 8, 3, 0, 11, 4, 12, 5, 0, 6, 13, 14, 7, 15, 0};
static const int nine_rack[] = {1, 0, 2, 3, 0, 4, 9, 5, 0, 6, 7, 0, 8, 0};

static const double apart = 1.002;

struct spot {
    int ball;
    struct ap_plane2 at; // in spacings, the apex at 0, rows toward −z
};

static int lattice(enum ap_game_kind kind, struct spot *spots) {
    const int *rack = kind == AP_GAME_NINE ? nine_rack : eight_rack;
    size_t size = kind == AP_GAME_NINE ? sizeof nine_rack : sizeof eight_rack;
    int n = 0, row = 0, begin = 0;
    for (size_t i = 0; i < size / sizeof *rack; i++) {
        if (rack[i]) {
            spots[n] = (struct spot){rack[i], {n - begin, -row * sqrt(0.75)}};
            n++;
            continue;
        }
        for (int k = begin; k < n; k++)
            spots[k].at.x -= (n - begin - 1) / 2.0;
        begin = n;
        row++;
    }
    return n;
}

struct ap_plane2 ap_rack_head_spot(const struct ap_physics *ph) {
    return (struct ap_plane2){0, 0.6 * ph->shape.inradius_m};
}

struct ap_plane2 ap_rack_foot_spot(const struct ap_physics *ph) {
    return (struct ap_plane2){0, -0.28 * ph->shape.inradius_m};
}

double ap_rack_head_line(const struct ap_physics *ph) {
    return 0.55 * ph->shape.inradius_m;
}

static struct ap_plane2 tangent_of(const struct ap_physics *ph, const struct spot *s,
                                   double spacing, double middle) {
    return (struct ap_plane2){s->at.x * spacing,
                              ap_rack_foot_spot(ph).z + (s->at.z - middle) * spacing};
}

static double closest(const struct ap_physics *ph, const struct spot *spots, int n, double spacing,
                      double middle) {
    struct ap_plane3 p[AP_BALLS_MAX];
    double least = INFINITY;
    for (int i = 0; i < n; i++) {
        struct ap_plane_frame f =
            ap_plane_translate(ph->shape.space, tangent_of(ph, &spots[i], spacing, middle));
        p[i] = ap_plane_foot(&f, ph->shape.space.rho_m);
        for (int j = 0; j < i; j++)
            least = fmin(least, ap_plane_chord2(ph->shape.space.kappa, p[i], p[j]));
    }
    return sqrt(least);
}

// As the room shows them: every ball lies differently, its number where one may see it.
static struct ap_quat first_turn(int ball) {
    struct ap_vec3 axis = ap_vec3_normalize((struct ap_vec3){1, 0.25 * (ball % 5 - 2), 0.3});
    return ap_quat_mul(ap_quat_from_axis_angle((struct ap_vec3){0, 1, 0}, 2.4 * ball),
                       ap_quat_from_axis_angle(axis, -0.45 - 0.11 * (ball % 7)));
}

enum ap_status ap_rack_set(struct ap_error *err, struct ap_physics *ph, enum ap_game_kind kind) {
    struct spot spots[AP_BALLS_MAX];
    int n = lattice(kind, spots);
    double middle = 0;
    for (int i = 0; i < n; i++)
        middle += spots[i].at.z / n;
    double touch = 2 * ph->rolling_radius_m * apart, spacing = touch;
    for (int i = 0; i < 6; i++)
        spacing *= touch / closest(ph, spots, n, spacing, middle);
    struct ap_error why = {""};
    enum ap_status st = ap_physics_place(&why, ph, 0, ap_rack_head_spot(ph));
    for (int i = 0; i < n && !st; i++) {
        st = ap_physics_place(&why, ph, spots[i].ball, tangent_of(ph, &spots[i], spacing, middle));
        if (!st)
            ph->ball[spots[i].ball].foot_from_ball = first_turn(spots[i].ball);
    }
    if (st)
        return ap_fail(err, AP_INPUT,
                       "the rack of %s does not fit on this table: %s (use smaller balls or a "
                       "larger table)",
                       ap_game_kind_name(kind), why.text);
    return AP_OK;
}

bool ap_rack_free_place(const struct ap_physics *physics, int ball, struct ap_plane2 wanted,
                        struct ap_plane2 *place) {
    struct ap_physics ph = *physics;
    double step = ph.params.ball_radius_m / 2;
    int rings = (int)(2 * ph.shape.circumradius_m / step);
    for (int ring = 0; ring <= rings; ring++)
        for (int k = 0; k < (ring ? 6 * ring : 1); k++) {
            double a = 2 * M_PI * k / (ring ? 6 * ring : 1), r = ring * step;
            struct ap_plane2 at = {wanted.x + r * sin(a), wanted.z + r * cos(a)};
            if (ap_physics_place(NULL, &ph, ball, at) == AP_OK) {
                *place = at;
                return true;
            }
        }
    return false;
}
