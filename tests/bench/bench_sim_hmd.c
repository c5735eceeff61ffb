#include "tests/sim_hmd/client.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

// What the simulated headset costs a program: two 64×64 swapchains, one projection layer, nothing
// drawn, nothing captured; CPU time of the whole process, and of each call. On the virtual clock,
// or with the argument "real" at 90 Hz.

enum { FRAMES = 2000, CALLS = 7 };

static const char *const names[CALLS] = {"xrWaitFrame",  "xrBeginFrame", "xrLocateViews",
                                         "two acquires", "two waits",    "two releases",
                                         "xrEndFrame"};
static double spent[CALLS];
static const char *settings = "{\"clock\": \"virtual\", \"poses\": {\"script\": \"walk\", "
                              "\"duration_s\": 60}}";

static double cpu_us(void) {
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec * 1e6 + (double)t.tv_nsec * 1e-3;
}

static double lap(double since, int call) {
    double now = cpu_us();
    spent[call] += now - since;
    return now;
}

static void frame(struct client *c, const XrSwapchain swapchain[2]) {
    double t = cpu_us();
    XrFrameState f = client_wait(c);
    t = lap(t, 0);
    client_begin(c);
    t = lap(t, 1);
    XrViewLocateInfo info = {.type = XR_TYPE_VIEW_LOCATE_INFO,
                             .viewConfigurationType = XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO,
                             .displayTime = f.predictedDisplayTime,
                             .space = c->local};
    XrViewState state = {.type = XR_TYPE_VIEW_STATE};
    XrView views[2] = {{.type = XR_TYPE_VIEW}, {.type = XR_TYPE_VIEW}};
    uint32_t count, index;
    XR_OK(xrLocateViews(c->session, &info, &state, 2, &count, views));
    t = lap(t, 2);
    for (int eye = 0; eye < 2; eye++)
        XR_OK(xrAcquireSwapchainImage(swapchain[eye], NULL, &index));
    t = lap(t, 3);
    XrSwapchainImageWaitInfo wait = {.type = XR_TYPE_SWAPCHAIN_IMAGE_WAIT_INFO};
    for (int eye = 0; eye < 2; eye++)
        XR_OK(xrWaitSwapchainImage(swapchain[eye], &wait));
    t = lap(t, 4);
    for (int eye = 0; eye < 2; eye++)
        XR_OK(xrReleaseSwapchainImage(swapchain[eye], NULL));
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
    XR_OK(xrEndFrame(c->session, &end));
    lap(t, 6);
}

static void measure(void **state) {
    (void)state;
    client_settings(settings);
    struct client c = {0};
    client_start(&c);
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
    double start = cpu_us();
    for (int k = 0; k < FRAMES; k++)
        frame(&c, swapchain);
    printf("%d frames: %.2f us of CPU a frame\n", FRAMES, (cpu_us() - start) / FRAMES);
    for (int i = 0; i < CALLS; i++)
        printf("  %-14s %6.2f us\n", names[i], spent[i] / FRAMES);
    client_stop(&c);
}

int main(int argc, char **argv) {
    if (argc > 1 && strcmp(argv[1], "real") == 0)
        settings = "{\"clock\": \"real\", \"refresh_hz\": 90}";
    const struct CMUnitTest tests[] = {cmocka_unit_test(measure)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
