#ifndef ANTIPODE_SCENE_BUILD_H
#define ANTIPODE_SCENE_BUILD_H

#include "src/geom/map.h"
#include "src/geom/table.h"
#include "src/scene/mesh.h"
#include "src/scene/scene.h"

// A scene in the making, private to src/scene. Running out of memory is remembered, and told once
// by ap_build_finish, so that what furnishes a room reads as a list of things and not of checks.

struct ap_scene_build {
    struct ap_scene *scene;
    struct ap_table_shape
        table; // of the scene's space; in a file without a table, what one would be
    size_t part_room, solid_room, decal_room;
    int object;        // what the next parts belong to
    bool side_pockets; // of the square table: two more, in the middles of edges 1 and 3
    bool out_of_memory;
};

// What the space and the table's edge are by the command line, then by the file, then by default.
struct ap_space_request {
    const char *space_name, *file_space_name; // NULL: not given
    double radius_m, file_radius_m;           // 0: not given
    double table_edge_m, table_height_m;      // 0: not given
    size_t budget_bytes;                      // 0: not given
    bool has_table; // an edge that contradicts the radius (s3, h3) is then AP_USAGE
};

// Makes an empty scene. On success the caller owes ap_build_finish or ap_build_abort.
enum ap_status ap_build_init(struct ap_error *err, const struct ap_space_request *request,
                             struct ap_scene_build *build);
void ap_build_abort(struct ap_scene_build *build);
// AP_ENVIRONMENT where memory ran out; the scene is the caller's otherwise.
enum ap_status ap_build_finish(struct ap_error *err, struct ap_scene_build *build,
                               struct ap_scene **scene);

// Appends a copy; its object is build->object.
void ap_build_part(struct ap_scene_build *build, struct ap_part part);

// Takes over what the mesh holds and zeroes it; returns the solid's index. A mesh that ran out of
// memory is remembered too.
int ap_build_solid(struct ap_scene_build *build, struct ap_mesh *mesh);

// The same for one of AP_MESH_LEVELS of a thing, mesh->sagitta_m being this level's; they are added
// one after the other. The finest counts as the thing itself. Returns the part's radius_m with it.
int ap_build_level(struct ap_scene_build *build, struct ap_mesh *mesh, int level, double *radius_m);

// What a part's `decal` is to be for this text (at most AP_DECAL_TEXT_MAX − 1 bytes, else it is
// cut); the same for the same text.
int ap_build_decal(struct ap_scene_build *build, const char *text);

// 0xRRGGBB as 0…1 three times, and back.
void ap_color_set(struct ap_part *part, unsigned rgb);
unsigned ap_color_rgb(const double srgb[3]);

// Parts in the world. A stick's −z end is `to`.
struct ap_part ap_ball_part(struct ap_iso place, double radius_m, unsigned rgb);
struct ap_part ap_stick_part(struct ap_iso place, double length_m, double radius_m, unsigned rgb);
struct ap_part ap_polygon_part(struct ap_iso place, int sides, double edge_m, unsigned rgb);
struct ap_part ap_solid_part(struct ap_iso place, int solid, unsigned rgb);

// Every point of the part lies within so many metres of its place.
double ap_part_reach(const struct ap_scene *scene, const struct ap_part *part);

// translate(0, 0, z)·… and the like.
struct ap_iso ap_shift(struct ap_space space, double x, double y, double z);

// Things that are more than one part.
void ap_furnish_table(struct ap_scene_build *build);
void ap_furnish_tiling(struct ap_scene_build *build);
void ap_furnish_hands(struct ap_scene_build *build);
void ap_furnish_cue(struct ap_scene_build *build);

// Balls of the game: their radius on this table, and how near to a corner their foot falls into its
// pocket: the mouth's radius. A foot comes no nearer to an edge than rail and ball allow.
double ap_pool_ball_radius(const struct ap_table_shape *table);
double ap_pocket_radius(const struct ap_table_shape *table);

// How far the rails stand over the felt and reach in from the edge.
double ap_rail_radius(const struct ap_table_shape *table);

// Reads a model file of at most 64 MiB and 5 million vertices, and adds a solid for each mesh and
// place in it, under `place`. Works in a process of its own (fork), so that a hostile file cannot
// take this one with it; blocks until that is done.
struct ap_model_request {
    const char *path;
    double scale;
    struct ap_iso place;
    long rgb; // −1: the model's own colours
    bool lit;
    size_t most_bytes; // of memory for all its solids: they are simplified, and a warning says so
};
enum ap_status ap_build_model(struct ap_error *err, struct ap_scene_build *build,
                              const struct ap_model_request *request);

#endif
