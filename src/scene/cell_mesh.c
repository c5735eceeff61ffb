#include "src/scene/honeycomb.h"

#include <string.h>

// The pieces of a cell as meshes. Points are found on the space and handed over as tangent vectors
// at the piece's place.

static struct ap_vec3 log_of(struct ap_space space, struct ap_vec4 p) {
    return ap_log_unchecked(space, p, 0);
}

static double between(struct ap_space space, struct ap_vec3 a, struct ap_vec3 b) {
    struct ap_iso a_from = ap_iso_inverse(space, ap_iso_translate(space, a));
    return ap_vec3_length(log_of(space, ap_iso_apply(&a_from, ap_exp(space, b))));
}

struct ap_iso ap_wall_place(const struct ap_tiling *t, int face) {
    return ap_iso_mul(t->symmetry[t->turn_to_face[face]].turn,
                      ap_shift(t->space, 0, -t->inradius_m, 0));
}

// About x, so that −z points to the middle of edge 0.
static struct ap_iso edge_turn(const struct ap_tiling *t) {
    struct ap_vec3 u = t->edge_out[0];
    return ap_iso_rotate(ap_quat_from_axis_angle((struct ap_vec3){1, 0, 0}, atan2(u.y, -u.z)));
}

struct ap_iso ap_strut_place(const struct ap_tiling *t, int edge) {
    return ap_iso_mul(ap_iso_mul(t->symmetry[t->turn_to_edge[edge]].turn, edge_turn(t)),
                      ap_shift(t->space, 0, 0, -t->midradius_m));
}

// −z to vertex 0, x across the mirror that holds vertex 0 and halves face 0's angle there.
static struct ap_iso vertex_turn(const struct ap_tiling *t) {
    struct ap_vec4 p = t->vertex_m[0];
    struct ap_vec3 z = ap_vec3_scale(-1, ap_vec3_normalize((struct ap_vec3){p.x, p.y, p.z}));
    struct ap_vec3 x = t->mirror[1], y = ap_vec3_cross(z, x);
    struct ap_iso m = AP_ISO_IDENTITY;
    const struct ap_vec3 column[3] = {x, y, z};
    for (int j = 0; j < 3; j++) {
        m.m[0][j] = column[j].x;
        m.m[1][j] = column[j].y;
        m.m[2][j] = column[j].z;
    }
    return m;
}

struct ap_iso ap_joint_place(const struct ap_tiling *t, int vertex) {
    return ap_iso_mul(ap_iso_mul(t->symmetry[t->turn_to_vertex[vertex]].turn, vertex_turn(t)),
                      ap_shift(t->space, 0, 0, -t->circumradius_m));
}

// The point of the geodesic from a to b at the share `s` of its length; the ends are a and b to the
// last bit, so that what meets there has one corner.
static struct ap_vec4 along(struct ap_space space, struct ap_vec4 a, struct ap_vec4 b, double s) {
    double rho = space.rho_m, x = b.x - a.x, y = b.y - a.y, z = b.z - a.z, w = b.w - a.w;
    double half = sqrt(fmax(x * x + y * y + z * z + space.kappa * w * w, 0)) / rho / 2;
    double t = space.kappa > 0 ? 2 * asin(half) : space.kappa < 0 ? 2 * asinh(half) : 2 * half;
    if (s <= 0 || s >= 1 || !(t > 0))
        return s < 0.5 ? a : b;
    double p = ap_space_sin(space, (1 - s) * t) / ap_space_sin(space, t),
           q = ap_space_sin(space, s * t) / ap_space_sin(space, t);
    return (struct ap_vec4){p * a.x + q * b.x, p * a.y + q * b.y, p * a.z + q * b.z,
                            p * a.w + q * b.w};
}

// Corner k of a face, seen from its centre, drawn in by `width` of the way there.
static struct ap_vec4 window_corner(const struct ap_tiling *t, const struct ap_iso *face_from_cell,
                                    int face, int k, double width) {
    struct ap_vec4 corner = ap_iso_apply(face_from_cell, t->vertex_m[t->face_vertex[face][k]]);
    return ap_exp(t->space, ap_vec3_scale(1 - width, log_of(t->space, corner)));
}

