// What the room's materials cost: the billiards room at 1280×720, one eye and two, as it is and
// with every part plain (light at the corners, no text, no shadow), in turn: bench_look [rounds].
// Medians of the processor time of all threads, which on a software device is the drawing itself,
// and of wall time; the ratio is of the same run.
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "src/base/clock.h"
#include "src/image/text.h"
#include "tests/render/stage.h"

enum { ROUNDS_MAX = 200 };

static double cpu_ms(void) {
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec * 1e3 + (double)t.tv_nsec / 1e6;
}

static int compare(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return x < y ? -1 : x > y;
}

static double median(double *v, int n) {
    qsort(v, (size_t)n, sizeof *v, compare);
    return v[n / 2];
}

static struct ap_scene *room(const char *space) {
    struct ap_scene *scene;
    struct ap_scene_params params = {.space_name = space};
    STAGE_CHECK(ap_scene_billiards(&stage_error, &params, &scene));
    return scene;
}

static struct ap_renderer *renderer_of(const struct stage *stage, const struct ap_scene *scene) {
    const char *texts[32];
    struct ap_text_atlas atlas = {0};
    for (size_t i = 0; i < scene->decal_count && i < 32; i++)
        texts[i] = scene->decals[i].text;
    STAGE_CHECK(
        ap_text_atlas_create(&stage_error, texts, (uint32_t)scene->decal_count, 96, &atlas));
    struct ap_renderer_params how = {
        .decals = atlas.coverage, .decal_px = atlas.cell_px, .decal_count = atlas.count};
    struct ap_renderer *renderer = stage_renderer(stage, scene, &how);
    ap_text_atlas_finish(&atlas);
    return renderer;
}

static void bench(struct stage *stage, const char *space, unsigned closed_eyes, int rounds) {
    struct ap_scene *scene = room(space);
    struct ap_renderer *renderer = renderer_of(stage, scene);
    static double cpu[2][ROUNDS_MAX], wall[2][ROUNDS_MAX];
    VkImage image = stage->target.image;
    struct ap_target target = {{image, image}, {0, 1}};
    for (int k = -2; k < rounds; k++) // the first ones compile
        for (int look = 0; look < 2; look++) {
            struct ap_frame_input input = stage_input(scene->space, AP_VIEW_NATIVE, 0.6, 0.064);
            for (int e = 0; e < 2; e++) {
                input.viewer.eye[e].frustum.left *= 16.0 / 9;
                input.viewer.eye[e].frustum.right *= 16.0 / 9;
            }
            struct ap_quat down = ap_quat_from_axis_angle((struct ap_vec3){1, 0, 0}, -0.6);
            struct ap_vec3 at = {0.002 * k, 0.5, 0.75};
            input.viewer.world_from_nose =
                ap_iso_from_pose(scene->space, (struct ap_pose){at, down});
            input.closed_eyes = closed_eyes;
            input.plain = look == 0;
            double from = cpu_ms();
            int64_t start = ap_clock_now_ns();
            STAGE_CHECK(ap_renderer_draw(&stage_error, renderer, &input, &target, NULL));
            vkDeviceWaitIdle(stage->gpu.device);
            if (k >= 0) {
                wall[look][k] = (double)(ap_clock_now_ns() - start) / 1e6;
                cpu[look][k] = cpu_ms() - from;
            }
        }
    double plain = median(cpu[0], rounds), made = median(cpu[1], rounds);
    printf("%s %s: plain %.1f ms of CPU, as it is %.1f, ratio %.2f; wall %.1f and %.1f ms\n", space,
           closed_eyes ? "one eye" : "two eyes", plain, made, made / plain, median(wall[0], rounds),
           median(wall[1], rounds));
    ap_renderer_destroy(renderer);
    ap_scene_destroy(scene);
}

int main(int argc, char **argv) {
    static const char *const SPACES[] = {"s3", "e3", "h3"};
    int rounds = argc > 1 ? atoi(argv[1]) : 15;
    struct stage stage;
    if (rounds < 1 || rounds > ROUNDS_MAX || !stage_open(&stage, 1280, 720, false))
        return 77;
    printf("%s, 1280x720\n", stage.gpu.properties.deviceName);
    for (int s = 0; s < 3; s++)
        for (unsigned closed = 0; closed < 2; closed++)
            bench(&stage, SPACES[s], closed, rounds);
    stage_close(&stage);
    return 0;
}
