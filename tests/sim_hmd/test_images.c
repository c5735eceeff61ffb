#include "tests/sim_hmd/painter.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "src/image/image.h"

// Swapchains and what xrEndFrame says of layers.

enum { W = 64, H = 48 };

static void set(const char *more) {
    char json[1024];
    snprintf(json, sizeof json,
             "{\"clock\": \"virtual\", %s \"headset\": {\"name\": \"tiny\", \"refresh_hz\": 90, "
             "\"ipd_m\": 0.06, \"eyes\": {\"left\": {\"resolution_px\": [%d, %d], \"fov_rad\": "
             "{\"left\": -0.8, \"right\": 0.8, \"up\": 0.7, \"down\": -0.7}, \"yaw_rad\": 0}, "
             "\"right\": {\"resolution_px\": [%d, %d], \"fov_rad\": {\"left\": -0.8, \"right\": "
             "0.8, \"up\": 0.7, \"down\": -0.7}, \"yaw_rad\": 0}}}}",
             more, W, H, W, H);
    client_settings(json);
}

static void start(struct client *c, const char *more) {
    set(more);
    client_start(c);
}

static XrSwapchainCreateInfo colour_info(void) {
    return client_colour_info(VK_FORMAT_R8G8B8A8_SRGB, W, H);
}

static void swapchains_are_checked(void **state) {
    (void)state;
    struct client c = {0};
    start(&c, "");
    XrSwapchain s;
    XrSwapchainCreateInfo i = colour_info();
    i.format = VK_FORMAT_R8_UNORM;
    XR_IS(XR_ERROR_SWAPCHAIN_FORMAT_UNSUPPORTED, xrCreateSwapchain(c.session, &i, &s));
    i = colour_info();
    i.width = 0;
    XR_IS(XR_ERROR_VALIDATION_FAILURE, xrCreateSwapchain(c.session, &i, &s));
    i = colour_info();
    i.mipCount = 30;
    XR_IS(XR_ERROR_VALIDATION_FAILURE, xrCreateSwapchain(c.session, &i, &s));
    i = colour_info();
    i.sampleCount = 3;
    XR_IS(XR_ERROR_VALIDATION_FAILURE, xrCreateSwapchain(c.session, &i, &s));
    i = colour_info();
    i.width = 1u << 30;
    XR_IS(XR_ERROR_VALIDATION_FAILURE, xrCreateSwapchain(c.session, &i, &s));
    i = colour_info();
    i.createFlags = XR_SWAPCHAIN_CREATE_PROTECTED_CONTENT_BIT;
    XR_IS(XR_ERROR_FEATURE_UNSUPPORTED, xrCreateSwapchain(c.session, &i, &s));
    i = colour_info();
    i.usageFlags |= XR_SWAPCHAIN_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT;
    XR_IS(XR_ERROR_FEATURE_UNSUPPORTED, xrCreateSwapchain(c.session, &i, &s));
    i = colour_info();
    i.type = XR_TYPE_SESSION_CREATE_INFO;
    XR_IS(XR_ERROR_VALIDATION_FAILURE, xrCreateSwapchain(c.session, &i, &s));
    client_stop(&c);
}

// Every format that is offered can be made, plain, as an array and multisampled where it may be.
static void every_listed_format_can_be_made(void **state) {
    (void)state;
    struct client c = {0};
    start(&c, "");
    int64_t formats[32];
    uint32_t n;
    XR_OK(xrEnumerateSwapchainFormats(c.session, 32, &n, formats));
    assert_true(n >= 5);
    assert_int_equal(formats[0], VK_FORMAT_R8G8B8A8_SRGB);
    for (uint32_t f = 0; f < n; f++)
        for (uint32_t layers = 1; layers <= 2; layers++)
            for (uint32_t samples = 1; samples <= 4; samples *= 4) {
                XrSwapchainCreateInfo i = colour_info();
                i.format = formats[f];
                i.usageFlags = XR_SWAPCHAIN_USAGE_SAMPLED_BIT;
                i.arraySize = layers;
                i.sampleCount = samples;
                XrSwapchain s;
                XrResult result = xrCreateSwapchain(c.session, &i, &s);
                if (samples > 1 && result == XR_ERROR_FEATURE_UNSUPPORTED)
                    continue;
                XR_OK(result);
                uint32_t index;
                XR_OK(xrAcquireSwapchainImage(s, NULL, &index));
                XR_OK(xrDestroySwapchain(s));
            }
    client_stop(&c);
}

