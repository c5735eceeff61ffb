#include "tests/sim_hmd/client.h"

#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

// What the simulated headset costs a program: two 64×64 swapchains, one projection layer, nothing
// drawn, nothing captured; CPU time of the whole process, and of each call. On the virtual clock,
// or with the argument "real" at 90 Hz. There, block by block in turn with the frames, a program
// that only sleeps as long and reads the measuring clock as often: what is left is the runtime's.
// The functions are what xrGetInstanceProcAddr gives, as engines call them; with the argument
// "linked" the loader's, which look the handle's instance up first.

enum { BLOCK = 50, CALLS = 7, RATE_HZ = 90 };

static const char *const names[CALLS] = {"xrWaitFrame",  "xrBeginFrame", "xrLocateViews",
                                         "two acquires", "two waits",    "two releases",
                                         "xrEndFrame"};
#define EACH(X)                                                                                    \
    X(WaitFrame)                                                                                   \
    X(BeginFrame)                                                                                  \
    X(LocateViews)                                                                                 \
    X(AcquireSwapchainImage) X(WaitSwapchainImage) X(ReleaseSwapchainImage) X(EndFrame)
#define MEMBER(name) PFN_xr##name name;
#define LINKED(name) .name = xr##name,
static struct { EACH(MEMBER) } call = {EACH(LINKED)};

static double spent[CALLS];
static const char *settings = "{\"clock\": \"virtual\", \"poses\": {\"script\": \"walk\", "
                              "\"duration_s\": 60}}";

static double cpu_us(void) {
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec * 1e6 + (double)t.tv_nsec * 1e-3;
}

static double lap(double since, int which) {
    double now = cpu_us();
    spent[which] += now - since;
    return now;
}

static void frame(struct client *c, const XrSwapchain swapchain[2]) {
    double t = cpu_us();
    XrFrameState f = {.type = XR_TYPE_FRAME_STATE};
    XR_OK(call.WaitFrame(c->session, NULL, &f));
    t = lap(t, 0);
    XR_OK(call.BeginFrame(c->session, NULL));
    t = lap(t, 1);
    XrViewLocateInfo info = {.type = XR_TYPE_VIEW_LOCATE_INFO,
                             .viewConfigurationType = XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO,
                             .displayTime = f.predictedDisplayTime,
                             .space = c->local};
    XrViewState state = {.type = XR_TYPE_VIEW_STATE};
    XrView views[2] = {{.type = XR_TYPE_VIEW}, {.type = XR_TYPE_VIEW}};
    uint32_t count, index;
    XR_OK(call.LocateViews(c->session, &info, &state, 2, &count, views));
    t = lap(t, 2);
    for (int eye = 0; eye < 2; eye++)
        XR_OK(call.AcquireSwapchainImage(swapchain[eye], NULL, &index));
    t = lap(t, 3);
    XrSwapchainImageWaitInfo wait = {.type = XR_TYPE_SWAPCHAIN_IMAGE_WAIT_INFO};
    for (int eye = 0; eye < 2; eye++)
        XR_OK(call.WaitSwapchainImage(swapchain[eye], &wait));
    t = lap(t, 4);
    for (int eye = 0; eye < 2; eye++)
        XR_OK(call.ReleaseSwapchainImage(swapchain[eye], NULL));
    t = lap(t, 5);
    XrCompositionLayerProjectionView views_out[2];
    for (int eye = 0; eye < 2; eye++)
        views_out[eye] = (XrCompositionLayerProjectionView){
            .type = XR_TYPE_COMPOSITION_LAYER_PROJECTION_VIEW,
            .pose = views[eye].pose,
            .fov = views[eye].fov,
            .subImage = {.swapchain = swapchain[eye], .imageRect.extent = {64, 64}}};
    XrCompositionLayerProjection layer = {.type = XR_TYPE_COMPOSITION_LAYER_PROJECTION,
                                          .space = c->local,
                                          .viewCount = 2,
                                          .views = views_out};
    const XrCompositionLayerBaseHeader *layers[] = {(const XrCompositionLayerBaseHeader *)&layer};
    XrFrameEndInfo end = {.type = XR_TYPE_FRAME_END_INFO,
                          .displayTime = f.predictedDisplayTime,
                          .environmentBlendMode = XR_ENVIRONMENT_BLEND_MODE_OPAQUE,
                          .layerCount = 1,
                          .layers = layers};
    XR_OK(call.EndFrame(c->session, &end));
    lap(t, 6);
}

