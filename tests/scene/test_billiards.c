#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "src/geom/map.h"
#include "src/geom/table.h"
#include "src/scene/scene.h"

static const char *const spaces[] = {"h3", "e3", "s3"};

static void close_to(const char *what, double got, double expected, double tolerance) {
    if (!(fabs(got - expected) <= tolerance)) {
        print_error("%s: %.17g, expected %.17g within %g\n", what, got, expected, tolerance);
        fail();
    }
}

static struct ap_scene *room(const char *space, double edge_m) {
    const struct ap_scene_params params = {.space_name = space, .table_edge_m = edge_m};
    struct ap_error err = {""};
    struct ap_scene *scene = NULL;
    if (ap_scene_billiards(&err, &params, &scene)) {
        print_error("%s\n", err.text);
        fail();
    }
    return scene;
}

static struct ap_vec4 place(const struct ap_scene *s, const struct ap_part *part) {
    return ap_iso_apply(&part->carrier_from_part, (struct ap_vec4){0, 0, 0, s->space.rho_m});
}

static double apart(const struct ap_scene *s, struct ap_vec4 p, struct ap_vec4 q) {
    double d = NAN;
    struct ap_error err = {""};
    if (ap_distance(&err, s->space, p, q, &d))
        print_error("%s\n", err.text);
    return d;
}

// Signed height over the table's plane.
static double height(struct ap_space s, struct ap_vec4 p) {
    double y = p.y / s.rho_m;
    return s.rho_m * (s.kappa > 0 ? asin(y) : s.kappa < 0 ? asinh(y) : y);
}

static bool billiard_ball(const struct ap_part *p) {
    return p->kind == AP_PART_BALL && p->lit && p->radius_m > 0.01 && p->radius_m < 0.029 &&
           p->object >= 4;
}

static void check_balls(const struct ap_scene *s, const struct ap_table_shape *table) {
    int count = 0;
    double closest = INFINITY;
    for (size_t i = 0; i < s->part_count; i++) {
        const struct ap_part *p = &s->parts[i];
        if (!billiard_ball(p))
            continue;
        count++;
        close_to("a ball lies on the felt", height(s->space, place(s, p)), p->radius_m, 1e-12);
        for (int e = 0; e < table->sides; e++) { // and between the rails
            struct ap_iso frame = ap_table_edge_frame(table, e);
            frame = ap_iso_inverse(s->space, frame);
            struct ap_vec4 q = ap_iso_apply(&frame, place(s, p));
            double in = height(s->space, (struct ap_vec4){0, q.z, 0, 0});
            if (!(in > p->radius_m + 0.025)) {
                print_error("a ball stands %g m from edge %d, its radius %g\n", in, e, p->radius_m);
                fail();
            }
        }
        for (size_t k = 0; k < i; k++)
            if (billiard_ball(&s->parts[k]))
                closest =
                    fmin(closest, apart(s, place(s, p), place(s, &s->parts[k])) - 2 * p->radius_m);
    }
    print_message("%d balls, the closest two %.3g mm apart\n", count, 1000 * closest);
    assert_int_equal(count, 16);
    assert_true(closest >= 0 && closest < 1e-3);
}

static void sixteen_balls_lie_on_the_felt(void **state) {
    (void)state;
    const double edges[] = {0.9, 1.4, 2.2};
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++) {
            struct ap_scene *s = room(spaces[i], edges[k]);
            struct ap_table_shape table =
                ap_table_from_edge(s->space.kappa, edges[k], s->space.rho_m);
            check_balls(s, &table);
            assert_true(s->has_table);
            close_to("edge", s->table_edge_m, edges[k], 1e-14);
            ap_scene_destroy(s);
        }
}

static void targets_have_their_own_colours(void **state) {
    (void)state;
    for (int i = 0; i < 3; i++) {
        struct ap_scene *s = room(spaces[i], 0);
        int targets = 0;
        for (size_t k = 0; k < s->part_count; k++) {
            const struct ap_part *p = &s->parts[k];
            if (!p->target)
                continue;
            targets++;
            assert_true(p->kind == AP_PART_BALL && !p->lit && p->name[0]);
            assert_memory_not_equal(p->color_srgb, s->background_srgb, sizeof p->color_srgb);
            for (size_t m = 0; m < s->part_count; m++)
                if (m != k) {
                    assert_memory_not_equal(p->color_srgb, s->parts[m].color_srgb,
                                            sizeof p->color_srgb);
                    assert_true(strcmp(p->name, s->parts[m].name) != 0);
                }
        }
        assert_true(targets >= 5);
        ap_scene_destroy(s);
    }
}

