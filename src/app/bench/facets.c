#include "src/app/bench/facets.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "src/view/exact.h"

static const double PI = 3.14159265358979323846;
static const double LOOK_CLOSER = 0.4; // of the bound: what need not be known better
enum { PART_POINTS_MAX = 200 };

struct ap_facet_corner {
    struct ap_vec3 at; // in the eye's axes: native, metres; tourist, a direction
    double px[2];
};

struct look {
    struct ap_facets *facets;
    const struct ap_facets_params *params;
    const struct ap_viewer *viewer;
    struct ap_space space;
    bool tourist;
    struct ap_iso eye_from_nose[2]; // tourist
    uint64_t random;
    // Of the item at hand.
    const struct ap_draw_item *item;
    const struct ap_part *part;
    const struct ap_mesh_data *data;
    bool sheet;
    struct ap_iso part_from_nose, eye_from_part[2]; // the latter: tourist
    struct ap_vec4 eye[2];                          // tourist: in the part, over rho
    bool corners_known;
};

enum ap_status ap_facets_open(struct ap_error *err, const struct ap_scene *scene,
                              struct ap_facets *facets) {
    *facets = (struct ap_facets){.scene = scene};
    enum ap_status st = ap_meshes_make(err, scene, &facets->meshes, &facets->ahead);
    if (!st && scene->honeycomb)
        st = ap_cell_view_create(err, scene, &facets->meshes, &facets->cells);
    if (!st)
        st = ap_draw_list_create(err, scene->part_count, &facets->list);
    if (st)
        ap_facets_close(facets);
    return st;
}

void ap_facets_close(struct ap_facets *facets) {
    const struct ap_gpu none = {0};
    for (int e = 0; e < 2; e++)
        free(facets->corner[e]);
    ap_draw_list_destroy(&facets->list);
    ap_cell_view_destroy(&facets->cells);
    ap_meshes_destroy(&none, &facets->meshes);
    ap_mesh_data_finish(&facets->ahead);
    *facets = (struct ap_facets){0};
}

static double uniform(struct look *l) {
    l->random = l->random * 6364136223846793005u + 1442695040888963407u;
    return (double)(l->random >> 11) * 0x1p-53;
}

// --- points: of the part (over rho), of tangent space, of an eye

static struct ap_vec4 times(double s, struct ap_vec4 p) {
    return (struct ap_vec4){s * p.x, s * p.y, s * p.z, s * p.w};
}

// A corner of a mesh; balls share unit vectors.
static struct ap_vec4 corner_of(const struct look *l, uint32_t vertex) {
    const float *v = l->data->vertices[l->item->mesh.first_vertex + vertex].position;
    if (l->part->kind != AP_PART_BALL)
        return (struct ap_vec4){v[0], v[1], v[2], v[3]};
    double r = l->part->radius_m / l->space.rho_m, sine = ap_space_sin(l->space, r);
    return (struct ap_vec4){sine * v[0], sine * v[1], sine * v[2], ap_space_cos(l->space, r)};
}

static struct ap_vec3 tangent(const struct look *l, struct ap_vec4 p) {
    struct ap_vec4 x = ap_iso_apply(&l->item->nose_from_part, times(l->space.rho_m, p));
    return ap_log_unchecked(l->space, x, l->item->image);
}

static struct ap_vec3 seen_tangent(const struct look *l, int e, struct ap_vec3 t) {
    return ap_eye_from_tangent(&l->viewer->eye[e], (struct ap_tangent_point){t}).x;
}

static struct ap_vec3 seen(const struct look *l, int e, struct ap_vec4 p) {
    if (!l->tourist)
        return seen_tangent(l, e, tangent(l, p));
    double to = l->item->image ? -l->space.rho_m : l->space.rho_m;
    struct ap_vec4 x = ap_iso_apply(&l->eye_from_part[e], times(to, p));
    return (struct ap_vec3){x.x, x.y, x.z};
}

static bool pixel(const struct look *l, int e, struct ap_vec3 at, double px[2]) {
    return ap_exact_pixel_at(&l->viewer->eye[e], l->params->size_px, at, px);
}

