// clang-format off
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>
// clang-format on
#include "tests/app/page/synth.h"

#include <dirent.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "src/base/file.h"
#include "src/base/number.h"

char *synth_folder(void) {
    char *dir = strdup("/tmp/antipode-page-XXXXXX");
    assert_non_null(dir);
    assert_non_null(mkdtemp(dir));
    return dir;
}

void synth_remove(char *dir) {
    DIR *d = opendir(dir);
    assert_non_null(d);
    for (struct dirent *e; (e = readdir(d));) {
        char *path = synth_path(dir, e->d_name);
        unlink(path); // fails for "." and "..", which is as well
        free(path);
    }
    closedir(d);
    rmdir(dir);
    free(dir);
}

char *synth_path(const char *dir, const char *name) {
    char *path = ap_path_join(dir, name);
    assert_non_null(path);
    return path;
}

void synth_write_text(const char *dir, const char *name, const char *text) {
    char *path = synth_path(dir, name);
    assert_int_equal(ap_file_write(NULL, path, text, strlen(text)), AP_OK);
    free(path);
}

char *synth_read_text(const char *dir, const char *name) {
    char *path = synth_path(dir, name), *text = NULL;
    size_t len;
    struct ap_error err = {""};
    if (ap_file_read(&err, path, (size_t)64 << 20, &text, &len))
        fail_msg("%s", err.text);
    free(path);
    return text;
}

static struct ap_eye_profile synth_eye(double left_rad, double right_rad, double yaw_rad) {
    return (struct ap_eye_profile){.width_px = 300,
                                   .height_px = 280,
                                   .left_rad = left_rad,
                                   .right_rad = right_rad,
                                   .up_rad = 0.65,
                                   .down_rad = -0.7,
                                   .yaw_rad = yaw_rad};
}

struct ap_headset_profile synth_headset(void) {
    return (struct ap_headset_profile){
        .name = "synthetic",
        .refresh_hz = 90,
        .ipd_m = 0.064,
        .eye = {synth_eye(-0.75, 0.6, 0.06), synth_eye(-0.6, 0.75, -0.06)},
        .grip_from_aim = AP_POSE_IDENTITY};
}

static struct ap_pose head_pose(int64_t frame) {
    struct ap_quat turn =
        ap_quat_from_axis_angle((struct ap_vec3){0, 1, 0}, 0.02 * sin(0.3 * (double)frame));
    struct ap_quat nod =
        ap_quat_from_axis_angle((struct ap_vec3){1, 0, 0}, -0.01 * (double)(frame % 7));
    return (struct ap_pose){{0.01 * (double)frame, 0.8, 0.7 + 0.01 * cos((double)frame)},
                            ap_quat_mul(turn, nod)};
}

struct ap_capture synth_capture(const char *dir, struct ap_space space, enum ap_view_mode view,
                                int frames) {
    struct ap_capture c = {.dir = strdup(dir),
                           .space = space,
                           .view = view,
                           .headset = synth_headset(),
                           .tracker = "billiards",
                           .log_name = "walk.csv",
                           .total_frames = frames,
                           .table_edge_m = 0.9,
                           .table_height_m = 0.75,
                           .has_table = true};
    c.targets = calloc(16, sizeof *c.targets);
    c.frames = calloc((size_t)frames, sizeof *c.frames);
    assert_non_null(c.targets);
    assert_non_null(c.frames);
    for (int64_t k = 0; k < frames; k += 2) {
        struct ap_capture_frame *f = &c.frames[c.frame_count++];
        f->frame = k;
        f->t_ns = 1000 + k * 11111111;
        f->table_from_head = head_pose(k);
        f->world_from_head = ap_iso_from_pose(space, f->table_from_head);
    }
    return c;
}

void synth_target(struct ap_capture *c, const char *name, const uint8_t color[3],
                  struct ap_vec3 nose_m, double radius_m) {
    struct ap_capture_target *t = &c->targets[c->target_count++];
    snprintf(t->name, sizeof t->name, "%s", name);
    memcpy(t->color, color, 3);
    t->at = ap_iso_apply(&c->frames[0].world_from_head, ap_exp(c->space, nose_m));
    t->radius_m = radius_m;
}

