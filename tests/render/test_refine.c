// The bound that --max-error promises, held against another way to the same surfaces: over random
// places, points of the triangles that the GPU would draw straight in tangent space are projected
// for both eyes, and so are the points of the true surface that the nose sees in the same direction
// (polygons; closed form) or the exact outline (balls). The distance is in pixels of the picture.
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <stdio.h>
#include <string.h>

#include "src/render/list.h"
#include "src/view/silhouette.h"
#include "tests/render/exact.h"

static const double PI = 3.14159265358979323846;
enum { WIDTH = 1440, HEIGHT = 1600 };

static const uint32_t SIZE_PX[2] = {WIDTH, HEIGHT};
static struct exact_random random_of;

static double uniform(double low, double high) {
    return exact_uniform(&random_of, low, high);
}

static struct ap_iso random_place(struct ap_space space, double least_m, double most_m,
                                  double *distance_m) {
    double d = exp(uniform(log(least_m), log(most_m)));
    struct ap_vec3 u =
        ap_vec3_normalize((struct ap_vec3){uniform(-1, 1), uniform(-1, 1), uniform(-1.2, 0.2)});
    struct ap_quat q = ap_quat_normalize(
        (struct ap_quat){uniform(-1, 1), uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)});
    *distance_m = d;
    return ap_iso_mul(ap_iso_translate(space, ap_vec3_scale(d, u)), ap_iso_rotate(q));
}

static struct ap_vec3 corner(const struct ap_viewer *v, const struct ap_iso *nose_from_part,
                             const struct ap_mesh_data *data, uint32_t index, int image) {
    const float *p = data->vertices[index].position;
    double rho = v->space.rho_m;
    struct ap_vec4 x = {rho * p[0], rho * p[1], rho * p[2], rho * p[3]};
    return ap_log_unchecked(v->space, ap_iso_apply(nose_from_part, x), image);
}

struct tally {
    double worst_px, at_m, rho_m;
    long points, places, held, triangles;
};

// Points of every triangle of a polygon.
static void polygon_errors(const struct ap_viewer *v, const struct ap_iso *nose_from_part,
                           const struct ap_mesh_data *data, int image, struct tally *tally) {
    struct ap_iso part_from_nose = ap_iso_inverse(v->space, *nose_from_part);
    for (size_t i = 0; i + 2 < data->index_count; i += 3) {
        struct ap_vec3 c[3];
        for (int k = 0; k < 3; k++)
            c[k] = corner(v, nose_from_part, data, data->indices[i + (size_t)k], image);
        for (int sample = 0; sample < 1 + (data->index_count < 3000); sample++) {
            double s = sample == 0 ? 1 / 3.0 : uniform(0, 1),
                   t = sample == 0 ? 1 / 3.0 : uniform(0, 1);
            if (s + t > 1)
                s = 1 - s, t = 1 - t;
            struct ap_vec3 flat = ap_vec3_add(
                               ap_vec3_scale(1 - s - t, c[0]),
                               ap_vec3_add(ap_vec3_scale(s, c[1]), ap_vec3_scale(t, c[2]))),
                           truth;
            double d = ap_vec3_length(flat), rho = v->space.rho_m;
            double sine = v->space.kappa > 0 ? fabs(d - PI * rho) : 1;
            if (sine < 2e-3 || !ap_exact_on_plane(v->space, &part_from_nose,
                                                  ap_vec3_scale(1 / d, flat), d, &truth))
                continue;
            for (int e = 0; e < 2; e++) {
                double p[2], q[2];
                if (!ap_exact_pixel(v, SIZE_PX, e, flat, p) ||
                    !ap_exact_pixel(v, SIZE_PX, e, truth, q))
                    continue;
                double px = hypot(p[0] - q[0], p[1] - q[1]);
                tally->points++;
                if (px > tally->worst_px) {
                    tally->worst_px = px;
                    tally->at_m = d;
                    tally->rho_m = rho;
                }
            }
        }
    }
}

// The picture of the mesh reaches as far to each side as the exact outline.
static void ball_errors(const struct ap_viewer *v, const struct ap_iso *nose_from_part,
                        const struct ap_part *part, const struct ap_mesh_data *data, int image,
                        struct tally *tally) {
    double rho = v->space.rho_m, sine = ap_space_sin(v->space, part->radius_m / rho);
    struct ap_vec4 base = {0, 0, 0, rho};
    for (int e = 0; e < 2; e++) {
        const struct ap_frustum *f = &v->eye[e].frustum;
        struct ap_silhouette s;
        double low[2] = {INFINITY, INFINITY}, high[2] = {-INFINITY, -INFINITY};
        if (!ap_ball_silhouette(v, e, ap_iso_apply(nose_from_part, base), part->radius_m, image,
                                &s) ||
            s.min_a < f->left || s.max_a > f->right || s.min_b < f->down || s.max_b > f->up)
            continue;
        for (size_t i = 0; i < data->vertex_count; i++) {
            const float *u = data->vertices[i].position;
            struct ap_vec4 x = {rho * sine * u[0], rho * sine * u[1], rho * sine * u[2],
                                rho * ap_space_cos(v->space, part->radius_m / rho)};
            double p[2];
            ap_exact_pixel(v, SIZE_PX, e,
                           ap_log_unchecked(v->space, ap_iso_apply(nose_from_part, x), image), p);
            for (int k = 0; k < 2; k++) {
                low[k] = fmin(low[k], p[k]);
                high[k] = fmax(high[k], p[k]);
            }
        }
        double sx = WIDTH / (f->right - f->left), sy = HEIGHT / (f->up - f->down);
        double off[4] = {low[0] - (s.min_a - f->left) * sx, (s.max_a - f->left) * sx - high[0],
                         low[1] - (f->up - s.max_b) * sy, (f->up - s.min_b) * sy - high[1]};
        tally->points++;
        for (int k = 0; k < 4; k++)
            if (off[k] > tally->worst_px) {
                tally->worst_px = off[k];
                tally->at_m = ap_vec3_length(
                    ap_log_unchecked(v->space, ap_iso_apply(nose_from_part, base), image));
                tally->rho_m = rho;
            }
    }
}

