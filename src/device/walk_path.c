#include "src/device/walk_path.h"

#include <math.h>

#include "src/geom/vec.h"

const double ap_walk_offset_m = 0.56;

// Between control points on the walked curve; less than a corner's arc, so that corners stay.
static const double STEP_M = 0.24;

struct corner_arc {
    double x, z;
};

double ap_walk_path_edge_length_m(double edge_m) {
    return edge_m + M_PI_2 * ap_walk_offset_m;
}

// The unsmoothed curve. Points are spread as on the walked one whatever the offset, so that the
// curves run side by side.
static struct corner_arc widened_square(double edge_m, double offset_m, double u) {
    double e = floor(u), arc = M_PI_4 * ap_walk_offset_m;
    double s = (u - e) * ap_walk_path_edge_length_m(edge_m), half = edge_m / 2, x, z;
    if (s < arc || s > arc + edge_m) {
        double middle = s < arc ? half : -half;
        double a = s < arc ? M_PI_4 - s / ap_walk_offset_m : -(s - arc - edge_m) / ap_walk_offset_m;
        x = middle + offset_m * sin(a);
        z = -half - offset_m * cos(a);
    } else {
        x = half - (s - arc);
        z = -half - offset_m;
    }
    // rotY by a quarter turn per edge.
    for (int i = (int)(e - 4 * floor(e / 4)); i > 0; i--) { // exact, and cheaper than fmod
        double old_x = x;
        x = z;
        z = -old_x;
    }
    return (struct corner_arc){x, z};
}

struct ap_walk_point ap_walk_path(double edge_m, double offset_m, double u) {
    double n = ceil(ap_walk_path_edge_length_m(edge_m) / STEP_M);
    double i = floor(u * n), t = u * n - i;
    const double w[4] = {(1 - t) * (1 - t) * (1 - t) / 6, (3 * t * t * t - 6 * t * t + 4) / 6,
                         (-3 * t * t * t + 3 * t * t + 3 * t + 1) / 6, t * t * t / 6};
    const double dw[4] = {-(1 - t) * (1 - t) / 2, (3 * t * t - 4 * t) / 2,
                          (-3 * t * t + 2 * t + 1) / 2, t * t / 2};
    struct ap_walk_point p = {0};
    for (int k = 0; k < 4; k++) {
        struct corner_arc c = widened_square(edge_m, offset_m, (i + k - 1) / n);
        p.x += w[k] * c.x;
        p.z += w[k] * c.z;
        p.dx += n * dw[k] * c.x;
        p.dz += n * dw[k] * c.z;
    }
    return p;
}

double ap_walk_turn_rad(double angle_rad) {
    return fabs(angle_rad) <= M_PI ? angle_rad : remainder(angle_rad, 2 * M_PI);
}

double ap_walk_path_heading(const struct ap_walk_point *p, double u) {
    double near = M_PI_2 * (u + 0.5);
    return near + ap_walk_turn_rad(atan2(-p->dx, -p->dz) - near);
}
