#include "src/render/mesh/mesh.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "src/geom/table.h"
#include "src/geom/vec.h"

static const double PI = 3.14159265358979323846;

void ap_mesh_data_finish(struct ap_mesh_data *data) {
    free(data->vertices);
    free(data->indices);
    memset(data, 0, sizeof *data);
}

// Room for so many more; the caller fills what it asked for and no more.
static enum ap_status reserve(struct ap_error *err, struct ap_mesh_data *data, size_t vertices,
                              size_t indices) {
    size_t want_v = data->vertex_count + vertices, want_i = data->index_count + indices;
    if (want_v > UINT32_MAX / 64 || want_i > UINT32_MAX / 8)
        return ap_fail(err, AP_INPUT, "the scene has too many vertices for the renderer");
    if (want_v > data->vertex_space) {
        size_t space = want_v + want_v / 2;
        void *grown = realloc(data->vertices, space * sizeof *data->vertices);
        if (!grown)
            return ap_fail(err, AP_ENVIRONMENT, "no memory for %zu vertices", space);
        data->vertices = grown;
        data->vertex_space = space;
    }
    if (want_i > data->index_space) {
        size_t space = want_i + want_i / 2;
        void *grown = realloc(data->indices, space * sizeof *data->indices);
        if (!grown)
            return ap_fail(err, AP_ENVIRONMENT, "no memory for %zu triangles", space / 3);
        data->indices = grown;
        data->index_space = space;
    }
    return AP_OK;
}

size_t ap_mesh_data_bytes(const struct ap_mesh_data *data) {
    return data->vertex_space * sizeof *data->vertices + data->index_space * sizeof *data->indices;
}

struct ap_mesh ap_mesh_data_begin(const struct ap_mesh_data *data) {
    return (struct ap_mesh){.first_vertex = (uint32_t)data->vertex_count,
                            .first_index = (uint32_t)data->index_count};
}

void ap_mesh_data_end(const struct ap_mesh_data *data, struct ap_mesh *mesh) {
    mesh->vertex_count = (uint32_t)data->vertex_count - mesh->first_vertex;
    mesh->index_count = (uint32_t)data->index_count - mesh->first_index;
}

static void add_vertex(struct ap_mesh_data *data, struct ap_vec4 p, struct ap_vec4 n) {
    data->vertices[data->vertex_count++] =
        (struct ap_vertex){{(float)p.x, (float)p.y, (float)p.z, (float)p.w},
                           {(float)n.x, (float)n.y, (float)n.z, (float)n.w}};
}

static void add_triangle(struct ap_mesh_data *data, uint32_t a, uint32_t b, uint32_t c) {
    uint32_t *to = data->indices + data->index_count;
    to[0] = a;
    to[1] = b;
    to[2] = c;
    data->index_count += 3;
}

enum ap_status ap_mesh_data_vertex(struct ap_error *err, struct ap_mesh_data *data,
                                   struct ap_vec4 position, struct ap_vec4 normal) {
    enum ap_status st = reserve(err, data, 1, 0);
    if (st == AP_OK)
        add_vertex(data, position, normal);
    return st;
}

enum ap_status ap_mesh_data_copy(struct ap_error *err, struct ap_mesh_data *data,
                                 const struct ap_vertex *vertex) {
    enum ap_status st = reserve(err, data, 1, 0);
    if (st == AP_OK)
        data->vertices[data->vertex_count++] = *vertex;
    return st;
}

enum ap_status ap_mesh_data_append(struct ap_error *err, struct ap_mesh_data *data,
                                   const struct ap_mesh_data *from, const struct ap_mesh *mesh,
                                   struct ap_mesh *copy) {
    enum ap_status st = reserve(err, data, mesh->vertex_count, mesh->index_count);
    if (st != AP_OK)
        return st;
    struct ap_mesh made = ap_mesh_data_begin(data);
    memcpy(data->vertices + data->vertex_count, from->vertices + mesh->first_vertex,
           mesh->vertex_count * sizeof *data->vertices);
    memcpy(data->indices + data->index_count, from->indices + mesh->first_index,
           mesh->index_count * sizeof *data->indices);
    data->vertex_count += mesh->vertex_count;
    data->index_count += mesh->index_count;
    ap_mesh_data_end(data, &made);
    *copy = made;
    return AP_OK;
}