static XrResult wait_image(XrSwapchain s) {
    XrSwapchainImageWaitInfo info = {.type = XR_TYPE_SWAPCHAIN_IMAGE_WAIT_INFO,
                                     .timeout = XR_INFINITE_DURATION};
    return xrWaitSwapchainImage(s, &info);
}

static void images_go_round_in_order(void **state) {
    (void)state;
    struct client c = {0};
    start(&c, "");
    XrSwapchainCreateInfo i = colour_info();
    XrSwapchain s;
    XR_OK(xrCreateSwapchain(c.session, &i, &s));
    uint32_t count, index;
    XR_OK(xrEnumerateSwapchainImages(s, 0, &count, NULL));
    assert_int_equal(count, 3);
    XR_IS(XR_ERROR_CALL_ORDER_INVALID, wait_image(s));
    XR_IS(XR_ERROR_CALL_ORDER_INVALID, xrReleaseSwapchainImage(s, NULL));
    for (uint32_t k = 0; k < count; k++) {
        XR_OK(xrAcquireSwapchainImage(s, NULL, &index));
        assert_int_equal(index, k);
    }
    XR_IS(XR_ERROR_CALL_ORDER_INVALID, xrAcquireSwapchainImage(s, NULL, &index));
    XR_IS(XR_ERROR_CALL_ORDER_INVALID, xrReleaseSwapchainImage(s, NULL)); // not waited for
    XR_OK(wait_image(s));
    XR_IS(XR_ERROR_CALL_ORDER_INVALID, wait_image(s)); // the last is not released
    XR_OK(xrReleaseSwapchainImage(s, NULL));
    XR_OK(xrAcquireSwapchainImage(s, NULL, &index));
    assert_int_equal(index, 0);
    XR_OK(xrDestroySwapchain(s));
    XR_IS(XR_ERROR_HANDLE_INVALID, xrAcquireSwapchainImage(s, NULL, &index));
    i.createFlags = XR_SWAPCHAIN_CREATE_STATIC_IMAGE_BIT;
    XR_OK(xrCreateSwapchain(c.session, &i, &s));
    XR_OK(xrEnumerateSwapchainImages(s, 0, &count, NULL));
    assert_int_equal(count, 1);
    XR_OK(xrAcquireSwapchainImage(s, NULL, &index));
    XR_OK(wait_image(s));
    XR_OK(xrReleaseSwapchainImage(s, NULL));
    XR_IS(XR_ERROR_CALL_ORDER_INVALID, xrAcquireSwapchainImage(s, NULL, &index));
    client_stop(&c);
}

// A picture with a colour of its own in every pixel, put into both layers by a transfer.
static uint8_t texel(int x, int y, int layer, int channel) {
    const int v[4] = {x * 3 + layer, y * 5, x ^ y, 255};
    return (uint8_t)v[channel];
}

static void fill(uint8_t *p) {
    for (int layer = 0; layer < 2; layer++)
        for (int y = 0; y < H; y++)
            for (int x = 0; x < W; x++)
                for (int k = 0; k < 4; k++)
                    *p++ = texel(x, y, layer, k);
}

static void draw(struct painter *p, VkImage image) {
    VkCommandBuffer cmd = painter_begin(p);
    painter_turn(cmd, image, VK_IMAGE_ASPECT_COLOR_BIT, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL,
                 VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
    VkBufferImageCopy copy = {.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 2},
                              .imageExtent = {W, H, 1}};
    vkCmdCopyBufferToImage(cmd, p->buffer, image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &copy);
    painter_turn(cmd, image, VK_IMAGE_ASPECT_COLOR_BIT, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                 VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL);
    painter_submit(p, cmd);
}

struct layer {
    XrCompositionLayerProjectionView views[2];
    XrCompositionLayerProjection projection;
    const XrCompositionLayerBaseHeader *list[1];
    XrFrameEndInfo end;
};

