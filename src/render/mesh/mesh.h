#ifndef ANTIPODE_RENDER_MESH_MESH_H
#define ANTIPODE_RENDER_MESH_MESH_H

#include <stddef.h>
#include <stdint.h>

#include "src/base/status.h"
#include "src/geom/space.h"
#include "src/scene/scene.h"

// Triangle meshes in a part's own coordinates, made in double and rounded once: positions are
// points of the space over rho, normals unit tangent 4-vectors there. Counterclockwise seen from
// outside. CPU only; src/render/mesh/meshes.h takes them to the GPU.
struct ap_vertex {
    float position[4];
    float normal[4];
};

// Grows; vertices of several meshes may follow one another.
struct ap_mesh_data {
    struct ap_vertex *vertices;
    uint32_t *indices; // relative to the mesh's first vertex
    size_t vertex_count, index_count;
    size_t vertex_space, index_space;
};
size_t ap_mesh_data_bytes(const struct ap_mesh_data *data); // that it holds
void ap_mesh_data_finish(struct ap_mesh_data *data);
enum ap_status ap_mesh_data_vertex(struct ap_error *err, struct ap_mesh_data *data,
                                   struct ap_vec4 position, struct ap_vec4 normal);
enum ap_status ap_mesh_data_copy(struct ap_error *err, struct ap_mesh_data *data,
                                 const struct ap_vertex *vertex);
enum ap_status ap_mesh_data_triangle(struct ap_error *err, struct ap_mesh_data *data, uint32_t a,
                                     uint32_t b, uint32_t c);

// Where a mesh lies in its data.
struct ap_mesh {
    uint32_t first_vertex, vertex_count, first_index, index_count;
};
struct ap_mesh ap_mesh_data_begin(const struct ap_mesh_data *data); // what is added from here on…
void ap_mesh_data_end(const struct ap_mesh_data *data, struct ap_mesh *mesh); // …is the mesh

// Copies a mesh of other data, `from`.
enum ap_status ap_mesh_data_append(struct ap_error *err, struct ap_mesh_data *data,
                                   const struct ap_mesh_data *from, const struct ap_mesh *mesh,
                                   struct ap_mesh *copy);

// The twelve corners and twenty faces of the icosahedron.
struct ap_vec3 ap_icosahedron_corner(int i);
void ap_icosahedron_face(int f, int corner[3]);

// A sphere of unit vectors, shared by all balls: position = (u, 0), normal = (u, 0); the vertex
// shader makes (S·u, C) of it. An icosahedron's faces with `steps` an edge: 20·steps² triangles; a
// facet's corners lie within *facet_rad of its centre.
enum ap_status ap_mesh_sphere(struct ap_error *err, int steps, struct ap_mesh_data *data,
                              struct ap_mesh *mesh, double *facet_rad);

// A tube about the geodesic segment along z, `around` corners in each ring, rings *step_m apart,
// round caps. along: steps from end to end; 0: at most 1.6·rho/around where the space is curved,
// but no more than 192 of them.
enum ap_status ap_mesh_stick(struct ap_error *err, struct ap_space space,
                             const struct ap_part *part, int around, int along,
                             struct ap_mesh_data *data, struct ap_mesh *mesh, double *step_m);

// Fans of sides·division² triangles about the centre; corners of the triangles are geodesic
// barycentres, so outline and plane are exact.
enum ap_status ap_mesh_polygon(struct ap_error *err, struct ap_space space, int sides,
                               double edge_m, int division, struct ap_mesh_data *data,
                               struct ap_mesh *mesh);

enum ap_status ap_mesh_solid(struct ap_error *err, struct ap_space space,
                             const struct ap_solid *solid, struct ap_mesh_data *data,
                             struct ap_mesh *mesh);

#endif
