// How long a frame of the billiards room takes: bench_render [frames]. Prints milliseconds from the
// call to an idle queue, both eyes, at the sizes of the shipped headset profiles, and the CPU time
// of all threads, which on a software device is the drawing itself and does not depend on who else
// runs.
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "src/base/clock.h"
#include "tests/render/stage.h"

static double cpu_ms(void) {
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec * 1e3 + (double)t.tv_nsec / 1e6;
}

static void bench(struct stage *stage, const char *space, enum ap_view_mode mode, int frames) {
    struct ap_scene *scene;
    struct ap_scene_params params = {.space_name = space};
    STAGE_CHECK(ap_scene_billiards(&stage_error, &params, &scene));
    struct ap_frame_input input = stage_input(scene->space, mode, 0.85, 0.064);
    struct ap_renderer *renderer = stage_renderer(stage, scene, NULL);
    VkImage image = stage->target.image;
    struct ap_target target = {{image, image}, {0, 1}};
    struct ap_frame_stats stats = {0};
    double total = 0, recording = 0, cpu = 0;
    for (int f = -1; f < frames; f++) { // the first one compiles
        struct ap_vec3 at = {0.1 * f / frames, 0.5, 0.9};
        struct ap_quat pitch = ap_quat_from_axis_angle((struct ap_vec3){1, 0, 0}, -0.5);
        input.viewer.world_from_nose = ap_iso_from_pose(scene->space, (struct ap_pose){at, pitch});
        double cpu_start = cpu_ms();
        int64_t start = ap_clock_now_ns();
        STAGE_CHECK(ap_renderer_draw(&stage_error, renderer, &input, &target, &stats));
        int64_t recorded = ap_clock_now_ns();
        vkDeviceWaitIdle(stage->gpu.device);
        if (f >= 0) {
            recording += (double)(recorded - start) / 1e6;
            cpu += cpu_ms() - cpu_start;
            total += (double)(ap_clock_now_ns() - start) / 1e6;
        }
    }
    printf(
        "%s %s %ux%u x2: %.1f ms/frame, %.1f of CPU; %.2f until the submission returned; left eye "
        "%u draws, %llu triangles\n",
        space, ap_view_mode_name(mode), stage->width, stage->height, total / frames, cpu / frames,
        recording / frames, stats.eye[0].draws, (unsigned long long)stats.eye[0].triangles);
    ap_renderer_destroy(renderer);
    ap_scene_destroy(scene);
}

int main(int argc, char **argv) {
    static const char *const SPACES[] = {"s3", "e3", "h3"};
    static const uint32_t SIZES[][2] = {{360, 400}, {1440, 1600}};
    int frames = argc > 1 ? atoi(argv[1]) : 10;
    struct stage stage;
    if (frames < 1 || !stage_open(&stage, SIZES[0][0], SIZES[0][1], false))
        return 77;
    printf("%s\n", stage.gpu.properties.deviceName);
    for (int size = 0; size < 2; size++) {
        stage_resize(&stage, SIZES[size][0], SIZES[size][1]);
        for (int s = 0; s < 3; s++)
            bench(&stage, SPACES[s], AP_VIEW_NATIVE, frames);
        bench(&stage, "h3", AP_VIEW_TOURIST, frames);
    }
    stage_close(&stage);
    return 0;
}
