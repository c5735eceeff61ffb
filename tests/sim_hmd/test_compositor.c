// Frames handed to the compositor on a headless device, its pictures read back from disk.

#include "tests/sim_hmd/stage.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "sim_hmd/window/input.h"
#include "src/base/file.h"

// ---- The reference: shaders/composite.frag in double

// Lays one layer over what is there; bytes are those of its image.
static void reference(const struct sim_frame *f, int eye, const struct sim_layer *layer,
                      const uint8_t *bytes, double *linear) {
    const struct sim_layer_view *v = &layer->view[eye];
    const XrFovf *a = &f->fov[eye], *b = &v->fov;
    for (int j = 0; j < H; j++)
        for (int i = 0; i < W; i++) {
            double u = (i + 0.5) / W, t = (j + 0.5) / H;
            struct ap_vec3 d = {tan(a->angleLeft) + u * (tan(a->angleRight) - tan(a->angleLeft)),
                                tan(a->angleUp) + t * (tan(a->angleDown) - tan(a->angleUp)), -1};
            d = ap_quat_rotate(f->stage_from_eye[eye].q, d);
            d = ap_quat_rotate(ap_quat_conj(v->stage_from_view.q), d);
            double x = (d.x / -d.z - tan(b->angleLeft)) / (tan(b->angleRight) - tan(b->angleLeft));
            double y = (tan(b->angleUp) - d.y / -d.z) / (tan(b->angleUp) - tan(b->angleDown));
            if (d.z >= 0 || x < 0 || x > 1 || y < 0 || y > 1)
                continue;
            double c[4];
            texel(v, bytes, v->rect.offset.x + x * v->rect.extent.width,
                  v->rect.offset.y + y * v->rect.extent.height, c);
            double alpha = layer->blend_alpha ? c[3] : 1;
            double *out = linear + 3 * (j * W + i);
            for (int k = 0; k < 3; k++)
                out[k] = c[k] * (layer->blend_alpha && layer->unpremultiplied ? alpha : 1) +
                         (1 - alpha) * out[k];
        }
}

// ---- Tests

static void copies_bit_for_bit(void **state) {
    (void)state;
    const VkFormat formats[] = {VK_FORMAT_R8G8B8A8_SRGB, VK_FORMAT_B8G8R8A8_SRGB};
    for (int k = 0; k < 2; k++) {
        // A larger image of two layers; each eye a rectangle in its own layer.
        enum { BIG_W = W + 13, BIG_H = H + 9, AT_X = 7, AT_Y = 4 };
        struct picture p = make_picture(formats[k], BIG_W, BIG_H, 2, 1);
        uint8_t *bytes = noise((size_t)BIG_W * BIG_H * 4 * 2);
        upload(&p, bytes, 4);
        struct sim_compositor *c = create();
        struct sim_frame f = new_frame(k);
        add_layer(&f, &p);
        for (int eye = 0; eye < 2; eye++)
            f.layer[0].view[eye].rect = (XrRect2Di){{AT_X, AT_Y}, {W, H}};
        submit(c, &f);
        flush(c);
        assert_int_equal(sim_compositor_stats(c).copied, 2);
        assert_int_equal(sim_compositor_stats(c).composed, 0);
        sim_compositor_destroy(c);
        for (int eye = 0; eye < 2; eye++) {
            struct ap_image image = read_picture(k, eye);
            for (int i = 0; i < W * H * 3; i++) {
                int x = i / 3 % W + AT_X, y = i / 3 / W + AT_Y, channel = i % 3;
                size_t at = (((size_t)eye * BIG_H + (size_t)y) * BIG_W + (size_t)x) * 4;
                assert_int_equal(image.rgb[i],
                                 bytes[at + (size_t)(k == 1 ? 2 - channel : channel)]);
            }
            ap_image_finish(&image);
        }
        ap_gpu_image_destroy(&gpu, &p.image);
        free(bytes);
    }
}

