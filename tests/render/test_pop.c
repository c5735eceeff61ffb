// Crossing levels of detail must not pop: along walks (coming near and going away again, the head
// turning) each part's triangles of one frame are held against those of the frame before. Points of
// its surface are looked for in both meshes, where the GPU would draw them (straight in tangent
// space; by interpolated coordinates), and where they truly are: what is drawn may move against the
// truth by no more than the bound, from frame to frame, whichever meshes were chosen.
// `test_pop WALKS [SEED [SCENE]]` takes whole walks at all bounds.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "src/render/cells.h"
#include "src/render/refine/refine_surface.h"
#include "tests/render/exact.h"
#include "tests/render/stage.h"

static const double PI = 3.14159265358979323846;
enum { WIDTH = 1440, HEIGHT = 1600, FRAMES = 24, SHORT = 6, PER_FRAME = 24, POINTS = 3 };
// What the doubles of the test and the floats of meshes made ahead may add.
static const double ROUNDING_PX = 0.02;

static struct exact_random random_of;

static double uniform(double low, double high) {
    return exact_uniform(&random_of, low, high);
}

// A scene as the renderer holds it but for the GPU, and two frames of a walk.
struct world {
    struct ap_scene *scene;
    struct ap_meshes meshes;
    struct ap_mesh_data ahead;
    struct ap_cell_view cells;
    struct ap_draw_list list[2];
    struct ap_frame_input input[2];
};

static void open_world(struct world *w, const char *name) {
    struct ap_scene_params params = {0};
    memset(w, 0, sizeof *w);
    if (ap_scene_is_named(name)) {
        STAGE_CHECK(ap_scene_named(&stage_error, name, &params, &w->scene));
    } else {
        params.space_name = name;
        STAGE_CHECK(ap_scene_billiards(&stage_error, &params, &w->scene));
    }
    for (size_t i = 0; i < w->scene->part_count; i++)
        w->scene->parts[i].lit = true; // no discs
    STAGE_CHECK(ap_meshes_make(&stage_error, w->scene, &w->meshes, &w->ahead));
    if (w->scene->honeycomb)
        STAGE_CHECK(ap_cell_view_create(&stage_error, w->scene, &w->meshes, &w->cells));
    for (int i = 0; i < 2; i++)
        STAGE_CHECK(ap_draw_list_create(&stage_error, w->scene->part_count, &w->list[i]));
}

static void close_world(struct world *w) {
    for (int i = 0; i < 2; i++)
        ap_draw_list_destroy(&w->list[i]);
    if (w->scene->honeycomb)
        ap_cell_view_destroy(&w->cells);
    free(w->meshes.shapes);
    free(w->meshes.shape_of_part);
    free(w->meshes.reach_m);
    ap_mesh_data_finish(&w->meshes.kept);
    ap_mesh_data_finish(&w->ahead);
    ap_scene_destroy(w->scene);
}

static void fill(struct world *w, int k, double bound_px) {
    struct ap_eyes eyes = ap_eyes_of(&w->input[k].viewer, WIDTH, HEIGHT);
    const struct ap_list_params what = {.scene = w->scene,
                                        .meshes = &w->meshes,
                                        .input = &w->input[k],
                                        .eyes = &eyes,
                                        .width_px = WIDTH,
                                        .height_px = HEIGHT,
                                        .max_error_px = bound_px};
    STAGE_CHECK(ap_draw_list_fill(&stage_error, &what, &w->list[k]));
    if (w->scene->honeycomb)
        STAGE_CHECK(ap_cell_view_fill(&stage_error, &w->cells, &what, &w->list[k]));
    ap_draw_list_sort(&w->list[k]);
}

// --- where a part's points are seen

struct shown { // up to a factor that an eye does not see
    struct ap_vec3 e;
    double weight; // the nose-space point's multiple that it is
};

static struct ap_vec4 metres(struct ap_space space, const double p[4]) {
    double rho = space.rho_m;
    return (struct ap_vec4){rho * p[0], rho * p[1], rho * p[2], rho * p[3]};
}

