#ifndef ANTIPODE_GEOM_TILING_H
#define ANTIPODE_GEOM_TILING_H

#include <stdbool.h>

#include "src/geom/dd.h"
#include "src/geom/isometry.h"
#include "src/geom/map.h"

// The regular tilings of the three spaces by bounded cells, from nothing but a Schläfli symbol
// {p,q,r}: cells {p,q}, r of them round each edge. All lengths and places come from the reflection
// group's fundamental simplex (Coxeter, Regular Polytopes, chapters 7 and 10), in double-double and
// rounded once; there are no tables of coordinates. Pure, any thread; a tiling is constant once it
// is made.

enum { AP_CELL_FACES = 20, AP_CELL_VERTICES = 20, AP_CELL_EDGES = 30, AP_CELL_SYMMETRIES = 120 };

struct ap_symbol {
    int p, q, r;
};

// A symmetry of the cell about its centre.
struct ap_symmetry {
    struct ap_iso turn, turn_low; // their sum is exact to 1e-31
    bool reverses;                // a reflection, or a rotary reflection
    unsigned char inverse, face[AP_CELL_FACES], vertex[AP_CELL_VERTICES]; // where each goes
};

// A convex polygon in the plane of a face: p corners in the cell's frame.
struct ap_window {
    struct ap_vec4 corner_m[5];
};

// The cell's frame: its centre at the base point, face 0 toward −y (a floor), its edge 0 toward +z,
// so that −z is a corner's side where p is odd. x → −x is a symmetry of the cell that fixes face 0
// and edge 0.
struct ap_tiling {
    struct ap_symbol symbol;
    struct ap_space space;
    int face_count, vertex_count, edge_count, symmetry_count;
    int cell_count; // of the whole space in s3, else 0
    // Metres, each within 3e-16 of itself: from the cell's centre to a face's, an edge's middle, a
    // vertex; an edge; from a face's centre to its vertices and to its edges.
    double inradius_m, midradius_m, circumradius_m, edge_m, face_circumradius_m, face_inradius_m;
    struct ap_vec4 vertex_m[AP_CELL_VERTICES];
    struct ap_vec3
        mirror[3]; // unit normals of the fundamental simplex's mirrors through the centre
    struct ap_vec3 face_out[AP_CELL_FACES], edge_out[AP_CELL_EDGES]; // unit, from the centre
    int face_vertex[AP_CELL_FACES][5]; // counterclockwise seen from the cell's centre
    int edge_vertex[AP_CELL_EDGES][2], edge_face[AP_CELL_EDGES][2];
    int face_neighbour[AP_CELL_FACES][5]; // over the edge from face_vertex[k] to [k + 1]
    // Rotations that take face 0, edge 0, vertex 0 to each.
    int turn_to_face[AP_CELL_FACES], turn_to_edge[AP_CELL_EDGES], turn_to_vertex[AP_CELL_VERTICES];
    struct ap_symmetry symmetry[AP_CELL_SYMMETRIES]; // [0] is the identity
    struct ap_dd inradius_cos, inradius_sin;         // (C, S) of inradius/rho
};

// Signed distance of a point (cell's frame, metres) beyond the plane of a face, as S(distance/rho).
double ap_tiling_beyond(const struct ap_tiling *tiling, struct ap_vec4 p_m, int face);

// Which space a symbol belongs to: its kappa. AP_INPUT where there is no such tiling by bounded
// cells, with the reason (flat or unbounded cells, vertices at or beyond infinity).
enum ap_status ap_symbol_space(struct ap_error *err, struct ap_symbol symbol, int *kappa);

// size_m is the radius of s3 and h3; in e3 it is the edge, and rho_m what Euclidean radians are
// taken in. AP_INPUT as above, AP_USAGE where the space is another one than the symbol's (the
// sentence says which it belongs to).
enum ap_status ap_tiling_init(struct ap_error *err, struct ap_symbol symbol, struct ap_space space,
                              double e3_edge_m, struct ap_tiling *tiling);

// The edge and the cell's inradius over rho, of s3 and h3; in e3 over the edge.
enum ap_status ap_symbol_lengths(struct ap_error *err, struct ap_symbol symbol, double *edge,
                                 double *inradius);

// Reflection in the plane of a face, then symmetry g before it: a neighbour's frame. The sum of
// both is exact to 1e-30.
void ap_tiling_across(const struct ap_tiling *tiling, int face, int symmetry, struct ap_iso *high,
                      struct ap_iso *low);

#endif
