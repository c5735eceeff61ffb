// What a picture must be, whatever is in it: exact colours, the same by two ways of drawing,
// nothing within the forbidden millimetre, no work for what cannot be seen.
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/render/stage.h"

static struct stage stage;
enum { SIZE = 256 };
static const size_t EYE_BYTES = (size_t)SIZE * SIZE * 4;
static const double PI = 3.14159265358979323846;
static const uint8_t RED[3] = {200, 30, 40}, GREEN[3] = {20, 220, 60};

static const struct ap_space SPACES[3] = {{1, 0.7}, {0, 1}, {-1, 0.8}};

// Pixels of eye that are not the background's.
static int drawn(int eye) {
    const uint8_t *p = stage_eye(&stage, eye);
    int n = 0;
    for (int i = 0; i < SIZE * SIZE; i++)
        n += p[4 * i] != 0 || p[4 * i + 1] != 0 || p[4 * i + 2] != 0;
    return n;
}

static struct ap_frame_stats draw_once(struct ap_scene *scene, const struct ap_frame_input *input,
                                       const struct ap_renderer_params *params) {
    struct ap_renderer *renderer = stage_renderer(&stage, scene, params);
    struct ap_frame_stats stats = stage_draw(&stage, renderer, input);
    ap_renderer_destroy(renderer);
    return stats;
}

// Two balls, whose place, size and colour may change between frames, and the space with them: one
// renderer for most tests, since a software device takes long to compile its shaders.
static struct ap_part balls[2];
static struct ap_scene balls_scene;
static struct ap_renderer *balls_renderer;

static struct ap_frame_stats draw_balls(const struct ap_frame_input *input, int count) {
    balls_scene.space = input->viewer.space;
    balls_scene.lamp = (struct ap_vec4){0, 0, 0, input->viewer.space.rho_m};
    balls[1].hidden = count < 2;
    return stage_draw(&stage, balls_renderer, input);
}

static uint8_t *copy_picture(void) {
    uint8_t *copy = malloc(2 * EYE_BYTES);
    assert_non_null(copy);
    memcpy(copy, stage_eye(&stage, 0), 2 * EYE_BYTES);
    return copy;
}

// A bit of everything, some of it beside and behind the viewer.
enum { MIXED = 40 };
static void mixed_parts(struct ap_space space, struct ap_part parts[MIXED], bool in_front) {
    uint64_t seed = 3;
    for (int i = 0; i < MIXED; i++) {
        double v[6];
        for (int k = 0; k < 6; k++) {
            seed = seed * 6364136223846793005u + 1442695040888963407u;
            v[k] = (double)(seed >> 11) / 9007199254740992.0 * 2 - 1;
        }
        double d = in_front ? 0.6 + 0.3 * v[0] : 0.7 + 0.6 * v[0];
        struct ap_vec3 at = ap_vec3_scale(
            d, ap_vec3_normalize(in_front ? (struct ap_vec3){0.3 * v[1], 0.3 * v[2], -1}
                                          : (struct ap_vec3){v[1], v[2], v[3]}));
        uint8_t color[3] = {(uint8_t)(128 + 120 * v[3]), (uint8_t)(128 + 120 * v[4]),
                            (uint8_t)(128 + 120 * v[5])};
        parts[i] = stage_ball(space, at, in_front ? 0.03 : 0.08, color);
        parts[i].carrier_from_part =
            ap_iso_mul(parts[i].carrier_from_part,
                       ap_iso_rotate(ap_quat_normalize((struct ap_quat){v[3], v[4], v[5], 1})));
        parts[i].lit = i % 2;
        if (i % 4 == 1) {
            parts[i].kind = AP_PART_STICK;
            parts[i].radius_m = parts[i].radius2_m = 0.01;
            parts[i].length_m = in_front ? 0.05 : 0.4;
        } else if (i % 4 == 2) {
            parts[i].kind = AP_PART_POLYGON;
            parts[i].sides = 3 + i % 5;
            parts[i].edge_m = in_front ? 0.04 : 0.2;
        }
    }
}

