#include "tests/sim_hmd/client.h"

#include <inttypes.h>
#include <jansson.h>
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "src/base/clock.h"
#include "src/base/file.h"
#include "src/image/image.h"
#include "src/image/lens.h"

// What a capture holds beside the composed pictures, through the loader: the program's own pictures
// bit for bit, frames.jsonl, the lens, and that two runs leave the same bytes.

enum { W = 64, H = 48, FRAMES = 6 };

static const char *clock_name = "virtual";

static void start(struct client *c, const char *dir, const char *more, const char *profile) {
    char json[2048];
    snprintf(json, sizeof json,
             "{\"clock\": \"%s\", \"capture\": {\"dir\": \"%s/%s\"%s}, \"headset\": "
             "{\"name\": \"tiny\", \"refresh_hz\": 90, \"ipd_m\": 0.06%s, \"eyes\": {\"left\": "
             "{\"resolution_px\": [%d, %d], \"fov_rad\": {\"left\": -0.8, \"right\": 0.7, "
             "\"up\": 0.7, \"down\": -0.6}}, \"right\": {\"resolution_px\": [%d, %d], "
             "\"fov_rad\": {\"left\": -0.7, \"right\": 0.8, \"up\": 0.7, \"down\": -0.6}}}}}",
             clock_name, client_folder(), dir, more, profile, W, H, W, H);
    client_settings(json);
    client_start(c);
}

// ---- a program that draws by copying: swapchains of two array layers, a colour for every pixel

static uint8_t texel(int x, int y, int layer, int channel) {
    const int v[4] = {x * 3 + 17 * layer, y * 5, x ^ y, 255 - 2 * x};
    return (uint8_t)v[channel];
}

struct screen {
    XrSwapchain swapchain;
    VkImage image[3];
    VkFormat format;
    uint32_t texel_bytes;
};

struct program {
    struct client c;
    VkBuffer buffer;
    VkDeviceMemory memory;
    uint8_t *mapped;
    VkCommandPool pool;
    VkQueue queue;
};

static void make_program(struct program *p, const char *dir, const char *more,
                         const char *profile) {
    *p = (struct program){0};
    start(&p->c, dir, more, profile);
    VkBufferCreateInfo b = {.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO,
                            .size = 2 * W * H * 8,
                            .usage = VK_BUFFER_USAGE_TRANSFER_SRC_BIT};
    assert_int_equal(vkCreateBuffer(p->c.device, &b, NULL, &p->buffer), VK_SUCCESS);
    VkMemoryRequirements needs;
    vkGetBufferMemoryRequirements(p->c.device, p->buffer, &needs);
    VkMemoryAllocateInfo a = {.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO,
                              .allocationSize = needs.size}; // type 0: host visible on lavapipe
    assert_int_equal(vkAllocateMemory(p->c.device, &a, NULL, &p->memory), VK_SUCCESS);
    assert_int_equal(vkBindBufferMemory(p->c.device, p->buffer, p->memory, 0), VK_SUCCESS);
    assert_int_equal(vkMapMemory(p->c.device, p->memory, 0, VK_WHOLE_SIZE, 0, (void **)&p->mapped),
                     VK_SUCCESS);
    VkCommandPoolCreateInfo pool = {.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO};
    assert_int_equal(vkCreateCommandPool(p->c.device, &pool, NULL, &p->pool), VK_SUCCESS);
    vkGetDeviceQueue(p->c.device, 0, 0, &p->queue);
}

static void end_program(struct program *p) {
    vkDeviceWaitIdle(p->c.device);
    vkDestroyCommandPool(p->c.device, p->pool, NULL);
    vkDestroyBuffer(p->c.device, p->buffer, NULL);
    vkFreeMemory(p->c.device, p->memory, NULL);
    client_stop(&p->c);
}