static void write_row(FILE *f, const struct ap_capture *c, int64_t frame, const char *device,
                      struct ap_pose pose) {
    struct ap_iso world = ap_iso_from_pose(c->space, pose);
    double n[23] = {pose.p.x, pose.p.y, pose.p.z, pose.q.x, pose.q.y, pose.q.z, pose.q.w};
    memcpy(n + 7, world.m, sizeof world.m);
    fprintf(f, "%" PRId64 ",%" PRId64 ",%s,exact", frame, 1000 + frame * 11111111, device);
    for (int i = 0; i < 23; i++) {
        char text[AP_DOUBLE_TEXT_MAX];
        ap_format_double(text, n[i]);
        fprintf(f, ",%s", text);
    }
    fprintf(f, "\n");
}

static void write_frames(const struct ap_capture *c) {
    char *path = synth_path(c->dir, "frames.csv");
    FILE *f = fopen(path, "wb");
    assert_non_null(f);
    fprintf(f, "frame,t_ns,device,state,px,py,pz,qx,qy,qz,qw,m00,m01,m02,m03,m10,m11,m12,m13,"
               "m20,m21,m22,m23,m30,m31,m32,m33\n");
    for (int64_t k = 0; k < c->total_frames; k++) {
        struct ap_pose hand = {{0.2, -0.4, -0.3}, AP_QUAT_IDENTITY};
        write_row(f, c, k, "head", head_pose(k));
        write_row(f, c, k, "right", ap_pose_mul(head_pose(k), hand));
    }
    fclose(f);
    free(path);
}

// How far beyond the ball's edge a sight line passes at its nearest, in metres (native) or radians
// (tourist); negative inside.
struct sight_line {
    const struct ap_capture *c;
    struct ap_viewer viewer;
    int eye;
    struct ap_vec4 nose_centre;
    double radius_m, reach_m, half_angle;
    struct ap_vec3 eye_direction; // of the centre, tourist
    int image;
};

// x + t·d in tangent space, and how far its exp is from the centre.
static double distance_at(const struct sight_line *s, struct ap_vec3 d, double t) {
    struct ap_vec3 x = ap_vec3_add(s->viewer.eye[s->eye].view_from_eye.p, ap_vec3_scale(t, d));
    struct ap_vec4 p = ap_exp(s->c->space, x), q = s->nose_centre;
    double r = s->c->space.rho_m;
    if (s->c->space.kappa > 0) {
        double n = sqrt((p.x - q.x) * (p.x - q.x) + (p.y - q.y) * (p.y - q.y) +
                        (p.z - q.z) * (p.z - q.z) + (p.w - q.w) * (p.w - q.w));
        return 2 * r * asin(fmin(1, n / (2 * r)));
    }
    if (s->c->space.kappa == 0)
        return ap_vec3_length((struct ap_vec3){p.x - q.x, p.y - q.y, p.z - q.z});
    double n = (p.x - q.x) * (p.x - q.x) + (p.y - q.y) * (p.y - q.y) + (p.z - q.z) * (p.z - q.z) -
               (p.w - q.w) * (p.w - q.w);
    return 2 * r * asinh(sqrt(fmax(0, n)) / (2 * r));
}

static double beyond(const struct sight_line *s, double a, double b) {
    struct ap_vec3 d = ap_vec3_normalize((struct ap_vec3){a, b, -1});
    if (s->c->view == AP_VIEW_TOURIST) {
        struct ap_vec3 x = ap_vec3_cross(d, s->eye_direction);
        return atan2(ap_vec3_length(x), ap_vec3_dot(d, s->eye_direction)) - s->half_angle;
    }
    d = ap_quat_rotate(s->viewer.eye[s->eye].view_from_eye.q, d);
    // Golden section round the place where the centre is: one minimum there.
    double lo = fmax(0, s->reach_m - 3 * s->radius_m), hi = s->reach_m + 3 * s->radius_m;
    const double g = 0.6180339887498949;
    double t1 = hi - g * (hi - lo), t2 = lo + g * (hi - lo);
    double f1 = distance_at(s, d, t1), f2 = distance_at(s, d, t2);
    for (int k = 0; k < 15; k++) {
        if (f1 < f2) {
            hi = t2, t2 = t1, f2 = f1;
            t1 = hi - g * (hi - lo);
            f1 = distance_at(s, d, t1);
        } else {
            lo = t1, t1 = t2, f1 = f2;
            t2 = lo + g * (hi - lo);
            f2 = distance_at(s, d, t2);
        }
    }
    return fmin(f1, f2) - s->radius_m;
}

