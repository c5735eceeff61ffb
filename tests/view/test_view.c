#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "src/view/silhouette.h"
#include "tests/view/random.h"

static void close_to(const char *what, double got, double expected, double tolerance) {
    if (!(fabs(got - expected) <= tolerance)) {
        print_error("%s: %.17g, expected %.17g within %g\n", what, got, expected, tolerance);
        fail();
    }
}

static struct ap_viewer plain_viewer(int kappa, double rho_m, enum ap_view_mode mode, double ipd) {
    struct ap_viewer v = {.space = {kappa, rho_m}, .mode = mode};
    v.world_from_nose = AP_ISO_IDENTITY;
    for (int e = 0; e < 2; e++) {
        v.eye[e].view_from_eye = AP_POSE_IDENTITY;
        v.eye[e].view_from_eye.p.x = e ? ipd / 2 : -ipd / 2;
        v.eye[e].frustum = (struct ap_frustum){-1, 1, 1, -1};
    }
    return v;
}

// What a straight-ahead target at distance d does to the two eyes, by the closed forms.
static double closed_form(struct ap_space s, enum ap_view_mode mode, double a, double d) {
    if (mode == AP_VIEW_NATIVE || s.kappa == 0)
        return 2 * atan(a / d);
    if (s.kappa > 0) {
        double q = sin(a / s.rho_m) / tan(d / s.rho_m);
        return 2 * atan(q);
    }
    return 2 * atan(sinh(a / s.rho_m) / tanh(d / s.rho_m));
}

static void directions_give_the_closed_forms_of_vergence(void **state) {
    (void)state;
    for (int kappa = -1; kappa <= 1; kappa++)
        for (int mode = AP_VIEW_NATIVE; mode <= AP_VIEW_TOURIST; mode++)
            for (double d = 0.1; d < 5; d += 0.117) {
                struct ap_viewer v = plain_viewer(kappa, 0.85, (enum ap_view_mode)mode, 0.064);
                if (kappa > 0 && (d > 2 * M_PI * 0.85 - 0.05 || fabs(d - M_PI * 0.85) < 0.05))
                    continue;
                int image = kappa > 0 && d > M_PI * 0.85;
                struct ap_vec4 p = ap_exp(v.space, (struct ap_vec3){0, 0, -d});
                double a[2], b[2];
                for (int e = 0; e < 2; e++)
                    assert_true(ap_direction(&v, e, p, image, &a[e], &b[e]));
                double verg = ap_vergence_of((struct ap_vec3){a[0], b[0], -1},
                                             (struct ap_vec3){a[1], b[1], -1});
                close_to("vergence", verg, closed_form(v.space, v.mode, 0.032, d), 1e-13);
            }
}

static void native_keeps_every_distance(void **state) {
    (void)state;
    struct dice dice = {12345};
    for (int i = 0; i < 2000; i++) {
        int kappa = i % 3 - 1;
        struct ap_viewer v = roll_viewer(&dice, kappa, AP_VIEW_NATIVE);
        struct ap_iso turn = ap_iso_rotate(roll_turn(&dice, M_PI));
        v.world_from_nose = ap_iso_mul(
            ap_iso_translate(v.space, ap_vec3_scale(v.space.rho_m, roll_direction(&dice))), turn);
        // Where the visitor is told that something stands, it stands: through the whole pipeline.
        struct ap_vec3 q =
            ap_vec3_scale(roll(&dice, 0.2, 2.9) * v.space.rho_m, roll_direction(&dice));
        struct ap_vec4 world = ap_iso_apply(&v.world_from_nose, ap_exp(v.space, q));
        struct ap_tangent_point t = ap_tangent_from_nose(v.space, ap_nose_from_world(&v, world), 0);
        close_to("x", t.x.x, q.x, 1e-12 * v.space.rho_m);
        close_to("y", t.x.y, q.y, 1e-12 * v.space.rho_m);
        close_to("z", t.x.z, q.z, 1e-12 * v.space.rho_m);
        struct ap_vec3 e =
            ap_pose_apply(v.eye[1].view_from_eye, ap_eye_from_tangent(&v.eye[1], t).x);
        close_to("eye and back", ap_vec3_length(ap_vec3_sub(e, q)), 0, 1e-12 * v.space.rho_m);
    }
}

static void flat_views_are_the_same(void **state) {
    (void)state;
    struct dice dice = {99};
    for (int i = 0; i < 2000; i++) {
        struct ap_viewer native = roll_viewer(&dice, 0, AP_VIEW_NATIVE), tourist = native;
        tourist.mode = AP_VIEW_TOURIST;
        struct ap_vec4 p =
            ap_exp(native.space,
                   (struct ap_vec3){roll(&dice, -2, 2), roll(&dice, -2, 2), roll(&dice, -2, 2)});
        double a0 = 0, b0 = 0, a1 = 0, b1 = 0;
        bool seen = ap_direction(&native, 0, p, 0, &a0, &b0);
        assert_int_equal(seen, ap_direction(&tourist, 0, p, 0, &a1, &b1));
        double size = 1 + hypot(a0, b0);
        close_to("a", a1, a0, 1e-12 * size * size);
        close_to("b", b1, b0, 1e-12 * size * size);
    }
}