// X moved along the line of sight.
static struct ap_vec4 along_sight(const struct look *l, int e, struct ap_vec4 x, double more_m) {
    struct ap_space space = l->space;
    double rho = space.rho_m;
    if (!l->tourist) {
        struct ap_vec3 t = tangent(l, x);
        struct ap_vec3 u = ap_vec3_normalize(ap_vec3_sub(t, l->viewer->eye[e].view_from_eye.p));
        x = ap_exp(space, ap_vec3_add(t, ap_vec3_scale(more_m, u)));
        return times(1 / rho, ap_iso_apply(&l->part_from_nose, x));
    }
    struct ap_vec4 o = l->eye[e];
    double with = space.kappa ? space.kappa * (o.x * x.x + o.y * x.y + o.z * x.z) + o.w * x.w : 1;
    struct ap_vec4 v = {with * x.x - o.x, with * x.y - o.y, with * x.z - o.z, with * x.w - o.w};
    double n = sqrt(v.x * v.x + v.y * v.y + v.z * v.z + space.kappa * v.w * v.w);
    double s = ap_space_sin(space, more_m / rho) / n, c = ap_space_cos(space, more_m / rho);
    return (struct ap_vec4){c * x.x + s * v.x, c * x.y + s * v.y, c * x.z + s * v.z,
                            c * x.w + s * v.w};
}

// --- round surfaces by coordinates of their own

// The place along the axis over rho, a ball's is 0, and the unit vector out of it, the axis being
// x.
struct spot {
    double along;
    struct ap_vec3 out;
};

static bool is_ball(const struct look *l) {
    return l->part->kind == AP_PART_BALL || l->part->form == AP_FORM_SPHERE;
}

static double radius_at(const struct look *l, double along) {
    const struct ap_part *p = l->part;
    double t = 0;
    if (p->kind == AP_PART_STICK)
        t = fmin(fmax(along * l->space.rho_m / p->length_m + 0.5, 0), 1);
    return (p->radius_m + t * (p->radius2_m - p->radius_m)) / l->space.rho_m;
}

// Of a point of the part, and how far it is from the surface, over rho. False: on the axis, or in a
// stick's cap.
static bool spot_of(const struct look *l, struct ap_vec4 p, struct spot *spot, double *gap) {
    struct ap_space space = l->space;
    bool stick = l->part->kind == AP_PART_STICK, ball = is_ball(l);
    double x = stick ? p.z : p.x;
    struct ap_vec3 out = stick  ? (struct ap_vec3){0, p.x, p.y}
                         : ball ? (struct ap_vec3){p.x, p.y, p.z}
                                : (struct ap_vec3){0, p.y, p.z};
    double s = ap_vec3_length(out), c = p.w;
    if (!(s > 0))
        return false;
    spot->along = ball              ? 0
                  : space.kappa > 0 ? atan2(x, p.w)
                  : space.kappa < 0 ? atanh(x / p.w)
                                    : x / p.w;
    if (!ball && space.kappa > 0)
        c = hypot(x, p.w);
    spot->out = ap_vec3_scale(1 / s, out);
    *gap = (space.kappa > 0   ? atan2(s, c)
            : space.kappa < 0 ? asinh(s)
                              : s) -
           radius_at(l, spot->along);
    return !stick || fabs(spot->along) <= l->part->length_m / 2 / space.rho_m + 1e-6;
}

static struct ap_vec4 on_surface(const struct look *l, const struct spot *spot) {
    struct ap_space space = l->space;
    double r = radius_at(l, spot->along);
    double sr = ap_space_sin(space, r), cr = ap_space_cos(space, r);
    double s = ap_space_sin(space, spot->along), c = ap_space_cos(space, spot->along);
    struct ap_vec3 u = ap_vec3_scale(sr, spot->out);
    if (is_ball(l))
        return (struct ap_vec4){u.x, u.y, u.z, cr};
    double x = s * cr;
    return l->part->kind == AP_PART_STICK ? (struct ap_vec4){u.y, u.z, x, c * cr}
                                          : (struct ap_vec4){x, u.y, u.z, c * cr};
}