enum ap_status ap_mesh_data_triangle(struct ap_error *err, struct ap_mesh_data *data, uint32_t a,
                                     uint32_t b, uint32_t c) {
    enum ap_status st = reserve(err, data, 0, 3);
    if (st == AP_OK)
        add_triangle(data, a, b, c);
    return st;
}

struct ap_vec3 ap_icosahedron_corner(int i) {
    if (i == 0)
        return (struct ap_vec3){0, 1, 0};
    if (i == 11)
        return (struct ap_vec3){0, -1, 0};
    double y = (i <= 5 ? 1 : -1) / sqrt(5), r = 2 / sqrt(5);
    double a = PI / 5 * (i <= 5 ? 2 * (i - 1) : 2 * (i - 6) + 1);
    return (struct ap_vec3){r * sin(a), y, r * cos(a)};
}

void ap_icosahedron_face(int f, int corner[3]) {
    int k = f % 5, next = (k + 1) % 5;
    static const int TOP = 0, BOTTOM = 11, UPPER = 1, LOWER = 6;
    int faces[4][3] = {{TOP, UPPER + k, UPPER + next},
                       {UPPER + k, LOWER + k, UPPER + next},
                       {LOWER + k, LOWER + next, UPPER + next},
                       {BOTTOM, LOWER + next, LOWER + k}};
    memcpy(corner, faces[f / 5], sizeof faces[0]);
}

// The point of a triangle of unit vectors at (i, j) of n steps, on the sphere.
static struct ap_vec3 sphere_point(const struct ap_vec3 c[3], int i, int j, int n) {
    struct ap_vec3 p = ap_vec3_add(ap_vec3_scale(n - i - j, c[0]),
                                   ap_vec3_add(ap_vec3_scale(i, c[1]), ap_vec3_scale(j, c[2])));
    return ap_vec3_normalize(p);
}

// Index of grid point (i, j) of a triangle of n steps, rows of growing i.
static uint32_t grid_index(int i, int j, int n) {
    return (uint32_t)(i * (n + 1) - i * (i - 1) / 2 + j);
}

static void add_grid_triangles(struct ap_mesh_data *data, uint32_t base, int n) {
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n - i; j++) {
            uint32_t a = base + grid_index(i, j, n), b = base + grid_index(i + 1, j, n),
                     c = base + grid_index(i, j + 1, n);
            add_triangle(data, a, b, c);
            if (j < n - i - 1)
                add_triangle(data, b, base + grid_index(i + 1, j + 1, n), c);
        }
}

static double angle_between(struct ap_vec3 a, struct ap_vec3 b) {
    return atan2(ap_vec3_length(ap_vec3_cross(a, b)), ap_vec3_dot(a, b));
}

static double circumradius(struct ap_vec3 a, struct ap_vec3 b, struct ap_vec3 c) {
    return angle_between(ap_vec3_normalize(ap_vec3_cross(ap_vec3_sub(b, a), ap_vec3_sub(c, a))), a);
}

// The largest circumradius of a face's facets.
static double largest_facet(const struct ap_vec3 corner[3], int n) {
    double largest = 0;
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n - i; j++) {
            struct ap_vec3 a = sphere_point(corner, i, j, n), b = sphere_point(corner, i + 1, j, n),
                           c = sphere_point(corner, i, j + 1, n);
            largest = fmax(largest, circumradius(a, b, c));
            if (j < n - i - 1) // the one that points the other way is the larger
                largest = fmax(largest, circumradius(b, sphere_point(corner, i + 1, j + 1, n), c));
        }
    return largest;
}

