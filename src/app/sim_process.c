#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <signal.h>
#include <spawn.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "src/app/sim.h"
#include "src/base/clock.h"

extern char **environ;

// Between SIGTERM and SIGKILL.
static const int64_t GRACE_NS = INT64_C(3000000000);

struct running {
    pid_t pid;
    bool own_group;    // signals go to the program and to what it started
    int64_t deadline;  // INT64_MAX: none
    bool asked_to_end; // SIGTERM was sent because the time is over
};

static void watched_signals(sigset_t *set) {
    sigemptyset(set);
    sigaddset(set, SIGCHLD);
    sigaddset(set, SIGINT);
    sigaddset(set, SIGTERM);
    sigaddset(set, SIGHUP);
}

// A program that reads from a terminal must stay in the terminal's group of processes. Any other
// gets a group of its own, so that --timeout ends what it has started, too.
static bool wants_own_group(const struct ap_sim_process *process) {
    return process->hold_stdin || !isatty(STDIN_FILENO);
}

static int spawn(const struct ap_sim_process *process, const sigset_t *mask, bool own_group,
                 int stdin_fd, pid_t *pid) {
    posix_spawnattr_t attr;
    posix_spawn_file_actions_t files;
    int e = posix_spawnattr_init(&attr);
    if (e)
        return e;
    e = posix_spawn_file_actions_init(&files);
    if (e) {
        posix_spawnattr_destroy(&attr);
        return e;
    }
    // main() ignores SIGPIPE and SIGXFSZ for itself; we block what we wait for.
    sigset_t usual;
    sigemptyset(&usual);
    sigaddset(&usual, SIGPIPE);
    sigaddset(&usual, SIGXFSZ);
    short flags = POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETSIGMASK;
    posix_spawnattr_setsigdefault(&attr, &usual);
    posix_spawnattr_setsigmask(&attr, mask);
    if (own_group)
        posix_spawnattr_setpgroup(&attr, 0);
    posix_spawnattr_setflags(&attr, (short)(flags | (own_group ? POSIX_SPAWN_SETPGROUP : 0)));
    if (stdin_fd >= 0)
        e = posix_spawn_file_actions_adddup2(&files, stdin_fd, STDIN_FILENO);
    if (!e)
        e = posix_spawnp(pid, process->argv[0], &files, &attr, process->argv, environ);
    posix_spawn_file_actions_destroy(&files);
    posix_spawnattr_destroy(&attr);
    return e;
}

static void send(const struct running *r, int sig) {
    kill(r->own_group ? -r->pid : r->pid, sig);
}

// The next signal of the set, 0 when the time is over.
static int next_signal(const sigset_t *set, int64_t deadline, siginfo_t *info) {
    int sig;
    do {
        if (deadline == INT64_MAX) {
            sig = sigwaitinfo(set, info);
        } else {
            int64_t left = deadline - ap_clock_now_ns();
            struct timespec wait = {.tv_sec = left > 0 ? left / 1000000000 : 0,
                                    .tv_nsec = left > 0 ? left % 1000000000 : 0};
            sig = sigtimedwait(set, info, &wait);
        }
    } while (sig < 0 && errno == EINTR);
    return sig < 0 ? 0 : sig;
}

static void time_is_over(struct running *r) {
    send(r, r->asked_to_end ? SIGKILL : SIGTERM);
    r->deadline = r->asked_to_end ? INT64_MAX : ap_clock_now_ns() + GRACE_NS;
    r->asked_to_end = true;
}

static int wait_for_end(struct running *r, const sigset_t *set) {
    for (;;) {
        siginfo_t info;
        int sig = next_signal(set, r->deadline, &info), status;
        if (sig == 0)
            time_is_over(r);
        else if (sig != SIGCHLD && (r->own_group || info.si_code != SI_KERNEL))
            send(r, sig); // what the terminal sends reaches its whole group by itself
        if (waitpid(r->pid, &status, WNOHANG) == r->pid)
            return status;
    }
}

static int64_t deadline_of(double timeout_s) {
    if (isnan(timeout_s) || timeout_s > 1e9)
        return INT64_MAX;
    return ap_clock_now_ns() + (int64_t)(timeout_s * 1e9);
}

static enum ap_status run(struct ap_error *err, const struct ap_sim_process *process, int stdin_fd,
                          struct ap_sim_end *end) {
    sigset_t set, before;
    watched_signals(&set);
    sigprocmask(SIG_BLOCK, &set, &before);
    struct running r = {.own_group = wants_own_group(process),
                        .deadline = deadline_of(process->timeout_s)};
    int e = spawn(process, &before, r.own_group, stdin_fd, &r.pid);
    if (!e) {
        int status = wait_for_end(&r, &set);
        end->timed_out = r.asked_to_end;
        end->signal = WIFSIGNALED(status) ? WTERMSIG(status) : 0;
        end->status = end->signal ? 128 + end->signal : WEXITSTATUS(status);
        if (r.asked_to_end)
            send(&r, SIGKILL); // what it has left behind
    }
    sigprocmask(SIG_SETMASK, &before, NULL);
    if (e)
        return ap_fail(err, AP_ENVIRONMENT, "%s cannot be started: %s", process->argv[0],
                       strerror(e));
    return AP_OK;
}

enum ap_status ap_sim_run_process(struct ap_error *err, const struct ap_sim_process *process,
                                  struct ap_sim_end *end) {
    if (!process->hold_stdin)
        return run(err, process, -1, end);
    int ends[2];
    if (pipe2(ends, O_CLOEXEC) != 0)
        return ap_fail(err, AP_ENVIRONMENT, "no pipe for the program's input: %s", strerror(errno));
    enum ap_status st = run(err, process, ends[0], end);
    close(ends[0]);
    close(ends[1]);
    return st;
}
