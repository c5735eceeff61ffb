#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "src/base/clock.h"
#include "src/device/poselog.h"
#include "src/device/walk.h"

// A pose log comes through a pipe at standard input while it is being made; the reader's memory
// must not grow with it. `device_stream 2000` sends 2 GB instead of 64 MB.

enum { TAILS = 768, LIMIT_KB = 64 * 1024 };

// What stands behind the time in 256 instants of the walk, three devices each.
static char tails[TAILS][256];

static void make_tails(void) {
    static const char *const names[] = {"head", "left", "right"};
    struct ap_walk_params walk = {0};
    for (int i = 0; i < TAILS; i++) {
        char *text = NULL;
        size_t len = 0;
        FILE *stream = open_memstream(&text, &len);
        struct ap_sample sample = ap_walk_at(&walk, i % 3, i / 3 * INT64_C(70000000));
        ap_poselog_write_row(stream, names[i % 3], &sample);
        fclose(stream);
        snprintf(tails[i], sizeof tails[i], "%s", strchr(text, ','));
        free(text);
    }
}

static int write_log(int fd, int64_t bytes) {
    FILE *stream = fdopen(fd, "w");
    if (!stream)
        return 1;
    ap_poselog_write_header(stream);
    int64_t rows = 0;
    for (int64_t sent = 0; sent < bytes; rows++) {
        const char *tail = tails[rows % TAILS];
        int n = fprintf(stream, "%" PRId64, INT64_C(1700000000000000000) + rows / 3 * 1000000);
        if (n < 0 || fputs(tail, stream) < 0)
            return 1;
        sent += n + (int64_t)strlen(tail);
    }
    return fclose(stream) ? 1 : 0;
}

static int read_log(int64_t *rows) {
    const char *source = "-";
    struct ap_poselog_params params = {.sources = &source, .source_count = 1};
    struct ap_poselog *log = NULL;
    struct ap_error err;
    enum ap_status st = ap_poselog_open(&err, &params, &log);
    bool got = !st;
    double sum = 0;
    while (!st && got) {
        struct ap_sample sample;
        st = ap_poselog_next(&err, log, &sample, &got);
        if (!st && got) {
            sum += sample.pose.p.y;
            ++*rows;
        }
    }
    if (st)
        printf("error: %s\n", err.text);
    if (!(sum > 0))
        puts("error: the sum of heights is not positive");
    ap_poselog_close(log);
    return st || !(sum > 0);
}

// The process's own high-water mark: getrusage's also counts what ran before exec.
static long peak_kb(void) {
    FILE *stream = fopen("/proc/self/status", "r");
    char line[256];
    long kb = -1;
    while (stream && fgets(line, sizeof line, stream))
        if (strncmp(line, "VmHWM:", 6) == 0)
            kb = atol(line + 6);
    if (stream)
        fclose(stream);
    return kb;
}

int main(int argc, char **argv) {
    int64_t megabytes = argc > 1 ? atoll(argv[1]) : 64;
    int ends[2];
    make_tails();
    if (pipe(ends))
        return 1;
    pid_t writer = fork();
    if (writer == 0) {
        close(ends[0]);
        _exit(write_log(ends[1], megabytes * 1000000));
    }
    close(ends[1]);
    if (writer < 0 || dup2(ends[0], STDIN_FILENO) < 0)
        return 1;
    int64_t rows = 0, start = ap_clock_now_ns();
    int failed = read_log(&rows), status;
    double seconds = (double)(ap_clock_now_ns() - start) * 1e-9;
    if (waitpid(writer, &status, 0) != writer || status != 0) {
        puts("error: the writer failed");
        failed = 1;
    }
    struct rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    long peak = peak_kb();
    double cpu = (double)usage.ru_utime.tv_sec + 1e-6 * (double)usage.ru_utime.tv_usec;
    printf("%" PRId64 " MB, %" PRId64
           " rows in %.2f s (%.2f s of it computing: %.2f million rows a "
           "second); at most %ld kB resident, expected below %d kB\n",
           megabytes, rows, seconds, cpu, (double)rows * 1e-6 / cpu, peak, LIMIT_KB);
    return failed || peak < 0 || peak >= LIMIT_KB;
}
