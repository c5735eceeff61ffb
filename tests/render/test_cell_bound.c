// --max-error in worlds of cells: the frame's own list of triangles, as straight as the GPU draws
// them in tangent space, against the geodesic planes, tubes and spheres that they stand for, seen
// from places anywhere in a cell, every fourth as a tourist. `test_cell_bound PLACES` looks from
// more of them, `test_cell_bound PLACES fine [SEED]` at {5,3,4} alone, at 0.05 px.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "src/render/cells.h"
#include "tests/render/exact.h"
#include "tests/render/stage.h"

static const double PI = 3.14159265358979323846;
static const uint32_t SIZE_PX[2] = {1440, 1600};
enum { SAMPLES = 4 }; // of a part in a frame, at most

static struct stage stage;
static struct exact_random random_of = {11};

static double uniform(double low, double high) {
    return exact_uniform(&random_of, low, high);
}

// A scene with its meshes, on the GPU and here.
struct world {
    struct ap_scene *scene;
    struct ap_meshes meshes;
    struct ap_mesh_data ahead;
    struct ap_cell_view cells;
    struct ap_draw_list list;
};

// The meshes made ahead once more, in the order that the renderer makes them in.
static void copy_meshes(struct world *w) {
    for (size_t s = 0; s < w->meshes.shape_count; s++) {
        size_t i = 0;
        while (w->meshes.shape_of_part[i] != s)
            i++;
        const struct ap_part *part = &w->scene->parts[i];
        for (int k = 0; k < w->meshes.shapes[s].levels; k++) {
            struct ap_mesh mesh = {0};
            double facet = 0;
            STAGE_CHECK(part->kind == AP_PART_BALL
                            ? ap_mesh_sphere(&stage_error, k, &w->ahead, &mesh, &facet)
                            : ap_mesh_solid(&stage_error, w->scene->space,
                                            &w->scene->solids[part->solid + k], &w->ahead, &mesh));
            if (memcmp(&mesh, &w->meshes.shapes[s].mesh[k], sizeof mesh) != 0) {
                printf("shape %zu, level %d: the renderer's mesh lies elsewhere\n", s, k);
                exit(1);
            }
        }
    }
}

static void open_world(struct world *w, const char *name) {
    const struct ap_scene_params none = {0};
    memset(w, 0, sizeof *w);
    STAGE_CHECK(ap_scene_named(&stage_error, name, &none, &w->scene));
    STAGE_CHECK(ap_meshes_create(&stage_error, &stage.gpu, w->scene, &w->meshes));
    STAGE_CHECK(ap_cell_view_create(&stage_error, w->scene, &w->meshes, &w->cells));
    STAGE_CHECK(ap_draw_list_create(&stage_error, w->scene->part_count, &w->list));
    copy_meshes(w);
}

static void close_world(struct world *w) {
    ap_draw_list_destroy(&w->list);
    ap_cell_view_destroy(&w->cells);
    ap_meshes_destroy(&stage.gpu, &w->meshes);
    ap_mesh_data_finish(&w->ahead);
    ap_scene_destroy(w->scene);
}

struct tally {
    long places, beyond, points, refined;
    double triangles;
    double worst_px, over_px, at_m; // where all parts held the bound; where some did not
};

struct look {
    const struct ap_viewer *viewer;
    const struct ap_draw_item *item;
    const struct ap_part *part;
    struct ap_iso part_from_nose;
    const struct ap_mesh_data *data;
    double bound_px;
    struct ap_iso eye_from_part[2];
    double radius; // of a tube or sphere, over rho
};

static void corners_of(const struct look *l, uint32_t t, double p[3][4]) {
    const struct ap_mesh *mesh = &l->item->mesh;
    for (uint32_t k = 0; k < 3; k++) {
        uint32_t v = mesh->first_vertex + l->data->indices[mesh->first_index + 3 * t + k];
        for (int j = 0; j < 4; j++)
            p[k][j] = l->data->vertices[v].position[j];
        if (l->part->kind != AP_PART_BALL)
            continue;
        for (int j = 0; j < 3; j++) // a ball's meshes hold directions
            p[k][j] *= ap_space_sin(l->viewer->space, l->radius);
        p[k][3] = ap_space_cos(l->viewer->space, l->radius);
    }
}