static void every_colour_is_written_as_given(void **state) {
    (void)state;
    struct ap_space space = {0, 1};
    uint8_t none[3] = {0, 0, 0};
    balls[0] = stage_ball(space, (struct ap_vec3){0, 0, -1}, 0.05, none);
    struct ap_frame_input input = stage_input(space, AP_VIEW_NATIVE, 0.7, 0.06);
    for (int v = 0; v < 256; v++) {
        uint8_t want[3] = {(uint8_t)v, (uint8_t)(255 - v), (uint8_t)(v ^ 85)};
        for (int k = 0; k < 3; k++) {
            balls[0].color_srgb[k] = want[k] / 255.0;
            balls_scene.background_srgb[k] = want[2 - k] / 255.0;
        }
        draw_balls(&input, 1);
        const uint8_t *middle = stage_eye(&stage, v % 2) + 4 * (SIZE / 2 * SIZE + SIZE / 2);
        const uint8_t *corner = stage_eye(&stage, v % 2);
        for (int k = 0; k < 3; k++)
            if (middle[k] != want[k] || corner[k] != want[2 - k])
                fail_msg("colour %d: ball %d, background %d, expected %d and %d", v, middle[k],
                         corner[k], want[k], want[2 - k]);
    }
    memset(balls_scene.background_srgb, 0, sizeof balls_scene.background_srgb);
}

static void two_renders_are_the_same_bytes(void **state) {
    (void)state;
    for (int s = 0; s < 3; s++) {
        struct ap_part parts[MIXED];
        mixed_parts(SPACES[s], parts, false);
        struct ap_scene scene = stage_scene(SPACES[s], parts, MIXED);
        struct ap_frame_input input = stage_input(SPACES[s], AP_VIEW_NATIVE, 0.8, 0.064);
        draw_once(&scene, &input, NULL);
        uint8_t *first = copy_picture();
        draw_once(&scene, &input, NULL);
        assert_memory_equal(first, stage_eye(&stage, 0), 2 * EYE_BYTES);
        free(first);
    }
}

static void one_pass_equals_two(void **state) {
    (void)state;
    bool software = stage.gpu.properties.deviceType == VK_PHYSICAL_DEVICE_TYPE_CPU;
    for (int s = 0; s < 3; s++) {
        // Lavapipe's multiview is right only where nothing is clipped (docs/rendering.md), so all
        // of it is inside both pictures, and s3, where the long way round is clipped, is left out.
        if (software && SPACES[s].kappa > 0)
            continue;
        struct ap_part parts[MIXED];
        mixed_parts(SPACES[s], parts, true);
        for (int i = 0; i < MIXED; i++)
            parts[i].hidden = software && parts[i].kind != AP_PART_BALL;
        struct ap_scene scene = stage_scene(SPACES[s], parts, MIXED);
        struct ap_renderer_params two_passes = {.no_multiview = true},
                                  one_pass = {.multiview_in_software = true};
        struct ap_renderer *two = stage_renderer(&stage, &scene, &two_passes),
                           *one = stage_renderer(&stage, &scene, &one_pass);
        for (int mode = 0; mode < 2; mode++) {
            struct ap_frame_input input =
                stage_input(SPACES[s], mode ? AP_VIEW_TOURIST : AP_VIEW_NATIVE, 0.9, 0.064);
            stage_draw(&stage, two, &input);
            assert_true(drawn(0) > 1000);
            uint8_t *first = copy_picture();
            stage_draw(&stage, one, &input);
            int differ = 0;
            for (size_t i = 0; i < 2 * EYE_BYTES; i++)
                differ += first[i] != stage_eye(&stage, 0)[i];
            free(first);
            int allowed = software ? 300 : 0;
            printf("%s, mode %d: %d bytes differ, allowed %d\n", ap_space_name(SPACES[s]), mode,
                   differ, allowed);
            if (differ > allowed)
                fail_msg("%s, mode %d: %d bytes differ, allowed %d", ap_space_name(SPACES[s]), mode,
                         differ, allowed);
        }
        ap_renderer_destroy(two);
        ap_renderer_destroy(one);
    }
}