static void one_place(struct ap_refiner *refiner, int kappa, enum ap_part_kind kind,
                      double max_error_px, struct tally *tally) {
    struct ap_viewer v = exact_viewer(&random_of, kappa, AP_VIEW_NATIVE);
    double rho = v.space.rho_m, distance;
    struct ap_part part = {.kind = kind, .sides = 5, .edge_m = uniform(0.3, 1) * rho};
    int image = kappa > 0 && uniform(0, 1) < 0.4;
    struct ap_refine_params params = {
        .viewer = &v, .image = image, .max_error_px = max_error_px, .triangles_max = 100000};
    struct ap_eyes eyes = ap_eyes_of(&v, WIDTH, HEIGHT);
    params.eyes = &eyes;
    params.nose_from_part = random_place(v.space, 0.01, (kappa > 0 ? 3.1 : 4) * rho, &distance);
    double angle = uniform(0.005, 0.3);
    part.radius_m =
        kappa > 0 ? rho * asin(sin(angle) * fabs(sin(distance / rho))) : distance * angle;
    params.closed = kind == AP_PART_BALL && distance > part.radius_m + 0.05;
    struct ap_mesh_data data = {0};
    struct ap_mesh mesh;
    struct ap_error err;
    bool held;
    uint32_t unseen;
    assert_int_equal(ap_refine_part(&err, refiner, &params, &part, &data, &mesh, &held, &unseen),
                     AP_OK);
    tally->places++;
    tally->held += held;
    tally->triangles += (long)mesh.index_count / 3;
    if (held && kind == AP_PART_POLYGON)
        polygon_errors(&v, &params.nose_from_part, &data, image, tally);
    else if (held)
        ball_errors(&v, &params.nose_from_part, &part, &data, image, tally);
    ap_mesh_data_finish(&data);
}

static void bound_holds(void **state) {
    (void)state;
    static const double BOUNDS[] = {0.25, 0.05};
    struct ap_refiner refiner = {0};
    random_of.seed = 7;
    for (int b = 0; b < 2; b++)
        for (int kappa = 1; kappa >= -1; kappa--)
            for (int kind = 0; kind < 2; kind++) {
                struct tally tally = {0};
                for (int i = 0; i < 40; i++)
                    one_place(&refiner, kappa, kind ? AP_PART_POLYGON : AP_PART_BALL, BOUNDS[b],
                              &tally);
                printf("%s %s: worst %.4f px of %.2f over %ld points (at %.3f m, rho %.3f m), "
                       "held in %ld of %ld places, %.0f triangles a place\n",
                       ap_space_name((struct ap_space){kappa, 1}), kind ? "polygons" : "balls",
                       tally.worst_px, BOUNDS[b], tally.points, tally.at_m, tally.rho_m, tally.held,
                       tally.places, (double)tally.triangles / (double)tally.places);
                assert_true(tally.points > 8);
                assert_true(tally.held > tally.places * 9 / 10);
                if (!(tally.worst_px <= BOUNDS[b]))
                    fail_msg("%.4f px, allowed %.2f", tally.worst_px, BOUNDS[b]);
            }
    ap_refiner_finish(&refiner);
}

// A plane's part at the nose's foot is the same plane, and the foot its place: so far from the nose
// as the plane is, and straight across from it.
static void foot_is_on_plane(void **state) {
    (void)state;
    random_of.seed = 11;
    for (int i = 0; i < 300; i++) {
        struct ap_space space = {1, exp(uniform(-2, 2))};
        double rho = space.rho_m, distance;
        struct ap_iso m = random_place(space, 1e-9 * rho, 3 * rho, &distance);
        struct ap_iso n = ap_iso_mul(m, ap_plane_foot(space, &m));
        struct ap_iso m_inverse = ap_iso_inverse(space, m), n_inverse = ap_iso_inverse(space, n);
        double off = 0;
        for (int k = 0; k < 4; k++) // the normal, and how high the nose is above it
            off = fmax(off, fabs(m.m[k][1] - n.m[k][1]));
        off = fmax(off, fabs(m_inverse.m[1][3] - n_inverse.m[1][3]));
        off = fmax(off, hypot(n_inverse.m[0][3], n_inverse.m[2][3]));
        if (!(off < 2e-15))
            fail_msg("place %d: %g, allowed 2e-15", i, off);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(bound_holds),
                                       cmocka_unit_test(foot_is_on_plane)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
