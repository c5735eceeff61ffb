#include "tests/render/reference_surface.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const double PI = 3.14159265358979323846;

void *ref_grow(void *at, size_t bytes) {
    void *more = realloc(at, bytes ? bytes : 1);
    if (!more) {
        fprintf(stderr, "no memory for the reference\n");
        exit(1);
    }
    return more;
}

void ref_cos_sin(int kappa, double t, double *c, double *s) {
    *c = kappa > 0 ? cos(t) : kappa < 0 ? cosh(t) : 1;
    *s = kappa > 0 ? sin(t) : kappa < 0 ? sinh(t) : t;
}

void ref_apply(const struct ap_iso *m, const double x[4], double y[4]) {
    double out[4];
    for (int i = 0; i < 4; i++)
        out[i] = m->m[i][0] * x[0] + m->m[i][1] * x[1] + m->m[i][2] * x[2] + m->m[i][3] * x[3];
    memcpy(y, out, sizeof out);
}

// The distance whose S this is; in s3 with its C.
static double arc(int kappa, double s, double c) {
    return kappa > 0 ? atan2(s, c) : kappa < 0 ? asinh(s) : s;
}

static double length3(const double x[3]) {
    return sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]);
}

// From the segment of the z axis, of half the length and a radius that goes from one end's to the
// other's: across the axis beside it, from its ends beyond.
static double stick_value(int kappa, const struct ref_prim *p, const double y[4]) {
    double across = hypot(y[0], y[1]);
    double foot = kappa > 0 ? atan2(y[2], y[3]) : kappa < 0 ? atanh(y[2] / y[3]) : y[2];
    if (fabs(foot) <= p->half) {
        double k = (foot + p->half) / (2 * p->half);
        double c = kappa > 0 ? hypot(y[2], y[3]) : 1;
        return arc(kappa, across, c) - (p->radius + k * (p->radius2 - p->radius));
    }
    double end = foot < 0 ? -p->half : p->half, c, s;
    ref_cos_sin(kappa, end, &c, &s);
    // translate(−end) along z takes that end to the base point.
    double at[3] = {y[0], y[1], c * y[2] - s * y[3]}, w = c * y[3] + kappa * s * y[2];
    return arc(kappa, length3(at), w) - (foot < 0 ? p->radius : p->radius2);
}

double ref_value(const struct ref_surfaces *s, const struct ref_prim *p, const double x[4]) {
    double y[4];
    if (p->shape == REF_FACET)
        return p->plane[0] * x[0] + p->plane[1] * x[1] + p->plane[2] * x[2] + p->plane[3] * x[3];
    ref_apply(&p->part_from_nose, x, y);
    switch (p->shape) {
    case REF_STICK:
        return stick_value(s->kappa, p, y);
    case REF_SHEET:
        return s->kappa > 0 ? asin(fmax(-1, fmin(1, y[1]))) : arc(s->kappa, y[1], 1);
    case REF_TUBE:
        return arc(s->kappa, hypot(y[1], y[2]), s->kappa > 0 ? hypot(y[0], y[3]) : 1) - p->radius;
    default:
        return arc(s->kappa, length3(y), y[3]) - p->radius;
    }
}

static double row(const struct ref_prim *p, int i, const double x[4]) {
    const double *m = p->part_from_nose.m[i];
    return m[0] * x[0] + m[1] * x[1] + m[2] * x[2] + m[3] * x[3];
}

double ref_cheap(const struct ref_prim *p, const double x[4]) {
    double y[4] = {0};
    switch (p->shape) {
    case REF_FACET:
        return p->plane[0] * x[0] + p->plane[1] * x[1] + p->plane[2] * x[2] + p->plane[3] * x[3];
    case REF_SHEET:
        return row(p, 1, x);
    case REF_TUBE:
        y[1] = row(p, 1, x);
        y[2] = row(p, 2, x);
        return y[1] * y[1] + y[2] * y[2] - p->sine * p->sine;
    case REF_STICK:
        ref_apply(&p->part_from_nose, x, y);
        return stick_value(1, p, y);
    default:
        return p->cosine - row(p, 3, x);
    }
}

