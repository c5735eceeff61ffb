#include "tests/sim_hmd/painter.h"

#include <jansson.h>
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>

#include "src/base/file.h"
#include "src/image/image.h"

// Captures of what is more than a picture an eye: a cube map's faces and the depths that come with
// a projection, through the loader, against what the program put into its images.

enum { SIDE = 16, W = 40, H = 24, MAX_BYTES = 12 * SIDE * SIDE * 4 };

static void begin_program(struct painter *p, const char *dir, const char *more) {
    static const char *const extensions[] = {XR_KHR_COMPOSITION_LAYER_CUBE_EXTENSION_NAME,
                                             XR_KHR_COMPOSITION_LAYER_DEPTH_EXTENSION_NAME};
    char json[1024];
    snprintf(
        json, sizeof json,
        "{\"clock\": \"virtual\", \"capture\": {\"dir\": \"%s/%s\", \"layers\": true%s}, "
        "\"headset\": {\"name\": \"tiny\", \"refresh_hz\": 90, \"ipd_m\": 0.06, \"eyes\": "
        "{\"left\": {\"resolution_px\": [%d, %d], \"fov_rad\": {\"left\": -0.5, \"right\": 0.5,"
        " \"up\": 0.5, \"down\": -0.5}}, \"right\": {\"resolution_px\": [%d, %d], \"fov_rad\":"
        " {\"left\": -0.5, \"right\": 0.5, \"up\": 0.5, \"down\": -0.5}}}}}",
        client_folder(), dir, more, W, H, W, H);
    client_settings(json);
    client_extensions(extensions, 2);
    painter_start(p, MAX_BYTES);
}

static XrSwapchainCreateInfo swapchain_info(VkFormat format, bool depth, uint32_t faces) {
    return (XrSwapchainCreateInfo){.type = XR_TYPE_SWAPCHAIN_CREATE_INFO,
                                   .usageFlags =
                                       XR_SWAPCHAIN_USAGE_TRANSFER_DST_BIT |
                                       (depth ? XR_SWAPCHAIN_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT
                                              : XR_SWAPCHAIN_USAGE_COLOR_ATTACHMENT_BIT),
                                   .format = format,
                                   .sampleCount = 1,
                                   .width = faces == 6 ? SIDE : W,
                                   .height = faces == 6 ? SIDE : H,
                                   .faceCount = faces,
                                   .arraySize = 2,
                                   .mipCount = 1};
}