// The surface's point at a share of a triangle's corners, by those coordinates.
static bool between(const struct look *l, const struct ap_vec4 p[3], const double share[3],
                    struct ap_vec4 *at) {
    struct spot sum = {.along = 0};
    for (int k = 0; k < 3; k++) {
        struct spot corner;
        double gap;
        if (!spot_of(l, p[k], &corner, &gap))
            return false;
        sum.along += share[k] * corner.along;
        sum.out = ap_vec3_add(sum.out, ap_vec3_scale(share[k], corner.out));
    }
    sum.out = ap_vec3_normalize(sum.out);
    *at = on_surface(l, &sum);
    return true;
}

// --- what is shown against what should be

static struct ap_facet_corner see(const struct look *l, int e, struct ap_vec4 p) {
    struct ap_facet_corner c = {.at = seen(l, e, p)};
    pixel(l, e, c.at, c.px);
    return c;
}

// All of the mesh's corners, when the first is asked for.
static bool know_corners(struct look *l) {
    struct ap_facets *f = l->facets;
    uint32_t count = l->item->mesh.vertex_count;
    if (l->corners_known)
        return true;
    for (int e = 0; e < 2 && count > f->corner_room; e++) {
        struct ap_facet_corner *more = realloc(f->corner[e], count * sizeof *more);
        if (!more)
            return false;
        f->corner[e] = more;
    }
    f->corner_room = count > f->corner_room ? count : f->corner_room;
    for (uint32_t i = 0; i < count; i++)
        for (int e = 0; e < 2; e++)
            f->corner[e][i] = see(l, e, corner_of(l, i));
    return l->corners_known = true;
}

// Whether a triangle is seen from its front and covers a direction, however far it reaches behind
// the eye.
static bool covers(const struct ap_facet_corner *const c[3], struct ap_vec3 toward) {
    for (int k = 0; k < 3; k++) {
        struct ap_vec3 side = ap_vec3_cross(c[k]->at, c[(k + 1) % 3]->at);
        if (!(ap_vec3_dot(side, toward) < 0) || !(ap_vec3_dot(side, c[(k + 2) % 3]->at) < 0))
            return false;
    }
    return true;
}

// How far a point, at q of the picture, lies outside what a triangle covers of it; INFINITY where
// that is not seen from its front or, reaching behind the eye, does not cover it.
static double outside(const struct ap_facet_corner *const c[3], struct ap_vec3 toward,
                      const double q[2]) {
    for (int k = 0; k < 3; k++)
        if (!(c[k]->at.z < 0))
            return covers(c, toward) ? 0 : INFINITY;
    return ap_exact_outside(q, c[0]->px, c[1]->px, c[2]->px);
}

// Whether a line of sight enters there: farther on it is below the surface.
static bool faces(const struct look *l, int e, struct ap_vec4 truth) {
    double step_m = 1e-6 * l->space.rho_m, gap;
    struct spot spot;
    if (l->tourist && l->item->image) // the long way round sight goes toward the eye
        step_m = -step_m;
    return spot_of(l, along_sight(l, e, truth, step_m), &spot, &gap) && gap < 0;
}

// A point of the surface; a neighbour of its own triangle may well show it.
static double uncovered(struct look *l, int e, const struct ap_facet_corner *const corner[3],
                        struct ap_vec4 at) {
    double q[2], bound = LOOK_CLOSER * l->params->max_error_px;
    struct ap_vec3 toward = seen(l, e, at);
    if (!pixel(l, e, toward, q) || !faces(l, e, at))
        return -1;
    double least = outside(corner, toward, q);
    if (least == INFINITY || least <= bound || !know_corners(l))
        return least == INFINITY ? -1 : least;
    const struct ap_mesh *mesh = &l->item->mesh;
    for (uint32_t i = 0; least > bound && i < mesh->index_count; i += 3) {
        const struct ap_facet_corner *c[3];
        for (int k = 0; k < 3; k++)
            c[k] = &l->facets->corner[e][l->data->indices[mesh->first_index + i + k]];
        least = fmin(least, outside(c, toward, q));
    }
    return least;
}

