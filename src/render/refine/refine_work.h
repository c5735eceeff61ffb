#ifndef ANTIPODE_RENDER_REFINE_REFINE_WORK_H
#define ANTIPODE_RENDER_REFINE_REFINE_WORK_H

#include "src/render/refine/refine.h"
#include "src/render/refine/refine_surface.h"

// One part on its way to triangles, as src/render/refine/ passes it around among itself:
// refine_begin.c says where it begins, refine_edge.c which edges are cut, refine.c what becomes of
// the triangles.

#define AP_REFINE_SHARE 0.75 // of the bound: what an edge may use up
#define AP_NOT_CUT UINT32_MAX

// How far a straight edge is off, pixels: in direction, and with its share of the error in depth.
struct ap_refine_error {
    double aside, all;
};

struct ap_refine_node {
    struct ap_surface_point point;
    unsigned char seams;            // bit k: it lies on the part's seam k
    unsigned char depth;            // it halves a piece of the seam that was cut so often
    struct ap_refine_error allowed; // of edges that end here
};

struct ap_refine_edge {
    uint64_t key; // what is at hand, and both ends; free where it is of something else
    uint32_t middle;
};

struct ap_refine_triangle {
    uint32_t corner[3];
    uint32_t depth; // how often what it is of was split with an edge left whole
};

struct ap_refine_work {
    struct ap_error *err;
    struct ap_refiner *r;
    const struct ap_refine_params *params;
    struct ap_surface surface;
    double shortest; // over rho: edges up to this are not cut
    struct ap_mesh_data *data;
    struct ap_refine_triangle *stack;
    size_t stack_count, stack_space, triangles;
    size_t first_index; // of data
    size_t forced;      // edges that were kept, and cut after all
    bool faces;         // nodes know which way the surface is turned
    double taper;       // of a stick: its normals are those of a straight one
    bool cut_all;       // edges are cut unasked
    bool held;
    uint32_t unseen; // triangles that are left out
    enum ap_status st;
};

// These leave an error in work->st where memory runs out.
uint32_t ap_refine_add_node(struct ap_refine_work *work, struct ap_surface_point point);
void ap_refine_push(struct ap_refine_work *work, uint32_t depth, uint32_t a, uint32_t b,
                    uint32_t c);

// Its first nodes, and triangles on the stack.
void ap_refine_begin(struct ap_refine_work *work, const struct ap_part *part);
// From a mesh made ahead as it is.
void ap_refine_begin_mesh(struct ap_refine_work *work);

// Another part: no nodes, and no edge is judged.
void ap_refine_forget(struct ap_refiner *refiner);
// The node in the middle of an edge that is cut, else AP_NOT_CUT. Every edge is judged once.
uint32_t ap_refine_middle(struct ap_refine_work *work, uint32_t i, uint32_t j);
// Cuts an edge that was kept, but for a seam's, which the part beyond keeps, too.
uint32_t ap_refine_cut_after_all(struct ap_refine_work *work, uint32_t i, uint32_t j);
// The distance between two points, straight, over rho: the same in any part's coordinates.
double ap_refine_chord(struct ap_space space, struct ap_vec4 p, struct ap_vec4 q);

// A triangle's pieces, onto the stack; at least one of its edges is cut.
void ap_refine_split(struct ap_refine_work *work, const struct ap_refine_triangle *t,
                     const uint32_t middle[3]);

#endif