static struct ap_vec3 tangent(const struct look *l, const double p[4]) {
    double rho = l->viewer->space.rho_m;
    struct ap_vec4 x = {rho * p[0], rho * p[1], rho * p[2], rho * p[3]};
    return ap_log_unchecked(l->viewer->space, ap_iso_apply(&l->item->nose_from_part, x),
                            l->item->image);
}

// The point of the tube or the sphere at the share (s[0], s[1], s[2]) of three points on it, by its
// own coordinates.
static void between(const struct look *l, double p[3][4], const double s[3], double out[4]) {
    struct ap_space space = l->viewer->space;
    double sr = ap_space_sin(space, l->radius), cr = ap_space_cos(space, l->radius);
    double t = 0, phi = 0, u[3] = {0, 0, 0};
    for (int k = 0; k < 3; k++) {
        double x = p[k][0] / p[k][3];
        t += s[k] * (space.kappa > 0 ? atan(x) : space.kappa < 0 ? atanh(x) : x);
        phi += s[k] * atan2(p[k][1], p[k][2]);
        for (int i = 0; i < 3; i++)
            u[i] += s[k] * p[k][i];
    }
    if (l->part->form == AP_FORM_TUBE) {
        out[0] = ap_space_sin(space, t) * (space.kappa ? cr : 1);
        out[1] = sr * sin(phi);
        out[2] = sr * cos(phi);
        out[3] = ap_space_cos(space, t) * cr;
        return;
    }
    double n = sqrt(u[0] * u[0] + u[1] * u[1] + u[2] * u[2]);
    for (int i = 0; i < 3; i++)
        out[i] = sr * u[i] / n;
    out[3] = cr;
}

// Where an eye sees a point of the part, in its axes: native, metres; tourist, a direction, which
// is linear in the point as its triangles are.
static struct ap_vec3 seen(const struct look *l, int e, const double p[4]) {
    double rho = l->viewer->space.rho_m, sign = l->item->image ? -1 : 1;
    struct ap_vec4 x = {rho * p[0], rho * p[1], rho * p[2], rho * p[3]};
    if (l->viewer->mode != AP_VIEW_TOURIST)
        return ap_eye_from_tangent(&l->viewer->eye[e], (struct ap_tangent_point){tangent(l, p)}).x;
    x = ap_iso_apply(&l->eye_from_part[e], x);
    return (struct ap_vec3){sign * x.x, sign * x.y, sign * x.z};
}

// As ap_exact_pixel.
static bool pixel(const struct look *l, int e, struct ap_vec3 at, double px[2]) {
    const struct ap_frustum *f = &l->viewer->eye[e].frustum;
    double a = at.x / -at.z, b = at.y / -at.z;
    px[0] = (a - f->left) / (f->right - f->left) * SIZE_PX[0];
    px[1] = (f->up - b) / (f->up - f->down) * SIZE_PX[1];
    return at.z < 0 && ap_vec3_length(at) > AP_NEAR_M && a > f->left && a < f->right &&
           b > f->down && b < f->up;
}

// Of triangle t to q, which is on the surface.
static double to_triangle(const struct look *l, int e, uint32_t t, const double q[2]) {
    double corner[3][2], p[3][4];
    corners_of(l, t, p);
    for (int k = 0; k < 3; k++) { // they may lie beside the picture, but not behind the eye
        struct ap_vec3 c = seen(l, e, p[k]);
        if (!(c.z < 0))
            return INFINITY;
        pixel(l, e, c, corner[k]);
    }
    return ap_exact_outside(q, corner[0], corner[1], corner[2]);
}

