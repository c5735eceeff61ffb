// Hostile places: what reaches the GPU's buffers must be finite numbers whatever is where, and what
// has left the domain must be counted. Objects on the nose, on an eye, denormally near it, behind,
// at and about s3's antipode, at 80 rho in h3; radii of the space from 1e-3 to 1e9 m; a head that
// turns by 1e6 rad/s; all views. Then the three spaces against one another as rho grows.
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <glob.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "src/device/poselog.h"
#include "src/render/list.h"
#include "src/render/logmap/logmap_float.h"
#include "tests/render/stage.h"

static const double PI = 3.14159265358979323846;
static struct stage stage;
enum { PLACES = 14, KINDS = 3, PARTS = PLACES * KINDS, RECORDED_PARTS = 2 * KINDS };
static const uint8_t WHITE[3] = {255, 255, 255};

static void place_parts(struct ap_space space, struct ap_part parts[PARTS]) {
    double rho = space.rho_m, antipode = PI * rho;
    const struct ap_vec3 at[PLACES] = {{0, 0, 0},
                                       {0, 0, -1e-12 * rho},
                                       {5e-324, 0, 0},
                                       {0.032, 0, 0},
                                       {-0.032, 1e-18, 1e-300},
                                       {0, 0, -0.3 * rho},
                                       {0, 0, 0.3 * rho},
                                       {0, 0, -antipode},
                                       {0, 0, -antipode * (1 - 1e-12)},
                                       {0, 0, antipode * (1 - 1e-5)},
                                       {0.5 * antipode, 0, 0},
                                       {0, 0, -80 * rho},
                                       {0, -60 * rho, -1},
                                       {0, 0, -700 * rho}};
    for (int i = 0; i < PARTS; i++) {
        parts[i] = stage_ball(space, at[i / KINDS], 0.02 * rho, WHITE);
        parts[i].lit = i % 2;
        if (i % KINDS == 1) {
            parts[i].kind = AP_PART_STICK;
            parts[i].radius2_m = 0.01 * rho;
            parts[i].length_m = 0.4 * rho;
        } else if (i % KINDS == 2) {
            parts[i].kind = AP_PART_POLYGON;
            parts[i].sides = 5;
            parts[i].edge_m = 0.3 * rho;
        }
    }
}

static int unfinite(const void *from, size_t bytes) {
    const float *f = from;
    int n = 0;
    for (size_t i = 0; i < bytes / sizeof *f; i++)
        n += !isfinite(f[i]);
    return n;
}

static struct ap_frame_stats check_frame(const struct ap_scene *scene,
                                         const struct ap_meshes *meshes, struct ap_draw_list *list,
                                         const struct ap_frame_input *input) {
    struct ap_eyes eyes = ap_eyes_of(&input->viewer, 200, 200);
    const struct ap_list_params params = {.scene = scene,
                                          .meshes = meshes,
                                          .input = input,
                                          .eyes = &eyes,
                                          .width_px = 200,
                                          .height_px = 200,
                                          .max_error_px = 2};
    STAGE_CHECK(ap_draw_list_fill(&stage_error, &params, list));
    ap_draw_list_sort(list);
    struct ap_gpu_draw *draws = calloc(list->count + 1, sizeof *draws);
    struct ap_gpu_marks *marks = calloc(1, sizeof *marks);
    struct ap_gpu_frame frame = ap_frame_of(&input->viewer, false);
    ap_frame_depth(&input->viewer, &eyes, &list->range, &frame);
    ap_draw_list_write(scene, input, &eyes, list, draws, marks);
    int bad[3] = {unfinite(draws, list->count * sizeof *draws),
                  unfinite(list->refined.vertices,
                           list->refined.vertex_count * sizeof *list->refined.vertices),
                  unfinite(frame.view, sizeof frame.view) +
                      unfinite(frame.depth, sizeof frame.depth)};
    if (bad[0] + bad[1] + bad[2] > 0)
        fail_msg("%s, rho %g, mode %d: %d numbers of draws, %d of vertices and %d of the frame are "
                 "not finite, expected none",
                 ap_space_name(scene->space), scene->space.rho_m, (int)input->viewer.mode, bad[0],
                 bad[1], bad[2]);
    free(draws);
    free(marks);
    return list->stats;
}

