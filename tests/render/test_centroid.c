// Where the renderer puts a ball, to a fraction of a pixel: the area centroid of its pixels (linear
// light) against that of its exact outline (src/view/silhouette.h), over balls strewn through the
// whole range that is promised: three spaces, both views, rho 0.5…100 m, distances 0.25 m…3 rho,
// asymmetric and canted eyes, radius at least 8 pixels; and small ones down to the 12 pixels that a
// vergence is measured on, with their area.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "src/view/silhouette.h"
#include "tests/render/stage.h"

enum { WIDTH = 520, HEIGHT = 480, BALLS = 8, FRAMES_EACH = 6 };
static const double TOLERANCE_PX = 0.006, SMALL_TOLERANCE_PX = 0.02, AREA_TOLERANCE_PX2 = 0.35;
static bool small_ones; // 3.9 to some 16 pixels across

static int image; // 1: s3's long way round
static uint64_t seed = 20;
static double uniform(double low, double high) {
    seed = seed * 6364136223846793005u + 1442695040888963407u;
    return low + (high - low) * (double)(seed >> 11) / 9007199254740992.0;
}

static struct ap_vec3 random_direction(double cone) {
    double a = uniform(-cone, cone), b = uniform(-cone, cone);
    return ap_vec3_normalize((struct ap_vec3){a, b, -1});
}

static void random_viewer(struct ap_frame_input *input) {
    struct ap_viewer *v = &input->viewer;
    double ipd = uniform(0.054, 0.074);
    for (int e = 0; e < 2; e++) {
        struct ap_quat yaw =
            ap_quat_from_axis_angle((struct ap_vec3){0, 1, 0}, uniform(-0.15, 0.15));
        struct ap_quat pitch =
            ap_quat_from_axis_angle((struct ap_vec3){1, 0, 0}, uniform(-0.05, 0.05));
        v->eye[e].view_from_eye.q = ap_quat_mul(yaw, pitch);
        v->eye[e].view_from_eye.p =
            (struct ap_vec3){(e ? 0.5 : -0.5) * ipd, uniform(-0.01, 0.01), uniform(-0.02, 0.02)};
        v->eye[e].frustum = (struct ap_frustum){-tan(uniform(0.5, 0.9)), tan(uniform(0.5, 0.9)),
                                                tan(uniform(0.5, 0.9)), -tan(uniform(0.5, 0.9))};
    }
    double walk = uniform(0, 1) * v->space.rho_m;
    struct ap_vec3 axis = random_direction(3);
    struct ap_quat turn = ap_quat_from_axis_angle(random_direction(2), uniform(-3, 3));
    v->world_from_nose =
        ap_iso_from_pose(v->space, (struct ap_pose){ap_vec3_scale(walk, axis), turn});
}

struct box {
    double i0, i1, j0, j1, i, j, area_px2; // and the exact centroid and area
};

static bool exact_box(const struct ap_viewer *v, int eye, struct ap_vec4 centre, double radius_m,
                      struct box *box) {
    const struct ap_frustum *f = &v->eye[eye].frustum;
    struct ap_silhouette s;
    if (!ap_ball_silhouette(v, eye, centre, radius_m, image, &s))
        return false;
    double sx = WIDTH / (f->right - f->left), sy = HEIGHT / (f->up - f->down);
    *box = (struct box){
        (s.min_a - f->left) * sx, (s.max_a - f->left) * sx,      (f->up - s.max_b) * sy,
        (f->up - s.min_b) * sy,   (s.centroid_a - f->left) * sx, (f->up - s.centroid_b) * sy,
        s.area * sx * sy};
    double least = small_ones ? 3.9 : 16;
    return box->i0 > 2 && box->i1 < WIDTH - 2 && box->j0 > 2 && box->j1 < HEIGHT - 2 &&
           box->i1 - box->i0 >= least && box->j1 - box->j0 >= least;
}

static bool overlap(const struct box *a, const struct box *b) {
    return a->i0 - 4 < b->i1 && b->i0 - 4 < a->i1 && a->j0 - 4 < b->j1 && b->j0 - 4 < a->j1;
}

static double inverse_sin(int kappa, double s) {
    return kappa > 0 ? asin(s) : kappa < 0 ? asinh(s) : s;
}

// One more ball that both eyes see whole and apart from the others.
static bool place_ball(const struct ap_viewer *v, struct ap_part *part, struct box boxes[2][BALLS],
                       int n, double *distance) {
    double rho = v->space.rho_m;
    double d = exp(uniform(log(0.25), log(3 * rho))),
           angle = (small_ones ? uniform(2, 9) : uniform(9, 70)) / 400;
    double s = sin(angle) * ap_space_sin(v->space, d / rho);
    part->radius_m = rho * inverse_sin(v->space.kappa, s);
    struct ap_iso nose_from_ball =
        ap_iso_translate(v->space, ap_vec3_scale(image ? -d : d, random_direction(1.1)));
    part->carrier_from_part = ap_iso_mul(v->world_from_nose, nose_from_ball);
    struct ap_vec4 base = {0, 0, 0, rho}, centre = ap_iso_apply(&part->carrier_from_part, base);
    *distance = d;
    for (int e = 0; e < 2; e++) {
        if (!exact_box(v, e, centre, part->radius_m, &boxes[e][n]))
            return false;
        for (int k = 0; k < n; k++)
            if (overlap(&boxes[e][n], &boxes[e][k]))
                return false;
    }
    return true;
}

