#include "src/scene/mesh.h"

#include <limits.h>
#include <stdlib.h>

double ap_mesh_sagitta_m(int level) {
    static const double sagitta_m[AP_MESH_LEVELS] = {3.2e-3, 1.6e-3, 8e-4, 4e-4, 2e-4};
    return sagitta_m[level];
}

// Into how many chords a circle of this radius is divided; a multiple of four.
static int chords(struct ap_mesh *mesh, double radius_m) {
    double sagitta = mesh->sagitta_m > 0 ? mesh->sagitta_m : ap_mesh_sagitta_m(AP_MESH_LEVELS - 1);
    double turn = sagitta < radius_m ? acos(1 - sagitta / radius_m) : M_PI / 2;
    int quarters = (int)ceil(M_PI / 4 / turn);
    int n = 4 * (quarters < 2 ? 2 : quarters > 16 ? 16 : quarters);
    mesh->roundest_m = fmax(mesh->roundest_m, radius_m);
    mesh->solid.longest_m = fmax(mesh->solid.longest_m, 2 * radius_m * sin(M_PI / n));
    return n;
}

void ap_mesh_finish(struct ap_mesh *mesh) {
    free(mesh->solid.positions);
    free(mesh->solid.normals);
    free(mesh->solid.indices);
    free(mesh->solid.seams);
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

void ap_mesh_seams(struct ap_mesh *mesh, int count, int pieces) {
    mesh->solid.seams = calloc((size_t)count * (size_t)(pieces + 1), sizeof *mesh->solid.seams);
    mesh->out_of_memory = mesh->out_of_memory || !mesh->solid.seams;
    mesh->solid.seam_count = count;
    mesh->solid.seam_pieces = pieces;
}

void ap_mesh_seam_vertex(struct ap_mesh *mesh, int seam, int i, unsigned vertex) {
    if (mesh->solid.seams)
        mesh->solid.seams[seam * (mesh->solid.seam_pieces + 1) + i] = vertex;
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
    int around = chords(mesh, fmax(radii.x, fmax(radii.y, radii.z))), along = around / 2;
    unsigned before = 0;
    for (int j = 0; j <= along; j++) {
        double lat = M_PI * (j - along / 2.0) / along;
        unsigned row = (unsigned)mesh->solid.vertex_count;
        for (int i = 0; i <= around; i++) {
            double lon = 2 * M_PI * i / around;
            struct ap_vec3 d = {cos(lat) * sin(lon), sin(lat), cos(lat) * cos(lon)};
            struct ap_vec3 p = {radii.x * d.x, radii.y * d.y, radii.z * d.z};
            struct ap_vec3 n = {d.x / radii.x, d.y / radii.y, d.z / radii.z};
            ap_mesh_vertex(mesh, ap_pose_apply(mesh_from_shape, p),
                           ap_vec3_normalize(ap_quat_rotate(mesh_from_shape.q, n)));
        }
        if (j > 0)
            join_rows(mesh, before, row, (unsigned)around);
        before = row;
    }
}

// A ring of what is swept along `axis`; u, v: across it, so that u × v is the axis.
struct row {
    struct ap_vec3 middle, axis, u, v;
    double radius_m, lat; // lat: of a half sphere at an end, else 0
};

// Joined to the row before, unless that is UINT_MAX. Returns this one.
static unsigned add_row(struct ap_mesh *mesh, const struct row *r, int around, unsigned before) {
    unsigned row = (unsigned)mesh->solid.vertex_count;
    for (int i = 0; i <= around; i++) {
        double lon = 2 * M_PI * i / around;
        struct ap_vec3 across =
            ap_vec3_add(ap_vec3_scale(cos(lon), r->u), ap_vec3_scale(sin(lon), r->v));
        struct ap_vec3 n =
            ap_vec3_add(ap_vec3_scale(sin(r->lat), r->axis), ap_vec3_scale(cos(r->lat), across));
        ap_mesh_vertex(mesh, ap_vec3_add(r->middle, ap_vec3_scale(r->radius_m, n)), n);
    }
    if (before != UINT_MAX)
        join_rows(mesh, before, row, (unsigned)around);
    return row;
}

void ap_mesh_limb(struct ap_mesh *mesh, struct ap_vec3 a, double r0, struct ap_vec3 b, double r1) {
    struct ap_vec3 axis = ap_vec3_normalize(ap_vec3_sub(b, a));
    struct ap_vec3 any = fabs(axis.x) < 0.7 ? (struct ap_vec3){1, 0, 0} : (struct ap_vec3){0, 1, 0};
    struct ap_vec3 u = ap_vec3_normalize(ap_vec3_cross(axis, any));
    int around = chords(mesh, fmax(r0, r1)), cap = around / 4;
    struct row row = {.axis = axis, .u = u, .v = ap_vec3_cross(axis, u)};
    unsigned before = UINT_MAX;
    // Two half spheres; the tube is what joins their equators.
    for (int j = 0; j < 2 * (cap + 1); j++) {
        bool far = j > cap;
        row.middle = far ? b : a;
        row.radius_m = far ? r1 : r0;
        row.lat = M_PI / 2 * (far ? j - cap - 1 : j - cap) / cap;
        before = add_row(mesh, &row, around, before);
    }
    mesh->solid.longest_m = fmax(mesh->solid.longest_m, ap_vec3_length(ap_vec3_sub(b, a)));
}

void ap_mesh_arc(struct ap_mesh *mesh, const struct ap_mesh_arc *arc) {
    double turn = arc->to_rad - arc->from_rad;
    int around = chords(mesh, arc->thick_m), cap = around / 4;
    int steps = (int)ceil(chords(mesh, arc->radius_m + arc->thick_m) * turn / (2 * M_PI));
    unsigned before = UINT_MAX;
    for (int j = -cap; j <= steps + cap; j++) {
        double a = arc->from_rad + turn * fmin(fmax((double)j / steps, 0), 1);
        struct ap_vec3 out = {sin(a), 0, cos(a)};
        struct row row = {.axis = {cos(a), 0, -sin(a)},
                          .u = out,
                          .v = {0, -1, 0},
                          .middle = ap_vec3_scale(arc->radius_m, out),
                          .radius_m = arc->thick_m,
                          .lat = M_PI / 2 *
                                 (j < 0       ? j
                                  : j > steps ? j - steps
                                              : 0) /
                                 cap};
        row.middle.y = arc->height_m;
        before = add_row(mesh, &row, around, before);
    }
}
