#include "src/render/refine/refine_work.h"

#include <math.h>

#include "src/geom/table.h"
#include "src/render/refine/refine_stick.h"

// Where a part's triangles begin.

static const double PI = 3.14159265358979323846;
enum { AROUND = 8, GRID_MAX = 50000 };

static uint32_t node_at(struct ap_refine_work *w, double along, struct ap_vec3 from) {
    struct ap_surface_point point = {.from = from};
    ap_surface_place(&w->surface, along, &point);
    ap_surface_see(&w->surface, &point);
    return ap_refine_add_node(w, point);
}

static void begin_ball(struct ap_refine_work *w) {
    for (int i = 0; i < 12; i++)
        node_at(w, 0, ap_icosahedron_corner(i));
    // Cut once everywhere: from the icosahedron itself edges could cut off a whole side.
    struct ap_refine_triangle first[20];
    for (int f = 0; f < 20; f++) {
        int c[3];
        ap_icosahedron_face(f, c);
        first[f] = (struct ap_refine_triangle){{(uint32_t)c[0], (uint32_t)c[1], (uint32_t)c[2]}, 0};
    }
    w->cut_all = true;
    for (int f = 0; f < 20 && w->st == AP_OK; f++) {
        uint32_t m[3];
        for (int i = 0; i < 3; i++)
            m[i] = ap_refine_middle(w, first[f].corner[i], first[f].corner[(i + 1) % 3]);
        if (w->st == AP_OK)
            ap_refine_split(w, &first[f], m);
    }
    w->cut_all = false;
}

// A ring of nodes at one place along the axis; up: of a right angle, out of the cross-section.
struct ring {
    uint32_t first;
    uint32_t count; // 1: the pole
};

static struct ring add_ring(struct ap_refine_work *w, double along, double up, uint32_t count) {
    struct ring ring = {(uint32_t)w->r->node_count, count};
    double c = fabs(up) < 1 ? cos(PI / 2 * up) : 0, s = sin(PI / 2 * up);
    for (uint32_t i = 0; i < count; i++) {
        double turn = 2 * PI * i / count;
        node_at(w, along, (struct ap_vec3){c * cos(turn), c * sin(turn), s});
    }
    return ring;
}

// The band between two rings, the second farther along: corners by their order around the axis.
static void push_band(struct ap_refine_work *w, struct ring a, struct ring b) {
    uint32_t i = 0, j = 0, of_a = a.count > 1 ? a.count : 0, of_b = b.count > 1 ? b.count : 0;
    while (i < of_a || j < of_b) {
        uint32_t p = a.first + i % a.count, q = b.first + j % b.count;
        // Which of the next corners comes first; a pole has none.
        bool next_a =
            j == of_b || (i < of_a && (uint64_t)(i + 1) * b.count <= (uint64_t)(j + 1) * a.count);
        if (next_a)
            ap_refine_push(w, 0, p, a.first + ++i % a.count, q);
        else
            ap_refine_push(w, 0, p, b.first + ++j % b.count, q);
    }
}

// A round cap in bands as wide as the body's corners are apart; fewer corners toward the pole.
static void push_cap(struct ap_refine_work *w, double along, int end, struct ring last) {
    uint32_t around = last.count, bands = (around + 3) / 4;
    for (uint32_t k = 1; k <= bands; k++) {
        double up = (double)k / bands, part = cos(PI / 2 * up);
        uint32_t count = k == bands ? 1 : (uint32_t)fmax(ceil(part * around), 3);
        struct ring ring = add_ring(w, along, end * up, count);
        if (end < 0)
            push_band(w, ring, last);
        else
            push_band(w, last, ring);
        last = ring;
    }
}

static void begin_stick(struct ap_refine_work *w) {
    double half = w->surface.part->length_m / w->surface.space.rho_m / 2;
    struct ap_stick_grid grid = {.along = {-half, half}, .rings = 2, .around = AROUND};
    if (w->params->triangles_max > GRID_MAX)
        grid = ap_stick_grid_of(&w->surface, w->params->eyes,
                                AP_REFINE_SHARE * w->params->max_error_px);
    struct ring last = add_ring(w, -half, 0, (uint32_t)grid.around);
    push_cap(w, -half, -1, last);
    for (int i = 1; i < grid.rings && w->st == AP_OK; i++) {
        struct ring next = add_ring(w, grid.along[i], 0, (uint32_t)grid.around);
        push_band(w, last, next);
        last = next;
    }
    push_cap(w, half, 1, last);
}