static void culling_changes_no_pixel(void **state) {
    (void)state;
    for (int s = 0; s < 3; s++) {
        struct ap_part parts[MIXED];
        mixed_parts(SPACES[s], parts, false);
        struct ap_scene scene = stage_scene(SPACES[s], parts, MIXED);
        struct ap_renderer *culls = stage_renderer(&stage, &scene, NULL),
                           *draws_all = stage_renderer(
                               &stage, &scene, &(struct ap_renderer_params){.no_cull = true});
        for (int i = 0; i < 6; i++) {
            struct ap_frame_input input =
                stage_input(SPACES[s], i % 2 ? AP_VIEW_TOURIST : AP_VIEW_NATIVE, 0.6, 0.064);
            input.viewer.world_from_nose = ap_iso_rotate_y(i / 2 * 1.7);
            struct ap_frame_stats with = stage_draw(&stage, culls, &input);
            uint8_t *first = copy_picture();
            struct ap_frame_stats without = stage_draw(&stage, draws_all, &input);
            if (memcmp(first, stage_eye(&stage, 0), 2 * EYE_BYTES) != 0)
                fail_msg("%s, frame %d: the pictures differ", ap_space_name(SPACES[s]), i);
            free(first);
            assert_int_equal(without.eye[0].culled, 0);
            assert_true(with.eye[0].culled > 5);
            assert_int_equal(with.eye[0].culled + with.eye[0].draws, without.eye[0].draws);
        }
        ap_renderer_destroy(culls);
        ap_renderer_destroy(draws_all);
    }
}

// Of what is seen the long way round s3, that which a polygon stands before is left out, and
// nothing of the picture: balls all around, whose images are behind the polygon, beside it and
// across its rim.
static void the_back_hemisphere_behind_a_polygon_costs_nothing(void **state) {
    (void)state;
    enum { BALLS = 60 };
    struct ap_part parts[BALLS + 1];
    parts[0] = (struct ap_part){.kind = AP_PART_POLYGON, .sides = 4, .edge_m = 0.8};
    parts[0].carrier_from_part =
        ap_iso_mul(ap_iso_translate(SPACES[0], (struct ap_vec3){0, 0, -0.6}),
                   ap_iso_rotate(ap_quat_from_axis_angle((struct ap_vec3){1, 0, 0}, 1.3)));
    for (int i = 0; i < BALLS; i++) {
        struct ap_vec3 at = {0.9 * sin(1.7 * i), 0.9 * sin(2.9 * i + 1), 0.4 + 0.02 * i};
        parts[i + 1] = stage_ball(SPACES[0], at, 0.01 + 0.001 * (i % 7), i % 2 ? RED : GREEN);
        parts[i + 1].lit = i % 3 == 0;
    }
    struct ap_scene scene = stage_scene(SPACES[0], parts, BALLS + 1);
    struct ap_renderer *culls = stage_renderer(&stage, &scene, NULL),
                       *draws_all = stage_renderer(&stage, &scene,
                                                   &(struct ap_renderer_params){.no_cull = true});
    uint32_t hidden = 0, seen = 0;
    for (int i = 0; i < 6; i++) {
        struct ap_frame_input input = stage_input(SPACES[0], AP_VIEW_NATIVE, 0.8, 0.064);
        struct ap_vec3 axis = {sin(2.0 * i), cos(3.0 * i), 0.3};
        input.viewer.world_from_nose =
            ap_iso_mul(ap_iso_translate(SPACES[0], (struct ap_vec3){0.02 * i, -0.03 * i, 0.02 * i}),
                       ap_iso_rotate(ap_quat_from_axis_angle(ap_vec3_normalize(axis), 0.1 * i)));
        struct ap_frame_stats with = stage_draw(&stage, culls, &input);
        uint8_t *first = copy_picture();
        struct ap_frame_stats without = stage_draw(&stage, draws_all, &input);
        if (memcmp(first, stage_eye(&stage, 0), 2 * EYE_BYTES) != 0)
            fail_msg("frame %d: the pictures differ", i);
        free(first);
        assert_int_equal(without.eye[0].back_hidden, 0);
        for (int e = 0; e < 2; e++) {
            hidden += with.eye[e].back_hidden;
            seen += with.eye[e].back_draws;
        }
    }
    print_message("hidden %u, drawn %u of those seen the long way round\n", hidden, seen);
    assert_true(hidden > 30 && seen > 30);
    ap_renderer_destroy(culls);
    ap_renderer_destroy(draws_all);
}