static void nobody_looks(void **state) {
    (void)state;
    struct sim_compositor *c = create();
    struct sim_frame f = new_frame(5);
    f.capture = false;
    f.layer_count = 1; // its handles are null: touching them would be a crash
    for (int k = 0; k < 100; k++)
        submit(c, &f);
    assert_int_equal(sim_compositor_stats(c).skipped, 100);
    assert_int_equal(sim_compositor_stats(c).copied + sim_compositor_stats(c).composed, 0);
    assert_false(sim_compositor_wants_frames(c));
    struct sim_window_input input;
    assert_false(sim_compositor_input(c, &input));
    flush(c);
    sim_compositor_destroy(c);
    assert_false(ap_file_exists(path_of(5, 0)));
    sim_compositor_destroy(NULL);
}

static void no_layer_is_black(void **state) {
    (void)state;
    static const double black[3 * W * H];
    struct sim_compositor *c = create();
    struct sim_frame f = new_frame(1);
    submit(c, &f);
    sim_compositor_destroy(c); // which drains
    compare(1, 0, black, 0);
    compare(1, 1, black, 0);
}

// UNORM and float images hold linear light.
static void linear_formats(void **state) {
    (void)state;
    static double linear[3 * W * H];
    uint8_t *bytes = noise((size_t)W * H * 4);
    static float wide[4 * W * H];
    for (int k = 0; k < 4 * W * H; k++) {
        wide[k] = bytes[k] / 200.0f - 0.1f;
        if (k % 4 < 3)
            linear[k / 4 * 3 + k % 4] = bytes[k] / 255.0;
    }
    struct sim_compositor *c = create();
    struct picture unorm = make_picture(VK_FORMAT_R8G8B8A8_UNORM, W, H, 1, 1);
    struct picture real = make_picture(VK_FORMAT_R32G32B32A32_SFLOAT, W, H, 1, 1);
    upload(&unorm, bytes, 4);
    upload(&real, wide, 16);
    struct sim_frame f = new_frame(1), g = new_frame(2);
    add_layer(&f, &unorm);
    add_layer(&g, &real);
    submit(c, &f);
    submit(c, &g);
    flush(c);
    compare(1, 0, linear, 1);
    compare(1, 1, linear, 1);
    for (int k = 0; k < 4 * W * H; k++)
        if (k % 4 < 3)
            linear[k / 4 * 3 + k % 4] = (double)wide[k];
    compare(2, 0, linear, 1);
    compare(2, 1, linear, 1);
    // A layer's values are cut to 0…1 before they are laid over another's.
    struct sim_frame h = new_frame(3);
    add_layer(&h, &unorm);
    add_layer(&h, &real)->blend_alpha = true;
    submit(c, &h);
    flush(c);
    for (int k = 0; k < W * H; k++) {
        double alpha = fmin(fmax((double)wide[4 * k + 3], 0), 1);
        for (int i = 0; i < 3; i++)
            linear[3 * k + i] =
                fmin(fmax((double)wide[4 * k + i], 0), 1) + (1 - alpha) * bytes[4 * k + i] / 255.0;
    }
    compare(3, 0, linear, 1);
    compare(3, 1, linear, 1);
    sim_compositor_destroy(c);
    ap_gpu_image_destroy(&gpu, &unorm.image);
    ap_gpu_image_destroy(&gpu, &real.image);
    free(bytes);
}

static void reprojects(void **state) {
    (void)state;
    static double linear[2][3 * W * H];
    enum { LAYER_W = 150, LAYER_H = 110 };
    uint8_t *bytes = smooth(LAYER_W, LAYER_H);
    struct picture p = make_picture(VK_FORMAT_R8G8B8A8_SRGB, LAYER_W, LAYER_H, 1, 1);
    upload(&p, bytes, 4);
    struct sim_compositor *c = create();
    for (int k = 0; k < 4; k++) {
        struct sim_frame f = new_frame(k);
        add_layer(&f, &p);
        memset(linear, 0, sizeof linear);
        for (int eye = 0; eye < 2; eye++) {
            struct sim_layer_view *v = &f.layer[0].view[eye];
            struct ap_quat turn = ap_quat_from_axis_angle(
                ap_vec3_normalize((struct ap_vec3){0.2 * k, 1, 0.3}), 0.15 * k);
            v->at_display = false;
            v->stage_from_view.q = ap_quat_mul(v->stage_from_view.q, turn);
            v->stage_from_view.p.x += 1; // no part of it
            v->fov = (XrFovf){-0.7f, 0.75f, 0.7f, -0.5f};
            v->rect = (XrRect2Di){{10 * eye, 5}, {LAYER_W - 20, LAYER_H - 10}};
            reference(&f, eye, &f.layer[0], bytes, linear[eye]);
        }
        submit(c, &f);
        flush(c);
        compare(k, 0, linear[0], 2);
        compare(k, 1, linear[1], 2);
    }
    assert_int_equal(sim_compositor_stats(c).composed, 8);
    sim_compositor_destroy(c);
    ap_gpu_image_destroy(&gpu, &p.image);
    free(bytes);
}