static void begin_polygon(struct ap_refine_work *w) {
    const struct ap_part *part = w->surface.part;
    struct ap_space space = w->surface.space;
    double circum, in;
    w->st = ap_regular_polygon(w->err, space, part->sides, part->edge_m, &circum, &in);
    if (w->st != AP_OK)
        return;
    double s = ap_space_sin(space, circum / space.rho_m),
           c = ap_space_cos(space, circum / space.rho_m);
    for (int i = -1; i < part->sides && w->st == AP_OK; i++) {
        struct ap_surface_point point = {.p = {0, 0, 0, 1}};
        double a = PI / part->sides * (2 * i + 1);
        if (i >= 0)
            point.p = (struct ap_vec4){-s * sin(a), 0, -s * cos(a), c};
        ap_surface_see(&w->surface, &point);
        ap_refine_add_node(w, point);
    }
    for (int i = 0; i < part->sides; i++)
        ap_refine_push(w, 0, 0, (uint32_t)(i == 0 ? part->sides : i), (uint32_t)i + 1);
}

// A vertex of a solid.
static struct ap_surface_point solid_point(const struct ap_refine_work *w, const float *v) {
    double rho = w->surface.space.rho_m;
    struct ap_vec4 p = ap_exp(w->surface.space, (struct ap_vec3){v[0], v[1], v[2]});
    if (w->params->part_from_solid)
        p = ap_iso_apply(w->params->part_from_solid, p);
    struct ap_surface_point point = ap_surface_point_of(
        &w->surface, (struct ap_vec4){p.x / rho, p.y / rho, p.z / rho, p.w / rho});
    ap_surface_see(&w->surface, &point);
    return point;
}

// The same node for the same place, so that nothing is judged twice.
static uint32_t shared_node(struct ap_refine_work *w, struct ap_surface_point point) {
    for (uint32_t i = 0; i < w->r->node_count; i++) {
        const struct ap_vec4 *q = &w->r->nodes[i].point.p;
        if (q->x == point.p.x && q->y == point.p.y && q->z == point.p.z)
            return i;
    }
    return ap_refine_add_node(w, point);
}

void ap_refine_begin_mesh(struct ap_refine_work *w) {
    const struct ap_solid *solid = w->params->solid;
    for (size_t i = 0; i < solid->vertex_count && w->st == AP_OK; i++)
        ap_refine_add_node(w, solid_point(w, solid->positions + 3 * i));
    for (size_t i = 0; i + 2 < solid->index_count && w->st == AP_OK; i += 3)
        ap_refine_push(w, 0, solid->indices[i], solid->indices[i + 1], solid->indices[i + 2]);
}

// From the coarsest of its meshes made ahead, which has few vertices and whole seams.
enum { COARSEST_MAX = 64 };
static void begin_solid(struct ap_refine_work *w) {
    const struct ap_solid *solid = w->params->solid;
    uint32_t node[COARSEST_MAX];
    if (!w->params->seams || solid->vertex_count > COARSEST_MAX) {
        ap_refine_begin_mesh(w);
        return;
    }
    for (size_t i = 0; i < solid->vertex_count && w->st == AP_OK; i++)
        node[i] = shared_node(w, solid_point(w, solid->positions + 3 * i));
    for (int k = 0; k < solid->seam_count && w->st == AP_OK; k++)
        for (int i = 0; i <= 1; i++)
            w->r->nodes[node[solid->seams[2 * k + i]]].seams |= (unsigned char)(1 << k);
    for (size_t i = 0; i + 2 < solid->index_count && w->st == AP_OK; i += 3)
        ap_refine_push(w, 0, node[solid->indices[i]], node[solid->indices[i + 1]],
                       node[solid->indices[i + 2]]);
}

void ap_refine_begin(struct ap_refine_work *w, const struct ap_part *part) {
    if (part->kind == AP_PART_BALL)
        begin_ball(w);
    else if (part->kind == AP_PART_STICK)
        begin_stick(w);
    else if (part->kind == AP_PART_POLYGON)
        begin_polygon(w);
    else
        begin_solid(w);
}