static void make_layer(struct client *c, XrSwapchain s, XrTime time, struct layer *l) {
    XrView views[2];
    client_views(c, c->local, time, views);
    *l = (struct layer){.projection = {.type = XR_TYPE_COMPOSITION_LAYER_PROJECTION,
                                       .space = c->local,
                                       .viewCount = 2},
                        .end = {.type = XR_TYPE_FRAME_END_INFO,
                                .displayTime = time,
                                .environmentBlendMode = XR_ENVIRONMENT_BLEND_MODE_OPAQUE,
                                .layerCount = 1}};
    for (uint32_t eye = 0; eye < 2; eye++)
        l->views[eye] = (XrCompositionLayerProjectionView){
            .type = XR_TYPE_COMPOSITION_LAYER_PROJECTION_VIEW,
            .pose = views[eye].pose,
            .fov = views[eye].fov,
            .subImage = {.swapchain = s, .imageRect.extent = {W, H}, .imageArrayIndex = eye}};
    l->projection.views = l->views;
    l->list[0] = (const XrCompositionLayerBaseHeader *)&l->projection;
    l->end.layers = l->list;
}

static void check_picture(const char *name, int layer) {
    char path[256];
    snprintf(path, sizeof path, "%s/cap/%s", client_folder(), name);
    struct ap_image image;
    struct ap_error err;
    if (ap_png_read(&err, path, &image))
        fail_msg("%s", err.text);
    assert_int_equal(image.width, W);
    assert_int_equal(image.height, H);
    for (int y = 0; y < H; y++)
        for (int x = 0; x < W; x++)
            for (int k = 0; k < 3; k++)
                if (image.rgb[(y * W + x) * 3 + k] != texel(x, y, layer, k))
                    fail_msg("%s: pixel (%d, %d), channel %d is %d, expected %d", name, x, y, k,
                             image.rgb[(y * W + x) * 3 + k], texel(x, y, layer, k));
    ap_image_finish(&image);
}

static uint32_t next_image(XrSwapchain s) {
    uint32_t index;
    XR_OK(xrAcquireSwapchainImage(s, NULL, &index));
    XR_OK(wait_image(s));
    return index;
}

static void a_picture_at_the_display_is_captured_bit_for_bit(void **state) {
    (void)state;
    struct painter p;
    struct client *c = &p.c;
    char capture[256];
    snprintf(capture, sizeof capture, "\"capture\": {\"dir\": \"%s/cap\", \"frames\": \"1:2\"},",
             client_folder());
    set(capture);
    painter_start(&p, 2 * W * H * 4);
    fill(p.mapped);
    XrSwapchainCreateInfo i = colour_info();
    XrSwapchain s;
    XR_OK(xrCreateSwapchain(c->session, &i, &s));
    struct layer l;
    for (int k = 0; k < 3; k++) {
        XrFrameState f = client_wait(c);
        assert_int_equal(f.shouldRender, k == 1);
        client_begin(c);
        VkImage image = painter_acquire(s);
        if (k == 1)
            draw(&p, image);
        XR_OK(xrReleaseSwapchainImage(s, NULL));
        make_layer(c, s, f.predictedDisplayTime, &l);
        XR_OK(xrEndFrame(c->session, &l.end));
    }
    XR_OK(xrDestroySwapchain(s)); // while the session runs: its images are collected later
    painter_stop(&p);
    check_picture("000001-left.png", 0);
    check_picture("000001-right.png", 1);
}

