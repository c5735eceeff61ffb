#include "tests/sim_hmd/client.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "src/image/image.h"

// The layers that are not projections, as a program submits them: what xrEndFrame says of them, and
// that they are seen where they should be. Every pixel of every kind is test_surfaces.c's.

enum { W = 64, H = 48, SIZE = 16 };

static const char *const all_layers[] = {XR_KHR_COMPOSITION_LAYER_DEPTH_EXTENSION_NAME,
                                         XR_KHR_COMPOSITION_LAYER_CYLINDER_EXTENSION_NAME,
                                         XR_KHR_COMPOSITION_LAYER_EQUIRECT_EXTENSION_NAME,
                                         XR_KHR_COMPOSITION_LAYER_EQUIRECT2_EXTENSION_NAME,
                                         XR_KHR_COMPOSITION_LAYER_CUBE_EXTENSION_NAME};

// A display of ±0.8 rad by ±0.7 rad; the eyes are where the head is.
static void start(struct client *c, bool extensions, const char *more) {
    char json[1024];
    snprintf(json, sizeof json,
             "{\"clock\": \"virtual\", %s \"headset\": {\"name\": \"tiny\", \"refresh_hz\": 90, "
             "\"ipd_m\": 0.06, \"eyes\": {\"left\": {\"resolution_px\": [%d, %d], \"fov_rad\": "
             "{\"left\": -0.8, \"right\": 0.8, \"up\": 0.7, \"down\": -0.7}, \"yaw_rad\": 0}, "
             "\"right\": {\"resolution_px\": [%d, %d], \"fov_rad\": {\"left\": -0.8, \"right\": "
             "0.8, \"up\": 0.7, \"down\": -0.7}, \"yaw_rad\": 0}}}}",
             more, W, H, W, H);
    client_settings(json);
    client_extensions(all_layers, extensions ? 5 : 0);
    client_start(c);
    client_extensions(NULL, 0);
}

static XrSwapchainCreateInfo static_info(uint32_t faces, int64_t format) {
    return (XrSwapchainCreateInfo){.type = XR_TYPE_SWAPCHAIN_CREATE_INFO,
                                   .createFlags = XR_SWAPCHAIN_CREATE_STATIC_IMAGE_BIT,
                                   .usageFlags = XR_SWAPCHAIN_USAGE_TRANSFER_DST_BIT,
                                   .format = format,
                                   .sampleCount = 1,
                                   .width = SIZE,
                                   .height = SIZE,
                                   .faceCount = faces,
                                   .arraySize = 1,
                                   .mipCount = 1};
}

static XrSwapchain make(struct client *c, uint32_t faces, int64_t format) {
    XrSwapchainCreateInfo info = static_info(faces, format);
    XrSwapchain s;
    XR_OK(xrCreateSwapchain(c->session, &info, &s));
    return s;
}

static void barrier(VkCommandBuffer cmd, VkImage image, VkImageLayout from, VkImageLayout to) {
    VkImageMemoryBarrier b = {
        .sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER,
        .srcAccessMask = VK_ACCESS_MEMORY_WRITE_BIT,
        .dstAccessMask = VK_ACCESS_MEMORY_WRITE_BIT,
        .oldLayout = from,
        .newLayout = to,
        .image = image,
        .subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, VK_REMAINING_ARRAY_LAYERS}};
    vkCmdPipelineBarrier(cmd, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT,
                         VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, 0, 0, NULL, 0, NULL, 1, &b);
}

static const VkClearColorValue colours[6] = {{.float32 = {1, 0, 0, 1}}, {.float32 = {0, 1, 0, 1}},
                                             {.float32 = {0, 0, 1, 1}}, {.float32 = {1, 1, 0, 1}},
                                             {.float32 = {0, 1, 1, 1}}, {.float32 = {1, 0, 1, 1}}};

