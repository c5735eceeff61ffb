#include "src/scene/build.h"

#include <stdlib.h>

double ap_rail_radius(const struct ap_table_shape *table) {
    return fmin(0.025, 0.07 * table->inradius_m);
}

double ap_pool_ball_radius(const struct ap_table_shape *table) {
    // Real balls, unless the table is too small for fifteen of them.
    return fmin(0.05715 / 2, 0.0835 * table->inradius_m);
}

double ap_pocket_radius(const struct ap_table_shape *table) {
    double ball_m = ap_pool_ball_radius(table);
    return sqrt(2) * (ap_rail_radius(table) + ball_m) + ball_m;
}

// The stick's frame lies along z; edges run along x.
static struct ap_iso along_x(void) {
    return ap_iso_rotate_y(M_PI / 2);
}

static struct ap_iso along_y(void) {
    return ap_iso_rotate(ap_quat_from_axis_angle((struct ap_vec3){1, 0, 0}, M_PI / 2));
}

static struct ap_iso world_from_corner(const struct ap_table_shape *t, int k) {
    return ap_iso_mul(ap_iso_rotate_y((2 * k + 1) * M_PI / t->sides),
                      ap_shift(t->space, 0, 0, -t->circumradius_m));
}

static struct ap_part wooden(struct ap_part part) {
    part.finish = AP_FINISH_WOOD;
    return part;
}

// A roll of leather round the outside of a pocket, from rail to rail: three quarters of the mouth's
// rim at a corner (from 45°), half of it in the middle of an edge (from 90°), given as tangent
// vectors there, where the table lies toward +z.
static struct ap_part pocket_rim(struct ap_scene_build *build, double from_rad) {
    double thick = 0.36 * ap_rail_radius(&build->table);
    const struct ap_mesh_arc arc = {.radius_m = ap_pocket_radius(&build->table),
                                    .height_m = 0.4 * thick,
                                    .thick_m = thick,
                                    .from_rad = from_rad,
                                    .to_rad = 2 * M_PI - from_rad};
    struct ap_part part = ap_solid_part(AP_ISO_IDENTITY, 0, 0x3a2114);
    for (int k = 0; k < AP_MESH_LEVELS; k++) {
        struct ap_mesh mesh = {.sagitta_m = ap_mesh_sagitta_m(k)};
        ap_mesh_arc(&mesh, &arc);
        int at = ap_build_level(build, &mesh, k, &part.radius_m);
        part.solid = k == 0 ? at : part.solid;
    }
    part.solid_levels = AP_MESH_LEVELS;
    part.one_sided = true;
    return part;
}

enum { MOUTH_SIDES = 32 };

static void furnish_pocket(struct ap_scene_build *build, struct ap_iso place, struct ap_part rim) {
    const struct ap_table_shape *t = &build->table;
    rim.carrier_from_part = place;
    ap_build_part(build, rim);
    // Black beyond the cloth, over the tiles that meet there.
    double r = ap_pocket_radius(t), half = sin(M_PI / MOUTH_SIDES);
    half *= ap_space_sin(t->space, r / t->space.rho_m);
    half = t->space.kappa > 0 ? asin(half) : t->space.kappa < 0 ? asinh(half) : half;
    struct ap_iso lid = ap_iso_mul(place, ap_shift(t->space, 0, 0.06 * ap_rail_radius(t), 0));
    struct ap_part hole = ap_polygon_part(lid, MOUTH_SIDES, 2 * half * t->space.rho_m, 0x0a0908);
    ap_build_part(build, hole);
    struct ap_mouth *mouth = &build->scene->mouths[build->scene->mouth_count++];
    mouth->at = ap_iso_apply(&place, (struct ap_vec4){0, 0, 0, t->space.rho_m});
    mouth->radius_m = ap_pocket_radius(t);
}

