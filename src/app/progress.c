#include "src/app/progress.h"

#include <stdbool.h>
#include <stdio.h>
#include <unistd.h>

static int64_t last_percent = -1;
static bool open_line;

void ap_progress_show(const char *label, int64_t done, int64_t total) {
    enum { WIDTH = 40 };
    int64_t percent = total > 0 ? done * 100 / total : 100;
    if (percent == last_percent)
        return;
    if (!isatty(STDERR_FILENO)) {
        if (percent % 25 == 0)
            fprintf(stderr, "%s %3d%%\n", label, (int)percent);
        last_percent = percent;
        return;
    }
    int filled = (int)(percent * WIDTH / 100);
    fprintf(stderr, "\r%-18.18s [", label);
    for (int i = 0; i < WIDTH; i++)
        fputc(i < filled ? '#' : '.', stderr);
    fprintf(stderr, "] %3d%%", (int)percent);
    fflush(stderr);
    last_percent = percent;
    open_line = true;
}

void ap_progress_end(void) {
    if (open_line)
        fputc('\n', stderr);
    open_line = false;
    last_percent = -1;
}