// Whoever stands at an edge, 0.85 m over the table's plane and 0.6 m outside, and looks at its
// middle, sees most targets within 50° and all of them within arm's length to a few steps.
static void targets_are_seen_from_round_the_table(void **state) {
    (void)state;
    for (int i = 0; i < 3; i++) {
        struct ap_scene *s = room(spaces[i], 0);
        struct ap_table_shape table = ap_table_from_edge(s->space.kappa, 0.9, s->space.rho_m);
        int seen = 0, all = 0;
        for (int e = 0; e < table.sides; e++) {
            struct ap_iso head =
                ap_iso_mul(ap_table_edge_frame(&table, e),
                           ap_iso_translate(s->space, (struct ap_vec3){0, 0.85, -0.6}));
            struct ap_iso inverse = ap_iso_inverse(s->space, head);
            struct ap_vec4 middle = {0, 0, 0, s->space.rho_m};
            struct ap_vec3 gaze =
                ap_vec3_normalize(ap_log_unchecked(s->space, ap_iso_apply(&inverse, middle), 0));
            for (size_t k = 0; k < s->part_count; k++) {
                if (!s->parts[k].target)
                    continue;
                struct ap_vec3 v =
                    ap_log_unchecked(s->space, ap_iso_apply(&inverse, place(s, &s->parts[k])), 0);
                double d = ap_vec3_length(v);
                double off = acos(fmin(1, ap_vec3_dot(gaze, v) / d)) * 57.29577951308232;
                all++;
                seen += off < 50;
                print_message("%s edge %d %-8s %.2f m (%.1f rho), %3.0f deg off\n", spaces[i], e,
                              s->parts[k].name, d, d / s->space.rho_m, off);
                assert_true(d > 0.25);
            }
        }
        print_message("%s: %d of %d within 50 degrees of the gaze\n", spaces[i], seen, all);
        assert_true(2 * seen > all);
        ap_scene_destroy(s);
    }
}

// Not the lid of a pocket's mouth, which lies above.
static bool is_tile(const struct ap_part *p) {
    return p->kind == AP_PART_POLYGON && p->sides <= 5;
}

// Polygons lie in one plane: no two may overlap, or they would flicker. Their centres are at least
// two inradii apart.
static void tiles_do_not_overlap(void **state) {
    (void)state;
    for (int i = 0; i < 3; i++) {
        struct ap_scene *s = room(spaces[i], 0);
        double least = INFINITY, biggest = 0;
        int tiles = 0;
        for (size_t a = 0; a < s->part_count; a++) {
            if (!is_tile(&s->parts[a]))
                continue;
            tiles++;
            double circum, in;
            assert_int_equal(ap_regular_polygon(NULL, s->space, s->parts[a].sides,
                                                s->parts[a].edge_m, &circum, &in),
                             AP_OK);
            biggest = fmax(biggest, in);
            close_to("a tile lies in the plane", height(s->space, place(s, &s->parts[a])), 0, 1e-9);
            for (size_t b = 0; b < a; b++)
                if (is_tile(&s->parts[b]))
                    least = fmin(least, apart(s, place(s, &s->parts[a]), place(s, &s->parts[b])));
        }
        print_message("%s: %d polygons, %zu parts, centres at least %.4g m apart\n", spaces[i],
                      tiles, s->part_count, least);
        assert_true(least > 2 * biggest - 1e-9);
        assert_int_equal(tiles, i == 2 ? 8 : i == 1 ? 41 : 61); // the whole octahedron in s3
        ap_scene_destroy(s);
    }
}

// Fifteen numbers, each once, on balls that lie still: stripes from nine on; the mouths stand at
// the corners and reach beyond the rails' ends, and no ball lies in one.
static void numbers_and_pockets(void **state) {
    (void)state;
    for (int i = 0; i < 3; i++) {
        struct ap_scene *s = room(spaces[i], 0);
        struct ap_table_shape table = ap_table_from_edge(s->space.kappa, 0.9, s->space.rho_m);
        assert_int_equal(s->mouth_count, table.sides);
        assert_int_equal(s->decal_count, 15);
        int seen[16] = {0}, casting = 0;
        for (size_t k = 0; k < s->part_count; k++) {
            const struct ap_part *p = &s->parts[k];
            casting += p->casts_shadow;
            if (p->takes_marks)
                assert_int_equal(p->finish, AP_FINISH_CLOTH);
            if (!billiard_ball(p))
                continue;
            assert_true(p->casts_shadow);
            for (int m = 0; m < s->mouth_count; m++)
                assert_true(apart(s, place(s, p), s->mouths[m].at) > s->mouths[m].radius_m);
            if (!p->decal)
                continue;
            int number = atoi(s->decals[p->decal - 1].text);
            assert_in_range(number, 1, 15);
            assert_int_equal(seen[number]++, 0);
            assert_int_equal(p->finish, number > 8 ? AP_FINISH_STRIPED : AP_FINISH_POOL);
        }
        assert_int_equal(casting, 16);
        for (int m = 0; m < s->mouth_count; m++)
            close_to("a corner",
                     apart(s, s->mouths[m].at, (struct ap_vec4){0, 0, 0, s->space.rho_m}),
                     table.circumradius_m, 1e-12);
        ap_scene_destroy(s);
    }
}

