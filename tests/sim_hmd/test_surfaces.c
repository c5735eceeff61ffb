// Every kind of layer against its geometry in double, pixel by pixel: where the ray through the
// pixel's middle meets the surface, and the texel that lies there.

#include "tests/sim_hmd/stage.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { LAYER_W = 180, LAYER_H = 140, POSES = 30, TOLERANCE = 2 };

static const double PI = 3.14159265358979323846;

static uint32_t random_state = 7;
static double between(double low, double high) {
    random_state = random_state * 1664525u + 1013904223u;
    return low + (high - low) * (random_state >> 8) / 16777216.0;
}

static struct ap_quat some_turn(double most_rad) {
    struct ap_vec3 axis = {between(-1, 1), between(-1, 1), between(-1, 1)};
    return ap_quat_from_axis_angle(ap_vec3_normalize(axis), between(0, most_rad));
}

// ---- The reference

static bool meets_quad(const struct sim_layer *l, struct ap_vec3 o, struct ap_vec3 d,
                       double at[2]) {
    double t = -o.z / d.z;
    if (!(o.z > 0 && t > 0))
        return false;
    at[0] = (o.x + t * d.x) / l->width_m + 0.5;
    at[1] = 0.5 - (o.y + t * d.y) / l->height_m;
    return true;
}

// The farther place where the ray meets the cylinder or sphere, in radii. NAN: it grazes it.
static bool meets_round(const struct sim_layer *l, bool sphere, struct ap_vec3 o, struct ap_vec3 d,
                        struct ap_vec3 *p) {
    o = l->radius_m > 0 ? ap_vec3_scale(1 / l->radius_m, o) : (struct ap_vec3){0, 0, 0};
    double y = sphere ? 1 : 0;
    double a = d.x * d.x + y * d.y * d.y + d.z * d.z;
    double half = (o.x * d.x + y * o.y * d.y + o.z * d.z) / a;
    double rest = (o.x * o.x + y * o.y * o.y + o.z * o.z - 1) / a;
    double square = half * half - rest;
    if (square < 0)
        return false;
    double t = sqrt(square) - half;
    *p = ap_vec3_add(o, ap_vec3_scale(square < 1e-3 ? NAN : t, d));
    return square < 1e-3 || t > 0;
}

static bool meets(const struct sim_layer *l, struct ap_vec3 o, struct ap_vec3 d, double at[2]) {
    struct ap_vec3 p;
    switch (l->kind) {
    case SIM_LAYER_QUAD:
        return meets_quad(l, o, d, at);
    case SIM_LAYER_CYLINDER:
        if (!meets_round(l, false, o, d, &p))
            return false;
        at[0] = atan2(p.x, -p.z) / l->central_rad + 0.5;
        at[1] = 0.5 - p.y / l->height_radii;
        return true;
    case SIM_LAYER_EQUIRECT:
        if (!meets_round(l, true, o, d, &p))
            return false;
        at[0] = atan2(p.x, -p.z) / l->central_rad + 0.5;
        at[1] = (l->upper_rad - asin(fmin(fmax(p.y, -1), 1))) / (l->upper_rad - l->lower_rad);
        return true;
    default:
        return false;
    }
}

static struct ap_vec3 ray_of(const struct sim_frame *f, int eye, int i, int j) {
    const XrFovf *a = &f->fov[eye];
    double u = (i + 0.5) / W, t = (j + 0.5) / H;
    struct ap_vec3 d = {tan(a->angleLeft) + u * (tan(a->angleRight) - tan(a->angleLeft)),
                        tan(a->angleUp) + t * (tan(a->angleDown) - tan(a->angleUp)), -1};
    return ap_quat_rotate(f->stage_from_eye[eye].q, d);
}

static void lay_over(const struct sim_layer *l, const double c[4], double *out) {
    double alpha = l->blend_alpha ? c[3] : 1;
    for (int k = 0; k < 3 && !isnan(out[k]); k++)
        out[k] = fmin(
            c[k] * (l->blend_alpha && l->unpremultiplied ? alpha : 1) + (1 - alpha) * out[k], 1);
}

