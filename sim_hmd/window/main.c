// antipode-sim-window: shows what the simulated headset's eyes see, hands keyboard and mouse back.
// Started by the runtime (window.c) with the shared memory at descriptor 3 and a socket at 4 whose
// other end closes when the runtime's process is gone. Not for people to start.

#include <math.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include "sim_hmd/window/arrange.h"
#include "sim_hmd/window/screen.h"
#include "sim_hmd/window/shared.h"

// A key that is only tapped stays down until the runtime has looked so often, so that no frame of a
// slow program misses it.
enum { TAP_LOOKS = 2 };

static const double ARROW_PX_PER_S = 500; // the arrow keys stand for the mouse

static const struct {
    int glfw;
    uint32_t key;
} keys[] = {{GLFW_KEY_W, SIM_KEY_FORWARD},
            {GLFW_KEY_S, SIM_KEY_BACK},
            {GLFW_KEY_A, SIM_KEY_LEFT},
            {GLFW_KEY_D, SIM_KEY_RIGHT},
            {GLFW_KEY_E, SIM_KEY_UP},
            {GLFW_KEY_Q, SIM_KEY_DOWN},
            {GLFW_KEY_LEFT_SHIFT, SIM_KEY_SLOW},
            {GLFW_KEY_RIGHT_SHIFT, SIM_KEY_SLOW},
            {GLFW_KEY_SPACE, SIM_KEY_TRIGGER},
            {GLFW_KEY_F, SIM_KEY_SQUEEZE},
            {GLFW_KEY_1, SIM_KEY_HAND_LEFT},
            {GLFW_KEY_LEFT_ALT, SIM_KEY_HAND_LEFT},
            {GLFW_KEY_2, SIM_KEY_HAND_RIGHT},
            {GLFW_KEY_RIGHT_ALT, SIM_KEY_HAND_RIGHT},
            {GLFW_KEY_R, SIM_KEY_RECENTRE},
            {GLFW_KEY_I, SIM_KEY_STICK_UP},
            {GLFW_KEY_K, SIM_KEY_STICK_DOWN},
            {GLFW_KEY_J, SIM_KEY_STICK_LEFT},
            {GLFW_KEY_L, SIM_KEY_STICK_RIGHT},
            {GLFW_KEY_U, SIM_KEY_TURN_LEFT},
            {GLFW_KEY_O, SIM_KEY_TURN_RIGHT},
            {GLFW_KEY_T, SIM_KEY_RIGHT_STICK_UP},
            {GLFW_KEY_G, SIM_KEY_RIGHT_STICK_DOWN},
            {GLFW_KEY_X, SIM_KEY_X},
            {GLFW_KEY_Y, SIM_KEY_Y},
            {GLFW_KEY_C, SIM_KEY_A},
            {GLFW_KEY_V, SIM_KEY_B},
            {GLFW_KEY_M, SIM_KEY_MENU},
            {GLFW_KEY_F1, SIM_KEY_MENU},
            {GLFW_KEY_F11, SIM_KEY_RIGHT_STICK_CLICK},
            {GLFW_KEY_F12, SIM_KEY_STICK_CLICK}};

enum { KEY_COUNT = sizeof keys / sizeof keys[0] };

struct app {
    struct sim_window_shared *shared;
    GLFWwindow *window;
    bool captured; // the mouse turns the head and its pointer is hidden
    bool redraw;
    double pointer_x, pointer_y;
    double mouse_x, mouse_y, wheel; // accumulated
    uint32_t buttons;               // sim_key bits of the mouse
    struct sim_pair pair;           // the last picture
    uint8_t *arranged;
    enum sim_window_layout layout;
    int pictures; // since the title was written
    double titled_s;
    uint32_t tapped[KEY_COUNT]; // down at least until the runtime has looked so often
};

static void capture_mouse(struct app *app, bool captured) {
    app->captured = captured;
    glfwSetInputMode(app->window, GLFW_CURSOR,
                     captured ? GLFW_CURSOR_DISABLED : GLFW_CURSOR_NORMAL);
    glfwGetCursorPos(app->window, &app->pointer_x, &app->pointer_y);
}

static void on_key(GLFWwindow *window, int key, int code, int action, int mods) {
    (void)code;
    (void)mods;
    struct app *app = glfwGetWindowUserPointer(window);
    uint32_t looks = atomic_load_explicit(&app->shared->looks, memory_order_relaxed);
    for (size_t k = 0; k < KEY_COUNT; k++)
        if (action == GLFW_PRESS && keys[k].glfw == key)
            app->tapped[k] = looks + TAP_LOOKS;
    if (action == GLFW_PRESS && key == GLFW_KEY_ESCAPE)
        glfwSetWindowShouldClose(window, GLFW_TRUE);
    if (action == GLFW_PRESS && key == GLFW_KEY_TAB)
        capture_mouse(app, !app->captured);
    if (action == GLFW_PRESS && key == GLFW_KEY_F2 && app->shared->split_px > 0) {
        app->layout = (app->layout + 1) % SIM_WINDOW_LAYOUT_COUNT;
        app->redraw = true;
    }
}

