#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tests/vm/headset.h"
#include "tests/vm/player.h"

// An OpenXR program as somebody else would write it, without graphics (XR_MND_headless), through
// the real loader: follows the head for a while on a recording whose report i turns it by i·0.1
// mrad.
//
//   headset_client SECONDS SENT-LOG|- [frames]
//
// Every four milliseconds it asks where the head is now, and where it was each millisecond from 13
// to 10 ms ago; with "frames" it runs a frame loop instead. Told, a line each:
//   state head tracked|lost at T               CLOCK_MONOTONIC, as it changes
//   located N backwards B aside A              past poses; steps back; off the vertical axis
//   behind median … p99 … max … us             of a past pose behind what had been sent by then
//   frames N longest … us                      between two xrWaitFrame, less the period

enum { MAX = 400000, ROUND = 6283, ASKED = 4 };
static const int64_t MS = 1000000, BACK_NS = 10000000;

struct located {
    int64_t t_ns; // CLOCK_MONOTONIC
    double yaw_rad;
};

struct client {
    struct headset headset;
    struct located *located;
    int64_t count, backwards, aside, frames, longest_ns;
    const char *state;
};

static bool note_state(struct client *c, const XrSpaceLocation *at) {
    bool tracked = at->locationFlags & XR_SPACE_LOCATION_ORIENTATION_TRACKED_BIT;
    const char *state = tracked ? "tracked" : "lost";
    if (!c->state || strcmp(state, c->state) != 0)
        printf("state head %s at %" PRId64 "\n", state, player_now_ns());
    c->state = state;
    return tracked;
}

static double wrapped(double rad) {
    return remainder(rad, 2 * 3.14159265358979);
}

static void note_past(struct client *c, int64_t t_ns) {
    XrSpaceLocation at =
        headset_locate(&c->headset, c->headset.view, headset_time(&c->headset, t_ns));
    XrQuaternionf q = at.pose.orientation;
    bool tracked = at.locationFlags & XR_SPACE_LOCATION_ORIENTATION_TRACKED_BIT;
    if (!tracked || c->count == MAX)
        return;
    double yaw = 2 * atan2((double)q.y, (double)q.w);
    // A rounded quaternion (Q15) is off the axis by some 1e-5.
    c->aside += fabs((double)q.x) > 1e-4 || fabs((double)q.z) > 1e-4;
    if (c->count > 0 && wrapped(yaw - c->located[c->count - 1].yaw_rad) < -5e-4)
        c->backwards++;
    c->located[c->count++] = (struct located){t_ns, yaw};
}

static void follow(struct client *c, double seconds) {
    int64_t now = player_now_ns(), end = now + (int64_t)(seconds * 1e9);
    for (int64_t next = now; !player_stop && now < end;
         next += ASKED * MS + 10000) { // at every phase of a report
        while ((now = player_now_ns()) < next)
            nanosleep(&(struct timespec){.tv_nsec = next - now}, NULL);
        XrSpaceLocation at =
            headset_locate(&c->headset, c->headset.view, headset_time(&c->headset, now));
        if (note_state(c, &at))
            for (int i = ASKED; i-- > 0;)
                note_past(c, next - BACK_NS - i * MS);
    }
}

static void run_frames(struct client *c, double seconds) {
    int64_t end = player_now_ns() + (int64_t)(seconds * 1e9), before = player_now_ns();
    while (!player_stop && player_now_ns() < end) {
        XrFrameState frame = {.type = XR_TYPE_FRAME_STATE};
        headset_need(xrWaitFrame(c->headset.session, NULL, &frame), "xrWaitFrame");
        headset_need(xrBeginFrame(c->headset.session, NULL), "xrBeginFrame");
        XrSpaceLocation at =
            headset_locate(&c->headset, c->headset.view, frame.predictedDisplayTime);
        note_state(c, &at);
        const XrFrameEndInfo info = {.type = XR_TYPE_FRAME_END_INFO,
                                     .displayTime = frame.predictedDisplayTime,
                                     .environmentBlendMode = XR_ENVIRONMENT_BLEND_MODE_OPAQUE};
        headset_need(xrEndFrame(c->headset.session, &info), "xrEndFrame");
        int64_t now = player_now_ns(), over = now - before - frame.predictedDisplayPeriod;
        if (c->frames++ > 2 && over > c->longest_ns)
            c->longest_ns = over;
        before = now;
    }
}

static int compare(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

// What had been sent at the time of each past pose, less what the pose shows; a report is 1 ms.
static void tell_behind(const struct client *c, const char *sent_log) {
    FILE *file = fopen(sent_log, "r");
    double *us = calloc((size_t)c->count + 1, sizeof *us);
    long long index, t_ns, last_index = -1, last_t_ns = 0;
    int64_t at = 0, n = 0;
    char end;
    while (file && us && fscanf(file, "%lld %lld%c", &index, &t_ns, &end) == 3) {
        for (; at < c->count && c->located[at].t_ns < t_ns; at++)
            if (last_index >= 0) {
                double part =
                    (double)(c->located[at].t_ns - last_t_ns) / (double)(t_ns - last_t_ns);
                double sent_rad = 1e-3 * ((double)(last_index % ROUND) + part);
                us[n++] = fabs(wrapped(sent_rad - c->located[at].yaw_rad)) * 1e6;
            }
        last_index = index;
        last_t_ns = t_ns;
    }
    if (n > 0) {
        qsort(us, (size_t)n, sizeof *us, compare);
        printf("behind median %.0f p99 %.0f max %.0f us of %" PRId64 "\n", us[n / 2],
               us[n * 99 / 100], us[n - 1], n);
    }
    free(us);
    if (file)
        fclose(file);
}

static void on_signal(int number) {
    (void)number;
    player_stop = 1;
}

int main(int argc, char **argv) {
    struct client c = {.located = calloc(MAX, sizeof *c.located)};
    if (argc < 3 || !c.located)
        player_die("see headset_client.c for the arguments");
    setvbuf(stdout, NULL, _IOLBF, 0);
    sigaction(SIGTERM, &(struct sigaction){.sa_handler = on_signal}, NULL);
    headset_open(&c.headset);
    headset_begin(&c.headset);
    printf("ready\n");
    if (argc > 3)
        run_frames(&c, atof(argv[1]));
    else
        follow(&c, atof(argv[1]));
    headset_close(&c.headset);
    if (argc > 3)
        printf("frames %" PRId64 " longest %.0f us\n", c.frames, (double)c.longest_ns / 1e3);
    else
        printf("located %" PRId64 " backwards %" PRId64 " aside %" PRId64 "\n", c.count,
               c.backwards, c.aside);
    if (strcmp(argv[2], "-") != 0)
        tell_behind(&c, argv[2]);
    free(c.located);
    return 0;
}