// Inside of the regular polygon: by its edges' planes, S of the distance from each.
static bool in_polygon(int kappa, const struct ref_prim *p, double inradius, const double y[4]) {
    double c, s;
    ref_cos_sin(kappa, inradius, &c, &s);
    for (int i = 0; i < p->sides; i++) {
        double a = p->turn + 2 * PI * i / p->sides;
        if (c * (-sin(a) * y[0] - cos(a) * y[2]) - s * y[3] > 0)
            return false;
    }
    return true;
}

static bool in_cell(const struct ref_surfaces *s, int cell, const double x[4]) {
    const struct ap_tiling *t = s->tiling;
    double y[4], cosine, sine;
    ref_apply(&s->cell_from_nose[cell], x, y);
    ref_cos_sin(s->kappa, t->inradius_m / t->space.rho_m, &cosine, &sine);
    for (int f = 0; f < t->face_count; f++) {
        struct ap_vec3 n = t->face_out[f];
        if (cosine * (n.x * y[0] + n.y * y[1] + n.z * y[2]) - sine * y[3] > 1e-10)
            return false;
    }
    return true;
}

bool ref_within(const struct ref_surfaces *s, const struct ref_prim *p, const double x[4]) {
    double y[4];
    switch (p->shape) {
    case REF_TUBE:
    case REF_JOINT:
        return in_cell(s, p->cell, x);
    case REF_SHEET:
        ref_apply(&p->part_from_nose, x, y);
        return in_polygon(s->kappa, p, p->inradius[0], y) &&
               !(p->inradius[1] > 0 && in_polygon(s->kappa, p, p->inradius[1], y));
    case REF_FACET:
        for (int k = 0; k < 3; k++)
            if (p->side[k][0] * x[0] + p->side[k][1] * x[1] + p->side[k][2] * x[2] +
                    p->side[k][3] * x[3] <
                -1e-9)
                return false;
        return true;
    default:
        return true;
    }
}

static struct ref_prim *add_prim(struct ref_surfaces *s) {
    if (s->prim_count == s->prim_room) {
        s->prim_room = s->prim_room ? 2 * s->prim_room : 256;
        s->prims = ref_grow(s->prims, (size_t)s->prim_room * sizeof *s->prims);
    }
    struct ref_prim *p = &s->prims[s->prim_count++];
    memset(p, 0, sizeof *p);
    p->thing = s->thing_count - 1;
    p->cell = -1;
    return p;
}

static void add_thing(struct ref_surfaces *s, uint32_t part, struct ap_iso nose_from_part) {
    if (s->thing_count == s->thing_room) {
        s->thing_room = s->thing_room ? 2 * s->thing_room : 256;
        s->things = ref_grow(s->things, (size_t)s->thing_room * sizeof *s->things);
        s->bounds = ref_grow(s->bounds, (size_t)s->thing_room * sizeof *s->bounds);
    }
    s->things[s->thing_count++] = (struct ref_thing){part, nose_from_part};
}

// Of a regular polygon: tan (tanh, nothing) of the inradius is that of the circumradius times
// cos(π/n), and sin (sinh) of half an edge sin of the circumradius times sin(π/n).
static double inradius_of(int kappa, int sides, double circumradius) {
    double k = cos(PI / sides);
    return kappa > 0   ? atan(tan(circumradius) * k)
           : kappa < 0 ? atanh(tanh(circumradius) * k)
                       : circumradius * k;
}

static double circumradius_of(int kappa, int sides, double edge) {
    double c, s, k = 1 / sin(PI / sides);
    ref_cos_sin(kappa, edge / 2, &c, &s);
    return kappa > 0 ? asin(fmin(1, s * k)) : kappa < 0 ? asinh(s * k) : s * k;
}