static struct screen make_screen(struct program *p, VkFormat format) {
    struct screen s = {.format = format,
                       .texel_bytes = format == VK_FORMAT_R16G16B16A16_SFLOAT ? 8 : 4};
    XrSwapchainCreateInfo i = {.type = XR_TYPE_SWAPCHAIN_CREATE_INFO,
                               .usageFlags = XR_SWAPCHAIN_USAGE_COLOR_ATTACHMENT_BIT |
                                             XR_SWAPCHAIN_USAGE_TRANSFER_DST_BIT,
                               .format = format,
                               .sampleCount = 1,
                               .width = W,
                               .height = H,
                               .faceCount = 1,
                               .arraySize = 2,
                               .mipCount = 1};
    XR_OK(xrCreateSwapchain(p->c.session, &i, &s.swapchain));
    XrSwapchainImageVulkanKHR images[3] = {{.type = XR_TYPE_SWAPCHAIN_IMAGE_VULKAN_KHR},
                                           {.type = XR_TYPE_SWAPCHAIN_IMAGE_VULKAN_KHR},
                                           {.type = XR_TYPE_SWAPCHAIN_IMAGE_VULKAN_KHR}};
    uint32_t count;
    XR_OK(xrEnumerateSwapchainImages(s.swapchain, 3, &count, (XrSwapchainImageBaseHeader *)images));
    for (int k = 0; k < 3; k++)
        s.image[k] = images[k].image;
    return s;
}

// The half of v/255: 2048 steps from 0.5 to 1 and so on, so that a byte comes back from it.
static uint16_t half_of(double v) {
    int e = 0;
    if (v <= 0)
        return 0;
    double m = frexp(v, &e); // 0.5 ≤ m < 1
    return e < -13 ? 0 : (uint16_t)(((e + 14) << 10) + (int)lround((2 * m - 1) * 1024));
}

static void fill(struct program *p, const struct screen *s, int frame) {
    uint8_t *to = p->mapped;
    for (int layer = 0; layer < 2; layer++)
        for (int y = 0; y < H; y++)
            for (int x = 0; x < W; x++)
                for (int c = 0; c < 4; c++) {
                    uint8_t v = texel(x + frame, y, layer, c);
                    uint16_t half = half_of(c == 3 ? v / 255.0 : ap_linear_from_srgb(v));
                    if (s->texel_bytes == 8)
                        memcpy(to, &half, 2);
                    else
                        *to = v;
                    to += s->texel_bytes / 4;
                }
}

static void turn(VkCommandBuffer cmd, VkImage image, VkImageLayout from, VkImageLayout to) {
    VkImageMemoryBarrier b = {.sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER,
                              .srcAccessMask = VK_ACCESS_MEMORY_WRITE_BIT,
                              .dstAccessMask = VK_ACCESS_MEMORY_WRITE_BIT,
                              .oldLayout = from,
                              .newLayout = to,
                              .image = image,
                              .subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 2}};
    vkCmdPipelineBarrier(cmd, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT,
                         VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, 0, 0, NULL, 0, NULL, 1, &b);
}

static void draw(struct program *p, struct screen *s, int frame) {
    uint32_t index;
    XrSwapchainImageWaitInfo wait = {.type = XR_TYPE_SWAPCHAIN_IMAGE_WAIT_INFO,
                                     .timeout = XR_INFINITE_DURATION};
    XR_OK(xrAcquireSwapchainImage(s->swapchain, NULL, &index));
    XR_OK(xrWaitSwapchainImage(s->swapchain, &wait));
    fill(p, s, frame);
    VkCommandBufferAllocateInfo a = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
                                     .commandPool = p->pool,
                                     .commandBufferCount = 1};
    VkCommandBuffer cmd;
    assert_int_equal(vkAllocateCommandBuffers(p->c.device, &a, &cmd), VK_SUCCESS);
    VkCommandBufferBeginInfo begin = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
    vkBeginCommandBuffer(cmd, &begin);
    turn(cmd, s->image[index], VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL,
         VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
    VkBufferImageCopy copy = {.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 2},
                              .imageExtent = {W, H, 1}};
    vkCmdCopyBufferToImage(cmd, p->buffer, s->image[index], VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1,
                           &copy);
    turn(cmd, s->image[index], VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
         VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL);
    vkEndCommandBuffer(cmd);
    VkSubmitInfo submit = {
        .sType = VK_STRUCTURE_TYPE_SUBMIT_INFO, .commandBufferCount = 1, .pCommandBuffers = &cmd};
    assert_int_equal(vkQueueSubmit(p->queue, 1, &submit, VK_NULL_HANDLE), VK_SUCCESS);
    vkQueueWaitIdle(p->queue); // the buffer is written again for the next screen
    XR_OK(xrReleaseSwapchainImage(s->swapchain, NULL));
}