// A layer behind the head, or of no width, shows nothing and breaks nothing.
static void out_of_sight(void **state) {
    (void)state;
    static const double black[3 * W * H];
    uint8_t *bytes = smooth(W, H);
    struct picture p = make_picture(VK_FORMAT_R8G8B8A8_SRGB, W, H, 1, 1);
    upload(&p, bytes, 4);
    struct sim_compositor *c = create();
    struct sim_frame f = new_frame(1);
    add_layer(&f, &p);
    for (int eye = 0; eye < 2; eye++) {
        struct sim_layer_view *v = &f.layer[0].view[eye];
        v->at_display = false;
        if (eye == 0)
            v->stage_from_view.q = ap_quat_mul(
                v->stage_from_view.q, ap_quat_from_axis_angle((struct ap_vec3){0, 1, 0}, 3.14159));
        else
            v->fov.angleRight = v->fov.angleLeft;
    }
    submit(c, &f);
    sim_compositor_destroy(c);
    compare(1, 0, black, 0);
    compare(1, 1, black, 0);
    ap_gpu_image_destroy(&gpu, &p.image);
    free(bytes);
}

static void blends(void **state) {
    (void)state;
    static double linear[2][3 * W * H];
    uint8_t *below = smooth(W, H), *above = smooth(2 * W, 2 * H);
    struct picture p = make_picture(VK_FORMAT_R8G8B8A8_SRGB, W, H, 1, 1);
    struct picture q = make_picture(VK_FORMAT_R8G8B8A8_SRGB, 2 * W, 2 * H, 1, 1);
    for (int k = 0; k < 8 * W * H * 2; k += 4) // another picture, its own alpha
        above[k + 1] = (uint8_t)(255 - above[k + 1]);
    upload(&p, below, 4);
    upload(&q, above, 4);
    struct sim_compositor *c = create();
    for (int unpremultiplied = 0; unpremultiplied < 2; unpremultiplied++) {
        struct sim_frame f = new_frame(unpremultiplied);
        add_layer(&f, &p);
        add_layer(&f, &q);
        f.layer[1].blend_alpha = true;
        f.layer[1].unpremultiplied = unpremultiplied != 0;
        memset(linear, 0, sizeof linear);
        for (int eye = 0; eye < 2; eye++) {
            reference(&f, eye, &f.layer[0], below, linear[eye]);
            reference(&f, eye, &f.layer[1], above, linear[eye]);
            for (int k = 0; k < 3 * W * H; k++)
                linear[eye][k] = fmin(linear[eye][k], 1);
        }
        submit(c, &f);
        flush(c);
        compare(f.index, 0, linear[0], 2);
        compare(f.index, 1, linear[1], 2);
    }
    // One unpremultiplied layer is no copy: over black it is darkened.
    struct sim_frame f = new_frame(3);
    add_layer(&f, &p);
    f.layer[0].blend_alpha = f.layer[0].unpremultiplied = true;
    memset(linear, 0, sizeof linear);
    reference(&f, 0, &f.layer[0], below, linear[0]);
    submit(c, &f);
    flush(c);
    compare(3, 0, linear[0], 2);
    compare(3, 1, linear[0], 2);
    assert_int_equal(sim_compositor_stats(c).copied, 0);
    sim_compositor_destroy(c);
    ap_gpu_image_destroy(&gpu, &p.image);
    ap_gpu_image_destroy(&gpu, &q.image);
    free(below);
    free(above);
}