static void furnish_leg(struct ap_scene_build *build, struct ap_iso corner) {
    const struct ap_table_shape *t = &build->table;
    double rail = ap_rail_radius(t),
           leg = t->space.kappa > 0 ? fmin(0.7, 0.8 * t->space.rho_m) : 0.7;
    struct ap_iso middle = ap_iso_mul(corner, ap_shift(t->space, 0, -leg / 2 - rail, 0));
    ap_build_part(build,
                  wooden(ap_stick_part(ap_iso_mul(middle, along_y()), leg, 0.9 * rail, 0x4a2c18)));
}

// The rail of an edge from pocket to pocket, and its sights; with a pocket in its middle, two
// rails.
static void furnish_edge(struct ap_scene_build *build, struct ap_iso edge, bool side_pocket) {
    const struct ap_table_shape *t = &build->table;
    double rail = ap_rail_radius(t), pocket = ap_pocket_radius(t);
    int rails = side_pocket ? 2 : 1;
    double length_m = t->edge_m / rails - 2 * pocket;
    for (int i = 0; i < rails; i++) {
        double middle_m = side_pocket ? (i - 0.5) * t->edge_m / 2 : 0;
        struct ap_iso middle = ap_iso_mul(edge, ap_shift(t->space, middle_m, 0, 0));
        struct ap_iso lying = ap_iso_mul(middle, along_x());
        ap_build_part(build, wooden(ap_stick_part(lying, length_m, rail, 0x6b3f22)));
    }
    for (int i = -1; i <= 1; i++) {
        if (i == 0 && side_pocket)
            continue;
        struct ap_iso along = ap_iso_mul(edge, ap_shift(t->space, i * t->edge_m / 4, 0, 0));
        struct ap_iso top = ap_iso_mul(along, ap_shift(t->space, 0, rail, 0));
        ap_build_part(build, ap_ball_part(top, 0.16 * rail, 0xf0e8d0));
    }
}

// Cloth, a rail along each edge as a geodesic tube whose axis is the edge itself, so that it
// follows the edge in every space; the cloth ends inside of it. Sights on the rails, pockets and
// legs at the corners.
void ap_furnish_table(struct ap_scene_build *build) {
    const struct ap_table_shape *t = &build->table;
    struct ap_part felt = ap_polygon_part(AP_ISO_IDENTITY, t->sides, t->edge_m, 0x1f7a4a);
    felt.finish = AP_FINISH_CLOTH;
    felt.takes_marks = true;
    ap_build_part(build, felt);
    struct ap_part rim = pocket_rim(build, M_PI / 4), side_rim = {0};
    if (build->side_pockets)
        side_rim = pocket_rim(build, M_PI / 2);
    build->scene->mouth_count = 0;
    for (int k = 0; k < t->sides; k++) {
        struct ap_iso corner = world_from_corner(t, k);
        furnish_edge(build, ap_table_edge_frame(t, k), build->side_pockets && k % 2 == 1);
        furnish_pocket(build, corner, rim);
        furnish_leg(build, corner);
    }
    for (int k = 1; k < t->sides && build->side_pockets; k += 2)
        furnish_pocket(build, ap_table_edge_frame(t, k), side_rim);
}

// The tiling of the table's plane: whoever walks round the table walks over it. A tile is reached
// by turning half a circle about the middle of an edge of one that is there.
enum { MAX_TILES = 160 };

struct tile {
    struct ap_iso world_from_tile;
    int ring;
};

static bool same_place(struct ap_space space, struct ap_vec4 p, struct ap_vec4 q) {
    double dx = p.x - q.x, dy = p.y - q.y, dz = p.z - q.z, dw = p.w - q.w;
    // w tells the two points of s3 apart that lie over one another; far off in h3 all four are
    // large.
    double scale = fmax(fabs(p.w), space.rho_m);
    return hypot(hypot(dx, dy), hypot(dz, dw)) < 1e-6 * scale;
}

static struct ap_vec4 place_of(const struct ap_iso *world_from_part, struct ap_space space) {
    return ap_iso_apply(world_from_part, (struct ap_vec4){0, 0, 0, space.rho_m});
}