static bool real, linked;
static int frames = 2000;
enum { MOST_FRAMES = 100000 };
static double own_us[MOST_FRAMES], bare_us[MOST_FRAMES];
static int bare_count;

static void bare_frame(struct timespec *until) {
    until->tv_nsec += 1000000000 / RATE_HZ;
    if (until->tv_nsec >= 1000000000) {
        until->tv_nsec -= 1000000000;
        until->tv_sec++;
    }
    double start = cpu_us(), t = start;
    clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, until, NULL);
    for (int i = 0; i < CALLS; i++)
        t = cpu_us();
    bare_us[bare_count++] = t - start;
}

static int rising(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double median(double *values, int count) {
    qsort(values, (size_t)count, sizeof *values, rising);
    return values[count / 2];
}

static void measure(void **state) {
    (void)state;
    client_settings(settings);
    struct client c = {0};
    client_start(&c);
#define FOUND(name)                                                                                \
    XR_OK(xrGetInstanceProcAddr(c.instance, "xr" #name, (PFN_xrVoidFunction *)&call.name));
    if (!linked) {
        EACH(FOUND)
    }
    XrSwapchain swapchain[2];
    XrSwapchainCreateInfo info = {.type = XR_TYPE_SWAPCHAIN_CREATE_INFO,
                                  .usageFlags = XR_SWAPCHAIN_USAGE_COLOR_ATTACHMENT_BIT,
                                  .format = VK_FORMAT_R8G8B8A8_SRGB,
                                  .sampleCount = 1,
                                  .width = 64,
                                  .height = 64,
                                  .faceCount = 1,
                                  .arraySize = 1,
                                  .mipCount = 1};
    for (int eye = 0; eye < 2; eye++)
        XR_OK(xrCreateSwapchain(c.session, &info, &swapchain[eye]));
    for (int k = 0; k < 100; k++)
        frame(&c, swapchain);
    memset(spent, 0, sizeof spent);
    double total = 0;
    for (int done = 0; done < frames; done += BLOCK) {
        for (int k = 0; k < BLOCK; k++) {
            double start = cpu_us();
            frame(&c, swapchain);
            own_us[done + k] = cpu_us() - start;
            total += own_us[done + k];
        }
        struct timespec until;
        clock_gettime(CLOCK_MONOTONIC, &until);
        for (int k = 0; k < BLOCK && real; k++)
            bare_frame(&until);
    }
    Dl_info where;
    if (dladdr((void *)(uintptr_t)call.LocateViews, &where))
        printf("functions of %s\n", where.dli_fname);
    printf("%d frames: %.2f us of CPU a frame\n", frames, total / frames);
    for (int i = 0; i < CALLS; i++)
        printf("  %-14s %6.2f us\n", names[i], spent[i] / frames);
    if (real) {
        double frame_us = median(own_us, frames), asleep_us = median(bare_us, bare_count);
        printf("  medians: a frame %.2f us, bare sleep %.2f us; the runtime's own %.2f us\n",
               frame_us, asleep_us, frame_us - asleep_us);
    }
    client_stop(&c);
}

int main(int argc, char **argv) {
    for (int i = 1; i < argc; i++) {
        real |= strcmp(argv[i], "real") == 0;
        linked |= strcmp(argv[i], "linked") == 0;
        frames =
            atoi(argv[i]) >= BLOCK && atoi(argv[i]) <= MOST_FRAMES - BLOCK ? atoi(argv[i]) : frames;
    }
    if (real)
        settings = "{\"clock\": \"real\", \"refresh_hz\": 90}";
    const struct CMUnitTest tests[] = {cmocka_unit_test(measure)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