static void on_button(GLFWwindow *window, int button, int action, int mods) {
    (void)mods;
    struct app *app = glfwGetWindowUserPointer(window);
    if (!app->captured && action == GLFW_PRESS) {
        capture_mouse(app, true); // the first click is not the program's
        return;
    }
    uint32_t key = button == GLFW_MOUSE_BUTTON_LEFT    ? SIM_KEY_TRIGGER
                   : button == GLFW_MOUSE_BUTTON_RIGHT ? SIM_KEY_SQUEEZE
                                                       : 0;
    app->buttons = action == GLFW_PRESS ? app->buttons | key : app->buttons & ~key;
}

static void on_pointer(GLFWwindow *window, double x, double y) {
    struct app *app = glfwGetWindowUserPointer(window);
    if (app->captured) {
        app->mouse_x += x - app->pointer_x;
        app->mouse_y += y - app->pointer_y;
    }
    app->pointer_x = x;
    app->pointer_y = y;
}

static void on_wheel(GLFWwindow *window, double x, double y) {
    (void)x;
    struct app *app = glfwGetWindowUserPointer(window);
    app->wheel += y;
}

static void on_focus(GLFWwindow *window, int focused) {
    struct app *app = glfwGetWindowUserPointer(window);
    if (!focused) {
        capture_mouse(app, false);
        app->buttons = 0;
    }
}

static void on_redraw(GLFWwindow *window) {
    struct app *app = glfwGetWindowUserPointer(window);
    app->redraw = true;
}

static double held(const struct app *app, int key) {
    return glfwGetKey(app->window, key) == GLFW_PRESS ? 1 : 0;
}

static void publish(_Atomic int64_t *to, double value) {
    if (value > -1e15 && value < 1e15)
        atomic_store_explicit(to, (int64_t)(value * SIM_WINDOW_FIXED_POINT), memory_order_relaxed);
}

static void hand_over_input(struct app *app, double step_s) {
    uint32_t bits = app->buttons;
    uint32_t looks = atomic_load_explicit(&app->shared->looks, memory_order_relaxed);
    for (size_t k = 0; k < KEY_COUNT; k++)
        if (glfwGetKey(app->window, keys[k].glfw) == GLFW_PRESS ||
            (int32_t)(app->tapped[k] - looks) > 0)
            bits |= keys[k].key;
    double step_px = ARROW_PX_PER_S * step_s;
    app->mouse_x += step_px * (held(app, GLFW_KEY_RIGHT) - held(app, GLFW_KEY_LEFT));
    app->mouse_y += step_px * (held(app, GLFW_KEY_DOWN) - held(app, GLFW_KEY_UP));
    atomic_store_explicit(&app->shared->keys, bits, memory_order_relaxed);
    publish(&app->shared->mouse_x, app->mouse_x);
    publish(&app->shared->mouse_y, app->mouse_y);
    publish(&app->shared->wheel, app->wheel);
}

static struct sim_window_shared *map_memory(void) {
    struct stat info;
    if (fstat(SIM_WINDOW_MEMORY_FD, &info) != 0 ||
        info.st_size < (off_t)sizeof(struct sim_window_shared))
        return NULL;
    void *mapped = mmap(NULL, (size_t)info.st_size, PROT_READ | PROT_WRITE, MAP_SHARED,
                        SIM_WINDOW_MEMORY_FD, 0);
    if (mapped == MAP_FAILED)
        return NULL;
    struct sim_window_shared *shared = mapped;
    if (shared->version != SIM_WINDOW_VERSION || shared->width_px - 1 >= SIM_WINDOW_MAX_SIDE ||
        shared->height_px - 1 >= SIM_WINDOW_MAX_SIDE || shared->split_px >= shared->width_px ||
        shared->layout >= SIM_WINDOW_LAYOUT_COUNT ||
        sim_window_memory_bytes(shared) > (size_t)info.st_size)
        return NULL;
    return shared;
}

static bool runtime_gone(void) {
    struct pollfd life = {.fd = SIM_WINDOW_LIFE_FD, .events = POLLIN};
    return poll(&life, 1, 0) != 0;
}

static void say(struct sim_window_shared *shared, const char *why, enum sim_window_state state) {
    snprintf(shared->why, sizeof shared->why, "%s", why);
    atomic_store_explicit(&shared->state, state, memory_order_release);
}

