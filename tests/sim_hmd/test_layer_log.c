#include "tests/sim_hmd/layered.h"

#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "src/base/clock.h"
#include "src/image/image.h"

// frames.jsonl: what a capture's log says of the layers that were submitted, and of the clock.

static json_t *line_at(json_t *root, const char *path) {
    char copy[128], *rest = NULL;
    snprintf(copy, sizeof copy, "%s", path);
    for (char *key = strtok_r(copy, "/", &rest); key; key = strtok_r(NULL, "/", &rest)) {
        root = json_is_array(root) ? json_array_get(root, (size_t)atoi(key))
                                   : json_object_get(root, key);
        if (!root)
            fail_msg("the line has no %s", path);
    }
    return root;
}

static void line_has_text(json_t *root, const char *path, const char *want) {
    assert_string_equal(json_string_value(line_at(root, path)), want);
}

static void line_has_number(json_t *root, const char *path, double want) {
    double got = json_number_value(line_at(root, path));
    if (got != want)
        fail_msg("%s: %.17g, expected %.17g", path, got, want);
}

static void check_line(json_t *root, int frame) {
    line_has_number(root, "frame", frame);
    line_has_number(root, "display_ns", (double)(1000000000 + llround(frame * 1e9 / 90)));
    line_has_number(root, "missed", 0);
    line_has_number(root, "discarded", 0);
    assert_null(json_object_get(root, "ended_ns")); // no machine's time
    line_has_text(root, "head/tracking", "tracked");
    assert_int_equal(json_array_size(line_at(root, "head/pose")), 7);
    line_has_number(root, "eyes/1/fov/1", (double)0.8f);
    assert_int_equal(json_array_size(line_at(root, "layers")), 2);
    line_has_text(root, "layers/0/type", "projection");
    line_has_text(root, "layers/0/space", "stage");
    assert_int_equal(json_array_size(line_at(root, "layers/0/flags")), 0);
    line_has_text(root, "layers/0/views/0/format", "R8G8B8A8_SRGB");
    line_has_number(root, "layers/0/views/0/array_index", 1);
    line_has_text(root, "layers/1/flags/0", "blend_texture_source_alpha");
    line_has_text(root, "layers/1/views/1/format", "B8G8R8A8_UNORM");
    line_has_number(root, "layers/1/views/1/array_index", 0);
    const double rect[] = {5, 7, 33, 19, W, H};
    for (int k = 0; k < 6; k++) {
        char path[64];
        snprintf(path, sizeof path, "layers/1/views/1/%s/%d", k < 4 ? "rect" : "size", k % 4);
        line_has_number(root, path, rect[k]);
    }
    // The program located its views in STAGE, so that is where they are, to float.
    for (int k = 0; k < 7; k++) {
        char path[64];
        snprintf(path, sizeof path, "eyes/1/pose/%d", k);
        double want = (double)(float)json_number_value(line_at(root, path));
        snprintf(path, sizeof path, "layers/0/views/1/pose/%d", k);
        line_has_number(root, path, want);
    }
    const char *files[] = {"000001-left.png",        "000001-right.png",
                           "000001-layer0-left.png", "000001-layer0-right.png",
                           "000001-layer1-left.png", "000001-layer1-right.png"};
    assert_int_equal(json_array_size(line_at(root, "files")), frame == 1 ? 6 : 0);
    for (size_t k = 0; k < 6 && frame == 1; k++) {
        assert_string_equal(json_string_value(json_array_get(line_at(root, "files"), k)), files[k]);
        assert_true(layered_exists("log", files[k]));
    }
}

