// --max-error in worlds of cells: the frame's own triangles against the geodesic planes, tubes and
// spheres that they stand for (src/app/bench/facets.h), from places that are as awkward as can be:
// anywhere in a cell, next to walls, struts and corners and on them, by all ways of turning the
// head, native and tourist, with eyes and headsets of all sizes.
//
// test_cell_bound PX FIRST COUNT SCENE...: places FIRST to FIRST + COUNT - 1, in turn of each
// scene. A place is a function of its number, so that a long run can be cut up and taken up again.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "src/app/bench/facets.h"
#include "tests/render/exact.h"

enum { SCENES_MAX = 16, POINTS = 8000, PROGRESS = 100 };
// Where triangles run out it is counted, and what is drawn is still this near.
static const double GIVEN_UP_PX = 0.25;

static struct exact_random random_of;

static double uniform(double low, double high) {
    return exact_uniform(&random_of, low, high);
}

static int pick(int count) {
    return (int)uniform(0, count);
}

static void check(enum ap_status st, const struct ap_error *err) {
    if (st == AP_OK)
        return;
    printf("%s\n", err->text);
    exit(1);
}

// --- places

// A point of the cell: the shares of its corners; a convex cell holds all of them.
static struct ap_vec4 mixed(const struct ap_tiling *t, const int *vertex, int count) {
    struct ap_vec4 p = {0, 0, 0, 0};
    for (int i = 0; i < count; i++) {
        struct ap_vec4 v = t->vertex_m[vertex ? vertex[i] : i];
        double s = -log(uniform(1e-9, 1));
        p = (struct ap_vec4){p.x + s * v.x, p.y + s * v.y, p.z + s * v.z, p.w + s * v.w};
    }
    return p;
}

static struct ap_vec4 on_space(struct ap_space space, struct ap_vec4 p) {
    double square = p.x * p.x + p.y * p.y + p.z * p.z + space.kappa * p.w * p.w;
    double to = space.rho_m / (space.kappa ? sqrt(fabs(square)) : p.w);
    return (struct ap_vec4){to * p.x, to * p.y, to * p.z, to * p.w};
}

static const char *const WHERE[] = {"anywhere",      "near a wall",      "near a strut",
                                    "near a corner", "1e-9 from a wall", "on an edge"};
enum { WHERES = sizeof WHERE / sizeof *WHERE };

// On a face, an edge or a corner, and from there some way into the cell.
static struct ap_iso pose(const struct ap_tiling *t, int where) {
    struct ap_vec4 inner = on_space(t->space, mixed(t, NULL, t->vertex_count)), p = inner;
    int face = pick(t->face_count), edge = pick(t->edge_count), vertex = pick(t->vertex_count);
    double in = pow(10, uniform(-9, 0));
    if (where == 1 || where == 4)
        p = mixed(t, t->face_vertex[face], t->symbol.p);
    else if (where == 2 || where == 5)
        p = mixed(t, t->edge_vertex[edge], 2);
    else if (where == 3)
        p = t->vertex_m[vertex];
    p = on_space(t->space, p);
    if (where == 2 || where == 3) // a strut may be in the way: mostly outside of it
        in = pow(10, uniform(-3, 0));
    else if (where >= 4)
        in = where == 4 ? 1e-9 / t->inradius_m : 0;
    p = on_space(t->space,
                 (struct ap_vec4){p.x + in * (inner.x - p.x), p.y + in * (inner.y - p.y),
                                  p.z + in * (inner.z - p.z), p.w + in * (inner.w - p.w)});
    struct ap_quat q = {uniform(-1, 1), uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)};
    if (pick(8) == 0)
        q = (struct ap_quat){0, 0, 0, 1};
    return ap_iso_mul(ap_iso_translate(t->space, ap_log_unchecked(t->space, p, 0)),
                      ap_iso_rotate(ap_quat_normalize(q)));
}

