#include "tests/sim_hmd/layered.h"

#include <jansson.h>
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "src/image/image.h"
#include "src/image/lens.h"

// What a capture holds beside the composed pictures, through the loader: the program's own pictures
// bit for bit, the lens, that two runs leave the same bytes, and what is left where one ends badly.

// Every byte of a PAM, by hand: its header is pinned too.
static void check_pam(const char *dir, const char *name, XrRect2Di r, int layer, int frame,
                      bool linear, int tolerance) {
    char header[128];
    int n = snprintf(header, sizeof header,
                     "P7\n%sWIDTH %d\nHEIGHT %d\nDEPTH 4\nMAXVAL 255\nTUPLTYPE RGB_ALPHA\nENDHDR\n",
                     linear ? "# linear light\n" : "", r.extent.width, r.extent.height);
    size_t len;
    char *bytes = layered_read(dir, name, &len);
    assert_int_equal(len, (size_t)n + (size_t)r.extent.width * (size_t)r.extent.height * 4);
    assert_memory_equal(bytes, header, (size_t)n);
    const uint8_t *at = (const uint8_t *)bytes + n;
    for (int y = 0; y < r.extent.height; y++)
        for (int x = 0; x < r.extent.width; x++)
            for (int c = 0; c < 4; c++, at++) {
                int want = layered_texel(r.offset.x + x + frame, r.offset.y + y, layer, c);
                if (abs(*at - want) > tolerance)
                    fail_msg("%s: (%d, %d) channel %d is %d, expected %d within %d", name, x, y, c,
                             *at, want, tolerance);
            }
    free(bytes);
}

// A killed program leaves layered_whole lines under the other name. First: it forks.
static void a_killed_program_leaves_its_lines(void **state) {
    (void)state;
    client_folder();
    pid_t child = fork();
    if (child == 0) {
        struct painter p;
        layered_start(&p, "killed", ", \"log\": \"all\", \"frames\": \"1:2\"", "");
        layered_run(&p, VK_FORMAT_R8G8B8A8_SRGB, VK_FORMAT_R8G8B8A8_SRGB, FRAMES);
        kill(getpid(), SIGKILL);
    }
    int status;
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_true(WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL);
    assert_false(layered_exists("killed", "frames.jsonl"));
    size_t len;
    char *text = layered_read("killed", "frames.jsonl.part", &len);
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
        struct painter p;
        char dir[16];
        snprintf(dir, sizeof dir, "layers%zu", k);
        layered_start(
            &p, dir,
            ", \"layers\": true, \"composed\": false, \"format\": \"raw\", \"frames\": \"1:4:2\"",
            "");
        layered_run(&p, cases[k].format[0], cases[k].format[1], FRAMES);
        painter_stop(&p);
        for (int frame = 1; frame < 4; frame += 2)
            for (int eye = 0; eye < 2; eye++)
                for (int layer = 0; layer < 2; layer++) {
                    bool bgra = cases[k].format[layer] == VK_FORMAT_B8G8R8A8_SRGB ||
                                cases[k].format[layer] == VK_FORMAT_B8G8R8A8_UNORM;
                    char name[64];
                    snprintf(name, sizeof name, "%06d-layer%d-%s.pam", frame, layer,
                             eye ? "right" : "left");
                    if (!bgra) // the file is R,G,B,A whatever the image is
                        check_pam(dir, name, layer ? layered_part : layered_whole, 1 - eye, frame,
                                  cases[k].linear[layer], cases[k].tolerance);
                    else
                        assert_true(layered_exists(dir, name));
                }
        assert_false(layered_exists(dir, "000001-left.pam"));
        assert_false(layered_exists(dir, "000000-layer0-left.pam"));
        assert_true(layered_exists(dir, "frames.jsonl"));
    }
}

