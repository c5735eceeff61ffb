// Frames handed to the compositor on a headless device, its pictures read back from disk.

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "sim_hmd/compositor.h"
#include "sim_hmd/compositor_pass.h"
#include "src/base/file.h"
#include "src/image/image.h"

enum { W = 64, H = 48 };

static struct ap_gpu gpu;
static int validation_errors;
static char folder[] = "/tmp/antipode-compositor-XXXXXX";
static struct sim_settings settings;

static const XrFovf FOV = {-0.8f, 0.7f, 0.6f, -0.65f};

// ---- Images with known bytes

struct picture {
    struct ap_gpu_image image;
    VkFormat format;
    uint32_t width, height, layers, samples;
};

static void commands(VkCommandBuffer *cmd) {
    assert_int_equal(ap_gpu_commands_begin(NULL, &gpu, cmd), AP_OK);
}

// In COLOR_ATTACHMENT_OPTIMAL, as a program leaves it.
static struct picture make_picture(VkFormat format, uint32_t width, uint32_t height,
                                   uint32_t layers, uint32_t samples) {
    struct picture p = {
        .format = format, .width = width, .height = height, .layers = layers, .samples = samples};
    VkImageCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
        .imageType = VK_IMAGE_TYPE_2D,
        .format = format,
        .extent = {width, height, 1},
        .mipLevels = 1,
        .arrayLayers = layers,
        .samples = (VkSampleCountFlagBits)samples,
        .tiling = VK_IMAGE_TILING_OPTIMAL,
        .usage = VK_IMAGE_USAGE_TRANSFER_SRC_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT |
                 VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT,
        .initialLayout = VK_IMAGE_LAYOUT_UNDEFINED};
    struct ap_error err;
    if (ap_gpu_image_create(&err, &gpu, &info, VK_IMAGE_VIEW_TYPE_2D_ARRAY,
                            VK_IMAGE_ASPECT_COLOR_BIT, &p.image))
        fail_msg("%s", err.text);
    VkCommandBuffer cmd;
    commands(&cmd);
    ap_gpu_barrier(cmd, p.image.image, VK_IMAGE_ASPECT_COLOR_BIT, VK_IMAGE_LAYOUT_UNDEFINED,
                   VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL);
    assert_int_equal(ap_gpu_commands_end(NULL, &gpu, cmd), AP_OK);
    return p;
}

// Layers of `bytes_per_pixel`·width·height bytes. Does not wait for earlier work: the queue orders.
static void upload(const struct picture *p, const void *bytes, uint32_t bytes_per_pixel) {
    struct ap_gpu_buffer buffer;
    size_t size = (size_t)p->width * p->height * p->layers * bytes_per_pixel;
    assert_int_equal(
        ap_gpu_buffer_create(NULL, &gpu, size, VK_BUFFER_USAGE_TRANSFER_SRC_BIT, true, &buffer),
        AP_OK);
    memcpy(buffer.mapped, bytes, size);
    VkCommandBuffer cmd;
    commands(&cmd);
    VkBufferImageCopy region = {.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, p->layers},
                                .imageExtent = {p->width, p->height, 1}};
    ap_gpu_barrier(cmd, p->image.image, VK_IMAGE_ASPECT_COLOR_BIT,
                   VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
    vkCmdCopyBufferToImage(cmd, buffer.buffer, p->image.image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                           1, &region);
    ap_gpu_barrier(cmd, p->image.image, VK_IMAGE_ASPECT_COLOR_BIT,
                   VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL);
    assert_int_equal(ap_gpu_commands_end(NULL, &gpu, cmd), AP_OK);
    ap_gpu_buffer_destroy(&gpu, &buffer);
}

static uint32_t noise_state = 1;
static uint8_t *noise(size_t n) {
    uint8_t *bytes = malloc(n);
    assert_non_null(bytes);
    for (size_t k = 0; k < n; k++) {
        noise_state = noise_state * 1664525u + 1013904223u;
        bytes[k] = (uint8_t)(noise_state >> 24);
    }
    return bytes;
}