static void buffers_stay_finite(void **state) {
    (void)state;
    static const double RADII[] = {1e-3, 0.7, 40, 1e9};
    uint32_t left = 0, drawn = 0;
    for (int kappa = -1; kappa <= 1; kappa++)
        for (int r = 0; r < 4; r++) {
            struct ap_part parts[PARTS];
            struct ap_space space = {kappa, RADII[r]};
            place_parts(space, parts);
            struct ap_scene scene = stage_scene(space, parts, PARTS);
            struct ap_meshes meshes;
            struct ap_draw_list list;
            STAGE_CHECK(ap_meshes_create(&stage_error, &stage.gpu, &scene, &meshes));
            STAGE_CHECK(ap_draw_list_create(&stage_error, PARTS, &list));
            for (int i = 0; i < 9; i++) {
                enum ap_view_mode mode = (enum ap_view_mode)(i % 3);
                struct ap_frame_input input = stage_input(space, mode, 0.8, 0.064);
                input.viewer.born = (struct ap_space){kappa == 0 ? 1 : -kappa, RADII[r]};
                // 1e6 rad/s, a ninetieth of a second a frame.
                input.viewer.world_from_nose = ap_iso_rotate_y(i / 3 * 1e6 / 90);
                struct ap_frame_stats stats = check_frame(&scene, &meshes, &list, &input);
                left += stats.out_of_domain;
                drawn += stats.eye[0].draws + stats.eye[1].draws;
            }
            ap_draw_list_destroy(&list);
            ap_meshes_destroy(&stage.gpu, &meshes);
        }
    printf("%u parts drawn, %u out of domain\n", drawn, left);
    assert_true(drawn > 1000);
    assert_true(left > 0);
}

// A head that is nowhere draws nothing.
static void a_lost_head_is_counted(void **state) {
    (void)state;
    struct ap_part parts[PARTS];
    struct ap_space space = {-1, 1};
    place_parts(space, parts);
    struct ap_scene scene = stage_scene(space, parts, PARTS);
    struct ap_meshes meshes;
    struct ap_draw_list list;
    STAGE_CHECK(ap_meshes_create(&stage_error, &stage.gpu, &scene, &meshes));
    STAGE_CHECK(ap_draw_list_create(&stage_error, PARTS, &list));
    struct ap_frame_input input = stage_input(space, AP_VIEW_NATIVE, 0.8, 0.064);
    input.viewer.world_from_nose.m[0][3] = NAN;
    struct ap_eyes eyes = ap_eyes_of(&input.viewer, 200, 200);
    const struct ap_list_params params = {.scene = &scene,
                                          .meshes = &meshes,
                                          .input = &input,
                                          .eyes = &eyes,
                                          .width_px = 200,
                                          .height_px = 200,
                                          .max_error_px = 2};
    STAGE_CHECK(ap_draw_list_fill(&stage_error, &params, &list));
    assert_int_equal(list.count, 0);
    assert_int_equal(list.stats.out_of_domain, PARTS);
    ap_draw_list_destroy(&list);
    ap_meshes_destroy(&stage.gpu, &meshes);
}

// Curvature is 1/rho²: within reach, directions differ from flat ones by that much and no more.
static void spaces_agree_as_rho_grows(void **state) {
    (void)state;
    static const struct ap_vec3 POINTS[] = {{0.3, 0.2, -1}, {-0.8, 0.5, -2}, {0.01, -0.02, -0.3}};
    for (int mode = 0; mode < 2; mode++)
        for (double rho = 10; rho < 2e9; rho *= 10) {
            double worst = 0;
            for (int kappa = -1; kappa <= 1; kappa += 2)
                for (int k = 0; k < 6; k++) {
                    struct ap_vec3 v = POINTS[k / 2];
                    double a[2], b[2];
                    for (int curved = 0; curved < 2; curved++) {
                        struct ap_space space = {curved ? kappa : 0, rho};
                        struct ap_frame_input input =
                            stage_input(space, (enum ap_view_mode)mode, 0.8, 0.064);
                        assert_true(ap_direction(&input.viewer, k % 2, ap_exp(space, v), 0,
                                                 &a[curved], &b[curved]));
                    }
                    worst = fmax(worst, hypot(a[1] - a[0], b[1] - b[0]));
                }
            // exp and log in double are good to a few units of the last place.
            double allowed = 0.5 / (rho * rho) + 4e-15;
            if (!(worst <= allowed))
                fail_msg("mode %d, rho %g: directions differ by %g, allowed %g", mode, rho, worst,
                         allowed);
        }
}