enum ap_status ap_mesh_sphere(struct ap_error *err, int steps, struct ap_mesh_data *data,
                              struct ap_mesh *mesh, double *facet_rad) {
    int n = steps;
    size_t per_face = (size_t)(n + 1) * (size_t)(n + 2) / 2;
    enum ap_status st = reserve(err, data, 20 * per_face, (size_t)60 * (size_t)n * (size_t)n);
    if (st != AP_OK)
        return st;
    struct ap_mesh made = ap_mesh_data_begin(data);
    double largest = 0;
    for (int f = 0; f < 20; f++) {
        int index[3];
        ap_icosahedron_face(f, index);
        struct ap_vec3 corner[3] = {ap_icosahedron_corner(index[0]),
                                    ap_icosahedron_corner(index[1]),
                                    ap_icosahedron_corner(index[2])};
        uint32_t base = (uint32_t)data->vertex_count - made.first_vertex;
        for (int i = 0; i <= n; i++)
            for (int j = 0; j <= n - i; j++) {
                struct ap_vec3 u = sphere_point(corner, i, j, n);
                add_vertex(data, (struct ap_vec4){u.x, u.y, u.z, 0},
                           (struct ap_vec4){u.x, u.y, u.z, 0});
            }
        add_grid_triangles(data, base, n);
        if (f % 5 == 0) // the five of a row are congruent
            largest = fmax(largest, largest_facet(corner, n));
    }
    ap_mesh_data_end(data, &made);
    *mesh = made;
    *facet_rad = largest;
    return AP_OK;
}

// The point at distance r (angle phi about z, elevation psi out of the cross-section toward +z) of
// the axis point at z = s, and the normal of the tube there; all lengths over rho.
static void add_tube_vertex(struct ap_mesh_data *data, struct ap_space space, double s, double r,
                            double phi, double psi) {
    double sr = ap_space_sin(space, r), cr = ap_space_cos(space, r);
    double ss = ap_space_sin(space, s), cs = ap_space_cos(space, s);
    double ux = cos(psi) * cos(phi), uy = cos(psi) * sin(phi), uz = sin(psi);
    double nw = -space.kappa * sr;
    struct ap_vec4 p = {sr * ux, sr * uy, cs * sr * uz + ss * cr,
                        cs * cr - space.kappa * ss * sr * uz};
    struct ap_vec4 n = {cr * ux, cr * uy, cs * cr * uz + ss * nw,
                        cs * nw - space.kappa * ss * cr * uz};
    add_vertex(data, p, n);
}

enum ap_status ap_mesh_stick(struct ap_error *err, struct ap_space space,
                             const struct ap_part *part, int around, int along,
                             struct ap_mesh_data *data, struct ap_mesh *mesh, double *step_m) {
    double half = part->length_m / space.rho_m / 2, r0 = part->radius_m / space.rho_m,
           r1 = part->radius2_m / space.rho_m;
    // Finer about the axis, finer along it: both serve the same closeness.
    double steps = space.kappa == 0 ? 4 : ceil(1.25 * around * half);
    if (along <= 0)
        along = (int)fmin(fmax(steps, 4), 192);
    int cap = around / 4 > 2 ? around / 4 : 2;
    int rings = along + 1 + 2 * cap;
    size_t ring_size = (size_t)around + 1;
    enum ap_status st =
        reserve(err, data, (size_t)rings * ring_size, (size_t)(rings - 1) * (size_t)around * 6);
    if (st != AP_OK)
        return st;
    struct ap_mesh made = ap_mesh_data_begin(data);
    for (int ring = 0; ring < rings; ring++) {
        int k = ring - cap; // < 0 and > along: in a cap
        double t = fmin(fmax((double)k / along, 0), 1);
        double psi = k < 0 ? PI / 2 * k / cap : k > along ? PI / 2 * (k - along) / cap : 0;
        for (int i = 0; i <= around; i++)
            add_tube_vertex(data, space, (2 * t - 1) * half, r0 + t * (r1 - r0),
                            2 * PI * i / around, psi);
    }
    for (int ring = 0; ring + 1 < rings; ring++)
        for (int i = 0; i < around; i++) {
            uint32_t a = (uint32_t)ring * (uint32_t)ring_size + (uint32_t)i;
            uint32_t b = a + (uint32_t)ring_size;
            add_triangle(data, a, a + 1, b + 1);
            add_triangle(data, a, b + 1, b);
        }
    ap_mesh_data_end(data, &made);
    *mesh = made;
    *step_m = part->length_m / along;
    return AP_OK;
}

// A combination of points, back on the space.
static struct ap_vec4 barycentre(struct ap_space space, const struct ap_vec4 corner[3], int i,
                                 int j, int n) {
    double a = (double)(n - i - j) / n, b = (double)i / n, c = (double)j / n;
    struct ap_vec4 p = {a * corner[0].x + b * corner[1].x + c * corner[2].x, 0,
                        a * corner[0].z + b * corner[1].z + c * corner[2].z,
                        a * corner[0].w + b * corner[1].w + c * corner[2].w};
    double r2 = p.x * p.x + p.z * p.z;
    double norm = space.kappa > 0   ? sqrt(p.w * p.w + r2)
                  : space.kappa < 0 ? sqrt(p.w * p.w - r2)
                                    : p.w;
    return (struct ap_vec4){p.x / norm, 0, p.z / norm, p.w / norm};
}

