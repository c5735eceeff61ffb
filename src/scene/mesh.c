#include "src/scene/mesh.h"

#include <stdlib.h>

enum { AROUND = 16, ALONG = 8, BAND_AROUND = 64, BAND_ACROSS = 8 };

void ap_mesh_finish(struct ap_mesh *mesh) {
    free(mesh->solid.positions);
    free(mesh->solid.normals);
    free(mesh->solid.indices);
    *mesh = (struct ap_mesh){0};
}

void ap_mesh_reserve(struct ap_mesh *mesh, size_t vertex_count, size_t index_count) {
    struct ap_solid *s = &mesh->solid;
    s->positions = calloc(3 * vertex_count + 1, sizeof *s->positions);
    s->normals = calloc(3 * vertex_count + 1, sizeof *s->normals);
    s->indices = calloc(index_count + 1, sizeof *s->indices);
    mesh->out_of_memory = !s->positions || !s->normals || !s->indices;
    if (mesh->out_of_memory)
        return;
    s->vertex_count = mesh->vertex_room = vertex_count;
    s->index_count = mesh->index_room = index_count;
}

void ap_mesh_measure(struct ap_mesh *mesh) {
    struct ap_solid *s = &mesh->solid;
    s->reach_m = 0;
    for (size_t i = 0; i < s->vertex_count; i++) {
        const float *p = &s->positions[3 * i];
        s->reach_m = fmax(s->reach_m, ap_vec3_length((struct ap_vec3){p[0], p[1], p[2]}));
    }
}

static bool grow_vertices(struct ap_mesh *m) {
    size_t room = m->vertex_room ? 2 * m->vertex_room : 256;
    float *p = realloc(m->solid.positions, room * 3 * sizeof *p);
    if (p)
        m->solid.positions = p;
    float *n = realloc(m->solid.normals, room * 3 * sizeof *n);
    if (n)
        m->solid.normals = n;
    if (!p || !n)
        return false;
    m->vertex_room = room;
    return true;
}

unsigned ap_mesh_vertex(struct ap_mesh *mesh, struct ap_vec3 position, struct ap_vec3 normal) {
    struct ap_solid *s = &mesh->solid;
    if (s->vertex_count == mesh->vertex_room && !mesh->out_of_memory)
        mesh->out_of_memory = !grow_vertices(mesh);
    if (mesh->out_of_memory)
        return 0;
    double side = mesh->mirrored ? -1 : 1;
    const double p[3] = {side * position.x, position.y, position.z};
    const double n[3] = {side * normal.x, normal.y, normal.z};
    for (int i = 0; i < 3; i++) {
        s->positions[3 * s->vertex_count + (size_t)i] = (float)p[i];
        s->normals[3 * s->vertex_count + (size_t)i] = (float)n[i];
    }
    s->reach_m = fmax(s->reach_m, ap_vec3_length(position));
    return (unsigned)s->vertex_count++;
}

void ap_mesh_triangle(struct ap_mesh *mesh, unsigned a, unsigned b, unsigned c) {
    struct ap_solid *s = &mesh->solid;
    if (s->index_count + 3 > mesh->index_room && !mesh->out_of_memory) {
        size_t room = mesh->index_room ? 2 * mesh->index_room : 768;
        unsigned *grown = realloc(s->indices, room * sizeof *grown);
        mesh->out_of_memory = !grown;
        if (grown) {
            s->indices = grown;
            mesh->index_room = room;
        }
    }
    if (mesh->out_of_memory)
        return;
    const unsigned corner[3] = {a, mesh->mirrored ? c : b, mesh->mirrored ? b : c};
    for (int i = 0; i < 3; i++)
        s->indices[s->index_count++] = corner[i];
}

// Joins two rows of around + 1 vertices; the second row lies counterclockwise-up of the first.
static void join_rows(struct ap_mesh *mesh, unsigned lower, unsigned upper, unsigned around) {
    for (unsigned i = 0; i < around; i++) {
        ap_mesh_triangle(mesh, lower + i, lower + i + 1, upper + i + 1);
        ap_mesh_triangle(mesh, lower + i, upper + i + 1, upper + i);
    }
}

void ap_mesh_ellipsoid(struct ap_mesh *mesh, struct ap_pose mesh_from_shape, struct ap_vec3 radii) {
    unsigned before = 0;
    for (int j = 0; j <= ALONG; j++) {
        double lat = M_PI * (j - ALONG / 2.0) / ALONG;
        unsigned row = (unsigned)mesh->solid.vertex_count;
        for (int i = 0; i <= AROUND; i++) {
            double lon = 2 * M_PI * i / AROUND;
            struct ap_vec3 d = {cos(lat) * sin(lon), sin(lat), cos(lat) * cos(lon)};
            struct ap_vec3 p = {radii.x * d.x, radii.y * d.y, radii.z * d.z};
            struct ap_vec3 n = {d.x / radii.x, d.y / radii.y, d.z / radii.z};
            ap_mesh_vertex(mesh, ap_pose_apply(mesh_from_shape, p),
                           ap_vec3_normalize(ap_quat_rotate(mesh_from_shape.q, n)));
        }
        if (j > 0)
            join_rows(mesh, before, row, AROUND);
        before = row;
    }
}

void ap_mesh_limb(struct ap_mesh *mesh, struct ap_vec3 a, double r0, struct ap_vec3 b, double r1) {
    struct ap_vec3 axis = ap_vec3_normalize(ap_vec3_sub(b, a));
    struct ap_vec3 any = fabs(axis.x) < 0.7 ? (struct ap_vec3){1, 0, 0} : (struct ap_vec3){0, 1, 0};
    struct ap_vec3 u = ap_vec3_normalize(ap_vec3_cross(axis, any)), v = ap_vec3_cross(axis, u);
    unsigned before = 0;
    // Two half spheres; the tube is what joins their equators.
    for (int j = 0; j <= ALONG + 1; j++) {
        bool far = j > ALONG / 2;
        double lat = M_PI * (j - (far ? 1 : 0) - ALONG / 2.0) / ALONG, r = far ? r1 : r0;
        unsigned row = (unsigned)mesh->solid.vertex_count;
        for (int i = 0; i <= AROUND; i++) {
            double lon = 2 * M_PI * i / AROUND;
            struct ap_vec3 n =
                ap_vec3_add(ap_vec3_scale(sin(lat), axis),
                            ap_vec3_scale(cos(lat), ap_vec3_add(ap_vec3_scale(cos(lon), u),
                                                                ap_vec3_scale(sin(lon), v))));
            ap_mesh_vertex(mesh, ap_vec3_add(far ? b : a, ap_vec3_scale(r, n)), n);
        }
        if (j > 0)
            join_rows(mesh, before, row, AROUND);
        before = row;
    }
}
