// Nothing shows between pieces of a world of cells that meet, whatever their levels of detail.
// First each line that two of them share in the frame's own list of triangles: both must draw the
// same polyline, to the rounding of a float. Then pictures from inside of cells whose walls are
// closed. `test_watertight PLACES` looks from more places.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "src/render/cells.h"
#include "tests/render/closed_world.h"
#include "tests/render/exact.h"
#include "tests/render/stage.h"

static const uint32_t SIZE_PX[2] = {1440, 1600};
enum { SAMPLES = 4, LINES_MAX = 6, POINTS_MAX = 4096, COARSE_MAX = 256 };

static struct exact_random random_of = {5};

static double uniform(double low, double high) {
    return exact_uniform(&random_of, low, high);
}

// A line of a part's rim, in its coordinates over rho.
struct line {
    struct ap_vec4 end[2];
};

struct world {
    struct ap_scene *scene;
    struct ap_meshes meshes;
    struct ap_mesh_data ahead;
    struct ap_cell_view cells;
    struct ap_draw_list list;
    struct line *lines; // LINES_MAX a part
    int *line_count;
};

static double inner(struct ap_vec4 a, struct ap_vec4 b, double kappa) {
    return a.x * b.x + a.y * b.y + a.z * b.z + kappa * a.w * b.w;
}

static struct ap_vec4 minus(struct ap_vec4 a, struct ap_vec4 b) {
    return (struct ap_vec4){a.x - b.x, a.y - b.y, a.z - b.z, a.w - b.w};
}

static double apart(struct ap_space space, struct ap_vec4 a, struct ap_vec4 b) {
    struct ap_vec4 d = minus(a, b);
    return sqrt(fabs(inner(d, d, space.kappa)));
}

// Lines of the rim of a solid's coarsest mesh, its edges that one triangle has: the outer ones of a
// wall, those along a strut, all of a joint.
static int find_lines(const struct ap_scene *scene, const struct ap_part *part,
                      struct line lines[LINES_MAX]) {
    const struct ap_solid *solid = &scene->solids[part->solid];
    struct ap_space space = scene->space;
    struct ap_vec4 p[COARSE_MAX];
    int count = 0;
    if (solid->vertex_count > COARSE_MAX)
        return 0;
    for (size_t i = 0; i < solid->vertex_count; i++) {
        const float *v = solid->positions + 3 * i;
        p[i] = ap_exp(space, (struct ap_vec3){v[0], v[1], v[2]});
        p[i] = (struct ap_vec4){p[i].x / space.rho_m, p[i].y / space.rho_m, p[i].z / space.rho_m,
                                p[i].w / space.rho_m};
    }
    for (size_t i = 0; i < solid->index_count; i++) {
        size_t next = i % 3 == 2 ? i - 2 : i + 1;
        struct ap_vec4 a = p[solid->indices[i]], b = p[solid->indices[next]];
        int used = 0;
        for (size_t k = 0; k < solid->index_count; k++) {
            size_t after = k % 3 == 2 ? k - 2 : k + 1;
            struct ap_vec4 c = p[solid->indices[k]], d = p[solid->indices[after]];
            used += (apart(space, a, c) < 1e-6 && apart(space, b, d) < 1e-6) ||
                    (apart(space, a, d) < 1e-6 && apart(space, b, c) < 1e-6);
        }
        double far = hypot(a.x, a.z), reach = ap_space_sin(space, solid->reach_m / space.rho_m);
        bool outer = part->form == AP_FORM_PLANE
                         ? far > 0.999 * reach && hypot(b.x, b.z) > 0.999 * reach
                     : part->form == AP_FORM_TUBE ? fabs(a.y - b.y) < 1e-6
                                                  : true;
        if (used == 1 && outer && count < LINES_MAX)
            lines[count++] = (struct line){{a, b}};
    }
    return count;
}

