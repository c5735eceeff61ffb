// What the pictures show of light against the double reference: a white polygon with balls on it,
// in the three spaces and from several places; every pixel that shows it is held against
// src/view/light.h at the exact point that its ray meets. And what is painted: numbers, stripes,
// pockets.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "src/view/light.h"
#include "tests/render/stage.h"

enum { SIDE = 240, BALLS = 3 };
static int failures;

static void expect(bool good, const char *what, double got, double want, double tolerance) {
    if (good)
        return;
    printf("FAILED: %s: %.6g, expected %.6g within %.3g\n", what, got, want, tolerance);
    failures++;
}

static const struct ap_space SPACES[3] = {{1, 0.6}, {0, 1}, {-1, 0.85}};

static struct ap_part white_sheet(struct ap_space space) {
    struct ap_part part = {.kind = AP_PART_POLYGON,
                           .carrier_from_part = AP_ISO_IDENTITY,
                           .sides = 5,
                           .edge_m = 0.9 * fmin(space.rho_m, 1),
                           .color_srgb = {1, 1, 1},
                           .lit = true,
                           .finish = AP_FINISH_MATTE,
                           .takes_marks = true};
    return part;
}

static struct ap_part ball_on_sheet(struct ap_space space, int k) {
    static const uint8_t red[3] = {255, 0, 0};
    static const double at[BALLS][2] = {{0.1, 0.05}, {-0.16, -0.1}, {0.02, -0.2}};
    struct ap_iso foot = ap_iso_translate(space, (struct ap_vec3){at[k][0], 0, at[k][1]});
    double r = 0.02 + 0.012 * k;
    struct ap_part part = stage_ball(space, (struct ap_vec3){0, 0, 0}, r, red);
    part.carrier_from_part = ap_iso_mul(foot, ap_iso_translate(space, (struct ap_vec3){0, r, 0}));
    part.casts_shadow = true;
    return part;
}

// Where the ray of a pixel meets the plane y = 0 of the world: the eye is the nose here, so it is a
// geodesic. False where it does not.
static bool meet(const struct ap_viewer *v, double a, double b, struct ap_vec4 *at) {
    double rho = v->space.rho_m;
    struct ap_vec3 u = ap_vec3_normalize((struct ap_vec3){a, b, -1});
    struct ap_vec4 here = ap_iso_apply(&v->world_from_nose, (struct ap_vec4){0, 0, 0, rho});
    struct ap_vec4 way = ap_iso_apply(&v->world_from_nose, (struct ap_vec4){u.x, u.y, u.z, 0});
    // C·here + rho·S·way has y = 0.
    double t = -here.y / (rho * way.y); // S/C
    if (!(t > 0))
        return false;
    double d = v->space.kappa > 0 ? atan(t) : v->space.kappa < 0 ? (t < 1 ? atanh(t) : NAN) : t;
    if (!(d > 0))
        return false;
    *at = ap_iso_apply(&v->world_from_nose, ap_exp(v->space, ap_vec3_scale(d * rho, u)));
    return true;
}

static double reference(const struct ap_scene *scene, const struct ap_viewer *v,
                        struct ap_vec4 at) {
    struct ap_lamp lamp = {scene->lamp, scene->lamp_reach_m, scene->lamp_radius_m};
    struct ap_lit_point point = {at, {0, 1, 0, 0}};
    struct ap_vec4 nose =
        ap_iso_apply(&v->world_from_nose, (struct ap_vec4){0, 0, 0, v->space.rho_m});
    double hidden = 0, left = 1;
    for (size_t i = 0; i < scene->part_count; i++) {
        const struct ap_part *p = &scene->parts[i];
        if (!p->casts_shadow)
            continue;
        struct ap_vec4 ball =
            ap_iso_apply(&p->carrier_from_part, (struct ap_vec4){0, 0, 0, v->space.rho_m});
        struct ap_hidden h = ap_hidden_by_ball(v->space, &lamp, &point, ball, p->radius_m);
        hidden += h.surroundings;
        left *= 1 - h.lamp;
    }
    return ap_surface_strength(v->space, &lamp, &point, nose, hidden, left);
}

struct tally {
    int pixels, dark, off; // off: by more than 2 of 255
    double worst, sum;
};