static double pixels_apart(const struct look *l, int e, struct ap_vec4 a, struct ap_vec4 b) {
    double p[2], q[2];
    pixel(l, e, seen(l, e, a), p);
    pixel(l, e, seen(l, e, b), q);
    return hypot(p[0] - q[0], p[1] - q[1]);
}

// Where a line of sight comes nearest to the surface, no farther than reach_m from x: 0 where it
// meets it there; negative: nowhere that is known.
static double passes_beside(const struct look *l, int e, struct ap_vec4 x, double reach_m) {
    double low = -reach_m, high = reach_m, gap = INFINITY;
    struct ap_vec4 nearest = x;
    struct spot spot = {.along = 0};
    for (int i = 0; i < 50; i++) {
        double at[2] = {low + (high - low) * 0.382, low + (high - low) * 0.618}, g[2];
        for (int k = 0; k < 2; k++) {
            nearest = along_sight(l, e, x, at[k]);
            if (!spot_of(l, nearest, &spot, &g[k]))
                return -1;
            if (g[k] <= 0)
                return 0;
        }
        *(g[0] < g[1] ? &high : &low) = g[0] < g[1] ? at[1] : at[0];
        gap = fmin(g[0], g[1]);
    }
    return gap < INFINITY ? pixels_apart(l, e, x, on_surface(l, &spot)) : -1;
}

// A drawn point of the front: where its line of sight comes nearest to the surface or meets it.
static double stands_out(const struct look *l, int e, struct ap_vec4 x) {
    struct spot spot;
    double gap, more, step_m = 1e-6 * l->space.rho_m, rho = l->space.rho_m;
    if (!spot_of(l, x, &spot, &gap))
        return -1;
    double off = pixels_apart(l, e, x, on_surface(l, &spot));
    if (off <= LOOK_CLOSER * l->params->max_error_px)
        return off;
    if (gap <= 0)
        return 0;
    double reach = 4 * rho * (sqrt(2 * radius_at(l, spot.along) * gap) + gap);
    double beside = passes_beside(l, e, x, reach);
    // A line at a slant, nearly along a tube, comes down to it farther off.
    if (!(beside > 0) || !spot_of(l, along_sight(l, e, x, step_m), &spot, &more))
        return beside;
    double slant = fmin(2 * step_m * gap / fabs(more - gap), rho / 2);
    double farther = slant > reach ? passes_beside(l, e, x, slant) : -1;
    return farther >= 0 ? fmin(farther, beside) : beside;
}

// What is drawn at a share of a triangle's corners, of the part: on the space, in tangent space,
// and (of a plane) the geodesic triangle's point that the nose sees in the same direction.
struct point {
    struct ap_vec4 shown;
    struct ap_vec3 flat, truth; // native
};

static double product(struct ap_space space, struct ap_vec4 p) {
    return space.kappa ? p.x * p.x + p.y * p.y + p.z * p.z + space.kappa * p.w * p.w : p.w * p.w;
}

static void add_share(struct ap_vec4 *sum, double share, struct ap_vec4 p) {
    struct ap_vec4 q = times(share, p);
    *sum = (struct ap_vec4){sum->x + q.x, sum->y + q.y, sum->z + q.z, sum->w + q.w};
}

