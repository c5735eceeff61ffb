#include "src/geom/table.h"

#include "src/geom/map.h"

static const double pi = 3.141592653589793, acosh_golden_ratio = 1.0612750619050357;

// From the right triangle at the centre: angle pi/n, opposite leg the half edge h, adjacent leg the
// inradius, hypotenuse the circumradius, all over rho. As arctangents, which are exact where the
// polygon of s3 nears a great circle.
static void right_triangle(int kappa, int sides, double h, double *circum, double *in) {
    double a = pi / sides;
    if (kappa > 0) {
        double root = sqrt(sin(a - h) * sin(a + h));
        *circum = atan2(sin(h), root);
        *in = atan2(sin(h) * cos(a), root);
    } else if (kappa < 0) {
        *circum = asinh(sinh(h) / sin(a));
        *in = asinh(tanh(h) / tan(a));
    } else {
        *circum = h / sin(a);
        *in = h / tan(a);
    }
}

enum ap_status ap_regular_polygon(struct ap_error *err, struct ap_space space, int sides,
                                  double edge_m, double *circumradius_m, double *inradius_m) {
    if (sides < 3)
        return ap_fail(err, AP_INPUT, "a polygon of %d sides: give at least 3", sides);
    if (!isfinite(edge_m) || edge_m <= 0)
        return ap_fail(err, AP_INPUT, "an edge of %g m: give a finite length above 0", edge_m);
    double h = edge_m / (2 * space.rho_m);
    if (space.kappa > 0 && !(h < pi / sides))
        return ap_fail(err, AP_INPUT,
                       "%d edges of %g m do not close on s3 of radius %g m: the edge must be "
                       "shorter than %.9g m",
                       sides, edge_m, space.rho_m, 2 * pi * space.rho_m / sides);
    double circum, in;
    right_triangle(space.kappa, sides, h, &circum, &in);
    *circumradius_m = circum * space.rho_m;
    *inradius_m = in * space.rho_m;
    return AP_OK;
}

double ap_table_edge_of_radius(struct ap_space space) {
    return space.rho_m * (space.kappa > 0 ? pi / 2 : acosh_golden_ratio);
}

struct ap_table_shape ap_table_from_edge(int kappa, double edge_m, double e3_rho_m) {
    double rho_m = kappa > 0   ? edge_m / (pi / 2)
                   : kappa < 0 ? edge_m / acosh_golden_ratio
                               : e3_rho_m;
    struct ap_table_shape table = {.space = {kappa, rho_m}, .sides = 4 - kappa, .edge_m = edge_m};
    double circum, in;
    // The half edge in units of rho is known exactly; in e3 any unit will do.
    double h = kappa > 0 ? pi / 4 : kappa < 0 ? acosh_golden_ratio / 2 : 0.5;
    right_triangle(kappa, table.sides, h, &circum, &in);
    double unit_m = kappa ? rho_m : edge_m;
    table.circumradius_m = circum * unit_m;
    table.inradius_m = kappa ? in * unit_m : edge_m / 2;
    return table;
}

// Quarter turns are exact, so that the four frames of a square are.
static struct ap_iso turn_of_edge(long long edge, int sides) {
    int k = (int)(((edge % sides) + sides) % sides);
    if (k * 4 % sides != 0)
        return ap_iso_rotate_y(2 * pi * k / sides);
    static const double cosine[4] = {1, 0, -1, 0}, sine[4] = {0, 1, 0, -1};
    double c = cosine[k * 4 / sides], s = sine[k * 4 / sides];
    return (struct ap_iso){{{c, 0, s, 0}, {0, 1, 0, 0}, {-s, 0, c, 0}, {0, 0, 0, 1}}};
}

struct ap_iso ap_table_edge_frame(const struct ap_table_shape *table, long long edge) {
    return ap_iso_mul(turn_of_edge(edge, table->sides),
                      ap_iso_translate(table->space, (struct ap_vec3){0, 0, -table->inradius_m}));
}