static void every_part_is_sound(void **state) {
    (void)state;
    for (int i = 0; i < 3; i++) {
        struct ap_scene *s = room(spaces[i], 0);
        for (size_t k = 0; k < s->part_count; k++) {
            const struct ap_part *p = &s->parts[k];
            double far = fmax(1, fabs(p->carrier_from_part.m[3][3]));
            close_to("defect", ap_iso_defect(s->space, &p->carrier_from_part), 0,
                     1e-14 * far * far);
            if (p->kind == AP_PART_SOLID)
                assert_in_range(p->solid, 0, (int)s->solid_count - 1);
            else if (p->kind != AP_PART_POLYGON)
                assert_true(p->radius_m > 0 && p->radius2_m > 0);
        }
        for (size_t k = 0; k < s->solid_count; k++) {
            const struct ap_solid *o = &s->solids[k];
            assert_true(o->index_count > 0 && o->index_count % 3 == 0);
            double volume = 0;
            for (size_t t = 0; t < o->index_count; t += 3) {
                struct ap_vec3 c[3];
                for (size_t m = 0; m < 3; m++) {
                    assert_true(o->indices[t + m] < o->vertex_count);
                    const float *q = &o->positions[3 * o->indices[t + m]];
                    c[m] = (struct ap_vec3){q[0], q[1], q[2]};
                    assert_true(ap_vec3_length(c[m]) <= o->reach_m * (1 + 1e-6));
                }
                volume += ap_vec3_dot(c[0], ap_vec3_cross(c[1], c[2])) / 6;
            }
            assert_true(volume > 0); // triangles face outward, the mirrored hand's too
        }
        ap_scene_destroy(s);
    }
}

static void small_tables_get_small_balls(void **state) {
    (void)state;
    const struct ap_scene_params params = {.space_name = "s3", .radius_m = 0.2};
    struct ap_scene *s = NULL;
    assert_int_equal(ap_scene_billiards(NULL, &params, &s), AP_OK);
    for (size_t k = 0; k < s->part_count; k++)
        assert_true(s->parts[k].kind != AP_PART_BALL || s->parts[k].radius_m < 0.2 * M_PI / 2);
    ap_scene_destroy(s);
    const struct ap_scene_params bad = {.space_name = "s3", .radius_m = 0.2, .table_edge_m = 0.9};
    struct ap_error err = {""};
    assert_int_equal(ap_scene_billiards(&err, &bad, &s), AP_USAGE);
}

// Two more pockets in the middles of opposite edges of the square table; no other table has them.
static void six_pockets(void **state) {
    (void)state;
    static const char *const names[] = {"s3", "e3", "h3"};
    for (int k = 0; k < 3; k++) {
        const struct ap_scene_params params = {.space_name = names[k], .side_pockets = true};
        struct ap_scene *s = NULL;
        assert_int_equal(ap_scene_billiards(NULL, &params, &s), AP_OK);
        assert_int_equal(s->mouth_count, k == 0 ? 3 : k == 1 ? 6 : 5);
        for (int m = 4; k == 1 && m < 6; m++) {
            struct ap_vec4 at = s->mouths[m].at;
            if (fabs(fabs(at.x) - 0.45) > 1e-12 || fabs(at.y) > 1e-12 || fabs(at.z) > 1e-12)
                fail_msg("mouth %d at (%g, %g, %g), expected (±0.45, 0, 0)", m, at.x, at.y, at.z);
        }
        ap_scene_destroy(s);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(sixteen_balls_lie_on_the_felt),
                                       cmocka_unit_test(targets_have_their_own_colours),
                                       cmocka_unit_test(targets_are_seen_from_round_the_table),
                                       cmocka_unit_test(tiles_do_not_overlap),
                                       cmocka_unit_test(numbers_and_pockets),
                                       cmocka_unit_test(every_part_is_sound),
                                       cmocka_unit_test(small_tables_get_small_balls),
                                       cmocka_unit_test(six_pockets)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