// Every face in its own colour, from `first` on.
static void paint(struct client *c, VkImage image, uint32_t faces, uint32_t first) {
    VkCommandPoolCreateInfo pool_info = {.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO};
    VkCommandPool pool;
    assert_int_equal(vkCreateCommandPool(c->device, &pool_info, NULL, &pool), VK_SUCCESS);
    VkCommandBufferAllocateInfo a = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
                                     .commandPool = pool,
                                     .commandBufferCount = 1};
    VkCommandBuffer cmd;
    assert_int_equal(vkAllocateCommandBuffers(c->device, &a, &cmd), VK_SUCCESS);
    VkCommandBufferBeginInfo begin = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
    vkBeginCommandBuffer(cmd, &begin);
    const VkImageLayout between = VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL;
    barrier(cmd, image, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL, between);
    for (uint32_t k = 0; k < faces; k++) {
        VkImageSubresourceRange part = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, k, 1};
        vkCmdClearColorImage(cmd, image, between, &colours[first + k], 1, &part);
    }
    barrier(cmd, image, between, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL);
    vkEndCommandBuffer(cmd);
    VkSubmitInfo submit = {
        .sType = VK_STRUCTURE_TYPE_SUBMIT_INFO, .commandBufferCount = 1, .pCommandBuffers = &cmd};
    VkQueue queue;
    vkGetDeviceQueue(c->device, 0, 0, &queue);
    assert_int_equal(vkQueueSubmit(queue, 1, &submit, VK_NULL_HANDLE), VK_SUCCESS);
    vkQueueWaitIdle(queue);
    vkDestroyCommandPool(c->device, pool, NULL);
}

static void acquire(XrSwapchain s) {
    uint32_t index;
    XR_OK(xrAcquireSwapchainImage(s, NULL, &index));
    XrSwapchainImageWaitInfo info = {.type = XR_TYPE_SWAPCHAIN_IMAGE_WAIT_INFO,
                                     .timeout = XR_INFINITE_DURATION};
    XR_OK(xrWaitSwapchainImage(s, &info));
}

// A static swapchain of one colour; a cube's faces have one each.
static XrSwapchain painted(struct client *c, uint32_t faces, uint32_t first) {
    XrSwapchain s = make(c, faces, VK_FORMAT_R8G8B8A8_SRGB);
    XrSwapchainImageVulkanKHR image = {.type = XR_TYPE_SWAPCHAIN_IMAGE_VULKAN_KHR};
    uint32_t count;
    XR_OK(xrEnumerateSwapchainImages(s, 1, &count, (XrSwapchainImageBaseHeader *)&image));
    assert_int_equal(count, 1);
    acquire(s);
    paint(c, image.image, faces, first);
    XR_OK(xrReleaseSwapchainImage(s, NULL));
    return s;
}

static XrResult end(struct client *c, XrTime time, const void *const *layers, uint32_t count) {
    XrFrameEndInfo info = {.type = XR_TYPE_FRAME_END_INFO,
                           .displayTime = time,
                           .environmentBlendMode = XR_ENVIRONMENT_BLEND_MODE_OPAQUE,
                           .layerCount = count,
                           .layers = (const XrCompositionLayerBaseHeader *const *)layers};
    return xrEndFrame(c->session, &info);
}

static XrResult end_one(struct client *c, XrTime time, const void *layer) {
    return end(c, time, &layer, 1);
}

// ---- One of each, that is in order

struct set {
    XrSwapchain flat, cube;
    XrCompositionLayerQuad quad;
    XrCompositionLayerCylinderKHR cylinder;
    XrCompositionLayerEquirectKHR equirect;
    XrCompositionLayerEquirect2KHR equirect2;
    XrCompositionLayerCubeKHR sky;
};

static const XrPosef IDENTITY = {.orientation.w = 1};

static void fill_set(struct set *s, XrSpace space) {
    XrSwapchainSubImage sub = {.swapchain = s->flat, .imageRect.extent = {SIZE, SIZE}};
    s->quad = (XrCompositionLayerQuad){.type = XR_TYPE_COMPOSITION_LAYER_QUAD,
                                       .space = space,
                                       .subImage = sub,
                                       .pose = {.orientation.w = 1, .position.z = -1},
                                       .size = {0.5f, 0.5f}};
    s->cylinder = (XrCompositionLayerCylinderKHR){.type = XR_TYPE_COMPOSITION_LAYER_CYLINDER_KHR,
                                                  .space = space,
                                                  .subImage = sub,
                                                  .pose = IDENTITY,
                                                  .radius = 2,
                                                  .centralAngle = 0.8f,
                                                  .aspectRatio = 2};
    s->equirect = (XrCompositionLayerEquirectKHR){.type = XR_TYPE_COMPOSITION_LAYER_EQUIRECT_KHR,
                                                  .space = space,
                                                  .subImage = sub,
                                                  .pose = IDENTITY,
                                                  .scale = {0.125f, 0.25f}};
    s->equirect2 = (XrCompositionLayerEquirect2KHR){.type = XR_TYPE_COMPOSITION_LAYER_EQUIRECT2_KHR,
                                                    .space = space,
                                                    .subImage = sub,
                                                    .pose = IDENTITY,
                                                    .radius = INFINITY,
                                                    .centralHorizontalAngle = 0.785398f,
                                                    .upperVerticalAngle = 0.392699f,
                                                    .lowerVerticalAngle = -0.392699f};
    s->sky = (XrCompositionLayerCubeKHR){.type = XR_TYPE_COMPOSITION_LAYER_CUBE_KHR,
                                         .space = space,
                                         .swapchain = s->cube,
                                         .orientation.w = 1};
}