// Eyes that are 50 to 75 mm apart and, now and then, not quite level; fields of 70° to 109°.
static void headset(struct ap_viewer *viewer) {
    double ipd = uniform(0.05, 0.075), cant = uniform(-0.2, 0.2), rise = pick(2) ? 0.01 : 0;
    for (int e = 0; e < 2; e++) {
        struct ap_view_eye *eye = &viewer->eye[e];
        eye->view_from_eye.p =
            (struct ap_vec3){e ? ipd / 2 : -ipd / 2, rise * uniform(-1, 1), rise * uniform(-2, 2)};
        eye->view_from_eye.q = ap_quat_from_axis_angle((struct ap_vec3){0, 1, 0}, e ? -cant : cant);
        eye->frustum = (struct ap_frustum){-uniform(0.7, 1.4), uniform(0.7, 1.4), uniform(0.7, 1.4),
                                           -uniform(0.7, 1.4)};
    }
}

struct look_from {
    struct ap_frame_input input;
    uint32_t size_px[2];
    int where;
};

static struct look_from place_of(const struct ap_scene *scene, long number) {
    static const uint32_t SIZES_PX[][2] = {{320, 320},   {640, 720},   {1080, 1200},
                                           {1440, 1600}, {1832, 1920}, {2000, 2000}};
    random_of.seed = 0x9e3779b97f4a7c15u * (uint64_t)(number + 1);
    uniform(0, 1);
    struct look_from l = {.where = pick(WHERES)};
    int size = pick(sizeof SIZES_PX / sizeof *SIZES_PX);
    memcpy(l.size_px, SIZES_PX[size], sizeof l.size_px);
    l.input.world_from_hand[0] = l.input.world_from_hand[1] = AP_ISO_IDENTITY;
    l.input.viewer.space = scene->space;
    l.input.viewer.mode = pick(3) ? AP_VIEW_NATIVE : AP_VIEW_TOURIST;
    headset(&l.input.viewer);
    l.input.viewer.world_from_nose = pose(&scene->honeycomb->tiling, l.where);
    return l;
}

// --- what is found

struct world {
    const char *name;
    struct ap_scene *scene;
    struct ap_facets facets;
};

static void open_world(const char *name, struct world *w) {
    const struct ap_scene_params none = {0};
    struct ap_error err;
    memset(w, 0, sizeof *w);
    w->name = name;
    check(ap_scene_named(&err, name, &none, &w->scene), &err);
    check(ap_facets_open(&err, w->scene, &w->facets), &err);
}

static void close_world(struct world *w) {
    ap_facets_close(&w->facets);
    ap_scene_destroy(w->scene);
}

struct tally {
    long places, given_up, points, refined;
    double triangles;
    double worst_px, over_px; // where all parts held the bound; where some did not
    long worst_at, over_at;
};

static void tell_place(const struct world *w, const struct look_from *l, long number,
                       const struct ap_facet_errors *found) {
    const struct ap_part *part = &w->scene->parts[found->part];
    printf("place %ld: %s, %s, %s, %ux%u: %.4f px, %s %d%s, %.3f m off; %.0f triangles; %u parts "
           "given up\n",
           number, w->name, ap_view_mode_name(l->input.viewer.mode), WHERE[l->where], l->size_px[0],
           l->size_px[1], found->worst_px, part->kind == AP_PART_BALL ? "ball" : "form",
           (int)part->form, found->refined ? " of its own" : "", found->at_m, found->triangles,
           found->beyond_bound);
}

static void look(struct world *w, long number, double max_error_px, struct tally *t) {
    struct look_from l = place_of(w->scene, number);
    const struct ap_facets_params params = {.input = &l.input,
                                            .size_px = {l.size_px[0], l.size_px[1]},
                                            .max_error_px = max_error_px,
                                            .points = POINTS,
                                            .seed = (uint64_t)number};
    struct ap_facet_errors found = {.worst_px = 0};
    struct ap_error err;
    check(ap_facets_look(&err, &w->facets, &params, &found), &err);
    bool held = found.beyond_bound == 0;
    if (!held || found.worst_px > max_error_px)
        tell_place(w, &l, number, &found);
    double *worst_px = held ? &t->worst_px : &t->over_px;
    if (found.worst_px >= *worst_px) {
        *worst_px = found.worst_px;
        *(held ? &t->worst_at : &t->over_at) = number;
    }
    t->places++;
    t->given_up += !held;
    t->points += found.points;
    t->refined += found.refined_parts;
    t->triangles += found.triangles / 2;
}