static void multisampled(void **state) {
    (void)state;
    static double linear[3 * W * H];
    struct picture p = make_picture(VK_FORMAT_R8G8B8A8_SRGB, W, H, 2, 4);
    const float color[4] = {0.5f, 0.25f, 0.75f, 1};
    fill(&p, 0, color);
    struct sim_compositor *c = create();
    struct sim_frame f = new_frame(1);
    add_layer(&f, &p);
    submit(c, &f);
    sim_compositor_destroy(c);
    for (int k = 0; k < 3 * W * H; k++)
        linear[k] = (double)color[k % 3];
    compare(1, 0, linear, 1);
    compare(1, 1, linear, 1);
    ap_gpu_image_destroy(&gpu, &p.image);
}

// The program draws the next frame into the same image at once; every picture is its own frame's.
static void a_ring_of_frames(void **state) {
    (void)state;
    enum { FRAMES = 40 };
    struct picture p = make_picture(VK_FORMAT_R8G8B8A8_SRGB, W, H, 2, 1);
    uint8_t *bytes = malloc((size_t)W * H * 4 * 2);
    struct sim_compositor *c = create();
    for (int k = 0; k < FRAMES; k++) {
        memset(bytes, 5 + 3 * k, (size_t)W * H * 4);
        memset(bytes + W * H * 4, 6 + 3 * k, (size_t)W * H * 4);
        upload(&p, bytes, 4);
        struct sim_frame f = new_frame(k);
        f.capture = k % 3 != 1;
        add_layer(&f, &p);
        if (k % 3 == 2) // the graphics pass takes turns with the copy
            f.layer[0].view[0].at_display = f.layer[0].view[1].at_display = false;
        submit(c, &f);
    }
    sim_compositor_destroy(c);
    for (int k = 0; k < FRAMES; k++)
        for (int eye = 0; eye < 2; eye++) {
            if (k % 3 == 1) {
                assert_false(ap_file_exists(path_of(k, eye)));
                continue;
            }
            struct ap_image image = read_picture(k, eye);
            for (int i = 0; i < 3 * W * H; i++)
                assert_int_equal(image.rgb[i], 5 + 3 * k + eye);
            ap_image_finish(&image);
        }
    ap_gpu_image_destroy(&gpu, &p.image);
    free(bytes);
}

// The folder goes away: the first reason is told once, by the next call.
static void write_errors(void **state) {
    (void)state;
    struct ap_error err = {{0}};
    char sub[300];
    snprintf(sub, sizeof sub, "%s/a/b", folder);
    char *kept = settings.capture_dir;
    settings.capture_dir = sub;
    struct sim_compositor *c = create();
    assert_int_equal(rmdir(sub), 0);
    struct sim_frame f = new_frame(7);
    enum ap_status st = sim_compositor_frame(&err, c, &f);
    if (!st)
        st = sim_compositor_flush(&err, c);
    assert_int_equal(st, AP_ENVIRONMENT);
    assert_non_null(strstr(err.text, "000007-"));
    assert_non_null(strstr(err.text, "No such file"));
    sim_compositor_flush(NULL, c);
    assert_int_equal(sim_compositor_flush(&err, c), AP_OK);
    sim_compositor_destroy(c);
    snprintf(sub, sizeof sub, "%s/a", folder);
    rmdir(sub);
    snprintf(sub, sizeof sub, "/proc/nowhere");
    assert_int_equal(sim_compositor_create(&err, &gpu, &settings, &c), AP_ENVIRONMENT);
    assert_non_null(strstr(err.text, "/proc/nowhere"));
    settings.capture_dir = NULL;
    c = create();
    assert_int_equal(sim_compositor_frame(&err, c, &f), AP_USAGE);
    sim_compositor_destroy(c);
    settings.capture_dir = kept;
}

int main(void) {
    if (!stage_open())
        return 77;
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(copies_bit_for_bit),
        cmocka_unit_test(nobody_looks),
        cmocka_unit_test(no_layer_is_black),
        cmocka_unit_test(linear_formats),
        cmocka_unit_test(reprojects),
        cmocka_unit_test(out_of_sight),
        cmocka_unit_test(blends),
        cmocka_unit_test(multisampled),
        cmocka_unit_test(a_ring_of_frames),
        cmocka_unit_test(write_errors),
        cmocka_unit_test(validation_is_silent),
    };
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    stage_close();
    return failed;
}