static void layers_need_their_extension(void **state) {
    (void)state;
    struct client c = {0};
    start(&c, false, "");
    struct set s = {.flat = painted(&c, 1, 1), .cube = painted(&c, 6, 0)};
    XrTime time = client_wait(&c).predictedDisplayTime;
    client_begin(&c);
    fill_set(&s, c.local);
    XR_IS(XR_ERROR_LAYER_INVALID, end_one(&c, time, &s.cylinder));
    XR_IS(XR_ERROR_LAYER_INVALID, end_one(&c, time, &s.equirect));
    XR_IS(XR_ERROR_LAYER_INVALID, end_one(&c, time, &s.equirect2));
    XR_IS(XR_ERROR_LAYER_INVALID, end_one(&c, time, &s.sky));
    s.quad.type = XR_TYPE_UNKNOWN;
    XR_IS(XR_ERROR_LAYER_INVALID, end_one(&c, time, &s.quad));
    fill_set(&s, c.local);
    XR_OK(end_one(&c, time, &s.quad));
    client_stop(&c);
}

// Each change alone makes the layer wrong; the frame is still there to be ended.
#define WRONG(expected, layer, member, value)                                                      \
    do {                                                                                           \
        fill_set(&s, c.local);                                                                     \
        s.layer.member = value;                                                                    \
        XR_IS(expected, end_one(&c, time, &s.layer));                                              \
    } while (0)
#define INVALID(layer, member, value) WRONG(XR_ERROR_VALIDATION_FAILURE, layer, member, value)

static void what_is_wrong_is_named(void **state) {
    (void)state;
    struct client c = {0};
    start(&c, true, "");
    struct set s = {.flat = painted(&c, 1, 1), .cube = painted(&c, 6, 0)};
    XrSwapchain bare = make(&c, 1, VK_FORMAT_R8G8B8A8_SRGB);
    XrSwapchain depth = make(&c, 1, VK_FORMAT_D32_SFLOAT);
    XrTime time = client_wait(&c).predictedDisplayTime;
    client_begin(&c);
    WRONG(XR_ERROR_LAYER_INVALID, quad, subImage.swapchain, bare);
    WRONG(XR_ERROR_LAYER_INVALID, quad, subImage.swapchain, depth);
    WRONG(XR_ERROR_HANDLE_INVALID, quad, subImage.swapchain, XR_NULL_HANDLE);
    WRONG(XR_ERROR_HANDLE_INVALID, quad, space, XR_NULL_HANDLE);
    WRONG(XR_ERROR_SWAPCHAIN_RECT_INVALID, quad, subImage.imageRect.offset.x, 1);
    WRONG(XR_ERROR_SWAPCHAIN_RECT_INVALID, cylinder, subImage.imageRect.extent.height, -1);
    WRONG(XR_ERROR_POSE_INVALID, quad, pose.orientation.w, 0.98f);
    WRONG(XR_ERROR_POSE_INVALID, equirect2, pose.position.x, NAN);
    WRONG(XR_ERROR_POSE_INVALID, sky, orientation.w, 0);
    INVALID(quad, subImage.swapchain, s.cube);
    INVALID(quad, subImage.imageArrayIndex, 1);
    INVALID(quad, eyeVisibility, (XrEyeVisibility)3);
    INVALID(quad, layerFlags, 1u << 20);
    INVALID(quad, size.width, -1);
    INVALID(quad, size.height, NAN);
    INVALID(cylinder, radius, -1);
    INVALID(cylinder, radius, NAN);
    INVALID(cylinder, centralAngle, -0.1f);
    INVALID(cylinder, centralAngle, 6.3f);
    INVALID(cylinder, aspectRatio, 0);
    INVALID(equirect, radius, -1);
    INVALID(equirect, scale.x, INFINITY);
    INVALID(equirect, bias.y, NAN);
    INVALID(equirect2, centralHorizontalAngle, 6.3f);
    INVALID(equirect2, upperVerticalAngle, 1.6f);
    INVALID(equirect2, lowerVerticalAngle, -1.6f);
    INVALID(sky, swapchain, s.flat);
    INVALID(sky, imageArrayIndex, 1);
    fill_set(&s, c.local);
    const void *many[17];
    for (int k = 0; k < 17; k++)
        many[k] = &s.quad;
    XR_IS(XR_ERROR_LAYER_LIMIT_EXCEEDED, end(&c, time, many, 17));
    XR_OK(end(&c, time, many, 16));
    client_stop(&c);
}

