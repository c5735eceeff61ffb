#ifndef ANTIPODE_SCENE_HONEYCOMB_H
#define ANTIPODE_SCENE_HONEYCOMB_H

#include "src/base/json.h"
#include "src/geom/pairing.h"
#include "src/scene/build.h"

// Private to src/scene: worlds that repeat one cell.

// What is in a cell, and how far one sees.
struct ap_honeycomb_look {
    bool walls, struts, balls;
    double width; // of walls and struts, as a share of what there is room for
    double horizon_px, budget_mib;
    double edge_m; // 0: by the radius
};

// A {"honeycomb": …} or {"quotient": …} as far as it is known before there is a space.
struct ap_honeycomb_plan {
    struct ap_symbol symbol;
    int kappa;
    bool quotient;
    const char *name; // of a quotient space, or NULL
    struct ap_face_pair pairs[AP_CELL_FACES];
    int pair_count;
    struct ap_honeycomb_look look;
};

// AP_INPUT names the place.
enum ap_status ap_honeycomb_plan_read(struct ap_error *err, const struct ap_json_at *at,
                                      struct ap_honeycomb_plan *plan);

// The radius that the plan asks for where nothing else does: an edge of edge_m, or an inradius of a
// metre. 1 in e3.
double ap_honeycomb_radius(const struct ap_honeycomb_plan *plan);

// Gives the scene its tiling and puts the parts of a cell into it.
enum ap_status ap_furnish_honeycomb(struct ap_error *err, const struct ap_json_at *at,
                                    const struct ap_honeycomb_plan *plan,
                                    struct ap_scene_build *build);

// Meshes of a cell's pieces, `fine` times divided. All lie inside the closed cell, so that what is
// seen of a cell is seen through its faces, and all are symmetric under x → −x, so that a mirrored
// cell needs no meshes of its own. Seen from within the cell only.
// Face 0's wall without its window: about the face's centre, +y into the cell.
void ap_mesh_wall(const struct ap_tiling *tiling, double width, int fine, struct ap_mesh *mesh,
                  double *longest_m);
// What of a tube about edge 0 is in the cell: about the edge's middle, along x, +z into the cell.
void ap_mesh_strut(const struct ap_tiling *tiling, double radius_m, int fine, struct ap_mesh *mesh,
                   double *longest_m, double *turn_rad);
// What of a ball about vertex 0 is in the cell, +z into the cell.
void ap_mesh_joint(const struct ap_tiling *tiling, double radius_m, int fine, struct ap_mesh *mesh,
                   double *longest_m, double *turn_rad);
// The places of those in the cell's frame.
// The corners of the window in a wall, in the cell's frame.
struct ap_window ap_wall_window(const struct ap_tiling *tiling, int face, double width);
struct ap_iso ap_wall_place(const struct ap_tiling *tiling, int face);
struct ap_iso ap_strut_place(const struct ap_tiling *tiling, int edge);
struct ap_iso ap_joint_place(const struct ap_tiling *tiling, int vertex);
// A ball about a vertex that holds the ends of its struts.
double ap_joint_radius(const struct ap_tiling *tiling, double strut_radius_m);

#endif
