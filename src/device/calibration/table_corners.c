#include "src/device/calibration/table_corners.h"

#include <complex.h>
#include <math.h>
#include <stddef.h>

static const double EDGE_MIN_M = 0.2, EDGE_MAX_M = 5, OFF_MAX_M = 0.1, MOVED_MAX_M = 0.02;
static const int64_t PRESS_NS = 500000000;

// The floor as the complex plane: counterclockwise there is counterclockwise seen from above.
static double complex from_above(struct ap_vec3 p) {
    return p.x - I * p.z;
}

// Of three touches the corner is the one whose sides are nearest to a right angle.
static int corner_of_three(const struct ap_vec3 *t) {
    int best = 0;
    double least = INFINITY;
    for (int i = 0; i < 3; i++) {
        struct ap_vec3 a = ap_vec3_sub(t[(i + 1) % 3], t[i]), b = ap_vec3_sub(t[(i + 2) % 3], t[i]);
        double cosine =
            fabs(ap_vec3_dot(a, b)) / fmax(ap_vec3_length(a) * ap_vec3_length(b), 1e-30);
        if (cosine < least) {
            least = cosine;
            best = i;
        }
    }
    return best;
}

// Which corner each touch is, counted counterclockwise from an arbitrary one.
static void number_touches(const struct ap_vec3 *t, int count, int number[AP_TABLE_TOUCHES_MAX]) {
    if (count == 3) {
        int m = corner_of_three(t), a = (m + 1) % 3, b = (m + 2) % 3;
        double complex u = from_above(t[a]) - from_above(t[m]),
                       v = from_above(t[b]) - from_above(t[m]);
        bool left = cimag(conj(u) * v) > 0; // a, corner, b run clockwise
        number[m] = 1;
        number[a] = left ? 2 : 0;
        number[b] = left ? 0 : 2;
        return;
    }
    double complex centre = 0;
    for (int i = 0; i < count; i++)
        centre += from_above(t[i]) / count;
    for (int i = 0; i < count; i++) {
        number[i] = 0;
        for (int k = 0; k < count; k++)
            number[i] += carg(from_above(t[k]) - centre) < carg(from_above(t[i]) - centre);
    }
}

static double complex turn(int quarter) {
    static const double re[4] = {1, 0, -1, 0}, im[4] = {0, 1, 0, -1};
    return re[quarter % 4] + I * im[quarter % 4];
}

// Corner k stands at c + w·i^k: linear, so the normal equations of two complex unknowns.
static void fit_square(const struct ap_vec3 *t, const int *number, int count, double edge_m,
                       double complex *c, double complex *w) {
    double complex sum = 0, turned = 0, turns = 0;
    for (int i = 0; i < count; i++) {
        double complex z = from_above(t[i]), r = turn(number[i]);
        sum += z;
        turned += conj(r) * z;
        turns += r;
    }
    double n = count, det = n * n - creal(turns * conj(turns));
    *w = (n * turned - conj(turns) * sum) / det;
    if (edge_m > 0 && cabs(*w) > 0) // its best direction is the free fit's
        *w *= edge_m * M_SQRT1_2 / cabs(*w);
    *c = (sum - turns * *w) / n;
}

// The plane through the touches: the mean of the normals of the triangles over them.
static double slope(const struct ap_vec3 *t, int count) {
    struct ap_vec3 normal = {0, 0, 0};
    for (int i = 0; i + 2 < count; i++) {
        struct ap_vec3 n = ap_vec3_cross(ap_vec3_sub(t[i + 1], t[i]), ap_vec3_sub(t[i + 2], t[i]));
        normal = ap_vec3_add(normal, n.y < 0 ? ap_vec3_scale(-1, n) : n);
    }
    return atan2(hypot(normal.x, normal.z), normal.y);
}

static void measure_corner(const struct ap_vec3 *t, int count, struct ap_table_fit *fit) {
    int m = count == 3 ? corner_of_three(t) : 0, a = (m + 1) % 3, b = (m + 2) % 3;
    if (count == 4) { // the two nearest to the first touch are its neighbours
        double far = 0;
        int opposite = 1;
        for (int i = 1; i < 4; i++)
            if (ap_vec3_length(ap_vec3_sub(t[i], t[0])) > far) {
                far = ap_vec3_length(ap_vec3_sub(t[i], t[0]));
                opposite = i;
            }
        a = opposite == 1 ? 2 : 1;
        b = opposite == 3 ? 2 : 3;
    }
    struct ap_vec3 u = ap_vec3_sub(t[a], t[m]), v = ap_vec3_sub(t[b], t[m]);
    fit->side_m[0] = ap_vec3_length(u);
    fit->side_m[1] = ap_vec3_length(v);
    fit->corner_rad = atan2(ap_vec3_length(ap_vec3_cross(u, v)), ap_vec3_dot(u, v));
}