// −1: not seen. A round surface's point may well be shown by a neighbour of its own triangle.
static double round_error(const struct look *l, int e, uint32_t t, double p[3][4],
                          const double s[3]) {
    double q[2], at[4], least;
    between(l, p, s, at);
    if (!pixel(l, e, seen(l, e, at), q) || (least = to_triangle(l, e, t, q)) == INFINITY)
        return -1;
    for (uint32_t i = 0; least > 0.4 * l->bound_px && i < l->item->mesh.index_count / 3; i++)
        least = fmin(least, to_triangle(l, e, i, q));
    return least;
}

// −1: not seen.
static double error_px(const struct look *l, int e, uint32_t t, const double s[3]) {
    struct ap_vec3 flat = {0, 0, 0}, truth;
    double p[3][4], q[2], r[2];
    corners_of(l, t, p);
    if (l->viewer->mode == AP_VIEW_TOURIST) // planes are linear there
        return l->part->form == AP_FORM_PLANE ? -1 : round_error(l, e, t, p, s);
    for (int k = 0; k < 3; k++)
        flat = ap_vec3_add(flat, ap_vec3_scale(s[k], tangent(l, p[k])));
    double d = ap_vec3_length(flat), rho = l->viewer->space.rho_m;
    if (l->viewer->space.kappa > 0 && fabs(d / rho - PI) < 2e-3)
        return -1;
    if (l->part->form == AP_FORM_PLANE) {
        if (!ap_exact_on_plane(l->viewer->space, &l->part_from_nose, ap_vec3_scale(1 / d, flat), d,
                               &truth) ||
            !ap_exact_pixel(l->viewer, SIZE_PX, e, flat, r) ||
            !ap_exact_pixel(l->viewer, SIZE_PX, e, truth, q))
            return -1;
        return hypot(q[0] - r[0], q[1] - r[1]);
    }
    return round_error(l, e, t, p, s);
}

static void look_at(const struct world *w, const struct ap_viewer *viewer,
                    const struct ap_draw_item *item, double max_error_px, double *worst_px,
                    struct tally *tally) {
    struct look l = {.viewer = viewer, .item = item, .part = &w->scene->parts[item->part]};
    if (l.part->form == AP_FORM_FACETS && l.part->kind != AP_PART_BALL)
        return;
    for (int e = 0; e < 2; e++)
        l.eye_from_part[e] = ap_iso_mul(ap_eye_from_nose(viewer, e), item->nose_from_part);
    l.data = item->refined ? &w->list.refined : &w->ahead;
    l.bound_px = max_error_px;
    l.part_from_nose = ap_iso_inverse(viewer->space, item->nose_from_part);
    l.radius = l.part->radius_m / viewer->space.rho_m;
    uint32_t count = item->mesh.index_count / 3;
    for (uint32_t i = 0; i < SAMPLES && i < count; i++) {
        uint32_t t = count <= SAMPLES ? i : (uint32_t)uniform(0, count);
        double s[3] = {uniform(0.02, 0.98), uniform(0.02, 0.98), 0};
        if (s[0] + s[1] > 1)
            s[0] = 1 - s[0], s[1] = 1 - s[1];
        s[2] = 1 - s[0] - s[1];
        for (int e = 0; e < 2; e++) {
            double px = item->eyes >> e & 1 ? error_px(&l, e, t, s) : -1;
            tally->points += px >= 0;
            if (px > *worst_px) {
                double p[3][4];
                *worst_px = px;
                corners_of(&l, t, p);
                tally->at_m = ap_vec3_length(tangent(&l, p[0]));
            }
        }
    }
}

