#include "sim_hmd/core/quiet_write.h"

#include <errno.h>
#include <pthread.h>
#include <signal.h>
#include <time.h>
#include <unistd.h>

static ssize_t write_some(int fd, const char *bytes, size_t len) {
    sigset_t too_long, old;
    sigemptyset(&too_long);
    sigaddset(&too_long, SIGXFSZ);
    pthread_sigmask(SIG_BLOCK, &too_long, &old);
    ssize_t n = write(fd, bytes, len);
    int why = errno;
    if (n < 0 && why == EFBIG)
        sigtimedwait(&too_long, NULL, &(struct timespec){0});
    pthread_sigmask(SIG_SETMASK, &old, NULL);
    errno = why;
    return n;
}

bool sim_write_quietly(int fd, const char *bytes, size_t len) {
    while (len > 0) {
        ssize_t n = write_some(fd, bytes, len);
        if (n < 0 && errno == EINTR)
            continue;
        if (n <= 0) {
            errno = n ? errno : ENOSPC;
            return false;
        }
        bytes += n;
        len -= (size_t)n;
    }
    return true;
}
