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
            // Loose cells are the same but for how they are turned, and so for the last digit and
            // the way in which round pieces are divided.
            size_t most = scene->honeycomb->pairing.loose ? 40 : 0;
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
        if (differ > EYE_BYTES / 1000)
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

static double linear_of(int code) {
    double c = code / 255.0;
    return c <= 0.04045 ? c / 12.92 : pow((c + 0.055) / 1.055, 2.4);
}

static double code_of(double linear) {
    return 255 * (linear <= 0.0031308 ? 12.92 * linear : 1.055 * pow(linear, 1 / 2.4) - 0.055);
}

static uint8_t *drawn_by(struct ap_scene *scene, const struct ap_renderer_params *params) {
    struct ap_renderer *r = stage_renderer(&stage, scene, params);
    struct ap_frame_input input = stage_input(scene->space, AP_VIEW_NATIVE, 0.6, 0.064);
    input.viewer.world_from_nose = pose(scene, 5);
    stage_draw(&stage, r, &input);
    size_t bytes = (size_t)8 * stage.width * stage.height;
    uint8_t *copy = malloc(bytes);
    memcpy(copy, stage_eye(&stage, 0), bytes);
    ap_renderer_destroy(r);
    return copy;
}

// A byte of the mean of four pixels in linear light, from a picture twice as wide and high.
static double mean_of(const uint8_t *larger, size_t i) {
    size_t k = i % 4, x = i / 4 % SIZE, y = i / 4 / SIZE; // of both eyes, one above the other
    double sum = 0;
    for (int n = 0; n < 4; n++)
        sum += linear_of(larger[((2 * y + n / 2) * 2 * SIZE + 2 * x + n % 2) * 4 + k]);
    return code_of(sum / 4);
}

// Worlds of cells are drawn and averaged as codes that the shaders make and read themselves: the
// same as if the device encoded a picture of twice the size, and its pixels were averaged in
// double.
static void codes_are_linear_light(void **state) {
    (void)state;
    static const char *const scenes[] = {"honeycomb:5,3,4,walls,horizon=9",
                                         "honeycomb:4,3,5,struts,balls,horizon=9",
                                         "poincare-dodecahedral", "torus,struts,horizon=10"};
    for (size_t s = 0; s < sizeof scenes / sizeof *scenes; s++) {
        struct ap_scene *scene = named(scenes[s]);
        uint8_t *codes = drawn_by(scene, &(struct ap_renderer_params){.max_error_px = 0.25});
        stage_resize(&stage, 2 * SIZE, 2 * SIZE);
        scene->honeycomb->horizon_px *= 2;
        uint8_t *larger =
            drawn_by(scene, &(struct ap_renderer_params){.max_error_px = 0.5, .samples = 1});
        stage_resize(&stage, SIZE, SIZE);
        size_t unlike = 0;
        double most = 0;
        for (size_t i = 0; i < 2 * EYE_BYTES; i++) {
            double off = i % 4 == 3 ? 0 : fabs(codes[i] - mean_of(larger, i));
            most = fmax(most, off);
            unlike += off > 1;
        }
        print_message("%-40s off by %.2f of 255 at most (1.5 allowed), more than 1: %zu of %zu\n",
                      scenes[s], most, unlike, 2 * EYE_BYTES);
        if (is_blank(codes) || most > 1.5 || unlike > EYE_BYTES / 100)
            fail_msg("%s: off by %.2f, %zu by more than 1", scenes[s], most, unlike);
        free(codes);
        free(larger);
        ap_scene_destroy(scene);
    }
}

// A world of nothing but its background: every byte comes back as it was given.
static void codes_are_written_as_given(void **state) {
    (void)state;
    struct ap_scene *scene = named("honeycomb:5,3,4,walls,horizon=9");
    for (size_t i = 0; i < scene->part_count; i++)
        scene->parts[i].hidden = true;
    struct ap_renderer *r = stage_renderer(&stage, scene, NULL);
    const struct ap_frame_input input = stage_input(scene->space, AP_VIEW_NATIVE, 0.6, 0.064);
    for (int v = 0; v < 256; v++) {
        const uint8_t want[3] = {(uint8_t)v, (uint8_t)(255 - v), (uint8_t)(v ^ 85)};
        for (int k = 0; k < 3; k++)
            scene->background_srgb[k] = want[k] / 255.0;
        stage_draw(&stage, r, &input);
        const uint8_t *at = stage_eye(&stage, v % 2) + 4 * v;
        if (memcmp(at, want, 3) != 0)
            fail_msg("background %d %d %d, expected %d %d %d", at[0], at[1], at[2], want[0],
                     want[1], want[2]);
    }
    ap_renderer_destroy(r);
    ap_scene_destroy(scene);
}

static int open_stage(void **state) {
    (void)state;
    return stage_open(&stage, SIZE, SIZE, false) ? 0 : 77;
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(leaving_cells_out_changes_no_pixel),
                                       cmocka_unit_test(crossing_a_face_is_not_seen),
                                       cmocka_unit_test(light_does_not_know_the_level),
                                       cmocka_unit_test(codes_are_linear_light),
                                       cmocka_unit_test(codes_are_written_as_given)};
    void *none = NULL;
    if (open_stage(&none) != 0)
        return 77;
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    stage_close(&stage);
    return failed;
}