struct layer {
    XrCompositionLayerProjectionView views[2];
    XrCompositionLayerProjection projection;
};

static void make_layer(struct program *p, const struct screen *s, XrTime time, XrRect2Di rect,
                       XrCompositionLayerFlags flags, struct layer *l) {
    XrViewLocateInfo info = {.type = XR_TYPE_VIEW_LOCATE_INFO,
                             .viewConfigurationType = XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO,
                             .displayTime = time,
                             .space = p->c.stage};
    XrViewState view_state = {.type = XR_TYPE_VIEW_STATE};
    XrView views[2] = {{.type = XR_TYPE_VIEW}, {.type = XR_TYPE_VIEW}};
    uint32_t count;
    XR_OK(xrLocateViews(p->c.session, &info, &view_state, 2, &count, views));
    *l = (struct layer){.projection = {.type = XR_TYPE_COMPOSITION_LAYER_PROJECTION,
                                       .layerFlags = flags,
                                       .space = p->c.stage,
                                       .viewCount = 2,
                                       .views = l->views}};
    for (uint32_t eye = 0; eye < 2; eye++)
        l->views[eye] = (XrCompositionLayerProjectionView){
            .type = XR_TYPE_COMPOSITION_LAYER_PROJECTION_VIEW,
            .pose = views[eye].pose,
            .fov = views[eye].fov,
            .subImage = {.swapchain = s->swapchain, .imageRect = rect, .imageArrayIndex = 1 - eye}};
}

static const XrRect2Di whole = {{0, 0}, {W, H}}, part = {{5, 7}, {33, 19}};

// Two layers a frame, the second blended and a part of its image, for `frames` frames.
static void run(struct program *p, VkFormat first, VkFormat second, int frames) {
    struct screen s[2] = {make_screen(p, first), make_screen(p, second)};
    for (int k = 0; k < frames; k++) {
        struct layer l[2];
        XrFrameState f = client_wait(&p->c);
        client_begin(&p->c);
        for (int i = 0; i < 2; i++) {
            draw(p, &s[i], k);
            make_layer(p, &s[i], f.predictedDisplayTime, i ? part : whole,
                       i ? XR_COMPOSITION_LAYER_BLEND_TEXTURE_SOURCE_ALPHA_BIT : 0, &l[i]);
        }
        const XrCompositionLayerBaseHeader *list[2] = {
            (const XrCompositionLayerBaseHeader *)&l[0].projection,
            (const XrCompositionLayerBaseHeader *)&l[1].projection};
        XrFrameEndInfo end = {.type = XR_TYPE_FRAME_END_INFO,
                              .displayTime = f.predictedDisplayTime,
                              .environmentBlendMode = XR_ENVIRONMENT_BLEND_MODE_OPAQUE,
                              .layerCount = 2,
                              .layers = list};
        XR_OK(xrEndFrame(p->c.session, &end));
    }
}

// ---- reading what was left

static const char *path_of(const char *dir, const char *name) {
    static char path[512];
    snprintf(path, sizeof path, "%s/%s/%s", client_folder(), dir, name);
    return path;
}

static bool exists(const char *dir, const char *name) {
    return ap_file_exists(path_of(dir, name));
}

static char *read_whole(const char *dir, const char *name, size_t *len) {
    char *bytes;
    struct ap_error err;
    if (ap_file_read(&err, path_of(dir, name), 1 << 24, &bytes, len))
        fail_msg("%s", err.text);
    return bytes;
}

