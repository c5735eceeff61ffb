// The window's program under a virtual X server: a picture arrives, keys and mouse come back, and
// neither side outlives the other by much. Without Xvfb, xdotool or import it is skipped.

#include <fcntl.h>
#include <poll.h>
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmocka.h>

#include "sim_hmd/input/source.h"
#include "sim_hmd/window/arrange.h"
#include "sim_hmd/window/window.h"
#include "src/base/clock.h"
#include "src/base/file.h"
#include "src/image/image.h"

enum { W = 400, H = 200 };
static const int64_t PATIENCE_NS = 20000000000; // a loaded machine under a sanitizer

static const char *program; // NULL: beside this one
static char shot[] = "/tmp/antipode-window-XXXXXX";
static pid_t server;

static bool start_server(void) {
    int ends[2];
    if (pipe(ends) != 0)
        return false;
    server = fork();
    if (server == 0) {
        char number[16];
        snprintf(number, sizeof number, "%d", ends[1]);
        int null = open("/dev/null", O_WRONLY);
        dup2(null, 2);
        execlp("Xvfb", "Xvfb", "-displayfd", number, "-screen", "0", "1024x768x24", "-noreset",
               "-nolisten", "tcp", (char *)NULL);
        _exit(127);
    }
    close(ends[1]);
    char display[32] = ":";
    size_t n = 1;
    while (n < sizeof display - 1 && read(ends[0], display + n, 1) == 1 && display[n] != '\n')
        n++;
    display[n] = '\0';
    close(ends[0]);
    return n > 1 && setenv("DISPLAY", display, 1) == 0;
}

static void stop_server(void) {
    kill(server, SIGTERM);
    waitpid(server, NULL, 0);
}

static void nap(void) {
    ap_clock_sleep_until_ns(ap_clock_now_ns() + 20000000);
}

static struct sim_window *open_window(void) {
    struct sim_window *window;
    struct ap_error err = {{0}};
    struct sim_window_params params = {
        .program = program, .title = "test", .width_px = W, .height_px = H, .split_px = W / 2};
    if (sim_window_open(&err, &params, &window))
        fail_msg("%s", err.text);
    return window;
}

// Left half one colour, right half another.
static void show(struct sim_window *window, int64_t frame, const uint8_t left[3],
                 const uint8_t right[3]) {
    static uint8_t rgba[W * H * 4];
    for (int k = 0; k < W * H; k++)
        memcpy(rgba + 4 * k, k % W < W / 2 ? left : right, 3);
    sim_window_show(window, frame, rgba);
}

static int count_color(const struct ap_image *image, const uint8_t color[3]) {
    int n = 0;
    for (size_t k = 0; k < (size_t)image->width * image->height; k++)
        n += memcmp(image->rgb + 3 * k, color, 3) == 0;
    return n;
}

static int seen(const uint8_t color[3]) {
    char command[300];
    struct ap_image image;
    snprintf(command, sizeof command, "import -window root png:%s 2>/dev/null", shot);
    if (system(command) != 0 || ap_png_read(NULL, shot, &image))
        return -1;
    int n = count_color(&image, color);
    ap_image_finish(&image);
    return n;
}

static void wait_for_color(const uint8_t color[3], int pixels) {
    int n = 0;
    for (int64_t end = ap_clock_now_ns() + PATIENCE_NS; ap_clock_now_ns() < end; nap()) {
        n = seen(color);
        if (n == pixels)
            return;
    }
    fail_msg("%d pixels of #%02x%02x%02x, expected %d", n, color[0], color[1], color[2], pixels);
}

static void run(const char *command) {
    if (system(command) != 0)
        fail_msg("%s failed", command);
}

static struct sim_window_input wait_for(struct sim_window *window,
                                        bool (*here)(const struct sim_window_input *),
                                        const char *what) {
    struct sim_window_input input;
    for (int64_t end = ap_clock_now_ns() + PATIENCE_NS; ap_clock_now_ns() < end; nap()) {
        sim_window_alive(window);
        sim_window_input(window, &input);
        if (here(&input))
            return input;
    }
    fail_msg("%s: keys %#x, mouse (%g, %g), closed %d", what, input.keys, input.mouse_x_px,
             input.mouse_y_px, input.closed);
    return input;
}

