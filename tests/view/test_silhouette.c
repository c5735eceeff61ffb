#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>

#include <cmocka.h>

#include "src/view/silhouette.h"
#include "tests/samples.h"
#include "tests/view/random.h"

// The outline, found in another way: along the line of sight the nearest that it comes to the
// ball's centre is searched, and for each azimuth about the centre's direction the angle where that
// is the ball's radius is bisected. In tourist view the line of sight is a geodesic from the eye.
enum { AZIMUTHS = 32, SCAN = 24, GOLDEN = 34, BISECT = 34 };

struct sight {
    const struct ap_viewer *viewer;
    int eye, image;
    struct ap_vec4 centre;
    double centre_d; // as seen
    double radius;
};

static double distance_at(const struct sight *s, struct ap_vec3 dir, double t) {
    const struct ap_viewer *v = s->viewer;
    struct ap_pose pose = v->eye[s->eye].view_from_eye;
    struct ap_vec4 p;
    if (v->mode == AP_VIEW_TOURIST) {
        struct ap_iso nose_from_eye = ap_iso_from_pose(v->space, pose);
        p = ap_iso_apply(&nose_from_eye, ap_exp(v->space, ap_vec3_scale(t, dir)));
    } else if (v->mode == AP_VIEW_BORN) {
        // A geodesic of her space, brought back through both maps.
        struct ap_iso nose_from_eye = ap_iso_from_pose(v->born, pose);
        p = ap_iso_apply(&nose_from_eye, ap_exp(v->born, ap_vec3_scale(t, dir)));
        p = ap_exp(v->space, ap_log_unchecked(v->born, p, 0));
    } else {
        p = ap_exp(v->space, ap_pose_apply(pose, ap_vec3_scale(t, dir)));
    }
    p = ap_iso_apply(&v->world_from_nose, p);
    double d = NAN;
    if (ap_distance(NULL, v->space, p, s->centre, &d))
        return INFINITY;
    return d;
}

static double nearest(const struct sight *s, double a, double b) {
    struct ap_vec3 dir = ap_vec3_normalize((struct ap_vec3){a, b, -1});
    double reach = s->radius * 3 + 0.1, best = INFINITY, at = 0;
    double lo = fmax(s->centre_d - reach, 0), hi = s->centre_d + reach;
    if (s->viewer->mode == AP_VIEW_BORN && s->viewer->born.kappa > 0)
        hi = fmin(hi, (M_PI - 0.03) * s->viewer->born.rho_m);
    if (s->viewer->space.kappa > 0) { // the other image is another outline
        double half = M_PI * s->viewer->space.rho_m;
        lo = s->image ? fmax(lo, half) : lo;
        hi = s->image ? fmin(hi, 2 * half) : fmin(hi, half);
    }
    double step = (hi - lo) / SCAN;
    for (int i = 0; i <= SCAN; i++) {
        double d = distance_at(s, dir, lo + i * step);
        if (d < best) {
            best = d;
            at = lo + i * step;
        }
    }
    double l = at - step, r = at + step, g = 0.6180339887498949;
    for (int i = 0; i < GOLDEN; i++) {
        double m1 = r - g * (r - l), m2 = l + g * (r - l);
        if (distance_at(s, dir, m1) < distance_at(s, dir, m2))
            r = m2;
        else
            l = m1;
    }
    return distance_at(s, dir, (l + r) / 2);
}

static double outline_radius(const struct sight *s, double a, double b, double phi) {
    double lo = 0, hi = 1e-3, c = cos(phi), d = sin(phi);
    while (nearest(s, a + hi * c, b + hi * d) < s->radius && hi < 100)
        lo = hi, hi *= 1.5;
    for (int i = 0; i < BISECT; i++) {
        double m = (lo + hi) / 2;
        if (nearest(s, a + m * c, b + m * d) < s->radius)
            lo = m;
        else
            hi = m;
    }
    return (lo + hi) / 2;
}

// In polar coordinates about the centre's direction the integrals are sums over a smooth periodic
// function.
static struct ap_silhouette by_rays(const struct sight *s, double a, double b) {
    struct ap_silhouette out = {.centre_a = a, .centre_b = b};
    double ma = 0, mb = 0;
    for (int i = 0; i < AZIMUTHS; i++) {
        double phi = 2 * M_PI * i / AZIMUTHS, r = outline_radius(s, a, b, phi);
        out.area += r * r / 2 * (2 * M_PI / AZIMUTHS);
        ma += r * r * r / 3 * cos(phi) * (2 * M_PI / AZIMUTHS);
        mb += r * r * r / 3 * sin(phi) * (2 * M_PI / AZIMUTHS);
    }
    out.centroid_a = a + ma / out.area;
    out.centroid_b = b + mb / out.area;
    return out;
}

struct example {
    int kappa, image;
    struct ap_vec3 at; // tangent vector from the nose, over rho
    double radius;     // over rho
};