static bool goes_around(const struct sim_layer *l, const struct sim_layer_view *v) {
    return l->kind == SIM_LAYER_EQUIRECT && fabs(fabs(l->central_rad) - 2 * PI) < 1e-6 &&
           v->rect.extent.width == (int32_t)v->width_px;
}

// Between the middles of the last column and the first, where the sides meet: both, by distance.
static void texel_around(const struct sim_layer_view *v, const uint8_t *bytes, double x, double y,
                         double c[4]) {
    double past = x < 0.5 ? x + 0.5 : x - (v->width_px - 0.5), first[4];
    texel(v, bytes, x < 0.5 || past > 0 ? v->width_px - 0.5 : x, y, c);
    if (!(x < 0.5 || past > 0))
        return;
    texel(v, bytes, 0.5, y, first);
    for (int k = 0; k < 4; k++)
        c[k] += past * (first[k] - c[k]);
}

// Lays a layer over what is there. Pixels whose middle is at the very edge become NaN: how many.
static int reference(const struct sim_frame *f, int eye, const struct sim_layer *l,
                     const uint8_t *bytes, double *linear) {
    const struct sim_layer_view *v = &l->view[eye];
    struct ap_quat back = ap_quat_conj(v->stage_from_view.q);
    struct ap_vec3 o =
        ap_quat_rotate(back, ap_vec3_sub(f->stage_from_eye[eye].p, v->stage_from_view.p));
    int doubtful = 0;
    for (int j = 0; j < H; j++)
        for (int i = 0; i < W; i++) {
            double at[2], *out = linear + 3 * (j * W + i);
            if (l->hidden[eye] || !meets(l, o, ap_quat_rotate(back, ray_of(f, eye, i, j)), at))
                continue;
            bool around = goes_around(l, v);
            double across = around ? 1 : fmin(at[0], 1 - at[0]);
            double edge = fmin(across, fmin(at[1], 1 - at[1]));
            if (isnan(at[0]) || fabs(edge) <= 1e-4) {
                out[0] = out[1] = out[2] = NAN;
                doubtful++;
            } else if (edge > 0) {
                double c[4];
                (around ? texel_around
                        : texel)(v, bytes, v->rect.offset.x + at[0] * v->rect.extent.width,
                                 v->rect.offset.y + at[1] * v->rect.extent.height, c);
                lay_over(l, c, out);
            }
        }
    return doubtful;
}

static void below_is(const uint8_t *bytes, double *linear) {
    for (int k = 0; k < 3 * W * H; k++)
        linear[k] = ap_linear_from_srgb(bytes[k / 3 * 4 + k % 3]);
}

// ---- The frames

struct pictures {
    struct picture below, above;
    uint8_t *below_bytes, *above_bytes;
    struct sim_compositor *c;
};

static void open_pictures(struct pictures *p) {
    p->below = make_picture(VK_FORMAT_R8G8B8A8_SRGB, W, H, 1, 1);
    p->above = make_picture(VK_FORMAT_R8G8B8A8_SRGB, LAYER_W, LAYER_H, 1, 1);
    p->below_bytes = smooth(W, H);
    p->above_bytes = smooth(LAYER_W, LAYER_H);
    for (int k = 0; k < LAYER_W * LAYER_H * 4; k += 4) { // another picture, its own alpha
        p->above_bytes[k] = (uint8_t)(255 - p->above_bytes[k]);
        p->above_bytes[k + 1] = (uint8_t)(255 - p->above_bytes[k + 1]);
    }
    upload(&p->below, p->below_bytes, 4);
    upload(&p->above, p->above_bytes, 4);
    p->c = create();
}