static double distance_of(int kappa, const double a[4], const double b[4]) {
    if (kappa == 0) {
        double d[3] = {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
        return length3(d);
    }
    double inner = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + kappa * a[3] * b[3];
    return kappa > 0 ? acos(fmax(-1, fmin(1, inner))) : acosh(fmax(1, -inner));
}

// A point of a model: exp of a tangent vector at its place, in nose space.
static void model_point(int kappa, const struct ap_iso *nose_from_part, const double v[3],
                        double x[4]) {
    double t = length3(v), c, s, y[4];
    ref_cos_sin(kappa, t, &c, &s);
    for (int i = 0; i < 3; i++)
        y[i] = t > 0 ? s / t * v[i] : 0;
    y[3] = c;
    ref_apply(nose_from_part, y, x);
}

// The linear form that vanishes at three points of R⁴.
static void plane_through(const double a[4], const double b[4], const double c[4], double n[4]) {
    for (int i = 0; i < 4; i++) {
        int r[3], k = 0;
        for (int j = 0; j < 4; j++)
            if (j != i)
                r[k++] = j;
        double det = a[r[0]] * (b[r[1]] * c[r[2]] - b[r[2]] * c[r[1]]) -
                     a[r[1]] * (b[r[0]] * c[r[2]] - b[r[2]] * c[r[0]]) +
                     a[r[2]] * (b[r[0]] * c[r[1]] - b[r[1]] * c[r[0]]);
        n[i] = (i & 1 ? -1 : 1) * det;
    }
}

static double form(const double n[4], const double x[4]) {
    return n[0] * x[0] + n[1] * x[1] + n[2] * x[2] + n[3] * x[3];
}

static void add_facet(struct ref_surfaces *s, const struct ap_iso *m, double v[3][3]) {
    double x[3][4], up[4], e[3][3], n[3], most = 0;
    for (int i = 0; i < 3; i++) {
        e[0][i] = v[1][i] - v[0][i];
        e[1][i] = v[2][i] - v[0][i];
    }
    for (int i = 0; i < 3; i++)
        n[i] = e[0][(i + 1) % 3] * e[1][(i + 2) % 3] - e[0][(i + 2) % 3] * e[1][(i + 1) % 3];
    double area = length3(n);
    if (!(area > 1e-16)) // rows of a cap meet in a point
        return;
    for (int i = 0; i < 3; i++) {
        model_point(s->kappa, m, v[i], x[i]);
        e[2][i] = v[0][i] + n[i] / area * sqrt(area);
    }
    model_point(s->kappa, m, e[2], up);
    struct ref_prim *p = add_prim(s);
    p->shape = REF_FACET;
    p->samples = 1;
    plane_through(x[0], x[1], x[2], p->plane);
    double scale = 1 / length3(p->plane) * (form(p->plane, up) < 0 ? -1 : 1);
    for (int i = 0; i < 4; i++)
        p->plane[i] *= scale;
    for (int k = 0; k < 3; k++) {
        plane_through(x[(k + 1) % 3], x[(k + 2) % 3], up, p->side[k]);
        double one = 1 / form(p->side[k], x[k]);
        for (int i = 0; i < 4; i++)
            p->side[k][i] *= one;
    }
    // The middle, back on the space.
    double square = 0;
    for (int i = 0; i < 4; i++) {
        p->centre[i] = (x[0][i] + x[1][i] + x[2][i]) / 3;
        square += (i < 3 ? 1 : s->kappa) * p->centre[i] * p->centre[i];
    }
    for (int i = 0; s->kappa && i < 4; i++)
        p->centre[i] /= sqrt(s->kappa * square);
    for (int k = 0; k < 3; k++)
        most = fmax(most, distance_of(s->kappa, p->centre, x[k]));
    p->reach = most * 1.001 + 1e-7;
}

static void add_facets(struct ref_surfaces *s, const struct ap_scene *scene,
                       const struct ap_part *part, const struct ap_iso *m) {
    int finest = part->solid + (part->solid_levels > 0 ? part->solid_levels - 1 : 0);
    const struct ap_solid *solid = &scene->solids[finest];
    for (size_t i = 0; i + 2 < solid->index_count; i += 3) {
        double v[3][3];
        for (size_t k = 0; k < 3; k++)
            for (size_t j = 0; j < 3; j++)
                v[k][j] = solid->positions[3 * solid->indices[i + k] + j] / scene->space.rho_m;
        add_facet(s, m, v);
    }
}

static void set_sheet(struct ref_surfaces *s, struct ref_prim *p, int sides, double circumradius) {
    p->shape = REF_SHEET;
    p->samples = 12;
    p->sides = sides;
    p->inradius[0] = inradius_of(s->kappa, sides, circumradius);
    p->reach = circumradius;
}

// A piece of a cell.
static void set_piece(struct ref_surfaces *s, struct ref_prim *p, const struct ap_honeycomb *h,
                      const struct ap_part *part) {
    const struct ap_tiling *t = &h->tiling;
    double rho = t->space.rho_m;
    p->from_outside = true;
    p->radius = part->radius_m / rho;
    if (part->form == AP_FORM_PLANE) {
        double circumradius = t->face_circumradius_m / rho;
        set_sheet(s, p, t->symbol.p, circumradius);
        // A corner of the cell that lies in the wall's plane.
        struct ap_iso wall_from_cell = ap_iso_inverse(t->space, part->carrier_from_part);
        for (int k = 0; k < t->vertex_count; k++) {
            struct ap_vec4 v = ap_iso_apply(&wall_from_cell, t->vertex_m[k]);
            if (fabs(v.y) < 1e-9 * rho)
                p->turn = atan2(-v.x, -v.z) + PI / p->sides;
        }
        // A corner of the window of face 0 from that face's middle.
        struct ap_vec4 c = h->window[0].corner_m[0];
        double corner[4] = {c.x / rho, c.y / rho, c.z / rho, c.w / rho}, cosine, sine;
        ref_cos_sin(s->kappa, t->inradius_m / rho, &cosine, &sine);
        struct ap_vec3 out = t->face_out[0];
        double middle[4] = {sine * out.x, sine * out.y, sine * out.z, cosine};
        p->inradius[1] = inradius_of(s->kappa, p->sides, distance_of(s->kappa, corner, middle));
        return;
    }
    p->samples = 16;
    p->shape = part->form == AP_FORM_TUBE ? REF_TUBE : REF_JOINT;
    p->reach = p->radius + (part->form == AP_FORM_TUBE ? t->edge_m / rho / 2 : 0);
}

static void add_surface(struct ref_surfaces *s, const struct ap_scene *scene, uint32_t index,
                        struct ap_iso nose_from_carrier, int cell) {
    const struct ap_part *part = &scene->parts[index];
    double rho = scene->space.rho_m;
    struct ap_iso m = ap_iso_mul(nose_from_carrier, part->carrier_from_part);
    add_thing(s, index, m);
    if (part->kind == AP_PART_SOLID && part->form == AP_FORM_FACETS) {
        add_facets(s, scene, part, &m);
        return;
    }
    struct ref_prim *p = add_prim(s);
    p->cell = cell;
    p->samples = 8;
    p->radius = part->radius_m / rho;
    p->radius2 = part->radius2_m / rho;
    p->half = part->length_m / rho / 2;
    for (int i = 0; i < 4; i++)
        p->centre[i] = m.m[i][3];
    p->part_from_nose = ap_iso_inverse(scene->space, m);
    if (part->kind == AP_PART_BALL) {
        p->shape = REF_BALL;
        p->reach = p->radius;
        p->from_outside = cell >= 0;
    } else if (part->kind == AP_PART_STICK) {
        p->shape = REF_STICK;
        p->samples = 16;
        p->reach = p->half + fmax(p->radius, p->radius2);
    } else if (part->kind == AP_PART_POLYGON) {
        set_sheet(s, p, part->sides, circumradius_of(s->kappa, part->sides, part->edge_m / rho));
    } else {
        set_piece(s, p, scene->honeycomb, part);
    }
    p->reach = p->reach * (1 + 1e-9) + 1e-9;
    ref_cos_sin(s->kappa, p->radius, &p->cosine, &p->sine);
}

static void add_part(struct ref_surfaces *s, const struct ap_scene *scene, uint32_t index,
                     struct ap_iso nose_from_carrier, int cell) {
    int first = s->prim_count;
    add_surface(s, scene, index, nose_from_carrier, cell);
    struct ref_bound *b = &s->bounds[s->thing_count - 1];
    *b = (struct ref_bound){.first_prim = first, .prim_count = s->prim_count - first};
    for (int i = 0; i < 4; i++)
        b->centre[i] = s->things[s->thing_count - 1].nose_from_part.m[i][3];
    for (int i = first; i < s->prim_count; i++)
        b->reach = fmax(b->reach, s->prims[i].reach +
                                      distance_of(s->kappa, b->centre, s->prims[i].centre) + 1e-7);
}

// The cells about the nose's, each found across a face of one that is there.
static int walk_cells(const struct ap_honeycomb *h, struct ap_iso nose_from_world, double within,
                      struct ap_iso **found) {
    const struct ap_tiling *t = &h->tiling;
    int count = 1, room = 64;
    struct ap_iso *cell = ref_grow(NULL, (size_t)room * sizeof *cell);
    const double base[4] = {0, 0, 0, 1};
    cell[0] = nose_from_world;
    for (int i = 0; i < count; i++)
        for (int f = 0; f < t->face_count; f++) {
            struct ap_iso next = ap_iso_mul(cell[i], h->pairing.cell_from_neighbour[f]);
            double at[4], other[4];
            ref_apply(&next, base, at);
            bool known = distance_of(t->space.kappa, at, base) > within;
            for (int j = 0; j < count && !known; j++) {
                ref_apply(&cell[j], base, other);
                double dx = at[0] - other[0], dy = at[1] - other[1], dz = at[2] - other[2];
                known = hypot(hypot(dx, dy), hypot(dz, at[3] - other[3])) < 1e-4 * fmax(1, at[3]);
            }
            if (known)
                continue;
            if (count == room)
                cell = ref_grow(cell, (size_t)(room *= 2) * sizeof *cell);
            cell[count++] = next;
        }
    *found = cell;
    return count;
}

// How far off a cell is seen with a radius of horizon_px, as docs/honeycombs.md says it.
static double horizon_of(const struct ap_honeycomb *h, const struct ap_viewer *viewer,
                         const uint32_t size_px[2]) {
    double pixels = 0, rho = h->tiling.space.rho_m;
    for (int e = 0; e < 2; e++) {
        const struct ap_frustum *f = &viewer->eye[e].frustum;
        pixels =
            fmax(pixels, fmax(size_px[0] / (f->right - f->left), size_px[1] / (f->up - f->down)));
    }
    double c, s;
    ref_cos_sin(h->tiling.space.kappa, h->tiling.circumradius_m / rho, &c, &s);
    s /= sin(atan(h->horizon_px / pixels));
    return h->tiling.space.kappa > 0 ? INFINITY : h->tiling.space.kappa < 0 ? asinh(s) : s;
}

static void add_cells(struct ref_surfaces *s, const struct ap_scene *scene,
                      const struct ap_frame_input *input, struct ap_iso nose_from_world,
                      const uint32_t size_px[2]) {
    const struct ap_honeycomb *h = scene->honeycomb;
    double horizon = horizon_of(h, &input->viewer, size_px);
    const double base[4] = {0, 0, 0, 1};
    struct ap_iso *cell;
    int count =
        walk_cells(h, nose_from_world, horizon + h->tiling.inradius_m / scene->space.rho_m, &cell);
    s->tiling = &h->tiling;
    s->cell_from_nose = ref_grow(NULL, (size_t)count * sizeof *s->cell_from_nose);
    for (int i = 0; i < count; i++) {
        double at[4];
        s->cell_from_nose[i] = ap_iso_inverse(scene->space, cell[i]);
        ref_apply(&cell[i], base, at);
        if (!(distance_of(s->kappa, at, base) < horizon))
            continue;
        for (uint32_t k = 0; k < scene->part_count; k++)
            if (scene->parts[k].carrier == AP_CARRIER_CELL)
                add_part(s, scene, k, cell[i], i);
    }
    free(cell);
}

void ref_surfaces_fill(struct ref_surfaces *s, const struct ap_scene *scene,
                       const struct ap_frame_input *input, const uint32_t size_px[2]) {
    memset(s, 0, sizeof *s);
    s->kappa = scene->space.kappa;
    struct ap_iso nose_from_carrier[3],
        nose_from_world = ap_iso_inverse(scene->space, input->viewer.world_from_nose);
    nose_from_carrier[AP_CARRIER_WORLD] = nose_from_world;
    for (int hand = 0; hand < 2; hand++)
        nose_from_carrier[AP_CARRIER_LEFT + hand] =
            ap_iso_mul(nose_from_world, input->world_from_hand[hand]);
    for (uint32_t i = 0; i < scene->part_count; i++) {
        const struct ap_part *part = &scene->parts[i];
        bool missing = part->carrier == AP_CARRIER_CELL ||
                       (part->carrier == AP_CARRIER_LEFT && !input->hand_tracked[0]) ||
                       (part->carrier == AP_CARRIER_RIGHT && !input->hand_tracked[1]);
        if (!part->hidden && !missing)
            add_part(s, scene, i, nose_from_carrier[part->carrier], -1);
    }
    if (scene->honeycomb)
        add_cells(s, scene, input, nose_from_world, size_px);
}

void ref_surfaces_finish(struct ref_surfaces *s) {
    free(s->prims);
    free(s->things);
    free(s->bounds);
    free(s->cell_from_nose);
}