// Colours that change slowly, so that a texel more or less does not decide.
static uint8_t *smooth(uint32_t width, uint32_t height) {
    uint8_t *bytes = malloc((size_t)width * height * 4);
    assert_non_null(bytes);
    for (uint32_t y = 0; y < height; y++)
        for (uint32_t x = 0; x < width; x++) {
            uint8_t *p = bytes + ((size_t)y * width + x) * 4;
            p[0] = (uint8_t)(40 + 200 * x / width);
            p[1] = (uint8_t)(30 + 210 * y / height);
            p[2] = (uint8_t)(128 + 90 * sin(0.1 * x) * cos(0.12 * y));
            p[3] = (uint8_t)(255 - 180 * x / width);
        }
    return bytes;
}

// ---- Frames

static struct sim_compositor *create(void) {
    struct sim_compositor *c;
    struct ap_error err = {{0}};
    if (sim_compositor_create(&err, &gpu, &settings, &c))
        fail_msg("%s", err.text);
    return c;
}

static struct sim_frame new_frame(int64_t index) {
    struct sim_frame f = {.index = index, .capture = true};
    for (int eye = 0; eye < 2; eye++) {
        f.stage_from_eye[eye] = (struct ap_pose){
            {0.03 * eye, 1.6, 0}, ap_quat_from_axis_angle((struct ap_vec3){0.6, 0.8, 0}, 0.4)};
        f.fov[eye] = FOV;
    }
    return f;
}

static struct sim_layer_view whole(const struct picture *p, const struct sim_frame *f, int eye) {
    return (struct sim_layer_view){.image = p->image.image,
                                   .format = p->format,
                                   .width_px = p->width,
                                   .height_px = p->height,
                                   .samples = p->samples,
                                   .array_layer = p->layers > 1 ? (uint32_t)eye : 0,
                                   .rect = {{0, 0}, {(int32_t)p->width, (int32_t)p->height}},
                                   .stage_from_view = f->stage_from_eye[eye],
                                   .fov = f->fov[eye],
                                   .at_display = true};
}

static void add_layer(struct sim_frame *f, const struct picture *p) {
    struct sim_layer *layer = &f->layer[f->layer_count++];
    for (int eye = 0; eye < 2; eye++)
        layer->view[eye] = whole(p, f, eye);
}

static void submit(struct sim_compositor *c, const struct sim_frame *f) {
    struct ap_error err = {{0}};
    if (sim_compositor_frame(&err, c, f))
        fail_msg("%s", err.text);
}

static void flush(struct sim_compositor *c) {
    struct ap_error err = {{0}};
    if (sim_compositor_flush(&err, c))
        fail_msg("%s", err.text);
}

static const char *path_of(int64_t index, int eye) {
    static char path[256];
    snprintf(path, sizeof path, "%s/%06d-%s.png", folder, (int)index, eye ? "right" : "left");
    return path;
}

static struct ap_image read_picture(int64_t index, int eye) {
    struct ap_image image;
    struct ap_error err = {{0}};
    if (ap_png_read(&err, path_of(index, eye), &image))
        fail_msg("%s", err.text);
    assert_int_equal(image.width, W);
    assert_int_equal(image.height, H);
    unlink(path_of(index, eye));
    return image;
}

// Every pixel of the file is within `tolerance` of the reference (linear light, 3·W·H).
static void compare(int64_t index, int eye, const double *linear, int tolerance) {
    struct ap_image image = read_picture(index, eye);
    int worst = 0;
    for (int k = 0; k < W * H * 3; k++) {
        int d = abs((int)image.rgb[k] - (int)ap_srgb_from_linear(linear[k]));
        if (d > tolerance)
            fail_msg("pixel (%d, %d) channel %d: %d, expected %d within %d", k / 3 % W, k / 3 / W,
                     k % 3, image.rgb[k], ap_srgb_from_linear(linear[k]), tolerance);
        worst = d > worst ? d : worst;
    }
    printf("frame %d eye %d: worst difference %d, tolerance %d\n", (int)index, eye, worst,
           tolerance);
    ap_image_finish(&image);
}