static bool forward_only(const struct sim_window_input *i) {
    return i->keys == SIM_KEY_FORWARD;
}
static bool hand_up(const struct sim_window_input *i) {
    return i->keys == (SIM_KEY_HAND_LEFT | SIM_KEY_UP | SIM_KEY_TRIGGER);
}
static bool nothing(const struct sim_window_input *i) {
    return i->keys == 0;
}
static bool turned(const struct sim_window_input *i) {
    return i->mouse_x_px > 50;
}
static bool moved(const struct sim_window_input *i) {
    return i->mouse_y_px > 20;
}
static bool squeezed(const struct sim_window_input *i) {
    return i->keys == SIM_KEY_SQUEEZE;
}
static bool menu_and_stick(const struct sim_window_input *i) {
    return i->keys == (SIM_KEY_MENU | SIM_KEY_STICK_UP | SIM_KEY_TURN_LEFT);
}
static bool closed(const struct sim_window_input *i) {
    return i->closed;
}

static void picture_and_keys(void **state) {
    (void)state;
    const uint8_t red[3] = {201, 31, 17}, blue[3] = {13, 57, 211}, green[3] = {19, 181, 77};
    struct sim_window *window = open_window();
    show(window, 1, red, blue);
    wait_for_color(red, W * H / 2);
    assert_int_equal(seen(blue), W * H / 2);
    show(window, 3, green, blue);
    show(window, 2, red, red); // late: dropped
    wait_for_color(green, W * H / 2);
    assert_true(sim_window_alive(window));
    // Without a window manager the keys go where the pointer is.
    run("xdotool mousemove 200 100");
    run("xdotool keydown w");
    wait_for(window, forward_only, "W");
    run("xdotool keyup w keydown 1 keydown e keydown space");
    wait_for(window, hand_up, "1, E and space");
    run("xdotool keyup 1 keyup e keyup space");
    wait_for(window, nothing, "keys let go");
    run("xdotool keydown F1 keydown i keydown u");
    wait_for(window, menu_and_stick, "F1, I and U");
    run("xdotool keyup F1 keyup i keyup u");
    wait_for(window, nothing, "keys let go");
    // F2: crossed eyes, the anaglyph (of green and blue: the left's luminance in red), left alone
    // (as large as fits: the window's whole height), and side by side again.
    const uint8_t mixed[3] = {157, 57, 211};
    run("xdotool key F2");
    wait_for_color(green, W * H / 2);
    run("xdotool key F2");
    wait_for_color(mixed, W * H / 2);
    run("xdotool key F2");
    wait_for_color(blue, 0);
    assert_int_equal(seen(green), W * H / 2);
    run("xdotool key F2");
    wait_for_color(blue, W * H / 2);
    run("xdotool keydown Right");
    wait_for(window, turned, "the right arrow");
    run("xdotool keyup Right");
    // A click takes the mouse; that one is not the program's.
    run("xdotool click 1");
    for (int k = 0; k < 8; k++)
        run("xdotool mousemove_relative 0 10");
    wait_for(window, moved, "the mouse");
    run("xdotool mousedown 3");
    wait_for(window, squeezed, "the right button");
    run("xdotool mouseup 3");
    run("xdotool key Escape");
    wait_for(window, closed, "Esc");
    assert_false(sim_window_alive(window));
    show(window, 4, red, red); // nobody sees it, nothing breaks
    sim_window_close(window);
    assert_int_equal(waitpid(-1, NULL, WNOHANG), 0); // the server is our only child
}

// The runtime's process closes its end, or dies: the window goes.
static void goes_with_the_runtime(void **state) {
    (void)state;
    const uint8_t red[3] = {201, 31, 17}, blue[3] = {13, 57, 211};
    struct sim_window *window = open_window();
    show(window, 1, red, blue);
    wait_for_color(red, W * H / 2);
    sim_window_close(window);
    wait_for_color(red, 0);
    pid_t other = fork();
    if (other == 0) {
        window = open_window();
        show(window, 1, blue, red);
        wait_for_color(blue, W * H / 2);
        _exit(0);
    }
    int status;
    waitpid(other, &status, 0);
    assert_true(WIFEXITED(status) && WEXITSTATUS(status) == 0);
    wait_for_color(blue, 0);
    sim_window_close(NULL);
}

// A child that the runtime's process forks does not keep the window.
static void a_fork_does_not_keep_it(void **state) {
    (void)state;
    const uint8_t red[3] = {201, 31, 17};
    struct sim_window *window = open_window();
    show(window, 1, red, red);
    wait_for_color(red, W * H);
    pid_t child = fork();
    if (child == 0) {
        for (;;)
            pause();
    }
    assert_true(sim_window_alive(window)); // the child's copy was closed, ours was not
    sim_window_close(window);
    wait_for_color(red, 0);
    kill(child, SIGKILL);
    assert_int_equal(waitpid(child, NULL, 0), child);
}

