#include "sim_hmd/window/window.h"

#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <poll.h>
#include <pthread.h>
#include <signal.h>
#include <spawn.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include "sim_hmd/window/shared.h"
#include "src/base/file.h"
#include "src/base/log.h"

struct sim_window {
    struct sim_window_shared *shared;
    size_t bytes;
    int life; // socket
    bool gone, failed;
    pthread_mutex_t lock; // back and last
    uint32_t back;
    int64_t last; // frame shown
};

static char *program_in(const char *folder, const char *below) {
    char *dir = ap_path_join(folder, below);
    char *path = dir ? ap_path_join(dir, "antipode-sim-window") : NULL;
    free(dir);
    if (path && access(path, X_OK) == 0)
        return path;
    free(path);
    return NULL;
}

// Beside the library that this code is in (the build folder), or where it is installed:
// PREFIX/lib[/TRIPLET] and PREFIX/libexec/antipode.
static char *find_program(void) {
    static const char *const below[] = {".", "../libexec/antipode", "../../libexec/antipode"};
    Dl_info info;
    char real[PATH_MAX];
    void *here = NULL;
    // ISO C has no conversion from a function's pointer to an object's; POSIX has the cast.
    enum ap_status (*self)(struct ap_error *, const struct sim_window_params *,
                           struct sim_window **) = sim_window_open;
    memcpy(&here, &self, sizeof here);
    if (!dladdr(here, &info) || !info.dli_fname || !realpath(info.dli_fname, real))
        return NULL;
    char *slash = strrchr(real, '/');
    if (!slash)
        return NULL;
    *slash = '\0';
    char *path = NULL;
    for (size_t k = 0; k < sizeof below / sizeof below[0] && !path; k++)
        path = program_in(real, below[k]);
    return path;
}

// Out of the way of the numbers that the program expects its own at.
static int high_fd(int fd) {
    int high = fd < 0 ? -1 : fcntl(fd, F_DUPFD_CLOEXEC, 16);
    if (fd >= 0)
        close(fd);
    return high;
}

// The ends that a fork's child must not keep open, for the window would outlive its runtime. Places
// are taken and left without a lock: the child may close them only if no other thread can hold one.
enum { MAX_LIVES = 16 };
static _Atomic int lives[MAX_LIVES]; // descriptor + 1; 0: free

static void close_in_child(void) {
    for (int i = 0; i < MAX_LIVES; i++) {
        int life = atomic_exchange(&lives[i], 0) - 1;
        if (life >= 0)
            close(life);
    }
}

static void watch_forks(void) {
    pthread_atfork(NULL, NULL, close_in_child);
}

static void remember_life(int life) {
    static pthread_once_t once = PTHREAD_ONCE_INIT;
    pthread_once(&once, watch_forks);
    for (int i = 0; i < MAX_LIVES; i++) {
        int none = 0;
        if (atomic_compare_exchange_strong(&lives[i], &none, life + 1))
            return;
    }
}

static void forget_life(int life) {
    for (int i = 0; i < MAX_LIVES && life >= 0; i++) {
        int it = life + 1;
        if (atomic_compare_exchange_strong(&lives[i], &it, 0))
            return;
    }
}

// The program forks at once and its first process leaves, so that the program that we live in never
// gets to see a child of ours. Its own signal settings and open files stay its own too.
static enum ap_status spawn(struct ap_error *err, const char *path, int memory, int life) {
    posix_spawn_file_actions_t files;
    posix_spawnattr_t attributes;
    sigset_t none, defaults;
    sigemptyset(&none);
    sigfillset(&defaults);
    posix_spawn_file_actions_init(&files);
    posix_spawnattr_init(&attributes);
    posix_spawn_file_actions_addopen(&files, 0, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_adddup2(&files, 2, 1); // what it says is for people
    posix_spawn_file_actions_adddup2(&files, memory, SIM_WINDOW_MEMORY_FD);
    posix_spawn_file_actions_adddup2(&files, life, SIM_WINDOW_LIFE_FD);
    posix_spawn_file_actions_addclosefrom_np(&files, SIM_WINDOW_LIFE_FD + 1);
    posix_spawnattr_setsigmask(&attributes, &none);
    posix_spawnattr_setsigdefault(&attributes, &defaults);
    posix_spawnattr_setpgroup(&attributes, 0);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF |
                                              POSIX_SPAWN_SETPGROUP);
    char name[] = "antipode-sim-window";
    char *argv[] = {name, NULL};
    pid_t pid;
    int failed = posix_spawn(&pid, path, &files, &attributes, argv, environ);
    posix_spawnattr_destroy(&attributes);
    posix_spawn_file_actions_destroy(&files);
    if (failed)
        return ap_fail(err, AP_ENVIRONMENT, "%s: cannot be started: %s", path, strerror(failed));
    int status = 0;
    while (waitpid(pid, &status, 0) < 0)
        if (errno != EINTR)
            return AP_OK; // somebody else waited for it, or nobody may; its socket will tell
    if (!WIFEXITED(status) || WEXITSTATUS(status) != 0)
        return ap_fail(err, AP_ENVIRONMENT, "%s: did not start", path);
    return AP_OK;
}