// p over rho, in the part's coordinates.
static struct shown show(const struct ap_viewer *v, const struct ap_draw_item *item, int eye,
                         const double p[4]) {
    struct ap_vec4 q = ap_iso_apply(&item->nose_from_part, metres(v->space, p));
    struct ap_iso eye_from_nose = ap_eye_from_nose(v, eye);
    double across = sqrt(q.x * q.x + q.y * q.y + q.z * q.z);
    if (v->mode == AP_VIEW_TOURIST) {
        struct ap_vec4 s = ap_iso_apply(&eye_from_nose, q);
        return (struct shown){ap_vec3_scale(item->image ? -1 : 1, (struct ap_vec3){s.x, s.y, s.z}),
                              1};
    }
    struct ap_vec3 t = ap_log_unchecked(v->space, q, item->image);
    double length = ap_vec3_length(t);
    if (v->mode == AP_VIEW_NATIVE)
        return (struct shown){ap_eye_from_tangent(&v->eye[eye], (struct ap_tangent_point){t}).x,
                              across > 0 ? length / across : 1};
    struct ap_space born = v->born;
    double a = length / born.rho_m, s = born.kappa < 0 ? tanh(a) : sin(a);
    double k = a > 0 ? s / a : 1, c = born.kappa < 0 ? 1 : cos(a);
    struct ap_vec4 b = {k * t.x, k * t.y, k * t.z, c * born.rho_m};
    b = ap_iso_apply(&eye_from_nose, b);
    return (struct shown){ap_vec3_scale(item->way ? -1 : 1, (struct ap_vec3){b.x, b.y, b.z}),
                          across > 0 ? fabs(k) * length / across : 1};
}

static bool pixel_of(const struct ap_viewer *v, int eye, struct ap_vec3 e, double px[2]) {
    const struct ap_frustum *f = &v->eye[eye].frustum;
    double a = e.x / -e.z, b = e.y / -e.z;
    px[0] = WIDTH * (a - f->left) / (f->right - f->left);
    px[1] = HEIGHT * (f->up - b) / (f->up - f->down);
    return e.z < 0 && a > f->left && a < f->right && b > f->down && b < f->up;
}

// --- what the triangles stand for

static double arc_of(int kappa, double s, double c) {
    return kappa > 0 ? atan2(s, c) : kappa < 0 ? atanh(s / c) : s / c;
}

// The surface's point next to one between a facet's corners, the unit normal 4-vector there, and
// outward without its last component.
struct foot {
    double p[4], n[4], out[3];
};

static void around(struct ap_space space, double along, double r, const double d[3], int axis,
                   struct foot *f) {
    int k = space.kappa;
    double ss = ap_space_sin(space, along), cs = ap_space_cos(space, along);
    double sr = ap_space_sin(space, r), cr = ap_space_cos(space, r);
    for (int i = 0; i < 3; i++) {
        f->p[i] = sr * d[i];
        f->n[i] = cr * d[i];
        f->out[i] = d[i];
    }
    double z = d[axis];
    f->p[axis] = cs * sr * z + ss * cr;
    f->p[3] = cs * cr - k * ss * sr * z;
    f->n[axis] = cs * cr * z - k * ss * sr;
    f->n[3] = -k * (cs * sr + ss * cr * z);
}

static struct foot foot_of(struct ap_space space, const struct ap_part *part, const double a[4]) {
    struct foot f = {.n = {0, 1, 0, 0}, .out = {0, 1, 0}};
    int k = space.kappa;
    bool stick = part->kind == AP_PART_STICK, tube = stick || part->form == AP_FORM_TUBE;
    double rho = space.rho_m;
    if (part->kind == AP_PART_BALL || part->form == AP_FORM_SPHERE) {
        double n = sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]);
        around(space, 0, part->radius_m / rho, (double[3]){a[0] / n, a[1] / n, a[2] / n}, 2, &f);
    } else if (tube) {
        int axis = stick ? 2 : 0;
        double half = stick ? part->length_m / rho / 2 : INFINITY, r = part->radius_m / rho;
        double along = arc_of(k, a[axis], a[3]), d[3] = {a[0], a[1], a[2]};
        d[axis] = 0;
        if (fabs(along) > half) {
            along = along < 0 ? -half : half;
            double c = ap_space_cos(space, along), s = ap_space_sin(space, along);
            d[axis] = c * a[axis] - s * a[3];
        }
        double n = sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
        if (stick)
            r += (along / half + 1) / 2 * (part->radius2_m - part->radius_m) / rho;
        around(space, along, r, (double[3]){d[0] / n, d[1] / n, d[2] / n}, axis, &f);
    } else {
        double n = sqrt(fabs(a[0] * a[0] + a[2] * a[2] + k * a[3] * a[3]));
        n = k == 0 ? a[3] : n;
        for (int i = 0; i < 4; i++)
            f.p[i] = i == 1 ? 0 : a[i] / n;
    }
    return f;
}

