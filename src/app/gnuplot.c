#include "src/app/gnuplot.h"

#include <errno.h>
#include <spawn.h>
#include <stdbool.h>
#include <sys/wait.h>
#include <unistd.h>

#include "src/base/file.h"
#include "src/base/log.h"

// True where gnuplot ran and said that all went well.
static bool run_gnuplot(FILE *script, FILE *picture) {
    extern char **environ;
    char program[] = "gnuplot", defaults[] = "--default-settings";
    char *argv[] = {program, defaults, NULL};
    posix_spawn_file_actions_t actions;
    pid_t pid;
    int status = 1;
    if (posix_spawn_file_actions_init(&actions) != 0)
        return false;
    bool ran = posix_spawn_file_actions_adddup2(&actions, fileno(script), STDIN_FILENO) == 0 &&
               posix_spawn_file_actions_adddup2(&actions, fileno(picture), STDOUT_FILENO) == 0 &&
               posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, "/dev/null", 1, 0) == 0 &&
               posix_spawnp(&pid, program, &actions, NULL, argv, environ) == 0;
    posix_spawn_file_actions_destroy(&actions);
    if (!ran)
        return false;
    while (waitpid(pid, &status, 0) < 0)
        if (errno != EINTR)
            return false;
    return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

enum ap_status ap_gnuplot(struct ap_error *err, FILE *script, const char *path) {
    struct ap_outfile picture;
    enum ap_status st = ap_outfile_open(err, path, &picture);
    if (st)
        return st;
    rewind(script);
    if (run_gnuplot(script, picture.stream) && lseek(fileno(picture.stream), 0, SEEK_END) > 0)
        return ap_outfile_commit(err, &picture);
    ap_outfile_abort(&picture);
    unlink(path);
    ap_log(AP_LOG_WARNING,
           "%s: no plot: gnuplot is not installed (apt-get install gnuplot-nox), or failed", path);
    return AP_OK;
}