static void write_title(const struct app *app, double rate_hz, char title[256]) {
    char rate[32] = "";
    if (!isnan(rate_hz))
        snprintf(rate, sizeof rate, " - %.0f fps", rate_hz);
    snprintf(title, 256,
             "%.120s%s - click: look, Tab: let go, WASD QE: move, 1/2: hands, M: menu%s, Esc: end",
             app->shared->title, rate, app->pair.split_px > 0 ? ", F2: layout" : "");
}

// How many pictures a second are shown, about once a second.
static void count_picture(struct app *app) {
    double now = glfwGetTime();
    app->pictures++;
    if (now - app->titled_s < 1)
        return;
    char title[256];
    write_title(app, app->pictures / (now - app->titled_s), title);
    glfwSetWindowTitle(app->window, title);
    app->pictures = 0;
    app->titled_s = now;
}

static bool open_window(struct app *app) {
    if (!glfwInit())
        return false;
    char title[256];
    write_title(app, NAN, title);
    glfwWindowHint(GLFW_CLIENT_API, GLFW_NO_API);
    app->window = glfwCreateWindow((int)app->shared->width_px, (int)app->shared->height_px, title,
                                   NULL, NULL);
    if (!app->window)
        return false;
    glfwSetWindowUserPointer(app->window, app);
    glfwSetKeyCallback(app->window, on_key);
    glfwSetMouseButtonCallback(app->window, on_button);
    glfwSetCursorPosCallback(app->window, on_pointer);
    glfwSetScrollCallback(app->window, on_wheel);
    glfwSetWindowFocusCallback(app->window, on_focus);
    glfwSetWindowRefreshCallback(app->window, on_redraw);
    return true;
}

static enum ap_status draw(struct ap_error *err, struct app *app, struct sim_screen *screen) {
    if (!app->pair.rgba)
        return sim_screen_draw(err, screen, NULL, app->pair.width_px, app->pair.height_px);
    uint32_t width_px, height_px;
    sim_arrange(&app->pair, app->layout, app->arranged, &width_px, &height_px);
    return sim_screen_draw(err, screen, app->arranged, width_px, height_px);
}

static enum ap_status run(struct ap_error *err, struct app *app, struct sim_screen *screen) {
    uint32_t front = 2;
    double before = glfwGetTime();
    enum ap_status st = AP_OK;
    while (!st && !glfwWindowShouldClose(app->window) && !runtime_gone()) {
        double now = glfwGetTime();
        hand_over_input(app, now - before);
        before = now;
        uint32_t middle = atomic_load_explicit(&app->shared->middle, memory_order_acquire);
        bool fresh = (middle & SIM_WINDOW_FRESH) != 0;
        if (fresh)
            front = atomic_exchange_explicit(&app->shared->middle, front, memory_order_acq_rel) %
                    SIM_WINDOW_FRESH;
        if (fresh) {
            app->pair.rgba = sim_window_picture(app->shared, front);
            count_picture(app);
        }
        if (fresh || app->redraw || !screen->swapchain)
            st = draw(err, app, screen);
        app->redraw = false;
        if (fresh)
            glfwPollEvents();
        else
            glfwWaitEventsTimeout(0.004);
    }
    return st;
}

int main(void) {
    // The runtime waits for this first process, so that its program never sees a child; what it
    // started lives on as nobody's.
    pid_t pid = fork();
    if (pid != 0)
        _exit(pid < 0 ? 1 : 0);
    struct app app = {.shared = map_memory()};
    struct sim_screen screen = {0};
    struct ap_error error = {{0}};
    if (!app.shared) {
        fputs("antipode-sim-window: is started by the simulated headset (\"window\": true)\n",
              stderr);
        return 2;
    }
    app.layout = (enum sim_window_layout)app.shared->layout;
    app.pair = (struct sim_pair){.width_px = app.shared->width_px,
                                 .height_px = app.shared->height_px,
                                 .split_px = app.shared->split_px};
    app.arranged = malloc(sim_window_picture_bytes(app.shared));
    if (!app.arranged) {
        say(app.shared, "out of memory", SIM_WINDOW_FAILED);
        return 4;
    }
    if (!open_window(&app)) {
        const char *why = NULL;
        glfwGetError(&why);
        say(app.shared, why ? why : "no window system", SIM_WINDOW_FAILED);
        glfwTerminate();
        return 4;
    }
    enum ap_status st =
        sim_screen_open(&error, app.window, app.shared->width_px, app.shared->height_px, &screen);
    if (!st) {
        atomic_store_explicit(&app.shared->state, SIM_WINDOW_OPEN, memory_order_release);
        st = run(&error, &app, &screen);
        say(app.shared, error.text, SIM_WINDOW_CLOSED);
    } else {
        say(app.shared, error.text, SIM_WINDOW_FAILED);
    }
    sim_screen_close(&screen);
    glfwDestroyWindow(app.window);
    glfwTerminate();
    free(app.arranged);
    return (int)st;
}
