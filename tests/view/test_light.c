// Light in the space against what it stands for: flow through geodesic spheres, shadows as the
// paths that a ball cuts, the share of the surroundings that it hides by counting directions.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>

#include <cmocka.h>

#include "src/view/light.h"
#include "tests/view/random.h"

static void close_to(const char *what, double got, double expected, double tolerance) {
    if (!(fabs(got - expected) <= tolerance)) {
        print_error("%s: %.15g, expected %.15g within %g\n", what, got, expected, tolerance);
        fail();
    }
}

static struct ap_iso roll_place(struct dice *dice, struct ap_space space, double most) {
    struct ap_vec3 v = ap_vec3_scale(roll(dice, 0.05, most), roll_direction(dice));
    return ap_iso_mul(ap_iso_translate(space, v), ap_iso_rotate(roll_turn(dice, 3)));
}

static const struct ap_space SPACES[3] = {{1, 0.6}, {0, 1}, {-1, 0.85}};

// The flow through a small patch, times its area, is the same on every sphere about the lamp: the
// patch is spanned by geodesics that leave the lamp beside one another, and its area is measured by
// distances.
static void light_is_neither_made_nor_lost(void **state) {
    (void)state;
    struct dice dice = {404};
    for (int i = 0; i < 300; i++) {
        struct ap_space space = SPACES[i % 3];
        struct ap_iso world_from_lamp = roll_place(&dice, space, 0.5);
        struct ap_vec4 base = {0, 0, 0, space.rho_m};
        struct ap_lamp lamp = {ap_iso_apply(&world_from_lamp, base), 0.7, 0.02};
        double first = 0;
        for (int k = 0; k < 5; k++) {
            double d = 0.45 + 0.25 * k, h = 1e-4, side[2];
            if (d > 0.9 * M_PI * space.rho_m)
                break;
            struct ap_vec3 u = roll_direction(&dice), a, b;
            a = ap_vec3_normalize(ap_vec3_cross(u, (struct ap_vec3){0.3, 0.5, 0.8}));
            b = ap_vec3_cross(u, a);
            struct ap_vec4 p = ap_exp(space, ap_vec3_scale(d, u));
            const struct ap_vec3 aside[2] = {a, b};
            for (int s = 0; s < 2; s++) {
                struct ap_vec3 v =
                    ap_vec3_add(ap_vec3_scale(cos(h), u), ap_vec3_scale(sin(h), aside[s]));
                ap_distance(NULL, space, p, ap_exp(space, ap_vec3_scale(d, v)), &side[s]);
            }
            // The patch faces the lamp: its normal runs back along the geodesic.
            struct ap_iso along = ap_iso_translate(space, ap_vec3_scale(d, u));
            struct ap_lit_point point = {ap_iso_apply(&world_from_lamp, p), {0, 0, 0, 0}};
            point.normal = ap_iso_apply(&along, (struct ap_vec4){-u.x, -u.y, -u.z, 0});
            point.normal = ap_iso_apply(&world_from_lamp, point.normal);
            struct ap_lamplight light = ap_lamp_light(space, &lamp, &point);
            close_to("it faces the lamp", light.cosine, 1, 1e-12);
            double flow = light.falloff * side[0] * side[1];
            first = k == 0 ? flow : first;
            close_to("flow", flow / first, 1, 1e-6);
        }
    }
}

// A point of the plane y = 0 and a ball above it; lamp over both.
struct stand {
    struct ap_space space;
    struct ap_lamp lamp;
    struct ap_lit_point point;
    struct ap_vec4 ball;
    double radius_m;
};

static struct stand roll_stand(struct dice *dice, int i) {
    struct stand s = {.space = SPACES[i % 3], .radius_m = roll(dice, 0.01, 0.06)};
    s.lamp = (struct ap_lamp){
        ap_exp(s.space, (struct ap_vec3){roll(dice, -0.2, 0.2), roll(dice, 0.4, 0.7), 0.1}), 0.6,
        0.015};
    struct ap_iso foot = ap_iso_translate(
        s.space, (struct ap_vec3){roll(dice, -0.3, 0.3), 0, roll(dice, -0.3, 0.3)});
    s.ball = ap_iso_apply(&foot, ap_exp(s.space, (struct ap_vec3){0, s.radius_m, 0}));
    struct ap_iso near =
        ap_iso_translate(s.space, (struct ap_vec3){roll(dice, -2.5, 2.5) * s.radius_m, 0,
                                                   roll(dice, -2.5, 2.5) * s.radius_m});
    struct ap_iso place = ap_iso_mul(foot, near);
    s.point.at = ap_iso_apply(&place, (struct ap_vec4){0, 0, 0, s.space.rho_m});
    s.point.normal = (struct ap_vec4){0, 1, 0, 0}; // of the plane, everywhere
    return s;
}