// Anywhere in the cell, looking anywhere.
static struct ap_iso pose(const struct ap_scene *scene) {
    const struct ap_tiling *t = &scene->honeycomb->tiling;
    struct ap_vec3 at;
    bool inside;
    do {
        at = (struct ap_vec3){uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)};
        inside = ap_vec3_length(at) < 1;
        at = ap_vec3_scale(t->circumradius_m, at);
        for (int f = 0; inside && f < t->face_count; f++)
            inside = ap_tiling_beyond(t, ap_exp(scene->space, at), f) < 0;
    } while (!inside);
    struct ap_quat q = ap_quat_normalize(
        (struct ap_quat){uniform(-1, 1), uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)});
    return ap_iso_mul(ap_iso_translate(scene->space, at), ap_iso_rotate(q));
}

static void look_from(struct world *w, enum ap_view_mode mode, double max_error_px,
                      struct tally *tally) {
    struct ap_frame_input input = {.viewer = exact_viewer(&random_of, w->scene->space.kappa, mode),
                                   .world_from_hand = {AP_ISO_IDENTITY, AP_ISO_IDENTITY}};
    input.viewer.space = w->scene->space;
    input.viewer.world_from_nose = pose(w->scene);
    struct ap_eyes eyes = ap_eyes_of(&input.viewer, SIZE_PX[0], SIZE_PX[1]);
    const struct ap_list_params what = {.scene = w->scene,
                                        .meshes = &w->meshes,
                                        .input = &input,
                                        .eyes = &eyes,
                                        .width_px = SIZE_PX[0],
                                        .height_px = SIZE_PX[1],
                                        .max_error_px = max_error_px};
    STAGE_CHECK(ap_draw_list_fill(&stage_error, &what, &w->list));
    STAGE_CHECK(ap_cell_view_fill(&stage_error, &w->cells, &what, &w->list));
    bool held = w->list.stats.beyond_bound == 0;
    for (size_t i = 0; i < w->list.count; i++)
        look_at(w, &input.viewer, &w->list.items[i], max_error_px,
                held ? &tally->worst_px : &tally->over_px, tally);
    tally->places++;
    tally->beyond += !held;
    tally->refined += w->list.stats.refined;
    tally->triangles += (double)w->list.stats.eye[0].triangles;
}

int main(int argc, char **argv) {
    static const struct {
        const char *name;
        int places;
    } SCENES[] = {{"honeycomb:5,3,4,walls,struts,balls,horizon=150", 4},
                  {"honeycomb:4,3,4,walls,struts,horizon=150", 2},
                  {"honeycomb:4,3,3,walls,struts", 4}};
    static const double BOUNDS[] = {0.25, 0.05};
    int failures = 0, more = argc > 1 ? atoi(argv[1]) : 0;
    size_t scenes = argc > 2 ? 1 : sizeof SCENES / sizeof *SCENES;
    if (argc > 3)
        random_of.seed = strtoull(argv[3], NULL, 10);
    if (!stage_open(&stage, 64, 64, false))
        return 77;
    for (size_t s = 0; s < scenes; s++)
        for (int b = argc > 2; b < 2; b++) {
            struct world world;
            struct tally t = {0};
            open_world(&world, SCENES[s].name);
            for (int i = 0; i < (more ? more : SCENES[s].places); i++)
                look_from(&world, (i & 3) == 3 ? AP_VIEW_TOURIST : AP_VIEW_NATIVE, BOUNDS[b], &t);
            // Where a frame's triangles run out it is counted, and still all is near.
            bool bad = !(t.worst_px <= BOUNDS[b]) || !(t.over_px <= 0.25) || t.points < 1000 ||
                       t.refined == 0 || (t.beyond > 0 && (b == 0 || !more));
            printf("%-40s worst %.4f px of %.2f over %ld points (at %.3f m) from %ld places; a "
                   "place: %.0f triangles, %.1f parts of its own; beyond it in %ld places, %.3f "
                   "px%s\n",
                   SCENES[s].name, t.worst_px, BOUNDS[b], t.points, t.at_m, t.places,
                   t.triangles / (double)t.places, (double)t.refined / (double)t.places, t.beyond,
                   t.over_px, bad ? "  FAILED" : "");
            failures += bad;
            close_world(&world);
        }
    stage_close(&stage);
    return failures;
}