// The log map is a factor for each corner, so that the same shares with those factors make the true
// point of them, in the same direction; its scale is best known in the part's coordinates.
static struct point point_at(const struct look *l, const struct ap_vec4 p[3],
                             const double share[3]) {
    struct ap_space space = l->space;
    struct point at = {.flat = {0, 0, 0}};
    struct ap_vec4 sum = {0, 0, 0, 0}, sum_nose = sum;
    for (int k = 0; k < 3; k++) {
        double factor = 1;
        struct ap_vec4 nose = ap_iso_apply(&l->item->nose_from_part, p[k]);
        if (!l->tourist) {
            struct ap_vec3 t = tangent(l, p[k]), x = {nose.x, nose.y, nose.z};
            at.flat = ap_vec3_add(at.flat, ap_vec3_scale(share[k], t));
            factor = ap_vec3_length(t) / ap_vec3_length(x);
        }
        add_share(&sum, share[k] * factor, p[k]);
        add_share(&sum_nose, share[k] * factor, nose);
    }
    double to = 1 / sqrt(fabs(product(space, sum))), rho = space.rho_m;
    at.shown = times(to, sum); // tourist: a geodesic triangle
    at.truth = ap_log_unchecked(space, times(to * rho, sum_nose), l->item->image);
    if (!l->tourist)
        at.shown = times(1 / rho, ap_iso_apply(&l->part_from_nose, ap_exp(space, at.flat)));
    return at;
}

// A plane's point is seen in its facet's direction by the nose, and beside it by the eyes.
static double beside(const struct look *l, int e, const struct point *at) {
    double shown[2], exact[2];
    if (!pixel(l, e, seen_tangent(l, e, at->flat), shown) ||
        !pixel(l, e, seen_tangent(l, e, at->truth), exact))
        return -1;
    return hypot(shown[0] - exact[0], shown[1] - exact[1]);
}

// Facing the eye.
static bool is_front(const struct ap_facet_corner c[3]) {
    struct ap_vec3 n = ap_vec3_cross(ap_vec3_sub(c[1].at, c[0].at), ap_vec3_sub(c[2].at, c[0].at));
    return ap_vec3_dot(n, c[0].at) < 0;
}

static double round_error(struct look *l, int e, const struct ap_vec4 p[3], struct ap_vec4 truth,
                          struct ap_vec4 shown) {
    struct ap_facet_corner c[3];
    double q[2], most = -1;
    for (int k = 0; k < 3; k++)
        c[k] = see(l, e, p[k]);
    if (!is_front(c))
        return -1;
    const struct ap_facet_corner *const corner[3] = {&c[0], &c[1], &c[2]};
    most = uncovered(l, e, corner, truth);
    if (pixel(l, e, seen(l, e, shown), q))
        most = fmax(most, stands_out(l, e, shown));
    return most;
}

// Next to the antipode a direction means nothing, and what is within the forbidden millimetre of it
// by its coordinates is not drawn (shaders/part_guard.glsl), wherever its facet is.
static bool is_antipode(const struct look *l, const struct point *at) {
    double half = PI * l->space.rho_m;
    return l->space.kappa > 0 && !l->tourist &&
           (fabs(ap_vec3_length(at->flat) - half) < 2e-3 * l->space.rho_m ||
            fabs(ap_vec3_length(at->truth) - half) < AP_NEAR_M);
}

// Errors are largest in the middle of a triangle or of an edge; or anywhere.
static void choose_share(struct look *l, double share[3]) {
    static const double MIDDLE[4][3] = {
        {1. / 3, 1. / 3, 1. / 3}, {0.5, 0.5, 0}, {0, 0.5, 0.5}, {0.5, 0, 0.5}};
    int which = (int)(8 * uniform(l));
    if (which < 4) {
        memcpy(share, MIDDLE[which], sizeof MIDDLE[which]);
        return;
    }
    share[0] = uniform(l);
    share[1] = uniform(l);
    if (share[0] + share[1] > 1)
        share[0] = 1 - share[0], share[1] = 1 - share[1];
    share[2] = 1 - share[0] - share[1];
}

static void look_at_point(struct look *l, uint32_t t, struct ap_facet_errors *errors) {
    const uint32_t *index = &l->data->indices[l->item->mesh.first_index + 3 * t];
    double share[3];
    choose_share(l, share);
    struct ap_vec4 p[3], truth;
    for (int k = 0; k < 3; k++)
        p[k] = corner_of(l, index[k]);
    struct point at = point_at(l, p, share);
    if (is_antipode(l, &at) || (!l->sheet && !between(l, p, share, &truth)))
        return;
    for (int e = 0; e < 2; e++) {
        if (!(l->item->eyes >> e & 1))
            continue;
        double px = l->sheet ? beside(l, e, &at) : round_error(l, e, p, truth, at.shown);
        errors->points += px >= 0;
        if (!(px > errors->worst_px))
            continue;
        errors->worst_px = px;
        errors->at_m = ap_vec3_length(tangent(l, at.shown));
        errors->part = l->item->part;
        errors->refined = l->item->refined;
    }
}