struct ap_window ap_wall_window(const struct ap_tiling *t, int face, double width) {
    struct ap_window window = {{{0, 0, 0, 0}}};
    struct ap_iso cell_from_face = ap_wall_place(t, face);
    struct ap_iso face_from_cell = ap_iso_inverse(t->space, cell_from_face);
    for (int k = 0; k < t->symbol.p; k++) {
        struct ap_vec4 corner = window_corner(t, &face_from_cell, face, k, width);
        window.corner_m[k] = ap_iso_apply(&cell_from_face, corner);
    }
    return window;
}

// A row of a wall from its outer to its inner edge, at the share `at` of face 0's edge k.
enum { ACROSS_MAX = 64 };
static void wall_row(const struct ap_tiling *t, const struct ap_vec3 corner[2], double width,
                     double at, int across, struct ap_vec3 row[ACROSS_MAX + 1]) {
    struct ap_space space = t->space;
    for (int i = 0; i <= across; i++) {
        double in = 1 - width * i / across;
        struct ap_vec4 a = ap_exp(space, ap_vec3_scale(in, corner[0])),
                       b = ap_exp(space, ap_vec3_scale(in, corner[1]));
        row[i] = log_of(space, along(space, a, b, at));
        row[i].y = 0;
    }
}

void ap_mesh_wall(const struct ap_tiling *t, double width, int fine, struct ap_mesh *mesh,
                  double *longest_m) {
    struct ap_space space = t->space;
    struct ap_iso face_from_cell = ap_iso_inverse(space, ap_wall_place(t, 0));
    struct ap_vec3 corner[6], row[ACROSS_MAX + 1], last[ACROSS_MAX + 1];
    int p = t->symbol.p;
    for (int k = 0; k <= p; k++)
        corner[k] =
            log_of(space, ap_iso_apply(&face_from_cell, t->vertex_m[t->face_vertex[0][k % p]]));
    int across = (int)ceil(fine * width * ap_vec3_length(corner[0]) / t->edge_m);
    across = across < ACROSS_MAX ? across : ACROSS_MAX;
    *longest_m = 0;
    ap_mesh_seams(mesh, p, fine);
    for (int k = 0; k < p; k++) {
        unsigned before = 0;
        for (int i = 0; i <= fine; i++) {
            unsigned first = (unsigned)mesh->solid.vertex_count;
            wall_row(t, corner + k, width, (double)i / fine, across, row);
            ap_mesh_seam_vertex(mesh, k, i, first);
            for (int j = 0; j <= across; j++)
                ap_mesh_vertex(mesh, row[j], (struct ap_vec3){0, 1, 0});
            for (unsigned j = 0; i > 0 && j < (unsigned)across; j++) {
                ap_mesh_triangle(mesh, before + j, first + j, first + j + 1);
                ap_mesh_triangle(mesh, before + j, first + j + 1, before + j + 1);
                *longest_m = fmax(*longest_m, between(space, last[j], row[j]));
                *longest_m = fmax(*longest_m, between(space, last[j], row[j + 1]));
                *longest_m = fmax(*longest_m, between(space, row[j], row[j + 1]));
            }
            memcpy(last, row, sizeof last);
            before = first;
        }
    }
}

// The way out of a tube at (t along x, angle phi about it from +z), and the point there.
static struct ap_iso tube_frame(struct ap_space space, double along_m, double radius_m,
                                double phi) {
    return ap_iso_mul(ap_shift(space, along_m, 0, 0),
                      ap_shift(space, 0, radius_m * sin(phi), radius_m * cos(phi)));
}

// A normal at exp(v) as a covector of the chart log: across the way to it lengths are S(r)/r of
// what they are in the chart.
static struct ap_vec3 chart_normal(struct ap_space space, struct ap_vec3 v,
                                   const struct ap_iso *place, struct ap_vec3 out) {
    struct ap_iso back = ap_iso_inverse(space, ap_iso_translate(space, v));
    struct ap_iso local = ap_iso_mul(back, *place);
    struct ap_vec4 n = ap_iso_apply(&local, (struct ap_vec4){out.x, out.y, out.z, 0});
    struct ap_vec3 n3 = {n.x, n.y, n.z}, u = ap_vec3_normalize(v);
    double r = ap_vec3_length(v) / space.rho_m, radial = ap_vec3_dot(n3, u);
    double shrink = r > 1e-9 ? ap_space_sin(space, r) / r : 1;
    struct ap_vec3 across = ap_vec3_sub(n3, ap_vec3_scale(radial, u));
    return ap_vec3_normalize(ap_vec3_add(ap_vec3_scale(radial, u), ap_vec3_scale(shrink, across)));
}