static void what_is_behind_costs_nothing(void **state) {
    (void)state;
    for (int s = 1; s < 3; s++)
        for (int mode = 0; mode < 2; mode++) {
            balls[0] = stage_ball(SPACES[s], (struct ap_vec3){0, 0, 1}, 0.1, RED);
            struct ap_frame_input input =
                stage_input(SPACES[s], mode ? AP_VIEW_TOURIST : AP_VIEW_NATIVE, 0.8, 0.064);
            struct ap_frame_stats stats = draw_balls(&input, 1);
            for (int e = 0; e < 2; e++) {
                assert_int_equal(stats.eye[e].vertices, 0);
                assert_int_equal(stats.eye[e].triangles, 0);
                assert_int_equal(stats.eye[e].draws, 0);
                assert_int_equal(stats.eye[e].culled, 1);
                assert_int_equal(drawn(e), 0);
            }
        }
}

// In s3 what lies behind is seen the long way round, in front; only the long way.
static void the_back_hemisphere_is_seen_the_long_way(void **state) {
    (void)state;
    for (int mode = 0; mode < 2; mode++) {
        balls[0] = stage_ball(SPACES[0], (struct ap_vec3){0, 0, 1}, 0.1, RED);
        balls[1] = stage_ball(SPACES[0], (struct ap_vec3){0, 0, -1}, 0.05, GREEN);
        struct ap_frame_input input =
            stage_input(SPACES[0], mode ? AP_VIEW_TOURIST : AP_VIEW_NATIVE, 0.8, 0.0);
        struct ap_frame_stats stats = draw_balls(&input, 2);
        assert_int_equal(stats.eye[0].draws, 2);
        assert_int_equal(stats.eye[0].back_draws, 1);
        assert_int_equal(stats.eye[0].culled, 2);
        // The nearer one hides the middle of the farther one.
        const uint8_t *middle = stage_eye(&stage, 0) + 4 * (SIZE / 2 * SIZE + SIZE / 2);
        assert_memory_equal(middle, GREEN, 3);
        draw_balls(&input, 1);
        assert_memory_equal(stage_eye(&stage, 0) + 4 * (SIZE / 2 * SIZE + SIZE / 2), RED, 3);
        // Its half-angle is asin(sin s/sin d): the same as by the short way.
        double angle = asin(sin(0.1 / 0.7) / sin(1 / 0.7)), focal = SIZE / 2 / tan(0.8);
        double expected = PI * pow(focal * tan(angle), 2), area = 0;
        for (int i = 0; i < SIZE * SIZE; i++)
            area += ap_linear_from_srgb(stage_eye(&stage, 0)[4 * i]) / ap_linear_from_srgb(RED[0]);
        printf("mode %d: %.2f pixels, expected %.2f within 0.2 %%\n", mode, area, expected);
        if (fabs(area - expected) > 0.002 * expected)
            fail_msg("%.2f pixels, expected %.2f within 0.2 %%", area, expected);
    }
}

// From the nose itself both views show everything in the same direction.
static void both_views_agree_at_the_nose(void **state) {
    (void)state;
    for (int s = 0; s < 3; s++) {
        struct ap_part parts[MIXED];
        mixed_parts(SPACES[s], parts, false);
        for (int i = 0; i < MIXED; i++)
            parts[i].lit = false;
        struct ap_scene scene = stage_scene(SPACES[s], parts, MIXED);
        struct ap_frame_input input = stage_input(SPACES[s], AP_VIEW_NATIVE, 0.8, 0.0);
        draw_once(&scene, &input, NULL);
        uint8_t *native = copy_picture();
        input.viewer.mode = AP_VIEW_TOURIST;
        draw_once(&scene, &input, NULL);
        const uint8_t *tourist = stage_eye(&stage, 0);
        int differ = 0;
        for (size_t i = 0; i < EYE_BYTES; i++)
            differ += abs(native[i] - tourist[i]) > 64;
        free(native);
        // Where parts pierce one another facets differ in depth, no more.
        if (differ > 400)
            fail_msg("%s: %d bytes differ by more than 64, expected at most 400",
                     ap_space_name(SPACES[s]), differ);
    }
}