static void open_world(struct world *w, const char *name) {
    const struct ap_scene_params none = {0};
    memset(w, 0, sizeof *w);
    STAGE_CHECK(ap_scene_named(&stage_error, name, &none, &w->scene));
    STAGE_CHECK(ap_meshes_make(&stage_error, w->scene, &w->meshes, &w->ahead));
    STAGE_CHECK(ap_cell_view_create(&stage_error, w->scene, &w->meshes, &w->cells));
    STAGE_CHECK(ap_draw_list_create(&stage_error, w->scene->part_count, &w->list));
    w->lines = calloc(w->scene->part_count * LINES_MAX, sizeof *w->lines);
    w->line_count = calloc(w->scene->part_count, sizeof *w->line_count);
    for (size_t i = 0; i < w->scene->part_count; i++)
        if (w->scene->parts[i].kind == AP_PART_SOLID && w->scene->parts[i].form != AP_FORM_FACETS)
            w->line_count[i] = find_lines(w->scene, &w->scene->parts[i], w->lines + i * LINES_MAX);
}

static void close_world(struct world *w) {
    const struct ap_gpu none = {0};
    free(w->lines);
    free(w->line_count);
    ap_draw_list_destroy(&w->list);
    ap_cell_view_destroy(&w->cells);
    ap_meshes_destroy(&none, &w->meshes);
    ap_mesh_data_finish(&w->ahead);
    ap_scene_destroy(w->scene);
}

// What an item draws of a line: the corners of its triangles there, in nose space over rho.
struct drawn {
    const struct ap_draw_item *item;
    struct ap_vec4 end[2], sum;
    struct ap_vec4 normal[2]; // there
    size_t first;
    int count;
};

struct tally {
    struct drawn *drawn;
    size_t drawn_count, drawn_room;
    struct ap_vec4 *points;
    size_t point_count, point_room;
    long pairs, unlike, points_compared, bad;
    double worst;
};

static void *grown(void *array, size_t *room, size_t count, size_t size) {
    if (count < *room)
        return array;
    *room = *room ? 2 * *room : 1024;
    array = realloc(array, *room * size);
    if (!array)
        exit(1);
    return array;
}

// The share of the way from a to b, or −1 beside the line.
static double along(struct ap_space space, const struct ap_part *part, const struct line *l,
                    struct ap_vec4 p) {
    const double close = 3e-6;
    struct ap_vec4 a = l->end[0], b = l->end[1];
    if (part->form == AP_FORM_TUBE) {
        double t = (p.x / p.w - a.x / a.w) / (b.x / b.w - a.x / a.w);
        return fabs(p.y - a.y) < close && fabs(p.z * a.w - a.z * p.w) < close * a.w * p.w ? t : -1;
    }
    // p = s·a + t·b?
    if (part->form == AP_FORM_SPHERE)
        a.w = b.w = p.w = 0;
    double aa = inner(a, a, 1), ab = inner(a, b, 1), bb = inner(b, b, 1), ap = inner(a, p, 1),
           bp = inner(b, p, 1), below = aa * bb - ab * ab;
    double s = (ap * bb - bp * ab) / below, t = (bp * aa - ap * ab) / below;
    struct ap_vec4 q = {s * a.x + t * b.x, s * a.y + t * b.y, s * a.z + t * b.z, s * a.w + t * b.w};
    q = minus(q, p);
    (void)space;
    return s > -close && t > -close && sqrt(inner(q, q, 1)) < close ? t / (s + t) : -1;
}