// What the shader makes of the numbers that it gets, against the vector that each thing was put at:
// matrices by way of exp and a product in double, rounded once, and the log map in float32.
enum { RANGE = 10 };

static void check_images(const struct ap_scene *scene, const struct ap_meshes *meshes,
                         struct ap_draw_list *list, const struct ap_frame_input *input,
                         const struct ap_vec3 at[RANGE], double worst[2]) {
    struct ap_eyes eyes = ap_eyes_of(&input->viewer, 200, 200);
    const struct ap_list_params params = {.scene = scene,
                                          .meshes = meshes,
                                          .input = input,
                                          .eyes = &eyes,
                                          .width_px = 200,
                                          .height_px = 200,
                                          .max_error_px = 2,
                                          .no_cull = true};
    static struct ap_gpu_draw draws[4 * RANGE];
    static struct ap_gpu_marks marks;
    double rho = scene->space.rho_m;
    STAGE_CHECK(ap_draw_list_fill(&stage_error, &params, list));
    assert_int_equal(list->count, scene->space.kappa > 0 ? 2 * RANGE : RANGE);
    ap_draw_list_sort(list);
    ap_draw_list_write(scene, input, &eyes, list, draws, &marks);
    struct ap_iso nose_from_world = ap_iso_inverse(scene->space, input->viewer.world_from_nose);
    for (size_t i = 0; i < list->count; i++) {
        const struct ap_draw_item *item = list->order[i];
        struct ap_vec3 v = at[item->part];
        struct ap_vec4 turned = ap_iso_apply(&nose_from_world, (struct ap_vec4){v.x, v.y, v.z, 0});
        struct ap_vec3 is = {turned.x, turned.y, turned.z};
        double d = ap_vec3_length(is);
        if (item->image == 1)
            is = ap_vec3_scale(1 - 2 * PI * rho / d, is);
        float tangent[3];
        ap_logmap_float(scene->space.kappa, item->image, &draws[i].to[0][12], tangent);
        struct ap_vec3 seen = {rho * (double)tangent[0], rho * (double)tangent[1],
                               rho * (double)tangent[2]};
        double length = ap_vec3_length(is), sees = ap_vec3_length(seen);
        struct ap_vec3 off =
            ap_vec3_sub(ap_vec3_scale(1 / sees, seen), ap_vec3_scale(1 / length, is));
        double by[2] = {fabs(sees / length - 1), ap_vec3_length(off)};
        for (int k = 0; k < 2; k++)
            worst[k] = by[k] <= worst[k] ? worst[k] : by[k];
    }
}

static void near_and_far_things_are_where_they_are(void **state) {
    (void)state;
    // Beyond 60 rho of h3 nothing is drawn: it would be smaller than 1e-20 of a pixel.
    static const double H3[RANGE] = {1e-12, 1e-8, 1e-5, 1e-3, 0.1, 1, 3, 12, 40, 59.9};
    static const double S3[RANGE] = {1e-12, 1e-8, 1e-5, 1e-3, 0.1, 1, 1.5707963, 3, 3.14, 3.14158};
    for (int kappa = -1; kappa <= 1; kappa++)
        for (int big = 0; big < 2; big++) {
            struct ap_space space = {kappa, big ? 1e9 : 1e-3};
            struct ap_part parts[RANGE];
            struct ap_vec3 at[RANGE];
            double worst[2] = {0};
            for (int turn = 0; turn < 12; turn++) {
                for (int i = 0; i < RANGE; i++) {
                    double d = (kappa > 0 ? S3 : H3)[i] * space.rho_m, a = 1.3 * i + turn;
                    at[i] = (struct ap_vec3){d * sin(a) * 0.8, d * 0.6, d * cos(a) * 0.8};
                    parts[i] = stage_ball(space, at[i], 1e-3 * space.rho_m, WHITE);
                    parts[i].lit = true; // else a disc, which is made otherwise
                }
                struct ap_scene scene = stage_scene(space, parts, RANGE);
                struct ap_meshes meshes;
                struct ap_draw_list list;
                STAGE_CHECK(ap_meshes_create(&stage_error, &stage.gpu, &scene, &meshes));
                STAGE_CHECK(ap_draw_list_create(&stage_error, RANGE, &list));
                struct ap_frame_input input = stage_input(space, AP_VIEW_NATIVE, 0.8, 0.064);
                // A head that turns by 1e6 rad/s, a ninetieth of a second a frame.
                input.viewer.world_from_nose = ap_iso_rotate_y(turn * 1e6 / 90);
                check_images(&scene, &meshes, &list, &input, at, worst);
                ap_draw_list_destroy(&list);
                ap_meshes_destroy(&stage.gpu, &meshes);
            }
            printf("%s, rho %g: distances off by %.2g of themselves, directions by %.2g rad\n",
                   ap_space_name(space), space.rho_m, worst[0], worst[1]);
            // 4e-7 is the log map's; sums of three squares' roundings in the direction.
            if (!(worst[0] < 4e-7 && worst[1] < 1.5e-7))
                fail_msg("more than 4e-7 or 1.5e-7");
        }
}

