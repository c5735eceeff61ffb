#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "src/base/file.h"
#include "src/gpu/gpu.h"
#include "src/image/image.h"
#include "xr/client.h"

static char dir[64];

static char *in_dir(const char *name) {
    return ap_path_join(dir, name);
}

static void write_text(const char *name, const char *text) {
    char *path = in_dir(name);
    assert_int_equal(ap_file_write(NULL, path, text, strlen(text)), AP_OK);
    free(path);
}

static int make_dir(void **state) {
    (void)state;
    snprintf(dir, sizeof dir, "/tmp/antipode-xr-XXXXXX");
    if (!mkdtemp(dir))
        return -1;
    // A head that walks 1 m in 1 s, a left hand that is gone after 0.2 s, a right one with buttons.
    char *path = in_dir("log.csv");
    FILE *f = fopen(path, "w");
    free(path);
    fputs("t_ns,device,px,py,pz,qx,qy,qz,qw,trigger,squeeze,select\n", f);
    for (int i = 0; i <= 90; i++) {
        long long t = i * 11000000LL;
        fprintf(f, "%lld,head,%.17g,1.6,0.5,0,0,0,1,0,0,0\n", t, i / 90.0);
        if (t < 200000000)
            fprintf(f, "%lld,left,-0.2,1,0,0,0,0,1,0,0,0\n", t);
        fprintf(f, "%lld,right,0.2,1,0,0,0.6,0,0.8,%g,0.25,%d\n", t, i / 90.0, i >= 45);
    }
    fclose(f);
    write_text("sim.json", "{\"headset\": \"ci.json\", \"poses\": {\"logs\": [\"log.csv\"]}, "
                           "\"clock\": \"virtual\", \"capture\": {\"dir\": \"out\", "
                           "\"frames\": \"::10\"}}");
    write_text("ci.json",
               "{\"name\": \"t\", \"refresh_hz\": 90, \"ipd_m\": 0.06, \"eyes\": {"
               "\"left\": {\"resolution_px\": [80, 96], \"fov_rad\": {\"left\": -0.8, \"right\": "
               "0.7, \"up\": 0.7, \"down\": -0.8}, \"yaw_rad\": 0.1},"
               "\"right\": {\"resolution_px\": [64, 96], \"fov_rad\": {\"left\": -0.7, \"right\": "
               "0.8, \"up\": 0.7, \"down\": -0.8}, \"yaw_rad\": -0.1}}}");
    return 0;
}

static int remove_dir(void **state) {
    (void)state;
    char command[128];
    snprintf(command, sizeof command, "rm -rf %s", dir);
    return system(command);
}

static struct ap_xr *open_client(const char *settings, bool older_vulkan) {
    char *path = in_dir(settings);
    setenv("ANTIPODE_SIM", path, 1);
    free(path);
    struct ap_error err = {""};
    struct ap_xr *xr = NULL;
    const struct ap_xr_params params = {.application = "test", .older_vulkan = older_vulkan};
    if (ap_xr_create(&err, &params, &xr)) {
        if (strstr(err.text, "Vulkan driver")) {
            print_message("skipped: %s\n", err.text);
            exit(77);
        }
        fail_msg("%s", err.text);
    }
    return xr;
}

static bool close_to(double a, double b, double tolerance, const char *what, int frame) {
    if (fabs(a - b) <= tolerance)
        return true;
    print_error("frame %d: %s is %.9g, not %.9g (tolerance %g)\n", frame, what, a, b, tolerance);
    return false;
}

static bool check_frame(const struct ap_xr_frame *f, int k) {
    double t = k / 90.0;
    bool good = close_to((double)f->time_ns, 1e9 + round(k * 1e9 / 90), 0, "time", k);
    good &= close_to(f->head.pose.p.x, t * 1e9 / 990000000, 1e-6, "head x", k);
    good &= f->head.valid && f->head.tracked && f->hand[1].grip.tracked;
    good &= close_to(f->hand[1].grip.pose.q.y, 0.6, 1e-6, "right hand's turn", k);
    good &= close_to(f->hand[1].squeeze, 0.25, 1e-6, "squeeze", k);
    good &= f->hand[1].select == (t * 1e9 >= 45 * 11000000.0);
    // The log's last left sample is at 198 ms; from then on it is held and not tracked.
    good &= f->hand[0].grip.valid && f->hand[0].grip.tracked == (t <= 0.198);
    good &= close_to(f->view[0].view_from_eye.p.x, -0.03, 1e-9, "left eye", k);
    good &= close_to(f->view[0].view_from_eye.q.y, sin(0.05), 1e-7, "left eye's cant", k);
    good &= close_to(f->view[1].right_rad, 0.8, 1e-7, "fov", k);
    good &= f->view[0].width_px == 80 && f->view[1].width_px == 64;
    return good & (f->should_render == (k % 10 == 0));
}