static void note(struct world *w, const struct ap_draw_item *item, int k, struct tally *t) {
    const struct ap_part *part = &w->scene->parts[item->part];
    const struct line *l = &w->lines[item->part * LINES_MAX + (size_t)k];
    const struct ap_mesh_data *data = item->refined ? &w->list.refined : &w->ahead;
    struct ap_space space = w->scene->space;
    struct drawn d = {.item = item, .first = t->point_count};
    double last = -1, at[POINTS_MAX];
    uint32_t index[POINTS_MAX];
    for (uint32_t i = 0; i < item->mesh.index_count; i++) {
        uint32_t v = data->indices[item->mesh.first_index + i];
        const float *f = data->vertices[item->mesh.first_vertex + v].position;
        double s = along(space, part, l, (struct ap_vec4){f[0], f[1], f[2], f[3]});
        bool known = s < -1e-5;
        for (int j = 0; j < d.count && !known; j++)
            known = fabs(at[j] - s) < 1e-6;
        if (known || d.count == POINTS_MAX)
            continue;
        int j = d.count++;
        for (; j > 0 && at[j - 1] > s; j--) {
            at[j] = at[j - 1];
            index[j] = index[j - 1];
        }
        at[j] = s;
        index[j] = v;
    }
    (void)last;
    for (int i = 0; i < d.count; i++) {
        const struct ap_vertex *v = &data->vertices[item->mesh.first_vertex + index[i]];
        struct ap_vec4 p = {v->position[0], v->position[1], v->position[2], v->position[3]},
                       n = {v->normal[0], v->normal[1], v->normal[2], v->normal[3]};
        t->points = grown(t->points, &t->point_room, t->point_count, sizeof *t->points);
        t->points[t->point_count++] = ap_iso_apply(&item->nose_from_part, p);
        if (i == 0 || i == d.count - 1)
            d.normal[i > 0] = ap_iso_apply(&item->nose_from_part, n);
    }
    for (int i = 0; i < 2; i++)
        d.end[i] = ap_iso_apply(&item->nose_from_part, l->end[i]);
    d.sum = (struct ap_vec4){d.end[0].x + d.end[1].x, d.end[0].y + d.end[1].y,
                             d.end[0].z + d.end[1].z, d.end[0].w + d.end[1].w};
    t->drawn = grown(t->drawn, &t->drawn_room, t->drawn_count, sizeof *t->drawn);
    t->drawn[t->drawn_count++] = d;
}

static int by_sum(const void *left, const void *right) {
    const struct drawn *a = left, *b = right;
    return a->sum.x < b->sum.x ? -1 : a->sum.x > b->sum.x;
}

// Whether an eye that both are drawn for sees this point.
static bool in_view(const struct ap_viewer *viewer, const struct drawn *a, const struct drawn *b,
                    struct ap_vec4 p) {
    double rho = viewer->space.rho_m, sign = a->item->image ? -1 : 1;
    struct ap_vec4 p_m = {rho * p.x, rho * p.y, rho * p.z, rho * p.w};
    for (int e = 0; e < 2; e++) {
        const struct ap_frustum *f = &viewer->eye[e].frustum;
        struct ap_vec3 at;
        if (!(a->item->eyes & b->item->eyes & 1u << e))
            continue;
        if (viewer->mode == AP_VIEW_TOURIST) {
            struct ap_iso eye_from_nose = ap_eye_from_nose(viewer, e);
            struct ap_vec4 q = ap_iso_apply(&eye_from_nose, p_m);
            at = (struct ap_vec3){sign * q.x, sign * q.y, sign * q.z};
        } else {
            struct ap_vec3 t = ap_log_unchecked(viewer->space, p_m, a->item->image);
            at = ap_eye_from_tangent(&viewer->eye[e], (struct ap_tangent_point){t}).x;
        }
        double x = at.x / -at.z, y = at.y / -at.z;
        if (at.z < -0.001 && x > f->left && x < f->right && y > f->down && y < f->up)
            return true;
    }
    return false;
}

// Round surfaces: whether the line's side is turned to the nose. What is turned away is behind the
// rest.
static bool faces(const struct world *w, const struct drawn *d) {
    const struct ap_part *part = &w->scene->parts[d->item->part];
    struct ap_vec4 nose = {0, 0, 0, 1};
    double sign = d->item->image ? -1 : 1, least = INFINITY;
    if (part->form == AP_FORM_PLANE)
        return true;
    for (int i = 0; i < 2; i++) {
        struct ap_vec4 to = w->scene->space.kappa ? nose : minus(nose, d->end[i]);
        least = fmin(least, sign * inner(d->normal[i], to, w->scene->space.kappa));
    }
    return least > 0.05;
}

// Every corner of one is a corner of the other, or out of view.
static void compare(const struct world *w, const struct ap_viewer *viewer, const struct drawn *a,
                    const struct drawn *b, struct tally *t) {
    struct ap_space space = viewer->space;
    for (int i = 0; i < a->count; i++) {
        double least = INFINITY;
        struct ap_vec4 p = t->points[a->first + (size_t)i];
        if (!in_view(viewer, a, b, p))
            continue;
        for (int j = 0; j < b->count; j++)
            least = fmin(least, apart(space, p, t->points[b->first + (size_t)j]));
        t->points_compared++;
        t->worst = fmax(t->worst, least);
        if (least > 3e-6 && t->bad++ < 3)
            printf(
                "  a corner %d of %d on a line of a part of form %d is %.2g rho from the nearest "
                "of the %d of its neighbour's (allowed 3e-6), image %d, refined %d and %d\n",
                i, a->count, (int)w->scene->parts[a->item->part].form, least, b->count,
                a->item->image, a->item->refined, b->item->refined);
    }
}

