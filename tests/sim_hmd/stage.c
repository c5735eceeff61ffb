#include "tests/sim_hmd/stage.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

struct ap_gpu gpu;
struct sim_settings settings;
char folder[] = "/tmp/antipode-compositor-XXXXXX";
static int validation_errors;

static const XrFovf FOV = {-0.8f, 0.7f, 0.6f, -0.65f};

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

bool stage_open(void) {
    struct ap_error err = {{0}};
    struct ap_gpu_headless_params params = {.validation = VALIDATE,
                                            .validation_errors = &validation_errors};
    if (ap_gpu_create_headless(&err, &params, &gpu)) {
        printf("skipped: %s\n", err.text);
        return false;
    }
    // The driver keeps a little memory, and once it is unloaded with the last VkInstance a leak
    // checker no longer knows whose (lsan.supp). One stays.
    static VkInstance kept;
    VkInstanceCreateInfo info = {.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO};
    if (vkCreateInstance(&info, NULL, &kept) != VK_SUCCESS || !mkdtemp(folder)) {
        printf("no folder in /tmp, or no second instance\n");
        exit(1);
    }
    settings.capture_dir = folder;
    for (int eye = 0; eye < 2; eye++)
        settings.profile.eye[eye] = (struct ap_eye_profile){.width_px = W, .height_px = H};
    return true;
}

void stage_close(void) {
    rmdir(folder);
    ap_gpu_finish(&gpu);
}

void validation_is_silent(void **state) {
    (void)state;
    assert_int_equal(validation_errors, 0);
}

// ---- Images with known bytes

static void commands(VkCommandBuffer *cmd) {
    assert_int_equal(ap_gpu_commands_begin(NULL, &gpu, cmd), AP_OK);
}

static struct picture make(VkFormat format, uint32_t width, uint32_t height, uint32_t layers,
                           uint32_t samples, uint32_t mips, bool cube) {
    struct picture p = {.format = format,
                        .width = width,
                        .height = height,
                        .layers = layers,
                        .samples = samples,
                        .mips = mips,
                        .cube = cube};
    VkImageCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
        .flags = cube ? VK_IMAGE_CREATE_CUBE_COMPATIBLE_BIT : 0,
        .imageType = VK_IMAGE_TYPE_2D,
        .format = format,
        .extent = {width, height, 1},
        .mipLevels = mips,
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

struct picture make_picture(VkFormat format, uint32_t width, uint32_t height, uint32_t layers,
                            uint32_t samples) {
    return make(format, width, height, layers, samples, 1, false);
}

struct picture make_cube(VkFormat format, uint32_t size, uint32_t count) {
    return make(format, size, size, 6 * count, 1, 1, true);
}

struct picture make_mips(VkFormat format, uint32_t width, uint32_t height, uint32_t mips) {
    return make(format, width, height, 1, 1, mips, false);
}

void free_picture(struct picture *p) {
    ap_gpu_image_destroy(&gpu, &p->image);
}

void fill(const struct picture *p, uint32_t mip, const float color[4]) {
    VkCommandBuffer cmd;
    commands(&cmd);
    VkClearColorValue value = {.float32 = {color[0], color[1], color[2], color[3]}};
    VkImageSubresourceRange all = {VK_IMAGE_ASPECT_COLOR_BIT, mip, 1, 0, p->layers};
    ap_gpu_barrier(cmd, p->image.image, VK_IMAGE_ASPECT_COLOR_BIT,
                   VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
    vkCmdClearColorImage(cmd, p->image.image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, &value, 1,
                         &all);
    ap_gpu_barrier(cmd, p->image.image, VK_IMAGE_ASPECT_COLOR_BIT,
                   VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL);
    assert_int_equal(ap_gpu_commands_end(NULL, &gpu, cmd), AP_OK);
}

void upload(const struct picture *p, const void *bytes, uint32_t bytes_per_pixel) {
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
uint8_t *noise(size_t n) {
    uint8_t *bytes = malloc(n);
    assert_non_null(bytes);
    for (size_t k = 0; k < n; k++) {
        noise_state = noise_state * 1664525u + 1013904223u;
        bytes[k] = (uint8_t)(noise_state >> 24);
    }
    return bytes;
}

uint8_t *smooth(uint32_t width, uint32_t height) {
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

struct sim_compositor *create(void) {
    struct sim_compositor *c;
    struct ap_error err = {{0}};
    if (sim_compositor_create(&err, &gpu, &settings, &c))
        fail_msg("%s", err.text);
    return c;
}

struct sim_frame new_frame(int64_t index) {
    struct sim_frame f = {.index = index, .capture = true};
    for (int eye = 0; eye < 2; eye++) {
        f.stage_from_eye[eye] = (struct ap_pose){
            {0.03 * eye, 1.6, 0}, ap_quat_from_axis_angle((struct ap_vec3){0.6, 0.8, 0}, 0.4)};
        f.fov[eye] = FOV;
    }
    return f;
}

struct sim_layer_view whole(const struct picture *p, const struct sim_frame *f, int eye) {
    return (struct sim_layer_view){.image = p->image.image,
                                   .format = p->format,
                                   .width_px = p->width,
                                   .height_px = p->height,
                                   .samples = p->samples,
                                   .mips = p->mips,
                                   .array_layer = p->layers > 1 && !p->cube ? (uint32_t)eye : 0,
                                   .rect = {{0, 0}, {(int32_t)p->width, (int32_t)p->height}},
                                   .stage_from_view = f->stage_from_eye[eye],
                                   .fov = f->fov[eye],
                                   .at_display = true};
}

struct sim_layer *add_layer(struct sim_frame *f, const struct picture *p) {
    struct sim_layer *layer = &f->layer[f->layer_count++];
    for (int eye = 0; eye < 2; eye++)
        layer->view[eye] = whole(p, f, eye);
    return layer;
}

void submit(struct sim_compositor *c, const struct sim_frame *f) {
    struct ap_error err = {{0}};
    if (sim_compositor_frame(&err, c, f))
        fail_msg("%s", err.text);
}

void flush(struct sim_compositor *c) {
    struct ap_error err = {{0}};
    if (sim_compositor_flush(&err, c))
        fail_msg("%s", err.text);
}

const char *path_of(int64_t index, int eye) {
    static char path[256];
    snprintf(path, sizeof path, "%s/%06d-%s.png", folder, (int)index, eye ? "right" : "left");
    return path;
}

struct ap_image read_picture(int64_t index, int eye) {
    struct ap_image image;
    struct ap_error err = {{0}};
    if (ap_png_read(&err, path_of(index, eye), &image))
        fail_msg("%s", err.text);
    assert_int_equal(image.width, W);
    assert_int_equal(image.height, H);
    unlink(path_of(index, eye));
    return image;
}

void compare(int64_t index, int eye, const double *linear, int tolerance) {
    struct ap_image image = read_picture(index, eye);
    int worst = 0;
    for (int k = 0; k < W * H * 3; k++) {
        if (isnan(linear[k]))
            continue;
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

void texel(const struct sim_layer_view *v, const uint8_t *bytes, double x, double y,
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
