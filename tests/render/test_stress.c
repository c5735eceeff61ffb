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
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "src/render/list.h"
#include "tests/render/stage.h"

static const double PI = 3.14159265358979323846;
static struct stage stage;
enum { PLACES = 14, KINDS = 3, PARTS = PLACES * KINDS };
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
    struct ap_gpu_draw *draws = calloc(list->count + 1, sizeof *draws);
    struct ap_gpu_marks *marks = calloc(1, sizeof *marks);
    struct ap_gpu_frame frame = ap_frame_of(&input->viewer);
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

int main(void) {
    if (!stage_open(&stage, 32, 32, false))
        return 77;
    const struct CMUnitTest tests[] = {cmocka_unit_test(buffers_stay_finite),
                                       cmocka_unit_test(a_lost_head_is_counted),
                                       cmocka_unit_test(spaces_agree_as_rho_grows)};
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    stage_close(&stage);
    return failed;
}