enum ap_status ap_mesh_polygon(struct ap_error *err, struct ap_space space, int sides,
                               double edge_m, int division, struct ap_mesh_data *data,
                               struct ap_mesh *mesh) {
    double circum, in;
    int n = division;
    enum ap_status st = ap_regular_polygon(err, space, sides, edge_m, &circum, &in);
    if (st == AP_OK)
        st = reserve(err, data, (size_t)sides * (size_t)(n + 1) * (size_t)(n + 2) / 2,
                     (size_t)sides * (size_t)n * (size_t)n * 3);
    if (st != AP_OK)
        return st;
    struct ap_mesh made = ap_mesh_data_begin(data);
    double s = ap_space_sin(space, circum / space.rho_m),
           c = ap_space_cos(space, circum / space.rho_m);
    struct ap_vec4 up = {0, 1, 0, 0};
    for (int side = 0; side < sides; side++) {
        // Edge 0's midpoint lies toward −z; counterclockwise from above.
        double a0 = PI / sides * (2 * side - 1), a1 = PI / sides * (2 * side + 1);
        struct ap_vec4 corner[3] = {
            {0, 0, 0, 1}, {-s * sin(a0), 0, -s * cos(a0), c}, {-s * sin(a1), 0, -s * cos(a1), c}};
        uint32_t base = (uint32_t)data->vertex_count - made.first_vertex;
        for (int i = 0; i <= n; i++)
            for (int j = 0; j <= n - i; j++)
                add_vertex(data, barycentre(space, corner, i, j, n), up);
        add_grid_triangles(data, base, n);
    }
    ap_mesh_data_end(data, &made);
    *mesh = made;
    return AP_OK;
}

// exp of a tangent vector, and what it makes of a normal there: a covector, so its part across the
// geodesic grows by theta/sin theta where lengths shrink by sin theta/theta.
static void add_solid_vertex(struct ap_mesh_data *data, struct ap_space space, struct ap_vec3 v,
                             struct ap_vec3 normal) {
    double r = ap_vec3_length(v), t = r / space.rho_m;
    double s = ap_space_sin(space, t), c = ap_space_cos(space, t);
    struct ap_vec3 u = r > 0 ? ap_vec3_scale(1 / r, v) : normal;
    double along = ap_vec3_dot(normal, u), grow = s > 0 ? t / s : 1;
    struct ap_vec3 across = ap_vec3_scale(grow, ap_vec3_sub(normal, ap_vec3_scale(along, u)));
    double length = hypot(along, ap_vec3_length(across)), k = length > 0 ? 1 / length : 0;
    struct ap_vec3 n = ap_vec3_scale(k, ap_vec3_add(across, ap_vec3_scale(along * c, u)));
    struct ap_vec3 p = ap_vec3_scale(s, r > 0 ? u : (struct ap_vec3){0, 0, 0});
    add_vertex(data, (struct ap_vec4){p.x, p.y, p.z, c},
               (struct ap_vec4){n.x, n.y, n.z, -space.kappa * s * along * k});
}

enum ap_status ap_mesh_solid(struct ap_error *err, struct ap_space space,
                             const struct ap_solid *solid, struct ap_mesh_data *data,
                             struct ap_mesh *mesh) {
    enum ap_status st = reserve(err, data, solid->vertex_count, solid->index_count);
    if (st != AP_OK)
        return st;
    struct ap_mesh made = ap_mesh_data_begin(data);
    for (size_t i = 0; i < solid->vertex_count; i++) {
        const float *p = solid->positions + 3 * i, *n = solid->normals + 3 * i;
        add_solid_vertex(data, space, (struct ap_vec3){p[0], p[1], p[2]},
                         (struct ap_vec3){n[0], n[1], n[2]});
    }
    for (size_t i = 0; i + 2 < solid->index_count; i += 3)
        add_triangle(data, solid->indices[i], solid->indices[i + 1], solid->indices[i + 2]);
    ap_mesh_data_end(data, &made);
    *mesh = made;
    return AP_OK;
}