static void tell(const char *name, double max_error_px, const struct tally *t) {
    double n = (double)t->places;
    printf("%-44s worst %.4f px of %.2f (place %ld), %ld points, %ld places; a place: %.0f "
           "triangles an eye, %.1f parts of its own; given up in %ld, %.4f px at worst (%ld)\n",
           name, t->worst_px, max_error_px, t->worst_at, t->points, t->places, t->triangles / n,
           (double)t->refined / n, t->given_up, t->over_px, t->over_at);
    fflush(stdout);
}

static bool is_bad(double max_error_px, const struct tally *t) {
    return !(t->worst_px <= max_error_px) || !(t->over_px <= GIVEN_UP_PX) || t->refined == 0 ||
           t->points < 100 * t->places;
}

static int long_run(double max_error_px, long first, long count, char **names, int scenes) {
    struct world world[SCENES_MAX];
    struct tally t = {0};
    for (int i = 0; i < scenes; i++)
        open_world(names[i], &world[i]);
    for (long i = first; i < first + count; i++) {
        look(&world[i % scenes], i, max_error_px, &t);
        if (t.places % PROGRESS == 0)
            tell("so far", max_error_px, &t);
    }
    tell("in all", max_error_px, &t);
    for (int i = 0; i < scenes; i++)
        close_world(&world[i]);
    return is_bad(max_error_px, &t);
}

int main(int argc, char **argv) {
    static const struct {
        const char *name;
        int first, places;
        double max_error_px;
    } SCENES[] = {{"honeycomb:5,3,4,walls,struts,balls,horizon=150", 0, 6, 0.25},
                  {"honeycomb:5,3,4,walls,struts,horizon=150,budget=1024", 0, 6, 0.05},
                  {"honeycomb:4,3,4,walls,struts,horizon=150", 0, 6, 0.25},
                  {"honeycomb:4,3,3,walls,struts", 0, 6, 0.25},
                  {"poincare-dodecahedral", 0, 6, 0.05},
                  // Where edges of her own strut, of one beyond and of one seen along its length
                  // cross what they stand for in their middles.
                  {"honeycomb:3,3,3,walls,struts", 4, 1, 0.05},
                  {"honeycomb:3,3,4,walls,struts", 25, 1, 0.05},
                  {"honeycomb:3,3,5,walls,struts", 30, 1, 0.25},
                  // Where a long edge is off by as much as shorter ones beside it.
                  {"honeycomb:3,4,3,walls,struts", 1, 1, 0.05},
                  {"honeycomb:3,3,4,walls,struts", 31, 1, 0.25},
                  // A billionth from a wall, and on one: the long way round it fills half the sky.
                  {"honeycomb:3,3,4,walls,struts", 2, 1, 0.05},
                  {"poincare-dodecahedral", 36, 1, 0.25}};
    int failures = 0;
    if (argc > 4)
        return long_run(atof(argv[1]), atol(argv[2]), atol(argv[3]), argv + 4,
                        argc - 4 < SCENES_MAX ? argc - 4 : SCENES_MAX);
    for (size_t s = 0; s < sizeof SCENES / sizeof *SCENES; s++) {
        struct world world;
        struct tally t = {0};
        open_world(SCENES[s].name, &world);
        for (int i = 0; i < SCENES[s].places; i++)
            look(&world, SCENES[s].first + i, SCENES[s].max_error_px, &t);
        tell(world.name, SCENES[s].max_error_px, &t);
        failures += is_bad(SCENES[s].max_error_px, &t) || t.given_up > 0;
        close_world(&world);
    }
    return failures;
}