static void close_pictures(struct pictures *p) {
    sim_compositor_destroy(p->c);
    free_picture(&p->below);
    free_picture(&p->above);
    free(p->below_bytes);
    free(p->above_bytes);
}

// A frame with the picture below at the display, and over it a layer that the caller shapes.
static struct sim_layer *stacked(struct pictures *p, int k, struct sim_frame *f) {
    *f = new_frame(k);
    add_layer(f, &p->below);
    struct sim_layer *l = add_layer(f, &p->above);
    l->blend_alpha = k % 3 > 0;
    l->unpremultiplied = k % 3 == 2;
    l->hidden[1] = k % 7 == 6;
    for (int eye = 0; eye < 2; eye++) {
        l->view[eye].at_display = false;
        l->view[eye].rect = (XrRect2Di){{k % 30, k % 20}, {LAYER_W - 30, LAYER_H - 20}};
    }
    return l;
}

static void place(struct sim_layer *l, struct ap_pose stage_from_layer) {
    l->view[0].stage_from_view = l->view[1].stage_from_view = stage_from_layer;
}

static void check(struct pictures *p, const struct sim_frame *f) {
    static double linear[2][3 * W * H];
    int doubtful = 0;
    for (int eye = 0; eye < 2; eye++) {
        below_is(p->below_bytes, linear[eye]);
        doubtful += reference(f, eye, &f->layer[1], p->above_bytes, linear[eye]);
    }
    assert_true(doubtful < 2 * W * H / 50);
    submit(p->c, f);
    flush(p->c);
    for (int eye = 0; eye < 2; eye++)
        compare(f->index, eye, linear[eye], TOLERANCE);
}

// Somewhere before the eyes or beside them, turned by up to so much from facing them.
static struct ap_pose before(const struct sim_frame *f, double near_m, double far_m,
                             double most_rad) {
    struct ap_vec3 d = {between(-0.6, 0.6), between(-0.5, 0.5), -1};
    d = ap_vec3_scale(between(near_m, far_m), d);
    struct ap_pose eye = f->stage_from_eye[0];
    return (struct ap_pose){ap_pose_apply(eye, d), ap_quat_mul(eye.q, some_turn(most_rad))};
}

static void quads(void **state) {
    (void)state;
    struct pictures p;
    open_pictures(&p);
    for (int k = 0; k < POSES; k++) {
        struct sim_frame f;
        struct sim_layer *l = stacked(&p, k, &f);
        l->kind = SIM_LAYER_QUAD;
        l->width_m = between(0.1, 3);
        l->height_m = between(0.1, 2);
        place(l, before(&f, 0.05, 3, k < 20 ? 1.2 : PI)); // some from behind, some around the head
        check(&p, &f);
    }
    close_pictures(&p);
}

static void cylinders(void **state) {
    (void)state;
    struct pictures p;
    open_pictures(&p);
    for (int k = 0; k < POSES; k++) {
        struct sim_frame f;
        struct sim_layer *l = stacked(&p, k, &f);
        l->kind = SIM_LAYER_CYLINDER;
        l->radius_m = k % 5 == 0 ? 0 : between(0.3, 3);
        l->central_rad = between(0.2, k % 4 ? 3 : 6.2);
        l->height_radii = between(0.2, 4);
        // From inside, beside and far outside.
        place(l, before(&f, -0.5, 2, 1.5));
        check(&p, &f);
    }
    close_pictures(&p);
}

static void spheres(void **state) {
    (void)state;
    struct pictures p;
    open_pictures(&p);
    for (int k = 0; k < 2 * POSES; k++) {
        struct sim_frame f;
        struct sim_layer *l = stacked(&p, k, &f);
        l->kind = SIM_LAYER_EQUIRECT;
        l->radius_m = k % 5 == 0 ? 0 : between(0.3, 3);
        l->central_rad = k % 3 ? between(0.2, 2 * PI) : 2 * PI;
        l->upper_rad = k % 4 ? between(0, PI / 2) : PI / 2;
        l->lower_rad = k % 4 ? between(-PI / 2, l->upper_rad - 0.05) : -PI / 2;
        if (k % 11 == 10)
            l->central_rad = -l->central_rad; // mirrored
        place(l, before(&f, -0.5, 2, PI));
        check(&p, &f);
    }
    close_pictures(&p);
}