// A sheet at height y before the eye, seen on the axis: drawn from 1 mm on.
static void nothing_within_a_millimetre_is_drawn(void **state) {
    (void)state;
    for (int s = 0; s < 3; s++)
        for (int mode = 0; mode < 2; mode++)
            for (int place = 0; place < 4; place++) {
                static const double AT[4] = {0.0005, 0.0009, 0.0011, 0.01};
                double small = AT[place] / 4;
                balls[0] = stage_ball(SPACES[s], (struct ap_vec3){0, 0, -AT[place]}, small, RED);
                struct ap_frame_input input =
                    stage_input(SPACES[s], mode ? AP_VIEW_TOURIST : AP_VIEW_NATIVE, 0.8, 0.0);
                draw_balls(&input, 1);
                // The nearest point of the ball is at AT − small, its limb at about AT.
                int n = drawn(0);
                if (AT[place] < 0.00099 && AT[place] * 1.25 < 0.001 && n > 0)
                    fail_msg("%s: %d pixels at %g m, expected none", ap_space_name(SPACES[s]), n,
                             AT[place]);
                if (place == 3 && n < 1000)
                    fail_msg("%s: %d pixels at %g m, expected many", ap_space_name(SPACES[s]), n,
                             AT[place]);
            }
}

static void nothing_within_a_millimetre_of_the_antipode_is_drawn(void **state) {
    (void)state;
    double rho = SPACES[0].rho_m;
    for (int mode = 0; mode < 2; mode++)
        for (int place = 0; place < 2; place++) {
            double radius = place == 0 ? 0.0009 : 0.01;
            balls[0] = stage_ball(SPACES[0], (struct ap_vec3){0, 0, -PI * rho}, radius, RED);
            struct ap_frame_input input =
                stage_input(SPACES[0], mode ? AP_VIEW_TOURIST : AP_VIEW_NATIVE, 0.8, 0.0);
            draw_balls(&input, 1);
            int n = drawn(0), expected = place == 0 ? 0 : SIZE * SIZE;
            // Larger than the forbidden ball about the antipode it fills the whole sky.
            if (n != expected)
                fail_msg("mode %d, ball of %g m about the antipode: %d pixels, expected %d", mode,
                         radius, n, expected);
        }
}

static void shut_one_eye(struct ap_renderer *renderer) {
    struct ap_space space = SPACES[2];
    balls[0] = stage_ball(space, (struct ap_vec3){0.1, 0, -0.8}, 0.06, RED);
    balls[1] = stage_ball(space, (struct ap_vec3){-0.1, 0, -0.8}, 0.06, GREEN);
    balls_scene.background_srgb[1] = 0.5;
    struct ap_frame_input input = stage_input(space, AP_VIEW_NATIVE, 0.7, 0.06);
    balls_scene.space = space;
    balls[1].hidden = false;
    stage_draw(&stage, renderer, &input);
    uint8_t *open = copy_picture();
    for (int shut = 0; shut < 2; shut++) {
        input.closed_eyes = 1u << shut;
        struct ap_frame_stats stats = stage_draw(&stage, renderer, &input);
        assert_int_equal(drawn(shut), 0);
        assert_int_equal(stats.eye[shut].triangles, 0);
        assert_memory_equal(stage_eye(&stage, !shut), open + (shut ? 0 : EYE_BYTES), EYE_BYTES);
        assert_int_equal(drawn(!shut), SIZE * SIZE);
    }
    free(open);
    balls_scene.background_srgb[1] = 0;
}

static void a_shut_eye_is_black_and_changes_nothing(void **state) {
    (void)state;
    shut_one_eye(balls_renderer);
    struct ap_renderer *one =
        stage_renderer(&stage, &balls_scene, &(struct ap_renderer_params){.samples = 1});
    shut_one_eye(one);
    ap_renderer_destroy(one);
}