// Every byte of a PAM, by hand: its header is pinned too.
static void check_pam(const char *dir, const char *name, XrRect2Di r, int layer, int frame,
                      bool linear, int tolerance) {
    char header[128];
    int n = snprintf(header, sizeof header,
                     "P7\n%sWIDTH %d\nHEIGHT %d\nDEPTH 4\nMAXVAL 255\nTUPLTYPE RGB_ALPHA\nENDHDR\n",
                     linear ? "# linear light\n" : "", r.extent.width, r.extent.height);
    size_t len;
    char *bytes = read_whole(dir, name, &len);
    assert_int_equal(len, (size_t)n + (size_t)r.extent.width * (size_t)r.extent.height * 4);
    assert_memory_equal(bytes, header, (size_t)n);
    const uint8_t *at = (const uint8_t *)bytes + n;
    for (int y = 0; y < r.extent.height; y++)
        for (int x = 0; x < r.extent.width; x++)
            for (int c = 0; c < 4; c++, at++) {
                int want = texel(r.offset.x + x + frame, r.offset.y + y, layer, c);
                if (abs(*at - want) > tolerance)
                    fail_msg("%s: (%d, %d) channel %d is %d, expected %d within %d", name, x, y, c,
                             *at, want, tolerance);
            }
    free(bytes);
}

// A killed program leaves whole lines under the other name. First: it forks.
static void a_killed_program_leaves_its_lines(void **state) {
    (void)state;
    client_folder();
    pid_t child = fork();
    if (child == 0) {
        struct program p;
        make_program(&p, "killed", ", \"log\": \"all\", \"frames\": \"1:2\"", "");
        run(&p, VK_FORMAT_R8G8B8A8_SRGB, VK_FORMAT_R8G8B8A8_SRGB, FRAMES);
        kill(getpid(), SIGKILL);
    }
    int status;
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_true(WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL);
    assert_false(exists("killed", "frames.jsonl"));
    size_t len;
    char *text = read_whole("killed", "frames.jsonl.part", &len);
    int lines = 0;
    for (char *line = text; *line; lines++) {
        json_t *root = json_loadb(line, strcspn(line, "\n"), 0, NULL);
        assert_non_null(root);
        json_decref(root);
        line += strcspn(line, "\n") + 1;
    }
    assert_int_equal(lines, FRAMES);
    free(text);
}

static void layers_are_bit_for_bit(void **state) {
    (void)state;
    static const struct {
        VkFormat format[2];
        bool linear[2];
        int tolerance;
    } cases[] = {
        {{VK_FORMAT_R8G8B8A8_SRGB, VK_FORMAT_B8G8R8A8_SRGB}, {false, false}, 0},
        {{VK_FORMAT_R8G8B8A8_UNORM, VK_FORMAT_B8G8R8A8_UNORM}, {true, true}, 0},
        {{VK_FORMAT_R16G16B16A16_SFLOAT, VK_FORMAT_R16G16B16A16_SFLOAT}, {false, false}, 1},
    };
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        struct program p;
        char dir[16];
        snprintf(dir, sizeof dir, "layers%zu", k);
        make_program(
            &p, dir,
            ", \"layers\": true, \"composed\": false, \"format\": \"raw\", \"frames\": \"1:4:2\"",
            "");
        run(&p, cases[k].format[0], cases[k].format[1], FRAMES);
        end_program(&p);
        for (int frame = 1; frame < 4; frame += 2)
            for (int eye = 0; eye < 2; eye++)
                for (int layer = 0; layer < 2; layer++) {
                    bool bgra = cases[k].format[layer] == VK_FORMAT_B8G8R8A8_SRGB ||
                                cases[k].format[layer] == VK_FORMAT_B8G8R8A8_UNORM;
                    char name[64];
                    snprintf(name, sizeof name, "%06d-layer%d-%s.pam", frame, layer,
                             eye ? "right" : "left");
                    if (!bgra) // the file is R,G,B,A whatever the image is
                        check_pam(dir, name, layer ? part : whole, 1 - eye, frame,
                                  cases[k].linear[layer], cases[k].tolerance);
                    else
                        assert_true(exists(dir, name));
                }
        assert_false(exists(dir, "000001-left.pam"));
        assert_false(exists(dir, "000000-layer0-left.pam"));
        assert_true(exists(dir, "frames.jsonl"));
    }
}