struct projection {
    XrCompositionLayerDepthInfoKHR depth[2];
    XrCompositionLayerProjectionView views[2];
    XrCompositionLayerProjection layer;
};

static void fill_projection(struct projection *p, XrSpace space, XrSwapchain colour,
                            XrSwapchain depth) {
    XrSwapchainSubImage sub = {.swapchain = colour, .imageRect.extent = {SIZE, SIZE}};
    for (int eye = 0; eye < 2; eye++) {
        p->depth[eye] = (XrCompositionLayerDepthInfoKHR){
            .type = XR_TYPE_COMPOSITION_LAYER_DEPTH_INFO_KHR,
            .subImage = {.swapchain = depth, .imageRect.extent = {SIZE, SIZE}},
            .maxDepth = 1,
            .nearZ = INFINITY,
            .farZ = 0.1f};
        p->views[eye] =
            (XrCompositionLayerProjectionView){.type = XR_TYPE_COMPOSITION_LAYER_PROJECTION_VIEW,
                                               .next = &p->depth[eye],
                                               .pose = IDENTITY,
                                               .fov = {-0.8f, 0.8f, 0.7f, -0.7f},
                                               .subImage = sub};
    }
    p->layer = (XrCompositionLayerProjection){.type = XR_TYPE_COMPOSITION_LAYER_PROJECTION,
                                              .space = space,
                                              .viewCount = 2,
                                              .views = p->views};
}

#define DEPTH_WRONG(expected, member, value)                                                       \
    do {                                                                                           \
        fill_projection(&p, c.local, colour, depth);                                               \
        p.depth[1].member = value;                                                                 \
        XR_IS(expected, end_one(&c, time, &p.layer));                                              \
    } while (0)

static void depth_is_verified(void **state) {
    (void)state;
    struct client c = {0};
    start(&c, true, "");
    XrSwapchain colour = painted(&c, 1, 1), bare = make(&c, 1, VK_FORMAT_D32_SFLOAT);
    XrSwapchain depth = make(&c, 1, VK_FORMAT_D32_SFLOAT);
    acquire(depth);
    XR_OK(xrReleaseSwapchainImage(depth, NULL));
    XrTime time = client_wait(&c).predictedDisplayTime;
    client_begin(&c);
    struct projection p;
    DEPTH_WRONG(XR_ERROR_LAYER_INVALID, subImage.swapchain, bare);
    DEPTH_WRONG(XR_ERROR_LAYER_INVALID, subImage.swapchain, colour);
    DEPTH_WRONG(XR_ERROR_HANDLE_INVALID, subImage.swapchain, XR_NULL_HANDLE);
    DEPTH_WRONG(XR_ERROR_SWAPCHAIN_RECT_INVALID, subImage.imageRect.offset.y, 1);
    DEPTH_WRONG(XR_ERROR_VALIDATION_FAILURE, subImage.imageArrayIndex, 1);
    DEPTH_WRONG(XR_ERROR_VALIDATION_FAILURE, minDepth, 1);
    DEPTH_WRONG(XR_ERROR_VALIDATION_FAILURE, minDepth, -0.5f);
    DEPTH_WRONG(XR_ERROR_VALIDATION_FAILURE, maxDepth, NAN);
    DEPTH_WRONG(XR_ERROR_VALIDATION_FAILURE, nearZ, 0.1f); // as far as farZ
    DEPTH_WRONG(XR_ERROR_VALIDATION_FAILURE, farZ, 0);
    fill_projection(&p, c.local, colour, depth);
    XR_OK(end_one(&c, time, &p.layer));
    client_stop(&c);
}

// ---- Where they are seen

static struct ap_image picture(int index, int eye) {
    char path[256];
    snprintf(path, sizeof path, "%s/cap/%06d-%s.png", client_folder(), index,
             eye ? "right" : "left");
    struct ap_image image;
    struct ap_error err;
    if (ap_png_read(&err, path, &image))
        fail_msg("%s", err.text);
    return image;
}