static void no_display(void **state) {
    (void)state;
    char kept[64];
    snprintf(kept, sizeof kept, "%s", getenv("DISPLAY"));
    unsetenv("DISPLAY");
    unsetenv("WAYLAND_DISPLAY");
    struct sim_window *window = open_window();
    setenv("DISPLAY", kept, 1);
    int64_t end = ap_clock_now_ns() + PATIENCE_NS;
    while (sim_window_alive(window) && ap_clock_now_ns() < end)
        nap();
    assert_false(sim_window_alive(window));
    struct sim_window_input input;
    sim_window_input(window, &input);
    assert_false(input.closed); // nobody closed it: the program goes on
    sim_window_close(window);
    struct ap_error err = {{0}};
    struct sim_window_params params = {.program = "/nowhere/x", .width_px = 10, .height_px = 10};
    assert_int_equal(sim_window_open(&err, &params, &window), AP_ENVIRONMENT);
    assert_non_null(strstr(err.text, "/nowhere/x"));
    params.width_px = 5000;
    assert_int_equal(sim_window_open(&err, &params, &window), AP_USAGE);
}

// What is arranged, pixel by pixel, with parts of different widths.
static void arrangements(void **state) {
    (void)state;
    enum { PAIR_W = 5, PAIR_H = 2, SPLIT = 3 };
    uint8_t rgba[4 * PAIR_W * PAIR_H], out[sizeof rgba];
    for (size_t k = 0; k < sizeof rgba; k++)
        rgba[k] = k % 4 == 3 ? 255 : (uint8_t)(k * 37 + 11);
    const struct sim_pair pair = {rgba, PAIR_W, PAIR_H, SPLIT};
    uint32_t w, h;
    sim_arrange(&pair, SIM_WINDOW_PAIR, out, &w, &h);
    assert_true(w == PAIR_W && h == PAIR_H && memcmp(out, rgba, sizeof rgba) == 0);
    sim_arrange(&pair, SIM_WINDOW_CROSS, out, &w, &h);
    assert_true(w == PAIR_W && h == PAIR_H);
    for (uint32_t y = 0; y < PAIR_H; y++)
        for (uint32_t x = 0; x < PAIR_W; x++)
            assert_memory_equal(out + 4 * (y * PAIR_W + x),
                                rgba + 4 * (y * PAIR_W + (x + SPLIT) % PAIR_W), 4);
    sim_arrange(&pair, SIM_WINDOW_LEFT, out, &w, &h);
    assert_true(w == SPLIT && h == PAIR_H);
    assert_memory_equal(out + 4 * SPLIT, rgba + 4 * PAIR_W, 4 * SPLIT);
    sim_arrange(&pair, SIM_WINDOW_ANAGLYPH, out, &w, &h);
    assert_true(w == PAIR_W - SPLIT && h == PAIR_H);
    // As the pictures of `replay` have it.
    struct ap_image left = {.width = SPLIT - 1, .height = PAIR_H}, right = left, want;
    uint8_t l[2][3 * 2 * PAIR_H];
    for (uint32_t k = 0; k < 2 * PAIR_H; k++)
        for (int eye = 0; eye < 2; eye++)
            memcpy(l[eye] + 3 * k, rgba + 4 * (k / 2 * PAIR_W + (eye ? SPLIT : 0) + k % 2), 3);
    left.rgb = l[0];
    right.rgb = l[1];
    assert_int_equal(ap_image_anaglyph(NULL, &left, &right, &want), AP_OK);
    for (uint32_t k = 0; k < 2 * PAIR_H; k++)
        for (int c = 0; c < 3; c++)
            if (abs(out[4 * k + c] - want.rgb[3 * k + c]) > 1)
                fail_msg("anaglyph: pixel %u, channel %d is %d, the pictures' is %d", k, c,
                         out[4 * k + c], want.rgb[3 * k + c]);
    ap_image_finish(&want);
    const struct sim_pair alone = {rgba, PAIR_W, PAIR_H, 0};
    sim_arrange(&alone, SIM_WINDOW_ANAGLYPH, out, &w, &h);
    assert_true(w == PAIR_W && memcmp(out, rgba, sizeof rgba) == 0);
}

static void check_component(const struct sim_source *source, const char *profile, const char *path,
                            int top, enum sim_kind kind, float x, float y) {
    int found = sim_profile_find(profile), at;
    const struct sim_component *c = sim_profile_component(found, path, kind, &at);
    float value[2] = {9, 9};
    if (!c || at != top)
        fail_msg("%s: no such input", path);
    if (!sim_source_component(source, c, top, 1000000000, value))
        fail_msg("%s: the keys say nothing", path);
    if (value[0] != x || (kind == SIM_VEC2 && value[1] != y))
        fail_msg("%s is %g %g, expected %g %g", path, (double)value[0], (double)value[1], (double)x,
                 (double)y);
}