// PNG: colours as they are; a blended layer keeps its alpha.
static void layers_as_png(void **state) {
    (void)state;
    struct program p;
    make_program(&p, "png", ", \"layers\": true, \"frames\": \"2:3\"", "");
    run(&p, VK_FORMAT_R8G8B8A8_SRGB, VK_FORMAT_B8G8R8A8_SRGB, FRAMES);
    end_program(&p);
    for (int layer = 0; layer < 2; layer++)
        for (int eye = 0; eye < 2; eye++) {
            char name[64];
            snprintf(name, sizeof name, "000002-layer%d-%s.png", layer, eye ? "right" : "left");
            struct ap_image image;
            struct ap_error err;
            if (ap_png_read(&err, path_of("png", name), &image))
                fail_msg("%s", err.text);
            XrRect2Di r = layer ? part : whole;
            assert_int_equal(image.width, r.extent.width);
            assert_int_equal(image.height, r.extent.height);
            for (int k = 0; k < r.extent.width * r.extent.height * 3; k++) {
                int x = k / 3 % r.extent.width, y = k / 3 / r.extent.width, c = k % 3;
                // What the program wrote into a BGRA image first is blue.
                int want = texel(r.offset.x + x + 2, r.offset.y + y, 1 - eye, layer ? 2 - c : c);
                if (image.rgb[k] != want)
                    fail_msg("%s: (%d, %d) channel %d is %d, expected %d", name, x, y, c,
                             image.rgb[k], want);
            }
            ap_image_finish(&image);
            size_t len;
            char *bytes = read_whole("png", name, &len);
            assert_int_equal(bytes[25], layer ? 6 : 2); // IHDR's colour type: RGBA, RGB
            free(bytes);
        }
    assert_true(exists("png", "000002-left.png"));
}