// White where the sheet is: grey, and no edge nearby.
static bool plain_sheet(const uint8_t *rgba, int i, int j) {
    for (int y = j - 2; y <= j + 2; y++)
        for (int x = i - 2; x <= i + 2; x++) {
            const uint8_t *p = rgba + 4 * (y * SIDE + x);
            if (p[0] != p[1] || p[1] != p[2] || p[0] < 20)
                return false;
        }
    return true;
}

static void compare(const uint8_t *rgba, const struct ap_scene *scene, const struct ap_viewer *v,
                    struct tally *tally) {
    const struct ap_frustum *f = &v->eye[0].frustum;
    for (int j = 2; j < SIDE - 2; j++)
        for (int i = 2; i < SIDE - 2; i++) {
            struct ap_vec4 at;
            double a = f->left + (f->right - f->left) * (i + 0.5) / SIDE;
            double b = f->up - (f->up - f->down) * (j + 0.5) / SIDE;
            if (!plain_sheet(rgba, i, j) || !meet(v, a, b, &at))
                continue;
            double want = reference(scene, v, at);
            if (want > 0.98)
                continue; // cut at white
            double got = rgba[4 * (j * SIDE + i)], miss;
            miss = fabs(got - ap_srgb_from_linear(want));
            tally->pixels++;
            tally->dark += want < 0.3;
            tally->off += miss > 2;
            tally->sum += miss;
            tally->worst = fmax(tally->worst, miss);
        }
}

static void sheet_is_lit_as_it_should_be(struct stage *stage) {
    for (int s = 0; s < 3; s++) {
        struct ap_space space = SPACES[s];
        struct ap_part parts[1 + BALLS] = {white_sheet(space)};
        for (int k = 0; k < BALLS; k++)
            parts[1 + k] = ball_on_sheet(space, k);
        struct ap_scene scene = stage_scene(space, parts, 1 + BALLS);
        scene.lamp = ap_exp(space, (struct ap_vec3){0.12, 0.42, -0.05});
        scene.lamp_reach_m = 0.5;
        scene.lamp_radius_m = 0.02;
        struct ap_renderer *renderer = stage_renderer(stage, &scene, NULL);
        struct tally tally = {0};
        for (int k = 0; k < 6; k++) {
            enum ap_view_mode mode = k % 2 ? AP_VIEW_TOURIST : AP_VIEW_NATIVE;
            struct ap_frame_input input = stage_input(space, mode, 0.7, 0);
            struct ap_quat yaw =
                ap_quat_from_axis_angle((struct ap_vec3){0, 1, 0}, 2 * 3.14159265 * k / 6);
            struct ap_vec3 back = ap_quat_rotate(yaw, (struct ap_vec3){0, 0.35, 0.4});
            struct ap_quat down =
                ap_quat_from_axis_angle((struct ap_vec3){1, 0, 0}, -0.7 - 0.05 * k);
            input.viewer.world_from_nose =
                ap_iso_from_pose(space, (struct ap_pose){back, ap_quat_mul(yaw, down)});
            stage_draw(stage, renderer, &input);
            compare(stage_eye(stage, 0), &scene, &input.viewer, &tally);
        }
        double mean = tally.sum / tally.pixels;
        printf("%s: %d pixels, %d of them dark: mean miss %.3f of 255, worst %.0f, %d over 2\n",
               ap_space_name(space), tally.pixels, tally.dark, mean, tally.worst, tally.off);
        expect(tally.pixels > 50000 && tally.dark > 300, "pixels", tally.pixels, 50000, 0);
        // At a shadow's edge a millimetre is 20 of 255; what is interpolated is the surface's own.
        expect(tally.worst <= 4, "worst pixel", tally.worst, 0, 4);
        expect(tally.off < tally.pixels / 20000, "pixels off", tally.off, 0,
               tally.pixels / 20000.0);
        expect(mean < 0.2, "mean", mean, 0, 0.2);
        ap_renderer_destroy(renderer);
    }
}