// A swapchain whose next image holds what the buffer does, all its layers one after another.
static XrSwapchain painted(struct painter *p, const XrSwapchainCreateInfo *info, bool depth) {
    XrSwapchain swapchain;
    XR_OK(xrCreateSwapchain(p->c.session, info, &swapchain));
    VkImage image = painter_acquire(swapchain);
    const VkImageAspectFlags aspect = depth ? VK_IMAGE_ASPECT_DEPTH_BIT : VK_IMAGE_ASPECT_COLOR_BIT;
    const VkImageLayout layout = depth ? VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL
                                       : VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL;
    VkCommandBuffer cmd = painter_begin(p);
    VkBufferImageCopy copy = {.imageSubresource = {aspect, 0, 0, info->faceCount * info->arraySize},
                              .imageExtent = {info->width, info->height, 1}};
    painter_turn(cmd, image, aspect, layout, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
    vkCmdCopyBufferToImage(cmd, p->buffer, image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &copy);
    painter_turn(cmd, image, aspect, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, layout);
    painter_submit(p, cmd);
    vkQueueWaitIdle(p->queue); // the buffer is written again
    XR_OK(xrReleaseSwapchainImage(swapchain, NULL));
    return swapchain;
}

static XrResult try_end(struct painter *p, XrTime time, const void *layer) {
    const XrCompositionLayerBaseHeader *list = layer;
    XrFrameEndInfo end = {.type = XR_TYPE_FRAME_END_INFO,
                          .displayTime = time,
                          .environmentBlendMode = XR_ENVIRONMENT_BLEND_MODE_OPAQUE,
                          .layerCount = 1,
                          .layers = &list};
    return xrEndFrame(p->c.session, &end);
}

static XrTime begin_frame(struct painter *p) {
    XrTime time = client_wait(&p->c).predictedDisplayTime;
    client_begin(&p->c);
    return time;
}

static struct ap_image picture(const char *dir, const char *name) {
    struct ap_image image;
    struct ap_error err;
    if (ap_picture_read(&err, painter_path(dir, name), &image))
        fail_msg("%s", err.text);
    return image;
}

static void has_no(const char *dir, const char *name) {
    if (ap_file_exists(painter_path(dir, name)))
        fail_msg("%s is there, and should not be", name);
}

// The only line of the log.
static json_t *line_of(const char *dir) {
    char *text;
    size_t len;
    assert_int_equal(ap_file_read(NULL, painter_path(dir, "frames.jsonl"), 1 << 20, &text, &len),
                     AP_OK);
    json_t *root = json_loadb(text, strcspn(text, "\n"), JSON_REJECT_DUPLICATES, NULL);
    assert_non_null(root);
    free(text);
    return root;
}

static void check_files(json_t *root, const char *const *names, size_t count) {
    json_t *files = json_object_get(root, "files");
    assert_int_equal(json_array_size(files), count);
    for (size_t k = 0; k < count; k++)
        assert_string_equal(json_string_value(json_array_get(files, k)), names[k]);
}

// ---- Cubes

static uint8_t face_texel(int layer, int x, int y, int c) {
    const int v[4] = {20 * layer + x / 4, 255 - 20 * layer - y / 4, 7 * x, 255};
    return (uint8_t)v[c];
}

static XrSwapchain painted_cube(struct painter *p) {
    uint8_t *to = p->mapped;
    for (int layer = 0; layer < 12; layer++)
        for (int k = 0; k < SIDE * SIDE * 4; k++)
            *to++ = face_texel(layer, k / 4 % SIDE, k / 4 / SIDE, k % 4);
    XrSwapchainCreateInfo info = swapchain_info(VK_FORMAT_R8G8B8A8_SRGB, false, 6);
    return painted(p, &info, false);
}

static XrCompositionLayerCubeKHR cube_of(const struct painter *p, XrSwapchain swapchain) {
    return (XrCompositionLayerCubeKHR){.type = XR_TYPE_COMPOSITION_LAYER_CUBE_KHR,
                                       .space = p->c.view,
                                       .eyeVisibility = XR_EYE_VISIBILITY_BOTH,
                                       .swapchain = swapchain,
                                       .imageArrayIndex = 1,
                                       .orientation = {0, 0, 0, 1}};
}

// The second cube of two, seen from within the head: the face that is called front is what the eyes
// look at.
static void faces(void **state) {
    (void)state;
    static const char *const names[] = {"000000-left.png",         "000000-right.png",
                                        "000000-layer0-right.png", "000000-layer0-left.png",
                                        "000000-layer0-up.png",    "000000-layer0-down.png",
                                        "000000-layer0-back.png",  "000000-layer0-front.png"};
    struct painter p;
    begin_program(&p, "faces", ", \"frames\": \"0:1\"");
    XrCompositionLayerCubeKHR cube = cube_of(&p, painted_cube(&p));
    XR_OK(try_end(&p, begin_frame(&p), &cube));
    painter_stop(&p);
    for (int face = 0; face < 6; face++) {
        struct ap_image image = picture("faces", names[2 + face]);
        assert_int_equal(image.width, SIDE);
        assert_int_equal(image.height, SIDE);
        for (int k = 0; k < SIDE * SIDE * 3; k++)
            if (image.rgb[k] != face_texel(6 + face, k / 3 % SIDE, k / 3 / SIDE, k % 3))
                fail_msg("%s: byte %d is %d, expected %d", names[2 + face], k, image.rgb[k],
                         face_texel(6 + face, k / 3 % SIDE, k / 3 / SIDE, k % 3));
        ap_image_finish(&image);
    }
    struct ap_image seen = picture("faces", "000000-left.png");
    const uint8_t *middle = seen.rgb + 3 * (H / 2 * W + W / 2);
    for (int c = 0; c < 2; c++) { // faces are 20 apart
        int want = face_texel(11, SIDE / 2, SIDE / 2, c);
        if (abs(middle[c] - want) > 2)
            fail_msg("straight ahead channel %d is %d, expected the front's %d within 2", c,
                     middle[c], want);
    }
    ap_image_finish(&seen);
    json_t *root = line_of("faces");
    check_files(root, names, 8);
    json_decref(root);
}

// ---- Depths

struct projection {
    XrCompositionLayerProjectionView views[2];
    XrCompositionLayerDepthInfoKHR depth[2];
    XrCompositionLayerProjection layer;
};

static const XrRect2Di part = {{3, 5}, {31, 17}};

static void make_projection(struct painter *p, XrTime time, XrSwapchain colour, XrSwapchain depth,
                            float min, float max, struct projection *out) {
    XrView views[2];
    client_views(&p->c, p->c.stage, time, views);
    for (uint32_t eye = 0; eye < 2; eye++) {
        out->depth[eye] = (XrCompositionLayerDepthInfoKHR){
            .type = XR_TYPE_COMPOSITION_LAYER_DEPTH_INFO_KHR,
            .subImage = {.swapchain = depth, .imageRect = part, .imageArrayIndex = 1 - eye},
            .minDepth = min,
            .maxDepth = max,
            .nearZ = 0.5f,
            .farZ = INFINITY};
        out->views[eye] = (XrCompositionLayerProjectionView){
            .type = XR_TYPE_COMPOSITION_LAYER_PROJECTION_VIEW,
            .next = depth ? &out->depth[eye] : NULL,
            .pose = views[eye].pose,
            .fov = views[eye].fov,
            .subImage = {.swapchain = colour, .imageRect = part, .imageArrayIndex = eye}};
    }
    out->layer = (XrCompositionLayerProjection){.type = XR_TYPE_COMPOSITION_LAYER_PROJECTION,
                                                .space = p->c.stage,
                                                .viewCount = 2,
                                                .views = out->views};
}

static uint16_t short_depth(int layer, int x, int y) {
    return (uint16_t)(layer * 30011 + y * 1301 + x * 37);
}

// Every fifth is beyond the range or no number.
static float real_depth(int layer, int x, int y) {
    static const float odd[] = {-1, 2, NAN, INFINITY, 0.25f, 0.75f};
    int k = x + W * y + layer;
    return k % 5 ? 0.25f + 0.5f * (float)(k % 769) / 768.0f : odd[k / 5 % 6];
}

static double real_value(float v) {
    double s = ((double)v - 0.25) / 0.5 * 65535;
    return s >= 65535 ? 65535 : s > 0 ? s : 0;
}

static XrSwapchain painted_depth(struct painter *p, VkFormat format) {
    for (int k = 0; k < 2 * W * H; k++) {
        int layer = k / (W * H), x = k % W, y = k / W % H;
        uint16_t v = short_depth(layer, x, y);
        float f = real_depth(layer, x, y);
        if (format == VK_FORMAT_D16_UNORM)
            memcpy(p->mapped + 2 * k, &v, 2);
        else
            memcpy(p->mapped + 4 * k, &f, 4);
    }
    XrSwapchainCreateInfo info = swapchain_info(format, true, 1);
    return painted(p, &info, true);
}

static XrSwapchain painted_colour(struct painter *p) {
    memset(p->mapped, 0x55, MAX_BYTES);
    XrSwapchainCreateInfo info = swapchain_info(VK_FORMAT_R8G8B8A8_SRGB, false, 1);
    return painted(p, &info, false);
}

static void check_depths(const char *dir, bool real, bool raw) {
    for (int eye = 0; eye < 2; eye++) {
        char name[64];
        snprintf(name, sizeof name, "000000-layer0-depth-%s.%s", eye ? "right" : "left",
                 raw ? "pam" : "png");
        struct ap_image image = picture(dir, name);
        assert_non_null(image.grey);
        assert_int_equal(image.width, part.extent.width);
        assert_int_equal(image.height, part.extent.height);
        for (int k = 0; k < part.extent.width * part.extent.height; k++) {
            int x = part.offset.x + k % part.extent.width,
                y = part.offset.y + k / part.extent.width;
            double want =
                real ? real_value(real_depth(1 - eye, x, y)) : (double)short_depth(1 - eye, x, y);
            double tolerance = real ? 0.5 + 1e-6 : 0;
            if (!(fabs(image.grey[k] - want) <= tolerance))
                fail_msg("%s: (%d, %d) is %d, expected %.9g within %g", name, x, y, image.grey[k],
                         want, tolerance);
        }
        ap_image_finish(&image);
    }
}

static double number_at(json_t *view, const char *key, size_t i) {
    return json_number_value(
        json_array_get(json_object_get(json_object_get(view, "depth"), key), i));
}

static void check_depth_line(const char *dir, const char *format, double min, double max) {
    json_t *root = line_of(dir);
    json_t *layer = json_array_get(json_object_get(root, "layers"), 0);
    json_t *view = json_array_get(json_object_get(layer, "views"), 1);
    json_t *depth = json_object_get(view, "depth");
    assert_non_null(depth);
    assert_string_equal(json_string_value(json_object_get(depth, "format")), format);
    assert_int_equal(json_integer_value(json_object_get(depth, "array_index")), 0);
    const double want[] = {min, max, 0.5, 3, 5, 31, 17, W, H};
    const double got[] = {
        number_at(view, "range", 0), number_at(view, "range", 1), number_at(view, "near_far_m", 0),
        number_at(view, "rect", 0),  number_at(view, "rect", 1),  number_at(view, "rect", 2),
        number_at(view, "rect", 3),  number_at(view, "size", 0),  number_at(view, "size", 1)};
    for (size_t k = 0; k < sizeof want / sizeof *want; k++)
        if (got[k] != want[k])
            fail_msg("depth's number %zu is %.17g, expected %.17g", k, got[k], want[k]);
    assert_true(json_is_null(json_array_get(json_object_get(depth, "near_far_m"), 1)));
    static const char *const files[] = {"000000-layer0-left.png", "000000-layer0-right.png",
                                        "000000-layer0-depth-left.png",
                                        "000000-layer0-depth-right.png"};
    check_files(root, files, 4);
    json_decref(root);
}

// The layers of the swapchain and those of the views are crossed over.
static void depths(void **state) {
    (void)state;
    for (int real = 0; real < 2; real++) {
        const char *dir = real ? "real" : "short";
        struct painter p;
        struct projection l;
        begin_program(&p, dir, ", \"frames\": \"0:1\", \"composed\": false");
        XrSwapchain colour = painted_colour(&p);
        XrSwapchain depth = painted_depth(&p, real ? VK_FORMAT_D32_SFLOAT : VK_FORMAT_D16_UNORM);
        XrTime time = begin_frame(&p);
        make_projection(&p, time, colour, depth, real ? 0.25f : 0, real ? 0.75f : 1, &l);
        XR_OK(try_end(&p, time, &l.layer));
        painter_stop(&p);
        check_depths(dir, real, false);
        check_depth_line(dir, real ? "D32_SFLOAT" : "D16_UNORM", real ? 0.25 : 0, real ? 0.75 : 1);
    }
}

// PAM; then frames without a depth and with one of several samples, which give no picture of it.
static void depths_raw_and_none(void **state) {
    (void)state;
    struct painter p;
    struct projection l;
    begin_program(&p, "raw", ", \"frames\": \"0:3\", \"composed\": false, \"format\": \"raw\"");
    XrSwapchain colour = painted_colour(&p), depth = painted_depth(&p, VK_FORMAT_D16_UNORM), many;
    XrTime time = begin_frame(&p);
    make_projection(&p, time, colour, depth, 0, 1, &l);
    XR_OK(try_end(&p, time, &l.layer));
    time = begin_frame(&p);
    make_projection(&p, time, colour, XR_NULL_HANDLE, 0, 1, &l);
    XR_OK(try_end(&p, time, &l.layer));
    XrSwapchainCreateInfo info = swapchain_info(VK_FORMAT_D16_UNORM, true, 1);
    info.sampleCount = 4;
    info.usageFlags = XR_SWAPCHAIN_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT;
    if (xrCreateSwapchain(p.c.session, &info, &many) == XR_SUCCESS) {
        uint32_t index;
        XrSwapchainImageWaitInfo wait = {.type = XR_TYPE_SWAPCHAIN_IMAGE_WAIT_INFO,
                                         .timeout = XR_INFINITE_DURATION};
        XR_OK(xrAcquireSwapchainImage(many, NULL, &index));
        XR_OK(xrWaitSwapchainImage(many, &wait));
        XR_OK(xrReleaseSwapchainImage(many, NULL));
        time = begin_frame(&p);
        make_projection(&p, time, colour, many, 0, 1, &l);
        XR_OK(try_end(&p, time, &l.layer));
    } else
        printf("no depth of several samples on this device: not tried\n");
    painter_stop(&p);
    check_depths("raw", false, true);
    has_no("raw", "000001-layer0-depth-left.pam");
    has_no("raw", "000002-layer0-depth-left.pam");
}

// A file-size limit stands for the full disk: the session is lost, and no half capture is called a
// whole one. Cube faces, then depths.
static void a_full_disk(void **state) {
    (void)state;
    signal(SIGXFSZ, SIG_IGN);
    for (int k = 0; k < 2; k++) {
        struct painter p;
        struct projection l;
        struct rlimit old, small;
        const char *dir = k ? "full-depth" : "full-cube";
        begin_program(&p, dir, ", \"composed\": false, \"format\": \"raw\"");
        XrSwapchain pixels = k ? painted_colour(&p) : painted_cube(&p);
        XrSwapchain depth = k ? painted_depth(&p, VK_FORMAT_D16_UNORM) : XR_NULL_HANDLE;
        XrCompositionLayerCubeKHR cube = cube_of(&p, pixels);
        getrlimit(RLIMIT_FSIZE, &old);
        small = old;
        small.rlim_cur = 1000; // a face has 1024 bytes and a header, a depth 1054
        XrResult result = XR_SUCCESS;
        for (int i = 0; i < 100 && result == XR_SUCCESS; i++) {
            XrFrameState f = {.type = XR_TYPE_FRAME_STATE};
            result = xrWaitFrame(p.c.session, NULL, &f);
            if (result == XR_SUCCESS)
                result = xrBeginFrame(p.c.session, NULL);
            if (result == XR_SUCCESS && k)
                make_projection(&p, f.predictedDisplayTime, pixels, depth, 0, 1, &l);
            setrlimit(RLIMIT_FSIZE, &small);
            if (result == XR_SUCCESS)
                result = try_end(&p, f.predictedDisplayTime,
                                 k ? (const void *)&l.layer : (const void *)&cube);
        }
        setrlimit(RLIMIT_FSIZE, &old);
        XR_IS(XR_ERROR_SESSION_LOST, result);
        painter_stop(&p);
        has_no(dir, "frames.jsonl");
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(faces, client_teardown),
        cmocka_unit_test_teardown(depths, client_teardown),
        cmocka_unit_test_teardown(depths_raw_and_none, client_teardown),
        cmocka_unit_test_teardown(a_full_disk, client_teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