static struct sight_line line_to(const struct ap_capture *c, size_t frame, int eye,
                                 struct ap_vec4 at, double radius_m) {
    struct sight_line s = {
        .c = c, .viewer = ap_capture_viewer(c, frame), .eye = eye, .radius_m = radius_m};
    struct ap_iso nose_from_world = ap_iso_inverse(c->space, s.viewer.world_from_nose);
    s.nose_centre = ap_iso_apply(&nose_from_world, at);
    s.image = c->space.kappa > 0 && s.nose_centre.z > 0;
    s.reach_m = ap_vec3_length(ap_log_unchecked(c->space, s.nose_centre, s.image));
    struct ap_pose v = s.viewer.eye[eye].view_from_eye;
    struct ap_iso eye_from_nose = ap_iso_inverse(c->space, ap_iso_from_pose(c->space, v));
    struct ap_vec4 e = ap_iso_apply(&eye_from_nose, s.nose_centre);
    s.eye_direction = ap_vec3_scale(s.image ? -1 : 1, (struct ap_vec3){e.x, e.y, e.z});
    double r = radius_m / c->space.rho_m, n = ap_vec3_length(s.eye_direction) / c->space.rho_m;
    s.half_angle = asin(fmin(1, ap_space_sin(c->space, r) / n));
    return s;
}

void synth_draw(const struct ap_capture *c, size_t frame, int eye, const uint8_t color[3],
                struct ap_vec4 at, double radius_m, struct ap_image *image) {
    enum { SUB = 8 };
    struct sight_line s = line_to(c, frame, eye, at, radius_m);
    struct ap_frustum f = s.viewer.eye[eye].frustum;
    double da = (f.right - f.left) / image->width, db = (f.up - f.down) / image->height;
    // Metres (or radians) that a pixel spans there, taken large.
    double px = 1.2 * fmax(da, db) * (c->view == AP_VIEW_TOURIST ? 1 : s.reach_m);
    struct ap_vec3 middle_of = ap_vec3_normalize(s.eye_direction);
    double near = cos(fmin(1.5, 2.5 * s.half_angle + 0.1)); // generous; the rest is not looked at
    for (uint32_t y = 0; y < image->height; y++)
        for (uint32_t x = 0; x < image->width; x++) {
            struct ap_vec3 d = {f.left + (x + 0.5) * da, f.up - (y + 0.5) * db, -1};
            if (ap_vec3_dot(ap_vec3_normalize(d), middle_of) < near)
                continue;
            double middle = beyond(&s, d.x, d.y);
            double covered = middle < 0;
            if (fabs(middle) < px) {
                int n = 0;
                for (int k = 0; k < SUB * SUB; k++)
                    n += beyond(&s, f.left + (x + (k % SUB + 0.5) / SUB) * da,
                                f.up - (y + (k / SUB + 0.5) / SUB) * db) < 0;
                covered = (double)n / (SUB * SUB);
            }
            uint8_t *p = image->rgb + ((size_t)y * image->width + x) * 3;
            for (int k = 0; k < 3 && covered > 0; k++)
                p[k] = ap_srgb_from_linear(covered * ap_linear_from_srgb(color[k]) +
                                           (1 - covered) * ap_linear_from_srgb(p[k]));
        }
}

void synth_write(const struct ap_capture *c) {
    struct ap_error err = {""};
    if (ap_capture_write(&err, c->dir, c))
        fail_msg("%s", err.text);
    write_frames(c);
    for (size_t k = 0; k < c->frame_count; k++)
        for (int e = 0; e < 2; e++) {
            struct ap_image image = {0};
            const struct ap_eye_profile *eye = &c->headset.eye[e];
            assert_int_equal(ap_image_create(&err, eye->width_px, eye->height_px, &image), AP_OK);
            for (size_t t = 0; t < c->target_count; t++)
                synth_draw(c, k, e, c->targets[t].color, c->targets[t].at, c->targets[t].radius_m,
                           &image);
            char *path =
                ap_capture_picture_path(c, c->frames[k].frame, e ? "right.png" : "left.png");
            if (ap_png_write(&err, path, &image))
                fail_msg("%s", err.text);
            free(path);
            ap_image_finish(&image);
        }
}
