#include "src/scene/build.h"

#include <stdio.h>
#include <string.h>

enum { RACK = 15, ROWS = 5 };

static const unsigned cue_ball_rgb = 0xfbf7ea;

// Numbers 1 to 8; 9 to 15 are white with a stripe of 1 to 7.
static const unsigned ball_rgb[8] = {0xf2b705, 0x1d3fa8, 0xc8201e, 0x5b2a86,
                                     0xe5661a, 0x14713f, 0x7b1f26, 0x15151a};

// The usual rack: the eight in the middle, a full and a striped ball in the back corners.
static const int rack[RACK] = {1, 9, 2, 10, 8, 3, 11, 4, 12, 5, 6, 13, 14, 7, 15};

// A ball that lies on the felt, its foot at the tangent vector (x, 0, z).
static struct ap_iso resting(struct ap_space space, double x, double z, double radius_m) {
    return ap_iso_mul(ap_shift(space, x, 0, z), ap_shift(space, 0, radius_m, 0));
}

// Feet of the rack for a spacing in tangent space, the apex toward +z.
static void rack_feet(double spacing_m, double middle_z, struct ap_vec3 feet[RACK]) {
    int i = 0;
    for (int row = 0; row < ROWS; row++)
        for (int k = 0; k <= row; k++, i++)
            feet[i] = (struct ap_vec3){(k - row / 2.0) * spacing_m, 0,
                                       middle_z + (ROWS * 2 / 3.0 - 2 / 3.0 - row) * spacing_m *
                                                      sqrt(0.75)};
}

static double closest_feet(struct ap_space space, const struct ap_vec3 feet[RACK]) {
    double least = INFINITY;
    for (int i = 0; i < RACK; i++)
        for (int j = 0; j < i; j++) {
            struct ap_vec4 p = ap_exp(space, feet[i]), q = ap_exp(space, feet[j]);
            double d;
            if (!ap_distance(NULL, space, p, q, &d))
                least = fmin(least, d);
        }
    return least;
}

// Two balls on the plane touch where their feet are this far apart.
static double touching_feet(struct ap_space space, double s) {
    double t = s / space.rho_m, rho = space.rho_m;
    if (space.kappa > 0)
        return 2 * rho * asin(fmin(tan(t), 1));
    return space.kappa < 0 ? 2 * rho * asinh(tanh(t)) : 2 * s;
}

static void add_pool_ball(struct ap_scene_build *build, struct ap_iso place, double radius_m,
                          int number) {
    // Every ball lies differently, its number where somebody who walks round may see it.
    struct ap_vec3 axis = ap_vec3_normalize((struct ap_vec3){1, 0.25 * (number % 5 - 2), 0.3});
    struct ap_iso turn =
        ap_iso_mul(ap_iso_rotate_y(2.4 * number),
                   ap_iso_rotate(ap_quat_from_axis_angle(axis, -0.45 - 0.11 * (number % 7))));
    char text[8];
    snprintf(text, sizeof text, "%d", number);
    struct ap_part part =
        ap_ball_part(ap_iso_mul(place, turn), radius_m, ball_rgb[(number - 1) % 8]);
    part.finish = number > 8 ? AP_FINISH_STRIPED : AP_FINISH_POOL;
    part.decal = ap_build_decal(build, text);
    part.casts_shadow = true;
    part.pool_ball = 1 + number;
    ap_build_part(build, part);
}

static void add_rack(struct ap_scene_build *build, double radius_m) {
    const struct ap_table_shape *t = &build->table;
    struct ap_vec3 feet[RACK];
    double gap = touching_feet(t->space, radius_m) * 1.002, spacing = gap;
    // A triangular lattice fits a flat plane only: spread it until the closest two do not overlap.
    for (int i = 0; i < 4; i++) {
        rack_feet(spacing, -0.28 * t->inradius_m, feet);
        spacing *= gap / closest_feet(t->space, feet);
    }
    rack_feet(spacing, -0.28 * t->inradius_m, feet);
    for (int i = 0; i < RACK; i++) {
        add_pool_ball(build, resting(t->space, feet[i].x, feet[i].z, radius_m), radius_m, rack[i]);
        build->object++;
    }
}