// The sides of a picture that goes all around meet without a seam, and nothing is torn at the
// poles. The picture's two sides are as different as can be.
static void seams(void **state) {
    (void)state;
    struct pictures p;
    open_pictures(&p);
    for (int k = 0; k < POSES; k++) {
        struct sim_frame f;
        struct sim_layer *l = stacked(&p, k, &f);
        l->kind = SIM_LAYER_EQUIRECT;
        l->blend_alpha = false;
        l->radius_m = k % 3 == 0 ? 0 : between(2, 4);
        l->central_rad = k % 5 == 4 ? -2 * PI : 2 * PI;
        l->upper_rad = k % 2 ? PI / 2 : between(0.3, 1);
        l->lower_rad = k % 2 ? -PI / 2 : between(-1, -0.3);
        for (int eye = 0; eye < 2; eye++) {
            l->hidden[eye] = false;
            l->view[eye].rect = k % 4 < 2 ? (XrRect2Di){{0, 0}, {LAYER_W, LAYER_H}}
                                          : (XrRect2Di){{0, LAYER_H / 2}, {LAYER_W, LAYER_H / 2}};
        }
        // Behind the eyes' back is before them; every third looks at a pole.
        struct ap_quat back = ap_quat_from_axis_angle((struct ap_vec3){0, 1, 0}, PI + 0.3);
        struct ap_quat up = ap_quat_from_axis_angle((struct ap_vec3){1, 0, 0}, k % 2 ? 1.5 : -1.5);
        struct ap_pose eye = f.stage_from_eye[0];
        eye.q = ap_quat_mul(eye.q, k % 3 == 1 ? up : ap_quat_mul(back, some_turn(0.5)));
        place(l, eye);
        check(&p, &f);
    }
    close_pictures(&p);
}

// Many layers at once, large and small, so that some are laid within one draw and some are not.
static void stacks(void **state) {
    (void)state;
    struct pictures p;
    open_pictures(&p);
    for (int k = 0; k < 12; k++) {
        static double linear[2][3 * W * H];
        struct sim_frame f;
        stacked(&p, k, &f);
        f.layer_count = 1;
        for (int eye = 0; eye < 2; eye++)
            below_is(p.below_bytes, linear[eye]);
        while (f.layer_count < 9) {
            struct sim_layer *l = add_layer(&f, &p.above);
            l->kind = f.layer_count % 3 == 0   ? SIM_LAYER_QUAD
                      : f.layer_count % 3 == 1 ? SIM_LAYER_CYLINDER
                                               : SIM_LAYER_EQUIRECT;
            l->blend_alpha = f.layer_count != 4;
            l->unpremultiplied = true;
            l->width_m = l->height_m = between(0.3, 5);
            l->radius_m = between(2, 4);
            l->central_rad = between(1, 2 * PI);
            l->height_radii = between(1, 4);
            l->upper_rad = between(0.5, PI / 2);
            l->lower_rad = between(-PI / 2, -0.5);
            l->view[0].at_display = l->view[1].at_display = false;
            place(l, before(&f, 0.1, 1.5, 0.6));
            for (int eye = 0; eye < 2; eye++)
                reference(&f, eye, l, p.above_bytes, linear[eye]);
        }
        submit(p.c, &f);
        flush(p.c);
        for (int eye = 0; eye < 2; eye++)
            compare(k, eye, linear[eye], TOLERANCE);
    }
    close_pictures(&p);
}

// ---- Cubes: a colour that is a smooth function of the direction

