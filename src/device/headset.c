#include "src/device/headset.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "src/device/unit_quat.h"

enum { MAX_SIDE_PX = 16384 };

static enum ap_status read_in_range(struct ap_error *err, const struct ap_json_at *object,
                                    const char *key, double above, double at_most, const char *what,
                                    double *value) {
    double v;
    enum ap_status st = ap_json_number(err, object, key, &v);
    if (st)
        return st;
    struct ap_json_at at = ap_json_member(object, key);
    if (!(v > above && v <= at_most))
        return ap_json_fail(err, &at, "expected %s, not %.17g", what, v);
    *value = v;
    return AP_OK;
}

static enum ap_status read_angle(struct ap_error *err, const struct ap_json_at *object,
                                 const char *key, double *value) {
    double v;
    enum ap_status st = ap_json_number(err, object, key, &v);
    if (st)
        return st;
    struct ap_json_at at = ap_json_member(object, key);
    if (!(fabs(v) < M_PI_2))
        return ap_json_fail(err, &at, "expected an angle between -pi/2 and pi/2 radians, not %.17g",
                            v);
    *value = v;
    return AP_OK;
}

static enum ap_status read_fov(struct ap_error *err, const struct ap_json_at *eye,
                               struct ap_eye_profile *out) {
    static const char *const keys[] = {"left", "right", "up", "down", NULL};
    struct ap_json_at at = ap_json_member(eye, "fov_rad");
    enum ap_status st = ap_json_check_keys(err, &at, keys);
    double *const values[] = {&out->left_rad, &out->right_rad, &out->up_rad, &out->down_rad};
    for (int i = 0; !st && keys[i]; i++)
        st = read_angle(err, &at, keys[i], values[i]);
    if (st)
        return st;
    if (out->left_rad >= out->right_rad)
        return ap_json_fail(err, &at, "expected left < right (left is negative as a rule)");
    if (out->down_rad >= out->up_rad)
        return ap_json_fail(err, &at, "expected down < up (down is negative as a rule)");
    return AP_OK;
}

static enum ap_status read_side(struct ap_error *err, const struct ap_json_at *array, size_t i,
                                uint32_t *side) {
    struct ap_json_at at = ap_json_element(array, i);
    json_int_t v = json_is_integer(at.value) ? json_integer_value(at.value) : 0;
    if (v < 1 || v > MAX_SIDE_PX)
        return ap_json_fail(err, &at, "expected a whole number of pixels, 1 to %d", MAX_SIDE_PX);
    *side = (uint32_t)v;
    return AP_OK;
}

static enum ap_status read_hidden_area(struct ap_error *err, const struct ap_json_at *eye,
                                       struct ap_eye_profile *out) {
    static const char *const keys[] = {"outside_ellipse", NULL};
    struct ap_json_at at = ap_json_member(eye, "hidden_area");
    double e[4];
    enum ap_status st = ap_json_check_keys(err, &at, keys);
    if (!st)
        st = ap_json_numbers(err, &at, "outside_ellipse", 4, e);
    if (st)
        return st;
    struct ap_json_at ellipse = ap_json_member(&at, "outside_ellipse");
    if (!(e[2] >= 1e-3 && e[2] <= 1e3 && e[3] >= 1e-3 && e[3] <= 1e3))
        return ap_json_fail(err, &ellipse, "expected radii from 0.001 to 1000 (in tangents)");
    if (!(e[0] > tan(out->left_rad) && e[0] < tan(out->right_rad) && e[1] > tan(out->down_rad) &&
          e[1] < tan(out->up_rad)))
        return ap_json_fail(err, &ellipse, "expected a center inside the field of view");
    memcpy(out->seen, e, sizeof e);
    return AP_OK;
}

static enum ap_status read_lens(struct ap_error *err, const struct ap_json_at *object,
                                struct ap_eye_profile *out) {
    if (!ap_json_has(object, "lens"))
        return AP_OK;
    struct ap_json_at at = ap_json_member(object, "lens");
    double x = fmax(fabs(tan(out->left_rad)), fabs(tan(out->right_rad)));
    double y = fmax(fabs(tan(out->up_rad)), fabs(tan(out->down_rad)));
    return ap_lens_parse(err, &at, hypot(x, y), &out->lens);
}