// How near the geodesic from the point to q comes to the ball's middle, by trying many places.
static double nearest(const struct stand *s, struct ap_vec4 q) {
    double best = INFINITY;
    struct ap_iso here = ap_iso_translate(s->space, ap_log_unchecked(s->space, s->point.at, 0));
    struct ap_iso from_here = ap_iso_inverse(s->space, here);
    struct ap_vec3 way = ap_log_unchecked(s->space, ap_iso_apply(&from_here, q), 0);
    for (int k = 0; k <= 4000; k++) {
        struct ap_vec4 at = ap_iso_apply(&here, ap_exp(s->space, ap_vec3_scale(k / 4000.0, way)));
        double d;
        if (ap_distance(NULL, s->space, at, s->ball, &d) == AP_OK)
            best = fmin(best, d);
    }
    return best;
}

static void shadows_are_where_paths_are_cut(void **state) {
    (void)state;
    struct dice dice = {77};
    int dark = 0, light = 0, half = 0;
    for (int i = 0; i < 1200; i++) {
        struct stand s = roll_stand(&dice, i);
        double hidden = ap_hidden_by_ball(s.space, &s.lamp, &s.point, s.ball, s.radius_m).lamp;
        double d = nearest(&s, s.lamp.at), gap = d - s.radius_m;
        // The middle of the lamp is at the shadow's edge exactly where a half is hidden.
        if (gap < -2e-5 && hidden < 0.5)
            fail_msg("the lamp's middle is hidden by %g m, but only %g of it", -gap, hidden);
        if (gap > 2e-5 && hidden > 0.5)
            fail_msg("the lamp's middle clears the ball by %g m, but %g is hidden", gap, hidden);
        dark += hidden == 1;
        light += hidden == 0;
        half += hidden > 0 && hidden < 1;
    }
    print_message("%d in the full shadow, %d outside, %d half\n", dark, light, half);
    assert_true(dark > 50 && light > 50 && half >= 10);
}

// By counting directions on the upper half of the sphere at the point, each weighted by its cosine.
static void surroundings_are_hidden_by_solid_angle(void **state) {
    (void)state;
    struct dice dice = {5};
    for (int i = 0; i < 12; i++) {
        struct stand s = roll_stand(&dice, i);
        double want = 0, all = 0;
        struct ap_iso here = ap_iso_translate(s.space, ap_log_unchecked(s.space, s.point.at, 0));
        struct ap_iso from_here = ap_iso_inverse(s.space, here);
        struct ap_vec4 seen = ap_iso_apply(&from_here, s.ball);
        struct ap_vec3 to = ap_log_unchecked(s.space, seen, 0);
        double d = ap_vec3_length(to);
        // Within the ball's angular radius of its direction (maths: "How much is visible").
        double most = asin(fmin(1, ap_space_sin(s.space, s.radius_m / s.space.rho_m) /
                                       ap_space_sin(s.space, d / s.space.rho_m)));
        for (int k = 0; k < 300000; k++) {
            struct ap_vec3 u = roll_direction(&dice);
            u.y = fabs(u.y);
            all += u.y;
            double c = ap_vec3_dot(u, to) / d;
            want += c > cos(most) ? u.y : 0;
        }
        double got = ap_hidden_by_ball(s.space, &s.lamp, &s.point, s.ball, s.radius_m).surroundings;
        close_to("hidden", got, want / all, 0.004);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(light_is_neither_made_nor_lost),
                                       cmocka_unit_test(shadows_are_where_paths_are_cut),
                                       cmocka_unit_test(surroundings_are_hidden_by_solid_angle)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