static double dot4(const double a[4], const double b[4]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
}

// Two linear forms that vanish on the normal's geodesic.
static void forms_of(const struct foot *f, double form[2][4]) {
    double base[4][4];
    int have = 0;
    for (int i = 0; i < 6 && have < 4; i++) {
        double v[4] = {i == 2, i == 3, i == 4, i == 5};
        for (int j = 0; i < 2 && j < 4; j++)
            v[j] = i == 0 ? f->p[j] : f->n[j];
        for (int pass = 0; pass < 2; pass++)
            for (int k = 0; k < have; k++) {
                double d = dot4(v, base[k]);
                for (int j = 0; j < 4; j++)
                    v[j] -= d * base[k][j];
            }
        double n = sqrt(dot4(v, v));
        if (n < 0.3 && i >= 2)
            continue;
        for (int j = 0; j < 4; j++)
            base[have][j] = v[j] / n;
        have++;
    }
    memcpy(form, base[2], 2 * sizeof base[2]);
}

// An item's mesh, with the vertices' points of the space.
struct mesh_of {
    const struct ap_viewer *viewer;
    const struct ap_draw_item *item;
    const struct ap_part *part;
    const struct ap_vertex *vertices;
    const uint32_t *indices;
    double sine, cosine; // of a ball's radius
};

static void vertex_at(const struct mesh_of *m, uint32_t i, double p[4]) {
    for (int j = 0; j < 4; j++)
        p[j] = (double)m->vertices[i].position[j];
    if (m->part->kind != AP_PART_BALL)
        return;
    for (int j = 0; j < 3; j++)
        p[j] *= m->sine;
    p[3] = m->cosine;
}

static double cross2(const double a[2], const double b[2]) {
    return a[0] * b[1] - a[1] * b[0];
}

// Whether a point of the normal's geodesic lies on this side of the axis or the middle.
static bool is_on_this_side(const struct mesh_of *m, const struct foot *f, const double a[4]) {
    int k = m->viewer->space.kappa;
    double home =
        k ? k * (a[0] * f->p[0] + a[1] * f->p[1] + a[2] * f->p[2]) + a[3] * f->p[3] : a[3];
    double up = a[0] * f->n[0] + a[1] * f->n[1] + a[2] * f->n[2] + k * a[3] * f->n[3];
    if (k == 0)
        up -= home * (f->p[0] * f->n[0] + f->p[1] * f->n[1] + f->p[2] * f->n[2]);
    bool sheet = m->part->kind == AP_PART_POLYGON || m->part->form == AP_FORM_PLANE;
    return home > 0 && (sheet || up / home > -m->sine / m->cosine);
}

// Where a mesh shows a point of its surface: in the triangle whose interpolated coordinates are
// next to it. False: in none (a hair outside of all).
static bool drawn_at(const struct mesh_of *m, const struct foot *f, int eye, double px[2]) {
    double form[2][4], best = -1e-6, share[3] = {0}, p[4];
    uint32_t corner[3] = {0};
    forms_of(f, form);
    uint32_t n = m->item->mesh.vertex_count;
    double(*g)[2] = malloc(n * sizeof *g);
    for (uint32_t i = 0; i < n; i++) {
        vertex_at(m, i, p);
        g[i][0] = dot4(form[0], p);
        g[i][1] = dot4(form[1], p);
    }
    for (uint32_t t = 0; t + 2 < m->item->mesh.index_count; t += 3) {
        const uint32_t *c = m->indices + t;
        double s[3] = {cross2(g[c[1]], g[c[2]]), cross2(g[c[2]], g[c[0]]),
                       cross2(g[c[0]], g[c[1]])};
        double sum = s[0] + s[1] + s[2], at[4] = {0};
        double span = 0; // rows of a cap meet in a point: no triangle
        for (int k = 0; k < 3; k++)
            for (int j = 0; j < 2; j++)
                span = fmax(span, fabs(g[c[k]][j] - g[c[(k + 1) % 3]][j]));
        if (!(fabs(sum) > 1e-6 * span * span) ||
            fmin(fmin(s[0] / sum, s[1] / sum), s[2] / sum) <= best)
            continue;
        for (int k = 0; k < 3; k++) {
            vertex_at(m, c[k], p);
            for (int j = 0; j < 4; j++)
                at[j] += s[k] / sum * p[j];
        }
        if (!is_on_this_side(m, f, at))
            continue;
        best = fmin(fmin(s[0] / sum, s[1] / sum), s[2] / sum);
        for (int k = 0; k < 3; k++) {
            share[k] = s[k] / sum;
            corner[k] = c[k];
        }
    }
    free(g);
    if (best <= -1e-6)
        return false;
    // What is interpolated is the point times its weight.
    struct ap_vec3 at = {0, 0, 0};
    for (int k = 0; k < 3; k++) {
        vertex_at(m, corner[k], p);
        struct shown s = show(m->viewer, m->item, eye, p);
        at = ap_vec3_add(at, ap_vec3_scale(share[k] / s.weight, s.e));
    }
    pixel_of(m->viewer, eye, at, px);
    return at.z < 0;
}