static enum ap_status read_eye(struct ap_error *err, const struct ap_json_at *eyes, const char *key,
                               struct ap_eye_profile *out) {
    static const char *const keys[] = {"resolution_px", "fov_rad",     "yaw_rad",
                                       "lens",          "hidden_area", NULL};
    struct ap_json_at at = ap_json_member(eyes, key);
    enum ap_status st = ap_json_check_keys(err, &at, keys);
    if (st)
        return st;
    struct ap_json_at size = ap_json_member(&at, "resolution_px");
    if (!json_is_array(size.value) || json_array_size(size.value) != 2)
        return ap_json_fail(err, &size, "expected [width, height] in pixels");
    st = read_side(err, &size, 0, &out->width_px);
    if (!st)
        st = read_side(err, &size, 1, &out->height_px);
    if (!st)
        st = read_fov(err, &at, out);
    if (!st && ap_json_has(&at, "yaw_rad"))
        st = read_angle(err, &at, "yaw_rad", &out->yaw_rad);
    if (!st)
        st = read_lens(err, &at, out);
    if (!st && ap_json_has(&at, "hidden_area"))
        st = read_hidden_area(err, &at, out);
    return st;
}

static enum ap_status read_aim(struct ap_error *err, const struct ap_json_at *profile,
                               struct ap_pose *pose) {
    static const char *const keys[] = {"position_m", "rotate", NULL};
    struct ap_json_at at = ap_json_member(profile, "grip_from_aim");
    double p[3] = {0}, q[4] = {0, 0, 0, 1};
    enum ap_status st = ap_json_check_keys(err, &at, keys);
    if (!st && ap_json_has(&at, "position_m"))
        st = ap_json_numbers(err, &at, "position_m", 3, p);
    if (!st && ap_json_has(&at, "rotate"))
        st = ap_json_numbers(err, &at, "rotate", 4, q);
    if (st)
        return st;
    struct ap_json_at position = ap_json_member(&at, "position_m");
    for (int i = 0; i < 3; i++)
        if (fabs(p[i]) > 1)
            return ap_json_fail(err, &position, "expected an offset of at most 1 m");
    struct ap_quat rotate = {q[0], q[1], q[2], q[3]};
    struct ap_json_at rotation = ap_json_member(&at, "rotate");
    if (!ap_quat_make_unit(&rotate))
        return ap_json_fail(err, &rotation, "expected a unit quaternion [x, y, z, w]");
    *pose = (struct ap_pose){{p[0], p[1], p[2]}, rotate};
    return AP_OK;
}

static enum ap_status read_name(struct ap_error *err, const struct ap_json_at *profile,
                                char name[128]) {
    const char *text;
    enum ap_status st = ap_json_string(err, profile, "name", &text);
    if (st)
        return st;
    struct ap_json_at at = ap_json_member(profile, "name");
    size_t n = strlen(text);
    if (n < 1 || n > 127 || n != json_string_length(at.value))
        return ap_json_fail(err, &at, "expected a name of 1 to 127 bytes");
    for (size_t i = 0; i < n; i++)
        if ((unsigned char)text[i] < ' ' || text[i] == 0x7f)
            return ap_json_fail(err, &at, "expected a name without control characters");
    memcpy(name, text, n + 1);
    return AP_OK;
}

enum ap_status ap_headset_parse(struct ap_error *err, const struct ap_json_at *at,
                                struct ap_headset_profile *profile) {
    static const char *const keys[] = {"name",          "refresh_hz", "ipd_m", "eyes",
                                       "grip_from_aim", "lens",       NULL};
    static const char *const eye_keys[] = {"left", "right", NULL};
    struct ap_headset_profile p = {.grip_from_aim = AP_POSE_IDENTITY};
    enum ap_status st = ap_json_check_keys(err, at, keys);
    if (!st)
        st = read_name(err, at, p.name);
    if (!st)
        st = read_in_range(err, at, "refresh_hz", 0, 10000, "a rate above 0, at most 10000",
                           &p.refresh_hz);
    if (!st)
        st = read_in_range(err, at, "ipd_m", 0, 1, "metres above 0, at most 1", &p.ipd_m);
    struct ap_json_at eyes = ap_json_member(at, "eyes");
    if (!st)
        st = ap_json_check_keys(err, &eyes, eye_keys);
    for (int i = 0; !st && i < 2; i++) {
        st = read_eye(err, &eyes, eye_keys[i], &p.eye[i]);
        if (!st && p.eye[i].lens.red_scale == 0) // an eye's own goes before the common one
            st = read_lens(err, at, &p.eye[i]);
    }
    if (!st && ap_json_has(at, "grip_from_aim"))
        st = read_aim(err, at, &p.grip_from_aim);
    if (!st)
        *profile = p;
    return st;
}