static void compare_all(const struct world *w, const struct ap_viewer *viewer, struct tally *t) {
    struct ap_space space = viewer->space;
    qsort(t->drawn, t->drawn_count, sizeof *t->drawn, by_sum);
    for (size_t i = 0; i < t->drawn_count; i++)
        for (size_t k = i + 1; k < t->drawn_count; k++) {
            const struct drawn *a = &t->drawn[i], *b = &t->drawn[k];
            double close = 1e-5 * (1 + fabs(a->sum.w));
            if (b->sum.x - a->sum.x > close)
                break;
            struct ap_vec4 off = minus(a->sum, b->sum);
            if (inner(off, off, 1) > close * close || a->item->image != b->item->image ||
                fmin(apart(space, a->end[0], b->end[0]), apart(space, a->end[0], b->end[1])) >
                    1e-5 ||
                !faces(w, a) || !faces(w, b))
                continue;
            t->pairs++;
            t->unlike += a->item->mesh.first_index != b->item->mesh.first_index ||
                         a->item->refined != b->item->refined;
            compare(w, viewer, a, b, t);
            compare(w, viewer, b, a, t);
        }
}

// Anywhere in the cell, looking anywhere; every third near its rim.
static struct ap_iso pose(const struct ap_scene *scene, int i) {
    const struct ap_tiling *t = &scene->honeycomb->tiling;
    struct ap_vec3 at;
    bool inside;
    do {
        at = (struct ap_vec3){uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)};
        inside = ap_vec3_length(at) < 1 && (i % 3 != 2 || ap_vec3_length(at) > 0.7);
        at = ap_vec3_scale(t->circumradius_m, at);
        for (int f = 0; inside && f < t->face_count; f++)
            inside = ap_tiling_beyond(t, ap_exp(scene->space, at), f) < -0.02;
    } while (!inside);
    struct ap_quat q = ap_quat_normalize(
        (struct ap_quat){uniform(-1, 1), uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)});
    return ap_iso_mul(ap_iso_translate(scene->space, at), ap_iso_rotate(q));
}

static void look_from(struct world *w, int i, double max_error_px, struct tally *t) {
    enum ap_view_mode mode = i % 5 == 4 ? AP_VIEW_TOURIST : AP_VIEW_NATIVE;
    struct ap_frame_input input = {.viewer = exact_viewer(&random_of, w->scene->space.kappa, mode),
                                   .world_from_hand = {AP_ISO_IDENTITY, AP_ISO_IDENTITY}};
    input.viewer.space = w->scene->space;
    input.viewer.world_from_nose = pose(w->scene, i);
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
    t->drawn_count = t->point_count = 0;
    for (size_t k = 0; k < w->list.count; k++)
        for (int l = 0; l < w->line_count[w->list.items[k].part]; l++)
            note(w, &w->list.items[k], l, t);
    compare_all(w, &input.viewer, t);
}

