#include "src/app/bench/facets.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "src/render/refine_surface.h"
#include "src/view/exact.h"

static const double PI = 3.14159265358979323846;
// Points of a frame, about, and of a part of it.
enum { POINTS = 12000, PART_POINTS_MIN = 2, PART_POINTS_MAX = 200 };

struct ap_facet_corner {
    double px[2];
    bool before; // the eye
};

struct look {
    struct ap_facets *facets;
    const struct ap_frame_input *input;
    const uint32_t *size_px;
    const struct ap_draw_item *item;
    const struct ap_mesh_data *data;
    struct ap_surface surface;
    struct ap_iso part_from_nose;
    bool corners_known;
    double bound_px;
    uint64_t random;
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

// A corner of a mesh, in the part's coordinates over rho; balls share unit vectors.
static struct ap_vec4 corner_of(const struct look *l, uint32_t vertex) {
    const float *v = l->data->vertices[l->item->mesh.first_vertex + vertex].position;
    const struct ap_surface *s = &l->surface;
    if (s->part->kind != AP_PART_BALL)
        return (struct ap_vec4){v[0], v[1], v[2], v[3]};
    double r = s->part->radius_m / s->space.rho_m, sine = ap_space_sin(s->space, r);
    return (struct ap_vec4){sine * v[0], sine * v[1], sine * v[2], ap_space_cos(s->space, r)};
}

static struct ap_vec3 tangent(const struct look *l, struct ap_vec4 p) {
    double rho = l->surface.space.rho_m;
    struct ap_vec4 x = {rho * p.x, rho * p.y, rho * p.z, rho * p.w};
    return ap_log_unchecked(l->surface.space, ap_iso_apply(&l->item->nose_from_part, x),
                            l->item->image);
}

static struct ap_facet_corner see(const struct look *l, int e, struct ap_vec3 tangent_m) {
    const struct ap_viewer *viewer = &l->input->viewer;
    struct ap_facet_corner c;
    ap_exact_pixel(viewer, l->size_px, e, tangent_m, c.px);
    c.before = ap_eye_from_tangent(&viewer->eye[e], (struct ap_tangent_point){tangent_m}).x.z < 0;
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
    for (uint32_t i = 0; i < count; i++) {
        struct ap_vec3 t = tangent(l, corner_of(l, i));
        for (int e = 0; e < 2; e++)
            f->corner[e][i] = see(l, e, t);
    }
    return l->corners_known = true;
}

// How far q lies outside what triangle t covers of the picture; INFINITY where it is not seen from
// its front or not wholly before the eye.
static double to_triangle(const struct look *l, int e, uint32_t t, const double q[2]) {
    const uint32_t *index = &l->data->indices[l->item->mesh.first_index + 3 * t];
    const double *c[3];
    for (int k = 0; k < 3; k++) {
        const struct ap_facet_corner *corner = &l->facets->corner[e][index[k]];
        if (!corner->before)
            return INFINITY;
        c[k] = corner->px;
    }
    return ap_exact_outside(q, c[0], c[1], c[2]);
}

// A plane's point is seen in its facet's direction by the nose, and beside it by the eyes.
static double sheet_error(const struct look *l, int e, struct ap_vec3 flat) {
    double d = ap_vec3_length(flat), shown[2], exact[2];
    struct ap_vec3 truth;
    if (!ap_exact_on_plane(l->surface.space, &l->part_from_nose, ap_vec3_scale(1 / d, flat), d,
                           &truth) ||
        !ap_exact_pixel(&l->input->viewer, l->size_px, e, flat, shown) ||
        !ap_exact_pixel(&l->input->viewer, l->size_px, e, truth, exact))
        return -1;
    return hypot(shown[0] - exact[0], shown[1] - exact[1]);
}

// A point of a ball or a tube, from how far it lies beside what is drawn of it; a neighbour of its
// own triangle may well show it.
static double round_error(struct look *l, int e, uint32_t t, const struct ap_surface_point *at) {
    double q[2];
    if (!ap_exact_pixel(&l->input->viewer, l->size_px, e, at->tangent_m, q) || !know_corners(l))
        return -1;
    double least = to_triangle(l, e, t, q);
    if (least == INFINITY)
        return -1;
    for (uint32_t i = 0; least > 0.4 * l->bound_px && i < l->item->mesh.index_count / 3; i++)
        least = fmin(least, to_triangle(l, e, i, q));
    return least;
}

// The point of the round surface at a share of three points on it, by its own coordinates. False:
// in a stick's cap.
static bool between(const struct look *l, const struct ap_vec4 p[3], const double share[3],
                    struct ap_surface_point *at) {
    const struct ap_surface *s = &l->surface;
    *at = (struct ap_surface_point){.along = 0};
    for (int k = 0; k < 3; k++) {
        struct ap_surface_point c = ap_surface_point_of(s, p[k]);
        if (s->part->kind == AP_PART_STICK) { // its axis is z
            double x = p[k].z / p[k].w;
            c.along = s->space.kappa > 0   ? atan2(p[k].z, p[k].w)
                      : s->space.kappa < 0 ? atanh(x)
                                           : x;
            double across = hypot(p[k].x, p[k].y);
            c.from = (struct ap_vec3){p[k].x / across, p[k].y / across, 0};
            if (fabs(c.along) > s->part->length_m / 2 / s->space.rho_m + 1e-6 || !(across > 0))
                return false;
        }
        at->along += share[k] * c.along;
        at->from = ap_vec3_add(at->from, ap_vec3_scale(share[k], c.from));
    }
    at->from = ap_vec3_normalize(at->from);
    ap_surface_place(s, at->along, at);
    ap_surface_see(s, at);
    return true;
}

static void look_at_point(struct look *l, uint32_t t, struct ap_facet_errors *errors) {
    const uint32_t *index = &l->data->indices[l->item->mesh.first_index + 3 * t];
    double share[3] = {uniform(l), uniform(l), 0};
    if (share[0] + share[1] > 1)
        share[0] = 1 - share[0], share[1] = 1 - share[1];
    share[2] = 1 - share[0] - share[1];
    struct ap_vec4 p[3];
    struct ap_vec3 flat = {0, 0, 0};
    for (int k = 0; k < 3; k++) {
        p[k] = corner_of(l, index[k]);
        flat = ap_vec3_add(flat, ap_vec3_scale(share[k], tangent(l, p[k])));
    }
    const struct ap_space space = l->surface.space;
    bool sheet = l->surface.shape == AP_SURFACE_SHEET;
    // Next to the antipode a direction means nothing.
    if (space.kappa > 0 && fabs(ap_vec3_length(flat) / space.rho_m - PI) < 2e-3)
        return;
    struct ap_surface_point at;
    if (!sheet && !between(l, p, share, &at))
        return;
    for (int e = 0; e < 2; e++) {
        if (!(l->item->eyes >> e & 1))
            continue;
        double px = sheet ? sheet_error(l, e, flat) : round_error(l, e, t, &at);
        errors->points += px >= 0;
        errors->worst_px = fmax(errors->worst_px, px);
    }
}

static void look_at_item(struct look *l, const struct ap_eyes *eyes, uint32_t points,
                         struct ap_facet_errors *errors) {
    const struct ap_draw_item *item = l->item;
    const struct ap_part *part = &l->facets->scene->parts[item->part];
    uint32_t count = item->mesh.index_count / 3;
    if (item->pipeline == AP_PIPELINE_DISC ||
        (part->kind == AP_PART_SOLID && part->form == AP_FORM_FACETS))
        return;
    l->data = item->refined ? &l->facets->list.refined : &l->facets->ahead;
    l->surface = ap_surface_of(&l->input->viewer, eyes, part, item->nose_from_part, item->image);
    l->part_from_nose = ap_iso_inverse(l->surface.space, item->nose_from_part);
    l->corners_known = false;
    for (uint32_t i = 0; i < points && count > 0; i++)
        look_at_point(l, count <= points ? i % count : (uint32_t)(uniform(l) * count), errors);
}

enum ap_status ap_facets_look(struct ap_error *err, struct ap_facets *facets,
                              const struct ap_frame_input *input, const uint32_t size_px[2],
                              double max_error_px, struct ap_facet_errors *errors) {
    struct ap_eyes eyes = ap_eyes_of(&input->viewer, size_px[0], size_px[1]);
    const struct ap_list_params what = {.scene = facets->scene,
                                        .meshes = &facets->meshes,
                                        .input = input,
                                        .eyes = &eyes,
                                        .width_px = size_px[0],
                                        .height_px = size_px[1],
                                        .max_error_px = max_error_px};
    struct look l = {.facets = facets,
                     .input = input,
                     .size_px = size_px,
                     .bound_px = max_error_px,
                     .random = 11};
    enum ap_status st = ap_draw_list_fill(err, &what, &facets->list);
    if (!st && facets->scene->honeycomb)
        st = ap_cell_view_fill(err, &facets->cells, &what, &facets->list);
    if (st)
        return st;
    size_t points = POINTS / (facets->list.count + 1);
    points = points < PART_POINTS_MIN ? PART_POINTS_MIN : points;
    points = points > PART_POINTS_MAX ? PART_POINTS_MAX : points;
    for (size_t i = 0; i < facets->list.count; i++) {
        l.item = &facets->list.items[i];
        look_at_item(&l, &eyes, (uint32_t)points, errors);
    }
    errors->beyond_bound += facets->list.stats.beyond_bound;
    return AP_OK;
}