static enum ap_status check_touches(struct ap_error *err, const struct ap_vec3 *t, int count,
                                    double edge_m) {
    if (count < 3 || count > AP_TABLE_TOUCHES_MAX)
        return ap_fail(err, AP_INPUT, "%d corners were touched: expected three or four", count);
    for (int i = 0; i < count; i++)
        if (!isfinite(t[i].x + t[i].y + t[i].z))
            return ap_fail(err, AP_INPUT, "touch %d: not a finite place", i + 1);
    if (edge_m > 0 && !(edge_m >= EDGE_MIN_M && edge_m <= EDGE_MAX_M))
        return ap_fail(err, AP_INPUT, "an edge of %g m: expected %g to %g", edge_m, EDGE_MIN_M,
                       EDGE_MAX_M);
    return AP_OK;
}

enum ap_status ap_table_fit(struct ap_error *err, const struct ap_vec3 *touches, int count,
                            double edge_m, struct ap_table_fit *out) {
    enum ap_status st = check_touches(err, touches, count, edge_m);
    if (st)
        return st;
    int number[AP_TABLE_TOUCHES_MAX];
    double complex c, w;
    struct ap_table_fit fit = {.slope_rad = slope(touches, count)};
    struct ap_table_place *place = &fit.place;
    number_touches(touches, count, number);
    fit_square(touches, number, count, edge_m, &c, &w);
    for (int i = 0; i < count; i++)
        place->height_m += touches[i].y / count;
    place->x_m = creal(c);
    place->z_m = -cimag(c);
    place->edge_m = cabs(w) * M_SQRT2;
    double yaw = carg(w) - M_PI_4; // a corner of a table that is not turned is at 45°
    place->yaw_rad = yaw - M_PI_2 * floor(yaw / M_PI_2 + 0.5);
    for (int i = 0; i < count; i++) {
        double complex off = from_above(touches[i]) - c - w * turn(number[i]);
        fit.residual_m[i] = hypot(cabs(off), touches[i].y - place->height_m);
        fit.rms_m += fit.residual_m[i] * fit.residual_m[i] / count;
    }
    fit.rms_m = sqrt(fit.rms_m);
    measure_corner(touches, count, &fit);
    if (!(place->edge_m >= EDGE_MIN_M && place->edge_m <= EDGE_MAX_M))
        return ap_fail(err, AP_INPUT,
                       "the corners are %.3f m apart: expected a table with edges of %g to %g m",
                       place->edge_m, EDGE_MIN_M, EDGE_MAX_M);
    for (int i = 0; i < count; i++)
        if (fit.residual_m[i] > OFF_MAX_M)
            return ap_fail(err, AP_INPUT,
                           "touch %d is %.0f mm from the corner of a square through the touches: "
                           "expected corners of one square, level table; touch them again",
                           i + 1, 1e3 * fit.residual_m[i]);
    *out = fit;
    return AP_OK;
}

const char *ap_table_fit_doubt(const struct ap_table_fit *fit) {
    if (fabs(fit->corner_rad - M_PI_2) > 2 * M_PI / 180)
        return "the corner is not a right one within 2 degrees: were the corners hit?";
    if (fabs(fit->side_m[0] - fit->side_m[1]) > 0.02)
        return "two edges differ by over 2 cm: is the table square?";
    if (fit->slope_rad > M_PI / 180)
        return "the surface is over 1 degree off level: is the room's floor calibrated?";
    return NULL;
}

static enum ap_touch_event end_press(struct ap_touch_finder *f, struct ap_vec3 *touch) {
    f->is_done = true;
    if (f->spread_m > MOVED_MAX_M)
        return AP_TOUCH_MOVED;
    *touch = ap_vec3_add(f->first, ap_vec3_scale(1.0 / (double)f->count, f->sum));
    return AP_TOUCH_MADE;
}

enum ap_touch_event ap_touch_find(struct ap_touch_finder *f, int64_t t_ns, struct ap_pose pose,
                                  bool pressed, struct ap_vec3 *touch) {
    if (!pressed) {
        bool ends = f->is_pressed && !f->is_done;
        f->is_pressed = false;
        return ends ? end_press(f, touch) : AP_TOUCH_NONE;
    }
    struct ap_vec3 tip = ap_pose_apply(pose, f->tip_m);
    if (!f->is_pressed) {
        struct ap_vec3 offset = f->tip_m;
        *f = (struct ap_touch_finder){
            .tip_m = offset, .is_pressed = true, .start_ns = t_ns, .first = tip};
    }
    if (f->is_done)
        return AP_TOUCH_NONE;
    struct ap_vec3 from_first = ap_vec3_sub(tip, f->first);
    f->count++;
    f->sum = ap_vec3_add(f->sum, from_first);
    f->spread_m = fmax(f->spread_m, ap_vec3_length(from_first));
    return t_ns - f->start_ns >= PRESS_NS ? end_press(f, touch) : AP_TOUCH_NONE;
}