static void colour_of(struct ap_vec3 d, uint8_t out[4]) {
    d = ap_vec3_normalize(d);
    out[0] = (uint8_t)(127.5 + 100 * d.x);
    out[1] = (uint8_t)(127.5 + 100 * d.y);
    out[2] = (uint8_t)(127.5 + 100 * d.z);
    out[3] = (uint8_t)(160 + 60 * d.x * d.y);
}

// As Vulkan's table of cube map faces has it: s and t from −1 to 1.
static struct ap_vec3 cube_direction(int face, double s, double t) {
    const struct ap_vec3 d[6] = {{1, -t, -s}, {-1, -t, s}, {s, 1, t},
                                 {s, -1, -t}, {s, -t, 1},  {-s, -t, -1}};
    return d[face];
}

enum { FACE = 96 };

static struct picture make_sky(uint32_t count) {
    struct picture p = make_cube(VK_FORMAT_R8G8B8A8_SRGB, FACE, count);
    uint8_t *bytes = calloc((size_t)6 * count * FACE * FACE, 4);
    assert_non_null(bytes);
    // All cubes but the last are black.
    uint8_t *to = bytes + (size_t)6 * (count - 1) * FACE * FACE * 4;
    for (int k = 0; k < 6 * FACE * FACE; k++) {
        double s = 2 * (k % FACE + 0.5) / FACE - 1, t = 2 * (k / FACE % FACE + 0.5) / FACE - 1;
        colour_of(cube_direction(k / (FACE * FACE), s, t), to + 4 * k);
    }
    upload(&p, bytes, 4);
    free(bytes);
    return p;
}

static void cubes(void **state) {
    (void)state;
    struct pictures p;
    open_pictures(&p);
    struct picture sky = make_sky(2);
    static double linear[3 * W * H];
    for (int k = 0; k < 12; k++) {
        struct sim_frame f = new_frame(k);
        add_layer(&f, &p.below);
        struct sim_layer *l = add_layer(&f, &sky);
        l->kind = SIM_LAYER_CUBE;
        l->blend_alpha = k % 3 > 0;
        l->unpremultiplied = k % 3 == 2;
        struct ap_pose pose = {{1, 2, 3}, some_turn(PI)}; // the place is no part of it
        for (int eye = 0; eye < 2; eye++)
            l->view[eye].array_layer = 6;
        place(l, pose);
        submit(p.c, &f);
        flush(p.c);
        for (int eye = 0; eye < 2; eye++) {
            below_is(p.below_bytes, linear);
            for (int i = 0; i < W * H; i++) {
                struct ap_vec3 d = ray_of(&f, eye, i % W, i / W);
                uint8_t b[4];
                colour_of(ap_quat_rotate(ap_quat_conj(pose.q), d), b);
                const double c[4] = {ap_linear_from_srgb(b[0]), ap_linear_from_srgb(b[1]),
                                     ap_linear_from_srgb(b[2]), b[3] / 255.0};
                lay_over(l, c, linear + 3 * i);
            }
            compare(k, eye, linear, TOLERANCE);
        }
    }
    free_picture(&sky);
    close_pictures(&p);
}

// A plane seen smaller than its image shows the mip of its size, and none where it is seen larger.
static void mips(void **state) {
    (void)state;
    static const float colours[3][4] = {{1, 0, 0, 1}, {0, 1, 0, 1}, {0, 0, 1, 1}};
    struct sim_compositor *c = create();
    // Half as wide again as the display's picture, so that a pixel is so many of the image's.
    for (int k = 0; k < 3; k++) {
        struct sim_frame f = new_frame(k);
        const XrFovf *fov = &f.fov[0];
        double width = tan((double)fov->angleRight) - tan((double)fov->angleLeft);
        double height = tan((double)fov->angleUp) - tan((double)fov->angleDown);
        struct picture p = make_mips(VK_FORMAT_R8G8B8A8_SRGB, W * 3 / 2 << k, H * 3 / 2 << k, 3);
        for (uint32_t mip = 0; mip < 3; mip++)
            fill(&p, mip, colours[mip]);
        struct sim_layer *l = add_layer(&f, &p);
        l->kind = SIM_LAYER_QUAD;
        l->width_m = 1.5 * width;
        l->height_m = 1.5 * height;
        f.stage_from_eye[1] = f.stage_from_eye[0];
        struct ap_pose eye = f.stage_from_eye[0];
        place(l, (struct ap_pose){ap_pose_apply(eye, (struct ap_vec3){0, 0, -1}), eye.q});
        submit(c, &f);
        flush(c);
        static double linear[3 * W * H];
        for (int i = 0; i < 3 * W * H; i++)
            linear[i] = (double)colours[k][i % 3];
        compare(k, 0, linear, 24); // devices blend the mips around by their own idea of a logarithm
        compare(k, 1, linear, 24);
        free_picture(&p);
    }
    sim_compositor_destroy(c);
}

