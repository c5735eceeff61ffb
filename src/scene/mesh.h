#ifndef ANTIPODE_SCENE_MESH_H
#define ANTIPODE_SCENE_MESH_H

#include "src/geom/pose.h"
#include "src/scene/scene.h"

// A solid that grows. Zero-initialised it is empty; finish drops what it holds. When memory runs
// out it remembers, and takes nothing more.
struct ap_mesh {
    struct ap_solid solid;
    size_t vertex_room, index_room;
    bool out_of_memory;
    bool mirrored; // what is added is reflected in x = 0
    // How far inside of what is round the middles of its facets may fall; 0: 0.2 mm.
    double sagitta_m;
    double roundest_m; // the largest radius that was added
};

// The same thing at so many levels of detail, coarse before fine: how far its facets may fall
// inside.
enum { AP_MESH_LEVELS = 5 };
double ap_mesh_sagitta_m(int level);

void ap_mesh_finish(struct ap_mesh *mesh);

// Fills an empty mesh with counts of zeroed vertices and indices, to be written by the caller, who
// then lets ap_mesh_measure find its reach.
void ap_mesh_reserve(struct ap_mesh *mesh, size_t vertex_count, size_t index_count);
void ap_mesh_measure(struct ap_mesh *mesh);

// position metres, normal unit; returns the vertex's index.
unsigned ap_mesh_vertex(struct ap_mesh *mesh, struct ap_vec3 position, struct ap_vec3 normal);

// Counterclockwise from outside.
void ap_mesh_triangle(struct ap_mesh *mesh, unsigned a, unsigned b, unsigned c);

// Lines of the rim that neighbours share, of so many pieces each (ap_solid); then each one's
// vertices, i = 0…pieces.
void ap_mesh_seams(struct ap_mesh *mesh, int count, int pieces);
void ap_mesh_seam_vertex(struct ap_mesh *mesh, int seam, int i, unsigned vertex);

// An ellipsoid with the semi-axes `radii`, placed by mesh_from_shape.
void ap_mesh_ellipsoid(struct ap_mesh *mesh, struct ap_pose mesh_from_shape, struct ap_vec3 radii);

// A tube of radius thick_m about an arc of a circle of radius_m, which lies in the plane y =
// height_m about the y axis, from the angle from_rad (0 at +z, counterclockwise from above) to
// to_rad; round-ended.
struct ap_mesh_arc {
    double radius_m, height_m, thick_m, from_rad, to_rad;
};
void ap_mesh_arc(struct ap_mesh *mesh, const struct ap_mesh_arc *arc);

// What is within r0…r1 of the segment a…b: a round-ended, tapering limb.
void ap_mesh_limb(struct ap_mesh *mesh, struct ap_vec3 a, double r0, struct ap_vec3 b, double r1);

#endif