// Runs to the end of the log; returns the frames seen.
static int run_session(struct ap_xr *xr, int stop_at) {
    struct ap_error err = {""};
    int k = 0;
    for (;;) {
        enum ap_xr_state state;
        if (ap_xr_poll(&err, xr, &state))
            fail_msg("%s", err.text);
        if (state == AP_XR_ENDED)
            return k;
        assert_int_not_equal(state, AP_XR_LOST);
        if (state == AP_XR_WAITING)
            continue;
        struct ap_xr_frame frame;
        struct ap_xr_images images;
        if (ap_xr_begin_frame(&err, xr, &frame) ||
            (frame.should_render && ap_xr_acquire(&err, xr, &images)))
            fail_msg("frame %d: %s", k, err.text);
        // While the session ends its hands are out of focus; the frames before it are the log's.
        if (stop_at < 0 && !check_frame(&frame, k))
            fail();
        if (ap_xr_haptic(&err, xr, 1, 0.1, 0.5) || ap_xr_end_frame(&err, xr, &frame))
            fail_msg("frame %d: %s", k, err.text);
        k++;
        if (k == stop_at)
            assert_int_equal(ap_xr_request_exit(&err, xr), AP_OK);
    }
}

static int count_of(const char *text, const char *word) {
    int n = 0;
    for (const char *at = strstr(text, word); at; at = strstr(at + 1, word))
        n++;
    return n;
}

// Each frame asks for a pulse in the right hand; frames 0, 10 … 80 are captured and have a line.
static void check_haptics(void) {
    char *path = in_dir("out/frames.jsonl"), *text;
    size_t len;
    assert_int_equal(ap_file_read(NULL, path, 1 << 20, &text, &len), AP_OK);
    free(path);
    assert_int_equal(count_of(text, "\"at\":\"/user/hand/right\""), 81);
    assert_int_equal(count_of(text, "\"duration_ns\":100000000,\"frequency_amplitude\":[0,0.5]"),
                     81);
    free(text);
}

static void a_log_arrives_frame_by_frame(void **state) {
    (void)state;
    struct ap_xr *xr = open_client("sim.json", false);
    struct ap_xr_vulkan vk = ap_xr_vulkan(xr);
    assert_int_equal(vk.width_px, 80);
    assert_int_equal(vk.height_px, 96);
    assert_true(ap_xr_has_stage(xr));
    assert_non_null(strstr(ap_xr_runtime_name(xr), "antipode"));
    assert_int_equal(run_session(xr, -1), 90);
    ap_xr_destroy(xr);
    check_haptics();
}

static void the_older_way_of_sharing_vulkan_works_too(void **state) {
    (void)state;
    struct ap_xr *xr = open_client("sim.json", true);
    assert_int_equal(run_session(xr, -1), 90);
    ap_xr_destroy(xr);
}

static void a_client_may_ask_to_end(void **state) {
    (void)state;
    struct ap_xr *xr = open_client("sim.json", false);
    int frames = run_session(xr, 7);
    assert_in_range(frames, 7, 12);
    ap_xr_destroy(xr);
}

static void a_lost_session_ends_cleanly(void **state) {
    (void)state;
    // The capture's folder is taken away and a file put in its place: the writer fails.
    write_text("lost.json", "{\"headset\": \"ci.json\", \"poses\": {\"logs\": [\"log.csv\"]}, "
                            "\"clock\": \"virtual\", \"capture\": {\"dir\": \"gone\"}}");
    struct ap_xr *xr = open_client("lost.json", false);
    char command[128];
    snprintf(command, sizeof command, "rm -rf %s/gone", dir);
    assert_int_equal(system(command), 0);
    write_text("gone", "");
    struct ap_error err = {""};
    enum ap_xr_state run = AP_XR_WAITING;
    bool failed = false;
    for (int i = 0; i < 1000 && run != AP_XR_LOST; i++) {
        assert_int_equal(ap_xr_poll(&err, xr, &run), AP_OK);
        if (run != AP_XR_RUNNING)
            continue;
        struct ap_xr_frame frame;
        struct ap_xr_images images;
        enum ap_status st = ap_xr_begin_frame(&err, xr, &frame);
        if (!st && frame.should_render)
            st = ap_xr_acquire(&err, xr, &images);
        if (!st)
            st = ap_xr_end_frame(&err, xr, &frame);
        failed |= st != AP_OK;
    }
    assert_int_equal(run, AP_XR_LOST);
    if (failed)
        assert_non_null(strstr(err.text, "LOST"));
    ap_xr_destroy(xr);
}

