#include "src/render/refine/refine_work.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

// How far turned away something must be, and how much more where its normals differ: cosines.
static const double TURNED_AWAY = 0.01, TURNED_SHARE = 0.25;
static const double LEAST = 1e-12;       // over rho: places of a part are not known better
static const double TURNED_REACH = 0.25; // in s3, over rho: how large it may look at most
enum {
    DEEPEST = 90,
    PATIENCE = 30, // so deep edges are cut without need
    PASSES = 20
};

static double length(struct ap_vec3 v) {
    return sqrt(ap_vec3_dot(v, v));
}

void ap_refiner_finish(struct ap_refiner *r) {
    free(r->nodes);
    free(r->edges);
    memset(r, 0, sizeof *r);
}

static bool grow(struct ap_refine_work *w, void **array, size_t *space, size_t count, size_t size) {
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

uint32_t ap_refine_add_node(struct ap_refine_work *w, struct ap_surface_point point) {
    if (!grow(w, (void **)&w->r->nodes, &w->r->node_space, w->r->node_count, sizeof *w->r->nodes))
        return 0;
    if (w->faces)
        ap_surface_face(&w->surface, &point);
    w->r->nodes[w->r->node_count] = (struct ap_refine_node){.point = point};
    return (uint32_t)w->r->node_count++;
}

void ap_refine_push(struct ap_refine_work *w, uint32_t depth, uint32_t a, uint32_t b, uint32_t c) {
    if (grow(w, (void **)&w->stack, &w->stack_space, w->stack_count, sizeof *w->stack))
        w->stack[w->stack_count++] = (struct ap_refine_triangle){{a, b, c}, depth};
}

static int longest_side(const struct ap_refine_work *w, const struct ap_refine_triangle *t) {
    double most = -1;
    int longest = 0;
    for (int i = 0; i < 3; i++) {
        double side = ap_refine_chord(w->surface.space, w->r->nodes[t->corner[i]].point.p,
                                      w->r->nodes[t->corner[(i + 1) % 3]].point.p);
        longest = side > most ? i : longest;
        most = fmax(side, most);
    }
    return longest;
}

static bool out_of_sight(const struct ap_refine_work *w, const struct ap_refine_triangle *t) {
    const struct ap_surface_point *p[3];
    for (int i = 0; i < 3; i++)
        p[i] = &w->r->nodes[t->corner[i]].point;
    return ap_surface_out_of_sight(&w->surface, p);
}

// In the curved space, where normals of different places cannot be compared: by those at the
// corners alone, and how far apart the corners are.
static bool tourist_turned_away(const struct ap_refine_work *w,
                                const struct ap_surface_point *const p[3]) {
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
static bool turned_away(const struct ap_refine_work *w, const struct ap_refine_triangle *t) {
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

static void emit(struct ap_refine_work *w, const struct ap_refine_triangle *t) {
    w->triangles++;
    w->st = ap_mesh_data_triangle(w->err, w->data, t->corner[0], t->corner[1], t->corner[2]);
}

// Rotated so that the cuts come first: one of three ways.
void ap_refine_split(struct ap_refine_work *w, const struct ap_refine_triangle *t,
                     const uint32_t m[3]) {
    int cuts = (m[0] != AP_NOT_CUT) + (m[1] != AP_NOT_CUT) + (m[2] != AP_NOT_CUT), k = 0;
    // With one cut edge 0 is it; with two edge 0 is the one that is whole.
    while (cuts < 3 && (m[k] != AP_NOT_CUT) != (cuts == 1))
        k++;
    uint32_t a = t->corner[k], b = t->corner[(k + 1) % 3], c = t->corner[(k + 2) % 3];
    uint32_t ab = m[k], bc = m[(k + 1) % 3], ca = m[(k + 2) % 3];
    if (cuts == 1) {
        ap_refine_push(w, t->depth + 1, a, ab, c);
        ap_refine_push(w, t->depth + 1, ab, b, c);
    } else if (cuts == 2) {
        ap_refine_push(w, t->depth + 1, bc, c, ca);
        ap_refine_push(w, t->depth + 1, a, b, bc);
        ap_refine_push(w, t->depth + 1, a, bc, ca);
    } else {
        ap_refine_push(w, t->depth, a, ab, ca);
        ap_refine_push(w, t->depth, ab, b, bc);
        ap_refine_push(w, t->depth, ca, bc, c);
        ap_refine_push(w, t->depth, ab, bc, ca);
    }
}

static void refine_one(struct ap_refine_work *w, const struct ap_refine_triangle *t) {
    uint32_t m[3] = {AP_NOT_CUT, AP_NOT_CUT, AP_NOT_CUT};
    // Whatever is waiting becomes a triangle too.
    if (w->triangles + w->stack_count >= w->params->triangles_max || t->depth > DEEPEST)
        w->held = false;
    else if (!out_of_sight(w, t) && !turned_away(w, t))
        for (int i = 0; i < 3; i++)
            m[i] = ap_refine_middle(w, t->corner[i], t->corner[(i + 1) % 3]);
    else if (!w->params->keep_unseen) {
        w->unseen++;
        return;
    }
    if (m[0] == AP_NOT_CUT && m[1] == AP_NOT_CUT && m[2] == AP_NOT_CUT) {
        emit(w, t);
        return;
    }
    // What is cut off again and again is a corner that has come to lie on the edge opposite: one
    // that was kept beside shorter ones that are not, however little they differ.
    int k = t->depth > PATIENCE ? longest_side(w, t) : 0;
    if (t->depth > PATIENCE && m[k] == AP_NOT_CUT && w->st == AP_OK)
        m[k] = ap_refine_cut_after_all(w, t->corner[k], t->corner[(k + 1) % 3]);
    if (w->st == AP_OK)
        ap_refine_split(w, t, m);
}

// Triangles that were made beside an edge that is cut by now have a corner too few.
static void take_back(struct ap_refine_work *w) {
    const struct ap_mesh_data *data = w->data;
    for (size_t i = w->first_index; i + 2 < data->index_count; i += 3)
        ap_refine_push(w, 0, data->indices[i], data->indices[i + 1], data->indices[i + 2]);
    w->data->index_count = w->first_index;
    w->triangles = 0;
    w->forced = 0;
}

static void refine_all(struct ap_refine_work *w) {
    for (int pass = 0; w->st == AP_OK && w->stack_count > 0; pass++) {
        while (w->st == AP_OK && w->stack_count > 0) {
            struct ap_refine_triangle t = w->stack[--w->stack_count];
            refine_one(w, &t);
        }
        if (w->forced > 0 && pass < PASSES)
            take_back(w);
    }
    w->held &= w->forced == 0;
}

static void write_nodes(struct ap_refine_work *w) {
    for (size_t i = 0; w->st == AP_OK && i < w->r->node_count; i++) {
        const struct ap_surface_point *point = &w->r->nodes[i].point;
        // A ball's meshes hold unit vectors, of which the shader makes points.
        struct ap_vec4 p = w->surface.part->kind == AP_PART_BALL
                               ? (struct ap_vec4){point->from.x, point->from.y, point->from.z, 0}
                               : point->p;
        w->st = ap_mesh_data_vertex(w->err, w->data, p, ap_surface_normal(&w->surface, point));
    }
}

// Of the nose above a sheet's plane, over rho; a sine.
static double height_of(const struct ap_refine_params *params) {
    struct ap_iso part_from_nose = ap_iso_inverse(params->viewer->space, params->nose_from_part);
    return fabs(part_from_nose.m[1][3]);
}

static void begin(struct ap_refine_work *w, const struct ap_part *part) {
    const struct ap_refine_params *params = w->params;
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
    // The long way round, a plane next to the nose is as large as half of the sky.
    else if (params->image == 1 && params->part_from_solid)
        w->shortest = fmin(w->shortest, fmax(height_of(params) / 64, LEAST));
    ap_refine_forget(w->r);
}

bool ap_refine_holds(struct ap_refiner *r, const struct ap_refine_params *params,
                     const struct ap_part *part) {
    struct ap_error err;
    struct ap_refine_work w = {.err = &err, .r = r, .params = params, .held = true, .st = AP_OK};
    begin(&w, part);
    ap_refine_begin_mesh(&w);
    while (w.st == AP_OK && w.held && w.stack_count > 0) {
        struct ap_refine_triangle t = w.stack[--w.stack_count];
        if (out_of_sight(&w, &t) || turned_away(&w, &t))
            continue;
        for (int i = 0; i < 3 && w.held && w.st == AP_OK; i++)
            w.held =
                ap_refine_middle(&w, t.corner[i], t.corner[(i + 1) % 3]) == AP_NOT_CUT && w.held;
    }
    free(w.stack);
    return w.st == AP_OK && w.held;
}

enum ap_status ap_refine_part(struct ap_error *err, struct ap_refiner *r,
                              const struct ap_refine_params *params, const struct ap_part *part,
                              struct ap_mesh_data *data, struct ap_mesh *mesh, bool *held,
                              uint32_t *unseen) {
    struct ap_refine_work w = {
        .err = err, .r = r, .params = params, .data = data, .held = true, .st = AP_OK};
    begin(&w, part);
    struct ap_mesh made = ap_mesh_data_begin(data);
    w.first_index = data->index_count;
    ap_refine_begin(&w, part);
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