static json_t *at(json_t *root, const char *path) {
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

static void check_text(json_t *root, const char *path, const char *want) {
    assert_string_equal(json_string_value(at(root, path)), want);
}

static void check_number(json_t *root, const char *path, double want) {
    double got = json_number_value(at(root, path));
    if (got != want)
        fail_msg("%s: %.17g, expected %.17g", path, got, want);
}

static void check_line(json_t *root, int frame) {
    check_number(root, "frame", frame);
    check_number(root, "display_ns", (double)(1000000000 + llround(frame * 1e9 / 90)));
    check_number(root, "missed", 0);
    check_number(root, "discarded", 0);
    assert_null(json_object_get(root, "ended_ns")); // no machine's time
    check_text(root, "head/tracking", "tracked");
    assert_int_equal(json_array_size(at(root, "head/pose")), 7);
    check_number(root, "eyes/1/fov/1", (double)0.8f);
    assert_int_equal(json_array_size(at(root, "layers")), 2);
    check_text(root, "layers/0/type", "projection");
    check_text(root, "layers/0/space", "stage");
    assert_int_equal(json_array_size(at(root, "layers/0/flags")), 0);
    check_text(root, "layers/0/views/0/format", "R8G8B8A8_SRGB");
    check_number(root, "layers/0/views/0/array_index", 1);
    check_text(root, "layers/1/flags/0", "blend_texture_source_alpha");
    check_text(root, "layers/1/views/1/format", "B8G8R8A8_UNORM");
    check_number(root, "layers/1/views/1/array_index", 0);
    const double rect[] = {5, 7, 33, 19, W, H};
    for (int k = 0; k < 6; k++) {
        char path[64];
        snprintf(path, sizeof path, "layers/1/views/1/%s/%d", k < 4 ? "rect" : "size", k % 4);
        check_number(root, path, rect[k]);
    }
    // The program located its views in STAGE, so that is where they are, to float.
    for (int k = 0; k < 7; k++) {
        char path[64];
        snprintf(path, sizeof path, "eyes/1/pose/%d", k);
        double want = (double)(float)json_number_value(at(root, path));
        snprintf(path, sizeof path, "layers/0/views/1/pose/%d", k);
        check_number(root, path, want);
    }
    const char *files[] = {"000001-left.png",        "000001-right.png",
                           "000001-layer0-left.png", "000001-layer0-right.png",
                           "000001-layer1-left.png", "000001-layer1-right.png"};
    assert_int_equal(json_array_size(at(root, "files")), frame == 1 ? 6 : 0);
    for (size_t k = 0; k < 6 && frame == 1; k++) {
        assert_string_equal(json_string_value(json_array_get(at(root, "files"), k)), files[k]);
        assert_true(exists("log", files[k]));
    }
}

static void the_log_tells_what_was_submitted(void **state) {
    (void)state;
    struct program p;
    make_program(&p, "log", ", \"layers\": true, \"log\": \"all\", \"frames\": \"1:2\"", "");
    run(&p, VK_FORMAT_R8G8B8A8_SRGB, VK_FORMAT_B8G8R8A8_UNORM, FRAMES);
    end_program(&p);
    size_t len;
    char *text = read_whole("log", "frames.jsonl", &len);
    assert_false(exists("log", "frames.jsonl.part"));
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
    struct program p;
    clock_name = "real";
    make_program(&p, "real", ", \"log\": \"all\", \"frames\": \"0:1\"", "");
    clock_name = "virtual";
    for (int k = 0; k < FRAMES; k++) {
        XrFrameState f = client_wait(&p.c);
        client_begin(&p.c);
        if (k == LATE)
            ap_clock_sleep_until_ns(ap_clock_now_ns() + 60000000);
        client_end_empty(&p.c, f.predictedDisplayTime);
    }
    end_program(&p);
    size_t len;
    char *text = read_whole("real", "frames.jsonl", &len);
    double last = 0;
    int k = 0;
    for (char *line = text; *line; k++, line += strcspn(line, "\n") + 1) {
        json_t *root = json_loadb(line, strcspn(line, "\n"), JSON_REJECT_DUPLICATES, NULL);
        assert_non_null(root);
        double waited = json_number_value(at(root, "waited_ns"));
        double begun = json_number_value(at(root, "begun_ns"));
        double ended = json_number_value(at(root, "ended_ns"));
        double display = json_number_value(at(root, "display_ns"));
        double period = json_number_value(at(root, "period_ns"));
        check_number(root, "deadline_ns", display);
        if (!(last <= waited && waited <= begun && begun <= ended))
            fail_msg("frame %d: last %.0f, waited %.0f, begun %.0f, ended %.0f", k, last, waited,
                     begun, ended);
        // xrWaitFrame returns a period before the display, not sooner.
        if (waited < display - period - 1)
            fail_msg("frame %d: waited %.0f, display %.0f less %.0f", k, waited, display, period);
        assert_int_equal(json_is_true(at(root, "late")), ended > display);
        if (k == LATE)
            assert_true(json_is_true(at(root, "late")) && ended >= begun + 6e7);
        if (k == LATE + 1 && json_number_value(at(root, "missed")) < 3)
            fail_msg("after 60 ms at 90 Hz %g periods are missed, expected at least 3",
                     json_number_value(at(root, "missed")));
        last = ended;
        json_decref(root);
    }
    free(text);
    assert_int_equal(k, FRAMES);
}

static void two_runs_leave_the_same_bytes(void **state) {
    (void)state;
    char command[256];
    for (int k = 0; k < 2; k++) {
        struct program p;
        make_program(&p, k ? "again" : "once", ", \"layers\": true, \"log\": \"all\"", "");
        run(&p, VK_FORMAT_R8G8B8A8_SRGB, VK_FORMAT_R16G16B16A16_SFLOAT, FRAMES);
        end_program(&p);
    }
    snprintf(command, sizeof command, "diff -r '%s/once' '%s/again' >&2", client_folder(),
             client_folder());
    assert_int_equal(system(command), 0);
    snprintf(command, sizeof command, "test $(ls '%s/once' | wc -l) = %d", client_folder(),
             FRAMES * 6 + 1);
    assert_int_equal(system(command), 0);
}

// The composed picture, seen through the lens, is what the lens makes of the plain one.
static void through_the_lens(void **state) {
    (void)state;
    const char *lens = ", \"lens\": {\"k1\": 0.25, \"k2\": 0.05, \"red_scale\": 0.98, "
                       "\"blue_scale\": 1.03}";
    for (int k = 0; k < 2; k++) {
        struct program p;
        make_program(&p, k ? "lens" : "plain",
                     k ? ", \"lens\": true, \"frames\": \"1:2\"" : ", \"frames\": \"1:2\"", lens);
        run(&p, VK_FORMAT_R8G8B8A8_SRGB, VK_FORMAT_R8G8B8A8_SRGB, 3);
        end_program(&p);
    }
    for (int eye = 0; eye < 2; eye++) {
        const char *name = eye ? "000001-right.png" : "000001-left.png";
        struct ap_image plain, seen;
        assert_int_equal(ap_png_read(NULL, path_of("plain", name), &plain), AP_OK);
        assert_int_equal(ap_png_read(NULL, path_of("lens", name), &seen), AP_OK);
        static uint8_t in[W * H * 4], want[W * H * 4];
        for (int i = 0; i < W * H; i++)
            memcpy(in + 4 * i, plain.rgb + 3 * i, 3);
        struct ap_pixels pixels = {in, W, H, W * 4, false};
        struct ap_lens_view view = {
            tan(eye ? -0.7 : -0.8), tan(eye ? 0.8 : 0.7), tan(0.7), tan(-0.6), 0.25, 0.05,
            {0.98, 1, 1.03}};
        ap_pixels_through_lens(&pixels, &view, want);
        assert_memory_not_equal(plain.rgb, seen.rgb, W * H * 3);
        for (int i = 0; i < W * H; i++)
            assert_memory_equal(seen.rgb + 3 * i, want + 4 * i, 3);
        ap_image_finish(&plain);
        ap_image_finish(&seen);
    }
}

// One colour all over, whatever the image is: cleared, not copied to.
static void clear(struct program *p, XrSwapchain swapchain, const float rgba[4]) {
    uint32_t index, count;
    XrSwapchainImageWaitInfo wait = {.type = XR_TYPE_SWAPCHAIN_IMAGE_WAIT_INFO,
                                     .timeout = XR_INFINITE_DURATION};
    XrSwapchainImageVulkanKHR images[3] = {{.type = XR_TYPE_SWAPCHAIN_IMAGE_VULKAN_KHR},
                                           {.type = XR_TYPE_SWAPCHAIN_IMAGE_VULKAN_KHR},
                                           {.type = XR_TYPE_SWAPCHAIN_IMAGE_VULKAN_KHR}};
    XR_OK(xrEnumerateSwapchainImages(swapchain, 3, &count, (XrSwapchainImageBaseHeader *)images));
    XR_OK(xrAcquireSwapchainImage(swapchain, NULL, &index));
    XR_OK(xrWaitSwapchainImage(swapchain, &wait));
    VkCommandBufferAllocateInfo a = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
                                     .commandPool = p->pool,
                                     .commandBufferCount = 1};
    VkCommandBuffer cmd;
    assert_int_equal(vkAllocateCommandBuffers(p->c.device, &a, &cmd), VK_SUCCESS);
    VkCommandBufferBeginInfo begin = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
    vkBeginCommandBuffer(cmd, &begin);
    VkImage image = images[index].image;
    turn(cmd, image, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL,
         VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
    VkClearColorValue colour;
    memcpy(colour.float32, rgba, sizeof colour.float32);
    VkImageSubresourceRange all = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 2};
    vkCmdClearColorImage(cmd, image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, &colour, 1, &all);
    turn(cmd, image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
         VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL);
    vkEndCommandBuffer(cmd);
    VkSubmitInfo submit = {
        .sType = VK_STRUCTURE_TYPE_SUBMIT_INFO, .commandBufferCount = 1, .pCommandBuffers = &cmd};
    assert_int_equal(vkQueueSubmit(p->queue, 1, &submit, VK_NULL_HANDLE), VK_SUCCESS);
    XR_OK(xrReleaseSwapchainImage(swapchain, NULL));
}