enum ap_status ap_headset_read(struct ap_error *err, const char *path,
                               struct ap_headset_profile *profile) {
    json_t *root;
    enum ap_status st = ap_json_read(err, path, &root);
    if (st)
        return st;
    struct ap_json_at at = ap_json_root(root, path);
    st = ap_headset_parse(err, &at, profile);
    json_decref(root);
    return st;
}

static json_t *eye_to_json(const struct ap_eye_profile *eye) {
    json_t *seen = NULL; // "o*" leaves out what is NULL
    if (eye->seen[2] > 0)
        seen = json_pack("{s:[f,f,f,f]}", "outside_ellipse", eye->seen[0], eye->seen[1],
                         eye->seen[2], eye->seen[3]);
    return json_pack("{s:[i,i], s:{s:f, s:f, s:f, s:f}, s:f, s:o*}", "resolution_px",
                     (int)eye->width_px, (int)eye->height_px, "fov_rad", "left", eye->left_rad,
                     "right", eye->right_rad, "up", eye->up_rad, "down", eye->down_rad, "yaw_rad",
                     eye->yaw_rad, "hidden_area", seen);
}

// NULL where the eye is, or without memory.
static json_t *with_lens(json_t *eye, const struct ap_lens *lens) {
    if (!eye || lens->red_scale == 0 ||
        json_object_set_new(eye, "lens", ap_lens_to_json(lens)) == 0)
        return eye;
    json_decref(eye);
    return NULL;
}

static bool is_identity(const struct ap_pose *p) {
    return p->p.x == 0 && p->p.y == 0 && p->p.z == 0 && p->q.x == 0 && p->q.y == 0 && p->q.z == 0 &&
           p->q.w == 1;
}

json_t *ap_headset_to_json(const struct ap_headset_profile *p) {
    // "o" takes the eyes over, and makes the whole NULL where one is.
    json_t *root = json_pack("{s:s, s:f, s:f, s:{s:o, s:o}}", "name", p->name, "refresh_hz",
                             p->refresh_hz, "ipd_m", p->ipd_m, "eyes", "left",
                             with_lens(eye_to_json(&p->eye[0]), &p->eye[0].lens), "right",
                             with_lens(eye_to_json(&p->eye[1]), &p->eye[1].lens));
    if (!root || is_identity(&p->grip_from_aim))
        return root;
    const struct ap_pose *a = &p->grip_from_aim;
    json_t *aim = json_pack("{s:[f,f,f], s:[f,f,f,f]}", "position_m", a->p.x, a->p.y, a->p.z,
                            "rotate", a->q.x, a->q.y, a->q.z, a->q.w);
    if (json_object_set_new(root, "grip_from_aim", aim) == 0)
        return root;
    json_decref(root);
    return NULL;
}

struct ap_pose ap_headset_aim(const struct ap_headset_profile *profile,
                              struct ap_pose room_from_grip) {
    // Untouched without an offset, so that aim and grip agree bit for bit.
    if (is_identity(&profile->grip_from_aim))
        return room_from_grip;
    return ap_pose_mul(room_from_grip, profile->grip_from_aim);
}

struct ap_pose ap_headset_view_from_eye(const struct ap_headset_profile *profile, int eye) {
    double half_ipd = profile->ipd_m / 2;
    return (struct ap_pose){
        {eye == 0 ? -half_ipd : half_ipd, 0, 0},
        ap_quat_from_axis_angle((struct ap_vec3){0, 1, 0}, profile->eye[eye].yaw_rad)};
}