// --- a walk

struct worst {
    double off_px, pop_px;
    char off[160], pop[160];
};
struct tally {
    long points, pairs, changed, beyond, lost;
    struct worst far, near; // near: within 5 cm of an eye
    struct worst bare;      // what is round and bears no pattern
};

static struct mesh_of mesh_in(const struct world *w, int k, const struct ap_draw_item *item) {
    const struct ap_mesh_data *data = item->refined ? &w->list[k].refined : &w->ahead;
    const struct ap_part *part = &w->scene->parts[item->part];
    double r = fmin(part->radius_m, part->kind == AP_PART_STICK ? part->radius2_m : INFINITY) /
               w->scene->space.rho_m;
    return (struct mesh_of){.viewer = &w->input[k].viewer,
                            .item = item,
                            .part = part,
                            .sine = ap_space_sin(w->scene->space, r),
                            .cosine = ap_space_cos(w->scene->space, r),
                            .vertices = data->vertices + item->mesh.first_vertex,
                            .indices = data->indices + item->mesh.first_index};
}

// Whether an eye truly sees this side of it, where, and how far from it.
static bool truly_seen(const struct mesh_of *m, const struct foot *f, int eye, double px[2],
                       double *distance_m) {
    struct ap_space space = m->viewer->space;
    double p[3][2], x[4];
    struct ap_vec3 o = {f->out[0], f->out[1], f->out[2]};
    struct ap_vec3 any = fabs(o.x) < 0.6 ? (struct ap_vec3){1, 0, 0} : (struct ap_vec3){0, 0, 1};
    struct ap_vec3 u = ap_vec3_normalize(ap_vec3_cross(o, any)), v = ap_vec3_cross(o, u);
    struct shown s = show(m->viewer, m->item, eye, f->p);
    bool seen = pixel_of(m->viewer, eye, s.e, p[0]);
    for (int k = 0; k < 2; k++) {
        struct ap_vec3 d = ap_vec3_scale(1e-6, k ? v : u);
        x[0] = f->p[0] + d.x, x[1] = f->p[1] + d.y, x[2] = f->p[2] + d.z, x[3] = f->p[3];
        struct foot beside = foot_of(space, m->part, x);
        pixel_of(m->viewer, eye, show(m->viewer, m->item, eye, beside.p).e, p[1 + k]);
    }
    double a[2] = {p[1][0] - p[0][0], p[1][1] - p[0][1]},
           b[2] = {p[2][0] - p[0][0], p[2][1] - p[0][1]};
    memcpy(px, p[0], sizeof p[0]);
    *distance_m = ap_vec3_length(s.e);
    struct ap_vec4 q = ap_iso_apply(&m->item->nose_from_part, metres(space, f->p));
    double far = ap_vec3_length(ap_log_unchecked(space, q, m->item->image));
    if (m->viewer->mode == AP_VIEW_TOURIST)
        *distance_m = m->item->image ? INFINITY : far;
    if (space.kappa > 0 && fabs(far - PI * space.rho_m) < 0.1 * space.rho_m)
        return false;
    if (m->viewer->mode == AP_VIEW_BORN && m->viewer->born.kappa > 0)
        *distance_m = far,
        seen = seen && (m->item->way == 0) == (far < PI * m->viewer->born.rho_m) &&
               fabs(far - PI * m->viewer->born.rho_m) > 0.1 * m->viewer->born.rho_m &&
               far < 1.9 * PI * m->viewer->born.rho_m;
    bool both = m->part->kind == AP_PART_POLYGON;
    return seen && (cross2(a, b) < 0 || both) && *distance_m > 2 * AP_NEAR_M;
}

