#include <math.h>
#include <stdlib.h>
#include <time.h>

#include "src/app/bench/bench.h"

const struct ap_bench_view ap_bench_views[] = {
    {"billiards s3", NULL, "s3", {0, 0.5, 0.9}, -0.5},
    {"billiards e3", NULL, "e3", {0, 0.5, 0.9}, -0.5},
    {"billiards h3", NULL, "h3", {0, 0.5, 0.9}, -0.5},
    {"{5,3,4} struts", "honeycomb:5,3,4,struts", NULL, {0.1, 0.05, 0.2}, 0.2},
    {"{5,3,4} walls", "honeycomb:5,3,4,walls", NULL, {0.1, 0.05, 0.2}, 0.2},
    {"Seifert-Weber", "seifert-weber", NULL, {0.1, 0.05, 0.2}, 0.2},
    {"{4,3,4} struts", "honeycomb:4,3,4,struts,horizon=24", NULL, {0.1, 0.05, 0.2}, 0.2},
    {"{5,3,3} struts", "honeycomb:5,3,3,struts", NULL, {0.1, 0.05, 0.2}, 0.2},
};
const uint32_t ap_bench_sizes_px[2][2] = {{1080, 1200}, {320, 320}};
const int ap_bench_view_count = sizeof ap_bench_views / sizeof *ap_bench_views;

enum ap_status ap_bench_open_room(struct ap_error *err, const struct ap_bench_view *view,
                                  uint32_t width_px, struct ap_room *room) {
    struct ap_room_options options = AP_ROOM_OPTIONS_NONE;
    options.scene = view->scene;
    options.space = view->space;
    enum ap_status st = ap_room_open(err, &options, room);
    if (!st && width_px && room->scene->honeycomb)
        room->scene->honeycomb->horizon_px *= width_px / 320.0;
    return st;
}

struct ap_frame_input ap_bench_input(const struct ap_scene *scene, const struct ap_bench_view *view,
                                     uint32_t width, uint32_t height) {
    const double t = tan(50 * 3.14159265358979323846 / 180), up = t * height / width,
                 half_ipd_m = 0.032;
    const struct ap_quat pitch =
        ap_quat_from_axis_angle((struct ap_vec3){1, 0, 0}, view->pitch_rad);
    struct ap_frame_input input = {
        .viewer = {.space = scene->space,
                   .mode = AP_VIEW_NATIVE,
                   .world_from_nose =
                       ap_iso_from_pose(scene->space, (struct ap_pose){view->at_m, pitch})},
        .world_from_hand = {AP_ISO_IDENTITY, AP_ISO_IDENTITY}};
    for (int e = 0; e < 2; e++) {
        input.viewer.eye[e].view_from_eye = AP_POSE_IDENTITY;
        input.viewer.eye[e].view_from_eye.p.x = e == 0 ? -half_ipd_m : half_ipd_m;
        input.viewer.eye[e].frustum = (struct ap_frustum){-t, t, up, -up};
    }
    return input;
}

enum ap_status ap_bench_screen_open(struct ap_error *err, const struct ap_gpu *gpu, uint32_t width,
                                    uint32_t height, struct ap_bench_screen *screen) {
    *screen = (struct ap_bench_screen){.gpu = gpu, .width = width, .height = height};
    const VkImageCreateInfo info = {.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
                                    .imageType = VK_IMAGE_TYPE_2D,
                                    .format = VK_FORMAT_R8G8B8A8_SRGB,
                                    .extent = {width, height, 1},
                                    .mipLevels = 1,
                                    .arrayLayers = 2,
                                    .samples = VK_SAMPLE_COUNT_1_BIT,
                                    .usage = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT |
                                             VK_IMAGE_USAGE_TRANSFER_SRC_BIT};
    enum ap_status st = ap_gpu_image_create(err, gpu, &info, VK_IMAGE_VIEW_TYPE_2D_ARRAY,
                                            VK_IMAGE_ASPECT_COLOR_BIT, &screen->image);
    if (!st)
        st = ap_gpu_buffer_create(err, gpu, (VkDeviceSize)width * height * 8,
                                  VK_BUFFER_USAGE_TRANSFER_DST_BIT, true, &screen->pixels);
    if (st)
        ap_bench_screen_close(screen);
    return st;
}

void ap_bench_screen_close(struct ap_bench_screen *screen) {
    if (!screen->gpu)
        return;
    vkDeviceWaitIdle(screen->gpu->device);
    ap_gpu_image_destroy(screen->gpu, &screen->image);
    ap_gpu_buffer_destroy(screen->gpu, &screen->pixels);
    *screen = (struct ap_bench_screen){0};
}