// Poses of a recording of real devices, in each space in turn, placed and culled: one of
// `every`, or all that there are (test_stress all).
static long every = 200;

static long place_recording(const char *path) {
    struct ap_part parts[PARTS];
    struct ap_poselog *log = NULL;
    struct ap_sample sample;
    long poses = 0;
    uint32_t placed = 0;
    bool got = true;
    const struct ap_poselog_params params = {.sources = &path, .source_count = 1, .skip_bad = true};
    STAGE_CHECK(ap_poselog_open(&stage_error, &params, &log));
    struct ap_space space[3];
    struct ap_scene scene[3];
    struct ap_meshes meshes[3];
    struct ap_draw_list list[3];
    static struct ap_part all[3][PARTS];
    for (int i = 0; i < 3; i++) {
        space[i] = (struct ap_space){i - 1, 0.85};
        place_parts(space[i], parts);
        for (int k = 0; k < RECORDED_PARTS; k++)
            all[i][k] = parts[KINDS * 3 + k];
        scene[i] = stage_scene(space[i], all[i], RECORDED_PARTS);
        STAGE_CHECK(ap_meshes_create(&stage_error, &stage.gpu, &scene[i], &meshes[i]));
        STAGE_CHECK(ap_draw_list_create(&stage_error, RECORDED_PARTS, &list[i]));
    }
    for (;;) {
        STAGE_CHECK(ap_poselog_next(&stage_error, log, &sample, &got));
        if (!got)
            break;
        if (poses++ % every != 0)
            continue;
        int i = (int)(poses / every % 3);
        struct ap_frame_input input =
            stage_input(space[i], (enum ap_view_mode)(poses / every / 3 % 2), 0.8, 0.064);
        input.viewer.world_from_nose =
            ap_iso_mul(ap_iso_translate(space[i], sample.pose.p), ap_iso_rotate(sample.pose.q));
        struct ap_frame_stats stats = check_frame(&scene[i], &meshes[i], &list[i], &input);
        assert_int_equal(stats.out_of_domain, 0);
        placed += stats.eye[0].draws + stats.eye[0].culled;
    }
    assert_true(placed > 0);
    for (int i = 0; i < 3; i++) {
        ap_draw_list_destroy(&list[i]);
        ap_meshes_destroy(&stage.gpu, &meshes[i]);
    }
    ap_poselog_close(log);
    return poses;
}

static void recorded_poses_are_placed(void **state) {
    (void)state;
    const char *shared = getenv("ANTIPODE_SHARED");
    if (!shared) {
        print_message("skipped: ANTIPODE_SHARED is not set\n");
        skip();
    }
    char pattern[4096];
    glob_t files;
    long poses = 0;
    snprintf(pattern, sizeof pattern, "%s/data/poses/*", shared);
    assert_int_equal(glob(pattern, 0, NULL, &files), 0);
    for (size_t i = 0; i < files.gl_pathc; i++) {
        long n = strstr(files.gl_pathv[i], ".md") ? 0 : place_recording(files.gl_pathv[i]);
        printf("%s: %ld poses\n", strrchr(files.gl_pathv[i], '/') + 1, n);
        poses += n;
    }
    globfree(&files);
    assert_true(poses > 1000);
}

int main(int argc, char **argv) {
    if (argc > 1 && strcmp(argv[1], "all") == 0)
        every = 1;
    if (!stage_open(&stage, 32, 32, false))
        return 77;
    const struct CMUnitTest tests[] = {cmocka_unit_test(buffers_stay_finite),
                                       cmocka_unit_test(a_lost_head_is_counted),
                                       cmocka_unit_test(spaces_agree_as_rho_grows),
                                       cmocka_unit_test(near_and_far_things_are_where_they_are),
                                       cmocka_unit_test(recorded_poses_are_placed)};
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    stage_close(&stage);
    return failed;
}