static struct ap_iso across_edge(const struct ap_table_shape *t, const struct ap_iso *tile, int k) {
    struct ap_iso edge = ap_table_edge_frame(t, k);
    struct ap_iso turned = ap_iso_mul(edge, ap_iso_rotate_y(M_PI));
    // Back by the same way: the new tile's edge 0 is the shared one.
    struct ap_iso next = ap_iso_mul(turned, ap_shift(t->space, 0, 0, t->inradius_m));
    return ap_iso_mul(*tile, next);
}

static int grow_tiling(const struct ap_table_shape *t, int rings, struct tile *tiles) {
    int count = 1;
    tiles[0] = (struct tile){AP_ISO_IDENTITY, 0};
    for (int i = 0; i < count && tiles[i].ring < rings; i++)
        for (int k = 0; k < t->sides && count < MAX_TILES; k++) {
            struct tile next = {across_edge(t, &tiles[i].world_from_tile, k), tiles[i].ring + 1};
            struct ap_vec4 p = place_of(&next.world_from_tile, t->space);
            bool known = false;
            for (int j = 0; j < count && !known; j++)
                known = same_place(t->space, p, place_of(&tiles[j].world_from_tile, t->space));
            if (!known)
                tiles[count++] = next;
        }
    return count;
}

// Along a tile's edge; where it would end at a corner of the table, it ends at the pocket.
static void add_strut(struct ap_scene_build *build, struct ap_iso edge) {
    const struct ap_table_shape *t = &build->table;
    double cut_m[2] = {0, 0};
    for (int end = 0; end < 2; end++) {
        struct ap_iso to_end = ap_shift(t->space, (end ? 0.5 : -0.5) * t->edge_m, 0, 0);
        struct ap_iso at = ap_iso_mul(edge, to_end);
        for (int i = 0; i < build->scene->mouth_count; i++)
            if (same_place(t->space, place_of(&at, t->space), build->scene->mouths[i].at))
                cut_m[end] = ap_pocket_radius(t);
    }
    struct ap_iso middle = ap_iso_mul(edge, ap_shift(t->space, (cut_m[0] - cut_m[1]) / 2, 0, 0));
    ap_build_part(build,
                  ap_stick_part(ap_iso_mul(middle, along_x()), t->edge_m - cut_m[0] - cut_m[1],
                                0.24 * ap_rail_radius(t), 0x93a3b8));
}

// The struts of tile i that no earlier tile has; the table's own edges have rails.
static void add_struts(struct ap_scene_build *build, const struct tile *tiles, int i) {
    const struct ap_table_shape *t = &build->table;
    for (int k = 0; k < t->sides; k++) {
        struct ap_iso edge = ap_iso_mul(tiles[i].world_from_tile, ap_table_edge_frame(t, k));
        struct ap_vec4 p = place_of(&edge, t->space);
        bool known = false;
        for (int j = 0; j < i && !known; j++)
            for (int m = 0; m < t->sides && !known; m++) {
                struct ap_iso other =
                    ap_iso_mul(tiles[j].world_from_tile, ap_table_edge_frame(t, m));
                known = same_place(t->space, p, place_of(&other, t->space));
            }
        if (!known)
            add_strut(build, edge);
    }
}

// In s3 the plane is a sphere that closes above the visitor's head, so its tiles are small islands
// between the struts: one sees past them to what lies beyond, and the long way round.
void ap_furnish_tiling(struct ap_scene_build *build) {
    const struct ap_table_shape *t = &build->table;
    struct tile *tiles = malloc(MAX_TILES * sizeof *tiles);
    if (!tiles) {
        build->out_of_memory = true;
        return;
    }
    static const unsigned rgb[2] = {0x2c4a5e, 0x54486a};
    double filled = t->space.kappa > 0 ? 0.45 : 0.94;
    int count = grow_tiling(t, t->space.kappa < 0 ? 3 : 4, tiles);
    for (int i = 1; i < count; i++) {
        struct ap_part tile = ap_polygon_part(tiles[i].world_from_tile, t->sides,
                                              filled * t->edge_m, rgb[tiles[i].ring % 2]);
        tile.apart = true;
        ap_build_part(build, tile);
        if (tiles[i].ring <= 2) // beyond, tiles are small and many, and tell enough themselves
            add_struts(build, tiles, i);
    }
    free(tiles);
}
