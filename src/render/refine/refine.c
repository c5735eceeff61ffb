#include "src/render/refine/refine.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "src/geom/table.h"
#include "src/render/refine/refine_stick.h"

static const double PI = 3.14159265358979323846;
static const double SHARE = 0.75; // of the bound: what an edge's middle may use up
static const double AS_FAR = 1.1; // of what a seam is off: what edges there may be
// How far an edge's middle may be from its distance, of that distance: part_guard.glsl drops what
// is 5 % off.
static const double DEPTH_SHARE = 0.02;
// How far turned away something must be, and how much more where its normals differ: cosines.
static const double TURNED_AWAY = 0.01, TURNED_SHARE = 0.25;
static const double TURNED_REACH = 0.25; // in s3, over rho: how large it may look at most
static const uint32_t NOT_CUT = UINT32_MAX;
enum {
    AROUND = 8,
    DEEPEST = 90,
    PATIENCE = 30, // so deep edges are cut without need
    PASSES = 20,
    NODE_BITS = 24,
    PART_MAX = 65535,
    FEW_EDGES = 256,
    GRID_MAX = 50000
};

// How far a straight edge is off, pixels: in direction, and with its share of the error in depth.
struct error {
    double aside, all;
};

struct ap_refine_node {
    struct ap_surface_point point;
    unsigned char seams;  // bit k: it lies on the part's seam k
    unsigned char depth;  // it halves a piece of the seam that was cut so often
    struct error allowed; // of edges that end here
};

struct ap_refine_edge {
    uint64_t key; // what is at hand, and both ends; free where it is of something else
    uint32_t middle;
};

struct triangle {
    uint32_t corner[3], depth;
};

