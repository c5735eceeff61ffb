#include "src/render/refine/refine_work.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

// Which edges are cut: how far off they are, and the memory of it.

enum { NODE_BITS = 24, PART_MAX = 65535, FEW_EDGES = 256 };
static const double PI = 3.14159265358979323846;
static const double AS_FAR = 1.1; // of what a seam is off: what edges there may be
// How far an edge's middle may be from its distance, of that distance: part_guard.glsl drops what
// is 5 % off.
static const double DEPTH_SHARE = 0.02;

static double length(struct ap_vec3 v) {
    return sqrt(ap_vec3_dot(v, v));
}

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
static bool rehash(struct ap_refine_work *w) {
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

void ap_refine_forget(struct ap_refiner *r) {
    r->node_count = r->edge_count = 0;
    r->part = r->part % PART_MAX + 1;
    if (r->edges && r->part == 1)
        memset(r->edges, 0, r->edge_room * sizeof *r->edges);
    r->edge_space = r->edge_room < FEW_EDGES ? r->edge_room : FEW_EDGES;
}

double ap_refine_chord(struct ap_space space, struct ap_vec4 p, struct ap_vec4 q) {
    double x = p.x - q.x, y = p.y - q.y, z = p.z - q.z, w = p.w - q.w;
    return sqrt(fmax(x * x + y * y + z * z + space.kappa * w * w, 0));
}

// Whether something of the edge may be outside the forbidden millimetre: there alone it matters.
static bool matters(const struct ap_refine_work *w, const struct ap_surface_point *a,
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
static bool too_long(const struct ap_refine_work *w, const struct ap_surface_point *a,
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
static double off_px(struct ap_refine_work *w, const struct ap_surface_point *a,
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

static double aside_px(struct ap_refine_work *w, const struct ap_surface_point *a,
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
static bool close_enough(struct ap_refine_work *w, const struct ap_surface_point *a,
                         const struct ap_surface_point *b, const struct ap_surface_point *m,
                         struct ap_refine_error allowed) {
    double bound = AP_REFINE_SHARE * w->params->max_error_px;
    if (too_long(w, a, b, m))
        return false;
    double off = off_px(w, a, b, m, fmax(bound, allowed.all)), aside = fmax(bound, allowed.aside);
    return off <= bound || (off <= allowed.all && aside_px(w, a, b, m, aside) <= aside);
}

static bool cut(struct ap_refine_work *w, const struct ap_surface_point *a,
                const struct ap_surface_point *b, const struct ap_surface_point *m,
                struct ap_refine_error allowed) {
    if (w->cut_all)
        return true;
    if (close_enough(w, a, b, m, allowed))
        return false;
    if (ap_refine_chord(w->surface.space, a->p, b->p) > w->shortest)
        return true;
    w->held &= !matters(w, a, b, m);
    return false;
}

static void allow(struct ap_refine_node *node, struct ap_refine_error more) {
    node->allowed.aside = fmax(node->allowed.aside, more.aside);
    node->allowed.all = fmax(node->allowed.all, more.all);
}

// A piece of a seam is cut by what the seam is alone, so that the part beyond does the same. Where
// that leaves it coarser than edges are here, those that end at it may be as far off as it is: else
// there would be no end to them.
static bool cut_seam(struct ap_refine_work *w, uint32_t i, uint32_t j, int k,
                     const struct ap_surface_point *m) {
    struct ap_refine_node *a = &w->r->nodes[i], *b = &w->r->nodes[j];
    const struct ap_seam_cut *seam = &w->params->seams[k];
    bool own = w->surface.any_depth, yes;
    if (seam->depth == AP_SEAM_BY_PIECE) {
        w->surface.any_depth = seam->any_depth;
        yes = cut(w, &a->point, &b->point, m, (struct ap_refine_error){0, 0});
        w->surface.any_depth = own;
    } else {
        yes = (a->depth > b->depth ? a->depth : b->depth) < seam->depth;
    }
    if (yes)
        return true;
    const struct ap_refine_error off = {AS_FAR * aside_px(w, &a->point, &b->point, m, INFINITY),
                                        AS_FAR * off_px(w, &a->point, &b->point, m, INFINITY)};
    allow(a, off);
    allow(b, off);
    return false;
}

static uint64_t key_of(const struct ap_refiner *r, uint32_t low, uint32_t high) {
    return (((uint64_t)r->part << NODE_BITS | high) << NODE_BITS) | low;
}

uint32_t ap_refine_middle(struct ap_refine_work *w, uint32_t i, uint32_t j) {
    struct ap_refiner *r = w->r;
    uint32_t low = i < j ? i : j, high = i < j ? j : i;
    if (3 * r->edge_count >= 2 * r->edge_space && !rehash(w))
        return AP_NOT_CUT;
    uint64_t key = key_of(r, low, high);
    size_t slot = slot_of(r, key);
    if (in_use(r, slot))
        return r->edges[slot].middle;
    const struct ap_refine_node *a = &r->nodes[low], *b = &r->nodes[high];
    struct ap_surface_point m = ap_surface_middle(&w->surface, &a->point, &b->point);
    unsigned char seams = a->seams & b->seams;
    unsigned char depth = (a->depth > b->depth ? a->depth : b->depth) + 1;
    const struct ap_refine_error allowed = {fmax(a->allowed.aside, b->allowed.aside),
                                            fmax(a->allowed.all, b->allowed.all)};
    bool yes = seams ? cut_seam(w, low, high, ffs(seams) - 1, &m)
                     : cut(w, &a->point, &b->point, &m, allowed);
    uint32_t middle = yes ? ap_refine_add_node(w, m) : AP_NOT_CUT;
    if (yes && seams && w->st == AP_OK) {
        r->nodes[middle].seams = seams;
        r->nodes[middle].depth = depth;
    }
    r->edges[slot] = (struct ap_refine_edge){key, middle};
    r->edge_count++;
    return middle;
}

uint32_t ap_refine_cut_after_all(struct ap_refine_work *w, uint32_t i, uint32_t j) {
    struct ap_refiner *r = w->r;
    uint32_t low = i < j ? i : j, high = i < j ? j : i;
    const struct ap_refine_node *a = &r->nodes[low], *b = &r->nodes[high];
    size_t slot = slot_of(r, key_of(r, low, high));
    if (a->seams & b->seams || !in_use(r, slot))
        return AP_NOT_CUT;
    struct ap_surface_point m = ap_surface_middle(&w->surface, &a->point, &b->point);
    w->forced++;
    return r->edges[slot].middle = ap_refine_add_node(w, m);
}