// Whether a point of the strut's frame is in the cell.
static bool in_cell(const struct ap_tiling *t, const struct ap_iso *cell_from_strut,
                    struct ap_vec4 p) {
    struct ap_vec4 q = ap_iso_apply(cell_from_strut, p);
    for (int f = 0; f < t->face_count; f++)
        if (ap_tiling_beyond(t, q, f) > 1e-9)
            return false;
    return true;
}

// How far along the edge the tube can go with all of its part between the two faces in the cell.
static double strut_half(const struct ap_tiling *t, double radius_m) {
    struct ap_iso place = ap_strut_place(t, 0);
    struct ap_vec4 base = {0, 0, 0, t->space.rho_m};
    double low = 0, high = t->edge_m / 2, beta = M_PI / t->symbol.r;
    for (int step = 0; step < 50; step++) {
        double middle = (low + high) / 2;
        bool inside = true;
        for (int i = -4; i <= 4; i++) {
            struct ap_iso at = tube_frame(t->space, middle, radius_m, beta * i / 4);
            inside = inside && in_cell(t, &place, ap_iso_apply(&at, base));
        }
        *(inside ? &low : &high) = middle;
    }
    return low;
}

double ap_joint_radius(const struct ap_tiling *t, double strut_radius_m) {
    struct ap_iso at = tube_frame(t->space, strut_half(t, strut_radius_m), strut_radius_m, 0);
    struct ap_vec4 base = {0, 0, 0, t->space.rho_m};
    struct ap_vec3 end = log_of(t->space, ap_iso_apply(&at, base));
    double reach = between(t->space, end, (struct ap_vec3){t->edge_m / 2, 0, 0});
    return fmax(1.5 * strut_radius_m, 1.02 * reach);
}

void ap_mesh_strut(const struct ap_tiling *t, double radius_m, int fine, struct ap_mesh *mesh,
                   double *longest_m, double *turn_rad) {
    struct ap_space space = t->space;
    struct ap_vec4 base = {0, 0, 0, space.rho_m};
    double half = strut_half(t, radius_m), beta = M_PI / t->symbol.r;
    // Far off the outline is what asks for fine ones; straight is straight in e3, but not for
    // somebody who was born elsewhere.
    int around = fine <= 2 ? fine : fine <= 4 ? 3 : fine / 2;
    int steps = fine < 4 || (space.kappa == 0 && fine < 32) ? 1 : fine / 2;
    unsigned before = 0;
    ap_mesh_seams(mesh, 2, steps);
    for (int i = 0; i <= steps; i++) {
        double x = half * (2.0 * i / steps - 1);
        unsigned row = (unsigned)mesh->solid.vertex_count;
        for (int j = 0; j <= around; j++) {
            double phi = beta * (2.0 * j / around - 1);
            struct ap_iso at = tube_frame(space, x, radius_m, phi);
            struct ap_vec3 v = log_of(space, ap_iso_apply(&at, base));
            struct ap_vec3 out = {0, sin(phi), cos(phi)};
            ap_mesh_vertex(mesh, v, chart_normal(space, v, &at, out));
        }
        ap_mesh_seam_vertex(mesh, 0, i, row);
        ap_mesh_seam_vertex(mesh, 1, i, row + (unsigned)around);
        for (unsigned j = 0; i > 0 && j < (unsigned)around; j++) {
            ap_mesh_triangle(mesh, before + j, row + j, row + j + 1);
            ap_mesh_triangle(mesh, before + j, row + j + 1, before + j + 1);
        }
        before = row;
    }
    *longest_m =
        2 * half / steps * ap_space_cos(space, space.kappa < 0 ? radius_m / space.rho_m : 0);
    *turn_rad = beta / around;
}