struct work {
    struct ap_error *err;
    struct ap_refiner *r;
    const struct ap_refine_params *params;
    struct ap_surface surface;
    double shortest; // over rho: edges up to this are not cut
    struct ap_mesh_data *data;
    struct triangle *stack;
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

static double length(struct ap_vec3 v) {
    return sqrt(ap_vec3_dot(v, v));
}

void ap_refiner_finish(struct ap_refiner *r) {
    free(r->nodes);
    free(r->edges);
    memset(r, 0, sizeof *r);
}

static bool grow(struct work *w, void **array, size_t *space, size_t count, size_t size) {
    if (count < *space)
        return true;
    size_t more = *space ? 2 * *space : 256;
    void *grown = realloc(*array, more * size);
    if (!grown) {
        w->st = ap_fail(w->err, AP_ENVIRONMENT, "no memory for %zu vertices", more);
        return false;
    }
    *array = grown;
    *space = more;
    return true;
}

static uint32_t add_node(struct work *w, struct ap_surface_point point) {
    if (!grow(w, (void **)&w->r->nodes, &w->r->node_space, w->r->node_count, sizeof *w->r->nodes))
        return 0;
    if (w->faces)
        ap_surface_face(&w->surface, &point);
    w->r->nodes[w->r->node_count] = (struct ap_refine_node){.point = point};
    return (uint32_t)w->r->node_count++;
}

static void push(struct work *w, uint32_t depth, uint32_t a, uint32_t b, uint32_t c) {
    if (grow(w, (void **)&w->stack, &w->stack_space, w->stack_count, sizeof *w->stack))
        w->stack[w->stack_count++] = (struct triangle){{a, b, c}, depth};
}

// --- edges

static bool in_use(const struct ap_refiner *r, size_t slot) {
    return r->edges[slot].key >> (2 * NODE_BITS) == r->part;
}

static size_t slot_of(const struct ap_refiner *r, uint64_t key) {
    size_t i = (size_t)(key * 0x9e3779b97f4a7c15u >> 40) & (r->edge_space - 1);
    while (in_use(r, i) && r->edges[i].key != key)
        i = (i + 1) & (r->edge_space - 1);
    return i;
}

// Twice the slots, of those that there are while there are enough: a small part's edges stay close
// together in memory, however large another one was.
static bool rehash(struct work *w) {
    struct ap_refiner *r = w->r;
    size_t count = r->edge_space, kept = 0, space = count ? 2 * count : FEW_EDGES;
    struct ap_refine_edge *edges = r->edges, *old = malloc((r->edge_count + 1) * sizeof *old);
    if (old && space > r->edge_room)
        edges = realloc(r->edges, space * sizeof *edges);
    if (!old || !edges) {
        free(old);
        w->st = ap_fail(w->err, AP_ENVIRONMENT, "no memory for %zu edges", space);
        return false;
    }
    r->edges = edges;
    if (space > r->edge_room) {
        memset(edges + r->edge_room, 0, (space - r->edge_room) * sizeof *edges);
        r->edge_room = space;
    }
    for (size_t i = 0; i < count; i++)
        if (in_use(r, i)) {
            old[kept++] = edges[i];
            edges[i].key = 0;
        }
    r->edge_space = space;
    for (size_t i = 0; i < kept; i++)
        edges[slot_of(r, old[i].key)] = old[i];
    free(old);
    return true;
}

// The same in any part's coordinates.
static double chord(struct ap_space space, struct ap_vec4 p, struct ap_vec4 q) {
    double x = p.x - q.x, y = p.y - q.y, z = p.z - q.z, w = p.w - q.w;
    return sqrt(fmax(x * x + y * y + z * z + space.kappa * w * w, 0));
}

// Whether something of the edge may be outside the forbidden millimetre: there alone it matters.
static bool matters(const struct work *w, const struct ap_surface_point *a,
                    const struct ap_surface_point *b, const struct ap_surface_point *m) {
    const struct ap_surface_point *points[3] = {a, m, b};
    double rho = w->surface.space.rho_m;
    for (int i = 0; i < 3; i++)
        for (int e = 0; e < 2; e++) {
            double d = length(points[i]->seen[e]);
            bool antipode = w->surface.mode != AP_VIEW_TOURIST && w->surface.space.kappa > 0 &&
                            fabs(length(points[i]->tangent_m) - PI * rho) < AP_NEAR_M;
            if (d >= AP_NEAR_M && !antipode)
                return true;
        }
    return false;
}

// An edge as long as it is far is not near enough to straight for its middle to speak for it.
static bool too_long(const struct work *w, const struct ap_surface_point *a,
                     const struct ap_surface_point *b, const struct ap_surface_point *m) {
    const struct ap_surface *s = &w->surface;
    bool sheet = s->shape == AP_SURFACE_SHEET, born = s->mode == AP_VIEW_BORN;
    if (s->mode == AP_VIEW_TOURIST || (sheet && s->space.kappa == 0 && !born))
        return false;
    // Near an antipode the surface may bulge straight away from both eyes without end.
    struct ap_vec3 straight = ap_vec3_scale(0.5, ap_vec3_add(a->tangent_m, b->tangent_m));
    if ((born || s->space.kappa > 0) &&
        length(ap_vec3_sub(m->tangent_m, straight)) > DEPTH_SHARE * length(m->tangent_m))
        return true;
    for (int e = 0; e < 2; e++) {
        struct ap_vec3 p = born ? a->tangent_m : a->seen[e], q = born ? b->tangent_m : b->seen[e],
                       r = born ? m->tangent_m : m->seen[e];
        double l = length(ap_vec3_sub(p, q));
        double d = fmin(fmin(length(p), length(q)), length(r));
        if (l > d && l > AP_NEAR_M)
            return true;
    }
    return false;
}

// How far the straight edge from a to b is off, at its middle m and halfway from there to its ends;
// more than most_px where it is. What bends one way and then the other crosses its surface in the
// middle: that alone would let a long edge pass beside which shorter ones do not, and a corner next
// to it would be cut off again and again.
static double off_px(struct work *w, const struct ap_surface_point *a,
                     const struct ap_surface_point *b, const struct ap_surface_point *m,
                     double most_px) {
    const struct ap_surface *s = &w->surface;
    const struct ap_eyes *eyes = w->params->eyes;
    double off = ap_surface_error_px(s, eyes, a, b, 0.5, m);
    if (!(off <= most_px) || ap_surface_is_straight(s))
        return off;
    struct ap_surface_point first = ap_surface_middle(s, a, m), last = ap_surface_middle(s, m, b);
    return fmax(off, fmax(ap_surface_error_px(s, eyes, a, b, 0.25, &first),
                          ap_surface_error_px(s, eyes, a, b, 0.75, &last)));
}

static double aside_px(struct work *w, const struct ap_surface_point *a,
                       const struct ap_surface_point *b, const struct ap_surface_point *m,
                       double most_px) {
    bool own = w->surface.any_depth;
    w->surface.any_depth = true;
    double off = off_px(w, a, b, m, most_px);
    w->surface.any_depth = own;
    return off;
}

// Whether the straight edge from a to b is close enough to the surface; m: the middle. allowed:
// more than the bound, or 0.
static bool close_enough(struct work *w, const struct ap_surface_point *a,
                         const struct ap_surface_point *b, const struct ap_surface_point *m,
                         struct error allowed) {
    double bound = SHARE * w->params->max_error_px;
    if (too_long(w, a, b, m))
        return false;
    double off = off_px(w, a, b, m, fmax(bound, allowed.all)), aside = fmax(bound, allowed.aside);
    return off <= bound || (off <= allowed.all && aside_px(w, a, b, m, aside) <= aside);
}

static bool cut(struct work *w, const struct ap_surface_point *a, const struct ap_surface_point *b,
                const struct ap_surface_point *m, struct error allowed) {
    if (w->cut_all)
        return true;
    if (close_enough(w, a, b, m, allowed))
        return false;
    if (chord(w->surface.space, a->p, b->p) > w->shortest)
        return true;
    w->held &= !matters(w, a, b, m);
    return false;
}

static void allow(struct ap_refine_node *node, struct error more) {
    node->allowed.aside = fmax(node->allowed.aside, more.aside);
    node->allowed.all = fmax(node->allowed.all, more.all);
}

// A piece of a seam is cut by what the seam is alone, so that the part beyond does the same. Where
// that leaves it coarser than edges are here, those that end at it may be as far off as it is: else
// there would be no end to them.
static bool cut_seam(struct work *w, uint32_t i, uint32_t j, int k,
                     const struct ap_surface_point *m) {
    struct ap_refine_node *a = &w->r->nodes[i], *b = &w->r->nodes[j];
    const struct ap_seam_cut *seam = &w->params->seams[k];
    bool own = w->surface.any_depth, yes;
    if (seam->depth == AP_SEAM_BY_PIECE) {
        w->surface.any_depth = seam->any_depth;
        yes = cut(w, &a->point, &b->point, m, (struct error){0, 0});
        w->surface.any_depth = own;
    } else {
        yes = (a->depth > b->depth ? a->depth : b->depth) < seam->depth;
    }
    if (yes)
        return true;
    const struct error off = {AS_FAR * aside_px(w, &a->point, &b->point, m, INFINITY),
                              AS_FAR * off_px(w, &a->point, &b->point, m, INFINITY)};
    allow(a, off);
    allow(b, off);
    return false;
}

static uint64_t key_of(const struct ap_refiner *r, uint32_t low, uint32_t high) {
    return (((uint64_t)r->part << NODE_BITS | high) << NODE_BITS) | low;
}

// The node in the middle of an edge that is cut, else NOT_CUT. Every edge is judged once.
static uint32_t middle_of(struct work *w, uint32_t i, uint32_t j) {
    struct ap_refiner *r = w->r;
    uint32_t low = i < j ? i : j, high = i < j ? j : i;
    if (3 * r->edge_count >= 2 * r->edge_space && !rehash(w))
        return NOT_CUT;
    uint64_t key = key_of(r, low, high);
    size_t slot = slot_of(r, key);
    if (in_use(r, slot))
        return r->edges[slot].middle;
    const struct ap_refine_node *a = &r->nodes[low], *b = &r->nodes[high];
    struct ap_surface_point m = ap_surface_middle(&w->surface, &a->point, &b->point);
    unsigned char seams = a->seams & b->seams;
    unsigned char depth = (a->depth > b->depth ? a->depth : b->depth) + 1;
    const struct error allowed = {fmax(a->allowed.aside, b->allowed.aside),
                                  fmax(a->allowed.all, b->allowed.all)};
    bool yes = seams ? cut_seam(w, low, high, ffs(seams) - 1, &m)
                     : cut(w, &a->point, &b->point, &m, allowed);
    uint32_t middle = yes ? add_node(w, m) : NOT_CUT;
    if (yes && seams && w->st == AP_OK) {
        r->nodes[middle].seams = seams;
        r->nodes[middle].depth = depth;
    }
    r->edges[slot] = (struct ap_refine_edge){key, middle};
    r->edge_count++;
    return middle;
}

// --- triangles

static int longest_side(const struct work *w, const struct triangle *t) {
    double most = -1;
    int longest = 0;
    for (int i = 0; i < 3; i++) {
        double side = chord(w->surface.space, w->r->nodes[t->corner[i]].point.p,
                            w->r->nodes[t->corner[(i + 1) % 3]].point.p);
        longest = side > most ? i : longest;
        most = fmax(side, most);
    }
    return longest;
}

// Cuts an edge that was kept, but for a seam's, which the part beyond keeps, too.
static uint32_t cut_after_all(struct work *w, uint32_t i, uint32_t j) {
    struct ap_refiner *r = w->r;
    uint32_t low = i < j ? i : j, high = i < j ? j : i;
    const struct ap_refine_node *a = &r->nodes[low], *b = &r->nodes[high];
    size_t slot = slot_of(r, key_of(r, low, high));
    if (a->seams & b->seams || !in_use(r, slot))
        return NOT_CUT;
    struct ap_surface_point m = ap_surface_middle(&w->surface, &a->point, &b->point);
    w->forced++;
    return r->edges[slot].middle = add_node(w, m);
}

static bool out_of_sight(const struct work *w, const struct triangle *t) {
    const struct ap_surface_point *p[3];
    for (int i = 0; i < 3; i++)
        p[i] = &w->r->nodes[t->corner[i]].point;
    return ap_surface_out_of_sight(&w->surface, p);
}

// In the curved space, where normals of different places cannot be compared: by those at the
// corners alone, and how far apart the corners are.
static bool tourist_turned_away(const struct work *w, const struct ap_surface_point *const p[3]) {
    double span = w->taper;
    for (int i = 0; i < 3; i++) {
        const struct ap_surface_point *q = p[(i + 1) % 3];
        span = fmax(span, length(ap_vec3_sub(p[i]->from, q->from)) + fabs(p[i]->along - q->along));
    }
    double least = TURNED_AWAY + TURNED_SHARE * span;
    for (int e = 0; e < 2; e++)
        for (int i = 0; i < 3; i++)
            if (!(p[i]->away[e] > least))
                return false;
    return true;
}

// Turned away from both eyes: normals within a triangle lie between those of its corners, and so do
// the lines of sight, so that products of all of these speak for it. What the surface bulges
// between them is small where they differ little.
static bool turned_away(const struct work *w, const struct triangle *t) {
    const struct ap_surface_point *p[3];
    if (!w->faces)
        return false;
    double span = w->taper;
    for (int i = 0; i < 3; i++)
        p[i] = &w->r->nodes[t->corner[i]].point;
    if (w->surface.mode == AP_VIEW_TOURIST)
        return tourist_turned_away(w, p);
    // About an antipode tangent space turns by any angle between corners that hardly differ.
    double reach = w->surface.space.kappa > 0 ? TURNED_REACH * w->surface.space.rho_m : INFINITY;
    for (int i = 0; i < 3; i++) {
        const struct ap_surface_point *q = p[(i + 1) % 3];
        span = fmax(span, length(ap_vec3_sub(p[i]->outward, q->outward)));
        if (!(length(ap_vec3_sub(p[i]->tangent_m, q->tangent_m)) < reach))
            return false;
    }
    for (int e = 0; e < 2; e++)
        for (int i = 0; i < 3; i++) {
            struct ap_vec3 sight = ap_vec3_sub(p[i]->tangent_m, w->surface.eye_m[e]);
            double least = (TURNED_AWAY + TURNED_SHARE * span) * length(sight);
            for (int k = 0; k < 3; k++)
                if (!(ap_vec3_dot(p[k]->outward, sight) > least))
                    return false;
        }
    return true;
}

static void emit(struct work *w, const struct triangle *t) {
    w->triangles++;
    w->st = ap_mesh_data_triangle(w->err, w->data, t->corner[0], t->corner[1], t->corner[2]);
}

// Rotated so that the cuts come first: one of three ways.
static void split(struct work *w, const struct triangle *t, const uint32_t m[3]) {
    int cuts = (m[0] != NOT_CUT) + (m[1] != NOT_CUT) + (m[2] != NOT_CUT), k = 0;
    // With one cut edge 0 is it; with two edge 0 is the one that is whole.
    while (cuts < 3 && (m[k] != NOT_CUT) != (cuts == 1))
        k++;
    uint32_t a = t->corner[k], b = t->corner[(k + 1) % 3], c = t->corner[(k + 2) % 3];
    uint32_t ab = m[k], bc = m[(k + 1) % 3], ca = m[(k + 2) % 3];
    if (cuts == 1) {
        push(w, t->depth + 1, a, ab, c);
        push(w, t->depth + 1, ab, b, c);
    } else if (cuts == 2) {
        push(w, t->depth + 1, bc, c, ca);
        push(w, t->depth + 1, a, b, bc);
        push(w, t->depth + 1, a, bc, ca);
    } else {
        push(w, t->depth + 1, a, ab, ca);
        push(w, t->depth + 1, ab, b, bc);
        push(w, t->depth + 1, ca, bc, c);
        push(w, t->depth + 1, ab, bc, ca);
    }
}

static void refine_one(struct work *w, const struct triangle *t) {
    uint32_t m[3] = {NOT_CUT, NOT_CUT, NOT_CUT};
    // Whatever is waiting becomes a triangle too.
    if (w->triangles + w->stack_count >= w->params->triangles_max || t->depth > DEEPEST)
        w->held = false;
    else if (!out_of_sight(w, t) && !turned_away(w, t))
        for (int i = 0; i < 3; i++)
            m[i] = middle_of(w, t->corner[i], t->corner[(i + 1) % 3]);
    else if (!w->params->keep_unseen) {
        w->unseen++;
        return;
    }
    if (m[0] == NOT_CUT && m[1] == NOT_CUT && m[2] == NOT_CUT) {
        emit(w, t);
        return;
    }
    // What is cut off again and again is a corner that has come to lie on the edge opposite: one
    // that was kept beside shorter ones that are not, however little they differ.
    int k = t->depth > PATIENCE ? longest_side(w, t) : 0;
    if (t->depth > PATIENCE && m[k] == NOT_CUT && w->st == AP_OK)
        m[k] = cut_after_all(w, t->corner[k], t->corner[(k + 1) % 3]);
    if (w->st == AP_OK)
        split(w, t, m);
}

// Triangles that were made beside an edge that is cut by now have a corner too few.
static void take_back(struct work *w) {
    const struct ap_mesh_data *data = w->data;
    for (size_t i = w->first_index; i + 2 < data->index_count; i += 3)
        push(w, 0, data->indices[i], data->indices[i + 1], data->indices[i + 2]);
    w->data->index_count = w->first_index;
    w->triangles = 0;
    w->forced = 0;
}

static void refine_all(struct work *w) {
    for (int pass = 0; w->st == AP_OK && w->stack_count > 0; pass++) {
        while (w->st == AP_OK && w->stack_count > 0) {
            struct triangle t = w->stack[--w->stack_count];
            refine_one(w, &t);
        }
        if (w->forced > 0 && pass < PASSES)
            take_back(w);
    }
    w->held &= w->forced == 0;
}

// --- what is refined

static uint32_t node_at(struct work *w, double along, struct ap_vec3 from) {
    struct ap_surface_point point = {.from = from};
    ap_surface_place(&w->surface, along, &point);
    ap_surface_see(&w->surface, &point);
    return add_node(w, point);
}

static void begin_ball(struct work *w) {
    for (int i = 0; i < 12; i++)
        node_at(w, 0, ap_icosahedron_corner(i));
    // Cut once everywhere: from the icosahedron itself edges could cut off a whole side.
    struct triangle first[20];
    for (int f = 0; f < 20; f++) {
        int c[3];
        ap_icosahedron_face(f, c);
        first[f] = (struct triangle){{(uint32_t)c[0], (uint32_t)c[1], (uint32_t)c[2]}, 0};
    }
    w->cut_all = true;
    for (int f = 0; f < 20 && w->st == AP_OK; f++) {
        uint32_t m[3];
        for (int i = 0; i < 3; i++)
            m[i] = middle_of(w, first[f].corner[i], first[f].corner[(i + 1) % 3]);
        if (w->st == AP_OK)
            split(w, &first[f], m);
    }
    w->cut_all = false;
}

// A ring of nodes at one place along the axis; up: of a right angle, out of the cross-section.
struct ring {
    uint32_t first;
    uint32_t count; // 1: the pole
};

static struct ring add_ring(struct work *w, double along, double up, uint32_t count) {
    struct ring ring = {(uint32_t)w->r->node_count, count};
    double c = fabs(up) < 1 ? cos(PI / 2 * up) : 0, s = sin(PI / 2 * up);
    for (uint32_t i = 0; i < count; i++) {
        double turn = 2 * PI * i / count;
        node_at(w, along, (struct ap_vec3){c * cos(turn), c * sin(turn), s});
    }
    return ring;
}

// The band between two rings, the second farther along: corners by their order around the axis.
static void push_band(struct work *w, struct ring a, struct ring b) {
    uint32_t i = 0, j = 0, of_a = a.count > 1 ? a.count : 0, of_b = b.count > 1 ? b.count : 0;
    while (i < of_a || j < of_b) {
        uint32_t p = a.first + i % a.count, q = b.first + j % b.count;
        // Which of the next corners comes first; a pole has none.
        bool next_a =
            j == of_b || (i < of_a && (uint64_t)(i + 1) * b.count <= (uint64_t)(j + 1) * a.count);
        if (next_a)
            push(w, 0, p, a.first + ++i % a.count, q);
        else
            push(w, 0, p, b.first + ++j % b.count, q);
    }
}

// A round cap in bands as wide as the body's corners are apart; fewer corners toward the pole.
static void push_cap(struct work *w, double along, int end, struct ring last) {
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

static void begin_stick(struct work *w) {
    double half = w->surface.part->length_m / w->surface.space.rho_m / 2;
    struct ap_stick_grid grid = {.along = {-half, half}, .rings = 2, .around = AROUND};
    if (w->params->triangles_max > GRID_MAX)
        grid = ap_stick_grid_of(&w->surface, w->params->eyes, SHARE * w->params->max_error_px);
    struct ring last = add_ring(w, -half, 0, (uint32_t)grid.around);
    push_cap(w, -half, -1, last);
    for (int i = 1; i < grid.rings && w->st == AP_OK; i++) {
        struct ring next = add_ring(w, grid.along[i], 0, (uint32_t)grid.around);
        push_band(w, last, next);
        last = next;
    }
    push_cap(w, half, 1, last);
}

static void begin_polygon(struct work *w) {
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
        add_node(w, point);
    }
    for (int i = 0; i < part->sides; i++)
        push(w, 0, 0, (uint32_t)(i == 0 ? part->sides : i), (uint32_t)i + 1);
}

// A vertex of a solid.
static struct ap_surface_point solid_point(const struct work *w, const float *v) {
    double rho = w->surface.space.rho_m;
    struct ap_vec4 p = ap_exp(w->surface.space, (struct ap_vec3){v[0], v[1], v[2]});
    struct ap_surface_point point = ap_surface_point_of(
        &w->surface, (struct ap_vec4){p.x / rho, p.y / rho, p.z / rho, p.w / rho});
    ap_surface_see(&w->surface, &point);
    return point;
}

// The same node for the same place, so that nothing is judged twice.
static uint32_t shared_node(struct work *w, struct ap_surface_point point) {
    for (uint32_t i = 0; i < w->r->node_count; i++) {
        const struct ap_vec4 *q = &w->r->nodes[i].point.p;
        if (q->x == point.p.x && q->y == point.p.y && q->z == point.p.z)
            return i;
    }
    return add_node(w, point);
}

// From a mesh made ahead as it is.
static void begin_mesh(struct work *w) {
    const struct ap_solid *solid = w->params->solid;
    for (size_t i = 0; i < solid->vertex_count && w->st == AP_OK; i++)
        add_node(w, solid_point(w, solid->positions + 3 * i));
    for (size_t i = 0; i + 2 < solid->index_count && w->st == AP_OK; i += 3)
        push(w, 0, solid->indices[i], solid->indices[i + 1], solid->indices[i + 2]);
}

// From the coarsest of its meshes made ahead, which has few vertices and whole seams.
enum { COARSEST_MAX = 64 };
static void begin_solid(struct work *w) {
    const struct ap_solid *solid = w->params->solid;
    uint32_t node[COARSEST_MAX];
    if (!w->params->seams || solid->vertex_count > COARSEST_MAX) {
        begin_mesh(w);
        return;
    }
    for (size_t i = 0; i < solid->vertex_count && w->st == AP_OK; i++)
        node[i] = shared_node(w, solid_point(w, solid->positions + 3 * i));
    for (int k = 0; k < solid->seam_count && w->st == AP_OK; k++)
        for (int i = 0; i <= 1; i++)
            w->r->nodes[node[solid->seams[2 * k + i]]].seams |= (unsigned char)(1 << k);
    for (size_t i = 0; i + 2 < solid->index_count && w->st == AP_OK; i += 3)
        push(w, 0, node[solid->indices[i]], node[solid->indices[i + 1]],
             node[solid->indices[i + 2]]);
}

static void write_nodes(struct work *w) {
    for (size_t i = 0; w->st == AP_OK && i < w->r->node_count; i++) {
        const struct ap_surface_point *point = &w->r->nodes[i].point;
        // A ball's meshes hold unit vectors, of which the shader makes points.
        struct ap_vec4 p = w->surface.part->kind == AP_PART_BALL
                               ? (struct ap_vec4){point->from.x, point->from.y, point->from.z, 0}
                               : point->p;
        w->st = ap_mesh_data_vertex(w->err, w->data, p, ap_surface_normal(&w->surface, point));
    }
}

static void begin(struct work *w, const struct ap_part *part) {
    const struct ap_refine_params *params = w->params;
    struct ap_refiner *r = w->r;
    w->surface =
        ap_surface_of(params->viewer, params->eyes, part, params->nose_from_part, params->image);
    w->surface.any_depth = params->any_depth;
    w->faces =
        params->closed && w->surface.shape != AP_SURFACE_SHEET && w->surface.mode != AP_VIEW_BORN;
    w->taper =
        part->kind == AP_PART_STICK ? fabs(part->radius2_m - part->radius_m) / part->length_m : 0;
    double rho = params->viewer->space.rho_m;
    const struct ap_eyes *eyes = params->eyes;
    double fine = sqrt(params->max_error_px / fmax(eyes->pixels[0], eyes->pixels[1]));
    w->shortest = fmin(AP_NEAR_M / rho * fmin(8 * fine, 1. / 3), 1e-3);
    double radius = fmax(part->radius_m, part->radius2_m) / rho;
    if (w->surface.shape != AP_SURFACE_SHEET)
        w->shortest = fmin(w->shortest, 0.005 * radius);
    r->node_count = r->edge_count = 0;
    r->part = r->part % PART_MAX + 1;
    if (r->edges && r->part == 1)
        memset(r->edges, 0, r->edge_room * sizeof *r->edges);
    r->edge_space = r->edge_room < FEW_EDGES ? r->edge_room : FEW_EDGES;
}

bool ap_refine_holds(struct ap_refiner *r, const struct ap_refine_params *params,
                     const struct ap_part *part) {
    struct ap_error err;
    struct work w = {.err = &err, .r = r, .params = params, .held = true, .st = AP_OK};
    begin(&w, part);
    begin_mesh(&w);
    while (w.st == AP_OK && w.held && w.stack_count > 0) {
        struct triangle t = w.stack[--w.stack_count];
        if (out_of_sight(&w, &t) || turned_away(&w, &t))
            continue;
        for (int i = 0; i < 3 && w.held && w.st == AP_OK; i++)
            w.held = middle_of(&w, t.corner[i], t.corner[(i + 1) % 3]) == NOT_CUT && w.held;
    }
    free(w.stack);
    return w.st == AP_OK && w.held;
}

enum ap_status ap_refine_part(struct ap_error *err, struct ap_refiner *r,
                              const struct ap_refine_params *params, const struct ap_part *part,
                              struct ap_mesh_data *data, struct ap_mesh *mesh, bool *held,
                              uint32_t *unseen) {
    struct work w = {.err = err, .r = r, .params = params, .data = data, .held = true, .st = AP_OK};
    begin(&w, part);
    struct ap_mesh made = ap_mesh_data_begin(data);
    w.first_index = data->index_count;
    if (part->kind == AP_PART_BALL)
        begin_ball(&w);
    else if (part->kind == AP_PART_STICK)
        begin_stick(&w);
    else if (part->kind == AP_PART_POLYGON)
        begin_polygon(&w);
    else
        begin_solid(&w);
    if (w.st == AP_OK)
        refine_all(&w);
    if (w.st == AP_OK)
        write_nodes(&w);
    free(w.stack);
    if (w.st == AP_OK) {
        ap_mesh_data_end(data, &made);
        *mesh = made;
        *held = w.held;
        *unseen = w.unseen;
    }
    return w.st;
}
