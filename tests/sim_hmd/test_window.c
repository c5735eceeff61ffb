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
        .program = program, .title = "test", .width_px = W, .height_px = H};
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
        cmocka_unit_test(picture_and_keys),
        cmocka_unit_test(goes_with_the_runtime),
        cmocka_unit_test(no_display),
    };
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    stop_server();
    unlink(shot);
    free((char *)program);
    return failed;
}