static const struct example examples[] = {
    {-1, 0, {0.05, 0.1, -0.3}, 0.05}, {-1, 0, {0.2, -0.1, -0.5}, 0.3},
    {-1, 0, {-0.8, 0.5, -2.5}, 0.4},  {-1, 0, {1.5, 0.0, -4.0}, 0.05},
    {0, 0, {0.1, 0.05, -0.3}, 0.08},  {0, 0, {-0.9, 0.4, -1.2}, 0.3},
    {1, 0, {0.05, 0.1, -0.3}, 0.05},  {1, 0, {0.5, 0.5, -1.2}, 0.4},
    {1, 0, {-0.6, 0.2, -2.5}, 0.2},   {1, 0, {0.2, 0.1, -3.0}, 0.05},
    {1, 1, {0.1, -0.1, 2.9}, 0.06},   {1, 1, {0.3, 0.2, 1.2}, 0.3},
    {1, 1, {-0.2, 0.05, 0.6}, 0.1},
};

static struct ap_viewer viewer_of(int kappa, enum ap_view_mode mode) {
    struct dice dice = {77};
    struct ap_viewer v = roll_viewer(&dice, kappa, mode);
    v.space.rho_m = 0.85;
    v.world_from_nose =
        ap_iso_mul(ap_iso_translate(v.space, (struct ap_vec3){0.3, 0.5, -0.4}),
                   ap_iso_rotate(ap_quat_from_axis_angle((struct ap_vec3){0.6, 0.8, 0}, 0.7)));
    return v;
}

static struct sight sight_of(const struct ap_viewer *v, const struct example *x, int eye) {
    struct ap_vec4 nose = ap_exp(v->space, ap_vec3_scale(v->space.rho_m, x->at));
    double d = ap_vec3_length(x->at);
    return (struct sight){.viewer = v,
                          .eye = eye,
                          .image = x->image,
                          .centre = ap_iso_apply(&v->world_from_nose, nose),
                          .centre_d = (x->image ? 2 * M_PI - d : d) * v->space.rho_m,
                          .radius = x->radius * v->space.rho_m};
}

static void close_to(const char *what, double got, double expected, double tolerance) {
    if (!(fabs(got - expected) <= tolerance)) {
        print_error("%s: %.12g, expected %.12g within %g\n", what, got, expected, tolerance);
        fail();
    }
}

static void outlines_agree_with_lines_of_sight(void **state) {
    (void)state;
    double worst = 0;
    const int count = sizeof examples / sizeof *examples, step = count / test_samples(count);
    for (int i = 0; i < count; i += step)
        for (int k = 0; k < 4; k++) {
            // Two modes, and two that are born in h3 and in s3.
            int mode = k < 2 ? k : AP_VIEW_BORN, eye = i / step % 2;
            struct ap_viewer v = viewer_of(examples[i].kappa, (enum ap_view_mode)mode);
            v.born = (struct ap_space){k == 2 ? -1 : 1, k == 2 ? 0.7 : 1.6};
            struct sight s = sight_of(&v, &examples[i], eye);
            struct ap_silhouette got;
            print_message("example %d %s\n", i, ap_view_mode_name((enum ap_view_mode)mode));
            if (k == 3 && (s.image == 1 || s.centre_d + 2 * s.radius > 3.1 * v.born.rho_m))
                continue; // beyond what her space holds on this side of its antipode
            assert_true(ap_ball_silhouette(&v, eye, s.centre, s.radius, s.image, &got));
            struct ap_silhouette want = by_rays(&s, got.centre_a, got.centre_b);
            double size = sqrt(want.area);
            close_to("centroid a", got.centroid_a, want.centroid_a, 1e-6 * size);
            close_to("centroid b", got.centroid_b, want.centroid_b, 1e-6 * size);
            close_to("area", got.area, want.area, 2e-6 * want.area);
            assert_true(got.min_a < got.centroid_a && got.centroid_a < got.max_a);
            assert_true(got.min_b < got.centroid_b && got.centroid_b < got.max_b);
            worst = fmax(worst,
                         hypot(got.centroid_a - want.centroid_a, got.centroid_b - want.centroid_b) /
                             size);
        }
    print_message("worst centroid error: %.2g of the outline's size\n", worst);
}

// In flat space there is one way to see; the outline on the ball's surface and the cone must agree.
static void flat_views_agree(void **state) {
    (void)state;
    struct dice dice = {4242};
    double worst = 0;
    int count = 0;
    for (int i = 0; i < 2000; i++) {
        struct ap_viewer native = roll_viewer(&dice, 0, AP_VIEW_NATIVE), tourist = native;
        tourist.mode = AP_VIEW_TOURIST;
        struct ap_vec3 at = {roll(&dice, -1, 1), roll(&dice, -1, 1), roll(&dice, -3, -0.1)};
        double radius = exp(roll(&dice, log(1e-4), log(0.5)));
        struct ap_vec4 p = ap_exp(native.space, at);
        struct ap_silhouette a, b;
        bool seen = ap_ball_silhouette(&native, i % 2, p, radius, 0, &a);
        if (!seen || !ap_ball_silhouette(&tourist, i % 2, p, radius, 0, &b))
            continue;
        count++;
        double size = sqrt(b.area);
        double error = hypot(a.centroid_a - b.centroid_a, a.centroid_b - b.centroid_b) / size;
        worst = fmax(worst, error);
        close_to("centroid", error, 0, 1e-6);
        close_to("area", a.area, b.area, 1e-6 * b.area);
        close_to("min a", a.min_a, b.min_a, 1e-4 * size);
        close_to("max a", a.max_a, b.max_a, 1e-4 * size);
        close_to("min b", a.min_b, b.min_b, 1e-4 * size);
        close_to("max b", a.max_b, b.max_b, 1e-4 * size);
    }
    print_message("%d balls, worst difference %.2g of the outline's size\n", count, worst);
    assert_true(count > 500);
}