// ---- What need not be done is not done

// An opaque layer over the whole eye hides what is below; what is out of sight is left out; so one
// layer is left, which is copied.
static void what_is_hidden_costs_nothing(void **state) {
    (void)state;
    struct pictures p;
    open_pictures(&p);
    struct sim_frame f = new_frame(3);
    struct sim_layer *behind = add_layer(&f, &p.above);
    behind->kind = SIM_LAYER_QUAD;
    behind->width_m = behind->height_m = 1;
    place(behind, f.stage_from_eye[0]);
    add_layer(&f, &p.below);
    struct sim_layer *back = add_layer(&f, &p.above);
    back->kind = SIM_LAYER_QUAD;
    back->width_m = back->height_m = 1;
    place(back, (struct ap_pose){{0, 0, 5}, AP_QUAT_IDENTITY}); // behind the head
    struct sim_layer *other = add_layer(&f, &p.above);
    other->hidden[0] = other->hidden[1] = true;
    submit(p.c, &f);
    flush(p.c);
    assert_int_equal(sim_compositor_stats(p.c).copied, 2);
    assert_int_equal(sim_compositor_stats(p.c).composed, 0);
    for (int eye = 0; eye < 2; eye++) {
        static double linear[3 * W * H];
        below_is(p.below_bytes, linear);
        compare(3, eye, linear, 0);
    }
    close_pictures(&p);
}

// Shapes that are nothing, or far too much, draw nothing or something, and break nothing.
static void odd_shapes(void **state) {
    (void)state;
    struct pictures p;
    open_pictures(&p);
    const double odd[] = {0, 1e-30, 1e-6, 1e6, 1e30};
    int n = 0;
    for (int kind = SIM_LAYER_QUAD; kind <= SIM_LAYER_EQUIRECT; kind++)
        for (int k = 0; k < 5; k++) {
            struct sim_frame f;
            struct sim_layer *l = stacked(&p, n, &f);
            l->kind = (enum sim_layer_kind)kind;
            l->width_m = l->height_m = l->radius_m = odd[k];
            l->central_rad = fmin(odd[k], 6);
            l->height_radii = odd[k];
            l->upper_rad = fmin(odd[k], 1);
            place(l, before(&f, 0.5, 2, 1));
            f.index = n++;
            submit(p.c, &f);
            flush(p.c);
            for (int eye = 0; eye < 2; eye++) {
                struct ap_image image = read_picture(f.index, eye);
                ap_image_finish(&image);
            }
        }
    close_pictures(&p);
}

int main(void) {
    if (!stage_open())
        return 77;
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(quads),      cmocka_unit_test(cylinders),
        cmocka_unit_test(spheres),    cmocka_unit_test(seams),
        cmocka_unit_test(stacks),     cmocka_unit_test(cubes),
        cmocka_unit_test(mips),       cmocka_unit_test(what_is_hidden_costs_nothing),
        cmocka_unit_test(odd_shapes), cmocka_unit_test(validation_is_silent),
    };
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    stage_close();
    return failed;
}