// Coverage-weighted mean position of a box's pixels; white on black.
static double miss(const struct stage *stage, int eye, const struct box *box, double *area_px2) {
    const uint8_t *rgba = stage_eye(stage, eye);
    double sum = 0, i_sum = 0, j_sum = 0;
    for (int j = (int)box->j0 - 2; j <= (int)box->j1 + 2; j++)
        for (int i = (int)box->i0 - 2; i <= (int)box->i1 + 2; i++) {
            if (i < 0 || j < 0 || i >= WIDTH || j >= HEIGHT)
                continue;
            double c = ap_linear_from_srgb(rgba[4 * (j * WIDTH + i)]);
            sum += c;
            i_sum += c * (i + 0.5);
            j_sum += c * (j + 0.5);
        }
    *area_px2 = sum;
    return sum > 0 ? hypot(i_sum / sum - box->i, j_sum / sum - box->j) : INFINITY;
}

struct worst {
    double px, distance_over_rho, rho, area_px2;
    int measured;
};

static void one_frame(struct stage *stage, struct ap_renderer *renderer, struct ap_scene *scene,
                      struct ap_frame_input *input, struct worst *worst) {
    struct box boxes[2][BALLS];
    double distance[BALLS];
    int n = 0;
    for (int i = 0; i < BALLS; i++)
        scene->parts[i].hidden = true;
    for (int attempt = 0; attempt < 400 && n < BALLS; attempt++)
        if (place_ball(&input->viewer, &scene->parts[n], boxes, n, &distance[n]))
            scene->parts[n++].hidden = false;
    stage_draw(stage, renderer, input);
    double rho = input->viewer.space.rho_m;
    for (int k = 0; k < n; k++)
        for (int e = 0; e < 2; e++) {
            double area, px = miss(stage, e, &boxes[e][k], &area);
            worst->area_px2 = fmax(worst->area_px2, fabs(area - boxes[e][k].area_px2));
            worst->measured++;
            if (px > worst->px) {
                worst->px = px;
                worst->distance_over_rho = distance[k] / rho;
                worst->rho = rho;
            }
        }
}

// One space and view; 1 on failure.
static int one_kind(struct stage *stage, struct ap_renderer *renderer, struct ap_scene *scene,
                    int kappa, enum ap_view_mode mode) {
    struct worst worst = {0};
    int frames = mode == AP_VIEW_BORN ? FRAMES_EACH / 2 : FRAMES_EACH;
    for (int f = 0; f < frames; f++) {
        struct ap_frame_input input = {0};
        double rho = f == 0 ? 0.5 : f == 1 ? 100 : exp(uniform(log(0.5), log(100)));
        input.viewer.space = (struct ap_space){kappa, rho};
        input.viewer.mode = mode;
        if (mode == AP_VIEW_BORN) // each of the three spaces in turn
            input.viewer.born = (struct ap_space){f % 3 - 1, rho * uniform(0.5, 3)};
        scene->space = input.viewer.space;
        scene->lamp = (struct ap_vec4){0, 0, 0, rho};
        random_viewer(&input);
        one_frame(stage, renderer, scene, &input, &worst);
    }
    double tolerance = small_ones ? SMALL_TOLERANCE_PX : TOLERANCE_PX;
    bool bad = !(worst.px <= tolerance) || worst.measured < frames ||
               (small_ones && !(worst.area_px2 <= AREA_TOLERANCE_PX2));
    printf(
        "%s image %d %s%s: %d centroids, worst miss %.4f px (tolerance %.3f) at %.3f rho, rho %.3f "
        "m; worst area %.3f px^2 off (small: tolerance %.2f)%s\n",
        ap_space_name((struct ap_space){kappa, 1}), image, ap_view_mode_name(mode),
        small_ones ? " small" : "", worst.measured, worst.px, tolerance, worst.distance_over_rho,
        worst.rho, worst.area_px2, AREA_TOLERANCE_PX2, bad ? "  FAILED" : "");
    return bad;
}

int main(void) {
    struct stage stage;
    if (!stage_open(&stage, WIDTH, HEIGHT, false))
        return 77;
    static const uint8_t white[3] = {255, 255, 255};
    struct ap_part parts[BALLS];
    for (int i = 0; i < BALLS; i++)
        parts[i] = stage_ball((struct ap_space){0, 1}, (struct ap_vec3){0, 0, 0}, 0.1, white);
    struct ap_scene scene = stage_scene((struct ap_space){0, 1}, parts, BALLS);
    struct ap_renderer *renderer = stage_renderer(&stage, &scene, NULL);
    int failures = 0;
    for (int kappa = 1; kappa >= -1; kappa--)
        for (int way = 0; way < (kappa > 0 ? 4 : 2); way++) {
            image = way / 2;
            small_ones = way % 2;
            failures += one_kind(&stage, renderer, &scene, kappa, AP_VIEW_NATIVE);
            failures += one_kind(&stage, renderer, &scene, kappa, AP_VIEW_TOURIST);
            failures += one_kind(&stage, renderer, &scene, kappa, AP_VIEW_BORN);
        }
    ap_renderer_destroy(renderer);
    stage_close(&stage);
    return failures;
}