// The keys are sticks and buttons of whatever the hands hold.
static void keys_are_controllers(void **state) {
    (void)state;
    static const char touch[] = "/interaction_profiles/oculus/touch_controller";
    static const char vive[] = "/interaction_profiles/htc/vive_controller";
    struct sim_settings settings;
    struct sim_source *source;
    struct ap_error err;
    assert_int_equal(sim_settings_read(&err, NULL, &settings), AP_OK);
    settings.poses = SIM_POSES_WINDOW;
    if (sim_source_create(&err, &settings, &source))
        fail_msg("%s", err.text);
    const struct sim_window_input keys = {.keys = SIM_KEY_STICK_UP | SIM_KEY_STICK_LEFT |
                                                  SIM_KEY_TURN_RIGHT | SIM_KEY_Y | SIM_KEY_A |
                                                  SIM_KEY_MENU | SIM_KEY_STICK_CLICK};
    sim_source_input(source, &keys, 0.01);
    check_component(source, touch, "/user/hand/left/input/thumbstick", SIM_TOP_LEFT, SIM_VEC2, -1,
                    1);
    check_component(source, touch, "/user/hand/left/input/thumbstick/y", SIM_TOP_LEFT, SIM_FLOAT, 1,
                    0);
    check_component(source, touch, "/user/hand/right/input/thumbstick", SIM_TOP_RIGHT, SIM_VEC2, 1,
                    0);
    check_component(source, vive, "/user/hand/right/input/trackpad/x", SIM_TOP_RIGHT, SIM_FLOAT, 1,
                    0);
    check_component(source, touch, "/user/hand/left/input/x/click", SIM_TOP_LEFT, SIM_BOOL, 0, 0);
    check_component(source, touch, "/user/hand/left/input/y/click", SIM_TOP_LEFT, SIM_BOOL, 1, 0);
    check_component(source, touch, "/user/hand/right/input/a/click", SIM_TOP_RIGHT, SIM_BOOL, 1, 0);
    check_component(source, touch, "/user/hand/left/input/menu/click", SIM_TOP_LEFT, SIM_BOOL, 1,
                    0);
    check_component(source, vive, "/user/hand/left/input/menu/click", SIM_TOP_LEFT, SIM_BOOL, 1, 0);
    check_component(source, touch, "/user/hand/left/input/thumbstick/click", SIM_TOP_LEFT, SIM_BOOL,
                    1, 0);
    // The wheel pushes the right stick for a moment, while the right button is down.
    const struct sim_window_input free_wheel = {.wheel = 2},
                                  wheel = {.keys = SIM_KEY_SQUEEZE, .wheel = 1},
                                  after = {.keys = SIM_KEY_SQUEEZE, .wheel = 1};
    sim_source_input(source, &free_wheel, 0.01);
    check_component(source, touch, "/user/hand/right/input/thumbstick", SIM_TOP_RIGHT, SIM_VEC2, 0,
                    0);
    sim_source_input(source, &wheel, 0.01);
    check_component(source, touch, "/user/hand/right/input/thumbstick", SIM_TOP_RIGHT, SIM_VEC2, 0,
                    -1);
    check_component(source, touch, "/user/hand/left/input/thumbstick", SIM_TOP_LEFT, SIM_VEC2, 0,
                    0);
    sim_source_input(source, &after, 0.05);
    check_component(source, touch, "/user/hand/right/input/thumbstick/y", SIM_TOP_RIGHT, SIM_FLOAT,
                    -1, 0);
    sim_source_input(source, &after, 0.06);
    check_component(source, touch, "/user/hand/right/input/thumbstick/y", SIM_TOP_RIGHT, SIM_FLOAT,
                    0, 0);
    sim_source_destroy(source);
    sim_settings_finish(&settings);
}

int main(void) {
    if (system("command -v Xvfb xdotool import >/dev/null 2>&1") != 0) {
        puts("skipped: Xvfb, xdotool or ImageMagick's import is not installed");
        return 77;
    }
    const char *build = getenv("ANTIPODE_BUILD");
    if (build)
        program = ap_path_join(build, "sim_hmd/antipode-sim-window");
    int fd = mkstemp(shot);
    if (fd < 0 || !start_server()) {
        puts("skipped: Xvfb does not start");
        return 77;
    }
    close(fd);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(arrangements),     cmocka_unit_test(keys_are_controllers),
        cmocka_unit_test(picture_and_keys), cmocka_unit_test(goes_with_the_runtime),
        cmocka_unit_test(no_display),       cmocka_unit_test(a_fork_does_not_keep_it),
    };
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    stop_server();
    unlink(shot);
    free((char *)program);
    return failed;
}