static void the_log_tells_what_was_submitted(void **state) {
    (void)state;
    struct painter p;
    layered_start(&p, "log", ", \"layers\": true, \"log\": \"all\", \"frames\": \"1:2\"", "");
    layered_run(&p, VK_FORMAT_R8G8B8A8_SRGB, VK_FORMAT_B8G8R8A8_UNORM, FRAMES);
    painter_stop(&p);
    size_t len;
    char *text = layered_read("log", "frames.jsonl", &len);
    assert_false(layered_exists("log", "frames.jsonl.part"));
    int k = 0;
    for (char *line = text; *line; k++, line += strcspn(line, "\n") + 1) {
        json_t *root = json_loadb(line, strcspn(line, "\n"), JSON_REJECT_DUPLICATES, NULL);
        assert_non_null(root);
        check_line(root, k);
        json_decref(root);
    }
    free(text);
    assert_int_equal(k, FRAMES);
}

// On the real clock a line has the machine's times, in the order in which things happen. One frame
// is ended long after its display.
static void the_real_clock_is_told(void **state) {
    (void)state;
    enum { LATE = 3 };
    struct painter p;
    layered_start_real(&p, "real", ", \"log\": \"all\", \"frames\": \"0:1\"");
    for (int k = 0; k < FRAMES; k++) {
        XrFrameState f = client_wait(&p.c);
        client_begin(&p.c);
        if (k == LATE)
            ap_clock_sleep_until_ns(ap_clock_now_ns() + 60000000);
        client_end_empty(&p.c, f.predictedDisplayTime);
    }
    painter_stop(&p);
    size_t len;
    char *text = layered_read("real", "frames.jsonl", &len);
    double last = 0;
    int k = 0;
    for (char *line = text; *line; k++, line += strcspn(line, "\n") + 1) {
        json_t *root = json_loadb(line, strcspn(line, "\n"), JSON_REJECT_DUPLICATES, NULL);
        assert_non_null(root);
        double waited = json_number_value(line_at(root, "waited_ns"));
        double begun = json_number_value(line_at(root, "begun_ns"));
        double ended = json_number_value(line_at(root, "ended_ns"));
        double display = json_number_value(line_at(root, "display_ns"));
        double period = json_number_value(line_at(root, "period_ns"));
        line_has_number(root, "deadline_ns", display);
        if (!(last <= waited && waited <= begun && begun <= ended))
            fail_msg("frame %d: last %.0f, waited %.0f, begun %.0f, ended %.0f", k, last, waited,
                     begun, ended);
        // xrWaitFrame returns a period before the display, not sooner.
        if (waited < display - period - 1)
            fail_msg("frame %d: waited %.0f, display %.0f less %.0f", k, waited, display, period);
        assert_int_equal(json_is_true(line_at(root, "late")), ended > display);
        if (k == LATE)
            assert_true(json_is_true(line_at(root, "late")) && ended >= begun + 6e7);
        if (k == LATE + 1 && json_number_value(line_at(root, "missed")) < 3)
            fail_msg("after 60 ms at 90 Hz %g periods are missed, expected at least 3",
                     json_number_value(line_at(root, "missed")));
        last = ended;
        json_decref(root);
    }
    free(text);
    assert_int_equal(k, FRAMES);
}

// One colour all over, whatever the image is: cleared, not copied to.
static void clear(struct painter *p, XrSwapchain swapchain, const float rgba[4]) {
    VkImage image = painter_acquire(swapchain);
    VkCommandBuffer cmd = painter_begin(p);
    painter_turn(cmd, image, VK_IMAGE_ASPECT_COLOR_BIT, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL,
                 VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
    VkClearColorValue colour;
    memcpy(colour.float32, rgba, sizeof colour.float32);
    VkImageSubresourceRange all = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 2};
    vkCmdClearColorImage(cmd, image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, &colour, 1, &all);
    painter_turn(cmd, image, VK_IMAGE_ASPECT_COLOR_BIT, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                 VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL);
    painter_submit(p, cmd);
    XR_OK(xrReleaseSwapchainImage(swapchain, NULL));
}

static void check_colour(const char *name, int width, int height, const int want[3]) {
    struct ap_image image;
    struct ap_error err;
    if (ap_png_read(&err, painter_path("clear", name), &image))
        fail_msg("%s", err.text);
    assert_int_equal(image.width, width);
    assert_int_equal(image.height, height);
    for (int k = 0; k < width * height * 3; k++)
        if (abs(image.rgb[k] - want[k % 3]) > 1)
            fail_msg("%s: byte %d is %d, expected %d within 1", name, k, image.rgb[k], want[k % 3]);
    ap_image_finish(&image);
}