static const char *name_of(const struct ap_part *part) {
    static const char *const KIND[] = {"ball", "stick", "polygon", "solid"}, *const FORM[] = {
                                                                                 "facets", "wall",
                                                                                 "strut", "joint"};
    return part->kind == AP_PART_SOLID ? FORM[part->form] : part->apart ? "tile" : KIND[part->kind];
}

static void note(double px, const struct mesh_of *a, const struct mesh_of *b, double distance_m,
                 double *most, char text[160]) {
    if (!(px > *most))
        return;
    *most = px;
    snprintf(text, 160, "%s %u%s at %.3f m, %s%u triangles, then %s%u", name_of(b->part),
             b->item->part, b->item->image ? "'" : "", distance_m, a->item->refined ? "own " : "",
             a->item->mesh.index_count / 3, b->item->refined ? "own " : "",
             b->item->mesh.index_count / 3);
}

static void compare(const struct mesh_of *a, const struct mesh_of *b, struct tally *tally) {
    for (int tries = 0, found = 0; tries < 12 * POINTS && found < POINTS; tries++) {
        uint32_t t = 3 * (uint32_t)uniform(0, b->item->mesh.index_count / 3);
        double s = uniform(0, 1), u = uniform(0, 1), x[4] = {0}, p[4];
        if (s + u > 1)
            s = 1 - s, u = 1 - u;
        const double share[3] = {1 - s - u, s, u};
        for (int k = 0; k < 3; k++) {
            vertex_at(b, b->indices[t + (uint32_t)k], p);
            for (int j = 0; j < 4; j++)
                x[j] += share[k] * p[j];
        }
        struct foot f = foot_of(b->viewer->space, b->part, x);
        int eye = tries % 2;
        double true_a[2], true_b[2], at_a[2], at_b[2], d;
        if (!(a->item->eyes & b->item->eyes & 1u << eye) || !truly_seen(a, &f, eye, true_a, &d) ||
            !truly_seen(b, &f, eye, true_b, &d))
            continue;
        if (!drawn_at(a, &f, eye, at_a) || !drawn_at(b, &f, eye, at_b)) {
            tally->lost++;
            continue;
        }
        double off_a[2] = {at_a[0] - true_a[0], at_a[1] - true_a[1]},
               off_b[2] = {at_b[0] - true_b[0], at_b[1] - true_b[1]};
        struct worst *w = ap_surface_is_bare(b->part) ? &tally->bare
                          : d < 0.05                  ? &tally->near
                                                      : &tally->far;
        found++;
        tally->points++;
        note(hypot(off_b[0], off_b[1]), a, b, d, &w->off_px, w->off);
        note(hypot(off_b[0] - off_a[0], off_b[1] - off_a[1]), a, b, d, &w->pop_px, w->pop);
    }
}

// The item of list 0 that one of list 1 was; b_from_a: how the nose has moved.
static const struct ap_draw_item *before(const struct world *w, const struct ap_draw_item *b,
                                         const struct ap_iso *b_from_a) {
    for (size_t i = 0; i < w->list[0].count; i++) {
        const struct ap_draw_item *a = &w->list[0].items[i];
        if (a->part != b->part || a->image != b->image || a->way != b->way)
            continue;
        struct ap_iso m = ap_iso_mul(*b_from_a, a->nose_from_part);
        double off = 0;
        for (int k = 0; k < 16; k++)
            off = fmax(off, fabs(m.m[k / 4][k % 4] - b->nose_from_part.m[k / 4][k % 4]));
        if (off < 1e-6 * fabs(b->nose_from_part.m[3][3]) + 1e-6)
            return a;
    }
    return NULL;
}

