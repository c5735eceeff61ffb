#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "tests/render/stage.h"

enum { SIZE = 128 };
#define EYE_BYTES ((size_t)SIZE * SIZE * 4)

static struct stage stage;

static struct ap_scene *named(const char *text) {
    struct ap_error err = {""};
    struct ap_scene *scene = NULL;
    const struct ap_scene_params none = {0};
    if (ap_scene_named(&err, text, &none, &scene))
        fail_msg("%s", err.text);
    return scene;
}

static bool is_blank(const uint8_t *pixels) {
    for (size_t i = 4; i < EYE_BYTES; i += 4)
        if (memcmp(pixels, pixels + i, 4) != 0)
            return false;
    return true;
}

// Somewhere in the cell, looking somewhere.
static struct ap_iso pose(const struct ap_scene *scene, int i) {
    double r = 0.6 * scene->honeycomb->tiling.inradius_m;
    struct ap_vec3 at = {r * sin(2.1 * i), r * sin(1.3 * i + 1) / 2, r * cos(2.1 * i) / 2};
    struct ap_vec3 axis = ap_vec3_normalize((struct ap_vec3){sin(0.7 * i), 1, 0.4});
    return ap_iso_mul(ap_iso_translate(scene->space, at),
                      ap_iso_rotate(ap_quat_from_axis_angle(axis, 1.9 * i)));
}

// Cells and parts of cells that no eye sees are left out, and the picture is the same to the bit.
static void leaving_cells_out_changes_no_pixel(void **state) {
    (void)state;
    static const char *const scenes[] = {"honeycomb:5,3,4,horizon=9",
                                         "honeycomb:4,3,5,struts,balls,horizon=9",
                                         "honeycomb:3,5,3,struts,horizon=12",
                                         "honeycomb:5,3,5,horizon=8",
                                         "honeycomb:4,3,4,balls,horizon=8",
                                         "honeycomb:5,3,3",
                                         "honeycomb:3,3,4,struts,balls",
                                         "honeycomb:3,4,3",
                                         "mirrored-dodecahedron,horizon=9",
                                         "poincare-dodecahedral,struts",
                                         "torus,struts,horizon=10",
                                         "seifert-weber,horizon=8",
                                         "honeycomb:5,3,4,horizon=9,width=0.6",
                                         "honeycomb:5,3,3,width=0.7"};
    for (size_t s = 0; s < sizeof scenes / sizeof *scenes; s++) {
        struct ap_scene *scene = named(scenes[s]);
        struct ap_renderer *culls = stage_renderer(&stage, scene, NULL);
        struct ap_renderer *draws_all =
            stage_renderer(&stage, scene, &(struct ap_renderer_params){.no_cull = true});
        uint32_t cells[2] = {0}, draws[2] = {0}, behind_walls = 0;
        for (int i = 0; i < 2; i++) {
            struct ap_frame_input input =
                stage_input(scene->space, i % 2 ? AP_VIEW_TOURIST : AP_VIEW_NATIVE, 0.6, 0.064);
            input.viewer.world_from_nose = pose(scene, (int)s + i);
            struct ap_frame_stats with = stage_draw(&stage, culls, &input);
            uint8_t *first = malloc(2 * EYE_BYTES);
            memcpy(first, stage_eye(&stage, 0), 2 * EYE_BYTES);
            struct ap_frame_stats without = stage_draw(&stage, draws_all, &input);
            size_t differ = 0;
            for (size_t p = 0; p < 2 * EYE_BYTES; p += 4)
                differ += memcmp(first + p, stage_eye(&stage, 0) + p, 4) != 0;
            // Loose cells are the same but for how they are turned, and so for the last digit.
            // Between walls of unlike fineness there is a gap, far below the bound, in which a
            // sample may now and then show what is behind them.
            size_t most = scene->honeycomb->pairing.loose ? 30
                          : strstr(scenes[s], "width=")   ? 3
                                                          : 0;
            if (differ > most || is_blank(first) || is_blank(first + EYE_BYTES))
                fail_msg("%s, frame %d: %zu pixels differ, or nothing is there", scenes[s], i,
                         differ);
            free(first);
            behind_walls += with.cells.walls;
            cells[0] += with.cells.visited;
            cells[1] += without.cells.visited;
            draws[0] += with.eye[0].draws;
            draws[1] += without.eye[0].draws;
        }
        print_message("%-36s cells %5u of %5u, parts %6u of %6u; behind walls %u\n", scenes[s],
                      cells[0], cells[1], draws[0], draws[1], behind_walls);
        // The wider the walls, the more is behind them.
        if (strstr(scenes[s], "width="))
            assert_true(behind_walls > 5);
        else if (!scene->honeycomb->has_walls)
            assert_int_equal(behind_walls, 0);
        assert_true(draws[0] < draws[1]);
        ap_renderer_destroy(culls);
        ap_renderer_destroy(draws_all);
        ap_scene_destroy(scene);
    }
}

