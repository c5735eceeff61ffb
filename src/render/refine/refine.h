#ifndef ANTIPODE_RENDER_REFINE_REFINE_H
#define ANTIPODE_RENDER_REFINE_REFINE_H

#include "src/render/place/frame.h"
#include "src/render/mesh/mesh.h"
#include "src/render/refine/seam.h"

// Triangles for one part as two eyes see it from one place: an edge is cut in two where the
// straight line that the GPU will draw for it is seen farther than the bound from the surface it
// stands for. For what no mesh made ahead holds the bound with (docs/rendering.md). CPU, double.

struct ap_refine_params {
    const struct ap_viewer *viewer;
    const struct ap_eyes *eyes;
    struct ap_iso nose_from_part;
    // Of a solid with a plane next to the nose, the long way round: its vertices are moved by this
    // first, along their plane, to where the nose is (ap_plane_foot); NULL: as they are.
    // nose_from_part is of what is moved.
    const struct ap_iso *part_from_solid;
    int image;
    const struct ap_solid *solid; // of a solid with a form: the coarsest of its meshes made ahead,
                                  // or the one that ap_refine_holds is asked about
    double max_error_px;          // of either eye's picture
    size_t triangles_max;
    // Its seams and how they are cut, by the solid's own order; NULL: it has none.
    const struct ap_seam_cut *seams;
    bool any_depth; // an error in depth does not show
    bool closed;    // back faces are not drawn: they need not be there
    // Triangles that no eye sees are made all the same, coarse; else they are left out and counted
    // in *unseen: those wholly outside one side of both pictures, and of what is closed those that
    // are turned away from both eyes (native view).
    bool keep_unseen;
};

// Nodes and the memory of which edges were cut, kept from part to part.
struct ap_refiner {
    struct ap_refine_node *nodes;
    struct ap_refine_edge *edges; // open addressing, a power of two
    size_t node_count, node_space, edge_count, edge_room, edge_space; // of edge_room in use
    uint32_t part; // counts, so that a small part need not clear what a large one used
};
void ap_refiner_finish(struct ap_refiner *refiner);

// Appends the mesh of a ball, a stick, a polygon or a solid with a form to data. *held: false where
// triangles_max was reached, or edges of less than a third of AP_NEAR_M (or 1e-3 rho; a
// twentieth where 0.05 px are asked for; with part_from_solid a 64th of the nose's height above the
// plane) still miss the bound outside the forbidden millimetre; the
// mesh is whole all the same. Edges are cut by what their ends are alone, so neighbours share their
// cuts and nothing gapes. AP_ENVIRONMENT: no memory.
//
// The bound is on the middle of each edge and the middles of its halves, tightened by 3/4: inside a
// triangle a quadratic error is at most 4/3 of its edges' largest. Worst measured over random
// places: tests/render/test_refine.c.
enum ap_status ap_refine_part(struct ap_error *err, struct ap_refiner *refiner,
                              const struct ap_refine_params *params, const struct ap_part *part,
                              struct ap_mesh_data *data, struct ap_mesh *mesh, bool *held,
                              uint32_t *unseen);

// Whether a mesh made ahead of a solid with a form holds the bound as it is, by each of its edges
// that an eye may see: exact where closed bounds (src/render/place/place.h) are too careful. At
// most as long as it takes to make such a mesh; false too where memory runs out.
bool ap_refine_holds(struct ap_refiner *refiner, const struct ap_refine_params *params,
                     const struct ap_part *part);

#endif