static struct ap_vec3 roll_tangent(struct dice *dice, struct ap_space space) {
    return ap_vec3_scale(roll(dice, 0.05, 3.0) * space.rho_m, roll_direction(dice));
}

static double angle_between(struct ap_vec3 a, struct ap_vec3 b) {
    return atan2(ap_vec3_length(ap_vec3_cross(a, b)), ap_vec3_dot(a, b));
}

// native is native-of e3, whatever its radius; tourist is native-of the world's own space.
static void born_at_home_is_native_and_tourist(void **state) {
    (void)state;
    struct dice dice = {2021};
    double worst[2] = {0, 0};
    for (int i = 0; i < 12000; i++) {
        int kappa = i % 3 - 1, which = i / 3 % 2, image = kappa > 0 ? i / 6 % 2 : 0;
        enum ap_view_mode mode = which ? AP_VIEW_TOURIST : AP_VIEW_NATIVE;
        struct ap_viewer v = roll_viewer(&dice, kappa, mode), w = v;
        w.mode = AP_VIEW_BORN;
        w.born = which ? v.space : (struct ap_space){0, roll(&dice, 0.01, 100)};
        assert_int_equal(ap_view_mode_of(v.space, w.born), kappa == 0 ? AP_VIEW_NATIVE : mode);
        struct ap_nose_point p = {ap_exp(v.space, roll_tangent(&dice, v.space))};
        struct ap_vec3 a, b;
        assert_true(ap_sight_line(&v, i % 2, p, image, &a));
        assert_true(ap_sight_line(&w, i % 2, p, image, &b));
        worst[which] = fmax(worst[which], angle_between(a, b));
        close_to(ap_view_mode_name(mode), angle_between(a, b), 0, 2e-12);
    }
    print_message("native-of e3 and native: %.2g rad, of the own space and tourist: %.2g rad\n",
                  worst[0], worst[1]);
}

// By another way: what she sees is a point of her own space; the geodesic of that space that leaves
// her eye along the line of sight comes by it.
static void born_elsewhere_looks_along_her_geodesics(void **state) {
    (void)state;
    struct dice dice = {31};
    int behind = 0;
    for (int i = 0; i < 12000; i++) {
        struct ap_viewer v = roll_viewer(&dice, i % 3 - 1, AP_VIEW_BORN);
        struct ap_vec3 q = roll_tangent(&dice, v.space), line;
        struct ap_nose_point p = {ap_exp(v.space, q)};
        bool seen = ap_sight_line(&v, 0, p, 0, &line);
        double rho = v.born.rho_m, d = ap_vec3_length(q);
        assert_int_equal(seen, v.born.kappa <= 0 || d < 2 * M_PI * rho);
        // Near the antipodes of her nose and her eye all lines pass.
        if (!seen || (v.born.kappa > 0 && fabs(fmod(d / rho, M_PI) - M_PI / 2) > 1.3))
            continue;
        behind += v.born.kappa > 0 && d > M_PI * rho;
        struct ap_iso nose_from_eye = ap_iso_from_pose(v.born, v.eye[0].view_from_eye);
        struct ap_vec4 want = ap_exp(v.born, q);
        struct ap_iso eye_from_nose = ap_iso_inverse(v.born, nose_from_eye);
        double e;
        assert_int_equal(ap_distance(NULL, v.born, (struct ap_vec4){0, 0, 0, rho},
                                     ap_iso_apply(&eye_from_nose, want), &e),
                         AP_OK);
        // From the long way round the point is reached after a full turn less its distance.
        double t = d > M_PI * rho && v.born.kappa > 0 ? 2 * M_PI * rho - e : e;
        struct ap_vec4 along = ap_exp(v.born, ap_vec3_scale(t, ap_vec3_normalize(line)));
        struct ap_vec4 got = ap_iso_apply(&nose_from_eye, along);
        double size = fabs(want.w) + rho;
        close_to("x", got.x, want.x, 1e-11 * size);
        close_to("y", got.y, want.y, 1e-11 * size);
        close_to("z", got.z, want.z, 1e-11 * size);
    }
    print_message("%d of them the long way round her own space\n", behind);
    assert_true(behind > 100);
}