// PNG: colours as they are; a blended layer keeps its alpha.
static void layers_as_png(void **state) {
    (void)state;
    struct painter p;
    layered_start(&p, "png", ", \"layers\": true, \"frames\": \"2:3\"", "");
    layered_run(&p, VK_FORMAT_R8G8B8A8_SRGB, VK_FORMAT_B8G8R8A8_SRGB, FRAMES);
    painter_stop(&p);
    for (int layer = 0; layer < 2; layer++)
        for (int eye = 0; eye < 2; eye++) {
            char name[64];
            snprintf(name, sizeof name, "000002-layer%d-%s.png", layer, eye ? "right" : "left");
            struct ap_image image;
            struct ap_error err;
            if (ap_png_read(&err, painter_path("png", name), &image))
                fail_msg("%s", err.text);
            XrRect2Di r = layer ? layered_part : layered_whole;
            assert_int_equal(image.width, r.extent.width);
            assert_int_equal(image.height, r.extent.height);
            for (int k = 0; k < r.extent.width * r.extent.height * 3; k++) {
                int x = k / 3 % r.extent.width, y = k / 3 / r.extent.width, c = k % 3;
                // What the program wrote into a BGRA image first is blue.
                int want =
                    layered_texel(r.offset.x + x + 2, r.offset.y + y, 1 - eye, layer ? 2 - c : c);
                if (image.rgb[k] != want)
                    fail_msg("%s: (%d, %d) channel %d is %d, expected %d", name, x, y, c,
                             image.rgb[k], want);
            }
            ap_image_finish(&image);
            size_t len;
            char *bytes = layered_read("png", name, &len);
            assert_int_equal(bytes[25], layer ? 6 : 2); // IHDR's colour type: RGBA, RGB
            free(bytes);
        }
    assert_true(layered_exists("png", "000002-left.png"));
}

static void two_runs_leave_the_same_bytes(void **state) {
    (void)state;
    char command[256];
    for (int k = 0; k < 2; k++) {
        struct painter p;
        layered_start(&p, k ? "again" : "once", ", \"layers\": true, \"log\": \"all\"", "");
        layered_run(&p, VK_FORMAT_R8G8B8A8_SRGB, VK_FORMAT_R16G16B16A16_SFLOAT, FRAMES);
        painter_stop(&p);
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
        struct painter p;
        layered_start(&p, k ? "lens" : "plain",
                      k ? ", \"lens\": true, \"frames\": \"1:2\"" : ", \"frames\": \"1:2\"", lens);
        layered_run(&p, VK_FORMAT_R8G8B8A8_SRGB, VK_FORMAT_R8G8B8A8_SRGB, 3);
        painter_stop(&p);
    }
    for (int eye = 0; eye < 2; eye++) {
        const char *name = eye ? "000001-right.png" : "000001-left.png";
        struct ap_image plain, seen;
        assert_int_equal(ap_png_read(NULL, painter_path("plain", name), &plain), AP_OK);
        assert_int_equal(ap_png_read(NULL, painter_path("lens", name), &seen), AP_OK);
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

static XrResult try_frame(struct painter *p, const struct screen *s) {
    XrFrameState f = {.type = XR_TYPE_FRAME_STATE};
    XrResult result = xrWaitFrame(p->c.session, NULL, &f);
    if (result == XR_SUCCESS)
        result = xrBeginFrame(p->c.session, NULL);
    if (result != XR_SUCCESS)
        return result;
    struct layer l;
    layered_layer(p, s, f.predictedDisplayTime, layered_whole, 0, &l);
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
        struct painter p;
        char dir[16];
        snprintf(dir, sizeof dir, "full%d", k);
        layered_start(&p, dir, more[k], "");
        struct screen s = layered_screen(&p, VK_FORMAT_R8G8B8A8_SRGB);
        layered_draw(&p, &s, 0);
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
        painter_stop(&p);
        assert_false(layered_exists(dir, "frames.jsonl"));
        assert_false(layered_exists(dir, "frames.jsonl.part"));
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_killed_program_leaves_its_lines),
        cmocka_unit_test_teardown(layers_are_bit_for_bit, client_teardown),
        cmocka_unit_test_teardown(layers_as_png, client_teardown),
        cmocka_unit_test_teardown(two_runs_leave_the_same_bytes, client_teardown),
        cmocka_unit_test_teardown(through_the_lens, client_teardown),
        cmocka_unit_test_teardown(a_full_disk_loses_the_session, client_teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