// A projection of multisampled images, which are resolved, and a quad, which has one picture.
static void samples_and_quads(void **state) {
    (void)state;
    struct painter p;
    layered_start(&p, "clear", ", \"layers\": true, \"frames\": \"0:1\"", "");
    XrSwapchainCreateInfo i = {.type = XR_TYPE_SWAPCHAIN_CREATE_INFO,
                               .usageFlags = XR_SWAPCHAIN_USAGE_COLOR_ATTACHMENT_BIT |
                                             XR_SWAPCHAIN_USAGE_TRANSFER_DST_BIT,
                               .format = VK_FORMAT_R16G16B16A16_SFLOAT,
                               .sampleCount = 4,
                               .width = W,
                               .height = H,
                               .faceCount = 1,
                               .arraySize = 2,
                               .mipCount = 1};
    struct screen s[2] = {{0}, {0}};
    XR_OK(xrCreateSwapchain(p.c.session, &i, &s[0].swapchain));
    i.sampleCount = 1;
    i.format = VK_FORMAT_B8G8R8A8_SRGB;
    XR_OK(xrCreateSwapchain(p.c.session, &i, &s[1].swapchain));
    const float first[4] = {0.5f, 2, 0.1f, 1}, second[4] = {0.25f, 0, 1, 1};
    XrTime time = client_wait(&p.c).predictedDisplayTime;
    client_begin(&p.c);
    clear(&p, s[0].swapchain, first);
    clear(&p, s[1].swapchain, second);
    struct layer l;
    layered_layer(&p, &s[0], time, layered_part, 0, &l);
    XrCompositionLayerQuad quad = {
        .type = XR_TYPE_COMPOSITION_LAYER_QUAD,
        .space = p.c.local,
        .eyeVisibility = XR_EYE_VISIBILITY_RIGHT,
        .subImage = {.swapchain = s[1].swapchain, .imageRect = layered_part},
        .pose = {{0, 0, 0, 1}, {0, 0, -1}},
        .size = {1, 1}};
    const XrCompositionLayerBaseHeader *list[2] = {
        (const XrCompositionLayerBaseHeader *)&l.projection,
        (const XrCompositionLayerBaseHeader *)&quad};
    XrFrameEndInfo end = {.type = XR_TYPE_FRAME_END_INFO,
                          .displayTime = time,
                          .environmentBlendMode = XR_ENVIRONMENT_BLEND_MODE_OPAQUE,
                          .layerCount = 2,
                          .layers = list};
    XR_OK(xrEndFrame(p.c.session, &end));
    painter_stop(&p);
    const int resolved[3] = {188, 255, 89}, encoded[3] = {137, 0, 255};
    check_colour("000000-layer0-left.png", 33, 19, resolved);
    check_colour("000000-layer0-right.png", 33, 19, resolved);
    check_colour("000000-layer1.png", 33, 19, encoded);
    assert_false(layered_exists("clear", "000000-layer1-left.png"));
    size_t len;
    char *text = layered_read("clear", "frames.jsonl", &len);
    json_t *root = json_loads(text, 0, NULL);
    line_has_text(root, "layers/1/type", "quad");
    line_has_text(root, "layers/1/eyes", "right");
    line_has_text(root, "layers/1/space", "local");
    line_has_number(root, "layers/0/views/0/samples", 4);
    assert_int_equal(json_array_size(line_at(root, "layers/1/views")), 1);
    line_has_text(root, "files/4", "000000-layer1.png");
    json_decref(root);
    free(text);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(the_log_tells_what_was_submitted, client_teardown),
        cmocka_unit_test_teardown(the_real_clock_is_told, client_teardown),
        cmocka_unit_test_teardown(samples_and_quads, client_teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