static void layers_are_checked(void **state) {
    (void)state;
    struct client c = {0};
    start(&c, "");
    XrSwapchainCreateInfo i = colour_info();
    XrSwapchain s;
    XR_OK(xrCreateSwapchain(c.session, &i, &s));
    XrTime time = client_wait(&c).predictedDisplayTime;
    client_begin(&c);
    struct layer l;
    make_layer(&c, s, time, &l);
    XR_IS(XR_ERROR_LAYER_INVALID, xrEndFrame(c.session, &l.end)); // no image released yet
    next_image(s);
    XR_OK(xrReleaseSwapchainImage(s, NULL));
    l.views[1].subImage.imageRect.extent.width = W + 1;
    XR_IS(XR_ERROR_SWAPCHAIN_RECT_INVALID, xrEndFrame(c.session, &l.end));
    make_layer(&c, s, time, &l);
    l.views[0].subImage.imageRect.offset.x = -1;
    XR_IS(XR_ERROR_SWAPCHAIN_RECT_INVALID, xrEndFrame(c.session, &l.end));
    make_layer(&c, s, time, &l);
    l.views[0].subImage.imageRect.offset.x = INT32_MAX;
    XR_IS(XR_ERROR_SWAPCHAIN_RECT_INVALID, xrEndFrame(c.session, &l.end));
    make_layer(&c, s, time, &l);
    l.views[0].subImage.imageArrayIndex = 2;
    XR_IS(XR_ERROR_VALIDATION_FAILURE, xrEndFrame(c.session, &l.end));
    make_layer(&c, s, time, &l);
    l.views[0].subImage.swapchain = XR_NULL_HANDLE;
    XR_IS(XR_ERROR_HANDLE_INVALID, xrEndFrame(c.session, &l.end));
    make_layer(&c, s, time, &l);
    l.views[0].pose.orientation = (XrQuaternionf){0, 0, 0, 0};
    XR_IS(XR_ERROR_POSE_INVALID, xrEndFrame(c.session, &l.end));
    make_layer(&c, s, time, &l);
    l.views[1].fov.angleUp = NAN;
    XR_IS(XR_ERROR_VALIDATION_FAILURE, xrEndFrame(c.session, &l.end));
    make_layer(&c, s, time, &l);
    l.projection.viewCount = 1;
    XR_IS(XR_ERROR_VALIDATION_FAILURE, xrEndFrame(c.session, &l.end));
    make_layer(&c, s, time, &l);
    l.projection.space = XR_NULL_HANDLE;
    XR_IS(XR_ERROR_HANDLE_INVALID, xrEndFrame(c.session, &l.end));
    make_layer(&c, s, time, &l);
    l.projection.type = XR_TYPE_COMPOSITION_LAYER_CUBE_KHR; // its extension is not enabled
    XR_IS(XR_ERROR_LAYER_INVALID, xrEndFrame(c.session, &l.end));
    make_layer(&c, s, time, &l);
    l.list[0] = NULL;
    XR_IS(XR_ERROR_LAYER_INVALID, xrEndFrame(c.session, &l.end));
    make_layer(&c, s, time, &l);
    XR_OK(xrEndFrame(c.session, &l.end)); // and the frame is still there to be ended
    client_stop(&c);
}

static void a_full_disk_ends_the_session_cleanly(void **state) {
    (void)state;
    struct client c = {0};
    // No room at all: /dev/full's folder cannot be made, so the capture cannot start.
    client_settings("{\"clock\": \"virtual\", \"capture\": {\"dir\": \"/dev/full/x\"}}");
    client_make_instance(&c);
    client_make_device(&c);
    XrGraphicsBindingVulkanKHR b;
    XrSessionCreateInfo info = client_session_info(&c, &b);
    XR_IS(XR_ERROR_RUNTIME_FAILURE, xrCreateSession(c.instance, &info, &c.session));
    c.session = XR_NULL_HANDLE;
    client_stop(&c);
    // The folder goes away while frames are captured.
    char capture[256];
    snprintf(capture, sizeof capture, "\"capture\": {\"dir\": \"%s/gone\"},", client_folder());
    start(&c, capture);
    char command[256];
    snprintf(command, sizeof command, "rm -rf '%s/gone'", client_folder());
    assert_int_equal(system(command), 0);
    XrResult result = XR_SUCCESS;
    for (int k = 0; k < 200 && result == XR_SUCCESS; k++) {
        XrFrameState f = {.type = XR_TYPE_FRAME_STATE};
        result = xrWaitFrame(c.session, NULL, &f);
        if (result == XR_SUCCESS)
            result = xrBeginFrame(c.session, NULL);
        XrFrameEndInfo end = {.type = XR_TYPE_FRAME_END_INFO,
                              .displayTime = f.predictedDisplayTime,
                              .environmentBlendMode = XR_ENVIRONMENT_BLEND_MODE_OPAQUE};
        if (result == XR_SUCCESS)
            result = xrEndFrame(c.session, &end);
    }
    assert_int_equal(result, XR_ERROR_SESSION_LOST);
    client_poll(&c);
    assert_int_equal(c.state, XR_SESSION_STATE_LOSS_PENDING);
    client_stop(&c);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(swapchains_are_checked, client_teardown),
        cmocka_unit_test_teardown(every_listed_format_can_be_made, client_teardown),
        cmocka_unit_test_teardown(images_go_round_in_order, client_teardown),
        cmocka_unit_test_teardown(a_picture_at_the_display_is_captured_bit_for_bit,
                                  client_teardown),
        cmocka_unit_test_teardown(layers_are_checked, client_teardown),
        cmocka_unit_test_teardown(a_full_disk_ends_the_session_cleanly, client_teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