// How far pixel (i, j)'s middle is inside a convex outline, pixels; counterclockwise, row 0 above.
static double inside_px(double corner[4][2], int i, int j) {
    double least = INFINITY;
    for (int k = 0; k < 4; k++) {
        const double *a = corner[k], *b = corner[(k + 1) % 4];
        double dx = b[0] - a[0], dy = b[1] - a[1];
        least = fmin(least, (dy * (i + 0.5 - a[0]) - dx * (j + 0.5 - a[1])) / hypot(dx, dy));
    }
    return least;
}

// With one sample a pixel is what its middle is, in both eyes; with more, edges are between.
static void one_sample_is_a_pixels_middle(void **state) {
    (void)state;
    const struct ap_space space = SPACES[1];
    struct ap_part part = stage_ball(space, (struct ap_vec3){0, 0, -1}, 0.1, GREEN);
    part.kind = AP_PART_POLYGON;
    part.sides = 4;
    part.edge_m = 0.5;
    const double turn = 0.3, half = 0.7, ipd = 0.06, pixels = SIZE / (2 * tan(half));
    part.carrier_from_part = ap_iso_mul(
        part.carrier_from_part,
        ap_iso_mul(ap_iso_rotate(ap_quat_from_axis_angle((struct ap_vec3){0, 0, 1}, turn)),
                   ap_iso_rotate(ap_quat_from_axis_angle((struct ap_vec3){1, 0, 0}, PI / 2))));
    struct ap_scene scene = stage_scene(space, &part, 1);
    const struct ap_frame_input input = stage_input(space, AP_VIEW_NATIVE, half, ipd);
    int off[2] = {0}, mixed[2] = {0}, seen[2] = {0};
    for (int many = 0; many < 2; many++) {
        draw_once(&scene, &input, &(struct ap_renderer_params){.samples = many ? 4 : 1});
        for (int n = 0; n < 2 * SIZE * SIZE; n++) {
            int e = n / (SIZE * SIZE), i = n % SIZE, j = n / SIZE % SIZE;
            double corner[4][2];
            for (int k = 0; k < 4; k++) {
                double a = turn + (k + 0.5) * PI / 2, r = part.edge_m / sqrt(2);
                corner[k][0] = SIZE / 2. + pixels * (r * cos(a) - (e ? ipd / 2 : -ipd / 2));
                corner[k][1] = SIZE / 2. - pixels * r * sin(a);
            }
            double in = inside_px(corner, i, j);
            const uint8_t *p = stage_eye(&stage, 0) + (size_t)4 * n;
            bool all = memcmp(p, GREEN, 3) == 0, none = p[0] + p[1] + p[2] == 0;
            seen[many] += all;
            mixed[many] += !all && !none;
            off[many] += fabs(in) > 0.02 && (in > 0 ? !all : !none);
        }
    }
    printf(
        "one sample: %d pixels of it, %d between, %d unlike their middle (0 expected); four: %d, "
        "%d, %d\n",
        seen[0], mixed[0], off[0], seen[1], mixed[1], off[1]);
    assert_true(seen[0] > 5000 && mixed[1] > 200);
    assert_int_equal(mixed[0], 0);
    assert_int_equal(off[0], 0);
}

static void an_empty_scene_is_black(void **state) {
    (void)state;
    struct ap_scene scene = stage_scene(SPACES[2], NULL, 0);
    struct ap_frame_input input = stage_input(SPACES[2], AP_VIEW_NATIVE, 0.8, 0.064);
    draw_once(&scene, &input, NULL);
    assert_int_equal(drawn(0) + drawn(1), 0);
    for (int i = 0; i < 2 * SIZE * SIZE; i++)
        assert_int_equal(stage_eye(&stage, 0)[4 * i + 3], 255);
}

static void hands_come_and_go(void **state) {
    (void)state;
    struct ap_part part = stage_ball(SPACES[2], (struct ap_vec3){0, 0, 0}, 0.05, RED);
    part.carrier = AP_CARRIER_RIGHT;
    struct ap_scene scene = stage_scene(SPACES[2], &part, 1);
    struct ap_frame_input input = stage_input(SPACES[2], AP_VIEW_NATIVE, 0.8, 0.064);
    input.world_from_hand[1] = ap_iso_translate(SPACES[2], (struct ap_vec3){0, 0, -0.5});
    struct ap_frame_stats stats = draw_once(&scene, &input, NULL);
    assert_int_equal(stats.eye[0].draws + stats.eye[0].culled, 0);
    assert_int_equal(drawn(0), 0);
    input.hand_tracked[1] = true;
    draw_once(&scene, &input, NULL);
    assert_true(drawn(0) > 200);
}

