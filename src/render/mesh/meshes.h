#ifndef ANTIPODE_RENDER_MESH_MESHES_H
#define ANTIPODE_RENDER_MESH_MESHES_H

#include "src/gpu/gpu.h"
#include "src/render/mesh/mesh.h"

// Every mesh that a scene may need, on the GPU: equal shapes are made once, each in several levels
// of detail, coarse before fine.

enum { AP_LEVELS_MAX = 12, AP_OUT_MAX = 12, AP_SEAMS_MAX = 6 };

// A line of a piece's rim that others share (ap_solid): on a plane a geodesic, on a tube along it,
// on a sphere a great circle's.
struct ap_seam {
    struct ap_vec4 end[2];       // in the part's coordinates
    double length_m, bulge_m;    // along the line, and how far it leaves the straight way
    double chord_cos, chord_sin; // C and S of the straight way from end to end
    double bend_rad;             // on a sphere: half the angle at its middle
};

struct ap_shape {
    int levels;
    struct ap_mesh mesh[AP_LEVELS_MAX];
    // How coarse: balls and sticks, the angle at the axis between a facet's middle and its corner;
    // polygons, the longest edge in metres.
    double grain[AP_LEVELS_MAX];
    double step_m[AP_LEVELS_MAX]; // sticks: between rings
    // One-sided solids with a form: the corners of where they face (ap_facing); count 0: anywhere.
    struct ap_vec3 out[AP_OUT_MAX];
    int out_count;
    struct ap_seam seam[AP_SEAMS_MAX];
    int seam_count;
    struct ap_seam worst_seam; // the largest length_m, bulge_m and bend_rad of all
    // By level, where there are seams: the solid's own (borrowed), and the level in `kept`.
    int seam_pieces[AP_LEVELS_MAX];
    const unsigned *seam_vertex[AP_LEVELS_MAX];
    struct ap_mesh kept[AP_LEVELS_MAX];
};

struct ap_meshes {
    struct ap_gpu_buffer vertices, indices;
    struct ap_shape *shapes;
    size_t shape_count;
    size_t *shape_of_part;
    double *reach_m;          // by part: every point lies within so many metres of the part's place
    struct ap_mesh_data kept; // shapes with seams once more, to make others of in a frame
};

// The meshes themselves, without a GPU (borrows the scene): adds them to data, which `mesh` of each
// shape points into; buffers stay empty. Finish the data, and destroy with any gpu.
enum ap_status ap_meshes_make(struct ap_error *err, const struct ap_scene *scene,
                              struct ap_meshes *meshes, struct ap_mesh_data *data);

enum ap_status ap_meshes_create(struct ap_error *err, const struct ap_gpu *gpu,
                                const struct ap_scene *scene, struct ap_meshes *meshes);
// What they take, on the GPU and in the process.
size_t ap_meshes_bytes(const struct ap_meshes *meshes);
void ap_meshes_destroy(const struct ap_gpu *gpu, struct ap_meshes *meshes);

#endif