static void add_balls(struct ap_scene_build *build) {
    const struct ap_table_shape *t = &build->table;
    double radius = ap_pool_ball_radius(t);
    add_rack(build, radius);
    struct ap_part cue_ball =
        ap_ball_part(resting(t->space, 0, 0.6 * t->inradius_m, radius), radius, cue_ball_rgb);
    cue_ball.finish = AP_FINISH_POOL;
    cue_ball.casts_shadow = true;
    cue_ball.pool_ball = 1;
    ap_build_part(build, cue_ball);
    build->object++;
}

// What vergence is measured on: unlit balls, each of its own colour, from an arm's length to where
// things get small. Metres; in s3, where the whole way round is 3.6 m for the default table, they
// hang nearer.
static void add_lanterns(struct ap_scene_build *build) {
    static const struct {
        const char *name;
        struct ap_vec3 at;
        double radius;
        unsigned rgb;
    } lantern[] = {
        {"red", {-0.22, 0.26, 0.06}, 0.020, 0xff2a2a},
        {"cyan", {0.30, 0.42, -0.22}, 0.024, 0x22e0ff},
        {"lamp", {0.00, 0.95, 0.00}, 0.030, 0xffe9a8},
        {"magenta", {-0.80, 0.42, 0.50}, 0.036, 0xff3cf0},
        {"lime", {0.85, 0.50, 0.75}, 0.040, 0x86ff2a},
        {"orange", {-0.35, 0.60, -1.55}, 0.070, 0xff8a10},
        {"azure", {1.20, 0.35, -1.40}, 0.070, 0x3c7dff},
    };
    struct ap_space space = build->scene->space;
    // Of the table's size; in s3 nothing is farther than pi·rho.
    double unit = build->table.edge_m / 0.9 * (space.kappa > 0 ? 0.42 : 1);
    for (size_t i = 0; i < sizeof lantern / sizeof *lantern; i++) {
        struct ap_vec3 at = ap_vec3_scale(unit, lantern[i].at);
        double radius = lantern[i].radius * fmin(1, build->table.edge_m / 0.9);
        struct ap_part part = ap_ball_part(ap_iso_translate(space, at), radius, lantern[i].rgb);
        part.lit = false;
        part.target = true;
        strcpy(part.name, lantern[i].name);
        if (strcmp(part.name, "lamp") == 0) {
            build->scene->lamp = ap_exp(space, at);
            build->scene->lamp_reach_m = ap_vec3_length(at);
            build->scene->lamp_radius_m = radius;
        }
        ap_build_part(build, part);
        build->object++;
    }
}

enum ap_status ap_scene_billiards(struct ap_error *err, const struct ap_scene_params *params,
                                  struct ap_scene **scene) {
    const struct ap_space_request request = {.space_name = params->space_name,
                                             .radius_m = params->radius_m,
                                             .table_edge_m = params->table_edge_m,
                                             .table_height_m = params->table_height_m,
                                             .budget_bytes = params->budget_bytes,
                                             .has_table = true};
    struct ap_scene_build build;
    enum ap_status st = ap_build_init(err, &request, &build);
    if (st)
        return st;
    build.side_pockets = params->side_pockets && build.table.sides == 4;
    const unsigned rgb[3] = {0x14, 0x1a, 0x26}; // a room at dusk
    for (int i = 0; i < 3; i++)
        build.scene->background_srgb[i] = rgb[i] / 255.0;
    void (*const furnish[])(struct ap_scene_build *) = {ap_furnish_table, ap_furnish_tiling,
                                                        ap_furnish_hands, ap_furnish_cue};
    for (size_t i = 0; i < sizeof furnish / sizeof *furnish; i++) {
        furnish[i](&build);
        build.object++;
    }
    add_balls(&build);
    add_lanterns(&build);
    return ap_build_finish(err, &build, scene);
}