// Sticks and buttons, by whichever hand has them.
static void sticks_and_buttons_arrive(void **state) {
    (void)state;
    write_text("keys.csv",
               "0,left,/input/thumbstick,0.5,-0.25\n0,right,/input/b/click,1\n"
               "0,left,/input/x/click,1\n0,left,/input/menu/click,1\n"
               "500000000,left,/input/thumbstick,-1,1\n500000000,left,/input/x/click,0\n");
    write_text("keys.json", "{\"headset\": \"ci.json\", \"poses\": {\"logs\": [\"log.csv\"]}, "
                            "\"clock\": \"virtual\", \"inputs\": [\"keys.csv\"]}");
    struct ap_xr *xr = open_client("keys.json", false);
    struct ap_error err = {""};
    double width_m, depth_m;
    assert_false(ap_xr_stage_bounds(xr, &width_m, &depth_m)); // a log does not say
    enum ap_xr_state run = AP_XR_WAITING;
    for (int k = 0; run != AP_XR_ENDED;) {
        assert_int_equal(ap_xr_poll(&err, xr, &run), AP_OK);
        if (run != AP_XR_RUNNING)
            continue;
        struct ap_xr_frame f;
        if (ap_xr_begin_frame(&err, xr, &f) || ap_xr_end_frame(&err, xr, &f))
            fail_msg("frame %d: %s", k, err.text);
        bool later = k >= 45, before_the_end = k < 89;
        if (before_the_end &&
            (f.hand[0].stick_x != (later ? -1 : 0.5f) ||
             f.hand[0].stick_y != (later ? 1 : -0.25f) || f.hand[0].primary != !later ||
             f.hand[0].secondary || !f.hand[0].menu || f.hand[1].stick_x != 0 ||
             f.hand[1].primary || !f.hand[1].secondary || f.hand[1].menu))
            fail_msg("frame %d: stick %g %g, buttons %d %d %d, right %d %d %d", k,
                     (double)f.hand[0].stick_x, (double)f.hand[0].stick_y, f.hand[0].primary,
                     f.hand[0].secondary, f.hand[0].menu, f.hand[1].primary, f.hand[1].secondary,
                     f.hand[1].menu);
        k++;
    }
    ap_xr_destroy(xr);
}