static void look_at_item(struct look *l, uint32_t points, struct ap_facet_errors *errors) {
    const struct ap_draw_item *item = l->item;
    uint32_t count = item->mesh.index_count / 3;
    l->part = &l->facets->scene->parts[item->part];
    l->sheet = ap_part_form(l->part) == AP_FORM_PLANE;
    if (item->pipeline == AP_PIPELINE_DISC || (l->sheet && l->tourist) || // geodesic: exact
        (l->part->kind == AP_PART_SOLID && l->part->form == AP_FORM_FACETS))
        return;
    l->data = item->refined ? &l->facets->list.refined : &l->facets->ahead;
    l->part_from_nose = ap_iso_inverse(l->space, item->nose_from_part);
    for (int e = 0; e < 2 && l->tourist; e++) {
        const struct ap_vec4 base = {0, 0, 0, 1};
        l->eye_from_part[e] = ap_iso_mul(l->eye_from_nose[e], item->nose_from_part);
        struct ap_iso back = ap_iso_inverse(l->space, l->eye_from_part[e]);
        l->eye[e] = ap_iso_apply(&back, base);
    }
    l->corners_known = false;
    for (uint32_t i = 0; i < points && count > 0; i++)
        look_at_point(l, count <= points ? i % count : (uint32_t)(uniform(l) * count), errors);
}

static double all_triangles(const struct ap_draw_list *list) {
    double all = 1;
    for (size_t i = 0; i < list->count; i++)
        all += list->items[i].mesh.index_count / 3;
    return all;
}

static void take_stats(const struct ap_frame_stats *stats, struct ap_facet_errors *errors) {
    errors->beyond_bound += stats->beyond_bound;
    errors->refined_parts += stats->refined;
    for (int e = 0; e < 2; e++)
        errors->triangles += (double)stats->eye[e].triangles;
}

enum ap_status ap_facets_look(struct ap_error *err, struct ap_facets *facets,
                              const struct ap_facets_params *params,
                              struct ap_facet_errors *errors) {
    const struct ap_viewer *viewer = &params->input->viewer;
    struct ap_eyes eyes = ap_eyes_of(viewer, params->size_px[0], params->size_px[1]);
    const struct ap_list_params what = {.scene = facets->scene,
                                        .meshes = &facets->meshes,
                                        .input = params->input,
                                        .eyes = &eyes,
                                        .width_px = params->size_px[0],
                                        .height_px = params->size_px[1],
                                        .max_error_px = params->max_error_px};
    struct look l = {.facets = facets,
                     .params = params,
                     .viewer = viewer,
                     .space = viewer->space,
                     .tourist = viewer->mode == AP_VIEW_TOURIST,
                     .random = params->seed};
    for (int e = 0; e < 2; e++)
        l.eye_from_nose[e] = ap_eye_from_nose(viewer, e);
    enum ap_status st = ap_draw_list_fill(err, &what, &facets->list);
    if (!st && facets->scene->honeycomb)
        st = ap_cell_view_fill(err, &facets->cells, &what, &facets->list);
    if (st)
        return st;
    const struct ap_draw_list *list = &facets->list;
    double all = all_triangles(list);
    for (size_t i = 0; i < list->count; i++) {
        // A half to all parts alike, a half to where the triangles are.
        double share = 0.5 / (double)list->count + 0.5 * list->items[i].mesh.index_count / 3 / all;
        double points = fmin(params->points * share, PART_POINTS_MAX);
        l.item = &list->items[i];
        look_at_item(&l, (uint32_t)(points + uniform(&l)), errors);
    }
    take_stats(&list->stats, errors);
    return AP_OK;
}