// Going on to the next cell changes the frame of everything, and the picture hardly: the same pose
// told in either cell's frame.
static void crossing_a_face_is_not_seen(void **state) {
    (void)state;
    static const char *const scenes[] = {"honeycomb:5,3,4,horizon=9", "honeycomb:5,3,3,struts",
                                         "torus,horizon=4", "seifert-weber,struts,horizon=9"};
    for (size_t s = 0; s < sizeof scenes / sizeof *scenes; s++) {
        struct ap_scene *scene = named(scenes[s]);
        const struct ap_honeycomb *h = scene->honeycomb;
        struct ap_renderer *r = stage_renderer(&stage, scene, NULL);
        struct ap_frame_input input = stage_input(scene->space, AP_VIEW_NATIVE, 0.6, 0.064);
        struct ap_vec3 at = ap_vec3_scale(0.99 * h->tiling.inradius_m, h->tiling.face_out[0]);
        input.viewer.world_from_nose =
            ap_iso_mul(ap_iso_translate(scene->space, at), ap_iso_rotate_y(0.4));
        stage_draw(&stage, r, &input);
        uint8_t *first = malloc(2 * EYE_BYTES);
        memcpy(first, stage_eye(&stage, 0), 2 * EYE_BYTES);
        input.viewer.world_from_nose = ap_iso_mul(h->pairing.cell_from_neighbour[h->pairing.to[0]],
                                                  input.viewer.world_from_nose);
        stage_draw(&stage, r, &input);
        size_t differ = 0;
        for (size_t p = 0; p < 2 * EYE_BYTES; p++)
            differ += abs(first[p] - stage_eye(&stage, 0)[p]) > 24;
        if (differ > EYE_BYTES / 500)
            fail_msg("%s: %zu of %zu bytes differ by more than 24", scenes[s], differ,
                     2 * EYE_BYTES);
        free(first);
        ap_renderer_destroy(r);
        ap_scene_destroy(scene);
    }
}

// Light is as the surface is, not as the facets are: with other levels of detail, and as a tourist
// from the same place where both eyes are at the nose, only outlines differ.
static void light_does_not_know_the_level(void **state) {
    (void)state;
    static const char *const scenes[] = {"honeycomb:3,3,4", "honeycomb:5,3,4,width=0.7,horizon=60",
                                         "torus,balls,horizon=60"};
    for (size_t s = 0; s < sizeof scenes / sizeof *scenes; s++) {
        struct ap_scene *scene = named(scenes[s]);
        uint8_t *first = malloc(2 * EYE_BYTES);
        size_t differ[2] = {0};
        for (int i = 0; i < 3; i++) {
            const struct ap_renderer_params params = {.max_error_px = i == 0 ? 0.1 : 1};
            struct ap_renderer *r = stage_renderer(&stage, scene, &params);
            struct ap_frame_input input =
                stage_input(scene->space, i == 2 ? AP_VIEW_TOURIST : AP_VIEW_NATIVE, 0.6, 0);
            input.viewer.world_from_nose = pose(scene, 3);
            stage_draw(&stage, r, &input);
            const uint8_t *now = stage_eye(&stage, 0);
            if (i == 0)
                memcpy(first, now, 2 * EYE_BYTES);
            for (size_t p = 0; p < 2 * EYE_BYTES && i > 0; p++)
                differ[i - 1] += abs(first[p] - now[p]) > 8;
            ap_renderer_destroy(r);
        }
        print_message("%-36s differ by more than 8: 0.1 px and 1 px %zu, tourist %zu of %zu\n",
                      scenes[s], differ[0], differ[1], 2 * EYE_BYTES);
        size_t most = 2 * EYE_BYTES / 100;
        if (is_blank(first) || differ[0] > most || differ[1] > most)
            fail_msg("%s: more than %zu of %zu bytes differ", scenes[s], most, 2 * EYE_BYTES);
        free(first);
        ap_scene_destroy(scene);
    }
}

static int open_stage(void **state) {
    (void)state;
    return stage_open(&stage, SIZE, SIZE, false) ? 0 : 77;
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(leaving_cells_out_changes_no_pixel),
                                       cmocka_unit_test(crossing_a_face_is_not_seen),
                                       cmocka_unit_test(light_does_not_know_the_level)};
    void *none = NULL;
    if (open_stage(&none) != 0)
        return 77;
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    stage_close(&stage);
    return failed;
}