static void compare_frames(const struct world *w, struct tally *tally) {
    struct ap_space space = w->scene->space;
    struct ap_iso b_from_world = ap_iso_inverse(space, w->input[1].viewer.world_from_nose);
    struct ap_iso b_from_a = ap_iso_mul(b_from_world, w->input[0].viewer.world_from_nose);
    for (int i = 0, done = 0; i < 6 * PER_FRAME && done < PER_FRAME && w->list[1].count; i++) {
        const struct ap_draw_item *b =
            &w->list[1].items[(size_t)uniform(0, (double)w->list[1].count)];
        const struct ap_part *part = &w->scene->parts[b->part];
        if ((part->kind == AP_PART_SOLID && part->form == AP_FORM_FACETS) || !b->eyes)
            continue;
        const struct ap_draw_item *a = before(w, b, &b_from_a);
        if (!a)
            continue;
        if (a->beyond || b->beyond) {
            tally->beyond++;
            continue;
        }
        bool changed = a->refined || b->refined || a->mesh.first_index != b->mesh.first_index;
        if (!changed && i % 4 != 0)
            continue;
        struct mesh_of ma = mesh_in(w, 0, a), mb = mesh_in(w, 1, b);
        compare(&ma, &mb, tally);
        tally->pairs++;
        tally->changed += changed;
        done++;
    }
}

static struct ap_vec3 any_direction(void) {
    return ap_vec3_normalize((struct ap_vec3){uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)});
}

// From somewhere near a part up to it and away again.
struct walk {
    struct ap_iso from;
    struct ap_vec3 along_m, turn_about;
    double turn_rad;
};

static struct walk any_walk(const struct ap_scene *scene) {
    struct ap_space space = scene->space;
    double unit = fmin(1, 0.8 * space.rho_m);
    struct walk walk = {.turn_about = any_direction(), .turn_rad = uniform(-1, 1)};
    if (scene->honeycomb) {
        const struct ap_tiling *t = &scene->honeycomb->tiling;
        struct ap_vec3 at = ap_vec3_scale(uniform(0, 0.4) * t->inradius_m, any_direction());
        walk.along_m = ap_vec3_scale(uniform(0.3, 0.55) * t->inradius_m, any_direction());
        struct ap_quat q = ap_quat_normalize(
            (struct ap_quat){uniform(-1, 1), uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)});
        walk.from = ap_iso_mul(ap_iso_translate(space, at), ap_iso_rotate(q));
        return walk;
    }
    const struct ap_part *part;
    do
        part = &scene->parts[(size_t)uniform(0, (double)scene->part_count)];
    while (part->carrier != AP_CARRIER_WORLD);
    double far = unit * uniform(0.3, 1.2), gap = exp(uniform(log(0.01), log(0.2)));
    gap += fmax(part->radius_m, part->radius2_m);
    struct ap_vec3 out = any_direction();
    out.y = fabs(out.y);
    // Looks at it, a little aside.
    struct ap_vec3 z = ap_vec3_normalize(ap_vec3_add(out, ap_vec3_scale(0.2, any_direction())));
    struct ap_vec3 x = ap_vec3_normalize(ap_vec3_cross((struct ap_vec3){0.01, 1, 0.02}, z));
    struct ap_vec3 y = ap_vec3_cross(z, x);
    struct ap_iso look = AP_ISO_IDENTITY;
    const struct ap_vec3 column[3] = {x, y, z};
    for (int j = 0; j < 3; j++) {
        look.m[0][j] = column[j].x;
        look.m[1][j] = column[j].y;
        look.m[2][j] = column[j].z;
    }
    walk.from = ap_iso_mul(
        ap_iso_mul(part->carrier_from_part, ap_iso_translate(space, ap_vec3_scale(far, out))),
        look);
    struct ap_vec3 home = {-ap_vec3_dot(out, x), -ap_vec3_dot(out, y), -ap_vec3_dot(out, z)};
    walk.along_m = ap_vec3_scale(far - gap, home);
    return walk;
}

// At 0…1 of the way: there and back.
static struct ap_iso pose_of(struct ap_space space, const struct walk *walk, double t) {
    double there = 0.5 - 0.5 * cos(2 * PI * t);
    struct ap_iso step = ap_iso_translate(space, ap_vec3_scale(there, walk->along_m));
    struct ap_quat turn = ap_quat_from_axis_angle(walk->turn_about, walk->turn_rad * t);
    return ap_iso_mul(walk->from, ap_iso_mul(step, ap_iso_rotate(turn)));
}