// The largest angle at the middle of a sphere between a facet's middle and its corners.
static double widest_turn(const struct ap_solid *solid, size_t first_index) {
    double least = 1;
    for (size_t i = first_index; i + 2 < solid->index_count; i += 3) {
        struct ap_vec3 c[3];
        for (int k = 0; k < 3; k++) {
            const float *p = solid->positions + 3 * solid->indices[i + (size_t)k];
            c[k] = ap_vec3_normalize((struct ap_vec3){p[0], p[1], p[2]});
        }
        struct ap_vec3 n =
            ap_vec3_normalize(ap_vec3_cross(ap_vec3_sub(c[1], c[0]), ap_vec3_sub(c[2], c[0])));
        least = fmin(least, fabs(ap_vec3_dot(n, c[0])));
    }
    return acos(least);
}

// Directions from a joint to the other ends of the cell's edges there, counterclockwise seen from
// within the cell, which is toward +z; returns how many.
static int joint_corners(const struct ap_tiling *t, struct ap_vec3 corner[5]) {
    struct ap_iso vertex_from_cell = ap_iso_inverse(t->space, ap_joint_place(t, 0));
    int count = 0;
    for (int e = 0; e < t->edge_count; e++)
        for (int side = 0; side < 2; side++)
            if (t->edge_vertex[e][side] == 0) {
                struct ap_vec4 end = t->vertex_m[t->edge_vertex[e][!side]];
                end = ap_iso_apply(&vertex_from_cell, end);
                corner[count++] = ap_vec3_normalize(log_of(t->space, end));
            }
    for (int i = 0; i < count; i++)
        for (int j = i + 1; j < count; j++)
            if (atan2(corner[j].y, corner[j].x) < atan2(corner[i].y, corner[i].x)) {
                struct ap_vec3 swap = corner[i];
                corner[i] = corner[j];
                corner[j] = swap;
            }
    return count;
}

// A row of a joint's piece between top, a and b: the share `down` of the way from the top, i of n.
static void joint_row(const struct ap_vec3 at[3], double down, int n, struct ap_vec3 row[]) {
    const struct ap_space ball = {1, 1};
    struct ap_vec4 p[3];
    for (int k = 0; k < 3; k++)
        p[k] = (struct ap_vec4){at[k].x, at[k].y, at[k].z, 0};
    struct ap_vec4 a = along(ball, p[0], p[1], down), b = along(ball, p[0], p[2], down);
    for (int j = 0; j <= n; j++) {
        struct ap_vec4 d = along(ball, a, b, n ? (double)j / n : 0);
        row[j] = ap_vec3_normalize((struct ap_vec3){d.x, d.y, d.z});
    }
}

void ap_mesh_joint(const struct ap_tiling *t, double radius_m, int fine, struct ap_mesh *mesh,
                   double *longest_m, double *turn_rad) {
    size_t first_index = mesh->solid.index_count;
    struct ap_vec3 corner[5], row[ACROSS_MAX + 1], last[ACROSS_MAX + 1];
    int count = joint_corners(t, corner);
    double longest = 0;
    ap_mesh_seams(mesh, count, fine);
    for (int k = 0; k < count; k++) {
        const struct ap_vec3 at[3] = {{0, 0, 1}, corner[k], corner[(k + 1) % count]};
        unsigned before = 0;
        for (int i = 0; i <= fine; i++) {
            unsigned first = (unsigned)mesh->solid.vertex_count;
            joint_row(at, (double)i / fine, i, row);
            for (int j = 0; j <= i; j++)
                ap_mesh_vertex(mesh, ap_vec3_scale(radius_m, row[j]), row[j]);
            for (int j = 0; i == fine && j <= i; j++)
                ap_mesh_seam_vertex(mesh, k, j, first + (unsigned)j);
            for (unsigned j = 0; i > 0 && j < (unsigned)i; j++) {
                ap_mesh_triangle(mesh, before + j, first + j, first + j + 1);
                if (j + 1 < (unsigned)i)
                    ap_mesh_triangle(mesh, before + j, first + j + 1, before + j + 1);
                longest = fmax(longest, ap_vec3_length(ap_vec3_sub(row[j], row[j + 1])));
                longest = fmax(longest, ap_vec3_length(ap_vec3_sub(row[j], last[j])));
                longest = fmax(longest, ap_vec3_length(ap_vec3_sub(row[j + 1], last[j])));
            }
            memcpy(last, row, sizeof last);
            before = first;
        }
    }
    *longest_m = longest * t->space.rho_m * ap_space_sin(t->space, radius_m / t->space.rho_m);
    *turn_rad = widest_turn(&mesh->solid, first_index);
}