// One ball before the eye, its number toward it.
static void draw_ball(struct stage *stage, struct ap_part part, const uint8_t *decal,
                      uint8_t *pixels) {
    struct ap_scene scene = stage_scene(SPACES[2], &part, 1);
    scene.lamp = ap_exp(SPACES[2], (struct ap_vec3){0, 0.4, -0.4}); // its gloss not on the number
    struct ap_renderer_params how = {.decals = decal, .decal_px = 8, .decal_count = decal ? 1 : 0};
    struct ap_renderer *renderer = stage_renderer(stage, &scene, &how);
    struct ap_frame_input input = stage_input(SPACES[2], AP_VIEW_NATIVE, 0.3, 0.06);
    stage_draw(stage, renderer, &input);
    memcpy(pixels, stage_eye(stage, 0), 4 * SIDE * SIDE);
    ap_renderer_destroy(renderer);
}

static int count_color(const uint8_t *p, bool (*like)(const uint8_t *)) {
    int n = 0;
    for (int k = 0; k < SIDE * SIDE; k++)
        n += like(p + 4 * k);
    return n;
}

static bool is_blue(const uint8_t *p) {
    return p[2] > 40 && p[2] > 2 * p[0];
}
static bool is_white(const uint8_t *p) {
    return p[0] > 90 && p[1] > 80 && p[2] > 70 && p[2] < p[0] + 3;
}
static bool is_ink(const uint8_t *p) {
    return p[0] < 70 && p[0] > 2 && abs(p[0] - p[2]) < 25;
}

static void balls_bear_what_they_should(struct stage *stage) {
    static const uint8_t blue[3] = {20, 40, 255};
    static uint8_t plain[4 * SIDE * SIDE], bare[4 * SIDE * SIDE], full[4 * SIDE * SIDE],
        striped[4 * SIDE * SIDE];
    uint8_t decal[64]; // a black square in the middle
    for (int k = 0; k < 64; k++)
        decal[k] = k % 8 > 1 && k % 8 < 6 && k / 8 > 1 && k / 8 < 6 ? 255 : 0;
    struct ap_part ball = stage_ball(SPACES[2], (struct ap_vec3){0, 0, -0.4}, 0.08, blue);
    ball.lit = true;
    ball.finish = AP_FINISH_POOL;
    draw_ball(stage, ball, NULL, plain);
    ball.decal = 1;
    draw_ball(stage, ball, NULL, bare);
    draw_ball(stage, ball, decal, full);
    ball.finish = AP_FINISH_STRIPED;
    draw_ball(stage, ball, decal, striped);
    int area = count_color(plain, is_blue);
    expect(area > 3000, "a blue ball", area, 3000, 0);
    expect(count_color(plain, is_white) < area / 8, "white on it but gloss",
           count_color(plain, is_white), 0, area / 8.0);
    int white = count_color(bare, is_white), ink = count_color(full, is_ink);
    expect(white > area / 10, "a white disc", white, area / 10.0, 0);
    expect(ink > white / 6 && ink < white, "a black square in it", ink, white / 3.0, white / 6.0);
    expect(count_color(bare, is_ink) < ink / 4, "no ink without a text", count_color(bare, is_ink),
           0, ink / 4.0);
    int poles = count_color(striped, is_white) - count_color(full, is_white);
    expect(poles > area / 8, "white poles beside the band", poles, area / 4.0, 0);
}

// An unlit part is what it was, whatever it is said to be made of.
static void unlit_stays_as_given(struct stage *stage) {
    static uint8_t pixels[4 * SIDE * SIDE];
    static const uint8_t color[3] = {13, 200, 77};
    for (int finish = AP_FINISH_PLAIN; finish <= AP_FINISH_STRIPED; finish++) {
        struct ap_part ball = stage_ball(SPACES[2], (struct ap_vec3){0, 0, -0.4}, 0.08, color);
        ball.finish = (enum ap_finish)finish;
        draw_ball(stage, ball, NULL, pixels);
        const uint8_t *p = pixels + 4 * (SIDE / 2 * SIDE + SIDE / 2);
        expect(memcmp(p, color, 3) == 0, "unlit green", p[1], color[1], 0);
    }
}

int main(void) {
    struct stage stage;
    if (!stage_open(&stage, SIDE, SIDE, true))
        return 77;
    sheet_is_lit_as_it_should_be(&stage);
    balls_bear_what_they_should(&stage);
    unlit_stays_as_given(&stage);
    expect(stage.validation_errors == 0, "validation", stage.validation_errors, 0, 0);
    stage_close(&stage);
    return failures != 0;
}