static void check_colour(const char *name, int width, int height, const int want[3]) {
    struct ap_image image;
    struct ap_error err;
    if (ap_png_read(&err, path_of("clear", name), &image))
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
    struct program p;
    make_program(&p, "clear", ", \"layers\": true, \"frames\": \"0:1\"", "");
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
    make_layer(&p, &s[0], time, part, 0, &l);
    XrCompositionLayerQuad quad = {.type = XR_TYPE_COMPOSITION_LAYER_QUAD,
                                   .space = p.c.local,
                                   .eyeVisibility = XR_EYE_VISIBILITY_RIGHT,
                                   .subImage = {.swapchain = s[1].swapchain, .imageRect = part},
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
    end_program(&p);
    const int resolved[3] = {188, 255, 89}, encoded[3] = {137, 0, 255};
    check_colour("000000-layer0-left.png", 33, 19, resolved);
    check_colour("000000-layer0-right.png", 33, 19, resolved);
    check_colour("000000-layer1.png", 33, 19, encoded);
    assert_false(exists("clear", "000000-layer1-left.png"));
    size_t len;
    char *text = read_whole("clear", "frames.jsonl", &len);
    json_t *root = json_loads(text, 0, NULL);
    check_text(root, "layers/1/type", "quad");
    check_text(root, "layers/1/eyes", "right");
    check_text(root, "layers/1/space", "local");
    check_number(root, "layers/0/views/0/samples", 4);
    assert_int_equal(json_array_size(at(root, "layers/1/views")), 1);
    check_text(root, "files/4", "000000-layer1.png");
    json_decref(root);
    free(text);
}

static XrResult try_frame(struct program *p, const struct screen *s) {
    XrFrameState f = {.type = XR_TYPE_FRAME_STATE};
    XrResult result = xrWaitFrame(p->c.session, NULL, &f);
    if (result == XR_SUCCESS)
        result = xrBeginFrame(p->c.session, NULL);
    if (result != XR_SUCCESS)
        return result;
    struct layer l;
    make_layer(p, s, f.predictedDisplayTime, whole, 0, &l);
    const XrCompositionLayerBaseHeader *list = (const XrCompositionLayerBaseHeader *)&l.projection;
    XrFrameEndInfo end = {.type = XR_TYPE_FRAME_END_INFO,
                          .displayTime = f.predictedDisplayTime,
                          .environmentBlendMode = XR_ENVIRONMENT_BLEND_MODE_OPAQUE,
                          .layerCount = 1,
                          .layers = &list};
    return xrEndFrame(p->c.session, &end);
}

// A file-size limit stands for the full disk: for the log, then for the pictures.
static void a_full_disk_loses_the_session(void **state) {
    (void)state;
    static const char *const more[] = {
        ", \"log\": \"all\", \"composed\": false, \"frames\": \"0:1\"",
        ", \"layers\": true, \"composed\": false, \"format\": \"raw\""};
    signal(SIGXFSZ, SIG_IGN);
    for (int k = 0; k < 2; k++) {
        struct program p;
        char dir[16];
        snprintf(dir, sizeof dir, "full%d", k);
        make_program(&p, dir, more[k], "");
        struct screen s = make_screen(&p, VK_FORMAT_R8G8B8A8_SRGB);
        draw(&p, &s, 0);
        XrResult result = try_frame(&p, &s);
        struct rlimit old, small;
        getrlimit(RLIMIT_FSIZE, &old);
        small = old;
        small.rlim_cur = k ? 12000 : 9000; // a raw picture has 12288 bytes and a header
        setrlimit(RLIMIT_FSIZE, &small);
        for (int i = 0; i < 300 && result == XR_SUCCESS; i++)
            result = try_frame(&p, &s);
        setrlimit(RLIMIT_FSIZE, &old);
        XR_IS(XR_ERROR_SESSION_LOST, result);
        end_program(&p);
        assert_false(exists(dir, "frames.jsonl"));
        assert_false(exists(dir, "frames.jsonl.part"));
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_killed_program_leaves_its_lines),
        cmocka_unit_test_teardown(layers_are_bit_for_bit, client_teardown),
        cmocka_unit_test_teardown(layers_as_png, client_teardown),
        cmocka_unit_test_teardown(the_log_tells_what_was_submitted, client_teardown),
        cmocka_unit_test_teardown(the_real_clock_is_told, client_teardown),
        cmocka_unit_test_teardown(two_runs_leave_the_same_bytes, client_teardown),
        cmocka_unit_test_teardown(through_the_lens, client_teardown),
        cmocka_unit_test_teardown(samples_and_quads, client_teardown),
        cmocka_unit_test_teardown(a_full_disk_loses_the_session, client_teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