static void paint(const struct ap_gpu *gpu, VkImage image, const float srgb_linear[4]) {
    struct ap_error err = {""};
    VkCommandBuffer cmd;
    if (ap_gpu_commands_begin(&err, gpu, &cmd))
        fail_msg("%s", err.text);
    ap_gpu_barrier(cmd, image, VK_IMAGE_ASPECT_COLOR_BIT, VK_IMAGE_LAYOUT_UNDEFINED,
                   VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
    VkClearColorValue color;
    memcpy(color.float32, srgb_linear, sizeof color.float32);
    VkImageSubresourceRange all = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
    vkCmdClearColorImage(cmd, image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, &color, 1, &all);
    ap_gpu_barrier(cmd, image, VK_IMAGE_ASPECT_COLOR_BIT, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                   VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL);
    if (ap_gpu_commands_end(&err, gpu, cmd))
        fail_msg("%s", err.text);
}

static void check_pixel(const struct ap_image *image, uint32_t x, uint32_t y, int r, int g, int b) {
    const uint8_t *p = image->rgb + 3 * ((size_t)y * image->width + x);
    if (abs(p[0] - r) > 1 || abs(p[1] - g) > 1 || abs(p[2] - b) > 1)
        fail_msg("pixel %u,%u is %d %d %d, expected %d %d %d", x, y, p[0], p[1], p[2], r, g, b);
}

// A green panel a metre ahead in VIEW, with no world behind it; hidden, it is gone; blended by
// half, it is half.
static void panels_are_shown(void **state) {
    (void)state;
    write_text("panel.json", "{\"headset\": \"ci.json\", \"poses\": {\"logs\": [\"log.csv\"]}, "
                             "\"clock\": \"virtual\", \"frames\": 3, \"capture\": {\"dir\": "
                             "\"panel\"}}");
    struct ap_xr *xr = open_client("panel.json", false);
    struct ap_error err = {""};
    struct ap_xr_vulkan vk = ap_xr_vulkan(xr);
    struct ap_gpu gpu;
    if (ap_gpu_init(&err, vk.instance, vk.physical_device, vk.device, vk.queue_family, 0, &gpu))
        fail_msg("%s", err.text);
    struct ap_xr_panel *panel, *other[AP_XR_MAX_PANELS];
    const struct ap_xr_panel_params size = {64, 32};
    if (ap_xr_panel_create(&err, xr, &size, &panel))
        fail_msg("%s", err.text);
    for (int i = 1; i < AP_XR_MAX_PANELS; i++)
        assert_int_equal(ap_xr_panel_create(&err, xr, &size, &other[i]), AP_OK);
    assert_int_equal(ap_xr_panel_create(&err, xr, &size, &other[0]), AP_USAGE);
    ap_xr_panel_destroy(other[1]);
    struct ap_xr_panel_place place = {
        .shown = true, .in_view = true, .pose = {{0, 0, -1}, {0, 0, 0, 1}}, .width_m = 0.4};
    enum ap_xr_state run = AP_XR_WAITING;
    for (int k = 0; run != AP_XR_ENDED;) {
        assert_int_equal(ap_xr_poll(&err, xr, &run), AP_OK);
        if (run != AP_XR_RUNNING)
            continue;
        struct ap_xr_frame f;
        if (ap_xr_begin_frame(&err, xr, &f))
            fail_msg("frame %d: %s", k, err.text);
        if (f.should_render) {
            VkImage image;
            assert_int_equal(ap_xr_panel_acquire(&err, panel, &image), AP_OK);
            paint(&gpu, image, (float[4]){0, 1, 0, k == 2 ? 0.5f : 1});
            assert_int_equal(ap_xr_panel_release(&err, panel), AP_OK);
        }
        place.shown = k != 1;
        place.blended = k == 2;
        ap_xr_panel_set(panel, &place);
        if (ap_xr_end_frame(&err, xr, &f))
            fail_msg("frame %d: %s", k, err.text);
        k++;
    }
    ap_gpu_finish(&gpu);
    ap_xr_destroy(xr); // and the panels with it
    for (int k = 0; k < 3; k++) {
        char name[32];
        snprintf(name, sizeof name, "panel/%06d-left.png", k);
        char *path = in_dir(name);
        struct ap_image image;
        if (ap_png_read(&err, path, &image))
            fail_msg("%s", err.text);
        free(path);
        // The middle of the panel: 0.03 m to the right of this eye, canted by 0.1 to the left.
        double a = tan(atan(0.03) + 0.1), l = tan(-0.8), r = tan(0.7), u = tan(0.7), d = tan(-0.8);
        uint32_t x = (uint32_t)(80 * (a - l) / (r - l)), y = (uint32_t)(96 * u / (u - d));
        // Shown, hidden, and by half, which is 188 where it is blended in linear light.
        check_pixel(&image, x, y, 0, k == 0 ? 255 : k == 1 ? 0 : 188, 0);
        ap_image_finish(&image);
    }
}

static void a_broken_runtime_is_one_clear_error(void **state) {
    (void)state;
    write_text("bad.json", "{\"clock\": \"sundial\"}");
    char *path = in_dir("bad.json");
    setenv("ANTIPODE_SIM", path, 1);
    free(path);
    struct ap_error err = {""};
    struct ap_xr *xr = NULL;
    const struct ap_xr_params params = {.application = "test"};
    assert_int_equal(ap_xr_create(&err, &params, &xr), AP_ENVIRONMENT);
    assert_null(xr);
    assert_non_null(strstr(err.text, "xrCreateInstance"));
    ap_xr_destroy(NULL);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_log_arrives_frame_by_frame),
        cmocka_unit_test(the_older_way_of_sharing_vulkan_works_too),
        cmocka_unit_test(a_client_may_ask_to_end),
        cmocka_unit_test(a_lost_session_ends_cleanly),
        cmocka_unit_test(sticks_and_buttons_arrive),
        cmocka_unit_test(panels_are_shown),
        cmocka_unit_test(a_broken_runtime_is_one_clear_error),
    };
    return cmocka_run_group_tests(tests, make_dir, remove_dir);
}
