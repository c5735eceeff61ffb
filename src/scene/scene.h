#ifndef ANTIPODE_SCENE_SCENE_H
#define ANTIPODE_SCENE_SCENE_H

#include <jansson.h>
#include <stdbool.h>
#include <stddef.h>

#include "src/base/status.h"
#include "src/geom/isometry.h"
#include "src/geom/pairing.h"

// What is in the world: a flat list of parts. Everything in a scene file (balls, sticks, polygons,
// models, the table, the hands, the cue) becomes parts, each one mesh under one isometry, so that
// the renderer knows five shapes and nothing of billiards.

enum ap_part_kind {
    AP_PART_BALL,    // geodesic ball of radius_m about the part's base point
    AP_PART_STICK,   // points within radius_m of the geodesic segment, along the part's −z…+z:
                     // centred, length_m; radius tapers from radius_m (−z end) to radius2_m
    AP_PART_POLYGON, // regular geodesic polygon in the part's x–z plane, +y its face; edge 0's
                     // midpoint toward −z; seen from both sides
    AP_PART_SOLID,   // triangles given as tangent vectors at the part's place, then exp
};

// What a lit part's surface is made of. Plain ones get their light at their corners, the others at
// every pixel; it is the lamp's, along geodesics (src/view/light.h).
enum ap_finish {
    AP_FINISH_PLAIN,
    AP_FINISH_MATTE,
    AP_FINISH_CLOTH,   // of a table; its weave lies in the part's x–z plane
    AP_FINISH_WOOD,    // the grain along the part's z
    AP_FINISH_POOL,    // a ball of one colour with its text in a white disc about ±z
    AP_FINISH_STRIPED, // a white ball with a band of its colour round the y–z plane, and the same
};

// The geodesic surface that a solid's facets stand for, so that they can be made finer.
enum ap_form {
    AP_FORM_FACETS, // none: the facets are its shape
    AP_FORM_PLANE,  // the part's plane y = 0
    AP_FORM_TUBE,   // what is radius_m from the geodesic along x
    AP_FORM_SPHERE, // what is radius_m from the part's place
    AP_FORM_STICK,  // what is radius_m from the length_m of the geodesic along z about that place
};

// What carries a part: its place is carrier_from_part, relative to the world or to a tracked device
// whose virtual pose changes every frame; or to each cell of the scene's tiling.
enum ap_carrier { AP_CARRIER_WORLD, AP_CARRIER_LEFT, AP_CARRIER_RIGHT, AP_CARRIER_CELL };

// A shared triangle mesh in metres (tangent vectors), outward normals, three indices a triangle.
struct ap_solid {
    float *positions; // 3·vertex_count
    float *normals;   // 3·vertex_count
    unsigned *indices;
    size_t vertex_count, index_count;
    double reach_m; // largest |position|
    // A level of a part with several: its longest edge, and half the angle that a facet of its
    // round side turns by (the part's radius_m is the round side's). 0: not known.
    double longest_m, turn_rad;
    // Lines of its rim that neighbours share, who draw them as the same polylines: of each, from end
    // to end, the vertices that cut it into seam_pieces (a power of two) of equal lengths.
    unsigned *seams; // seam_count·(seam_pieces + 1)
    int seam_count, seam_pieces;
};

// A short text on balls (AP_FINISH_POOL, _STRIPED).
enum { AP_DECAL_TEXT_MAX = 8 };
struct ap_decal {
    char text[AP_DECAL_TEXT_MAX]; // UTF-8
};

// The mouth of a pocket, drawn on what takes marks: all within radius_m of a point of the world.
struct ap_mouth {
    struct ap_vec4 at;
    double radius_m;
};
enum { AP_MOUTHS_MAX = 8 };

struct ap_part {
    enum ap_part_kind kind;
    enum ap_carrier carrier;
    struct ap_iso carrier_from_part;
    double radius_m, radius2_m, length_m; // ball; stick
    int sides;                            // polygon
    double edge_m;
    int solid;            // index into scene->solids
    int solid_levels;     // 0: one; else so many from `solid` on, coarse before fine
    bool one_sided;       // a solid that is never seen from behind
    enum ap_form form;    // of a solid
    double color_srgb[3]; // 0…1, as written in the file; unlit parts show exactly this
    bool lit;
    enum ap_finish finish;
    int decal;         // 1 + an index into scene->decals; 0: none
    bool casts_shadow; // a ball, on what takes marks
    bool takes_marks;  // the surface on which such balls lie (the first 16): their shadows, and the
                       // pockets' mouths. One part of a scene; it lies within a quarter turn of s3
    bool apart;    // a polygon that meets nothing else: an error in its depth alone does not show
    bool hidden;   // not drawn (a hand that is not tracked is handled by the renderer)
    char name[64]; // target name, or ""
    bool target;   // an unlit ball with a colour used once
    int pool_ball; // 1 + its number (the cue ball's is 0), for who plays; 0: none
    int object;    // index of the scene object it came from
};