static void solids_are_drawn_where_they_are(void **state) {
    (void)state;
    // A square of 0.2 m seen face on from 0.5 m, both faces.
    float positions[12] = {-0.1f, -0.1f, 0, 0.1f, -0.1f, 0, 0.1f, 0.1f, 0, -0.1f, 0.1f, 0};
    float normals[12] = {0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1};
    unsigned indices[6] = {0, 1, 2, 0, 2, 3};
    struct ap_solid solid = {.positions = positions,
                             .normals = normals,
                             .indices = indices,
                             .vertex_count = 4,
                             .index_count = 6,
                             .reach_m = 0.1415};
    for (int s = 0; s < 3; s++) {
        struct ap_part part = stage_ball(SPACES[s], (struct ap_vec3){0, 0, -0.5}, 0, RED);
        part.kind = AP_PART_SOLID;
        struct ap_scene scene = stage_scene(SPACES[s], &part, 1);
        scene.solids = &solid;
        scene.solid_count = 1;
        struct ap_frame_input input = stage_input(SPACES[s], AP_VIEW_NATIVE, 0.8, 0.0);
        draw_once(&scene, &input, NULL);
        double rho = SPACES[s].rho_m, t = 0.5 / rho, c = 0.1 / rho;
        // From the nose its corners are seen at tan = exp's x/z.
        struct ap_vec4 p = {rho * ap_space_sin(SPACES[s], c * sqrt(2)) / sqrt(2), 0, 0,
                            rho * ap_space_cos(SPACES[s], c * sqrt(2))};
        struct ap_iso move = ap_iso_translate(SPACES[s], (struct ap_vec3){0, 0, -t * rho});
        struct ap_vec4 q = ap_iso_apply(&move, p);
        double half = q.x / -q.z * SIZE / 2 / tan(0.8), expected = 4 * half * half;
        if (fabs(drawn(0) - expected) > 8 * half + 8)
            fail_msg("%s: %d pixels, expected %.0f within %.0f", ap_space_name(SPACES[s]), drawn(0),
                     expected, 8 * half + 8);
    }
}

static void validation_is_silent(void **state) {
    (void)state;
    if (stage.validation_errors != 0)
        fail_msg("%d validation errors, expected 0", stage.validation_errors);
}

int main(void) {
    if (!stage_open(&stage, SIZE, SIZE, true))
        return 77;
    balls[0] = balls[1] = stage_ball(SPACES[1], (struct ap_vec3){0, 0, -1}, 0.1, RED);
    balls_scene = stage_scene(SPACES[1], balls, 2);
    balls_renderer = stage_renderer(&stage, &balls_scene, NULL);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_colour_is_written_as_given),
        cmocka_unit_test(two_renders_are_the_same_bytes),
        cmocka_unit_test(one_pass_equals_two),
        cmocka_unit_test(culling_changes_no_pixel),
        cmocka_unit_test(what_is_behind_costs_nothing),
        cmocka_unit_test(the_back_hemisphere_behind_a_polygon_costs_nothing),
        cmocka_unit_test(the_back_hemisphere_is_seen_the_long_way),
        cmocka_unit_test(both_views_agree_at_the_nose),
        cmocka_unit_test(nothing_within_a_millimetre_is_drawn),
        cmocka_unit_test(nothing_within_a_millimetre_of_the_antipode_is_drawn),
        cmocka_unit_test(a_shut_eye_is_black_and_changes_nothing),
        cmocka_unit_test(one_sample_is_a_pixels_middle),
        cmocka_unit_test(an_empty_scene_is_black),
        cmocka_unit_test(hands_come_and_go),
        cmocka_unit_test(solids_are_drawn_where_they_are),
        cmocka_unit_test(validation_is_silent),
    };
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    ap_renderer_destroy(balls_renderer);
    stage_close(&stage);
    return failed + (stage.validation_errors != 0);
}