static enum ap_status draw(struct ap_error *err, const struct ap_bench_case *c,
                           const struct ap_frame_input *input, struct ap_frame_stats *stats) {
    VkImage image = c->screen->image.image;
    const struct ap_target target = {{image, image}, {0, 1}};
    enum ap_status st = ap_renderer_draw(err, c->renderer, input, &target, stats);
    if (!st)
        st = ap_vk_check(err, vkDeviceWaitIdle(c->screen->gpu->device), "vkDeviceWaitIdle");
    return st;
}

enum ap_status ap_bench_picture(struct ap_error *err, const struct ap_bench_case *c) {
    const struct ap_bench_screen *s = c->screen;
    enum ap_status st = draw(err, c, &c->input, NULL);
    VkCommandBuffer cmd = VK_NULL_HANDLE;
    if (!st)
        st = ap_gpu_commands_begin(err, s->gpu, &cmd);
    if (st)
        return st;
    ap_gpu_barrier(cmd, s->image.image, VK_IMAGE_ASPECT_COLOR_BIT,
                   VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
    const VkBufferImageCopy copy = {.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 2},
                                    .imageExtent = {s->width, s->height, 1}};
    vkCmdCopyImageToBuffer(cmd, s->image.image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
                           s->pixels.buffer, 1, &copy);
    return ap_gpu_commands_end(err, s->gpu, cmd);
}

// --- the race

enum { PLACE, RECORD, GPU, CPU, MEASURES };

struct lane {
    double value[MEASURES][AP_BENCH_ROUNDS_MAX];
};

int64_t ap_bench_thread_ns(void) {
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return (int64_t)t.tv_sec * 1000000000 + t.tv_nsec;
}

static enum ap_status lap(struct ap_error *err, const struct ap_bench *bench,
                          struct ap_bench_case *c, int round, struct lane *lane) {
    struct ap_frame_input input = c->input;
    const struct ap_vec3 sway = {0.002 * sin(round), 0.001 * cos(round), 0};
    input.viewer.world_from_nose =
        ap_iso_mul(input.viewer.world_from_nose, ap_iso_translate(input.viewer.space, sway));
    double cpu = ap_bench_cpu_ms(), gpu = NAN;
    enum ap_status st = draw(err, c, &input, &c->stats);
    cpu = ap_bench_cpu_ms() - cpu;
    if (st || round < 0)
        return st;
    if (!ap_renderer_gpu_ms(c->renderer, &gpu))
        gpu = NAN;
    const double all[MEASURES] = {
        [PLACE] = c->stats.place_ms, [RECORD] = c->stats.record_ms, [GPU] = gpu, [CPU] = cpu};
    for (int m = 0; m < MEASURES; m++)
        lane->value[m][round] = all[m];
    c->round_ms[round] = bench->software ? cpu : gpu;
    return AP_OK;
}

enum ap_status ap_bench_race(struct ap_error *err, const struct ap_bench *bench,
                             struct ap_bench_case *cases, int count) {
    struct lane *lanes = calloc((size_t)count, sizeof *lanes);
    if (!lanes)
        return ap_fail(err, AP_ENVIRONMENT, "out of memory");
    enum ap_status st = AP_OK;
    for (int round = bench->quick ? -1 : -2; !st && round < bench->rounds; round++)
        for (int k = 0; !st && k < count; k++) {
            int i = round % 2 ? count - 1 - k : k;
            st = lap(err, bench, &cases[i], round, &lanes[i]);
        }
    for (int i = 0; !st && i < count; i++) {
        struct ap_spread *to[MEASURES] = {&cases[i].place_ms, &cases[i].record_ms, &cases[i].gpu_ms,
                                          &cases[i].cpu_ms};
        for (int m = 0; m < MEASURES; m++)
            *to[m] = ap_bench_spread(lanes[i].value[m], bench->rounds);
        cases[i].cost_ms = bench->software ? cases[i].cpu_ms : cases[i].gpu_ms;
    }
    free(lanes);
    return st;
}

struct ap_spread ap_bench_ratio(const struct ap_bench *bench, const struct ap_bench_case *a,
                                const struct ap_bench_case *b) {
    double ratio[AP_BENCH_ROUNDS_MAX];
    for (int i = 0; i < bench->rounds; i++)
        ratio[i] = a->round_ms[i] / b->round_ms[i];
    return ap_bench_spread(ratio, bench->rounds);
}

const char *ap_bench_cost_name(const struct ap_bench *bench) {
    return bench->software ? "CPU ms of all threads, two eyes" : "GPU ms, two eyes";
}