// A world of cells: what is in one is in each. The world's frame is that of the cell that the
// visitor is in; when she leaves it, world and trackers move on to the next (ap_cells_left_by).
struct ap_honeycomb {
    struct ap_tiling tiling;
    struct ap_pairing pairing;
    bool quotient;       // the cells are one: the hands are in each of them
    double horizon_px;   // a cell that is seen with less than this radius is not drawn
    struct ap_vec4 lamp; // of each cell, in its frame
    // Opaque walls with a window in each face, whose corners these are (cell's frame).
    bool has_walls;
    struct ap_window window[AP_CELL_FACES];
};

struct ap_scene {
    struct ap_space space;
    double background_srgb[3];
    struct ap_part *parts;
    size_t part_count;
    struct ap_solid *solids;
    size_t solid_count;
    bool has_table; // a {"table": {}} object: the room has a physical table
    double table_edge_m, table_height_m;
    struct ap_vec4 lamp; // where lit parts are lit from (world)
    // The lamp is a ball; at lamp_reach_m its light shows colours as they are written, and falls
    // from there as the area of a geodesic sphere grows. 0: a reach of 1 m (in s3 at most a sixth
    // of a turn), a point.
    double lamp_reach_m, lamp_radius_m;
    struct ap_decal *decals;
    size_t decal_count;
    struct ap_mouth mouths[AP_MOUTHS_MAX];
    int mouth_count;
    struct ap_honeycomb *honeycomb; // NULL: the world is not made of cells
    // What it may take of memory (ap_scene_budget), 0: the default. A quarter for triangles made
    // for a frame; half for models, as they are read and drawn, the rest for meshes made ahead. In
    // a world of cells a quarter for those that are known, three eighths for the list of what is
    // drawn of them; where they are a finite number, what is left for the triangles, up to three
    // quarters (src/render/mesh/budget.h). One that has no room for what a scene cannot do without,
    // the coarsest meshes and a list of its parts, is refused.
    size_t budget_bytes;
};

struct ap_scene_params {
    const char *space_name; // NULL: the file's, else h3
    double radius_m;        // 0: the file's, else the table's for table_edge_m (s3, h3), else 1
    double table_edge_m;    // 0: 0.9, or what radius_m says
    double table_height_m;  // 0: 0.75
    bool side_pockets;      // the billiards room of e3: six pockets
    size_t budget_bytes;    // 0: the file's, else a default
};

// From a scene file. AP_INPUT names the place ("room.json: /objects/3/ball/radius_m: …").
// Command line (params) before file before defaults.
enum ap_status ap_scene_read(struct ap_error *err, const char *path,
                             const struct ap_scene_params *params, struct ap_scene **scene);

// The billiards room: table, tiling of its plane, sixteen balls, cue, hands, lamps (targets).
enum ap_status ap_scene_billiards(struct ap_error *err, const struct ap_scene_params *params,
                                  struct ap_scene **scene);

// Appends `count` copies of a part, hidden, for a program to move, colour and show as it goes
// (before a renderer is made of the scene); *first is the first one's index.
enum ap_status ap_scene_add(struct ap_error *err, struct ap_scene *scene,
                            const struct ap_part *part, size_t count, size_t *first);
// The same from a document that is read already; `name` stands for the file's in messages.
enum ap_status ap_scene_from_json(struct ap_error *err, const char *name, const json_t *document,
                                  const struct ap_scene_params *params, struct ap_scene **scene);

// Scenes with a name, and what may follow it after commas (docs/honeycombs.md); for people, and
// read by docs/antipode.bash.
#define AP_SCENE_QUOTIENTS "torus poincare-dodecahedral seifert-weber mirrored-dodecahedron"
#define AP_SCENE_SYMBOLS "3,3,3 3,3,4 3,3,5 3,4,3 4,3,3 5,3,3 4,3,4 5,3,4 4,3,5 3,5,3 5,3,5"
#define AP_SCENE_WORDS ",walls ,struts ,balls ,width=SHARE ,edge=M ,horizon=PX ,budget=MIB"

// AP_USAGE for a word that is not known or a space that is not the tiling's, else as ap_scene_read.
bool ap_scene_is_named(const char *text);
enum ap_status ap_scene_named(struct ap_error *err, const char *text,
                              const struct ap_scene_params *params, struct ap_scene **scene);

// The scene's budget, or the default: 512 MiB for a world of cells, 2048 for others.
size_t ap_scene_budget(const struct ap_scene *scene);

void ap_scene_destroy(struct ap_scene *scene);

#endif
