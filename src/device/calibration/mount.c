#include "src/device/calibration/mount.h"

#include <math.h>

static const int64_t LEVEL_NS = 1000000000;
static const double DEGREE = M_PI / 180;

static struct ap_vec3 rotation_vector(struct ap_quat q) {
    struct ap_vec3 v = {q.x, q.y, q.z};
    if (q.w < 0)
        v = ap_vec3_scale(-1, v);
    double s = ap_vec3_length(v);
    return s > 0 ? ap_vec3_scale(2 * atan2(s, fabs(q.w)) / s, v) : v;
}

static double *axis_of(struct ap_vec3 *v, int i) {
    return i == 0 ? &v->x : i == 1 ? &v->y : &v->z;
}

void ap_mount_add(struct ap_mount *m, int64_t t_ns, struct ap_quat q) {
    if (!m->started) {
        m->started = true;
        m->start_ns = t_ns;
        m->first = m->level = q;
    }
    m->count++;
    if (t_ns - m->start_ns < LEVEL_NS) {
        struct ap_vec3 moved = rotation_vector(ap_quat_mul(ap_quat_conj(m->first), q));
        m->unrest_rad = fmax(m->unrest_rad, ap_vec3_length(moved));
        m->up_sum =
            ap_vec3_add(m->up_sum, ap_quat_rotate(ap_quat_conj(q), (struct ap_vec3){0, 1, 0}));
        m->level = q;
        m->still_count++;
        return;
    }
    struct ap_vec3 r = rotation_vector(ap_quat_mul(ap_quat_conj(m->level), q));
    double angle = ap_vec3_length(r);
    m->farthest_rad = fmax(m->farthest_rad, angle);
    if (angle > 10 * DEGREE && ap_vec3_length(m->down) == 0)
        m->down = ap_vec3_scale(1 / angle, r);
    for (int i = 0; i < 3; i++)
        m->moment[i] = ap_vec3_add(m->moment[i], ap_vec3_scale(*axis_of(&r, i), r));
}

bool ap_mount_is_level(const struct ap_mount *m) {
    return m->count > m->still_count;
}

// The direction of the largest moment by iteration, which begins at the first way.
static struct ap_vec3 main_axis(const struct ap_mount *m, double *straight) {
    struct ap_vec3 axis = m->down;
    double trace = m->moment[0].x + m->moment[1].y + m->moment[2].z, most = 0;
    for (int i = 0; i < 100; i++) {
        struct ap_vec3 next = {ap_vec3_dot(m->moment[0], axis), ap_vec3_dot(m->moment[1], axis),
                               ap_vec3_dot(m->moment[2], axis)};
        most = ap_vec3_length(next);
        axis = ap_vec3_normalize(next);
    }
    *straight = trace > 0 ? 1 - most / trace : 1;
    return axis;
}

// The rotation whose columns these right-handed axes are (Shepperd's four cases).
static struct ap_quat from_axes(struct ap_vec3 x, struct ap_vec3 y, struct ap_vec3 z) {
    double w2 = 1 + x.x + y.y + z.z, x2 = 1 + x.x - y.y - z.z, y2 = 1 - x.x + y.y - z.z,
           z2 = 1 - x.x - y.y + z.z;
    struct ap_quat q;
    if (w2 >= x2 && w2 >= y2 && w2 >= z2)
        q = (struct ap_quat){y.z - z.y, z.x - x.z, x.y - y.x, w2};
    else if (x2 >= y2 && x2 >= z2)
        q = (struct ap_quat){x2, x.y + y.x, z.x + x.z, y.z - z.y};
    else if (y2 >= z2)
        q = (struct ap_quat){x.y + y.x, y2, y.z + z.y, z.x - x.z};
    else
        q = (struct ap_quat){z.x + x.z, y.z + z.y, z2, x.y - y.x};
    return ap_quat_normalize(q);
}

enum ap_status ap_mount_result(struct ap_error *err, const struct ap_mount *m,
                               struct ap_mount_result *out) {
    if (m->still_count < 5)
        return ap_fail(err, AP_INPUT, "expected a second of orientations, looking level ahead");
    if (m->unrest_rad > 2 * DEGREE)
        return ap_fail(err, AP_INPUT,
                       "it moved by %.1f degrees in the first second: look ahead and hold still",
                       m->unrest_rad / DEGREE);
    if (m->farthest_rad < 15 * DEGREE)
        return ap_fail(err, AP_INPUT, "a nod of %.0f degrees: expected 15 or more, down first",
                       m->farthest_rad / DEGREE);
    struct ap_mount_result result = {.nod_rad = m->farthest_rad};
    struct ap_vec3 up = ap_vec3_normalize(m->up_sum);
    struct ap_vec3 axis = main_axis(m, &result.straight);
    double along = ap_vec3_dot(axis, up);
    result.upright_rad = asin(fmin(fabs(along), 1));
    if (result.straight > 0.1 || result.upright_rad > 20 * DEGREE)
        return ap_fail(err, AP_INPUT,
                       "that was no straight nod (%.0f%% about other axes, %.0f degrees off "
                       "level): down and up, without turning",
                       100 * result.straight, result.upright_rad / DEGREE);
    // Looking down turns about −x.
    struct ap_vec3 x = ap_vec3_normalize(ap_vec3_sub(axis, ap_vec3_scale(along, up)));
    if (ap_vec3_dot(x, m->down) > 0)
        x = ap_vec3_scale(-1, x);
    result.tracker_from_body = from_axes(x, up, ap_vec3_cross(x, up));
    *out = result;
    return AP_OK;
}