static int lines_are_shared(int places) {
    static const struct {
        const char *name;
        double px[3];
    } WORLDS[] = {{"honeycomb:5,3,4,walls,struts,horizon=150", {4, 1, 0.25}},
                  {"honeycomb:4,3,5,walls,struts,horizon=150", {4, 1, 0.25}},
                  {"honeycomb:4,3,4,walls,struts,horizon=150", {4, 0.25, 0.05}},
                  {"seifert-weber,walls,struts,horizon=200", {4, 1, 0.25}},
                  {"mirrored-dodecahedron,walls,struts,horizon=150", {4, 1, 0.25}},
                  {"honeycomb:3,5,3,walls,struts,horizon=200", {4, 1, 0.25}},
                  {"honeycomb:5,3,3,walls,struts", {4, 1, 0.25}},
                  {"honeycomb:4,3,3,walls,struts", {4, 1, 0.25}},
                  {"honeycomb:3,4,3,walls,struts", {4, 1, 0.25}},
                  {"honeycomb:3,3,3,walls,struts", {4, 1, 0.25}},
                  {"poincare-dodecahedral,walls,struts", {4, 1, 0.25}}};
    int failures = 0;
    for (size_t s = 0; s < sizeof WORLDS / sizeof *WORLDS; s++) {
        struct world w;
        struct tally t = {0};
        open_world(&w, WORLDS[s].name);
        for (int i = 0; i < places; i++)
            look_from(&w, i, WORLDS[s].px[i % 3], &t);
        bool bad = t.bad > 0 || t.unlike < 10L * places || t.points_compared < 200L * places;
        printf(
            "%-48s %ld pairs of lines (%ld of unlike meshes), %ld corners in view: %ld have none "
            "at the other's, worst %.2g rho%s\n",
            WORLDS[s].name, t.pairs, t.unlike, t.points_compared, t.bad, t.worst,
            bad ? "  FAILED" : "");
        failures += bad;
        free(t.drawn);
        free(t.points);
        close_world(&w);
    }
    return failures;
}

// --- pictures

static double linear(uint8_t byte) {
    double c = byte / 255.0;
    return c <= 0.04045 ? c / 12.92 : pow((c + 0.055) / 1.055, 2.4);
}

// Pixels of which a sample or more shows the background, which is white. Walls of other cells are a
// little lighter than this one's, and where they all meet a sample of the edge may be theirs.
static void count_holes(const struct stage *stage, int e, long *walls, long *holes) {
    long of[256] = {0}, all = (long)stage->width * stage->height;
    int own = 0;
    for (long p = 0; p < all; p++)
        of[stage_eye(stage, e)[4 * p]]++;
    for (int c = 0; c < 200; c++)
        own = of[c] > of[own] ? c : own;
    double grey = linear((uint8_t)own), one = grey + 0.7 * (1 - grey) / SAMPLES;
    for (int c = 0; c < 256; c++)
        *(linear((uint8_t)c) > one ? holes : walls) += of[c];
}

static int walls_are_closed(struct stage *stage, int places) {
    static const char *const WORLDS[] = {
        "honeycomb:5,3,4", "honeycomb:4,3,5", "honeycomb:4,3,4", "honeycomb:5,3,3",
        "honeycomb:3,3,3", "honeycomb:4,3,3", "honeycomb:3,4,3", "poincare-dodecahedral"};
    static const double BOUNDS[] = {4, 1, 0.25};
    int failures = 0;
    for (size_t s = 0; s < sizeof WORLDS / sizeof *WORLDS; s++) {
        struct ap_scene *scene = closed_world(WORLDS[s]);
        long through = 0, seen = 0;
        for (int b = 0; b < 3; b++) {
            const struct ap_renderer_params how = {.max_error_px = BOUNDS[b]};
            struct ap_renderer *renderer = stage_renderer(stage, scene, &how);
            for (int i = 0; i < places; i++) {
                struct ap_frame_input input = stage_input(
                    scene->space, i % 5 == 4 ? AP_VIEW_TOURIST : AP_VIEW_NATIVE, 0.9, 0.064);
                input.viewer.world_from_nose = pose(scene, i);
                stage_draw(stage, renderer, &input);
                for (int e = 0; e < 2; e++)
                    count_holes(stage, e, &seen, &through);
            }
            ap_renderer_destroy(renderer);
        }
        long all = 6L * places * stage->width * stage->height;
        bool bad = through > 0 || seen < all * 9 / 10;
        printf(
            "%-24s %ld of %ld pixels show what is behind the walls (none allowed), %ld walls%s\n",
            WORLDS[s], through, all, seen, bad ? "  FAILED" : "");
        failures += bad;
        ap_scene_destroy(scene);
    }
    return failures;
}

int main(int argc, char **argv) {
    int places = argc > 1 ? atoi(argv[1]) : 3;
    struct stage stage;
    int failures = lines_are_shared(places);
    if (!stage_open(&stage, 256, 256, false))
        return failures ? 1 : 77;
    failures += walls_are_closed(&stage, places);
    stage_close(&stage);
    return failures != 0;
}