// She reads a thing at its true distance: the vergence is that of a tourist in her space.
static void born_reads_the_true_distance(void **state) {
    (void)state;
    for (int world = -1; world <= 1; world++)
        for (int born = -1; born <= 1; born++)
            for (double d = 0.1; d < 2.4; d += 0.117) {
                struct ap_viewer v = plain_viewer(world, 0.85, AP_VIEW_BORN, 0.064);
                v.born = (struct ap_space){born, 1.1};
                struct ap_nose_point p = {ap_exp(v.space, (struct ap_vec3){0, 0, -d})};
                struct ap_vec3 line[2];
                for (int e = 0; e < 2; e++)
                    assert_true(ap_sight_line(&v, e, p, 0, &line[e]));
                close_to("vergence", ap_vergence_of(line[0], line[1]),
                         closed_form(v.born, AP_VIEW_TOURIST, 0.032, d), 1e-13);
            }
}

// From the nose both views see along the same geodesics; in s3 the long way round is seen in the
// opposite direction.
static void eyes_at_the_nose_agree_and_images_are_opposite(void **state) {
    (void)state;
    struct dice dice = {7};
    for (int i = 0; i < 1000; i++) {
        struct ap_viewer v = plain_viewer(1, 0.9, AP_VIEW_NATIVE, 0), w = v;
        w.mode = AP_VIEW_TOURIST;
        struct ap_vec3 q = ap_vec3_scale(roll(&dice, 0.1, 2.7), roll_direction(&dice));
        struct ap_vec4 p = ap_exp(v.space, q);
        double a[2], b[2];
        for (int image = 0; image < 2; image++) {
            bool seen = ap_direction(&v, 0, p, image, &a[0], &b[0]);
            assert_int_equal(seen, image ? q.z > 0 : q.z < 0);
            assert_int_equal(seen, ap_direction(&w, 0, p, image, &a[1], &b[1]));
            if (!seen || hypot(a[0], b[0]) > 100)
                continue;
            close_to("a", a[0], q.x / -q.z, 1e-9);
            close_to("tourist a", a[1], q.x / -q.z, 1e-9);
            close_to("b", b[0], q.y / -q.z, 1e-9);
            close_to("tourist b", b[1], q.y / -q.z, 1e-9);
        }
    }
}

static void undefined_directions_are_refused(void **state) {
    (void)state;
    struct ap_viewer v = plain_viewer(1, 1, AP_VIEW_NATIVE, 0.06);
    double a = 5, b = 5;
    assert_false(ap_direction(&v, 0, (struct ap_vec4){0, 0, 0, -1}, 0, &a, &b)); // the antipode
    assert_false(ap_direction(&v, 0, (struct ap_vec4){0, 0, 0, 1}, 1, &a, &b));  // the nose itself
    assert_false(ap_direction(&v, 0, (struct ap_vec4){0, 0, -1, 0}, 2, &a, &b));
    v.space.kappa = -1;
    assert_false(ap_direction(&v, 0, ap_exp(v.space, (struct ap_vec3){0, 0, -1}), 1, &a, &b));
    assert_true(a == 5 && b == 5);
}

static void sight_lines_meet_at_the_target(void **state) {
    (void)state;
    struct ap_vec3 l = {-0.03, 0, 0}, r = {0.03, 0, 0}, target = {0.2, -0.1, -1.5};
    struct ap_vec3 dl = ap_vec3_sub(target, l), dr = ap_vec3_sub(target, r);
    close_to("distance", ap_vergence_distance(l, dl, r, dr), ap_vec3_length(target), 1e-12);
    assert_true(isinf(ap_vergence_distance(l, dl, r, dl))); // parallel
    assert_true(
        isinf(ap_vergence_distance(l, (struct ap_vec3){-1, 0, -1}, r, target))); // diverging
    // Skew lines: halfway between them, one 1 cm higher than the other.
    dl = (struct ap_vec3){0.03, 0.01, -1};
    dr = (struct ap_vec3){-0.03, -0.01, -1};
    double d = ap_vergence_distance(l, dl, r, dr);
    close_to("skew", d, 0.9, 1e-12);
}

static void names(void **state) {
    (void)state;
    enum ap_view_mode mode;
    struct ap_error err = {""};
    assert_int_equal(ap_view_mode_from_name(&err, "tourist", &mode), AP_OK);
    assert_int_equal(mode, AP_VIEW_TOURIST);
    assert_string_equal(ap_view_mode_name(AP_VIEW_NATIVE), "native");
    assert_int_equal(ap_view_mode_from_name(&err, "Native", &mode), AP_USAGE);
    assert_non_null(strstr(err.text, "expected native or tourist"));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(directions_give_the_closed_forms_of_vergence),
        cmocka_unit_test(native_keeps_every_distance),
        cmocka_unit_test(flat_views_are_the_same),
        cmocka_unit_test(born_at_home_is_native_and_tourist),
        cmocka_unit_test(born_elsewhere_looks_along_her_geodesics),
        cmocka_unit_test(born_reads_the_true_distance),
        cmocka_unit_test(eyes_at_the_nose_agree_and_images_are_opposite),
        cmocka_unit_test(undefined_directions_are_refused),
        cmocka_unit_test(sight_lines_meet_at_the_target),
        cmocka_unit_test(names)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