// native is native-of e3, tourist native-of the world's own space, outline by outline.
static void born_at_home_is_the_same(void **state) {
    (void)state;
    double worst = 0;
    int count = 0;
    for (size_t i = 0; i < sizeof examples / sizeof *examples; i++)
        for (int mode = AP_VIEW_NATIVE; mode <= AP_VIEW_TOURIST; mode++) {
            struct ap_viewer v = viewer_of(examples[i].kappa, (enum ap_view_mode)mode), w = v;
            w.mode = AP_VIEW_BORN;
            w.born = mode == AP_VIEW_NATIVE ? (struct ap_space){0, 7} : v.space;
            struct sight s = sight_of(&v, &examples[i], 1);
            struct ap_silhouette a, b;
            bool seen = ap_ball_silhouette(&v, 1, s.centre, s.radius, s.image, &a);
            if (!seen || !ap_ball_silhouette(&w, 1, s.centre, s.radius, s.image, &b))
                continue;
            count++;
            double size = sqrt(a.area);
            double off = hypot(a.centroid_a - b.centroid_a, a.centroid_b - b.centroid_b) / size;
            worst = fmax(worst, off);
            close_to("centroid", off, 0, 1e-7);
            close_to("area", b.area / a.area, 1, 1e-7);
            close_to("centre a", b.centre_a, a.centre_a, 1e-11);
        }
    print_message("%d outlines, worst difference %.2g of the outline's size\n", count, worst);
    assert_true(count >= 22);
}

// Pixel counting, coarse but without any idea of what an outline is.
static void outline_agrees_with_counted_pixels(void **state) {
    (void)state;
    struct ap_viewer v = viewer_of(1, AP_VIEW_NATIVE);
    struct sight s = sight_of(&v, &examples[8], 0);
    struct ap_silhouette o;
    assert_true(ap_ball_silhouette(&v, 0, s.centre, s.radius, 0, &o));
    enum { SIDE = 60 };
    double w = (o.max_a - o.min_a) * 1.2, h = (o.max_b - o.min_b) * 1.2;
    double a0 = (o.min_a + o.max_a - w) / 2, b0 = (o.min_b + o.max_b - h) / 2;
    double count = 0, sum_a = 0, sum_b = 0;
    for (int j = 0; j < SIDE; j++)
        for (int i = 0; i < SIDE; i++) {
            double a = a0 + w * (i + 0.5) / SIDE, b = b0 + h * (j + 0.5) / SIDE;
            if (nearest(&s, a, b) >= s.radius)
                continue;
            count++;
            sum_a += a;
            sum_b += b;
        }
    close_to("area", count * w * h / (SIDE * SIDE), o.area, 1e-2 * o.area);
    close_to("centroid a", sum_a / count, o.centroid_a, 5e-3 * w);
    close_to("centroid b", sum_b / count, o.centroid_b, 5e-3 * h);
}

static void refuses_what_has_no_outline(void **state) {
    (void)state;
    for (int mode = AP_VIEW_NATIVE; mode <= AP_VIEW_TOURIST; mode++)
        for (int kappa = -1; kappa <= 1; kappa++) {
            struct ap_viewer v = viewer_of(kappa, (enum ap_view_mode)mode);
            v.world_from_nose = AP_ISO_IDENTITY;
            struct ap_silhouette out = {.area = -1};
            struct ap_vec4 near = ap_exp(v.space, (struct ap_vec3){0, 0, -0.1});
            struct ap_vec4 behind = ap_exp(v.space, (struct ap_vec3){0, 0, 0.5});
            assert_false(ap_ball_silhouette(&v, 0, near, 0.2, 0, &out)); // the eye is inside
            assert_false(ap_ball_silhouette(&v, 0, behind, 0.05, 0, &out));
            assert_false(ap_ball_silhouette(&v, 0, near, 0, 0, &out));
            if (kappa <= 0)
                assert_false(ap_ball_silhouette(&v, 0, near, 0.01, 1, &out));
            else
                assert_true(ap_ball_silhouette(&v, 0, behind, 0.05, 1, &out));
            assert_true(kappa > 0 || out.area == -1);
        }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(outlines_agree_with_lines_of_sight),
                                       cmocka_unit_test(flat_views_agree),
                                       cmocka_unit_test(born_at_home_is_the_same),
                                       cmocka_unit_test(outline_agrees_with_counted_pixels),
                                       cmocka_unit_test(refuses_what_has_no_outline)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
