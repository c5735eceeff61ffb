// What a frame of a scene costs, in processor time of all threads a megapixel drawn, and where it
// goes: bench_cells [ROUNDS [WIDTH HEIGHT [SCENE…]]]. Every scene has its turn in every round: with
// one eye open, and with both. "1:" or "4:" before a scene's name: with so many samples a pixel.
// Medians, with the quarters above and below; the ratio of two eyes to one is of the rounds' own
// ratios.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "tests/render/stage.h"

enum { ROUNDS_MAX = 400, SCENES_MAX = 24 };

static double cpu_ms(void) {
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec * 1e3 + (double)t.tv_nsec / 1e6;
}

// Of the renderer's own thread, which places and records.
static int64_t thread_ns(void) {
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return (int64_t)t.tv_sec * 1000000000 + t.tv_nsec;
}

static int compare(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return x < y ? -1 : x > y;
}

// Sorts.
static double quantile(double *v, int n, double share) {
    qsort(v, (size_t)n, sizeof *v, compare);
    return v[(int)(share * (n - 1) + 0.5)];
}

struct contender {
    const char *name;
    struct ap_scene *scene;
    struct ap_renderer *renderer;
    struct ap_frame_stats stats;
    double one[ROUNDS_MAX], two[ROUNDS_MAX], ratio[ROUNDS_MAX], place[ROUNDS_MAX];
};

static struct ap_scene *scene_named(const char *name) {
    struct ap_scene *scene;
    struct ap_scene_params params = {0};
    name += name[0] && name[1] == ':' ? 2 : 0;
    if (strncmp(name, "room:", 5) == 0) {
        params.space_name = name + 5;
        STAGE_CHECK(ap_scene_billiards(&stage_error, &params, &scene));
    } else {
        STAGE_CHECK(ap_scene_named(&stage_error, name, &params, &scene));
    }
    return scene;
}

// A slow walk and turn through the middle of the cell, or at the table.
static struct ap_iso pose(const struct ap_scene *scene, int k) {
    if (!scene->honeycomb) {
        struct ap_quat down = ap_quat_from_axis_angle((struct ap_vec3){1, 0, 0}, -0.6);
        return ap_iso_from_pose(scene->space, (struct ap_pose){{0.002 * k, 0.5, 0.75}, down});
    }
    double r = 0.3 * scene->honeycomb->tiling.inradius_m;
    struct ap_vec3 at = {r * sin(0.3 * k), r * cos(0.2 * k), r * sin(0.5 * k)};
    struct ap_vec3 axis = ap_vec3_normalize((struct ap_vec3){0.3, 1, 0.2});
    return ap_iso_mul(ap_iso_translate(scene->space, at),
                      ap_iso_rotate(ap_quat_from_axis_angle(axis, 0.7 * k)));
}

static double draw(const struct stage *stage, struct contender *c, unsigned closed, int k) {
    VkImage image = stage->target.image;
    struct ap_target target = {{image, image}, {0, 1}};
    struct ap_frame_input input = stage_input(c->scene->space, AP_VIEW_NATIVE, 0.7854, 0.064);
    for (int e = 0; e < 2; e++) {
        input.viewer.eye[e].frustum.left *= (double)stage->width / stage->height;
        input.viewer.eye[e].frustum.right *= (double)stage->width / stage->height;
    }
    input.viewer.world_from_nose = pose(c->scene, k);
    input.closed_eyes = closed;
    double from = cpu_ms();
    STAGE_CHECK(ap_renderer_draw(&stage_error, c->renderer, &input, &target, &c->stats));
    vkDeviceWaitIdle(stage->gpu.device);
    return cpu_ms() - from;
}

static void report(struct contender *c, int rounds, double megapixels) {
    double low = quantile(c->one, rounds, 0.25), one = quantile(c->one, rounds, 0.5),
           high = quantile(c->one, rounds, 0.75);
    printf("%s: one eye %.2f ms (%.2f to %.2f), %.0f a megapixel; two %.2f, ratio %.2f; placing "
           "%.2f; %u cells, %u parts, %llu triangles\n",
           c->name, one, low, high, one / megapixels, quantile(c->two, rounds, 0.5),
           quantile(c->ratio, rounds, 0.5), quantile(c->place, rounds, 0.5), c->stats.cells.visited,
           c->stats.eye[0].draws, (unsigned long long)c->stats.eye[0].triangles);
}

int main(int argc, char **argv) {
    static const char *const SCENES[] = {"honeycomb:5,3,4", "honeycomb:5,3,4,struts",
                                         "seifert-weber",   "honeycomb:4,3,4",
                                         "honeycomb:5,3,3", "room:h3",
                                         "room:e3",         "room:s3"};
    int rounds = argc > 1 ? atoi(argv[1]) : 15, count = argc > 4 ? argc - 4 : 8;
    uint32_t width = argc > 3 ? (uint32_t)atoi(argv[2]) : 320,
             height = argc > 3 ? (uint32_t)atoi(argv[3]) : 320;
    static struct contender contender[SCENES_MAX];
    struct stage stage;
    if (rounds < 1 || rounds > ROUNDS_MAX || count > SCENES_MAX ||
        !stage_open(&stage, width, height, false))
        return 77;
    for (int i = 0; i < count; i++) {
        contender[i].name = argc > 4 ? argv[4 + i] : SCENES[i];
        contender[i].scene = scene_named(contender[i].name);
        bool one = strncmp(contender[i].name, "1:", 2) == 0,
             four = strncmp(contender[i].name, "4:", 2) == 0;
        struct ap_renderer_params params = {.now_ns = thread_ns, .samples = one ? 1 : four ? 4 : 0};
        contender[i].renderer = stage_renderer(&stage, contender[i].scene, &params);
    }
    for (int k = -2; k < rounds; k++) // the first ones compile
        for (int i = 0; i < count; i++) {
            struct contender *c = &contender[i];
            double two = draw(&stage, c, 0, k), one = draw(&stage, c, 2, k);
            if (k < 0)
                continue;
            c->one[k] = one;
            c->two[k] = two;
            c->ratio[k] = two / one;
            c->place[k] = c->stats.place_ms;
        }
    printf("%s, %ux%u\n", stage.gpu.properties.deviceName, width, height);
    for (int i = 0; i < count; i++) {
        report(&contender[i], rounds, width * height * 1e-6);
        ap_renderer_destroy(contender[i].renderer);
        ap_scene_destroy(contender[i].scene);
    }
    stage_close(&stage);
    return 0;
}