// The pixel in the direction x right and y up, in radians, has this colour (NULL: black).
static void seen(int index, int eye, double x, double y, const VkClearColorValue *colour) {
    struct ap_image image = picture(index, eye);
    int i = (int)(W * (0.5 + 0.5 * tan(x) / tan(0.8))),
        j = (int)(H * (0.5 - 0.5 * tan(y) / tan(0.7)));
    for (int k = 0; k < 3; k++) {
        int expected = colour ? (int)(255 * colour->float32[k]) : 0,
            is = image.rgb[(j * W + i) * 3 + k];
        if (is != expected)
            fail_msg("frame %d eye %d at (%g, %g) rad: channel %d is %d, expected %d", index, eye,
                     x, y, k, is, expected);
    }
    ap_image_finish(&image);
}

// Green from −w to w and from −h to h, black beyond.
static void seen_rectangle(int index, int eye, double w, double h) {
    const double in = 0.9, out = 1.15;
    seen(index, eye, 0, 0, &colours[1]);
    for (int sign = -1; sign <= 1; sign += 2) {
        seen(index, eye, sign * in * w, 0, &colours[1]);
        seen(index, eye, 0, sign * in * h, &colours[1]);
        seen(index, eye, sign * out * w, 0, NULL);
        seen(index, eye, 0, sign * out * h, NULL);
    }
}

static void they_are_seen_where_they_are(void **state) {
    (void)state;
    struct client c = {0};
    char capture[256];
    snprintf(capture, sizeof capture, "\"capture\": {\"dir\": \"%s/cap\"},", client_folder());
    start(&c, true, capture);
    struct set s = {.flat = painted(&c, 1, 1), .cube = painted(&c, 6, 0)};
    // On the head, so that the walk does not matter.
    fill_set(&s, c.view);
    s.quad.eyeVisibility = XR_EYE_VISIBILITY_LEFT;
    s.quad.pose.position.z = -100;
    s.quad.size = (XrExtent2Df){50, 50};
    s.cylinder.radius = 0;
    XrCompositionLayerEquirectKHR aside = s.equirect;
    aside.bias = (XrVector2f){0.05f, 0.05f}; // 18° right and 9° down
    const void *frames[6] = {&s.quad, &s.cylinder, &s.equirect, &s.equirect2, &s.sky, &aside};
    for (int k = 0; k < 6; k++) {
        XrTime time = client_wait(&c).predictedDisplayTime;
        client_begin(&c);
        XR_OK(end_one(&c, time, frames[k]));
    }
    client_stop(&c);
    seen_rectangle(0, 0, atan(0.25), atan(0.25));
    seen(0, 1, 0, 0, NULL); // the left eye's only
    for (int eye = 0; eye < 2; eye++) {
        seen_rectangle(1, eye, 0.4, atan(0.2));
        seen_rectangle(2, eye, 0.3927, 0.3927);
        seen_rectangle(3, eye, 0.3927, 0.3927);
        seen(4, eye, 0, 0, &colours[5]); // −z
        seen(5, eye, 0.3, -0.15, &colours[1]);
        seen(5, eye, 0.62, -0.15, &colours[1]);
        seen(5, eye, -0.05, -0.15, &colours[1]);
        seen(5, eye, -0.15, -0.15, NULL);
        seen(5, eye, 0.3, 0.35, NULL);
    }
}

// ---- Cube swapchains

static void cube_swapchains(void **state) {
    (void)state;
    struct client c = {0};
    start(&c, true, "");
    XrSwapchain s;
    XrSwapchainCreateInfo i = static_info(6, VK_FORMAT_R8G8B8A8_SRGB);
    i.height = 2 * SIZE;
    XR_IS(XR_ERROR_VALIDATION_FAILURE, xrCreateSwapchain(c.session, &i, &s));
    i = static_info(5, VK_FORMAT_R8G8B8A8_SRGB);
    XR_IS(XR_ERROR_VALIDATION_FAILURE, xrCreateSwapchain(c.session, &i, &s));
    i = static_info(6, VK_FORMAT_R8G8B8A8_SRGB);
    i.sampleCount = 4;
    XR_IS(XR_ERROR_FEATURE_UNSUPPORTED, xrCreateSwapchain(c.session, &i, &s));
    i = static_info(6, VK_FORMAT_R8G8B8A8_SRGB);
    i.createFlags = 0;
    i.arraySize = 3;
    i.mipCount = 5;
    XR_OK(xrCreateSwapchain(c.session, &i, &s));
    XR_OK(xrDestroySwapchain(s));
    client_stop(&c);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(layers_need_their_extension, client_teardown),
        cmocka_unit_test_teardown(what_is_wrong_is_named, client_teardown),
        cmocka_unit_test_teardown(depth_is_verified, client_teardown),
        cmocka_unit_test_teardown(they_are_seen_where_they_are, client_teardown),
        cmocka_unit_test_teardown(cube_swapchains, client_teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