// ---- The reference: shaders/composite.frag in double

static void texel(const struct sim_layer_view *v, const uint8_t *bytes, double x, double y,
                  double out[4]) {
    double left = v->rect.offset.x + 0.5, right = left + v->rect.extent.width - 1;
    double top = v->rect.offset.y + 0.5, bottom = top + v->rect.extent.height - 1;
    x = fmin(fmax(x, left), right) - 0.5;
    y = fmin(fmax(y, top), bottom) - 0.5;
    for (int c = 0; c < 4; c++)
        out[c] = 0;
    for (int k = 0; k < 4; k++) {
        int i = (int)floor(x) + (k & 1), j = (int)floor(y) + (k >> 1);
        double w =
            (k & 1 ? x - floor(x) : 1 - x + floor(x)) * (k >> 1 ? y - floor(y) : 1 - y + floor(y));
        if (w == 0)
            continue;
        const uint8_t *p = bytes + ((size_t)j * v->width_px + (size_t)i) * 4;
        for (int c = 0; c < 4; c++)
            out[c] += w * (c == 3 ? p[c] / 255.0 : ap_linear_from_srgb(p[c]));
    }
}

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
    VkCommandBuffer cmd;
    commands(&cmd);
    VkClearColorValue color = {.float32 = {0.5f, 0.25f, 0.75f, 1}};
    VkImageSubresourceRange all = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 2};
    ap_gpu_barrier(cmd, p.image.image, VK_IMAGE_ASPECT_COLOR_BIT,
                   VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
    vkCmdClearColorImage(cmd, p.image.image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, &color, 1, &all);
    ap_gpu_barrier(cmd, p.image.image, VK_IMAGE_ASPECT_COLOR_BIT,
                   VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL);
    assert_int_equal(ap_gpu_commands_end(NULL, &gpu, cmd), AP_OK);
    struct sim_compositor *c = create();
    struct sim_frame f = new_frame(1);
    add_layer(&f, &p);
    submit(c, &f);
    sim_compositor_destroy(c);
    for (int k = 0; k < 3 * W * H; k++)
        linear[k] = (double)color.float32[k % 3];
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

static void validation_is_silent(void **state) {
    (void)state;
    assert_int_equal(validation_errors, 0);
}

// The software driver and the validation layer were built without ThreadSanitizer, which takes what
// they do for races.
#ifdef __SANITIZE_THREAD__
__attribute__((visibility("default"))) const char *__tsan_default_suppressions(void);
const char *__tsan_default_suppressions(void) {
    return "race:libvulkan_lvp.so\n";
}
static const bool VALIDATE = false;
#else
static const bool VALIDATE = true;
#endif

int main(void) {
    struct ap_error err = {{0}};
    struct ap_gpu_headless_params params = {.validation = VALIDATE,
                                            .validation_errors = &validation_errors};
    if (ap_gpu_create_headless(&err, &params, &gpu)) {
        printf("skipped: %s\n", err.text);
        return 77;
    }
    // The driver keeps a little memory, and once it is unloaded with the last VkInstance a leak
    // checker no longer knows whose (lsan.supp). One stays.
    static VkInstance kept;
    VkInstanceCreateInfo info = {.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO};
    if (vkCreateInstance(&info, NULL, &kept) != VK_SUCCESS || !mkdtemp(folder))
        return 1;
    settings.capture_dir = folder;
    for (int eye = 0; eye < 2; eye++)
        settings.profile.eye[eye] = (struct ap_eye_profile){.width_px = W, .height_px = H};
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
    rmdir(folder);
    ap_gpu_finish(&gpu);
    return failed;
}