static enum ap_status share_memory(struct ap_error *err, const struct sim_window_params *params,
                                   struct sim_window *w, int *memory) {
    struct sim_window_shared shared = {.version = SIM_WINDOW_VERSION,
                                       .width_px = params->width_px,
                                       .height_px = params->height_px,
                                       .split_px = params->split_px,
                                       .layout = params->layout,
                                       .middle = 1};
    strncpy(shared.title, params->title && *params->title ? params->title : "antipode",
            sizeof shared.title - 1);
    w->bytes = sim_window_memory_bytes(&shared);
    *memory = high_fd(memfd_create("antipode-window", MFD_CLOEXEC));
    if (*memory < 0 || ftruncate(*memory, (off_t)w->bytes) != 0)
        return ap_fail(err, AP_ENVIRONMENT, "no shared memory for the window: %s", strerror(errno));
    void *mapped = mmap(NULL, w->bytes, PROT_READ | PROT_WRITE, MAP_SHARED, *memory, 0);
    if (mapped == MAP_FAILED)
        return ap_fail(err, AP_ENVIRONMENT, "no shared memory for the window: %s", strerror(errno));
    w->shared = mapped;
    memcpy(w->shared, &shared, sizeof shared);
    return AP_OK;
}

static enum ap_status create(struct ap_error *err, const struct sim_window_params *params,
                             const char *program, struct sim_window *w) {
    int memory = -1, ends[2] = {-1, -1};
    enum ap_status st = share_memory(err, params, w, &memory);
    if (!st && socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0)
        st = ap_fail(err, AP_ENVIRONMENT, "no socket for the window: %s", strerror(errno));
    w->life = high_fd(ends[0]);
    ends[1] = high_fd(ends[1]);
    if (!st && (w->life < 0 || ends[1] < 0))
        st = ap_fail(err, AP_ENVIRONMENT, "no socket for the window: %s", strerror(errno));
    if (!st)
        st = spawn(err, program, memory, ends[1]);
    if (!st)
        remember_life(w->life);
    if (memory >= 0)
        close(memory);
    if (ends[1] >= 0)
        close(ends[1]);
    return st;
}

enum ap_status sim_window_open(struct ap_error *err, const struct sim_window_params *params,
                               struct sim_window **window) {
    if (params->width_px == 0 || params->height_px == 0 || params->width_px > SIM_WINDOW_MAX_SIDE ||
        params->height_px > SIM_WINDOW_MAX_SIDE)
        return ap_fail(err, AP_USAGE, "a window of %ux%u pixels: expected 1 to %d each way",
                       params->width_px, params->height_px, SIM_WINDOW_MAX_SIDE);
    if (params->split_px >= params->width_px)
        return ap_fail(err, AP_USAGE, "a window of %u pixels cannot begin its right eye at %u",
                       params->width_px, params->split_px);
    char *found = params->program ? strdup(params->program) : find_program();
    if (!found)
        return ap_fail(err, AP_ENVIRONMENT,
                       "antipode-sim-window is neither beside the runtime library nor in "
                       "../libexec/antipode");
    enum ap_status st = AP_OK;
    struct sim_window *w = calloc(1, sizeof *w);
    if (!w) {
        st = ap_fail(err, AP_ENVIRONMENT, "out of memory");
        goto out;
    }
    w->life = -1;
    w->back = 0;
    w->last = INT64_MIN;
    pthread_mutex_init(&w->lock, NULL);
    st = create(err, params, found, w);
    if (st)
        sim_window_close(w);
    else
        *window = w;
out:
    free(found);
    return st;
}

bool sim_window_alive(struct sim_window *w) {
    if (w->gone)
        return false;
    uint32_t state = atomic_load_explicit(&w->shared->state, memory_order_acquire);
    struct pollfd life = {.fd = w->life, .events = POLLIN};
    if (state != SIM_WINDOW_FAILED && state != SIM_WINDOW_CLOSED && poll(&life, 1, 0) <= 0)
        return true;
    w->gone = true;
    // It may have said why between our two looks.
    state = atomic_load_explicit(&w->shared->state, memory_order_acquire);
    if (state == SIM_WINDOW_FAILED || state == SIM_WINDOW_STARTING) {
        w->failed = true;
        char why[sizeof w->shared->why];
        memcpy(why, w->shared->why, sizeof why);
        why[sizeof why - 1] = '\0';
        for (char *c = why; *c; c++)
            if ((unsigned char)*c < 0x20 || *c == 0x7f)
                *c = '?';
        ap_log(AP_LOG_WARNING, "the window cannot be opened (%s): going on without it",
               *why ? why : "its program ended");
    }
    return false;
}

void sim_window_show(struct sim_window *w, int64_t frame, const void *rgba) {
    pthread_mutex_lock(&w->lock);
    if (frame > w->last) {
        w->last = frame;
        memcpy(sim_window_picture(w->shared, w->back), rgba, sim_window_picture_bytes(w->shared));
        w->back = atomic_exchange_explicit(&w->shared->middle, w->back | SIM_WINDOW_FRESH,
                                           memory_order_acq_rel) %
                  SIM_WINDOW_FRESH;
    }
    pthread_mutex_unlock(&w->lock);
}

static double from_fixed(_Atomic int64_t *value) {
    return (double)atomic_load_explicit(value, memory_order_relaxed) / SIM_WINDOW_FIXED_POINT;
}

void sim_window_input(struct sim_window *w, struct sim_window_input *input) {
    struct sim_window_shared *s = w->shared;
    *input = (struct sim_window_input){
        .keys = w->gone ? 0 : atomic_load_explicit(&s->keys, memory_order_relaxed),
        .mouse_x_px = from_fixed(&s->mouse_x),
        .mouse_y_px = from_fixed(&s->mouse_y),
        .wheel = from_fixed(&s->wheel),
        .closed = w->gone && !w->failed};
    atomic_fetch_add_explicit(&s->looks, 1, memory_order_relaxed);
}

void sim_window_close(struct sim_window *w) {
    if (!w)
        return;
    forget_life(w->life);
    if (w->life >= 0)
        close(w->life); // which is how the program learns of it
    if (w->shared)
        munmap(w->shared, w->bytes);
    pthread_mutex_destroy(&w->lock);
    free(w);
}