// frames: so many of it, from anywhere on; 0: all of it.
static void one_walk(struct world *w, enum ap_view_mode mode, double bound_px, int frames,
                     struct tally *tally) {
    struct ap_space space = w->scene->space;
    struct walk walk = any_walk(w->scene);
    struct ap_frame_input input = {.viewer = exact_viewer(&random_of, space.kappa, mode)};
    input.viewer.space = space;
    if (mode == AP_VIEW_BORN) {
        int kappa = uniform(-1, 1) < 0 ? -1 : 1;
        input.viewer.born = (struct ap_space){kappa, uniform(2, 4)};
        if (kappa == space.kappa)
            input.viewer.born.rho_m = 1.3 * space.rho_m;
    }
    int first = frames ? (int)uniform(0, FRAMES) : 0;
    for (int k = 0; k <= (frames ? frames : FRAMES); k++) {
        struct ap_draw_list spare = w->list[0];
        w->list[0] = w->list[1];
        w->list[1] = spare;
        w->input[0] = w->input[1];
        w->input[1] = input;
        w->input[1].viewer.world_from_nose = pose_of(space, &walk, (double)(first + k) / FRAMES);
        fill(w, 1, bound_px);
        if (k > 0)
            compare_frames(w, tally);
    }
}

static bool report(const char *name, enum ap_view_mode mode, double bound_px,
                   const struct tally *t) {
    double most = bound_px + ROUNDING_PX;
    bool bad = !(t->far.pop_px <= most) || !(t->far.off_px <= most) || !(t->near.pop_px <= most) ||
               !(t->near.off_px <= most) || !(t->bare.pop_px <= 4 * most) ||
               !(t->bare.off_px <= 4 * most) || t->points < 20 || t->changed < 1 ||
               t->lost * 50 > t->points;
    printf("%-22.22s %-9s %4.2f px: off %.4f, pops %.4f | within 5 cm off %.4f, pops %.4f | "
           "bare off %.4f, pops %.4f | %ld "
           "points, %ld of %ld pairs changed, %ld beyond, %ld lost%s\n",
           name, ap_view_mode_name(mode), bound_px, t->far.off_px, t->far.pop_px, t->near.off_px,
           t->near.pop_px, t->bare.off_px, t->bare.pop_px, t->points, t->changed, t->pairs,
           t->beyond, t->lost, bad ? "  FAILED" : "");
    if (bad)
        printf("    off: %s\n    pops: %s\n    off: %s\n    pops: %s\n    off: %s\n    pops: %s\n",
               t->far.off, t->far.pop, t->near.off, t->near.pop, t->bare.off, t->bare.pop);
    fflush(stdout);
    return !bad;
}

// walks: 0: a piece of one in each view, at bounds in turn.
static int walk_in(const char *name, int walks, int seed, int turn) {
    static const double BOUNDS[] = {0.25, 1, 4};
    struct world w;
    int failures = 0;
    open_world(&w, name);
    for (int mode = AP_VIEW_NATIVE; mode <= AP_VIEW_BORN; mode++)
        for (int b = 0; b < 3; b++) {
            struct tally t = {0};
            // All is refined as somebody born elsewhere sees it: of cells and in s3 that takes
            // long.
            bool slow = mode == AP_VIEW_BORN && (w.scene->honeycomb || w.scene->space.kappa > 0);
            if (walks == 0 && (b != (turn + mode) % 3 || slow))
                continue;
            random_of.seed = (uint64_t)(1000 * seed + 10 * mode + b);
            for (int i = 0; i < (walks ? walks : 3); i++)
                one_walk(&w, (enum ap_view_mode)mode, BOUNDS[b], walks ? 0 : SHORT, &t);
            failures += !report(name, (enum ap_view_mode)mode, BOUNDS[b], &t);
        }
    close_world(&w);
    return failures;
}

int main(int argc, char **argv) {
    static const char *const SCENES[] = {"h3", "e3", "s3",
                                         "honeycomb:5,3,4,walls,struts,balls,horizon=60",
                                         "honeycomb:4,3,3,walls,struts,balls"};
    int walks = argc > 1 ? atoi(argv[1]) : 0, seed = argc > 2 ? atoi(argv[2]) : 0, failures = 0;
    const char *only = argc > 3 ? argv[3] : "";
    for (size_t s = 0; s < sizeof SCENES / sizeof *SCENES; s++)
        if (strstr(SCENES[s], only))
            failures += walk_in(SCENES[s], walks, seed, (int)s);
    return failures > 0;
}
